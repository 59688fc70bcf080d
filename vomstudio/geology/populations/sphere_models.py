"""Bingham and Kent distributions: maximum-likelihood estimates and goodness of fit.

Bingham's distribution (1974, Annals of Statistics 2, 1201-1225) describes axes by the density
exp(k1 (x.v3)^2 + k2 (x.v2)^2), k1 <= k2 <= 0, where v1, v2, v3 are the axes of the orientation
tensor: a cluster, a girdle (k2 near 0) or an intermediate shape. Kent's distribution (1982,
Journal of the Royal Statistical Society B 44, 71-80) describes directions in one elongated cluster
by exp(kappa x.g1 + beta ((x.g2)^2 - (x.g3)^2)), 2 beta < kappa. Constants and moments are sums over
Gauss-Legendre nodes that are adapted to the density; they are accurate from uniform scatter to
clusters of a thousandth of a degree.

The goodness of fit is assessed by the smooth test (Neyman 1937; for directions Boulerice & Ducharme
1997, Journal of Multivariate Analysis 60, 154-175): the harmonics or moments of the degrees
above those of the fit are compared with their expectations under the fitted model, with a
chi-square statistic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.populations.probabilities import chi2_tail

RANGE_SIGMA = 7.0
"""Range of the nodes to each side, in standard deviations."""
N_NODES = 64
MAX_BROAD_CONCENTRATION = 30.0
"""Maximum concentration for which the nodes cover the whole sphere."""
MIN_FIT_DIRECTIONS = 20
"""Minimum number of vectors for the chi-square approximation of the smooth test."""


@dataclass(frozen=True, eq=False)
class QuadratureNodes:
    """Points on the sphere (m, 3) in the frame of the model, and their probabilities."""

    positions: FloatArray
    shares: FloatArray
    log_constant: float

    def mean(self, values: FloatArray) -> FloatArray:
        """Return the expectation of values (m, ...)."""
        return np.asarray(np.tensordot(self.shares, values, axes=(0, 0)))


@dataclass(frozen=True)
class Bingham:
    """Bingham distribution.

    The concentrations k1 <= k2 <= 0 belong to the third and second axes of the tensor.
    """

    k1: float
    k2: float
    nodes: QuadratureNodes


@dataclass(frozen=True)
class Kent:
    """Kent distribution; the rows of `axes` are the mean, the major and the minor axis."""

    kappa: float
    beta: float
    axes: FloatArray
    nodes: QuadratureNodes


def bingham_nodes(k1: float, k2: float) -> QuadratureNodes:
    """Return nodes in the frame of the axes, on the hemisphere around the first axis.

    Parameters
    ----------
    k1, k2 : float
        Concentrations.

    Returns
    -------
    QuadratureNodes
    """
    a, b = -k1, -k2
    x, wx = _legendre_nodes(-1.0, 1.0, _standard_deviation(a))
    angle, wt = _legendre_nodes(-math.pi / 2, math.pi / 2, _standard_deviation(b))
    sines = np.sqrt(np.maximum(1.0 - x**2, 0.0))
    positions = np.stack(
        [
            (sines[:, None] * np.cos(angle)).ravel(),
            (sines[:, None] * np.sin(angle)).ravel(),
            np.repeat(x, len(angle)),
        ],
        axis=-1,
    )
    log_density = -a * positions[:, 2] ** 2 - b * positions[:, 1] ** 2
    return _build_nodes(positions, log_density, (wx[:, None] * wt).ravel(), 2.0)


def estimate_bingham(eigenvalues: npt.ArrayLike) -> Bingham | None:
    """Estimate a Bingham distribution by maximum likelihood.

    Parameters
    ----------
    eigenvalues : (3,) array_like
        Eigenvalues of the orientation tensor.

    Returns
    -------
    Bingham or None
        None if S3 is 0, so that the concentration is infinite.
    """
    values = np.asarray(eigenvalues, dtype=np.float64)
    _, s2, s3 = (float(s) for s in values / values.sum())
    if s3 < 1e-12:
        return None
    target_moments = np.array([s3, s2])
    # Solve for the logarithms of (a - b) and b, which remain positive; a and b are -k1 and -k2.
    initial_concentrations = 0.5 / np.maximum(target_moments, 1e-12) - 1.5
    a, b = max(float(initial_concentrations[0]), 1e-3), max(float(initial_concentrations[1]), 0.0)
    for _ in range(200):
        nodes = bingham_nodes(-a, -b)
        squares = np.stack([nodes.positions[:, 2] ** 2, nodes.positions[:, 1] ** 2], axis=-1)
        mean = nodes.mean(squares)
        covariance = nodes.mean(squares[:, :, None] * squares[:, None, :]) - np.outer(mean, mean)
        # d mean / d(-a, -b) = spread: take a Newton step, limited to valid values.
        step = np.linalg.solve(covariance + 1e-300 * np.eye(2), mean - target_moments)
        if b <= 0.0 and b + step[1] <= 0.0:
            step = np.array([(mean[0] - target_moments[0]) / covariance[0, 0], 0.0])
        new_a = a + float(step[0]) if a + step[0] > 0.2 * a else 0.2 * a
        new_b = b + float(step[1])
        new_b = max(new_b, 0.2 * b if b > 1e-9 else 0.0)
        if new_b < 1e-12:
            new_b = 0.0
        new_a, new_b = min(new_a, 5.0 * a + 1.0), min(new_b, 5.0 * b + 1.0)
        new_a = max(new_a, new_b)
        has_converged = abs(new_a - a) <= 1e-10 * (1 + a) and abs(new_b - b) <= 1e-10 * (1 + b)
        a, b = new_a, new_b
        if has_converged:
            break
    return Bingham(-a, -b, bingham_nodes(-a, -b))


def kent_nodes(kappa: float, beta: float) -> QuadratureNodes:
    """Return nodes on the equal-area plane about the mean.

    Parameters
    ----------
    kappa, beta : float
        Concentration and ovalness.

    Returns
    -------
    QuadratureNodes
        Nodes in the frame of the mean, major and minor axis.
    """
    major_width = 1.0 / math.sqrt(kappa - 2.0 * beta)
    minor_width = 1.0 / math.sqrt(kappa + 2.0 * beta)
    # A flat top along the major axis (2 beta near kappa) decays only with the fourth power.
    major_width = min(major_width, 1.6 * kappa**-0.25)
    p, wp = _legendre_nodes(-2.0, 2.0, major_width)
    q, wq = _legendre_nodes(-2.0, 2.0, minor_width)
    u, v = (grid.ravel() for grid in np.meshgrid(p, q, indexing="ij"))
    weights = (wp[:, None] * wq).ravel()
    square = u**2 + v**2
    is_inside = square <= 4.0
    u, v, square, weights = u[is_inside], v[is_inside], square[is_inside], weights[is_inside]
    scale = np.sqrt(1.0 - square / 4.0)
    positions = np.stack([1.0 - square / 2.0, u * scale, v * scale], axis=-1)
    log_density = -kappa * square / 2.0 + beta * (positions[:, 1] ** 2 - positions[:, 2] ** 2)
    unscaled_nodes = _build_nodes(positions, log_density, weights, 1.0)
    return QuadratureNodes(
        unscaled_nodes.positions, unscaled_nodes.shares, unscaled_nodes.log_constant + kappa
    )


def estimate_kent(directions: npt.ArrayLike) -> Kent | None:
    """Estimate a Kent distribution by maximum likelihood along the axes of the moments.

    See section 4 of Kent (1982).

    Parameters
    ----------
    directions : (n, 3) array_like
        Unit vectors.

    Returns
    -------
    Kent or None
        None if the directions do not form a cluster (kappa below 5) or scatter in one direction
        only.
    """
    x = np.asarray(directions, dtype=np.float64)
    mean = x.mean(axis=0)
    length = float(np.linalg.norm(mean))
    axis = mean / length
    first_axis = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first_axis /= np.linalg.norm(first_axis)
    second_axis = np.cross(axis, first_axis)
    tangent_components = np.stack([x @ first_axis, x @ second_axis], axis=-1)
    squares, rotation_axes = np.linalg.eigh(tangent_components.T @ tangent_components / len(x))
    if squares[0] < 1e-14:
        return None
    major = rotation_axes[0, 1] * first_axis + rotation_axes[1, 1] * second_axis
    axes = np.array([axis, major, np.cross(axis, major)])
    shortfall = float(np.mean(0.5 * np.sum((x - axis) ** 2, axis=1)))
    concentrations = kent_concentrations(1.0 - shortfall, float(squares[1] - squares[0]))
    return (
        None if concentrations is None else Kent(*concentrations, axes, kent_nodes(*concentrations))
    )


def kent_concentrations(resultant: float, square_difference: float) -> tuple[float, float] | None:
    """Estimate kappa and beta by maximum likelihood.

    Parameters
    ----------
    resultant : float
        Mean resultant length.
    square_difference : float
        Difference between the mean squares along the major and the minor axis.

    Returns
    -------
    (float, float) or None
        None if kappa is below 5.
    """
    shortfall = 1.0 - resultant
    major_concentration, minor_concentration = (
        1.0 / (2 * shortfall + square_difference),
        1.0 / max(2 * shortfall - square_difference, 1e-300),
    )
    kappa, beta = (
        minor_concentration + major_concentration,
        0.5 * (minor_concentration - major_concentration),
    )
    if kappa < 5.0:
        return None
    for _ in range(100):
        nodes = kent_nodes(kappa, beta)
        p = nodes.positions
        sufficient_statistics = np.stack([-(1.0 - p[:, 0]), p[:, 1] ** 2 - p[:, 2] ** 2], axis=-1)
        expected_moments = nodes.mean(sufficient_statistics)
        covariance = nodes.mean(
            sufficient_statistics[:, :, None] * sufficient_statistics[:, None, :]
        )
        covariance -= np.outer(expected_moments, expected_moments)
        step = np.linalg.solve(
            covariance, np.array([-shortfall, square_difference]) - expected_moments
        )
        step_factor = 1.0
        while step_factor > 1e-6 and not _is_valid_kent(
            kappa + step_factor * step[0], beta + step_factor * step[1]
        ):
            step_factor *= 0.5
        kappa, beta = (
            kappa + step_factor * float(step[0]),
            max(beta + step_factor * float(step[1]), 0.0),
        )
        if float(np.abs(step).max()) <= 1e-10 * kappa or step_factor <= 1e-6:
            break
    return (kappa, beta) if kappa >= 5.0 else None


def _is_valid_kent(kappa: float, beta: float) -> bool:
    return kappa > 0.0 and -1e-9 * kappa <= beta < 0.4999 * kappa


def _standard_deviation(concentration: float) -> float:
    """Return the standard deviation of exp(-concentration x^2); infinite if it is broad."""
    return (
        1.0 / math.sqrt(2.0 * concentration)
        if concentration > MAX_BROAD_CONCENTRATION
        else math.inf
    )


@cache
def _gauss_legendre() -> tuple[FloatArray, FloatArray]:
    return np.polynomial.legendre.leggauss(N_NODES)


def _legendre_nodes(low: float, high: float, sigma: float) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights over the range, limited to `RANGE_SIGMA` about 0."""
    if math.isfinite(sigma):
        low, high = max(low, -RANGE_SIGMA * sigma), min(high, RANGE_SIGMA * sigma)
    nodes, weights = _gauss_legendre()
    half_width = (high - low) / 2.0
    return nodes * half_width + (high + low) / 2.0, weights * half_width


