"""Drawing of density contours on a net, with their colour bar."""

from __future__ import annotations

import numpy as np

from vomstudio.products.net.contents import NetSet
from vomstudio.products.net.contours import (
    OPACITY,
    ContourPlan,
    bar_columns,
    bar_height,
    bar_width,
    contour_colors,
    dash,
)
from vomstudio.products.net.page import NetPage
from vomstudio.products.net.style import NetStyle, layer, mix_colors


def draw_contours(page: NetPage, plan: ContourPlan) -> None:
    """Draw density contours on a page."""
    style, n = page.style, len(plan.levels)
    if not n:
        return
    for part in plan.parts:
        top = float(part.values.max())
        if top <= plan.levels[0]:
            continue
        colors = contour_colors(part.of, n, plan.filled, style)
        if plan.filled:
            # Add an upper limit, so that a single level suffices.
            filled = page.axes.contourf(
                part.x,
                part.y,
                part.values,
                levels=[*plan.levels, plan.levels[-1] + top],
                colors=colors,
                alpha=None if part.of is None else OPACITY,
                zorder=layer("density"),
                antialiased=True,
            )
            filled.set_clip_path(page.rim)
        shades = _line_colors(part.of, colors, plan.filled, style)
        lines = page.axes.contour(
            part.x,
            part.y,
            part.values,
            levels=list(plan.levels),
            colors=shades,
            linewidths=_line_width(plan, style),
            linestyles=dash(part.of),
            zorder=layer("contours"),
        )
        lines.set_clip_path(page.rim)
    _draw_bar(page, plan)


def _line_colors(
    of: NetSet | None, colors: list[object], filled: bool, style: NetStyle
) -> list[object]:
    """Return the line colours; between filled contours, lines are only separators."""
    if not filled:
        return colors
    color = style.soft if of is None else style.outline(style.color(of.color))
    return [color] * len(colors)


def _line_width(plan: ContourPlan, style: NetStyle) -> float:
    return (0.6 if plan.filled else 1.1) * style.line_pt


def _draw_bar(page: NetPage, plan: ContourPlan) -> None:
    from matplotlib.patches import Rectangle

    n, font, row = len(plan.levels), page.font, page.row
    thick = bar_width(plan, font, page.is_beside)
    if page.is_beside:
        tall = bar_height(plan, font, page.height)
        x_left, y_low = page.legend_x, page.pad + (page.under + 0.8) * row
        page.text(x_left, y_low + tall + 0.8 * row, plan.unit)
        page.text(x_left, y_low + tall + 1.8 * row, plan.name)
    else:
        tall = min(1.5 * font * n, 1.2 * page.radius)
        x_left, y_low = page.width - page.pad - 2.2 * font - thick, page.cy - tall / 2
        page.text(page.width - page.pad, y_low + tall + 0.8 * row, plan.short_unit, align="right")
    columns = bar_columns(plan)
    each = thick / len(columns)
    for column, part in enumerate(columns):
        colors = contour_colors(part.of, n, plan.filled, page.style)
        for i, color in enumerate(colors):
            x, y = x_left + column * each, y_low + tall * i / n
            if plan.filled:
                cell = Rectangle(
                    page.net_of(x, y),
                    each / page.radius,
                    tall / n / page.radius,
                    facecolor=_composite_color(color, part.of, page.style),
                    edgecolor=page.style.soft,
                    linewidth=0.5 * page.style.line_pt,
                    zorder=layer("legend"),
                )
                page.axes.add_patch(cell)
            else:
                ends = np.array([page.net_of(x, y), page.net_of(x + 0.85 * each, y)])
                page.axes.plot(
                    *ends.T,
                    color=color,
                    linestyle=dash(part.of),
                    linewidth=1.4 * _line_width(plan, page.style),
                    zorder=layer("legend"),
                )
    for i, level in enumerate(plan.levels):
        page.text(x_left + thick + 0.4 * font, y_low + tall * i / n, f"{level:g}")


def _composite_color(color: object, of: NetSet | None, style: NetStyle) -> object:
    """Return a translucent colour as it appears on the net."""
    return color if of is None else mix_colors(style.net, str(color), OPACITY)
