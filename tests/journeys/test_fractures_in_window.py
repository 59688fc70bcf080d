"""Fractures and fault displacement in the real window, against closed forms and the commands."""

from __future__ import annotations

import json
import re
import shlex

import numpy as np
import pytest
from PySide6.QtCore import QPoint
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import figures, shown_codes, shown_values
from vomstudio.cli.common.entry import main
from vomstudio.geology.orientation import Plane
from vomstudio.project import edits, grid_edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import FaceGrid
from vomstudio.ui.panels.displacement_panel import DisplacementPanel
from vomstudio.ui.panels.fractures.fractures_panel import FracturesPanel


def press(button) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def type_in(field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)


def settle(panel) -> None:
    driver.pause(200)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the figures")


def add(window, model_id: str, name: str, points, kind: str = "joint", set_name: str = "") -> str:
    model = window.studio.records[model_id]
    vertices = tuple(map(tuple, np.asarray(points, float).tolist()))
    trace = Trace(name, name, kind, model_id, model.content_hash, vertices, set_name=set_name)
    assert window.studio.attempt(edits.add_trace, trace)
    return name


def told(line: str, capfd) -> dict:
    program, *arguments = shlex.split(line)
    assert program == "vomstudio"
    capfd.readouterr()
    code = main([*arguments, "--json"])
    said = capfd.readouterr()
    assert code == 0, said.err
    return json.loads(said.out)


# --- fractures ---------------------------------------------------------------------------------
def on_a_wall(window, model_id: str, xz) -> np.ndarray:
    """Places right and up on a vertical wall that faces south, beside the outcrop."""
    low, _ = window.studio.models[model_id].data.bounds
    xz = np.asarray(xz, float)
    before = np.where(np.arange(len(xz)) == 1, 0.3, 0.0)  # or they would be straight
    return np.column_stack([low[0] + xz[:, 0], low[1] - before, low[2] + xz[:, 1]])


@pytest.fixture
def wall(window, outcrop):
    """Three level traces six metres long, and one that ends on two of them."""
    model_id = driver.open_outcrop(window, outcrop)
    for y in (1, 2, 3):
        add(
            window,
            model_id,
            f"L{y}",
            on_a_wall(window, model_id, [(0, y), (3, y), (6, y)]),
            set_name="level",
        )
    add(window, model_id, "V", on_a_wall(window, model_id, [(2, 1), (2, 2), (2, 3)]))
    window.actions_table.run("count_fractures")
    panel = window.findChild(FracturesPanel)
    assert not panel.visibleRegion().isEmpty()
    window.docks.ensure_height("fractures", 330)
    type_in(panel.plane.line, "180/90")
    settle(panel)
    return panel


def corner(panel) -> np.ndarray:
    """On the map, of the place (0, 0) of the wall."""
    return np.concatenate(panel.result.lines).min(axis=0) - [0, 1]


def figures_of(statistics) -> dict:
    return json.loads(json.dumps(statistics.to_dict(), default=lambda finding: finding.to_dict()))


def nearly(value):
    """The same to rounding: areas go from the face to World and back."""
    if isinstance(value, dict):
        return {key: nearly(each) for key, each in value.items()}
    if isinstance(value, list):
        return [nearly(each) for each in value]
    return pytest.approx(value, rel=1e-9, abs=1e-9) if isinstance(value, float) else value


@pytest.mark.full
def test_window_statistics_match_closed_form_and_command(
    window, wall, tmp_path, monkeypatch, capfd
) -> None:
    panel = wall
    left, low = corner(panel)
    type_in(panel.region_field, f"{left + 1}, {low}, {left + 5}, {low + 4}")
    settle(panel)
    statistics = panel.result.network.statistics
    # Three pieces of four metres and one of two on 16 m2; that one crosses the middle one.
    assert statistics.P21_1_per_m == pytest.approx(14 / 16, rel=1e-6)
    assert statistics.P20_1_per_m2 == pytest.approx(4 / 16, rel=1e-6)
    assert (statistics.nodes.Y, statistics.nodes.X) == (2, 1)
    assert {s.name for s in statistics.sets} == {"level", "Joint"}
    assert "0.875" in panel.figures.toPlainText()
    assert "one face" in panel.message.text()
    panel.tabs.setCurrentWidget(panel.picture)
    wait(lambda: not panel.picture.image.isNull(), "the figure")
    driver.keep_picture(window, "fractures_figure")
    panel.tabs.setCurrentWidget(panel.map)
    driver.keep_picture(window, "fractures_panel")
    target = tmp_path / "a b" / "traces.gpkg"
    target.parent.mkdir()
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(panel.copy)
    said = told(QGuiApplication.clipboard().text(), capfd)
    mine = figures_of(statistics)
    said.pop("image")
    assert said == nearly(mine)


