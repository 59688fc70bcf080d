"""Plotters for scripts, notebooks and programs with Qt."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

if TYPE_CHECKING:
    from vomstudio.rendering.plots.plotting import DrawnFeature, Plotter


def create_plotter(
    models: Sequence[Mesh | PointCloud], features: Sequence[DrawnFeature] = ()
) -> Plotter:
    """Create a plotter of models and features, as a window if Qt runs, otherwise off-screen.

    Parameters
    ----------
    models : sequence of Mesh or PointCloud
    features : sequence of DrawnFeature, optional

    Returns
    -------
    pyvista.Plotter
    """
    from vomstudio.rendering.plots.plotting import draw, off_screen_plotter

    app = find_application()
    if app is None:
        return draw(off_screen_plotter(), models, features)
    from vomstudio.rendering.qt.background_plot import create_plotter

    return draw(create_plotter(app), models, features)


def find_application() -> Any:
    """Return the QApplication of this process, or None, without importing Qt."""
    widgets = sys.modules.get("PySide6.QtWidgets")
    return None if widgets is None else widgets.QApplication.instance()
