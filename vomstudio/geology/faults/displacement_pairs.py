"""Displacements of many pairs on one fault: what `vomstudio displacement` prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.faults.displacement import (
    Displacement,
    Errors,
    Separations,
    net_slip_of_cutoffs,
    net_slip_of_piercing_points,
    separations,
)
from vomstudio.geology.faults.displacement_options import DisplacementOptions
from vomstudio.geology.notation import line_option, plane_option
from vomstudio.geology.orientation import Line, Plane, angle_line_plane, rake_of
from vomstudio.geometry.rotation_errors import Z95

OFF_PLANE_DEG = 10.0
"""Slips that leave their fault by more are doubtful."""
_NAMED = 8


@dataclass(frozen=True)
class Pair:
    """One of the two is None."""

    name: str
    displacement: Displacement | None
    separations: Separations | None


@dataclass(frozen=True, repr=False)
class Displacements(PrintableResult):
    """what : net slip, or separation where the slip is unknown; mean_net_m, mean_throw_m,
    mean_heave_m with the standard deviation of the pairs, None of one pair; of separations the dip
    separation. skipped : pairs without a result, with the reason; warnings : on slips and motions
    that leave the fault"""

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
        World, m. Without a bed the points of a pair were one.
    options : DisplacementOptions

    Returns
    -------
    Displacements

    Raises
    ------
    GeometryError
        If no pair has a result.
    UsageError
        For attitudes that cannot be read, and for a rake on a horizontal fault.
    """
    fault = plane_option(options.fault, "--fault")
    bed = None if options.bed is None else plane_option(options.bed, "--bed")
    slip = None if options.slip is None else line_option(options.slip, "--slip")
    rake_deg = options.rake_deg
    errors = Errors(
        options.sigma_m or 0.0,
        options.fault_error_deg,
        options.bed_error_deg,
        options.rake_error_deg,
    )
    warnings: list[Finding] = []
    if slip is not None:
        rake_deg = rake_of(slip, fault)
        warnings += _slip_warnings(slip, fault)
    elif rake_deg is not None:
        warnings += _rake_warnings(fault)
    pairs: list[Pair] = []
    skipped: list[dict[str, Any]] = []
    for name, h, f in zip(names, hanging_wall, footwall, strict=True):
        try:
            pairs.append(_pair(name, h, f, fault, bed, rake_deg, errors))
        except GeometryError as error:
            skipped.append({"id": name, "reason": cause_of(error)})
    vectors = [d for d in map(_vector, pairs) if d is not None]
    if not vectors and skipped:
        raise GeometryError(skipped[0]["reason"])
    if not vectors:
        raise GeometryError(Finding("displacement.bed-down-dip"))

    def mean(name: str) -> tuple[float, float | None]:
        values = [getattr(d, name).value for d in vectors]
        return float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else None

    return Displacements(
        vectors[0].what,
        len(pairs),
        tuple(pairs),
        *mean("net_m"),
        *mean("throw_m"),
        *mean("heave_m"),
        tuple(skipped),
        (*warnings, *_motion_warnings(pairs, errors)),
    )


def _slip_warnings(slip: Line, fault: Plane) -> list[Finding]:
    away = angle_line_plane(slip, fault)
    if not away > OFF_PLANE_DEG:
        return []
    return [Finding("displacement.slip-off-fault", angle_deg=away, limit_deg=OFF_PLANE_DEG)]


def _rake_warnings(fault: Plane) -> list[Finding]:
    """Warn of a vertical fault whose strike is ambiguous as the origin of the rake."""
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


def _motion_warnings(pairs: Sequence[Pair], errors: Errors) -> list[Finding]:
    """Warn of piercing points whose motion leaves the fault by more than their errors explain."""
    off: dict[str, tuple[float, float]] = {}
    for pair in pairs:
        moved = pair.displacement
        if moved is None or not moved.net_m.value > 0:
            continue
        out = min(1.0, abs(moved.off_fault_m) / moved.net_m.value)
        away = float(np.degrees(np.arcsin(out)))
        by_points = Z95 * np.sqrt(2.0) * errors.sigma_m
        if away > max(OFF_PLANE_DEG, errors.fault95_deg) and abs(moved.off_fault_m) > by_points:
            off[pair.name] = (away, abs(moved.off_fault_m))
    if not off:
        return []
    return [
        Finding(
            "displacement.motion-off-fault",
            count=len(off),
            limit_deg=OFF_PLANE_DEG,
            pairs=list(off),
            angle_deg=[angle for angle, _ in off.values()],
            distance_m=[away for _, away in off.values()],
        )
    ]


def _vector(pair: Pair) -> Displacement | None:
    """The slip, or the dip separation where that is all there is."""
    return pair.displacement if pair.separations is None else pair.separations.dip


def _pair(
    name: str,
    h: FloatArray,
    f: FloatArray,
    fault: Plane,
    bed: Plane | None,
    rake: float | None,
    errors: Errors,
) -> Pair:
    if bed is None:
        return Pair(name, net_slip_of_piercing_points(h, f, fault, errors), None)
    if rake is None:
        return Pair(name, None, separations(h, f, fault, bed, errors))
    return Pair(name, net_slip_of_cutoffs(h, f, fault, bed, rake, errors), None)
