"""Fold axes and common axes: the pi-plane, beta, how well beta is known, what may be done with it.

Beta is the eigenvector of S3 of the poles' orientation tensor, the pole of the best plane through
them (textbook 4.2, fig. 31). Its confidence region is the asymptotic one of a principal axis,
variance S3 Sj / (n (Sj - S3)^2) toward axis j (Anderson 1963, Annals of Mathematical Statistics
34, 122-148; Fisher, Lewis & Embleton 1987, Statistical analysis of spherical data, ch. 6), with n
replaced by n - 2 in S3 and F(0.95; 2, n - 2) in place of chi-square, as in the regression that it
becomes where the scatter about the great circle is small. It is joint (both tilts at once), 95 %,
and supposes that each pole strays from the great circle on its own and by the same law.

An axis is valid only if its region is small, and of folds that scatter alike that is so for those
whose few poles happen to scatter little: their regions hold less often than 95 %. So the semi-axes
are widened by 1 / (n - 2), and under `MIN_PLANES_FOR_YES` planes no axis is valid without
conditions. `tests/benchmarks/bench_folds.py` prints how often regions hold, of all axes and of the
valid ones. A region over 30 degrees holds in 85 % only, and from `WEAK_AXIS_DEG` on the result
says that the axis is weak. What the registration of the models adds to it is common to their
planes and does not shrink with their number (common_turns).
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
    Moved,
    Region,
    Turns,
    moved,
    principal_axis,
    region,
)
from vomstudio.geology.folding.arcs import arc_deg, arc_ends, rms
from vomstudio.geology.folding.figures import (
    AxisFigures,
    BetaFigures,
    ConeFigures,
    LeaveOneOut,
    LimbFigures,
    PairFigures,
    PlaneFigures,
    SmallCircleFigures,
    Stray,
)
from vomstudio.geology.folding.findings import (
    bowed_findings,
    cone_untested_finding,
    error_finding,
    lone_plane_finding,
    shape_findings,
)
from vomstudio.geology.folding.limbs import lone_limb
from vomstudio.geology.folding.shapes import Shape, shape_of, strays_of
from vomstudio.geology.folding.verdicts import FEW_PLANES, WEAK_AXIS_DEG, Verdict, verdict_of
from vomstudio.geology.orientation import Line, Plane, angle_between_lines, planes_to_poles, rake_of
from vomstudio.geology.populations.distributions import LineFigures, f95, uniformity
from vomstudio.geology.statistics import orientation_tensor, unit_vectors

FELT_DEG = 1.0
"""A turn of beta by less is no matter for any verdict, however exact the planes are."""

MIN_ARC = 1e-10
"""S2 below this: the planes are parallel (to 1e-5 rad); any line in them would do."""


@dataclass(frozen=True, eq=False)
class FoldAxis:
    """A view direction found from planes, with its uncertainty and its verdict.

    n: of the planes, or of the sets of a common axis.
    beta: the axis, plunging down. pi_plane: the plane normal to it, the best through the poles.
    max/min_confidence95_deg: semi-axes of the joint 95 % region of beta, None where the data have
    no redundancy.
    confidence_direction_deg: rake in the pi-plane, 0 to 180 from its right-hand-rule strike, of
    the direction in which beta tilts most; `confidence_axis` is the same direction as a line.
    eigenvalues: S1 >= S2 >= S3 of the tensor, sum 1.
    rms_deg: of the poles' angles from the pi-plane. arc_deg: shortest arc of the pi-plane that
    holds all poles (axial, 0 to 180).
    valid: "yes", "conditional" or "no"; verdict: its name; reasons: findings with numbers.
    registration_error_deg: larger half-angle of the 95 % region by which the registrations of the
    planes' models can turn beta, None where none is known. total: the joint 95 % region with it,
    None where that of the planes is not known.
    strays: the planes that the verdict is not about; beta is that of all.
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
    total: Region | None = None
    shape: Shape | None = None
    limbs: LimbFigures | None = None
    leave_one_out: LeaveOneOut | None = None
    pairs: tuple[PairFigures, ...] = ()
    strays: tuple[Stray, ...] = ()

    @property
    def error95_deg(self) -> float | None:
        """The larger half-angle of all that is known of beta's error."""
        return self.max_confidence95_deg if self.total is None else self.total.largest_deg

    @property
    def figures(self) -> AxisFigures:
        """The results as plain numbers and words."""
        swing, total = self.confidence_axis, self.total
        return AxisFigures(
            BetaFigures(
                self.beta.trend_deg,
                self.beta.plunge_deg,
                self.max_confidence95_deg,
                self.min_confidence95_deg,
                self.confidence_direction_deg,
                _line_figures(swing),
                self.registration_error_deg,
                None if total is None else total.largest_deg,
                None if total is None else total.smallest_deg,
                None if total is None else _line_figures(total.line),
            ),
            plane_figures(self.pi_plane),
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


def _line_figures(line: Line | None) -> LineFigures | None:
    return None if line is None else LineFigures(line.trend_deg, line.plunge_deg)


def fold_axis(
    dip_direction_deg: npt.ArrayLike,
    dip_deg: npt.ArrayLike,
    turns: Turns | None = None,
    bowed_deg: float | None = None,
    waviness_deg: float | None = None,
    names: Sequence[str] | None = None,
    overturned: npt.ArrayLike | None = None,
) -> FoldAxis:
    """Pi-plane and beta of n >= 2 planes of one kind (arrays (n,), degrees).

    turns : what is known of their registrations, (n,)
    bowed_deg : by how much dips differ from edge to edge of a model of theirs that is bowed
    waviness_deg : how far a pole strays by nature, with its error (standard deviation); None for
        the usual limits of a cylindrical fold
    names : of the planes, for what is said of single ones; None for their places, from 1
    overturned : (n,) whether younger beds lie below each, for the angle between limbs
    Raises GeometryError for fewer than two planes or planes that are all parallel.
    """
    poles = planes_to_poles(dip_direction_deg, dip_deg).reshape(-1, 3)
    n = len(poles)
    if n < 2:
        raise GeometryError(Finding("fold.one-plane", n=n))
    poles = unit_vectors(poles)
    values, axes = orientation_tensor(poles)
    if values[1] < MIN_ARC:
        raise GeometryError(Finding("fold.parallel-planes", n=n))
    semi_axes = _semi_axes(values, n)
    given = None if turns is None or not turns.known else moved(poles, turns)
    turned = None if given is None else principal_axis(given, values, axes, 2)
    flags = None if overturned is None else np.asarray(overturned, bool).reshape(-1)
    shape = shape_of(poles, values, axes, flags)
    uniform = uniformity(poles, False).p
    bowed = bowed_findings(bowed_deg, shape.arc_deg)

    left_out = None if n < 4 else _leave_one_out(poles, axes[2])
    labels = names or [str(row + 1) for row in range(n)]
    is_stray, others = strays_of(poles, axes), None
    if is_stray.any():
        is_used = ~is_stray
        azimuths, dips = np.atleast_1d(dip_direction_deg)[is_used], np.atleast_1d(dip_deg)[is_used]
        used_turns = None if turns is None else turns.of(is_used)
        used_flags = None if flags is None else flags[is_used]
        used_labels = [labels[row] for row in np.flatnonzero(is_used).tolist()]
        others = fold_axis(
            azimuths, dips, used_turns, bowed_deg, waviness_deg, used_labels, used_flags
        )
        if others.valid == "no" or others.strays:
            others = None

    def judged(error95_deg: float | None) -> Verdict:
        verdict = verdict_of(shape, error95_deg, uniform, waviness_deg)
        valid = "conditional" if bowed and verdict.valid == "yes" else verdict.valid
        verdict = replace(verdict, valid=valid, reasons=(*bowed, *verdict.reasons))
        if others is not None or left_out is None or semi_axes is None:
            return verdict
        return _on_many(verdict, poles, shape, left_out, semi_axes[0], labels, bowed, waviness_deg)

    result = axis_of(poles, values, axes, semi_axes, axes[1], judged, turned, shape_findings(shape))
    result = replace(result, shape=shape, limbs=_limbs(shape), leave_one_out=left_out)
    if others is None:
        return result
    stray_rows = np.flatnonzero(is_stray).tolist()
    stray_labels = [labels[row] for row in stray_rows]
    return replace(
        result,
        strays=tuple(Stray(row, names[row] if names else None) for row in stray_rows),
        valid="conditional",
        verdict=others.verdict,
        reasons=(_strays_finding(stray_labels, result, others), *others.reasons),
    )


def _semi_axes(values: FloatArray, n: int) -> tuple[float, float] | None:
    """Degrees, of the joint 95 % region of beta by the eigenvalues of the tensor of n poles, the
    larger first; None where they have no redundancy."""
    if n < 3:
        return None
    variance = values[2] * values[:2] / ((n - 2) * (values[:2] - values[2]) ** 2 + 1e-300)
    wider = 1.0 + 1.0 / (n - 2)
    first, second = np.degrees(np.arctan(wider * np.sqrt(variance * 2.0 * f95(n - 2))))
    return float(second), float(first)


def _on_many(
    verdict: Verdict,
    poles: FloatArray,
    shape: Shape,
    leave_one_out: LeaveOneOut,
    most_deg: float,
    names: Sequence[str],
    bowed: Sequence[Finding],
    waviness_deg: float | None,
) -> Verdict:
    """Return the verdict, or "undetermined" if it depends on one plane.

    It does if beta leaves its own 95 % region without that plane, or if the other planes have
    another verdict. Of the two validities the weaker one counts.
    """
    if len(poles) < FEW_PLANES or verdict.name in ("homoclinal", "scattered"):
        return verdict
    turned = leave_one_out.turn_deg > max(most_deg, FELT_DEG)
    row, other = lone_limb(poles), None
    if row is None and verdict.name != "undetermined":
        row, other = _decisive(verdict, poles, shape, leave_one_out.index, waviness_deg)
    if row is None and turned and verdict.name not in ("conical", "two axes"):
        # Where there is no one axis beta may turn.
        row = leave_one_out.index
    if row is None:
        return verdict
    if other is not None and other.untested and verdict.name == "cylindrical":
        finding = cone_untested_finding(names[row], other)
        return replace(verdict, valid="conditional", reasons=(finding, *verdict.reasons))
    turn = leave_one_out.turn_deg if turned and row == leave_one_out.index else None
    finding = lone_plane_finding(names[row], turn, most_deg, other)
    if verdict.name == "undetermined":
        return replace(verdict, reasons=(finding, *verdict.reasons))
    # What spoke for the shape does so no more.
    return Verdict("undetermined", "conditional", (finding, *bowed))


def _decisive(
    verdict: Verdict, poles: FloatArray, shape: Shape, turns_most: int, waviness_deg: float | None
) -> tuple[int | None, Verdict | None]:
    """Find the plane without which the others have another verdict.

    Only planes that can have this effect are tested: the ends of the arc, the one farthest from
    the great circle, and the one that turns beta most.

    Returns
    -------
    row : int or None
    verdict : Verdict or None
        Verdict of the other planes.
    """
    far = int(np.argmax(np.abs(poles @ shape.axes[2])))
    for row in dict.fromkeys((*arc_ends(poles, shape.axes), turns_most, far)):
        # Two axes of the others would be no doubt of any other verdict.
        two = verdict.name == "two axes"
        other = _verdict_without(poles, row, waviness_deg, two=two)
        # The best of several cones through all planes but one is often better by chance alone.
        is_cone_artifact = verdict.name == "cylindrical" and other.name == "conical"
        is_alike = other.name == verdict.name or verdict.valid == other.valid == "no"
        if not is_alike and not is_cone_artifact:
            return row, other
    return None, None


def _verdict_without(
    poles: FloatArray, row: int, waviness_deg: float | None, *, two: bool
) -> Verdict:
    """Of all planes but one, as if they were as many: errors that are larger and an arc that is
    shorter only since there is one plane fewer say nothing of that plane."""
    n, others = len(poles), np.delete(poles, row, axis=0)
    values, axes = orientation_tensor(others)
    shape = shape_of(others, values, axes)
    semi_axes = _semi_axes(values, n)
    error = None if semi_axes is None else semi_axes[0]
    cone = None if shape.cone is None else shape.cone.of_more(n - 1, n)
    as_many = replace(shape, cone=cone, arc_deg=shape.arc_deg * (n - 1) / (n - 2))
    uniform = uniformity(others, False).p
    return verdict_of(as_many, error, uniform, waviness_deg, FEW_PLANES - 1, two=two)


def axis_of(
    poles: FloatArray,
    values: FloatArray,
    axes: FloatArray,
    semi_axes: tuple[float, float] | None,
    swing: FloatArray,
    judged: Callable[[float | None], Verdict],
    turned: Moved | None,
    counted: Sequence[Finding],
) -> FoldAxis:
    """Return beta of poles, or of the means of sets, with its errors and its verdict.

    Parameters
    ----------
    poles : (n, 3) array
    values, axes : (3,) and (3, 3) arrays
        Eigenvalues and eigenvectors of their orientation tensor.
    semi_axes : (float, float) or None
        Of the joint 95 % region of beta, degrees, the larger one first.
    swing : (3,) array
        Direction of the larger semi-axis.
    judged : callable
        Returns the verdict for a 95 % error of beta, degrees.
    turned : Moved or None
        Effect of the registrations on beta.
    counted : sequence of Finding
        Listed after the reasons of the verdict.
    """
    beta = Line.from_vector(axes[2])
    pi_plane = beta.normal_plane()
    covariance = None if turned is None else turned.covariance()[0]
    total = None if semi_axes is None else region(axes[2], covariance, (*semi_axes, swing))
    registration, registration_findings = None, list[Finding]()
    if covariance is not None:
        registration = region(axes[2], covariance).largest_deg
        registration_findings = [_registered(registration, total)]
    direction = None if semi_axes is None else Line.from_vector(swing)
    verdict = judged(None if total is None else total.largest_deg)
    off = np.degrees(np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0)))
    known = [] if semi_axes is None else [error_finding(semi_axes)]
    return FoldAxis(
        n=len(poles),
        beta=beta,
        pi_plane=pi_plane,
        eigenvalues=(float(values[0]), float(values[1]), float(values[2])),
        rms_deg=rms(off),
        arc_deg=arc_deg(poles, axes),
        max_confidence95_deg=None if semi_axes is None else semi_axes[0],
        min_confidence95_deg=None if semi_axes is None else semi_axes[1],
        confidence_direction_deg=None if direction is None else rake_of(direction, pi_plane),
        confidence_axis=direction,
        valid=verdict.valid,
        verdict=verdict.name,
        reasons=(*verdict.reasons, *counted, *known, *registration_findings),
        registration_error_deg=registration,
        total=total,
    )


