"""Layout that figures share: ticks of logarithmic axes, legends, and names beside symbols."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.legend import Legend

_DIGIT_WIDTH = 0.64
"""Mean width of a digit relative to the font size."""
_PLAIN_POWERS = range(-3, 6)
"""Powers of ten that are written as decimal numbers."""
_LEGEND_GAP = 0.03
"""Distance between a legend and the curves, as a share of the axes."""


def set_log_ticks(axis: Axis, font_pt: float) -> None:
    """Set round ticks on a logarithmic axis, as dense as their labels allow.

    Call it after the limits of the axis and the position of the axes are set.

    Parameters
    ----------
    axis : Axis
    font_pt : float
    """
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

    low, high = sorted(axis.get_view_interval())
    is_horizontal = axis is axis.axes.xaxis
    figure = axis.axes.get_figure(root=True)
    assert figure is not None
    position = axis.axes.get_position()
    fraction, side = (
        (position.width, figure.get_figwidth())
        if is_horizontal
        else (position.height, figure.get_figheight())
    )
    points_per_decade = 72.0 * fraction * side / math.log10(high / low)
    ticks = np.array([low, high])
    for ticks in _log_ticks(low, high):
        max_length = max(len(_plain_number(value)) for value in ticks.tolist())
        required_width = font_pt * (_DIGIT_WIDTH * max_length + 1.0 if is_horizontal else 1.5)
        if points_per_decade * float(np.diff(np.log10(ticks)).min()) >= required_width:
            break
    axis.set_major_locator(FixedLocator(ticks.tolist()))
    axis.set_major_formatter(FuncFormatter(lambda value, _: _plain_number(value)))
    axis.set_minor_formatter(NullFormatter())


def _log_ticks(low: float, high: float) -> Iterator[FloatArray]:
    """Yield sets of at least two round ticks within a range, the densest first."""
    first_power, last_power = math.floor(math.log10(low)), math.ceil(math.log10(high))
    powers = np.power(10.0, np.arange(first_power, last_power + 1, dtype=np.float64))
    for steps in ((1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0), (1.0, 2.0, 5.0), (1.0, 3.0)):
        ticks: FloatArray = np.sort(np.outer(powers, steps).ravel())
        ticks = ticks[(ticks >= low * (1 - 1e-9)) & (ticks <= high * (1 + 1e-9))]
        if 2 <= len(ticks) <= 12:
            yield ticks
    visible_powers = powers[(powers >= low * (1 - 1e-9)) & (powers <= high * (1 + 1e-9))]
    for stride in range(1, max(2, len(visible_powers))):
        if len(visible_powers[::stride]) >= 2:
            yield visible_powers[::stride]
    from matplotlib.ticker import MaxNLocator

    # A short range contains too few round powers.
    for count in (4, 2, 1):
        ticks = np.asarray(MaxNLocator(count).tick_values(low, high), np.float64)
        ticks = ticks[(ticks >= low) & (ticks <= high)]
        if len(ticks) >= 2:
            yield ticks


def _plain_number(value: float) -> str:
    power = math.floor(math.log10(value) + 1e-9)
    if power in _PLAIN_POWERS:
        return f"{value:g}"
    factor = value / 10.0**power
    return f"$10^{{{power}}}$" if abs(factor - 1) < 1e-6 else f"{factor:g}·$10^{{{power}}}$"


def extend_limits_for_legend(axes: Axes, legend: Legend) -> None:
    """Extend the vertical limits until the legend covers no curve or area.

    Only the limit at the legend is moved. Call this function after everything is drawn.

    Parameters
    ----------
    axes : Axes
    legend : Legend
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = axes.get_figure(root=True)
    assert figure is not None
    renderer = FigureCanvasAgg(figure).get_renderer()
    box = legend.get_window_extent(renderer).transformed(axes.transAxes.inverted())
    points = _curve_points(axes)
    nearby_heights = points[(points[:, 0] >= box.x0 - 0.01) & (points[:, 0] <= box.x1 + 0.01), 1]
    if not len(nearby_heights):
        return
    scale = axes.yaxis.get_transform()
    low, high = scale.transform(np.array(axes.get_ylim()))
    if box.y0 + box.y1 > 1.0:
        top = float(nearby_heights.max())
        limit = box.y0 - _LEGEND_GAP
        if top > limit:
            high = low + (high - low) * top / limit
    else:
        bottom = float(nearby_heights.min())
        limit = box.y1 + _LEGEND_GAP
        if bottom < limit:
            low = high - (high - low) * (1.0 - bottom) / (1.0 - limit)
    new_low, new_high = scale.inverted().transform(np.array([low, high])).tolist()
    axes.set_ylim(new_low, new_high)


