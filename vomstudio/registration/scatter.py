"""Errors of coordinates, and of a fitted rotation, from the residuals of a similarity.

Satellite heights are less accurate than horizontal positions, whereas levelled heights are more
accurate. A single error for all coordinates would therefore give a wrong error of the tilt.
Horizontal coordinates and heights have separate errors, as does each axis from
`MIN_POINTS_FOR_AXES` points on. The errors are unbiased quadratic estimates independent of the
similarity (Rao's MINQUE, here with equal prior weights): with the projection M onto the residuals,
the expected sum of squares of group g is sum_k tr(M_gk M_kg) sigma_k^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.serial_errors import (
    correlate,
    fit_serial_correlation,
    independent_share,
    variance_inflation,
)
from vomstudio.registration.similarity import jacobian

MIN_POINTS_FOR_HEIGHTS = 5
MIN_POINTS_FOR_AXES = 12
HEIGHT_ERROR_RATIO = 1.4
"""Assumed ratio of height errors to horizontal errors if there are fewer points.

Satellite heights are 1.5 to 3 times less accurate; this value covers at least 90 % of models with
ratios from 1 to 2.5."""
# Estimates may be negative by chance: lower limit as a share of the pooled variance for few
# points.
_MIN_VARIANCE_SHARE = 0.1
# Confidence from which large residuals replace stated errors.
_CONFIDENCE = 0.95
_MAX_SCALE_ERROR = 0.01


@dataclass(frozen=True, eq=False)
class Scatter:
    """Errors of coordinates and of a similarity.

    Attributes
    ----------
    sigma : (3,) array
        Errors of a coordinate along east, north and up, metres.
    covariance : (7, 7) array
        Covariance of a small rotation about east, north and up (rad), a relative change of scale
        and a translation, as one sigma of a normal distribution with the same 95 % limit as
        Student's t.
    drift : float
        Correlation of the errors of adjacent points; 0 if they are independent or unordered.
    """

    sigma: FloatArray
    covariance: FloatArray
    drift: float = 0.0

    @property
    def rotation(self) -> FloatArray:
        """Covariance (3, 3) of the rotation, in rad²."""
        return self.covariance[:3, :3]

    @property
    def horizontal_sigma(self) -> float:
        """Standard deviation of a horizontal coordinate, in metres."""
        return float(np.sqrt((self.sigma[:2] ** 2).mean()))

    @property
    def worst_rotation_deg(self) -> float:
        """Standard deviation of the rotation about its least certain axis, in degrees."""
        return float(np.degrees(np.sqrt(np.linalg.eigvalsh(self.rotation)[-1])))


def estimate_scatter(
    positions: FloatArray,
    residuals: FloatArray,
    stated_errors: float | FloatArray | None = None,
    *,
    is_ordered: bool = False,
) -> Scatter:
    """Estimate the errors of a least-squares similarity with equal weights.

    Parameters
    ----------
    positions, residuals : (n, 3) array
        At least three points and their residuals in the target frame.
    stated_errors : float, (3,) or (n, 3, 3) array, optional
        One-sigma errors of the coordinates, or covariances of the points. They are replaced by
        estimates from the residuals if these are significantly larger.
    is_ordered : bool
        Whether the points are in the order of measurement, so that receiver drift can be
        detected.
    """
    from scipy.stats import chi2, norm, t

    n = len(positions)
    design = np.array([jacobian(position) for position in positions - positions.mean(axis=0)])
    # The equations are well conditioned in units of the spread of the points.
    size = float(np.sqrt(((positions - positions.mean(axis=0)) ** 2).sum(axis=1).mean()))
    column_scales = np.array([size, size, size, size, 1.0, 1.0, 1.0])
    design = design / column_scales
    inverse = np.linalg.pinv(np.einsum("nik,nil->kl", design, design), hermitian=True)
    information = _information(design, 0.0)
    known_covariances = _covariances(stated_errors, n)
    freedom = float(3 * n - 7)
    if known_covariances is not None:
        roots, weights = _matrix_roots(known_covariances)
        whitened_residuals = np.einsum("nij,nj->ni", weights, residuals)
        if (whitened_residuals**2).sum() * freedom / _expected_square(
            design, inverse, known_covariances
        ) <= chi2.ppf(_CONFIDENCE, freedom):
            rho = (
                fit_serial_correlation(weights @ design, whitened_residuals) if is_ordered else 0.0
            )
            whitened_design = roots @ design
            meat = np.einsum("nik,nil->kl", whitened_design, correlate(whitened_design, rho))
            covariance = inverse @ meat @ inverse / np.outer(column_scales, column_scales)
            sigma = np.sqrt(np.einsum("nii->i", known_covariances) / n)
            return Scatter(sigma, covariance, rho)
    groups = _groups(n)
    variances, degrees_of_freedom = _variances(
        groups, n, inverse, information, (residuals**2).sum(axis=0)
    )
    if known_covariances is not None:
        variances = np.maximum(variances, np.einsum("nii->i", known_covariances) / n)
    is_usable = is_ordered and (variances > 0.0).all()
    rho = fit_serial_correlation(design, residuals / np.sqrt(variances)) if is_usable else 0.0
    next_information = information if rho == 0.0 else _information(design, rho)
    for g in groups if rho > 0.0 else ():
        response, correlated_response = (
            inverse @ item[list(g)].sum(axis=0) for item in (information, next_information)
        )
        variances[list(g)] *= variance_inflation(response, correlated_response, n * len(g))
    degrees_of_freedom = degrees_of_freedom * independent_share(rho)
    fractions = np.array(
        [
            np.diag(inverse @ next_information[list(group)].sum(axis=0) @ inverse)
            * variances[group[0]]
            for group in groups
        ]
    )
    # Degrees of freedom of a sum of estimated variances (Satterthwaite).
    totals = fractions.sum(axis=0)
    item = totals**2 / np.maximum(
        (fractions**2 / np.maximum(degrees_of_freedom, 1.0)[:, None]).sum(axis=0), 1e-300
    )
    factor = t.ppf(0.975, np.clip(item, 1.0, None)) / norm.ppf(0.975)
    return _result(np.sqrt(variances), inverse, next_information, column_scales, factor, drift=rho)


def _covariances(stated_errors: float | FloatArray | None, n: int) -> FloatArray | None:
    """Convert stated errors to covariances (n, 3, 3), or None if an error is unknown."""
    if stated_errors is None:
        return None
    values = np.asarray(stated_errors, np.float64)
    if values.ndim < 3:
        values = np.tile(np.diag(np.broadcast_to(values, 3) ** 2), (n, 1, 1))
    return values if (np.einsum("nii->ni", values) > 0.0).all() else None


def _matrix_roots(covariances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the symmetric square roots (n, 3, 3) of covariances, and their inverses."""
    values, vectors = np.linalg.eigh(covariances)
    sizes = np.sqrt(values)[:, None, :]
    inverse_vectors = np.swapaxes(vectors, 1, 2)
    return (vectors * sizes) @ inverse_vectors, (vectors / sizes) @ inverse_vectors


