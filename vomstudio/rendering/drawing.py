"""What the viewport is told to draw for one feature: plain data in World, no Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.tools.types import Area


@dataclass(frozen=True, eq=False)
class FeatureDrawing:
    """One feature of the document as the viewport draws it.

    id : the record's id, given back by `Viewport.pick_feature`
    line : (k, 3) float64 World vertices joined in order; k may be 0
    disc : (c, 3) float64 World corners of a convex ring, drawn translucent, or None
    color : RGB 0..1
    label : text beside the anchor, empty for none
    anchor : (3,) World point the label belongs to
    visible : False keeps it registered but draws nothing
    area : the piece of the surface that it is, drawn translucent over it, or None
    """

    id: str
    line: npt.NDArray[np.float64]
    disc: npt.NDArray[np.float64] | None
    color: tuple[float, float, float]
    label: str
    anchor: npt.NDArray[np.float64]
    visible: bool = True
    area: Area | None = None
