"""Net for scripts, which continue to draw on its axes of mplstereonet."""

from __future__ import annotations

from typing import Any

from vomstudio.core.words import tr
from vomstudio.geology.density import DENSITY_UNITS
from vomstudio.products.net.contents import NetContents
from vomstudio.products.net.contour_drawing import draw_contours
from vomstudio.products.net.contours import ContourPlan, contour_colors
from vomstudio.products.net.drawing import NetDrawing
from vomstudio.products.net.figure_style import FigureStyle
from vomstudio.products.net.net_axes import add_net

_LINE_HEIGHT_IN = 0.15
"""Height of a line of text in inches."""
_FIGURE_SIZE_IN = (8.0, 5.0)
"""Size of a new figure in inches."""


def create_axes(
    net: NetContents, style: FigureStyle, size_mm: tuple[float, float] | None = None
) -> Any:
    """Create axes in a new pyplot figure, with space for the legend and the text of a net.

    Parameters
    ----------
    net : NetContents
    style : FigureStyle
    size_mm : (float, float) or None, optional

    Returns
    -------
    object
    """
    import matplotlib.pyplot as plt

    width, height = _FIGURE_SIZE_IN if size_mm is None else (size_mm[0] / 25.4, size_mm[1] / 25.4)
    figure = plt.figure(figsize=(width, height))
    low = 0.11 + len(_caption_lines(net)) * _LINE_HEIGHT_IN / height
    ax = add_net(
        figure,
        (0.04, low, 0.62, 0.88 - low),
        style.net_style(),
        net.projection,
        north="N" if net.north else "y",
    )
    # Scripts may show a grid.
    ax.xaxis.set_visible(True)
    ax.yaxis.set_visible(True)
    plt.sca(ax)
    return ax


def draw_net(ax: Any, net: NetContents, style: FigureStyle | None = None) -> None:
    """Draw the contents of a net on the axes, with a legend.

    The size in `style` is ignored in favour of that of the axes' figure.

    Parameters
    ----------
    ax : object
    net : NetContents
    style : FigureStyle or None, optional
    """
    figure_style = style or FigureStyle()
    net_style = figure_style.net_style()
    plan = ContourPlan.of(net)
    if plan is not None:
        draw_contours(ax, plan, net_style)
        _draw_bar(ax, plan, figure_style)
    NetDrawing(ax, net, net_style).draw()
    text_style: dict[str, Any] = {"size": net_style.font_pt}
    if figure_style.figure.font:
        text_style["family"] = figure_style.figure.font
    ax.legend(loc="upper left", bbox_to_anchor=(1.1, 1.0), frameon=False, prop=text_style)
    lines = _caption_lines(net)
    if lines:
        ax.text(
            0.0,
            -0.09,
            "\n".join(lines),
            transform=ax.transAxes,
            va="top",
            fontproperties=text_style,
        )


def _caption_lines(net: NetContents) -> list[str]:
    """Return the lines of text below a net."""
    return [*net.averages, *net.notes]


def _draw_bar(ax: Any, plan: ContourPlan, figure_style: FigureStyle) -> None:
    """Draw the colour bar below the legend, in the shades of the first set."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap

    levels = list(plan.levels)
    if not levels:
        return
    net_style = figure_style.net_style()
    colors = contour_colors(plan.parts[0].of, len(levels), plan.filled, net_style)
    inset = ax.inset_axes((1.13, 0.02, 0.04, min(0.06 * len(levels), 0.42)), projection=None)
    shades: Any = ListedColormap(colors)
    norm = BoundaryNorm([*levels, levels[-1] + 1.0], len(levels))
    bar = ax.figure.colorbar(
        ScalarMappable(norm, shades), cax=inset, spacing="uniform", ticks=levels
    )
    bar.ax.tick_params(labelsize=net_style.font_pt, length=0)
    bar.ax.set_title(tr(DENSITY_UNITS[plan.method]), fontsize=net_style.font_pt, loc="left", pad=8)