def _build_nodes(
    positions: FloatArray, log_density: FloatArray, weights: FloatArray, multiplicity: float
) -> QuadratureNodes:
    max_log_density = float(log_density.max())
    mass = np.exp(log_density - max_log_density) * weights
    total_mass = float(mass.sum())
    return QuadratureNodes(
        positions, mass / total_mass, math.log(total_mass * multiplicity) + max_log_density
    )


# Goodness of fit -------------------------------------------------------------------------------


def smooth_test(
    data: FloatArray,
    score_data: FloatArray,
    nodes: FloatArray,
    score_nodes: FloatArray,
    fractions: FloatArray,
) -> float:
    """Compute the p-value of the smooth goodness-of-fit test.

    Parameters
    ----------
    data : (n, k) ndarray
        Additional functions of the data.
    score_data : (n, j) ndarray
        Scores of the data, the derivatives of the log density with respect to the fitted
        parameters.
    nodes : (m, k) ndarray
        Additional functions at the nodes of the fitted model.
    score_nodes : (m, j) ndarray
        Scores at the nodes.
    fractions : (m,) ndarray
        Probabilities of the nodes.

    Returns
    -------
    float
    """
    n = len(data)
    score_mean = fractions @ score_nodes
    mean = fractions @ nodes
    scores = score_nodes - score_mean
    centred_nodes = nodes - mean
    information = scores.T @ (scores * fractions[:, None])
    cross_products = scores.T @ (centred_nodes * fractions[:, None])
    regression_coefficients = np.linalg.lstsq(
        _to_correlation(information), _scale_rows(cross_products, information), rcond=1e-12
    )[0]
    regression_coefficients = regression_coefficients / np.sqrt(np.diag(information))[:, None]
    residual_nodes = centred_nodes - scores @ regression_coefficients
    residual_data = (data - mean) - (score_data - score_mean) @ regression_coefficients
    covariance = residual_nodes.T @ (residual_nodes * fractions[:, None])
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    is_used = values > 1e-6 * values.max()
    score_sums = (residual_data.sum(axis=0) / scale) @ axes[:, is_used]
    statistic = float(np.sum(score_sums**2 / values[is_used])) / n
    return chi2_tail(int(is_used.sum()), statistic)


