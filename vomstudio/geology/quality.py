"""Verdicts (good, doubtful or poor) on fitted planes and lines, with their reasons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geometry.lines import FittedLine
from vomstudio.geometry.plane_sizes import POINT_OVER_RESOLUTION, PlaneSizes, is_width_within_wander
from vomstudio.geometry.plane_sizes import resolution_tilt_deg as tilt_of_resolution_deg
from vomstudio.geometry.planes import FittedPlane
from vomstudio.geometry.rotation_errors import CHI2_TWO

Quality = Literal["good", "doubtful", "poor"]
Kind = Literal["trace", "patch"]


@dataclass(frozen=True)
class Verdict:
    """Verdict on a plane or line.

    Attributes
    ----------
    quality : {"good", "doubtful", "poor"}
    reasons : tuple of Finding
        Reasons for a verdict worse than good, with remedies.
    notes : tuple of Finding
        Comparisons of shape and extent with recommended values, and questions to the geologist.
    limits : Thresholds
    """

    quality: Quality
    reasons: tuple[Finding, ...]
    notes: tuple[Finding, ...] = ()
    limits: Thresholds = DEFAULT_THRESHOLDS

    @property
    def profile(self) -> str:
        """Name of the threshold profile."""
        return self.limits.profile

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Reasons, followed by notes."""
        return (*self.reasons, *self.notes)


# Own choice: if a trace is closer to the outcrop face than this angle, its plane may be the face
# itself. A plane with a larger error is poor in any case.
MAX_FACE_ANGLE_DEG = DEFAULT_THRESHOLDS.poor_confidence95_deg
# Own choice: a trace with less relief is merely a line drawn on the face.
MIN_RELIEF_OVER_RESOLUTION = 3.0
MIN_RELIEF_OVER_EXTENT = 0.02
# Own choice, based on tests/benchmarks/bench_conditional.py.
MIN_INDEPENDENT_POINTS = 6.0


def governing_confidence_deg(fit: FittedPlane, kind: Kind = "trace") -> float | None:
    """Return the half-angle that governs the verdict on a plane.

    For patches, and for traces whose roughness is as long as the trace, it is the larger of the
    confidence and the hyperbolic error. The points of a patch are close neighbours on one rough
    surface, so a confidence that assumes independence would depend on the resolution of the model
    rather than on information. The possible tilt caused by an unresolved bow of the trace is added.

    Parameters
    ----------
    fit : FittedPlane
    kind : Kind, optional

    Returns
    -------
    float or None
        Degrees; None if undefined.
    """
    confidence, hyperbolic_error_deg = fit.max_confidence95_deg, fit.max_angular_error_deg
    if hyperbolic_error_deg is not None and (fit.long_roughness or kind == "patch"):
        confidence = (
            hyperbolic_error_deg if confidence is None else max(confidence, hyperbolic_error_deg)
        )
    if confidence is None or not fit.bow_tilt_deg:
        return confidence
    return min(math.hypot(confidence, fit.bow_tilt_deg), 90.0)


def governing_half_angles(
    fit: FittedPlane,
    kind: Kind = "trace",
    resolution_m: float | None = None,
    outcrop_normal: npt.ArrayLike | None = None,
    stretch_error_deg: float | None = None,
) -> tuple[float | None, float | None]:
    """Return the largest and smallest half-angle that govern the verdict.

    See `governing_confidence_deg`. Doubtful stretches may rotate the plane about any axis.

    Parameters
    ----------
    fit : FittedPlane
    kind : Kind, optional
    resolution_m : float, optional
        Effective resolution of the model.
    outcrop_normal : (3,) array_like, optional
        Normal of the face of the outcrop.
    stretch_error_deg : float, optional
        95 % error caused by doubtful stretches, degrees.

    Returns
    -------
    largest, smallest : float or None
        Degrees; None if undefined.
    """
    major_deg, minor_deg = governing_confidence_deg(fit, kind), fit.min_confidence95_deg
    if major_deg is None or minor_deg is None or fit.max_confidence95_deg is None:
        return None, None
    is_widened = fit.long_roughness or kind == "patch"
    if (
        is_widened
        and major_deg > fit.max_confidence95_deg
        and fit.min_angular_error_deg is not None
    ):
        minor_deg = max(minor_deg, fit.min_angular_error_deg)
    is_undetermined = is_within_wander(fit, kind, resolution_m, outcrop_normal)
    stretch = stretch_error_deg or 0.0
    return max(90.0 if is_undetermined else major_deg, stretch), max(minor_deg, stretch)


