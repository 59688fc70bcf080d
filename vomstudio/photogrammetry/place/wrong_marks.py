"""Marks of a point that contradict the others, found by leaving one out after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cameras import View
from vomstudio.io.control.points import Mark
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.mark_observations import PointMarks
from vomstudio.registration.marks.wrong_marks import LEAST_PX as LEAST_PX
from vomstudio.registration.marks.wrong_marks import WrongMark as WrongMark
from vomstudio.registration.marks.wrong_marks import agreeing, meet, misses
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

SAME_SPOT_PX = 3.0
# Of all marks in Gaussian scatter one in three thousand is farther off.
_SCATTER_LIMIT = 4.0
# Of the diagonal of a photo. Marks that scatter by more do not show the same points.
_MAX_SCATTER = 0.05


def without_wrong_marks(
    scene: SparseScene, label: str, seen: PointMarks
) -> tuple[PointMarks, list[WrongMark]]:
    """The marks of a point that agree, and those that do not. Two marks that contradict each other
    are both kept: which is wrong can be told by the place of the point alone."""
    rows, wrong = agreeing(label, _views(scene, seen), seen.pixels)
    return PointMarks(seen.views[rows], seen.pixels[rows]), wrong


def agree(scene: SparseScene, seen: PointMarks, limit_px: float = LEAST_PX) -> bool:
    """Whether the rays of the marks meet in a place that no mark misses by more than a limit."""
    return meet(_views(scene, seen), seen.pixels, limit_px)


def mark_scatter_px(scene: SparseScene, points: Sequence[PointMarks]) -> float:
    """Estimate the error of a mark in one direction from the marks alone.

    The median distance of marks from the place where all marks of their point meet, which a few
    wrong marks do not move, corrected for the coordinates that are fitted to each point.

    Returns
    -------
    float
        One sigma, pixels; NaN if no point is located, infinite if most marks are behind a camera.
    """
    distances: list[float] = []
    for seen in points:
        place = seen.place(scene)
        if np.isfinite(place).all():
            count = 2 * len(seen.views)
            factor = math.sqrt(count / (count - 3))
            distances += (factor * misses(_views(scene, seen), seen.pixels, place)).tolist()
    # The median length of a Gaussian vector in the plane is 1.177 sigma.
    return float(np.median(distances)) / 1.1774 if distances else float("nan")


def agreement_px(mark_px: float) -> float:
    """Limit of the distance of right marks from their point, for marks with an error of `mark_px`
    in one direction."""
    return max(LEAST_PX, _SCATTER_LIMIT * mark_px)


def is_plausible(scene: SparseScene, scatter_px: float) -> bool:
    """Whether marks with this scatter can show the same points."""
    diagonals = [math.hypot(v.intrinsics.width, v.intrinsics.height) for v in scene.views]
    return scatter_px <= _MAX_SCATTER * float(np.median(diagonals))


def misplaced(
    scene: SparseScene,
    label: str,
    seen: PointMarks,
    place: Array,
    limit_px: float,
    mark_px: float,
) -> tuple[PointMarks, list[WrongMark]]:
    """As `without_wrong_marks`, by the surveyed place (3,) of the point in a scene that others have
    registered: of marks that contradict each other those are wrong that are farther off from it
    than `limit_px`, unless all are. Marks that agree are right, and the place may be wrong.

    mark_px : error of a mark in one direction"""
    least = agreement_px(mark_px)
    if agree(scene, seen, least):
        return seen, []
    off = misses(_views(scene, seen), seen.pixels, place)
    far = ~(off <= max(limit_px, least))
    if not far.any() or far.all():
        return seen, []
    wrong = []
    for row in np.flatnonzero(far):
        view = scene.views[int(seen.views[row])]
        x, y = (float(v) for v in seen.pixels[row])
        there = view.project(place)[0]
        wanted = (float(there[0]), float(there[1])) if np.isfinite(there).all() else None
        wrong.append(WrongMark(label, view.name, (x, y), wanted))
    return PointMarks(seen.views[~far], seen.pixels[~far]), wrong


def _views(scene: SparseScene, seen: PointMarks) -> list[View]:
    return [scene.views[int(row)] for row in seen.views]


def labels_on_one_spot(marks: Sequence[Mark]) -> Iterator[str]:
    """A sentence for each two points that are marked at the same place of a photo: one of them is
    mistaken for the other."""
    from scipy.spatial import cKDTree

    of_photo: dict[str, list[Mark]] = {}
    for mark in marks:
        of_photo.setdefault(mark.photo, []).append(mark)
    for photo, own in of_photo.items():
        tree = cKDTree([(mark.x, mark.y) for mark in own])
        for i, k in sorted(tree.query_pairs(SAME_SPOT_PX)):
            if own[i].label != own[k].label:
                yield tr(
                    "In {photo} the points {first} and {second} are marked at the same place "
                    "(x {x:.0f}, y {y:.0f}). One of these marks is wrong: remove or move it.",
                    photo=photo,
                    first=own[i].label,
                    second=own[k].label,
                    x=own[i].x,
                    y=own[i].y,
                )
