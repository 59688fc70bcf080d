"""Planes grown and painted with the mouse, in the window that people use."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import CTRL, click, drag, key, look_at, move, open_outcrop, pixel, wait
from tests.journeys.conftest import SCREENS
from tests.tiers import first_in_default_tier
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.polyline import rgb
from vomstudio.ui.panels.tools.plane import PlanePanel

RIGHT = Qt.MouseButton.RightButton
SHIFT, ALT = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.AltModifier
NORTH = QPoint(0, -40)


def patches(window) -> list[Patch]:
    return window.studio.session.of(Patch)


def get_plane(window, patch: Patch) -> np.ndarray:
    """Normal of the chosen faces' plane by singular values, each corner with a third of the area
    of its face."""
    mesh = window.studio.models[patch.model_id].data
    corners = mesh.vertices[mesh.faces[runs_to_ids(patch.runs)]].astype(np.float64)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    points, weight = corners.reshape(-1, 3), np.repeat(area, 3)
    centred = points - np.average(points, axis=0, weights=weight)
    return np.linalg.svd(np.sqrt(weight)[:, None] * centred, full_matrices=False)[2][2]


def ready(window, outcrop, picks) -> QPoint:
    """Before the middle of a bed, with the brush in hand; where that is on the view."""
    open_outcrop(window, outcrop)
    wait(
        lambda: all(m.surface._faces_by_vertex is not None for m in window.studio.models.values()),
        "the search structures",
    )
    look_at(window, picks["B04"], 0.0, 10.0)
    key(window, Qt.Key.Key_P)
    assert window.studio.tool_name == "plane"
    key(window, Qt.Key.Key_G)
    at = pixel(window, np.median(picks["B04"], axis=0))
    assert window.viewport.pick(at.x(), at.y()) is not None
    return at


def still(window) -> None:
    viewport = window.viewport
    wait(lambda: viewport.is_still, "the camera's rest")


@pytest.mark.full
def test_plane_is_painted_edited_and_restored_after_reopening(
    own_folders, qtbot, outcrop, picks, tmp_path
):
    window = driver.make_window()
    studio, viewport, tool = window.studio, window.viewport, window.studio.get_tool(PlaneTool)
    at = ready(window, outcrop, picks)
    panel = driver.tool_panel(window, PlanePanel)
    assert panel.isVisible()
    move(viewport, at)
    assert viewport.preview.brush is not None
    panel.radius.setValue(0.25)
    assert tool.radius == 0.25

    # The view stands still while the left button paints.
    camera = viewport.moves.camera_state()
    drag(viewport, at, at + QPoint(60, 20), release=False)
    assert tool.is_painting
    assert viewport.preview.stroke is not None
    assert " ± " in viewport.preview.reading[0]
    assert panel.fit_view.isVisible()
    driver.keep_picture(window, "plane-1-painting")
    drag(viewport, at, at + QPoint(60, 20))
    QTest.mouseRelease(viewport, driver.LEFT, driver.NONE, at + QPoint(60, 20))
    assert viewport.moves.camera_state() == camera
    assert not tool.is_painting
    painted = tool.selection.mask
    assert painted.sum() > 20
    assert patches(window) == []

    # Shift adds, Alt removes, undo brings back; the right button moves the view.
    drag(viewport, at + 2 * NORTH, at + 2 * NORTH + QPoint(20, 0), modifier=SHIFT)
    more = tool.selection.mask
    assert (more & painted).sum() == painted.sum() < more.sum()
    drag(viewport, at, at + QPoint(20, 8), modifier=ALT)
    less = tool.selection.mask
    assert less.sum() < more.sum()
    key(window, Qt.Key.Key_Z, CTRL)
    assert np.array_equal(tool.selection.mask, more)
    key(window, Qt.Key.Key_Y, CTRL)
    assert np.array_equal(tool.selection.mask, less)
    assert viewport.moves.camera_state() == camera
    drag(viewport, at, at + QPoint(40, 0), RIGHT)
    assert viewport.moves.camera_state() != camera
    viewport.moves.set_camera_state(camera)
    still(window)

    # The keys of the brush; Esc discards only the stroke that is being painted.
    key(window, Qt.Key.Key_BracketLeft)
    assert tool.radius == pytest.approx(0.2)
    assert panel.radius.value() == pytest.approx(0.2)
    key(window, Qt.Key.Key_BracketRight)
    drag(viewport, at + 2 * NORTH, at + 2 * NORTH + QPoint(40, 0), modifier=SHIFT, release=False)
    key(window, Qt.Key.Key_Z, CTRL)
    assert tool.is_painting
    key(window, Qt.Key.Key_Escape)
    assert not tool.is_painting
    QTest.mouseRelease(viewport, driver.LEFT, driver.NONE, at + 2 * NORTH)
    assert np.array_equal(tool.selection.mask, less)

    # Enter keeps the plane of the chosen faces.
    key(window, Qt.Key.Key_Return)
    (patch,) = patches(window)
    assert np.array_equal(runs_to_ids(patch.runs), np.flatnonzero(less))
    measured = studio.measured([patch.id])[patch.id]
    assert abs(measured.fit.normal @ get_plane(window, patch)) == pytest.approx(1.0, abs=1e-9)
    assert measured.verdict is not None
    assert studio.selection.ids == (patch.id,)
    # Poor planes are outlined, others are filled.
    drawing = viewport.features.drawings[patch.id]
    assert drawing.is_outlined == (measured.verdict.quality == "poor")
    assert (drawing.area is None) == drawing.is_outlined

    # Another one of another type, grown, in an orthographic view.
    panel.type_box.setCurrentIndex(panel.type_box.findData("joint"))
    window.actions_table.run("orthographic")
    still(window)
    place = pixel(window, np.median(picks["B04"], axis=0)) - 2 * NORTH
    click(viewport, place)
    wait(lambda: tool.count, "the plane")
    assert viewport.preview.color == rgb(studio.records["joint"].color)
    key(window, Qt.Key.Key_Return)
    assert [p.name for p in patches(window)] == ["B01", "J01"]
    driver.keep_picture(window, "plane-2-two")

    # A double click changes it.
    key(window, Qt.Key.Key_N)
    move(viewport, QPoint(5, 5))
    studio.selection.set([])
    QTest.qWait(QApplication.doubleClickInterval() + 50)
    click(viewport, place)
    joint = patches(window)[1]
    assert studio.selection.ids == (joint.id,)
    QTest.mouseDClick(viewport, driver.LEFT, driver.NONE, place)
    assert studio.tool_name == "plane"
    assert tool.is_continued
    assert not panel.type_box.isEnabled()
    drag(viewport, place + QPoint(60, 0), place + QPoint(80, 0), modifier=SHIFT)
    key(window, Qt.Key.Key_Return)
    assert [p.name for p in patches(window)] == ["B01", "J01"]
    assert len(runs_to_ids(patches(window)[1].runs)) >= len(runs_to_ids(joint.runs))
    key(window, Qt.Key.Key_N)
    kept = patches(window)
    studio.save_as(tmp_path / "cliff.vom")
    driver.dismiss(window)

    # The next day, once more without the model's file.
    window = driver.make_window([tmp_path / "cliff.vom"])
    driver.settled(window)
    assert patches(window) == kept
    drawings = window.viewport.features.drawings
    wait(lambda: all(p.id in drawings for p in kept), "the patches")
    assert all((drawings[p.id].area is None) == drawings[p.id].is_outlined for p in kept)
    driver.dismiss(window)
    outcrop.unlink()
    window = driver.make_window([tmp_path / "cliff.vom"])
    wait(lambda: kept[0].id in window.viewport.features.drawings, "the outline")
    drawing = window.viewport.features.drawings[kept[0].id]
    assert drawing.area is None
    assert drawing.disc is not None or drawing.is_outlined
    assert len(drawing.line) == len(kept[0].outline) + 1
    driver.dismiss(window)


@pytest.mark.parametrize("screen", first_in_default_tier(SCREENS), indirect=True)
def test_ten_planes_take_twenty_actions(window, screen, outcrop, picks):
    at, viewport = ready(window, outcrop, picks), window.viewport
    tool, actions = window.studio.get_tool(PlaneTool), 0
    tool.set_tolerance(angle_deg=8.0, distance=0.02)
    step = viewport.height() // 16
    places = [at + QPoint(step * (k % 5 - 2), step * (k // 5) - step // 2) for k in range(10)]
    for number, place in enumerate(places):
        click(viewport, place)
        key(window, Qt.Key.Key_Return)
        actions += 2
        wait(lambda count=number + 1: len(patches(window)) == count, "the plane")
    driver.keep_picture(window, f"plane-3-ten-{screen}")
    assert actions == 20
    assert not tool.is_open


def test_preview_takes_the_colour_of_a_new_type_immediately(window, outcrop, picks):
    at, viewport, studio = ready(window, outcrop, picks), window.viewport, window.studio
    click(viewport, at)
    wait(lambda: studio.get_tool(PlaneTool).count, "the plane")
    drawn = []
    viewport.features.set_preview_areas = lambda areas: drawn.append([color for _, color in areas])
    for number, name in ((Qt.Key.Key_2, "fault"), (Qt.Key.Key_3, "joint")):
        key(window, number)
        assert viewport.preview.color == rgb(studio.records[name].color)
        assert drawn[-1] == [viewport.preview.color]
    del viewport.features.set_preview_areas
    key(window, Qt.Key.Key_Return)
    assert patches(window)[0].type_id == "joint"


def test_quick_drag_paints_without_gaps(window, outcrop, picks):
    """One jump of the cursor across the view paints all that lies between."""
    at = ready(window, outcrop, picks)
    tool = window.studio.get_tool(PlaneTool)
    move(window.viewport, at)
    tool.set_radius(0.12)

    def send(kind, place, held):
        changed = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseMove else driver.LEFT
        where = QPointF(window.viewport.mapToGlobal(place))
        QApplication.sendEvent(
            window.viewport, QMouseEvent(kind, QPointF(place), where, changed, held, driver.NONE)
        )

    end = at + QPoint(160, 0)
    send(QEvent.Type.MouseButtonPress, at, driver.LEFT)
    send(QEvent.Type.MouseMove, end, driver.LEFT)
    send(QEvent.Type.MouseButtonRelease, end, Qt.MouseButton.NoButton)
    chosen = set(tool.selection.ids().tolist())
    for x in range(0, 161, 4):
        hit = window.viewport.pick(at.x() + x, at.y())
        assert hit is None or hit.index in chosen


@pytest.mark.full
def test_two_quick_clicks_are_not_a_double_click(window, outcrop, picks):
    at = ready(window, outcrop, picks)
    tool = window.studio.get_tool(PlaneTool)
    tool.set_tolerance(angle_deg=8.0, distance=0.02)
    pivot = window.viewport.moves.camera_state()
    QTest.mouseClick(window.viewport, driver.LEFT, driver.NONE, at)
    wait(lambda: tool.count, "the plane")
    QTest.mouseDClick(window.viewport, driver.LEFT, SHIFT, at + QPoint(60, 30))
    QTest.mouseRelease(window.viewport, driver.LEFT, SHIFT, at + QPoint(60, 30))
    assert window.viewport.moves.camera_state() == pivot
    assert tool.undo_label == "Grow"
    assert tool.undo()
    assert tool.count > 0
