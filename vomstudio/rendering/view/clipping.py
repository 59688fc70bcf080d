"""The clipping box: along the axes of World, everything outside it is neither drawn nor picked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.rendering.view.blocks import box_range

Array = npt.NDArray[np.float64]

FACES = tuple((axis, side) for axis in range(3) for side in range(2))
"""(axis, 0 for the low or 1 for the high side), in the order of the handles."""

EDGES = tuple(
    (a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1
)  # fmt: skip
"""Pairs of rows of `ClipBox.corners`."""


@dataclass(frozen=True)
class ClipBox:
    """Corners in World, metres; low < high along each axis."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    @classmethod
    def around(cls, points: Array) -> ClipBox:
        """The box of World points (n, 3)."""
        low, high = points.min(axis=0), points.max(axis=0)
        flat = high - low < 1e-3
        low, high = np.where(flat, low - 0.5, low), np.where(flat, high + 0.5, high)
        return cls(_triple(low), _triple(high))

    def as_dict(self) -> dict[str, list[float]]:
        return {"low": list(self.low), "high": list(self.high)}

    @classmethod
    def from_dict(cls, values: Any) -> ClipBox:
        """Raises ValueError where it is none."""
        try:
            low, high = np.array(values["low"], float), np.array(values["high"], float)
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a clipping box: {values!r}") from error
        if low.shape != (3,) or high.shape != (3,) or not (low < high).all():
            raise ValueError(f"not a clipping box: {values!r}")
        return cls(_triple(low), _triple(high))

    def corners(self) -> Array:
        """(8, 3)."""
        both = np.array([self.low, self.high])
        return np.array([[both[k >> a & 1, a] for a in range(3)] for k in range(8)])

    def face_centre(self, axis: int, side: int) -> Array:
        centre: Array = (np.array(self.low) + np.array(self.high)) / 2.0
        centre[axis] = (self.low, self.high)[side][axis]
        return centre

    def with_face(self, axis: int, side: int, value: float) -> ClipBox:
        """One face elsewhere; it stays a hair before the face opposite."""
        low, high = list(self.low), list(self.high)
        hair = max(1e-3, 1e-3 * (high[axis] - low[axis]))
        if side:
            high[axis] = max(value, low[axis] + hair)
        else:
            low[axis] = min(value, high[axis] - hair)
        return ClipBox(_triple(np.array(low)), _triple(np.array(high)))

    def meets(self, other: ClipBox) -> bool:
        """Whether the boxes have a point in common."""
        mine, theirs = (self.low, self.high), (other.low, other.high)
        return bool(
            (np.array(mine[0]) <= theirs[1]).all() and (np.array(theirs[0]) <= mine[1]).all()
        )

    def holds(self, points: Array) -> npt.NDArray[np.bool_]:
        """Whether World points (n, 3) lie inside."""
        points = np.asarray(points, float).reshape(-1, 3)
        return np.asarray(((points >= self.low) & (points <= self.high)).all(axis=1))

    def meets_balls(self, centres: Array, radii: Array) -> npt.NDArray[np.bool_]:
        """Whether balls in World, (n, 3) and (n,), have a part inside."""
        off = np.maximum(np.maximum(self.low - centres, centres - self.high), 0.0)
        return np.asarray(np.einsum("ij,ij->i", off, off) <= radii * radii)

    def stretch(
        self, origin: Array, direction: Array, reach: float = 0.0
    ) -> tuple[float, float] | None:
        """From where to where a World ray is inside, or within `reach` along each axis, ahead of
        its origin; None where nowhere."""
        low, high = np.array([self.low]) - reach, np.array([self.high]) + reach
        enter, leave = box_range(low, high, origin, direction)
        first, last = max(float(enter[0]), 0.0), float(leave[0])
        return (first, last) if last >= first else None


def _triple(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


@dataclass(frozen=True, eq=False)
class Limits:
    """What picking may find on a ray through one model.

    first, last : depths along the ray in the model's local frame
    inside : which local points (n, 3) lie in the box
    """

    first: float
    last: float
    inside: Callable[[Array], npt.NDArray[np.bool_]]


def limits_for(
    box: ClipBox,
    origin: Array,
    direction: Array,
    to_world: Array,
    model_origin: Array,
    reach: float = 0.0,
) -> Limits | None:
    """Limits of a World ray for a model; None where the ray does not come within `reach` of the
    box."""
    stretch = box.stretch(origin, direction, reach)
    if stretch is None:
        return None
    scale = float(np.cbrt(abs(np.linalg.det(to_world[:3, :3])))) or 1.0

    def inside(local: Array) -> npt.NDArray[np.bool_]:
        return box.holds((local + model_origin) @ to_world[:3, :3].T + to_world[:3, 3])

    return Limits(stretch[0] / scale, stretch[1] / scale, inside)


def along_axis(origin: Array, direction: Array, through: Array, axis: int) -> float | None:
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
