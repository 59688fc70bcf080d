"""Drawing of a feature as plain data in World; no Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.arrays import FloatArray
from vomstudio.studio.tools.interaction_types import Area

SymbolKind = Literal["plane", "overturned", "vertical", "horizontal", "line", "disc"]

PREVIEW = "preview:"
"""Prefix of the ids of previews, which are replaced by models and never picked."""


@dataclass(frozen=True, eq=False)
class Symbol:
    """Attitude of a feature as a symbol of constant size on the screen.

    Parameters
    ----------
    kind : SymbolKind
        "plane" strike line with a tick down the dip, "overturned" the same with a hook,
        "vertical" a tick either way, "horizontal" a cross in a circle, "line" an arrow down the
        plunge, "disc" a dot for a disc that is too small to be seen.
    place : (3,) float64
        World position.
    along : (3,) float64
        Unit vector of the strike of a plane or the direction of a line, 0 for a dot.
    across : (3,) float64
        Downward unit vector in the plane, perpendicular to `along`; 0 if undefined.
    text : str
        Dip or plunge, "" for none.
    extent : float
        Extent of the feature, metres.
    """

    kind: SymbolKind
    place: FloatArray
    along: FloatArray
    across: FloatArray
    text: str
    extent: float


@dataclass(frozen=True, eq=False)
class FeatureDrawing:
    """Feature of the document as the viewport draws it.

    Parameters
    ----------
    id : str
        Id of the record, which `ShownFeatures.at` returns.
    line : (k, 3) float64
        World vertices joined in order; k may be 0.
    disc : (c, 3) float64 or None
        World corners of a convex ring, drawn translucent.
    color : tuple of float
        RGB, 0 to 1.
    label : str
        Text beside the anchor, "" for none.
    anchor : (3,) float64
        World point of the label.
    visible : bool
        Whether it is drawn.
    area : Area, optional
        Part of the surface, drawn translucent over it.
    symbol : Symbol, optional
    extent : float
        Metres; larger features get their labels first.
    """

    id: str
    line: FloatArray
    disc: FloatArray | None
    color: tuple[float, float, float]
    label: str
    anchor: FloatArray
    visible: bool = True
    area: Area | None = None
    symbol: Symbol | None = None
    extent: float = 0.0
