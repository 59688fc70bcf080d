"""Structural domains with their own fold axes, and a test whether one axis fits all.

If no direction is valid for all domains (fig. 31c), a section projects each domain along its own
axis. An F test (extra sum of squares of nested fits) compares a single great circle through all
poles with one great circle per domain. A domain of uniform dip has no axis of its own: only the
angle between its mean pole and the common great circle enters the test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import tr
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.folding.figures import AxisFigures
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Line, angle_between_lines, planes_to_poles
from vomstudio.geology.populations.probabilities import f_tail
from vomstudio.geology.statistics import flip_to_hemisphere, orientation_tensor

AXIS_DIFFERENCE_SIGNIFICANCE, MIN_AXIS_DIFFERENCE_DEG = 0.05, 5.0
"""Significance level and minimum angle for the axes of domains to be considered different."""


@dataclass(frozen=True)
class DomainFigures:
    """Number of planes of a domain, and its axis or the reason why it has none."""

    n: int
    axis: AxisFigures | None
    reason: Finding | None


@dataclass(frozen=True)
class OneAxisTest:
    """Result of the test whether one axis fits all domains.

    Attributes
    ----------
    F, p : float or None
        F statistic of the extra sum of squares and its p-value; None if the test is not possible.
    apart_deg : float or None
        Largest angle between the axes of two domains, degrees; None if fewer than two domains have
        an axis.
    beds_off_deg : float or None
        Largest angle between the common axis and the mean bed of a domain that has no axis,
        degrees; None if all domains have an axis.
    """

    serves_all: bool
    F: float | None
    p: float | None
    apart_deg: float | None
    beds_off_deg: float | None
    reasons: tuple[Finding, ...]


def describe_domain(domain: DomainFigures, decimals: int) -> str:
    """Describe a domain in one line: its count and its axis, or why it has none.

    Parameters
    ----------
    domain : DomainFigures
    decimals : int
        Number of decimals for angles.

    Returns
    -------
    str
    """
    if domain.axis is None:
        return tr("n = {n}: {reason}", n=domain.n, reason=domain.reason)
    if domain.axis.verdict == "homoclinal":
        return tr("n = {n}: one dip, no axis of its own", n=domain.n)
    beta = domain.axis.beta
    return tr(
        "n = {n}: beta {line}; {verdict}; valid: {valid}",
        n=domain.n,
        line=format_line(Line(beta.trend_deg, beta.plunge_deg), decimals),
        verdict=domain.axis.verdict,
        valid=domain.axis.valid,
    )


def apply_domain_verdict(axis: FoldAxis, one_axis_test: OneAxisTest) -> FoldAxis:
    """Return the axis of all planes with its verdict adjusted to the domains.

    Parameters
    ----------
    axis : FoldAxis
        Axis of all planes.
    one_axis_test : OneAxisTest

    Returns
    -------
    FoldAxis
    """
    if one_axis_test.serves_all:
        return replace(axis, reasons=(*axis.reasons, *one_axis_test.reasons))
    reasons = (*one_axis_test.reasons, *axis.reasons)
    return replace(axis, verdict="two axes", valid="no", reasons=reasons)


def domain_axes(
    beds: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    common_axis: FoldAxis,
    waviness_deg: float | None = None,
) -> tuple[dict[str, DomainFigures], OneAxisTest]:
    """Compute the fold axis of each domain, and test whether one axis fits all.

    Parameters
    ----------
    beds : mapping
        Dip directions and dips (n,) of each domain, degrees.
    common_axis : FoldAxis
        Fold axis of the planes of all domains.
    waviness_deg : float, optional
        See `fold_axis`.

    Returns
    -------
    figures : dict of str to DomainFigures
    test : OneAxisTest
    """
    beta = common_axis.beta.vector()
    figures: dict[str, DomainFigures] = {}
    axes_by_domain: dict[str, FoldAxis] = {}
    separate_squares, n_parameters, n = 0.0, 0, 0
    pooled_squares, bed_angles_deg = 0.0, list[float]()
    for name, (azimuth, dip) in beds.items():
        poles = planes_to_poles(azimuth, dip).reshape(-1, 3)
        n += len(poles)
        pooled_squares += _sum_of_squares(poles @ beta)
        axis, reason = _domain_axis(azimuth, dip, waviness_deg)
        if axis is not None and axis.verdict != "homoclinal" and len(poles) > 2:
            axes_by_domain[name] = axis
            separate_squares += _sum_of_squares(poles @ axis.beta.vector())
            n_parameters += 2
        else:
            axes = orientation_tensor(poles)[1]
            projections = flip_to_hemisphere(poles, axes[0]) @ beta
            separate_squares += float(np.sum((projections - projections.mean()) ** 2))
            n_parameters += 1
            bed_angles_deg.append(math.degrees(math.asin(min(abs(float(axes[0] @ beta)), 1.0))))
        figures[name] = DomainFigures(len(poles), None if axis is None else axis.figures, reason)
    axis_angles_deg = [
        angle_between_lines(first_axis.beta, second_axis.beta)
        for first_axis, second_axis in combinations(axes_by_domain.values(), 2)
    ]
    return figures, _test_one_axis(
        pooled_squares,
        separate_squares,
        n_parameters,
        n,
        max(axis_angles_deg, default=None),
        max(bed_angles_deg, default=None),
    )


@dataclass(frozen=True)
class ProjectionAxis:
    """Axis along which a domain is projected.

    It is the fold axis of the domain, or the intersection line of its beds with the faults (fig.
    31c).

    Attributes
    ----------
    line : Line or None
        None if the domain has no such axis.
    error95_deg : float or None
        95 % error, degrees; None if unknown.
    description : str
        Name of the line, or the reason why the domain has none.
    valid : str or None
        Validity of the line, as in `FoldAxis`; None if the domain has no line.
    """

    line: Line | None
    error95_deg: float | None
    description: str
    valid: str | None = None


def projection_axes(
    beds: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    faults: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
) -> dict[str, ProjectionAxis]:
    """Compute the projection axis of each domain (textbook 4.2, fig. 31c and d).

    It is beta for a fold whose validity is not "no". Otherwise, it is the intersection of the mean
    plane of the beds with the mean plane of the faults, if faults are given.

    Parameters
    ----------
    beds : mapping of str to (array_like, array_like)
        Dip directions and dips of each domain, degrees.
    faults : (array_like, array_like), optional
        Dip directions and dips of all faults, degrees.

    Returns
    -------
    dict of str to ProjectionAxis
    """
    axes: dict[str, ProjectionAxis] = {}
    for name, (azimuth, dip) in beds.items():
        fold, reason = _domain_axis(azimuth, dip, None)
        if fold is not None and fold.verdict != "homoclinal" and fold.valid != "no":
            description = tr("fold axis, {verdict}", verdict=fold.verdict)
            axes[name] = ProjectionAxis(fold.beta, fold.error95_deg, description, fold.valid)
            continue
        if faults is not None:
            try:
                shared_axis = common_axis({"beds": (azimuth, dip), "faults": faults})
            except GeometryError as error:
                axes[name] = ProjectionAxis(None, None, error.message)
                continue
            description = tr("intersection of beds and faults")
            axes[name] = ProjectionAxis(
                shared_axis.beta, shared_axis.error95_deg, description, shared_axis.valid
            )
            continue
        description = (
            str(reason)
            if fold is None
            else tr("{verdict}, and no fault intersects its beds", verdict=fold.verdict)
        )
        axes[name] = ProjectionAxis(None, None, description)
    return axes


def _domain_axis(
    azimuth: npt.ArrayLike, dip: npt.ArrayLike, waviness_deg: float | None
) -> tuple[FoldAxis | None, Finding | None]:
    try:
        return fold_axis(azimuth, dip, waviness_deg=waviness_deg), None
    except GeometryError as error:
        return None, cause_finding(error)


def _sum_of_squares(axis_cosines: FloatArray) -> float:
    return float(np.sum(np.arcsin(np.clip(axis_cosines, -1.0, 1.0)) ** 2))


def _test_one_axis(
    pooled_squares: float,
    separate_squares: float,
    n_parameters: int,
    n: int,
    axes_angle_deg: float | None,
    beds_off_deg: float | None,
) -> OneAxisTest:
    n_extra_parameters, dof = n_parameters - 2, n - n_parameters
    if n_extra_parameters <= 0 or dof <= 0:
        reason = Finding("fold.one-dip-domains")
        return OneAxisTest(True, None, None, axes_angle_deg, beds_off_deg, (reason,))
    variance = max(separate_squares / dof, 1e-12)
    ratio = max(pooled_squares - separate_squares, 0.0) / n_extra_parameters / variance
    p = f_tail(n_extra_parameters, dof, ratio)
    is_significant = p < AXIS_DIFFERENCE_SIGNIFICANCE
    is_large = max(axes_angle_deg or 0.0, beds_off_deg or 0.0) >= MIN_AXIS_DIFFERENCE_DEG
    are_different = is_significant and is_large
    if is_significant and not is_large:
        reasons = [Finding("fold.domains-close", p=p, limit_deg=MIN_AXIS_DIFFERENCE_DEG)]
    else:
        reasons = [Finding("fold.domains-differ" if are_different else "fold.one-axis", p=p)]
    if axes_angle_deg is not None:
        reasons.append(Finding("fold.axes-apart", angle_deg=axes_angle_deg))
    if beds_off_deg is not None:
        reasons.append(Finding("fold.beds-off-axis", angle_deg=beds_off_deg))
    return OneAxisTest(not are_different, ratio, p, axes_angle_deg, beds_off_deg, tuple(reasons))
