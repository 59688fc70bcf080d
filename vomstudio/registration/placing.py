"""Placement of a model by all observations, with its errors and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import MIN_BOWING_POINTS, Bowing, fit_bowing, model_shape
from vomstudio.geology.orientation import Line
from vomstudio.geometry.coordinate_limits import check_error
from vomstudio.geometry.registrations import ObservationGroup
from vomstudio.registration.adjustment import Adjustment, adjust
from vomstudio.registration.blunders import (
    Blunder,
    LeaveOneOut,
    exclude_labels,
    find_blunders,
    leave_one_out,
)
from vomstudio.registration.checks.mirrors import mirror_findings, upside_down_findings
from vomstudio.registration.consistency import (
    check_fixed_scale,
    disagreement_findings,
    estimate_north_errors,
)
from vomstudio.registration.length_evidence import fixed_scale
from vomstudio.registration.likelihood import widen_by_likelihood
from vomstudio.registration.observations import (
    FixedScale,
    ObservationKind,
    PhotoUpright,
    Points,
    kind_name,
)
from vomstudio.registration.precision import add_rounding
from vomstudio.registration.results import (
    AdditionalPoint,
    DeterminedParameters,
    ModelPlacement,
    PointResidual,
    RotationError,
    RotationError95,
    WeakestAxis,
)
from vomstudio.registration.rotation_uncertainty import turn_findings
from vomstudio.registration.similarity import (
    Similarity,
    fit_similarity,
    is_nearly_collinear,
    jacobian,
)
from vomstudio.registration.similarity_observation import SimilarityObservation
from vomstudio.registration.warnings import (
    blunder_findings,
    bowing_findings,
    error_findings,
    fit_findings,
    redundancy_findings,
    suspect_findings,
)

_Z95 = 1.959963984540054
# One-sigma error above which a rotation or the relative scale is undetermined.
_MAX_ROTATION_SIGMA_RAD = np.radians(30.0)
_MAX_SCALE_SIGMA = 0.5
# Minimum component of a free direction.
_MIN_COMPONENT = 0.05
_MIN_IMPROVEMENT = 0.8
# Limits of one-sigma errors, metres or rad; the limits for user input are narrower.
_ERROR_LIMITS = 1e-9, 1e9
# Minimum distance of points from their line, as a multiple of their stated or estimated error.
# Noise alone gives 1.4; with four points it gives 10 in one of thousands of sets.
_MIN_LINE_OFFSET_STATED, _MIN_LINE_OFFSET_ESTIMATED, _MIN_POINTS_OFF_LINE = 6.0, 10.0, 4


def place(
    kinds: Sequence[ObservationKind],
    check: Points | None = None,
    extent: FloatArray | None = None,
    *,
    up: FloatArray | None = None,
    is_doubted: bool = False,
) -> ModelPlacement:
    """Register a model by all observations.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    check : Points, optional
        Check points, which do not affect the result.
    extent : (n, 3) array, optional
        Points distributed over the model; by default the points of the observations.
    up : (3,) array, optional
        Up direction in the frame of the model.
    is_doubted : bool
        Whether an earlier finding must be corrected before further measurements.

    Raises
    ------
    GeometryError
        If no observations are given, or only points that are too few or collinear; or if all points
        are equal or an error is out of range.
    """
    kinds = [kind for kind in kinds if len(kind.labels)]
    if not kinds and check is not None and len(check.labels):
        raise GeometryError(Finding("control.all-check", count=len(check.labels)))
    points = next((kind for kind in kinds if isinstance(kind, Points)), None)
    _require_valid_values(kinds)
    if points is not None and len(kinds) == 1:
        _require_enough_points(points)
    centre, size = _extent(kinds, extent)
    # An error common to all readings must not make single readings appear wrong.
    contradiction, consistent_kinds = check_fixed_scale(kinds, centre, size)
    north_turns, corrected_kinds = estimate_north_errors(consistent_kinds, centre, size)
    result = widen_by_likelihood(corrected_kinds, adjust(corrected_kinds, centre, size), centre)
    result = add_rounding(corrected_kinds, result, centre, size)
    determined_parameters = _determined_parameters(result, corrected_kinds)
    mirrors = mirror_findings(points)
    blunders, leave_one_out_results = _find_outliers(
        corrected_kinds, result, centre, size, is_mirrored=bool(mirrors)
    )
    control = _residuals(points, result.fit)
    residual_share = _residual_share(points, control)
    checked_residuals = _residuals(check, result.fit)
    rotation, rotation95 = _rotation_errors(result, determined_parameters)
    scale95 = (
        _Z95 * float(np.sqrt(result.covariance[3, 3])) if determined_parameters.scale else None
    )
    named_causes = [
        *(
            suspect_findings(leave_one_out_results)
            or blunder_findings(corrected_kinds, blunders, result, centre, size)
        ),
        *mirrors,
        *upside_down_findings(result.fit.rotation, up, None if mirrors else points),
    ]
    is_doubted = is_doubted or bool(named_causes)
    warnings = [
        *named_causes,
        *fit_findings(result, kinds),
        *([] if contradiction is None else [contradiction.finding]),
        *disagreement_findings(corrected_kinds, centre, size),
        *(north.finding for north in north_turns),
        *redundancy_findings(control, checked_residuals, points),
        *error_findings(
            rotation,
            scale95,
            determined_parameters,
            points,
            is_named=is_doubted,
            fraction=residual_share,
        ),
        *turn_findings(result.rotation),
        *bowing_findings(
            _bowing(points, check, {blunder.label for blunder in blunders}, result.fit, extent)
        ),
    ]
    shape = _shape(extent, result.fit)
    return ModelPlacement(
        matrix=_matrix(result.fit),
        scale=result.fit.scale,
        control=control,
        check=checked_residuals,
        rms_control_m=_rms(control),
        rms_check_m=_rms(checked_residuals),
        rotation_error_deg=rotation,
        rotation_error_95_deg=rotation95,
        scale_error_95=scale95,
        worth_adding=_best_additional_point(result, points, extent, determined_parameters),
        known=determined_parameters,
        blunders=tuple(blunders),
        without=tuple(leave_one_out_results),
        warnings=tuple(warnings),
        covariance=tuple(tuple(row) for row in result.covariance.tolist()),
        centre=(float(result.centre[0]), float(result.centre[1]), float(result.centre[2])),
        reach_m=shape[0],
        normal=shape[1],
        observations=tuple(
            ObservationGroup(kind_name(kind), tuple(map(str, kind.labels))) for kind in kinds
        ),
    )


def place_robustly(
    kinds: Sequence[ObservationKind],
    check: Points | None = None,
    extent: FloatArray | None = None,
    *,
    up: FloatArray | None = None,
    is_doubted: bool = False,
) -> ModelPlacement:
    """Register a model without outliers, and report them.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    check : Points, optional
        Check points.
    extent : (n, 3) ndarray, optional
        Points of the model.
    up : (3,) ndarray, optional
        Up direction in the frame of the model.
    is_doubted : bool, optional
        See `place`.

    Returns
    -------
    ModelPlacement

    Raises
    ------
    GeometryError
        See `place`.
    """
    first_placement = place(kinds, check, extent, up=up, is_doubted=is_doubted)
    if not first_placement.blunders:
        return first_placement
    labels = [blunder.label for blunder in first_placement.blunders]
    inlier_kinds, inlier_check = exclude_labels(kinds, check, labels)
    placement = place(inlier_kinds, inlier_check, extent, up=up, is_doubted=is_doubted)
    finding = Finding(
        "registration.left-out", labels=[blunder.text() for blunder in first_placement.blunders]
    )
    return replace(
        placement,
        blunders=(*first_placement.blunders, *placement.blunders),
        warnings=(finding, *placement.warnings),
    )


def _find_outliers(
    kinds: Sequence[ObservationKind],
    result: Adjustment,
    centre: FloatArray,
    size: float,
    *,
    is_mirrored: bool,
) -> tuple[list[Blunder], list[LeaveOneOut]]:
    """Return the blunders and, for few directions, the placement without each direction."""
    # Mirrored points do not fit at all, but no single point is wrong.
    blunders = [] if is_mirrored else find_blunders(kinds, result, centre, size)
    leave_one_out_results = leave_one_out(kinds, result, centre, size)
    if leave_one_out_results and leave_one_out_results[0].suspect:
        blunders = [
            Blunder(leave_one_out_results[0].label, None, None, leave_one_out_results[0].error_deg)
        ]
    return blunders, leave_one_out_results


def _matrix(fit: Similarity) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3] = fit.scale * fit.rotation
    matrix[:3, 3] = fit.translation
    return matrix


def _shape(
    extent: FloatArray | None, fit: Similarity
) -> tuple[float | None, tuple[float, float, float] | None]:
    """Return the distance from the centre of the model to its edge, and its mean normal.

    Both are None if `extent` contains too few points.
    """
    if extent is None or len(extent) < MIN_BOWING_POINTS:
        return None, None
    _, axes, edge_distance = model_shape(fit(extent))
    x, y, z = (float(v) for v in axes[2])
    return edge_distance, (x, y, z)


def _require_enough_points(points: Points) -> None:
    if len(points.labels) < 3:
        fit_similarity(points.model, points.world)
    is_collinear = is_nearly_collinear(points.world) or is_nearly_collinear(points.model)
    if is_collinear and not _is_rotation_determined(points):
        raise GeometryError(Finding("control.collinear"))


def _require_valid_values(kinds: Sequence[ObservationKind]) -> None:
    """Raise GeometryError if all points are equal, or if errors are out of range."""
    for kind in kinds:
        if isinstance(kind, Points) and len(kind.labels) > 1:
            for positions in (kind.world, kind.model):
                if float(np.ptp(positions, axis=0).max()) <= 1e-12 * float(np.abs(positions).max()):
                    raise GeometryError(Finding("control.one-place"))
        sigma = np.asarray(getattr(kind, "sigma", ()), np.float64)
        is_wrong = np.isfinite(sigma) & ~((sigma >= _ERROR_LIMITS[0]) & (sigma <= _ERROR_LIMITS[1]))
        if is_wrong.any() and not isinstance(kind, SimilarityObservation | FixedScale):
            finding = check_error(float(sigma[is_wrong][0]))
            assert finding is not None
            raise GeometryError(finding, field=kind.labels[int(np.argwhere(is_wrong)[0, 0])])


def _is_rotation_determined(points: Points) -> bool:
    """Return whether nearly collinear points determine the rotation about their line."""
    n = len(points.labels)
    try:
        fit = fit_similarity(points.model, points.world)
    except GeometryError:
        return False
    sigma = points.total_sigma(fit)
    if np.isfinite(sigma).all():
        min_distance = _MIN_LINE_OFFSET_STATED * float(np.sqrt((sigma**2).mean()))
    elif n >= _MIN_POINTS_OFF_LINE:
        squares = float(((fit(points.model) - points.world) ** 2).sum())
        min_distance = _MIN_LINE_OFFSET_ESTIMATED * float(np.sqrt(squares / (3 * n - 7)))
    else:
        return False
    distance = [
        float(np.linalg.svd(p - p.mean(axis=0), compute_uv=False)[1]) / np.sqrt(n)
        for p in (points.world, fit(points.model))
    ]
    return bool(min(distance) > min_distance)


def _extent(
    kinds: Sequence[ObservationKind], extent: FloatArray | None
) -> tuple[FloatArray, float]:
    """Return the centre (1, 3) of the model, and the typical distance of the model from it."""
    positions = [extent] if extent is not None and len(extent) else []
    if not positions:
        for kind in kinds:
            positions += [
                value
                for name in ("model", "first", "second")
                if isinstance(value := getattr(kind, name, None), np.ndarray)
                and value.ndim == 2
                and (isinstance(kind, Points) or name != "model")
            ]
    fitted_kinds = [kind for kind in kinds if isinstance(kind, SimilarityObservation)]
    if not positions and fitted_kinds:
        start = fitted_kinds[0].start
        return start.inverse(fitted_kinds[0].rotation_centre[None]), fitted_kinds[
            0
        ].size / start.scale
    if not positions:
        return np.zeros((1, 3)), 1.0
    all_positions = np.concatenate(positions)
    centre = all_positions.mean(axis=0, keepdims=True)
    size = float(np.sqrt(((all_positions - centre) ** 2).sum(axis=1).mean()))
    return centre, size if size > 0 else 1.0


# --- determined parameters --------------------------------------------------------------------
def _determined_parameters(
    result: Adjustment, kinds: Sequence[ObservationKind]
) -> DeterminedParameters:
    free_parameters = result.null_space
    sigma = np.sqrt(np.maximum(np.diag(result.covariance), 0.0))
    tilt = float(np.sqrt(max(np.linalg.eigvalsh(result.covariance[:2, :2])[-1], 0.0)))
    # The prior from upright photos does not determine the vertical; other observations must do so.
    priors = [float(kind.sigma[0, 0]) for kind in kinds if isinstance(kind, PhotoUpright)]
    max_tilt = sum(sigma_rad**-2 for sigma_rad in (_MAX_ROTATION_SIGMA_RAD, *priors)) ** -0.5

    def is_determined(*rows: int) -> bool:
        return not free_parameters.shape[1] or bool(
            np.linalg.norm(free_parameters[list(rows)], axis=1).max() < _MIN_COMPONENT
        )

    # The azimuth of an inclined line determines north if the vertical is known.
    is_north_determined = (
        is_determined(2) or result.information[2, 2] > 1.0 / _MAX_ROTATION_SIGMA_RAD**2
    )
    return DeterminedParameters(
        north=bool(is_north_determined and sigma[2] < _MAX_ROTATION_SIGMA_RAD),
        vertical=is_determined(0, 1) and bool(tilt < max_tilt),
        scale=is_determined(3) and bool(sigma[3] < _MAX_SCALE_SIGMA),
        position=is_determined(4, 5, 6),
    )


def _rotation_errors(
    result: Adjustment, known_parameters: DeterminedParameters
) -> tuple[RotationError, RotationError95]:
    free_axes = result.null_space[:3]
    is_undetermined = (
        np.linalg.norm(free_axes, axis=1) > _MIN_COMPONENT
        if free_axes.shape[1]
        else np.zeros(3, bool)
    )
    if known_parameters.north:
        is_undetermined[2] = False

    def axis_errors(covariance: FloatArray, scale_factor: float) -> list[float | None]:
        sigma = np.degrees(np.sqrt(np.maximum(np.diag(covariance)[:3], 0.0)))
        return [
            None if is_undetermined_axis else scale_factor * float(s)
            for s, is_undetermined_axis in zip(sigma, is_undetermined, strict=True)
        ]

    if is_undetermined.any() or not (known_parameters.north and known_parameters.vertical):
        axis, worst_axis = _free_axis(result), None
    else:
        values, axes = np.linalg.eigh(result.rotation)
        axis, worst_axis = axes[:, -1], _Z95 * float(np.degrees(np.sqrt(max(values[-1], 0.0))))
    line = Line.from_vector(axis)
    east, north, up = axis_errors(result.plain_covariance, 1.0)
    east95, north95, up95 = axis_errors(result.covariance, _Z95)
    weakest = WeakestAxis(line.trend_deg, line.plunge_deg, worst_axis)
    return RotationError(up, east, north), RotationError95(up95, east95, north95, weakest)


def _free_axis(result: Adjustment) -> FloatArray:
    """Return the axis (3,) about which the rotation is least determined."""
    free_axes = result.null_space[:3]
    if free_axes.shape[1]:
        u, s, _ = np.linalg.svd(free_axes)
        if s[0] > _MIN_COMPONENT:
            return np.asarray(u[:, 0], np.float64)
    return np.asarray(np.linalg.eigh(result.rotation)[1][:, -1], np.float64)


def _best_additional_point(
    result: Adjustment,
    points: Points | None,
    extent: FloatArray | None,
    known_parameters: DeterminedParameters,
) -> AdditionalPoint | None:
    """Return the best position for an equally accurate point at the edge of the model.

    Returns None if a parameter is undetermined, or if no point would improve the rotation much.
    """
    if points is None or not known_parameters.all:
        return None
    extent_points = points.model if extent is None or not len(extent) else extent
    low, high = result.fit(extent_points).min(axis=0), result.fit(extent_points).max(axis=0)
    centre = (low + high) / 2
    corners = [np.where(corner_index, high, low) for corner_index in np.ndindex(2, 2, 2)]
    for axis in range(3):
        corners += [np.where(np.arange(3) == axis, end, centre) for end in (low, high)]
    point_rows = slice(3 * len(points.labels))
    squares = result.error[point_rows].reshape(-1, 3) ** 2
    if result.rows.axes is not None:
        squares = np.einsum(
            "nji,nj->ni", result.rows.axes[point_rows].reshape(-1, 3, 3) ** 2, squares
        )
    sigma = np.sqrt(squares.mean(axis=0))
    covariance = result.covariance
    error_before_deg = _worst_error(covariance[:3, :3])
    best_addition: tuple[float, FloatArray] | None = None
    for corner in corners:
        design = jacobian(corner - result.centre)
        covariance_product = covariance @ design.T
        variances = design @ covariance_product + np.diag(sigma**2)
        # Points that fit exactly have a singular scatter matrix.
        inverse = np.linalg.pinv(variances, hermitian=True)
        error_after_deg = _worst_error(
            (covariance - covariance_product @ inverse @ covariance_product.T)[:3, :3]
        )
        if best_addition is None or error_after_deg < best_addition[0]:
            best_addition = error_after_deg, corner
    if best_addition is None or not best_addition[0] < _MIN_IMPROVEMENT * error_before_deg:
        return None
    x, y, z = (float(v) for v in best_addition[1])
    return AdditionalPoint(x, y, z, error_before_deg, best_addition[0])


def _worst_error(rotation: FloatArray) -> float:
    """Return the 95 % error about the weakest axis, in degrees."""
    largest_variance = float(np.linalg.eigvalsh(rotation)[-1])
    return _Z95 * float(np.degrees(np.sqrt(max(largest_variance, 0.0))))


# --- residuals --------------------------------------------------------------------------------
def _residuals(points: Points | None, fit: Similarity) -> tuple[PointResidual, ...]:
    if points is None or not len(points.labels):
        return ()
    return tuple(
        PointResidual(label, dx, dy, dz, float(np.linalg.norm([dx, dy, dz])))
        for label, (dx, dy, dz) in zip(
            points.labels, (fit(points.model) - points.world).tolist(), strict=True
        )
    )


def _bowing(
    control: Points | None,
    check: Points | None,
    outliers: set[str],
    fit: Similarity,
    extent: FloatArray | None,
) -> Bowing | None:
    """Estimate the bowing from control and check points, excluding outliers.

    Returns None if the points do not determine it.
    """
    point_sets = [
        points for points in (control, check) if points is not None and len(points.labels)
    ]
    if not point_sets:
        return None
    is_inlier = np.array(
        [label not in outliers for points in point_sets for label in points.labels]
    )
    model, world, sigma = (
        np.concatenate(arrays)[is_inlier]
        for arrays in zip(
            *((item.model, item.world, item.total_sigma(fit)) for item in point_sets), strict=True
        )
    )
    placed_extent = None if extent is None or not len(extent) else fit(extent)
    return fit_bowing(world, fit(model) - world, sigma, placed_extent)


def _rms(points: Sequence[PointResidual]) -> float | None:
    return float(np.sqrt(np.mean([point.error_m**2 for point in points]))) if points else None


def _residual_share(points: Points | None, residuals: Sequence[PointResidual]) -> float:
    """Return the RMS residual of points as a share of their extent."""
    rms = _rms(residuals)
    if points is None or rms is None:
        return 0.0
    extent = float(np.sqrt(((points.world - points.world.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return rms / extent if extent > 0.0 else 0.0


def pairs(
    model: FloatArray,
    world: FloatArray,
    sigma_m: FloatArray | None,
    labels: Sequence[str],
    mask: FloatArray,
    *,
    click_sigma_m: float | None = None,
) -> Points:
    """Convert the selected pairs of points to observations.

    Parameters
    ----------
    model, world : (n, 3) ndarray
    sigma_m : (n, 3) ndarray or None
        One-sigma errors of `world`, or None if they are not stated.
    labels : sequence of str
    mask : (n,) ndarray
        Mask of the selected points.
    click_sigma_m : float, optional
        One-sigma error of each coordinate of `model`, metres.

    Returns
    -------
    Points
    """
    sigma = np.full(world.shape, np.nan) if sigma_m is None else sigma_m
    rows = np.flatnonzero(mask)
    click_error_m = np.full(len(rows), click_sigma_m) if click_sigma_m else None
    return Points(
        [labels[int(i)] for i in rows],
        model[rows],
        world[rows],
        sigma[rows],
        click_error_m=click_error_m,
    )


def register_points(
    model: FloatArray,
    world: FloatArray,
    sigma_m: FloatArray | None = None,
    check: BoolArray | None = None,
    labels: Sequence[str] | None = None,
    *,
    click_sigma_m: float | None = None,
    scale: float | None = None,
    is_robust: bool = False,
) -> ModelPlacement:
    """Register a model by pairs of points.

    Parameters
    ----------
    model, world : (n, 3) array
        Points on the model, and the same points in the World frame, metres.
    sigma_m : (n, 3) array, optional
        One-sigma errors of the World coordinates; by default equal errors, estimated from the
        residuals.
    check : (n,) array of bool, optional
        Mask of the check points, which do not affect the result.
    labels : sequence of str, optional
    click_sigma_m : float, optional
        One-sigma error of each coordinate of the points on the model, metres, which is added to
        `sigma_m`. If None, 0 is assumed, which is reported in a finding.
    scale : float, optional
        Fixed scale, metres per unit of the model.
    is_robust : bool
        Whether to exclude outliers.

    Raises
    ------
    GeometryError
        If there are fewer than three control points, or they are collinear.
    """
    is_check = np.zeros(len(model), bool) if check is None else np.asarray(check, bool)
    names = list(labels) if labels is not None else [str(i + 1) for i in range(len(model))]
    control, check_points = (
        pairs(model, world, sigma_m, names, is_selected, click_sigma_m=click_sigma_m)
        for is_selected in (~is_check, is_check)
    )
    _require_enough_points(control)
    kinds: list[ObservationKind] = [control]
    if scale is not None:
        kinds += fixed_scale(scale, kinds, None)
    placement = (place_robustly if is_robust else place)(kinds, check_points)
    placement = replace(placement, click_sigma_m=click_sigma_m or 0.0)
    if click_sigma_m is not None or sigma_m is None:
        return placement
    return prepend_warnings(placement, [Finding("control.click-error-unknown")])


def prepend_warnings(placement: ModelPlacement, warnings: Sequence[Finding]) -> ModelPlacement:
    """Return a placement with earlier warnings placed before its own.

    Parameters
    ----------
    placement : ModelPlacement
    warnings : sequence of Finding

    Returns
    -------
    ModelPlacement
    """
    return replace(placement, warnings=(*warnings, *placement.warnings))
