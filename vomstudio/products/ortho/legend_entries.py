"""Legend entries of a drawing: feature types with their colours and symbols."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.map_symbols import strike_and_dip_symbol

MAX_LETTERS = 40
EXAMPLE_DIP_DEG = 35.0
"""Dip of the example plane that the legend shows."""


class LegendShape(Protocol):
    """Properties of a shape (`vector_drawing.DrawingShape`) that a legend needs."""

    @property
    def layer(self) -> str: ...
    @property
    def points(self) -> FloatArray: ...
    @property
    def color(self) -> str: ...
    @property
    def is_closed(self) -> bool: ...
    @property
    def is_filled(self) -> bool: ...
    @property
    def dip_deg(self) -> float | None: ...
    @property
    def symbol(self) -> tuple[FloatArray, ...]: ...
    @property
    def values(self) -> Mapping[str, Any]: ...
    @property
    def legend(self) -> str: ...


@dataclass
class LegendEntry:
    """Entry of a legend.

    Parameters
    ----------
    name : str
        Name of a feature type, lithology or layer.
    color : str
    line, area, place : bool
        Whether its features are drawn as lines, areas or point symbols.
    is_filled : bool
        Whether the areas are filled.
    dips : bool
        Whether the point symbols have the tick of a plane.
    has_map_symbol, overturned : bool
        Whether the point symbols are map symbols, and map symbols of overturned beds.
    """

    name: str
    color: str
    line: bool = False
    area: bool = False
    place: bool = False
    is_filled: bool = False
    dips: bool = False
    has_map_symbol: bool = False
    overturned: bool = False

    @property
    def short_name(self) -> str:
        """Name shortened to `MAX_LETTERS`."""
        name = self.name
        return name if len(name) <= MAX_LETTERS else name[: MAX_LETTERS - 1].rstrip() + "…"

    def marks(self) -> list[FloatArray]:
        """Return the polylines (k, 2) of the point symbol, right and up within -1 to 1."""
        if self.has_map_symbol:
            symbol = strike_and_dip_symbol(np.zeros(3), 180.0, 45.0, 2.0)
            return [line[:, :2] for line in symbol]
        if not self.dips:
            return []
        a = math.radians(EXAMPLE_DIP_DEG)
        tick_direction = np.array([math.cos(a), -math.sin(a)])
        return [np.stack([-tick_direction, tick_direction])]


def create_entries(shapes: Sequence[LegendShape]) -> list[LegendEntry]:
    """Return one entry per feature type and colour, in the order of the shapes."""
    entries: dict[tuple[str, str], LegendEntry] = {}
    for shape in shapes:
        name = shape.legend or str(shape.values.get("kind") or shape.layer.replace("_", " "))
        entry = entries.setdefault((name.casefold(), shape.color), LegendEntry(name, shape.color))
        if len(shape.points) == 1:
            entry.place = True
            entry.dips |= shape.dip_deg is not None
            entry.has_map_symbol |= bool(shape.symbol)
            entry.overturned |= bool(shape.values.get("overturned"))
        elif shape.is_closed:
            entry.area = True
            entry.is_filled |= shape.is_filled
        else:
            entry.line = True
    return list(entries.values())


def explain_symbols(entries: Sequence[LegendEntry]) -> str:
    """Explain the ticks and symbols of the entries; empty if they have neither."""
    if any(entry.overturned for entry in entries):
        return tr("Symbols at points: strike and true dip of planes; with a hook: overturned beds")
    if any(entry.has_map_symbol for entry in entries):
        return tr("Symbols at points: strike and true dip of planes")
    if any(entry.dips for entry in entries):
        return tr("Ticks at points: planes with their apparent dips")
    return ""