def plane_figures(plane: Plane) -> PlaneFigures:
    """Return the angles of a plane as plain numbers."""
    return PlaneFigures(plane.dip_direction_deg, plane.dip_deg, plane.strike_rhr_deg)


def _cone_figures(shape: Shape) -> ConeFigures | None:
    cone = shape.cone
    if cone is None:
        return None
    width = cone.half_width_deg if math.isfinite(cone.half_width_deg) else None
    line, nearer, by_nearer_ends = cone.axis, cone.by_nearer_ends, None
    if nearer is not None:
        by_nearer_ends = SmallCircleFigures(
            nearer.axis.trend_deg, nearer.axis.plunge_deg, nearer.half_angle_deg, nearer.rms_deg
        )
    return ConeFigures(
        line.trend_deg,
        line.plunge_deg,
        cone.half_angle_deg,
        width,
        cone.rms_deg,
        cone.p,
        by_nearer_ends,
    )


def _limbs(shape: Shape) -> LimbFigures | None:
    """The fold opens downward, or upward, but lies on neither limb. None where the poles do not
    tell the limbs."""
    if shape.limbs is None or shape.limbs.doubt:
        return None
    limbs = shape.limbs
    first, second = limbs.up
    apart = math.degrees(
        math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second))
    )
    planes = tuple(plane_figures(Plane.from_normal(pole)) for pole in (first, second))
    axial = Plane.from_normal(first - second)
    angle_error, axial_error = limbs.errors95_deg(shape.axes[2])
    return LimbFigures(
        (planes[0], planes[1]),
        limbs.counts,
        180.0 - apart,
        plane_figures(axial),
        angle_error,
        axial_error,
        limbs.overturned,
    )


