"""A model that stands turned is placed by planes on it that were read by compass, with mouse and
keys, and the command that is copied places it the same."""

from __future__ import annotations

import csv
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit

from tests import driver
from tests.journeys.test_known_lines import SCALE, TURN, tilted, to_file
from vomstudio.cli.common.arguments import Parser
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.geometry.transform import apply
from vomstudio.project import edits
from vomstudio.project.compass_edits import get_compass
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.ui.panels.tools.compass_dialog import CompassDialog
from vomstudio.ui.panels.tools.control import ControlPanel

pytestmark = pytest.mark.full

__all__ = ["tilted"]


def begin(window, tilted: Path, picks) -> ControlPanel:
    """The tilted outcrop with its traces, in the panel that places it."""
    world = np.load(tilted.with_name("world.npy"))
    window.open_path(tilted)
    driver.wait(lambda: driver.dialog_of(window) is not None, "the frame dialog")
    driver.dialog_of(window).reject()
    driver.settled(window)
    studio = window.studio
    model = driver.model(window)
    middle = world.mean(axis=0)
    for name, points in picks.items():
        places = tuple(map(tuple, to_file(points, middle).tolist()))
        trace = Trace(f"t-{name}", name, "bedding", model.id, model.content_hash, places)
        studio.attempt(edits.add_trace, trace)
    window.actions_table.run("register_model")
    panel = driver.tool_panel(window, ControlPanel)
    choose(panel, "plane")
    driver.look_at(window, to_file(world, middle), 25.0, 5.0)
    driver.wait(panel.compass.reading.isVisible, "the field for what was read")
    driver.focus(window)
    return panel


def choose(panel: ControlPanel, kind: str) -> None:
    panel.click_box.setCurrentIndex(panel.click_box.findData(kind))
    panel.click_box.activated.emit(panel.click_box.currentIndex())


def select(window, name: str) -> None:
    """Click the middle of a trace on the outcrop."""
    studio = window.studio
    trace = studio.records[f"t-{name}"]
    points = apply(driver.model(window).to_world, np.array(trace.vertices))
    for share in np.linspace(0.0, 1.0, 41):
        # Where another feature lies in front, another place of the trace is clicked.
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
        place = np.array([np.interp(share, along, points[:, k]) for k in range(3)])
        window.viewport.setFocus()
        driver.click(window.viewport, driver.pixel(window, place))
        driver.pause()
        if studio.selection.ids == (trace.id,):
            return
    raise AssertionError(f"{name} was not found on the outcrop")


def read(window, panel: ControlPanel, name: str, text: str) -> None:
    """Select a trace on the outcrop and type what was read, where the cursor then waits."""
    select(window, name)
    assert QApplication.focusWidget() is panel.compass.reading
    QTest.keyClicks(panel.compass.reading, text)
    QTest.keyClick(panel.compass.reading, Qt.Key.Key_Return)
    solved(panel)


def solved(panel: ControlPanel) -> None:
    """Wait for the placement, which is worked out beside the window."""
    driver.pause()
    driver.wait(lambda: not panel._solving.is_waiting, "the placement")
    driver.pause()


def off_deg(model: Model) -> float:
    matrix = np.array(model.to_world)[:3, :3]
    left = matrix / np.cbrt(np.linalg.det(matrix)) @ TURN
    return float(np.degrees(np.arccos(np.clip((np.trace(left) - 1.0) / 2.0, -1.0, 1.0))))


def spread(truth, count: int) -> list[str]:
    """Names of planes whose poles lie far apart."""
    names = list(truth)
    poles = np.array([pole(*truth[name]) for name in names])
    chosen = [0]
    while len(chosen) < count:
        near = np.abs(poles @ poles[chosen].T).max(axis=1)
        near[chosen] = 2.0
        chosen.append(int(near.argmin()))
    return [names[i] for i in chosen]


def pole(azimuth: float, dip: float) -> np.ndarray:
    a, d = np.radians([azimuth, dip])
    return np.array([np.sin(a) * np.sin(d), np.cos(a) * np.sin(d), np.cos(d)])


