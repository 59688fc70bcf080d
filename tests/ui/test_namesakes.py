"""Two features of one name are warned of when the name comes about, and are allowed."""

from __future__ import annotations

from typing import Any

import pytest

from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading


def reading(number: int, name: str = "") -> Reading:
    return Reading(f"r{number}", name, "bedding", "plane", 100.0 + number, 30.0)


@pytest.mark.full
def test_renaming_to_an_existing_name_is_reported(studio: Any) -> None:
    said: list[Finding] = []
    studio.workspace.notices.posted.connect(lambda notice: said.append(notice.message))
    for number in range(3):
        studio.attempt(edits.add_features, [reading(number)])
    assert not said
    names = [feature.name for feature in studio.session.features()]
    assert len(set(names)) == 3
    studio.attempt(edits.set_attributes, ["r1"], name="alone")
    assert not said
    studio.attempt(edits.set_attributes, ["r1"], name=names[0])
    (finding,) = said
    assert finding.code == "feature.same-names"
    assert finding.values["names"] == names[0]
    assert [f.name for f in studio.session.features()] == [names[0], names[0], names[2]]
    studio.undo()
    studio.attempt(edits.set_attributes, ["r2"], notes="the same bed")
    assert [each.code for each in said] == ["feature.same-names", "edit.undone"]


def test_import_of_duplicate_names_is_reported(studio: Any) -> None:
    said: list[Finding] = []
    studio.workspace.notices.posted.connect(lambda notice: said.append(notice.message))
    studio.attempt(edits.add_features, [reading(1, "A"), reading(2, "A"), reading(3, "B")])
    (finding,) = said
    assert (finding.code, finding.values["count"]) == ("feature.same-names", 1)
    assert finding.values["names"] == "A"
