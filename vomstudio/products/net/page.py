"""Page with a net: its layout, and drawing of everything except the selection."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray, IndexArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology import stereonet as nets
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import format_attitude
from vomstudio.products.net.contents import (
    AUTO_CIRCLES,
    NetContents,
    NetLineEllipse,
    fold_ellipse,
    shows_all_circles,
)
from vomstudio.products.net.contours import ContourPlan, bar_height, bar_space
from vomstudio.products.net.labels import Box, find_label_place
from vomstudio.products.net.legend import (
    NetLegendEntry,
    legend_entries,
    shorten_text,
    text_width,
    wrap_text,
)
from vomstudio.products.net.slip_arrows import draw_slip_arrows
from vomstudio.products.net.style import SYMBOL_SIZES, NetStyle, layer, symbol_scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

PROJECTION_NAMES = {
    "area": to_translate("Equal area, lower hemisphere"),
    "angle": to_translate("Equal angle, lower hemisphere"),
}

_MAX_LEGEND_LETTERS = 24.0
"""Maximum width of a legend beside the net, in letter widths."""
_MIN_CONNECTED_LETTERS = 1.5
"""Minimum distance, in letter widths, at which a line connects a label to its mark."""
_SLIP_HALF_LENGTH = 0.1
"""Half the length of a slip arrow, which extends beyond the symbol of its striae."""


class NetPage:
    """Layout of a figure, in points from its bottom left corner."""

    def __init__(self, figure: Figure, net: NetContents, style: NetStyle) -> None:
        self.net, self.style = net, style
        self.width, self.height = (72.0 * float(v) for v in figure.get_size_inches())
        self.px = figure.dpi / 72.0
        self.font = style.font_pt
        self.row = 1.45 * self.font
        self.pad = 0.8 * self.font
        self.entries = legend_entries(net, style)
        self.contours = ContourPlan.of(net)
        self.bar = self.contours if self.contours and self.contours.levels else None
        self.foot = list(net.notes)
        planes = sum(len(s) for s in net.sets if s.kind == "plane")
        if net.circles is None and planes > AUTO_CIRCLES:
            self.foot.append(tr("Great circles of {count:,} planes not drawn", count=planes))
        if self.contours and not self.bar:
            self.foot.append(Finding("net.nowhere-dense").message)
        self.foot.append(tr(PROJECTION_NAMES[net.projection]))
        self.words: list[str] = []
        self.whole = True
        self.heading = 1.9 * self.row if net.title else 0.0
        self.text_boxes: list[Box] = []
        self.outlines: list[FloatArray] = []
        """Points along curves on the net that labels should avoid."""
        self._arrange()
        self.axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        r = self.radius
        self.axes.set_xlim(-self.cx / r, (self.width - self.cx) / r)
        self.axes.set_ylim(-self.cy / r, (self.height - self.cy) / r)
        self.axes.set_axis_off()
        self.axes.set_autoscale_on(False)

    # Layout

    def _arrange(self) -> None:
        """Arrange the legend and the colour bar beside or below the net to make it largest.

        The attribute `whole` is set to whether nothing had to be omitted.
        """
        head = self.row + 0.6 * self.font  # N and its tick
        tick = 0.9 * self.font
        bar = bar_space(self.bar, self.font)
        notes, widest = self.foot, _MAX_LEGEND_LETTERS * self.font

        self.foot = _lines(notes, self.font, widest)
        words = _lines(self.net.averages, self.font, widest)
        gap = tick + 1.5 * self.font
        column = self._column_width(words)
        is_beside = min(
            self.height - head - tick - self.pad,
            self.width - 2 * self.pad - tick - gap - column,
        )
        low_foot = _lines(notes, self.font, self.width - 2 * self.pad)
        room = self.width - 2 * (self.pad + tick) - bar
        rows, low_words, low = self._under_net(low_foot, head + tick, room)
        below_diameter = min(self.height - head - tick - low - self.heading, room)

        self.is_beside = is_beside >= below_diameter
        self.radius = max(is_beside, below_diameter, 20.0) / 2.0
        if self.is_beside:
            room = self.height - 2 * self.pad - self._foot() - self.heading
            most = max(int(room / (1.15 * self.row)), 1)
            self.rows = [[(0.0, e)] for e in self.entries[:most]]
            room -= 1.15 * self.row * len(self.rows)
            self.words = _cut(words, max(int(room / self.row), 0))
            self.whole = len(self.rows) == len(self.entries) and self.words == words
            self.cx = self.pad + tick + self.radius
            self.cy = self.height - head - self.radius - self.pad / 2
            self.legend_x = self.cx + self.radius + gap
            self.legend_width = self.width - self.legend_x - self.pad
        else:
            self.foot, self.rows, self.words = low_foot, rows, low_words
            self.whole = self.words == _lines(
                self.net.averages, self.font, self.width - 2 * self.pad
            )
            self.whole = self.whole and sum(map(len, rows)) == len(self.entries)
            # Beside the net, the name of the bar is above it; at the right edge it does not fit.
            if self.bar is not None and not self.net.compact:
                full = f"{self.bar.name}; {self.bar.unit}"
                fits = text_width(full, self.font) <= self.width - 2 * self.pad
                self.foot.insert(-1, full if fits else self.bar.name)
            self.cx = (self.width - bar) / 2.0
            self.cy = self.height - self.heading - head - self.radius
            self.legend_x = self.pad
            self.legend_width = self.width - 2 * self.pad

    def _under_net(
        self, foot: list[str], head: float, widest: float
    ) -> tuple[list[list[tuple[float, NetLegendEntry]]], list[str], float]:
        """Return the legend rows below the net, the wrapped averages, and their total height.

        `head` is the height above the net, and `widest` the maximum diameter of the net.
        """
        rows = self._flow(self.width - 2 * self.pad)
        words = _lines(self.net.averages, self.font, self.width - 2 * self.pad)
        under = len(foot) + (self.bar is not None and not self.net.compact)
        least = min((0.55 if self.net.compact else 0.4) * self.height, widest)
        low = (len(rows) + len(words) + under) * self.row + self.pad
        # Assign space to the net first, then to the legend, then to the averages.
        while (len(rows) > 1 or words) and self.height - head - low < least:
            if words:
                words = _cut(words, len(words) - 1)
            else:
                rows.pop()
            low = (len(rows) + len(words) + under) * self.row + self.pad
        return rows, words, low

    def _column_width(self, words: list[str]) -> float:
        """Return the width of a legend beside the net, for which long names are shortened."""
        texts = [*self.foot, *words]
        if self.bar is not None:
            texts += [self.bar.name, self.bar.unit]
        entries = [2.2 * self.font + text_width(e.text, self.font) for e in self.entries]
        widest = min(max(entries, default=0.0), _MAX_LEGEND_LETTERS * self.font)
        title = text_width(self.net.title[:40], 1.15 * self.font, "bold")
        return 1.05 * max(widest, title, *(text_width(t, self.font) for t in texts))

    def _foot(self) -> float:
        """Return the height of the caption and the colour bar below a legend beside the net."""
        under = (self.under + 1.0) * self.row
        if self.bar is None:
            return under
        return under + bar_height(self.bar, self.font, self.height) + 3.0 * self.row

    @property
    def under(self) -> int:
        """Number of text rows below the legend."""
        return len(self.foot) + len(self.words)

    def _flow(self, width: float) -> list[list[tuple[float, NetLegendEntry]]]:
        """Arrange legend entries side by side in rows of (offset, entry)."""
        rows: list[list[tuple[float, NetLegendEntry]]] = []
        x = 0.0
        for e in self.entries:
            need = 2.2 * self.font + text_width(e.text, self.font)
            if rows and x + need <= width:
                rows[-1].append((x, e))
            else:
                rows.append([(0.0, e)])
                x = 0.0
            x += need + 1.6 * self.font
        return rows

    def net_of(self, x: float, y: float) -> tuple[float, float]:
        return (x - self.cx) / self.radius, (y - self.cy) / self.radius

    def text(
        self,
        x: float,
        y: float,
        text: str,
        *,
        align: str = "left",
        color: str | None = None,
        weight: str = "normal",
        halo: bool = False,
        size: float = 1.0,
    ) -> None:
        """Draw text at a position in points, where y is its middle, and store its box."""
        from matplotlib import patheffects

        width = text_width(text, self.font * size, weight)
        x_left = {"left": x, "center": x - width / 2, "right": x - width}[align]
        half = 0.5 * self.font * size
        self.text_boxes.append((x_left, y - half, x_left + width, y + half))
        artist = self.axes.text(
            *self.net_of(x, y),
            text,
            ha=align,
            va="center_baseline",
            fontsize=self.font * size,
            color=color or self.style.ink,
            weight=weight,
            zorder=layer("words"),
            parse_math=False,
        )
        if halo:
            ring = patheffects.withStroke(linewidth=0.45 * self.font, foreground=self.style.net)
            artist.set_path_effects([ring])

    # Drawing

    def draw_frame(self) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.patches import Circle

        style, ax = self.style, self.axes
        ax.add_patch(
            Circle((0, 0), 1.0, facecolor=style.net, edgecolor="none", zorder=layer("ground"))
        )
        self.rim = Circle(
            (0, 0),
            1.0,
            facecolor="none",
            edgecolor=style.ink,
            linewidth=1.25 * style.line_pt,
            zorder=layer("rim"),
        )
        ax.add_patch(self.rim)
        azimuth = np.radians(np.arange(0, 360, 10))
        unit = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
        long = np.arange(36) % 9 == 0
        length = np.where(long, 0.6, 0.3)[:, None] * self.font / self.radius
        cross = 0.35 * self.font / self.radius
        ticks = [*np.stack([unit, unit * (1 + length)], axis=1)]
        ticks += [np.array([[-cross, 0], [cross, 0]]), np.array([[0, -cross], [0, cross]])]
        ax.add_collection(
            LineCollection(ticks, colors=style.ink, linewidths=style.line_pt, zorder=layer("ticks"))
        )
        self.text(
            self.cx,
            self.cy + self.radius + 0.6 * self.font + 0.62 * self.row,
            "N" if self.net.north else "y",
            align="center",
            weight="bold",
            size=1.15,
        )

    def draw_circles(self) -> tuple[list[FloatArray], list[IndexArray]]:
        from matplotlib.collections import LineCollection

        net, style = self.net, self.style
        count = sum(len(s) for s in net.sets if s.kind == "plane")
        all_of_them = shows_all_circles(net)
        steps = 61 if count <= 100 else 31
        arcs: list[FloatArray] = []
        rows: list[IndexArray] = []
        for s in net.sets:
            keep = np.arange(len(s) if s.kind == "plane" and all_of_them else 0)
            lines = nets.great_circles(
                s.azimuth_deg[keep], s.angle_deg[keep], net.projection, steps
            )
            arcs.append(lines)
            rows.append(keep)
            if len(keep) <= AUTO_CIRCLES:
                self.outlines += list(lines[:, ::4])
            if len(keep):
                self.axes.add_collection(
                    LineCollection(
                        list(lines),
                        colors=style.outline(style.color(s.color)),
                        linewidths=style.line_pt,
                        alpha=min(1.0, max(0.15, 4.0 / math.sqrt(count))),
                        zorder=layer("circles"),
                    )
                )
        return arcs, rows

    def draw_poles(self, positions: list[FloatArray]) -> list[Line2D]:
        net, style = self.net, self.style
        total = sum(len(s) for s in net.sets)
        size = style.marker_pt * symbol_scale(total)
        dots = net.contour is not None and total > 500  # so that the contours stay visible
        if dots:
            size *= 0.5
        drawn = []
        for s, at in zip(net.sets, positions, strict=True):
            shown = at if net.poles else at[:0]
            # Directed lines that point upwards are shown as hollow symbols at their lower end.
            up = (s.angle_deg < 0) if s.kind == "line" else np.zeros(len(s), dtype=bool)
            up = up[: len(shown)]
            color = style.color(s.color)
            face, rim, edge = style.symbol(s)
            if rim == style.net and (dots or len(at) > 2000):
                edge = 0.0
            symbol_size = size * SYMBOL_SIZES.get(s.marker, 1.0)
            (line,) = self.axes.plot(
                shown[~up, 0],
                shown[~up, 1],
                linestyle="none",
                marker=s.marker,
                markersize=symbol_size,
                markerfacecolor=face,
                markeredgecolor=rim,
                markeredgewidth=edge,
                alpha=0.4 if dots else 1.0,
                zorder=layer("poles"),
            )
            drawn.append(line)
            if s.slips is not None and net.poles:
                draw_slip_arrows(
                    self.axes,
                    at,
                    s.slips,
                    color=style.ink,
                    half=_SLIP_HALF_LENGTH,
                    width_pt=1.2 * style.line_pt,
                    zorder=layer("poles"),
                )
            if up.any():
                self.axes.plot(
                    shown[up, 0],
                    shown[up, 1],
                    linestyle="none",
                    marker=s.marker,
                    markersize=symbol_size,
                    markerfacecolor=style.net,
                    markeredgecolor=color,
                    markeredgewidth=1.2 * style.line_pt,
                    zorder=layer("poles"),
                )
        return drawn

    def draw_fold(self, fold: FoldAxis) -> None:
        net, style = self.net, self.style
        circle = nets.great_circle(fold.pi_plane, net.projection)
        self.outlines.append(circle)
        self.axes.plot(
            *circle.T,
            color=style.ink,
            linewidth=1.3 * style.line_pt,
            linestyle="--",
            zorder=layer("fold"),
        )
        ellipse = fold_ellipse(fold)
        if ellipse is not None:
            self._draw_ellipse(ellipse, style.ink)
        x, y = nets.project(fold.beta.vector(), net.projection)[0]
        self.axes.plot(
            [x],
            [y],
            marker="*",
            markersize=2.4 * style.marker_pt,
            markerfacecolor=style.ink,
            markeredgecolor=style.net,
            markeredgewidth=style.line_pt,
            linestyle="none",
            zorder=layer("means"),
        )

    def _draw_ellipse(self, ellipse: NetLineEllipse, color: str) -> None:
        for part in ellipse.outline(self.net.projection):
            self.axes.plot(*part.T, color=color, linewidth=self.style.line_pt, zorder=layer("fold"))
            self.outlines.append(part)

    def draw_means_and_labels(self) -> None:
        net, style = self.net, self.style
        labels: list[tuple[FloatArray, str, str]] = []
        for mean in net.means:
            at = nets.project(mean.line.vector(), net.projection)[0]
            color = style.outline(style.color(mean.color))
            self.axes.plot(
                *at[:, None],
                marker=mean.marker,
                markersize=2.0 * style.marker_pt,
                markerfacecolor=style.net,
                markeredgecolor=color,
                markeredgewidth=2.4 * style.line_pt,
                linestyle="none",
                zorder=layer("means"),
            )
            labels.append((at, mean.label, style.ink))
            if mean.total is not None:
                self._draw_ellipse(mean.total, color)
        if net.fold is not None:
            at = nets.project(net.fold.beta.vector(), net.projection)[0]
            text = f"β {format_attitude(net.fold.beta, net.fold.error95_deg)}"
            labels.append((at, text, style.ink))
        for requested in net.marks:
            at = nets.project(requested.line.vector(), net.projection)[0]
            labels.append((at, requested.label, style.ink))
        crowd = np.vstack(
            [np.zeros((0, 2)), *self.outlines]
            + [part for e in net.ellipses for part in e.outline(net.projection)]
            + [nets.project(s.vectors(), net.projection) for s in net.sets if net.poles and len(s)]
        )
        crowd = np.array([self.cx, self.cy]) + self.radius * crowd
        marks = [np.array([self.cx, self.cy]) + self.radius * at for at, _, _ in labels]
        for mark, (_, text, color) in zip(marks, labels, strict=True):
            place = find_label_place(self, mark, text, crowd, marks)
            if place is not None:
                self.text(*place, text, color=color, halo=True)
                self._join(mark)

    def _join(self, mark: FloatArray) -> None:
        """Connect the last text to its mark by a line if other symbols are nearer to it."""
        x_left, y_low, x_right, y_high = self.text_boxes[-1]
        end = np.clip(mark, [x_left, y_low], [x_right, y_high])
        away = mark - end
        gap = float(np.hypot(*away))
        if gap > _MIN_CONNECTED_LETTERS * self.font:
            # Keep a distance from both, since the line would otherwise look like a minus sign.
            away *= 0.4 * self.font / gap
            ends = np.array([end + away, mark - 1.5 * away])
            ends = (ends - [self.cx, self.cy]) / self.radius
            self.axes.plot(
                *ends.T,
                color=self.style.soft,
                linewidth=self.style.line_pt,
                zorder=layer("means"),
                gid="to label",
            )

    def draw_legend(self) -> None:
        if self.net.title:
            room = self.legend_width if self.is_beside else self.width - 2 * self.pad
            title = shorten_text(self.net.title, 1.15 * self.font, room, "bold")
            top = self.height - self.pad - 0.5 * self.row
            self.text(self.legend_x, top, title, weight="bold", size=1.15)
        if self.is_beside:
            y = self.height - self.pad - 0.5 * self.row - self.heading
        else:
            y = self.pad + (len(self.rows) + self.under - 0.5) * self.row
        hidden = len(self.entries) - sum(len(r) for r in self.rows)
        step = self.row * (1.15 if self.is_beside else 1.0)
        for i, row in enumerate(self.rows):
            for offset, entry in row:
                room = self.legend_width - offset - 2.2 * self.font
                text = entry.text
                if hidden and i == len(self.rows) - 1 and (offset, entry) == row[-1]:
                    text = tr("and {count} more", count=hidden + 1)
                    self._legend_entry(offset, y, replace(entry, text=text, marker=None, line=None))
                    continue
                text = shorten_text(text, self.font, room)
                self._legend_entry(offset, y, replace(entry, text=text))
            y -= step
        for i, line in enumerate([*self.words, *self.foot]):
            y = self.pad + (self.under - i - 0.5) * self.row
            text = shorten_text(line, self.font, self.legend_width)
            soft = i >= len(self.words)
            self.text(self.legend_x, y, text, color=self.style.soft if soft else self.style.ink)

    def _legend_entry(self, offset: float, y: float, entry: NetLegendEntry) -> None:
        style = self.style
        x = self.legend_x + offset
        start, end = self.net_of(x, y), self.net_of(x + 1.6 * self.font, y)
        if entry.line is not None:
            self.axes.plot(
                [start[0], end[0]],
                [start[1], end[1]],
                color=entry.color,
                zorder=layer("legend"),
                linewidth=1.3 * style.line_pt,
                linestyle=entry.line,
            )
        if entry.marker is not None:
            big = 1.6 if entry.marker == "*" or entry.outlined else 1.1
            face, edge = entry.color, style.ink if entry.outlined else style.paper
            width = (1.4 if entry.outlined else 0.5) * style.line_pt
            if entry.like is not None:
                face, edge, width = style.symbol(entry.like)
                big = 1.1 * SYMBOL_SIZES.get(entry.marker, 1.0)
            self.axes.plot(
                [(start[0] + end[0]) / 2],
                [start[1]],
                marker=entry.marker,
                zorder=layer("legend"),
                markersize=big * style.marker_pt,
                linestyle="none",
                markerfacecolor=face,
                markeredgecolor=edge,
                markeredgewidth=width,
            )
        self.text(x + 2.2 * self.font, y, entry.text)


def _lines(texts: Sequence[str], font_pt: float, width: float) -> list[str]:
    """Wrap texts to a width."""
    return [line for text in texts for line in wrap_text(text, font_pt, width)]


def _cut(words: list[str], max_lines: int) -> list[str]:
    """Limit the number of lines of averages; the last one reports omitted lines."""
    if len(words) <= max_lines:
        return words
    return [*words[: max_lines - 1], tr("…: the averages need more room")] if max_lines > 1 else []