def is_within_wander(
    fit: FittedPlane,
    kind: Kind,
    resolution_m: float | None,
    outcrop_normal: npt.ArrayLike | None,
) -> bool:
    """Return whether a trace in the outcrop face is not wider than the wander of its points.

    In this case, any plane through the line is possible. The error of the fit includes deviations
    normal to the face, but if the plane is the face, the residuals do not show deviations along it.

    Parameters
    ----------
    fit : FittedPlane
    kind : Kind
    resolution_m : float or None
        Effective resolution of the model.
    outcrop_normal : (3,) array_like or None
        Normal of the face of the outcrop.

    Returns
    -------
    bool
    """
    spacing = resolution_m or 0.0
    if kind != "trace" or not spacing > 0.0 or fit.trace is None or fit.extent is None:
        return False
    if outcrop_normal is None:
        return False
    angle = _axial_angle_deg(fit.normal, np.asarray(outcrop_normal, dtype=np.float64))
    if angle is None or angle > MAX_FACE_ANGLE_DEG:
        return False
    return is_width_within_wander(fit.trace * float(fit.eigenvalues[1]), fit.extent, fit.n, spacing)


def feature_extent_m(fit: FittedPlane, kind: Kind = "trace") -> float | None:
    """Return the length of a trace, or the diameter of a disc equivalent to a patch.

    Parameters
    ----------
    fit : FittedPlane
    kind : Kind, optional

    Returns
    -------
    float or None
        Metres.
    """
    if kind == "trace" or fit.trace is None:
        return fit.extent
    l1, l2, _ = fit.eigenvalues
    # A uniform disc of radius R has a variance of R^2 / 4 along each diameter.
    return float(4.0 * np.sqrt(fit.trace * np.sqrt(l1 * l2)))


def resolution_tilt_deg(
    fit: FittedPlane, resolution_m: float | None, kind: Kind = "trace"
) -> float | None:
    """Return the possible tilt of a plane due to the resolution of the model.

    For a patch, it is the angle whose tangent is half the resolution divided by the shorter
    axis. Each point of a trace has a one-sigma error of `POINT_OVER_RESOLUTION` times the
    resolution, regardless of the residuals. The tilt of a trace is the resulting 95 % tilt for
    independent points, but at most that of a patch.

    Parameters
    ----------
    fit : FittedPlane
    resolution_m : float or None
        Effective resolution of the model.
    kind : Kind, optional

    Returns
    -------
    float or None
        Degrees; None if unknown.
    """
    if resolution_m is None or not resolution_m > 0.0 or fit.trace is None:
        return None
    # A strip of width w has a variance of w^2 / 12 across it.
    width = math.sqrt(12.0 * max(fit.trace * float(fit.eigenvalues[1]), 0.0))
    max_tilt = tilt_of_resolution_deg(resolution_m, width)
    if kind == "patch":
        return max_tilt
    return min(max_tilt, _tilt_of_points_deg(fit, POINT_OVER_RESOLUTION * resolution_m))


def _tilt_of_points_deg(fit: FittedPlane, sigma_m: float) -> float:
    """Return the 95 % tilt of a plane about its longer axis, degrees.

    The errors of its points are assumed to be independent.
    """
    n_independent = float(fit.n if fit.n_effective is None else fit.n_effective)
    width = math.sqrt(n_independent * max((fit.trace or 0.0) * float(fit.eigenvalues[1]), 0.0))
    return math.degrees(math.atan2(math.sqrt(CHI2_TWO) * sigma_m, width))


def has_too_few_points(fit: FittedPlane, resolution_m: float | None, good_deg: float) -> bool:
    """Return whether a plane has fewer than 6 independent points and no roughness bound.

    The misfit of a few points is too often small by chance. Three points, which have no misfit, are
    judged separately. The resolution of the model is a
    roughness bound if point errors of half the resolution still result in a good plane.

    Parameters
    ----------
    fit : FittedPlane
    resolution_m : float or None
        Effective resolution of the model.
    good_deg : float
        Maximum error of a good plane, degrees.

    Returns
    -------
    bool
    """
    if (
        fit.n <= 3
        or (fit.n if fit.n_effective is None else fit.n_effective) >= MIN_INDEPENDENT_POINTS
    ):
        return False
    return not resolution_m or _tilt_of_points_deg(fit, 0.5 * resolution_m) > good_deg


