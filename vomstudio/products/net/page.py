"""Page with a net: its layout, labels and legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology import stereonet as nets
from vomstudio.geology.notation import format_attitude
from vomstudio.products.net.contents import MAX_AUTOMATIC_CIRCLES, NetContents
from vomstudio.products.net.contours import ContourPlan, bar_height, bar_space
from vomstudio.products.net.labels import Box, find_label_position
from vomstudio.products.net.legend import (
    NetLegendEntry,
    legend_entries,
    shorten_text,
    text_width,
    wrap_text,
)
from vomstudio.products.net.net_axes import NORTH_HEIGHT_LETTERS, NORTH_SIZE, add_net
from vomstudio.products.net.style import SYMBOL_SIZES, NetStyle, layer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PROJECTION_NAMES = {
    "area": to_translate("Equal area, lower hemisphere"),
    "angle": to_translate("Equal angle, lower hemisphere"),
}

_MAX_LEGEND_LETTERS = 24.0
"""Maximum width of a legend beside the net, in letter widths."""
_MAX_BRIEF_ROWS = 2
"""Maximum number of rows of the legend of a small net."""
_MAX_CORNER_SHARE = 0.4
"""Maximum width of the selected feature's name, as a share of the width of the net."""
_SYMBOL_LETTERS = 2.2
"""Width of the symbol of a legend entry, in letter widths."""
_HINTING_FACTOR = 1.05
"""Factor by which hinting may widen a text on the screen compared with its outlines."""
_MIN_CONNECTED_LETTERS = 1.5
"""Minimum distance, in letter widths, at which a line connects a label to its mark."""


LegendRow = list[tuple[float, NetLegendEntry]]
"""Entries in one row of the legend, with their offsets in points."""


