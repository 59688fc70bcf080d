"""Selection of the source photos of each depth map, based on tie points."""

from __future__ import annotations

import itertools
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.base.scene import SparseScene

SGBM, PATCHMATCH = "sgbm", "patchmatch"

# Rays that intersect at 10 degrees are accurate and see the same surfaces. The weight decreases
# more slowly towards larger angles, where only occlusion increases.
_BEST_ANGLE_DEG, _SMALL_ANGLE_WIDTH_DEG, _LARGE_ANGLE_WIDTH_DEG = 10.0, 5.0, 12.0
_MIN_SHARED_POINTS = 5
_MIN_POINTS = 5
_MIN_ANGLE_DEG = 1.0
# Beyond these limits, a rectified pair shows the same patch in different shapes. Within them,
# rectification is better, since pairs are sheared onto the plane of the rock: with 25 degrees
# between neighbours it measures 92 % of the rock and PatchMatch 63 %, more accurately and in a
# tenth of the time (tests/benchmarks/bench_wide).
_MAX_CONVERGENCE_DEG = 50.0
_MAX_ANGLE_DEG = 50.0
_MIN_CROSSING_DEG = 45.0
_MAX_SCALE_RATIO = 1.5
_DEPTH_PADDING = 0.1
_MAX_NEIGHBOURS = 20
N_SOURCES = 3
"""Number of sources of a photo. A fourth one, at a wider angle, adds more blur than detail."""


@dataclass(frozen=True)
class SourcePhoto:
    """Source photo of a depth map.

    Attributes
    ----------
    view : int
        Row of the source photo in the views of the scene.
    method : {"sgbm", "patchmatch"}
    shared : int
        Number of common tie points.
    angle_deg : float
        Median angle between the rays to these points.
    convergence_deg : float
        Angle between the optical axes.
    """

    view: int
    method: str
    shared: int
    angle_deg: float
    convergence_deg: float


@dataclass(frozen=True, eq=False)
class DepthMapPlan:
    """Plan of the depth map of one photo.

    Attributes
    ----------
    view : int
        Row of the photo in the views of the scene.
    near, far : float
        Range of depths along the optical axis.
    points : (n, 3) array
        Tie points of the photo.
    sources : tuple of SourcePhoto
        Source photos, the best first.
    neighbours : tuple of int
        Rows of up to 20 photos that show the same rock, those with the most common points first.
    """

    view: int
    near: float
    far: float
    points: FloatArray
    sources: tuple[SourcePhoto, ...]
    neighbours: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class DepthMapPlans:
    """Plans of all photos that can have a depth map, and findings about other photos."""

    plans: tuple[DepthMapPlan, ...]
    left_out: tuple[Finding, ...]

    def select_views(self, views: Collection[int]) -> DepthMapPlans:
        """Return the plans of the given views. Raises GeometryError if there are none."""
        plans = tuple(plan for plan in self.plans if plan.view in views)
        if not plans:
            raise GeometryError(
                Finding("region.no-depths"),
                field="--region",
            )
        return replace(self, plans=plans)


def select_pairs(
    scene: SparseScene, *, count: int = N_SOURCES, method: str | None = None
) -> DepthMapPlans:
    """Select the sources, the depth range and the methods for every photo.

    Photos are ranked by common tie points, weighted by the angle between their rays. A photo is
    ranked lower if another photo from the same side has already been selected.

    Parameters
    ----------
    scene : SparseScene
    count : int
        Number of sources of each photo.
    method : str, optional
        Method for all pairs, "sgbm" or "patchmatch"; by default, the better one for each pair.

    Raises
    ------
    GeometryError
        If no photo can have a depth map.
    """
    if len(scene.views) < 2:
        raise GeometryError(Finding("dense.too-few-photos", photos=len(scene.views)))
    points_by_view = _points_of_views(scene)
    shared_views = _views_with_common_points(scene)
    centres = scene.centres
    plans, skipped_photos = [], []
    for row, view in enumerate(scene.views):
        points = scene.points[points_by_view[row]]
        depths = view.depths(points)
        depths = depths[np.isfinite(depths) & (depths > 0)]
        if len(depths) < _MIN_POINTS:
            skipped_photos.append(
                Finding("dense.few-tie-points", count=len(depths), photo=view.name)
            )
            continue
        candidates = _find_candidates(scene, row, shared_views[row], points_by_view, centres)
        if not candidates:
            skipped_photos.append(Finding("dense.no-neighbour", photo=view.name))
            continue
        near_depth, far_depth = _depth_range(depths)
        selection = _select_sources(candidates, count)
        sources = tuple(
            SourcePhoto(
                c.view,
                method or _choose_method(view, scene.views[c.view], points, c),
                c.shared_count,
                c.angle_deg,
                c.convergence_deg,
            )
            for c in selection
        )
        ranked_candidates = sorted(candidates, key=lambda c: (-c.shared_count, c.view))
        neighbours = tuple(c.view for c in ranked_candidates[:_MAX_NEIGHBOURS])
        plans.append(DepthMapPlan(row, near_depth, far_depth, points, sources, neighbours))
    if not plans:
        raise GeometryError(
            Finding(
                "dense.no-photos",
                reasons=" ".join(finding.message for finding in skipped_photos[:3]),
                reason_codes=[finding.code for finding in skipped_photos],
            )
        )
    return DepthMapPlans(tuple(plans), tuple(skipped_photos))


