"""What a trace's plane is worth if some stretches of it are on another surface than the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.planes import PlaneFit, fit_planes

Range = tuple[int, int]
"""First and last vertex of a stretch, from 0."""

MIN_POINTS = 8
"""Of the rest, for a plane that has an error."""
MARGIN = 2
"""Vertices at either end of a stretch that belong to the way across, and to neither side."""


@dataclass(frozen=True)
class DoubtfulStretch:
    """start, end : first and last vertex, from 0; offset_m : of its middle from the plane of the
    rest, along the upward normal"""

    start: int
    end: int
    offset_m: float


@dataclass(frozen=True, eq=False)
class Rest:
    """fit : plane of the points outside of the stretches; None if they have none"""

    fit: PlaneFit | None
    stretches: tuple[DoubtfulStretch, ...]

    def error95_deg(
        self, fit: PlaneFit, resolution_m: float | None, outcrop_normal: FloatArray | None = None
    ) -> float:
        """Half-angle of 95 % of the plane of all points, if the plane of the rest is right."""
        if self.fit is None:
            return 90.0
        cosine = min(abs(float(fit.normal @ self.fit.normal)), 1.0)
        own = total_error_deg(self.fit, resolution_m, outcrop_normal=outcrop_normal)
        return min(float(np.degrees(np.arccos(cosine))) + (90.0 if own is None else own), 90.0)

    def findings(self) -> list[Finding]:
        """One for each stretch, with its vertices counted from 1."""
        plane = None if self.fit is None else Plane.from_normal(self.fit.normal)
        return [
            Finding(
                "trace.beside",
                start=one.start + 1,
                end=one.end + 1,
                offset_m=abs(one.offset_m),
                rest_dip_direction_deg=None if plane is None else plane.dip_direction_deg,
                rest_dip_deg=None if plane is None else plane.dip_deg,
            )
            for one in self.stretches
        ]


def rest_of(points: FloatArray, ranges: Sequence[Range]) -> Rest | None:
    """Fit a plane to the points of a trace (n, 3) outside of some stretches; None without such.

    Ranges that are not of these points are left out.
    """
    n = len(points)
    valid = [(a, b) for a, b in ranges if 0 <= a <= b < n]
    if not valid:
        return None
    kept = np.ones(n, np.bool_)
    for a, b in valid:
        kept[max(a - MARGIN, 0) : b + 1 + MARGIN] = False
    fit = None
    if kept.sum() >= MIN_POINTS:
        found = fit_planes(points[kept], [0, int(kept.sum())])[0]
        fit = found if found.error is None else None
    stretches = tuple(DoubtfulStretch(a, b, offset(points, (a, b), fit)) for a, b in valid)
    return Rest(fit, stretches)


def offset(points: FloatArray, stretch: Range, fit: PlaneFit | None) -> float:
    """Distance of a stretch's middle from a plane; 0 without one."""
    if fit is None:
        return 0.0
    middle = points[stretch[0] : stretch[1] + 1].mean(axis=0)
    return float((middle - fit.centroid) @ fit.normal)
