"""Displacement on a fault, with errors, from pairs of points on both sides.

Two points that originally coincided (piercing points) determine the net slip. Two points of one bed
on both sides determine the net slip if the slip direction is known; otherwise, they determine
separations, which are not slip (Hill 1959, Journal of Geology 67, 641-653; Yamada & Sakaguchi
1995). Errors of the points, the fault, the bed and the slip direction are propagated to first
order.
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
from vomstudio.geology.measured_value import CONE95, MeasuredValue
from vomstudio.geology.orientation import (
    Line,
    Plane,
    line_from_rake,
    planes_to_normals,
)
from vomstudio.geometry.rotation_errors import Z95

DIFFERENTIATION_STEP = 1e-6
MIN_ANGLE_DEG = 5.0


@dataclass(frozen=True)
class DisplacementErrors:
    """Errors of the inputs of a displacement.

    Attributes
    ----------
    sigma_m : float
        Standard deviation of each coordinate of a point, m.
    fault95_deg, bed95_deg : float
        Half-angles of the 95 % cones of the normals, degrees.
    rake95_deg : float
        95 % error of the rake of the slip, degrees.
    """

    sigma_m: float = 0.0
    fault95_deg: float = 0.0
    bed95_deg: float = 0.0
    rake95_deg: float = 0.0

    @property
    def has_errors(self) -> bool:
        return any((self.sigma_m, self.fault95_deg, self.bed95_deg, self.rake95_deg))


NO_ERRORS = DisplacementErrors()


@dataclass(frozen=True)
class Displacement:
    """Movement of the hanging wall relative to the footwall.

    Attributes
    ----------
    what : str
        "net slip", or "separation" if the slip is unknown.
    net_m : MeasuredValue
        Length of the displacement, m.
    throw_m : MeasuredValue
        Vertical component, positive downward, m.
    heave_m : MeasuredValue
        Horizontal component perpendicular to the strike, positive if the walls moved apart, m.
    strike_slip_m : MeasuredValue
        Component along the right-hand-rule strike, positive if sinistral, m.
    dip_slip_m : MeasuredValue
        Component up the dip, positive if reverse, m.
    slip_rake_deg : float or None
        Directed rake, -180 to 180 degrees, positive with a reverse component; None if there is no
        movement.
    trend_deg, plunge_deg : float or None
        Direction of the movement, degrees; None if there is no movement.
    off_fault_m : float
        Component perpendicular to the fault plane, m.
    """

    what: str
    net_m: MeasuredValue
    throw_m: MeasuredValue
    heave_m: MeasuredValue
    strike_slip_m: MeasuredValue
    dip_slip_m: MeasuredValue
    slip_rake_deg: float | None
    trend_deg: float | None
    plunge_deg: float | None
    off_fault_m: float


@dataclass(frozen=True)
class Separations:
    """Separations of a bed across a fault with unknown slip, in metres.

    Attributes
    ----------
    stratigraphic_m : MeasuredValue
        Separation perpendicular to the bed.
    dip : Displacement or None
        Separation along the dip of the fault; None if the bed is within 5
        degrees of this direction.
    strike_m : MeasuredValue or None
        Separation along the strike, positive if sinistral; None if the bed is within 5 degrees
        of the strike.
    """

    stratigraphic_m: MeasuredValue
    dip: Displacement | None
    strike_m: MeasuredValue | None


def net_slip_from_piercing_points(
    hanging_wall_point: npt.ArrayLike,
    footwall_point: npt.ArrayLike,
    fault: Plane,
    errors: DisplacementErrors = NO_ERRORS,
) -> Displacement:
    """Compute the net slip from two points that originally coincided.

    Parameters
    ----------
    hanging_wall_point, footwall_point : (3,) array_like
        Points in the World frame, m.
    fault : Plane
    errors : DisplacementErrors

    Returns
    -------
    Displacement

    Raises
    ------
    GeometryError
        If a point is not finite.
    """
    points = _relative_points(hanging_wall_point, footwall_point)

    def vector(p: FloatArray) -> tuple[FloatArray, FloatArray]:
        return p[:3] - p[3:6], _tilted_normal(fault, p[6:8])

    sigmas = _parameter_sigmas(errors, fault95=errors.fault95_deg)
    return _build_displacement(
        "net slip", fault, vector, np.concatenate([points, np.zeros(2)]), sigmas, errors
    )


def net_slip_from_cutoffs(
    hanging_wall_point: npt.ArrayLike,
    footwall_point: npt.ArrayLike,
    fault: Plane,
    bed: Plane,
    rake_deg: float,
    errors: DisplacementErrors = NO_ERRORS,
    *,
    description: str = "net slip",
) -> Displacement:
    """Compute the net slip from the cutoffs of a bed and a slip lineation.

    The point of the hanging wall is moved back along the lineation until it meets the bed of the
    footwall, which also determines the sense of slip.

    Parameters
    ----------
    hanging_wall_point, footwall_point : (3,) array_like
        Points of the same bed in the World frame, m.
    fault, bed : Plane
        Attitudes; the bed has the same attitude on both sides.
    rake_deg : float
        Rake of the lineation as defined by `orientation.compute_rake` (90 is down dip), degrees.
    errors : DisplacementErrors
    description : str
        Name of the result.

    Returns
    -------
    Displacement

    Raises
    ------
    GeometryError
        If a point is not finite, or if the slip is within 5 degrees of the bed, which leaves it
        undetermined.
    """
    points = _relative_points(hanging_wall_point, footwall_point)
    bed_normal = planes_to_normals(bed.dip_direction_deg, bed.dip_deg).ravel()
    if abs(line_from_rake(fault, rake_deg).vector() @ bed_normal) < math.sin(
        math.radians(MIN_ANGLE_DEG)
    ):
        raise GeometryError(Finding("displacement.slip-along-bed", limit_deg=MIN_ANGLE_DEG))

    def vector(p: FloatArray) -> tuple[FloatArray, FloatArray]:
        normal, bed_normal = _tilted_normal(fault, p[6:8]), _tilted_normal(bed, p[8:10])
        strike, up_dip = _axes_in_plane(normal, fault)
        rake_rad = math.radians(rake_deg) + p[10]
        slip_direction = math.cos(rake_rad) * strike - math.sin(rake_rad) * up_dip
        return (p[:3] - p[3:6]) @ bed_normal / (
            slip_direction @ bed_normal
        ) * slip_direction, normal

    sigmas = _parameter_sigmas(
        errors, fault95=errors.fault95_deg, bed95=errors.bed95_deg, rake95=errors.rake95_deg
    )
    return _build_displacement(
        description, fault, vector, np.concatenate([points, np.zeros(5)]), sigmas, errors
    )


def separations(
    hanging_wall_point: npt.ArrayLike,
    footwall_point: npt.ArrayLike,
    fault: Plane,
    bed: Plane,
    errors: DisplacementErrors = NO_ERRORS,
) -> Separations:
    """Compute the separations of a bed across a fault with unknown slip.

    Parameters
    ----------
    hanging_wall_point, footwall_point : (3,) array_like
        Points of the same bed in the World frame, m.
    fault, bed : Plane
    errors : DisplacementErrors

    Returns
    -------
    Separations

    Raises
    ------
    GeometryError
        If a point is not finite, or if the bed is within 5 degrees of the fault.
    """
    points = _relative_points(hanging_wall_point, footwall_point)
    fault_normal = planes_to_normals(fault.dip_direction_deg, fault.dip_deg).ravel()
    bed_normal = planes_to_normals(bed.dip_direction_deg, bed.dip_deg).ravel()
    if np.linalg.norm(np.cross(fault_normal, bed_normal)) < math.sin(math.radians(MIN_ANGLE_DEG)):
        raise GeometryError(Finding("displacement.bed-along-fault", limit_deg=MIN_ANGLE_DEG))

    def thickness(p: FloatArray) -> FloatArray:
        return np.array([(p[:3] - p[3:6]) @ _tilted_normal(bed, p[6:8])])

    position = np.concatenate([points, np.zeros(2)])
    values, sigmas = _propagate_errors(
        thickness, position, _parameter_sigmas(errors, bed95=errors.bed95_deg)
    )
    slips: dict[float, Displacement | None] = {}
    errors_without_rake = DisplacementErrors(errors.sigma_m, errors.fault95_deg, errors.bed95_deg)
    for rake in (90.0, 0.0):
        try:
            slips[rake] = net_slip_from_cutoffs(
                hanging_wall_point,
                footwall_point,
                fault,
                bed,
                rake,
                errors_without_rake,
                description="separation",
            )
        except GeometryError:
            slips[rake] = None
    strike_separation = slips[0.0]
    return Separations(
        _to_measured(abs(float(values[0])), float(sigmas[0]), errors),
        slips[90.0],
        None if strike_separation is None else strike_separation.strike_slip_m,
    )


# --- vectors --------------------------------------------------------------------------------------
def _relative_points(
    hanging_wall_point: npt.ArrayLike, footwall_point: npt.ArrayLike
) -> FloatArray:
    """Return both points (6,) relative to the footwall point.

    This preserves the digits of large northings. Raises GeometryError if a point is not finite.
    """
    hanging_wall, footwall = (
        np.asarray(v, np.float64).ravel() for v in (hanging_wall_point, footwall_point)
    )
    if (
        hanging_wall.shape != (3,)
        or footwall.shape != (3,)
        or not np.isfinite([*hanging_wall, *footwall]).all()
    ):
        raise GeometryError(Finding("points.invalid"))
    return np.concatenate([hanging_wall - footwall, np.zeros(3)])


def _axes(plane: Plane) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the upward normal, the dip vector and the right-hand-rule strike vector."""
    normal = planes_to_normals(plane.dip_direction_deg, plane.dip_deg).ravel()
    return normal, plane.dip_vector(), plane.strike_vector()


