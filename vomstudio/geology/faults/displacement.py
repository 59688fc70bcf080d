"""Displacement on a fault: what pairs of points on both sides of it tell, and how well.

Two points that were one (piercing points) give the net slip. Two points of one bed on both sides
give only what the bed allows: along a slip direction that is known, the net slip; else separations,
which are no slip (Hill 1959, Journal of Geology 67, 641-653; Yamada & Sakaguchi 1995). Errors are
propagated to first order from those of the points, the fault, the bed and the slip direction.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.measured import CONE95, Measured
from vomstudio.geology.orientation import (
    Line,
    Plane,
    line_from_rake,
    planes_to_normals,
)
from vomstudio.geometry.rotation_errors import Z95

_STEP = 1e-6
_PARALLEL_DEG = 5.0


@dataclass(frozen=True)
class Errors:
    """sigma_m : standard deviation of each coordinate of a point; fault95_deg, bed95_deg : half-
    angles of the 95 % cones of their normals; rake95_deg : 95 % of the slip's rake"""

    sigma_m: float = 0.0
    fault95_deg: float = 0.0
    bed95_deg: float = 0.0
    rake95_deg: float = 0.0

    @property
    def known(self) -> bool:
        return any((self.sigma_m, self.fault95_deg, self.bed95_deg, self.rake95_deg))


NO_ERRORS = Errors()
"""Nothing is known of them."""


@dataclass(frozen=True)
class Displacement:
    """How the hanging wall moved against the footwall, metres.

    what : net slip, or separation where the slip is unknown; net_m : its length; throw_m : down
    positive; heave_m : horizontal, across the strike, positive where the walls moved apart;
    strike_slip_m : along the right-hand-rule strike, positive sinistral; dip_slip_m : up the dip,
    positive reverse; slip_rake_deg : -180 to 180, positive with a reverse part; direction : trend
    and plunge of the motion; off_fault_m : how far the vector leaves the fault plane
    """

    what: str
    net_m: Measured
    throw_m: Measured
    heave_m: Measured
    strike_slip_m: Measured
    dip_slip_m: Measured
    slip_rake_deg: float | None
    trend_deg: float | None
    plunge_deg: float | None
    off_fault_m: float


@dataclass(frozen=True)
class Separations:
    """Of one bed across a fault whose slip is unknown, metres: stratigraphic, across the bed; dip
    separation, along the fault's dip, with its throw and heave; strike separation, along its
    strike, positive sinistral. None where the bed runs along that direction."""

    stratigraphic_m: Measured
    dip: Displacement | None
    strike_m: Measured | None


def net_slip_of_piercing_points(
    hanging_wall: npt.ArrayLike, footwall: npt.ArrayLike, fault: Plane, errors: Errors = NO_ERRORS
) -> Displacement:
    """From two places (3,) in World that were one. Raises GeometryError for places that are not
    finite."""
    points = _points(hanging_wall, footwall)

    def vector(p: FloatArray) -> tuple[FloatArray, FloatArray]:
        return p[:3] - p[3:6], _tilted(fault, p[6:8])

    spread = _spread(errors, fault95=errors.fault95_deg)
    return _displacement(
        "net slip", fault, vector, np.concatenate([points, np.zeros(2)]), spread, errors
    )


def net_slip_of_cutoffs(
    hanging_wall: npt.ArrayLike,
    footwall: npt.ArrayLike,
    fault: Plane,
    bed: Plane,
    rake_deg: float,
    errors: Errors = NO_ERRORS,
    *,
    what: str = "net slip",
) -> Displacement:
    """From one point (3,) of the same bed on each side and the slip lineation: which way the slip
    went follows. bed : its attitude, the same on both sides; rake_deg : of the lineation, as
    `orientation.rake_of` counts it (90 is down dip).

    The hanging wall is moved back along the slip until its point lies in the footwall's bed. Raises
    GeometryError where the slip is within 5 degrees of the bed, which then says nothing of it.
    """
    points = _points(hanging_wall, footwall)
    bed_normal = planes_to_normals(bed.dip_direction_deg, bed.dip_deg).ravel()
    if abs(line_from_rake(fault, rake_deg).vector() @ bed_normal) < math.sin(
        math.radians(_PARALLEL_DEG)
    ):
        raise GeometryError(Finding("displacement.slip-along-bed", limit_deg=_PARALLEL_DEG))

    def vector(p: FloatArray) -> tuple[FloatArray, FloatArray]:
        normal, across = _tilted(fault, p[6:8]), _tilted(bed, p[8:10])
        strike, up_dip = _in_plane(normal, fault)
        rake_rad = math.radians(rake_deg) + p[10]
        along = math.cos(rake_rad) * strike - math.sin(rake_rad) * up_dip
        return (p[:3] - p[3:6]) @ across / (along @ across) * along, normal

    spread = _spread(
        errors, fault95=errors.fault95_deg, bed95=errors.bed95_deg, rake95=errors.rake95_deg
    )
    return _displacement(what, fault, vector, np.concatenate([points, np.zeros(5)]), spread, errors)


