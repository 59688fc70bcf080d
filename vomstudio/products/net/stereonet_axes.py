"""Net on mplstereonet axes, for scripts that continue to draw on them."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology import stereonet as nets
from vomstudio.geology.density import DENSITY_UNITS, density
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.orientation import Line, lines_to_vectors, vectors_to_lines
from vomstudio.products.net.contents import (
    NetCircle,
    NetContents,
    NetSet,
    fold_ellipse,
    shows_all_circles,
)
from vomstudio.products.net.contours import (
    OPACITY,
    contour_colors,
    contour_groups,
    contour_levels,
    dash,
)
from vomstudio.products.net.figure_style import FigureStyle
from vomstudio.products.net.legend import fold_texts
from vomstudio.products.net.style import NetStyle

_GRID = 101
_LINE = 0.15
"""Height of a line of text in inches."""
_SIZE = (8.0, 5.0)
"""Size of a new figure in inches."""


def _library() -> Any:
    with warnings.catch_warnings():
        # The library was written for an older version of matplotlib.
        warnings.simplefilter("ignore")
        import mplstereonet

    return mplstereonet


def new_axes(projection: str, size_mm: tuple[float, float] | None = None, lines: int = 0) -> Any:
    """Create axes in a new pyplot figure, with space for lines of text below."""
    import matplotlib.pyplot as plt

    _library()
    figure = plt.figure(
        figsize=_SIZE if size_mm is None else (size_mm[0] / 25.4, size_mm[1] / 25.4)
    )
    # Leave space for the legend beside the net.
    figure.subplots_adjust(
        left=0.04, right=0.66, bottom=0.11 + lines * _LINE / figure.get_figheight()
    )
    ax = figure.add_subplot(projection=f"equal_{projection}_stereonet")
    ax.grid(color="0.85", linewidth=0.5)
    return ax


def is_stereonet_axes(ax: Any) -> bool:
    """Return whether axes are those of mplstereonet."""
    return isinstance(ax, _library().StereonetAxes)


def draw_net(ax: Any, net: NetContents, style: FigureStyle | None = None) -> None:
    """Draw the contents of a net on the axes, with a legend.

    The contents are density, great circles, poles, lines, means and additions. The size in `style`
    is ignored in favour of that of the axes' figure.
    """
    figure_style = style or FigureStyle()
    paper = figure_style.net_style()
    symbol, thin = figure_style.symbol_pt or 5.0, figure_style.line_pt or 0.7
    if net.contour is not None:
        _draw_density(ax, net, net.contour, paper)
    for s in net.sets:
        if s.kind == "plane" and shows_all_circles(net):
            # Pass copies, because the library modifies its arguments.
            ax.plane(
                _strikes(s),
                s.angle_deg.copy(),
                color=paper.color(s.color),
                linewidth=thin,
                alpha=0.6,
            )
    for s in net.sets:
        look = {
            "marker": s.marker,
            "color": paper.color(s.color),
            "markersize": symbol,
            "label": _label(s),
        }
        if s.kind == "plane":
            ax.pole(_strikes(s), s.angle_deg.copy(), **look)
        else:
            _plot_lines(ax, s.azimuth_deg, s.angle_deg, **look)
    for mean in net.means:
        label = tr("Mean {orientation}", orientation=mean.orientation)
        _plot_star(ax, mean.line, paper.color(mean.color), label, paper, symbol)
    _draw_additions(ax, net, paper, symbol, thin)
    letters: dict[str, Any] = {"size": figure_style.font_pt or "small"}
    if figure_style.font:
        letters["family"] = figure_style.font
    ax.legend(loc="upper left", bbox_to_anchor=(1.1, 1.0), frameon=False, prop=letters)
    text_lines = text_below(net)
    if text_lines:
        ax.text(
            0.0,
            -0.09,
            chr(10).join(text_lines),
            transform=ax.transAxes,
            va="top",
            fontproperties=letters,
        )


def text_below(net: NetContents) -> list[str]:
    """Return the lines of text below a net."""
    return [*net.averages, *net.notes]


def _draw_fold(
    ax: Any, net: NetContents, fold: FoldAxis, paper: NetStyle, symbol: float, thin: float
) -> None:
    beta, plane = fold_texts(net, fold)
    pi_circle = NetCircle(fold.beta, 90.0, plane)
    ellipse = fold_ellipse(fold)
    outlines = [(pi_circle.outline(net.projection), "--", plane)]
    if ellipse is not None:
        outlines.append((ellipse.outline(net.projection), "-", "_nolegend_"))
    for parts, line, first in outlines:
        for place, part in enumerate(parts):
            label = first if place == 0 else "_nolegend_"
            ax.plot(
                *_to_axes(part, net.projection),
                color=paper.ink,
                linestyle=line,
                linewidth=1.5 * thin,
                label=label,
            )
    _plot_star(ax, fold.beta, paper.ink, beta, paper, symbol)


def _plot_star(ax: Any, line: Line, color: str, label: str, paper: NetStyle, symbol: float) -> None:
    _plot_lines(
        ax,
        np.array([line.trend_deg]),
        np.array([line.plunge_deg]),
        marker="*",
        markersize=2.4 * symbol,
        markerfacecolor=color,
        markeredgecolor=paper.ink,
        label=label,
    )


def _draw_additions(ax: Any, net: NetContents, paper: NetStyle, symbol: float, thin: float) -> None:
    if net.fold is not None:
        _draw_fold(ax, net, net.fold, paper, symbol, thin)
    for circle in net.circles_typed:
        color = paper.ink if circle.color is None else paper.color(circle.color)
        for place, part in enumerate(circle.outline(net.projection)):
            label = circle.label if place == 0 else "_nolegend_"
            ax.plot(
                *_to_axes(part, net.projection),
                color=color,
                linestyle=circle.dash,
                linewidth=1.5 * thin,
                label=label,
            )
    for ellipse in net.errors:
        for part in ellipse.outline(net.projection):
            ax.plot(*_to_axes(part, net.projection), color=paper.soft, linewidth=thin)
    for mark in net.marks:
        color = paper.ink if mark.color is None else paper.color(mark.color)
        _plot_lines(
            ax,
            np.array([mark.line.trend_deg]),
            np.array([mark.line.plunge_deg]),
            marker=mark.marker,
            markersize=2.0 * symbol,
            markeredgewidth=2.0 * thin,
            markeredgecolor=color,
            markerfacecolor="none",
            label=mark.label,
        )


def _to_axes(part: FloatArray, projection: str) -> tuple[FloatArray, FloatArray]:
    """Convert net positions (k, 2) to longitude and latitude in the library's axes."""
    # Move points slightly inward: on the primitive circle, a point would be drawn at its opposite
    # end.
    vectors = nets.unproject(part * (1.0 - 1e-7), projection)
    trend, plunge = vectors_to_lines(vectors)[:2]
    longitude, latitude = _library().line(plunge, trend)
    return np.asarray(longitude), np.asarray(latitude)


