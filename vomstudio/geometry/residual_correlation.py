"""Correlation of the residuals of a trace, and its effect on the error of the plane.

Neighbouring points of a trace share the roughness of the surface, so the effective number of points
is lower than the actual number. The cosine spectrum of the residuals is compared with a small
family of roughness models: no correlation, exponential or Gaussian correlation with several
lengths, and exponential correlation combined with white picking noise. The variance that the fit
itself removes is taken into account: each cosine is weighted by the share that remains. Every model
predicts the possible tilt of the plane and the degrees of freedom of its own scale. The mixture of
these distributions, weighted by the likelihood of each model, gives the 95 % limit. An uncertain
correlation length therefore widens the region instead of increasing the error rate.

Correlation lengths are measured along the trace in numbers of points, as if the points were evenly
spaced. If they are not, the tilt of each model is also computed for the actual positions along the
trace, and the larger of the two tilts is used. The likelihood of the models still assumes even
spacing.

The calibration constants below come from simulations (tests/benchmarks/bench_coverage.py,
docs/plane_errors.md): white noise incurs almost no penalty, and for correlation lengths up to a
tenth of the trace the nominal coverage is reached with 30 points or more.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

# Correlation lengths as fractions of the trace length. The residuals cannot distinguish the long
# ones from the plane itself. They are included, with a small weight, so that they are recognised.
SHORT_LENGTHS = tuple(0.1 * 0.5 ** (i / 2) for i in range(-1, 8))
LONG_LENGTHS = (0.25, 0.5)
MIN_LONG_LENGTH = 0.12
MIXED_WHITE_SHARES = (0.25, 0.5)  # shares of picking noise in the variance
MIN_POINTS = 12  # fewer points do not determine a correlation
MAX_PIECES = 256  # longer traces are divided into this many pieces, whose means are compared
MAX_UNEVENNESS = (
    0.25  # standard deviation of the spacing over its mean, above which it makes a difference
)
MAX_SUBDIVISION = 16  # positions within a piece that suffice for the correlation of its mean
# Higher frequencies distinguish white noise from roughness but do not distinguish the correlation
# lengths. They would make the estimate of the length overconfident.
N_FREQUENCIES = 127
# White variance added to data and models: frequencies without power must not decide between models,
# and no surface is as smooth as a Gaussian correlation implies.
MIN_NOISE_SHARE = 0.05

# Calibrated prior weights for a correlation length of a tenth of the trace; they increase with a
# power of the length. Pairs refer to exponential and Gaussian correlation.
SMOOTHNESS_WEIGHTS = (1.0, 0.38)
SMOOTHNESS_WEIGHT_SLOPES = (0.33, 0.0)
LONG_LENGTH_WEIGHTS = (0.75, 0.035)  # weight of each long length
MIXED_WEIGHT = (0.37, 0.036)  # weight for each share of white noise
MIXED_WEIGHT_SLOPE = 0.48
# The weight of white noise is (WHITE_POINTS / n)^WHITE_POWER, but at least MIN_WHITE_WEIGHT.
WHITE_POINTS, WHITE_POWER, MIN_WHITE_WEIGHT = 43.0, 2.0, 0.083
# Exponent applied to the weights of the models. A plain mixture is too wide if the right model is
# obvious, and too narrow if a wide model has a medium weight. Sharper weights compensate for both.
SHARPNESS = 2.0
# The degrees of freedom of the variance of correlated noise are themselves estimated.
DOF_FACTOR = 0.74

LOG_SIGNIFICANCE = np.log(0.05)
MIN_FLOAT = float(np.finfo(np.float64).tiny)


def _list_models() -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """Return the length, white share, smoothness and weight of each model but white noise."""
    rows: list[tuple[float, float, bool, float]] = []
    for is_smooth in (False, True):
        rows += [
            (
                x,
                0.0,
                is_smooth,
                SMOOTHNESS_WEIGHTS[is_smooth] * (10.0 * x) ** SMOOTHNESS_WEIGHT_SLOPES[is_smooth],
            )
            for x in SHORT_LENGTHS
        ]
        rows += [(x, 0.0, is_smooth, LONG_LENGTH_WEIGHTS[is_smooth]) for x in LONG_LENGTHS]
    for white_share, mixed_weight in zip(MIXED_WHITE_SHARES, MIXED_WEIGHT, strict=True):
        rows += [
            (x, white_share, False, mixed_weight * (10.0 * x) ** MIXED_WEIGHT_SLOPE)
            for x in SHORT_LENGTHS[::2]
        ]
    length, white_shares, smoothness, weight = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    return length, white_shares, smoothness, weight


MODEL_LENGTHS, MODEL_WHITE_SHARES, IS_SMOOTH_MODEL, MODEL_WEIGHTS = _list_models()
IS_PURE_MODEL = np.concatenate([[True], MODEL_WHITE_SHARES == 0.0])
IS_LONG_MODEL = np.concatenate([[False], MODEL_LENGTHS > MIN_LONG_LENGTH])


def _correlations(n: int, points_per_piece: int) -> tuple[FloatArray, FloatArray]:
    """Return the correlations (models, n) of the means of n pieces, and their white shares.

    The correlations exclude white noise; the white model is the first. Averaging reduces white
    noise and smooths rough noise.
    """
    n_fine = min(points_per_piece, MAX_SUBDIVISION)
    # Pairs of positions within two pieces, indexed by the difference of their lags.
    shift = np.arange(1 - n_fine, n_fine)
    fraction = (1.0 - np.abs(shift) / n_fine) / n_fine
    lag = np.abs(np.arange(n)[:, None] + shift / n_fine) * (
        points_per_piece / (n * points_per_piece - 1.0)
    )
    x = lag / MODEL_LENGTHS[:, None, None]
    rough_correlations = (
        np.exp(np.where(IS_SMOOTH_MODEL[:, None, None], -0.5 * x * x, -x)) @ fraction
    )
    rough_correlations *= (1.0 - MODEL_WHITE_SHARES)[:, None]
    variance = rough_correlations[:, :1] + (MODEL_WHITE_SHARES / points_per_piece)[:, None]
    white_shares = (MODEL_WHITE_SHARES / points_per_piece) / variance[:, 0]
    return np.vstack([np.zeros(n), rough_correlations / variance]), np.concatenate(
        [[1.0], white_shares]
    )


class _ModelLibrary:
    """Expectations of the models for a trace of n equal pieces; the first is white noise.

    Attributes
    ----------
    log_power, inverse_power : (models, N_FREQUENCIES) ndarray
        Logarithm and inverse of the expected squared coefficients of the orthonormal cosine
        transform (DCT-II), from coefficient 1 on, scaled to the share of the variance that remains
        after the fit and including the noise floor.
    squared_power : (models, n - 1) ndarray
        Squares of the expected squared coefficients of the same transform, for variance 1.
    toeplitz : (models, n + 1) ndarray
        Weights that convert the power spectrum (rfft) of a series padded to 2 n into the quadratic
        form series' R series, where R is the correlation matrix without `white_shares`.
    white_shares : (models,) ndarray
        Share of white noise; it adds this share of the squared norm of the series to the quadratic
        form.
    mean : (models,) ndarray
        Quadratic form of the constant series of norm 1.
    half_step : (n - 1,) ndarray
        Factors that convert the spectrum of a padded series into its cosine transform.
    log_weight : (models,) ndarray
        Logarithms of the prior weights.
    """

    def __init__(self, n: int, points_per_piece: int = 1) -> None:
        rho, self.white_shares = _correlations(n, points_per_piece)
        rho[:, 0] = 0.0
        taper = 1.0 - np.arange(n) / n
        # Coefficient j: 1 + 2 sum_h rho(h) [(1 - h / n) cos(t h) - sin(t h) / (n sin t)],
        # t = pi j / n.
        angle = np.pi * np.arange(1, n) / n
        transform = np.fft.rfft(rho, 2 * n)
        cosine = np.fft.rfft(rho * taper, 2 * n).real[:, 1:n]
        sine = -transform.imag[:, 1:n]
        s = np.maximum(1.0 + 2.0 * (cosine - sine / (n * np.sin(angle))), 0.0)
        self.half_step = np.exp(-0.5j * angle)
        self.squared_power = s * s
        self.mean = 1.0 + 2.0 * (rho * taper).sum(axis=1)
        # Scale to a variance of 1 after a fit has removed the two lowest coefficients.
        residual_dof = np.maximum(n - self.mean - s[:, 0] - s[:, 1], 1e-3 * n)
        scaled_sums = s[:, :N_FREQUENCIES] * ((n - 3.0) / residual_dof)[:, None] + MIN_NOISE_SHARE
        self.log_power = np.log(scaled_sums)
        self.inverse_power = 1.0 / scaled_sums
        doubled_counts = np.full(n + 1, 2.0)
        doubled_counts[[0, n]] = 1.0
        self.toeplitz = (
            ((1.0 - self.white_shares)[:, None] + 2.0 * transform.real) * doubled_counts / (2 * n)
        )
        # A correlation below 1/e at the next point is equivalent to white noise.
        decay_length = np.where(IS_SMOOTH_MODEL, np.sqrt(2.0), 1.0) * MODEL_LENGTHS
        is_resolved = decay_length * (n * points_per_piece - 1.0) > points_per_piece
        white_weight = max((WHITE_POINTS / n) ** WHITE_POWER, MIN_WHITE_WEIGHT)
        weight = np.concatenate([[white_weight], np.where(is_resolved, MODEL_WEIGHTS, 0.0)])
        self.log_weight = np.log(np.maximum(weight, MIN_FLOAT))


_cached_library = lru_cache(maxsize=256)(_ModelLibrary)


def inflate(
    u: FloatArray,
    v: FloatArray,
    r: FloatArray,
    starts: IntArray,
    counts: IntArray,
    degrees_of_freedom: FloatArray,
    white_quantiles: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Compute the quantiles for correlated residuals; see `plane_errors.quantiles`.

    Parameters
    ----------
    u, v, r : (n,) ndarray
        Coordinates along e1 and e2 of each plane, and residuals.
    starts, counts : (m,) ndarray of int
        First point and number of points of each group.
    degrees_of_freedom : (m,) ndarray
        Degrees of freedom.
    white_quantiles : (m,) ndarray
        Quantile for independent points.

    Returns
    -------
    q1, q2 : (m,) ndarray
        Quantiles along e1 and e2.
    effective : (m,) ndarray
        Effective number of points of each group.
    long : (m,) ndarray of bool
        Whether the roughness is as long as the trace.
    """
    q1, q2 = white_quantiles.copy(), white_quantiles.copy()
    effective_counts = degrees_of_freedom + 3.0
    is_long = np.zeros(len(degrees_of_freedom), bool)
    positions = _positions_along_trace(u, v, starts, counts)
    order = np.argsort(counts, kind="stable")
    sizes, first_rows = np.unique(counts[order], return_index=True)
    for size, rows in zip(sizes.tolist(), np.split(order, first_rows[1:]), strict=True):
        # A trace with few distinct points, or exactly in its plane, cannot be compared with models.
        rows = rows[(degrees_of_freedom[rows] > 1.0)]
        if size < MIN_POINTS or not len(rows):
            continue
        index = starts[rows][:, None] + np.arange(size)
        series = np.stack([u[index], v[index], r[index]])
        variance_share, dof = np.ones(len(rows)), degrees_of_freedom[rows]
        models = _cached_library(min(size, MAX_PIECES), max(round(size / MAX_PIECES), 1))
        if size > MAX_PIECES:
            blocks, variance_share = _block_means(series)
            dof = np.minimum(dof, MAX_PIECES - 3.0)
            g, model_dof, weight, is_long[rows] = _compare_models(blocks, dof, models)
        else:
            g, model_dof, weight, is_long[rows] = _compare_models(series, dof, models)
        t = positions[index]
        is_uneven = ((np.diff(t) * (size - 1.0) - 1.0) ** 2).mean(axis=1) > MAX_UNEVENNESS**2
        if is_uneven.any():
            position_inflation = _inflation_at_positions(
                series[:2, is_uneven], t[is_uneven], dof[is_uneven], models
            )
            g[:, is_uneven] = np.maximum(g[:, is_uneven], position_inflation)
        q = _mixture_quantile(g, model_dof, weight, dof) * variance_share
        q1[rows], q2[rows] = q
        # The number of independent points that would give the same limit.
        with np.errstate(divide="ignore"):  # q is 0 for points exactly on the plane
            independent_count = 3.0 - 2.0 * LOG_SIGNIFICANCE / np.log1p(q[1])
        effective_counts[rows] = np.minimum(independent_count, degrees_of_freedom[rows] + 3.0)
    return q1, q2, effective_counts, is_long


