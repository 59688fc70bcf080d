"""Layers of points, lines and rings with attributes, independent of the file format."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from vomstudio.core.arrays import AnyArray, FloatArray


@dataclass(frozen=True, eq=False)
class Layer:
    """Layer of features with attributes.

    Parameters
    ----------
    name : str
    kind : {"point", "line", "ring"}
    shapes : list of (n, 3) float64
        Points of each feature; n = 1 for a point feature. A ring does not repeat its first point.
    columns : dict of str to (m,) array
        One value per feature for each column.
    main, by
        As for `project.kind.GisLayer`.
    colors : sequence of str
        Colour of each feature as "#rrggbb" or ""; empty for points of orientations.
    """

    name: str
    kind: Literal["point", "line", "ring"]
    shapes: list[FloatArray]
    columns: dict[str, AnyArray]
    main: bool = False
    by: str = "kind"
    colors: Sequence[str] = ()

    @property
    def classes(self) -> list[str]:
        """Class of each feature, which determines its colour; "" if the layer has no classes."""
        return [str(word) for word in self.columns.get(self.by, [""] * len(self.shapes))]

    def colors_by_class(self, types: Mapping[str, str], default: str) -> dict[str, str]:
        """Return the colours of the classes.

        Parameters
        ----------
        types : mapping of str to str
            Colours of feature types by their names in lower case.
        default : str
            Colour of other classes.
        """
        if self.by == "kind":
            return {word: types.get(word.casefold(), default) for word in self.classes}
        class_colors = zip(self.classes, self.colors, strict=True)
        return {word: color or default for word, color in class_colors}