def _tilted_normal(plane: Plane, tilt_rad: FloatArray) -> FloatArray:
    """Return the upward normal, rotated by small angles down the dip and along the strike."""
    up, down, strike = _axes(plane)
    n = up + math.tan(tilt_rad[0]) * down + math.tan(tilt_rad[1]) * strike
    return np.asarray(n / np.linalg.norm(n))


def _axes_in_plane(normal: FloatArray, fault: Plane) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors along the strike and up the dip of a fault with a given normal.

    The strike is the direction from which rakes are counted.
    """
    reference = fault.strike_vector()
    size = math.hypot(normal[0], normal[1])
    strike = np.array([-normal[1], normal[0], 0.0]) / size if size > 1e-12 else reference
    strike = strike if strike @ reference >= 0 else -strike
    up_dip = np.cross(normal, strike)
    return strike, up_dip if up_dip[2] >= 0 else -up_dip


# --- errors ---------------------------------------------------------------------------------------
def _parameter_sigmas(errors: DisplacementErrors, **cones: float) -> FloatArray:
    """Return the standard deviations of six coordinates, the tilts and the rake."""
    parts = [np.full(6, errors.sigma_m)]
    for name, value in cones.items():
        sigma_rad = math.radians(value)
        parts.append(
            np.array([sigma_rad / Z95]) if name == "rake95" else np.full(2, sigma_rad / CONE95)
        )
    return np.concatenate(parts)


def _derivatives(
    function: Callable[[FloatArray], FloatArray],
    position: FloatArray,
    step: float = DIFFERENTIATION_STEP,
) -> FloatArray:
    steps = step * np.eye(len(position))
    return np.array(
        [(function(position + s) - function(position - s)) / (2 * step) for s in steps]
    ).T


def _propagate_errors(
    function: Callable[[FloatArray], FloatArray], position: FloatArray, sigmas: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the values of a function and their standard deviations."""
    values = function(position)
    if not sigmas.any():
        return values, np.zeros(len(values))
    slope = _derivatives(function, position) * sigmas
    return values, np.sqrt(np.sum(slope**2, axis=1))


