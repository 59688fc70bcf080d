"""Axis-aligned boxes in the World frame, and their intersections with rays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.results import Result
from vomstudio.geometry.coordinate_limits import find_invalid_points

BOX_FACES = tuple((axis, side) for axis in range(3) for side in range(2))
"""Faces as (axis, 0 for the lower or 1 for the upper side), in the order of the handles."""

BOX_EDGES = tuple((a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1)
"""Pairs of rows of `ClipBox.corners`."""


@dataclass(frozen=True)
class ClipBox(Result):
    """Axis-aligned box in the World frame, m, with low < high along each axis."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    @classmethod
    def from_points(cls, points: FloatArray) -> ClipBox:
        """Return the bounding box of points (n, 3) in the World frame.

        An axis along which the points do not differ receives a size of 1 m.
        """
        low, high = points.min(axis=0), points.max(axis=0)
        is_flat = high - low < 1e-3
        low, high = np.where(is_flat, low - 0.5, low), np.where(is_flat, high + 0.5, high)
        return cls(_triple(low), _triple(high))

    @classmethod
    def from_dict(cls, values: Any) -> ClipBox:
        """Read a box from a dictionary.

        Raises
        ------
        ValueError
            If the values are not a valid box.
        """
        try:
            low, high = np.array(values["low"], float), np.array(values["high"], float)
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"not a clipping box: {values!r}") from error
        if low.shape != (3,) or high.shape != (3,) or not (low < high).all():
            raise ValueError(f"not a clipping box: {values!r}")
        if find_invalid_points(np.stack([low, high])).any():
            raise ValueError(f"not a clipping box: {values!r}")
        return cls(_triple(low), _triple(high))

    def corners(self) -> FloatArray:
        """Return the corners (8, 3)."""
        ends = np.array([self.low, self.high])
        return np.array([[ends[k >> a & 1, a] for a in range(3)] for k in range(8)])

    def face_centre(self, axis: int, side: int) -> FloatArray:
        centre: FloatArray = (np.array(self.low) + np.array(self.high)) / 2.0
        centre[axis] = (self.low, self.high)[side][axis]
        return centre

    def move_face(self, axis: int, side: int, value: float) -> ClipBox:
        """Move one face, keeping a minimum distance from the opposite face."""
        low, high = list(self.low), list(self.high)
        min_thickness = max(1e-3, 1e-3 * (high[axis] - low[axis]))
        if side:
            high[axis] = max(value, low[axis] + min_thickness)
        else:
            low[axis] = min(value, high[axis] - min_thickness)
        return ClipBox(_triple(np.array(low)), _triple(np.array(high)))

    def intersects_box(self, other_box: ClipBox) -> bool:
        """Return whether the boxes have a point in common."""
        limits, other_limits = (self.low, self.high), (other_box.low, other_box.high)
        return bool(
            (np.array(limits[0]) <= other_limits[1]).all()
            and (np.array(other_limits[0]) <= limits[1]).all()
        )

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which World points (n, 3) are inside the box."""
        points = np.asarray(points, float).reshape(-1, 3)
        return np.asarray(((points >= self.low) & (points <= self.high)).all(axis=1))

    def intersects_balls(self, centres: FloatArray, radii: FloatArray) -> BoolArray:
        """Return which balls, with World centres (n, 3) and radii (n,), intersect the box."""
        offset = np.maximum(np.maximum(self.low - centres, centres - self.high), 0.0)
        return np.asarray(np.einsum("ij,ij->i", offset, offset) <= radii * radii)

    def ray_range(
        self, origin: FloatArray, direction: FloatArray, max_distance: float = 0.0
    ) -> tuple[float, float] | None:
        """Return the range of a World ray inside the box, or None if it misses the box.

        The range is in multiples of the length of `direction`. `max_distance` enlarges the box
        along each axis.
        """
        low, high = np.array([self.low]) - max_distance, np.array([self.high]) + max_distance
        entry, exit_ = box_range(low, high, origin, direction)
        entry_distance, exit_distance = max(float(entry[0]), 0.0), float(exit_[0])
        return (entry_distance, exit_distance) if exit_distance >= entry_distance else None


def _triple(values: FloatArray) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


def box_range(
    low: FloatArray, high: FloatArray, origin: FloatArray, direction: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the distances at which a ray enters and leaves boxes (n, 3).

    The ray misses a box if `leave` is less than `enter`, or if `leave` is negative because the
    box is behind its origin.

    Parameters
    ----------
    low, high : (n, 3) ndarray
        Corners of the boxes.
    origin, direction : (3,) ndarray
        Ray.

    Returns
    -------
    enter, leave : (n,) ndarray
        In multiples of the length of `direction`.
    """
    entries, exits = np.full(len(low), -np.inf), np.full(len(low), np.inf)
    # Column by column: a reduction along rows of three is four times slower.
    for k, (start, slope) in enumerate(zip(origin.tolist(), direction.tolist(), strict=True)):
        if abs(slope) < 1e-200:
            is_outside = (low[:, k] > start) | (high[:, k] < start)
            entries[is_outside] = np.inf
        else:
            a, b = (low[:, k] - start) / slope, (high[:, k] - start) / slope
            np.maximum(entries, np.minimum(a, b), out=entries)
            np.minimum(exits, np.maximum(a, b), out=exits)
    return entries, exits


def is_box_hit(
    low: FloatArray, high: FloatArray, origin: FloatArray, direction: FloatArray, pad: float = 0.0
) -> bool:
    """Return whether a ray meets one box (3,), enlarged by `pad`, ahead of its origin.

    Plain numbers are ten times faster than NumPy for a single box.

    Parameters
    ----------
    low, high : (3,) ndarray
        Corners of the box.
    origin, direction : (3,) ndarray
        Ray.
    pad : float, optional
        Added to each side.

    Returns
    -------
    bool
    """
    entry, exit_ = 0.0, math.inf
    sides = zip(low.tolist(), high.tolist(), origin.tolist(), direction.tolist(), strict=True)
    for minimum, maximum, start, slope in sides:
        minimum, maximum = minimum - pad, maximum + pad
        if abs(slope) < 1e-200:
            if not minimum <= start <= maximum:
                return False
            continue
        near_distance, far_distance = (minimum - start) / slope, (maximum - start) / slope
        if near_distance > far_distance:
            near_distance, far_distance = far_distance, near_distance
        entry, exit_ = max(entry, near_distance), min(exit_, far_distance)
    return exit_ >= entry


def are_boxes_hit(
    low: FloatArray, high: FloatArray, origin: FloatArray, direction: FloatArray
) -> BoolArray:
    """Return which boxes (n, 3) a ray meets ahead of its origin.

    Parameters
    ----------
    low, high : (n, 3) ndarray
        Corners of the boxes.
    origin, direction : (3,) ndarray
        Ray.

    Returns
    -------
    (n,) ndarray of bool
    """
    entries, exits = box_range(low, high, origin, direction)
    return np.asarray(exits >= np.maximum(entries, 0.0))