def total_error_deg(
    fit: FittedPlane,
    resolution_m: float | None,
    kind: Kind = "trace",
    registration_deg: float | None = None,
    outcrop_normal: npt.ArrayLike | None = None,
    stretch_error_deg: float | None = None,
) -> float | None:
    """Return the total 95 % half-angle of a plane, which decides the verdict.

    It is the half-angle of the fit (see `governing_confidence_deg`), but at least the tilt due to
    the resolution or to doubtful stretches (geology/doubtful_stretches.py), combined with the error
    of the registration. It is 90 degrees if the trace is not wider than the wander of its points.

    Parameters
    ----------
    fit : FittedPlane
    resolution_m : float or None
        Effective resolution of the model.
    kind : Kind, optional
    registration_deg : float, optional
        95 % error of the registration, degrees.
    outcrop_normal : (3,) array_like, optional
        Normal of the face of the outcrop.
    stretch_error_deg : float, optional
        95 % error caused by doubtful stretches, degrees.

    Returns
    -------
    float or None
        Degrees; None if the fit has no error estimate.
    """
    return _ErrorParts.of(
        fit, resolution_m, kind, registration_deg, outcrop_normal, stretch_error_deg
    ).total_deg


@dataclass(frozen=True)
class _ErrorParts:
    """Total 95 % error of a plane and its parts, degrees.

    Attributes
    ----------
    fit_deg : float or None
        Half-angle of the fit; None if there is no redundancy.
    model_deg : float or None
        Half-angle of the fit, but at least the tilt due to resolution and doubtful stretches.
    total_deg : float or None
        The error `model_deg` combined with that of the registration.
    is_undetermined : bool
        True if the trace is not wider than the wander of its points. See `is_within_wander`.
    """

    fit_deg: float | None
    model_deg: float | None
    total_deg: float | None
    is_undetermined: bool

    @classmethod
    def of(
        cls,
        fit: FittedPlane,
        resolution_m: float | None,
        kind: Kind,
        registration_deg: float | None,
        outcrop_normal: npt.ArrayLike | None,
        stretch_error_deg: float | None,
    ) -> _ErrorParts:
        fit_deg = governing_confidence_deg(fit, kind)
        if fit_deg is None:
            return cls(None, None, None, is_undetermined=False)
        if is_within_wander(fit, kind, resolution_m, outcrop_normal):
            return cls(fit_deg, 90.0, 90.0, is_undetermined=True)
        tilt_deg = resolution_tilt_deg(fit, resolution_m, kind) or 0.0
        model_deg = total_deg = max(fit_deg, tilt_deg, stretch_error_deg or 0.0)
        if registration_deg:
            total_deg = min(math.hypot(model_deg, registration_deg), 90.0)
        return cls(fit_deg, model_deg, total_deg, is_undetermined=False)


def judge(
    fit: FittedPlane,
    *,
    resolution_m: float | None,
    outcrop_normal: npt.ArrayLike | None,
    kind: Kind = "trace",
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    registration_deg: float | None = None,
    surface_findings: Sequence[Finding] = (),
    stretch_error_deg: float | None = None,
    bend_deg: float | None = None,
) -> Verdict:
    """Judge a fitted plane.

    If the thresholds use the error, the verdict depends on the total error and on effects that the
    total error does not include; shape and extent are reported as notes. If they use the shape, the
    plane is good if it meets all three limits of the textbook, doubtful if it misses one of them,
    and poor otherwise; the error is reported as a note.

    Parameters
    ----------
    fit : FittedPlane
    resolution_m : float or None
        Effective resolution of the model around the picked points, m; None if unknown.
    outcrop_normal : (3,) array_like or None
        Normal of the outcrop face on a scale larger than the trace, in either direction.
    kind : {"trace", "patch"}
        Only traces are compared with the outcrop face, because a patch is part of it.
    thresholds : Thresholds
    registration_deg : float, optional
        95 % half-angle of the registration of the model, degrees.
    surface_findings : sequence of Finding
        Findings about the surface or the path of a trace (geometry/heights/levels.py,
        geology/doubtful_stretches.py).
    stretch_error_deg : float, optional
        95 % half-angle that includes doubtful stretches, degrees.
    bend_deg : float, optional
        Bend of the whole face, degrees. See `geometry.heights.bends`.

    Returns
    -------
    Verdict
    """
    if fit.error is not None:
        return Verdict("poor", (fit.error,), limits=thresholds)
    face_reasons, face_notes = _face_findings(fit, kind, outcrop_normal, resolution_m, thresholds)
    judge_points = _judge_by_shape if thresholds.by == "shape" else _judge_by_error
    errors = _ErrorParts.of(
        fit, resolution_m, kind, registration_deg, outcrop_normal, stretch_error_deg
    )
    is_poor, reasons, notes = judge_points(
        fit, errors, kind, resolution_m, thresholds, registration_deg, stretch_error_deg
    )
    reasons += [*face_reasons, *surface_findings]
    quality: Quality = "poor" if is_poor else "doubtful" if reasons else "good"
    total_deg = errors.total_deg
    if bend_deg is not None and total_deg is not None and is_local(fit, bend_deg, total_deg):
        regional_deg = min(math.hypot(total_deg, bend_deg), 90.0)
        notes.append(Finding("plane.local", bend_deg=bend_deg, regional_deg=regional_deg))
    return Verdict(quality, tuple(reasons), tuple(notes + face_notes), thresholds)


