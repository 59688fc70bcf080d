"""The clipping box: along the axes of World, everything outside it is neither drawn nor picked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.boxes import EDGES, FACES, ClipBox

__all__ = ["EDGES", "FACES", "ClipBox", "Limits", "along_axis", "limits_for"]


@dataclass(frozen=True, eq=False)
class Limits:
    """What picking may find on a ray through one model.

    first, last : depths along the ray in the model's local frame
    inside : which local points (n, 3) lie in the box
    """

    first: float
    last: float
    inside: Callable[[FloatArray], BoolArray]


def limits_for(
    box: ClipBox,
    origin: FloatArray,
    direction: FloatArray,
    to_world: FloatArray,
    model_origin: FloatArray,
    reach: float = 0.0,
) -> Limits | None:
    """Limits of a World ray for a model; None where the ray does not come within `reach` of the
    box."""
    stretch = box.stretch(origin, direction, reach)
    if stretch is None:
        return None
    scale = float(np.cbrt(abs(np.linalg.det(to_world[:3, :3])))) or 1.0

    def inside(local: FloatArray) -> BoolArray:
        return box.holds((local + model_origin) @ to_world[:3, :3].T + to_world[:3, 3])

    return Limits(stretch[0] / scale, stretch[1] / scale, inside)


def along_axis(
    origin: FloatArray, direction: FloatArray, through: FloatArray, axis: int
) -> float | None:
    """Coordinate of the point of an axis-parallel line that is nearest to a ray; None where the
    ray runs along it."""
    along = np.zeros(3)
    along[axis] = 1.0
    cos = float(direction @ along)
    sin2 = 1.0 - cos * cos
    if sin2 < 1e-3:
        return None
    gap = through - origin
    shift = (cos * float(gap @ direction) - float(gap @ along)) / sin2
    return float(through[axis] + shift)
