"""Dialogs and panels copied as commands: the line runs, and says what the window says."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pyogrio
import pytest
from PIL import Image
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from tests import driver
from tests.driver import LEFT, NONE, wait
from vomstudio.cli.common.entry import main
from vomstudio.core.findings import Finding
from vomstudio.products.net.figure_options import StereonetFigure
from vomstudio.products.net.figure_style import FigureStyle
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import FeatureType, Model
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog
from vomstudio.ui.panels.sets.sets_panel import SetsPanel
from vomstudio.ui.panels.statistics.statistics_panel import StatisticsPanel


def press(button) -> None:
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


@pytest.fixture
def model_id(window, outcrop, picks):
    """The outcrop with all its traces, and eighty joints in two bundles."""
    model_id = driver.open_outcrop(window, outcrop)
    studio = window.studio
    model = studio.records[model_id]
    for name, points in picks.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert studio.attempt(edits.add_trace, trace)
    generator = np.random.default_rng(4)
    joints = [
        Reading(f"J{i}", f"J{i}", "joint", "plane", *(at + generator.normal(0, 4, 2)).tolist())
        for i, at in enumerate(np.repeat([[100.0, 70.0], [200.0, 50.0]], 40, axis=0))
    ]
    assert studio.attempt(edits.add_readings, joints)
    return model_id


@pytest.fixture
def told(monkeypatch, capfd, tmp_path):
    """Runs what is on the clipboard; files that are asked for come into a folder of their own."""
    folder = tmp_path / "for commands"
    folder.mkdir()

    def answer(_parent, _title, proposed, *_):
        return str(folder / proposed.rpartition("/")[2]), ""

    monkeypatch.setattr(QFileDialog, "getSaveFileName", answer)

    def run() -> dict:
        program, *arguments = shlex.split(QGuiApplication.clipboard().text())
        assert program == "vomstudio"
        capfd.readouterr()
        code = main([*arguments, "--json"])
        said = capfd.readouterr()
        assert code == 0, said.err
        return json.loads(said.out)

    return run


def counted(drawing: Path | str) -> dict[str, int]:
    """Features of each layer."""
    layers = [str(name) for name, _ in pyogrio.list_layers(drawing)]
    return {name: pyogrio.read_info(drawing, layer=name)["features"] for name in layers}


def choose(box, text: str) -> None:
    box.setCurrentIndex(box.findText(text))
    box.activated.emit(box.currentIndex())
    driver.pause(200)


@pytest.mark.full
def test_copied_command_reproduces_statistics(window, model_id, told) -> None:
    window.workspaces.switch("results")
    window.docks.bring_forward("statistics")
    panel = window.findChild(StatisticsPanel)
    wait(lambda: panel.figures.toPlainText(), "the figures")
    choose(panel.group_box, "Joint")
    press(panel.command)
    found = told()["sets"]["all"]
    shown = panel.figures.toPlainText()
    assert found["n"] == 80
    assert re.search(rf"\b{found['n']}\b", shown)
    assert f"{found['vollmer']['P']:.3f}" in shown or f"{found['vollmer']['P']:.2f}" in shown


@pytest.mark.full
def test_copied_command_reproduces_sets_with_number_or_seeds(window, model_id, told) -> None:
    window.actions_table.run("propose_sets")
    panel = window.findChild(SetsPanel)
    choose(panel.group_box, "Joint")
    for number, seeds in ((2, ""), (0, ""), (0, "100/70, 200/50")):
        panel.count.setValue(number)
        panel.seeds.setText(seeds)
        press(panel.start)
        wait(lambda: panel.result is not None and not panel._newest.is_waiting, "the sets")
        press(panel.copy)
        found = told()
        mine = panel.result
        assert [s["n"] for s in found["sets"]] == [s.n for s in mine.sets]
        for theirs, ours in zip(found["sets"], mine.sets, strict=True):
            assert theirs["dip_deg"] == pytest.approx(ours.dip_deg, abs=1e-6)
        assert found["unassigned"] == mine.unassigned_count


@pytest.mark.full
def test_copied_command_reproduces_the_stereonet(window, model_id, told) -> None:
    window.studio.settings.contour = "linear_kamb"
    window.studio.keep_settings()
    press(window.net.command)
    found = told()
    assert found["n"] == len(window.studio.session.features())
    line = QGuiApplication.clipboard().text()
    assert "linear_kamb" in line
    assert (found["image"]).endswith(".svg")


@pytest.mark.full
def test_copied_stereonet_command_includes_its_style(window, model_id, told) -> None:
    """Sizes, and the colours of types as figures have them; of a net and of roses."""
    studio = window.studio
    (joint,) = (t for t in studio.session.of(FeatureType) if t.id == "joint")
    figure = StereonetFigure(
        font="DejaVu Serif",
        font_size_pt=7.0,
        line_width_pt=1.2,
        symbol_size_pt=6.0,
        size_mm="90x80",
    )
    style = FigureStyle(figure, {joint.color: "#123456"})
    studio.settings.figure_style = style.to_settings()
    studio.keep_settings()
    press(window.net.command)
    image = Path(told()["image"]).read_text("utf-8")
    assert "#123456" in image
    assert 'width="255.1' in image
    assert "DejaVu Serif" in image
    window.net.view_settings.show_view("strike", "area")
    press(window.net.command)
    image = Path(told()["image"]).read_text("utf-8")
    assert 'width="255.1' in image
    line = QGuiApplication.clipboard().text()
    assert "joint=#123456" in line


@pytest.mark.full
@pytest.mark.parametrize("part", ["whole", "seen"])
def test_copied_command_reproduces_orthophoto_of_registered_model(
    window, model_id, told, tmp_path, part
) -> None:
    """As it stands in the project, and not in its file."""
    from dataclasses import replace

    studio = window.studio
    model = studio.records[model_id]
    frame = replace(model.frame, unit_m=2.0)
    assert studio.attempt(edits.declare_frame, model_id, frame)
    window.view.look_along(300.0, 20.0)
    wait(lambda: window.viewport.is_still, "the camera's rest")
    window.actions_table.run("orthophoto")
    (dialog,) = window.findChildren(OrthoDialog)
    wait(dialog._start_button.isEnabled, "a proposed pixel size")
    if part == "seen":
        dialog.visible_area.click()
        dialog.interpretation.boxes["symbols"].click()
    dialog.gsd.setText("0.05")
    out = tmp_path / "o.tif"
    dialog.target.setText(str(out))
    press(dialog.copy_button)
    press(dialog._start_button)
    wait(lambda: out.exists() and not studio.jobs.visible(), "the orthophoto", 60.0)
    facts = json.loads(out.with_suffix(".json").read_text("utf-8"))
    drawn = counted(tmp_path / "o_drawing.gpkg")
    assert ("planes" in drawn) == (part == "whole")
    with Image.open(tmp_path / "o_sheet.png") as page:
        wide = page.width
    found = told()
    assert drawn == counted(found["drawing"]["gpkg"])
    with Image.open(found["sheet"]) as page:
        assert page.width == wide
    assert (found["width"], found["height"]) == (facts["width"], facts["height"])
    assert np.array(found["pixel_to_world"]) == pytest.approx(
        np.array(facts["pixel_to_world"]), abs=1e-9
    )
    assert found["coverage"] == facts["coverage"]
    # Only a map has a CRS.
    assert "crs" not in facts
    assert found.get("crs") is None


@pytest.mark.full
def test_copied_commands_reproduce_fits_and_export(window, model_id, told, tmp_path, picks) -> None:
    run = window.actions_table.run
    studio = window.studio
    assert window.actions_table.disabled_reason("copy_export") == Finding("action.nothing-exported")
    names = list(picks)[:3]
    studio.selection.set(names)
    run("copy_fit")
    found = told()
    assert [row["id"] for row in found["planes"]] == names
    measured = studio.measured(names)
    for row in found["planes"]:
        fit = measured[row["id"]].fit
        assert row["rms_m"] == pytest.approx(fit.rms, rel=1e-6)
    figure = tmp_path / "shapes.svg"
    from vomstudio.ui.commands.fits import write_figure

    write_figure(studio, figure)
    assert names[0] in figure.read_text() or "good" in figure.read_text()
    window.files.export_features("csv", tmp_path / "mine.csv")
    mine = (tmp_path / "mine.csv").read_bytes()
    run("copy_export")
    assert told()["n"] == len(studio.session.features())
    assert (tmp_path / "mine.csv").read_bytes() == mine


@pytest.mark.full
def test_copied_command_reproduces_a_comparison(window, model_id, told, outcrop, tmp_path) -> None:
    from dataclasses import replace

    from vomstudio.ui.panels.comparison.compare_panel import ComparePanel

    studio = window.studio
    window.actions_table.run("compare_models")
    panel = window.findChild(ComparePanel)
    studio.selection.set([model_id])
    window.open_path(_moved(outcrop, tmp_path))
    wait(lambda: len(studio.models) == 2, "the other model")
    (other,) = (m for m in studio.session.of(Model) if m.id != model_id)
    # A centimetre a unit: only the project knows.
    assert studio.attempt(edits.declare_frame, other.id, replace(other.frame, unit_m=1.0))
    studio.selection.set([model_id])
    panel.refresh()
    box = panel.other.models
    box.setCurrentIndex(box.findData(other.id))
    press(panel.copy)
    press(panel.start)
    wait(lambda: panel.comparison is not None, "the distances", 60.0)
    found = told()
    for name in ("n", "mean_m", "median_m", "std_m"):
        assert found[name] == pytest.approx(panel.comparison.figures[name], rel=1e-9)


def _moved(outcrop, folder):
    """The same outcrop four centimetres higher."""
    made = folder / "later.obj"
    lines = []
    for line in outcrop.read_text().splitlines():
        if line.startswith("v "):
            _, x, y, z, *rest = line.split()
            line = " ".join(["v", x, y, repr(float(z) + 0.04), *rest])
        lines.append(line)
    made.write_text("\n".join(lines))
    return made


@pytest.mark.full
def test_copied_command_reproduces_a_registration_by_points(window, model_id, told, picks) -> None:
    from vomstudio.project.kinds.control_point import ControlPoint
    from vomstudio.ui.panels.tools.control import ControlPanel

    studio = window.studio
    model = studio.records[model_id]
    generator = np.random.default_rng(3)
    for k, points in enumerate(list(picks.values())[:5]):
        at = tuple(points[0].tolist())
        there = tuple((points[0] + [3.0, -2.0, 1.0] + generator.normal(0, 0.01, 3)).tolist())
        point = ControlPoint(
            f"c{k}", f"P{k}", model_id, model.content_hash, (at,), position=there, check=k == 4
        )
        assert studio.attempt(edits.add_features, [point])
    studio.activate("control")
    panel = driver.tool_panel(window, ControlPanel)
    wait(lambda: panel.placed is not None, "the placement")
    press(panel.copy)
    found = told()
    places = np.array([[*p[0], 1.0] for p in list(picks.values())[:5]])
    moved = [places @ np.array(m).T for m in (found["matrix"], panel.placed.matrix)]
    # Far from the origin a matrix has fewer digits than what it does to the model.
    assert np.abs(moved[0] - moved[1]).max() < 1e-6
    assert [p["label"] for p in found["check"]] == ["P4"]


@pytest.mark.full
def test_copied_command_reproduces_facets(window, model_id, told) -> None:
    from vomstudio.ui.panels.surface.facets_panel import FacetsPanel

    window.studio.selection.set([model_id])
    window.actions_table.run("propose_facets")
    panel = window.findChild(FacetsPanel)
    panel.limits.fields["min_points"].setValue(40)
    panel.limits.fields["min_coplanarity"].setValue(4.0)
    wait(panel.start.isEnabled, "the model in the panel")
    press(panel.start)
    wait(lambda: panel._facets.proposals is not None, "the facets", 120.0)
    press(panel.copy)
    assert told()["facets"] == len(panel._facets.proposals.patches)


@pytest.mark.full
def test_copied_command_reproduces_proposed_traces(window, model_id, told) -> None:
    from vomstudio.ui.panels.surface.traces_panel import TracesPanel

    window.studio.selection.set([model_id])
    window.actions_table.run("propose_traces")
    panel = window.findChild(TracesPanel)
    panel.cost.setCurrentIndex(panel.cost.findData("curvature"))
    panel.limits.fields["max_lines"].setValue(900)
    wait(panel.start.isEnabled, "the model in the panel")
    press(panel.start)
    wait(lambda: panel._traces.proposals is not None, "the lines", 120.0)
    press(panel.copy)
    of_command, found = told()["proposals"], panel._traces.proposals
    # But for those that run along traces of the project, which the window leaves out.
    assert len(of_command) == len(found.lines) + found.known
    shown = [(one.length_m, one.doubt) for one in found.lines]
    assert shown
    said = {(round(one["length_m"], 6), one["doubt"]) for one in of_command}
    assert {(round(length, 6), doubt) for length, doubt in shown} <= said
