"""Detection of levels in a patch: parallel planes or layers of misaligned scans.

A single plane through all points would lie between the levels. Steps are detected from the means of
small cells, which scatter much less than points, so that steps of twice the noise become visible:
after subtraction of the common plane, the means cluster at several levels with few means in
between. A wave or roughness has many means in between. Superimposed layers do not separate into
such cells. They are detected as two peaks in the distribution of the heights of the points, which
requires a gap of three times the noise.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, Int16Array
from vomstudio.core.findings import Finding
from vomstudio.geometry.patches import equal_cells

MIN_POINTS = 200
"""Minimum number of points that reveal a step of a few times their noise."""
MAX_POINTS = 6_000
# Points per cell; minimum number of cells per side (fewer would turn waves into steps), and the
# number of wide cells per side whose attitudes are used.
POINTS_PER_CELL, MIN_CELLS_PER_SIDE, WIDE_CELLS_PER_SIDE = 16.0, 6, 5
# Own choice: minimum step as a multiple of the local scatter, of the standard error of a cell mean,
# and of the grid step.
MIN_STEP_NOISE, MIN_STEP_ERRORS, MIN_STEP_GRIDS = 1.5, 4.5, 1.5
# Minimum share of the cells on a level; maximum number of cells between two levels relative to the
# smaller level (0.7 for a sine wave, 1 for a uniform distribution). Without a step, the means
# scatter only by their error.
MIN_LEVEL_SHARE, MAX_BETWEEN_SHARE, BAND_HALF_WIDTH_SHARE = 0.07, 0.3, 0.2
MAX_FLAT_SCATTER = 1.6
MAX_ITERATIONS, MAX_LEVELS = 12, 4
# Kernel width in standard deviations of the heights; maximum depth ratio of the valley to the
# smaller peak, within cells and overall (because waves also have peaks); minimum significance of
# the peaks.
KERNEL_WIDTH, MAX_VALLEY_RATIO, MAX_OVERALL_VALLEY_RATIO, MIN_PEAK_SIGMA = 0.35, 0.9, 0.6, 4.0
N_BINS = 256
MIN_RELATIVE_SCATTER = 1e-9
MAX_STEPS = 32_000


def level_gap(points: npt.ArrayLike, normal: npt.ArrayLike) -> float | None:
    """Measure the distance between the levels of the points of a patch.

    Parameters
    ----------
    points : (n, 3) array_like
        Points in any frame and unit.
    normal : (3,) array_like
        Normal of the plane of the patch.

    Returns
    -------
    float or None
        Distance in the unit of the points, or None for a single level or too few points.
    """
    xyz = np.asarray(points, np.float64)
    if len(xyz) < MIN_POINTS:
        return None
    if len(xyz) > MAX_POINTS:
        xyz = xyz[np.random.default_rng(0).choice(len(xyz), MAX_POINTS, replace=False)]
    n = np.asarray(normal, np.float64)
    local_points = xyz - xyz.mean(axis=0)
    grid = float(np.abs(n) @ grid_steps(xyz))
    _, _, basis = np.linalg.svd(n[None])
    plane_coordinates, h = local_points @ basis[1:].T, local_points @ n
    _, axes = np.linalg.eigh(plane_coordinates.T @ plane_coordinates)
    v, u = (plane_coordinates @ axes).T
    extent = max(float(np.ptp(u)), float(np.ptp(v)))
    if not h.std() > MIN_RELATIVE_SCATTER * extent:
        return None
    slopes = _median_slopes(u, v, h)
    cells_per_side = int(np.sqrt(len(u) / POINTS_PER_CELL))
    if cells_per_side < MIN_CELLS_PER_SIDE:
        return _gap_between_layers(h, MAX_VALLEY_RATIO, grid)
    cell = equal_cells(_round_positions(u), _round_positions(v), cells_per_side)
    count = np.bincount(cell, minlength=cells_per_side * cells_per_side).astype(np.float64)
    a, b, mean = (np.bincount(cell, x, cells_per_side * cells_per_side) / count for x in (u, v, h))
    cell_residuals = h - mean[cell] - slopes[0] * (u - a[cell]) - slopes[1] * (v - b[cell])
    # Most cells contain no step.
    square = np.bincount(cell, cell_residuals**2) / np.maximum(count - 1.0, 1.0)
    noise = float(np.sqrt(np.median(square)))
    error = noise / float(np.sqrt(np.median(count)))
    min_gap = max(MIN_STEP_NOISE * noise, MIN_STEP_ERRORS * error, MIN_STEP_GRIDS * grid)
    gap = _gap_between_cells(a, b, mean, slopes, MAX_FLAT_SCATTER * error)
    if gap is not None and gap >= min_gap:
        return gap
    gap = _gap_between_layers(h, MAX_OVERALL_VALLEY_RATIO, grid)
    return _gap_between_layers(cell_residuals, MAX_VALLEY_RATIO, grid) if gap is None else gap


def level_findings(gap_m: float | None) -> list[Finding]:
    """Report levels that make a plane doubtful.

    Parameters
    ----------
    gap_m : float or None
        Gap between the levels, m. If None, no finding is returned.

    Returns
    -------
    list of Finding
    """
    return [] if gap_m is None else [Finding("plane.levels", gap_m=gap_m)]


def bend_findings(is_bent: bool) -> list[Finding]:
    """Report a curved face, which makes the plane of a part of it doubtful.

    Parameters
    ----------
    is_bent : bool

    Returns
    -------
    list of Finding
    """
    return [Finding("plane.bowed")] if is_bent else []


def grid_steps(points: FloatArray) -> FloatArray:
    """Return the grid to which the coordinates of a file were rounded.

    Parameters
    ----------
    points : (n, 3) ndarray

    Returns
    -------
    (3,) ndarray
        Grid steps of x, y and z; 0 if the coordinates were not rounded.
    """
    steps = np.zeros(3)
    for axis in range(3):
        differences = np.diff(np.sort(points[:500, axis]))
        differences = np.sort(differences[differences > 0.0])
        differences = (
            differences[differences > 1e-6 * differences[len(differences) // 2]]
            if len(differences)
            else differences
        )
        if len(differences) < 2:
            continue
        step = float(differences[0])
        multiples = differences / step
        # Without a grid, differences are not multiples of the smallest one.
        if float(np.abs(multiples - np.round(multiples)).max()) < 0.02 * max(
            1.0, 1e-3 * multiples.max()
        ):
            steps[axis] = step
    return steps


# --- steps ------------------------------------------------------------------------------------
def _gap_between_cells(
    a: FloatArray, b: FloatArray, mean: FloatArray, slopes: FloatArray, max_scatter: float
) -> float | None:
    """Return the gap between the levels of cell means; None if there is only one level.

    Without a step, the scatter of the means is below `max_scatter`.
    """
    for start_slopes in (slopes, np.zeros(2)):
        if float(np.std(mean - start_slopes[0] * a - start_slopes[1] * b)) < max_scatter:
            return None
    for start_slopes in (slopes, np.zeros(2)):
        for levels in range(2, MAX_LEVELS + 1):
            gap = _fit_levels(a, b, mean, start_slopes, levels)
            if gap is not None:
                return gap
    return None


def _fit_levels(
    a: FloatArray, b: FloatArray, mean: FloatArray, slopes: FloatArray, level_count: int
) -> float | None:
    """Return the smallest distance between the levels of cells above a common plane.

    Return None if the cells do not cluster at this number of levels.
    """
    heights = mean - slopes[0] * a - slopes[1] * b
    low, high = np.quantile(heights, [0.05, 0.95])
    level_heights = np.asarray(np.linspace(float(low), float(high), level_count), np.float64)
    level = np.full(len(mean), -1)
    for _ in range(MAX_ITERATIONS):
        nearest_levels = np.abs(heights[:, None] - level_heights[None]).argmin(axis=1)
        if np.bincount(nearest_levels, minlength=level_count).min() < MIN_LEVEL_SHARE * len(mean):
            return None
        if (nearest_levels == level).all():
            break
        level = nearest_levels
        design = np.zeros((len(mean), level_count + 2))
        design[np.arange(len(mean)), level] = 1.0
        design[:, level_count], design[:, level_count + 1] = a, b
        slopes = np.asarray(np.linalg.lstsq(design, mean, rcond=None)[0][level_count:], np.float64)
        heights = mean - slopes[0] * a - slopes[1] * b
        level_heights = np.asarray(np.bincount(level, heights) / np.bincount(level), np.float64)
    level_heights = np.sort(level_heights)
    gaps = np.diff(level_heights)
    for low, gap in zip(level_heights, gaps, strict=False):
        position = (heights - low) / gap
        n_between = int((np.abs(position - 0.5) < BAND_HALF_WIDTH_SHARE).sum())
        n_on_level = min(
            int((np.abs(position - end) < BAND_HALF_WIDTH_SHARE).sum()) for end in (0.0, 1.0)
        )
        if n_between > MAX_BETWEEN_SHARE * n_on_level:
            return None
    return float(gaps.min())


def _median_slopes(u: FloatArray, v: FloatArray, h: FloatArray) -> FloatArray:
    """Return the median slope of wide cells, few of which contain a step."""
    cell = equal_cells(_round_positions(u), _round_positions(v), WIDE_CELLS_PER_SIDE)
    count = np.bincount(cell)
    a, b, c = (x - (np.bincount(cell, x) / count)[cell] for x in (u, v, h))
    aa, ab, bb, ac, bc = (np.bincount(cell, x) for x in (a * a, a * b, b * b, a * c, b * c))
    area = aa * bb - ab * ab
    is_valid = area > 1e-6 * aa * bb
    if not is_valid.any():
        return np.zeros(2)
    slopes = np.stack([bb * ac - ab * bc, aa * bc - ab * ac])[:, is_valid] / area[is_valid]
    return np.asarray(np.median(slopes, axis=1))


def _round_positions(x: FloatArray) -> Int16Array:
    """Round positions so that the points of a lattice row fall into one cell.

    The result does not depend on the tilt of the plane. Short integers sort ten times faster.
    """
    steps = np.round(x / max(1e-3 * float(x.std()), 1e-300))
    return np.clip(steps, -MAX_STEPS, MAX_STEPS).astype(np.int16)


# --- layers -----------------------------------------------------------------------------------
def _gap_between_layers(h: FloatArray, max_valley_ratio: float, grid: float) -> float | None:
    """Return the distance between the two largest peaks of the heights.

    Return None if there is a single peak or if the valley between the peaks is too shallow.
    """
    low, high = np.quantile(h, [0.002, 0.998])
    inner_heights = h[(h >= low) & (h <= high)]
    width = max(KERNEL_WIDTH * float(inner_heights.std()), 0.5 * grid)
    if not width > 0.0:
        return None
    margin = 4.0 * width
    count, edges = np.histogram(inner_heights, N_BINS, (low - margin, high + margin))
    step = edges[1] - edges[0]
    offsets = np.arange(-int(margin / step), int(margin / step) + 1) * step
    kernel = np.exp(-0.5 * (offsets / width) ** 2)
    density = np.convolve(count, kernel, mode="same")
    peaks = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] >= density[2:])) + 1
    if len(peaks) < 2:
        return None
    first_peak, second_peak = sorted(peaks[np.argsort(-density[peaks])[:2]].tolist())
    smaller_peak = min(density[first_peak], density[second_peak])
    valley = float(density[first_peak : second_peak + 1].min())
    # The variance of kernel-weighted counts is the sum of squared weights.
    min_depth = MIN_PEAK_SIGMA * float(np.sqrt(np.convolve(count, kernel**2, mode="same").max()))
    gap = float(edges[second_peak] - edges[first_peak])
    if (
        valley > max_valley_ratio * smaller_peak
        or smaller_peak - valley < min_depth
        or smaller_peak < 0.1 * density.max()
    ):
        return None
    return gap if gap > MIN_STEP_GRIDS * grid else None
