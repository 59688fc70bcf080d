"""The three-point problem in the real window: typed, clicked, added, and as a command."""

from __future__ import annotations

import json
import shlex

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import figures, shown_codes, shown_values
from vomstudio.cli.common.entry import main
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.panels.three_points_panel import ThreePointsPanel

BENNISON = (("393", "2374", "550"), ("1891", "2738", "650"), ("2191", "1037", "450"))
"""Bennison (1990), a coal seam in three boreholes: strike 106.45, dip 7.37."""


def press(button) -> None:
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def panel_of(window) -> ThreePointsPanel:
    window.actions_table.run("three_points")
    panel = window.findChild(ThreePointsPanel)
    assert not panel.visibleRegion().isEmpty()
    settle(panel)
    return panel


def settle(panel) -> None:
    driver.pause(200)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the plane")


def type_cell(panel, row: int, column: int, text: str) -> None:
    table = panel.table
    table.scrollToItem(table.item(row, column))
    at = table.visualItemRect(table.item(row, column)).center()
    QTest.mouseClick(table.viewport(), LEFT, NONE, at)
    QTest.mouseDClick(table.viewport(), LEFT, NONE, at)
    editor = QApplication.focusWidget()
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()


def told(capfd) -> dict:
    program, *arguments = shlex.split(QGuiApplication.clipboard().text())
    assert program == "vomstudio"
    capfd.readouterr()
    code = main([*arguments, "--json"])
    said = capfd.readouterr()
    assert code == 0, said.err
    return json.loads(said.out)


@pytest.mark.full
def test_bennison_three_point_example_is_typed_and_added(
    window, tmp_path, monkeypatch, capfd
) -> None:
    panel = panel_of(window)
    assert panel.result is None
    assert "three-points.too-few" in shown_codes(panel.message.text())
    assert not panel.add.isEnabled()
    assert shown_codes(panel.add.toolTip()) == {"action.no-result"}
    for row, words in enumerate(BENNISON):
        for column, text in enumerate(words):
            type_cell(panel, row, column, text)
    settle(panel)
    assert panel.result is not None, panel.message.text()
    assert panel.result.plane.dip_deg == pytest.approx(7.37, abs=0.005)
    assert panel.result.plane.max_confidence95_deg is None
    assert "three-points.no-error" in shown_codes(panel.message.text())
    driver.type_number(panel.options.fields["sigma_m"], "5")
    settle(panel)
    assert "± " in panel.message.text()
    driver.keep_picture(window, "three_points")
    points = tmp_path / "points.csv"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(points), ""))
    press(panel.copy)
    found = told(capfd)
    assert found["strike_rhr_deg"] == pytest.approx(106.45, abs=0.005)
    assert found["dip_error_deg"] == pytest.approx(panel.result.plane.dip_error_deg, rel=1e-12)
    press(panel.add)
    (reading,) = window.studio.session.of(Reading)
    assert reading.inclination_deg == panel.result.plane.dip_deg
    assert "± " in reading.notes
    assert reading.position == pytest.approx((4475 / 3, 6149 / 3, 550.0))
    window.actions_table.run("undo")
    assert not window.studio.session.of(Reading)


@pytest.mark.full
def test_invalid_three_points_are_reported(window, tmp_path, monkeypatch) -> None:
    panel = panel_of(window)
    for row, words in enumerate((("0", "0", "0"), ("1", "1", "1"), ("2", "2", "2"))):
        for column, text in enumerate(words):
            type_cell(panel, row, column, text)
    settle(panel)
    assert panel.result is None
    assert "points.collinear" in shown_codes(panel.message.text())
    type_cell(panel, 1, 2, "deep")
    settle(panel)
    assert shown_values(panel.message.text(), "number.invalid") == {"text": "deep"}
    assert figures(panel.message.text()) == [2]
    table = tmp_path / "wells.csv"
    table.write_text("name,x,y,z\n" + "".join(f"w,{','.join(row)}\n" for row in BENNISON))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(table), ""))
    press(panel.read)
    wait(lambda: panel.result is not None, "the seam")
    assert panel.result.plane.dip_deg == pytest.approx(7.37, abs=0.005)
    press(panel.add_row)
    settle(panel)
    assert panel.result.plane.n == 3


@pytest.mark.full
def test_three_clicks_on_the_outcrop_make_a_trace_with_its_plane(window, outcrop, picks) -> None:
    driver.open_outcrop(window, outcrop)
    panel = panel_of(window)
    trace = next(iter(picks.values()))
    driver.look_at(window, trace, 0.0, 10.0)
    press(panel.pick)
    driver.pick(window, trace[[0, len(trace) // 2, -1]])
    driver.key(window, Qt.Key.Key_Return)
    wait(lambda: panel.trace_id, "the trace")
    settle(panel)
    (made,) = window.studio.session.of(Trace)
    assert panel.result is not None
    plane = window.studio.measured([made.id])[made.id].plane
    assert panel.result.plane.dip_deg == pytest.approx(plane.dip_deg, abs=0.01)
    assert panel.result.plane.max_confidence95_deg is not None
    assert not panel.add.isEnabled()
    window.actions_table.run("undo")
    settle(panel)
    assert panel.trace_id == ""
