"""Whether the orientations that two models of the same rock give agree within their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.results import Result


@dataclass(frozen=True, eq=False)
class OrientedPlane:
    """normal : (3,) unit vector, World, whichever way it points; kind : such as "bedding", empty
    where not known; place : (3,) World, its middle; extent_m : how long it is; error95_deg : 95 %
    half-angle, with the registration where that is known. None where not known"""

    name: str
    kind: str
    normal: FloatArray
    place: FloatArray | None
    extent_m: float | None
    error95_deg: float | None


@dataclass(frozen=True)
class MatchedPlane:
    """first, second : names; by : how they were matched; distance_m : between their middles;
    angle_deg : between the planes, 0 to 90; error95_deg : the errors of both, as the root of the
    sum of squares; agree : the angle is no larger. None where not known"""

    first: str
    second: str
    by: Literal["name", "nearness"]
    distance_m: float | None
    angle_deg: float
    error95_deg: float | None
    agree: bool | None


@dataclass(frozen=True)
class Agreement(Result):
    """n : matched planes; unmatched : of the first and of the second; median_angle_deg and
    rms_angle_deg : over them, None without any; agree_share : of those whose errors are known, None
    without any"""

    n: int
    by_name: int
    by_nearness: int
    unmatched: tuple[int, int]
    median_angle_deg: float | None
    rms_angle_deg: float | None
    agree_share: float | None
    matched: tuple[MatchedPlane, ...]


def agreement(first: Sequence[OrientedPlane], second: Sequence[OrientedPlane]) -> Agreement:
    """The angle between each two planes that are the same structure, beside their errors.

    By name: where one plane of each has it (case and spaces at the ends forgiven). Of the others
    by nearness: of the same kind, each the nearest to the other, and no farther apart than half of
    the longer one's extent. The stated errors are larger half-angles of 95 % regions, so that where
    they are right more than 95 % agree.
    """
    pairs: list[tuple[int, int, Literal["name", "nearness"]]] = []
    names = [_unique(planes) for planes in (first, second)]
    for name, i in names[0].items():
        if (j := names[1].get(name)) is not None:
            pairs.append((i, j, "name"))
    left = [
        [k for k in range(len(planes)) if k not in {pair[side] for pair in pairs}]
        for side, planes in enumerate((first, second))
    ]
    pairs += [(i, j, "nearness") for i, j in _nearest(first, second, *left)]
    pairs.sort()
    matched = tuple(_matched(first[i], second[j], by) for i, j, by in pairs)
    angles = np.array([one.angle_deg for one in matched])
    known = [one.agree for one in matched if one.agree is not None]
    return Agreement(
        len(matched),
        sum(one.by == "name" for one in matched),
        sum(one.by == "nearness" for one in matched),
        (len(first) - len(matched), len(second) - len(matched)),
        float(np.median(angles)) if len(angles) else None,
        float(np.sqrt((angles**2).mean())) if len(angles) else None,
        sum(known) / len(known) if known else None,
        matched,
    )


def _unique(planes: Sequence[OrientedPlane]) -> dict[str, int]:
    """Rows by name, of names that stand once."""
    names = [plane.name.strip().casefold() for plane in planes]
    rows: dict[str, list[int]] = {}
    for row, name in enumerate(names):
        rows.setdefault(name, []).append(row)
    return {name: own[0] for name, own in rows.items() if name and len(own) == 1}


def _nearest(
    first: Sequence[OrientedPlane],
    second: Sequence[OrientedPlane],
    left: Sequence[int],
    right: Sequence[int],
) -> list[tuple[int, int]]:
    """Rows of planes of the same kind that are nearest to each other, and near enough."""
    from scipy.spatial import cKDTree

    found = []
    for kind in {first[i].kind for i in left}:
        sides = [
            [
                (k, place)
                for k in rows
                if planes[k].kind == kind and (place := planes[k].place) is not None
            ]
            for planes, rows in ((first, left), (second, right))
        ]
        if not (sides[0] and sides[1]):
            continue
        places = [np.array([place for _, place in side]) for side in sides]
        apart, there = cKDTree(places[1]).query(places[0])
        back = cKDTree(places[0]).query(places[1])[1]
        for row, (distance, other) in enumerate(zip(apart, there, strict=True)):
            i, j = sides[0][row][0], sides[1][int(other)][0]
            reach = max(first[i].extent_m or 0.0, second[j].extent_m or 0.0) / 2.0
            if back[int(other)] == row and distance <= reach:
                found.append((i, j))
    return found


def _matched(
    one: OrientedPlane, other: OrientedPlane, by: Literal["name", "nearness"]
) -> MatchedPlane:
    across = float(np.linalg.norm(np.cross(one.normal, other.normal)))
    angle = float(np.degrees(np.arctan2(across, abs(float(one.normal @ other.normal)))))
    distance = error = None
    if one.place is not None and other.place is not None:
        distance = float(np.linalg.norm(one.place - other.place))
    if one.error95_deg is not None and other.error95_deg is not None:
        error = float(np.hypot(one.error95_deg, other.error95_deg))
    agree = None if error is None else angle <= error
    return MatchedPlane(one.name, other.name, by, distance, angle, error, agree)