@pytest.mark.full
def test_inspected_grid_cells_are_used_as_the_sampling_window(
    window, wall, tmp_path, monkeypatch, capfd
) -> None:
    """Without a plane the face is that of the grid; cells that were not looked at, or in which
    nothing can be measured, count for nothing."""
    panel, studio = wall, window.studio
    model_id = studio.records["V"].model_id
    model = studio.records[model_id]
    low, _ = studio.models[model_id].data.bounds
    grid = FaceGrid(
        "g",
        "South wall",
        model_id,
        model.content_hash,
        tuple(low.tolist()),
        (1.0, 0.0, 0.0),
        (0.0, 0.0, 1.0),
        1.0,
        6,
        4,
    )
    assert studio.attempt(grid_edits.add_grid, grid)
    settle(panel)
    panel.plane.line.clear()
    panel.region_box.setCurrentIndex(panel.region_box.findText("Coverage: South wall"))
    settle(panel)
    said = shown_values(panel.message.text(), "fractures.no-cells")
    assert said == {"grid": "South wall"}
    assert panel.result.network is None
    assert not panel.copy.isEnabled()
    four = [row * 6 + column for row in range(4) for column in (1, 2, 3, 4)]
    assert studio.attempt(grid_edits.mark_cells, "g", four, "d")
    settle(panel)
    statistics = panel.result.network.statistics
    # As of the window of the same corners.
    assert statistics.area_m2 == pytest.approx(16, rel=1e-5)
    assert statistics.P21_1_per_m == pytest.approx(14 / 16, rel=1e-5)
    assert (statistics.nodes.Y, statistics.nodes.X) == (2, 1)
    (cells,) = (line for line in panel.message.text().splitlines() if "South wall" in line)
    assert 16 in figures(cells)
    driver.keep_picture(window, "fractures_in_a_grid")
    last = [row * 6 + 4 for row in range(4)]
    assert studio.attempt(grid_edits.mark_cells, "g", last, "u")
    # Nothing was found there, but somebody looked.
    assert studio.attempt(grid_edits.mark_cells, "g", [1], "e")
    settle(panel)
    statistics = panel.result.network.statistics
    assert statistics.area_m2 == pytest.approx(12, rel=1e-5)
    assert statistics.P21_1_per_m == pytest.approx(11 / 12, rel=1e-5)
    target = tmp_path / "traces.gpkg"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(panel.copy)
    said = told(QGuiApplication.clipboard().text(), capfd)
    assert said["P21_1_per_m"] == pytest.approx(statistics.P21_1_per_m, rel=1e-9)
    assert said["area_m2"] == pytest.approx(statistics.area_m2, rel=1e-9)
    # The window takes the place of a grid that is gone.
    assert studio.attempt(grid_edits.remove_grid, "g")
    settle(panel)
    assert panel.region_box.currentText() == "Window"


@pytest.mark.full
@pytest.mark.parametrize("kind", ["Circle", "Scanline"])
def test_dragging_on_the_map_marks_the_sampling_region(
    window, wall, kind, tmp_path, monkeypatch, capfd
) -> None:
    panel = wall
    panel.region_box.setCurrentIndex(panel.region_box.findText(kind))
    settle(panel)
    assert shown_codes(panel.message.text()) == {"fractures.no-mark"}
    assert not panel.copy.isEnabled()
    origin = corner(panel)
    ends = origin + ([[3, 2], [3, 3.5]] if kind == "Circle" else [[4, 0.5], [4, 3.5]])
    start, end = (QPoint(*np.rint(p).astype(int).tolist()) for p in panel.map.to_widget(ends))
    driver.drag(panel.map, start, end)
    settle(panel)
    assert panel.region_field.text()
    assert panel.result.network is not None, panel.message.text()
    statistics = panel.result.network.statistics
    if kind == "Circle":
        radius = panel.result.region.circle[2]
        assert radius == pytest.approx(1.5, abs=0.1)
        assert statistics.area_m2 == pytest.approx(np.pi * radius**2, rel=1e-3)
    else:
        assert statistics.scanline.n == 3
        assert statistics.P10_1_per_m == pytest.approx(3 / statistics.scanline_m)
    target = tmp_path / "traces.gpkg"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(panel.copy)
    said = told(QGuiApplication.clipboard().text(), capfd)
    said.pop("image")
    assert said == nearly(figures_of(statistics))


@pytest.mark.full
def test_window_around_all_traces_censors_none(window, wall) -> None:
    panel = wall
    panel.region_field.clear()
    settle(panel)
    statistics = panel.result.network.statistics
    assert statistics.nodes.E == 0
    assert statistics.P21_1_per_m == pytest.approx(statistics.P21_unclipped_1_per_m)


