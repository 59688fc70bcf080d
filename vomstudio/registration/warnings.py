"""Findings about a registration: possible errors, and their remedies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.bowing import Bowing, LensDeformation, bowing_deg
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import Line
from vomstudio.registration.adjustment import Adjustment, adjust
from vomstudio.registration.blunders import Blunder, LeaveOneOut, select_observations
from vomstudio.registration.compass_checks import MIN_PLANES, find_azimuth_correction
from vomstudio.registration.observations import (
    Directions,
    Lengths,
    ObservationKind,
    Points,
    all_rows,
)
from vomstudio.registration.results import (
    DeterminedParameters,
    ModelPlacement,
    PointResidual,
    RotationError,
)
from vomstudio.registration.scatter import drift_findings, scale_findings
from vomstudio.registration.similarity_observation import SimilarityObservation

_Z95 = 1.959963984540054
_MAX_ROTATION_DEG = 1.0
# Error above which the rotation is unknown, one sigma.
_UNKNOWN_ROTATION_DEG = 90.0
_MIN_BOWING_DEG = 0.1
# Minimum possible bowing, from edge to edge, that is reported.
_MIN_POSSIBLE_BOWING_DEG = 1.0
# Residual, as a share of the extent, that is due to wrong values and not to measurement errors.
_MAX_RESIDUAL_SHARE = 0.1
# Upward component of the normal below which a mean plane is a wall.
_MIN_UPWARD_COMPONENT = np.sqrt(0.5)
# Redundancy and p-value from which stated accuracies are too large.
_MIN_REDUNDANCY, _MIN_P_VALUE = 3.0, 1e-6
# Limits of the angle within which a reading agrees with the others.
_AZIMUTH_LIMITS_DEG = (10.0, 20.0)


def fit_findings(result: Adjustment, kinds: Sequence[ObservationKind]) -> list[Finding]:
    """Return findings about the residuals of a fit.

    Parameters
    ----------
    result : Adjustment
    kinds : sequence of ObservationKind

    Returns
    -------
    list of Finding
    """
    findings: list[Finding] = []
    if result.misfit_factor > 1.0:
        findings.append(Finding("registration.residuals-large", times=result.misfit_factor))
    if (times := _error_ratio(result, kinds)) is not None:
        findings.append(
            Finding("registration.readings-copied", times=times)
            if not any(isinstance(kind, Points | Lengths | SimilarityObservation) for kind in kinds)
            else Finding("registration.residuals-small", times=times)
        )
    findings += drift_findings(result.drift)
    if result.is_ambiguous:
        findings.append(Finding("registration.ambiguous"))
    if result.assumed_error_groups:
        findings.append(
            Finding(
                "registration.error-assumed",
                kinds=[tr(name) for name in result.assumed_error_groups],
            )
        )
    return findings


def _error_ratio(result: Adjustment, kinds: Sequence[ObservationKind]) -> float | None:
    """Return the ratio of stated errors to residuals if the residuals are too small.

    Returns None if they agree. The errors of clicks are not counted, since a click may be more
    accurate than the resolution of the model.
    """
    from scipy.stats import chi2

    exact_kinds = [
        kind.assume_exact_model() if isinstance(kind, Points | Lengths) else kind for kind in kinds
    ]
    stated_sigma = all_rows(exact_kinds, result.fit, result.centre)[0].sigma
    if (
        not len(stated_sigma)
        or not np.isfinite(stated_sigma).all()
        or result.redundancy < _MIN_REDUNDANCY
    ):
        return None
    squares = float(((result.rows.residuals / stated_sigma) ** 2).sum())
    if not squares > 0.0 or chi2.cdf(squares, result.redundancy) > _MIN_P_VALUE:
        return None
    return float(np.sqrt(result.redundancy / squares))


def redundancy_findings(
    control: Sequence[PointResidual], check: Sequence[PointResidual], points: Points | None
) -> list[Finding]:
    """Return findings about missing redundancy and check points of a registration.

    Parameters
    ----------
    control, check : sequence of PointResidual
        Residuals of the control and check points.
    points : Points or None

    Returns
    -------
    list of Finding
    """
    if points is None:
        return []
    findings = []
    if len(control) < 4:
        findings.append(Finding("control.no-redundancy", count=len(control), least=4))
    if not check:
        findings.append(Finding("control.no-check-points"))
    return findings


def weakest_axis_finding(error_deg: float, trend_deg: float, plunge_deg: float) -> Finding:
    """Return the finding about the weakest axis.

    Parameters
    ----------
    error_deg : float
        95 % error.
    trend_deg, plunge_deg : float
        Direction of the axis.

    Returns
    -------
    Finding
    """
    return Finding(
        "registration.weakest-axis",
        error95_deg=error_deg,
        trend=format_azimuth(trend_deg),
        plunge_deg=plunge_deg,
        trend_deg=trend_deg,
    )


def worst_axis_findings(placement: ModelPlacement) -> list[Finding]:
    """Return findings about the rotation error, and where one more point would help most.

    Parameters
    ----------
    placement : ModelPlacement

    Returns
    -------
    list of Finding
    """
    findings = []
    weakest_axis, advice = placement.rotation_error_95_deg.weakest, placement.worth_adding
    if weakest_axis.error_deg is not None:
        findings.append(
            weakest_axis_finding(
                weakest_axis.error_deg, weakest_axis.trend_deg, weakest_axis.plunge_deg
            )
        )
    if advice is not None:
        findings.append(
            Finding(
                "registration.worth-adding",
                x=advice.x,
                y=advice.y,
                z=advice.z,
                after_deg=advice.error_after_deg,
            )
        )
    return findings


def vertical_error_findings(placement: ModelPlacement) -> list[Finding]:
    """Return findings about the error of the vertical if north may be undetermined.

    Parameters
    ----------
    placement : ModelPlacement

    Returns
    -------
    list of Finding
    """
    if not placement.known.vertical:
        return []
    tilt = float(np.linalg.eigvalsh(np.array(placement.covariance)[:2, :2])[-1])
    return [
        Finding(
            "registration.vertical", error95_deg=_Z95 * float(np.degrees(np.sqrt(max(tilt, 0.0))))
        )
    ]


def reference_fit_finding(
    places: int, overlap: float, rms_m: float, blocks: int, block_m: float
) -> Finding:
    """Return the finding with the figures of a `ModelFit`.

    Parameters
    ----------
    places : int
        Number of compared positions.
    overlap : float
        See `ModelFit`.
    rms_m : float
        Root mean square distance.
    blocks : int
        Number of blocks of the error estimate.
    block_m : float
        Size of a block.

    Returns
    -------
    Finding
    """
    return Finding(
        "reference.fitted",
        places=places,
        overlap_percent=100.0 * overlap,
        rms_m=rms_m,
        blocks=blocks,
        block_m=block_m,
    )


def error_findings(
    error: RotationError,
    scale95: float | None,
    known_parameters: DeterminedParameters,
    points: Points | None,
    *,
    is_named: bool = False,
    fraction: float = 0.0,
) -> list[Finding]:
    """Return findings about the errors of a registration.

    Parameters
    ----------
    error : RotationError
    scale95 : float or None
    known_parameters : DeterminedParameters
    points : Points or None
        Points of the fit.
    is_named : bool
        Whether a reported error must be corrected before further measurements.
    fraction : float
        RMS residual of the points as a share of their extent.
    """
    findings = []
    undetermined_names = [
        tr(word)
        for word, is_known in (
            ("north", known_parameters.north),
            ("the vertical", known_parameters.vertical),
            ("the scale", known_parameters.scale),
            ("the position", known_parameters.position),
        )
        if not is_known
    ]
    if undetermined_names:
        findings.append(Finding("registration.not-known", parameters=undetermined_names))
    weakness_findings = []
    up, east, north = error.about_up, error.about_east, error.about_north
    if up is not None and east is not None and north is not None:
        tilt = float(np.hypot(east, north))
        if max(up, east, north) > _MAX_ROTATION_DEG:
            weakness_findings.append(
                Finding("registration.rotation-unknown")
                if max(up, tilt) > _UNKNOWN_ROTATION_DEG
                else Finding("registration.weak-rotation", azimuth_deg=up, tilt_deg=tilt)
            )
    if scale95 is not None:
        weakness_findings += scale_findings(scale95 / _Z95)
    has_large_residuals = (
        points is not None and points.name != "cameras" and fraction >= _MAX_RESIDUAL_SHARE
    )
    if weakness_findings and has_large_residuals and not is_named:
        findings.append(Finding("registration.points-nowhere", share_percent=100.0 * fraction))
    findings += weakness_findings
    return findings


def blunder_findings(
    kinds: Sequence[ObservationKind],
    blunders: Sequence[Blunder],
    result: Adjustment,
    centre: FloatArray,
    size: float,
) -> list[Finding]:
    """Return a finding about all blunders, and findings about misread azimuths among them.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    blunders : sequence of Blunder
    result : Adjustment
    centre, size : ndarray
        See `adjust`.

    Returns
    -------
    list of Finding
    """
    from scipy.spatial.transform import Rotation

    if not blunders:
        return []
    blunder_labels = {blunder.label for blunder in blunders}
    other_kinds = [
        select_observations(kind, [label not in blunder_labels for label in kind.labels])
        for kind in kinds
    ]
    remaining_fit = adjust([kind for kind in other_kinds if len(kind.labels)], centre, size)
    rotation_angle = Rotation.from_matrix(
        remaining_fit.fit.rotation @ result.fit.rotation.T
    ).magnitude()
    return [
        Finding(
            "registration.blunder",
            labels=[blunder.text() for blunder in blunders],
            turned_deg=float(np.degrees(rotation_angle)),
            scale_percent=100.0 * (remaining_fit.fit.scale / result.fit.scale - 1.0),
        ),
        *_other_azimuth_findings(kinds, blunder_labels, remaining_fit),
    ]


def suspect_findings(leave_one_out_results: Sequence[LeaveOneOut]) -> list[Finding]:
    """Return the finding about a suspect direction, with the placement without it.

    Parameters
    ----------
    leave_one_out_results : sequence of LeaveOneOut
        Placements without one of the directions each.

    Returns
    -------
    list of Finding
    """
    if not leave_one_out_results or not leave_one_out_results[0].suspect:
        return []
    first_result = leave_one_out_results[0]
    findings = [
        Finding(
            "registration.suspect",
            label=first_result.label,
            error_deg=first_result.error_deg,
            others_deg=first_result.others_deg,
            turn_deg=first_result.turned_deg,
        )
    ]
    if first_result.azimuth_off_deg is not None:
        findings.append(_misread_azimuth_finding(first_result.label, first_result.azimuth_off_deg))
    return findings


def _misread_azimuth_finding(label: str, turn_deg: float) -> Finding:
    return Finding("compass.other-azimuth", turn_deg=turn_deg, labels=[label])


def _other_azimuth_findings(
    kinds: Sequence[ObservationKind], blunder_labels: set[str], remaining_fit: Adjustment
) -> list[Finding]:
    """Return findings about outliers whose azimuth was misread.

    This is used if there are few readings; `azimuth_findings` checks larger sets of planes.
    """
    findings = []
    largest_error = float(
        np.degrees(np.sqrt(max(np.linalg.eigvalsh(remaining_fit.rotation)[-1], 0.0)))
    )
    limit = float(np.clip(2.0 * _Z95 * largest_error, *_AZIMUTH_LIMITS_DEG))
    for kind in kinds:
        if not isinstance(kind, Directions) or len(kind.labels) >= MIN_PLANES:
            continue
        for label, model, world in zip(kind.labels, kind.model, kind.world, strict=True):
            if label in blunder_labels:
                rotation = find_azimuth_correction(remaining_fit.fit.rotation @ model, world, limit)
                findings += [] if rotation is None else [_misread_azimuth_finding(label, rotation)]
    return findings


def bowing_findings(bowing: Bowing | None, *, is_photo_model: bool = False) -> list[Finding]:
    """Return a finding if the model is bent like a dome.

    Parameters
    ----------
    bowing : Bowing or None
    is_photo_model : bool, optional
        Whether the bowing was estimated from the verticals of photos, not from points.

    Returns
    -------
    list of Finding
    """
    if bowing is None or not bowing.significant or bowing.across_deg < _MIN_BOWING_DEG:
        return []
    evidence = (
        tr("the verticals of {count} photos", count=bowing.n)
        if is_photo_model
        else tr("the residuals of {count} points", count=bowing.n)
    )
    return [
        Finding(
            "registration.bowed",
            evidence=evidence,
            source="verticals" if is_photo_model else "residuals",
            n=bowing.n,
            rise_m=bowing.rise_m,
            where=describe_edges(bowing),
            side_deg=bowing.side_deg,
            error95_deg=bowing.side_error95_deg,
            across_deg=bowing.across_deg,
        )
    ]


def describe_edges(bowing: Bowing) -> str:
    """Describe where the edges of a bowed model are, relative to the plane of its middle.

    A dome is a false anticline, a dish a false syncline; for a wall the azimuth is stated.

    Parameters
    ----------
    bowing : Bowing

    Returns
    -------
    str
    """
    direction = bowing.edge_direction
    if abs(float(direction[2])) < _MIN_UPWARD_COMPONENT:
        return tr(
            "on its side towards {azimuth}",
            azimuth=format_azimuth(Line.from_vector(direction, is_directed=True).trend_deg),
        )
    return tr("above it (a dish)") if direction[2] > 0.0 else tr("below it (a dome)")


def lens_findings(bend: LensDeformation | None, bowing: Bowing | None) -> list[Finding]:
    """Return findings about the deformation of a model due to lens errors.

    Parameters
    ----------
    bend : LensDeformation or None
    bowing : Bowing or None
        Bowing estimated from the residuals.

    Returns
    -------
    list of Finding
    """
    return [] if bend is None else lens_bend_findings(bend.across_deg, bend.stretch95, bowing)


def lens_bend_findings(
    across95_deg: float, stretch95: float | None, bowing: Bowing | None
) -> list[Finding]:
    """Return the findings of `lens_findings` from the record of a registration.

    Parameters
    ----------
    across95_deg : float
        95 % tilt across the model due to lens errors, degrees.
    stretch95 : float or None
        Relative 95 % error of lengths.
    bowing : Bowing or None
        Bowing estimated from the residuals.

    Returns
    -------
    list of Finding
    """
    findings = []
    bowing_across_deg = bowing_deg(across95_deg, bowing)
    is_bent = bowing is not None and bowing.significant
    if (
        bowing_across_deg is not None
        and not is_bent
        and bowing_across_deg > _MIN_POSSIBLE_BOWING_DEG
    ):
        findings.append(
            Finding("lens.bowing", side_deg=bowing_across_deg / 2.0, across_deg=bowing_across_deg)
        )
    angle = float(np.degrees((stretch95 or 0.0) / 2.0))
    if angle > _MIN_POSSIBLE_BOWING_DEG / 2.0:
        findings.append(
            Finding("lens.stretch", share_percent=100.0 * (stretch95 or 0.0), turn_deg=angle)
        )
    return findings
