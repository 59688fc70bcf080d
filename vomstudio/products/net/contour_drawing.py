"""Drawing of density contours on a net, with their colour bar."""

from __future__ import annotations

from typing import Any

from vomstudio.products.net.contents import NetSet
from vomstudio.products.net.contours import (
    OPACITY,
    ContourPlan,
    bar_columns,
    bar_height,
    bar_width,
    contour_colors,
)
from vomstudio.products.net.page import NetPage
from vomstudio.products.net.style import NetStyle, layer, mix_colors


def draw_contours(ax: Any, plan: ContourPlan, style: NetStyle) -> None:
    """Draw density contours on axes of mplstereonet."""
    n = len(plan.levels)
    for part in plan.parts:
        top = float(part.values.max())
        if not n or top <= plan.levels[0]:
            continue
        colors = contour_colors(part.of, n, plan.filled, style)
        if plan.filled:
            # Add an upper limit, so that a single level suffices.
            ax.contourf(
                part.steps,
                part.steps,
                part.values,
                levels=[*plan.levels, plan.levels[-1] + top],
                colors=colors,
                alpha=OPACITY,
                zorder=layer("density"),
                antialiased=True,
            )
        ax.contour(
            part.steps,
            part.steps,
            part.values,
            levels=list(plan.levels),
            colors=_line_colors(part.of, colors, plan.filled, style),
            linewidths=_line_width(plan, style),
            linestyles=part.dash,
            zorder=layer("contours"),
        )


def _line_colors(
    colored_set: NetSet | None, colors: list[str], is_filled: bool, style: NetStyle
) -> list[str]:
    """Return the colours of the contour lines; between filled contours, all are the same."""
    if not is_filled:
        return colors
    color = style.soft if colored_set is None else style.outline(style.color(colored_set.color))
    return [color] * len(colors)


def _line_width(plan: ContourPlan, style: NetStyle) -> float:
    return (0.6 if plan.filled else 1.1) * style.line_pt


def draw_bar(page: NetPage, plan: ContourPlan) -> None:
    """Draw the colour bar of contours on a page.

    Parameters
    ----------
    page : NetPage
    plan : ContourPlan
    """
    from matplotlib.patches import Rectangle

    n, font, row = len(plan.levels), page.font, page.row
    bar_thickness = bar_width(plan, font, page.is_legend_beside)
    if page.is_legend_beside:
        height = bar_height(plan, font, page.height)
        x_left, y_low = page.legend_x, page.pad + (page.rows_below + 0.8) * row
        for i, line in enumerate(reversed(page.bar_lines)):
            page.text(x_left, y_low + height + (0.8 + i) * row, line)
    else:
        height = min(1.5 * font * n, 1.2 * page.radius)
        x_left, y_low = page.width - page.pad - 2.2 * font - bar_thickness, page.cy - height / 2
        page.text(page.width - page.pad, y_low + height + 0.8 * row, plan.short_unit, align="right")
    columns = bar_columns(plan)
    column_width = bar_thickness / len(columns)
    for column, part in enumerate(columns):
        colors = contour_colors(part.of, n, plan.filled, page.style)
        for i, color in enumerate(colors):
            x, y = x_left + column * column_width, y_low + height * i / n
            if plan.filled:
                cell = Rectangle(
                    (x, y),
                    column_width,
                    height / n,
                    facecolor=mix_colors(page.style.net, color, OPACITY),
                    edgecolor=page.style.soft,
                    linewidth=0.5 * page.style.line_pt,
                    zorder=layer("legend"),
                    transform=page.points,
                    clip_on=False,
                )
                page.axes.add_patch(cell)
            else:
                page.plot(
                    [x, x + 0.85 * column_width],
                    [y, y],
                    color=color,
                    linestyle=part.dash,
                    linewidth=1.4 * _line_width(plan, page.style),
                    zorder=layer("legend"),
                )
    for i, level in enumerate(plan.levels):
        page.text(x_left + bar_thickness + 0.4 * font, y_low + height * i / n, f"{level:g}")
