"""Detection of marks that contradict most other marks of the same point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.triangulation import triangulate
from vomstudio.registration.marks.mark_errors import Marks, mark_distances, robust_position

# Minimum number of marks that must agree before others are wrong; two rays nearly always intersect.
_MIN_CONSISTENT_MARKS = 3
# Minimum ratio of residuals if one of three marks is left out instead of another.
_MIN_RESIDUAL_RATIO = 3.0


@dataclass(frozen=True)
class WrongMark:
    """Mark that contradicts the other marks of its point.

    Attributes
    ----------
    photo : str
    at : (float, float)
        Pixel coordinates of the mark.
    expected : (float, float) or None
        Pixel coordinates expected from the other marks, or None if it is unknown which of several
        marks is wrong.
    """

    label: str
    photo: str
    at: tuple[float, float]
    expected: tuple[float, float] | None

    @property
    def finding(self) -> Finding:
        """Finding that states the label, the photo and the position of the mark."""
        x, y = self.at
        if self.expected is None:
            return Finding(
                "control.contradicting-marks", label=self.label, photo=self.photo, x=x, y=y
            )
        return Finding(
            "control.wrong-mark",
            label=self.label,
            photo=self.photo,
            x=x,
            y=y,
            wanted_x=self.expected[0],
            wanted_y=self.expected[1],
            distance_px=math.dist(self.at, self.expected),
        )


def find_consistent_marks(
    label: str, marks: Marks, limit_px: float
) -> tuple[IntArray, list[WrongMark]]:
    """Find the marks of a point that contradict most of its marks.

    Two marks that contradict each other are both kept, because only the position of the point shows
    which of them is wrong.

    Parameters
    ----------
    label : str
    marks : Marks
    limit_px : float
        Maximum distance of agreeing marks from the position of the point.

    Returns
    -------
    rows : (m,) array of int
        Rows of the marks that agree; all rows if it is unclear which marks are wrong.
    wrong : list of WrongMark
    """
    all_rows = np.arange(len(marks.views))
    if len(all_rows) < 3 or do_rays_intersect(marks, limit_px):
        return all_rows, []
    point = robust_position(marks)
    is_near = mark_distances(marks, point) <= limit_px
    if is_near.sum() >= _MIN_CONSISTENT_MARKS:
        point = triangulate(*marks.select(np.flatnonzero(is_near)))
        is_near = mark_distances(marks, point) <= limit_px
    if is_near.sum() >= _MIN_CONSISTENT_MARKS and 2 * is_near.sum() > len(all_rows):
        rows = np.flatnonzero(is_near)
        point = triangulate(*marks.select(rows))
        return rows, [
            _wrong_mark(label, marks, int(row), point) for row in np.flatnonzero(~is_near)
        ]
    worst_row, point = _find_worst_mark(marks)
    wrong_marks = [_wrong_mark(label, marks, worst_row, point)]
    return (
        all_rows if wrong_marks[0].expected is None else np.delete(all_rows, worst_row)
    ), wrong_marks


def find_misplaced_marks(
    label: str, marks: Marks, position: FloatArray, limit_px: float, outlier_px: float
) -> tuple[IntArray, list[WrongMark]]:
    """Find the marks of a point that contradict its surveyed position.

    Marks that agree with each other are correct, and the surveyed position may be wrong.

    Parameters
    ----------
    label : str
    marks : Marks
    position : (3,) array
        Surveyed position of the point in the frame of the views.
    limit_px : float
        Maximum distance of agreeing marks from the position of the point.
    outlier_px : float
        Distance from the surveyed position above which marks are wrong, unless all marks are.

    Returns
    -------
    rows : (m,) array of int
        Rows of the correct marks.
    wrong : list of WrongMark
    """
    is_far = mark_distances(marks, position) > max(limit_px, outlier_px)
    if not is_far.any() or is_far.all() or do_rays_intersect(marks, limit_px):
        return np.arange(len(is_far)), []
    wrong_marks = [_wrong_mark(label, marks, int(row), position) for row in np.flatnonzero(is_far)]
    return np.flatnonzero(~is_far), wrong_marks


def _wrong_mark(label: str, marks: Marks, row: int, position: FloatArray) -> WrongMark:
    """Return the wrong mark; the other marks intersect at `position` (3,), NaN if unknown."""
    view = marks.views[row]
    x, y = (float(v) for v in marks.pixels[row])
    pixels = view.project(position)[0] if np.isfinite(position).all() else np.full(2, np.nan)
    expected_pixel = (float(pixels[0]), float(pixels[1])) if np.isfinite(pixels).all() else None
    return WrongMark(label, view.name, (x, y), expected_pixel)


def do_rays_intersect(marks: Marks, limit_px: float) -> bool:
    """Return whether the rays of marks intersect near each mark.

    Parameters
    ----------
    marks : Marks
    limit_px : float
        Maximum distance from a mark.

    Returns
    -------
    bool
    """
    point = triangulate(*marks)
    return bool(np.isfinite(point).all() and mark_distances(marks, point).max() <= limit_px)


def _find_worst_mark(marks: Marks) -> tuple[int, FloatArray]:
    """Return the mark without which the others agree best, and the position they determine.

    The position is NaN if leaving out another mark is nearly as good.
    """
    rows = np.arange(len(marks.views))
    remaining_scatters, positions = [], []
    for row in rows:
        other_marks = marks.select(np.delete(rows, row))
        point = triangulate(*other_marks)
        positions.append(point)
        remaining_scatters.append(float(mark_distances(other_marks, point).max()))
    best_row = int(np.argmin(remaining_scatters))
    second = float(np.partition(remaining_scatters, 1)[1])
    is_clear = math.isfinite(remaining_scatters[best_row]) and second >= _MIN_RESIDUAL_RATIO * max(
        remaining_scatters[best_row], 1.0
    )
    return best_row, positions[best_row] if is_clear else np.full(3, np.nan)