@dataclass(frozen=True, eq=False)
class _Candidate:
    view: int
    shared_count: int
    angle_deg: float
    convergence_deg: float
    score: float
    side: FloatArray


def _points_of_views(scene: SparseScene) -> list[IntArray]:
    """Return the rows of the tie points that each view sees, in ascending order."""
    keys = np.unique(scene.track_views.astype(np.int64) << 32 | scene.track_points)
    starts = np.searchsorted(keys >> 32, np.arange(1, len(scene.views)))
    return np.split(keys & 0xFFFFFFFF, starts)


def _views_with_common_points(scene: SparseScene) -> list[IntArray]:
    """Return, for each view, the views that see enough of the same points."""
    from scipy.sparse import csr_matrix

    shape = (len(scene.views), len(scene.points))
    ones = np.ones(len(scene.track_views), np.int32)
    visibility = csr_matrix((ones, (scene.track_views, scene.track_points)), shape=shape)
    visibility.data[:] = 1
    shared_counts = (visibility @ visibility.T).tocsr()
    shared_counts.setdiag(0)
    shared_counts.sort_indices()
    return [
        shared_counts.indices[start:stop][
            shared_counts.data[start:stop] >= _MIN_SHARED_POINTS
        ].astype(np.int64)
        for start, stop in itertools.pairwise(shared_counts.indptr)
    ]


def _find_candidates(
    scene: SparseScene,
    row: int,
    other_rows: IntArray,
    points_by_view: list[IntArray],
    centres: FloatArray,
) -> list[_Candidate]:
    """Return the photos in `other_rows` that see the common points at sufficient angles."""
    candidates = []
    for other_row in other_rows.tolist():
        shared_points = np.intersect1d(
            points_by_view[row], points_by_view[other_row], assume_unique=True
        )
        first_rays = scene.points[shared_points] - centres[row]
        second_rays = scene.points[shared_points] - centres[other_row]
        angles = _angles_deg(first_rays, second_rays)
        median_angle_deg = float(np.median(angles))
        if not median_angle_deg > _MIN_ANGLE_DEG:
            continue
        baseline = centres[other_row] - centres[row]
        axis = scene.views[row].direction
        offset = baseline - axis * (axis @ baseline)
        candidates.append(
            _Candidate(
                other_row,
                len(shared_points),
                median_angle_deg,
                float(_angles_deg(axis[None], scene.views[other_row].direction[None])[0]),
                float(_angle_weights(angles).sum()),
                offset / max(float(np.linalg.norm(offset)), 1e-300),
            )
        )
    return candidates


def _angle_weights(angles_deg: FloatArray) -> FloatArray:
    offset = angles_deg - _BEST_ANGLE_DEG
    return np.asarray(
        np.exp(
            -0.5
            * (offset / np.where(offset < 0, _SMALL_ANGLE_WIDTH_DEG, _LARGE_ANGLE_WIDTH_DEG)) ** 2
        )
    )


def _select_sources(candidates: list[_Candidate], count: int) -> list[_Candidate]:
    selection: list[_Candidate] = []
    remaining = list(candidates)

    def rank(c: _Candidate) -> tuple[float, int]:
        max_cosine = max((float(c.side @ d.side) for d in selection), default=0.0)
        return -c.score * (1.0 - 0.6 * max(max_cosine, 0.0) ** 6), c.view

    while remaining and len(selection) < count:
        best_candidate = min(remaining, key=rank)
        remaining.remove(best_candidate)
        selection.append(best_candidate)
    return selection


def _choose_method(view: View, other_view: View, points: FloatArray, candidate: _Candidate) -> str:
    """Return the method for a pair: SGBM if it can be rectified without distortion."""
    if candidate.convergence_deg > _MAX_CONVERGENCE_DEG or candidate.angle_deg > _MAX_ANGLE_DEG:
        return PATCHMATCH
    baseline = (other_view.centre - view.centre)[None]
    for photo_view in (view, other_view):
        crossing_angle = float(_angles_deg(photo_view.direction[None], baseline)[0])
        if min(crossing_angle, 180.0 - crossing_angle) < _MIN_CROSSING_DEG:
            return PATCHMATCH
    pixel_sizes = [
        float(np.median(v.depths(points))) / float(np.mean(v.intrinsics.focal))
        for v in (view, other_view)
    ]
    if min(pixel_sizes) <= 0 or max(pixel_sizes) / min(pixel_sizes) > _MAX_SCALE_RATIO:
        return PATCHMATCH
    return SGBM


def _depth_range(depths: FloatArray) -> tuple[float, float]:
    """Return the nearest and the farthest depth, ignoring outliers among the tie points.

    The range is padded by a fraction of its extent and of the depth, because rock without tie
    points extends beyond it. The padding is applied to inverse depths, which are linear in pixels.
    """
    min_inverse, max_inverse = np.percentile(1.0 / depths, [1.0, 99.0])
    depth_padding = (
        2 * _DEPTH_PADDING * (max_inverse - min_inverse) + 0.5 * _DEPTH_PADDING * max_inverse
    )
    return float(1.0 / (max_inverse + depth_padding)), float(
        1.0 / max(min_inverse - depth_padding, 0.25 * min_inverse)
    )


def _angles_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    sines = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.degrees(np.arctan2(sines, (first * second).sum(axis=1))))