def is_local(fit: FittedPlane, bend_deg: float | None, total_deg: float | None) -> bool:
    """Return whether a plane represents only the attitude at its location.

    This is the case if its roughness is as long as the trace, or if its face bends by more than the
    error of the plane.

    Parameters
    ----------
    fit : FittedPlane
    bend_deg : float or None
        Bend of the face, degrees.
    total_deg : float or None
        95 % error of the plane, degrees.

    Returns
    -------
    bool
    """
    is_bent = bend_deg is not None and total_deg is not None and bend_deg > total_deg
    return is_bent or fit.long_roughness


def _judge_by_error(
    fit: FittedPlane,
    errors: _ErrorParts,
    kind: Kind,
    resolution_m: float | None,
    thresholds: Thresholds,
    registration_deg: float | None,
    stretch_error_deg: float | None,
) -> tuple[bool, list[Finding], list[Finding]]:
    """Judge a plane by its error; return whether it is poor, the reasons and the notes."""
    is_poor, reasons = _direction_findings(
        fit, errors, kind, resolution_m, thresholds, registration_deg, stretch_error_deg
    )
    if fit.long_roughness:
        reasons.append(Finding("plane.long-roughness"))
    notes = _shape_findings(fit, thresholds)
    extent = feature_extent_m(fit, kind)
    if resolution_m is not None and resolution_m > 0.0 and extent is not None:
        ratio = extent / resolution_m
        if ratio < thresholds.least_extent_over_resolution:
            minimum = thresholds.least_extent_over_resolution
            reasons.append(Finding("plane.too-small", ratio=ratio, minimum=minimum))
        elif ratio < thresholds.extent_over_resolution:
            expected_deg = PlaneSizes.from_resolution(resolution_m).error_deg(extent) or 90.0
            # A plane with an unknown or larger error must not be promised a smaller one.
            if errors.total_deg is not None and errors.total_deg <= expected_deg:
                notes.append(
                    Finding(
                        "plane.small",
                        # Round down, so that the recommended value itself is never displayed.
                        ratio=math.floor(10.0 * ratio) / 10.0
                        if ratio < 10.0
                        else math.floor(ratio),
                        recommended=thresholds.extent_over_resolution,
                        error_deg=expected_deg,
                    )
                )
    return is_poor, reasons, notes


def _judge_by_shape(
    fit: FittedPlane,
    errors: _ErrorParts,
    kind: Kind,
    resolution_m: float | None,
    thresholds: Thresholds,
    registration_deg: float | None,
    stretch_error_deg: float | None,
) -> tuple[bool, list[Finding], list[Finding]]:
    """Judge a plane by its shape; return whether it is poor, the reasons and the notes."""
    reasons, notes = list[Finding](), list[Finding]()
    # None means infinite: the points lie exactly in one plane or along one line.
    if fit.coplanarity is not None and fit.coplanarity < thresholds.least_coplanarity:
        reasons.append(
            Finding(
                "plane.not-coplanar",
                coplanarity=fit.coplanarity,
                minimum=thresholds.least_coplanarity,
            )
        )
    if fit.collinearity is None or fit.collinearity > thresholds.most_collinearity:
        reasons.append(
            Finding(
                "plane.collinear",
                collinearity=_number_or_infinity(fit.collinearity),
                maximum=thresholds.most_collinearity,
            )
        )
    extent = feature_extent_m(fit, kind)
    if extent is None or resolution_m is None or not resolution_m > 0.0:
        notes.append(Finding("plane.unknown-resolution"))
    elif extent < thresholds.extent_over_resolution * resolution_m:
        ratio = extent / resolution_m
        reasons.append(
            Finding("plane.too-small", ratio=ratio, minimum=thresholds.extent_over_resolution)
        )
    is_poor = len(reasons) > 1
    _, error_reasons = _direction_findings(
        fit, errors, kind, resolution_m, thresholds, registration_deg, stretch_error_deg
    )
    if errors.fit_deg is None:
        # Without redundancy, or if points are identical, the shape is irrelevant.
        return is_poor, reasons + error_reasons, notes
    return is_poor, reasons, notes + error_reasons


