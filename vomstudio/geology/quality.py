"""Whether a fitted plane is worth keeping: good, doubtful or poor, with the reasons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.geometry.lines import LineFit
from vomstudio.geometry.plane_sizes import POINT_OVER_RESOLUTION, PlaneSizes, within_wander
from vomstudio.geometry.plane_sizes import resolution_tilt_deg as tilt_of_resolution_deg
from vomstudio.geometry.planes import PlaneFit
from vomstudio.geometry.rotation_errors import CHI2_TWO

Quality = Literal["good", "doubtful", "poor"]
Kind = Literal["trace", "patch"]


@dataclass(frozen=True)
class Verdict:
    """How far a plane or line can be trusted, and why.

    Parameters
    ----------
    quality : {"good", "doubtful", "poor"}
    reasons : tuple of Finding
        What kept it from being good, and what to do about it.
    notes : tuple of Finding
        Shape and extent beside their recommended values, and questions to the geologist.
    limits : Thresholds
        By which it was given.
    """

    quality: Quality
    reasons: tuple[Finding, ...]
    notes: tuple[Finding, ...] = ()
    limits: Thresholds = DEFAULTS

    @property
    def profile(self) -> str:
        """The name of the limits."""
        return self.limits.profile


# Ours: the plane of a trace that is this close to the face may be the face: a plane whose error is
# larger is poor for that alone.
_IN_THE_FACE_DEG = DEFAULTS.poor_confidence95_deg
# Ours: a trace with less relief than this out of the face is a drawing on the face.
_RELIEF_OVER_RESOLUTION = 3.0
_RELIEF_OVER_EXTENT = 0.02
# Ours, by tests/benchmarks/bench_conditional.py.
_FEWEST_GOOD = 6.0


def confidence_that_counts_deg(fit: PlaneFit, kind: Kind = "trace") -> float | None:
    """Return the half-angle by which a plane is judged; None where undefined.

    The wider of confidence and hyperbolic error where the roughness is as long as the trace, and
    for a patch: its points are close neighbours on one rough surface, so a confidence that counts
    every one of them as independent shrinks with the resolution of the model, not with knowledge.
    What a bow of the trace can tilt that its points do not show comes on top.
    """
    confidence, hyperbolic = fit.max_confidence95_deg, fit.max_angular_error_deg
    if hyperbolic is not None and (fit.long_roughness or kind == "patch"):
        confidence = hyperbolic if confidence is None else max(confidence, hyperbolic)
    if confidence is None or not fit.bow_tilt_deg:
        return confidence
    return min(math.hypot(confidence, fit.bow_tilt_deg), 90.0)


def wider_of(
    fit: PlaneFit,
    kind: Kind = "trace",
    resolution_m: float | None = None,
    outcrop_normal: npt.ArrayLike | None = None,
    stretch_error_deg: float | None = None,
) -> tuple[float | None, float | None]:
    """Return the largest and smallest half-angle of the figure by which a plane is judged (see
    `confidence_that_counts_deg`), for what follows from the plane. Doubtful stretches may turn it
    in any direction."""
    counts, smallest = confidence_that_counts_deg(fit, kind), fit.min_confidence95_deg
    if counts is None or smallest is None or fit.max_confidence95_deg is None:
        return None, None
    widened = fit.long_roughness or kind == "patch"
    if widened and counts > fit.max_confidence95_deg and fit.min_angular_error_deg is not None:
        smallest = max(smallest, fit.min_angular_error_deg)
    turned = is_within_wander(fit, kind, resolution_m, outcrop_normal)
    stretch = stretch_error_deg or 0.0
    return max(90.0 if turned else counts, stretch), max(smallest, stretch)


def is_within_wander(
    fit: PlaneFit,
    kind: Kind,
    resolution_m: float | None,
    outcrop_normal: npt.ArrayLike | None,
) -> bool:
    """Return whether a trace lies in the outcrop's face and is no wider there than points stray
    along it, so that any plane through the line is possible.

    How far points stray out of the face their residuals show, and the fit's error has it. How far
    they stray along the face no residual shows where the plane is that face.
    """
    spacing = resolution_m or 0.0
    if kind != "trace" or not spacing > 0.0 or fit.trace is None or fit.extent is None:
        return False
    if outcrop_normal is None:
        return False
    angle = _axial_angle_deg(fit.normal, np.asarray(outcrop_normal, dtype=np.float64))
    if angle is None or angle > _IN_THE_FACE_DEG:
        return False
    return within_wander(fit.trace * float(fit.eigenvalues[1]), fit.extent, fit.n, spacing)


def feature_extent_m(fit: PlaneFit, kind: Kind = "trace") -> float | None:
    """Length of a trace; of a patch the diameter of the disc with the same spread of points."""
    if kind == "trace" or fit.trace is None:
        return fit.extent
    l1, l2, _ = fit.eigenvalues
    # A uniform disc of radius R has a variance of R^2 / 4 along each diameter.
    return float(4.0 * np.sqrt(fit.trace * np.sqrt(l1 * l2)))


def resolution_tilt_deg(
    fit: PlaneFit, resolution_m: float | None, kind: Kind = "trace"
) -> float | None:
    """Return by how much the model's resolution can tilt a plane, degrees; None where unknown.

    Of a patch half of the resolution over its shorter axis. The points of a trace are known no
    better than to a tenth of the resolution each, one sigma, whatever their residuals say: what
    that tilts the plane of independent points, 95 %, but no more than half of the resolution over
    the shorter axis.
    """
    if resolution_m is None or not resolution_m > 0.0 or fit.trace is None:
        return None
    # The variance of a strip of width w is w^2 / 12 across it.
    shorter = math.sqrt(12.0 * max(fit.trace * float(fit.eigenvalues[1]), 0.0))
    most = tilt_of_resolution_deg(resolution_m, shorter)
    if kind == "patch":
        return most
    return min(most, _tilt_of_points_deg(fit, POINT_OVER_RESOLUTION * resolution_m))


def _tilt_of_points_deg(fit: PlaneFit, sigma_m: float) -> float:
    """Return the 95 % half-angle, degrees, by which independent errors of the points tilt a plane
    about its longer axis."""
    independent = float(fit.n if fit.n_effective is None else fit.n_effective)
    width = math.sqrt(independent * max((fit.trace or 0.0) * float(fit.eigenvalues[1]), 0.0))
    return math.degrees(math.atan2(math.sqrt(CHI2_TWO) * sigma_m, width))


def is_from_too_few(fit: PlaneFit, resolution_m: float | None, good_deg: float) -> bool:
    """Return whether a plane is from fewer than 6 independent points and nothing else bounds the
    roughness: their own misfit is small by chance too often.

    The model's resolution bounds it where errors of the points of half of it still give a good
    plane.
    """
    if fit.n <= 3 or (fit.n if fit.n_effective is None else fit.n_effective) >= _FEWEST_GOOD:
        return False
    return not resolution_m or _tilt_of_points_deg(fit, 0.5 * resolution_m) > good_deg


def total_error_deg(
    fit: PlaneFit,
    resolution_m: float | None,
    kind: Kind = "trace",
    registration_deg: float | None = None,
    outcrop_normal: npt.ArrayLike | None = None,
    stretch_error_deg: float | None = None,
) -> float | None:
    """Return the half-angle by which the verdict is decided, 95 %; None where the fit's is
    undefined.

    That of the fit (see `confidence_that_counts_deg`), no less than what the resolution can tilt or
    what doubtful stretches leave (geology/doubtful_stretches.py), together with what the model's
    registration can.
    """
    angle = confidence_that_counts_deg(fit, kind)
    if angle is None or is_within_wander(fit, kind, resolution_m, outcrop_normal):
        return None if angle is None else 90.0
    own = max(angle, resolution_tilt_deg(fit, resolution_m, kind) or 0.0, stretch_error_deg or 0.0)
    return min(float(np.hypot(own, registration_deg or 0.0)), 90.0) if registration_deg else own


def judge(
    fit: PlaneFit,
    *,
    resolution_m: float | None,
    outcrop_normal: npt.ArrayLike | None,
    kind: Kind = "trace",
    thresholds: Thresholds = DEFAULTS,
    registration_deg: float | None = None,
    seen: Sequence[Finding] = (),
    stretch_error_deg: float | None = None,
    bend_deg: float | None = None,
) -> Verdict:
    """The verdict on a plane. By error, it is decided by how far the plane may be off, and by what
    that figure cannot know; shape and extent are notes. By shape, it is good where all three limits
    of the textbook are met, doubtful where one is missed, poor where more are; the error is a note.

    resolution_m : effective resolution of the model around the pick; None: unknown, no rule
    outcrop_normal : (3,) normal of the outcrop's face on a scale larger than the trace, either
        sense; None: unknown
    kind : a patch is the outcrop face, so the surface effect is looked for in traces only
    registration_deg : 95 % half-angle by which the model's registration can tilt the plane
    seen : what the surface or the way of a trace says against its plane
        (geometry/heights/levels.py, geology/doubtful_stretches.py)
    stretch_error_deg : 95 % half-angle of the plane in view of doubtful stretches
    bend_deg : by which a face bends as a whole, see `geometry.heights.bends`
    """
    if fit.error is not None:
        return Verdict("poor", (fit.error,), limits=thresholds)
    drawn, question = _of_face(fit, kind, outcrop_normal, resolution_m, thresholds)
    decided = _by_shape if thresholds.by == "shape" else _by_error
    poor, reasons, notes = decided(
        fit, kind, resolution_m, thresholds, registration_deg, outcrop_normal, stretch_error_deg
    )
    reasons += [*drawn, *seen]
    quality: Quality = "poor" if poor else "doubtful" if reasons else "good"
    total = total_error_deg(fit, resolution_m, kind, registration_deg)
    if is_local(fit, bend_deg, total) and bend_deg is not None and total is not None:
        regional_deg = min(math.hypot(total, bend_deg), 90.0)
        notes.append(Finding("plane.local", bend_deg=bend_deg, regional_deg=regional_deg))
    return Verdict(quality, tuple(reasons), tuple(notes + question), thresholds)


def is_local(fit: PlaneFit, bend_deg: float | None, total_deg: float | None) -> bool:
    """Return whether a plane is the attitude of this place alone: its roughness is as long as the
    trace, or its face bends as a whole by more than the plane's error."""
    bends = bend_deg is not None and total_deg is not None and bend_deg > total_deg
    return bends or fit.long_roughness


