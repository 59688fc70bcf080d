"""Ten mistakes in each tool, and the keys that take each of them back: never more than two at a
time, pressed once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from tests import driver
from tests.driver import CTRL, NONE, click, drag, key, look_at, wait
from vomstudio.document import edits
from vomstudio.document.kinds.patch import Patch
from vomstudio.tools.patch import PatchTool

SHIFT = Qt.KeyboardModifier.ShiftModifier
UNDO = (Qt.Key.Key_Z, CTRL)
BACK = (Qt.Key.Key_Z, SHIFT)
LAST = (Qt.Key.Key_Backspace, NONE)
LETTERS = {"trace": Qt.Key.Key_T, "line": Qt.Key.Key_L, "measure": Qt.Key.Key_M}


@pytest.fixture
def ready(window, outcrop, picks):
    driver.open_outcrop(window, outcrop)
    wait(
        lambda: all(m.surface._faces_of is not None for m in window.studio.models.values()),
        "the search structures",
    )
    look_at(window, picks["B04"], 0.0, 10.0)
    return window


def spots(window) -> list[QPoint]:
    middle = window.viewport.rect().center()
    found = [middle + QPoint(dx, dy) for dx, dy in ((-80, 10), (-30, -35), (20, 30), (75, -10))]
    assert all(window.viewport.pick(p.x(), p.y()) is not None for p in found)
    return found


def seen(window) -> dict[str, Any]:
    """What a person would call the state of the work: features, open picks, view, visibility."""
    studio, camera = window.studio, window.viewport.camera
    tool = studio.open_tool
    clip = studio.display.clip_shown
    return {
        "features": {f.id: f for f in studio.session.features()},
        "open": None if tool is None else getattr(tool, "vertices", None),
        "view": np.round(
            np.concatenate([camera.position, camera.frame.ravel(), [camera.orthographic]]), 6
        ).tolist(),
        "clip": None if clip is None else clip.corners().tolist(),
    }


def rest(window) -> None:
    """As long as a view must stand still to count."""
    wait(lambda: window.viewport.still, "the camera's rest")
    driver.pause(600)


def takes_back(
    window, mistake: Callable[[], object], keys: tuple[Any, Any], view: bool = False
) -> None:
    """One press of `keys` brings back what was there before the mistake."""
    before = seen(window)
    mistake()
    if view:
        rest(window)
    assert seen(window) != before, "it was no mistake"
    assert bin(int(keys[1].value)).count("1") <= 1, "two keys at the most"
    key(window, *keys)
    if view:
        rest(window)
    assert seen(window) == before


@pytest.mark.parametrize("name", ["trace", "line", "measure"])
def test_mistakes_of_tools_that_click_points(ready, name):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, LETTERS[name])
    if name == "measure":
        studio.tool.choose(kind="area")
    for spot in at[:2]:
        click(window.viewport, spot)
    moved = at[0] + QPoint(0, 16)
    tool = studio.open_tool
    # 1, 2: a click too many, by either key; 3: a point dragged to a wrong place; 4: one deleted;
    # 5: Esc instead of Enter
    takes_back(window, lambda: click(window.viewport, at[2]), LAST)
    takes_back(window, lambda: click(window.viewport, at[2]), UNDO)
    takes_back(window, lambda: drag(window.viewport, at[0], moved), UNDO)
    takes_back(window, lambda: tool.delete_vertex(1), UNDO)
    takes_back(window, lambda: key(window, Qt.Key.Key_Escape), UNDO)
    # 6: finished by Enter, which was meant for later: gone on with by one button, or undone
    for spot in at[2:]:
        click(window.viewport, spot)
    key(window, Qt.Key.Key_Return)
    (made,) = studio.session.features()
    studio.selection.set([made.id])
    # 7: deleted; 8: renamed; 9: the view turned while picking; 10: the tool's feature as a whole
    takes_back(window, lambda: key(window, Qt.Key.Key_Delete), UNDO)
    takes_back(window, lambda: studio.attempt(edits.set_attributes, [made.id], name="wrong"), UNDO)
    rest(window)
    takes_back(
        window, lambda: drag(window.viewport, at[3], at[3] + QPoint(90, 20), RIGHT), BACK, view=True
    )
    key(window, *UNDO)
    assert studio.session.features() == []
    key(window, Qt.Key.Key_Z, CTRL | SHIFT)
    assert studio.session.features() == [made]


RIGHT = Qt.MouseButton.RightButton


def test_mistakes_of_the_brush(ready):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_P)
    tool = studio.tool_of(PatchTool)
    tool.set_radius(0.2)
    # 1: a stroke too many; 2: an erasing one; 3: the first of all
    takes_back(window, lambda: drag(window.viewport, at[0], at[0] + QPoint(30, 0)), UNDO)
    drag(window.viewport, at[0], at[0] + QPoint(30, 0))
    takes_back(window, lambda: drag(window.viewport, at[0], at[0] + QPoint(60, 8)), UNDO)
    takes_back(
        window, lambda: drag(window.viewport, at[0], at[0] + QPoint(12, 0), modifier=CTRL), UNDO
    )
    # 4: Esc, which discards the patch
    takes_back(window, lambda: key(window, Qt.Key.Key_Escape), UNDO)
    key(window, Qt.Key.Key_Return)
    (made,) = studio.session.of(Patch)
    # 5: deleted; 6: a wrong type; 7: a wrong set; 8: hidden by mistake is no edit of the work
    studio.selection.set([made.id])
    takes_back(window, lambda: key(window, Qt.Key.Key_Delete), UNDO)
    for change in ({"type_id": "fault"}, {"set_name": "J9"}, {"notes": "wrong"}):
        takes_back(
            window, lambda c=change: studio.attempt(edits.set_attributes, [made.id], **c), UNDO
        )
    # 9: the view turned with the other button; 10: clipped
    rest(window)
    takes_back(
        window, lambda: drag(window.viewport, at[0], at[0] + QPoint(80, 0), RIGHT), BACK, view=True
    )
    takes_back(window, lambda: window.actions_table.run("clipping_box"), BACK, view=True)


def test_mistakes_while_navigating(ready):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_T)
    for count in (1, 2):
        for spot in at:
            click(window.viewport, spot + QPoint(0, 20 * count))
        key(window, Qt.Key.Key_Return)
    key(window, Qt.Key.Key_N)
    ids = [f.id for f in studio.session.features()]
    assert len(ids) == 2
    rest(window)
    studio.selection.set(ids)
    takes_back(window, lambda: key(window, Qt.Key.Key_Delete), UNDO)
    takes_back(window, lambda: studio.attempt(edits.set_attributes, ids, type_id="joint"), UNDO)
    takes_back(window, lambda: studio.attempt(edits.set_attributes, ids, overturned=True), UNDO)
    studio.selection.set(ids)
    for mistake in (
        lambda: drag(window.viewport, at[0], at[0] + QPoint(60, 10)),
        lambda: drag(window.viewport, at[0], at[0] + QPoint(60, 10), modifier=SHIFT),
        lambda: key(window, Qt.Key.Key_Home),
        lambda: key(window, Qt.Key.Key_2),
        lambda: key(window, Qt.Key.Key_O),
        lambda: window.actions_table.run("clipping_box"),
        lambda: key(window, Qt.Key.Key_F),
    ):
        takes_back(window, mistake, BACK, view=True)
