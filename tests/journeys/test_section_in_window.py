"""Sections and elevation models in the real window: cut, drawn, written, and as commands."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import shown_codes, shown_values
from vomstudio.cli.common.entry import main
from vomstudio.project import edits
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.panels.sections.elevation_panel import ElevationPanel
from vomstudio.ui.panels.sections.section_panel import SectionPanel


@pytest.fixture
def model_id(window, outcrop, picks):
    """The outcrop with five of its traces."""
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    for name, points in list(picks.items())[:5]:
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    return model_id


def press(button) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def type_in(field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    if text:
        QTest.keyClicks(field, text)
    else:
        QTest.keyClick(field, Qt.Key.Key_Delete)


def told(line: str, capfd, *more: str) -> dict:
    """What the command on the clipboard says."""
    program, *arguments = shlex.split(line)
    assert program == "vomstudio"
    capfd.readouterr()
    code = main([*arguments, *more, "--json"])
    said = capfd.readouterr()
    assert code == 0, said.err
    return json.loads(said.out)


def section_of(window) -> SectionPanel:
    window.actions_table.run("section")
    panel = window.findChild(SectionPanel)
    assert not panel.visibleRegion().isEmpty()
    return panel


def settle(panel) -> None:
    driver.pause(200)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the section")


def test_section_along_a_plane_matches_its_command(
    window, model_id, tmp_path, monkeypatch, capfd
) -> None:
    panel = section_of(window)
    settle(panel)
    assert not panel.write.isEnabled()
    assert shown_codes(panel.message.text()) == {"field.plane-missing"}
    type_in(panel.plane.line, "110/90")
    settle(panel)
    assert panel.result is not None, panel.message.text()
    figures = panel.result.figures
    assert figures.features > 0
    driver.keep_picture(window, "section_panel")
    press(panel.copy)
    out = tmp_path / "cut.csv"
    line = QGuiApplication.clipboard().text()
    found = told(line, capfd, "-o", str(out))
    assert found["length_m"] == pytest.approx(figures.length_m, rel=1e-12)
    assert (found["polylines"], found["features"]) == (figures.polylines, figures.features)
    for name in ("mine.svg", "mine.dxf", "mine.csv"):
        target = tmp_path / name
        monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, t=target: (str(t), ""))
        press(panel.write)
        wait(target.exists, name)
    # The second table is written after the first one.
    wait((tmp_path / "mine_features.csv").exists, "the features")
    assert (tmp_path / "mine.csv").read_text() == out.read_text()
    assert (tmp_path / "mine_features.csv").read_text() == (
        tmp_path / "cut_features.csv"
    ).read_text()


@pytest.mark.full
def test_line_drawn_on_the_outcrop_defines_the_section(
    window, model_id, picks, tmp_path, monkeypatch, capfd
) -> None:
    panel = section_of(window)
    points = np.concatenate(list(picks.values()))
    driver.look_at(window, points, 0.0, 10.0)
    press(panel.draw_line)
    trace = next(iter(picks.values()))
    clicked = trace[[0, len(trace) // 2, -1]]
    driver.pick(window, clicked)
    driver.key(window, Qt.Key.Key_Return)
    wait(lambda: panel.line is not None, "the line")
    settle(panel)
    assert panel.result is not None, panel.message.text()
    (drawn,) = window.studio.session.of(Dimension)
    assert np.array_equal(panel.line, window.studio.measured([drawn.id])[drawn.id].points)
    length = np.hypot(*np.diff(panel.line[:, :2], axis=0).T).sum()
    along = np.concatenate([line[:, 0] for line in panel.result.cut.lines])
    assert along.min() >= -1e-9
    assert along.max() <= length + 1e-6
    profile = tmp_path / "a line.csv"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(profile), ""))
    press(panel.copy)
    found = told(QGuiApplication.clipboard().text(), capfd, "-o", str(tmp_path / "cut.svg"))
    assert found["length_m"] == pytest.approx(panel.result.figures.length_m, rel=1e-12)


@pytest.mark.full
def test_a_section_is_drawn_from_the_side_of_the_viewer(window, model_id, picks, capfd) -> None:
    panel = section_of(window)
    ends = []
    for trend in (290.0, 110.0):
        driver.look_at(window, np.concatenate(list(picks.values())), trend)
        type_in(panel.plane.line, "")
        type_in(panel.plane.line, "110/90")
        settle(panel)
        # The viewer sees the azimuth to the right of the view on the right.
        assert panel.result.figures.right_deg == pytest.approx((trend + 90.0) % 360.0)
        ends.append(panel.result.drawing.ends)
    assert ends[0] == ends[1][::-1]
    panel.section_options.fields["flip"].click()
    settle(panel)
    assert panel.result.drawing.ends == ends[0]
    press(panel.copy)
    line = QGuiApplication.clipboard().text()
    found = told(line, capfd, "-o", str(window.studio.project.folder / "cut.csv"))
    assert found["right_deg"] == pytest.approx(panel.result.figures.right_deg)


@pytest.mark.full
def test_impossible_section_is_reported(window, model_id) -> None:
    panel = section_of(window)
    for typed, through, code in (
        ("110/95", "", "notation.dip-out-of-range"),
        ("steep", "", "notation.unknown-word"),
        ("110/90", "1, 2", "section.not-a-point"),
        ("110/90", "1, 2, 3", "section.misses-model"),
    ):
        type_in(panel.plane.line, typed)
        type_in(panel.through, through)
        settle(panel)
        assert shown_codes(panel.message.text()) == {code}
        assert panel.result is None
        assert not panel.copy.isEnabled()
    type_in(panel.through, "")
    type_in(panel.direction.line, "020/00")
    settle(panel)
    assert panel.result is None
    said = shown_values(panel.message.text(), "section.along-direction")
    assert said == {"limit_deg": "2", "recommended_deg": "20"}


def test_elevation_model_is_shown_and_matches_its_command(
    window, model_id, tmp_path, capfd
) -> None:
    import rasterio

    window.actions_table.run("elevation_model")
    panel = window.findChild(ElevationPanel)
    wait(panel.start.isEnabled, "the model")
    target = tmp_path / "heights.tif"
    type_in(panel.target, str(target))
    panel.grid.fields["gsd_m"].setValue(0.05)
    type_in(panel.plane.line, "200/80")
    press(panel.copy)
    line = QGuiApplication.clipboard().text()
    press(panel.start)
    wait(lambda: panel.result is not None and panel.picture.picture is not None, "the heights", 60)
    driver.keep_picture(window, "elevation_panel")
    assert "200" in panel.figures.text()
    assert (tmp_path / "heights_hillshade.tif").exists()
    with rasterio.open(target) as file:
        ours = file.read(1)
    found = told(line, capfd, "-o", str(tmp_path / "again.tif"))
    with rasterio.open(tmp_path / "again.tif") as file:
        assert np.array_equal(ours, file.read(1), equal_nan=True)
    assert found["coverage"] == panel.result.figures.coverage
    place = panel.picture._image_rect().center().toPoint()
    QTest.mouseMove(panel.picture, place)
    driver.pause(50)
    assert "height" in panel.cursor_label.text()


@pytest.mark.full
def test_an_elevation_model_can_be_stopped(window, model_id, tmp_path) -> None:
    window.actions_table.run("elevation_model")
    panel = window.findChild(ElevationPanel)
    wait(panel.start.isEnabled, "the model")
    target = tmp_path / "heights.tif"
    type_in(panel.target, str(target))
    panel.grid.fields["gsd_m"].setValue(0.002)
    press(panel.start)
    assert panel.start.text() == "Stop"
    press(panel.start)
    wait(lambda: panel.start.text() != "Stop", "the end")
    assert shown_codes(panel.message.text()) == {"job.stopped"}
    assert not target.exists()
    type_in(panel.plane.line, "95")
    assert not panel.start.isEnabled()
    assert "notation.one-angle" in shown_codes(panel.start.toolTip())
    type_in(panel.plane.line, "")
    assert Path(panel.target.text()) == target
