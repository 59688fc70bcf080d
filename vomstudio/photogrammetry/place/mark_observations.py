"""Image marks of each point, matched to the photos of a scene by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.triangulation import triangulate
from vomstudio.io.control.points import Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.registration.marks.mark_errors import Marks, place_covariance

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointMarks:
    """views : (k,) rows of the views in which a point is marked; pixels : (k, 2)"""

    views: npt.NDArray[np.int64]
    pixels: Array

    def in_views(self, scene: SparseScene) -> Marks:
        """Return the marks with the views of a scene."""
        return Marks([scene.views[int(row)] for row in self.views], self.pixels)

    def place(self, scene: SparseScene) -> Array:
        """(3,) in the frame of the scene; NaN where its rays do not determine it."""
        return triangulate(*self.in_views(scene))

    def covariance(self, scene: SparseScene, mark_px: float) -> Array:
        """Return the covariance (3, 3) of the place, in the frame of the scene.

        mark_px : error of a mark in one direction, one sigma
        """
        return place_covariance(self.in_views(scene), self.place(scene), mark_px)


NO_MARKS = PointMarks(np.zeros(0, np.int64), np.zeros((0, 2)))


def marks_by_point(
    scene: SparseScene, marks: Sequence[Mark]
) -> tuple[dict[str, PointMarks], set[str]]:
    """(by label, in the order of the marks; names of photos that are marked and not placed).

    Photos are found as `io.photo_names.photo_finder` does.
    """
    find = photo_finder([view.name for view in scene.views])
    found: dict[str, tuple[list[int], list[tuple[float, float]]]] = {}
    missing = set()
    for mark in marks:
        row = find(mark.photo)
        if row is None:
            missing.add(mark.photo)
            continue
        views, pixels = found.setdefault(mark.label, ([], []))
        views.append(row)
        pixels.append((mark.x, mark.y))
    return {
        label: PointMarks(np.array(views, np.int64), np.array(pixels, np.float64).reshape(-1, 2))
        for label, (views, pixels) in found.items()
    }, missing
