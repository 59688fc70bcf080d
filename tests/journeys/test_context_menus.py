"""The same menu for a feature on rock, net, tree and table, with real clicks."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QContextMenuEvent, QCursor, QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMenu, QWidget

from tests import driver
from tests.driver import LEFT, NONE, click, drag, key, look_at, open_outcrop, pixel, wait
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.outcrop.outcrop_view import NORMAL_RADIUS_SPACINGS

RIGHT = Qt.MouseButton.RightButton


def shown_menu() -> QMenu:
    """The menu that has just opened; it is closed for the next one."""
    wait(lambda: QApplication.activePopupWidget() is not None, "the menu")
    menu = QApplication.activePopupWidget()
    assert isinstance(menu, QMenu)
    return menu


def right_click(widget: QWidget, at: QPoint) -> QMenu:
    QTest.mouseMove(widget, at)
    QTest.mouseClick(widget, RIGHT, NONE, at)
    return shown_menu()


def entries(menu: QMenu) -> list[str]:
    return [a.objectName() or a.text().replace("&", "") for a in menu.actions() if a.text()]


def run(menu: QMenu, text: str) -> None:
    """Click an entry, in a submenu if need be."""
    for action in menu.actions():
        if action.menu() is not None and text in entries(action.menu()):
            menu = action.menu()
            menu.popup(QPoint(10, 10))
            break
    action = next(a for a in menu.actions() if text in (a.objectName(), a.text().replace("&", "")))
    QTest.mouseClick(menu, LEFT, NONE, menu.actionGeometry(action).center())
    driver.pause(30)
    while QApplication.activePopupWidget() is not None:
        QApplication.activePopupWidget().close()


def ready(window, outcrop, picks) -> QPoint:
    open_outcrop(window, outcrop)
    wait(
        lambda: all(m.surface._faces_by_vertex is not None for m in window.studio.models.values()),
        "the search structures",
    )
    look_at(window, picks["B04"], 0.0, 10.0)
    return pixel(window, np.median(picks["B04"], axis=0))


@pytest.mark.full
def test_outcrop_context_menu_starts_a_plane_and_moves_the_view(window, outcrop, picks):
    studio, viewport = window.studio, window.viewport
    at = ready(window, outcrop, picks)
    menu = right_click(viewport, at)
    assert {"Grow plane", "Start trace", "Centre of rotation", "Copy coordinates"} <= set(
        entries(menu)
    )
    driver.keep_picture(window, "menu-1-rock")
    run(menu, "Grow plane")
    plane = studio.get_tool(PlaneTool)
    wait(lambda: plane.count, "the plane")
    assert studio.tool_name == "plane"
    # While it is open, the menu ends it.
    menu = right_click(viewport, at)
    assert {"finish", "cancel"} <= set(entries(menu))
    assert "Grow plane" not in entries(menu)
    run(menu, "finish")
    (patch,) = studio.session.of(Patch)

    before = viewport.moves.camera_state()
    away = at + QPoint(120, 90)
    hit = viewport.pick(away.x(), away.y())
    key(window, Qt.Key.Key_N)
    run(right_click(viewport, away), "Look along normal")
    wait(lambda: viewport.is_still, "the view")
    assert viewport.moves.camera_state() != before
    radius = NORMAL_RADIUS_SPACINGS * studio.models[hit.model_id].resolution
    normal = studio.surface(hit.model_id).local_normal(hit.index, hit.position, radius)
    assert abs(viewport.camera.direction @ normal) == pytest.approx(1.0, abs=1e-3)
    viewport.moves.set_camera_state(before)
    run(right_click(viewport, away), "Centre of rotation")
    np.testing.assert_allclose(viewport.camera.pivot, viewport.world_position(hit), atol=1e-6)
    run(right_click(viewport, away), "Copy coordinates")
    copied = [float(word) for word in QGuiApplication.clipboard().text().split()]
    np.testing.assert_allclose(copied, viewport.world_position(hit), atol=1e-3)
    run(right_click(viewport, away), "Start trace")
    assert len(studio.get_tool(TraceTool).vertices) == 1
    key(window, Qt.Key.Key_Escape)
    # The menu key opens it at the cursor.
    QCursor.setPos(viewport.mapToGlobal(away))
    asked = QContextMenuEvent(QContextMenuEvent.Reason.Keyboard, away, viewport.mapToGlobal(away))
    QApplication.sendEvent(viewport, asked)
    menu = shown_menu()
    assert "Copy coordinates" in entries(menu)
    menu.close()
    # A drag of the button moves the view and opens no menu.
    drag(viewport, away, away + QPoint(40, 0), RIGHT)
    assert QApplication.activePopupWidget() is None
    assert studio.session.of(Patch) == [patch]


def test_a_feature_has_one_menu_everywhere(window, outcrop, picks):
    studio, viewport = window.studio, window.viewport
    ready(window, outcrop, picks)
    look_at(window, picks["B04"], 0.0, 10.0)
    key(window, Qt.Key.Key_T)
    driver.pick(window, picks["B04"][::3])
    key(window, Qt.Key.Key_Return)
    key(window, Qt.Key.Key_N)
    (trace,) = studio.session.of(Trace)
    studio.selection.set([])
    on_rock = pixel(window, picks["B04"][0])
    menu = right_click(viewport, on_rock)
    assert studio.selection.ids == (trace.id,)
    rock = entries(menu)
    assert {"edit_feature", "frame_selection", "face_plane", "show_in_photos"} <= set(rock)
    assert {"hide_chosen", "delete", "Type", "Set"} <= set(rock)
    driver.keep_picture(window, "menu-2-feature")
    run(menu, "Joint")
    assert studio.records[trace.id].type_id == "joint"

    window.docks.bring_forward("table")
    driver.pause(50)
    view = window.table.view
    row = view.visualRect(view.model().index(0, 0)).center()
    view.customContextMenuRequested.emit(row)
    table = shown_menu()
    window.docks.bring_forward("project")
    in_table = entries(table)
    table.close()
    in_tree = entries(window.tree.create_menu(trace.id))
    assert in_table == in_tree
    assert [name for name in rock if name in in_table] == in_table
    wait(lambda: window.net.artists is not None, "the net")
    driver.pause(300)
    canvas, artists = window.net.canvas, window.net.artists
    ratio = canvas.devicePixelRatioF()
    found = [
        QPoint(x, y)
        for x in range(0, canvas.width(), 4)
        for y in range(0, canvas.height(), 4)
        if artists.feature_at(x * ratio, (canvas.height() - y) * ratio, 4.0 * ratio) == trace.id
    ]
    canvas.customContextMenuRequested.emit(found[0])
    net = shown_menu()
    assert entries(net) == in_table
    net.close()


@pytest.mark.full
def test_a_double_click_edits_a_feature(window, outcrop, picks):
    studio = window.studio
    ready(window, outcrop, picks)
    key(window, Qt.Key.Key_T)
    driver.pick(window, picks["B04"][::3])
    key(window, Qt.Key.Key_Return)
    key(window, Qt.Key.Key_N)
    driver.pause(QApplication.doubleClickInterval() + 50)
    at = pixel(window, picks["B04"][0])
    click(window.viewport, at)
    QTest.mouseDClick(window.viewport, LEFT, NONE, at)
    assert studio.tool_name == "trace"
    assert studio.get_tool(TraceTool).is_continued
    key(window, Qt.Key.Key_Escape)
