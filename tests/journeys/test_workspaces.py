"""Workspaces in the real window: camera and open work stay, and photos take the middle."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import CTRL, key, look_at, pick, wait
from vomstudio.ui.shell.layout import WORKSPACES

pytestmark = pytest.mark.full


def test_switching_workspace_keeps_camera_open_trace_and_keyboard_focus(window, outcrop, picks):
    driver.open_outcrop(window, outcrop)
    viewport, studio = window.viewport, window.studio
    look_at(window, picks["B04"], 10.0, 12.0)
    key(window, Qt.Key.Key_T)
    pick(window, picks["B04"][:3])
    tool = studio.open_tool
    vertices = list(tool.vertices)
    assert len(vertices) == 3
    wait(lambda: viewport.is_still, "the camera's rest")
    camera, label = viewport.moves.camera_state(), studio.undo_label
    for number in (1, 2, 3, 2):
        key(window, Qt.Key.Key_0 + number, CTRL)
        driver.pause(100)
        assert window.workspaces.current_workspace is WORKSPACES[number - 1]
        assert viewport.hasFocus()
        assert viewport.moves.camera_state() == camera
        assert list(tool.vertices) == vertices
        assert studio.undo_label == label
        driver.keep_picture(window, f"workspace_{WORKSPACES[number - 1].name}")
    key(window, Qt.Key.Key_Return)
    (trace,) = driver.traces(window)
    assert len(trace.vertices) == 3


def test_a_model_can_be_picked_in_every_workspace(window, outcrop, picks):
    """The outcrop is drawn anew at its new size: a click still hits what is under it."""
    driver.open_outcrop(window, outcrop)
    for number in range(1, 4):
        key(window, Qt.Key.Key_0 + number, CTRL)
        look_at(window, picks["B04"], 10.0, 12.0)
        key(window, Qt.Key.Key_T)
        pick(window, picks["B04"][:3])
        key(window, Qt.Key.Key_Return)
        assert len(driver.traces(window)) == number
        key(window, Qt.Key.Key_N)


@pytest.mark.parametrize("size", [(1280, 688), (960, 540)])
def test_photos_fill_the_center_until_a_model_opens(window, outcrop, photos, size):
    window.resize(*size)
    window.open_path(photos)
    wait(lambda: len(window.survey.rows) == 4 and not window.survey.is_reading, "the photos", 60.0)
    assert window.workspaces.current_workspace.name == "model"
    assert not window.viewport.isVisible()
    table = window.photos_panel.table
    assert table.visibleRegion().boundingRect().height() > 0.4 * size[1]
    for row in range(4):
        name = table.visualItemRect(table.item(row, 0))
        assert table.viewport().rect().contains(name.center())
    driver.keep_picture(window, f"photos_{size[0]}")
    window.open_path(outcrop)
    driver.declare(window)
    driver.settled(window)
    assert window.workspaces.current_workspace.name == "interpret"
    assert window.viewport.isVisible()
    QTest.keyClick(window, Qt.Key.Key_1, CTRL)
    window.docks.bring_forward("photos")
    driver.pause(100)
    assert window.viewport.isVisible()
    assert window.viewport.height() > 150
    assert not window.photos_panel.visibleRegion().isEmpty()
