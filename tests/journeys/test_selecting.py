"""Faces and points chosen by hand in the window that people use."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import (
    CTRL,
    LEFT,
    NONE,
    click,
    drag,
    key,
    look_at,
    move,
    open_outcrop,
    pixel,
    wait,
)
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.select import SelectTool
from vomstudio.ui.panels.tools.plane import PlanePanel

SHIFT = Qt.KeyboardModifier.ShiftModifier
ALT = Qt.KeyboardModifier.AltModifier


def patches(window) -> list[Patch]:
    return window.studio.session.of(Patch)


def draw(window, ring: list[QPoint], modifier=NONE, *, release: bool = True) -> None:
    """Hold the left button along a line."""
    viewport = window.viewport

    def send(kind, at, held):
        changed = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseMove else LEFT
        where = QPointF(at)
        event = QMouseEvent(kind, where, QPointF(viewport.mapToGlobal(at)), changed, held, modifier)
        QApplication.sendEvent(viewport, event)

    send(QEvent.Type.MouseButtonPress, ring[0], LEFT)
    for start, end in pairwise(ring):
        for step in range(1, 5):
            send(QEvent.Type.MouseMove, start + (end - start) * step / 4, LEFT)
        QApplication.processEvents()
    if release:
        send(QEvent.Type.MouseButtonRelease, ring[-1], Qt.MouseButton.NoButton)
    driver.pause(5)


def circle(at: QPoint, radius: float, count: int = 24) -> list[QPoint]:
    turns = [2.0 * math.pi * k / count for k in range(count + 1)]
    return [at + QPoint(round(radius * math.cos(t)), round(radius * math.sin(t))) for t in turns]


def ready(window, outcrop, picks, tool: str = "select") -> QPoint:
    """Before the middle of a bed, with the tool in hand; where that is on the view."""
    open_outcrop(window, outcrop)
    wait(
        lambda: all(m.surface._faces_by_vertex is not None for m in window.studio.models.values()),
        "the search structures",
    )
    look_at(window, picks["B04"], 0.0, 10.0)
    key(window, Qt.Key.Key_S if tool == "select" else Qt.Key.Key_P)
    assert window.studio.tool_name == tool
    if tool == "select":
        window.actions_table.run("select_surface")
    return pixel(window, np.median(picks["B04"], axis=0))


@pytest.mark.full
def test_lasso_plane_is_a_single_edit(own_folders, qtbot, outcrop, picks):
    window = driver.make_window()
    studio, viewport, tool = window.studio, window.viewport, window.studio.get_tool(PlaneTool)
    at = ready(window, outcrop, picks, "plane")
    assert driver.tool_panel(window, PlanePanel).isVisible()
    camera = viewport.moves.camera_state()
    key(window, Qt.Key.Key_A)
    draw(window, circle(at, 60), release=False)
    assert tool.drawing
    assert viewport.preview.outline is not None
    driver.keep_picture(window, "select-1-drawing")
    key(window, Qt.Key.Key_Escape)
    assert not tool.is_open
    QTest.mouseRelease(viewport, LEFT, NONE, at)
    assert tool.count == 0
    draw(window, circle(at, 60))
    assert tool.count > 8
    assert viewport.moves.camera_state() == camera
    assert viewport.preview.area is not None
    assert driver.tool_panel(window, PlanePanel).fit_view.isVisible()
    driver.keep_picture(window, "select-2-chosen")

    # What is chosen are the faces whose centres lie inside, and which are seen.
    model = driver.model(window)
    mesh = studio.models[model.id].data
    chosen = tool.selection.ids()
    centres = mesh.vertices[mesh.faces[chosen]].mean(axis=1)
    rows = np.array(model.to_world)
    pixels, seen = viewport.project(centres @ rows[:3, :3].T + rows[:3, 3])
    assert (np.hypot(*(pixels - [at.x(), at.y()]).T) < 62.0).all()
    assert seen.mean() > 0.95

    # One more place with Shift, one less with Alt, steps back with Ctrl+Z.
    first = tool.count
    draw(window, circle(at + QPoint(90, 0), 40), SHIFT)
    more = tool.count
    assert more > first
    draw(window, circle(at, 20), ALT)
    less = tool.count
    assert less < more
    key(window, Qt.Key.Key_Z, CTRL)
    assert tool.count == more
    key(window, Qt.Key.Key_Return)
    (patch,) = patches(window)
    assert len(runs_to_ids(patch.runs)) == more
    assert not tool.is_open
    assert studio.selection.ids == (patch.id,)
    drawing = viewport.features.drawings[patch.id]
    # A poor plane is outlined instead of filled.
    assert drawing.is_outlined == (drawing.verdict == "poor") == (drawing.area is None)
    driver.keep_picture(window, "select-3-patch")
    key(window, Qt.Key.Key_Z, CTRL)
    assert patches(window) == []
    key(window, Qt.Key.Key_Y, CTRL)
    assert patches(window) == [patch]

    # Enter came too soon: the plane is edited, as a trace is.
    studio.selection.set([patch.id])
    window.actions_table.run("edit_feature")
    assert tool.count == more
    draw(window, circle(at, 20), ALT)
    key(window, Qt.Key.Key_Return)
    (smaller,) = patches(window)
    assert smaller.id == patch.id
    assert len(runs_to_ids(smaller.runs)) < more
    key(window, Qt.Key.Key_Z, CTRL)
    assert patches(window) == [patch]
    driver.dismiss(window)


def wheel(window, at: QPoint, notches: int, modifier) -> None:
    viewport = window.viewport
    where = QPointF(at)
    event = QWheelEvent(
        where,
        QPointF(viewport.mapToGlobal(at)),
        QPoint(0, 0),
        QPoint(0, 120 * notches),
        Qt.MouseButton.NoButton,
        modifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(viewport, event)
    driver.pause(5)


@pytest.mark.full
def test_region_grows_from_a_click_and_follows_the_wheel(window, outcrop, picks):
    viewport, tool = window.viewport, window.studio.get_tool(PlaneTool)
    at = ready(window, outcrop, picks, "plane")
    camera = viewport.moves.camera_state()
    key(window, Qt.Key.Key_G)
    click(viewport, at)
    wait(lambda: tool.count, "the piece")
    first, angle = tool.count, tool.growth.angle_deg
    driver.keep_picture(window, "select-4-grown")
    wheel(window, at, 5, CTRL)
    assert tool.growth.angle_deg == angle + 10.0
    assert tool.count > first
    more = tool.count
    wheel(window, at, -14, SHIFT)
    assert tool.count < more
    assert viewport.moves.camera_state() == camera
    driver.keep_picture(window, "select-5-wider-tolerance")
    # The wheel has changed one step: a single undo takes the piece back.
    key(window, Qt.Key.Key_Z, CTRL)
    assert not tool.is_open
    # Without a key the wheel moves the view as ever.
    wheel(window, at, 1, NONE)
    assert viewport.moves.camera_state() != camera


@pytest.mark.full
def test_rectangle_polygon_and_select_all_select_the_expected_faces(window, outcrop, picks):
    viewport, tool = window.viewport, window.studio.get_tool(SelectTool)
    at = ready(window, outcrop, picks)
    key(window, Qt.Key.Key_R)
    drag(viewport, at - QPoint(60, 50), at + QPoint(60, 50))
    rectangle = tool.selection.mask.copy()
    assert rectangle.sum() > 8
    key(window, Qt.Key.Key_Y)
    corners = [QPoint(-60, -50), QPoint(60, -50), QPoint(60, 50), QPoint(-60, 50)]
    for corner in corners:
        click(viewport, at + corner)
    move(viewport, at)
    driver.keep_picture(window, "select-6-polygon")
    key(window, Qt.Key.Key_Backspace)
    click(viewport, at + corners[-1])
    assert tool.drawing
    key(window, Qt.Key.Key_Return)
    # The same four corners, so the same faces: nothing changes.
    assert not tool.drawing
    assert np.array_equal(tool.selection.mask, rectangle)
    for corner in corners[:3]:
        click(viewport, at + corner * 2)
    click(viewport, at + corners[0] * 2)
    assert not tool.drawing
    assert tool.count != rectangle.sum()
    window.actions_table.run("select_everything")
    assert tool.count == len(rectangle)
    key(window, Qt.Key.Key_I, SHIFT)
    assert tool.count == 0
    assert not tool.is_open


@pytest.mark.full
def test_hidden_faces_are_selected_only_when_selecting_through_the_surface(window, outcrop, picks):
    viewport, tool = window.viewport, window.studio.get_tool(SelectTool)
    ready(window, outcrop, picks)
    viewport.moves.look_along(0.0, 45.0)
    wait(lambda: viewport.is_still, "the camera's rest")
    key(window, Qt.Key.Key_R)
    corner = QPoint(5, 5), QPoint(viewport.width() - 5, viewport.height() - 5)
    drag(viewport, *corner)
    seen = tool.selection.mask.copy()
    key(window, Qt.Key.Key_V)
    drag(viewport, *corner)
    through = tool.selection.mask.copy()
    assert (seen & ~through).sum() == 0
    assert 0 < seen.sum() < through.sum()


@pytest.mark.full
def test_selected_faces_are_hidden_isolated_and_shown_again(window, outcrop, picks):
    viewport, tool = window.viewport, window.studio.get_tool(SelectTool)
    at = ready(window, outcrop, picks)
    key(window, Qt.Key.Key_A)
    draw(window, circle(at, 60))
    face = viewport.pick(at.x(), at.y()).index
    assert tool.selection.mask[face]
    key(window, Qt.Key.Key_H)
    assert not tool.is_open
    wait(lambda: viewport.is_still, "the picture")
    behind = viewport.pick(at.x(), at.y())
    assert behind is None or behind.index != face
    driver.keep_picture(window, "select-7-hidden")
    # Hidden faces are not chosen either.
    draw(window, circle(at, 60))
    assert not tool.count or not tool.selection.mask[face]
    key(window, Qt.Key.Key_Escape)
    key(window, Qt.Key.Key_U)
    wait(lambda: viewport.is_still, "the picture")
    assert viewport.pick(at.x(), at.y()).index == face
    draw(window, circle(at, 60))
    key(window, Qt.Key.Key_H, SHIFT)
    wait(lambda: viewport.is_still, "the picture")
    assert tool.count
    assert viewport.pick(at.x(), at.y()).index == face
    away = at + QPoint(150, 100)
    assert viewport.pick(away.x(), away.y()) is None
    driver.keep_picture(window, "select-8-isolated")
    key(window, Qt.Key.Key_U)
    # Undo shows again what was hidden, and it is chosen as before.
    count = tool.count
    key(window, Qt.Key.Key_H)
    assert not tool.is_open
    key(window, Qt.Key.Key_Z, CTRL)
    assert tool.count == count
    assert window.studio.workspace.elements.hidden(tool.selection.model_id) is None


@pytest.mark.full
def test_hidden_faces_stay_hidden_in_the_saved_project(
    own_folders, qtbot, outcrop, picks, tmp_path
):
    window = driver.make_window()
    at = ready(window, outcrop, picks)
    key(window, Qt.Key.Key_A)
    draw(window, circle(at, 60))
    face, id_ = window.viewport.pick(at.x(), at.y()).index, driver.model(window).id
    key(window, Qt.Key.Key_H)
    window.studio.save_as(tmp_path / "cliff.vom")
    driver.dismiss(window)
    window = driver.make_window([tmp_path / "cliff.vom"])
    driver.settled(window)
    wait(lambda: window.viewport.is_still, "the picture")
    assert window.studio.workspace.elements.hidden(id_)[face]
    found = window.viewport.pick(at.x(), at.y())
    assert found is None or found.index != face
    assert window.viewport.scene.models[id_].hidden[face]
    driver.dismiss(window)


@pytest.mark.full
def test_piece_is_cut_out_with_its_texture_and_original_is_kept(window, outcrop, picks):
    studio, tool = window.studio, window.studio.get_tool(SelectTool)
    at = ready(window, outcrop, picks)
    before = outcrop.read_bytes()
    original = driver.model(window)
    key(window, Qt.Key.Key_A)
    draw(window, circle(at, 100))
    count, mask = tool.count, tool.selection.mask.copy()
    window.actions_table.run("cut_out")
    wait(lambda: len(studio.models) == 2, "the piece")
    piece = next(m for m in studio.session.of(type(original)) if m.id != original.id)
    assert piece.to_world == original.to_world
    data, whole = studio.models[piece.id].data, studio.models[original.id].data
    assert len(data.faces) == count
    assert np.array_equal(data.vertices[data.faces], whole.vertices[whole.faces[mask]])
    assert np.array_equal(data.uv[data.faces], whole.uv[whole.faces[mask]])
    assert data.materials[0].texture.read_bytes() == whole.materials[0].texture.read_bytes()
    assert outcrop.read_bytes() == before
    assert studio.undo_label.startswith("Cut ") or tool.is_open
    key(window, Qt.Key.Key_Escape)
    studio.set_visible([original.id], False)
    wait(lambda: "complete" in window.viewport.models.reached_stages(piece.id), "the drawn piece")
    wait(lambda: window.viewport.is_still, "the picture")
    driver.keep_picture(window, "select-9-cut-out")


@pytest.mark.full
def test_selection_is_stored_as_a_draft(window, outcrop, picks):
    studio, tool = window.studio, window.studio.get_tool(SelectTool)
    at = ready(window, outcrop, picks)
    key(window, Qt.Key.Key_A)
    draw(window, circle(at, 60))
    mask, state = tool.selection.mask.copy(), dict(studio.session.draft.state)
    key(window, Qt.Key.Key_Escape)
    assert not tool.is_open
    assert studio.session.draft is None
    studio.workspace.tools.restore(state)
    assert np.array_equal(tool.selection.mask, mask)
    assert not tool.restore({"tool": "select", "chosen": {"model_id": "m", "size": 3}})
    assert not tool.restore({"tool": "select", "chosen": {**state["chosen"], "bits": "?"}})


def test_features_are_selected_by_clicks_and_shapes(window, outcrop, picks):
    studio, viewport = window.studio, window.viewport
    ready(window, outcrop, picks)
    for name in ("B04", "B05", "B06"):
        look_at(window, picks[name], 0.0, 10.0)
        key(window, Qt.Key.Key_T)
        driver.pick(window, picks[name][::3])
        key(window, Qt.Key.Key_Return)
    look_at(window, np.concatenate([picks[name] for name in ("B04", "B05", "B06")]), 0.0, 10.0)
    one, two, three = studio.session.of(Trace)
    key(window, Qt.Key.Key_S)
    window.actions_table.run("select_features")
    studio.selection.set([])
    places = [
        next(
            at
            for point in picks[name][::3]
            if window.view.feature_at((at := pixel(window, point)).x(), at.y()) == trace.id
        )
        for name, trace in (("B04", one), ("B05", two), ("B06", three))
    ]
    click(viewport, places[0])
    assert studio.selection.ids == (one.id,)
    driver.pause(QApplication.doubleClickInterval() + 50)
    click(viewport, places[1], SHIFT)
    driver.pause(QApplication.doubleClickInterval() + 50)
    click(viewport, places[2], CTRL)
    assert set(studio.selection.ids) == {one.id, two.id, three.id}
    driver.pause(QApplication.doubleClickInterval() + 50)
    click(viewport, places[1], SHIFT)
    assert set(studio.selection.ids) == {one.id, three.id}
    camera = viewport.moves.camera_state()
    drag(viewport, QPoint(3, 3), QPoint(viewport.width() - 4, viewport.height() - 4))
    assert viewport.moves.camera_state() == camera
    assert set(studio.selection.ids) == {one.id, two.id, three.id}
    key(window, Qt.Key.Key_A)
    centre = np.mean([studio.measured([two.id])[two.id].points], axis=(0, 1))
    draw(window, circle(pixel(window, centre), 12), ALT)
    assert set(studio.selection.ids) == {one.id, three.id}
    # While navigating, Shift adds like Ctrl, and pans only when it is dragged.
    key(window, Qt.Key.Key_N)
    driver.pause(QApplication.doubleClickInterval() + 50)
    click(viewport, places[1], SHIFT)
    assert set(studio.selection.ids) == {one.id, two.id, three.id}
    assert viewport.moves.camera_state() == camera
    drag(viewport, places[1], places[1] + QPoint(30, 0), modifier=SHIFT)
    assert viewport.moves.camera_state() != camera
