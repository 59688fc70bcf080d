"""Roughness of a surface by its second differences: how it grows with the distance, and in which
direction the surface is smoothest.

z(x + h) - 2 z(x) + z(x - h) knows nothing of a tilt, so that the plane that was taken off leaves no
trace in it. For a self-affine surface its mean square grows as |h|^(2 H) with the Hurst exponent H
(Kent & Wood 1997, Journal of the Royal Statistical Society B 59, 679-699; on surfaces and by
direction Chan & Wood 2000, Statistica Sinica 10, 343-376; Davies & Hall 1999, ibid. B 61, 3-37).
Fault surfaces have H of about 0.6 along slip and 0.8 across (Candela et al. 2012, Journal of
Geophysical Research 117, B08409), and are smoothest along it (Renard et al. 2006, Geophysical
Research Letters 33, L04305).

Errors are those of the jackknife over sixteen parts of the surface, left out one by one: what is
longer than a quarter of it is not known from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

DIRECTIONS = 18
PARTS_A_SIDE = 4
_REACH = 10.0
"""The longest distance in the surface: both differences of it lie in a part, or nearly."""
LEAST_RANGE = 3.0
"""From the shortest distance to the longest; a slope over less is no exponent."""
_STEPS = 8
_FEWEST = 50
OVER_NOISE = 4.0
"""Of the mean square of second differences over what noise makes of it: from there on noise bends
the growth by less than it does for a quarter more."""
NOISE_SHARE = 6.0
"""A second difference of noise has six times its variance: 1 + 4 + 1."""
ALIKE = 1.44
"""By which the variance among parts is widened, since those beside each other are alike: simulated
on self-affine surfaces with H from 0.3 to 0.9, for stated 95 % that hold."""
MOST_BEND = 0.2
"""Ours: a surface whose growth bends by more has a length of its own, as grooves and waves have,
and no exponent; of 160 self-affine surfaces none bent by more than 0.06."""
LEVEL = 0.01
"""At which a direction is claimed: wrongly on one isotropic surface in a hundred."""


@dataclass(frozen=True, eq=False)
class Variations:
    """Mean squares of second differences, m2.

    angles_deg : (d,) from the columns' direction toward the rows', of each direction
    lags : (k,) distances, m, in ascending order
    sums, counts : (d, k, parts) of the squares, and how many, in each part of the surface
    lengths, ways_deg : (d, k) the distances, m, and directions that the cells allow
    """

    angles_deg: FloatArray
    lags: FloatArray
    sums: FloatArray
    counts: FloatArray
    lengths: FloatArray
    ways_deg: FloatArray

    def of_all(self) -> FloatArray:
        """(d, k) over the whole surface, NaN where there are too few."""
        counts = self.counts.sum(axis=2)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(counts >= _FEWEST, self.sums.sum(axis=2) / counts, np.nan)


@dataclass(frozen=True)
class Exponent:
    """Hurst's exponent with its 95 % error, over distances from from_m to to_m.

    short, long : over the shorter and the longer half of them; bend : by how much these differ
    beyond the 95 % error of their difference, which is half in error95"""

    H: float
    error95: float
    from_m: float
    to_m: float
    short: float
    long: float
    bend: float

    @property
    def straight(self) -> bool:
        """Whether one exponent serves all distances."""
        return self.bend <= MOST_BEND


@dataclass(frozen=True)
class DirectionExponent:
    """The same along one direction: angle_deg from the columns' toward the rows'."""

    angle_deg: float
    H: float
    error95: float


@dataclass(frozen=True)
class Smoothest:
    """angle_deg : of the direction in which the surface is smoothest, from the columns' toward the
    rows', [0, 180); error95_deg : of it; ratio : of the root mean square of second differences
    across it to that along it; p : of as much anisotropy on a surface without any"""

    angle_deg: float
    error95_deg: float
    ratio: float
    p: float

    @property
    def claimed(self) -> bool:
        return self.p < LEVEL


def variations(heights: FloatArray, cell: float, shortest: float) -> Variations | None:
    """Of a raster (rows, columns) of heights, m, NaN where unknown, in DIRECTIONS directions.

    cell : its side, m; shortest : distance, m. None where the surface is too small for LEAST_RANGE.
    """
    rows, columns = _span(heights)
    longest = min(rows, columns) * cell / _REACH
    shortest = max(shortest, 2.0 * cell)
    if longest < LEAST_RANGE * shortest:
        return None
    lags = np.geomspace(shortest, longest, _STEPS)
    angles = np.arange(DIRECTIONS) * 180.0 / DIRECTIONS
    part = _parts(heights.shape)
    shape = (len(angles), len(lags))
    sums = np.zeros((*shape, PARTS_A_SIDE**2))
    counts = np.zeros_like(sums)
    lengths, ways = np.zeros(shape), np.zeros(shape)
    for i, angle in enumerate(np.radians(angles)):
        for j, lag in enumerate(lags):
            across = round(float(lag * np.cos(angle)) / cell)
            down = round(float(lag * np.sin(angle)) / cell)
            lengths[i, j] = cell * float(np.hypot(across, down))
            ways[i, j] = float(np.degrees(np.arctan2(down, across)))
            square, where = _second_differences(heights, part, across, down)
            sums[i, j] = np.bincount(where, square, PARTS_A_SIDE**2)
            counts[i, j] = np.bincount(where, minlength=PARTS_A_SIDE**2)
    return Variations(angles, lags, sums, counts, lengths, ways)


def exponent(found: Variations, noise: float, lacking: float = 0.0) -> Exponent | None:
    """Of all directions together, over the distances at which the surface stands out of the noise;
    None where these reach over less than LEAST_RANGE. noise : standard deviation of the heights
    that is the model's own, m; lacking : variance of the heights that the raster lacks between the
    points that it was made from, m2 (`gaps.lacking`), which is put back; half of what that changes
    is in the error."""
    every = np.arange(len(found.angles_deg))
    return _exponent(found, noise, every, NOISE_SHARE * lacking)


def exponents(found: Variations, noise: float, lacking: float = 0.0) -> list[DirectionExponent]:
    """Of each direction on its own, where it can be told."""
    told = []
    for i, angle in enumerate(found.angles_deg.tolist()):
        one = _exponent(found, noise, np.array([i]), NOISE_SHARE * lacking)
        if one is not None and one.straight:
            told.append(DirectionExponent(angle, one.H, one.error95))
    return told


def smoothest(found: Variations, noise: float) -> Smoothest | None:
    """The direction in which second differences are least, by their second harmonic; None where too
    few parts of the surface stand out of the noise."""
    over = _over_noise(found, noise)
    if not over.any():
        return None
    sums, counts = found.sums[:, over], found.counts[:, over]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(counts >= _FEWEST / 2, sums / counts, np.nan)
    whole = np.isfinite(mean).all(axis=(0, 1))
    if whole.sum() < PARTS_A_SIDE**2 / 2:
        return None
    each = _harmonics(found, over, mean[:, :, whole]).mean(axis=1)
    n = each.shape[1]
    middle = each.mean(axis=1)
    size = float(np.hypot(*middle))
    spread = ALIKE * np.cov(each) / n
    rough = 0.5 * float(np.degrees(np.arctan2(middle[1], middle[0])))
    if size == 0.0:
        return None
    sideways = np.array([-middle[1], middle[0]]) / size
    error = float(np.sqrt(max(sideways @ spread @ sideways, 0.0))) / size / 2.0
    p = _hotelling_p(middle, spread, n)
    along = _along(found, over, rough)
    return Smoothest(
        float((rough + 90.0) % 180.0), float(min(np.degrees(_t95(n - 1) * error), 90.0)), along, p
    )


def range_told(found: Variations, noise: float) -> tuple[float, float] | None:
    """From and to which distance the surface stands out of the noise, m."""
    over = np.flatnonzero(_over_noise(found, noise))
    return (float(found.lags[over[0]]), float(found.lags[over[-1]])) if len(over) else None


def _harmonics(found: Variations, over: BoolArray, squares: FloatArray) -> FloatArray:
    """(2, k, n) cosine and sine of twice the direction in mean squares (d, k, n), over their mean:
    by least squares, since the cells allow no even steps of direction and length."""
    at = np.flatnonzero(over)
    growth = 2.0 * _usual_exponent(found, at)
    harmonics = np.empty((2, len(at), squares.shape[2]))
    for j, k in enumerate(at.tolist()):
        twice = 2.0 * np.radians(found.ways_deg[:, k])
        columns = np.stack([np.ones(len(twice)), np.cos(twice), np.sin(twice)], axis=1)
        even = squares[:, j] * ((found.lags[k] / found.lengths[:, k]) ** growth)[:, None]
        mean, *wave = np.linalg.lstsq(columns, even, rcond=None)[0]
        harmonics[:, j] = np.stack(wave) / mean
    return harmonics


def _usual_exponent(found: Variations, at: IntArray) -> float:
    squares = np.nanmean(found.of_all()[:, at], axis=0)
    if len(at) < 2:
        return 0.7
    return float(np.clip(_slope(found.lengths[:, at].mean(axis=0), squares) / 2.0, 0.0, 2.0))


def _along(found: Variations, over: BoolArray, rough_deg: float) -> float:
    """Root of the ratio of mean squares across the smoothest direction and along it, by the second
    harmonic of their logarithms."""
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(found.of_all()[:, over])
    twice = 2.0 * np.radians(found.ways_deg[:, over] - rough_deg)
    return float(np.exp(np.nanmean(2.0 * np.nanmean(np.cos(twice) * logs, axis=0))))


def _exponent(
    found: Variations, noise: float, directions: IntArray, lacking: float
) -> Exponent | None:
    """lacking : in the mean squares of second differences, m2"""
    over = _over_noise(found, noise)
    sums = found.sums[directions][:, over].sum(axis=0)
    counts = found.counts[directions][:, over].sum(axis=0)
    lengths = found.lengths[directions][:, over].mean(axis=0)
    enough = counts.sum(axis=1) >= _FEWEST
    sums, counts, lengths = sums[enough], counts[enough], lengths[enough]
    if len(lengths) < 3 or lengths[-1] < LEAST_RANGE * lengths[0]:
        return None
    known = counts.sum(axis=0) > 0
    n = int(known.sum())
    if n < 3:
        return None
    sums, counts = sums[:, known], counts[:, known]
    rest = (sums.sum(axis=1, keepdims=True) - sums, counts.sum(axis=1, keepdims=True) - counts)
    if (rest[1] <= 0).any():
        return None
    squares = sums.sum(axis=1) / counts.sum(axis=1)
    whole, short, long = _powers(lengths, squares + lacking)
    changed = abs(_powers(lengths, squares)[0] - whole)
    without = np.array(
        [_powers(lengths, rest[0][:, b] / rest[1][:, b] + lacking) for b in range(n)]
    )
    apart = _error95(without[:, 1] - without[:, 2])
    bend = max(abs(short - long) - apart, 0.0)
    error = float(np.linalg.norm([_error95(without[:, 0]), bend / 2.0, changed / 2.0]))
    return Exponent(whole, error, float(lengths[0]), float(lengths[-1]), short, long, bend)


def _powers(lengths: FloatArray, squares: FloatArray) -> tuple[float, float, float]:
    """Exponents over all distances, over the shorter half of them and over the longer."""
    half = len(lengths) // 2
    parts = (
        (lengths, squares),
        (lengths[: half + 1], squares[: half + 1]),
        (lengths[half:], squares[half:]),
    )
    whole, short, long = (_slope(*part) / 2.0 for part in parts)
    return whole, short, long


def _error95(without: FloatArray) -> float:
    """Of a figure, by what it is without each part of the surface."""
    n = len(without)
    variance = ALIKE * (n - 1.0) / n * float(((without - without.mean()) ** 2).sum())
    return _t95(n - 1) * float(np.sqrt(variance))


def _slope(lengths: FloatArray, squares: FloatArray) -> float:
    """Of the logarithms. A distance h has some (size / h)^2 independent differences, and counts by
    that."""
    x, y = np.log(lengths), np.log(np.maximum(squares, 1e-300))
    weight = 1.0 / lengths**2
    x = x - np.average(x, weights=weight)
    return float((weight * x * y).sum() / (weight * x * x).sum())


def _over_noise(found: Variations, noise: float) -> BoolArray:
    """(k,) distances from which on the mean square stands out of what noise makes of it."""
    with np.errstate(invalid="ignore"):
        squares = np.nanmean(found.of_all(), axis=0)
        above = np.asarray(squares > OVER_NOISE * NOISE_SHARE * noise**2)
    # Past the last distance that does not stand out all do.
    below = np.flatnonzero(~above)
    return np.arange(len(above)) > (below[-1] if len(below) else -1)


def _second_differences(
    heights: FloatArray, part: IntArray, across: int, down: int
) -> tuple[FloatArray, IntArray]:
    """(n,) squares, and the part of the surface in which the middle of each lies."""
    rows, columns = heights.shape
    wide = abs(across)
    if 2 * down >= rows or 2 * wide >= columns:
        return np.zeros(0), np.zeros(0, np.int64)
    middle = heights[down : rows - down, wide : columns - wide]
    after = heights[2 * down :, wide + across : columns - wide + across]
    before = heights[: rows - 2 * down, wide - across : columns - wide - across]
    found = after - 2.0 * middle + before
    known = np.isfinite(found)
    where = part[down : rows - down, wide : columns - wide]
    return found[known] ** 2, where[known]


def _parts(shape: tuple[int, ...]) -> IntArray:
    """(rows, columns) number of the part in which each cell lies."""
    row, column = (np.arange(size) * PARTS_A_SIDE // size for size in shape)
    return np.asarray(row[:, None] * PARTS_A_SIDE + column[None, :])


def _span(heights: FloatArray) -> tuple[int, int]:
    """Rows and columns of the smallest rectangle that has all heights."""
    known = np.isfinite(heights)
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        return 0, 0
    return int(rows[-1] - rows[0] + 1), int(columns[-1] - columns[0] + 1)


def _hotelling_p(middle: FloatArray, spread: FloatArray, n: int) -> float:
    """Of a mean as far from (0, 0), by Hotelling's T2 of n pairs."""
    from scipy.special import fdtrc

    values = np.linalg.eigvalsh(spread)
    if values[0] <= 0.0:
        return 0.0
    square = float(middle @ np.linalg.solve(spread, middle))
    return float(fdtrc(2, n - 2, square * (n - 2.0) / (2.0 * (n - 1.0))))


def _t95(free: float) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(free, 0.975))
