"""Linear problem of a registration, and the errors of its rows estimated from residuals.

See `adjustment` for the solution, and `observations` for the rows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.serial_errors import (
    correlate,
    fit_serial_correlation,
    independent_share,
    variance_inflation,
)
from vomstudio.registration.observations import Rows
from vomstudio.registration.scatter import expected_squares, min_variance

# Eigenvalues of the scaled information (unit diagonal) below which a direction is undetermined.
_MIN_EIGENVALUE = 1e-9
# Lower limit of angle errors. With much smaller errors, rounding would determine the common error
# of a compass.
_MIN_ANGLE_ERROR_RAD = 3e-4
# Significance of the F test of whether the error of a group is larger together with other groups
# than alone.
_SIGNIFICANCE = 1e-3
METRE_GROUPS = {"points", "cameras", "lengths"}
RECEIVER_GROUPS = ("points", "cameras")
"""Groups of positions in the order of measurement by a receiver, which may drift."""


def weighted_system(
    rows: Rows, sigma: FloatArray, size: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the weighted system of the rows and the priors of common errors.

    Returns
    -------
    design : (m + k, 7 + k) array
        Derivatives; each row is divided by its error.
    residuals : (m + k,) array
        Residuals divided by their errors.
    column_scales : (7 + k,) array
        Scale factors of the columns.
    """
    k = rows.shared_design.shape[1]
    column_scales = np.concatenate([np.ones(4), np.full(3, size), rows.shared_sigma])
    design = np.vstack(
        [
            np.hstack([rows.design, rows.shared_design]) / sigma[:, None] * column_scales,
            np.hstack([np.zeros((k, 7)), np.eye(k)]),
        ]
    )
    return design, np.concatenate([rows.residuals / sigma, np.zeros(k)]), column_scales