def _by_error(
    fit: PlaneFit,
    kind: Kind,
    resolution_m: float | None,
    thresholds: Thresholds,
    registration_deg: float | None,
    face: npt.ArrayLike | None,
    stretch_error_deg: float | None,
) -> tuple[bool, list[Finding], list[Finding]]:
    """Whether it is poor, reasons and notes."""
    poor, reasons = _of_direction(
        fit, kind, resolution_m, thresholds, registration_deg, face, stretch_error_deg
    )
    if fit.long_roughness:
        reasons.append(Finding("plane.long-roughness"))
    notes = _of_shape(fit, kind, thresholds)
    extent = feature_extent_m(fit, kind)
    if resolution_m is not None and resolution_m > 0.0 and extent is not None:
        ratio = extent / resolution_m
        if ratio < thresholds.least_extent_over_resolution:
            minimum = thresholds.least_extent_over_resolution
            reasons.append(Finding("plane.too-small", ratio=ratio, minimum=minimum))
        elif ratio < thresholds.extent_over_resolution:
            notes.append(
                Finding(
                    "plane.small",
                    # Rounded down: never the recommended figure itself.
                    ratio=math.floor(10.0 * ratio) / 10.0 if ratio < 10.0 else math.floor(ratio),
                    recommended=thresholds.extent_over_resolution,
                    error_deg=PlaneSizes.of_model(resolution_m).error_deg(extent) or 90.0,
                )
            )
    return poor, reasons, notes


