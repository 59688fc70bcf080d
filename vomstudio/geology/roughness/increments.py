"""Surface roughness from second differences, and the direction of least roughness.

z(x + h) - 2 z(x) + z(x - h) is independent of tilt, so the subtracted plane is irrelevant. On a
self-affine surface, the mean square of this difference increases as |h|^(2 H) with the Hurst
exponent H (Kent & Wood 1997, Journal of the Royal Statistical Society B 59, 679-699; for surfaces
and by direction Chan & Wood 2000, Statistica Sinica 10, 343-376; Davies & Hall 1999, ibid. B 61,
3-37). Fault surfaces have an H of about 0.6 along slip and 0.8 across it (Candela et al. 2012,
Journal of Geophysical Research 117, B08409), and are smoothest along slip (Renard et al. 2006,
Geophysical Research Letters 33, L04305).

Errors are jackknife errors over sixteen parts of the surface. Wavelengths longer than a quarter of
the surface are not resolved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

N_DIRECTIONS = 18
PARTS_PER_SIDE = 4
MAX_LAG_DIVISOR = 10.0
"""Ratio of the surface size to the longest lag, at which both differences are in the same part of
the surface, or nearly so.
"""
MIN_LAG_RATIO = 3.0
"""Minimum ratio of the longest to the shortest lag for fitting an exponent."""
N_LAGS = 8
MIN_COUNT = 50
MIN_NOISE_RATIO = 4.0
"""Minimum ratio of the mean square of second differences to that of noise. Above it, noise changes
the increase with distance by less than a quarter.
"""
NOISE_FACTOR = 6.0
"""Variance of a second difference of noise, relative to that of the noise: 1 + 4 + 1 = 6."""
PART_CORRELATION_FACTOR = 1.44
"""Factor for the variance among parts, because adjacent parts are correlated; from simulations of
self-affine surfaces with H from 0.3 to 0.9, for a coverage of 95 %.
"""
MAX_BEND = 0.2
"""Maximum bend of the slope for a single exponent (own choice); above it, the surface has a
characteristic length, like grooves and waves. None of 160 self-affine surfaces had a bend above
0.06.
"""
SIGNIFICANCE = 0.01
"""Significance level for a direction; one isotropic surface in a hundred is misclassified."""


@dataclass(frozen=True, eq=False)
class Variations:
    """Mean squares of second differences by direction and distance.

    Attributes
    ----------
    angles_deg : (d,) ndarray
        Directions in degrees, measured from the column axis toward the row axis.
    lags : (k,) ndarray
        Distances in ascending order, m.
    sums, counts : (d, k, parts) ndarray
        Sums of the squares in m2, and numbers of squares, in each part of the surface.
    lengths, directions_deg : (d, k) ndarray
        Actual distances (m) and directions (degrees) that the cells allow.
    """

    angles_deg: FloatArray
    lags: FloatArray
    sums: FloatArray
    counts: FloatArray
    lengths: FloatArray
    directions_deg: FloatArray

    def mean_squares(self) -> FloatArray:
        """Return the mean squares (d, k) over the whole surface; NaN if there are too few."""
        counts = self.counts.sum(axis=2)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(counts >= MIN_COUNT, self.sums.sum(axis=2) / counts, np.nan)


@dataclass(frozen=True)
class Exponent:
    """Hurst exponent with its 95 % error, for distances from `from_m` to `to_m`.

    `short` and `long` are the exponents for the shorter and the longer half of the distances.
    `bend` is the part of their difference that exceeds its 95 % error; half of it is included in
    `error95`.
    """

    H: float
    error95: float
    from_m: float
    to_m: float
    short: float
    long: float
    bend: float

    @property
    def is_single(self) -> bool:
        """Whether a single exponent describes all distances."""
        return self.bend <= MAX_BEND


@dataclass(frozen=True)
class DirectionExponent:
    """Hurst exponent along a direction.

    The direction is measured from the column axis toward the row axis, degrees.
    """

    angle_deg: float
    H: float
    error95: float


@dataclass(frozen=True)
class SmoothestDirection:
    """Direction in which the surface is smoothest.

    Attributes
    ----------
    angle_deg, error95_deg : float
        Direction in [0, 180) degrees, measured from the column axis toward the row axis, and its
        95 % error.
    ratio : float
        Ratio of the RMS second differences across this direction to those along it.
    p : float
        p-value for the hypothesis of isotropy.
    """

    angle_deg: float
    error95_deg: float
    ratio: float
    p: float

    @property
    def is_significant(self) -> bool:
        return self.p < SIGNIFICANCE


def measure_variations(heights: FloatArray, cell: float, shortest_lag: float) -> Variations | None:
    """Measure the second differences of a height raster in `N_DIRECTIONS` directions.

    Parameters
    ----------
    heights : (rows, columns) ndarray
        Heights in metres; NaN if unknown.
    cell : float
        Side length of a cell, m.
    shortest_lag : float
        Shortest distance, m.

    Returns
    -------
    Variations or None
        None if the surface is too small for a lag ratio of `MIN_LAG_RATIO`.
    """
    rows, columns = _known_extent(heights)
    longest_lag = min(rows, columns) * cell / MAX_LAG_DIVISOR
    shortest_lag = max(shortest_lag, 2.0 * cell)
    if longest_lag < MIN_LAG_RATIO * shortest_lag:
        return None
    lags = np.geomspace(shortest_lag, longest_lag, N_LAGS)
    angles = np.arange(N_DIRECTIONS) * 180.0 / N_DIRECTIONS
    part = _part_indices(heights.shape)
    shape = (len(angles), len(lags))
    sums = np.zeros((*shape, PARTS_PER_SIDE**2))
    counts = np.zeros_like(sums)
    lengths, directions_deg = np.zeros(shape), np.zeros(shape)
    for i, angle in enumerate(np.radians(angles)):
        for j, lag in enumerate(lags):
            column_step = round(float(lag * np.cos(angle)) / cell)
            row_step = round(float(lag * np.sin(angle)) / cell)
            lengths[i, j] = cell * float(np.hypot(column_step, row_step))
            directions_deg[i, j] = float(np.degrees(np.arctan2(row_step, column_step)))
            squares, part_indices = _second_differences(heights, part, column_step, row_step)
            sums[i, j] = np.bincount(part_indices, squares, PARTS_PER_SIDE**2)
            counts[i, j] = np.bincount(part_indices, minlength=PARTS_PER_SIDE**2)
    return Variations(angles, lags, sums, counts, lengths, directions_deg)


def fit_exponent(
    variations: Variations, noise: float, missing_variance: float = 0.0
) -> Exponent | None:
    """Fit the Hurst exponent over all directions and all distances not dominated by noise.

    Parameters
    ----------
    variations : Variations
    noise : float
        Standard deviation of the noise of the model, m.
    missing_variance : float
        Variance that is missing from the raster between its points (`gaps.missing_variance`), m2.
        It is added; half the effect of this correction is included in the error.

    Returns
    -------
    Exponent or None
        None if there are too few distances or data, or if the ratio of the longest to the shortest
        of these distances is below `MIN_LAG_RATIO`.
    """
    all_directions = np.arange(len(variations.angles_deg))
    return _fit_exponent(variations, noise, all_directions, NOISE_FACTOR * missing_variance)


def fit_directional_exponents(
    variations: Variations, noise: float, missing_variance: float = 0.0
) -> list[DirectionExponent]:
    """Fit the Hurst exponent along each direction.

    Directions in which a fit is not possible, or in which no single exponent describes all
    distances, are omitted.

    Parameters
    ----------
    variations : Variations
    noise : float
        Standard deviation of the noise, m.
    missing_variance : float, optional
        Variance that is missing from the model, m2.

    Returns
    -------
    list of DirectionExponent
    """
    exponents = []
    for i, angle in enumerate(variations.angles_deg.tolist()):
        exponent = _fit_exponent(variations, noise, np.array([i]), NOISE_FACTOR * missing_variance)
        if exponent is not None and exponent.is_single:
            exponents.append(DirectionExponent(angle, exponent.H, exponent.error95))
    return exponents


def find_smoothest_direction(variations: Variations, noise: float) -> SmoothestDirection | None:
    """Find the direction in which the second differences are smallest.

    It is computed from the second harmonic of their mean squares.

    Returns
    -------
    SmoothestDirection or None
        None if noise dominates at all distances, if more than half of the parts of the surface have
        too few data, or if there is no difference between the directions.
    """
    is_resolved = _is_resolved(variations, noise)
    if not is_resolved.any():
        return None
    sums, counts = variations.sums[:, is_resolved], variations.counts[:, is_resolved]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(counts >= MIN_COUNT / 2, sums / counts, np.nan)
    is_complete = np.isfinite(mean).all(axis=(0, 1))
    if is_complete.sum() < PARTS_PER_SIDE**2 / 2:
        return None
    harmonics = _harmonics(variations, is_resolved, mean[:, :, is_complete]).mean(axis=1)
    n = harmonics.shape[1]
    mean_harmonic = harmonics.mean(axis=1)
    amplitude = float(np.hypot(*mean_harmonic))
    covariance = PART_CORRELATION_FACTOR * np.cov(harmonics) / n
    roughest_deg = 0.5 * float(np.degrees(np.arctan2(mean_harmonic[1], mean_harmonic[0])))
    if amplitude == 0.0:
        return None
    cross_direction = np.array([-mean_harmonic[1], mean_harmonic[0]]) / amplitude
    error = (
        float(np.sqrt(max(cross_direction @ covariance @ cross_direction, 0.0))) / amplitude / 2.0
    )
    p = _hotelling_p(mean_harmonic, covariance, n)
    ratio = _roughness_ratio(variations, is_resolved, roughest_deg)
    return SmoothestDirection(
        float((roughest_deg + 90.0) % 180.0),
        float(min(np.degrees(_t95(n - 1) * error), 90.0)),
        ratio,
        p,
    )


def resolved_range(variations: Variations, noise: float) -> tuple[float, float] | None:
    """Return the range of distances at which noise does not dominate.

    Parameters
    ----------
    variations : Variations
    noise : float
        Standard deviation of the noise, m.

    Returns
    -------
    tuple of float or None
        Shortest and longest distance, m; None if noise dominates at all distances.
    """
    resolved_rows = np.flatnonzero(_is_resolved(variations, noise))
    return (
        (float(variations.lags[resolved_rows[0]]), float(variations.lags[resolved_rows[-1]]))
        if len(resolved_rows)
        else None
    )


def _harmonics(variations: Variations, is_resolved: BoolArray, squares: FloatArray) -> FloatArray:
    """Return the second harmonic (2, k, n) of mean squares, relative to their mean.

    The mean squares have the shape (d, k, n). The cosine and sine terms are fitted by least
    squares, because cells do not permit regular steps of direction and length.
    """
    lag_rows = np.flatnonzero(is_resolved)
    growth = 2.0 * _mean_exponent(variations, lag_rows)
    harmonics = np.empty((2, len(lag_rows), squares.shape[2]))
    for j, k in enumerate(lag_rows.tolist()):
        doubled_angles = 2.0 * np.radians(variations.directions_deg[:, k])
        columns = np.stack(
            [np.ones(len(doubled_angles)), np.cos(doubled_angles), np.sin(doubled_angles)], axis=1
        )
        normalized_squares = (
            squares[:, j] * ((variations.lags[k] / variations.lengths[:, k]) ** growth)[:, None]
        )
        mean, *coefficients = np.linalg.lstsq(columns, normalized_squares, rcond=None)[0]
        harmonics[:, j] = np.stack(coefficients) / mean
    return harmonics


def _mean_exponent(variations: Variations, lag_rows: IntArray) -> float:
    squares = np.nanmean(variations.mean_squares()[:, lag_rows], axis=0)
    if len(lag_rows) < 2:
        return 0.7
    return float(
        np.clip(_slope(variations.lengths[:, lag_rows].mean(axis=0), squares) / 2.0, 0.0, 2.0)
    )


def _roughness_ratio(variations: Variations, is_resolved: BoolArray, roughest_deg: float) -> float:
    """Return the root of the ratio of mean squares across and along the smoothest direction.

    The ratio is derived from the second harmonic of their logarithms.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(variations.mean_squares()[:, is_resolved])
    doubled_angles = 2.0 * np.radians(variations.directions_deg[:, is_resolved] - roughest_deg)
    return float(np.exp(np.nanmean(2.0 * np.nanmean(np.cos(doubled_angles) * logs, axis=0))))


