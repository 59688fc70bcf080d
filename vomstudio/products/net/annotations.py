"""Additional elements of a net besides the sets: circles, marks, and feature errors."""

from __future__ import annotations

from collections.abc import Iterable

from vomstudio.geology import stereonet as nets
from vomstudio.products.net.contents import AnyEllipse, NetCircle, NetMark
from vomstudio.products.net.page import NetPage
from vomstudio.products.net.style import layer


def draw_additions(page: NetPage) -> None:
    """Draw the circles, marks and error ellipses of a net."""
    net = page.net
    _draw_circles(page, net.circles_typed)
    _draw_errors(page, net.errors)
    _draw_marks(page, net.marks)


def _draw_circles(page: NetPage, circles: Iterable[NetCircle]) -> None:
    style = page.style
    for circle in circles:
        color = style.ink if circle.color is None else style.outline(style.color(circle.color))
        width = style.line_pt if circle.color is None else 1.5 * style.line_pt
        for part in circle.outline(page.net.projection):
            page.outlines.append(part[::4])
            page.axes.plot(
                *part.T,
                color=color,
                linewidth=width,
                linestyle=circle.dash,
                zorder=layer("circles"),
            )


def _draw_errors(page: NetPage, errors: Iterable[AnyEllipse]) -> None:
    from matplotlib.collections import LineCollection

    parts = [part for e in errors for part in e.outline(page.net.projection)]
    if parts:
        page.axes.add_collection(
            LineCollection(
                parts,
                colors=page.style.soft,
                linewidths=0.8 * page.style.line_pt,
                zorder=layer("poles"),
            ),
            autolim=False,
        )


def _draw_marks(page: NetPage, marks: Iterable[NetMark]) -> None:
    style = page.style
    for mark in marks:
        x, y = nets.project(mark.line.vector(), page.net.projection)[0]
        color = style.ink if mark.color is None else style.outline(style.color(mark.color))
        open_ = mark.marker not in "x+"
        for width, ink in ((3.6, style.net), (1.8, color)):
            page.axes.plot(
                [x],
                [y],
                marker=mark.marker,
                markersize=(1.6 if open_ else 2.4) * style.marker_pt,
                markerfacecolor=style.net,
                markeredgecolor=ink,
                linestyle="none",
                markeredgewidth=width * style.line_pt,
                zorder=layer("means"),
            )
