"""Shape that is drawn over the picture, in window pixels."""

from __future__ import annotations

import math

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.element_selection import Combine
from vomstudio.studio.tools.interaction_types import Outline, PointerEvent
from vomstudio.studio.tools.selection_messages import ShapeMode

ScreenPoint = tuple[float, float]

CLOSING_DISTANCE_PX = 8.0
"""Maximum distance from the first or last corner at which a click closes a polygon."""
MIN_STEP_PX = 2.0
"""Minimum distance between the vertices of a lasso."""


class DrawnShape:
    """Rectangle or lasso drawn by one drag, or polygon drawn by clicks.

    `combine` defines how the elements inside are combined with the selection.
    """

    def __init__(self, mode: ShapeMode, combine: Combine, start: ScreenPoint) -> None:
        self.mode, self.combine = mode, combine
        self._vertices: list[ScreenPoint] = [start]
        self._cursor: ScreenPoint = start

    @property
    def corners(self) -> int:
        """Number of corners drawn so far."""
        return len(self._vertices)

    def move(self, event: PointerEvent) -> None:
        """Move the cursor."""
        self._cursor = (event.x, event.y)

    def drag(self, event: PointerEvent) -> None:
        """Move the cursor while the button is pressed."""
        self.move(event)
        if self.mode == "lasso" and math.dist(self._vertices[-1], self._cursor) >= MIN_STEP_PX:
            self._vertices.append(self._cursor)

    def corner(self, event: PointerEvent) -> bool:
        """Add a corner to a polygon, or return True if the position closes the polygon."""
        self.move(event)
        cursor = self._cursor
        distance = (
            min(math.dist(cursor, self._vertices[0]), math.dist(cursor, self._vertices[-1]))
            < CLOSING_DISTANCE_PX
        )
        if distance:
            return self.close_problem() is None
        self._vertices.append(cursor)
        return False

    def remove_last_corner(self) -> bool:
        """Remove the last corner. Return False if no corner remains."""
        if self.mode != "polygon" or len(self._vertices) < 2:
            return False
        self._vertices.pop()
        return True

    def ring(self) -> list[ScreenPoint]:
        """Return the corners of the closed shape."""
        if self.mode != "rectangle":
            return self._vertices
        (x0, y0), (x1, y1) = self._vertices[0], self._cursor
        return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]

    def close_problem(self) -> Finding | None:
        """Return why the shape is not complete, or None if it is."""
        if self.mode == "polygon" and len(self._vertices) < 3:
            return Finding("feature.too-few-points", count=3 - len(self._vertices), minimum=3)
        return None

    def hint(self) -> str:
        """Describe the effect of the next click."""
        if self.mode != "polygon":
            return tr("Release the button to close the shape; press Esc to discard it.")
        if self.close_problem() is not None:
            return tr("Click the next corner; press Esc to discard the polygon.")
        return tr(
            "Click the next corner, or the first one (or Enter) to close the polygon; press"
            " Backspace to remove a corner, Esc to discard the polygon."
        )

    def outline(self) -> Outline:
        """Return the outline of the shape for painting."""
        positions = self.ring() if self.mode == "rectangle" else self._vertices
        if self.mode == "polygon":
            positions = [*positions, self._cursor]
        return Outline(tuple(positions), len(positions) > 2, self.combine == "subtract")
