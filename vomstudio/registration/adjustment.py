"""Least-squares estimation of a similarity and its covariance from all observations.

The seven parameters of `observations` are estimated by weighted least squares (Gauss-Newton) from
several starts. Errors that are not stated are estimated for each group of rows together with the
similarity (iterated variance components; Foerstner 1979, Z. f. Vermessungswesen 104, 149). Errors
estimated from few rows are widened by Student's t with Satterthwaite's degrees of freedom.
If a group contradicts the others, and the joint estimate of its error significantly exceeds the
estimate from the group alone, the latter is used. Parameters that no observation determines keep
their values from the model file; tilts are kept in preference to rotations about the vertical.
The covariance follows from linear least squares and is valid for rotation errors up to about 20
degrees.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.compass_checks import rotations_from_pairs
from vomstudio.registration.observations import (
    Attitudes,
    Directions,
    FixedScale,
    ObservationKind,
    Points,
    Rows,
    all_rows,
)
from vomstudio.registration.row_errors import (
    METRE_GROUPS,
    estimate_covariance,
    estimate_drift,
    estimate_errors,
    invert_determined,
    max_variance_ratio,
    remove_shared_errors,
    weighted_system,
)
from vomstudio.registration.similarity import Similarity, fit_similarity, is_nearly_collinear
from vomstudio.registration.similarity_observation import SimilarityObservation

_RANDOM_STARTS = 400
_MAX_SELECTED_STARTS = 6
_MAX_ITERATIONS = 60
_STEP_TOLERANCE = 1e-11
# Starts are only compared with each other; only the selected start is iterated to convergence.
_START_STEP_TOLERANCE = 1e-6
_SIGNIFICANCE = 0.99
# Redundancy below which a group does not reveal its error.
_MIN_SEPARATE_REDUNDANCY = 1.5
# Default error of rows without a stated error or redundancy, as a share of the model size or in
# radians.
_DEFAULT_ERROR_SHARE = 0.01
_DEFAULT_ERROR_RAD = np.radians(3.0)
# Difference of costs up to which two results are equally good fits, given chance.
EQUAL_FIT_COST = 9.0
# Residual, in multiples of its error, from which Cauchy's function reduces its weight.
_CAUCHY_SCALE = 3.0
_MIN_START_DISTANCE_RAD = 0.3
# Rotation difference, rad, above which solutions are distinct.
_DISTINCT_ROTATION_RAD = 0.2


@dataclass(frozen=True, eq=False)
class Adjustment:
    """Result of `adjust`.

    Attributes
    ----------
    fit : Similarity
        Similarity from the model to the World frame.
    centre : (3,) array
        Centre of the rotation and of the change of scale, in the World frame.
    covariance : (7, 7) array
        Covariance of a rotation about east, north and up (rad), a relative change of scale and a
        translation (metres), as one sigma of a normal distribution with the same 95 % limit as
        Student's t; zero for undetermined parameters, see `null_space`.
    plain_covariance : (7, 7) array
        The same covariance without widening by Student's t.
    null_space : (7, k) array
        Undetermined directions of the seven parameters, orthonormal in units of the model size.
    rows, sigma, error
        All observations, the one-sigma errors with which they entered the fit, and the one-sigma
        errors estimated from their residuals.
    starts : (kinds + 1,) tuple of int
        First row of each kind, and the end of the last kind.
    assumed_error_groups : tuple of str
        Groups whose error could not be estimated and was set to a default.
    misfit_factor : float
        Ratio of the residuals to the stated errors; 1 if they agree.
    is_ambiguous : bool
        Whether a distinct rotation fits equally well.
    redundancy_by_group : mapping
        Redundancy of each group whose error is not stated.
    drift : mapping
        Correlation of the errors of adjacent table rows, by group ("points", "cameras"). Groups
        with independent errors are omitted.
    common_errors, common_covariance : (k,) and (k, k) array
        Common errors of the rows and their covariance, in the order of `rows.shared_names`.
    """

    fit: Similarity
    centre: FloatArray
    covariance: FloatArray
    plain_covariance: FloatArray
    null_space: FloatArray
    rows: Rows
    sigma: FloatArray
    error: FloatArray
    starts: tuple[int, ...]
    assumed_error_groups: tuple[str, ...]
    misfit_factor: float
    is_ambiguous: bool
    size: float
    redundancy: float
    information: FloatArray
    common_errors: FloatArray
    common_covariance: FloatArray
    redundancy_by_group: Mapping[str, float]
    drift: Mapping[str, float]

    @property
    def rotation(self) -> FloatArray:
        """Covariance (3, 3) of the rotation about east, north and up, in rad²."""
        return self.covariance[:3, :3]


@dataclass(frozen=True, eq=False)
class _Problem:
    """Arguments of `adjust`, and the variances of the groups from `_separate_variances`."""

    kinds: Sequence[ObservationKind]
    centre: FloatArray
    size: float
    separate_variances: Mapping[str, tuple[float, float]]

    def linearise(self, fit: Similarity) -> tuple[Rows, list[int], FloatArray]:
        """Return the rows for a similarity, the first row of each kind, and the centre (3,)."""
        position = fit(self.centre)[0]
        return (*all_rows(self.kinds, fit, position), position)


def adjust(kinds: Sequence[ObservationKind], centre: FloatArray, size: float) -> Adjustment:
    """Estimate the similarity from the model to the World frame.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    centre : (1, 3) array
        Centre of the rotation in the model frame, used if no observation determines the position.
    size : float
        Typical distance of the model from its centre, in the unit of the model.

    Raises
    ------
    GeometryError
        If `kinds` contains no observations.
    """
    if not any(len(kind.labels) for kind in kinds):
        raise GeometryError(Finding("registration.no-observations"))
    offset = _common_origin(kinds)
    kinds = [_shift(kind, offset) for kind in kinds]
    separate_variances = _separate_variances(kinds, centre, size)
    problem = _Problem(kinds, centre, size, separate_variances)
    solutions = [
        _iterate(problem, start)
        for start in _select_robust_solutions(problem, _start_similarities(problem))
    ]
    min_cost = min(cost for _, cost in solutions)
    equal_fits = [fit for fit, cost in solutions if cost <= min_cost + EQUAL_FIT_COST]
    # Among equal fits, prefer the one that tilts the model least, then the one that rotates it
    # least.
    equal_fits.sort(
        key=lambda fit: (round(_tilt_angle(fit.rotation), 3), _rotation_angle(fit.rotation))
    )
    result = _evaluate(problem, equal_fits[0])
    # If the rotation is undetermined, several fits are equal by definition.
    is_rotation_determined = (
        not result.null_space.shape[1] or np.abs(result.null_space[:3]).max() < 1e-6
    )
    has_distinct_fit = any(
        _rotation_angle(equal_fits[0].rotation.T @ fit.rotation) > _DISTINCT_ROTATION_RAD
        for fit in equal_fits
    )
    result = replace(
        _add_scale_error(kinds, result),
        is_ambiguous=bool(is_rotation_determined and has_distinct_fit),
    )
    fit = replace(result.fit, translation=result.fit.translation + offset)
    return replace(result, fit=fit, centre=result.centre + offset)


def _add_scale_error(kinds: Sequence[ObservationKind], result: Adjustment) -> Adjustment:
    """Add the error of a fixed scale to the covariance of a fit.

    The fit itself is unchanged. The covariance of the seven parameters increases by their response
    to the error of the scale, which no observation determines.
    """
    change, error = np.zeros(len(result.rows.residuals)), 0.0
    kinds = [kind for kind in kinds if len(kind.labels)]
    for kind, start, end in zip(kinds, result.starts, result.starts[1:], strict=False):
        if isinstance(kind, SimilarityObservation | FixedScale) and kind.scale_error > 0:
            # All these observations share one scale error.
            change[start:end] = kind.scale_derivative
            error = max(error, kind.scale_error)
    if not error > 0:
        return result
    design, _, column_scales = weighted_system(result.rows, result.sigma, result.size)
    inverse, _ = invert_determined(design.T @ design)
    step = -inverse @ (design[: len(change)].T @ (change / result.sigma))
    response = error * (step * column_scales)[:7]
    added_covariance = np.outer(response, response)
    return replace(
        result,
        covariance=result.covariance + added_covariance,
        plain_covariance=result.plain_covariance + added_covariance,
    )


def _separate_variances(
    kinds: Sequence[ObservationKind], centre: FloatArray, size: float
) -> dict[str, tuple[float, float]]:
    """Estimate the variance of each group without a stated error, using its kind alone.

    Returns the variance and its redundancy by group for points and attitudes, provided that there
    are other kinds.
    """
    kinds = [kind for kind in kinds if len(kind.labels)]
    # A fixed scale applies to each kind.
    fixed_scale = [kind for kind in kinds if isinstance(kind, FixedScale)]
    kinds = [kind for kind in kinds if not isinstance(kind, FixedScale)]
    variances: dict[str, tuple[float, float]] = {}
    for kind in kinds if len(kinds) > 1 else ():
        # Planes have many starts and would take longer than the adjustment.
        if not isinstance(kind, Points | Attitudes) or np.isfinite(kind.sigma).all():
            continue
        adjusted_result = adjust([kind, *fixed_scale], centre, size)
        groups = np.array(adjusted_result.rows.groups)
        is_unknown = ~np.isfinite(adjusted_result.rows.sigma)
        for name, redundancy in adjusted_result.redundancy_by_group.items():
            if redundancy >= _MIN_SEPARATE_REDUNDANCY:
                sigma = adjusted_result.sigma[is_unknown & (groups == name)]
                variances[name] = float(sigma[0] ** 2), redundancy
    return variances


def _shift(kind: ObservationKind, offset: FloatArray) -> ObservationKind:
    if isinstance(kind, Points):
        return replace(kind, world=kind.world - offset)
    if isinstance(kind, SimilarityObservation):
        start = replace(kind.start, translation=kind.start.translation - offset)
        return replace(kind, start=start, rotation_centre=kind.rotation_centre - offset)
    return kind


def _common_origin(kinds: Sequence[ObservationKind]) -> FloatArray:
    """Return a World position (3,) near the points, as an origin that preserves digits."""
    points = [kind.world for kind in kinds if isinstance(kind, Points)]
    points += [
        kind.rotation_centre[None] for kind in kinds if isinstance(kind, SimilarityObservation)
    ]
    return np.round(np.concatenate(points).mean(axis=0)) if points else np.zeros(3)


# --- starts -----------------------------------------------------------------------------------
def _start_similarities(problem: _Problem) -> list[Similarity]:
    from scipy.spatial.transform import Rotation

    kinds, centre = problem.kinds, problem.centre
    for kind in kinds:
        if isinstance(kind, SimilarityObservation):
            return [kind.start]
    points = [kind for kind in kinds if isinstance(kind, Points) and len(kind.labels)]
    model = np.concatenate([k.model for k in points]) if points else np.zeros((0, 3))
    world = np.concatenate([k.world for k in points]) if points else np.zeros((0, 3))
    fixed_scale = _fixed_scale(kinds)
    is_only_kind = sum(not isinstance(kind, FixedScale) for kind in kinds) == 1
    if len(model) >= 3 and (
        is_only_kind or not (is_nearly_collinear(model) or is_nearly_collinear(world))
    ):
        with suppress(GeometryError):
            return [fit_similarity(model, world, scale=fixed_scale)]
    scale = _initial_scale(kinds, model, world) if fixed_scale is None else fixed_scale
    start_rotations = [
        np.eye(3),
        *(rotation for kind in kinds for rotation in _start_rotations(kind)),
    ]
    if len(start_rotations) == 1:
        start_rotations += [*Rotation.random(_RANDOM_STARTS, random_state=0).as_matrix()]
    candidates = []
    for start_rotation in start_rotations:
        if len(model):
            shift = world.mean(axis=0) - scale * start_rotation @ model.mean(axis=0)
        else:
            shift = centre.ravel() - scale * start_rotation @ centre.ravel()
        start = Similarity(scale, start_rotation, shift)
        candidates.append((_cost(problem, start, is_robust=True), start))
    selected_starts = [candidates[0][1]]
    for _, start in sorted(candidates[1:], key=lambda pair: pair[0]):
        # Similar starts converge to the same solution.
        if all(
            _rotation_angle(start.rotation.T @ f.rotation) > _MIN_START_DISTANCE_RAD
            for f in selected_starts
        ):
            selected_starts.append(start)
        if len(selected_starts) > _MAX_SELECTED_STARTS:
            break
    return selected_starts


def _select_robust_solutions(problem: _Problem, starts: Sequence[Similarity]) -> list[Similarity]:
    """Return the robust solutions from several starts, which most observations support.

    With plain least squares, a single strike misread as dip direction can turn a model upside down.
    """
    if len(starts) < 2:
        return list(starts)
    solutions = [_iterate(problem, start, is_robust=True) for start in starts]
    min_cost = min(cost for _, cost in solutions)
    return [fit for fit, cost in solutions if cost <= min_cost + EQUAL_FIT_COST]


def _start_rotations(kind: ObservationKind) -> list[FloatArray]:
    """Return the mean rotation from camera attitudes, or rotations from pairs of directions."""
    if isinstance(kind, Directions):
        return rotations_from_pairs(kind.model, kind.world, is_axial=kind.axial)
    model, world = getattr(kind, "model", None), getattr(kind, "world", None)
    if model is None or world is None or model.ndim != 3 or not len(model):
        return []
    u, _, vt = np.linalg.svd((world @ np.swapaxes(model, 1, 2)).sum(axis=0))
    return [u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt]


def _fixed_scale(kinds: Sequence[ObservationKind]) -> float | None:
    """Return the metres per unit of the model if the scale is fixed, or None."""
    for kind in kinds:
        if isinstance(kind, FixedScale):
            return float(kind.length[0] / np.linalg.norm(kind.second[0] - kind.first[0]))
    return None


def _initial_scale(kinds: Sequence[ObservationKind], model: FloatArray, world: FloatArray) -> float:
    if len(model) >= 2:
        distances = np.linalg.norm(model - model.mean(axis=0))
        if distances > 0:
            return float(np.linalg.norm(world - world.mean(axis=0)) / distances)
    for kind in kinds:
        length = getattr(kind, "length", None)
        if length is not None and len(length):
            return float(np.median(length / np.linalg.norm(kind.second - kind.first, axis=1)))  # type: ignore[attr-defined]
    return 1.0


def _initial_errors(
    rows: Rows, size: float, separate_variances: Mapping[str, tuple[float, float]]
) -> FloatArray:
    """Return the initial errors (m,) of rows, which are the stated errors or defaults.

    A default does not exceed the largest error that the group alone allows.
    """
    metres = np.array([group in METRE_GROUPS for group in rows.groups])
    default_errors = np.where(metres, _DEFAULT_ERROR_SHARE * size, _DEFAULT_ERROR_RAD)
    for name, (variance, redundancy) in separate_variances.items():
        mask = np.array(rows.groups) == name
        maximum = float(np.sqrt(variance * max_variance_ratio(redundancy, redundancy)))
        default_errors[mask] = np.minimum(default_errors[mask], max(maximum, 1e-12 * size))
    return np.where(np.isfinite(rows.sigma), rows.sigma, default_errors)


def _cost(problem: _Problem, fit: Similarity, *, is_robust: bool = False) -> float:
    """Return the sum of squares weighted by initial errors, or of Cauchy's loss if robust."""
    rows, _, _ = problem.linearise(fit)
    squares = (
        rows.residuals / _initial_errors(rows, problem.size * fit.scale, problem.separate_variances)
    ) ** 2
    return float(
        (_CAUCHY_SCALE**2 * np.log1p(squares / _CAUCHY_SCALE**2) if is_robust else squares).sum()
    )