def _plot_lines(ax: Any, trend_deg: Any, plunge_deg: Any, **style: Any) -> None:
    """Plot lines as one artist with one legend entry, unlike the library's `line`."""
    ax.plot(*_library().line(plunge_deg.copy(), trend_deg.copy()), linestyle="None", **style)


def _strikes(s: NetSet) -> Any:
    return (s.azimuth_deg - 90.0) % 360.0


def _label(s: NetSet) -> str:
    if s.kind == "plane":
        return tr("{set}, poles (n = {count:,})", set=s.name, count=len(s))
    return tr("{set}, lines (n = {count:,})", set=s.name, count=len(s))


def _draw_density(ax: Any, net: NetContents, method: str, paper: NetStyle) -> None:
    """Draw the density of our own kernels on the library's axes, with a colour bar."""
    across = np.linspace(-np.pi / 2, np.pi / 2, _GRID)
    longitude, latitude = np.meshgrid(across, across)
    plunge, bearing = _library().geographic2plunge_bearing(longitude.ravel(), latitude.ravel())
    at = lines_to_vectors(bearing, plunge)
    look, counted = net.contouring, []
    for of, vectors in contour_groups(net):
        counted.append((of, density(vectors, at, method, look.sigma).reshape(longitude.shape)))
    levels = contour_levels(net, max((float(v.max()) for _, v in counted), default=0.0))
    drawn = []
    for of, values in counted:
        top = float(values.max())
        if not levels or top <= levels[0]:
            continue
        colors = contour_colors(of, len(levels), look.is_filled, paper)
        if look.is_filled:
            # Add an upper limit, so that a single level suffices.
            drawn.append(
                ax.contourf(
                    longitude,
                    latitude,
                    values,
                    [*levels, levels[-1] + top],
                    colors=colors,
                    alpha=0.8 if of is None else OPACITY,
                    zorder=0,
                )
            )
        else:
            drawn.append(
                ax.contour(
                    longitude,
                    latitude,
                    values,
                    list(levels),
                    colors=colors,
                    linestyles=dash(of),
                    linewidths=1.1,
                    zorder=0,
                )
            )
    if drawn:
        _draw_bar(ax, drawn[0], levels, tr(DENSITY_UNITS[method]))


def _draw_bar(ax: Any, drawn: Any, levels: tuple[float, ...], unit: str) -> None:
    """Draw the colour bar below the legend, in the shades of the first set."""
    inset = ax.inset_axes((1.13, 0.02, 0.04, min(0.06 * len(levels), 0.42)), projection=None)
    bar = ax.figure.colorbar(drawn, cax=inset, spacing="uniform", ticks=list(levels))
    bar.ax.tick_params(labelsize="small", length=0)
    bar.ax.set_title(unit, fontsize="small", loc="left", pad=8)
