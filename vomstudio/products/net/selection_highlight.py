"""Highlighting of selected features on a drawn net."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.geology import stereonet as nets
from vomstudio.products.net.contents import MAX_AUTOMATIC_CIRCLES, NetContents
from vomstudio.products.net.net_axes import plot_curves, plot_polylines, plot_vectors
from vomstudio.products.net.style import SYMBOL_SIZES, NetStyle, layer, symbol_scale

if TYPE_CHECKING:
    from matplotlib.artist import Artist


LIVE_COLOR = "#D55E00"
"""Colour of the feature being picked."""


def draw_highlight(ax: Any, net: NetContents, style: NetStyle) -> list[Artist]:
    """Draw the selected features, their ellipses, and the feature being picked.

    Selected features have larger symbols with rings, and outlined great circles. This emphasis
    decreases with their number.
    """
    artists: list[Artist] = []
    selected_rows = [
        np.array([i for i, name in enumerate(set_.ids) if name in net.selected], dtype=np.intp)
        if net.selected
        else np.zeros(0, dtype=np.intp)
        for set_ in net.sets
    ]
    plane_count = sum(
        len(rows)
        for set_, rows in zip(net.sets, selected_rows, strict=True)
        if set_.kind == "plane"
    )
    has_circles = plane_count <= MAX_AUTOMATIC_CIRCLES or not net.poles
    # Bold rings around thousands of poles would merge into one black area.
    overlap_share = float(
        np.interp(math.log10(1 + sum(map(len, selected_rows))), [1.5, 3.0], [0.0, 1.0])
    )
    size = style.marker_pt * symbol_scale(sum(len(set_) for set_ in net.sets))
    size = max(size * (1.7 - 0.5 * overlap_share), (1.5 - 0.8 * overlap_share) * style.marker_pt)
    ring = (1.6 - 1.2 * overlap_share) * style.line_pt
    for set_, rows in zip(net.sets, selected_rows, strict=True):
        if not len(rows):
            continue
        color = style.color(set_.color)
        if set_.kind == "plane" and has_circles:
            steps = 181 if plane_count <= MAX_AUTOMATIC_CIRCLES else 31
            arcs = nets.great_circles(set_.azimuth_deg[rows], set_.angle_deg[rows], steps)
            for ink, width, layer_name in (
                (style.ink, 3.4, "casings"),
                (color, 2.0, "chosen circles"),
            ):
                artists.append(
                    plot_curves(
                        ax,
                        arcs,
                        colors=ink,
                        linewidths=width * style.line_pt,
                        zorder=layer(layer_name),
                    )
                )
        if net.poles:
            artists.append(
                plot_vectors(
                    ax,
                    set_.vectors()[rows],
                    linestyle="none",
                    marker=set_.marker,
                    markersize=size * SYMBOL_SIZES.get(set_.marker, 1.0),
                    markerfacecolor=style.symbol(set_)[0],
                    markeredgecolor=style.ink,
                    markeredgewidth=ring,
                    zorder=layer("chosen"),
                )
            )
    for ellipse in net.ellipses:
        artists += plot_polylines(
            ax,
            ellipse.outline(),
            color=style.ink,
            linewidth=1.2 * style.line_pt,
            zorder=layer("ellipses"),
        )
    return [*artists, *_draw_live_feature(ax, net, style)]


def _draw_live_feature(ax: Any, net: NetContents, style: NetStyle) -> list[Artist]:
    """Draw the feature being picked: a ring with a cross, its great circle and its ellipse."""
    live_feature = net.live
    position = None if live_feature is None else live_feature.place
    if live_feature is None or position is None:
        return []
    artists: list[Artist] = []
    color = style.color(LIVE_COLOR)
    if live_feature.plane is not None:
        circle = nets.great_circle(live_feature.plane)
        for ink, width in ((style.net, 3.0), (color, 1.6)):
            artists.append(
                plot_vectors(
                    ax,
                    circle,
                    flip=False,
                    color=ink,
                    linewidth=width * style.line_pt,
                    zorder=layer("chosen circles"),
                )
            )
    if live_feature.ellipse is not None:
        artists += plot_polylines(
            ax,
            live_feature.ellipse.outline(),
            color=color,
            linewidth=1.6 * style.line_pt,
            zorder=layer("ellipses"),
        )
    for marker in ("o", "+"):
        artists.append(
            plot_vectors(
                ax,
                position.vector()[None],
                marker=marker,
                markersize=2.2 * style.marker_pt,
                linestyle="none",
                markerfacecolor="none",
                markeredgecolor=color,
                markeredgewidth=1.6 * style.line_pt,
                zorder=layer("chosen"),
            )
        )
    return artists
