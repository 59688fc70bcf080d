"""What was closed without saving is told by its date and contents."""

from __future__ import annotations

import os
from datetime import datetime
from pathlib import Path

import pytest

from vomstudio.project import edits
from vomstudio.project.folder import create_untitled
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.records import Model
from vomstudio.studio.discarded_work import list_discarded_work


@pytest.mark.usefixtures("own_folders")
def test_discarded_work_states_its_closing_date_and_contents() -> None:
    folders: list[Path] = []
    for count in (1, 3):
        project = create_untitled()
        session = project.session
        model = Model("m", "cliff north", "cliff.obj", "mesh", "0" * 64)
        session.apply(edits.add_model(session.records, model))
        for number in range(count):
            reading = Reading(f"r{number}", "", "bedding", "plane", 120.0, 30.0)
            session.apply(edits.add_features(session.records, [reading]))
        session.discard_unsaved()
        project.close()
        os.utime(project.folder / "journal.sqlite", (1.7e9 + count, 1.7e9 + count))
        folders.append(project.folder)
    newer, older = list_discarded_work()
    assert [newer.folder, older.folder] == folders[::-1]
    assert (newer.features, older.features, newer.models) == (3, 1, ("cliff north",))
    day = datetime.fromtimestamp(1.7e9 + 3).strftime("%Y-%m-%d %H:%M")
    assert newer.describe().startswith(f"{day}: 3 ")
    assert ": 1 " in older.describe()
    assert newer.describe().endswith(" cliff north")
