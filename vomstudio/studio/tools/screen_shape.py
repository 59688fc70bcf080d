"""A shape that is being drawn over the picture, in the window's pixels."""

from __future__ import annotations

import math

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.element_selection import Combine
from vomstudio.studio.tools.interaction_types import Outline, PointerEvent
from vomstudio.studio.tools.selection_messages import Way

Place = tuple[float, float]

_CLOSE = 8.0
"""Pixels: a click so near the first corner closes a polygon, one so near the last does so too."""
_STEP = 2.0
"""Pixels between the places of a lasso."""


class DrawnShape:
    """A rectangle or lasso is drawn by one drag, a polygon by clicks. combine : what will be done
    with what lies inside"""

    def __init__(self, way: Way, combine: Combine, start: Place) -> None:
        self.way, self.combine = way, combine
        self._places: list[Place] = [start]
        self._cursor: Place = start

    @property
    def corners(self) -> int:
        """How many places have been set."""
        return len(self._places)

    def move(self, event: PointerEvent) -> None:
        """The cursor stands elsewhere."""
        self._cursor = (event.x, event.y)

    def drag(self, event: PointerEvent) -> None:
        """The cursor stands elsewhere, with the button held."""
        self.move(event)
        if self.way == "lasso" and math.dist(self._places[-1], self._cursor) >= _STEP:
            self._places.append(self._cursor)

    def corner(self, event: PointerEvent) -> bool:
        """A corner of a polygon; whether that closes it."""
        self.move(event)
        here = self._cursor
        near = min(math.dist(here, self._places[0]), math.dist(here, self._places[-1])) < _CLOSE
        if near:
            return self.why_not_close() is None
        self._places.append(here)
        return False

    def take_back(self) -> bool:
        """Without its last corner; False where nothing would be left."""
        if self.way != "polygon" or len(self._places) < 2:
            return False
        self._places.pop()
        return True

    def ring(self) -> list[Place]:
        """Its corners."""
        if self.way != "rectangle":
            return self._places
        (x0, y0), (x1, y1) = self._places[0], self._cursor
        return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]

    def why_not_close(self) -> Finding | None:
        """None where it is a shape already, else the reason as a sentence."""
        if self.way == "polygon" and len(self._places) < 3:
            return Finding("feature.too-few-points", count=3 - len(self._places), minimum=3)
        return None

    def hint(self) -> str:
        """What the next click does."""
        if self.way != "polygon":
            return tr("Releasing the button takes what lies inside; Esc lets the shape go.")
        if self.why_not_close() is not None:
            return tr("Click the next corner; Esc lets the polygon go.")
        return tr(
            "Click the next corner; Enter, or a click on the first corner, takes what lies inside; "
            "Backspace takes the last corner back; Esc lets the polygon go."
        )

    def outline(self) -> Outline:
        """As it is painted."""
        places = self.ring() if self.way == "rectangle" else self._places
        if self.way == "polygon":
            places = [*places, self._cursor]
        return Outline(tuple(places), len(places) > 2, self.combine == "subtract")
