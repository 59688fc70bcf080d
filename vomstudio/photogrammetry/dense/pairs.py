"""Choice of the photos with which the depths of each photo are computed, by their tie points."""

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

# Rays that meet at 10 degrees are wide enough for accuracy and see the same surfaces; the weight
# falls off more slowly to larger angles, where only occlusion grows.
_BEST_ANGLE_DEG, _BELOW_DEG, _ABOVE_DEG = 10.0, 5.0, 12.0
_FEWEST_SHARED = 5
_FEWEST_POINTS = 5
_LEAST_ANGLE_DEG = 1.0
# Beyond these a rectified pair shows the same patch in too different shapes. Up to there it is
# better, since it is sheared onto the plane of the rock: with 25 degrees between neighbours it
# finds 92 % of the rock where PatchMatch finds 63 %, more exactly and in a tenth of the time
# (tests/benchmarks/bench_wide).
_LARGEST_CONVERGENCE_DEG = 50.0
_LARGEST_ANGLE_DEG = 50.0
_LEAST_ACROSS_DEG = 45.0
_LARGEST_SCALE_RATIO = 1.5
_PADDING = 0.1
_MOST_NEIGHBOURS = 20
SOURCES = 3
"""Of a photo. A fourth, at a wider angle, blurs more than it adds."""


@dataclass(frozen=True)
class Source:
    """view : row in the scene's views
    method : "sgbm" or "patchmatch"
    shared : number of tie points that both photos see
    angle_deg : median angle between the rays to them
    convergence_deg : angle between the optical axes
    """

    view: int
    method: str
    shared: int
    angle_deg: float
    convergence_deg: float


@dataclass(frozen=True, eq=False)
class Plan:
    """How the depth map of one photo is made.

    view : row in the scene's views
    near, far : depths between which its surface lies, along the optical axis
    points : (n, 3) its tie points
    sources : best first
    neighbours : rows of all the photos that show the same places, most shared points first
    """

    view: int
    near: float
    far: float
    points: FloatArray
    sources: tuple[Source, ...]
    neighbours: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Pairs:
    """plans : one for each photo that can have a depth map
    left_out : a sentence for each photo that cannot
    """

    plans: tuple[Plan, ...]
    left_out: tuple[Finding, ...]

    def of_views(self, views: Collection[int]) -> Pairs:
        """The plans of some views alone. Raises GeometryError where none of them has one."""
        plans = tuple(plan for plan in self.plans if plan.view in views)
        if not plans:
            raise GeometryError(
                Finding("region.no-depths"),
                field="--region",
            )
        return replace(self, plans=plans)


def choose_pairs(scene: SparseScene, *, count: int = SOURCES, method: str | None = None) -> Pairs:
    """The sources, depth range and methods of every photo.

    count : of sources for each photo
    method : force one of the two, for comparisons

    Photos are ranked by the tie points they share, each weighted by the angle between its rays;
    the ranking of a photo falls when one that looks from the same side has been chosen already.

    Raises GeometryError where no photo can have a depth map.
    """
    if len(scene.views) < 2:
        raise GeometryError(Finding("dense.too-few-photos", photos=len(scene.views)))
    seen = _seen(scene)
    shared = _shared(scene)
    centres = scene.centres
    plans, left_out = [], []
    for row, view in enumerate(scene.views):
        points = scene.points[seen[row]]
        depths = view.depths(points)
        depths = depths[np.isfinite(depths) & (depths > 0)]
        if len(depths) < _FEWEST_POINTS:
            left_out.append(Finding("dense.few-tie-points", count=len(depths), photo=view.name))
            continue
        candidates = _candidates(scene, row, shared[row], seen, centres)
        if not candidates:
            left_out.append(Finding("dense.no-neighbour", photo=view.name))
            continue
        near, far = _range(depths)
        chosen = _spread(candidates, count)
        sources = tuple(
            Source(
                c.view,
                method or _method(view, scene.views[c.view], points, c),
                c.shared,
                c.angle_deg,
                c.convergence_deg,
            )
            for c in chosen
        )
        by_shared = sorted(candidates, key=lambda c: (-c.shared, c.view))
        neighbours = tuple(c.view for c in by_shared[:_MOST_NEIGHBOURS])
        plans.append(Plan(row, near, far, points, sources, neighbours))
    if not plans:
        raise GeometryError(
            Finding(
                "dense.no-photos",
                reasons=" ".join(finding.message for finding in left_out[:3]),
                reason_codes=[finding.code for finding in left_out],
            )
        )
    return Pairs(tuple(plans), tuple(left_out))