def _fit_exponent(
    variations: Variations, noise: float, directions: IntArray, missing_variance: float
) -> Exponent | None:
    """Fit the exponent over the given directions, or return None if this is not possible.

    `missing_variance` is added to the mean squared second differences, m2.
    """
    is_resolved = _is_resolved(variations, noise)
    sums = variations.sums[directions][:, is_resolved].sum(axis=0)
    counts = variations.counts[directions][:, is_resolved].sum(axis=0)
    lengths = variations.lengths[directions][:, is_resolved].mean(axis=0)
    is_sufficient = counts.sum(axis=1) >= MIN_COUNT
    sums, counts, lengths = sums[is_sufficient], counts[is_sufficient], lengths[is_sufficient]
    if len(lengths) < 3 or lengths[-1] < MIN_LAG_RATIO * lengths[0]:
        return None
    has_data = counts.sum(axis=0) > 0
    n = int(has_data.sum())
    if n < 3:
        return None
    sums, counts = sums[:, has_data], counts[:, has_data]
    other_parts = (
        sums.sum(axis=1, keepdims=True) - sums,
        counts.sum(axis=1, keepdims=True) - counts,
    )
    if (other_parts[1] <= 0).any():
        return None
    squares = sums.sum(axis=1) / counts.sum(axis=1)
    overall_exponent, short_exponent, long_exponent = _split_exponents(
        lengths, squares + missing_variance
    )
    correction = abs(_split_exponents(lengths, squares)[0] - overall_exponent)
    jackknife = np.array(
        [
            _split_exponents(
                lengths, other_parts[0][:, b] / other_parts[1][:, b] + missing_variance
            )
            for b in range(n)
        ]
    )
    difference_error = _error95(jackknife[:, 1] - jackknife[:, 2])
    bend = max(abs(short_exponent - long_exponent) - difference_error, 0.0)
    error = float(np.linalg.norm([_error95(jackknife[:, 0]), bend / 2.0, correction / 2.0]))
    return Exponent(
        overall_exponent,
        error,
        float(lengths[0]),
        float(lengths[-1]),
        short_exponent,
        long_exponent,
        bend,
    )