def _by_shape(
    fit: PlaneFit,
    kind: Kind,
    resolution_m: float | None,
    t: Thresholds,
    registration_deg: float | None,
    face: npt.ArrayLike | None,
    stretch_error_deg: float | None,
) -> tuple[bool, list[Finding], list[Finding]]:
    """Whether it is poor, reasons and notes."""
    missed, notes = list[Finding](), list[Finding]()
    # None is infinite: points exactly in one plane, or along one line.
    if fit.coplanarity is not None and fit.coplanarity < t.least_coplanarity:
        missed.append(
            Finding("plane.not-coplanar", coplanarity=fit.coplanarity, minimum=t.least_coplanarity)
        )
    if fit.collinearity is None or fit.collinearity > t.most_collinearity:
        missed.append(
            Finding(
                "plane.collinear",
                collinearity=_or_infinite(fit.collinearity),
                maximum=t.most_collinearity,
            )
        )
    extent = feature_extent_m(fit, kind)
    if extent is None or resolution_m is None or not resolution_m > 0.0:
        notes.append(Finding("plane.unknown-resolution"))
    elif extent < t.extent_over_resolution * resolution_m:
        ratio = extent / resolution_m
        missed.append(Finding("plane.too-small", ratio=ratio, minimum=t.extent_over_resolution))
    poor = len(missed) > 1
    _, of_error = _of_direction(
        fit, kind, resolution_m, t, registration_deg, face, stretch_error_deg
    )
    if confidence_that_counts_deg(fit, kind) is None:
        # Without redundancy, or with points that are the same, no shape speaks for a plane.
        return poor, missed + of_error, notes
    return poor, missed, notes + of_error


