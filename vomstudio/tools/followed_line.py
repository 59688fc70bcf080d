"""A line that follows a contact from way-point to way-point while it is being picked.

It holds what is known of the legs and asks for the others, one way-point to the next; answers come
when they are found, and those that nobody waits for any more are forgotten.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vomstudio.extraction.path_costs import OF_COLOURS
from vomstudio.tools.interaction_types import Point
from vomstudio.words import tr, tr_n

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Way:
    """points : (n, 3) of a path, in the model's file frame

    photo : the one in which it was followed; "" over the surface
    voters : the other photos that had a say; judged, confirmed : how many of the points these could
    judge, and on how many at least half of them show the same
    said : what the user should know of it
    final : False for a way to the cursor, in which other photos had no say yet
    """

    points: Array
    photo: str = ""
    voters: tuple[str, ...] = ()
    judged: int = 0
    confirmed: int = 0
    said: str = ""
    final: bool = True


Answer = Callable[[Way | str], None]
"""Called with a path, or why there is none."""
Key = tuple[str, str, Point, Point, str]

_MOST_LEGS = 400


class PathFinder(Protocol):
    """Finds paths over models, beside the window."""

    def follow(
        self,
        model_id: str,
        cost: str,
        ends: tuple[Point, Point],
        *,
        photo: str = "",
        live: bool,
        answer: Answer,
    ) -> None:
        """Ask for the path between two places of a model, in its file frame. `answer` is called in
        the caller's thread, later. photo : the one in whose pixels it is followed; "" for the
        surface. live : only the last of these is answered."""


class FollowedLine:
    """The legs of one line. cost : what is followed; None for straight legs. in_photos : a leg
    whose end was set in a photo is followed there, where the cost is one of photos.

    found : called when a leg has come; said : called with why there is none, once a leg
    """

    def __init__(
        self, finder: PathFinder, found: Callable[[], None], said: Callable[[str], None]
    ) -> None:
        self._finder, self._found, self._said = finder, found, said
        self.cost: str | None = None
        self.in_photos = True
        self._photos: dict[Point, str] = {}
        self._legs: dict[Key, Way | None] = {}
        self._asked: set[Key] = set()
        self._live: Key | None = None

    def set_in(self, photo: str, place: Point) -> None:
        """A way-point, or the cursor, was brought to this place in a photo; "" for elsewhere."""
        if photo:
            self._photos[place] = photo
        else:
            self._photos.pop(place, None)

    def photo_of(self, place: Point) -> str:
        """The photo in which a way-point was set; "" for elsewhere."""
        return self._photos.get(place, "")

    def ways(self, model_id: str, way_points: Sequence[Point]) -> list[Way]:
        """Those legs that are known."""
        keys = (self._key(model_id, a, b) for a, b in pairwise(way_points))
        return [way for key in keys if (way := self._legs.get(key)) is not None]

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
        key = self._key(model_id, one, other)
        known = self._legs.get(key)
        points = None if known is None else known.points
        if live and key not in self._legs:
            self._live = key
        elif live or self._has(key) or key in self._asked:
            return points
        else:
            self._asked.add(key)
        self._finder.follow(
            model_id,
            self.cost,
            (one, other),
            photo=key[4],
            live=live,
            answer=lambda found: self._keep(key, found),
        )
        return points

    def _key(self, model_id: str, one: Point, other: Point) -> Key:
        photo = self.photo_of(other) if self.in_photos and self.cost in OF_COLOURS else ""
        return model_id, self.cost or "", one, other, photo

    def _has(self, key: Key) -> bool:
        """Nothing more is to come of a leg."""
        known = self._legs.get(key)
        return key in self._legs if known is None else known.final

    def searching(self, model_id: str, way_points: Sequence[Point]) -> bool:
        """Whether a leg between these way-points has not come yet."""
        if self.cost is None:
            return False
        keys = (self._key(model_id, a, b) for a, b in pairwise(way_points) if a != b)
        return any(not self._has(key) for key in keys)

    def forget(self) -> None:
        """Nobody waits for a leg any more."""
        self._asked.clear()
        self._live = None

    def _keep(self, key: Key, found: Way | str) -> None:
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
            if found.final or not self._has(key):
                self._legs[key] = found
            if awaited and found.said:
                self._said(found.said)
        if awaited or self._live == key:
            self._found()


def photo_votes(ways: Sequence[Way]) -> str | None:
    """In which photos these were followed, and what the others say, in sentences; None for none."""
    if not ways:
        return None
    said = tr(
        "Followed in the pixels of {photos}.",
        photos=", ".join(dict.fromkeys(way.photo.rpartition("/")[2] for way in ways)),
    )
    judged = sum(way.judged for way in ways)
    if not judged:
        if not all(way.final for way in ways):
            return said
        return f"{said} {tr('No other photo could judge it.')}"
    voters = {voter for way in ways for voter in way.voters}
    votes = tr_n(
        "{count} other photo was asked, which shows the same on {percent:.0f} % of the line.",
        "{count} other photos were asked, which show the same on {percent:.0f} % of the line.",
        len(voters),
        percent=100.0 * sum(way.confirmed for way in ways) / judged,
    )
    return f"{said} {votes}"