def _to_correlation(matrix: FloatArray) -> FloatArray:
    root = np.sqrt(np.diag(matrix))
    return np.asarray(matrix / np.outer(root, root))


def _scale_rows(cross_products: FloatArray, matrix: FloatArray) -> FloatArray:
    return np.asarray(cross_products / np.sqrt(np.diag(matrix))[:, None])


def bingham_p(model: Bingham, x: FloatArray) -> float:
    """Return the goodness-of-fit p-value of a Bingham model, based on fourth-order harmonics.

    Parameters
    ----------
    model : Bingham
    x : (n, 3) ndarray
        Axes in the frame of the model.

    Returns
    -------
    float
    """
    positions = model.nodes.positions
    return smooth_test(
        _quartic_products(x),
        _quadratic_products(x),
        _quartic_products(positions),
        _quadratic_products(positions),
        model.nodes.shares,
    )


def kent_p(model: Kent, x: FloatArray) -> float:
    """Return the goodness-of-fit p-value of a Kent model, based on skewness and kurtosis.

    Parameters
    ----------
    model : Kent
    x : (n, 3) ndarray
        Directions in the frame of the model.

    Returns
    -------
    float
    """
    positions = model.nodes.positions
    return smooth_test(
        _tangent_products(x, 2),
        _kent_scores(x),
        _tangent_products(positions, 2),
        _kent_scores(positions),
        model.nodes.shares,
    )


