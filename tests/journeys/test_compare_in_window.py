"""A model is held against a benchmark in the window: distances, figures, colours, and a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests import driver
from tests.messages import shown_codes
from vomstudio.core.identifiers import new_id
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.ui.panels.comparison.compare_panel import DISTANCE_FIELD, ComparePanel

UP = 0.02


@pytest.fixture
def higher(outcrop, tmp_path) -> Path:
    """The outcrop, 2 cm up, as a cloud would be written by a survey."""
    mesh = read_model(outcrop).data
    path = tmp_path / "survey.ply"
    write_model(replace(mesh, vertices=mesh.vertices + [0.0, 0.0, UP]), None, path)
    return path


def panel_of(window) -> ComparePanel:
    window.actions_table.run("compare_models")
    panel = window.findChild(ComparePanel)
    driver.settled(window)
    driver.wait(panel.isVisible, "the panel")
    return panel


@pytest.mark.full
def test_distances_are_shown_as_statistics_and_colors_and_exported(
    window, outcrop, higher, tmp_path
) -> None:
    id_ = driver.open_outcrop(window, outcrop)
    panel = panel_of(window)
    assert not panel.start.isEnabled()
    assert shown_codes(panel.start.toolTip()) == {"action.no-other-model"}
    panel.other.load_file(higher)
    driver.wait(panel.start.isEnabled, "the benchmark")
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == "Stop"
    driver.wait(lambda: panel.comparison is not None, "the distances", 60.0)
    told = panel.comparison.figures
    mesh = window.studio.models[id_].data
    distances = np.asarray(mesh.fields[DISTANCE_FIELD])
    assert len(distances) == len(mesh.vertices)
    # The model lies below: before the benchmark where its faces look down, else behind.
    assert np.nanmax(np.abs(distances)) <= UP + 1e-6
    assert told["mean_m"] == pytest.approx(float(np.nanmean(distances)))
    assert "Accuracy" in panel.figures.text()
    assert panel.histogram.counts.sum() == told["n"]
    view = window.viewport
    driver.wait(lambda: view.display.color_scale(id_) is not None, "the colours")
    scale = view.display.color_scale(id_)
    assert (scale.kind, scale.unit, scale.title) == ("diverging", "m", "distance")
    assert scale.low == -scale.high
    driver.settled(window)
    driver.keep_picture(window, "compare-nearest")

    panel.method.setCurrentIndex(1)
    assert panel.limits.fields["m3c2_m"].isVisible()
    panel.limits.fields["m3c2_m"].setValue(0.6)
    panel.limits.fields["registration_error_m"].setValue(0.001)
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: panel.comparison.figures["method"] == "m3c2", "M3C2", 60.0)
    assert f"{panel.comparison.figures['lod95_m']:.3g} m" in panel.figures.text()
    driver.settled(window)
    driver.keep_picture(window, "compare-m3c2")
    out = tmp_path / "out.ply"
    panel.export_distances(out)
    driver.wait(out.is_file, "the file", 60.0)
    written = read_model(out).data
    assert {"distance_m", "lod95_m", "significant"} <= set(written.fields)
    assert np.nanmean(written.fields["distance_m"]) == pytest.approx(
        panel.comparison.figures["mean_m"], abs=1e-6
    )


@pytest.mark.full
def test_distances_are_restored_when_the_project_reopens(window, outcrop, higher, tmp_path) -> None:
    id_ = driver.open_outcrop(window, outcrop)
    studio = window.studio
    panel = panel_of(window)
    panel.other.load_file(higher)
    driver.wait(panel.start.isEnabled, "the benchmark")
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: panel.comparison is not None, "the distances", 60.0)
    first = panel.figures.text()
    folder = tmp_path / "kept"
    studio.save_as(folder)
    driver.settled(window)
    assert list((folder / "comparisons").glob("*.npz"))
    panel.export_distances(tmp_path / "after.ply")
    driver.wait((tmp_path / "after.ply").is_file, "the file", 60.0)
    studio.new_project()
    studio.open_project(folder)
    driver.wait(lambda: id_ in studio.models, "the model", 60.0)
    studio.selection.set([id_])
    panel = panel_of(window)
    driver.wait(lambda: panel.comparison is not None, "the kept distances", 60.0)
    assert panel.figures.text() == first
    assert panel.comparison.fields.is_relative_to(folder)
    assert DISTANCE_FIELD in studio.models[id_].data.fields


@pytest.mark.full
def test_planes_measured_on_both_models_are_compared_with_their_errors(
    window, outcrop, higher, picks
) -> None:
    driver.open_outcrop(window, outcrop)
    studio = window.studio
    own = driver.model(window)
    studio.open_model(higher, reference_id=own.id)
    driver.wait(lambda: len(studio.session.of(Model)) == 2, "the other model")
    other = next(m for m in studio.session.of(Model) if m.id != own.id)
    driver.wait(lambda: other.id in studio.models, "its data")
    for i, (name, points) in enumerate(picks.items()):
        for model, up in ((own, 0.0), (other, UP)):
            # The first by its name, the others by where they lie.
            called = name if i == 0 else f"{name} of {model.name}"
            vertices = tuple(map(tuple, (points + [0.0, 0.0, up]).tolist()))
            trace = Trace(
                new_id("trace"), called, "bedding", model.id, model.content_hash, vertices
            )
            assert studio.attempt(edits.add_trace, trace)
    studio.selection.set([own.id])
    panel = panel_of(window)
    found = panel.agreement.agreement
    assert found is not None
    assert found.by_name == 1
    assert found.by_nearness >= 2
    # The same picks, one lot higher.
    assert max(one.angle_deg for one in found.matched) < 1e-3
    assert found.agree_share == 1.0
    assert panel.agreement.isVisible()
    assert "by distance" in panel.agreement.summary.text()
    driver.keep_picture(window, "compare-planes")
