"""What the colours and symbols on a sheet mean: an entry for each type, in columns on the page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.geology.map_symbols import strike_and_dip
from vomstudio.products.ortho.vector_drawing import INK, Shape
from vomstudio.words import tr

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

LETTER_MM = 0.19
"""Of a letter's mean width and of a point of its size."""
_ROW_MM, _ABOVE_MM = 5.2, 2.0
_GLYPH_MM, _GAP_MM = 7.0, 1.6
_LONGEST = 40
"""Letters of a name."""
_TICK_DEG = 35.0
"""Of the plane in the legend."""


@dataclass
class Entry:
    """name : of a type, rock or layer; line, area, place : whether something of it is drawn so;
    filled : the area is; dips : the place has the tick of a plane; mapped : it has the symbol of a
    map; overturned : that of an overturned bed, too"""

    name: str
    color: str
    line: bool = False
    area: bool = False
    place: bool = False
    filled: bool = False
    dips: bool = False
    mapped: bool = False
    overturned: bool = False


def entries_of(shapes: Sequence[Shape]) -> list[Entry]:
    """In the order in which they come first."""
    found: dict[tuple[str, str], Entry] = {}
    for shape in shapes:
        name = str(shape.values.get("kind") or shape.layer.replace("_", " "))
        entry = found.setdefault((name.casefold(), shape.color), Entry(name, shape.color))
        if len(shape.points) == 1:
            entry.place = True
            entry.dips |= shape.dip_deg is not None
            entry.mapped |= bool(shape.symbol)
            entry.overturned |= bool(shape.values.get("overturned"))
        elif shape.closed:
            entry.area = True
            entry.filled |= shape.filled
        else:
            entry.line = True
    return list(found.values())


class Legend:
    """Of entries in columns, for a page of this width; height_mm : 0 where there are none"""

    def __init__(self, entries: Sequence[Entry], width_mm: float, font_pt: float) -> None:
        self._font = font_pt
        self._entries = entries
        self._words = [_shortened(entry.name) for entry in entries]
        # As many as the entry with the most has, so that the names of a column begin together.
        self._slots = max((sum((e.line, e.area, e.place)) for e in entries), default=0)
        letters = max(map(len, self._words), default=0)
        self._wide = self._slots * (_GLYPH_MM + _GAP_MM) + LETTER_MM * font_pt * (letters + 4)
        self._columns = max(1, math.floor(width_mm / max(self._wide, 1.0)))
        self._rows = math.ceil(len(entries) / self._columns)
        self._remark = _remark(entries)
        rows = self._rows + bool(self._remark)
        self.height_mm = rows * _ROW_MM + _ABOVE_MM if entries else 0.0

    def draw(self, ax: Axes, left: float, top: float) -> None:
        """ax : of the page, in millimetres; left, top : of the legend"""
        top -= _ABOVE_MM
        for k, (entry, words) in enumerate(zip(self._entries, self._words, strict=True)):
            column, row = divmod(k, self._rows)
            x, y = left + column * self._wide, top - (row + 0.5) * _ROW_MM
            _draw_glyphs(ax, entry, x, y)
            self._write(ax, x + self._slots * (_GLYPH_MM + _GAP_MM), y, words)
        if self._remark:
            self._write(ax, left, top - (self._rows + 0.5) * _ROW_MM, self._remark)

    def _write(self, ax: Axes, x: float, y: float, words: str) -> None:
        ax.text(x, y, words, fontsize=self._font, color=INK, va="center", parse_math=False)


def _draw_glyphs(ax: Axes, entry: Entry, x: float, y: float) -> None:
    from matplotlib.patches import Rectangle

    for drawn, wanted in enumerate(
        form for form in ("line", "area", "place") if getattr(entry, form)
    ):
        left = x + drawn * (_GLYPH_MM + _GAP_MM)
        middle, right = left + 0.5 * _GLYPH_MM, left + _GLYPH_MM
        if wanted == "line":
            ax.plot([left, right], [y, y], color=entry.color, linewidth=1.2)
        elif wanted == "area":
            at = (left, y - 1.6)
            ax.add_patch(
                Rectangle(at, _GLYPH_MM, 3.2, fill=False, edgecolor=entry.color, linewidth=1.0)
            )
            if entry.filled:
                ax.add_patch(
                    Rectangle(at, _GLYPH_MM, 3.2, facecolor=entry.color, alpha=0.5, linewidth=0.0)
                )
        else:
            ax.plot([middle], [y], "o", markersize=3.0, color=entry.color)
            for line in _marks(entry):
                across, above = 0.45 * _GLYPH_MM * line.T
                ax.plot(middle + across, y + above, color=entry.color, linewidth=0.9)


def _marks(entry: Entry) -> list[Array]:
    """Polylines (k, 2) about a place."""
    if entry.mapped:
        symbol = strike_and_dip(np.zeros(3), 180.0, 45.0, 2.0)
        return [line[:, :2] for line in symbol]
    if not entry.dips:
        return []
    a = math.radians(_TICK_DEG)
    across = np.array([math.cos(a), -math.sin(a)])
    return [np.stack([-across, across])]


def _remark(entries: Sequence[Entry]) -> str:
    if any(entry.overturned for entry in entries):
        return tr("Symbols at points: strike and true dip of planes; with a hook: overturned beds")
    if any(entry.mapped for entry in entries):
        return tr("Symbols at points: strike and true dip of planes")
    if any(entry.dips for entry in entries):
        return tr("Ticks at points: planes and their apparent dips")
    return ""


def _shortened(name: str) -> str:
    return name if len(name) <= _LONGEST else name[: _LONGEST - 1].rstrip() + "…"