def _positions_along_trace(
    u: FloatArray, v: FloatArray, starts: IntArray, counts: IntArray
) -> FloatArray:
    """Return the position of each point along its trace, from 0 to 1."""
    step = np.hypot(np.diff(u, prepend=0.0), np.diff(v, prepend=0.0))
    step[starts] = 0.0
    position = np.cumsum(step)
    position -= np.repeat(position[starts], counts)
    length = np.maximum(position[starts + counts - 1], MIN_FLOAT)
    result: FloatArray = position / np.repeat(length, counts)
    return result


def _inflation_at_positions(
    series: FloatArray, position: FloatArray, degrees_of_freedom: FloatArray, models: _ModelLibrary
) -> FloatArray:
    """Return the inflation (2, k, models) for the actual positions of the points.

    The inflation is defined as in `_compare_models`.

    `series` is (2, k, n), `position` (k, n) from 0 to 1. Points are binned into as many pieces of
    equal length as the models have; the noise of a piece acts on the sum of the coordinates of its
    points.
    """
    _, k, n = series.shape
    m = models.toeplitz.shape[1] - 1
    piece = np.minimum((position * m).astype(np.int64), m - 1) + np.arange(k)[:, None] * m
    sums = np.sqrt(np.maximum((series * series).sum(axis=-1), MIN_FLOAT))
    series = np.stack([series[0], series[1], np.ones((k, n))])
    sums = np.stack([sums[0], sums[1], np.full(k, np.sqrt(n))]) * np.sqrt(n / m)
    piece_sums = [np.bincount(piece.ravel(), x.ravel(), k * m).reshape(k, m) for x in series]
    spectrum = np.fft.rfft(np.stack(piece_sums) / sums[..., None], 2 * m)
    loading = (spectrum.real**2 + spectrum.imag**2) @ models.toeplitz.T + models.white_shares
    residual_dof = np.maximum(m - loading.sum(axis=0), 1e-2 * m)
    return np.asarray(np.maximum(loading[:2] * (degrees_of_freedom[:, None] / residual_dof), 1.0))


