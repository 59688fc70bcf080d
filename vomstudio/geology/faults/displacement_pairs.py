"""Displacements of several pairs of points on one fault, for `vomstudio displacement`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.faults.displacement import (
    Displacement,
    DisplacementErrors,
    Separations,
    net_slip_from_cutoffs,
    net_slip_from_piercing_points,
    separations,
)
from vomstudio.geology.faults.displacement_options import DisplacementOptions
from vomstudio.geology.notation import parse_line_option, parse_plane_option
from vomstudio.geology.orientation import Line, Plane, angle_line_plane, compute_rake
from vomstudio.geometry.rotation_errors import Z95

MAX_OFF_PLANE_DEG = 10.0
"""Maximum angle between a slip direction and the fault that does not cause a warning."""
_MAX_LISTED = 8


@dataclass(frozen=True)
class Pair:
    """Displacement or separations of a pair of points; the other attribute is None."""

    name: str
    displacement: Displacement | None
    separations: Separations | None


@dataclass(frozen=True, repr=False)
class Displacements(PrintableResult):
    """Displacements of pairs of points on one fault.

    Attributes
    ----------
    what : str
        "net slip", or "separation" if the slip is unknown.
    mean_net_m, mean_throw_m, mean_heave_m : float
        Means over all pairs, m; means of the dip separations if the slip is unknown.
    std_net_m, std_throw_m, std_heave_m : float or None
        Standard deviations over all pairs, m; None if there is only one pair.
    skipped : tuple of dict
        Pairs without a result, with the reasons.
    warnings : tuple of Finding
        Warnings about slip directions and movements that deviate from the fault plane.
    """

    what: str
    n: int
    pairs: tuple[Pair, ...]
    mean_net_m: float
    std_net_m: float | None
    mean_throw_m: float
    std_throw_m: float | None
    mean_heave_m: float
    std_heave_m: float | None
    skipped: tuple[dict[str, Any], ...]
    warnings: tuple[Finding, ...] = ()


def displacements(
    names: Sequence[str],
    hanging_wall: FloatArray,
    footwall: FloatArray,
    options: DisplacementOptions,
) -> Displacements:
    """Compute the displacements of pairs of points on both sides of a fault.

    Parameters
    ----------
    names : sequence of str
    hanging_wall, footwall : ndarray of float, shape (n, 3)
        Points in the World frame, m. If no bed is given, the points of a pair originally coincided.
    options : DisplacementOptions

    Returns
    -------
    Displacements

    Raises
    ------
    GeometryError
        If none of the pairs has a result.
    UsageError
        If an attitude cannot be parsed, or if a rake is given for a horizontal fault.
    """
    fault = parse_plane_option(options.fault, "--fault")
    bed = None if options.bed is None else parse_plane_option(options.bed, "--bed")
    slip = None if options.slip is None else parse_line_option(options.slip, "--slip")
    rake_deg = options.rake_deg
    errors = DisplacementErrors(
        options.sigma_m or 0.0,
        options.fault_error_deg,
        options.bed_error_deg,
        options.rake_error_deg,
    )
    warnings: list[Finding] = []
    if slip is not None:
        rake_deg = compute_rake(slip, fault)
        warnings += _slip_warnings(slip, fault)
    elif rake_deg is not None:
        warnings += _rake_warnings(fault)
    pairs: list[Pair] = []
    skipped_pairs: list[dict[str, Any]] = []
    for name, hanging_wall_xyz, footwall_xyz in zip(names, hanging_wall, footwall, strict=True):
        try:
            pairs.append(
                _measure_pair(name, hanging_wall_xyz, footwall_xyz, fault, bed, rake_deg, errors)
            )
        except GeometryError as error:
            skipped_pairs.append({"id": name, "reason": cause_finding(error)})
    vectors = [d for d in map(_reported_displacement, pairs) if d is not None]
    if not vectors and skipped_pairs:
        raise GeometryError(skipped_pairs[0]["reason"])
    if not vectors:
        raise GeometryError(Finding("displacement.bed-down-dip"))

    def mean(attribute: str) -> tuple[float, float | None]:
        values = [getattr(vector, attribute).value for vector in vectors]
        return float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else None

    return Displacements(
        vectors[0].what,
        len(pairs),
        tuple(pairs),
        *mean("net_m"),
        *mean("throw_m"),
        *mean("heave_m"),
        tuple(skipped_pairs),
        (*warnings, *_motion_warnings(pairs, errors)),
    )


def _slip_warnings(slip: Line, fault: Plane) -> list[Finding]:
    angle = angle_line_plane(slip, fault)
    if not angle > MAX_OFF_PLANE_DEG:
        return []
    return [Finding("displacement.slip-off-fault", angle_deg=angle, limit_deg=MAX_OFF_PLANE_DEG)]


def _rake_warnings(fault: Plane) -> list[Finding]:
    """Warn that the strike of a vertical fault is ambiguous as the origin of the rake.

    Raises UsageError if the fault is horizontal.
    """
    if fault.undefined:
        raise UsageError(Finding("displacement.rake-without-strike"), field="--rake")
    if not fault.vertical or fault.strike_rhr_deg < 180.0:
        return []
    return [
        Finding(
            "displacement.rake-of-vertical-fault",
            strike_deg=fault.strike_rhr_deg - 180.0,
            other_deg=fault.strike_rhr_deg,
        )
    ]


def _motion_warnings(pairs: Sequence[Pair], errors: DisplacementErrors) -> list[Finding]:
    """Warn about piercing points that move out of the fault plane by more than their errors."""
    deviations: dict[str, tuple[float, float]] = {}
    for pair in pairs:
        displacement = pair.displacement
        if displacement is None or not displacement.net_m.value > 0:
            continue
        sine = min(1.0, abs(displacement.off_fault_m) / displacement.net_m.value)
        angle = float(np.degrees(np.arcsin(sine)))
        error_m = Z95 * np.sqrt(2.0) * errors.sigma_m
        if (
            angle > max(MAX_OFF_PLANE_DEG, errors.fault95_deg)
            and abs(displacement.off_fault_m) > error_m
        ):
            deviations[pair.name] = (angle, abs(displacement.off_fault_m))
    if not deviations:
        return []
    return [
        Finding(
            "displacement.motion-off-fault",
            count=len(deviations),
            limit_deg=MAX_OFF_PLANE_DEG,
            pairs=list(deviations),
            angle_deg=[angle for angle, _ in deviations.values()],
            distance_m=[angle for _, angle in deviations.values()],
        )
    ]


def _reported_displacement(pair: Pair) -> Displacement | None:
    """Return the displacement, or the dip separation if the slip is unknown.

    The dip separation is None if it is undefined.
    """
    return pair.displacement if pair.separations is None else pair.separations.dip


def _measure_pair(
    name: str,
    hanging_wall_point: FloatArray,
    footwall_point: FloatArray,
    fault: Plane,
    bed: Plane | None,
    rake: float | None,
    errors: DisplacementErrors,
) -> Pair:
    if bed is None:
        return Pair(
            name,
            net_slip_from_piercing_points(hanging_wall_point, footwall_point, fault, errors),
            None,
        )
    if rake is None:
        return Pair(name, None, separations(hanging_wall_point, footwall_point, fault, bed, errors))
    return Pair(
        name,
        net_slip_from_cutoffs(hanging_wall_point, footwall_point, fault, bed, rake, errors),
        None,
    )