def _expected_square(
    design: FloatArray, inverse: FloatArray, known_covariances: FloatArray
) -> float:
    """Return the expected weighted sum of squares of the residuals of a fit.

    With equal weights, the residuals of accurate points exceed their own errors. `design` (n, 3, 7)
    contains the derivatives, `inverse` (7, 7) the inverse of their normal matrix, and
    `known_covariances` (n, 3, 3) the covariances.
    """
    weighted_information = np.einsum(
        "nik,nij,njl->kl", design, np.linalg.inv(known_covariances), design
    )
    spread = np.einsum("nik,nij,njl->kl", design, known_covariances, design)
    weighted_inverse = inverse @ np.einsum("nik,nil->kl", design, design)
    return float(
        3 * len(design)
        - 2.0 * np.trace(weighted_inverse)
        + np.trace(inverse @ spread @ inverse @ weighted_information)
    )


def _information(design: FloatArray, rho: float) -> FloatArray:
    """Return the information (3, 7, 7) of each axis with the correlations of its errors."""
    return np.asarray(np.einsum("nik,nil->ikl", design, correlate(design, rho)), np.float64)


def drift_findings(drift: Mapping[str, float]) -> list[Finding]:
    """Return a finding about each table of positions whose errors are correlated.

    Parameters
    ----------
    drift : mapping
        Correlation of adjacent rows, by group ("points" or "cameras").

    Returns
    -------
    list of Finding
    """
    codes = {"points": "control.drift", "cameras": "cameras.drift"}
    return [Finding(codes[group], correlation=rho) for group, rho in drift.items() if rho > 0.0]


