"""Distributions of trace lengths, of which some are known only to be longer than what was seen.

Two situations. Lengths cut off by chance, whatever they are: right-censored data, the likelihood of
survival analysis (Lawless 2003, Statistical Models and Methods for Lifetime Data, 2.2). Traces in a
window: long ones are met more often and cut off more often; the likelihood is that of Laslett
(1982), Censoring and edge effects in areal and line transect sampling of rock joint traces,
Mathematical Geology 14, 125-140: a trace seen whole counts by its density f, one cut off once by
its survival S, one cut off twice by the integral of S beyond, and n pieces are one of a Poisson
number with the mean density * (area + mean length * width).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray

LEAST_COMPLETE = 5
"""Lengths seen whole, below which nothing is fitted."""
_Z95 = 1.959963984540054
_FLOOR = -700.0


@dataclass(frozen=True)
class Window:
    """area_m2 and width_m : across the traces, the mean of what a straight window would show them;
    of a window of any shape half the sum of its edge as seen along the traces"""

    area_m2: float
    width_m: float


@dataclass(frozen=True)
class Parameter:
    """value, with the 95 % interval low to high, None where it is not estimated"""

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Fit:
    """One law. distribution : exponential, lognormal, weibull or power_law; mean_m : with its 95 %
    interval, None where it is infinite; aic : the less the better, delta_aic : above the best"""

    distribution: str
    parameters: Mapping[str, Parameter]
    mean_m: Parameter | None
    log_likelihood: float
    aic: float
    delta_aic: float = 0.0


@dataclass(frozen=True)
class Law:
    """A family of distributions by functions of lengths x (n,) and logarithms u (k,) of its
    parameters: log density, log survival S, log of the integral of S beyond x, log mean (inf where
    there is none). free : how many parameters AIC counts."""

    name: str
    parameters: tuple[str, ...]
    start: Callable[[FloatArray], FloatArray]
    log_f: Callable[[FloatArray, FloatArray], FloatArray]
    log_s: Callable[[FloatArray, FloatArray], FloatArray]
    log_h: Callable[[FloatArray, FloatArray], FloatArray]
    log_mean: Callable[[FloatArray], float]
    free: int
    given: Mapping[str, float]


def _exponential() -> Law:
    def log_s(x: FloatArray, u: FloatArray) -> FloatArray:
        return -x * math.exp(-u[0])

    return Law(
        "exponential",
        ("mean_m",),
        start=lambda x: np.array([math.log(x.mean())]),
        log_f=lambda x, u: log_s(x, u) - u[0],
        log_s=log_s,
        log_h=lambda x, u: log_s(x, u) + u[0],
        log_mean=lambda u: float(u[0]),
        free=1,
        given={},
    )


def _lognormal() -> Law:
    from scipy.special import log_ndtr

    def log_f(x: FloatArray, u: FloatArray) -> FloatArray:
        z = (np.log(x) - u[0]) * math.exp(-u[1])
        return np.asarray(-0.5 * z * z - 0.5 * math.log(2 * math.pi) - u[1] - np.log(x))

    def log_h(x: FloatArray, u: FloatArray) -> FloatArray:
        s = math.exp(u[1])
        z = (u[0] - np.log(x)) / s
        whole = u[0] + 0.5 * s * s + log_ndtr(z + s)
        less = np.log(x) + log_ndtr(z)
        return np.asarray(whole + np.log(-np.expm1(np.minimum(less - whole, -1e-15))))

    return Law(
        "lognormal",
        ("median_m", "sigma_log"),
        start=lambda x: np.array([np.log(x).mean(), math.log(max(float(np.log(x).std()), 0.05))]),
        log_f=log_f,
        log_s=lambda x, u: np.asarray(log_ndtr((u[0] - np.log(x)) * math.exp(-u[1]))),
        log_h=log_h,
        log_mean=lambda u: float(u[0] + 0.5 * math.exp(2 * u[1])),
        free=2,
        given={},
    )


def _weibull() -> Law:
    from scipy.special import gammaincc, gammaln

    def power(x: FloatArray, u: FloatArray) -> FloatArray:
        return np.asarray(np.exp(np.minimum(math.exp(u[1]) * (np.log(x) - u[0]), -_FLOOR)))

    def log_h(x: FloatArray, u: FloatArray) -> FloatArray:
        a, z = math.exp(-u[1]), power(x, u)
        share = gammaincc(a, z)
        far = (a - 1) * np.log(np.maximum(z, 1e-300)) - z - gammaln(a)
        known = share > 1e-290
        return np.asarray(
            u[0] - u[1] + gammaln(a) + np.where(known, np.log(np.where(known, share, 1.0)), far)
        )

    return Law(
        "weibull",
        ("scale_m", "shape"),
        start=lambda x: np.array([math.log(x.mean()), 0.0]),
        log_f=lambda x, u: u[1] - u[0] + (math.exp(u[1]) - 1) * (np.log(x) - u[0]) - power(x, u),
        log_s=lambda x, u: -power(x, u),
        log_h=log_h,
        log_mean=lambda u: float(u[0] + gammaln(1 + math.exp(-u[1]))),
        free=2,
        given={},
    )


def _power_law(minimum: float) -> Law:
    """Pareto's: S = (x / minimum)^-exponent. Lengths cut off below the minimum say nothing."""
    least = math.log(minimum)

    def above(x: FloatArray) -> FloatArray:
        return np.maximum(np.log(x) - least, 0.0)

    def log_h(x: FloatArray, u: FloatArray) -> FloatArray:
        a = math.exp(u[0])
        if a <= 1:
            return np.full(len(x), np.inf)
        below = np.maximum(minimum - x, 0.0)
        tail = np.exp((1 - a) * above(x)) * minimum / (a - 1)
        return np.asarray(np.log(tail + below))

    def log_mean(u: FloatArray) -> float:
        a = math.exp(u[0])
        return math.inf if a <= 1 else least + math.log(a / (a - 1))

    return Law(
        "power_law",
        ("exponent",),
        start=lambda x: np.array([math.log(1.0 / max(float(above(x).mean()), 1e-3))]),
        log_f=lambda x, u: u[0] - np.log(x) - math.exp(u[0]) * above(x),
        log_s=lambda x, u: -math.exp(u[0]) * above(x),
        log_h=log_h,
        log_mean=log_mean,
        free=2,
        given={"minimum_m": minimum},
    )


