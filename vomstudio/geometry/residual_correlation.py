"""How much the residuals of a trace depend on each other, and what that costs.

Neighbouring points of a trace share the roughness of the surface, so n points are worth fewer. The
residuals' cosine spectrum is compared with a small family of roughness models: none, exponential
and Gaussian correlation of several lengths, and exponential with some white picking noise. What
the fit itself has swallowed is allowed for: each cosine counts with the share the fit has left.
Every model then says how far the plane may tilt, and on how many degrees of freedom its own scale
stands; the mixture of these laws, weighted by how well each model explains the residuals, gives the
95 % limit, so that doubt about the length costs width instead of coverage.

Lengths are counted along the trace in points, as if these were evenly spaced. Where they are not,
what a model says of the tilt is also worked out for the points' places along the trace, and the
wider of the two counts; which model explains the residuals is still judged in points.

The constants of the calibration below were set by simulation (tests/benchmarks/bench_coverage.py,
docs/plane_errors.md), so that white noise is hardly penalised and lengths up to a tenth of the
trace keep their coverage from 30 points on.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

# Correlation lengths as fractions of the trace. The long ones cannot be told from the plane itself
# by what the fit has left; they are there to be recognised, and with little weight.
SHORT = tuple(0.1 * 0.5 ** (i / 2) for i in range(-1, 8))
LONG = (0.25, 0.5)
LONGER_THAN_A_TENTH = 0.12
MIXED_WHITE = (0.25, 0.5)  # shares of picking noise in the variance
FEWEST = 12  # below this many points nothing can be said about correlation
MOST = 256  # longer traces are compared by the means of this many pieces
UNEVEN = 0.25  # standard deviation of the spacing over its mean, from which it makes a difference
FINE = 16  # places within a piece that are enough to know the correlation of means
# Frequencies above this one tell white noise from rough, but no more of a length: they would only
# make the choice of a length surer than it is.
HEARD = 127
# White variance added to data and models alike: no model may stand or fall with frequencies in
# which nothing happens, and no surface is as smooth as a Gaussian correlation would have it.
FLOOR = 0.05

# The calibration. Weights before anything is seen, those of lengths for a tenth of the trace, from
# where they grow with a power of the length; pairs are for exponential and Gaussian correlation.
KIND_WEIGHT = (1.0, 0.38)
KIND_SLOPE = (0.33, 0.0)
LONG_WEIGHT = (0.75, 0.035)  # of each long length
MIXED_WEIGHT = (0.37, 0.036)  # for each white share
MIXED_SLOPE = 0.48
# White noise has the weight (points / n)^power, or the least one.
WHITE_POINTS, WHITE_POWER, WHITE_LEAST = 43.0, 2.0, 0.083
# The models' weights count with this power. A plain mixture is too wide where the right model is
# plain to see, and too narrow where a wide one is half believed; a sharper choice evens this out.
SHARPNESS = 2.0
# The degrees of freedom of a correlated noise's variance are themselves an estimate.
FREEDOM = 0.74

LOG_LEVEL = np.log(0.05)
TINY = float(np.finfo(np.float64).tiny)


def _models() -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """Length, white share, smoothness and weight of every model but the white one."""
    rows: list[tuple[float, float, bool, float]] = []
    for smooth in (False, True):
        rows += [
            (x, 0.0, smooth, KIND_WEIGHT[smooth] * (10.0 * x) ** KIND_SLOPE[smooth]) for x in SHORT
        ]
        rows += [(x, 0.0, smooth, LONG_WEIGHT[smooth]) for x in LONG]
    for share, each in zip(MIXED_WHITE, MIXED_WEIGHT, strict=True):
        rows += [(x, share, False, each * (10.0 * x) ** MIXED_SLOPE) for x in SHORT[::2]]
    length, white, smoothness, weight = (np.array(column) for column in zip(*rows, strict=True))
    return length, white, smoothness, weight


LENGTH, WHITE, SMOOTH, WEIGHT = _models()
PURE = np.concatenate([[True], WHITE == 0.0])
IS_LONG = np.concatenate([[False], LENGTH > LONGER_THAN_A_TENTH])


def _correlations(n: int, each: int) -> tuple[FloatArray, FloatArray]:
    """Correlations (models, n) of the means of n pieces of `each` points, white noise left out, and
    the white share (models,) of the variance of these means; the white model is the first.

    Averaging leaves less of the white noise, and makes rough noise smoother.
    """
    fine = min(each, FINE)
    # Pairs of places within two pieces, by the difference of their lags.
    shift = np.arange(1 - fine, fine)
    share = (1.0 - np.abs(shift) / fine) / fine
    lag = np.abs(np.arange(n)[:, None] + shift / fine) * (each / (n * each - 1.0))
    x = lag / LENGTH[:, None, None]
    rough = np.exp(np.where(SMOOTH[:, None, None], -0.5 * x * x, -x)) @ share
    rough *= (1.0 - WHITE)[:, None]
    variance = rough[:, :1] + (WHITE / each)[:, None]
    white = (WHITE / each) / variance[:, 0]
    return np.vstack([np.zeros(n), rough / variance]), np.concatenate([[1.0], white])


class _Library:
    """What the models expect of a trace of n even pieces; the first model is white.

    log, inverse : (models, HEARD) of the expected squared coefficients from 1 on of the orthonormal
        cosine transform (DCT-II), scaled to what the fit leaves, floor added
    square : (models, n - 1) those coefficients for noise of variance 1, squared
    toeplitz : (models, n + 1) weights that turn the power spectrum of a series padded to 2 n, as of
        rfft, into the quadratic form series' R series of the correlation matrix R, but for
    white : (models,) the white noise in it, which adds this share of the series' square
    mean : (models,) that form for the constant series of norm 1
    half_step : (n - 1,) turns the spectrum of such a series into its cosine transform
    log_weight : (models,) of the weights before anything is seen
    """

    def __init__(self, n: int, each: int = 1) -> None:
        rho, self.white = _correlations(n, each)
        rho[:, 0] = 0.0
        taper = 1.0 - np.arange(n) / n
        # Coefficient j: 1 + 2 sum_h rho(h) [(1 - h / n) cos(t h) - sin(t h) / (n sin t)],
        # t = pi j / n.
        t = np.pi * np.arange(1, n) / n
        transform = np.fft.rfft(rho, 2 * n)
        cosine = np.fft.rfft(rho * taper, 2 * n).real[:, 1:n]
        sine = -transform.imag[:, 1:n]
        s = np.maximum(1.0 + 2.0 * (cosine - sine / (n * np.sin(t))), 0.0)
        self.half_step = np.exp(-0.5j * t)
        self.square = s * s
        self.mean = 1.0 + 2.0 * (rho * taper).sum(axis=1)
        # Scaled to leave a variance of 1 when a fit has taken the two lowest of them.
        remains = np.maximum(n - self.mean - s[:, 0] - s[:, 1], 1e-3 * n)
        scaled = s[:, :HEARD] * ((n - 3.0) / remains)[:, None] + FLOOR
        self.log = np.log(scaled)
        self.inverse = 1.0 / scaled
        twice = np.full(n + 1, 2.0)
        twice[[0, n]] = 1.0
        self.toeplitz = ((1.0 - self.white)[:, None] + 2.0 * transform.real) * twice / (2 * n)
        # Correlation that has fallen below 1/e at the next point is white noise under another name.
        fallen = np.where(SMOOTH, np.sqrt(2.0), 1.0) * LENGTH
        known = fallen * (n * each - 1.0) > each
        white = max((WHITE_POINTS / n) ** WHITE_POWER, WHITE_LEAST)
        weight = np.concatenate([[white], np.where(known, WEIGHT, 0.0)])
        self.log_weight = np.log(np.maximum(weight, TINY))


_library = lru_cache(maxsize=256)(_Library)


def inflate(
    u: FloatArray,
    v: FloatArray,
    r: FloatArray,
    starts: IntArray,
    counts: IntArray,
    dof: FloatArray,
    white: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """See plane_errors.quantiles; `white` (m,) is the answer for independent points."""
    q1, q2 = white.copy(), white.copy()
    effective = dof + 3.0
    long = np.zeros(len(dof), bool)
    place = _places(u, v, starts, counts)
    order = np.argsort(counts, kind="stable")
    sizes, first = np.unique(counts[order], return_index=True)
    for n, rows in zip(sizes.tolist(), np.split(order, first[1:]), strict=True):
        # A trace of few different places, or exactly in its plane, has nothing to be compared.
        rows = rows[(dof[rows] > 1.0)]
        if n < FEWEST or not len(rows):
            continue
        index = starts[rows][:, None] + np.arange(n)
        series = np.stack([u[index], v[index], r[index]])
        part, free = np.ones(len(rows)), dof[rows]
        models = _library(min(n, MOST), max(round(n / MOST), 1))
        if n > MOST:
            blocks, part = _block_means(series)
            free = np.minimum(free, MOST - 3.0)
            g, freedom, weight, long[rows] = _compare(blocks, free, models)
        else:
            g, freedom, weight, long[rows] = _compare(series, free, models)
        t = place[index]
        uneven = ((np.diff(t) * (n - 1.0) - 1.0) ** 2).mean(axis=1) > UNEVEN**2
        if uneven.any():
            there = _at_places(series[:2, uneven], t[uneven], free[uneven], models)
            g[:, uneven] = np.maximum(g[:, uneven], there)
        q = _mixture_quantile(g, freedom, weight, free) * part
        q1[rows], q2[rows] = q
        # The number of independent points that would give the same limit.
        with np.errstate(divide="ignore"):  # q is 0 where nothing is off the plane
            independent = 3.0 - 2.0 * LOG_LEVEL / np.log1p(q[1])
        effective[rows] = np.minimum(independent, dof[rows] + 3.0)
    return q1, q2, effective, long


def _places(u: FloatArray, v: FloatArray, starts: IntArray, counts: IntArray) -> FloatArray:
    """Place of every point along its trace, from 0 to 1."""
    step = np.hypot(np.diff(u, prepend=0.0), np.diff(v, prepend=0.0))
    step[starts] = 0.0
    place = np.cumsum(step)
    place -= np.repeat(place[starts], counts)
    length = np.maximum(place[starts + counts - 1], TINY)
    result: FloatArray = place / np.repeat(length, counts)
    return result


def _at_places(
    series: FloatArray, place: FloatArray, dof: FloatArray, models: _Library
) -> FloatArray:
    """The inflation (2, k, models) as in _compare, with the points where they are on the trace.

    series (2, k, n), place (k, n) from 0 to 1. Points are gathered in as many pieces of equal
    length as the models have; the noise of a piece leans on the sum of their coordinates.
    """
    _, k, n = series.shape
    m = models.toeplitz.shape[1] - 1
    at = np.minimum((place * m).astype(np.int64), m - 1) + np.arange(k)[:, None] * m
    sums = np.sqrt(np.maximum((series * series).sum(axis=-1), TINY))
    series = np.stack([series[0], series[1], np.ones((k, n))])
    sums = np.stack([sums[0], sums[1], np.full(k, np.sqrt(n))]) * np.sqrt(n / m)
    total = [np.bincount(at.ravel(), x.ravel(), k * m).reshape(k, m) for x in series]
    spectrum = np.fft.rfft(np.stack(total) / sums[..., None], 2 * m)
    lean = (spectrum.real**2 + spectrum.imag**2) @ models.toeplitz.T + models.white
    remains = np.maximum(m - lean.sum(axis=0), 1e-2 * m)
    return np.asarray(np.maximum(lean[:2] * (dof[:, None] / remains), 1.0))


def _block_means(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Means over MOST pieces of long series (3, k, n), and the residuals' share of variance left.

    Tilts of the plane are slow along the trace, and only the slow part of the noise tilts it.
    """
    edges = np.linspace(0, series.shape[-1], MOST + 1).astype(np.int64)[:-1]
    sizes = np.diff(np.append(edges, series.shape[-1]))
    means: FloatArray = np.add.reduceat(series, edges, axis=-1) / sizes
    whole = np.maximum((series[2] ** 2).mean(axis=-1), TINY)
    return means, (means[2] ** 2).mean(axis=-1) / whole


