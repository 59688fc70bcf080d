"""Drawing of a feature as plain data in the World frame, independent of Qt and VTK."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.arrays import FloatArray
from vomstudio.studio.tools.interaction_types import Area

SymbolKind = Literal["plane", "overturned", "vertical", "horizontal", "line", "disc"]

PREVIEW = "preview:"
"""Prefix of the ids of model previews, which are later replaced by the models and never picked."""


@dataclass(frozen=True, eq=False)
class Symbol:
    """Attitude of a feature as a symbol of constant size on the screen.

    Parameters
    ----------
    kind : SymbolKind
        "plane" is a strike line with a tick in the dip direction, "overturned" the same with a
        hook, "vertical" a strike line with ticks on both sides, "horizontal" a cross in a
        circle, "line" an arrow in the plunge direction, and "disc" a dot for a disc that is too
        small to be visible.
    place : (3,) float64
        Position in the World frame.
    long_axis : (3,) float64
        Unit vector along the strike of a plane or along a line; 0 for a dot.
    cross_axis : (3,) float64
        Unit vector in the plane pointing down the dip, perpendicular to `long_axis`; 0 if
        undefined.
    text : str
        Dip or plunge as text, or "" for no number.
    extent : float
        Extent of the feature, metres.
    """

    kind: SymbolKind
    place: FloatArray
    long_axis: FloatArray
    cross_axis: FloatArray
    text: str
    extent: float


@dataclass(frozen=True, eq=False)
class FeatureDrawing:
    """Feature of the project as drawn by the viewport.

    Parameters
    ----------
    id : str
        Id of the record, as returned by `ShownFeatures.at`.
    line : (k, 3) float64
        Vertices of a polyline in the World frame; k may be 0.
    disc : (c, 3) float64 or None
        Corners of a convex polygon in the World frame, which is drawn translucently.
    color : tuple of float
        RGB colour, each component from 0 to 1.
    label : str
        Text of the label beside the anchor, or "" for no label.
    anchor : (3,) float64
        Position of the label in the World frame.
    visible : bool
        Whether the feature is drawn.
    area : Area, optional
        Part of the surface that is drawn translucently.
    symbol : Symbol, optional
    extent : float
        Extent of the feature in metres; larger features are labelled first.
    verdict : str or None
        Verdict whose mark follows the text of the label.
    is_outlined : bool
        Whether the disc is drawn as its outline only, as for poor planes.
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
    verdict: str | None = None
    is_outlined: bool = False