@pytest.mark.full
def test_invalid_window_or_selection_is_reported(window, wall) -> None:
    panel = wall
    for typed, code in (
        ("1, 2, 3", "fractures.not-a-window"),
        ("a, b", "fractures.not-numbers"),
        ("100, 100, 101, 101", "fractures.area-elsewhere"),
    ):
        type_in(panel.region_field, typed)
        settle(panel)
        assert code in shown_codes(panel.message.text()), panel.message.text()
        assert not panel.copy.isEnabled()
    panel.region_field.clear()
    window.studio.selection.set([])
    panel.group_box.setCurrentIndex(panel.group_box.findText("Selection"))
    panel.group_box.activated.emit(panel.group_box.currentIndex())
    settle(panel)
    assert shown_codes(panel.message.text()) == {"selection.unsuitable"}


# --- displacement ------------------------------------------------------------------------------
FAULT, BED, SLIP_M = Plane(90.0, 60.0), Plane(180.0, 20.0), 2.0


@pytest.fixture
def faulted(window, outcrop):
    """A bed that a fault moved by two metres down its dip, picked to a centimetre."""
    model_id = driver.open_outcrop(window, outcrop)
    low, _ = window.studio.models[model_id].data.bounds
    generator = np.random.default_rng(8)

    def scattered(plane: Plane, across, along) -> np.ndarray:
        steps = np.outer(across, plane.strike_vector()) + np.outer(along, plane.dip_vector())
        return low + steps + generator.normal(0, 0.01, steps.shape)

    zigzag = np.tile([0.0, 1.0], 8)
    add(window, model_id, "F", scattered(FAULT, zigzag, np.linspace(-3, 3, 16)), "fault")
    strike = BED.strike_vector()[0]
    west = scattered(BED, np.linspace(-6, -1, 16) * strike, zigzag)
    east = scattered(BED, np.linspace(1, 6, 16) * strike, zigzag) + SLIP_M * FAULT.dip_vector()
    add(window, model_id, "W", west, "bedding")
    add(window, model_id, "E", east, "bedding")
    window.actions_table.run("fault_displacement")
    panel = window.findChild(DisplacementPanel)
    assert not panel.visibleRegion().isEmpty()
    return panel


def cell(panel, column: int) -> str:
    return panel.table.item(0, column).text()


@pytest.mark.full
def test_the_slip_of_a_faulted_bed_is_found_within_its_error(
    window, faulted, tmp_path, monkeypatch, capfd
) -> None:
    panel, studio = faulted, window.studio
    assert not panel.copy.isEnabled()
    studio.selection.set(["F"])
    assert not panel.add.isEnabled()
    press(panel.fault.take_button)
    studio.selection.set(["W", "E"])
    press(panel.add)
    settle(panel)
    assert "net slip is unknown" in panel.message.text(), "the slip is unknown"
    type_in(panel.slip.line, "90")
    settle(panel)
    answered = panel.result
    assert answered is not None, panel.message.text()
    moved = answered.displacements.pairs[0].displacement
    assert abs(moved.net_m.value - SLIP_M) <= moved.net_m.error95
    down = SLIP_M * np.sin(np.radians(60))
    assert abs(moved.throw_m.value - down) <= moved.throw_m.error95
    assert moved.heave_m.value > 0
    assert "±" in cell(panel, 1)
    # The rake is stated once, with the sign of the motion.
    assert cell(panel, 5) == "-90°"
    assert re.findall(r"\b90(?:\.0)?°", panel.message.text()) == []
    driver.keep_picture(window, "displacement_panel")
    target = tmp_path / "points.csv"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(panel.copy)
    said = told(QGuiApplication.clipboard().text(), capfd)
    assert said == json.loads(json.dumps(answered.displacements.to_dict()))
    panel.slip.line.clear()
    settle(panel)
    press(panel.copy)
    said = told(QGuiApplication.clipboard().text(), capfd)
    assert said["what"] == "separation"
    assert said == json.loads(json.dumps(panel.result.displacements.to_dict()))


@pytest.mark.full
def test_traces_unusable_for_displacement_are_reported(window, faulted) -> None:
    panel, studio = faulted, window.studio
    studio.selection.set(["F"])
    press(panel.fault.take_button)
    add(
        window,
        driver.model(window).id,
        "W2",
        np.array(studio.records["W"].vertices) + [0, 3, 0],
        "bedding",
    )
    studio.selection.set(["W", "W2"])
    press(panel.add)
    settle(panel)
    assert "same side" in panel.message.text()
    panel.table.selectRow(0)
    press(panel.remove)
    settle(panel)
    assert "displacement.no-pairs" in shown_codes(panel.message.text())
    studio.selection.set(["W", "E"])
    press(panel.add)
    type_in(panel.slip.line, "200")
    settle(panel)
    assert "0 to 180" in panel.message.text()
