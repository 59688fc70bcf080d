"""View frames (right, down and depth) of orthographic images.

d is the view direction, right = d x U, down = d x right; U is World up, or North within 0.1 degree
of vertical views. Image columns run along right, rows along down, and depth increases along d. All
values are float64, because UTM northings exceed the precision of float32.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding

MIN_STEEP_DEG = 89.9
"""Minimum plunge of a view, up or down, for which the top of the image is North."""

ROUNDING_DEG = 1e-9


@dataclass(frozen=True, eq=False)
class ViewFrame:
    """Three unit vectors (3,) in the World frame; `right` and `down` span the image.

    `direction` points into the image.
    """

    right: FloatArray
    down: FloatArray
    direction: FloatArray

    @classmethod
    def from_direction(cls, direction: npt.ArrayLike) -> ViewFrame:
        """Return the frame of a viewer who looks along `direction` (3,).

        Raises
        ------
        GeometryError
            If the direction is zero or not finite.
        """
        d = np.asarray(direction, np.float64).reshape(3)
        length = float(np.linalg.norm(d))
        if not np.isfinite(length) or length == 0.0:
            raise GeometryError(Finding("vector.invalid", name="view direction"))
        d = d / length + 0.0
        plunge = np.degrees(np.arctan2(-d[2], np.hypot(d[0], d[1])))
        is_steep = abs(plunge) >= MIN_STEEP_DEG - ROUNDING_DEG
        up = np.array([0.0, 1.0, 0.0] if is_steep else [0.0, 0.0, 1.0])
        right = np.cross(d, up)
        right = right / np.linalg.norm(right) + 0.0
        down = np.cross(d, right)
        return cls(right, down / np.linalg.norm(down) + 0.0, d)

    @property
    def axes(self) -> FloatArray:
        """Matrix (3, 3) with the columns right, down and direction."""
        return np.stack([self.right, self.down, self.direction], axis=1)

    @property
    def is_vertical(self) -> bool:
        """Whether the view is vertical, so that each pixel has one map position at any depth."""
        return bool(np.hypot(self.direction[0], self.direction[1]) < 1e-12)

    def to_view(self, points: npt.ArrayLike, reference: npt.ArrayLike) -> FloatArray:
        """Return World points (n, 3) in metres right of, below and behind a reference (3,)."""
        p = np.asarray(points, np.float64).reshape(-1, 3)
        return (p - np.asarray(reference, np.float64)) @ self.axes

    def pixel_to_world(
        self, gsd: float, reference: npt.ArrayLike, left: float, top: float
    ) -> FloatArray:
        """Return the matrix (4, 4) that transforms (column, row, depth, 1) to World.

        `gsd` is in metres per pixel. `left` and `top` are the distances of the outer corner of the
        top left pixel to the right of and below `reference`, in metres. Depth is 0 on the plane
        through `reference`.
        """
        matrix = np.eye(4)
        matrix[:3, 0] = self.right * gsd
        matrix[:3, 1] = self.down * gsd
        matrix[:3, 2] = self.direction
        corner = self.right * left + self.down * top
        matrix[:3, 3] = np.asarray(reference, np.float64) + corner
        return matrix
