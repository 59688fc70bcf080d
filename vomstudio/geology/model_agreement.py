"""Comparison of orientations measured on two models of the same rock, given their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.results import Result


@dataclass(frozen=True, eq=False)
class OrientedPlane:
    """Plane measured on a model; unknown attributes are None.

    Attributes
    ----------
    kind : str
        Kind of feature, such as "bedding"; "" if unknown.
    normal : (3,) ndarray
        Unit vector in the World frame, pointing up or down.
    position : (3,) ndarray or None
        Midpoint of the plane in the World frame, m.
    extent_m : float or None
        Length, m.
    error95_deg : float or None
        95 % half-angle in degrees, including the registration if it is known.
    """

    name: str
    kind: str
    normal: FloatArray
    position: FloatArray | None
    extent_m: float | None
    error95_deg: float | None


@dataclass(frozen=True)
class MatchedPlane:
    """Pair of planes of the same structure; unknown attributes are None.

    Attributes
    ----------
    first, second : str
        Names of the planes.
    by : {"name", "nearness"}
        Criterion of the match.
    distance_m : float or None
        Distance between the midpoints, m.
    angle_deg : float
        Angle between the planes, 0 to 90 degrees.
    error95_deg : float or None
        Square root of the sum of the squared errors, degrees.
    agree : bool or None
        True if the angle is within the error.
    """

    first: str
    second: str
    by: Literal["name", "nearness"]
    distance_m: float | None
    angle_deg: float
    error95_deg: float | None
    agree: bool | None


@dataclass(frozen=True)
class Agreement(Result):
    """Summary of the agreement between two sets of planes.

    Attributes
    ----------
    n : int
        Number of matched pairs.
    unmatched : (int, int)
        Number of planes without a match in the first and in the second set.
    median_angle_deg, rms_angle_deg : float or None
        Angles between matched planes, degrees; None if there are no matches.
    agree_share : float or None
        Share of agreeing pairs among those with known errors; None if there are no such pairs.
    """

    n: int
    by_name: int
    by_nearness: int
    unmatched: tuple[int, int]
    median_angle_deg: float | None
    rms_angle_deg: float | None
    agree_share: float | None
    matched: tuple[MatchedPlane, ...]

    @property
    def findings(self) -> list[Finding]:
        """Findings on the number of planes measured on both models and the share that agrees."""
        if not self.n:
            return [Finding("comparison.no-planes-matched")]
        findings = [
            Finding(
                "comparison.planes-matched",
                n=self.n,
                named=self.by_name,
                near=self.by_nearness,
            )
        ]
        if self.agree_share is not None:
            share_percent = 100.0 * self.agree_share
            findings.append(Finding("comparison.planes-agree", share_percent=share_percent))
        return findings


def compare_orientations(
    first: Sequence[OrientedPlane], second: Sequence[OrientedPlane]
) -> Agreement:
    """Compare the orientations of the same structures measured on two models.

    Planes are matched by name if the name occurs exactly once in each model (ignoring case and
    surrounding spaces). The others are matched by nearness: they must be of the same kind, mutual
    nearest neighbours, and no farther apart than half the extent of the longer one. The stated
    errors are the larger half-angles of 95 % regions, so more than 95 % of the pairs agree if the
    errors are correct.

    Parameters
    ----------
    first, second : sequence of OrientedPlane

    Returns
    -------
    Agreement
    """
    pairs: list[tuple[int, int, Literal["name", "nearness"]]] = []
    names = [_unique_names(planes) for planes in (first, second)]
    for name, i in names[0].items():
        if (j := names[1].get(name)) is not None:
            pairs.append((i, j, "name"))
    unmatched_rows = [
        [k for k in range(len(planes)) if k not in {pair[index] for pair in pairs}]
        for index, planes in enumerate((first, second))
    ]
    pairs += [(i, j, "nearness") for i, j in _mutual_nearest_pairs(first, second, *unmatched_rows)]
    pairs.sort()
    matched_planes = tuple(_match(first[i], second[j], by) for i, j, by in pairs)
    angles = np.array([plane.angle_deg for plane in matched_planes])
    agreements = [plane.agree for plane in matched_planes if plane.agree is not None]
    return Agreement(
        len(matched_planes),
        sum(plane.by == "name" for plane in matched_planes),
        sum(plane.by == "nearness" for plane in matched_planes),
        (len(first) - len(matched_planes), len(second) - len(matched_planes)),
        float(np.median(angles)) if len(angles) else None,
        float(np.sqrt((angles**2).mean())) if len(angles) else None,
        sum(agreements) / len(agreements) if agreements else None,
        matched_planes,
    )


def _unique_names(planes: Sequence[OrientedPlane]) -> dict[str, int]:
    """Return the row of each name that occurs exactly once."""
    names = [plane.name.strip().casefold() for plane in planes]
    rows_by_name: dict[str, list[int]] = {}
    for row, name in enumerate(names):
        rows_by_name.setdefault(name, []).append(row)
    return {name: rows[0] for name, rows in rows_by_name.items() if name and len(rows) == 1}


def _mutual_nearest_pairs(
    first: Sequence[OrientedPlane],
    second: Sequence[OrientedPlane],
    first_rows: Sequence[int],
    second_rows: Sequence[int],
) -> list[tuple[int, int]]:
    """Return pairs of rows: planes of the same kind that are mutual nearest neighbours."""
    from scipy.spatial import cKDTree

    pairs = []
    for kind in {first[i].kind for i in first_rows}:
        sides = [
            [
                (k, position)
                for k in rows
                if planes[k].kind == kind and (position := planes[k].position) is not None
            ]
            for planes, rows in ((first, first_rows), (second, second_rows))
        ]
        if not (sides[0] and sides[1]):
            continue
        positions = [np.array([position for _, position in side]) for side in sides]
        distances, nearest_rows = cKDTree(positions[1]).query(positions[0])
        reverse_rows = cKDTree(positions[0]).query(positions[1])[1]
        for row, (distance, nearest_row) in enumerate(zip(distances, nearest_rows, strict=True)):
            i, j = sides[0][row][0], sides[1][int(nearest_row)][0]
            max_distance = max(first[i].extent_m or 0.0, second[j].extent_m or 0.0) / 2.0
            if reverse_rows[int(nearest_row)] == row and distance <= max_distance:
                pairs.append((i, j))
    return pairs


def _match(
    first_plane: OrientedPlane, second_plane: OrientedPlane, by: Literal["name", "nearness"]
) -> MatchedPlane:
    sine = float(np.linalg.norm(np.cross(first_plane.normal, second_plane.normal)))
    angle = float(
        np.degrees(np.arctan2(sine, abs(float(first_plane.normal @ second_plane.normal))))
    )
    distance = error = None
    if first_plane.position is not None and second_plane.position is not None:
        distance = float(np.linalg.norm(first_plane.position - second_plane.position))
    if first_plane.error95_deg is not None and second_plane.error95_deg is not None:
        error = float(np.hypot(first_plane.error95_deg, second_plane.error95_deg))
    agree = None if error is None else angle <= error
    return MatchedPlane(first_plane.name, second_plane.name, by, distance, angle, error, agree)
