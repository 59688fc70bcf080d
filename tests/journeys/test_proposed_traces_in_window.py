"""Traces proposed on a slope with two known beds: looked at, accepted, edited, rejected."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.extraction.small_onnx import convolution
from tests.messages import figures, shown_codes, shown_values
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.surface.trace_texts import reason_text
from vomstudio.ui.panels.surface.traces_panel import TracesPanel

BEDS = {0.5: 60.0, 1.4: 30.0}


@pytest.fixture
def panel(window, tmp_path) -> TracesPanel:
    """Level dark beds at known heights on a slope of noise."""
    random = np.random.default_rng(1)
    y, x = (a.ravel() * 0.05 for a in np.mgrid[0:60, 0:60])
    x = x + random.normal(0.0, 0.005, len(x))
    z = 0.6 * y + 0.2 * np.sin(3.0 * x) + random.normal(0.0, 0.003, len(x))
    grey = 128.0 + random.normal(0.0, 10.0, len(x))
    for height, darker in BEDS.items():
        grey -= darker * (np.abs(z - height) < 0.04)
    colours = np.repeat(np.clip(grey, 0, 255).round()[:, None], 3, axis=1)
    path = tmp_path / "slope.csv"
    table = np.column_stack([x, y, z, colours])
    np.savetxt(path, table, delimiter=",", header="x,y,z,r,g,b", comments="", fmt="%.6f")
    driver.open_outcrop(window, path)
    driver.settled(window)
    window.actions_table.run("propose_traces")
    made = window.findChild(TracesPanel)
    driver.wait(made.isVisible, "the panel")
    driver.wait(made.start.isEnabled, "the model")
    made.cost.setCurrentIndex(made.cost.findData("dark"))
    made.limits.fields["min_length_m"].setValue(1.0)
    return made


def look(window, panel) -> None:
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == "Stop"
    driver.wait(lambda: not panel._traces.running, "the lines", 120.0)
    driver.settled(window)


def traces(window) -> list[Trace]:
    return window.studio.session.of(Trace)


def choose(panel, *rows: int) -> None:
    panel.table.clearSelection()
    panel.table.setFocus()
    for row in rows:
        index = panel.table.numbers.index(row, 0)
        select = panel.table.selectionModel()
        panel.table.setCurrentIndex(index) if len(rows) == 1 else select.select(
            index, select.SelectionFlag.Select | select.SelectionFlag.Rows
        )


@pytest.mark.full
def test_proposed_traces_are_reviewed_accepted_and_undone(window, panel) -> None:
    studio = window.studio
    before = dict(studio.records)
    look(window, panel)
    assert dict(studio.records) == before
    rows = [values for (values, _) in panel.table.numbers.rows]
    assert [row[0][0] for row in rows] == sorted(row[0][0] for row in rows)
    assert rows[0][0][0] < 0.05
    assert figures(panel.summary.text())[0] == len(panel._traces.open_rows)
    drawn = [key for key in window.viewport.features.drawings if key.startswith("proposed")]
    assert any(key.endswith(":sure") for key in drawn)
    choose(panel, 0)
    found = panel._traces.proposals
    assert panel.reason.text() == reason_text(found, found.lines[panel._current()])
    assert found.result.surrogates in figures(panel.reason.text())
    driver.settled(window)
    driver.keep_picture(window, "proposed-traces")

    left = len(panel._traces.open_rows)
    QTest.keyClick(panel.table, Qt.Key.Key_Return)
    (trace,) = traces(window)
    heights = np.array(trace.vertices)[:, 2]
    assert np.percentile(np.abs(heights - 0.5), 90) < 0.05
    assert shown_values(trace.notes, "trace.accepted")["cost"] == "dark"
    assert len(panel._traces.open_rows) == left - 1
    measured = studio.measured([trace.id])[trace.id]
    assert measured.plane is not None
    assert measured.plane.dip_deg < max(measured.max_confidence95_deg, 2.0)
    # Taken back it is to be decided upon again.
    studio.undo()
    assert traces(window) == []
    assert len(panel._traces.open_rows) == left
    studio.redo()
    assert len(panel._traces.open_rows) == left - 1
    # Several at once are one step.
    driver.settled(window)
    panel.table.selectAll()
    driver.click(panel.accept, panel.accept.rect().center())
    assert len(traces(window)) == left
    assert not panel._traces.open_rows
    studio.undo()
    assert len(traces(window)) == 1


@pytest.mark.full
def test_rejected_lines_and_existing_traces_are_not_proposed_again(window, panel) -> None:
    look(window, panel)
    lines = panel._traces.proposals.lines
    first, second = lines[0].points, lines[1].points
    choose(panel, 0)
    QTest.keyClick(panel.table, Qt.Key.Key_Delete)
    assert traces(window) == []
    assert 0 not in panel._traces.open_rows
    choose(panel, 0)
    QTest.keyClick(panel.table, Qt.Key.Key_Return)
    assert len(traces(window)) == 1
    look(window, panel)
    assert panel._traces.proposals.known > 0
    assert panel._traces.proposals.known in figures(panel.summary.text())

    def beside(line, other) -> float:
        gaps = np.linalg.norm(line[:, None] - other[None], axis=2).min(axis=1)
        return float((gaps < 0.05).mean())

    for one in panel._traces.proposals.lines:
        assert beside(one.points, first) < 0.5
        assert beside(one.points, second) < 0.5
    # By another cost, and shorter ones, neither.
    panel.limits.fields["min_length_m"].setValue(0.5)
    look(window, panel)
    assert all(beside(one.points, first) < 0.5 for one in panel._traces.proposals.lines)
    # Unless it is brought back.
    assert panel.restore.isEnabled()
    driver.click(panel.restore, panel.restore.rect().center())
    assert not panel.restore.isEnabled()
    panel.limits.fields["min_length_m"].setValue(1.0)
    look(window, panel)
    assert any(beside(one.points, first) > 0.5 for one in panel._traces.proposals.lines)


@pytest.mark.full
def test_proposed_line_is_edited_with_the_trace_tool(window, panel) -> None:
    studio = window.studio
    look(window, panel)
    wanted, left = panel._traces.proposals.lines[0].points, len(panel._traces.open_rows)
    choose(panel, 0)
    driver.click(panel.edit, panel.edit.rect().center())
    tool = studio.get_tool(TraceTool)
    assert studio.tool_name == "trace"
    assert tool.is_open
    assert tool.cost == "dark"
    assert 2 <= len(tool.vertices) <= 12
    assert len(panel._traces.open_rows) == left - 1
    # Given up it is to be decided upon again.
    tool.cancel()
    driver.wait(lambda: len(panel._traces.open_rows) == left, "the line in the list again")
    driver.settled(window)
    choose(panel, 0)
    driver.click(panel.edit, panel.edit.rect().center())
    driver.wait(lambda: not tool.is_searching, "the way", 60.0)
    driver.keep_picture(window, "proposed-trace-edited")
    tool.finish()
    driver.wait(lambda: traces(window), "the trace", 60.0)
    (trace,) = traces(window)
    off = np.linalg.norm(np.array(trace.vertices)[:, None] - wanted[None], axis=2).min(axis=1)
    assert np.percentile(off, 90) < 0.1
    assert shown_values(trace.notes, "trace.edited")["cost"] == "dark"
    assert "follow.by-cost" in shown_codes(trace.notes)
    assert len(panel._traces.open_rows) == left - 1


@pytest.mark.full
def test_clicking_a_line_on_the_outcrop_selects_its_row(window, panel) -> None:
    look(window, panel)
    line = panel._traces.proposals.lines[0].points
    driver.click(window.viewport, driver.pixel(window, line[len(line) // 2]))
    driver.wait(lambda: panel._selection() == [0], "the row")


@pytest.mark.full
def test_stopped_search_changes_nothing(window, panel) -> None:
    before, start = dict(window.studio.records), panel.start.text()
    driver.click(panel.start, panel.start.rect().center())
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == start
    assert "job.stopped" in shown_codes(panel.summary.text())
    assert dict(window.studio.records) == before
    look(window, panel)
    assert panel._traces.proposals is not None


@pytest.mark.full
def test_search_without_results_is_reported(window, panel) -> None:
    panel.limits.fields["min_length_m"].setValue(500.0)
    look(window, panel)
    assert panel._traces.proposals.lines == ()
    assert figures(panel.summary.text()) == [500]
    assert not panel.accept.isEnabled()
    assert "action.no-row" in shown_codes(panel.accept.toolTip())


@pytest.mark.full
def test_user_network_detects_the_edges(window, panel, tmp_path) -> None:
    panel.cost.setCurrentIndex(panel.cost.findData("onnx"))
    assert panel.network.isVisible()
    assert not panel.start.isEnabled()
    assert "ONNX file" in panel.start.toolTip()
    network = tmp_path / "net.onnx"
    network.write_bytes(b"nothing")
    panel.network.setText(str(network))
    look(window, panel)
    assert "file.other-format" in shown_codes(panel.summary.text())
    # One minus the lightness.
    network.write_bytes(convolution(np.full((1, 3, 1, 1), -1.0 / 3.0), bias=1.0))
    look(window, panel)
    first = panel._traces.proposals.lines[0]
    assert np.percentile(np.abs(first.points[:, 2] - 0.5), 90) < 0.08
    choose(panel, 0)
    assert panel.reason.text() == reason_text(panel._traces.proposals, first)
    driver.keep_picture(window, "proposed-traces-network")
    # The trace tool does not know the network: the line opens with its own vertices.
    driver.click(panel.edit, panel.edit.rect().center())
    tool = window.studio.get_tool(TraceTool)
    assert tool.is_open
    assert tool.cost is None
    assert len(tool.vertices) > 2
