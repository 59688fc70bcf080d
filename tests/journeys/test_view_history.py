"""Back and forward through the views, beside undo and redo of the work."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from tests import driver
from tests.driver import click, drag, key, wait
from vomstudio.core.findings import Finding
from vomstudio.extraction.selection.visible_region import element_count
from vomstudio.studio.tools.select import SelectTool
from vomstudio.ui.base.actions import Actions

pytestmark = pytest.mark.full

SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def opened(window, outcrop):
    driver.open_outcrop(window, outcrop)
    rest(window)
    return window


def rest(window) -> None:
    """As long as a view must stand still to count."""
    wait(lambda: window.viewport.is_still, "the camera's rest")
    driver.pause(600)


def view(window) -> np.ndarray:
    """Where the camera is and how it stands, and the box that cuts, zero for none."""
    camera, box = window.viewport.camera, window.studio.display.effective_clip
    corners = np.zeros((2, 3)) if box is None else box.corners()[[0, -1]]
    parts = (camera.position, camera.frame.ravel(), [camera.distance, camera.orthographic])
    return np.concatenate([*parts, corners.ravel()])


def turn(window, dx: int = 80) -> None:
    at = window.viewport.rect().center()
    drag(window.viewport, at, at + QPoint(dx, 25))
    rest(window)


def back(window) -> None:
    key(window, Qt.Key.Key_Z, SHIFT)


def forward(window) -> None:
    key(window, Qt.Key.Key_Y, SHIFT)


def test_each_view_change_can_be_reverted_and_repeated(opened):
    display = opened.studio.display
    seen = [view(opened)]
    for change in (
        lambda: turn(opened),
        lambda: key(opened, Qt.Key.Key_O),
        lambda: opened.actions_table.run("clipping_box"),
        lambda: display.set_clip(display.box.move_face(0, 1, display.box.corners()[:, 0].mean())),
    ):
        change()
        rest(opened)
        assert not np.allclose(view(opened), seen[-1])
        seen.append(view(opened))
    for wanted in reversed(seen[:-1]):
        back(opened)
        assert np.allclose(view(opened), wanted, atol=1e-9)
    assert opened.actions_table.disabled_reason("view_back") == Finding("view.no-earlier")
    for wanted in seen[1:]:
        forward(opened)
        assert np.allclose(view(opened), wanted, atol=1e-9)
    assert opened.actions_table.disabled_reason("view_forward") == Finding("view.no-later")


def test_moving_view_can_be_reverted_immediately(opened):
    before = view(opened)
    at = opened.viewport.rect().center()
    drag(opened.viewport, at, at + QPoint(90, 0))
    assert not np.allclose(view(opened), before)
    assert opened.actions_table.all["view_back"].isEnabled()
    back(opened)
    assert np.allclose(view(opened), before, atol=1e-9)


def test_a_move_updates_only_the_commands_that_depend_on_the_camera(opened, monkeypatch):
    refreshed: list[str] = []
    monkeypatch.setattr(Actions, "_refresh_command", lambda _, name, __: refreshed.append(name))
    opened.view.state_changed.emit()
    assert set(refreshed) == {"orthographic", "view_back", "view_forward"}


def test_commands_are_updated_when_a_move_begins_and_ends(opened):
    updates: list[int] = []
    opened.view.state_changed.connect(lambda: updates.append(1))
    steps: list[int] = []
    opened.viewport.camera_changed.connect(lambda: steps.append(1))
    at = opened.viewport.rect().center()
    drag(opened.viewport, at, at + QPoint(90, 0))
    assert len(steps) > 2
    assert len(updates) == 1
    rest(opened)
    assert len(updates) == 2
    key(opened, Qt.Key.Key_O)
    is_checked = opened.actions_table.all["orthographic"].isChecked()
    assert is_checked == opened.view.is_orthographic


def test_new_view_clears_the_later_views(opened):
    turn(opened)
    back(opened)
    turn(opened, -60)
    there = view(opened)
    assert not opened.actions_table.all["view_forward"].isEnabled()
    forward(opened)
    assert np.allclose(view(opened), there)


def test_views_and_edits_are_undone_separately(opened):
    key(opened, Qt.Key.Key_T)
    at = opened.viewport.rect().center() + QPoint(-60, 0)
    click(opened.viewport, at)
    assert len(opened.studio.tool.vertices) == 1
    turn(opened)
    turned = view(opened)
    key(opened, Qt.Key.Key_Z, driver.CTRL)
    assert not opened.studio.tool.is_open
    assert np.allclose(view(opened), turned), "undo of a pick leaves the view"
    click(opened.viewport, at)
    assert len(opened.studio.tool.vertices) == 1
    back(opened)
    assert not np.allclose(view(opened), turned)
    assert len(opened.studio.tool.vertices) == 1, "back in the view leaves the pick"


def test_new_project_has_no_view_history(opened):
    turn(opened)
    opened.studio.new_project()
    rest(opened)
    assert not opened.actions_table.all["view_back"].isEnabled()
    assert not opened.actions_table.all["view_forward"].isEnabled()


def test_view_back_ends_isolation(opened):
    elements = opened.studio.workspace.elements
    (model_id,) = elements.shown()
    tool = opened.studio.get_tool(SelectTool)
    key(opened, Qt.Key.Key_S)
    count = element_count(elements.data(model_id))
    mask = np.zeros(count, bool)
    mask[: count // 3] = True
    tool.take(model_id, mask, tool.combine, "Choose a third")
    camera = view(opened)
    rest(opened)
    key(opened, Qt.Key.Key_H, SHIFT)
    assert elements.hidden(model_id).sum() == count - count // 3
    rest(opened)
    key(opened, Qt.Key.Key_N)
    turn(opened)
    assert not np.allclose(view(opened), camera, atol=1e-9)
    back(opened)
    assert np.allclose(view(opened), camera, atol=1e-9)
    assert elements.hidden(model_id) is not None, "the turn was the last change of the view"
    back(opened)
    assert elements.hidden(model_id) is None
    forward(opened)
    assert elements.hidden(model_id).sum() == count - count // 3
    assert np.array_equal(tool.selection.mask, mask), "what is chosen is no matter of the view"
    back(opened)
    assert elements.hidden(model_id) is None