def _of_face(
    fit: PlaneFit,
    kind: Kind,
    outcrop_normal: npt.ArrayLike | None,
    resolution_m: float | None,
    t: Thresholds,
) -> tuple[list[Finding], list[Finding]]:
    """A reason against a trace that is a drawing on the outcrop's face, and the question whether
    the face that it follows is the structure."""
    if kind != "trace" or outcrop_normal is None:
        return [], []
    face = np.asarray(outcrop_normal, dtype=np.float64)
    angle = _axial_angle_deg(fit.normal, face)
    if angle is None or angle >= t.surface_effect_deg or fit.trace is None or fit.extent is None:
        return [], []
    unit = face / np.linalg.norm(face)
    variance = float(np.sum(fit.eigenvalues * (fit.axes @ unit) ** 2)) * fit.trace
    relief = 4.0 * float(np.sqrt(max(variance, 0.0)))
    least = max(_RELIEF_OVER_RESOLUTION * (resolution_m or 0.0), _RELIEF_OVER_EXTENT * fit.extent)
    if relief < least:
        return [Finding("plane.in-face", angle_deg=angle)], []
    return [], [Finding("plane.along-face", angle_deg=angle)]


def _of_direction(
    fit: PlaneFit,
    kind: Kind,
    resolution_m: float | None,
    t: Thresholds,
    registration_deg: float | None,
    face: npt.ArrayLike | None,
    stretch_error_deg: float | None,
) -> tuple[bool, list[Finding]]:
    """Whether the plane is poor for its error, and the reasons."""
    angle = total_error_deg(fit, resolution_m, kind, registration_deg, face, stretch_error_deg)
    if angle is None and fit.n <= 3:
        return False, [Finding("plane.three-points")]
    if angle is None:
        return True, [Finding("plane.three-distinct-points", n=fit.n)]
    if angle <= t.good_confidence95_deg:
        if not is_from_too_few(fit, resolution_m, t.good_confidence95_deg):
            return False, []
        return False, [Finding("plane.too-few-points", minimum=int(_FEWEST_GOOD))]
    poor = angle > t.poor_confidence95_deg
    limit_deg = t.poor_confidence95_deg if poor else t.good_confidence95_deg
    own = angle
    if registration_deg is not None:
        own = total_error_deg(fit, resolution_m, kind, None, face, stretch_error_deg) or 0.0
    if registration_deg is not None and registration_deg > own:
        return poor, [
            Finding("plane.registration", error_deg=registration_deg, limit_deg=limit_deg)
        ]
    if is_within_wander(fit, kind, resolution_m, face):
        return poor, [Finding("plane.too-straight", error_deg=angle, limit_deg=limit_deg)]
    if stretch_error_deg is not None and own <= stretch_error_deg:
        # The stretches themselves are a reason.
        return poor, []
    if own > (confidence_that_counts_deg(fit, kind) or 0.0):
        return poor, [Finding("plane.resolution", error_deg=angle, limit_deg=limit_deg)]
    if kind == "patch":
        code = "plane.uncertain-patch"
    else:
        code = "plane.too-straight" if _is_straight(fit, t) else "plane.uncertain"
    return poor, [Finding(code, error_deg=angle, limit_deg=limit_deg)]


def _is_straight(fit: PlaneFit, t: Thresholds) -> bool:
    return fit.K is None or t.good_K <= fit.K


