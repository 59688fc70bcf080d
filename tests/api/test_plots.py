"""Plots: a still picture without a display, a window beside Qt."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vomstudio as vs

ROOT = Path(__file__).resolve().parents[2]
MODEL = vs.sample("sample.obj")

PLOT = """
import sys, pathlib, pandas, numpy as np, vomstudio as vs
picks = pandas.read_csv(vs.sample("picks.csv"), comment="#")
with vs.Project.create(sys.argv[1]) as project:
    model = project.add_model(vs.sample("sample.obj"))
    bare = project.models[0].plot()
    for name in ("B01", "F01"):
        own = picks[picks["pick"] == name]
        project.add_trace(own[["x", "y", "z"]], model=model, type=own["kind"].iloc[0])
    full = project.plot()
    pictures = []
    for plotter in (bare, full):
        plotter.camera.zoom(1.5)
        pictures.append(plotter.screenshot(return_img=True))
        plotter.close()
np.savez(sys.argv[2], *pictures)
print(*sorted({m.partition(".")[0] for m in sys.modules} & {"PySide6", "pyvistaqt"}))
"""


@pytest.mark.full
def test_plotting_needs_no_display(tmp_path: Path, own_folders: Path) -> None:
    import os

    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-c", PLOT, tmp_path / "a.vom", tmp_path / "pictures.npz"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=400,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    # No Qt is started for it.
    assert done.stdout.split() == []
    with np.load(tmp_path / "pictures.npz") as found:
        bare, full = found["arr_0"].astype(int), found["arr_1"].astype(int)
    covered = (bare < 250).any(axis=2)
    assert 0.2 < covered.mean() < 0.9
    # The rock has its colours: no grey stand-in for a texture that was not found.
    assert np.ptp(bare[covered], axis=1).mean() > 10
    # Bedding is blue in this program.
    blue = np.abs(full - [0x00, 0x72, 0xB2]).max(axis=2) < 12
    assert blue.sum() > 20
    assert not (np.abs(bare - [0x00, 0x72, 0xB2]).max(axis=2) < 12).any()


@pytest.mark.full
def test_plot_opens_window_when_qt_is_running(cliff: vs.Mesh, qtbot: Any) -> None:
    import pyvistaqt

    plotter = cliff.plot()
    try:
        assert isinstance(plotter, pyvistaqt.BackgroundPlotter)
        assert len(plotter.renderer.actors) >= len(cliff.materials)
    finally:
        plotter.close()


def test_camera_faces_exposed_side_of_outcrop(tmp_path: Path, own_folders: Path) -> None:
    """The camera looks at the exposed side: against the mean normal of the faces."""
    from vomstudio.rendering.plots.plotting import draw, off_screen_plotter

    model = vs.read(MODEL)
    plotter = draw(off_screen_plotter(), [model._data], [])
    a, b, c = (model.points[model.faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a).sum(axis=0)
    looking = np.array(plotter.camera.focal_point) - plotter.camera.position
    plotter.close()
    assert looking[:2] @ normal[:2] < 0
