"""95 % intervals of fracture densities and spacings, including those of clustered traces.

A density is a sum of weights over the traces: 1 per trace (P20), the trace length (P21), the number
of crossings (P10) or Terzaghi's weights. For independent traces, the sum is compound Poisson
distributed, and the interval is the gamma interval of Fay & Feuer (1997, Statistics in Medicine 16,
791-801). For equal weights, this is the exact Poisson interval of Garwood (1936, Biometrika 28,
437-442).

Clustered traces vary more. The dispersion is the ratio of the variance between parts of the area or
scanline to the variance of independent traces. The interval is then that of fewer traces whose
weights are larger by this factor (quasi-likelihood, Wedderburn 1974, Biometrika 61, 439-447).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray

Interval = tuple[float | None, float | None]
UNKNOWN_INTERVAL: Interval = (None, None)

CELLS_PER_SIDE = (2, 3)
"""Numbers of cells along each side of the area for variance estimates, coarse and fine."""

PARTS_PER_LINE = (4, 8)
"""Numbers of parts of a scanline for variance estimates, coarse and fine."""

MIN_DISPERSION_COUNT = 5
"""Minimum number of traces or gaps for detecting clustering."""

STUDENT_FACTOR = (2.306 / 1.960) ** 2
"""Squared ratio of Student's 95 % quantile with 8 degrees of freedom (because the dispersion is
estimated from nine cells) to that of the normal distribution.
"""

REGULAR_SIGNIFICANCE = 0.05
TAIL_PROBABILITY = 0.025


def density_interval(weights: FloatArray, size: float, dispersion: float = 1.0) -> Interval:
    """Return the 95 % interval of a sum of trace weights per area or length.

    Parameters
    ----------
    weights : (n,) ndarray
        Non-negative weights, one per trace.
    size : float
        Area in m2, or length of the scanline in metres.
    dispersion : float
        Variance as a multiple of that of independent traces, at least 1.

    Returns
    -------
    low, high : float
        None for `high` if no trace has a positive weight.
    """
    from scipy.special import gammaincinv

    positive_weights = weights[weights > 0]
    if not len(positive_weights):
        return 0.0, None
    total_weight = float(positive_weights.sum())
    inflation = 1.0 + STUDENT_FACTOR * (dispersion - 1.0)
    variance = inflation * float(np.sum(positive_weights**2))
    inflated_max_weight = inflation * float(positive_weights.max())
    low = variance / total_weight * float(gammaincinv(total_weight**2 / variance, TAIL_PROBABILITY))
    upper_total, variance = total_weight + inflated_max_weight, variance + inflated_max_weight**2
    high = (
        variance
        / upper_total
        * float(gammaincinv(upper_total**2 / variance, 1.0 - TAIL_PROBABILITY))
    )
    return low / size, high / size


def empty_interval(size: float) -> Interval:
    """Return the exact interval of a number per area or length if the count is zero.

    Parameters
    ----------
    size : float
        Area in m2, or length in metres.

    Returns
    -------
    Interval
    """
    return 0.0, -math.log(TAIL_PROBABILITY) / size


def area_dispersion(positions: FloatArray, weights: FloatArray, area: Any) -> float:
    """Return the dispersion of trace weights between the cells of an area.

    Parameters
    ----------
    positions : (n, 2) ndarray
        One point per trace, m.
    weights : (n,) ndarray
        Weights of the traces.
    area : shapely polygon

    Returns
    -------
    float
        Ratio of the variance to that of independent traces, at least 1: the maximum for cells of
        several sizes.
    """
    import shapely

    if len(positions) < MIN_DISPERSION_COUNT:
        return 1.0
    low_x, low_y, high_x, high_y = area.bounds
    dispersion = 1.0
    for n_cells in CELLS_PER_SIDE:
        x, y = (np.linspace(a, b, n_cells + 1) for a, b in ((low_x, high_x), (low_y, high_y)))
        column, row = (
            np.clip(np.searchsorted(edges, values, side="right") - 1, 0, n_cells - 1)
            for edges, values in ((x, positions[:, 0]), (y, positions[:, 1]))
        )
        cell = row * n_cells + column
        sums = np.asarray(np.bincount(cell, weights, minlength=n_cells**2), np.float64)
        left, bottom = (grid.ravel() for grid in np.meshgrid(x[:-1], y[:-1]))
        right, top = (grid.ravel() for grid in np.meshgrid(x[1:], y[1:]))
        cells = shapely.intersection(shapely.box(left, bottom, right, top), area)
        dispersion = max(
            dispersion, _dispersion(sums, shapely.area(cells), float(np.sum(weights**2)))
        )
    return dispersion


def line_dispersion(positions_m: FloatArray, length_m: float) -> float:
    """Return the dispersion of the number of crossings along a scanline.

    See `area_dispersion` for the definition.

    Parameters
    ----------
    positions_m : (n,) ndarray
        Positions of the crossings along the line, m.
    length_m : float

    Returns
    -------
    float
    """
    n = len(positions_m)
    if n < MIN_DISPERSION_COUNT:
        return 1.0
    dispersion = 1.0
    for parts in PARTS_PER_LINE:
        part_indices = np.clip((positions_m / length_m * parts).astype(np.int64), 0, parts - 1)
        sums = np.bincount(part_indices, minlength=parts).astype(np.float64)
        dispersion = max(dispersion, _dispersion(sums, np.ones(parts), float(n)))
    return dispersion


def _dispersion(sums: FloatArray, sizes: FloatArray, variance: float) -> float:
    """Return the dispersion of sums (k,) over parts, given the variance of the total."""
    shares = sizes / sizes.sum()
    expected_variance = variance * (1.0 - float(np.sum(shares**2)))
    if expected_variance <= 0.0:
        return 1.0
    return float(np.sum((sums - sums.sum() * shares) ** 2)) / expected_variance


def crossings_per_trace(trace: IntArray) -> FloatArray:
    """Return the number of crossings of each trace that crosses a scanline.

    Parameters
    ----------
    trace : (n,) ndarray of int
        Trace index of each crossing.

    Returns
    -------
    (k,) ndarray
    """
    counts = np.unique(trace, return_counts=True)[1]
    return np.asarray(counts, np.float64)


def are_regular(gaps: FloatArray, repeats: float = 1.0) -> bool:
    """Return whether gaps are significantly more regular than those of random positions.

    The test is that of Moran (1951, Journal of the Royal Statistical Society B 13, 147-150) for
    exponential gaps, with Bartlett's statistic.

    Parameters
    ----------
    gaps : (n,) ndarray
    repeats : float, optional
        Number of gaps per independent gap.

    Returns
    -------
    bool
    """
    from scipy.special import gammainc

    n = len(gaps) / repeats
    if n < MIN_DISPERSION_COUNT or not (gaps > 0).all():
        return False
    unevenness = math.log(float(gaps.mean())) - float(np.log(gaps).mean())
    statistic = 2.0 * n * max(unevenness, 0.0) / (1.0 + (n + 1.0) / (6.0 * n))
    return float(gammainc((n - 1.0) / 2.0, statistic / 2.0)) < REGULAR_SIGNIFICANCE


def regular_half_width(coefficient_of_variation: float, n_gaps: float) -> float:
    """Return the half-width of the 95 % interval of the logarithm of a mean gap.

    Parameters
    ----------
    coefficient_of_variation : float
        Coefficient of variation of the gaps.
    n_gaps : float
        Number of gaps, from which the quantile of Student's t follows.

    Returns
    -------
    float
    """
    from scipy.special import stdtrit

    return (
        float(stdtrit(n_gaps - 1.0, 1.0 - TAIL_PROBABILITY))
        * coefficient_of_variation
        / math.sqrt(n_gaps)
    )
