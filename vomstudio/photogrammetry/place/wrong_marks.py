"""Marks of a point that contradict the others, found by leaving one out after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.io.control.points import Mark
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.mark_observations import PointMarks
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

LEAST_PX = 20.0
"""A mark set by hand, in a photo whose lens is known badly, may be this far off and still be meant
for the point."""
_TIMES = 10.0
"""So many times as far off as the others are from each other."""
_CLEAR = 3.0
"""Leaving out any other mark must leave so many times as much, or which is wrong is not known."""
SAME_SPOT_PX = 3.0


@dataclass(frozen=True)
class WrongMark:
    """photo : its name; at, wanted : (x, y) where it is and where the other marks of the point say
    that it should be, in pixels; wanted is None where only one of several can be wrong, and it is
    not known which"""

    label: str
    photo: str
    at: tuple[float, float]
    wanted: tuple[float, float] | None

    def in_words(self) -> str:
        """A sentence that names label, photo and place."""
        x, y = self.at
        if self.wanted is None:
            return tr(
                "The marks of {label} contradict each other, and it cannot be told which is wrong. "
                "Check the one in {photo} at x {x:.0f}, y {y:.0f}, and the others.",
                label=self.label,
                photo=self.photo,
                x=x,
                y=y,
            )
        return tr(
            "The mark of {label} in {photo} at x {x:.0f}, y {y:.0f} contradicts its other marks "
            "and was left out: by those it should be at x {there:.0f}, y {below:.0f}, "
            "{distance:,.0f} pixels away.",
            label=self.label,
            photo=self.photo,
            x=x,
            y=y,
            there=self.wanted[0],
            below=self.wanted[1],
            distance=math.dist(self.at, self.wanted),
        )


def without_wrong_marks(
    scene: SparseScene, label: str, seen: PointMarks
) -> tuple[PointMarks, list[WrongMark]]:
    """The marks of a point that agree, and those that do not. Two marks that contradict each other
    are both kept: which is wrong can be told by the place of the point alone."""
    wrong: list[WrongMark] = []
    while len(seen.views) >= 3:
        found = _worst(scene, seen)
        if found is None:
            break
        row, wanted = found
        name = scene.views[int(seen.views[row])].name
        x, y = (float(v) for v in seen.pixels[row])
        if wanted is None:
            wrong.append(WrongMark(label, name, (x, y), None))
            break
        wrong.append(WrongMark(label, name, (x, y), (float(wanted[0]), float(wanted[1]))))
        keep = np.arange(len(seen.views)) != row
        seen = PointMarks(seen.views[keep], seen.pixels[keep])
    return seen, wrong


def agree(scene: SparseScene, seen: PointMarks) -> bool:
    """Whether the rays of the marks meet in a place."""
    place = seen.place(scene)
    return bool(np.isfinite(place).all() and _misses(scene, seen, place).max() <= LEAST_PX)


def misplaced(
    scene: SparseScene, label: str, seen: PointMarks, place: Array, limit_px: float
) -> tuple[PointMarks, list[WrongMark]]:
    """As `without_wrong_marks`, by the surveyed place (3,) of the point in a scene that others have
    registered: of marks that contradict each other those are wrong that are farther off from it
    than `limit_px`, unless all are. Marks that agree are right, and the place may be wrong."""
    if agree(scene, seen):
        return seen, []
    misses = _misses(scene, seen, place)
    far = ~(misses <= max(limit_px, LEAST_PX))
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


def _worst(scene: SparseScene, seen: PointMarks) -> tuple[int, Array | None] | None:
    """The mark that the others contradict, and where these want it; None where all agree."""
    if agree(scene, seen):
        return None
    rows = np.arange(len(seen.views))
    left, missed, places = [], [], []
    for row in rows:
        others = PointMarks(seen.views[rows != row], seen.pixels[rows != row])
        there = others.place(scene)
        known = bool(np.isfinite(there).all())
        left.append(float(_misses(scene, others, there).max()) if known else math.inf)
        view = scene.views[int(seen.views[row])]
        places.append(view.project(there)[0] if known else np.full(2, np.nan))
        missed.append(float(np.linalg.norm(places[-1] - seen.pixels[row])) if known else math.inf)
    best = int(np.argmin(left))
    if not math.isfinite(left[best]):
        return (best, None)
    if missed[best] <= max(LEAST_PX, _TIMES * left[best]):
        return None
    second = float(np.partition(left, 1)[1])
    clear = second >= _CLEAR * max(left[best], 1.0)
    return best, places[best] if clear and np.isfinite(places[best]).all() else None


def _misses(scene: SparseScene, seen: PointMarks, place: Array) -> Array:
    """(k,) pixels from each mark to the projection of a place (3,); infinite behind a camera."""
    if not np.isfinite(place).all():
        return np.full(len(seen.views), np.inf)
    off = [
        np.linalg.norm(scene.views[int(view)].project(place)[0] - pixel)
        for view, pixel in zip(seen.views, seen.pixels, strict=True)
    ]
    return np.nan_to_num(np.array(off, np.float64), nan=np.inf)


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
