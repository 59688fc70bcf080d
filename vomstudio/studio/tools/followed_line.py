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

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.extraction.path_costs import OF_COLOURS
from vomstudio.studio.tools.interaction_types import Point


@dataclass(frozen=True, eq=False)
class Way:
    """points : (n, 3) of a path, in the model's file frame

    photo : the one in which it was followed; "" over the surface
    voters : the other photos that had a say; judged, confirmed : how many of the points these could
    judge, and on how many at least half of them show the same
    warnings : about the way and the photos that judged it
    costs : (n,) of a metre at each point, in medians of what is around; None where not known
    final : False for a way to the cursor, in which other photos had no say yet
    """

    points: FloatArray
    photo: str = ""
    voters: tuple[str, ...] = ()
    judged: int = 0
    confirmed: int = 0
    warnings: tuple[Finding, ...] = ()
    final: bool = True
    costs: FloatArray | None = None


Answer = Callable[[Way | Finding], None]
"""Called with a path, or why there is none."""
Key = tuple[str, str, Point, Point, str]
Rank = tuple[int, float]
Range = tuple[int, int]
AUTO = "auto"

_MOST_LEGS = 1000


class PathFinder(Protocol):
    """Finds paths over models, beside the window."""

    def costs(self, model_id: str) -> tuple[str, ...]:
        """Those that a model has, without its fields."""

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
    """The legs of one line. cost : what is followed; None for straight legs, AUTO for the one of
    all whose line tells its plane best. in_photos : a leg whose end was set in a photo is followed
    there, where the cost is one of photos.

    found : called when a leg has come; said : called with why there is none, once a leg
    rank : by which lines (n, 3) on a model through way-points, followed by a cost, are ordered, the
    best first
    """

    def __init__(
        self,
        finder: PathFinder,
        found: Callable[[], None],
        said: Callable[[Finding], None],
        rank: Callable[[str, FloatArray, Sequence[Point], str], Rank],
    ) -> None:
        self._finder, self._found, self._said, self._rank = finder, found, said, rank
        self.cost: str | None = None
        self._best: tuple[object, str] | None = None
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
        by = self.by(model_id)
        keys = (self._key(model_id, a, b, by) for a, b in pairwise(way_points))
        return [way for key in keys if (way := self._legs.get(key)) is not None]

    def path(self, model_id: str, way_points: Sequence[Point], *, live: bool = False) -> FloatArray:
        """(n, 3) through the way-points, straight where a leg is not known yet, which is asked for.

        live : a way-point is being dragged: of the legs that are missing only the last one comes
        """
        given = np.asarray(way_points, np.float64).reshape(-1, 3)
        if self.cost is None or len(given) < 2:
            return given
        if self.cost == AUTO and not live:
            self._choose(model_id, tuple(way_points))
        by = self.by(model_id)
        legs = [self._leg(model_id, a, b, by, live=live) for a, b in pairwise(way_points)]
        return _joined(way_points, legs)

    def doubtful(
        self, model_id: str, way_points: Sequence[Point], resolution: float, cost: str = ""
    ) -> tuple[Range, ...]:
        """First and last row of `path` of the stretches that may be on another contact.

        resolution : of the model, in the unit of its file; cost : by which it is followed, the one
        of now where that is ""
        """
        from vomstudio.extraction.path_jumps import find_jumps

        by = cost or self.by(model_id)
        ways = [self._legs.get(self._key(model_id, a, b, by)) for a, b in pairwise(way_points)]
        known = [way for way in ways if way is not None and way.costs is not None]
        if not known or len(known) < len(ways):
            return ()
        line = np.concatenate([way.points for way in known])
        costs = np.concatenate([way.costs for way in known if way.costs is not None])
        new = _new_places(line)
        at = np.cumsum(new)[np.cumsum([len(way.points) for way in known]) - 1] - 1
        return find_jumps(line[new], costs[new], np.append(0, at), resolution)

    def by(self, model_id: str) -> str:
        """The cost by which a line on a model is followed now: of AUTO the best so far."""
        if self.cost != AUTO:
            return self.cost or ""
        costs = self._finder.costs(model_id)
        if self._best is not None and self._best[1] in costs:
            return self._best[1]
        return costs[0]

    def _choose(self, model_id: str, way_points: tuple[Point, ...]) -> None:
        """The best of the costs, once the line is known by each; until then the one before."""
        costs = self._candidates(model_id, way_points)
        if self._best is not None and self._best[0] == (model_id, way_points, costs):
            return
        ranks: list[tuple[Rank, int]] = []
        waiting = False
        for number, cost in enumerate(costs):
            legs = [self._leg(model_id, a, b, cost, live=False) for a, b in pairwise(way_points)]
            known = [
                self._has(self._key(model_id, a, b, cost))
                for a, b in pairwise(way_points)
                if a != b
            ]
            waiting = waiting or not all(known)
            if any(leg is not None for leg in legs):
                rank = self._rank(model_id, _joined(way_points, legs), way_points, cost)
                ranks.append((rank, number))
        if not waiting:
            best = costs[min(ranks)[1]] if ranks else costs[0]
            self._best = (model_id, way_points, costs), best

    def _candidates(self, model_id: str, way_points: Sequence[Point]) -> tuple[str, ...]:
        """What is tried where the best is asked for: in photos what photos have."""
        costs = self._finder.costs(model_id)
        seen = self.in_photos and any(self.photo_of(place) for place in way_points)
        of_photos = tuple(cost for cost in costs if cost in OF_COLOURS)
        return of_photos if seen and of_photos else costs

    def leg(self, model_id: str, one: Point, other: Point, *, live: bool) -> FloatArray | None:
        """The path between two places; None while it is searched for, and where there is none."""
        if self.cost is None:
            return None
        return self._leg(model_id, one, other, self.by(model_id), live=live)

    def _leg(
        self, model_id: str, one: Point, other: Point, cost: str, *, live: bool
    ) -> FloatArray | None:
        if one == other:
            return None
        key = self._key(model_id, one, other, cost)
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
            cost,
            (one, other),
            photo=key[4],
            live=live,
            answer=lambda found: self._keep(key, found),
        )
        return points

    def _key(self, model_id: str, one: Point, other: Point, cost: str) -> Key:
        photo = self.photo_of(other) if self.in_photos and cost in OF_COLOURS else ""
        return model_id, cost, one, other, photo

    def _has(self, key: Key) -> bool:
        """Nothing more is to come of a leg."""
        known = self._legs.get(key)
        return key in self._legs if known is None else known.final

    def searching(self, model_id: str, way_points: Sequence[Point]) -> bool:
        """Whether a leg between these way-points has not come yet."""
        if self.cost is None:
            return False
        costs = [self.by(model_id)]
        if self.cost == AUTO:
            costs = list(self._candidates(model_id, way_points))
        keys = (
            self._key(model_id, a, b, cost)
            for cost in costs
            for a, b in pairwise(way_points)
            if a != b
        )
        return any(not self._has(key) for key in keys)

    def forget(self) -> None:
        """Nobody waits for a leg any more."""
        self._asked.clear()
        self._live = None

    def _keep(self, key: Key, found: Way | Finding) -> None:
        awaited = key in self._asked
        self._asked.discard(key)
        if len(self._legs) > _MOST_LEGS:
            self._legs.clear()
        if isinstance(found, Finding):
            # Of the leg to the cursor nothing is said: the cursor is under way.
            if awaited:
                self._legs[key] = None
                if self._tells(key):
                    self._said(found)
        else:
            if found.final or not self._has(key):
                self._legs[key] = found
            if awaited and self._tells(key):
                for warning in found.warnings:
                    self._said(warning)
        if awaited or self._live == key:
            self._found()

    def _tells(self, key: Key) -> bool:
        """Of the costs that are tried for the best one speaks for all."""
        return self.cost != AUTO or key[1] == self._finder.costs(key[0])[0]


def _joined(way_points: Sequence[Point], legs: Sequence[FloatArray | None]) -> FloatArray:
    """(n, 3) one line of the legs, straight where there is none."""
    parts = [
        np.array(ends) if leg is None else leg
        for ends, leg in zip(pairwise(way_points), legs, strict=True)
    ]
    line = np.concatenate(parts)
    return np.asarray(line[_new_places(line)])


def _new_places(line: FloatArray) -> BoolArray:
    """(n,) where a point is not the one before once more."""
    return np.append(True, (np.diff(line, axis=0) != 0.0).any(axis=1))


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
