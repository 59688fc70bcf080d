"""Layers of points, lines and rings with attributes, whatever the format of their file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from vomstudio.core.arrays import AnyArray, FloatArray


@dataclass(frozen=True, eq=False)
class Layer:
    """shapes : one (n, 3) float64 array per feature; of a point n = 1, of a ring the first point is
    not repeated at the end. columns : one value per feature, by name. main, by : as in
    `project.kind.GisLayer`.
    colors : of each feature, "#rrggbb" or ""; none for the points of orientations"""

    name: str
    kind: Literal["point", "line", "ring"]
    shapes: list[FloatArray]
    columns: dict[str, AnyArray]
    main: bool = False
    by: str = "kind"
    colors: Sequence[str] = ()

    @property
    def classes(self) -> list[str]:
        """By what features have their colours; empty words where the layer does not say."""
        return [str(word) for word in self.columns.get(self.by, [""] * len(self.shapes))]

    def colors_of(self, types: Mapping[str, str], otherwise: str) -> dict[str, str]:
        """The colour of each class. types : of the feature types, by their names in lower case."""
        if self.by == "kind":
            return {word: types.get(word.casefold(), otherwise) for word in self.classes}
        own = zip(self.classes, self.colors, strict=True)
        return {word: color or otherwise for word, color in own}
