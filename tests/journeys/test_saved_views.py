"""Views by name, in the real window: saved, left, looked at again, after reopening too."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import drag, wait
from tests.messages import shown_codes
from vomstudio.ui.panels.view.saved_views_box import SavedViewsBox

pytestmark = pytest.mark.full


def rest(window) -> None:
    wait(lambda: window.viewport.is_still, "the camera's rest")


def view(window) -> np.ndarray:
    camera, box = window.viewport.camera, window.studio.display.effective_clip
    corners = np.zeros((2, 3)) if box is None else box.corners()[[0, -1]]
    return np.concatenate([camera.position, camera.frame.ravel(), corners.ravel()])


def test_named_view_is_restored_with_its_clipping_box(window, outcrop, tmp_path):
    driver.open_outcrop(window, outcrop)
    rest(window)
    box = window.findChild(SavedViewsBox)
    assert not box.save.isEnabled()
    assert "action.no-name" in shown_codes(box.save.toolTip())
    QTest.keyClicks(box.names, "Main face")
    QTest.mouseClick(box.save, Qt.MouseButton.LeftButton)
    first = view(window)

    at = window.viewport.rect().center()
    drag(window.viewport, at, at + QPoint(120, 40))
    rest(window)
    window.actions_table.run("clipping_box")
    box.names.clearEditText()
    QTest.keyClicks(box.names, "Cut")
    QTest.keyClick(box.names, Qt.Key.Key_Return)
    second = view(window)
    assert not np.allclose(first, second)

    box.names.setCurrentText("Main face")
    QTest.keyClick(box.names, Qt.Key.Key_Return)
    rest(window)
    np.testing.assert_allclose(view(window), first, atol=1e-6)
    box.names.setCurrentText("Cut")
    QTest.keyClick(box.names, Qt.Key.Key_Return)
    rest(window)
    np.testing.assert_allclose(view(window), second, atol=1e-6)

    path = tmp_path / "views.vom"
    window.studio.save_as(path)
    window.studio.workspace.projects.new()
    assert box.names.count() == 0
    window.studio.project.journal.set_view("named_views", [{"name": "bad", "camera": {"x": 1}}])
    box.fill()
    window.open_path(path)
    driver.settled(window)
    assert [box.names.itemText(i) for i in range(box.names.count())] == ["Main face", "Cut"]
    box.names.setCurrentText("Main face")
    QTest.mouseClick(box.delete, Qt.MouseButton.LeftButton)
    assert [box.names.itemText(i) for i in range(box.names.count())] == ["Cut"]
