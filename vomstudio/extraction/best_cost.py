"""Of several costs the one whose path tells most: followed by each, fitted and judged, without
anything known of the truth.

What looks like the contact differs from place to place: a dark bed in the sun is an edge in the
shade. A path along a contact that is there lies in one plane, within what the model resolves; one
that has lost it wanders, which its own residuals tell. So the path whose plane is stated to be
least off is the one with the strongest evidence. A path that strays on a flat wall lies in the
plane of that wall, the better the farther it strays: one whose plane is the outcrop's face comes
last. To take the best of several is a choice after the fact, which makes the stated error too small
where no path tells much: of those along a straight line, which say so, and one that strays from it,
and has a plane for that very reason, the one that strays would be taken. So where none is good, the
path is taken that the others confirm most, whatever its plane is worth. Simulation shows how often
what it states holds (docs/plane_errors.md, Followed traces).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.extraction.following import Follower, Path
from vomstudio.extraction.path_costs import COSTS, OF_COLOURS
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import Range, fit_remaining_plane
from vomstudio.geology.profiles import DEFAULTS
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.planes import fit_plane

AUTO = "auto"
"""The cost that is named for the best of all."""
_ALONG_FACE = float(np.cos(np.radians(DEFAULTS.surface_effect_deg)))
_BESIDE = 2.0
"""Resolutions of the model within which two paths run beside each other."""
_RANK = {"good": 0, "doubtful": 1, "poor": 2}


class _Followed(Protocol):
    @property
    def points(self) -> FloatArray: ...


P = TypeVar("P", bound=_Followed)
Face = Callable[[FloatArray], FloatArray | None]
"""The normal (3,) of the outcrop's face around points (n, 3), World; None where it has none."""
Rank = tuple[int, float]
"""What paths are ordered by: the verdict on the plane, and by how much it may be off, degrees."""


@dataclass(frozen=True)
class Tried:
    """cost : of a path; error95_deg : by which its plane may be off, None where it has none"""

    cost: str
    error95_deg: float | None


def costs_of(surface: SurfaceGraph) -> tuple[str, ...]:
    """Those that a model has, without its fields."""
    coloured = surface.data.colors is not None or surface.textures is not None
    return tuple(cost for cost in COSTS if coloured or cost not in OF_COLOURS)


def follow_best(
    surface: SurfaceGraph,
    way_points: FloatArray,
    resolution_near: Callable[[FloatArray], float | None],
    face_near: Face | None = None,
    *,
    whole: bool = False,
    costs: Sequence[str] | None = None,
) -> tuple[Path, str, tuple[Tried, ...]]:
    """The path through way-points (w, 3) by the best of the costs, its cost, and what was tried,
    the best first. resolution_near : of the model around points (n, 3), World; face_near : normal
    of the outcrop's face there. Raises as `Follower.follow`."""

    def follow(cost: str) -> Path:
        return Follower(surface, cost).follow(way_points, whole=whole)

    def doubtful(path: Path) -> tuple[Range, ...]:
        return find_jumps(path.points, path.costs, path.at, resolution_near(path.points) or 0.0)

    return best_of(costs or costs_of(surface), follow, resolution_near, face_near, doubtful)


def best_of(
    costs: Sequence[str],
    follow: Callable[[str], P],
    resolution_near: Callable[[FloatArray], float | None],
    face_near: Face | None = None,
    doubtful: Callable[[P], Sequence[Range]] = lambda path: (),
) -> tuple[P, str, tuple[Tried, ...]]:
    """As `follow_best`, whatever follows. doubtful : stretches of a path that may be on another
    contact. Raises GeometryError where none has a path."""
    found: list[tuple[Rank, int, P, Tried]] = []
    failed: GeometryError | None = None
    for number, cost in enumerate(costs):
        try:
            path = follow(cost)
        except GeometryError as error:
            failed = error
            continue
        rank, error95 = rank_of(path.points, resolution_near, face_near, doubtful(path))
        found.append((rank, number, path, Tried(cost, error95)))
    if not found:
        assert failed is not None
        raise failed
    found.sort(key=lambda each: each[:2])
    if found[0][0][0] != _RANK["good"] and len(found) > 2:
        shares = _confirmed([path.points for _, _, path, _ in found], resolution_near)
        # The first of those that are confirmed alike stays the first.
        found.insert(0, found.pop(int(np.argmax(shares))))
    _, _, path, best = found[0]
    return path, best.cost, tuple(tried for *_, tried in found)


def _confirmed(
    paths: Sequence[FloatArray], resolution_near: Callable[[FloatArray], float | None]
) -> FloatArray:
    """(k,) of paths (n, 3) each: the sum over the others of the share that runs beside them, of one
    or the other, whichever is less."""
    from scipy.spatial import cKDTree

    trees = [cKDTree(points) for points in paths]
    beside = np.zeros((len(paths), len(paths)))
    for i, points in enumerate(paths):
        near = _BESIDE * (resolution_near(points) or 0.0)
        for j in range(len(paths)):
            if i != j:
                beside[i, j] = np.mean(trees[j].query(points)[0] <= near)
    return np.asarray(np.minimum(beside, beside.T).sum(axis=1))


def rank_of(
    points: FloatArray,
    resolution_near: Callable[[FloatArray], float | None],
    face_near: Face | None = None,
    doubtful: Sequence[Range] = (),
) -> tuple[Rank, float | None]:
    """By which a path (n, 3), World, with doubtful stretches is ordered, and the stated error of
    its plane."""
    try:
        fit = fit_plane(points)
    except GeometryError:
        return (3, 90.0), None
    resolution = resolution_near(points)
    face = None if face_near is None else face_near(points)
    rest = fit_remaining_plane(points, doubtful)
    stretch = None if rest is None else rest.error95_deg(fit, resolution, face)
    error = total_error_deg(fit, resolution, outcrop_normal=face, stretch_error_deg=stretch)
    if face is not None and abs(float(fit.normal @ face)) > _ALONG_FACE:
        return (_RANK["poor"], 90.0), error
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=face,
        surface_findings=() if rest is None else rest.findings(),
        stretch_error_deg=stretch,
    )
    return (_RANK[verdict.quality], 90.0 if error is None else error), error
