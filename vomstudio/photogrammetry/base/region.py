"""Region of a scene to reconstruct, a box in the frame of the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.base.scene import SparseScene

MIN_POINTS = 5
"""Minimum number of tie points in the region for a photo to get a depth map."""


@dataclass(frozen=True)
class Region:
    """Box given by two corners, in the World frame or the frame of an unregistered model."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    @classmethod
    def of(cls, numbers: Sequence[float] | None) -> Region | None:
        """Create a region from x0, y0, z0, x1, y1, z1, or return None if `numbers` is None.

        Raises UsageError if the region is invalid.
        """
        if numbers is None:
            return None
        values = [float(v) for v in numbers]
        if len(values) != 6 or not all(map(math.isfinite, values)):
            raise UsageError(
                Finding("region.not-a-box"),
                field="--region",
            )
        low, high = tuple(values[:3]), tuple(values[3:])
        if not all(a < b for a, b in zip(low, high, strict=True)):
            raise UsageError(
                Finding("region.empty"),
                field="--region",
            )
        return cls((low[0], low[1], low[2]), (high[0], high[1], high[2]))

    def contains(self, points: npt.ArrayLike, origin: npt.ArrayLike) -> BoolArray:
        """Return a mask (n,) of the points (n, 3), relative to `origin`, that lie in the region."""
        positions = np.asarray(points, np.float64)
        low, high = (np.asarray(end) - np.asarray(origin) for end in (self.low, self.high))
        return np.asarray(((positions >= low) & (positions <= high)).all(axis=1))

    def select_region_views(self, scene: SparseScene) -> frozenset[int]:
        """Return the photos (rows) that see at least `MIN_POINTS` tie points in the region.

        Raises GeometryError if there are fewer than two.
        """
        is_inside = self.contains(scene.points, scene.origin)
        is_inside_observation = np.repeat(is_inside, np.diff(scene.track_offsets))
        counts = np.bincount(scene.track_views[is_inside_observation], minlength=len(scene.views))
        views = frozenset(np.flatnonzero(counts >= MIN_POINTS).tolist())
        if len(views) < 2:
            positions = scene.points + np.asarray(scene.origin, np.float64)
            frame = tr("local frame") if scene.crs is None else scene.crs
            ends = [] if not len(positions) else [*positions.min(axis=0), *positions.max(axis=0)]
            raise GeometryError(
                Finding(
                    "region.few-points",
                    points=int(is_inside.sum()),
                    bounds=",".join(f"{v:.1f}" for v in ends),
                    frame=frame,
                ),
                field="--region",
            )
        return views