def fisher_model_p(kappa: float, x: FloatArray) -> float:
    """Return the goodness-of-fit p-value of a Fisher model.

    The test rejects elongated or skewed clusters and those with a different radial decay.

    Parameters
    ----------
    kappa : float
    x : (n, 3) ndarray
        Directions in a frame whose first axis is the mean.

    Returns
    -------
    float
    """
    nodes = kent_nodes(kappa, 0.0)
    positions = nodes.positions
    return smooth_test(
        _tangent_products(x, 1), x, _tangent_products(positions, 1), positions, nodes.shares
    )


def _quadratic_products(x: FloatArray) -> FloatArray:
    a, b, c = x[:, 0], x[:, 1], x[:, 2]
    return np.stack([b * b, c * c, a * b, a * c, b * c], axis=-1)


def _quartic_products(x: FloatArray) -> FloatArray:
    a, b, c = x[:, 0], x[:, 1], x[:, 2]
    return np.stack(
        [
            b**4,
            c**4,
            b * b * c * c,
            b**3 * c,
            b * c**3,
            a * b**3,
            a * c**3,
            a * b * c * c,
            a * b * b * c,
        ],
        axis=-1,
    )


def _kent_scores(x: FloatArray) -> FloatArray:
    a, b, c = x[:, 0], x[:, 1], x[:, 2]
    return np.stack([a, b, c, b * b - c * c, b * c, a * b, a * c], axis=-1)[:, :5]


def _tangent_products(x: FloatArray, n_fitted_moments: int) -> FloatArray:
    """Return functions of the coordinates across the mean that are not part of the fit.

    They are of degrees two to four if one moment was fitted, otherwise of degrees three and four.
    """
    b, c = x[:, 1], x[:, 2]
    square = b * b + c * c
    if n_fitted_moments == 1:
        return np.stack([b * b - c * c, b * c, b * square, c * square, square**2], axis=-1)
    return np.stack([b**3, c**3, b * b * c, b * c * c, b**4, c**4, b * b * c * c], axis=-1)