def _to_measured(value: float, sigma: float, errors: DisplacementErrors) -> MeasuredValue:
    return MeasuredValue(value, Z95 * sigma if errors.has_errors else None)


def _build_displacement(
    description: str,
    fault: Plane,
    vector: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    position: FloatArray,
    parameter_sigmas: FloatArray,
    errors: DisplacementErrors,
) -> Displacement:
    def figures(p: FloatArray) -> FloatArray:
        d, normal = vector(p)
        strike, up_dip = _axes_in_plane(normal, fault)
        horizontal_length = math.hypot(normal[0], normal[1])
        heave_direction = (
            normal * [1, 1, 0] / horizontal_length if horizontal_length > 1e-9 else -up_dip
        )
        return np.array([np.linalg.norm(d), -d[2], d @ heave_direction, d @ strike, d @ up_dip])

    values, sigmas = _propagate_errors(figures, position, parameter_sigmas)
    net, throw, heave, strike, dip = (
        _to_measured(float(value), float(sigma), errors)
        for value, sigma in zip(values, sigmas, strict=True)
    )
    d, normal = vector(position)
    has_moved = float(np.linalg.norm(d)) > 1e-9
    line = Line.from_vector(d, is_directed=True) if has_moved else None
    rake = math.degrees(math.atan2(dip.value, strike.value)) if has_moved else None
    return Displacement(
        description,
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