def _face_findings(
    fit: FittedPlane,
    kind: Kind,
    outcrop_normal: npt.ArrayLike | None,
    resolution_m: float | None,
    thresholds: Thresholds,
) -> tuple[list[Finding], list[Finding]]:
    """Return the findings about a trace that is parallel to the outcrop face.

    The first list contains the reason against a trace that is merely drawn on the face; the second
    contains the question whether the face is the structure itself.
    """
    if kind != "trace" or outcrop_normal is None:
        return [], []
    face_normal = np.asarray(outcrop_normal, dtype=np.float64)
    angle = _axial_angle_deg(fit.normal, face_normal)
    if (
        angle is None
        or angle >= thresholds.surface_effect_deg
        or fit.trace is None
        or fit.extent is None
    ):
        return [], []
    unit = face_normal / np.linalg.norm(face_normal)
    variance = float(np.sum(fit.eigenvalues * (fit.axes @ unit) ** 2)) * fit.trace
    relief = 4.0 * float(np.sqrt(max(variance, 0.0)))
    min_relief = max(
        MIN_RELIEF_OVER_RESOLUTION * (resolution_m or 0.0), MIN_RELIEF_OVER_EXTENT * fit.extent
    )
    if relief < min_relief:
        return [Finding("plane.in-face", angle_deg=angle)], []
    return [], [Finding("plane.along-face", angle_deg=angle)]


def _direction_findings(
    fit: FittedPlane,
    errors: _ErrorParts,
    kind: Kind,
    resolution_m: float | None,
    thresholds: Thresholds,
    registration_deg: float | None,
    stretch_error_deg: float | None,
) -> tuple[bool, list[Finding]]:
    """Return whether the error makes the plane poor, and the reasons."""
    angle = errors.total_deg
    if angle is None and fit.n <= 3:
        # Profiles by shape already report a straight trace. K is undefined without scatter.
        is_straight = (
            thresholds.by != "shape"
            and _number_or_infinity(fit.collinearity) > thresholds.most_collinearity
        )
        return False, [
            Finding("plane.three-straight-points" if is_straight else "plane.three-points")
        ]
    if angle is None:
        return True, [Finding("plane.three-distinct-points", n=fit.n)]
    if angle <= thresholds.good_confidence95_deg:
        if not has_too_few_points(fit, resolution_m, thresholds.good_confidence95_deg):
            return False, []
        return False, [Finding("plane.too-few-points", minimum=int(MIN_INDEPENDENT_POINTS))]
    is_poor = angle > thresholds.poor_confidence95_deg
    limit_deg = thresholds.poor_confidence95_deg if is_poor else thresholds.good_confidence95_deg
    model_error = errors.model_deg or 0.0
    if registration_deg is not None and registration_deg > model_error:
        return is_poor, [
            Finding("plane.registration", error_deg=registration_deg, limit_deg=limit_deg)
        ]
    if errors.is_undetermined:
        return is_poor, [Finding("plane.too-straight", error_deg=angle, limit_deg=limit_deg)]
    if stretch_error_deg is not None and model_error <= stretch_error_deg:
        # The stretches have already been reported as a reason.
        return is_poor, []
    if model_error > (errors.fit_deg or 0.0):
        return is_poor, [Finding("plane.resolution", error_deg=angle, limit_deg=limit_deg)]
    if kind == "patch":
        code = "plane.uncertain-patch"
    else:
        code = "plane.too-straight" if _is_straight(fit, thresholds) else "plane.uncertain"
    return is_poor, [Finding(code, error_deg=angle, limit_deg=limit_deg)]


def _is_straight(fit: FittedPlane, thresholds: Thresholds) -> bool:
    return fit.K is None or thresholds.good_K <= fit.K