def separations(
    hanging_wall: npt.ArrayLike,
    footwall: npt.ArrayLike,
    fault: Plane,
    bed: Plane,
    errors: Errors = NO_ERRORS,
) -> Separations:
    """What can be said where the slip is unknown. Raises GeometryError for a bed parallel to the
    fault."""
    points = _points(hanging_wall, footwall)
    fault_normal = planes_to_normals(fault.dip_direction_deg, fault.dip_deg).ravel()
    bed_normal = planes_to_normals(bed.dip_direction_deg, bed.dip_deg).ravel()
    if np.linalg.norm(np.cross(fault_normal, bed_normal)) < math.sin(math.radians(_PARALLEL_DEG)):
        raise GeometryError(Finding("displacement.bed-along-fault", limit_deg=_PARALLEL_DEG))

    def across(p: FloatArray) -> FloatArray:
        return np.array([(p[:3] - p[3:6]) @ _tilted(bed, p[6:8])])

    at = np.concatenate([points, np.zeros(2)])
    value, error = _propagated(across, at, _spread(errors, bed95=errors.bed95_deg))
    found: dict[float, Displacement | None] = {}
    known = Errors(errors.sigma_m, errors.fault95_deg, errors.bed95_deg)
    for rake in (90.0, 0.0):
        try:
            found[rake] = net_slip_of_cutoffs(
                hanging_wall, footwall, fault, bed, rake, known, what="separation"
            )
        except GeometryError:
            found[rake] = None
    strike = found[0.0]
    return Separations(
        _measured(abs(float(value[0])), float(error[0]), errors),
        found[90.0],
        None if strike is None else strike.strike_slip_m,
    )


# --- vectors --------------------------------------------------------------------------------------
def _points(hanging_wall: npt.ArrayLike, footwall: npt.ArrayLike) -> FloatArray:
    """(6,) both, around the footwall's: a northing would cost the steps their digits."""
    h, f = (np.asarray(v, np.float64).ravel() for v in (hanging_wall, footwall))
    if h.shape != (3,) or f.shape != (3,) or not np.isfinite([*h, *f]).all():
        raise GeometryError(Finding("points.invalid"))
    return np.concatenate([h - f, np.zeros(3)])


def _axes(plane: Plane) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Upward normal, down the dip, along the right-hand-rule strike."""
    normal = planes_to_normals(plane.dip_direction_deg, plane.dip_deg).ravel()
    return normal, plane.dip_vector(), plane.strike_vector()


def _tilted(plane: Plane, tilt_rad: FloatArray) -> FloatArray:
    """The upward normal, turned by small angles down the dip and along the strike."""
    up, down, strike = _axes(plane)
    n = up + math.tan(tilt_rad[0]) * down + math.tan(tilt_rad[1]) * strike
    return np.asarray(n / np.linalg.norm(n))


def _in_plane(normal: FloatArray, fault: Plane) -> tuple[FloatArray, FloatArray]:
    """Unit vectors along the strike and up the dip of a fault that was tilted to this normal; its
    strike is the one that rakes are counted from."""
    known = fault.strike_vector()
    size = math.hypot(normal[0], normal[1])
    strike = np.array([-normal[1], normal[0], 0.0]) / size if size > 1e-12 else known
    strike = strike if strike @ known >= 0 else -strike
    up_dip = np.cross(normal, strike)
    return strike, up_dip if up_dip[2] >= 0 else -up_dip


# --- errors ---------------------------------------------------------------------------------------
def _spread(errors: Errors, **cones: float) -> FloatArray:
    """Standard deviations of the parameters: six coordinates, then tilts and the rake."""
    parts = [np.full(6, errors.sigma_m)]
    for name, value in cones.items():
        one = math.radians(value)
        parts.append(np.array([one / Z95]) if name == "rake95" else np.full(2, one / CONE95))
    return np.concatenate(parts)


def _slopes(
    f: Callable[[FloatArray], FloatArray], at: FloatArray, step: float = _STEP
) -> FloatArray:
    steps = step * np.eye(len(at))
    return np.array([(f(at + s) - f(at - s)) / (2 * step) for s in steps]).T


def _propagated(
    f: Callable[[FloatArray], FloatArray], at: FloatArray, spread: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values and their standard deviations."""
    values = f(at)
    if not spread.any():
        return values, np.zeros(len(values))
    slope = _slopes(f, at) * spread
    return values, np.sqrt(np.sum(slope**2, axis=1))


def _measured(value: float, sigma: float, errors: Errors) -> Measured:
    return Measured(value, Z95 * sigma if errors.known else None)


def _displacement(
    what: str,
    fault: Plane,
    vector: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    at: FloatArray,
    spread: FloatArray,
    errors: Errors,
) -> Displacement:
    def figures(p: FloatArray) -> FloatArray:
        d, normal = vector(p)
        strike, up_dip = _in_plane(normal, fault)
        size = math.hypot(normal[0], normal[1])
        outward = normal * [1, 1, 0] / size if size > 1e-9 else -up_dip
        return np.array([np.linalg.norm(d), -d[2], d @ outward, d @ strike, d @ up_dip])

    values, sigmas = _propagated(figures, at, spread)
    net, throw, heave, strike, dip = (
        _measured(float(v), float(s), errors) for v, s in zip(values, sigmas, strict=True)
    )
    d, normal = vector(at)
    moved = float(np.linalg.norm(d)) > 1e-9
    line = Line.from_vector(d, directed=True) if moved else None
    rake = math.degrees(math.atan2(dip.value, strike.value)) if moved else None
    return Displacement(
        what,
        net,
        throw,
        heave,
        strike,
        dip,
        rake,
        line.trend_deg if line else None,
        line.plunge_deg if line else None,
        float(d @ normal),
    )
