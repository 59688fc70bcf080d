"""Plane of a trace without its doubtful stretches, which may follow another surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.planes import FittedPlane, fit_planes

VertexRange = tuple[int, int]
"""First and last vertex of a stretch, counted from 0."""

MIN_POINTS = 8
"""Minimum number of remaining points for a plane with an error estimate."""
MARGIN_VERTICES = 2
"""Number of vertices before and after a stretch that may belong to neither surface."""


@dataclass(frozen=True)
class DoubtfulStretch:
    """Stretch of a trace that may follow another surface.

    Attributes
    ----------
    first, last : int
        First and last vertex, counted from 0.
    offset_m : float
        Distance of the mean of its points from the plane of the other points along the upward
        normal, m.
    """

    first: int
    last: int
    offset_m: float


@dataclass(frozen=True, eq=False)
class RemainingTrace:
    """Plane of the points outside the doubtful stretches.

    `fit` is None if too few points remain or they do not define a plane.
    """

    fit: FittedPlane | None
    stretches: tuple[DoubtfulStretch, ...]

    def error95_deg(
        self, fit: FittedPlane, resolution_m: float | None, outcrop_normal: FloatArray | None = None
    ) -> float:
        """Return the 95 % error of the plane of all points.

        The points outside the stretches are assumed to follow one surface. The error is the angle
        between both planes plus the error of the plane of the remaining points, at most 90
        degrees.
        """
        if self.fit is None:
            return 90.0
        cosine = min(abs(float(fit.normal @ self.fit.normal)), 1.0)
        remaining_error = total_error_deg(self.fit, resolution_m, outcrop_normal=outcrop_normal)
        return min(
            float(np.degrees(np.arccos(cosine)))
            + (90.0 if remaining_error is None else remaining_error),
            90.0,
        )

    def findings(self) -> list[Finding]:
        """Return one finding per stretch, with the vertices counted from 1."""
        plane = None if self.fit is None else Plane.from_normal(self.fit.normal)
        return [
            Finding(
                "trace.beside",
                start=stretch.first + 1,
                end=stretch.last + 1,
                offset_m=abs(stretch.offset_m),
                rest_dip_direction_deg=None if plane is None else plane.dip_direction_deg,
                rest_dip_deg=None if plane is None else plane.dip_deg,
            )
            for stretch in self.stretches
        ]


def fit_remaining_plane(
    points: FloatArray, vertex_ranges: Sequence[VertexRange]
) -> RemainingTrace | None:
    """Fit a plane to the points of a trace outside the given stretches.

    `MARGIN_VERTICES` points before and after each stretch are also excluded.

    Parameters
    ----------
    points : (n, 3) ndarray
        Points of the trace in the World frame, m.
    vertex_ranges : sequence of (int, int)
        First and last vertex of each stretch; invalid ranges are ignored.

    Returns
    -------
    RemainingTrace or None
        None if none of the ranges is valid.
    """
    n = len(points)
    valid_ranges = [
        (first_vertex, last_vertex)
        for first_vertex, last_vertex in vertex_ranges
        if 0 <= first_vertex <= last_vertex < n
    ]
    if not valid_ranges:
        return None
    is_remaining = np.ones(n, np.bool_)
    for first_vertex, last_vertex in valid_ranges:
        is_remaining[max(first_vertex - MARGIN_VERTICES, 0) : last_vertex + 1 + MARGIN_VERTICES] = (
            False
        )
    fit = None
    if is_remaining.sum() >= MIN_POINTS:
        candidate = fit_planes(points[is_remaining], [0, int(is_remaining.sum())])[0]
        fit = candidate if candidate.error is None else None
    stretches = tuple(
        DoubtfulStretch(
            first_vertex, last_vertex, offset_from_plane(points, (first_vertex, last_vertex), fit)
        )
        for first_vertex, last_vertex in valid_ranges
    )
    return RemainingTrace(fit, stretches)


def offset_from_plane(points: FloatArray, stretch: VertexRange, fit: FittedPlane | None) -> float:
    """Return the distance of the mean of a stretch from a plane.

    Parameters
    ----------
    points : (n, 3) ndarray
        Points of the trace.
    stretch : VertexRange
        First and last vertex of the stretch.
    fit : FittedPlane or None

    Returns
    -------
    float
        Signed distance in metres; 0 if there is no plane.
    """
    if fit is None:
        return 0.0
    centre = points[stretch[0] : stretch[1] + 1].mean(axis=0)
    return float((centre - fit.centroid) @ fit.normal)