def _shape_findings(fit: FittedPlane, thresholds: Thresholds) -> list[Finding]:
    """Compare the scatter of the points with the recommended values."""
    notes = list[Finding]()
    # None means infinite: the points lie exactly in one plane.
    if fit.M is not None and thresholds.good_M >= fit.M:
        notes.append(
            Finding(
                "plane.scattered",
                M=fit.M,
                coplanarity=_number_or_infinity(fit.coplanarity),
                recommended=thresholds.good_M,
            )
        )
    if _is_straight(fit, thresholds):
        notes.append(
            Finding(
                "plane.almost-straight",
                collinearity=_number_or_infinity(fit.collinearity),
                K=_number_or_infinity(fit.K),
                recommended=thresholds.good_K,
            )
        )
    if fit.hyperbolic_overflow:
        notes.append(Finding("plane.unbounded-error"))
    return notes


MAX_OFF_PLANE_DEG = 10.0
"""Maximum angle between a lineation and its plane (own choice); others were picked elsewhere."""


MAX_SET_SCATTER_DEG = 12.0
"""Maximum scatter of the planes of one set (own choice). Natural joint sets and limbs have a
scatter of 5 to 10 degrees; the folded beds of Big Elk have 49.
"""


def judge_line(
    fit: FittedLine | None,
    *,
    confidence95_deg: float | None,
    off_plane_deg: float | None = None,
    is_plane_missing: bool = False,
    is_plane_known: bool = True,
    scatter_deg: float = 0.0,
    registration_deg: float | None = None,
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
) -> Verdict:
    """Judge a lineation, or a line derived from planes if `fit` is None.

    Parameters
    ----------
    fit : FittedLine or None
    confidence95_deg : float or None
        Larger semi-axis of the 95 % region, including the registration, degrees; None if unknown.
    off_plane_deg : float, optional
        Angle between the line and its plane, degrees.
    is_plane_missing : bool
        True if the plane of the line was deleted.
    is_plane_known : bool
        True if the plane of the line has a known error, which is that of the line across the plane.
    scatter_deg : float
        RMS angle between planes and their mean in the set with the larger scatter, degrees.
    registration_deg : float, optional
        95 % half-angle of the registrations of the models, degrees.
    thresholds : Thresholds

    Returns
    -------
    Verdict
    """
    limits = thresholds
    is_poor = False
    reasons = list[Finding]()
    angle = confidence95_deg
    if angle is None:
        if fit is None:
            reasons.append(Finding("line.plane-error-unknown"))
        elif fit.confidence95_deg is None:
            reasons.append(Finding("line.two-points"))
        if fit is not None and not is_plane_known:
            reasons.append(Finding("line.plane-error-unknown"))
    elif angle > limits.good_confidence95_deg:
        is_poor = angle > limits.poor_confidence95_deg
        limit_deg = limits.poor_confidence95_deg if is_poor else limits.good_confidence95_deg
        if registration_deg is not None and registration_deg > math.sqrt(0.5) * angle:
            code = "line.registration"
        elif fit is None or (fit.confidence95_deg is not None and angle > fit.confidence95_deg):
            code = "line.uncertain-plane"
        else:
            code = "line.uncertain"
        reasons.append(Finding(code, error_deg=angle, limit_deg=limit_deg))
    if off_plane_deg is not None and off_plane_deg > MAX_OFF_PLANE_DEG:
        reasons.append(Finding("line.off-plane", angle_deg=off_plane_deg))
    if scatter_deg > MAX_SET_SCATTER_DEG:
        reasons.append(Finding("line.scattered-set", scatter_deg=scatter_deg))
    if is_plane_missing:
        reasons.append(Finding("line.plane-missing"))
    quality: Quality = "poor" if is_poor else "doubtful" if reasons else "good"
    return Verdict(quality, tuple(reasons), limits=limits)


def _axial_angle_deg(a: FloatArray, b: FloatArray) -> float | None:
    """Return the angle between two axes, 0 to 90 degrees, or None if one has no direction."""
    # Plain Python is ten times faster than NumPy for three elements.
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    lengths = math.sqrt(x * x + y * y + z * z) * math.sqrt(u * u + v * v + w * w)
    if not math.isfinite(lengths) or lengths == 0.0:
        return None
    i, j, k = y * w - z * v, z * u - x * w, x * v - y * u
    # The arc cosine alone loses digits near 0.
    cross_norm, cosine_product = math.sqrt(i * i + j * j + k * k), abs(x * u + y * v + z * w)
    return math.degrees(math.atan2(cross_norm, cosine_product))


def _number_or_infinity(ratio: float | None) -> float:
    return math.inf if ratio is None else ratio