def _of_shape(fit: PlaneFit, kind: Kind, t: Thresholds) -> list[Finding]:
    """Compare the scatter of the points with the recommended figures."""
    notes = list[Finding]()
    # None is infinite: points exactly in one plane.
    if fit.M is not None and t.good_M >= fit.M:
        notes.append(
            Finding(
                "plane.scattered",
                M=fit.M,
                coplanarity=_or_infinite(fit.coplanarity),
                recommended=t.good_M,
            )
        )
    if _is_straight(fit, t):
        notes.append(
            Finding(
                "plane.almost-straight",
                collinearity=_or_infinite(fit.collinearity),
                K=_or_infinite(fit.K),
                recommended=t.good_K,
            )
        )
    if fit.hyperbolic_overflow:
        notes.append(Finding("plane.unbounded-error"))
    return notes


OFF_PLANE_DEG = 10.0
"""Ours: a lineation this far from the plane it is said to lie on was picked elsewhere."""


ONE_SET_DEG = 12.0
"""Ours: planes that scatter more about their mean are hardly one set. Natural joint sets and limbs
have some 5 to 10 degrees; Big Elk, folded, has 49."""


def judge_line(
    fit: LineFit | None,
    *,
    confidence95_deg: float | None,
    off_plane_deg: float | None = None,
    plane_is_gone: bool = False,
    plane_is_known: bool = True,
    scatter_deg: float = 0.0,
    registration_deg: float | None = None,
    thresholds: Thresholds = DEFAULTS,
) -> Verdict:
    """The verdict on a line: of a lineation, or, where it follows from planes, fit None.

    confidence95_deg : larger semi-axis of its 95 % region, with the registration; None: unknown
    registration_deg : 95 % half-angle by which the registration of its models can turn it
    off_plane_deg : its angle from the plane it is said to lie on
    plane_is_known : that plane has an error, which is the line's across it
    scatter_deg : root mean square angle from its mean of the set of planes that scatters more
    """
    t = thresholds
    poor = False
    reasons = list[Finding]()
    angle = confidence95_deg
    if angle is None:
        if fit is None:
            reasons.append(Finding("line.plane-error-unknown"))
        elif fit.confidence95_deg is None:
            reasons.append(Finding("line.two-points"))
        if fit is not None and not plane_is_known:
            reasons.append(Finding("line.plane-error-unknown"))
    elif angle > t.good_confidence95_deg:
        poor = angle > t.poor_confidence95_deg
        limit_deg = t.poor_confidence95_deg if poor else t.good_confidence95_deg
        if registration_deg is not None and registration_deg > math.sqrt(0.5) * angle:
            code = "line.registration"
        elif fit is None or (fit.confidence95_deg is not None and angle > fit.confidence95_deg):
            code = "line.uncertain-plane"
        else:
            code = "line.uncertain"
        reasons.append(Finding(code, error_deg=angle, limit_deg=limit_deg))
    if off_plane_deg is not None and off_plane_deg > OFF_PLANE_DEG:
        reasons.append(Finding("line.off-plane", angle_deg=off_plane_deg))
    if scatter_deg > ONE_SET_DEG:
        reasons.append(Finding("line.scattered-set", scatter_deg=scatter_deg))
    if plane_is_gone:
        reasons.append(Finding("line.plane-missing"))
    quality: Quality = "poor" if poor else "doubtful" if reasons else "good"
    return Verdict(quality, tuple(reasons), limits=t)


def _axial_angle_deg(a: FloatArray, b: FloatArray) -> float | None:
    """Angle between two axes, 0 to 90; None where one has no direction."""
    # By hand: with vectors as small as these NumPy takes ten times as long.
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    lengths = math.sqrt(x * x + y * y + z * z) * math.sqrt(u * u + v * v + w * w)
    if not math.isfinite(lengths) or lengths == 0.0:
        return None
    i, j, k = y * w - z * v, z * u - x * w, x * v - y * u
    # Both parts, since the arc cosine alone is blind near 0.
    across, along = math.sqrt(i * i + j * j + k * k), abs(x * u + y * v + z * w)
    return math.degrees(math.atan2(across, along))


def _or_infinite(ratio: float | None) -> float:
    return math.inf if ratio is None else ratio
