"""Patches painted with the mouse, in the window that people use."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import CTRL, click, drag, key, look_at, move, open_outcrop, pixel, wait
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.ui.panels.tools.plane import PlanePanel

RIGHT, MIDDLE = Qt.MouseButton.RightButton, Qt.MouseButton.MiddleButton
NORTH = QPoint(0, -40)


def patches(window) -> list[Patch]:
    return window.studio.session.of(Patch)


def plane_of(window, patch: Patch) -> np.ndarray:
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
        lambda: all(m.surface._faces_of is not None for m in window.studio.models.values()),
        "the search structures",
    )
    look_at(window, picks["B04"], 0.0, 10.0)
    key(window, Qt.Key.Key_P)
    assert window.studio.tool_name == "plane"
    at = pixel(window, np.median(picks["B04"], axis=0))
    assert window.viewport.pick(at.x(), at.y()) is not None
    return at


def still(window) -> None:
    viewport = window.viewport
    wait(lambda: viewport.still, "the camera's rest")


@pytest.mark.full
def test_a_patch_is_painted_corrected_and_found_again(own_folders, qtbot, outcrop, picks, tmp_path):
    window = driver.make_window()
    studio, viewport, tool = window.studio, window.viewport, window.studio.tool_of(PlaneTool)
    at = ready(window, outcrop, picks)
    assert driver.tool_panel(window, PlanePanel).isVisible()
    move(viewport, at)
    assert viewport.preview.brush is not None
    driver.tool_panel(window, PlanePanel).radius.setValue(0.25)
    assert tool.radius == 0.25

    # The view stands still while the left button paints.
    camera = viewport.moves.camera_state()
    drag(viewport, at, at + QPoint(60, 20), release=False)
    assert tool.open
    assert viewport.preview.area is not None
    assert " ± " in viewport.preview.reading[0]
    assert driver.tool_panel(window, PlanePanel).fit_view.isVisible()
    driver.keep_picture(window, "patch-1-painting")
    drag(viewport, at, at + QPoint(60, 20))
    QTest.mouseRelease(viewport, driver.LEFT, driver.NONE, at + QPoint(60, 20))
    assert viewport.moves.camera_state() == camera
    (patch,) = patches(window)
    assert len(runs_to_ids(patch.runs)) > 20
    measured = studio.measured([patch.id])[patch.id]
    assert abs(measured.fit.normal @ plane_of(window, patch)) == pytest.approx(1.0, abs=1e-9)
    assert measured.verdict is not None
    assert studio.selection.ids == (patch.id,)
    assert viewport.features.drawings[patch.id].area is not None

    # Ctrl takes away, undo brings back; the other buttons move the view.
    drag(viewport, at, at + QPoint(20, 8), modifier=CTRL)
    (less,) = patches(window)
    assert set(runs_to_ids(less.runs)) < set(runs_to_ids(patch.runs))
    key(window, Qt.Key.Key_Z, CTRL)
    assert patches(window) == [patch]
    key(window, Qt.Key.Key_Y, CTRL)
    assert patches(window) == [less]
    key(window, Qt.Key.Key_Z, CTRL)
    assert viewport.moves.camera_state() == camera
    drag(viewport, at, at + QPoint(40, 0), RIGHT)
    turned = viewport.moves.camera_state()
    assert turned != camera
    drag(viewport, at, at + QPoint(0, 30), driver.LEFT, Qt.KeyboardModifier.ShiftModifier)
    assert viewport.moves.camera_state() != turned
    viewport.moves.set_camera_state(camera)
    still(window)
    assert patches(window) == [patch]

    # The keys of the brush; one click is one place.
    key(window, Qt.Key.Key_BracketLeft)
    assert tool.radius == pytest.approx(0.2)
    assert driver.tool_panel(window, PlanePanel).radius.value() == pytest.approx(0.2)
    key(window, Qt.Key.Key_BracketRight)
    assert tool.radius == pytest.approx(0.25)
    click(viewport, at + NORTH)
    (grown,) = patches(window)
    assert set(runs_to_ids(grown.runs)) > set(runs_to_ids(patch.runs))
    assert "Paint B01" in (studio.session.undo_label or "")

    # Escape abandons what is being painted, and only that; undo does nothing then.
    drag(viewport, at + 2 * NORTH, at + 2 * NORTH + QPoint(40, 0), release=False)
    key(window, Qt.Key.Key_Z, CTRL)
    assert patches(window) == [grown]
    assert tool.open
    key(window, Qt.Key.Key_Escape)
    assert not tool.open
    QTest.mouseRelease(viewport, driver.LEFT, driver.NONE, at + 2 * NORTH)
    assert patches(window) == [grown]
    assert viewport.preview.area is None

    # Another one, of another type, in an orthographic view.
    key(window, Qt.Key.Key_Return)
    assert tool.current is None
    driver.tool_panel(window, PlanePanel).type_box.setCurrentIndex(
        driver.tool_panel(window, PlanePanel).type_box.findData("joint")
    )
    window.actions_table.run("orthographic")
    still(window)
    place = pixel(window, np.median(picks["B04"], axis=0)) - 2 * NORTH
    click(viewport, place)
    assert [p.name for p in patches(window)] == ["B01", "J01"]
    assert abs(
        studio.measured([patches(window)[1].id])[patches(window)[1].id].fit.normal
        @ plane_of(window, patches(window)[1])
    ) == pytest.approx(1.0, abs=1e-9)
    driver.keep_picture(window, "patch-2-two")

    # A click on it finds it again; it is taken up and finished.
    key(window, Qt.Key.Key_N)
    move(viewport, QPoint(5, 5))
    studio.selection.set([])
    QTest.qWait(QApplication.doubleClickInterval() + 50)
    click(viewport, place)
    assert studio.selection.ids == (patches(window)[1].id,)
    window.actions_table.run("edit_feature")
    assert studio.tool_name == "plane"
    assert tool.continued
    assert not driver.tool_panel(window, PlanePanel).type_box.isEnabled()
    QTest.qWait(QApplication.doubleClickInterval() + 50)
    click(viewport, place + QPoint(30, 0))
    assert [p.name for p in patches(window)] == ["B01", "J01"]
    key(window, Qt.Key.Key_N)
    assert tool.current is None
    kept = patches(window)
    studio.save_as(tmp_path / "cliff.vom")
    driver.dismiss(window)

    # The next day, once more without the model's file.
    window = driver.make_window([tmp_path / "cliff.vom"])
    driver.settled(window)
    assert patches(window) == kept
    wait(
        lambda: window.viewport.features.drawings[kept[0].id].area is not None, "the painted faces"
    )
    driver.dismiss(window)
    outcrop.unlink()
    window = driver.make_window([tmp_path / "cliff.vom"])
    wait(lambda: kept[0].id in window.viewport.features.drawings, "the outline")
    drawing = window.viewport.features.drawings[kept[0].id]
    assert drawing.area is None
    assert drawing.disc is not None
    assert len(drawing.line) == len(kept[0].outline) + 1
    driver.dismiss(window)


def test_a_quick_drag_leaves_no_gaps(window, outcrop, picks):
    """One jump of the cursor across the view paints all that lies between."""
    at = ready(window, outcrop, picks)
    tool = window.studio.tool_of(PlaneTool)
    move(window.viewport, at)
    tool.set_radius(0.12)
    from PySide6.QtCore import QEvent, QPointF
    from PySide6.QtGui import QMouseEvent

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
    (patch,) = patches(window)
    chosen = set(runs_to_ids(patch.runs).tolist())
    for x in range(0, 161, 4):
        hit = window.viewport.pick(at.x() + x, at.y())
        assert hit is None or hit.index in chosen


@pytest.mark.full
def test_two_quick_clicks_are_two_strokes(window, outcrop, picks):
    at = ready(window, outcrop, picks)
    pivot = window.viewport.moves.camera_state()
    QTest.mouseClick(window.viewport, driver.LEFT, driver.NONE, at)
    QTest.mouseDClick(window.viewport, driver.LEFT, driver.NONE, at + QPoint(60, 0))
    QTest.mouseRelease(window.viewport, driver.LEFT, driver.NONE, at + QPoint(60, 0))
    assert window.viewport.moves.camera_state() == pivot
    (patch,) = patches(window)
    assert window.studio.session.undo_label == f"Paint {patch.name}"