# --- one start --------------------------------------------------------------------------------
def _step(rows: Rows, sigma: FloatArray, size: float, parameter_weights: FloatArray) -> FloatArray:
    """Return the minimum-norm parameter change (7,) that minimises the squares."""
    design, residuals, column_scales = weighted_system(rows, sigma, size)
    inverse, null_space = invert_determined(design.T @ design)
    step = -inverse @ (design.T @ residuals)
    if null_space.shape[1]:
        weighted_null_space = parameter_weights[:, None] * null_space
        step = (
            step
            - null_space
            @ np.linalg.lstsq(weighted_null_space, parameter_weights * step, rcond=None)[0]
        )
    return np.asarray((step * column_scales)[:7], np.float64)


def apply_step(fit: Similarity, step: FloatArray, centre: FloatArray) -> Similarity:
    """Apply a change of the seven parameters to a similarity.

    Parameters
    ----------
    fit : Similarity
    step : (7,) array
        Rotation about the World axes (rad), relative change of scale, and translation.
    centre : (3,) array
        Centre of the rotation and of the change of scale, in the World frame.
    """
    from scipy.spatial.transform import Rotation

    rotation_matrix = Rotation.from_rotvec(step[:3]).as_matrix()
    scale_factor = float(np.exp(np.clip(step[3], -1.0, 1.0)))
    rotation = rotation_matrix @ fit.rotation
    translation = scale_factor * rotation_matrix @ (fit.translation - centre) + centre + step[4:]
    return Similarity(fit.scale * scale_factor, rotation, translation)


