"""Errors that follow each other, as those of a receiver that drifts while photos are taken.

The correlation of neighbours is that of a first-order autoregression, by restricted maximum
likelihood (Cooper & Thompson 1977, Biometrika 64, 625): what a fit has taken out of the residuals
makes them look less alike than the errors are, and the likelihood of the residuals knows that.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray

FEWEST = 10
_TRIED = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 0.94])
_FINER = (0.1, 0.05, 0.02)
_MOST = 0.98
# Of the error of a coordinate: smaller residuals are rounding, whose order says nothing.
_ROUNDING = 1e-6
# What a fit takes out is at most this many times what it leaves, or nothing can be told.
_MOST_TAKEN = 25.0
# Twice the gain of the logarithm of the likelihood that chance reaches in one of a hundred sets of
# independent errors (chi squared with one degree of freedom, one side).
_SURE = 5.41


def correlation_of(moves: FloatArray, misses: FloatArray) -> float:
    """Of the errors of neighbours, 0 where that is no more than chance or they are too few.

    moves : (n, d, k) derivatives of d coordinates by k unknowns, in order; misses : (n, d), both
    divided by the error of their coordinate
    """
    n = len(misses)
    if n < FEWEST or not np.abs(misses).max() > _ROUNDING:
        return 0.0
    gain = {float(rho): _restricted(moves, misses, rho) for rho in _TRIED}
    best = max(gain, key=lambda rho: gain[rho])
    if best == 0.0:
        return 0.0
    for step in _FINER:
        for rho in (best - step, min(best + step, _MOST)):
            gain[rho] = _restricted(moves, misses, rho)
        best = max(gain, key=lambda rho: gain[rho])
    return best if 2.0 * (gain[best] - gain[0.0]) > _SURE else 0.0


def whitened(values: FloatArray, rho: float) -> FloatArray:
    """(n, ...) in order, made independent where their errors have this correlation."""
    if not rho > 0.0:
        return values
    rest = (values[1:] - rho * values[:-1]) / np.sqrt(1.0 - rho**2)
    return np.concatenate([values[:1], rest])


def correlated(values: FloatArray, rho: float) -> FloatArray:
    """(n, ...) in order, times the matrix of the correlations rho^|i - j|."""
    from scipy.signal import lfilter

    if not rho > 0.0:
        return values
    onward = lfilter([1.0], [1.0, -rho], values, axis=0)
    back = lfilter([1.0], [1.0, -rho], values[::-1], axis=0)[::-1]
    return np.asarray(onward + back - values, np.float64)


def independent_share(rho: float) -> float:
    """How many independent errors, of each of these, tell as much of their variance (Bartlett
    1935, J. R. Stat. Soc. 98, 536)."""
    return (1.0 - rho**2) / (1.0 + rho**2)


def more_taken(own: FloatArray, following: FloatArray, count: int) -> float:
    """By how much a variance is larger than `count` residuals show, since a fit takes more out of
    errors that follow each other. own, following : (k, k) the covariance by the weights of the fit
    times the information of these residuals, and times that with the correlations"""
    alone = count - 2.0 * np.trace(own) + np.trace(own @ own)
    left = count - 2.0 * np.trace(following) + np.trace(following @ own)
    return float(np.clip(alone / max(left, 1e-300), 1.0, _MOST_TAKEN))


def _restricted(moves: FloatArray, misses: FloatArray, rho: float) -> float:
    """The logarithm of the restricted likelihood, but for a constant."""
    n, d, k = moves.shape
    x = whitened(moves, rho).reshape(n * d, k)
    y = whitened(misses, rho).ravel()
    _, sizes, axes = np.linalg.svd(x, full_matrices=False)
    told = sizes > 1e-9 * max(float(sizes[0]), 1e-300)
    left = y - x @ (axes[told].T @ (axes[told] @ (x.T @ y) / sizes[told] ** 2))
    free = n * d - int(told.sum())
    of_errors = d * (n - 1) * np.log(1.0 - rho**2)
    of_unknowns = 2.0 * float(np.log(sizes[told]).sum())
    return -0.5 * float(free * np.log(max(float(left @ left), 1e-300)) + of_errors + of_unknowns)