def _compare(
    series: FloatArray, dof: FloatArray, models: _Library
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """What every model says of k traces of n points.

    series : (3, k, n) coordinates along e1 and e2, residuals
    Returns the inflation of the variance along e1 and e2 against white noise (2, k, models), its
    degrees of freedom and the models' weights (k, models), and the flag (k,).
    """
    n = series.shape[-1]
    spectrum = np.fft.rfft(series, 2 * n)
    sums = np.maximum((series * series).sum(axis=-1, keepdims=True), TINY)
    # The orthonormal DCT-II is the real part of this one, half a step on.
    squares = (spectrum[..., 1:n] * models.half_step).real ** 2 * (2.0 / n / sums)
    left = np.maximum(1.0 - squares[0] - squares[1], 0.0)
    # How much noise of variance 1 leans on each coordinate, what of it the fit leaves, and on
    # how many degrees of freedom that stands.
    power = (spectrum[:2].real ** 2 + spectrum[:2].imag ** 2) / sums[:2]
    lean = power @ models.toeplitz.T + models.white
    remains = np.maximum(n - models.mean - lean[0] - lean[1], 1e-3 * n)
    freedom = np.minimum(FREEDOM * remains**2 / (left @ models.square.T), n - 3.0)
    freedom[:, 0] = n - 3.0
    share = dof / (n - 3.0)
    g = np.maximum(lean * (dof[:, None] / remains), 1.0)
    # Whittle's likelihood, the scale profiled.
    heard = left[:, :HEARD]
    misfit = (squares[2, :, :HEARD] * (n - 3.0) + FLOOR * heard) @ models.inverse.T
    number = heard.sum(axis=1) * share
    likelihood = -0.5 * (heard @ models.log.T + number[:, None] * np.log(misfit))
    weight = _normalised(SHARPNESS * (likelihood + models.log_weight))
    even = _normalised(likelihood) * PURE
    long = even[:, IS_LONG].sum(axis=1) > 0.5 * even.sum(axis=1)
    return g, freedom * share[:, None], weight, long


def _normalised(logarithms: FloatArray) -> FloatArray:
    weight = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
    result: FloatArray = weight / weight.sum(axis=1, keepdims=True)
    return result


def _mixture_quantile(
    g: FloatArray, freedom: FloatArray, weight: FloatArray, dof: FloatArray
) -> FloatArray:
    """q (2, k) with sum_j weight_j P(F_j > q) = 0.05, F_j Fisher's with 2, freedom_j degrees.

    Newton's steps on the logarithm of the tail against x = log(1 + q), kept between bounds, each
    to its own end: no answer depends on those that are asked for together with it.
    """
    _, k, models = g.shape
    half = np.broadcast_to(0.5 * freedom, g.shape).reshape(-1, models)
    weight = np.broadcast_to(weight, g.shape).reshape(-1, models)
    rate = (dof[:, None] / (g * freedom)).reshape(-1, models)
    # Hundredths of a degree of freedom leave the plane open, whatever the number.
    each = np.log1p(np.expm1(np.minimum(-LOG_LEVEL / half, 500.0)) / rate)
    low, high = each.min(axis=-1), each.max(axis=-1)
    x = np.clip((weight * each).sum(axis=-1), low, high)
    found = np.empty_like(x)
    rows = np.arange(len(x))
    for _ in range(100):
        grown = np.exp(x)[:, None]
        base = 1.0 + rate * (grown - 1.0)
        tail = weight * np.exp(-half * np.log(base))
        value = tail.sum(axis=-1)
        slope = (tail * half * rate * grown / base).sum(axis=-1) / value
        excess = np.log(value) - LOG_LEVEL
        low, high = np.where(excess > 0.0, x, low), np.where(excess > 0.0, high, x)
        step = x + excess / slope
        # The steps' lengths are squared from one to the next, so a short one is the last. Rounding
        # may put it on a bound or beyond: halving would then end as far off as it is allowed to.
        last = np.abs(step - x) <= 1e-7 * x
        inside = (step > low) & (step < high)
        step = np.where(inside | last, step, 0.5 * (low + high))
        found[rows] = step
        going = ~last
        if not going.any():
            break
        rows, x, low, high = rows[going], step[going], low[going], high[going]
        half, weight, rate = half[going], weight[going], rate[going]
    result: FloatArray = np.expm1(found.reshape(2, k))
    return result