class NetPage:
    """Layout of a figure, in points from its bottom left corner."""

    def __init__(self, figure: Figure, net: NetContents, style: NetStyle) -> None:
        self._figure, self.net, self.style = figure, net, style
        self.width, self.height = (72.0 * float(v) for v in figure.get_size_inches())
        self.px = figure.dpi / 72.0
        self.font = style.font_pt
        self.row = 1.45 * self.font
        self.pad = 0.8 * self.font
        self.entries = legend_entries(net, style)
        self.contours = ContourPlan.of(net)
        self.bar = self.contours if self.contours and self.contours.levels else None
        self.caption_lines = list(net.notes)
        planes = sum(len(set_) for set_ in net.sets if set_.kind == "plane")
        if net.circles is None and planes > MAX_AUTOMATIC_CIRCLES and not net.brief:
            self.caption_lines.append(
                tr("Great circles of {count:,} planes are not drawn", count=planes)
            )
        if self.contours and not self.bar:
            self.caption_lines.append(Finding("net.nowhere-dense").message)
        if self.bar and self.bar.subject and net.compact:
            self.caption_lines.append(tr("Contours {subject}", subject=self.bar.subject))
        self.caption_lines.append("" if net.brief else tr(PROJECTION_NAMES[net.projection]))
        self.averages = () if net.brief else net.averages
        if net.brief:
            self.entries = [entry for entry in self.entries if entry.symbol_set is not None]
            if len(self._arrange_in_rows(self.width - 2 * self.pad)) > _MAX_BRIEF_ROWS:
                self.entries = []
        self.words: list[str] = []
        self.is_complete = True
        self.heading = 1.9 * self.row if net.title else 0.0
        self.text_boxes: list[Box] = []
        self.bar_lines: list[str] = []
        """Name, subject and unit of the colour bar beside the net."""
        self._arrange()

    @cached_property
    def axes(self) -> Any:
        """Axes of the net, created on first use because a layout does not need them."""
        x_left, y_low, side = self.cx - self.radius, self.cy - self.radius, 2.0 * self.radius
        width, height = self.width, self.height
        box = (x_left / width, y_low / height, side / width, side / height)
        return add_net(self._figure, box, self.style, self.net.projection, north="")

    @cached_property
    def points(self) -> Any:
        """Transform of positions in points."""
        from matplotlib.transforms import Affine2D

        return Affine2D().scale(1.0 / 72.0) + self._figure.dpi_scale_trans

    # Layout

    def _arrange(self) -> None:
        """Arrange the legend and the colour bar beside or below the net, whichever is better.

        The net should be as large as possible. Sets `is_complete` to False if entries or averages
        had to be omitted.
        """
        head = self.row + 0.6 * self.font  # N and its tick
        tick = 0.9 * self.font
        bar = bar_space(self.bar, self.font)
        notes, max_legend_width = self.caption_lines, _MAX_LEGEND_LETTERS * self.font

        self.caption_lines = _wrap_texts(notes, self.font, max_legend_width)
        lines = _wrap_texts(self.averages, self.font, max_legend_width)
        if self.bar is not None:
            texts = [text for text in (self.bar.name, self.bar.subject, self.bar.unit) if text]
            self.bar_lines = _wrap_texts(texts, self.font, max_legend_width)
        gap = tick + 1.5 * self.font
        column = self._column_width(lines)
        diameter_with_side_legend = min(
            self.height - head - tick - self.pad,
            self.width - 2 * self.pad - tick - gap - column,
        )
        width_below = self.width - 2 * self.pad
        if self.bar is not None and not self.net.compact:
            notes = [*notes[:-1], *_describe_bar(self.bar), notes[-1]]
        caption_below = _wrap_texts(notes, self.font, width_below)
        available_space = self.width - 2 * (self.pad + tick) - bar
        rows, averages_below, low = self._arrange_below_net(
            caption_below, head + tick, available_space
        )
        diameter_below = min(self.height - head - tick - low - self.heading, available_space)

        self.is_legend_beside = diameter_with_side_legend >= diameter_below and not self.net.brief
        self.radius = (
            max(diameter_with_side_legend if self.is_legend_beside else diameter_below, 20.0) / 2.0
        )
        if self.is_legend_beside:
            self.cx = self.pad + tick + self.radius
            self.cy = self.height - head - self.radius - self.pad / 2
            self.legend_x = self.cx + self.radius + gap
            self.legend_width = self.width - self.legend_x - self.pad
            available_space = self.height - 2 * self.pad - self._caption_height() - self.heading
            maximum = max(int(available_space / (1.15 * self.row)), 1)
            rows = self._arrange_in_column(self.legend_width)
            self.rows = rows[:maximum]
            available_space -= 1.15 * self.row * len(self.rows)
            self.words = _limit_lines(lines, max(int(available_space / self.row), 0))
            self.is_complete = len(self.rows) == len(rows) and self.words == lines
        else:
            self.caption_lines, self.rows, self.words = caption_below, rows, averages_below
            self.is_complete = self.words == _wrap_texts(self.averages, self.font, width_below)
            self.is_complete = self.is_complete and len(rows) == len(
                self._arrange_in_rows(width_below)
            )
            self.cx = (self.width - bar) / 2.0
            self.cy = self.height - self.heading - head - self.radius
            self.legend_x = self.pad
            self.legend_width = width_below

    def _arrange_below_net(
        self, caption_lines: list[str], head: float, max_width: float
    ) -> tuple[list[LegendRow], list[str], float]:
        """Return the legend rows below the net, the wrapped averages, and their total height.

        `head` is the height above the net, and `max_width` the maximum diameter of the net.
        """
        rows = self._arrange_in_rows(self.width - 2 * self.pad)
        lines = _wrap_texts(self.averages, self.font, self.width - 2 * self.pad)
        min_width = min((0.55 if self.net.compact else 0.4) * self.height, max_width)
        low = (len(rows) + len(lines) + len(caption_lines)) * self.row + self.pad
        # Assign space to the net first, then to the legend, then to the averages.
        while (len(rows) > 1 or lines) and self.height - head - low < min_width:
            if lines:
                lines = _limit_lines(lines, len(lines) - 1)
            else:
                rows.pop()
            low = (len(rows) + len(lines) + len(caption_lines)) * self.row + self.pad
        return rows, lines, low

    def _column_width(self, lines: list[str]) -> float:
        """Return the width of a legend beside the net, in which long texts are wrapped."""
        entries = [
            _SYMBOL_LETTERS * self.font + text_width(entry.text, self.font)
            for entry in self.entries
        ]
        widest = min(max(entries, default=0.0), _MAX_LEGEND_LETTERS * self.font)
        title = text_width(self.net.title[:40], 1.15 * self.font, "bold")
        texts = [*self.caption_lines, *lines, *self.bar_lines]
        return _HINTING_FACTOR * max(
            widest, title, *(text_width(text, self.font) for text in texts)
        )

    def _caption_height(self) -> float:
        """Return the height of the caption and the colour bar if the legend is beside the net."""
        caption_height = (self.rows_below + 1.0) * self.row
        if self.bar is None:
            return caption_height
        bar_text_height = (len(self.bar_lines) + 1.0) * self.row
        return caption_height + bar_height(self.bar, self.font, self.height) + bar_text_height

    @property
    def rows_below(self) -> int:
        """Number of text rows below the legend."""
        return len(self.caption_lines) + len(self.words)

    def _wrap(self, entry: NetLegendEntry, width: float) -> list[NetLegendEntry]:
        """Return the wrapped lines of a legend entry; on the screen, it remains a single line."""
        if self.net.compact:
            return [entry]
        line_width = (width - _SYMBOL_LETTERS * self.font) / _HINTING_FACTOR
        lines = wrap_text(entry.text, self.font, line_width)
        continuation = [
            NetLegendEntry(line, entry.color, is_continuation=True) for line in lines[1:]
        ]
        return [replace(entry, text=lines[0]), *continuation]

    def _arrange_in_column(self, width: float) -> list[LegendRow]:
        """Arrange legend entries below each other."""
        return [[(0.0, line)] for entry in self.entries for line in self._wrap(entry, width)]

    def _arrange_in_rows(self, width: float) -> list[LegendRow]:
        """Arrange legend entries side by side in rows."""
        rows: list[LegendRow] = []
        x = 0.0
        for entry in self.entries:
            required_width = _SYMBOL_LETTERS * self.font + _HINTING_FACTOR * text_width(
                entry.text, self.font
            )
            if rows and x + required_width <= width:
                rows[-1].append((x, entry))
            else:
                rows += [[(0.0, line)] for line in self._wrap(entry, width)]
                x = 0.0
            x += required_width + 1.6 * self.font
        return rows

    def to_page(self, vectors: FloatArray, *, flip: bool = True) -> FloatArray:
        """Return the positions (n, 2) of vectors (n, 3), in points."""
        position = nets.project(vectors, self.net.projection, flip=flip)
        return np.asarray(np.array([self.cx, self.cy]) + self.radius * position)

    def plot(self, x: Sequence[float], y: Sequence[float], **look: Any) -> None:
        """Draw a line or a symbol at positions in points."""
        from matplotlib.lines import Line2D

        self.axes.add_artist(Line2D(x, y, transform=self.points, clip_on=False, **look))

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
        half_height = 0.5 * self.font * size
        self.text_boxes.append((x_left, y - half_height, x_left + width, y + half_height))
        artist = self.axes.text(
            x,
            y,
            text,
            transform=self.points,
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

    def draw_north(self) -> None:
        self.text(
            self.cx,
            self.cy + self.radius + NORTH_HEIGHT_LETTERS * self.font,
            "N" if self.net.north else "y",
            align="center",
            weight="bold",
            size=NORTH_SIZE,
        )

    def draw_labels(self, outlines: Sequence[FloatArray]) -> None:
        """Label the means, the fold axis and the marks.

        Parameters
        ----------
        outlines : sequence of (k, 3) arrays
            Directions along curves that labels should avoid, besides the poles.
        """
        net, style = self.net, self.style
        labels = [(mean.line, mean.label) for mean in net.means]
        if net.fold is not None:
            text = f"β {format_attitude(net.fold.beta, net.fold.error95_deg)}"
            labels.append((net.fold.beta, text))
        labels += [(mark.line, mark.label) for mark in net.marks]
        curves = [*outlines, *(part for ellipse in net.ellipses for part in ellipse.outline())]
        obstacles = np.vstack(
            [
                self.to_page(np.vstack([np.zeros((0, 3)), *curves]), flip=False),
                *(self.to_page(set_.vectors()) for set_ in net.sets if net.poles and len(set_)),
            ]
        )
        marks = [self.to_page(line.vector())[0] for line, _ in labels]
        reserved_box = self._reserved_box()
        if reserved_box is not None:
            self.text_boxes.append(reserved_box)
        for mark, (_, text) in zip(marks, labels, strict=True):
            position = find_label_position(self, mark, text, obstacles, marks)
            if position is not None:
                self.text(*position, text, color=style.ink, halo=True)
                self._connect_label(mark)
        self.text_boxes = [box for box in self.text_boxes if box is not reserved_box]

    def _reserved_box(self) -> Box | None:
        """Return the area in which the screen shows the selected feature, or None in print."""
        if not self.net.compact:
            return None
        if self.net.brief:
            return (0.0, 0.0, self.width, self.pad + self.row)
        return (0.0, self.height - 2 * self.row, _MAX_CORNER_SHARE * self.width, self.height)

    def _connect_label(self, mark: FloatArray) -> None:
        """Connect the last text to its mark by a line if it is far from the mark."""
        x_left, y_low, x_right, y_high = self.text_boxes[-1]
        end = np.clip(mark, [x_left, y_low], [x_right, y_high])
        offsets = mark - end
        gap = float(np.hypot(*offsets))
        if gap > _MIN_CONNECTED_LETTERS * self.font:
            # Keep a distance from both, since the line would otherwise look like a minus sign.
            offsets *= 0.4 * self.font / gap
            self.plot(
                *np.array([end + offsets, mark - 1.5 * offsets]).T,
                color=self.style.soft,
                linewidth=self.style.line_pt,
                zorder=layer("means"),
                gid="to label",
            )

    def draw_legend(self) -> None:
        if self.net.title:
            available_width = (
                self.legend_width if self.is_legend_beside else self.width - 2 * self.pad
            )
            title = shorten_text(self.net.title, 1.15 * self.font, available_width, "bold")
            top = self.height - self.pad - 0.5 * self.row
            self.text(self.legend_x, top, title, weight="bold", size=1.15)
        if self.is_legend_beside:
            y = self.height - self.pad - 0.5 * self.row - self.heading
        else:
            y = self.pad + (len(self.rows) + self.rows_below - 0.5) * self.row
        step = self.row * (1.15 if self.is_legend_beside else 1.0)
        for row in self._shown_rows():
            for offset, entry in row:
                available_width = self.legend_width - offset - _SYMBOL_LETTERS * self.font
                text = shorten_text(entry.text, self.font, available_width / _HINTING_FACTOR)
                self._draw_legend_entry(offset, y, replace(entry, text=text))
            y -= step
        for i, line in enumerate([*self.words, *self.caption_lines]):
            y = self.pad + (self.rows_below - i - 0.5) * self.row
            text = shorten_text(line, self.font, self.legend_width)
            color = self.style.soft if i >= len(self.words) else self.style.ink
            if text:
                self.text(self.legend_x, y, text, color=color)

    def _shown_rows(self) -> list[LegendRow]:
        """Return the legend rows; the last entry states how many others do not fit, if any."""
        rows = self.rows
        shown_entries = [entry for row in rows for _, entry in row]
        if len(shown_entries) == sum(len(row) for row in self._all_rows()):
            return rows
        while len(rows) > 1 and rows[-1][-1][1].is_continuation:
            rows = rows[:-1]
        offset, last_entry = rows[-1][-1]
        shown_entries = [entry for row in rows for _, entry in row if not entry.is_continuation]
        text = tr("and {count} more", count=len(self.entries) - len(shown_entries) + 1)
        return [*rows[:-1], [*rows[-1][:-1], (offset, NetLegendEntry(text, last_entry.color))]]

    def _all_rows(self) -> list[LegendRow]:
        arrange = self._arrange_in_column if self.is_legend_beside else self._arrange_in_rows
        return arrange(self.legend_width)

    def _draw_legend_entry(self, offset: float, y: float, entry: NetLegendEntry) -> None:
        style = self.style
        x = self.legend_x + offset
        if entry.line is not None:
            self.plot(
                [x, x + 1.6 * self.font],
                [y, y],
                color=style.outline(entry.color),
                zorder=layer("legend"),
                linewidth=1.3 * style.line_pt,
                linestyle=entry.line,
            )
        if entry.marker is not None:
            marker_scale = 1.6 if entry.marker == "*" or entry.is_outlined else 1.1
            face, edge = entry.color, style.ink if entry.is_outlined else style.paper
            width = (1.4 if entry.is_outlined else 0.5) * style.line_pt
            if entry.symbol_set is not None:
                face, edge, width = style.symbol(entry.symbol_set)
                marker_scale = 1.1 * SYMBOL_SIZES.get(entry.marker, 1.0)
            self.plot(
                [x + 0.8 * self.font],
                [y],
                marker=entry.marker,
                zorder=layer("legend"),
                markersize=marker_scale * style.marker_pt,
                linestyle="none",
                markerfacecolor=face,
                markeredgecolor=edge,
                markeredgewidth=width,
            )
        self.text(x + _SYMBOL_LETTERS * self.font, y, entry.text)


def _describe_bar(plan: ContourPlan) -> list[str]:
    """Return the text of the colour bar for the caption below a net."""
    name = f"{plan.name}, {plan.subject}" if plan.subject else plan.name
    return [f"{name}; {plan.unit}"]


def _wrap_texts(texts: Sequence[str], font_pt: float, width: float) -> list[str]:
    """Wrap texts to a width."""
    return [line for text in texts for line in wrap_text(text, font_pt, width)]


def _limit_lines(lines: list[str], max_lines: int) -> list[str]:
    """Limit the number of lines of averages; the last line reports omissions.

    Returns an empty list if lines must be omitted and fewer than two are allowed.
    """
    if len(lines) <= max_lines:
        return lines
    return (
        [*lines[: max_lines - 1], tr("…: not enough space for all mean values")]
        if max_lines > 1
        else []
    )
