"""Serially correlated errors, for example of a drifting receiver during a photo flight.

The errors are modelled as a first-order autoregressive process, whose correlation is estimated by
restricted maximum likelihood (Cooper & Thompson 1977, Biometrika 64, 625). Residuals are less
correlated than errors, because a fit absorbs part of the errors; the restricted likelihood accounts
for this.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray

MIN_RESIDUALS = 10
RHO_GRID = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 0.94])
RHO_STEPS = (0.1, 0.05, 0.02)
MAX_RHO = 0.98
# Relative to the error of a coordinate; smaller residuals are rounding errors.
MAX_ROUNDING = 1e-6
# Maximum ratio of the errors to the residuals of a fit.
MAX_VARIANCE_RATIO = 25.0
# Twice the log-likelihood gain at a significance level of 1 % (chi-square, one-sided).
MIN_DEVIANCE_GAIN = 5.41


def fit_serial_correlation(derivatives: FloatArray, residuals: FloatArray) -> float:
    """Estimate the correlation of the errors of neighbouring measurements.

    Parameters
    ----------
    derivatives : (n, d, k) ndarray
        Derivatives of d coordinates with respect to k unknowns, in measurement order, divided by
        the errors.
    residuals : (n, d) ndarray
        Residuals in the same order, divided by the errors of their coordinates.

    Returns
    -------
    float
        Correlation; 0 if it is not significant, if there are too few measurements, or if the
        residuals are rounding errors.
    """
    n = len(residuals)
    if n < MIN_RESIDUALS or not np.abs(residuals).max() > MAX_ROUNDING:
        return 0.0
    likelihood_by_rho = {
        float(rho): _restricted_log_likelihood(derivatives, residuals, rho) for rho in RHO_GRID
    }
    best_rho = max(likelihood_by_rho, key=lambda rho: likelihood_by_rho[rho])
    if best_rho == 0.0:
        return 0.0
    for step in RHO_STEPS:
        for rho in (best_rho - step, min(best_rho + step, MAX_RHO)):
            likelihood_by_rho[rho] = _restricted_log_likelihood(derivatives, residuals, rho)
        best_rho = max(likelihood_by_rho, key=lambda rho: likelihood_by_rho[rho])
    return (
        best_rho
        if 2.0 * (likelihood_by_rho[best_rho] - likelihood_by_rho[0.0]) > MIN_DEVIANCE_GAIN
        else 0.0
    )


def whiten(values: FloatArray, rho: float) -> FloatArray:
    """Transform serially correlated values so that their errors become independent.

    Parameters
    ----------
    values : (n, ...) ndarray
    rho : float
        Correlation of neighbours.

    Returns
    -------
    (n, ...) ndarray
    """
    if not rho > 0.0:
        return values
    innovations = (values[1:] - rho * values[:-1]) / np.sqrt(1.0 - rho**2)
    return np.concatenate([values[:1], innovations])


def correlate(values: FloatArray, rho: float) -> FloatArray:
    """Multiply serial values by the correlation matrix rho^|i - j|.

    Parameters
    ----------
    values : (n, ...) ndarray
    rho : float
        Correlation of neighbours.

    Returns
    -------
    (n, ...) ndarray
    """
    from scipy.signal import lfilter

    if not rho > 0.0:
        return values
    forward = lfilter([1.0], [1.0, -rho], values, axis=0)
    backward = lfilter([1.0], [1.0, -rho], values[::-1], axis=0)[::-1]
    return np.asarray(forward + backward - values, np.float64)


def independent_share(rho: float) -> float:
    """Return the number of independent errors to which one correlated error is equivalent.

    See Bartlett 1935, J. R. Stat. Soc. 98, 536.

    Parameters
    ----------
    rho : float
        Correlation of neighbours.

    Returns
    -------
    float
    """
    return (1.0 - rho**2) / (1.0 + rho**2)


def variance_inflation(
    projection: FloatArray, correlated_projection: FloatArray, count: int
) -> float:
    """Return the factor by which a fit underestimates the variance of correlated errors.

    A fit absorbs a larger part of the errors if they are serially correlated.

    Parameters
    ----------
    projection : (k, k) ndarray
        Covariance from the weights of the fit, times the information of these residuals.
    correlated_projection : (k, k) ndarray
        The same matrix, including the correlations.
    count : int
        Number of residuals.

    Returns
    -------
    float
        Variance factor, from 1 to `MAX_VARIANCE_RATIO`.
    """
    expected_dof = count - 2.0 * np.trace(projection) + np.trace(projection @ projection)
    correlated_dof = (
        count - 2.0 * np.trace(correlated_projection) + np.trace(correlated_projection @ projection)
    )
    return float(np.clip(expected_dof / max(correlated_dof, 1e-300), 1.0, MAX_VARIANCE_RATIO))


def _restricted_log_likelihood(derivatives: FloatArray, residuals: FloatArray, rho: float) -> float:
    """Return the logarithm of the restricted likelihood up to a constant."""
    n, d, k = derivatives.shape
    x = whiten(derivatives, rho).reshape(n * d, k)
    y = whiten(residuals, rho).ravel()
    _, sizes, axes = np.linalg.svd(x, full_matrices=False)
    is_determined = sizes > 1e-9 * max(float(sizes[0]), 1e-300)
    whitened_residuals = y - x @ (
        axes[is_determined].T @ (axes[is_determined] @ (x.T @ y) / sizes[is_determined] ** 2)
    )
    dof = n * d - int(is_determined.sum())
    log_det_errors = d * (n - 1) * np.log(1.0 - rho**2)
    log_det_unknowns = 2.0 * float(np.log(sizes[is_determined]).sum())
    return -0.5 * float(
        dof * np.log(max(float(whitened_residuals @ whitened_residuals), 1e-300))
        + log_det_errors
        + log_det_unknowns
    )
