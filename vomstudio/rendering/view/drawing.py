"""What the viewport is told to draw for one feature: plain data in World, no Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.arrays import FloatArray
from vomstudio.studio.tools.interaction_types import Area

SymbolKind = Literal["plane", "overturned", "vertical", "horizontal", "line", "disc"]

PREVIEW = "preview:"
"""So begin the ids of models that are shown until others are there, and never picked."""


@dataclass(frozen=True, eq=False)
class Symbol:
    """The attitude of a feature as a sign of constant size on the screen.

    kind : "plane" strike line with a tick down the dip, "overturned" the same with a hook,
        "vertical" a tick either way, "horizontal" a cross in a circle, "line" an arrow down the
        plunge, "disc" a dot that stands for a disc too small to be seen
    place : (3,) World, where it lies
    along : (3,) unit vector, the strike of a plane or the direction of a line; 0 for a dot
    across : (3,) unit vector in the plane at right angles to `along`, downwards; 0 where it is none
    text : the dip or plunge beside it, empty for none
    extent : m, of the feature
    """

    kind: SymbolKind
    place: FloatArray
    along: FloatArray
    across: FloatArray
    text: str
    extent: float


@dataclass(frozen=True, eq=False)
class FeatureDrawing:
    """One feature of the document as the viewport draws it.

    id : the record's id, given back by `FeaturesShown.at`
    line : (k, 3) float64 World vertices joined in order; k may be 0
    disc : (c, 3) float64 World corners of a convex ring, drawn translucent, or None
    color : RGB 0..1
    label : text beside the anchor, empty for none
    anchor : (3,) World point the label belongs to
    visible : False keeps it registered but draws nothing
    area : the piece of the surface that it is, drawn translucent over it, or None
    symbol : its sign, or None
    extent : m; larger features get their labels first
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
