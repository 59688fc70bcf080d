"""Fold axes and common axes: the pi-plane, beta, how well beta is known, what may be done with it.

Beta is the eigenvector of S3 of the poles' orientation tensor, the pole of the best plane through
them (textbook 4.2, fig. 31). Its confidence region is the asymptotic one of a principal axis,
variance S3 Sj / (n (Sj - S3)^2) toward axis j (Anderson 1963, Annals of Mathematical Statistics
34, 122-148; Fisher, Lewis & Embleton 1987, Statistical analysis of spherical data, ch. 6), with n
replaced by n - 2 in S3 and F(0.95; 2, n - 2) in place of chi-square, as in the regression that it
becomes where the scatter about the great circle is small. It is joint (both tilts at once), 95 %,
and supposes that each pole strays from the great circle on its own and by the same law.
Simulated coverage (arcs of 40 to 180 degrees, 5 to 100 planes) is 93 to 97 % where the larger
semi-axis is under 20 degrees; it falls to 85 % where it is over 30, and from `WEAK_AXIS_DEG` on the
result says that the axis is weak. What the registration of the models adds to it is common to their
planes and does not shrink with their number (common_turns).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.common_turns import (
    Moved,
    Region,
    Turns,
    joined,
    moved,
    principal_axis,
    region,
)
from vomstudio.geology.distributions import LineFigures, f95
from vomstudio.geology.orientation import (
    Array,
    Line,
    Plane,
    planes_to_poles,
    rake_of,
)
from vomstudio.geology.statistics import (
    flip_to,
    orientation_tensor,
    unit_vectors,
)
from vomstudio.words import to_translate, tr

MIN_ARC = 1e-10
"""S2 below this: the planes are parallel (to 1e-5 rad); any line in them would do."""

WEAK_AXIS_DEG = 20.0
"""A semi-axis over this: beta is not known well enough to project anything along it, and its
region, which is drawn for small angles, is too narrow."""

FEW_PLANES = 10
"""Under this many planes neither the scatter nor its shape can be told (an axis can)."""

SHORT_ARC_DEG = 30.0
"""Poles within an arc shorter than this say little of the great circle they lie on."""

JUDGING_LATER = to_translate(
    "whether the poles fit one axis (cylindrical), a cone, one dip or two axes "
    "was not tested: judge by the net"
)


@dataclass(frozen=True)
class BetaFigures:
    """A fold axis with the semi-axes of its joint 95 % region, degrees; as in `FoldAxis`. total95:
    with the registration."""

    trend_deg: float
    plunge_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    confidence_direction_deg: float | None
    confidence_axis: LineFigures | None
    registration_error_deg: float | None
    total95_deg: float | None
    total95_min_deg: float | None
    total95_axis: LineFigures | None


@dataclass(frozen=True)
class PlaneFigures:
    """A plane by dip direction and dip, and by its right-hand-rule strike, degrees."""

    dip_direction_deg: float
    dip_deg: float
    strike_rhr_deg: float


@dataclass(frozen=True)
class AxisFigures:
    """What is said of a fold axis, as in `FoldAxis`."""

    beta: BetaFigures
    pi_plane: PlaneFigures
    eigenvalues: tuple[float, float, float]
    rms_deg: float
    arc_deg: float
    valid: str
    verdict: str
    reasons: tuple[str, ...]


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
    valid: "yes", "conditional" or "no"; verdict: its name; reasons: sentences with numbers.
    registration_error_deg: larger half-angle of the 95 % region by which the registrations of the
    planes' models can turn beta, None where none is known. total: the joint 95 % region with it,
    None where that of the planes is not known.
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
    reasons: tuple[str, ...]
    registration_error_deg: float | None = None
    total: Region | None = None

    @property
    def error95_deg(self) -> float | None:
        """The larger half-angle of all that is known of beta's error."""
        return self.max_confidence95_deg if self.total is None else self.total.largest_deg

    @property
    def figures(self) -> AxisFigures:
        """What is said of it, as plain numbers and words."""
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
            PlaneFigures(
                self.pi_plane.dip_direction_deg, self.pi_plane.dip_deg, self.pi_plane.strike_rhr_deg
            ),
            self.eigenvalues,
            self.rms_deg,
            self.arc_deg,
            self.valid,
            self.verdict,
            self.reasons,
        )

    def as_dict(self) -> dict[str, Any]:
        """The same, ready for JSON."""
        return asdict(self.figures)


def _line_figures(line: Line | None) -> LineFigures | None:
    return None if line is None else LineFigures(line.trend_deg, line.plunge_deg)


