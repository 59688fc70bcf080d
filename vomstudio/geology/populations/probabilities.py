"""Tail probabilities of common distributions in closed form or as continued fractions.

Importing scipy.special takes longer than running a command on a small table. Chi-square with an
integer number of degrees of freedom has a closed form (Abramowitz & Stegun 1964, 26.4.4 and
26.4.5). F and Student's t are incomplete beta functions (26.5.8, with Lentz's evaluation of the
continued fraction; Press and others 2007, Numerical recipes, 6.4).
"""

from __future__ import annotations

import math
from functools import lru_cache

MAX_STEPS = 400
MIN_VALUE = 1e-300


def chi2_tail(degrees_of_freedom: int, chi_square: float) -> float:
    """Return the upper tail probability of a chi-square value.

    Parameters
    ----------
    degrees_of_freedom : int
        Degrees of freedom.
    chi_square : float
        Value of chi-square.

    Returns
    -------
    float
    """
    if chi_square <= 0.0:
        return 1.0
    half_statistic = chi_square / 2.0
    series_sum, term = 0.0, 0.0
    if degrees_of_freedom % 2:
        series_sum = math.erfc(math.sqrt(half_statistic))
        term = math.exp(-half_statistic) * math.sqrt(half_statistic) / math.gamma(1.5)
        for k in range((degrees_of_freedom - 1) // 2):
            series_sum += term
            term *= half_statistic / (k + 1.5)
        return min(series_sum, 1.0)
    term = math.exp(-half_statistic)
    for k in range(degrees_of_freedom // 2):
        series_sum += term
        term *= half_statistic / (k + 1.0)
    return min(series_sum, 1.0)


def f_tail(numerator_dof: float, denominator_dof: float, ratio: float) -> float:
    """Return the upper tail probability of an F value.

    Parameters
    ----------
    numerator_dof, denominator_dof : float
        Degrees of freedom.
    ratio : float
        Value of F.

    Returns
    -------
    float
    """
    if ratio <= 0.0:
        return 1.0
    return _incomplete_beta(
        denominator_dof / 2.0,
        numerator_dof / 2.0,
        denominator_dof / (denominator_dof + numerator_dof * ratio),
    )


@lru_cache(maxsize=1024)
def t95(degrees_of_freedom: float) -> float:
    """Return the two-sided 95 % quantile of Student's t.

    Parameters
    ----------
    degrees_of_freedom : float
        Degrees of freedom.

    Returns
    -------
    float
    """
    low, high = 0.0, 13.0
    while f_tail(1.0, degrees_of_freedom, high**2) > 0.05:
        high *= 2.0
    for _ in range(50):
        centre = 0.5 * (low + high)
        low, high = (
            (centre, high) if f_tail(1.0, degrees_of_freedom, centre**2) > 0.05 else (low, centre)
        )
    return 0.5 * (low + high)


def _incomplete_beta(a: float, b: float, x: float) -> float:
    """Return the regularised incomplete beta function I_x(a, b)."""
    if x <= 0.0 or x >= 1.0:
        return 0.0 if x <= 0.0 else 1.0
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - _incomplete_beta(b, a, 1.0 - x)
    log_prefactor = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b)
    log_prefactor += a * math.log(x) + b * math.log1p(-x)
    c, d = 1.0, 1.0 / _replace_zero(1.0 - (a + b) * x / (a + 1.0))
    fraction = d
    for m in range(1, MAX_STEPS):
        even_step = m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m))
        odd_step = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0))
        previous_fraction = fraction
        for step in (even_step, odd_step):
            d = 1.0 / _replace_zero(1.0 + step * d)
            c = _replace_zero(1.0 + step / c)
            fraction *= c * d
        if abs(fraction - previous_fraction) < 1e-15 * abs(fraction):
            break
    return math.exp(log_prefactor) * fraction / a


def _replace_zero(value: float) -> float:
    return value if abs(value) > MIN_VALUE else MIN_VALUE