def invert_determined(information: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Invert the determined part of a normal matrix, and return a basis of its null space.

    Parameters
    ----------
    information : (k, k) ndarray
        Normal matrix.

    Returns
    -------
    inverse : (k, k) ndarray
    null_space : (k, j) ndarray
    """
    has_information = np.diag(information) > 0.0
    if not has_information.all():
        # Planes and lines alone determine neither scale nor position.
        n, informative_rows = len(has_information), np.ix_(has_information, has_information)
        reduced_inverse, reduced_null_space = (
            invert_determined(information[informative_rows])
            if has_information.any()
            else (np.zeros((0, 0)),) * 2
        )
        inverse, null_space = (
            np.zeros((n, n)),
            np.zeros((n, reduced_null_space.shape[1] + n - int(has_information.sum()))),
        )
        inverse[informative_rows] = reduced_inverse
        null_space[has_information, : reduced_null_space.shape[1]] = reduced_null_space
        null_space[~has_information, reduced_null_space.shape[1] :] = np.eye(
            n - int(has_information.sum())
        )
        return inverse, null_space
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scale = np.where(scale < 1e-140, 1.0, scale)
    values, axes = np.linalg.eigh(information / np.outer(scale, scale))
    is_determined = values > _MIN_EIGENVALUE
    if is_determined.all():
        return (axes / values) @ axes.T / np.outer(scale, scale), np.zeros((len(scale), 0))
    null_space = (axes / scale[:, None])[:, ~is_determined]
    null_space, _ = np.linalg.qr(null_space)
    projection = np.eye(len(information)) - null_space @ null_space.T
    projected_information = projection @ information @ projection
    # Invert in the determined subspace, free of the other parameters.
    basis = np.linalg.svd(projection)[0][:, : int(is_determined.sum())]
    inverse = (
        basis @ np.linalg.pinv(basis.T @ projected_information @ basis, hermitian=True) @ basis.T
    )
    return inverse, null_space


def max_variance_ratio(dof: float, separate_dof: float) -> float:
    """Return the maximum ratio of a group's joint to its separate variance due to chance.

    Parameters
    ----------
    dof, separate_dof : float
        Degrees of freedom of both variances.

    Returns
    -------
    float
    """
    from scipy.stats import f

    return float(f.isf(_SIGNIFICANCE, dof, separate_dof))


def estimate_errors(
    rows: Rows,
    sigma: FloatArray,
    size: float,
    unstated_names: Sequence[str],
    separate_variances: Mapping[str, tuple[float, float]],
    separate_groups: set[str],
) -> tuple[FloatArray, dict[str, float]]:
    """Estimate the errors of groups whose errors are not stated.

    Parameters
    ----------
    rows : Rows
    sigma : (m,) array
        Current errors.
    size : float
        Size of the model, metres.
    unstated_names : sequence of str
        Groups whose errors are estimated.
    separate_variances : mapping
        Variance and redundancy of each group, estimated from the group alone.
    separate_groups : set of str
        Groups that keep the error estimated from the group alone. Groups whose joint estimate
        exceeds it significantly are added to the set.

    Returns
    -------
    sigma : (m,) array
    redundancy_by_group : dict
        Redundancy of each unstated group.
    """
    design, residuals, _ = weighted_system(rows, sigma, size)
    inverse, _ = invert_determined(design.T @ design)
    residuals = remove_shared_errors(design, residuals, inverse, len(sigma))
    leverage = np.einsum("ij,jk,ik->i", design, inverse, design)[: len(sigma)]
    groups = np.array(rows.groups)
    is_unknown = ~np.isfinite(rows.sigma)
    errors, redundancy_by_group = sigma.copy(), {}
    for name in unstated_names:
        mask = is_unknown & (groups == name)
        dof = float(mask.sum() - leverage[mask].sum())
        redundancy_by_group[name] = dof
        if dof >= 0.5:
            squares = float((residuals[: len(sigma)][mask] ** 2).sum())
            variance = float(sigma[mask][0] ** 2) * squares / dof
            has_shared_angle_error = rows.shared_design.shape[1] and name not in METRE_GROUPS
            min_error = _MIN_ANGLE_ERROR_RAD if has_shared_angle_error else 1e-12 * size
            separate_variance, separate_redundancy = separate_variances.get(name, (np.inf, dof))
            if variance > separate_variance * max_variance_ratio(dof, separate_redundancy):
                separate_groups.add(name)
            if name in separate_groups:
                variance, redundancy_by_group[name] = separate_variance, separate_redundancy
            errors[mask] = np.sqrt(max(variance, min_error**2))
    return errors, redundancy_by_group


def remove_shared_errors(
    design: FloatArray, residuals: FloatArray, inverse: FloatArray, m: int
) -> FloatArray:
    """Return the residuals without the part explained by common errors.

    Parameters
    ----------
    design : ndarray
        Derivatives of the weighted system.
    residuals : ndarray
        Residuals of the weighted system.
    inverse : ndarray
        Inverse of the normal matrix.
    m : int
        Number of observations; the other rows are priors of common errors.

    Returns
    -------
    ndarray
        Residuals of all rows.
    """
    k = len(residuals) - m
    if not k:
        return residuals
    shared_errors = (inverse @ (design.T @ residuals))[-k:]
    remaining_residuals = residuals - design[:, -k:] @ shared_errors
    return np.asarray(remaining_residuals, np.float64)


def estimate_drift(rows: Rows, design: FloatArray, residuals: FloatArray) -> dict[str, float]:
    """Estimate the correlation of the errors of adjacent rows in each table of positions.

    Points and camera positions are in the order of their table, which is assumed to be the order of
    measurement by the receiver. Correlations that chance explains are omitted.

    Parameters
    ----------
    rows : Rows
    design : ndarray
        Derivatives of the weighted system.
    residuals : ndarray
        Residuals of the weighted system.

    Returns
    -------
    dict
        Correlation, by group ("points" or "cameras").
    """
    correlations = {}
    for group in RECEIVER_GROUPS:
        group_rows = np.flatnonzero(np.array(rows.groups) == group)
        if len(group_rows):
            axis_values = (
                _project_to_axes(rows, group_rows, design),
                _project_to_axes(rows, group_rows, residuals),
            )
            correlations[group] = fit_serial_correlation(*axis_values)
    return {group: rho for group, rho in correlations.items() if rho > 0.0}


def _project_to_axes(rows: Rows, selected_rows: IntArray, values: FloatArray) -> FloatArray:
    """Return the weighted values (n, 3, ...) of the rows of points along east, north and up."""
    values_by_axis = values[selected_rows].reshape(-1, 3, *values.shape[1:])
    if rows.axes is None:
        return values_by_axis
    return np.asarray(
        np.einsum("nji,nj...->ni...", rows.axes[selected_rows].reshape(-1, 3, 3), values_by_axis)
    )


def _correlated_design(rows: Rows, design: FloatArray, drift: Mapping[str, float]) -> FloatArray:
    """Return the weighted derivatives multiplied by the correlations of their errors."""
    result = design.copy()
    for group, rho in drift.items():
        group_rows = np.flatnonzero(np.array(rows.groups) == group)
        correlated_values = correlate(_project_to_axes(rows, group_rows, design), rho)
        if rows.axes is not None:
            correlated_values = rows.axes[group_rows].reshape(-1, 3, 3) @ correlated_values
        result[group_rows] = correlated_values.reshape(len(group_rows), -1)
    return result


def estimate_covariance(
    rows: Rows,
    design: FloatArray,
    residuals: FloatArray,
    inverse: FloatArray,
    drift: Mapping[str, float],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Estimate the covariance of the parameters from the residuals.

    The parts of a group have separate variances, which are unbiased quadratic estimates independent
    of the similarity (Rao's MINQUE). With the projection M onto the residuals, the expected sum of
    squares of part g is sum_k tr(M_gk M_kg) v_k.

    Returns
    -------
    share : (m,) array
        Ratio of the error of each row to the error with which it entered the fit.
    spread : array
        Covariance of the parameters.
    factor : array
        Widening of one sigma to the same 95 % limit as Student's t.
    """
    from scipy.stats import norm, t

    m = len(rows.residuals)
    is_unknown = np.concatenate([~np.isfinite(rows.sigma), np.zeros(len(residuals) - m, bool)])
    names = np.array([*rows.parts, *[""] * (len(residuals) - m)])
    parts = [
        np.flatnonzero(is_unknown & (names == name)) for name in dict.fromkeys(names[is_unknown])
    ]
    correlated_design = _correlated_design(rows, design, drift)
    fixed_covariance = inverse @ (design[~is_unknown].T @ design[~is_unknown])
    responses = [inverse @ (design[part].T @ design[part]) for part in parts]
    dof = np.array(
        [len(part) - np.trace(response) for part, response in zip(parts, responses, strict=True)]
    )
    fraction = np.ones(m)
    covariance = inverse @ (design[~is_unknown].T @ correlated_design[~is_unknown]) @ inverse
    variance_of_variances = np.zeros(len(inverse))
    variances = np.ones(len(parts))
    if parts and (dof > 0.1).all():
        system = expected_squares(responses, [len(part) for part in parts])
        squares = np.array([float((residuals[part] ** 2).sum()) for part in parts])
        squares -= [float(np.trace(response @ fixed_covariance)) for response in responses]
        variances = np.linalg.lstsq(system, squares, rcond=None)[0]
        for group_rows in _parts_by_group(rows, parts).values():
            pooled = max(float(squares[group_rows].sum() / dof[group_rows].sum()), 0.0)
            variances[group_rows] = np.maximum(
                variances[group_rows], min_variance(pooled, dof[group_rows])
            )
    error_factors = np.ones(m) if rows.error_factors is None else rows.error_factors
    for g, response, v, f in zip(parts, responses, variances, dof, strict=True):
        independent_fraction = independent_share(drift.get(rows.groups[g[0]], 0.0))
        variance = v * variance_inflation(
            response, inverse @ (design[g].T @ correlated_design[g]), len(g)
        )
        fraction[g] = np.sqrt(variance) * error_factors[g]
        variance_factors = error_factors[g][:, None] ** 2
        part = variance * (
            inverse @ ((design[g] * variance_factors).T @ correlated_design[g]) @ inverse
        )
        covariance = covariance + part
        variance_of_variances += np.diag(part) ** 2 / max(float(f) * independent_fraction, 1.0)
    # Degrees of freedom of a sum of estimated variances (Satterthwaite).
    total_variances = np.maximum(np.diag(covariance), 1e-300)
    effective_dof = np.clip(
        total_variances**2 / np.maximum(variance_of_variances, 1e-300), 1.0, 1e9
    )
    return fraction, covariance, t.ppf(0.975, effective_dof) / norm.ppf(0.975)


def _parts_by_group(rows: Rows, parts: Sequence[IntArray]) -> dict[str, FloatArray]:
    """Return the indices of the parts of each group."""
    groups: dict[str, list[int]] = {}
    for index, part in enumerate(parts):
        groups.setdefault(rows.groups[part[0]], []).append(index)
    return {name: np.array(rows) for name, rows in groups.items()}