@dataclass(frozen=True, eq=False)
class _Candidate:
    view: int
    shared: int
    angle_deg: float
    convergence_deg: float
    score: float
    side: FloatArray


def _seen(scene: SparseScene) -> list[IntArray]:
    """Rows of the tie points that each view sees, ascending."""
    keys = np.unique(scene.track_views.astype(np.int64) << 32 | scene.track_points)
    starts = np.searchsorted(keys >> 32, np.arange(1, len(scene.views)))
    return np.split(keys & 0xFFFFFFFF, starts)


def _shared(scene: SparseScene) -> list[IntArray]:
    """For each view, those that see enough of the same points: of hundreds, most see none."""
    from scipy.sparse import csr_matrix

    shape = (len(scene.views), len(scene.points))
    there = np.ones(len(scene.track_views), np.int32)
    table = csr_matrix((there, (scene.track_views, scene.track_points)), shape=shape)
    table.data[:] = 1
    both = (table @ table.T).tocsr()
    both.setdiag(0)
    both.sort_indices()
    return [
        both.indices[start:stop][both.data[start:stop] >= _FEWEST_SHARED].astype(np.int64)
        for start, stop in itertools.pairwise(both.indptr)
    ]


def _candidates(
    scene: SparseScene,
    row: int,
    shared: IntArray,
    seen: list[IntArray],
    centres: FloatArray,
) -> list[_Candidate]:
    """shared : rows of the photos that share points enough with this one"""
    found = []
    for other in shared.tolist():
        both = np.intersect1d(seen[row], seen[other], assume_unique=True)
        first = scene.points[both] - centres[row]
        second = scene.points[both] - centres[other]
        angles = _angles_deg(first, second)
        typical = float(np.median(angles))
        if not typical > _LEAST_ANGLE_DEG:
            continue
        baseline = centres[other] - centres[row]
        axis = scene.views[row].direction
        side = baseline - axis * (axis @ baseline)
        found.append(
            _Candidate(
                other,
                len(both),
                typical,
                float(_angles_deg(axis[None], scene.views[other].direction[None])[0]),
                float(_worth(angles).sum()),
                side / max(float(np.linalg.norm(side)), 1e-300),
            )
        )
    return found


def _worth(angles_deg: FloatArray) -> FloatArray:
    off = angles_deg - _BEST_ANGLE_DEG
    return np.asarray(np.exp(-0.5 * (off / np.where(off < 0, _BELOW_DEG, _ABOVE_DEG)) ** 2))


def _spread(candidates: list[_Candidate], count: int) -> list[_Candidate]:
    chosen: list[_Candidate] = []
    left = list(candidates)

    def rank(c: _Candidate) -> tuple[float, int]:
        same = max((float(c.side @ d.side) for d in chosen), default=0.0)
        return -c.score * (1.0 - 0.6 * max(same, 0.0) ** 6), c.view

    while left and len(chosen) < count:
        best = min(left, key=rank)
        left.remove(best)
        chosen.append(best)
    return chosen


def _method(view: View, other: View, points: FloatArray, candidate: _Candidate) -> str:
    """SGBM where the pair can be rectified without distorting what it shows."""
    if (
        candidate.convergence_deg > _LARGEST_CONVERGENCE_DEG
        or candidate.angle_deg > _LARGEST_ANGLE_DEG
    ):
        return PATCHMATCH
    baseline = (other.centre - view.centre)[None]
    for one in (view, other):
        across = float(_angles_deg(one.direction[None], baseline)[0])
        if min(across, 180.0 - across) < _LEAST_ACROSS_DEG:
            return PATCHMATCH
    sizes = [
        float(np.median(v.depths(points))) / float(np.mean(v.intrinsics.focal))
        for v in (view, other)
    ]
    if min(sizes) <= 0 or max(sizes) / min(sizes) > _LARGEST_SCALE_RATIO:
        return PATCHMATCH
    return SGBM


def _range(depths: FloatArray) -> tuple[float, float]:
    """Nearest and farthest depth, without the stray tie points. Padded in inverse depth, in which
    pixels count, by a part of the range and of the depth itself: rock without tie points reaches
    beyond."""
    far, near = np.percentile(1.0 / depths, [1.0, 99.0])
    room = 2 * _PADDING * (near - far) + 0.5 * _PADDING * near
    return float(1.0 / (near + room)), float(1.0 / max(far - room, 0.25 * far))


def _angles_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    cross = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.degrees(np.arctan2(cross, (first * second).sum(axis=1))))
