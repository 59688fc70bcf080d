"""A patch as a surface, and a plane carried on through the model, in the window people use."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.extraction.planes_by_construction import angle_deg, axes_of, normal_of
from tests.messages import shown_codes
from tests.products.test_surface import ATTITUDE, grooves, mesh_over, self_affine
from vomstudio.core.findings import Finding
from vomstudio.io.models.writing import write_model
from vomstudio.project import edits
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.brush_stroke import patch_fields
from vomstudio.ui.dialogs.extended_plane_dialog import DISTANCE_FIELD, ExtendDialog
from vomstudio.ui.dialogs.surface_dialog import SurfaceDialog

N, STEP = 130, 0.05
GROOVE = 40.0
BEND_FROM = 100


@pytest.fixture
def face(window, tmp_path):
    """A grooved fault face whose last columns bend away, open, with a patch of all of it and a
    trace on it."""
    rng = np.random.default_rng(1)
    heights = 0.002 * self_affine(N, 0.6, rng) + grooves(N, STEP, GROOVE, 0.7, 0.02)
    heights += np.maximum(np.arange(N) - BEND_FROM, 0) * STEP * math.tan(math.radians(25))
    mesh = mesh_over(heights, STEP)
    write_model(mesh, None, tmp_path / "face.ply")
    model_id = driver.open_outcrop(window, tmp_path / "face.ply")
    studio = window.studio
    model, opened = studio.records[model_id], studio.models[model_id]
    driver.wait(lambda: opened.surface._faces_by_vertex is not None, "the search structures")
    ids = np.arange(len(opened.data.faces))
    zero = (0.0, 0.0, 0.0)
    patch = Patch(
        "p1",
        "Face",
        "fault",
        model_id,
        model.content_hash,
        "face",
        (),
        0,
        zero,
        (zero, zero, zero),
        0.0,
    )
    from dataclasses import replace

    patch = replace(patch, **patch_fields(opened.surface, ids))
    rows = (np.arange(8) * 7 + 30) * N + (20 + 9 * np.array([0, 3, 1, 4, 2, 5, 3, 6]))
    points = np.asarray(opened.data.vertices[rows], np.float64)
    trace = Trace(
        "t1",
        "Scratch",
        "bedding",
        model_id,
        model.content_hash,
        tuple(map(tuple, points.tolist())),
    )
    assert studio.attempt(edits.add_features, [patch, trace])
    return window


def dialog(window, kind):
    found = [w for w in window.findChildren(kind) if w.isVisible()]
    assert len(found) == 1
    return found[0]


@pytest.mark.full
def test_a_patch_shows_its_deviations_and_is_trimmed(face) -> None:
    window, studio = face, face.studio
    assert window.actions_table.disabled_reason("patch_surface") == Finding("selection.no-patch")
    studio.selection.set(["p1"])
    assert window.actions_table.disabled_reason("patch_surface") is None
    window.actions_table.run("patch_surface")
    shown = dialog(window, SurfaceDialog)
    assert "patch.pending" in shown_codes(shown.show_button.toolTip())
    driver.wait(lambda: shown.figures is not None, "the figures")
    assert not shown.picture.pixmap().isNull()
    driver.keep_picture(shown, "surface-dialog")
    assert shown.figures.trim is not None
    driver.click(shown.show_button, shown.show_button.rect().center())
    model_id = studio.records["p1"].model_id
    assert studio.display.styles[model_id].name == "deviation_m"
    driver.settled(window)
    driver.keep_picture(window, "surface-on-model")
    before = studio.measure(studio.records["p1"]).fit.normal
    driver.click(shown.trim_button, shown.trim_button.rect().center())
    after = studio.measure(studio.records["p1"]).fit.normal
    assert angle_deg(before, normal_of(*ATTITUDE)) > 2.0
    assert angle_deg(after, normal_of(*ATTITUDE)) < 0.7
    studio.undo()
    assert studio.measure(studio.records["p1"]).fit.normal == pytest.approx(before)


@pytest.mark.full
def test_smoothest_direction_of_a_trimmed_patch_matches_its_grooves(face) -> None:
    window, studio = face, face.studio
    studio.selection.set(["p1"])
    window.actions_table.run("patch_surface")
    shown = dialog(window, SurfaceDialog)
    driver.wait(lambda: shown.figures is not None, "the figures")
    shown.trim()
    window.actions_table.run("patch_surface")
    shown = next(w for w in window.findChildren(SurfaceDialog) if w.isVisible())
    driver.wait(lambda: shown.figures is not None, "the figures")
    noise = shown.limits.fields["noise_m"]
    noise.setFocus()
    noise.selectAll()
    QTest.keyClicks(noise, "0.001")
    QTest.keyClick(noise, Qt.Key.Key_Return)
    driver.wait(lambda: shown.figures is not None and shown.figures.noise_m == 0.001, "the figures")
    line = shown.figures.smoothest
    assert line is not None, shown.summary.text()
    driver.keep_picture(shown, "surface-dialog-trimmed")
    u, v = axes_of(*ATTITUDE)
    truth = math.cos(math.radians(GROOVE)) * u + math.sin(math.radians(GROOVE)) * v
    t, p = math.radians(line.trend_deg), math.radians(line.plunge_deg)
    seen = np.array([math.sin(t) * math.cos(p), math.cos(t) * math.cos(p), -math.sin(p)])
    assert angle_deg(truth, seen) < line.error95_deg + 1.0
    assert "slip" in shown.summary.text()


@pytest.mark.full
def test_extended_plane_is_painted_with_its_error_band(face, tmp_path) -> None:
    window, studio = face, face.studio
    assert window.actions_table.disabled_reason("extend_plane") == Finding("selection.no-plane")
    studio.selection.set(["t1"])
    assert window.actions_table.disabled_reason("extend_plane") is None
    window.actions_table.run("extend_plane")
    shown = dialog(window, ExtendDialog)
    assert "extension.missing" in shown_codes(shown.save_button.toolTip())
    thickness = shown.limits.fields["thickness_m"]
    thickness.setFocus()
    thickness.selectAll()
    QTest.keyClicks(thickness, "0.4")
    QTest.keyClick(thickness, Qt.Key.Key_Tab)
    driver.click(shown.show_button, shown.show_button.rect().center())
    driver.wait(lambda: shown.extension is not None, "the plane")
    model_id = studio.records["t1"].model_id
    assert studio.display.styles[model_id].name == DISTANCE_FIELD
    values = studio.models[model_id].data.fields[DISTANCE_FIELD]
    assert 0.0 < np.isfinite(values).mean() < 1.0
    driver.settled(window)
    driver.keep_picture(window, "extended-plane")
    driver.keep_picture(shown, "extend-dialog")
    path = tmp_path / "traces.csv"
    shown.save_traces(path)
    columns = ["bed", "line", "x", "y", "z", "error95_m"]
    assert path.read_text().splitlines()[3].split(",") == columns
    lines = window.viewport.features
    assert {"extended plane:edges", "extended plane:traces"} <= lines.drawings.keys()
    driver.click(shown.color_box, QPoint(10, shown.color_box.height() // 2))
    assert studio.display.mode == "textured"
    driver.settled(window)
    driver.keep_picture(window, "extended-plane-over-texture")
    driver.click(shown.color_box, QPoint(10, shown.color_box.height() // 2))
    assert studio.display.mode == "field"
    shown.close()
    driver.wait(lambda: "extended plane:edges" not in lines.drawings, "no lines")
    # Nobody is left with a grey outcrop.
    assert studio.display.mode == "textured"
    assert model_id not in studio.display.styles
