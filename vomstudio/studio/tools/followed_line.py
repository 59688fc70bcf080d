"""Line that follows a contact from way-point to way-point while it is being picked.

The line caches the known legs between consecutive way-points and requests the missing ones.
Results that are no longer needed are discarded.
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
from vomstudio.extraction.path_costs import COLOUR_COSTS
from vomstudio.studio.tools.interaction_types import Point


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """Path between two way-points.

    Parameters
    ----------
    points : (n, 3) float64
        Points in the file frame of the model.
    photo : str
        Photo in which the path was followed, or "" if it was followed over the surface.
    voters : tuple of str
        Names of the other photos that were compared.
    checked_count, confirmed_count : int
        Number of points that could be checked in these photos, and number of points confirmed by
        at least half of the photos.
    warnings : tuple of Finding
        Findings about the path and the photos that were used to check it.
    is_final : bool
        Whether all checks were made; False for a path to the cursor in a photo, which is not
        compared with other photos.
    costs : (n,) float64 or None
        Cost per metre at each point relative to the median of its surroundings, or None if
        unknown.
    """

    points: FloatArray
    photo: str = ""
    voters: tuple[str, ...] = ()
    checked_count: int = 0
    confirmed_count: int = 0
    warnings: tuple[Finding, ...] = ()
    is_final: bool = True
    costs: FloatArray | None = None


PathCallback = Callable[[FollowedPath | Finding], None]
"""Callback that receives a path, or the reason why no path was found."""
Key = tuple[str, str, Point, Point, str]
Rank = tuple[int, float]
Range = tuple[int, int]
AUTO = "auto"

MAX_CACHED_LEGS = 1000


class PathFinder(Protocol):
    """Protocol of a finder of paths over models, which works in the background."""

    def costs(self, model_id: str) -> tuple[str, ...]:
        """Return the names of the costs available for a model, except costs by its fields."""

    def follow(
        self,
        model_id: str,
        cost: str,
        ends: tuple[Point, Point],
        *,
        photo: str = "",
        is_live: bool,
        callback: PathCallback,
    ) -> None:
        """Request the path between two points on a model.

        Parameters
        ----------
        model_id : str
        cost : str
            Name of the cost.
        ends : tuple of Point
            End points of the path, in the file frame of the model.
        photo : str
            Photo in whose pixels the path is followed, or "" to follow it over the surface.
        is_live : bool
            Whether a later live request replaces this one if it is still pending.
        callback : callable
            Called with the result later, in the caller's thread.
        """


class FollowedLine:
    """Line through way-points, with the legs that follow a contact.

    Parameters
    ----------
    finder : PathFinder
    on_leg : callable
        Called when a leg is available.
    on_finding : callable
        Receives the reason why a leg is not available, once per leg.
    rank : callable
        Returns the rank of a line (n, 3), given the model, its way-points and the cost; the
        lowest rank is best.

    Attributes
    ----------
    cost : str or None
        Cost that is followed; None for straight legs, AUTO for the cost whose line defines a
        plane best.
    follows_photos : bool
        Whether a leg whose end was set in a photo is followed in that photo, if the cost is
        available for photos.
    """

    def __init__(
        self,
        finder: PathFinder,
        on_leg: Callable[[], None],
        on_finding: Callable[[Finding], None],
        rank: Callable[[str, FloatArray, Sequence[Point], str], Rank],
    ) -> None:
        self._finder, self._on_leg, self._on_finding, self._rank = finder, on_leg, on_finding, rank
        self.cost: str | None = None
        self._best_cost: tuple[object, str] | None = None
        self.follows_photos = True
        self._photos: dict[Point, str] = {}
        self._legs: dict[Key, FollowedPath | None] = {}
        self._requested_keys: set[Key] = set()
        self._live_key: Key | None = None

    def set_photo(self, photo: str, place: Point) -> None:
        """Record the photo in which a way-point or the cursor was set, or "" for no photo."""
        if photo:
            self._photos[place] = photo
        else:
            self._photos.pop(place, None)

    def get_photo(self, place: Point) -> str:
        """Return the photo in which a way-point was set, or "" for no photo."""
        return self._photos.get(place, "")

    def stored_legs(self, model_id: str, way_points: Sequence[Point]) -> list[FollowedPath]:
        """Return the known legs between way-points."""
        cost_name = self.current_cost(model_id)
        keys = (self._key(model_id, a, b, cost_name) for a, b in pairwise(way_points))
        return [leg for key in keys if (leg := self._legs.get(key)) is not None]

    def path(
        self, model_id: str, way_points: Sequence[Point], *, is_live: bool = False
    ) -> FloatArray:
        """Return the line (n, 3) through way-points.

        Unknown legs are requested, and are straight until they are available.

        Parameters
        ----------
        model_id : str
        way_points : sequence of Point
            Way-points in the file frame of the model.
        is_live : bool
            Whether a way-point is being dragged; in this case only the last missing leg is
            requested.
        """
        points = np.asarray(way_points, np.float64).reshape(-1, 3)
        if self.cost is None or len(points) < 2:
            return points
        if self.cost == AUTO and not is_live:
            self._update_best_cost(model_id, tuple(way_points))
        cost_name = self.current_cost(model_id)
        legs = [
            self._find_leg(model_id, a, b, cost_name, is_live=is_live)
            for a, b in pairwise(way_points)
        ]
        return _join_legs(way_points, legs)

    def doubtful(
        self, model_id: str, way_points: Sequence[Point], resolution: float, cost: str = ""
    ) -> tuple[Range, ...]:
        """Return the first and last rows of parts of `path` that may follow another contact.

        The result is empty if the cost of any leg is unknown.

        Parameters
        ----------
        model_id : str
        way_points : sequence of Point
            Way-points in the file frame of the model.
        resolution : float
            Resolution of the model, in the unit of its file.
        cost : str
            Cost by which the line is followed, by default the current cost.
        """
        from vomstudio.extraction.path_jumps import find_jumps

        cost_name = cost or self.current_cost(model_id)
        legs = [
            self._legs.get(self._key(model_id, a, b, cost_name)) for a, b in pairwise(way_points)
        ]
        known_legs = [leg for leg in legs if leg is not None and leg.costs is not None]
        if not known_legs or len(known_legs) < len(legs):
            return ()
        line = np.concatenate([leg.points for leg in known_legs])
        costs = np.concatenate([leg.costs for leg in known_legs if leg.costs is not None])
        is_new_point = _are_new_points(line)
        position = (
            np.cumsum(is_new_point)[np.cumsum([len(leg.points) for leg in known_legs]) - 1] - 1
        )
        return find_jumps(
            line[is_new_point], costs[is_new_point], np.append(0, position), resolution
        )

    def current_cost(self, model_id: str) -> str:
        """Return the current cost on a model, or the best cost so far if it is AUTO."""
        if self.cost != AUTO:
            return self.cost or ""
        costs = self._finder.costs(model_id)
        if self._best_cost is not None and self._best_cost[1] in costs:
            return self._best_cost[1]
        return costs[0]

    def _update_best_cost(self, model_id: str, way_points: tuple[Point, ...]) -> None:
        """Determine the best cost, once the line is known for every candidate."""
        costs = self._candidate_costs(model_id, way_points)
        if self._best_cost is not None and self._best_cost[0] == (model_id, way_points, costs):
            return
        ranks: list[tuple[Rank, int]] = []
        is_waiting = False
        for number, cost in enumerate(costs):
            legs = [
                self._find_leg(model_id, a, b, cost, is_live=False) for a, b in pairwise(way_points)
            ]
            is_known = [
                self._is_cached(self._key(model_id, a, b, cost))
                for a, b in pairwise(way_points)
                if a != b
            ]
            is_waiting = is_waiting or not all(is_known)
            if any(leg is not None for leg in legs):
                rank = self._rank(model_id, _join_legs(way_points, legs), way_points, cost)
                ranks.append((rank, number))
        if not is_waiting:
            best_cost = costs[min(ranks)[1]] if ranks else costs[0]
            self._best_cost = (model_id, way_points, costs), best_cost

    def _candidate_costs(self, model_id: str, way_points: Sequence[Point]) -> tuple[str, ...]:
        """Return the candidate costs for AUTO; legs in photos permit only photo costs."""
        costs = self._finder.costs(model_id)
        uses_photos = self.follows_photos and any(
            self.get_photo(position) for position in way_points
        )
        photo_costs = tuple(cost for cost in costs if cost in COLOUR_COSTS)
        return photo_costs if uses_photos and photo_costs else costs

    def leg(self, model_id: str, start: Point, end: Point, *, is_live: bool) -> FloatArray | None:
        """Return the path between two points; None if not available yet or legs are straight."""
        if self.cost is None:
            return None
        return self._find_leg(model_id, start, end, self.current_cost(model_id), is_live=is_live)

    def _find_leg(
        self, model_id: str, start: Point, end: Point, cost: str, *, is_live: bool
    ) -> FloatArray | None:
        if start == end:
            return None
        key = self._key(model_id, start, end, cost)
        leg = self._legs.get(key)
        points = None if leg is None else leg.points
        if is_live and key not in self._legs:
            self._live_key = key
        elif is_live or self._is_cached(key) or key in self._requested_keys:
            return points
        else:
            self._requested_keys.add(key)
        self._finder.follow(
            model_id,
            cost,
            (start, end),
            photo=key[4],
            is_live=is_live,
            callback=lambda result: self._store_leg(key, result),
        )
        return points

    def _key(self, model_id: str, start: Point, end: Point, cost: str) -> Key:
        photo = self.get_photo(end) if self.follows_photos and cost in COLOUR_COSTS else ""
        return model_id, cost, start, end, photo

    def _is_cached(self, key: Key) -> bool:
        """Return whether a leg is final."""
        leg = self._legs.get(key)
        return key in self._legs if leg is None else leg.is_final

    def is_searching(self, model_id: str, way_points: Sequence[Point]) -> bool:
        """Return whether any leg between way-points is pending."""
        if self.cost is None:
            return False
        costs = [self.current_cost(model_id)]
        if self.cost == AUTO:
            costs = list(self._candidate_costs(model_id, way_points))
        keys = (
            self._key(model_id, a, b, cost)
            for cost in costs
            for a, b in pairwise(way_points)
            if a != b
        )
        return any(not self._is_cached(key) for key in keys)

    def clear_state(self) -> None:
        """Discard all requests; known legs remain available."""
        self._requested_keys.clear()
        self._live_key = None

    def _store_leg(self, key: Key, result: FollowedPath | Finding) -> None:
        is_awaited = key in self._requested_keys
        self._requested_keys.discard(key)
        if len(self._legs) > MAX_CACHED_LEGS:
            self._legs.clear()
        if isinstance(result, Finding):
            # The leg to the cursor changes soon, so its failure is not reported.
            if is_awaited:
                self._legs[key] = None
                if self._should_report(key):
                    self._on_finding(result)
        else:
            if result.is_final or not self._is_cached(key):
                self._legs[key] = result
            if is_awaited and self._should_report(key):
                for warning in result.warnings:
                    self._on_finding(warning)
        if is_awaited or self._live_key == key:
            self._on_leg()

    def _should_report(self, key: Key) -> bool:
        """Return whether to report a failure: for AUTO, only that of the first candidate."""
        return self.cost != AUTO or key[1] == self._finder.costs(key[0])[0]


def _join_legs(way_points: Sequence[Point], legs: Sequence[FloatArray | None]) -> FloatArray:
    """Join legs to a line (n, 3), which is straight where a leg is missing."""
    parts = [
        np.array(ends) if leg is None else leg
        for ends, leg in zip(pairwise(way_points), legs, strict=True)
    ]
    line = np.concatenate(parts)
    return np.asarray(line[_are_new_points(line)])


def _are_new_points(line: FloatArray) -> BoolArray:
    """Return which points (n,) differ from the previous point."""
    return np.append(True, (np.diff(line, axis=0) != 0.0).any(axis=1))


def photo_votes(legs: Sequence[FollowedPath]) -> str | None:
    """Describe the photos of paths and their confirmation; return None if `legs` is empty."""
    if not legs:
        return None
    text = tr(
        "Followed in the pixels of {photos}.",
        photos=", ".join(dict.fromkeys(leg.photo.rpartition("/")[2] for leg in legs)),
    )
    judged_count = sum(leg.checked_count for leg in legs)
    if not judged_count:
        if not all(leg.is_final for leg in legs):
            return text
        return f"{text} {tr('No other photo could confirm the line.')}"
    voters = {voter for leg in legs for voter in leg.voters}
    votes = tr_n(
        "{count} other photo was compared and confirms {percent:.0f} % of the line.",
        "{count} other photos were compared and confirm {percent:.0f} % of the line.",
        len(voters),
        percent=100.0 * sum(leg.confirmed_count for leg in legs) / judged_count,
    )
    return f"{text} {votes}"
