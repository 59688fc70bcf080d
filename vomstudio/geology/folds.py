"""Fold axes and common axes: pi-plane and beta, with error and validity.

Beta is the eigenvector of S3 of the orientation tensor of the poles, that is, the pole of the
best-fit plane through them (textbook 4.2, fig. 31). Its confidence region is the asymptotic one of
a principal axis, with the variance S3 Sj / (n (Sj - S3)^2) toward axis j (Anderson 1963, Annals of
Mathematical Statistics 34, 122-148; Fisher, Lewis & Embleton 1987, Statistical analysis of
spherical data, ch. 6). In S3, n is replaced by n - 2, and chi-square by F(0.95; 2, n - 2), as in
the regression that it approaches for a small scatter about the great circle. The region is joint
(both tilts at once) at 95 % and assumes that the deviations of the poles from the great circle are
independent and identically distributed.

An axis is valid only if its region is small. Among folds with equal scatter, this favours those
whose few poles have a small scatter by chance, and their regions contain the axis in less than 95 %
of cases. The semi-axes are therefore widened by a factor of 1 + 1 / (n - 2), and with fewer than
`MIN_PLANES_FOR_VALID_AXIS` planes no axis is valid without conditions. The script
`tests/benchmarks/bench_folds.py` prints the coverage of the regions for all axes and for the valid
ones. A region over 30 degrees has a coverage of 85 %; an axis whose error exceeds
`MAX_USABLE_AXIS_ERROR_DEG` is reported as weak. The error of the registration is common to the
planes of a model and does not decrease with their number (see common_rotation_errors).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import (
    ConfidenceRegion,
    RotationErrors,
    VectorsWithDerivatives,
    differentiate_vectors,
    principal_axis,
    region,
)
from vomstudio.geology.folding.arcs import arc_deg, arc_ends, rms
from vomstudio.geology.folding.figures import (
    AxisFigures,
    BetaFigures,
    ConeFigures,
    InfluentialPlane,
    LimbFigures,
    OutlyingPlane,
    PairIntersection,
    PlaneAttitude,
    SmallCircleFigures,
)
from vomstudio.geology.folding.findings import (
    bowed_findings,
    cone_excluded_finding,
    decisive_plane_finding,
    error_finding,
    shape_findings,
)
from vomstudio.geology.folding.limbs import find_lone_limb
from vomstudio.geology.folding.shapes import PoleShape, describe_shape, find_outliers
from vomstudio.geology.folding.verdicts import (
    MAX_USABLE_AXIS_ERROR_DEG,
    MIN_PLANES,
    FoldVerdict,
    assess_fold,
)
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    compute_rake,
    planes_to_poles,
)
from vomstudio.geology.populations.distributions import LineAttitude, assess_uniformity, f95
from vomstudio.geology.statistics import orientation_tensor, unit_vectors

MIN_TURN_DEG = 1.0
"""Minimum rotation of beta that affects a verdict, even if the planes are exact."""

MIN_SECOND_EIGENVALUE = 1e-10
"""Minimum S2; below it, the planes are parallel (to 1e-5 rad), and any line in them is an axis."""


@dataclass(frozen=True, eq=False)
class FoldAxis:
    """Fold axis with its uncertainty and its verdict.

    Attributes
    ----------
    n : int
        Number of planes, or of sets in the case of a common axis.
    beta : Line
        Fold axis, plunging downward.
    pi_plane : Plane
        Plane normal to beta, the best-fit plane through the poles.
    eigenvalues : (float, float, float)
        S1 >= S2 >= S3 of the orientation tensor, whose sum is 1.
    rms_deg : float
        RMS angle between the poles and the pi-plane, degrees.
    arc_deg : float
        Shortest arc of the pi-plane that contains all (axial) poles, 0 to 180 degrees.
    max_confidence95_deg, min_confidence95_deg : float or None
        Semi-axes of the joint 95 % region of beta, degrees; None if there is no redundancy.
    confidence_direction_deg : float or None
        Direction in which beta is least certain, as a rake in the pi-plane, 0 to 180 degrees from
        its right-hand-rule strike.
    confidence_axis : Line or None
        The same direction as a line.
    valid : {"yes", "conditional", "no"}
    verdict : str
    reasons : tuple of Finding
    registration_error_deg : float or None
        Larger half-angle of the 95 % region of beta due to the registrations, degrees; None if
        unknown.
    total : ConfidenceRegion or None
        Joint 95 % region including the registration; None if the region of the planes is unknown.
    strays : tuple of OutlyingPlane
        Outlying planes that are excluded from the verdict but included in beta.
    """

    n: int
    beta: Line
    pi_plane: Plane
    eigenvalues: tuple[float, float, float]
    rms_deg: float
    arc_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    confidence_direction_deg: float | None
    confidence_axis: Line | None
    valid: str
    verdict: str
    reasons: tuple[Finding, ...]
    registration_error_deg: float | None = None
    total: ConfidenceRegion | None = None
    shape: PoleShape | None = None
    limbs: LimbFigures | None = None
    leave_one_out: InfluentialPlane | None = None
    pairs: tuple[PairIntersection, ...] = ()
    strays: tuple[OutlyingPlane, ...] = ()

    @property
    def error95_deg(self) -> float | None:
        """Larger half-angle of the total 95 % region of beta, degrees; None if unknown."""
        return self.max_confidence95_deg if self.total is None else self.total.largest_deg

    @property
    def figures(self) -> AxisFigures:
        """Results as plain numbers and text."""
        direction, total_region = self.confidence_axis, self.total
        return AxisFigures(
            BetaFigures(
                self.beta.trend_deg,
                self.beta.plunge_deg,
                self.max_confidence95_deg,
                self.min_confidence95_deg,
                self.confidence_direction_deg,
                _line_attitude(direction),
                self.registration_error_deg,
                None if total_region is None else total_region.largest_deg,
                None if total_region is None else total_region.smallest_deg,
                None if total_region is None else _line_attitude(total_region.line),
            ),
            plane_attitude(self.pi_plane),
            self.eigenvalues,
            self.rms_deg,
            self.rms_deg if self.shape is None else self.shape.within90_deg,
            self.arc_deg,
            None if self.shape is None else _cone_figures(self.shape),
            self.limbs,
            self.leave_one_out,
            self.strays,
            self.pairs,
            self.valid,
            self.verdict,
            self.reasons,
        )


def _line_attitude(line: Line | None) -> LineAttitude | None:
    return None if line is None else LineAttitude(line.trend_deg, line.plunge_deg)


def fold_axis(
    dip_direction_deg: npt.ArrayLike,
    dip_deg: npt.ArrayLike,
    rotation_errors: RotationErrors | None = None,
    bowed_deg: float | None = None,
    waviness_deg: float | None = None,
    names: Sequence[str] | None = None,
    overturned: npt.ArrayLike | None = None,
) -> FoldAxis:
    """Compute the pi-plane and the fold axis beta of planes of one kind.

    Parameters
    ----------
    dip_direction_deg, dip_deg : (n,) array_like
        At least two planes, degrees.
    rotation_errors : RotationErrors, optional
        Errors of the registrations of the n planes.
    bowed_deg : float, optional
        Difference in dip between the edges of a bowed model, degrees.
    waviness_deg : float, optional
        Standard deviation of the poles of a cylindrical fold from the great circle, including their
        error, degrees; by default, the usual limits of a cylindrical fold apply.
    names : sequence of str, optional
        Names of the planes in findings; by default, they are numbered from 1.
    overturned : (n,) array_like of bool, optional
        True for overturned beds (younger side below), used for the interlimb angle.

    Returns
    -------
    FoldAxis

    Raises
    ------
    GeometryError
        If there are fewer than two planes, or if all are parallel.
    """
    poles = planes_to_poles(dip_direction_deg, dip_deg).reshape(-1, 3)
    n = len(poles)
    if n < 2:
        raise GeometryError(Finding("fold.one-plane", n=n))
    poles = unit_vectors(poles)
    eigenvalues, axes = orientation_tensor(poles)
    if eigenvalues[1] < MIN_SECOND_EIGENVALUE:
        raise GeometryError(Finding("fold.parallel-planes", n=n))
    semi_axes = _semi_axes(eigenvalues, n)
    poles_with_derivatives = (
        None
        if rotation_errors is None or not rotation_errors.has_known_errors
        else differentiate_vectors(poles, rotation_errors)
    )
    axis_with_derivatives = (
        None
        if poles_with_derivatives is None
        else principal_axis(poles_with_derivatives, eigenvalues, axes, 2)
    )
    overturned_flags = None if overturned is None else np.asarray(overturned, bool).reshape(-1)
    shape = describe_shape(poles, eigenvalues, axes, overturned_flags)
    uniformity_p = assess_uniformity(poles, False).p
    bowing_findings = bowed_findings(bowed_deg, shape.arc_deg)

    leave_one_out = None if n < 4 else _leave_one_out(poles, axes[2])
    labels = names or [str(row + 1) for row in range(n)]
    is_outlier, fold_without_outliers = find_outliers(poles, axes), None
    if is_outlier.any():
        is_used = ~is_outlier
        azimuths_deg, dips_deg = (
            np.atleast_1d(dip_direction_deg)[is_used],
            np.atleast_1d(dip_deg)[is_used],
        )
        used_rotation_errors = None if rotation_errors is None else rotation_errors.of(is_used)
        used_flags = None if overturned_flags is None else overturned_flags[is_used]
        used_labels = [labels[row] for row in np.flatnonzero(is_used).tolist()]
        fold_without_outliers = fold_axis(
            azimuths_deg,
            dips_deg,
            used_rotation_errors,
            bowed_deg,
            waviness_deg,
            used_labels,
            used_flags,
        )
        if fold_without_outliers.valid == "no" or fold_without_outliers.strays:
            fold_without_outliers = None

    def judge(error95_deg: float | None) -> FoldVerdict:
        verdict = assess_fold(shape, error95_deg, uniformity_p, waviness_deg)
        valid_text = "conditional" if bowing_findings and verdict.valid == "yes" else verdict.valid
        verdict = replace(verdict, valid=valid_text, reasons=(*bowing_findings, *verdict.reasons))
        if fold_without_outliers is not None or leave_one_out is None or semi_axes is None:
            return verdict
        return _check_single_planes(
            verdict,
            poles,
            shape,
            leave_one_out,
            semi_axes[0],
            labels,
            bowing_findings,
            waviness_deg,
        )

    result = build_axis(
        poles,
        eigenvalues,
        axes,
        semi_axes,
        axes[1],
        judge,
        axis_with_derivatives,
        shape_findings(shape),
    )
    result = replace(result, shape=shape, limbs=_limb_figures(shape), leave_one_out=leave_one_out)
    if fold_without_outliers is None:
        return result
    outlier_rows = np.flatnonzero(is_outlier).tolist()
    outlier_labels = [labels[row] for row in outlier_rows]
    return replace(
        result,
        strays=tuple(OutlyingPlane(row, names[row] if names else None) for row in outlier_rows),
        valid="conditional",
        verdict=fold_without_outliers.verdict,
        reasons=(
            _outliers_finding(outlier_labels, result, fold_without_outliers),
            *fold_without_outliers.reasons,
        ),
    )


def _semi_axes(eigenvalues: FloatArray, n: int) -> tuple[float, float] | None:
    """Return the semi-axes of the joint 95 % region of beta for n poles, larger first.

    The semi-axes are in degrees. Returns None for fewer than three poles (no redundancy).
    """
    if n < 3:
        return None
    variance = (
        eigenvalues[2]
        * eigenvalues[:2]
        / ((n - 2) * (eigenvalues[:2] - eigenvalues[2]) ** 2 + 1e-300)
    )
    widening = 1.0 + 1.0 / (n - 2)
    minor_deg, major_deg = np.degrees(np.arctan(widening * np.sqrt(variance * 2.0 * f95(n - 2))))
    return float(major_deg), float(minor_deg)


def _check_single_planes(
    verdict: FoldVerdict,
    poles: FloatArray,
    shape: PoleShape,
    leave_one_out: InfluentialPlane,
    error95_deg: float,
    names: Sequence[str],
    bowing_findings: Sequence[Finding],
    waviness_deg: float | None,
) -> FoldVerdict:
    """Return the verdict, or "undetermined" if it depends on a single plane.

    This is the case if omitting the plane moves beta out of its own 95 % region, or changes the
    verdict. A cylindrical verdict becomes conditional if a cone is excluded because of one plane.
    """
    if len(poles) < MIN_PLANES or verdict.name in ("homoclinal", "scattered"):
        return verdict
    is_influential = leave_one_out.turn_deg > max(error95_deg, MIN_TURN_DEG)
    row, verdict_without_plane = find_lone_limb(poles), None
    if row is None and verdict.name != "undetermined":
        row, verdict_without_plane = _find_decisive_plane(
            verdict, poles, shape, leave_one_out.index, waviness_deg
        )
    if row is None and is_influential and verdict.name not in ("conical", "two axes"):
        # Without a single axis, a rotation of beta is irrelevant.
        row = leave_one_out.index
    if row is None:
        return verdict
    if (
        verdict_without_plane is not None
        and verdict_without_plane.is_cone_untested
        and verdict.name == "cylindrical"
    ):
        finding = cone_excluded_finding(names[row], verdict_without_plane)
        return replace(verdict, valid="conditional", reasons=(finding, *verdict.reasons))
    angle = leave_one_out.turn_deg if is_influential and row == leave_one_out.index else None
    finding = decisive_plane_finding(names[row], angle, error95_deg, verdict_without_plane)
    if verdict.name == "undetermined":
        return replace(verdict, reasons=(finding, *verdict.reasons))
    # The reasons for the shape no longer apply.
    return FoldVerdict("undetermined", "conditional", (finding, *bowing_findings))


def _find_decisive_plane(
    verdict: FoldVerdict,
    poles: FloatArray,
    shape: PoleShape,
    most_influential_row: int,
    waviness_deg: float | None,
) -> tuple[int | None, FoldVerdict | None]:
    """Find a plane whose omission changes the verdict.

    Only planes that can have this effect are tested: the ends of the arc, the plane farthest from
    the great circle, and the plane that rotates beta most.

    Returns
    -------
    row : int or None
    verdict : FoldVerdict or None
        Verdict on the remaining planes.
    """
    farthest_row = int(np.argmax(np.abs(poles @ shape.axes[2])))
    for row in dict.fromkeys((*arc_ends(poles, shape.axes), most_influential_row, farthest_row)):
        # Two axes of the remaining planes do not contradict any other verdict.
        has_two_axes = verdict.name == "two axes"
        verdict_without_plane = _verdict_without_plane(
            poles, row, waviness_deg, test_two_circles=has_two_axes
        )
        # The best of several cones through all planes but one often fits better by chance.
        is_cone_artifact = verdict.name == "cylindrical" and verdict_without_plane.name == "conical"
        is_same_verdict = (
            verdict_without_plane.name == verdict.name
            or verdict.valid == verdict_without_plane.valid == "no"
        )
        if not is_same_verdict and not is_cone_artifact:
            return row, verdict_without_plane
    return None, None


def _verdict_without_plane(
    poles: FloatArray, row: int, waviness_deg: float | None, *, test_two_circles: bool
) -> FoldVerdict:
    """Return the verdict without one plane, scaled to the original number of planes.

    A larger error or a shorter arc that is due only to the smaller number of planes is ignored.
    """
    n, other_poles = len(poles), np.delete(poles, row, axis=0)
    eigenvalues, axes = orientation_tensor(other_poles)
    shape = describe_shape(other_poles, eigenvalues, axes)
    semi_axes = _semi_axes(eigenvalues, n)
    error = None if semi_axes is None else semi_axes[0]
    cone = None if shape.cone is None else shape.cone.with_count(n - 1, n)
    scaled_shape = replace(shape, cone=cone, arc_deg=shape.arc_deg * (n - 1) / (n - 2))
    uniformity_p = assess_uniformity(other_poles, False).p
    return assess_fold(
        scaled_shape,
        error,
        uniformity_p,
        waviness_deg,
        MIN_PLANES - 1,
        test_two_circles=test_two_circles,
    )


def build_axis(
    poles: FloatArray,
    eigenvalues: FloatArray,
    axes: FloatArray,
    semi_axes: tuple[float, float] | None,
    major_direction: FloatArray,
    judge: Callable[[float | None], FoldVerdict],
    axis_with_derivatives: VectorsWithDerivatives | None,
    notes: Sequence[Finding],
) -> FoldAxis:
    """Build the fold axis of poles, or of the means of sets, with its errors and verdict.

    Parameters
    ----------
    poles : (n, 3) ndarray
    eigenvalues, axes : (3,) and (3, 3) ndarray
        Eigenvalues and eigenvectors of the orientation tensor of the poles.
    semi_axes : tuple of float or None
        Semi-axes of the joint 95 % region of beta in degrees, the larger one first.
    major_direction : (3,) ndarray
        Direction of the larger semi-axis.
    judge : callable
        Function that returns the verdict for a 95 % error of beta in degrees (None if unknown).
    axis_with_derivatives : VectorsWithDerivatives or None
        Beta with its derivatives with respect to the rotations of the registrations.
    notes : sequence of Finding
        Findings to append to the reasons of the verdict.

    Returns
    -------
    FoldAxis
    """
    beta = Line.from_vector(axes[2])
    pi_plane = beta.normal_plane()
    covariance = None if axis_with_derivatives is None else axis_with_derivatives.covariance()[0]
    total_region = (
        None if semi_axes is None else region(axes[2], covariance, (*semi_axes, major_direction))
    )
    registration_deg, registration_findings = None, list[Finding]()
    if covariance is not None:
        registration_deg = region(axes[2], covariance).largest_deg
        registration_findings = [_registration_finding(registration_deg, total_region)]
    direction = None if semi_axes is None else Line.from_vector(major_direction)
    verdict = judge(None if total_region is None else total_region.largest_deg)
    deviations_deg = np.degrees(np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0)))
    error_findings = [] if semi_axes is None else [error_finding(semi_axes)]
    return FoldAxis(
        n=len(poles),
        beta=beta,
        pi_plane=pi_plane,
        eigenvalues=(float(eigenvalues[0]), float(eigenvalues[1]), float(eigenvalues[2])),
        rms_deg=rms(deviations_deg),
        arc_deg=arc_deg(poles, axes),
        max_confidence95_deg=None if semi_axes is None else semi_axes[0],
        min_confidence95_deg=None if semi_axes is None else semi_axes[1],
        confidence_direction_deg=None if direction is None else compute_rake(direction, pi_plane),
        confidence_axis=direction,
        valid=verdict.valid,
        verdict=verdict.name,
        reasons=(*verdict.reasons, *notes, *error_findings, *registration_findings),
        registration_error_deg=registration_deg,
        total=total_region,
    )


def plane_attitude(plane: Plane) -> PlaneAttitude:
    """Return the angles of a plane as plain numbers.

    Parameters
    ----------
    plane : Plane

    Returns
    -------
    PlaneAttitude
    """
    return PlaneAttitude(plane.dip_direction_deg, plane.dip_deg, plane.strike_rhr_deg)


def _cone_figures(shape: PoleShape) -> ConeFigures | None:
    cone = shape.cone
    if cone is None:
        return None
    width = cone.half_width_deg if math.isfinite(cone.half_width_deg) else None
    line, nearer_ends_circle, nearer_ends_figures = cone.axis, cone.nearer_ends_circle, None
    if nearer_ends_circle is not None:
        nearer_ends_figures = SmallCircleFigures(
            nearer_ends_circle.axis.trend_deg,
            nearer_ends_circle.axis.plunge_deg,
            nearer_ends_circle.half_angle_deg,
            nearer_ends_circle.rms_deg,
        )
    return ConeFigures(
        line.trend_deg,
        line.plunge_deg,
        cone.half_angle_deg,
        width,
        cone.rms_deg,
        cone.p,
        nearer_ends_figures,
    )


def _limb_figures(shape: PoleShape) -> LimbFigures | None:
    """Return the figures of the limbs, or None if the poles do not determine them.

    The interlimb angle is 180 degrees minus the angle between the normals toward younger beds.
    """
    if shape.limbs is None or shape.limbs.doubt:
        return None
    limbs = shape.limbs
    first, second = limbs.up
    pole_angle = math.degrees(
        math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second))
    )
    planes = tuple(plane_attitude(Plane.from_normal(pole)) for pole in (first, second))
    axial_plane = Plane.from_normal(first - second)
    angle_error, axial_error = limbs.errors95_deg(shape.axes[2])
    return LimbFigures(
        (planes[0], planes[1]),
        limbs.counts,
        180.0 - pole_angle,
        plane_attitude(axial_plane),
        angle_error,
        axial_error,
        limbs.overturned,
    )


def _leave_one_out(poles: FloatArray, beta: FloatArray) -> InfluentialPlane | None:
    """Find the plane whose omission rotates beta most."""
    tensor = poles.T @ poles
    tensors = tensor - poles[:, :, None] * poles[:, None, :]
    axes = np.linalg.eigh(tensors)[1][:, :, 0]
    angle = np.degrees(np.arccos(np.minimum(np.abs(axes @ beta), 1.0)))
    worst_row = int(np.argmax(angle))
    line = Line.from_vector(axes[worst_row])
    return InfluentialPlane(
        worst_row, None, float(angle[worst_row]), line.trend_deg, line.plunge_deg
    )


def _outliers_finding(
    planes: Sequence[str], axis: FoldAxis, fold_without_outliers: FoldAxis
) -> Finding:
    """Report the outlying planes, which are excluded from the verdict."""
    return Finding(
        "fold.strays",
        count=len(planes),
        n=axis.n,
        planes=planes,
        trend_deg=fold_without_outliers.beta.trend_deg,
        plunge_deg=fold_without_outliers.beta.plunge_deg,
        turn_deg=angle_between_lines(axis.beta, fold_without_outliers.beta),
    )


def _registration_finding(
    registration_deg: float, total_region: ConfidenceRegion | None
) -> Finding:
    """Report the error of beta due to the registration, common to all planes of a model."""
    if total_region is None:
        return Finding("fold.registration-alone", error_deg=registration_deg)
    is_weak = total_region.largest_deg > MAX_USABLE_AXIS_ERROR_DEG
    return Finding(
        "fold.registration-weak" if is_weak else "fold.registration",
        error_deg=registration_deg,
        major_deg=total_region.largest_deg,
        minor_deg=total_region.smallest_deg,
        limit_deg=MAX_USABLE_AXIS_ERROR_DEG,
    )