def _iterate(
    problem: _Problem, fit: Similarity, *, is_robust: bool = False
) -> tuple[Similarity, float]:
    """Return the solution to which a start converges with initial errors, and its cost."""
    for _ in range(_MAX_ITERATIONS):
        rows, _, position = problem.linearise(fit)
        size = problem.size * fit.scale
        sigma = _initial_errors(rows, size, problem.separate_variances)
        if is_robust:
            sigma = np.hypot(sigma, rows.residuals / _CAUCHY_SCALE)
        step = _step(rows, sigma, size, _parameter_weights(rows))
        length = np.linalg.norm(step[:3])
        if length > 0.7:
            step = step * (0.7 / length)
        fit = apply_step(fit, step, position)
        if np.abs(step[:4]).max() < _START_STEP_TOLERANCE:
            break
    return fit, _cost(problem, fit, is_robust=is_robust)


def _parameter_weights(rows: Rows) -> FloatArray:
    """Return the cost of undetermined changes; tilts cost more than rotations about vertical."""
    weights = np.ones(7 + rows.shared_design.shape[1])
    weights[:2] = 1e3
    return weights


# --- errors -----------------------------------------------------------------------------------
def _evaluate(problem: _Problem, fit: Similarity) -> Adjustment:
    from scipy.stats import chi2

    size, separate_variances = problem.size, problem.separate_variances
    rows, starts, position = problem.linearise(fit)
    sigma = _initial_errors(rows, size * fit.scale, separate_variances)
    groups = np.array(rows.groups)
    unstated_groups = [str(group) for group in dict.fromkeys(groups[~np.isfinite(rows.sigma)])]
    redundancy_by_group: dict[str, float] = {}
    separate_groups: set[str] = set()
    for _ in range(_MAX_ITERATIONS):
        rows, starts, position = problem.linearise(fit)
        previous_sigma = sigma.copy()
        if unstated_groups:
            sigma, redundancy_by_group = estimate_errors(
                rows, sigma, size * fit.scale, unstated_groups, separate_variances, separate_groups
            )
        step = _step(rows, sigma, size * fit.scale, _parameter_weights(rows))
        fit = apply_step(fit, step, position)
        if np.abs(step[:4]).max() < _STEP_TOLERANCE and np.allclose(
            previous_sigma, sigma, rtol=1e-6
        ):
            break
    rows, starts, position = problem.linearise(fit)
    length = size * fit.scale
    design, residuals, column_scales = weighted_system(rows, sigma, length)
    information = design.T @ design
    inverse, null_space = invert_determined(information)
    shared_shifts = -(inverse @ (design.T @ residuals) * column_scales)[7:]
    residuals = remove_shared_errors(design, residuals, inverse, len(rows.residuals))
    rows = replace(rows, residuals=residuals[: len(rows.residuals)] * sigma)
    redundancy = float(len(rows.residuals) - (7 - null_space.shape[1]))
    drift = estimate_drift(rows, design, residuals)
    fraction, spread, factor = estimate_covariance(rows, design, residuals, inverse, drift)
    misfit_factor = 1.0
    if np.isfinite(rows.sigma).any() and redundancy > 0:
        squares = float((residuals**2).sum())
        if squares > chi2.ppf(_SIGNIFICANCE, redundancy):
            misfit_factor = float(np.sqrt(squares / redundancy))
    covariance_diagonal = spread * np.outer(column_scales, column_scales) * misfit_factor**2
    covariance = covariance_diagonal * np.outer(factor, factor)
    assumed_error_groups = tuple(
        name for name in unstated_groups if redundancy_by_group.get(name, 0.0) < 0.5
    )
    return Adjustment(
        fit,
        position,
        covariance[:7, :7],
        covariance_diagonal[:7, :7],
        null_space[:7],
        rows,
        sigma,
        sigma * fraction,
        tuple(starts),
        assumed_error_groups,
        misfit_factor,
        False,
        length,
        redundancy,
        information,
        shared_shifts,
        covariance[7:, 7:],
        redundancy_by_group,
        drift,
    )


def weighted_rows(result: Adjustment) -> tuple[FloatArray, FloatArray]:
    """Return the weighted rows of an adjustment and the covariance of its parameters.

    Returns
    -------
    rows : (m, 7 + k) array
        Derivatives divided by the errors, including the derivatives by common errors.
    covariance : (7 + k, 7 + k) array
        Covariance without widening by Student's t; zero for undetermined parameters.
    """
    design, _, _ = weighted_system(result.rows, result.sigma, result.size)
    inverse, _ = invert_determined(design.T @ design)
    return design[: len(result.sigma)], inverse


def _tilt_angle(rotation: FloatArray) -> float:
    return float(np.arccos(np.clip(rotation[2, 2], -1.0, 1.0)))


def _rotation_angle(rotation: FloatArray) -> float:
    return float(np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0)))