def _curve_points(axes: Axes) -> FloatArray:
    """Return points (n, 2) along visible curves and areas, in axes coordinates (0 to 1)."""
    curves = [line.get_transform().transform(line.get_xydata()) for line in axes.lines]
    for collection in axes.collections:
        for path in collection.get_paths():
            curves.append(collection.get_transform().transform(path.vertices))
    parts = [np.empty((0, 2))]
    for curve in curves:
        points = axes.transAxes.inverted().transform(np.asarray(curve, np.float64))
        points = points[np.isfinite(points).all(axis=1)]
        fractions = np.linspace(0.0, 1.0, 20)[:, None, None]
        parts.append((points[:-1] + fractions * np.diff(points, axis=0)).reshape(-1, 2))
    all_points = np.concatenate(parts)
    return all_points[((all_points >= 0.0) & (all_points <= 1.0)).all(axis=1)]


_LABEL_SIDES = ((1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1), (0, -1), (1, 0), (-1, 0))
"""Positions (right, up) of a name relative to its symbol, in order of preference."""
_HORIZONTAL_ALIGNMENTS: Mapping[int, Literal["left", "center", "right"]] = {
    1: "left",
    0: "center",
    -1: "right",
}
_VERTICAL_ALIGNMENTS: Mapping[int, Literal["bottom", "center", "top"]] = {
    1: "bottom",
    0: "center",
    -1: "top",
}


def label_symbols(
    axes: Axes,
    points: FloatArray,
    names: Mapping[int, str],
    *,
    symbol_pt: float,
    font_pt: float,
    color: str,
) -> None:
    """Write names beside symbols, omitting those that would overlap text or symbols.

    Parameters
    ----------
    axes : Axes
        Axes with everything else drawn.
    points : (n, 2) array
        All symbols, in data coordinates.
    names : mapping of int to str
        Names by the row of their symbol.
    symbol_pt, font_pt : float
        Sizes of the symbols and of the letters.
    color : str
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.transforms import Bbox

    figure = axes.get_figure(root=True)
    assert figure is not None
    # The layout of the figure is set when it is drawn.
    figure.draw_without_rendering()
    renderer = FigureCanvasAgg(figure).get_renderer()
    positions = axes.transData.transform(points)
    half_size_px = 0.5 * symbol_pt * figure.dpi / 72.0
    occupied_boxes = [
        Bbox([position - half_size_px, position + half_size_px]) for position in positions
    ]
    occupied_boxes += [text.get_window_extent(renderer) for text in axes.texts]
    if (legend := axes.get_legend()) is not None:
        occupied_boxes.append(legend.get_window_extent(renderer))
    axes_box = axes.get_window_extent(renderer)
    # Also keep a distance from the symbol itself.
    distance = 0.5 * symbol_pt + 1.5
    for row, name in names.items():
        x, y = points[row].tolist()
        for right, up in _LABEL_SIDES:
            label = axes.annotate(
                name,
                (x, y),
                xytext=(right * distance, up * distance),
                textcoords="offset points",
                ha=_HORIZONTAL_ALIGNMENTS[right],
                va=_VERTICAL_ALIGNMENTS[up],
                fontsize=font_pt,
                color=color,
                zorder=5,
                parse_math=False,
            )
            box = label.get_window_extent(renderer)
            is_within = axes_box.x0 <= box.x0 and box.x1 <= axes_box.x1
            if is_within and not any(box.overlaps(occupied_box) for occupied_box in occupied_boxes):
                occupied_boxes.append(box)
                break
            label.remove()


def arrange_columns(widths: Sequence[float], width: float, gap: float) -> list[float]:
    """Return the widths of the columns of a legend with the fewest rows.

    The entries are arranged row by row.

    Parameters
    ----------
    widths : sequence of float
        Widths of the entries.
    width : float
        Available width.
    gap : float
        Distance between columns.

    Returns
    -------
    list of float
        Widths of the columns; one column if an entry is wider than the width.
    """
    for count in range(len(widths), 0, -1):
        columns = [max(widths[k::count]) for k in range(count)]
        if sum(columns) + gap * (count - 1) <= width:
            return columns
    return [max(widths, default=0.0)]