def fold_axis(
    dip_direction_deg: npt.ArrayLike,
    dip_deg: npt.ArrayLike,
    turns: Turns | None = None,
    bowed_deg: float | None = None,
) -> FoldAxis:
    """Pi-plane and beta of n >= 2 planes of one kind (arrays (n,), degrees).

    turns : what is known of their registrations, (n,)
    bowed_deg : by how much dips differ from edge to edge of a model of theirs that is bowed
    Raises GeometryError for fewer than two planes or planes that are all parallel.
    """
    poles = planes_to_poles(dip_direction_deg, dip_deg).reshape(-1, 3)
    n = len(poles)
    if n < 2:
        raise GeometryError(tr("A fold axis needs at least 2 planes; {n} given.", n=n))
    poles = unit_vectors(poles)
    values, axes = orientation_tensor(poles)
    if values[1] < MIN_ARC:
        raise GeometryError(
            tr(
                "All {n} planes are parallel: they define no fold axis. Any direction in the "
                "plane shows true thickness; choose one.",
                n=n,
            )
        )
    semi_axes: tuple[float, float] | None = None
    if n > 2:
        variance = values[2] * values[:2] / ((n - 2) * (values[:2] - values[2]) ** 2 + 1e-300)
        first, second = np.degrees(np.arctan(np.sqrt(variance * 2.0 * f95(n - 2))))
        semi_axes = float(second), float(first)
    given = None if turns is None or not turns.known else moved(poles, turns)
    turned = None if given is None else principal_axis(given, values, axes, 2)
    reasons = [*_bowed(bowed_deg, _arc_deg(poles, axes)), *_fold_reasons(poles, axes, n, semi_axes)]
    return _axis(poles, values, axes, semi_axes, axes[1], reasons, turned)


def common_axis(
    sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    turns: Mapping[str, Turns] | None = None,
) -> FoldAxis:
    """The axis common to several sets of planes (hanging wall, footwall, fault ...): the pole of
    the best plane through the means of their poles, each set counting once however many planes it
    has; with two sets the intersection of their mean planes (textbook 4.2, fig. 31a, b).

    sets: name -> (dip directions, dips) in degrees. turns: what is known of their registrations, by
    the same names and of the same rotations. The confidence carries the scatter of each
    set's mean along the axis, as F with the smallest set's degrees of freedom; it is None where a
    set has a single plane, whose scatter is unknown. Raises GeometryError for fewer than two sets,
    an empty one, or parallel means.
    """
    if len(sets) < 2:
        raise GeometryError(tr("A common axis needs at least 2 sets; name them as A,B."))
    names = list(sets)
    members: list[Array] = []
    for name in names:
        poles = planes_to_poles(*sets[name]).reshape(-1, 3)
        if len(poles) == 0:
            raise GeometryError(tr("Set {name} has no planes.", name=name))
        members.append(unit_vectors(poles))
    tensors = [orientation_tensor(poles) for poles in members]
    means = np.array([of_set[0] for _, of_set in tensors])
    values, axes = orientation_tensor(means)
    if values[1] < MIN_ARC:
        raise GeometryError(
            tr(
                "The mean planes of {names} are parallel: they have no common axis.",
                names=", ".join(names),
            )
        )
    beta = axes[2]
    semi_axes: tuple[float, float] | None = None
    swing = axes[1]
    smallest = min(len(poles) for poles in members)
    if smallest > 1:
        # A mean that strays by e along beta turns beta by t with A t = sum m e, A = sum m m^T in
        # the plane of the means (linearised); e has the variance of the mean of its set.
        across = axes[:2]
        flat = means @ across.T
        strays = np.array(
            [
                float(np.sum((flip_to(poles, mean) @ beta - mean @ beta) ** 2))
                / ((len(poles) - 1) * len(poles))
                for poles, mean in zip(members, means, strict=True)
            ]
        )
        inverse = np.linalg.inv(flat.T @ flat)
        covariance = inverse @ (flat.T * strays) @ flat @ inverse
        spread, directions = np.linalg.eigh(covariance)
        angles = np.degrees(np.arctan(np.sqrt(np.maximum(spread, 0.0) * 2.0 * f95(smallest - 1))))
        semi_axes = float(angles[1]), float(angles[0])
        swing = directions[:, 1] @ across
    reasons = [
        tr(
            "means of {sets}",
            sets=", ".join(f"{k} (n = {len(m)})" for k, m in zip(names, members, strict=True)),
        )
    ]
    if len(names) > 2:
        off = np.degrees(np.abs(np.arcsin(np.clip(means @ beta, -1.0, 1.0))))
        reasons.append(
            tr(
                "distance of the means from one plane: {distances} degrees",
                distances=", ".join(f"{k} {a:.1f}" for k, a in zip(names, off, strict=True)),
            )
        )
    if semi_axes is None:
        reasons.append(tr("a set has only one plane: the error of the axis is unknown"))
    else:
        reasons.extend(_weakness(semi_axes))
    reasons.append(tr("whether the sets share one axis within their errors was not tested"))
    turned = None
    if turns is not None and any(turns[name].known for name in names):
        own = [moved(poles, turns[name]) for name, poles in zip(names, members, strict=True)]
        turned = _turned_axis(own, tensors, values, axes)
    return _axis(means, values, axes, semi_axes, swing, reasons, turned)


def _turned_axis(
    members: Sequence[Moved], tensors: Sequence[tuple[Array, Array]], values: Array, axes: Array
) -> Moved:
    """The axis common to sets as the registrations of their planes move it."""
    parts = [principal_axis(own, *of, 0) for own, of in zip(members, tensors, strict=True)]
    return principal_axis(joined(parts), values, axes, 2)


