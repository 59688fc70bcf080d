"""Selection of the cost whose path has the most reliable plane, without ground truth.

The appearance of a contact varies along it: a bed that is dark in the sun is an edge in the shade.
A path along a real contact is planar within the resolution of the model; a path that has lost the
contact wanders, as its residuals show. The path whose plane has the smallest stated error therefore
has the strongest evidence.

A path that leaves the contact on a flat wall lies in the plane of this wall. A path whose plane is
the outcrop face is therefore ranked behind all other paths that have a plane.

Several straight paths do not determine a plane, whereas a path that leaves the contact may have a
plane with a small error. If none of at least three paths has a good verdict, the path that is best
confirmed by the others is therefore selected, whatever its plane. A simulation shows how often the
stated errors hold (docs/plane_errors.md, Followed traces).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.extraction.following import Follower, Path
from vomstudio.extraction.path_costs import COLOUR_COSTS, COST_NAMES
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import VertexRange, fit_remaining_plane
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.planes import fit_plane

AUTO = "auto"
"""Name of the option that selects the best of all costs."""
_MAX_FACE_COSINE = float(np.cos(np.radians(DEFAULT_THRESHOLDS.surface_effect_deg)))
_MAX_DISTANCE_RESOLUTIONS = 2.0
"""Maximum distance between two paths that run along each other, in model resolutions."""
_QUALITY_RANK = {"good": 0, "doubtful": 1, "poor": 2}


class _FollowedPath(Protocol):
    @property
    def points(self) -> FloatArray: ...


PathT = TypeVar("PathT", bound=_FollowedPath)
FaceNormalFunction = Callable[[FloatArray], FloatArray | None]
"""Function that returns the outcrop normal (3,) near points (n, 3) in the World frame, or None."""
PathRank = tuple[int, float]
"""Sort key of paths: verdict on the plane, and error of the plane in degrees."""


@dataclass(frozen=True)
class CostTrial:
    """Cost that was compared, with the 95 % error of its plane (None if it has no plane)."""

    cost: str
    error95_deg: float | None


def available_costs(surface: SurfaceGraph) -> tuple[str, ...]:
    """List the costs that are available for a model, other than its fields.

    Parameters
    ----------
    surface : SurfaceGraph

    Returns
    -------
    tuple of str
    """
    is_coloured = surface.data.colors is not None or surface.textures is not None
    return tuple(cost for cost in COST_NAMES if is_coloured or cost not in COLOUR_COSTS)


def follow_best(
    surface: SurfaceGraph,
    way_points: FloatArray,
    local_resolution: Callable[[FloatArray], float | None],
    face_normal: FaceNormalFunction | None = None,
    *,
    uses_whole_surface: bool = False,
    costs: Sequence[str] | None = None,
) -> tuple[Path, str, tuple[CostTrial, ...]]:
    """Follow way-points with each cost and select the best path.

    Parameters
    ----------
    surface : SurfaceGraph
    way_points : (w, 3) array
        Way-points in the World frame, m.
    local_resolution : callable
        Function that returns the resolution of the model around points (n, 3), m; None if unknown.
    face_normal : callable, optional
        Function that returns the normal of the outcrop face around points (n, 3); None if unknown.
    uses_whole_surface : bool
        See `Follower.follow`.
    costs : sequence of str, optional
        Costs to compare; by default, all costs that are available for the model.

    Returns
    -------
    path : Path
    cost : str
        Cost of the selected path.
    trials : tuple of CostTrial
        Compared costs, the selected one first.

    Raises
    ------
    GeometryError
        See `Follower.follow`.
    """

    def follow(cost: str) -> Path:
        return Follower(surface, cost).follow(way_points, uses_whole_surface=uses_whole_surface)

    def find_doubtful_ranges(path: Path) -> tuple[VertexRange, ...]:
        return find_jumps(
            path.points, path.costs, path.way_point_rows, local_resolution(path.points) or 0.0
        )

    return select_best_path(
        costs or available_costs(surface),
        follow,
        local_resolution,
        face_normal,
        find_doubtful_ranges,
    )


def select_best_path(
    costs: Sequence[str],
    follow: Callable[[str], PathT],
    local_resolution: Callable[[FloatArray], float | None],
    face_normal: FaceNormalFunction | None = None,
    doubtful_callback: Callable[[PathT], Sequence[VertexRange]] = lambda path: (),
) -> tuple[PathT, str, tuple[CostTrial, ...]]:
    """Select the best path of any follower. See `follow_best`.

    Parameters
    ----------
    costs : sequence of str
    follow : callable
        Function that follows a path with a given cost.
    local_resolution, face_normal : callables
        See `follow_best`.
    doubtful_callback : callable
        Function that returns the stretches of a path that may follow another contact.

    Returns
    -------
    path, cost, trials
        See `follow_best`.

    Raises
    ------
    GeometryError
        If no cost results in a path.
    """
    candidates: list[tuple[PathRank, int, PathT, CostTrial]] = []
    last_error: GeometryError | None = None
    for number, cost in enumerate(costs):
        try:
            path = follow(cost)
        except GeometryError as error:
            last_error = error
            continue
        rank, error95_deg = rank_path(
            path.points, local_resolution, face_normal, doubtful_callback(path)
        )
        candidates.append((rank, number, path, CostTrial(cost, error95_deg)))
    if not candidates:
        assert last_error is not None
        raise last_error
    candidates.sort(key=lambda each: each[:2])
    if candidates[0][0][0] != _QUALITY_RANK["good"] and len(candidates) > 2:
        confirmed_shares = _confirmed_shares(
            [path.points for _, _, path, _ in candidates], local_resolution
        )
        # Among equally confirmed paths, the first one stays first.
        candidates.insert(0, candidates.pop(int(np.argmax(confirmed_shares))))
    _, _, path, best_trial = candidates[0]
    return path, best_trial.cost, tuple(trial for *_, trial in candidates)


def _confirmed_shares(
    paths: Sequence[FloatArray], local_resolution: Callable[[FloatArray], float | None]
) -> FloatArray:
    """Sum the shares of each path that are confirmed by the other paths.

    For each pair, the smaller of two shares counts: the share of either path that is near the
    other one.
    """
    from scipy.spatial import cKDTree

    trees = [cKDTree(points) for points in paths]
    shares = np.zeros((len(paths), len(paths)))
    for i, points in enumerate(paths):
        max_distance = _MAX_DISTANCE_RESOLUTIONS * (local_resolution(points) or 0.0)
        for j in range(len(paths)):
            if i != j:
                shares[i, j] = np.mean(trees[j].query(points)[0] <= max_distance)
    return np.asarray(np.minimum(shares, shares.T).sum(axis=1))


def rank_path(
    points: FloatArray,
    local_resolution: Callable[[FloatArray], float | None],
    face_normal: FaceNormalFunction | None = None,
    doubtful_ranges: Sequence[VertexRange] = (),
) -> tuple[PathRank, float | None]:
    """Rank a path by the quality of its plane.

    Parameters
    ----------
    points : (n, 3) ndarray
        Points of the path in the World frame, m.
    local_resolution : callable
        Function that returns the effective resolution of the model near points (n, 3), m, or None.
    face_normal : FaceNormalFunction, optional
        Function that returns the normal of the outcrop face near points (n, 3), or None.
    doubtful_ranges : sequence of VertexRange, optional
        First and last row of each doubtful stretch.

    Returns
    -------
    rank : PathRank
    error95_deg : float or None
        Stated 95 % error of the plane, degrees; None if no plane can be fitted.
    """
    try:
        fit = fit_plane(points)
    except GeometryError:
        return (3, 90.0), None
    resolution = local_resolution(points)
    face = None if face_normal is None else face_normal(points)
    remaining_trace = fit_remaining_plane(points, doubtful_ranges)
    length_ratio = (
        None if remaining_trace is None else remaining_trace.error95_deg(fit, resolution, face)
    )
    error = total_error_deg(fit, resolution, outcrop_normal=face, stretch_error_deg=length_ratio)
    if face is not None and abs(float(fit.normal @ face)) > _MAX_FACE_COSINE:
        return (_QUALITY_RANK["poor"], 90.0), error
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=face,
        surface_findings=() if remaining_trace is None else remaining_trace.findings(),
        stretch_error_deg=length_ratio,
    )
    return (_QUALITY_RANK[verdict.quality], 90.0 if error is None else error), error
