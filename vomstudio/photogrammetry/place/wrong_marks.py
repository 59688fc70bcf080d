"""Marks of a point that contradict the others, found by leaving one out after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding
from vomstudio.io.control.points import Mark
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.mark_observations import PointMarks
from vomstudio.registration.marks.mark_errors import agreement_px, mark_distances
from vomstudio.registration.marks.wrong_marks import WrongMark, agreeing, meet

Array = npt.NDArray[np.float64]

SAME_SPOT_PX = 3.0


def without_wrong_marks(
    scene: SparseScene, label: str, seen: PointMarks, mark_px: float
) -> tuple[PointMarks, list[WrongMark]]:
    """The marks of a point that agree, and those that do not. Two marks that contradict each other
    are both kept: which is wrong can be told by the place of the point alone.

    mark_px : error of a mark in one direction"""
    rows, wrong = agreeing(label, seen.in_views(scene), agreement_px(mark_px))
    return PointMarks(seen.views[rows], seen.pixels[rows]), wrong


def agree(scene: SparseScene, seen: PointMarks, mark_px: float) -> bool:
    """Whether the rays of the marks meet in a place that no right mark misses by so much.

    mark_px : error of a mark in one direction"""
    return meet(seen.in_views(scene), agreement_px(mark_px))


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
    if agree(scene, seen, mark_px):
        return seen, []
    off = mark_distances(seen.in_views(scene), place)
    far = ~(off <= max(limit_px, agreement_px(mark_px)))
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


def labels_on_one_spot(marks: Sequence[Mark]) -> Iterator[Finding]:
    """Return a finding for each two points that are marked at the same place of a photo."""
    from scipy.spatial import cKDTree

    of_photo: dict[str, list[Mark]] = {}
    for mark in marks:
        of_photo.setdefault(mark.photo, []).append(mark)
    for photo, own in of_photo.items():
        tree = cKDTree([(mark.x, mark.y) for mark in own])
        for i, k in sorted(tree.query_pairs(SAME_SPOT_PX)):
            if own[i].label != own[k].label:
                yield Finding(
                    "control.same-spot",
                    photo=photo,
                    first=own[i].label,
                    second=own[k].label,
                    x=own[i].x,
                    y=own[i].y,
                )