def _split_exponents(lengths: FloatArray, squares: FloatArray) -> tuple[float, float, float]:
    """Return the exponents over all distances, and over their shorter and longer halves."""
    half_count = len(lengths) // 2
    parts = (
        (lengths, squares),
        (lengths[: half_count + 1], squares[: half_count + 1]),
        (lengths[half_count:], squares[half_count:]),
    )
    overall_exponent, short_exponent, long_exponent = (_slope(*part) / 2.0 for part in parts)
    return overall_exponent, short_exponent, long_exponent


def _error95(jackknife: FloatArray) -> float:
    """Return the 95 % error from the jackknife values of the parts."""
    n = len(jackknife)
    variance = (
        PART_CORRELATION_FACTOR * (n - 1.0) / n * float(((jackknife - jackknife.mean()) ** 2).sum())
    )
    return _t95(n - 1) * float(np.sqrt(variance))


def _slope(lengths: FloatArray, squares: FloatArray) -> float:
    """Return the slope of the logarithms of squares and lengths.

    The weights are proportional to the numbers (size / h)^2 of independent differences.
    """
    x, y = np.log(lengths), np.log(np.maximum(squares, 1e-300))
    weight = 1.0 / lengths**2
    x = x - np.average(x, weights=weight)
    return float((weight * x * y).sum() / (weight * x * x).sum())


