"""Image marks of points, matched to the photos of a scene by name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.triangulation import triangulate
from vomstudio.io.control.points import Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.registration.marks.mark_errors import Marks, position_covariance

MAX_COINCIDENCE_PX = 3.0


@dataclass(frozen=True, eq=False)
class PointMarks:
    """Marks of a point.

    Attributes
    ----------
    views : (k,) ndarray
        Rows of the views in which the point is marked.
    pixels : (k, 2) ndarray
        Marks in these views.
    """

    views: IntArray
    pixels: FloatArray

    def match_views(self, scene: SparseScene) -> Marks:
        """Return the marks together with their views in a scene."""
        return Marks([scene.views[int(row)] for row in self.views], self.pixels)

    def place(self, scene: SparseScene) -> FloatArray:
        """Return the position (3,) in the frame of the scene; NaN if undetermined."""
        return triangulate(*self.match_views(scene))

    def covariance(self, scene: SparseScene, mark_px: float) -> FloatArray:
        """Return the covariance (3, 3) of the position, in the frame of the scene.

        mark_px : error of a mark in one direction, one sigma
        """
        return position_covariance(self.match_views(scene), self.place(scene), mark_px)

    def select(self, rows: IntArray) -> PointMarks:
        """Return the marks in `rows`."""
        return PointMarks(self.views[rows], self.pixels[rows])


NO_MARKS = PointMarks(np.zeros(0, np.int64), np.zeros((0, 2)))


def marks_by_point(
    scene: SparseScene, marks: Sequence[Mark]
) -> tuple[dict[str, PointMarks], set[str]]:
    """Group marks by the labels of their points.

    Photos are matched as in `io.photos.photo_names.photo_finder`.

    Returns
    -------
    marks : dict
        PointMarks of each label, in the order of the marks.
    missing_photos : set of str
        Names of marked photos without a pose.
    """
    find_photo = photo_finder([view.name for view in scene.views])
    observations: dict[str, tuple[list[int], list[tuple[float, float]]]] = {}
    missing_photos = set()
    for mark in marks:
        row = find_photo(mark.photo)
        if row is None:
            missing_photos.add(mark.photo)
            continue
        views, pixels = observations.setdefault(mark.label, ([], []))
        views.append(row)
        pixels.append((mark.x, mark.y))
    return {
        label: PointMarks(np.array(views, np.int64), np.array(pixels, np.float64).reshape(-1, 2))
        for label, (views, pixels) in observations.items()
    }, missing_photos


def report_coincident_marks(marks: Sequence[Mark]) -> Iterator[Finding]:
    """Report each pair of points that are marked at the same position in a photo."""
    from scipy.spatial import cKDTree

    marks_by_photo: dict[str, list[Mark]] = {}
    for mark in marks:
        marks_by_photo.setdefault(mark.photo, []).append(mark)
    for photo, photo_marks in marks_by_photo.items():
        tree = cKDTree([(mark.x, mark.y) for mark in photo_marks])
        for i, k in sorted(tree.query_pairs(MAX_COINCIDENCE_PX)):
            if photo_marks[i].label != photo_marks[k].label:
                yield Finding(
                    "control.same-spot",
                    photo=photo,
                    first=photo_marks[i].label,
                    second=photo_marks[k].label,
                    x=photo_marks[i].x,
                    y=photo_marks[i].y,
                )
