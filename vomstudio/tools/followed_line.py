"""A line that follows a contact from way-point to way-point while it is being picked.

It holds what is known of the legs and asks for the others, one way-point to the next; answers come
when they are found, and those that nobody waits for any more are forgotten.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vomstudio.tools.interaction_types import Point

Array = npt.NDArray[np.float64]
Answer = Callable[["Array | str"], None]
"""Called with the vertices (n, 3) of a path in the model's file frame, or why there is none."""

_MOST_LEGS = 400


class PathFinder(Protocol):
    """Finds paths over models, beside the window."""

    def follow(
        self, model_id: str, cost: str, ends: tuple[Point, Point], *, live: bool, answer: Answer
    ) -> None:
        """Ask for the path between two places of a model, in its file frame. `answer` is called in
        the caller's thread, later. live : only the last of these is answered."""


class FollowedLine:
    """The legs of one line. cost : what is followed; None for straight legs.

    found : called when a leg has come; said : called with why there is none, once a leg
    """

    def __init__(
        self, finder: PathFinder, found: Callable[[], None], said: Callable[[str], None]
    ) -> None:
        self._finder, self._found, self._said = finder, found, said
        self.cost: str | None = None
        self._legs: dict[tuple[str, str, Point, Point], Array | None] = {}
        self._asked: set[tuple[str, str, Point, Point]] = set()
        self._live: tuple[str, str, Point, Point] | None = None

    def path(self, model_id: str, way_points: Sequence[Point], *, live: bool = False) -> Array:
        """(n, 3) through the way-points, straight where a leg is not known yet, which is asked for.

        live : a way-point is being dragged: of the legs that are missing only the last one comes
        """
        given = np.asarray(way_points, np.float64).reshape(-1, 3)
        if self.cost is None or len(given) < 2:
            return given
        parts = []
        for one, other in pairwise(way_points):
            leg = self.leg(model_id, one, other, live=live)
            parts.append(np.array([one, other]) if leg is None else leg)
        line = np.concatenate(parts)
        new = np.append(True, (np.diff(line, axis=0) != 0.0).any(axis=1))
        return np.asarray(line[new])

    def leg(self, model_id: str, one: Point, other: Point, *, live: bool) -> Array | None:
        """The path between two places; None while it is searched for, and where there is none."""
        if self.cost is None or one == other:
            return None
        key = (model_id, self.cost, one, other)
        if key in self._legs:
            return self._legs[key]
        if live:
            self._live = key
        elif key in self._asked:
            return None
        else:
            self._asked.add(key)
        self._finder.follow(
            model_id,
            self.cost,
            (one, other),
            live=live,
            answer=lambda found: self._keep(key, found),
        )
        return None

    def searching(self, model_id: str, way_points: Sequence[Point]) -> bool:
        """Whether a leg between these way-points has not come yet."""
        if self.cost is None:
            return False
        keys = ((model_id, self.cost, a, b) for a, b in pairwise(way_points) if a != b)
        return any(key not in self._legs for key in keys)

    def forget(self) -> None:
        """Nobody waits for a leg any more."""
        self._asked.clear()
        self._live = None

    def _keep(self, key: tuple[str, str, Point, Point], found: Array | str) -> None:
        awaited = key in self._asked
        self._asked.discard(key)
        if len(self._legs) > _MOST_LEGS:
            self._legs.clear()
        if isinstance(found, str):
            # Of the leg to the cursor nothing is said: the cursor is under way.
            if awaited:
                self._legs[key] = None
                self._said(found)
        else:
            self._legs[key] = found
        if awaited or self._live == key:
            self._found()