def test_compass_readings_of_planes_register_a_model(
    window, tilted, picks, truth, monkeypatch
) -> None:
    panel = begin(window, tilted, picks)
    studio = window.studio
    assert studio.tool_name == "known_line"
    assert not panel.compass.add_button.isEnabled()
    assert panel.compass.add_button.toolTip()
    names = spread(truth, 6)
    wrong = names[2]
    for name in names:
        azimuth, dip = truth[name]
        if name == wrong:
            azimuth = (azimuth - 90.0) % 360.0
        read(window, panel, name, f"{azimuth:.0f}/{dip:.0f} +- 3")
    assert [line.name for line in studio.session.of(KnownLine)] == names
    driver.keep_picture(window, "known_planes_wrong")

    # The strike that was read as dip direction is named, and its tick taken away.
    said = panel.summary.text()
    assert f"{wrong}" in said
    assert "+90°" in said
    assert "--without" not in said
    row = names.index(wrong)
    assert panel.lines.item(row, 5).text().endswith("°")
    assert not panel.lines.item(row, 1).icon().isNull()
    assert "the others agree" in panel.lines.item(row, 5).toolTip()
    panel.lines.item(row, 0).setCheckState(Qt.CheckState.Unchecked)
    solved(panel)
    assert float(panel.lines.item(row, 5).text()[:-1]) > 15.0
    left = [float(panel.lines.item(i, 5).text()[:-1]) for i in range(6) if i != row]
    assert max(left) < 6.0
    assert panel.placed.known.vertical
    assert panel.placed.known.north
    driver.keep_picture(window, "known_planes_right")

    # Its cell takes what was meant.
    panel.lines.item(row, 0).setCheckState(Qt.CheckState.Checked)
    azimuth, dip = truth[wrong]
    panel.lines.item(row, 3).setText(
        f"{azimuth - 90.0 if azimuth >= 90 else azimuth + 270:.0f}/{dip:.0f} RHR"
    )
    solved(panel)
    assert float(panel.lines.item(row, 5).text()[:-1]) < 6.0
    panel.lines.item(row, 3).setText("213/95")
    solved(panel)
    assert float(panel.lines.item(row, 5).text()[:-1]) < 6.0, "what is refused changes nothing"

    # Ten degrees of declination, stated, and the doubt about it.
    say_north(window, panel, north="magnetic", compass_declination="10", north_doubt="0.7")
    solved(panel)
    assert "+10.0°" in panel.compass.north_button.text()
    assert "declination" in panel.summary.text()
    table = tilted.with_name("readings.csv")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *a, **k: (str(table), ""))
    panel.copy.click()
    command = shlex.split(QGuiApplication.clipboard().text())
    driver.click(panel.register, panel.register.rect().center())
    driver.pause()
    model = driver.model(window)
    assert model.registration.method == "lines"
    assert model.registration.read_north.turned_deg == 10.0
    assert model.registration.read_north.doubt_deg == 0.7
    assert off_deg(model) == pytest.approx(10.0, abs=2.0)
    assert "north known" in studio.frame_name()
    driver.keep_picture(window, "known_planes_placed")

    # The command gives the same, of what it reads.
    assert command[:2] == ["vomstudio", "register"]
    assert command[command.index("--north-sigma") + 1] == "0.7"
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert [row["id"] for row in rows] == names
    placed = commanded(command[2:])
    ours = np.array(model.registration.matrix)[:3, :3]
    assert ours / np.cbrt(np.linalg.det(ours)) == pytest.approx(placed, abs=1e-9)

    # Kept with the project, and every step undone.
    driver.focus(window)
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert driver.model(window).registration is None
    assert get_compass(studio.records, model.id).declination_deg == 10.0
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert get_compass(studio.records, model.id) is None
    assert SCALE == 0.5


def commanded(words: list[str]) -> np.ndarray:
    """(3, 3) the rotation that the command's options give."""
    from vomstudio.studio.placing.register_order import register_model

    parser = Parser()
    add_options(parser, RegisterOptions)
    options = parse_options(parser.parse_args(words[1:]), RegisterOptions)
    placed = register_model("-", options, None).placed
    return placed.matrix[:3, :3] / placed.scale


def say_north(window, panel: ControlPanel, *, north: str, **fields: str) -> None:
    """In the dialog that the button opens."""
    from PySide6.QtCore import QTimer

    def fill() -> None:
        dialog = QApplication.activeModalWidget()
        assert isinstance(dialog, CompassDialog)
        dialog.north.setCurrentIndex(dialog.north.findData(north))
        ok = dialog.buttons.button(dialog.buttons.StandardButton.Ok)
        if north == "magnetic":
            assert not ok.isEnabled()
            assert ok.toolTip()
        for name, text in fields.items():
            field = dialog.findChild(QLineEdit, name)
            field.clear()
            QTest.keyClicks(field, text)
        driver.keep_picture(dialog, "compass_dialog")
        assert ok.isEnabled()
        QTest.mouseClick(ok, Qt.MouseButton.LeftButton)

    QTimer.singleShot(50, fill)
    panel.compass.north_button.click()
    driver.pause()


