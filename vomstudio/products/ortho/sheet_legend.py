"""Legend of a sheet, with an entry for each feature type, arranged in columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from vomstudio.products.ortho.legend_entries import LegendEntry, explain_symbols
from vomstudio.products.ortho.vector_drawing import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LETTER_MM = 0.19
"""Mean width of a letter per point of font size, mm."""
_ROW_MM, _TOP_MARGIN_MM = 5.2, 2.0
_GLYPH_MM, _GAP_MM = 7.0, 1.6


class SheetLegend:
    """Legend in columns for a page width; `height_mm` is 0 if there are no entries."""

    def __init__(self, entries: Sequence[LegendEntry], width_mm: float, font_pt: float) -> None:
        self._font_pt = font_pt
        self._entries = entries
        self._names = [entry.short_name for entry in entries]
        # Reserve space for the entry with the most glyphs, so that the names in a column are
        # aligned.
        self._glyph_slots = max(
            (sum((entry.line, entry.area, entry.place)) for entry in entries), default=0
        )
        max_length = max(map(len, self._names), default=0)
        self._column_width_mm = self._glyph_slots * (_GLYPH_MM + _GAP_MM) + LETTER_MM * font_pt * (
            max_length + 4
        )
        self._columns = max(1, math.floor(width_mm / max(self._column_width_mm, 1.0)))
        self._rows = math.ceil(len(entries) / self._columns)
        self._remark = explain_symbols(entries)
        rows = self._rows + bool(self._remark)
        self.height_mm = rows * _ROW_MM + _TOP_MARGIN_MM if entries else 0.0

    def draw(self, ax: Axes, left: float, top: float) -> None:
        """Draw the legend on the axes of the page; `left` and `top` are its position in mm."""
        top -= _TOP_MARGIN_MM
        for k, (entry, texts) in enumerate(zip(self._entries, self._names, strict=True)):
            column, row = divmod(k, self._rows)
            x, y = left + column * self._column_width_mm, top - (row + 0.5) * _ROW_MM
            _draw_glyphs(ax, entry, x, y)
            self._write(ax, x + self._glyph_slots * (_GLYPH_MM + _GAP_MM), y, texts)
        if self._remark:
            self._write(ax, left, top - (self._rows + 0.5) * _ROW_MM, self._remark)

    def _write(self, ax: Axes, x: float, y: float, text: str) -> None:
        ax.text(x, y, text, fontsize=self._font_pt, color=INK, va="center", parse_math=False)


def _draw_glyphs(ax: Axes, entry: LegendEntry, x: float, y: float) -> None:
    from matplotlib.patches import Rectangle

    for position, form in enumerate(
        name for name in ("line", "area", "place") if getattr(entry, name)
    ):
        x_left = x + position * (_GLYPH_MM + _GAP_MM)
        centre, x_right = x_left + 0.5 * _GLYPH_MM, x_left + _GLYPH_MM
        if form == "line":
            ax.plot([x_left, x_right], [y, y], color=entry.color, linewidth=1.2)
        elif form == "area":
            corner = (x_left, y - 1.6)
            ax.add_patch(
                Rectangle(corner, _GLYPH_MM, 3.2, fill=False, edgecolor=entry.color, linewidth=1.0)
            )
            if entry.is_filled:
                ax.add_patch(
                    Rectangle(
                        corner,
                        _GLYPH_MM,
                        3.2,
                        facecolor=entry.color,
                        alpha=0.5,
                        linewidth=0.0,
                    )
                )
        else:
            ax.plot([centre], [y], "o", markersize=3.0, color=entry.color)
            for line in entry.marks():
                horizontal_component, vertical_component = 0.45 * _GLYPH_MM * line.T
                ax.plot(
                    centre + horizontal_component,
                    y + vertical_component,
                    color=entry.color,
                    linewidth=0.9,
                )