def laws_for(lengths: FloatArray, cut: IntArray) -> list[Law]:
    """The four laws; the power law begins at the shortest length (n,) that was seen whole."""
    whole = lengths[cut == 0]
    return [_exponential(), _lognormal(), _weibull(), _power_law(float(whole.min()))]


def law_of(fit: Fit) -> tuple[Law, FloatArray]:
    """The law of a fit, with the logarithms of its parameters."""
    least = fit.parameters.get("minimum_m")
    laws = [_exponential(), _lognormal(), _weibull()]
    laws += [] if least is None else [_power_law(least.value)]
    law = next(law for law in laws if law.name == fit.distribution)
    return law, np.log([fit.parameters[name].value for name in law.parameters])


def fit_laws(lengths: FloatArray, cut: IntArray, window: Window | None = None) -> list[Fit]:
    """All laws fitted by maximum likelihood, the best by Akaike's (1974) criterion first.

    lengths : (n,) metres, above 0; cut : (n,) at how many ends each was cut off, 0 to 2. window :
    where the traces were seen; None: lengths cut off independently of what they are. Parameters
    have 95 % intervals by the curvature of the log-likelihood in their logarithms. Empty where
    fewer than LEAST_COMPLETE were seen whole, or all of them are alike.
    """
    whole = lengths[cut == 0]
    if len(whole) < LEAST_COMPLETE or np.ptp(whole) <= 1e-9 * whole.max():
        return []
    found = [fit_law(law, lengths, cut, window) for law in laws_for(lengths, cut)]
    fits = sorted((fit for fit in found if fit is not None), key=lambda fit: fit.aic)
    return [
        Fit(f.distribution, f.parameters, f.mean_m, f.log_likelihood, f.aic, f.aic - fits[0].aic)
        for f in fits
    ]


def fit_law(
    law: Law, lengths: FloatArray, cut: IntArray, window: Window | None = None
) -> Fit | None:
    """One law; None where its likelihood has no maximum, as of a power law in a window whose mean
    length would be infinite."""
    from scipy.optimize import minimize

    whole, once, twice = (lengths[cut == k] for k in range(3))
    if window is None:
        once, twice = np.concatenate([once, twice]), twice[:0]

    def log_likelihood(u: FloatArray) -> float:
        if not (np.abs(u) < 50).all():
            return -math.inf
        with np.errstate(all="ignore"):
            sum_ = float(law.log_f(whole, u).sum() + law.log_s(once, u).sum())
            if window is not None:
                mean = law.log_mean(u)
                if not mean < -_FLOOR:
                    return -math.inf
                met = window.area_m2 + math.exp(mean) * window.width_m
                sum_ += float(law.log_h(twice, u).sum()) - len(lengths) * math.log(met)
        return sum_ if math.isfinite(sum_) else -math.inf

    start = law.start(whole)
    if window is not None and law.name == "power_law":
        start = np.maximum(start, math.log(1.2))
    steps = np.vstack([start, *(start + 0.3 * row for row in np.eye(len(start)))])
    best = minimize(
        lambda u: -log_likelihood(u),
        start,
        method="Nelder-Mead",
        options={"initial_simplex": steps, "xatol": 1e-7, "fatol": 1e-9, "maxiter": 2000},
    )
    top = -float(best.fun)
    spread = _covariance(log_likelihood, best.x)
    if not math.isfinite(top) or spread is None:
        return None
    parameters = {
        name: _interval(float(best.x[i]), math.sqrt(spread[i, i]))
        for i, name in enumerate(law.parameters)
    }
    parameters.update({name: Parameter(v, None, None) for name, v in law.given.items()})
    mean = None
    if (log_mean := law.log_mean(best.x)) < -_FLOOR:
        slope = _slope(law.log_mean, best.x)
        error = float(slope @ spread @ slope)
        mean = (
            _interval(log_mean, math.sqrt(error))
            if math.isfinite(error)
            else Parameter(math.exp(log_mean), None, None)
        )
    return Fit(law.name, parameters, mean, top, 2.0 * law.free - 2.0 * top)


def _interval(log_value: float, error: float) -> Parameter:
    return Parameter(*(math.exp(log_value + z * error) for z in (0.0, -_Z95, _Z95)))


_STEP = 1e-3


def _slope(f: Callable[[FloatArray], float], u: FloatArray) -> FloatArray:
    steps = _STEP * np.eye(len(u))
    return np.array([(f(u + s) - f(u - s)) / (2 * _STEP) for s in steps])


def _covariance(f: Callable[[FloatArray], float], u: FloatArray) -> FloatArray | None:
    """The inverse of the observed information, None where the top is no top."""
    k = len(u)
    steps = _STEP * np.eye(k)
    curve = np.empty((k, k))
    for i in range(k):
        for j in range(k):
            a, b = steps[i], steps[j]
            curve[i, j] = (f(u + a + b) - f(u + a - b) - f(u - a + b) + f(u - a - b)) / (
                4 * _STEP * _STEP
            )
    if not np.isfinite(curve).all() or (np.linalg.eigvalsh(-curve) <= 0).any():
        return None
    return np.asarray(np.linalg.inv(-curve))