def test_invalid_reading_stays_in_the_field_and_deleted_trace_is_missing(
    window, tilted, picks, truth
) -> None:
    panel = begin(window, tilted, picks)
    studio = window.studio
    # Without points their table makes room for what is read.
    assert not panel.table.isVisible()
    choose(panel, "")
    assert panel.table.isVisible()
    choose(panel, "plane")
    assert not panel.table.isVisible()
    first, second, third = spread(truth, 3)
    for name in (first, second, third):
        read(window, panel, name, "{:.0f}/{:.0f}".format(*truth[name]))
    before = np.array(panel.placed.matrix)
    # Absurd ones are refused, and stay in the field to be corrected.
    read(window, panel, first, "213/95")
    assert panel.compass.reading.text() == "213/95"
    assert len(studio.session.of(KnownLine)) == 3
    studio.attempt(edits.delete, ["t-" + third])
    solved(panel)
    assert panel.lines.item(2, 5).text() == "missing"
    assert "no longer" in panel.lines.item(2, 5).toolTip()
    window.viewport.setFocus()
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    solved(panel)
    assert np.array(panel.placed.matrix) == pytest.approx(before)
    # A reading of the field book that is selected with a trace is what was read there.
    field = Reading("r1", "R01", "bedding", "plane", 213.0, 45.0)
    studio.attempt(edits.add_readings, [field])
    studio.selection.set(["t-" + second, "r1"])
    assert panel.compass.reading.text() == "213/45"
    assert second in panel.compass.feature_label.text()
    panel.compass.reading.clear()
    # A trace that is corrected moves its residual at once.
    trace = studio.records["t-" + third]
    shown = panel.lines.item(2, 5).text()
    bent = tuple((x, y + 0.2 * i, z) for i, (x, y, z) in enumerate(trace.vertices))
    studio.attempt(edits.change_feature, replace(trace, vertices=bent))
    solved(panel)
    assert panel.lines.item(2, 5).text() != shown


def test_reading_mistakes_are_undone_in_one_step(window, tilted, picks, truth) -> None:
    panel, studio = begin(window, tilted, picks), window.studio
    names = spread(truth, 4)

    def read_right(name: str) -> None:
        azimuth, dip = truth[name]
        read(window, panel, name, f"{azimuth:.0f}/{dip:.0f} +- 3")

    def typed(column: int, text: str) -> None:
        panel.lines.item(0, column).setText(text)
        solved(panel)

    def ticked() -> None:
        panel.lines.item(0, 0).setCheckState(Qt.CheckState.Unchecked)
        solved(panel)

    def deleted(id_: str) -> None:
        studio.selection.set([id_])
        driver.focus(window)
        driver.key(window, Qt.Key.Key_Delete)

    for name in names[:3]:
        read_right(name)
    # 1: read for the wrong plane; 2: a wrong value; 3: a wrong error; 4: left out; 5: a wrong name;
    # 6: the wrong north; 7: the reading deleted; 8: the plane that was read; 9: another type of it;
    # 10: placed too early
    mistakes = (
        lambda: read_right(names[3]),
        lambda: typed(3, "213/45"),
        lambda: typed(4, "9"),
        ticked,
        lambda: typed(1, "wrong"),
        lambda: say_north(window, panel, north="magnetic", compass_declination="10"),
        lambda: deleted(studio.session.of(KnownLine)[0].id),
        lambda: deleted(f"t-{names[0]}"),
        lambda: studio.attempt(edits.set_attributes, [f"t-{names[0]}"], type_id="joint"),
        lambda: driver.click(panel.register, panel.register.rect().center()),
    )
    for number, mistake in enumerate(mistakes, start=1):
        before = dict(studio.records)
        mistake()
        assert dict(studio.records) != before, f"{number} was no mistake"
        driver.focus(window)
        driver.key(window, Qt.Key.Key_Z, driver.CTRL)
        solved(panel)
        assert dict(studio.records) == before, number
