"""Coordinates that cannot be meant are refused in a sentence, and what stood there stays."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

from tests import driver
from tests.driver import key
from tests.messages import shown_codes
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.tools.trace import TracePanel

pytestmark = pytest.mark.full


def type_into_cell(table, row: int, column: int, text: str) -> None:
    """As somebody does: double click, type, Enter."""
    at = table.visualItemRect(table.item(row, column)).center()
    QTest.mouseClick(table.viewport(), driver.LEFT, driver.NONE, at)
    QTest.mouseDClick(table.viewport(), driver.LEFT, driver.NONE, at)
    editor = QApplication.focusWidget()
    assert isinstance(editor, QLineEdit)
    editor.selectAll()
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    driver.pause(30)


@pytest.mark.parametrize("text", ["1e30", "nan", "inf", "-1e308", "1e999", "999999999", "x"])
def test_vertex_cannot_be_moved_far_from_the_model(window, outcrop, picks, text):
    driver.open_outcrop(window, outcrop)
    points = next(iter(picks.values()))[:4]
    driver.look_at(window, points, 0.0)
    key(window, Qt.Key.Key_T)
    tool = window.studio.tools["trace"]
    assert isinstance(tool, TraceTool)
    driver.pick(window, points)
    assert tool.is_open
    before = tool.vertices
    table = driver.tool_panel(window, TracePanel).table
    type_into_cell(table, 1, 1, text)
    assert tool.vertices == before
    assert window.message_bar.isVisible()
    said = window.message_bar.text
    assert said.endswith(".")
    assert table.item(1, 1).text() != text


def test_a_face_of_the_clipping_box_stays_near_the_models(window, outcrop):
    driver.open_outcrop(window, outcrop)
    window.actions_table.run("clipping_box")
    before = window.studio.display.box
    assert before is not None
    window.docks.bring_forward("display")
    spin = window.display_panel.faces[1]
    spin.setFocus()
    spin.selectAll()
    QTest.keyClicks(spin, "999999999")
    QTest.keyClick(spin, Qt.Key.Key_Return)
    assert window.studio.display.box == before
    assert "coordinate.far-from-model" in shown_codes(window.message_bar.text)
    assert spin.value() == pytest.approx(before.high[0], abs=0.01)
    near = before.high[0] + 0.5 * (before.high[0] - before.low[0])
    spin.setFocus()
    spin.selectAll()
    QTest.keyClicks(spin, f"{near:.2f}")
    QTest.keyClick(spin, Qt.Key.Key_Return)
    assert window.studio.display.box.high[0] == pytest.approx(near, abs=0.01)


def test_invalid_camera_state_is_rejected(window, outcrop):
    driver.open_outcrop(window, outcrop)
    state = window.viewport.moves.camera_state()
    for value in (1e30, float("nan"), float("inf")):
        absurd = {**state, "position": [value, 0.0, 0.0]}
        with pytest.raises(ValueError, match="camera"):
            window.viewport.moves.set_camera_state(absurd)
        assert np.isfinite(window.viewport.camera.position).all()
        assert window.viewport.moves.camera_state() == state
