"""Place of the reading of an unfinished feature, in pixels; no Qt, no VTK.

It is beside the cursor if it covers nothing of the picked line there, else at an edge of the view,
else anywhere in the view. It stays on its side as long as that is free, and comes back from an edge
only into ample room, so that it does not jump about.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray

Size = tuple[float, float]
Box = tuple[float, float, float, float]
"""x, y of the top left corner, width, height."""

EDGE = 4.0
"""Pixels between the reading and the edge of the view."""
_ROUND_LINES, _TO_TAKE, _TO_RETURN = 8.0, 14.0, 40.0
"""Pixels that stay free all round lines and vertices: where the reading stands, where it goes
anew, and where it comes back to the cursor from an edge."""
_ROUND_CURSOR = 10.0
_ONWARDS = 120.0
_CURSOR_COSTS, _VERTEX_COSTS = 1e5, 40.0
_BESIDE = 6
_GRID = 16


def _nothing() -> FloatArray:
    return np.zeros((0, 2))


@dataclass(frozen=True, eq=False)
class Picked:
    """What must stay in sight, in pixels.

    line : (k, 2) vertices, joined in order; not finite where behind the viewer
    cursor : (2,) where the mouse is
    rubber : (2,) where the band from the last vertex ends, or None
    dots : (d, 2) other places, such as on the border of a painted area
    clear : half the width of the brush round the cursor
    """

    line: FloatArray
    cursor: tuple[float, float]
    rubber: FloatArray | None = None
    dots: FloatArray = field(default_factory=_nothing)
    clear: float = 0.0

    def segments(self) -> FloatArray:
        """(s, 4) x, y of both ends of all lines that are drawn."""
        line = np.asarray(self.line, float).reshape(-1, 2)
        if self.rubber is not None and len(line):
            line = np.vstack([line, self.rubber])
        found = np.hstack([line[:-1], line[1:]]) if len(line) > 1 else np.zeros((0, 4))
        return np.asarray(found[np.isfinite(found).all(axis=1)])

    def points(self) -> FloatArray:
        """(p, 2) vertices and dots that are in front of the viewer."""
        both = np.vstack([np.asarray(self.line, float).reshape(-1, 2), self.dots.reshape(-1, 2)])
        return np.asarray(both[np.isfinite(both).all(axis=1)])

    def onwards(self) -> FloatArray:
        """(0 or 1, 4) where the line goes on if it keeps its direction: what is picked next."""
        line = np.asarray(self.line, float).reshape(-1, 2)
        if not len(line) or not np.isfinite(line[-1]).all():
            return np.zeros((0, 4))
        way = np.array(self.cursor) - line[-1]
        length = float(np.hypot(*way))
        if length < 30.0:
            return np.zeros((0, 4))
        return np.concatenate([self.cursor, self.cursor + way / length * _ONWARDS])[None]


class ReadingPlace:
    """side : which of the places was taken last
    box : where the reading was drawn last, or None"""

    def __init__(self) -> None:
        self.side = 0
        self.box: Box | None = None

    def choose(self, sizes: list[Size], view: Size, picked: Picked) -> tuple[int, Box]:
        """Which of the sizes of the reading to draw, and where.

        sizes : of the whole reading, then of shorter forms, taken where the whole one finds no
            place; at least one
        view : width and height
        """
        for number, size in enumerate(sizes):
            places = _places(size, view, picked)
            side = self._free_side(places, picked)
            if side is not None:
                return number, self._take(side, places[side])
        number = len(sizes) - 1
        places = [*_places(sizes[number], view, picked), *_grid(sizes[number], view)]
        cost = [_covered(box, picked, _ROUND_LINES) for box in places]
        side = int(np.argmin(cost))
        if cost[self.side] <= cost[side]:
            side = self.side
        return number, self._take(side, places[side])

    def forget(self) -> None:
        """Nothing is drawn."""
        self.side, self.box = 0, None

    def _take(self, side: int, box: Box) -> Box:
        self.side, self.box = side, box
        return box

    def _free_side(self, places: list[Box], picked: Picked) -> int | None:
        onwards = picked.onwards()

        def free(side: int, margin: float, *, next_too: bool = False) -> bool:
            box = places[side]
            if _covered(box, picked, margin) > 0.0:
                return False
            return not next_too or float(_lengths_in(box, onwards).sum()) == 0.0

        beside = range(_BESIDE)
        is_usual = self.side < len(places)
        if self.side < _BESIDE:
            if free(self.side, _ROUND_LINES, next_too=True):
                return self.side
            back = _TO_TAKE
        else:
            back = _TO_RETURN
        for side in beside:
            if free(side, back, next_too=True):
                return side
        if is_usual and free(self.side, _ROUND_LINES):
            return self.side
        return next((side for side in range(len(places)) if free(side, _TO_TAKE)), None)


def _places(size: Size, view: Size, picked: Picked) -> list[Box]:
    """Six beside the cursor, then along the edges; all inside the view, as far as it is larger."""
    (wide, high), (width, height), (x, y) = size, view, picked.cursor
    right, left = x + max(20.0, picked.clear + 8.0), x - max(16.0, picked.clear + 8.0) - wide
    under, over = y + 18.0, y - 14.0 - high
    below, above = y + max(24.0, picked.clear + 12.0), y - max(20.0, picked.clear + 12.0) - high
    middle = x - wide / 2.0
    far_x, far_y = width - EDGE - wide, height - EDGE - high
    mid_x, mid_y = (width - wide) / 2.0, (height - high) / 2.0
    corners = [
        (right, under),
        (right, over),
        (left, under),
        (left, over),
        (middle, below),
        (middle, above),
        # Compass and scale bar stand in the lower corners: those come last.
        (EDGE, EDGE),
        (far_x, EDGE),
        (mid_x, EDGE),
        (EDGE, mid_y),
        (far_x, mid_y),
        (mid_x, far_y),
        (EDGE, far_y),
        (far_x, far_y),
    ]
    return [(max(EDGE, min(a, far_x)), max(EDGE, min(b, far_y)), wide, high) for a, b in corners]


def _grid(size: Size, view: Size) -> list[Box]:
    """Return a grid of places over the view, for lines that cover all preferred places."""
    (wide, high), (width, height) = size, view
    columns = np.linspace(EDGE, max(width - EDGE - wide, EDGE), _GRID)
    rows = np.linspace(EDGE, max(height - EDGE - high, EDGE), _GRID)
    return [(float(x), float(y), wide, high) for y in rows for x in columns]


def _covered(box: Box, picked: Picked, margin: float) -> float:
    """How much of what is picked lies under a box or nearer to it than `margin`: pixels of lines,
    with vertices and above all the cursor counted as many pixels each."""
    x, y, wide, high = box
    wider = (x - margin, y - margin, wide + 2 * margin, high + 2 * margin)
    cost = float(_lengths_in(wider, picked.segments()).sum())
    points = picked.points()
    cost += _VERTEX_COSTS * int(_inside(wider, points, 0.0).sum())
    reach = max(_ROUND_CURSOR, picked.clear)
    cost += _CURSOR_COSTS * int(_inside(box, np.array([picked.cursor], float), reach).sum())
    return cost


def _inside(box: Box, points: FloatArray, margin: float) -> BoolArray:
    x, y, wide, high = box
    low, top = np.array([x, y]) - margin, np.array([x + wide, y + high]) + margin
    return np.asarray(((points > low) & (points < top)).all(axis=1))


def _lengths_in(box: Box, segments: FloatArray) -> FloatArray:
    """(s,) length of each segment inside a box, after Liang and Barsky (1984, *ACM Trans. Graph.*
    3, 1)."""
    x, y, wide, high = box
    start, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    low, top = np.array([x, y]), np.array([x + wide, y + high])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, b = (low - start) / way, (top - start) / way
    still = way == 0.0
    within = (start >= low) & (start <= top)
    a = np.where(still, np.where(within, -np.inf, np.inf), a)
    b = np.where(still, np.where(within, np.inf, -np.inf), b)
    enter = np.clip(np.minimum(a, b).max(axis=1, initial=0.0), 0.0, None)
    leave = np.maximum(np.where(still & ~within, -np.inf, a), b).min(axis=1, initial=1.0)
    return np.asarray(np.clip(leave - enter, 0.0, None) * np.hypot(*way.T))
