"""Planar part of a surface, the largest part that fits a single plane.

A plane is fitted robustly (iteratively reweighted least squares: first absolute deviations, then
Tukey's biweight; Holland & Welsch 1977, Communications in Statistics A6, 813-827). Areas larger
than single cells do not belong to the planar part if they deviate by more than four times the
scatter about the plane or the noise of the model, whichever is larger.

If a third of the surface or more bends away, this plane is a compromise that fits neither part.
Therefore planes are also grown from parts of the surface, each over all cells within its own
scatter. On a surface that is a single plane, however rough, or smoothly bent, they grow over the
whole surface (for all of 200 self-affine surfaces with H from 0.3 to 0.9). If a plane stops growing
at a scatter well below that of the whole surface, the surface is broken, and the largest such part
is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

MAX_DEVIATION_SIGMA = 4.0
"""Maximum deviation due to roughness of the surface, in robust standard deviations."""
MIN_TRIM_SHARE = 0.03
"""Minimum deviating share of the surface for it to be trimmed."""
_BIWEIGHT_CONSTANT = 4.685
MAX_ITERATIONS = 30
MAD_FACTOR = 1.4826
MAX_CELLS = 40_000
MAX_BROKEN_RATIO = 0.7
"""Maximum ratio of the scatter of a part to that of the whole surface, about a plane and about a
paraboloid, for the surface to be considered broken.
"""
MIN_PART_SHARE = 0.25
SEEDS_PER_SIDE, _SEED_SIZE, MAX_GROWN_CELLS = 4, 1.0 / 3.0, 6_000


@dataclass(frozen=True, eq=False)
class PlanarPart:
    """Planar part of a raster of heights.

    Attributes
    ----------
    is_planar : (rows, columns) ndarray of bool
        True for cells that lie in the plane.
    deviating_share : float
        Share of the known cells that deviate from the plane.
    limit : float
        Maximum deviation, m.
    plane : (3,) ndarray
        Coefficients of the robust plane, height = a + b column + c row.
    remaining_plane : (3,) ndarray or None
        Largest other plane if the surface is broken; otherwise None.
    other_share : float
        Share of the known cells that lie in the other plane.
    """

    is_planar: BoolArray
    deviating_share: float
    limit: float
    plane: FloatArray
    remaining_plane: FloatArray | None = None
    other_share: float = 0.0

    @property
    def is_trimmed(self) -> bool:
        """Whether the deviating share is large enough for the surface to be trimmed."""
        return self.deviating_share >= MIN_TRIM_SHARE


def find_planar_part(heights: FloatArray, noise: float) -> PlanarPart:
    """Find the largest part of a height raster that is planar within its noise.

    Parameters
    ----------
    heights : (rows, columns) ndarray
        Heights in metres above any plane near the surface; NaN if unknown.
    noise : float
        Standard deviation of the noise of the model, m.

    Returns
    -------
    PlanarPart
    """
    from scipy import ndimage

    is_known = np.isfinite(heights)
    row, column = np.nonzero(is_known)
    values = heights[is_known]
    plane, scatter = _robust_plane(row, column, values)
    parts = _planar_parts(row, column, values, noise, scatter)
    if parts:
        plane, scatter, _ = parts[0]
    limit = MAX_DEVIATION_SIGMA * max(scatter, noise)
    surface = (
        plane[0]
        + plane[1] * np.arange(heights.shape[1])
        + (plane[2] * np.arange(heights.shape[0])[:, None])
    )
    is_deviating = is_known & ~(np.abs(heights - surface) <= limit)
    # Single cells are stones or outliers; unknown cells belong to neither side.
    is_deviating = ndimage.binary_opening(is_deviating, np.ones((3, 3), bool))
    pieces, count = ndimage.label(is_known & ~is_deviating, np.ones((3, 3), int))
    is_planar = is_known & ~is_deviating
    if count > 1:
        sizes = np.bincount(pieces.ravel())[1:]
        # Islands beyond a data gap belong to the plane; islands beyond a deviation do not.
        is_near_deviation = ndimage.binary_dilation(
            is_deviating, np.ones((3, 3), bool), iterations=2
        )
        for label in range(1, count + 1):
            is_piece = pieces == label
            if label != int(np.argmax(sizes)) + 1 and (is_piece & is_near_deviation).any():
                is_planar &= ~is_piece
    n = int(is_known.sum())
    deviating_share = float(1.0 - is_planar.sum() / n) if n else 0.0
    if len(parts) < 2:
        return PlanarPart(is_planar, deviating_share, limit, plane)
    return PlanarPart(
        is_planar,
        deviating_share,
        limit,
        plane,
        parts[1][0],
        float((parts[1][2] & ~parts[0][2]).mean()),
    )


def _planar_parts(
    row: IntArray,
    column: IntArray,
    values: FloatArray,
    noise: float,
    scatter: float,
) -> list[tuple[FloatArray, float, BoolArray]]:
    """Return the planes, scatters and cells of the two largest parts of a broken surface.

    `scatter` is the scatter about the plane of all cells; the list is empty if the surface is not
    broken.
    """
    step = max(1, round(float(np.sqrt(len(values) / MAX_GROWN_CELLS))))
    is_sampled = (row % step == 0) & (column % step == 0)
    row, column, z = row[is_sampled], column[is_sampled], values[is_sampled]
    if len(z) < 9 * SEEDS_PER_SIDE**2:
        return []
    x = (column - column.min()) / max(float(np.ptp(column)), 1.0)
    y = (row - row.min()) / max(float(np.ptp(row)), 1.0)
    columns = np.stack([np.ones(len(z)), column, row], axis=1).astype(np.float64)
    quadric_columns = np.stack([np.ones(len(z)), x, y, x * x, x * y, y * y], axis=1)
    curved_scatter = _scatter(
        z - quadric_columns @ np.linalg.lstsq(quadric_columns, z, rcond=None)[0]
    )
    max_scatter = MAX_BROKEN_RATIO * min(scatter, curved_scatter)
    if max_scatter <= noise:
        return []
    parts = []
    for start in np.linspace(0.0, 1.0 - _SEED_SIZE, SEEDS_PER_SIDE):
        is_in_rows = (y >= start) & (y <= start + _SEED_SIZE)
        for first in np.linspace(0.0, 1.0 - _SEED_SIZE, SEEDS_PER_SIDE):
            is_seed = is_in_rows & (x >= first) & (x <= first + _SEED_SIZE)
            part = _grow_plane(columns, z, is_seed, noise)
            if part is not None and part[1] < max_scatter and part[2].mean() >= MIN_PART_SHARE:
                parts.append(part)
    if not parts:
        return []
    # A plane that has grown across the break has a larger scatter than a part on one side of it.
    limit = 2.0 * min(part[1] for part in parts)
    parts = sorted((part for part in parts if part[1] <= limit), key=lambda part: -part[2].sum())
    other_parts = [part for part in parts if (part[2] & parts[0][2]).sum() < 0.3 * part[2].sum()]
    return [parts[0], *other_parts[:1]]


def _grow_plane(
    columns: FloatArray, z: FloatArray, is_member: BoolArray, noise: float
) -> tuple[FloatArray, float, BoolArray] | None:
    """Extend the plane of some cells to all cells within its scatter.

    Returns None if too few cells remain.
    """
    plane: FloatArray = np.zeros(3)
    scatter = 0.0
    for _ in range(MAX_ITERATIONS // 2):
        if is_member.sum() < 30:
            return None
        plane = np.asarray(np.linalg.lstsq(columns[is_member], z[is_member], rcond=None)[0])
        residuals = z - columns @ plane
        # Exact values scatter due to rounding.
        scatter = max(_scatter(residuals[is_member]), noise, 1e-9 * float(np.abs(z).max()))
        is_inside = np.abs(residuals) <= MAX_DEVIATION_SIGMA * scatter
        if np.array_equal(is_inside, is_member):
            break
        is_member = is_inside
    return plane, scatter, is_member


def _scatter(residuals: FloatArray) -> float:
    return MAD_FACTOR * float(np.median(np.abs(residuals)))


def _robust_plane(row: IntArray, column: IntArray, values: FloatArray) -> tuple[FloatArray, float]:
    """Return the coefficients (3,) of 1, column and row, and the scatter about the plane."""
    step = max(1, len(values) // MAX_CELLS)
    columns = np.stack([np.ones(len(values)), column, row], axis=1)
    sample, z = columns[::step], values[::step]
    weight = np.ones(len(z))
    plane = np.zeros(3)
    scatter = 0.0
    for iteration in range(MAX_ITERATIONS):
        root = np.sqrt(weight)
        plane = np.linalg.lstsq(sample * root[:, None], z * root, rcond=None)[0]
        residuals = np.abs(z - sample @ plane)
        scatter = MAD_FACTOR * float(np.median(residuals))
        if scatter == 0.0:
            break
        if iteration < MAX_ITERATIONS // 2:
            weight = 1.0 / np.maximum(residuals, 0.05 * scatter)
        else:
            weight = np.maximum(1.0 - (residuals / (_BIWEIGHT_CONSTANT * scatter)) ** 2, 0.0) ** 2
    return plane, scatter
