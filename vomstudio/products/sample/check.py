"""Comparison of measurements on the sample outcrop with the true values.

The true values are in a table written by the generator of the sample, which shares no code with
this program. Each check reports the error of a measurement, its stated 95 % error in that
direction, and whether the true value lies within it. About 1 in 20 such regions misses the true
value; a program whose regions never miss overstates its errors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.results import Result
from vomstudio.core.words import to_translate
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.planes import FittedPlane, PlaneFits, fit_planes
from vomstudio.project.sample import SamplePicks, SampleTruth

FAULT = "fault"
FOLD_AXIS = to_translate("fold axis beta")
INTERSECTION = to_translate("intersection of bedding and fault")
DISPLACEMENT = to_translate("displacement on the fault")
"""Names of the checks, which are in English in the results."""

# Tolerance for the tangent of the angle between two unit vectors of the same direction.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Check(Result):
    """Comparison of a measurement with its true value.

    Parameters
    ----------
    name : str
    truth, measured : mapping or float
        Angles, or a length in m.
    error : float
        Error of the measurement in `unit`.
    stated_95 : float or None
        Stated 95 % error in `unit`. Both this and `within` are None if it cannot be estimated.
    within : bool or None
        Whether the true value lies within `stated_95`.
    unit : str
    total_95 : float or None
        For a plane, the 95 % error including resolution and registration, as in tables.
    """

    name: str
    truth: Mapping[str, float] | float
    measured: Mapping[str, float] | float
    error: float
    stated_95: float | None
    within: bool | None
    unit: str = "deg"
    total_95: float | None = None

    @property
    def within_total(self) -> bool | None:
        """Whether the error is at most `total_95`; None if this is unknown."""
        return None if self.total_95 is None else self.error <= self.total_95

    def to_dict(self) -> dict[str, Any]:
        return super().to_dict() | {"within_total": self.within_total}


@dataclass(frozen=True, eq=False)
class SampleResult:
    """Fits of all picks, the fold axis, the intersection of bedding and fault, and checks."""

    fits: PlaneFits
    beta: FoldAxis
    intersection: FoldAxis
    checks: tuple[Check, ...]


def check_sample(picks: SamplePicks, truth: SampleTruth) -> SampleResult:
    """Fit all picks, compute fold axis, intersection and slip, and check them.

    Raises
    ------
    GeometryError
        If no plane can be fitted to a pick.
    """
    fits = fit_planes(picks.points, picks.offsets)
    for name, reason in zip(picks.names, fits.error, strict=True):
        if reason is not None:
            raise GeometryError(Finding("sample.pick-without-plane", pick=name, reason=reason))
    checks = [
        plane_check(f"{kind} {name}", fits[i], truth.planes[name])
        for i, (name, kind) in enumerate(zip(picks.names, picks.kinds, strict=True))
    ]
    bedding = [i for i, kind in enumerate(picks.kinds) if kind == "bedding"]
    fault = [i for i, kind in enumerate(picks.kinds) if kind == "fault"]
    beta = fold_axis(fits.dip_direction_deg[bedding], fits.dip_deg[bedding])
    checks.append(axis_check(FOLD_AXIS, beta, truth.axis))
    # Beds cut by the fault are those with a horizon on both sides of it.
    pairs = horizon_pairs(picks)
    cut_beds = [i for pair in pairs for i in pair]
    intersection = common_axis(
        {
            "bedding": (fits.dip_direction_deg[cut_beds], fits.dip_deg[cut_beds]),
            FAULT: (fits.dip_direction_deg[fault], fits.dip_deg[fault]),
        }
    )
    checks.append(axis_check(INTERSECTION, intersection, truth.intersection))
    checks.append(slip_check(fits, pairs, fault, beta.beta, truth.displacement_m))
    return SampleResult(fits, beta, intersection, tuple(checks))


def horizon_pairs(picks: SamplePicks) -> list[tuple[int, int]]:
    """Return the pairs of picks (hanging wall, footwall) on the same horizon."""
    sides: dict[str, dict[str, int]] = {}
    for i, (horizon, set_name) in enumerate(zip(picks.horizons, picks.sets, strict=True)):
        for side in ("hanging wall", "footwall"):
            if horizon and set_name.endswith(side):
                sides.setdefault(horizon, {})[side] = i
    return [(side["hanging wall"], side["footwall"]) for side in sides.values() if len(side) == 2]


def plane_check(name: str, fit: FittedPlane, truth: Plane) -> Check:
    """Compare a true plane with the confidence ellipse of the fitted plane.

    The semi-axes are tan(max) along the second axis of the fit and tan(min) along the first, in the
    tangent plane of the sphere at the fitted normal.
    """
    plane = Plane.from_normal(fit.normal)
    ratio, error, stated_error = _deviation(
        fit.normal,
        truth.normal(),
        fit.axes[1],
        fit.max_confidence95_deg,
        fit.min_confidence95_deg,
    )
    return Check(name, _plane(truth), _plane(plane), error, stated_error, _is_within(ratio))


def axis_check(name: str, axis: FoldAxis, truth: Line) -> Check:
    """Compare a true axis with the confidence ellipse of the measured axis."""
    major_axis = None if axis.confidence_axis is None else axis.confidence_axis.vector()
    ratio, error, stated_error = _deviation(
        axis.beta.vector(),
        truth.vector(),
        major_axis,
        axis.max_confidence95_deg,
        axis.min_confidence95_deg,
    )
    return Check(name, _line(truth), _line(axis.beta), error, stated_error, _is_within(ratio))


def slip_check(
    fits: PlaneFits,
    pairs: Sequence[tuple[int, int]],
    fault: Sequence[int],
    axis: Line,
    truth_m: float,
) -> Check:
    """Check the slip perpendicular to the axis, from horizons on both sides of the fault.

    The line of slip in the fault intersects the two planes of each pair. The result is the mean
    distance between these points, with Student's 95 % interval.
    """
    from scipy.special import stdtrit

    normals = fits.normal[list(fault)]
    values, vectors = np.linalg.eigh(normals.T @ normals)
    fault_normal = vectors[:, np.argmax(values)]
    centre = fits.centroid[list(fault)].mean(axis=0)
    slip_direction = np.cross(fault_normal, axis.vector())
    slip_direction /= np.linalg.norm(slip_direction)

    def slip_position(i: int) -> float:
        n = fits.normal[i]
        return float(n @ (fits.centroid[i] - centre) / (n @ slip_direction))

    slips = np.array([abs(slip_position(a) - slip_position(b)) for a, b in pairs])
    mean = float(slips.mean()) if len(slips) else math.nan
    stated_error = None
    if len(slips) > 1:
        quantile = float(stdtrit(len(slips) - 1, 0.975))
        stated_error = quantile * float(slips.std(ddof=1)) / math.sqrt(len(slips))
    error = abs(mean - truth_m)
    is_within = None if stated_error is None else error <= stated_error
    return Check(DISPLACEMENT, truth_m, mean, error, stated_error, is_within, "m")


def _deviation(
    measured_vector: FloatArray,
    truth: FloatArray,
    major: FloatArray | None,
    max_deg: float | None,
    min_deg: float | None,
) -> tuple[float | None, float, float | None]:
    """Return the error relative to the radius of the ellipse, the error, and the radius.

    The error is the angle between the measured and the true vector. Both angles are in degrees,
    and the radius is that in the direction of the true vector. The first and the last value are
    None if the ellipse is unknown.
    """
    truth = truth if truth @ measured_vector >= 0 else -truth
    cosine = float(truth @ measured_vector)
    error = math.degrees(
        math.atan2(float(np.linalg.norm(np.cross(measured_vector, truth))), cosine)
    )
    if major is None or max_deg is None or min_deg is None or cosine <= 0:
        return None, error, None
    offset = truth / cosine - measured_vector
    minor_axis = np.cross(measured_vector, major)
    ratio = math.hypot(
        _relative_distance(float(offset @ major), max_deg),
        _relative_distance(float(offset @ minor_axis), min_deg),
    )
    if ratio == 0.0:
        return 0.0, error, max_deg
    return ratio, error, math.degrees(math.atan(float(np.linalg.norm(offset)) / ratio))


def _relative_distance(distance: float, limit_deg: float) -> float:
    """Return a distance in units of a semi-axis.

    If the semi-axis is 0, the result is 0 for a distance within rounding errors, else infinite.
    """
    limit = math.tan(math.radians(limit_deg))
    if limit > 0.0:
        return distance / limit
    return 0.0 if abs(distance) <= _ROUNDING else math.inf


def _is_within(ratio: float | None) -> bool | None:
    return None if ratio is None else ratio <= 1.0


def _plane(plane: Plane) -> dict[str, float]:
    return {"dip_direction_deg": plane.dip_direction_deg, "dip_deg": plane.dip_deg}


def _line(line: Line) -> dict[str, float]:
    return {"trend_deg": line.trend_deg, "plunge_deg": line.plunge_deg}
