"""View state is no work: whatever a project's file holds there, its window opens."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path

import pytest

from tests.driver import close, make_window, wait
from tests.fuzz.projects import specimen
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.records import Feature

ODD = [
    7,
    [1, None, {}],
    {"mode": [], "lit": 3, "point_size": "x", "fields": {"a": 3}, "box": [1], "position": ["x"]},
]


def with_views(project: Path, value: str) -> None:
    db = sqlite3.connect(project / JOURNAL_NAME)
    known = {key for (key,) in db.execute("SELECT key FROM view")}
    known |= {"camera", "display", "hidden", "cameras", "named_views", "survey_plan"}
    known.discard("taking in")
    for key in known:
        db.execute("INSERT OR REPLACE INTO view VALUES (?, ?)", (key, value))
    db.commit()
    db.close()


@pytest.mark.full
@pytest.mark.parametrize("value", [json.dumps(odd) for odd in ODD] + ["[" * 100_000])
def test_window_opens_with_a_damaged_view_state(tmp_path: Path, qtbot, value: str) -> None:  # type: ignore[no-untyped-def]
    project = specimen(tmp_path)
    with_views(project, value)
    window = make_window([project])
    try:
        wait(lambda: window.studio.session.of(Feature), "the features")
        assert window.studio.display.mode
    finally:
        # The specimen has an unfinished trace.
        window.studio.cancel_tool()
        window.studio.session.save()
        close(window)
