"""Of several costs the one whose path tells most: followed by each, fitted and judged, without
anything known of the truth.

What looks like the contact differs from place to place: a dark bed in the sun is an edge in the
shade. A path along a contact that is there lies in one plane, within what the model resolves; one
that has lost it wanders, which its own residuals tell. So the path whose plane is stated to be
least off is the one with the strongest evidence. To take the best of several is a choice after the
fact, which could make the stated error too small; simulation shows how often it holds
(docs/plane_errors.md, Followed traces).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.extraction.following import Follower, Path
from vomstudio.extraction.path_costs import COSTS, OF_COLOURS
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.planes import fit_plane

Array = npt.NDArray[np.float64]

AUTO = "auto"
"""The cost that is named for the best of all."""
_RANK = {"good": 0, "doubtful": 1, "poor": 2}


class _Followed(Protocol):
    @property
    def points(self) -> Array: ...


P = TypeVar("P", bound=_Followed)
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
    way_points: Array,
    resolution_near: Callable[[Array], float | None],
    *,
    whole: bool = False,
    costs: Sequence[str] | None = None,
) -> tuple[Path, str, tuple[Tried, ...]]:
    """The path through way-points (w, 3) by the best of the costs, its cost, and what was tried,
    the best first. resolution_near : of the model around points (n, 3), World. Raises as
    `Follower.follow`."""

    def follow(cost: str) -> Path:
        return Follower(surface, cost).follow(way_points, whole=whole)

    return best_of(costs or costs_of(surface), follow, resolution_near)


def best_of(
    costs: Sequence[str],
    follow: Callable[[str], P],
    resolution_near: Callable[[Array], float | None],
) -> tuple[P, str, tuple[Tried, ...]]:
    """As `follow_best`, whatever follows. Raises GeometryError where none has a path."""
    found: list[tuple[Rank, int, P, Tried]] = []
    failed: GeometryError | None = None
    for number, cost in enumerate(costs):
        try:
            path = follow(cost)
        except GeometryError as error:
            failed = error
            continue
        rank, error95 = rank_of(path.points, resolution_near)
        found.append((rank, number, path, Tried(cost, error95)))
    if not found:
        assert failed is not None
        raise failed
    found.sort(key=lambda each: each[:2])
    _, _, path, best = found[0]
    return path, best.cost, tuple(tried for *_, tried in found)


def rank_of(
    points: Array, resolution_near: Callable[[Array], float | None]
) -> tuple[Rank, float | None]:
    """By which a path (n, 3), World, is ordered, and the stated error of its plane."""
    try:
        fit = fit_plane(points)
    except GeometryError:
        return (3, 90.0), None
    resolution = resolution_near(points)
    error = total_error_deg(fit, resolution)
    verdict = judge(fit, resolution_m=resolution, outcrop_normal=None)
    return (_RANK[verdict.quality], 90.0 if error is None else error), error
