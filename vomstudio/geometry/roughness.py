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

# Correlation lengths as fractions of the trace; beyond the tenth they only serve to be recognised.
LENGTHS = (1 / 80, 1 / 40, 1 / 20, 1 / 14, 1 / 10, 1 / 7, 1 / 4, 1 / 2)
LONG = 0.12
NUGGETS = (0.01, 0.5)
FEWEST = 8  # below this many points nothing can be said about correlation
LOG_LEVEL = np.log(0.05)


def _models() -> tuple[Floats, Floats, Floats, npt.NDArray[np.bool_]]:
    """Length, nugget, prior weight and smoothness of every model but the white one."""
    rows = [
        (length, nugget, smooth)
        for length in LENGTHS
        for nugget in NUGGETS
        for smooth in (False, True)
    ]
    length, nugget, smooth = (np.array(column) for column in zip(*rows, strict=True))
    prior = np.full(len(rows), 1.0 / len(rows))
    return length, nugget, prior, smooth.astype(bool)


LENGTH, NUGGET, PRIOR, SMOOTH = _models()
IS_LONG = np.concatenate([[False], LENGTH > LONG])


def _spectra(n: int) -> tuple[Floats, Floats, Floats]:
    """Expected squared cosine coefficients 1..n-1 of unit noise: S, log S, 1/S, each (models, n-1).

    For correlation rho(h) the expectation of coefficient j of the orthonormal DCT-II is
    1 + 2 sum_h rho(h) [(1 - h/n) cos(t h) - sin(t h) / (n sin t)], t = pi j / n.
    """
    lag = np.arange(n) / (n - 1.0)
    x = lag / LENGTH[:, None]
    rho = np.where(SMOOTH[:, None], np.exp(-0.5 * x * x), np.exp(-x))
    rho[:, 0] = 0.0
    t = np.pi * np.arange(1, n) / n
    cosine = np.fft.rfft(rho * (1.0 - np.arange(n) / n), 2 * n).real[:, 1:n]
    sine = -np.fft.rfft(rho, 2 * n).imag[:, 1:n]
    s = 1.0 + 2.0 * (cosine - sine / (n * np.sin(t)))
    s = (1.0 - NUGGET[:, None]) * s + NUGGET[:, None]
    s = np.maximum(np.vstack([np.ones(n - 1), s]), 1e-6)
    return s, np.log(s), 1.0 / s


_cached_spectra = lru_cache(maxsize=256)(_spectra)


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
        squares = _cosine_squares(np.stack([u[index], v[index], r[index]]))
        g1, g2, weight = _compare(squares, int(n), dof[rows])
        q1[rows] = _mixture_quantile(g1, weight, dof[rows])
        q2[rows] = _mixture_quantile(g2, weight, dof[rows])
        long[rows] = weight[:, IS_LONG].sum(axis=1) > 0.5
        # The number of independent points that would give the same limit.
        n_effective[rows] = 3.0 - 2.0 * LOG_LEVEL / np.log1p(q2[rows])
    return q1, q2, n_effective, long


def _compare(squares: Floats, n: int, dof: Floats) -> tuple[Floats, Floats, Floats]:
    """Inflation of q along e1 and e2 under every model (k, models), and the models' weights."""
    s, log_s, inverse = _cached_spectra(n) if n <= 1024 else _spectra(n)
    sums = squares.sum(axis=-1)
    share = squares[:2] / np.maximum(sums[:2], np.finfo(float).tiny)[..., None]
    left = np.maximum(1.0 - share[0] - share[1], 0.0)
    power = squares[2] @ inverse.T / np.maximum(sums[2], np.finfo(float).tiny)[:, None]
    power = np.maximum(power, np.finfo(float).tiny)
    likelihood = -0.5 * (left @ log_s.T + dof[:, None] * np.log(power))
    prior = np.concatenate([[1.0], PRIOR])
    likelihood += np.log(prior)
    weight = np.exp(likelihood - likelihood.max(axis=1, keepdims=True))
    weight /= weight.sum(axis=1, keepdims=True)
    # Relative to white noise: the model's variance, times how much of it falls on the coordinate.
    g1 = np.maximum(power * (share[0] @ s.T), 1.0)
    g2 = np.maximum(power * (share[1] @ s.T), 1.0)
    return g1, g2, weight


def _mixture_quantile(g: Floats, weight: Floats, dof: Floats) -> Floats:
    """q with sum_k weight_k (1 + q / g_k)^(-dof/2) = 0.05, by Newton steps on a convex function."""
    half = 0.5 * dof[:, None]
    q = np.expm1(-LOG_LEVEL / half[:, 0]) * g.min(axis=1)
    for _ in range(30):
        base = 1.0 + q[:, None] / g
        tail = weight * np.exp(-half * np.log(base))
        value = tail.sum(axis=1)
        slope = (tail * half / (base * g)).sum(axis=1)
        # log(value) is close to linear in log(1 + q): step there, from below.
        step = (np.log(value) - LOG_LEVEL) * value / slope
        q = q + step
        if np.all(np.abs(step) <= 1e-9 * (q + 1e-300)):
            break
    return q