def _block_means(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Average long series (3, k, n) over MAX_PIECES pieces.

    Return the means and the share of the variance that remains.

    Tilts of the plane vary slowly along the trace, and only the slow part of the noise tilts it.
    """
    edges = np.linspace(0, series.shape[-1], MAX_PIECES + 1).astype(np.int64)[:-1]
    sizes = np.diff(np.append(edges, series.shape[-1]))
    means: FloatArray = np.add.reduceat(series, edges, axis=-1) / sizes
    variance = np.maximum((series[2] ** 2).mean(axis=-1), MIN_FLOAT)
    return means, (means[2] ** 2).mean(axis=-1) / variance


def _compare_models(
    series: FloatArray, degrees_of_freedom: FloatArray, models: _ModelLibrary
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Compare k traces of n points with all models.

    Parameters
    ----------
    series : (3, k, n) ndarray
        Coordinates along e1 and e2, and residuals.
    degrees_of_freedom : (k,) ndarray
    models : _ModelLibrary

    Returns
    -------
    inflation : (2, k, models) ndarray
        Variance along e1 and e2 relative to the variance for white noise.
    freedom, weight : (k, models) ndarray
        Degrees of freedom of the inflated variance, and weights of the models.
    long : (k,) ndarray of bool
        Whether long roughness is likely.
    """
    n = series.shape[-1]
    spectrum = np.fft.rfft(series, 2 * n)
    sums = np.maximum((series * series).sum(axis=-1, keepdims=True), MIN_FLOAT)
    # The orthonormal DCT-II is the real part of this spectrum, shifted by half a step.
    squares = (spectrum[..., 1:n] * models.half_step).real ** 2 * (2.0 / n / sums)
    remaining_share = np.maximum(1.0 - squares[0] - squares[1], 0.0)
    # Loading of noise of variance 1 on each coordinate, the variance that remains after the fit,
    # and the degrees of freedom of this variance.
    power = (spectrum[:2].real ** 2 + spectrum[:2].imag ** 2) / sums[:2]
    loading = power @ models.toeplitz.T + models.white_shares
    residual_dof = np.maximum(n - models.mean - loading[0] - loading[1], 1e-3 * n)
    model_dof = np.minimum(
        DOF_FACTOR * residual_dof**2 / (remaining_share @ models.squared_power.T), n - 3.0
    )
    model_dof[:, 0] = n - 3.0
    dof_ratio = degrees_of_freedom / (n - 3.0)
    inflation = np.maximum(loading * (degrees_of_freedom[:, None] / residual_dof), 1.0)
    # Whittle likelihood with the scale profiled out.
    used_share = remaining_share[:, :N_FREQUENCIES]
    misfit = (
        squares[2, :, :N_FREQUENCIES] * (n - 3.0) + MIN_NOISE_SHARE * used_share
    ) @ models.inverse_power.T
    likelihood_counts = used_share.sum(axis=1) * dof_ratio
    likelihood = -0.5 * (
        used_share @ models.log_power.T + likelihood_counts[:, None] * np.log(misfit)
    )
    weight = _normalize(SHARPNESS * (likelihood + models.log_weight))
    likelihood_weight = _normalize(likelihood) * IS_PURE_MODEL
    is_long = likelihood_weight[:, IS_LONG_MODEL].sum(axis=1) > 0.5 * likelihood_weight.sum(axis=1)
    return inflation, model_dof * dof_ratio[:, None], weight, is_long


def _normalize(logarithms: FloatArray) -> FloatArray:
    weight = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
    result: FloatArray = weight / weight.sum(axis=1, keepdims=True)
    return result


def _mixture_quantile(
    g: FloatArray, model_dof: FloatArray, weight: FloatArray, degrees_of_freedom: FloatArray
) -> FloatArray:
    """Solve sum_j weight_j P(F_j > q) = 0.05 for q (2, k).

    F_j is g_j times a variable with Fisher's F distribution, with 2 and model_dof_j degrees of
    freedom. The result is scaled to `degrees_of_freedom`.

    Newton's method is applied to the logarithm of the tail as a function of x = log(1 + q), within
    bounds and separately for each element, so that no result depends on the other elements.
    """
    _, k, models = g.shape
    shape = np.broadcast_to(0.5 * model_dof, g.shape).reshape(-1, models)
    weight = np.broadcast_to(weight, g.shape).reshape(-1, models)
    rate = (degrees_of_freedom[:, None] / (g * model_dof)).reshape(-1, models)
    # A hundredth of a degree of freedom does not determine the plane.
    single_quantiles = np.log1p(np.expm1(np.minimum(-LOG_SIGNIFICANCE / shape, 500.0)) / rate)
    low, high = single_quantiles.min(axis=-1), single_quantiles.max(axis=-1)
    x = np.clip((weight * single_quantiles).sum(axis=-1), low, high)
    solution = np.empty_like(x)
    rows = np.arange(len(x))
    for _ in range(100):
        exponential = np.exp(x)[:, None]
        base = 1.0 + rate * (exponential - 1.0)
        tail_probabilities = weight * np.exp(-shape * np.log(base))
        value = tail_probabilities.sum(axis=-1)
        slope = (tail_probabilities * shape * rate * exponential / base).sum(axis=-1) / value
        log_excess = np.log(value) - LOG_SIGNIFICANCE
        low, high = np.where(log_excess > 0.0, x, low), np.where(log_excess > 0.0, high, x)
        step = x + log_excess / slope
        # Convergence is quadratic, so a short step is the last one. Rounding may place the step on
        # a bound, where bisection would only reach the tolerance.
        has_converged = np.abs(step - x) <= 1e-7 * x
        is_inside = (step > low) & (step < high)
        step = np.where(is_inside | has_converged, step, 0.5 * (low + high))
        solution[rows] = step
        is_active = ~has_converged
        if not is_active.any():
            break
        rows, x, low, high = rows[is_active], step[is_active], low[is_active], high[is_active]
        shape, weight, rate = shape[is_active], weight[is_active], rate[is_active]
    result: FloatArray = np.expm1(solution.reshape(2, k))
    return result
