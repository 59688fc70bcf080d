"""Marks of a point in photos that contradict each other, found by leaving one out at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cameras import View
from vomstudio.geometry.triangulation import triangulate
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

LEAST_PX = 20.0
"""A mark set by hand, in a photo whose lens is known badly, may be this far off and still be meant
for the point."""
_TIMES = 10.0
"""So many times as far off as the others are from each other."""
_CLEAR = 3.0
"""Leaving out any other mark must leave so many times as much, or which is wrong is not known."""


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


def agreeing(
    label: str, views: Sequence[View], pixels: Array
) -> tuple[npt.NDArray[np.int64], list[WrongMark]]:
    """(rows of the marks that agree, those that do not). Two marks that contradict each other are
    both kept: which is wrong can be told by the place of the point alone.

    pixels : (k, 2) where the k views show the point
    """
    wrong: list[WrongMark] = []
    rows = np.arange(len(views))
    while len(rows) >= 3:
        found = _worst([views[int(row)] for row in rows], pixels[rows])
        if found is None:
            break
        place, wanted = found
        row = int(rows[place])
        x, y = (float(v) for v in pixels[row])
        if wanted is None:
            wrong.append(WrongMark(label, views[row].name, (x, y), None))
            break
        there = (float(wanted[0]), float(wanted[1]))
        wrong.append(WrongMark(label, views[row].name, (x, y), there))
        rows = np.delete(rows, place)
    return rows, wrong


def meet(views: Sequence[View], pixels: Array, limit_px: float = LEAST_PX) -> bool:
    """Whether the rays of the marks meet in a place that no mark misses by more than a limit."""
    place = triangulate(views, pixels)
    return bool(np.isfinite(place).all() and misses(views, pixels, place).max() <= limit_px)


def misses(views: Sequence[View], pixels: Array, place: Array) -> Array:
    """(k,) pixels from each mark to the projection of a place (3,); infinite behind a camera."""
    if not np.isfinite(place).all():
        return np.full(len(views), np.inf)
    off = [
        np.linalg.norm(view.project(place)[0] - pixel)
        for view, pixel in zip(views, pixels, strict=True)
    ]
    return np.nan_to_num(np.array(off, np.float64), nan=np.inf)


def _worst(views: Sequence[View], pixels: Array) -> tuple[int, Array | None] | None:
    """The mark that the others contradict, and where these want it; None where all agree."""
    if meet(views, pixels):
        return None
    rows = np.arange(len(views))
    left, missed, places = [], [], []
    for row, view in enumerate(views):
        others = [views[int(other)] for other in rows if other != row]
        there = triangulate(others, pixels[rows != row])
        known = bool(np.isfinite(there).all())
        left.append(float(misses(others, pixels[rows != row], there).max()) if known else math.inf)
        places.append(view.project(there)[0] if known else np.full(2, np.nan))
        missed.append(float(np.linalg.norm(places[-1] - pixels[row])) if known else math.inf)
    best = int(np.argmin(left))
    if not math.isfinite(left[best]):
        return best, None
    if missed[best] <= max(LEAST_PX, _TIMES * left[best]):
        return None
    second = float(np.partition(left, 1)[1])
    clear = second >= _CLEAR * max(left[best], 1.0)
    return best, places[best] if clear and np.isfinite(places[best]).all() else None
