"""Distributions fitted to trace lengths, some of which are censored.

There are two cases. If lengths are censored at random, independently of their value, they are
right-censored data with the likelihood of survival analysis (Lawless 2003, Statistical Models and
Methods for Lifetime Data, 2.2). In a sampling window, long traces are sampled and censored more
often. The likelihood is then that of Laslett (1982), Censoring and edge effects in areal and line
transect sampling of rock joint traces, Mathematical Geology 14, 125-140: a complete trace
contributes its density f, a trace censored at one end its survival S, and a trace censored at both
ends the integral of S beyond its length. The number n of pieces is Poisson distributed with the
mean density * (area + mean length * width).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray

MIN_COMPLETE_TRACES = 5
"""Minimum number of complete lengths for a fit."""
Z95 = 1.959963984540054
MIN_LOG = -700.0


@dataclass(frozen=True)
class Window:
    """Sampling window: area in m2, and mean width across the traces in metres.

    For a window of any shape, the width is half the length of its boundary projected along the
    traces.
    """

    area_m2: float
    width_m: float


@dataclass(frozen=True)
class Parameter:
    """Value with its 95 % interval from `low` to `high` (None if not estimated)."""

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class LengthFit:
    """Distribution fitted to trace lengths.

    Attributes
    ----------
    distribution : {"exponential", "lognormal", "weibull", "power_law"}
    mean_m : Parameter or None
        Mean length with its 95 % interval, m; None if infinite.
    aic, delta_aic : float
        Akaike's criterion (lower is better), and its difference from that of the best fit.
    """

    distribution: str
    parameters: Mapping[str, Parameter]
    mean_m: Parameter | None
    log_likelihood: float
    aic: float
    delta_aic: float = 0.0


@dataclass(frozen=True)
class LengthLaw:
    """Family of distributions of lengths x (n,), given logarithms u (k,) of its parameters.

    Attributes
    ----------
    log_density, log_survival, log_survival_integral : callable
        Logarithms of the density, of the survival S, and of the integral of S from x to infinity.
    log_mean : callable
        Logarithm of the mean; inf if the mean does not exist.
    n_free : int
        Number of free parameters for AIC.
    """

    name: str
    parameters: tuple[str, ...]
    start: Callable[[FloatArray], FloatArray]
    log_density: Callable[[FloatArray, FloatArray], FloatArray]
    log_survival: Callable[[FloatArray, FloatArray], FloatArray]
    log_survival_integral: Callable[[FloatArray, FloatArray], FloatArray]
    log_mean: Callable[[FloatArray], float]
    n_free: int
    constants: Mapping[str, float]


def _exponential() -> LengthLaw:
    def log_survival(x: FloatArray, u: FloatArray) -> FloatArray:
        return -x * math.exp(-u[0])

    return LengthLaw(
        "exponential",
        ("mean_m",),
        start=lambda x: np.array([math.log(x.mean())]),
        log_density=lambda x, u: log_survival(x, u) - u[0],
        log_survival=log_survival,
        log_survival_integral=lambda x, u: log_survival(x, u) + u[0],
        log_mean=lambda u: float(u[0]),
        n_free=1,
        constants={},
    )


def _lognormal() -> LengthLaw:
    from scipy.special import log_ndtr

    def log_density(x: FloatArray, u: FloatArray) -> FloatArray:
        z = (np.log(x) - u[0]) * math.exp(-u[1])
        return np.asarray(-0.5 * z * z - 0.5 * math.log(2 * math.pi) - u[1] - np.log(x))

    def log_survival_integral(x: FloatArray, u: FloatArray) -> FloatArray:
        s = math.exp(u[1])
        z = (u[0] - np.log(x)) / s
        log_total = u[0] + 0.5 * s * s + log_ndtr(z + s)
        log_part = np.log(x) + log_ndtr(z)
        return np.asarray(log_total + np.log(-np.expm1(np.minimum(log_part - log_total, -1e-15))))

    return LengthLaw(
        "lognormal",
        ("median_m", "sigma_log"),
        start=lambda x: np.array([np.log(x).mean(), math.log(max(float(np.log(x).std()), 0.05))]),
        log_density=log_density,
        log_survival=lambda x, u: np.asarray(log_ndtr((u[0] - np.log(x)) * math.exp(-u[1]))),
        log_survival_integral=log_survival_integral,
        log_mean=lambda u: float(u[0] + 0.5 * math.exp(2 * u[1])),
        n_free=2,
        constants={},
    )


def _weibull() -> LengthLaw:
    from scipy.special import gammaincc, gammaln

    def power(x: FloatArray, u: FloatArray) -> FloatArray:
        return np.asarray(np.exp(np.minimum(math.exp(u[1]) * (np.log(x) - u[0]), -MIN_LOG)))

    def log_survival_integral(x: FloatArray, u: FloatArray) -> FloatArray:
        a, z = math.exp(-u[1]), power(x, u)
        fraction = gammaincc(a, z)
        asymptote = (a - 1) * np.log(np.maximum(z, 1e-300)) - z - gammaln(a)
        is_representable = fraction > 1e-290
        return np.asarray(
            u[0]
            - u[1]
            + gammaln(a)
            + np.where(
                is_representable, np.log(np.where(is_representable, fraction, 1.0)), asymptote
            )
        )

    return LengthLaw(
        "weibull",
        ("scale_m", "shape"),
        start=lambda x: np.array([math.log(x.mean()), 0.0]),
        log_density=lambda x, u: (
            u[1] - u[0] + (math.exp(u[1]) - 1) * (np.log(x) - u[0]) - power(x, u)
        ),
        log_survival=lambda x, u: -power(x, u),
        log_survival_integral=log_survival_integral,
        log_mean=lambda u: float(u[0] + gammaln(1 + math.exp(-u[1]))),
        n_free=2,
        constants={},
    )


def _power_law(minimum: float) -> LengthLaw:
    """Return Pareto's law, S = (x / minimum)^-exponent.

    Lengths that are censored below the minimum do not contribute.
    """
    log_minimum = math.log(minimum)

    def log_ratio(x: FloatArray) -> FloatArray:
        return np.maximum(np.log(x) - log_minimum, 0.0)

    def log_survival_integral(x: FloatArray, u: FloatArray) -> FloatArray:
        a = math.exp(u[0])
        if a <= 1:
            return np.full(len(x), np.inf)
        length_below_minimum = np.maximum(minimum - x, 0.0)
        tail = np.exp((1 - a) * log_ratio(x)) * minimum / (a - 1)
        return np.asarray(np.log(tail + length_below_minimum))

    def log_mean(u: FloatArray) -> float:
        a = math.exp(u[0])
        return math.inf if a <= 1 else log_minimum + math.log(a / (a - 1))

    return LengthLaw(
        "power_law",
        ("exponent",),
        start=lambda x: np.array([math.log(1.0 / max(float(log_ratio(x).mean()), 1e-3))]),
        log_density=lambda x, u: u[0] - np.log(x) - math.exp(u[0]) * log_ratio(x),
        log_survival=lambda x, u: -math.exp(u[0]) * log_ratio(x),
        log_survival_integral=log_survival_integral,
        log_mean=log_mean,
        n_free=2,
        constants={"minimum_m": minimum},
    )


def candidate_laws(lengths: FloatArray, cut_counts: IntArray) -> list[LengthLaw]:
    """Return the four laws; the power law starts at the shortest complete length.

    Parameters
    ----------
    lengths : (n,) ndarray
        Lengths in metres.
    cut_counts : (n,) ndarray of int
        Number of censored ends of each trace, 0 to 2.

    Returns
    -------
    list of LengthLaw
    """
    complete_lengths = lengths[cut_counts == 0]
    return [_exponential(), _lognormal(), _weibull(), _power_law(float(complete_lengths.min()))]


def find_law(fit: LengthFit) -> tuple[LengthLaw, FloatArray]:
    """Return the law of a fit and the logarithms of its parameters.

    Parameters
    ----------
    fit : LengthFit

    Returns
    -------
    law : LengthLaw
    logarithms : ndarray
        Logarithms of the fitted parameters.
    """
    minimum = fit.parameters.get("minimum_m")
    laws = [_exponential(), _lognormal(), _weibull()]
    laws += [] if minimum is None else [_power_law(minimum.value)]
    law = next(law for law in laws if law.name == fit.distribution)
    return law, np.log([fit.parameters[name].value for name in law.parameters])


def fit_laws(
    lengths: FloatArray, cut_counts: IntArray, window: Window | None = None
) -> list[LengthFit]:
    """Fit all laws to trace lengths by maximum likelihood.

    Parameters
    ----------
    lengths : (n,) ndarray
        Positive lengths in metres.
    cut_counts : (n,) ndarray of int
        Number of censored ends of each trace, 0 to 2.
    window : Window, optional
        Sampling window of the traces. If None, lengths are assumed to be censored independently of
        their value.

    Returns
    -------
    list of LengthFit
        Fits in order of increasing Akaike (1974) criterion. Empty if there are fewer than
        `MIN_COMPLETE_TRACES` complete lengths, or if these are equal. The 95 % intervals of the
        parameters are derived from the curvature of the log-likelihood with respect to their
        logarithms.
    """
    complete_lengths = lengths[cut_counts == 0]
    if (
        len(complete_lengths) < MIN_COMPLETE_TRACES
        or np.ptp(complete_lengths) <= 1e-9 * complete_lengths.max()
    ):
        return []
    candidates = [
        fit_law(law, lengths, cut_counts, window) for law in candidate_laws(lengths, cut_counts)
    ]
    fits = sorted((fit for fit in candidates if fit is not None), key=lambda fit: fit.aic)
    return [
        LengthFit(
            fit.distribution,
            fit.parameters,
            fit.mean_m,
            fit.log_likelihood,
            fit.aic,
            fit.aic - fits[0].aic,
        )
        for fit in fits
    ]


def fit_law(
    law: LengthLaw, lengths: FloatArray, cut_counts: IntArray, window: Window | None = None
) -> LengthFit | None:
    """Fit one law to trace lengths by maximum likelihood.

    Parameters
    ----------
    law : LengthLaw
    lengths : (n,) ndarray
        Lengths in metres.
    cut_counts : (n,) ndarray of int
        Number of censored ends of each trace, 0 to 2.
    window : Window, optional
        Window in which the traces were mapped.

    Returns
    -------
    LengthFit or None
        None if the likelihood has no maximum, for example for a power law with an infinite mean
        length in a window.
    """
    from scipy.optimize import minimize

    complete_lengths_m, lengths_cut_once, lengths_cut_twice = (
        lengths[cut_counts == k] for k in range(3)
    )
    if window is None:
        lengths_cut_once, lengths_cut_twice = (
            np.concatenate([lengths_cut_once, lengths_cut_twice]),
            lengths_cut_twice[:0],
        )

    def log_likelihood(u: FloatArray) -> float:
        if not (np.abs(u) < 50).all():
            return -math.inf
        with np.errstate(all="ignore"):
            total = float(
                law.log_density(complete_lengths_m, u).sum()
                + law.log_survival(lengths_cut_once, u).sum()
            )
            if window is not None:
                mean = law.log_mean(u)
                if not mean < -MIN_LOG:
                    return -math.inf
                effective_area = window.area_m2 + math.exp(mean) * window.width_m
                total += float(law.log_survival_integral(lengths_cut_twice, u).sum()) - len(
                    lengths
                ) * math.log(effective_area)
        return total if math.isfinite(total) else -math.inf

    start = law.start(complete_lengths_m)
    if window is not None and law.name == "power_law":
        start = np.maximum(start, math.log(1.2))
    steps = np.vstack([start, *(start + 0.3 * row for row in np.eye(len(start)))])
    solution = minimize(
        lambda u: -log_likelihood(u),
        start,
        method="Nelder-Mead",
        options={"initial_simplex": steps, "xatol": 1e-7, "fatol": 1e-9, "maxiter": 2000},
    )
    max_log_likelihood = -float(solution.fun)
    covariance = _covariance(log_likelihood, solution.x)
    if not math.isfinite(max_log_likelihood) or covariance is None:
        return None
    parameters = {
        name: _interval(float(solution.x[i]), math.sqrt(covariance[i, i]))
        for i, name in enumerate(law.parameters)
    }
    parameters.update({name: Parameter(v, None, None) for name, v in law.constants.items()})
    mean = None
    if (log_mean := law.log_mean(solution.x)) < -MIN_LOG:
        slope = _gradient(law.log_mean, solution.x)
        error = float(slope @ covariance @ slope)
        mean = (
            _interval(log_mean, math.sqrt(error))
            if math.isfinite(error)
            else Parameter(math.exp(log_mean), None, None)
        )
    return LengthFit(
        law.name, parameters, mean, max_log_likelihood, 2.0 * law.n_free - 2.0 * max_log_likelihood
    )


def _interval(log_value: float, error: float) -> Parameter:
    return Parameter(*(math.exp(log_value + z * error) for z in (0.0, -Z95, Z95)))


DIFFERENTIATION_STEP = 1e-3


def _gradient(function: Callable[[FloatArray], float], u: FloatArray) -> FloatArray:
    steps = DIFFERENTIATION_STEP * np.eye(len(u))
    return np.array(
        [(function(u + step) - function(u - step)) / (2 * DIFFERENTIATION_STEP) for step in steps]
    )


def _covariance(function: Callable[[FloatArray], float], u: FloatArray) -> FloatArray | None:
    """Return the inverse of the observed information, or None if u is not a maximum."""
    k = len(u)
    steps = DIFFERENTIATION_STEP * np.eye(k)
    hessian = np.empty((k, k))
    for i in range(k):
        for j in range(k):
            a, b = steps[i], steps[j]
            hessian[i, j] = (
                function(u + a + b)
                - function(u + a - b)
                - function(u - a + b)
                + function(u - a - b)
            ) / (4 * DIFFERENTIATION_STEP * DIFFERENTIATION_STEP)
    if not np.isfinite(hessian).all() or (np.linalg.eigvalsh(-hessian) <= 0).any():
        return None
    return np.asarray(np.linalg.inv(-hessian))
