"""Moving about never edits, and a click means what the active tool says."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import click, drag, key, look_at, pick, pixel, traces, wait
from tests.journeys.recorded import on_screen
from vomstudio.core.paths import resource
from vomstudio.studio.tools.trace import TraceTool

pytestmark = pytest.mark.full


@pytest.fixture
def picking(window, outcrop, picks):
    """The outcrop with a finished trace, and another one being picked."""
    driver.open_outcrop(window, outcrop)
    key(window, Qt.Key.Key_T)
    look_at(window, np.concatenate(list(picks.values())), 0.0, 10.0)
    pick(window, picks["B04"][2:22:3])
    key(window, Qt.Key.Key_Return)
    pick(window, picks["B03"][2:22:4])
    assert len(window.studio.get_tool(TraceTool).vertices) == 5
    return window


def free_place(window) -> QPoint:
    """On the outcrop, far from every vertex and line."""
    width, height = window.viewport.width(), window.viewport.height()
    for x in range(width // 2, width, 15):
        for y in range(height // 3, height, 15):
            if (
                window.viewport.pick(x, y) is not None
                and window.viewport.gestures.handle_at(x, y) is None
                and window.viewport.features.at(x, y) is None
            ):
                return QPoint(x, y)
    raise AssertionError("there is no free place")


def test_a_drag_moves_the_view_and_nothing_else(picking):
    before = on_screen(picking.studio)
    for button in (
        Qt.MouseButton.LeftButton,
        Qt.MouseButton.MiddleButton,
        Qt.MouseButton.RightButton,
    ):
        camera = picking.viewport.moves.camera_state()
        start = free_place(picking)
        drag(picking.viewport, start, start + QPoint(40, 25), button)
        assert on_screen(picking.studio) == before
        assert picking.viewport.moves.camera_state() != camera


def test_the_wheel_and_the_view_keys_move_the_view_and_nothing_else(picking):
    before = on_screen(picking.studio)
    viewport = picking.viewport
    at = free_place(picking)
    hit = viewport.pick(at.x(), at.y())
    event = QWheelEvent(
        QPointF(at),
        QPointF(viewport.mapToGlobal(at)),
        QPoint(),
        QPoint(0, 240),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(viewport, event)
    pixels, _ = viewport.project(viewport.world_position(hit)[None])
    assert np.hypot(*(pixels[0] - (at.x(), at.y()))) < 1.0, "the wheel zooms to the cursor"
    for code, looking in (
        (Qt.Key.Key_1, (0.0, 90.0)),
        (Qt.Key.Key_2, (0.0, 0.0)),
        (Qt.Key.Key_3, (90.0, 0.0)),
        (Qt.Key.Key_4, (180.0, 0.0)),
        (Qt.Key.Key_5, (270.0, 0.0)),
        (Qt.Key.Key_6, (0.0, -90.0)),
    ):
        key(picking, code, Qt.KeyboardModifier.AltModifier)
        assert viewport.moves.view_direction() == pytest.approx(looking, abs=1e-6)
    key(picking, Qt.Key.Key_O)
    assert viewport.moves.orthographic
    assert picking.actions_table.all["orthographic"].isChecked()
    assert "orthographic" in picking.view_panel.current_label.text()
    key(picking, Qt.Key.Key_O)
    key(picking, Qt.Key.Key_Home)
    key(picking, Qt.Key.Key_F)
    assert on_screen(picking.studio) == before


@pytest.mark.slow
def test_open_trace_is_kept_while_another_tool_is_used(picking, picks):
    before = on_screen(picking.studio)
    key(picking, Qt.Key.Key_N)
    click(picking.viewport, free_place(picking))
    assert on_screen(picking.studio) == before
    key(picking, Qt.Key.Key_T)
    pick(picking, picks["B03"][23:])
    assert len(picking.studio.get_tool(TraceTool).vertices) == 6


def test_clicking_a_plane_line_selects_it_and_clicking_beside_it_deselects(picking, picks):
    key(picking, Qt.Key.Key_Escape)
    key(picking, Qt.Key.Key_N)
    (trace,) = traces(picking)
    picking.studio.selection.set([])
    points = picking.studio.measured([trace.id])[trace.id].points
    click(picking.viewport, pixel(picking, points[3]))
    assert picking.studio.selection.ids == (trace.id,)
    assert picking.properties.fields["name"].text() == "B01"
    click(picking.viewport, free_place(picking))
    assert picking.studio.selection.ids == ()


@pytest.mark.full
@pytest.mark.parametrize("modifier", [driver.CTRL, Qt.KeyboardModifier.ShiftModifier])
def test_a_click_with_ctrl_or_shift_adds_to_the_selection(picking, modifier):
    key(picking, Qt.Key.Key_Return)
    key(picking, Qt.Key.Key_N)
    first, second = traces(picking)
    picking.studio.selection.set([])
    for trace, expected in ((first, (first.id,)), (second, (first.id, second.id))):
        points = picking.studio.measured([trace.id])[trace.id].points
        middle = points[1]
        click(picking.viewport, pixel(picking, middle), modifier)
        assert picking.studio.selection.ids == expected


def test_double_click_without_open_trace_sets_pivot_and_starts_nothing(picking):
    key(picking, Qt.Key.Key_Escape)
    key(picking, Qt.Key.Key_N)
    at = free_place(picking)
    before = on_screen(picking.studio)
    hit = picking.viewport.pick(at.x(), at.y())
    QTest.mouseClick(picking.viewport, driver.LEFT, driver.NONE, at)
    QTest.mouseDClick(picking.viewport, driver.LEFT, driver.NONE, at)
    assert on_screen(picking.studio) == before
    pivot = np.array(picking.viewport.camera.pivot)
    assert pivot == pytest.approx(picking.viewport.world_position(hit))


def test_a_file_dropped_on_the_window_is_opened(window, qtbot):
    """The small outcrop names its CRS itself, so nothing is asked."""
    driver.drop(window, [resource("outcrop", "outcrop.obj")])
    driver.settled(window)
    assert driver.model(window).frame.crs == "EPSG:32633"
    assert driver.dialog_of(window) is None
    assert str(resource("outcrop", "outcrop.obj")) in window.studio.settings.recent
    # The same file again is not a second model.
    window.open_path(resource("outcrop", "outcrop.obj"))
    wait(lambda: not window.studio.loader.busy, "the second reading")
    assert len(window.studio.models) == 1