def _is_resolved(variations: Variations, noise: float) -> BoolArray:
    """Return for each distance (k,) whether its mean square clearly exceeds that of noise.

    This must also apply to all longer distances.
    """
    with np.errstate(invalid="ignore"):
        squares = np.nanmean(variations.mean_squares(), axis=0)
        is_above_noise = np.asarray(squares > MIN_NOISE_RATIO * NOISE_FACTOR * noise**2)
    # All distances longer than the last noisy one are resolved.
    noisy_rows = np.flatnonzero(~is_above_noise)
    return np.arange(len(is_above_noise)) > (noisy_rows[-1] if len(noisy_rows) else -1)


def _second_differences(
    heights: FloatArray, part: IntArray, column_step: int, row_step: int
) -> tuple[FloatArray, IntArray]:
    """Return squares (n,) and the part of the surface that contains the middle of each one."""
    rows, columns = heights.shape
    column_margin = abs(column_step)
    if 2 * row_step >= rows or 2 * column_margin >= columns:
        return np.zeros(0), np.zeros(0, np.int64)
    middle = heights[row_step : rows - row_step, column_margin : columns - column_margin]
    heights_after = heights[
        2 * row_step :, column_margin + column_step : columns - column_margin + column_step
    ]
    heights_before = heights[
        : rows - 2 * row_step, column_margin - column_step : columns - column_margin - column_step
    ]
    second_differences = heights_after - 2.0 * middle + heights_before
    is_known = np.isfinite(second_differences)
    part_indices = part[row_step : rows - row_step, column_margin : columns - column_margin]
    return second_differences[is_known] ** 2, part_indices[is_known]


def _part_indices(shape: tuple[int, ...]) -> IntArray:
    """Return the index (rows, columns) of the part of the surface that contains each cell."""
    row, column = (np.arange(size) * PARTS_PER_SIDE // size for size in shape)
    return np.asarray(row[:, None] * PARTS_PER_SIDE + column[None, :])


def _known_extent(heights: FloatArray) -> tuple[int, int]:
    """Return the numbers of rows and columns of the bounding rectangle of known heights."""
    is_known = np.isfinite(heights)
    rows, columns = np.flatnonzero(is_known.any(axis=1)), np.flatnonzero(is_known.any(axis=0))
    if not len(rows):
        return 0, 0
    return int(rows[-1] - rows[0] + 1), int(columns[-1] - columns[0] + 1)


def _hotelling_p(mean: FloatArray, covariance: FloatArray, n: int) -> float:
    """Return the p-value of the mean of n pairs from Hotelling's T2."""
    from scipy.special import fdtrc

    values = np.linalg.eigvalsh(covariance)
    if values[0] <= 0.0:
        return 0.0
    square = float(mean @ np.linalg.solve(covariance, mean))
    return float(fdtrc(2, n - 2, square * (n - 2.0) / (2.0 * (n - 1.0))))


def _t95(dof: float) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(dof, 0.975))
