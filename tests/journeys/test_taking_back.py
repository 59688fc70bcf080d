"""Ten mistakes in each tool, and the keys that take each of them back: never more than two at a
time, pressed once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import CTRL, LEFT, NONE, click, drag, key, look_at, wait
from vomstudio.project import edits, grid_edits
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import FaceGrid
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.ui.panels.coverage.coverage_panel import CoveragePanel

SHIFT = Qt.KeyboardModifier.ShiftModifier
UNDO = (Qt.Key.Key_Z, CTRL)
BACK = (Qt.Key.Key_Z, SHIFT)
LAST = (Qt.Key.Key_Backspace, NONE)
LETTERS = {
    "trace": (Qt.Key.Key_T,),
    "line": (Qt.Key.Key_L,),
    "measure": (Qt.Key.Key_M,),
    "contact": (Qt.Key.Key_E,),
    "lithology": (Qt.Key.Key_R, SHIFT),
}


@pytest.fixture
def ready(window, outcrop, picks):
    driver.open_outcrop(window, outcrop)
    wait(
        lambda: all(m.surface._faces_by_vertex is not None for m in window.studio.models.values()),
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
    clip = studio.display.effective_clip
    chosen = getattr(tool, "selection", None)
    hidden = studio.workspace.elements.get_hidden_masks()
    return {
        "records": dict(studio.records),
        "open": None if tool is None else getattr(tool, "vertices", None),
        "chosen": None if chosen is None else chosen.mask.tobytes(),
        "hidden": {id_: mask.tobytes() for id_, mask in hidden.items()},
        "view": np.round(
            np.concatenate([camera.position, camera.frame.ravel(), [camera.orthographic]]), 6
        ).tolist(),
        "clip": None if clip is None else clip.corners().tolist(),
    }


def rest(window) -> None:
    """As long as a view must stand still to count."""
    wait(lambda: window.viewport.is_still, "the camera's rest")
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


@pytest.mark.full
@pytest.mark.parametrize("name", LETTERS)
def test_undo_reverts_mistakes_of_point_tools(ready, name):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, *LETTERS[name])
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


@pytest.mark.full
def test_undo_reverts_mistakes_with_stations_and_known_lines(ready):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_D)
    # 1: a click too many; 2: a station moved, where 3: Esc came in place of Enter; 4: deleted;
    # 5: a wrong number
    click(window.viewport, at[0])
    takes_back(window, lambda: click(window.viewport, at[1]), UNDO)
    (made,) = studio.session.features()
    takes_back(window, lambda: moved(window, made.id, at[2]), UNDO)
    studio.selection.set([made.id])
    window.actions_table.run("edit_feature")
    takes_back(window, lambda: click(window.viewport, at[2]), UNDO)
    click(window.viewport, at[2])
    takes_back(window, lambda: key(window, Qt.Key.Key_Escape), UNDO)
    key(window, Qt.Key.Key_Escape)
    studio.selection.set([made.id])
    takes_back(window, lambda: key(window, Qt.Key.Key_Delete), UNDO)
    takes_back(window, lambda: studio.attempt(edits.set_attributes, [made.id], number="7"), UNDO)
    key(window, Qt.Key.Key_N)
    key(window, Qt.Key.Key_K)
    assert studio.tool_name == "known_line"
    # 6: the first end clicked, by either key; 7: Esc; 8: the whole line; 9: its value
    takes_back(window, lambda: click(window.viewport, at[0]), LAST)
    takes_back(window, lambda: click(window.viewport, at[0]), UNDO)
    click(window.viewport, at[0])
    takes_back(window, lambda: key(window, Qt.Key.Key_Escape), UNDO)
    key(window, Qt.Key.Key_Escape)

    def whole_line() -> None:
        click(window.viewport, at[0])
        click(window.viewport, at[3])

    takes_back(window, whole_line, UNDO)
    whole_line()
    (line,) = studio.session.of(KnownLine)
    takes_back(
        window,
        lambda: studio.attempt(edits.change_feature, replace(line, kind="length", value=2.0)),
        UNDO,
    )


def moved(window, id_: str, to: QPoint) -> None:
    window.studio.selection.set([id_])
    window.actions_table.run("edit_feature")
    click(window.viewport, to)
    key(window, Qt.Key.Key_Return)


@pytest.mark.full
def test_undo_reverts_mistakes_when_selecting_faces(ready):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_P)
    run = window.actions_table.run
    # What lies beside what is looked up at the first click of all.
    click(window.viewport, at[0])
    wait(lambda: studio.tool.count, "what is grown from a click")
    key(window, *UNDO)
    # 1: the first click; 2: another; 3: a ring too many; 4: turned round; 5: everything
    takes_back(window, lambda: click(window.viewport, at[0]), UNDO)
    click(window.viewport, at[0])
    wait(lambda: studio.tool.count, "what is grown from a click")
    takes_back(window, lambda: click(window.viewport, at[3], SHIFT), UNDO)
    count = studio.tool.count
    run("select_wider")
    wait(lambda: studio.tool.count > count, "its neighbours")
    for step in ("select_wider", "select_invert", "select_everything"):
        takes_back(window, lambda step=step: run(step), UNDO)
    # 6: Esc; 7: hidden; 8: isolated; 9: shown again; 10: a plane of it all
    takes_back(window, lambda: key(window, Qt.Key.Key_Escape), UNDO)
    run("plane_to_selection")
    takes_back(window, lambda: key(window, Qt.Key.Key_Escape), UNDO)
    takes_back(window, lambda: key(window, Qt.Key.Key_H), UNDO)
    rest(window)
    takes_back(window, lambda: run("isolate_elements"), BACK, view=True)
    run("isolate_elements")
    key(window, Qt.Key.Key_Escape)
    takes_back(window, lambda: run("show_elements"), UNDO)
    key(window, Qt.Key.Key_P)
    click(window.viewport, at[0])
    wait(lambda: studio.tool.count, "what is grown from a click")
    before = dict(studio.records)
    key(window, Qt.Key.Key_Return)
    key(window, *UNDO)
    assert dict(studio.records) == before


@pytest.mark.full
def test_undo_reverts_mistakes_when_marking_cells(ready):
    window, studio = ready, ready.studio
    run = window.actions_table.run
    run("looked_at")
    panel = window.findChild(CoveragePanel)
    driver.pause(200)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the figures")
    takes_back(window, lambda: lay(window, panel), UNDO)
    lay(window, panel)
    (grid,) = studio.session.of(FaceGrid)
    wait(lambda: studio.workspace.grids.exposure(grid.id), "its cells")
    assert studio.tool_name == "cells"
    driver.focus(window)
    at = window.viewport.rect().center()
    takes_back(window, lambda: click(window.viewport, at), UNDO)
    driver.move(window.viewport, at)
    takes_back(window, lambda: key(window, Qt.Key.Key_X), UNDO)
    # A double click is no mark and its contrary.
    before = grid_edits.grid_marks(studio.records[grid.id])
    QTest.mouseClick(window.viewport, LEFT, NONE, at)
    QTest.mouseDClick(window.viewport, LEFT, NONE, at)
    assert grid_edits.grid_marks(studio.records[grid.id]) != before
    takes_back(window, lambda: studio.attempt(grid_edits.remove_grid, grid.id), UNDO)


def lay(window, panel: CoveragePanel) -> None:
    QTest.mouseClick(panel.create_button, LEFT, NONE, panel.create_button.rect().center())
    wait(lambda: window.studio.session.of(FaceGrid), "the grid")
    driver.focus(window)


@pytest.mark.full
def test_undo_reverts_mistakes_with_the_brush(ready):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_P)
    tool = studio.get_tool(PlaneTool)
    tool.set_radius(0.2)
    # 1: a stroke too many; 2: an erasing one; 3: the first of all
    takes_back(window, lambda: drag(window.viewport, at[0], at[0] + QPoint(30, 0)), UNDO)
    drag(window.viewport, at[0], at[0] + QPoint(30, 0))
    for keys in (NONE, SHIFT):
        takes_back(
            window,
            lambda keys=keys: drag(window.viewport, at[0], at[0] + QPoint(60, 8), modifier=keys),
            UNDO,
        )
    takes_back(
        window, lambda: drag(window.viewport, at[0], at[0] + QPoint(12, 0), modifier=CTRL), UNDO
    )
    # 4: Esc, which discards the plane
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


@pytest.mark.full
def test_undo_reverts_mistakes_while_navigating(ready):
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
        lambda: key(window, Qt.Key.Key_2, Qt.KeyboardModifier.AltModifier),
        lambda: key(window, Qt.Key.Key_O),
        lambda: window.actions_table.run("clipping_box"),
        lambda: key(window, Qt.Key.Key_F),
    ):
        takes_back(window, mistake, BACK, view=True)


def state_of(window) -> tuple[Any, ...]:
    tool = window.studio.open_tool
    chosen = getattr(tool, "selection", None)
    return (
        {f.id: f for f in window.studio.session.features()},
        None if tool is None else tool.name,
        getattr(tool, "vertices", None),
        None if chosen is None else chosen.mask.tobytes(),
    )


def back_and_forth(window, count: int) -> None:
    """Undo so many steps and redo them: each redo brings what its undo took, and says so."""
    states, said = [state_of(window)], []
    for _ in range(count):
        key(window, *UNDO)
        states.append(state_of(window))
        said.append(window.statusBar().currentMessage().removeprefix("Undone: "))
        assert states[-1] != states[-2], said
    for step in reversed(range(count)):
        key(window, Qt.Key.Key_Z, CTRL | SHIFT)
        assert state_of(window) == states[step], said[step]
        assert window.statusBar().currentMessage() == f"Redone: {said[step]}"


@pytest.mark.full
@pytest.mark.parametrize("name", LETTERS)
def test_excess_undo_is_redone_while_picking_points(ready, name):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_T)
    for spot in at:
        click(window.viewport, spot + QPoint(0, 20))
    key(window, Qt.Key.Key_Return)
    key(window, *LETTERS[name])
    if name == "measure":
        studio.tool.choose(kind="area")
    for spot in at[:3]:
        click(window.viewport, spot)
    drag(window.viewport, at[0], at[0] + QPoint(0, 16))
    # All of it, and the trace before it.
    back_and_forth(window, 5)
    # Another click is another way: what was undone does not come back.
    key(window, *UNDO)
    click(window.viewport, at[3])
    assert studio.redo_label is None
    # What undo took from the document waits until nothing is open.
    key(window, Qt.Key.Key_Escape)
    back_and_forth(window, 2)


@pytest.mark.full
def test_excess_undo_is_redone_while_selecting_faces(ready):
    window, studio = ready, ready.studio
    at = spots(window)
    key(window, Qt.Key.Key_P)
    assert studio.tool_name == "plane"
    click(window.viewport, at[0])
    wait(lambda: studio.tool.count, "what is grown from a click")
    count = studio.tool.count
    window.actions_table.run("select_wider")
    wait(lambda: studio.tool.count > count, "a ring more")
    back_and_forth(window, 2)
    # What was undone before Esc is not what redo brings after it.
    window.actions_table.run("select_invert")
    key(window, *UNDO)
    key(window, Qt.Key.Key_Escape)
    back_and_forth(window, 3)
