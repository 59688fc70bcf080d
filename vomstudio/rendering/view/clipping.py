"""Clipping box along the World axes, outside which nothing is drawn or picked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.boxes import BOX_EDGES, BOX_FACES, ClipBox

__all__ = ["BOX_EDGES", "BOX_FACES", "ClipBox", "PickLimits", "along_axis", "find_pick_limits"]


@dataclass(frozen=True, eq=False)
class PickLimits:
    """Limits of picking on a ray through one model.

    Parameters
    ----------
    first, last : float
        Permitted range of depths along the ray, in the local frame of the model.
    inside : callable
        Function that returns which points (n, 3) of the local frame are inside the box.
    """

    first: float
    last: float
    inside: Callable[[FloatArray], BoolArray]


def find_pick_limits(
    box: ClipBox,
    origin: FloatArray,
    direction: FloatArray,
    to_world: FloatArray,
    model_origin: FloatArray,
    max_distance: float = 0.0,
) -> PickLimits | None:
    """Return the picking limits on a World ray, or None if it misses the box."""
    depth_range = box.ray_range(origin, direction, max_distance)
    if depth_range is None:
        return None
    scale = float(np.cbrt(abs(np.linalg.det(to_world[:3, :3])))) or 1.0

    def inside(local_points: FloatArray) -> BoolArray:
        return box.contains((local_points + model_origin) @ to_world[:3, :3].T + to_world[:3, 3])

    return PickLimits(depth_range[0] / scale, depth_range[1] / scale, inside)


def along_axis(
    origin: FloatArray, direction: FloatArray, passing_point: FloatArray, axis: int
) -> float | None:
    """Return the coordinate on an axis-parallel line of the point nearest to a ray.

    The result is None if the ray is nearly parallel to the line.
    """
    line_direction = np.zeros(3)
    line_direction[axis] = 1.0
    cos = float(direction @ line_direction)
    sin_squared = 1.0 - cos * cos
    if sin_squared < 1e-3:
        return None
    gap = passing_point - origin
    shift = (cos * float(gap @ direction) - float(gap @ line_direction)) / sin_squared
    return float(passing_point[axis] + shift)