def _axis(
    poles: Array,
    values: Array,
    axes: Array,
    semi_axes: tuple[float, float] | None,
    swing: Array,
    reasons: list[str],
    turned: Moved | None,
) -> FoldAxis:
    beta = Line.from_vector(axes[2])
    pi_plane = beta.normal_plane()
    covariance = None if turned is None else turned.covariance()[0]
    total = None if semi_axes is None else region(axes[2], covariance, (*semi_axes, swing))
    registration = None
    if covariance is not None:
        registration = region(axes[2], covariance).largest_deg
        reasons = [*reasons, _registered(registration, total)]
    direction = None if semi_axes is None else Line.from_vector(swing)
    return FoldAxis(
        n=len(poles),
        beta=beta,
        pi_plane=pi_plane,
        eigenvalues=(float(values[0]), float(values[1]), float(values[2])),
        rms_deg=_rms_deg(poles, axes),
        arc_deg=_arc_deg(poles, axes),
        max_confidence95_deg=None if semi_axes is None else semi_axes[0],
        min_confidence95_deg=None if semi_axes is None else semi_axes[1],
        confidence_direction_deg=None if direction is None else rake_of(direction, pi_plane),
        confidence_axis=direction,
        # The one place that gives a verdict: its tests (cylindrical, conical, homoclinal, two
        # axes, scattered) will read the same poles and semi-axes.
        valid="conditional",
        verdict="undetermined",
        reasons=tuple(reasons),
        registration_error_deg=registration,
        total=total,
    )


def _bowed(bowed_deg: float | None, arc_deg: float) -> list[str]:
    """A dome looks like an open fold: limbs that differ by no more prove none."""
    if bowed_deg is None or arc_deg >= bowed_deg:
        return []
    return [
        tr(
            "the model is bowed: dips differ by {bowed:.1f} degrees from edge to edge of it, and "
            "these poles by {arc:.1f} degrees only: the fold may be the bowing",
            bowed=bowed_deg,
            arc=arc_deg,
        )
    ]


def _registered(registration: float, total: Region | None) -> str:
    """What the registration adds, which is the same for all planes of a model."""
    if total is None:
        return tr(
            "the registration can turn beta by {error:.1f} degrees (95 %)", error=registration
        )
    said = tr(
        "with the registration, which can turn beta by {error:.1f} degrees however many planes "
        "there are, it is known to {major:.1f} by {minor:.1f} degrees (joint 95 %)",
        error=registration,
        major=total.largest_deg,
        minor=total.smallest_deg,
    )
    if total.largest_deg > WEAK_AXIS_DEG:
        return tr("{text}: over {limit:.0f}, too weak to rely on", text=said, limit=WEAK_AXIS_DEG)
    return said


def _fold_reasons(
    poles: Array, axes: Array, n: int, semi_axes: tuple[float, float] | None
) -> list[str]:
    reasons = [
        tr(
            "n = {n}, poles {rms_deg:.1f} degrees RMS from the great circle, along "
            "{arc_deg:.0f} degrees of it",
            n=n,
            rms_deg=_rms_deg(poles, axes),
            arc_deg=_arc_deg(poles, axes),
        )
    ]
    if semi_axes is None:
        reasons.append(tr("two planes always meet in a line: its error is unknown"))
    else:
        reasons.extend(_weakness(semi_axes))
    if 2 < n < FEW_PLANES:
        reasons.append(tr("only {n} planes: the shape of the scatter cannot be told", n=n))
    if _arc_deg(poles, axes) < SHORT_ARC_DEG:
        reasons.append(
            tr("the poles cover less than {limit:.0f} degrees: nearly one dip", limit=SHORT_ARC_DEG)
        )
    reasons.append(tr(JUDGING_LATER))
    return reasons


def _weakness(semi_axes: tuple[float, float]) -> list[str]:
    major, minor = semi_axes
    text = tr(
        "beta is known to {major:.1f} by {minor:.1f} degrees (joint 95 %)", major=major, minor=minor
    )
    if major > WEAK_AXIS_DEG:
        return [tr("{text}: over {limit:.0f}, too weak to rely on", text=text, limit=WEAK_AXIS_DEG)]
    cost = 100.0 * (1.0 - math.cos(math.radians(major)))
    shift = 100.0 * math.sin(math.radians(major))
    return [
        tr(
            "{text}: a direction wrong by {major:.1f} shortens lengths by {cost:.1f} % "
            "and displaces by {shift:.0f} % of the depth of the view",
            text=text,
            major=major,
            cost=cost,
            shift=shift,
        )
    ]


def _rms_deg(poles: Array, axes: Array) -> float:
    off = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    return math.degrees(math.sqrt(float(np.mean(off**2))))


def _arc_deg(poles: Array, axes: Array) -> float:
    """Half a turn less the widest gap between neighbours, axially."""
    along = np.sort(np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0)
    gaps = np.diff(np.append(along, along[0] + 180.0))
    return float(180.0 - gaps.max())
