"""Drawing of the contents of a net on axes of mplstereonet, without the page around it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IndexArray
from vomstudio.core.words import tr
from vomstudio.geology import stereonet as nets
from vomstudio.geology.folds import FoldAxis
from vomstudio.products.net.contents import (
    MAX_AUTOMATIC_CIRCLES,
    NetContents,
    NetLineEllipse,
    NetSet,
    fold_ellipse,
    shows_all_circles,
)
from vomstudio.products.net.legend import fold_texts, format_set_entry
from vomstudio.products.net.net_axes import plot_curves, plot_polylines, plot_vectors
from vomstudio.products.net.slip_arrows import draw_slip_arrows
from vomstudio.products.net.style import SYMBOL_SIZES, NetStyle, layer, symbol_scale

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

_SLIP_HALF_LENGTH = 0.1
"""Half the length of a slip arrow, which extends beyond the symbol of its striae."""


@dataclass(eq=False)
class NetDrawing:
    """Contents of a net that are drawn on axes.

    The artists have labels, from which matplotlib can build a legend.
    """

    axes: Any
    net: NetContents
    style: NetStyle
    arcs: list[FloatArray] = field(default_factory=list)
    """Great circles (m, k, 3) of each set as drawn; m is 0 if a set has no great circles."""
    arc_rows: list[IndexArray] = field(default_factory=list)
    """For each set, the rows (m,) of the features to which the arcs belong."""
    poles: list[Line2D] = field(default_factory=list)
    outlines: list[FloatArray] = field(default_factory=list)
    """Directions (k, 3) along curves that labels should avoid."""

    def draw(self) -> None:
        """Draw everything except the contours and the selection."""
        for set_ in self.net.sets:
            self._draw_circles(set_)
        for set_ in self.net.sets:
            self._draw_set(set_)
        self._draw_means()
        if self.net.fold is not None:
            self._draw_fold(self.net.fold)
        self._draw_additions()

    def _draw_circles(self, s: NetSet) -> None:
        net, style = self.net, self.style
        count = sum(len(item) for item in net.sets if item.kind == "plane")
        has_circles = s.kind == "plane" and shows_all_circles(net)
        rows = np.arange(len(s) if has_circles else 0)
        arcs = nets.great_circles(
            s.azimuth_deg[rows], s.angle_deg[rows], 61 if count <= 100 else 31
        )
        self.arcs.append(arcs)
        self.arc_rows.append(rows)
        if len(rows) <= MAX_AUTOMATIC_CIRCLES:
            self.outlines += list(arcs[:, ::4])
        if len(rows):
            plot_curves(
                self.axes,
                arcs,
                colors=style.outline(style.color(s.color)),
                linewidths=style.line_pt,
                alpha=min(1.0, max(0.15, 4.0 / math.sqrt(count))),
                zorder=layer("circles"),
            )

    def _draw_additions(self) -> None:
        """Draw the circles, marks and error ellipses of the net."""
        style = self.style
        for circle in self.net.user_circles:
            parts = circle.outline()
            self.outlines += [part[::4] for part in parts]
            plot_polylines(
                self.axes,
                parts,
                label=circle.label,
                color=self._addition_color(circle.color),
                linewidth=style.line_pt if circle.color is None else 1.5 * style.line_pt,
                linestyle=circle.dash,
                zorder=layer("circles"),
            )
        if self.net.errors:
            plot_curves(
                self.axes,
                [part for ellipse in self.net.errors for part in ellipse.outline()],
                colors=style.soft,
                linewidths=0.8 * style.line_pt,
                zorder=layer("circles"),
            )
        for mark in self.net.marks:
            is_open = mark.marker not in "x+"
            for width, ink in ((3.6, style.net), (1.8, self._addition_color(mark.color))):
                self._plot_symbol(
                    mark.line.vector(),
                    mark.marker,
                    1.6 if is_open else 2.4,
                    style.net,
                    ink,
                    width,
                    label=mark.label if width < 3.0 else "",
                )

    def _addition_color(self, color: str | None) -> str:
        """Return the colour of a circle, mark or mean; `color` is that of its set, or None."""
        return self.style.ink if color is None else self.style.outline(self.style.color(color))

    def _draw_set(self, s: NetSet) -> None:
        """Draw the poles or lines of a set."""
        net, style = self.net, self.style
        feature_count = sum(len(item) for item in net.sets)
        size = style.marker_pt * symbol_scale(feature_count)
        is_dotted = (
            net.contour is not None and feature_count > 500
        )  # so that the contours stay visible
        if is_dotted:
            size *= 0.5
        vectors = s.vectors()
        shown_vectors = vectors if net.poles else vectors[:0]
        # Directed lines that point upwards are shown as hollow symbols at their lower end.
        up = (s.angle_deg < 0) if s.kind == "line" else np.zeros(len(s), dtype=bool)
        up = up[: len(shown_vectors)]
        face, rim, edge = style.symbol(s)
        if rim == style.net and (is_dotted or len(vectors) > 2000):
            edge = 0.0
        symbol: dict[str, Any] = {
            "linestyle": "none",
            "marker": s.marker,
            "markersize": size * SYMBOL_SIZES.get(s.marker, 1.0),
            "zorder": layer("dots" if is_dotted else "poles"),
        }
        self.poles.append(
            plot_vectors(
                self.axes,
                shown_vectors[~up],
                markerfacecolor=face,
                markeredgecolor=rim,
                markeredgewidth=edge,
                alpha=0.4 if is_dotted else 1.0,
                label=format_set_entry(s, net.poles),
                **symbol,
            )
        )
        if s.slips is not None and net.poles:
            draw_slip_arrows(
                self.axes,
                vectors,
                s.slips,
                color=style.ink,
                half_length=_SLIP_HALF_LENGTH,
                width_pt=1.2 * style.line_pt,
                zorder=layer("poles"),
            )
        if up.any():
            plot_vectors(
                self.axes,
                shown_vectors[up],
                markerfacecolor=style.net,
                markeredgecolor=style.color(s.color),
                markeredgewidth=1.2 * style.line_pt,
                **symbol,
            )

    def _draw_fold(self, fold: FoldAxis) -> None:
        style = self.style
        beta, plane = fold_texts(self.net, fold)
        circle = nets.great_circle(fold.pi_plane)
        self.outlines.append(circle)
        plot_vectors(
            self.axes,
            circle,
            flip=False,
            color=style.ink,
            linewidth=1.3 * style.line_pt,
            linestyle="--",
            zorder=layer("fold"),
            label=plane,
        )
        ellipse = fold_ellipse(fold)
        if ellipse is not None:
            self._draw_ellipse(ellipse, style.ink)
        self._plot_symbol(fold.beta.vector(), "*", 2.4, style.ink, style.net, 1.0, label=beta)

    def _draw_means(self) -> None:
        style = self.style
        for mean in self.net.means:
            color = self._addition_color(mean.color)
            self._plot_symbol(
                mean.line.vector(),
                mean.marker,
                2.0,
                style.net,
                color,
                2.4,
                label=tr("Mean {orientation}", orientation=mean.orientation),
            )
            if mean.total is not None:
                self._draw_ellipse(mean.total, color)

    def _draw_ellipse(self, ellipse: NetLineEllipse, color: str) -> None:
        parts = ellipse.outline()
        self.outlines += parts
        plot_polylines(
            self.axes, parts, color=color, linewidth=self.style.line_pt, zorder=layer("fold")
        )

    def _plot_symbol(
        self,
        vector: FloatArray,
        marker: str,
        size: float,
        face: str,
        edge: str,
        width: float,
        label: str = "",
    ) -> None:
        """Plot one symbol, with its size and edge width as multiples of those of the style."""
        plot_vectors(
            self.axes,
            vector[None],
            marker=marker,
            markersize=size * self.style.marker_pt,
            markerfacecolor=face,
            markeredgecolor=edge,
            markeredgewidth=width * self.style.line_pt,
            linestyle="none",
            zorder=layer("means"),
            label=label,
        )
