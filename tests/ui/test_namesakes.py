"""Two features of one name are warned of when the name comes about, and are allowed."""

from __future__ import annotations

from typing import Any

import pytest

from vomstudio.document import edits
from vomstudio.document.kinds.reading import Reading


def reading(number: int, name: str = "") -> Reading:
    return Reading(f"r{number}", name, "bedding", "plane", 100.0 + number, 30.0)


@pytest.mark.full
def test_a_rename_to_a_name_that_is_there(studio: Any) -> None:
    said: list[str] = []
    studio.workspace.notices.told.connect(lambda notice: said.append(notice.text))
    for number in range(3):
        studio.attempt(edits.add_features, [reading(number)])
    assert not said
    names = [feature.name for feature in studio.session.features()]
    assert len(set(names)) == 3
    studio.attempt(edits.set_attributes, ["r1"], name="alone")
    assert not said
    studio.attempt(edits.set_attributes, ["r1"], name=names[0])
    (sentence,) = said
    assert names[0] in sentence
    assert "Rename" in sentence
    assert [f.name for f in studio.session.features()] == [names[0], names[0], names[2]]
    studio.undo()
    studio.attempt(edits.set_attributes, ["r2"], notes="the same bed")
    assert len(said) == 1 or all("more than one feature" not in s for s in said[1:])


def test_an_import_of_names_that_come_twice(studio: Any) -> None:
    said: list[str] = []
    studio.workspace.notices.told.connect(lambda notice: said.append(notice.text))
    studio.attempt(edits.add_features, [reading(1, "A"), reading(2, "A"), reading(3, "B")])
    (sentence,) = said
    assert "1 name belongs" in sentence
    assert ": A." in sentence