def _leave_one_out(poles: FloatArray, beta: FloatArray) -> LeaveOneOut | None:
    """Which of the poles turns beta most."""
    total = poles.T @ poles
    without = total - poles[:, :, None] * poles[:, None, :]
    others = np.linalg.eigh(without)[1][:, :, 0]
    turn = np.degrees(np.arccos(np.minimum(np.abs(others @ beta), 1.0)))
    worst = int(np.argmax(turn))
    line = Line.from_vector(others[worst])
    return LeaveOneOut(worst, None, float(turn[worst]), line.trend_deg, line.plunge_deg)


def _strays_finding(planes: Sequence[str], axis: FoldAxis, others: FoldAxis) -> Finding:
    """Report the outlying planes, which the verdict does not include."""
    return Finding(
        "fold.strays",
        count=len(planes),
        n=axis.n,
        planes=planes,
        trend_deg=others.beta.trend_deg,
        plunge_deg=others.beta.plunge_deg,
        turn_deg=angle_between_lines(axis.beta, others.beta),
    )


def _registered(registration_deg: float, total: Region | None) -> Finding:
    """Report the error of beta by the registration, which all planes of a model share."""
    if total is None:
        return Finding("fold.registration-alone", error_deg=registration_deg)
    weak = total.largest_deg > WEAK_AXIS_DEG
    return Finding(
        "fold.registration-weak" if weak else "fold.registration",
        error_deg=registration_deg,
        major_deg=total.largest_deg,
        minor_deg=total.smallest_deg,
        limit_deg=WEAK_AXIS_DEG,
    )
