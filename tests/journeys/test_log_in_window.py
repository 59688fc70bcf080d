"""A log along a line in the real window: boundaries by clicks and by traces, words, files."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QFileDialog

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import shown_codes
from vomstudio.cli.common.entry import main
from vomstudio.project import edits
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.panels.logs.log_panel import BedLogPanel
from vomstudio.ui.panels.logs.log_table import LITHOLOGY, NOTES


@pytest.fixture
def model_id(window, outcrop, picks):
    """The outcrop with all its traces of beds."""
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    for name, points in picks.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    return model_id


def press(button) -> None:
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def panel_of(window) -> BedLogPanel:
    window.actions_table.run("bed_log")
    panel = window.findChild(BedLogPanel)
    assert not panel.visibleRegion().isEmpty()
    return panel


def settle(panel) -> None:
    driver.pause(250)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the log")


def beds_in_turn(picks):
    """The middles of the traces, from the lowest bed up."""
    return sorted(picks.values(), key=lambda points: points[:, 2].mean())


def type_rock(panel, row: int, text: str) -> None:
    """A double click on the cell, and keys."""
    table = panel.table
    at = table.visualItemRect(table.item(row, LITHOLOGY)).center()
    QTest.mouseClick(table.viewport(), LEFT, NONE, at)
    QTest.mouseDClick(table.viewport(), LEFT, NONE, at)
    (box,) = table.viewport().findChildren(QComboBox)
    box.lineEdit().selectAll()
    QTest.keyClicks(box.lineEdit(), text)
    QTest.keyClick(box.lineEdit(), Qt.Key.Key_Return)
    QApplication.processEvents()
    settle(panel)


@pytest.mark.full
def test_boundaries_are_clicked_and_the_log_is_written(
    window, model_id, picks, tmp_path, monkeypatch, capfd
) -> None:
    panel = panel_of(window)
    settle(panel)
    assert panel.result is None
    assert "bed.no-line" in shown_codes(panel.message.text())
    assert not panel.copy.isEnabled()
    beds = beds_in_turn(picks)
    driver.look_at(window, np.concatenate(beds), 0.0, 10.0)
    press(panel.pick)
    driver.pick(window, np.array([beds[i][len(beds[i]) // 2] for i in (0, len(beds) // 2, -1)]))
    driver.key(window, Qt.Key.Key_Return)
    wait(lambda: panel.line_id, "the picked line")
    settle(panel)
    assert panel.result is not None, panel.message.text()
    log = panel.result.log
    assert log.n == 3
    assert [panel.table.item(row, 0).text() for row in range(2)] == ["2", "1"]
    type_rock(panel, 1, "sandstone")
    type_rock(panel, 0, "gneiss")
    assert panel.result.log.intervals[0].strabospot["siliciclastic_type"] == "sandstone"
    assert "gneiss" in panel.message.text()
    wait(lambda: not panel.picture.image.isNull(), "the figure")
    driver.keep_picture(window, "log_panel")
    for name in ("mine.csv", "mine.svg", "mine.pdf"):
        target = tmp_path / name
        monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, t=target: (str(t), ""))
        press(panel.write)
        wait(target.exists, name)
    table = tmp_path / "boundaries.csv"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(table), ""))
    press(panel.copy)
    program, *arguments = shlex.split(QGuiApplication.clipboard().text())
    assert program == "vomstudio"
    capfd.readouterr()
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["total_m"]["value"] == pytest.approx(log.total_m.value, rel=1e-9)
    assert found["total_m"]["error95"] == pytest.approx(log.total_m.error95, rel=1e-9)
    assert [i["lithology"] for i in found["intervals"]] == ["sandstone", "gneiss"]
    assert (tmp_path / "mine.csv").read_text("utf-8") == Path(found["table"]).read_text("utf-8")
    assert (tmp_path / "mine.svg").read_bytes() == Path(found["image"]).read_bytes()


@pytest.mark.full
def test_traces_crossing_a_line_are_its_boundaries(window, model_id, picks) -> None:
    """A line that runs straight across the middles of three traces meets these, and a later
    deletion of one is noticed."""
    studio = window.studio
    beds = beds_in_turn(picks)
    chosen = [beds[i] for i in (0, 1, 2)]
    names = [name for bed in chosen for name, points in picks.items() if points is bed]
    ends = tuple(tuple(bed[len(bed) // 2].tolist()) for bed in chosen)
    model = studio.records[model_id]
    line = Dimension("m1", "section A", "polyline", model_id, model.content_hash, ends)
    assert studio.attempt(edits.add_features, [line])
    panel = panel_of(window)
    studio.selection.set(("m1",))
    driver.pause()
    press(panel.take)
    driver.type_number(panel.line_options.fields["reach_m"], "0.01")
    settle(panel)
    assert panel.result is not None, panel.message.text()
    assert {b.name for b in panel.result.boundaries} >= set(names)
    before = panel.result.log.n
    studio.selection.set((names[1],))
    studio.delete_selected()
    settle(panel)
    assert panel.result.log.n == before - 1
    driver.type_number(panel.line_options.fields["reach_m"], "far")
    settle(panel)
    assert panel.result.log.n == before - 1


@pytest.mark.full
def test_text_being_typed_survives_a_new_log(window, model_id, picks) -> None:
    studio = window.studio
    beds = beds_in_turn(picks)
    model = studio.records[model_id]
    ends = tuple(tuple(beds[i][len(beds[i]) // 2].tolist()) for i in (0, 3, 6))
    line = Dimension("m1", "section A", "polyline", model_id, model.content_hash, ends)
    assert studio.attempt(edits.add_features, [line])
    panel = panel_of(window)
    studio.selection.set(("m1",))
    driver.pause()
    press(panel.take)
    box = panel.line_options.fields["of"]
    box.setCurrentIndex(box.findData("points"))
    box.activated.emit(box.currentIndex())
    settle(panel)
    assert panel.result is not None, panel.message.text()
    table = panel.table
    item = table.item(0, NOTES)
    table.scrollToItem(item)
    at: QPoint = table.visualItemRect(item).center()
    QTest.mouseClick(table.viewport(), LEFT, NONE, at)
    QTest.mouseDClick(table.viewport(), LEFT, NONE, at)
    editor = table.viewport().focusWidget() or QApplication.focusWidget()
    QTest.keyClicks(editor, "cross")
    panel.options.fields["overturned"].click()
    settle(panel)
    QTest.keyClicks(editor, "-bedded")
    QTest.keyClick(editor, Qt.Key.Key_Return)
    settle(panel)
    assert "cross-bedded" in {notes for _, _, notes in studio.records["m1"].beds}


@pytest.mark.full
def test_bed_descriptions_are_stored_with_the_line(
    window, model_id, picks, tmp_path, monkeypatch, capfd
) -> None:
    """Undone and done again, saved, opened again, told by the command and in exports; the
    words of a trace stay with it where the line gets another point."""
    studio = window.studio
    beds = beds_in_turn(picks)
    chosen = [beds[i] for i in (0, 1, 2)]
    names = [name for bed in chosen for name, points in picks.items() if points is bed]
    ends = tuple(tuple(bed[len(bed) // 2].tolist()) for bed in chosen)
    model = studio.records[model_id]
    line = Dimension("m1", "section A", "polyline", model_id, model.content_hash, ends)
    assert studio.attempt(edits.add_features, [line])
    panel = panel_of(window)
    studio.selection.set(("m1",))
    driver.pause()
    press(panel.take)
    driver.type_number(panel.line_options.fields["reach_m"], "0.01")
    settle(panel)
    low = [panel.table.item(row, 1).text() for row in range(panel.table.rowCount())]
    at = low.index(names[0])
    type_rock(panel, at, "sandstone")
    assert panel.result.log.intervals[-1 - at].lithology == "sandstone"
    assert studio.records["m1"].beds == ((names[0], "sandstone", ""),)
    studio.undo()
    settle(panel)
    assert studio.records["m1"].beds == ()
    assert panel.table.item(at, LITHOLOGY).text() == ""
    studio.redo()
    settle(panel)
    assert panel.table.item(at, LITHOLOGY).text() == "sandstone"
    # Typed again as it is, nothing changes.
    label = studio.session.undo_label
    type_rock(panel, at, "sandstone")
    assert studio.session.undo_label == label
    folder = tmp_path / "kept.vom"
    studio.save_as(folder)
    driver.pause(300)
    capfd.readouterr()
    words = ["log", str(folder), "--line", "section A", "--reach", "0.01", "--json"]
    assert main(words) == 0
    found = json.loads(capfd.readouterr().out)
    log = panel.result.log
    assert [i["lithology"] for i in found["intervals"]] == [i.lithology for i in log.intervals]
    assert found["total_m"]["value"] == pytest.approx(log.total_m.value, rel=1e-9)
    assert found["total_m"]["error95"] == pytest.approx(log.total_m.error95, rel=1e-9)
    assert found["line"] == "section A"