def scale_findings(scale_error: float) -> list[Finding]:
    """Return a finding if a registration leaves lengths uncertain.

    Parameters
    ----------
    scale_error : float
        Relative one-sigma error.

    Returns
    -------
    list of Finding
    """
    if not scale_error > _MAX_SCALE_ERROR:
        return []
    return [Finding("registration.weak-scale", error95_percent=196.0 * scale_error)]


def _groups(n: int) -> Sequence[tuple[int, ...]]:
    if n >= MIN_POINTS_FOR_AXES:
        return ((0,), (1,), (2,))
    return ((0, 1), (2,)) if n >= MIN_POINTS_FOR_HEIGHTS else ((0, 1, 2),)


def expected_squares(parts: Sequence[FloatArray], counts: Sequence[int]) -> FloatArray:
    """Return the matrix (k, k) that maps variances of parts to expected squared residuals.

    Parameters
    ----------
    parts : sequence of array
        Covariance of the unknowns times the information of each part, with the weights of the fit.
    counts : sequence of int
        Number of residuals of each part.
    """
    system = np.array([[np.trace(a @ b) for b in parts] for a in parts])
    separate_squares = [count - 2.0 * np.trace(a) for count, a in zip(counts, parts, strict=True)]
    return np.asarray(system + np.diag(separate_squares), np.float64)


def min_variance(pooled_variance: float, degrees_of_freedom: FloatArray) -> FloatArray:
    """Return the lower limits of variances estimated with few degrees of freedom.

    Parameters
    ----------
    pooled_variance : float
        Variance of all groups together.
    degrees_of_freedom : (k,) ndarray
        Degrees of freedom of each variance.

    Returns
    -------
    (k,) ndarray
    """
    return np.asarray(
        _MIN_VARIANCE_SHARE * pooled_variance / np.maximum(degrees_of_freedom / 10.0, 1.0),
        np.float64,
    )


def _expected_squares_matrix(
    groups: Sequence[tuple[int, ...]], n: int, inverse: FloatArray, information: FloatArray
) -> FloatArray:
    """Return the matrix that maps variances of groups to expected squared residuals."""
    parts = [inverse @ information[list(group)].sum(axis=0) for group in groups]
    return expected_squares(parts, [n * len(group) for group in groups])


def _variances(
    groups: Sequence[tuple[int, ...]],
    n: int,
    inverse: FloatArray,
    information: FloatArray,
    squares: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the variances (3,) of the axes, and the degrees of freedom of each group."""
    system = _expected_squares_matrix(groups, n, inverse, information)
    sums = np.array([squares[list(group)].sum() for group in groups])
    dof = np.array(
        [
            n * len(group) - np.trace(inverse @ information[list(group)].sum(axis=0))
            for group in groups
        ]
    )
    pooled_variance = float(squares.sum()) / (3 * n - 7)
    estimates = np.linalg.solve(system, sums) if len(groups) > 1 else np.array([pooled_variance])
    estimates = np.maximum(estimates, min_variance(pooled_variance, dof))
    variances = np.empty(3)
    for group, value in zip(groups, estimates, strict=True):
        variances[list(group)] = value
    if n < MIN_POINTS_FOR_HEIGHTS:
        variances[2] *= HEIGHT_ERROR_RATIO**2
    return variances, np.maximum(dof, 1.0)


def _result(
    sigma: FloatArray,
    inverse: FloatArray,
    information: FloatArray,
    column_scales: FloatArray,
    factor: FloatArray,
    *,
    drift: float,
) -> Scatter:
    meat = np.einsum("i,ikl->kl", sigma**2, information)
    covariance = inverse @ meat @ inverse * np.outer(factor / column_scales, factor / column_scales)
    return Scatter(np.array(sigma, np.float64), covariance, drift)
