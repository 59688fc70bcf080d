"""Layout that figures share: a legend beside the curves."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from vomstudio.products.figure_layout import extend_limits_for_legend

LENGTHS_M = np.logspace(-1, 2, 200)


def draw_curve(shares: np.ndarray, position: str) -> tuple[Axes, Bbox]:
    """Draw a curve on logarithmic axes; return the axes and the box of their legend."""
    figure = Figure(figsize=(3.0, 2.5))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.loglog(LENGTHS_M, shares, label="share of longer traces")
    axes.loglog(LENGTHS_M, 0.8 * shares, label="fitted power law")
    axes.set_ylim(float(shares.min()), float(shares.max()))
    extend_limits_for_legend(axes, axes.legend(loc=position, fontsize=6))
    figure.draw_without_rendering()
    legend = axes.get_legend()
    assert legend is not None
    return axes, legend.get_window_extent()


@pytest.mark.parametrize(
    ("position", "exponent"), [("lower left", 1.5), ("upper right", -1.5), ("lower left", -1.5)]
)
def test_curves_do_not_cross_the_legend(position: str, exponent: float) -> None:
    axes, box = draw_curve(LENGTHS_M**exponent, position)
    for line in axes.lines:
        points = axes.transData.transform(np.column_stack(line.get_data()))
        inside = (points >= box.min).all(axis=1) & (points <= box.max).all(axis=1)
        assert not inside.any()


def test_limits_are_kept_if_the_legend_covers_no_curve() -> None:
    shares = LENGTHS_M**-1.5
    axes, _ = draw_curve(shares, "upper right")
    assert axes.get_ylim() == pytest.approx((shares.min(), shares.max()))
