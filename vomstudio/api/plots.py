"""Plotters, wherever the code runs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

if TYPE_CHECKING:
    from vomstudio.rendering.plots.plotting import DrawnFeature


def plotted(models: Sequence[Mesh | PointCloud], features: Sequence[DrawnFeature] = ()) -> Any:
    """A plotter that shows them: a window in a running Qt, else a still picture."""
    from vomstudio.rendering.plots.plotting import draw, off_screen_plotter

    app = running_qt()
    if app is None:
        return draw(off_screen_plotter(), models, features)
    from vomstudio.rendering.qt.background_plot import window_plotter

    return draw(window_plotter(app), models, features)


def running_qt() -> Any:
    """The QApplication of this process, None where there is none; Qt is not imported for that."""
    widgets = sys.modules.get("PySide6.QtWidgets")
    return None if widgets is None else widgets.QApplication.instance()
