"""Marks of a point in photos that contradict most others of the same point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.triangulation import triangulate
from vomstudio.registration.marks.mark_errors import Marks, mark_distances, robust_place

# Marks that must agree before others are called wrong: two always nearly meet.
_MIN_AGREEING = 3
# Of three marks, leaving out any other one must leave so many times as much.
_CLEAR = 3.0


@dataclass(frozen=True)
class WrongMark:
    """photo : its name; at, wanted : (x, y) where it is and where the other marks of the point say
    that it should be, in pixels; wanted is None where only one of several can be wrong, and it is
    not known which"""

    label: str
    photo: str
    at: tuple[float, float]
    wanted: tuple[float, float] | None

    @property
    def finding(self) -> Finding:
        """The mark as a finding that names label, photo and place."""
        x, y = self.at
        if self.wanted is None:
            return Finding(
                "control.contradicting-marks", label=self.label, photo=self.photo, x=x, y=y
            )
        return Finding(
            "control.wrong-mark",
            label=self.label,
            photo=self.photo,
            x=x,
            y=y,
            wanted_x=self.wanted[0],
            wanted_y=self.wanted[1],
            distance_px=math.dist(self.at, self.wanted),
        )


def agreeing(label: str, marks: Marks, limit_px: float) -> tuple[IntArray, list[WrongMark]]:
    """Find the marks of a point that contradict most of its marks.

    Two marks that contradict each other are both kept: only the place of the point can tell which
    is wrong.

    Parameters
    ----------
    label : str
    marks : Marks
    limit_px : float
        Distance from the place of the point up to which marks agree.

    Returns
    -------
    rows : (m,) array of int
        Marks that agree; all if it is not clear which are wrong.
    wrong : list of WrongMark
    """
    every = np.arange(len(marks.views))
    if len(every) < 3 or meet(marks, limit_px):
        return every, []
    place = robust_place(marks)
    near = mark_distances(marks, place) <= limit_px
    if near.sum() >= _MIN_AGREEING:
        place = triangulate(*marks.select(np.flatnonzero(near)))
        near = mark_distances(marks, place) <= limit_px
    if near.sum() >= _MIN_AGREEING and 2 * near.sum() > len(every):
        rows = np.flatnonzero(near)
        place = triangulate(*marks.select(rows))
        return rows, [_wrong(label, marks, int(row), place) for row in np.flatnonzero(~near)]
    worst, place = _worst(marks)
    wrong = [_wrong(label, marks, worst, place)]
    return (every if wrong[0].wanted is None else np.delete(every, worst)), wrong


def misplaced(
    label: str, marks: Marks, place: FloatArray, limit_px: float, far_px: float
) -> tuple[IntArray, list[WrongMark]]:
    """Find the marks of a point that contradict its surveyed place.

    Marks that agree with each other are right, and the place may be wrong.

    Parameters
    ----------
    label : str
    marks : Marks
    place : (3,) array
        Of the point, in the frame of the views.
    limit_px : float
        Distance from the place of the point up to which marks agree.
    far_px : float
        Distance from the surveyed place above which marks are wrong, unless all are.

    Returns
    -------
    rows : (m,) array of int
        Marks that are right.
    wrong : list of WrongMark
    """
    far = mark_distances(marks, place) > max(limit_px, far_px)
    if not far.any() or far.all() or meet(marks, limit_px):
        return np.arange(len(far)), []
    wrong = [_wrong(label, marks, int(row), place) for row in np.flatnonzero(far)]
    return np.flatnonzero(~far), wrong


def _wrong(label: str, marks: Marks, row: int, place: FloatArray) -> WrongMark:
    """place : (3,) where the other marks of the point meet, NaN if it is not known"""
    view = marks.views[row]
    x, y = (float(v) for v in marks.pixels[row])
    there = view.project(place)[0] if np.isfinite(place).all() else np.full(2, np.nan)
    wanted = (float(there[0]), float(there[1])) if np.isfinite(there).all() else None
    return WrongMark(label, view.name, (x, y), wanted)


def meet(marks: Marks, limit_px: float) -> bool:
    """Whether the rays of the marks meet in a place that no mark misses by more than a limit."""
    place = triangulate(*marks)
    return bool(np.isfinite(place).all() and mark_distances(marks, place).max() <= limit_px)


def _worst(marks: Marks) -> tuple[int, FloatArray]:
    """The mark without which the others agree best, and where these meet; NaN if leaving out
    another one is nearly as good."""
    rows = np.arange(len(marks.views))
    remaining, places = [], []
    for row in rows:
        others = marks.select(np.delete(rows, row))
        place = triangulate(*others)
        places.append(place)
        remaining.append(float(mark_distances(others, place).max()))
    best = int(np.argmin(remaining))
    second = float(np.partition(remaining, 1)[1])
    is_clear = math.isfinite(remaining[best]) and second >= _CLEAR * max(remaining[best], 1.0)
    return best, places[best] if is_clear else np.full(3, np.nan)
