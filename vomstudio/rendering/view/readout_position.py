"""Position of the reading box of an unfinished feature, in pixels.

The box is placed beside the cursor if it does not cover the picked line there. Otherwise it is
placed at an edge of the view, or else anywhere in the view. It remains on its side as long as
that is free, and returns from an edge only if there is ample space, so that it does not jump.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray

Size = tuple[float, float]
PixelBox = tuple[float, float, float, float]
"""x and y of the upper-left corner, width and height."""

EDGE_MARGIN = 4.0
"""Distance between the box and the edge of the view, pixels."""
LINE_CLEARANCE, NEW_CLEARANCE, RETURN_CLEARANCE = 8.0, 14.0, 40.0
"""Required clearance from lines and vertices in pixels: at the present position, at a new position,
and for the return from an edge to the cursor."""
CURSOR_CLEARANCE = 10.0
AHEAD_LENGTH = 120.0
CURSOR_COST, VERTEX_COST = 1e5, 40.0
POSITIONS_AT_CURSOR = 6
GRID_SIZE = 16


def _empty_points() -> FloatArray:
    return np.zeros((0, 2))


@dataclass(frozen=True, eq=False)
class PickedPoints:
    """Picked points that must remain visible, in pixels.

    Parameters
    ----------
    line : (k, 2) float64
        Vertices of the line in order; not finite if behind the viewer.
    cursor : (float, float)
    rubber : (2,) float64, optional
        End of the rubber band from the last vertex.
    dots : (d, 2) float64
        Other points, such as the border of a painted area.
    clearance : float
        Half the width of the brush around the cursor.
    widget : PixelBox, optional
        Rectangle of a widget over the view, which the box avoids.
    """

    line: FloatArray
    cursor: tuple[float, float]
    rubber: FloatArray | None = None
    dots: FloatArray = field(default_factory=_empty_points)
    clearance: float = 0.0
    widget: PixelBox | None = None

    def segments(self) -> FloatArray:
        """Return the end points (s, 4: x, y, x, y) of all drawn line segments."""
        line = np.asarray(self.line, float).reshape(-1, 2)
        if self.rubber is not None and len(line):
            line = np.vstack([line, self.rubber])
        segments = np.hstack([line[:-1], line[1:]]) if len(line) > 1 else np.zeros((0, 4))
        return np.asarray(segments[np.isfinite(segments).all(axis=1)])

    def points(self) -> FloatArray:
        """Return the vertices and dots (p, 2) that are in front of the viewer."""
        points = np.vstack([np.asarray(self.line, float).reshape(-1, 2), self.dots.reshape(-1, 2)])
        return np.asarray(points[np.isfinite(points).all(axis=1)])

    def expected_segment(self) -> FloatArray:
        """Return the segment (0 or 1, 4) along which the next vertex is expected."""
        line = np.asarray(self.line, float).reshape(-1, 2)
        if not len(line) or not np.isfinite(line[-1]).all():
            return np.zeros((0, 4))
        direction = np.array(self.cursor) - line[-1]
        length = float(np.hypot(*direction))
        if length < 30.0:
            return np.zeros((0, 4))
        return np.concatenate([self.cursor, self.cursor + direction / length * AHEAD_LENGTH])[None]


class ReadingPosition:
    """Position of the reading box, which is updated with the view.

    Attributes
    ----------
    side : int
        Index of the last position.
    box : PixelBox or None
        Rectangle in which the reading was last drawn, or None.
    """

    def __init__(self) -> None:
        self.side = 0
        self.box: PixelBox | None = None

    def choose(
        self, sizes: list[Size], view: Size, picked_points: PickedPoints
    ) -> tuple[int, PixelBox]:
        """Choose the form of the reading and its position.

        Parameters
        ----------
        sizes : list of Size
            Sizes of the complete reading and of its shorter forms; at least one.
        view : Size
            Width and height of the view.
        picked_points : PickedPoints
        """
        for number, size in enumerate(sizes):
            positions = _candidate_boxes(size, view, picked_points)
            side = self._free_side(positions, picked_points)
            if side is not None:
                return number, self._use_side(side, positions[side])
        number = len(sizes) - 1
        positions = [
            *_candidate_boxes(sizes[number], view, picked_points),
            *_grid_boxes(sizes[number], view),
        ]
        cost = [_covered_length(box, picked_points, LINE_CLEARANCE) for box in positions]
        side = int(np.argmin(cost))
        if cost[self.side] <= cost[side]:
            side = self.side
        return number, self._use_side(side, positions[side])

    def clear_state(self) -> None:
        """Reset the position because no reading is drawn."""
        self.side, self.box = 0, None

    def _use_side(self, side: int, box: PixelBox) -> PixelBox:
        self.side, self.box = side, box
        return box

    def _free_side(self, positions: list[PixelBox], picked_points: PickedPoints) -> int | None:
        next_segment = picked_points.expected_segment()

        def is_free(side: int, margin: float, *, include_next: bool = False) -> bool:
            box = positions[side]
            if _covered_length(box, picked_points, margin) > 0.0:
                return False
            return not include_next or float(_lengths_inside(box, next_segment).sum()) == 0.0

        cursor_positions = range(POSITIONS_AT_CURSOR)
        is_preferred = self.side < len(positions)
        if self.side < POSITIONS_AT_CURSOR:
            if is_free(self.side, LINE_CLEARANCE, include_next=True):
                return self.side
            clearance = NEW_CLEARANCE
        else:
            clearance = RETURN_CLEARANCE
        for side in cursor_positions:
            if is_free(side, clearance, include_next=True):
                return side
        if is_preferred and is_free(self.side, LINE_CLEARANCE):
            return self.side
        return next((side for side in range(len(positions)) if is_free(side, NEW_CLEARANCE)), None)


def _candidate_boxes(size: Size, view: Size, picked_points: PickedPoints) -> list[PixelBox]:
    """Return the candidate positions: six at the cursor, then those along the edges."""
    (box_width, box_height), (width, height), (x, y) = size, view, picked_points.cursor
    x_right, x_left = (
        x + max(20.0, picked_points.clearance + 8.0),
        x - max(16.0, picked_points.clearance + 8.0) - box_width,
    )
    y_below, y_above = y + 18.0, y - 14.0 - box_height
    below, above = (
        y + max(24.0, picked_points.clearance + 12.0),
        y - max(20.0, picked_points.clearance + 12.0) - box_height,
    )
    centre = x - box_width / 2.0
    x_max, y_max = width - EDGE_MARGIN - box_width, height - EDGE_MARGIN - box_height
    mid_x, mid_y = (width - box_width) / 2.0, (height - box_height) / 2.0
    corners = [
        (x_right, y_below),
        (x_right, y_above),
        (x_left, y_below),
        (x_left, y_above),
        (centre, below),
        (centre, above),
        # The lower corners come last, because they contain the compass and the scale bar.
        (EDGE_MARGIN, EDGE_MARGIN),
        (x_max, EDGE_MARGIN),
        (mid_x, EDGE_MARGIN),
        (EDGE_MARGIN, mid_y),
        (x_max, mid_y),
        (mid_x, y_max),
        (EDGE_MARGIN, y_max),
        (x_max, y_max),
    ]
    return [
        (max(EDGE_MARGIN, min(a, x_max)), max(EDGE_MARGIN, min(b, y_max)), box_width, box_height)
        for a, b in corners
    ]


def _grid_boxes(size: Size, view: Size) -> list[PixelBox]:
    """Return a grid of positions over the view, used if all preferred positions are covered."""
    (box_width, box_height), (width, height) = size, view
    columns = np.linspace(EDGE_MARGIN, max(width - EDGE_MARGIN - box_width, EDGE_MARGIN), GRID_SIZE)
    rows = np.linspace(EDGE_MARGIN, max(height - EDGE_MARGIN - box_height, EDGE_MARGIN), GRID_SIZE)
    return [(float(x), float(y), box_width, box_height) for y in rows for x in columns]


def _covered_length(box: PixelBox, picked_points: PickedPoints, margin: float) -> float:
    """Return the cost of a box that covers or is close to the picked points.

    The cost is the length of covered lines in pixels; each vertex, and especially the cursor,
    counts as many pixels.
    """
    x, y, box_width, box_height = box
    widened_box = (x - margin, y - margin, box_width + 2 * margin, box_height + 2 * margin)
    cost = float(_lengths_inside(widened_box, picked_points.segments()).sum())
    points = picked_points.points()
    cost += VERTEX_COST * int(_is_inside(widened_box, points, 0.0).sum())
    max_distance = max(CURSOR_CLEARANCE, picked_points.clearance)
    cost += CURSOR_COST * int(
        _is_inside(box, np.array([picked_points.cursor], float), max_distance).sum()
    )
    if picked_points.widget is not None and _overlaps(box, picked_points.widget):
        cost += CURSOR_COST
    return cost


def _overlaps(box: PixelBox, other_box: PixelBox) -> bool:
    (x, y, width, height), (other_x, other_y, other_width, other_height) = box, other_box
    overlaps_in_x = x < other_x + other_width and other_x < x + width
    return overlaps_in_x and y < other_y + other_height and other_y < y + height


def _is_inside(box: PixelBox, points: FloatArray, margin: float) -> BoolArray:
    x, y, box_width, box_height = box
    low, top = np.array([x, y]) - margin, np.array([x + box_width, y + box_height]) + margin
    return np.asarray(((points > low) & (points < top)).all(axis=1))


def _lengths_inside(box: PixelBox, segments: FloatArray) -> FloatArray:
    """Return the length (s,) of each segment inside a box (Liang & Barsky 1984)."""
    x, y, box_width, box_height = box
    start, direction = segments[:, :2], segments[:, 2:] - segments[:, :2]
    low, top = np.array([x, y]), np.array([x + box_width, y + box_height])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, b = (low - start) / direction, (top - start) / direction
    is_parallel = direction == 0.0
    is_within = (start >= low) & (start <= top)
    a = np.where(is_parallel, np.where(is_within, -np.inf, np.inf), a)
    b = np.where(is_parallel, np.where(is_within, np.inf, -np.inf), b)
    enter = np.clip(np.minimum(a, b).max(axis=1, initial=0.0), 0.0, None)
    leave_distances = np.maximum(np.where(is_parallel & ~is_within, -np.inf, a), b).min(
        axis=1, initial=1.0
    )
    return np.asarray(np.clip(leave_distances - enter, 0.0, None) * np.hypot(*direction.T))
