"""Errors of points marked in photos, for reconstructions and registrations.

The scatter of the marks is estimated from all marks. It is the median distance of the marks from
the positions where most rays of their points intersect (least median of squares over pairs of rays;
Rousseeuw 1984, J. Am. Stat. Assoc. 79, 871). Wrong marks do not affect these positions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.geometry.triangulation import triangulate

MIN_MARK_ERROR_PX = 0.3
"""One-sigma error of a mark in one direction, below which estimates from marks are not trusted."""
HAND_MARK_ERROR_PX = 1.0
"""Minimum error of a mark set by hand."""
MAX_MARK_SCATTER_PX = 5.0
"""Scatter above which marks or poses should be checked."""
_OUTLIER_SIGMAS = 6.0
# Share of the photo diagonal; marks that scatter by more do not show the same points.
_MAX_SCATTER_SHARE = 0.05
_MAX_PAIRS = 300
_MAX_ITERATIONS = 3
# Medians of the length of a Gaussian vector in the plane, and of a Gaussian number, in sigmas.
_MEDIAN_LENGTH, _MEDIAN_ABSOLUTE_VALUE = 1.1774, 0.6745


class Marks(NamedTuple):
    """Marks of one point: the views in which the point is marked, and the pixels (k, 2)."""

    views: Sequence[View]
    pixels: FloatArray

    def select(self, rows: Iterable[int]) -> Marks:
        """Return the selected marks."""
        rows = [int(row) for row in rows]
        return Marks([self.views[row] for row in rows], self.pixels[rows])


def mark_distances(marks: Marks, position: FloatArray) -> FloatArray:
    """Return the distances of marks from the projection of a position.

    Parameters
    ----------
    marks : Marks
    position : (3,) ndarray

    Returns
    -------
    (k,) ndarray
        Distances, pixels; infinite behind a camera and for an unknown position.
    """
    if not np.isfinite(position).all():
        return np.full(len(marks.views), np.inf)
    distance = [
        np.linalg.norm(view.project(position)[0] - pixel)
        for view, pixel in zip(marks.views, marks.pixels, strict=True)
    ]
    return np.nan_to_num(np.array(distance, np.float64), nan=np.inf)


def robust_position(marks: Marks) -> FloatArray:
    """Return the position with the least median distance from the marks of a point.

    For two marks, it is the intersection of both rays.

    Parameters
    ----------
    marks : Marks

    Returns
    -------
    (3,) ndarray
        Position, NaN if it cannot be determined.
    """
    count = len(marks.views)
    if count < 3:
        return triangulate(marks.views, marks.pixels)
    candidates = _ray_intersections(marks)
    if not len(candidates):
        return triangulate(marks.views, marks.pixels)
    distance = np.array(
        [
            np.linalg.norm(view.project(candidates) - pixel, axis=1)
            for view, pixel in zip(marks.views, marks.pixels, strict=True)
        ]
    )
    distance = np.sort(np.nan_to_num(distance, nan=np.inf), axis=0)
    best_position = candidates[int(np.argmin(distance[count // 2]))]
    nearest_rows = np.argsort(mark_distances(marks, best_position), kind="stable")[: count // 2 + 1]
    return triangulate(*marks.select(nearest_rows))


def _ray_intersections(marks: Marks) -> FloatArray:
    """Return the positions (m, 3) nearest to the rays of each pair of marks."""
    rays = np.array(
        [view.rays(pixel)[0] for view, pixel in zip(marks.views, marks.pixels, strict=True)]
    )
    centres = np.array([view.centre for view in marks.views])
    pairs = np.array(list(combinations(range(len(rays)), 2)))
    if len(pairs) > _MAX_PAIRS:
        pairs = pairs[np.random.default_rng(0).choice(len(pairs), _MAX_PAIRS, replace=False)]
    first_rows, second_rows = pairs.T
    projector = np.eye(3) - rays[:, :, None] * rays[:, None, :]
    normal = projector[first_rows] + projector[second_rows]
    right_hand_sides = np.einsum("nij,nj->ni", projector, centres)
    is_usable = np.linalg.cond(normal) < 1e8
    positions = np.linalg.solve(
        normal[is_usable],
        (right_hand_sides[first_rows] + right_hand_sides[second_rows])[is_usable][..., None],
    )
    return np.asarray(positions[..., 0])


def mark_scatter_px(points: Sequence[Marks]) -> float:
    """Estimate the error of a mark in one direction from the marks alone.

    Parameters
    ----------
    points : sequence of Marks
        All marks of each point.

    Returns
    -------
    float
        One-sigma error, pixels; NaN if no point is located.
    """
    return _scatter_px(_robust_distances(points))


def _robust_distances(points: Sequence[Marks]) -> list[tuple[Marks, FloatArray]]:
    """Return the located points, and the distances of their marks from the located positions."""
    positions = [(marks, robust_position(marks)) for marks in points if len(marks.views) >= 2]
    return [
        (marks, mark_distances(marks, position))
        for marks, position in positions
        if np.isfinite(position).all()
    ]


def _scatter_px(marks_with_distances: Sequence[tuple[Marks, FloatArray]]) -> float:
    distances = [distance_px for _, distance_px in marks_with_distances]
    if not distances:
        return float("nan")
    scatter = float(np.median(np.concatenate(distances))) / _MEDIAN_LENGTH
    for _ in range(_MAX_ITERATIONS):
        lengths: list[FloatArray] = []
        for marks, distance_px in marks_with_distances:
            near_rows = np.flatnonzero(distance_px <= _OUTLIER_SIGMAS * scatter)
            if len(near_rows) >= 2 and len(near_rows) < len(distance_px):
                point = triangulate(*marks.select(near_rows))
            else:
                near_rows, point = np.arange(len(distance_px)), triangulate(*marks)
            lengths.append(_residual_correction(len(near_rows)) * mark_distances(marks, point))
        previous_scatter, scatter = (
            scatter,
            float(np.median(np.concatenate(lengths))) / _MEDIAN_LENGTH,
        )
        if math.isclose(previous_scatter, scatter, rel_tol=1e-3):
            break
    return scatter


def _residual_correction(count: int) -> float:
    """Return the ratio of the errors of marks to their distances from a fitted position."""
    if count == 2:
        # One degree of freedom remains, shared by both marks.
        return math.sqrt(2.0) * _MEDIAN_LENGTH / _MEDIAN_ABSOLUTE_VALUE
    return math.sqrt(2 * count / (2 * count - 3))


def mark_error_px(points: Sequence[Marks]) -> float:
    """Return the one-sigma error to assume for a mark in one direction, pixels.

    It is estimated from the scatter of all marks, but is at least `MIN_MARK_ERROR_PX`. Points
    whose marks scatter too much to show the same point are excluded.

    Parameters
    ----------
    points : sequence of Marks
        All marks of each point.

    Raises
    ------
    GeometryError
        If the marks of all points scatter too much.
    """
    marks_with_distances = _robust_distances(points)
    if not marks_with_distances:
        return MIN_MARK_ERROR_PX
    plausible_marks = [
        item
        for item in marks_with_distances
        if float(np.median(item[1])) <= _max_scatter_px(item[0])
    ]
    if not plausible_marks:
        scatter_px = _scatter_px(marks_with_distances)
        raise GeometryError(Finding("control.marks-scattered", scatter_px=scatter_px))
    return max(MIN_MARK_ERROR_PX, _scatter_px(plausible_marks))


def _max_scatter_px(marks: Marks) -> float:
    sizes = [math.hypot(view.intrinsics.width, view.intrinsics.height) for view in marks.views]
    return _MAX_SCATTER_SHARE * float(np.median(sizes))


def mark_scatter_findings(scatter_px: float) -> list[Finding]:
    """Return a finding if marks scatter more than marks set by hand should.

    Parameters
    ----------
    scatter_px : float

    Returns
    -------
    list of Finding
    """
    if scatter_px <= MAX_MARK_SCATTER_PX:
        return []
    return [Finding("mark-scatter", photos=(), value=scatter_px)]


def disagreeing_marks_finding(labels: Sequence[str]) -> Finding:
    """Return the finding for points whose marks do not agree on one position.

    Parameters
    ----------
    labels : sequence of str

    Returns
    -------
    Finding
    """
    return Finding("control.marks-disagree", labels=list(labels))


def max_mark_distance_px(mark_px: float) -> float:
    """Return the maximum distance of correct marks from their point.

    Parameters
    ----------
    mark_px : float
        One-sigma error of a mark in one direction.

    Returns
    -------
    float
    """
    return _OUTLIER_SIGMAS * max(HAND_MARK_ERROR_PX, mark_px)


def position_covariance(marks: Marks, position: FloatArray, mark_px: float) -> FloatArray:
    """Return the covariance (3, 3) of a triangulated point in the frame of the views.

    Parameters
    ----------
    marks : Marks
        Marks from which the point was triangulated.
    position : (3,) array
    mark_px : float
        One-sigma error of a mark in one direction.
    """
    distances = [float(np.linalg.norm(position - view.centre)) for view in marks.views]
    step = 1e-6 * max(1e-9, min(distances))
    offsets = np.vstack([np.eye(3) * step, -np.eye(3) * step])
    pixels = np.array([view.project(position + offsets) for view in marks.views])
    design = ((pixels[:, :3] - pixels[:, 3:]) / (2.0 * step)).transpose(0, 2, 1).reshape(-1, 3)
    return np.asarray(mark_px**2 * np.linalg.inv(design.T @ design))
