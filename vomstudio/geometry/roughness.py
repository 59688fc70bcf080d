"""How much the residuals of a trace depend on each other, and what that costs.

Neighbouring points of a trace share the roughness of the surface, so n points are worth fewer. The
residuals' cosine spectrum is compared with a small family of roughness models (none; exponential
and Gaussian correlation of several lengths, with and without white picking noise), the fit's own
appetite taken into account: each cosine counts with the share the fit has left in it. Each
model says how far the fitted plane may tilt; the tail of their mixture, weighted by how well each
explains the residuals, gives the 95 % limit. No length is selected, so a doubtful one costs width,
not coverage.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

# Correlation lengths as fractions of the trace. Those beyond a tenth cannot be told from the plane
# itself by looking at what the fit has left; they are there to be recognised, with little weight.
SHORT = tuple(0.1 * 0.5 ** (i / 2) for i in range(-1, 9))
LONG = (1 / 4, 1 / 2)
SLOPE = 0.5
WEIGHT_WHITE = 0.7
WEIGHT_LONG = 0.01
WEIGHT_MIXED = 0.25  # share, among the short ones, of those with as much white noise on top
# White variance added to data and models alike: no model may stand or fall with frequencies in
# which nothing happens, and no surface is as smooth as a Gaussian correlation would have it.
FLOOR = 0.03
TEMPER = 1.0
FEWEST = 8  # below this many points nothing can be said about correlation
LOG_LEVEL = np.log(0.05)


def _models() -> tuple[Floats, Floats, Bools, Floats, Floats]:
    """Length, white share, smoothness and two weights (width, flag) of all but the white model."""
    rows: list[tuple[float, float, bool, float]] = []
    for smooth in (False, True):
        for white, share in ((0.0, 1.0 - WEIGHT_MIXED), (0.5, WEIGHT_MIXED)):
            total = sum(length**SLOPE for length in SHORT)
            weight = (1.0 - WEIGHT_WHITE - WEIGHT_LONG) * share / (2 * total)
            rows += [(length, white, smooth, weight * length**SLOPE) for length in SHORT]
        rows += [(length, 0.0, smooth, WEIGHT_LONG / (2 * len(LONG))) for length in LONG]
    length, white_share, smoothness, weights = (np.array(c) for c in zip(*rows, strict=True))
    flat = np.where(white_share == 0.0, 1.0, 0.0)
    return length, white_share, smoothness, weights, flat


LENGTH, WHITE, SMOOTH, WEIGHT, FLAT = _models()
LOG_WEIGHT = np.log(np.concatenate([[WEIGHT_WHITE], WEIGHT]))
FLAT_WEIGHT = np.concatenate([[1.0], FLAT])
IS_LONG = np.concatenate([[False], LENGTH > 0.11])


class _Library:
    """What the models expect of a trace of n evenly spaced points.

    log, inverse : (models, n - 1) of the expected squared coefficients 1..n-1 of the orthonormal
        cosine transform (DCT-II) of noise of variance 1, floor added
    square : (models, n - 1) those coefficients squared, no floor
    toeplitz : (models, n + 1) weights that turn the power spectrum of a series padded to 2 n, as of
        rfft, into the quadratic form series' R series of its correlation matrix R
    mean : (models,) that form for the constant series of norm 1
    """

    def __init__(self, n: int) -> None:
        h = np.arange(n) / (n - 1.0) / LENGTH[:, None]
        rho = np.where(SMOOTH[:, None], np.exp(-0.5 * h * h), np.exp(-h)) * (1 - WHITE)[:, None]
        rho = np.vstack([np.zeros(n), rho])
        rho[:, 0] = 0.0
        # Coefficient j: 1 + 2 sum_h rho(h) [(1 - h / n) cos(t h) - sin(t h) / (n sin t)],
        # t = pi j / n.
        t = np.pi * np.arange(1, n) / n
        cosine = np.fft.rfft(rho * (1.0 - np.arange(n) / n), 2 * n).real[:, 1:n]
        transform = np.fft.rfft(rho, 2 * n)
        sine = -transform.imag[:, 1:n]
        s = np.maximum(1.0 + 2.0 * (cosine - sine / (n * np.sin(t))), 0.0)
        self.mean = 1.0 + 2.0 * (rho * (1.0 - np.arange(n) / n)).sum(axis=1)
        # Scaled to leave a variance of 1 when a fit has taken the two lowest of them.
        remains = np.maximum(n - self.mean - s[:, 0] - s[:, 1], 1e-3 * n)
        scaled = s * ((n - 3.0) / remains)[:, None] + FLOOR
        self.log = np.log(scaled)
        self.inverse = 1.0 / scaled
        self.square = s * s
        weight = np.full(n + 1, 2.0)
        weight[[0, n]] = 1.0
        self.toeplitz = (1.0 + 2.0 * transform.real) * weight / (2 * n)


_library = lru_cache(maxsize=256)(_Library)


def _cosine_squares(x: Floats) -> Floats:
    """Squared coefficients 1..n-1 of the orthonormal DCT-II along the last axis."""
    n = x.shape[-1]
    shuffled = np.concatenate([x[..., ::2], x[..., 1::2][..., ::-1]], axis=-1)
    spectrum = np.fft.fft(shuffled, axis=-1)[..., 1:]
    turn = np.exp(-0.5j * np.pi * np.arange(1, n) / n)
    c: Floats = (spectrum * turn).real
    return c * c * (2.0 / n)


def inflate(
    u: Floats,
    v: Floats,
    r: Floats,
    starts: npt.NDArray[np.int64],
    counts: npt.NDArray[np.int64],
    dof: Floats,
    white: Floats,
) -> tuple[Floats, Floats, Floats, Bools]:
    """See plane_errors.quantiles; `white` is the answer for independent points."""
    q1, q2 = white.copy(), white.copy()
    n_effective = dof + 3.0
    long = np.zeros(len(dof), bool)
    for n in np.unique(counts):
        if n < FEWEST:
            continue
        rows = np.flatnonzero((counts == n) & (dof > 0))
        if not len(rows):
            continue
        index = starts[rows][:, None] + np.arange(n)
        series = np.stack([u[index], v[index], r[index]])
        g1, g2, freedom, weight, long[rows] = _compare(series, int(n), dof[rows])
        q1[rows] = _mixture_quantile(g1, freedom, weight, dof[rows])
        q2[rows] = _mixture_quantile(g2, freedom, weight, dof[rows])
        # The number of independent points that would give the same limit.
        n_effective[rows] = 3.0 - 2.0 * LOG_LEVEL / np.log1p(q2[rows])
    return q1, q2, n_effective, long


def _compare(series: Floats, n: int, dof: Floats) -> tuple[Floats, Floats, Floats, Floats, Bools]:
    """Inflation of q along e1 and e2 under every model (k, models), its degrees of freedom, the
    models' weights, and the flag."""
    models = _library(n) if n <= 1024 else _Library(n)
    squares = _cosine_squares(series)
    sums = np.maximum(squares.sum(axis=-1), np.finfo(np.float64).tiny)
    relative = squares / sums[..., None]
    left = np.maximum(1.0 - relative[0] - relative[1], 0.0)
    # How much noise of variance 1 leans on each coordinate, what of it the fit leaves, and on
    # how many degrees of freedom that stands.
    power = np.abs(np.fft.rfft(series[:2], 2 * n)) ** 2 / sums[:2, :, None]
    lean1, lean2 = power[0] @ models.toeplitz.T, power[1] @ models.toeplitz.T
    remains = np.maximum(n - models.mean - lean1 - lean2, 1e-3 * n)
    misfit = (relative[2] * (n - 3.0) + FLOOR * left) @ models.inverse.T
    likelihood = -0.5 * TEMPER * (left @ models.log.T + dof[:, None] * np.log(misfit))
    weight = _normalised(likelihood + LOG_WEIGHT)
    flat = _normalised(likelihood) * FLAT_WEIGHT
    long = flat[:, IS_LONG].sum(axis=1) > 0.5 * flat.sum(axis=1)
    freedom = np.minimum(remains**2 / (left @ models.square.T), n - 3.0)
    scale = dof[:, None] / remains
    g1 = np.maximum(scale * lean1, 1.0)
    g2 = np.maximum(scale * lean2, 1.0)
    return g1, g2, freedom * (dof / (n - 3.0))[:, None], weight, long


def _normalised(logarithms: Floats) -> Floats:
    weight = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
    result: Floats = weight / weight.sum(axis=1, keepdims=True)
    return result


def _mixture_quantile(g: Floats, freedom: Floats, weight: Floats, dof: Floats) -> Floats:
    """q with sum_k weight_k P(F_k > q) = 0.05, each Fisher's law with 2 and freedom_k degrees.

    Bisection on log(1 + q): the tails fall over many orders of magnitude.
    """
    half = 0.5 * freedom
    rate = dof[:, None] / (g * freedom)
    each = np.expm1(-LOG_LEVEL / half) / rate
    low, high = np.log1p(each.min(axis=1)), np.log1p(each.max(axis=1))
    for _ in range(40):
        middle = 0.5 * (low + high)
        tail = (weight * np.exp(-half * np.log1p(rate * np.expm1(middle)[:, None]))).sum(axis=1)
        above = tail > 0.05
        low, high = np.where(above, middle, low), np.where(above, high, middle)
        if np.all(high - low <= 1e-6 * high):
            break
    result: Floats = np.expm1(high)
    return result
