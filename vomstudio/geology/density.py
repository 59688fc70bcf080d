"""Density of poles and lines on the lower hemisphere: grids, contour levels and maxima.

There are four counting methods for axial data. Kamb's method (Kamb 1959, Journal of Geophysical
Research 64, 1891-1909) uses a counting circle that is larger if there are few data, so that the
expected count of a uniform distribution is `sigma` (3) times its standard deviation. The linear and
exponential kernels (Vollmer 1995, Computers & Geosciences 21, 31-49) smooth this count. Schmidt's
method counts in 1 % of the hemisphere, regardless of the number of data.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from vomstudio.core.arrays import FloatArray, IntegerArray
from vomstudio.core.words import to_translate
from vomstudio.geology.stereonet import hemisphere_grid

DENSITY_METHODS = ("kamb", "exponential_kamb", "linear_kamb", "schmidt")
DENSITY_UNITS = {
    "kamb": to_translate("standard deviations"),
    "exponential_kamb": to_translate("standard deviations"),
    "linear_kamb": to_translate("standard deviations"),
    "schmidt": to_translate("% of data per 1 % area"),
}
SIGMA = 3.0
MAX_LEVELS = 8

TILE_SIZE = 8
BLOCK_SIZE = TILE_SIZE**2
MAX_PAIRS = 100_000
"""Maximum number of cosines in one step, so that they stay in the cache."""
MIN_PEAK_SHARE = 0.8
"""Minimum density of a local maximum from which an ascent starts, relative to the highest."""
MAX_PEAKS = 8
NEGLIGIBLE_EXPONENT = 30.0
"""Poles with an exponent below minus this value contribute less than 1e-13 and are skipped."""


def density(
    vectors: npt.ArrayLike,
    position: npt.ArrayLike,
    method: str = "exponential_kamb",
    sigma: float = SIGMA,
) -> FloatArray:
    """Compute the density (m,) of axial data at given unit vectors.

    Kamb densities are reduced by half a count, as is usual, but never below zero. The function is
    fastest if consecutive rows of `position` are neighbours on the sphere.

    Parameters
    ----------
    vectors : (n, 3) array_like
        Axial data.
    position : (m, 3) array_like
        Unit vectors.
    method : str
        "kamb": count in a circle with an area of sigma^2 / (n + sigma^2) of the hemisphere, in
        standard deviations of a uniform distribution (Kamb 1959), whose density is `sigma`.
        "exponential_kamb" and "linear_kamb": the same with a smooth kernel (Vollmer 1995).
        "schmidt": share of the data per 1 % of the area, which is 1 for a uniform distribution.
    sigma : float
        Expected count of a uniform distribution, in its standard deviations.

    Returns
    -------
    (m,) ndarray

    Raises
    ------
    ValueError
        If the method is unknown.
    """
    kernel = _Kernel.of(method, np.atleast_2d(np.asarray(vectors)).shape[0], sigma)
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    g = np.atleast_2d(np.asarray(position, dtype=np.float64))
    return _density_of_blocks(v, g, np.arange(0, len(g), BLOCK_SIZE), kernel)


def _density_of_blocks(
    vectors: FloatArray, positions: FloatArray, starts: IntegerArray, kernel: _Kernel
) -> FloatArray:
    """Compute the density (m,) at blocks of adjacent positions, given their first rows."""
    counts = np.zeros(len(positions))
    for start, end in zip(starts, [*starts[1:], len(positions)], strict=True):
        near_points = _select_contributing_vectors(vectors, positions[start:end], kernel)
        if not len(near_points):
            continue
        step = max(1, MAX_PAIRS // len(near_points))
        for j in range(start, end, step):
            k = min(j + step, end)
            cosine = positions[j:k] @ near_points.T
            counts[j:k] = kernel.count(np.abs(cosine, out=cosine))
    correction = 0.0 if kernel.method == "schmidt" else 0.5
    return np.maximum((counts - correction) / kernel.scale, 0.0)


@dataclass(frozen=True)
class _Kernel:
    """Weight of a pole at a point, as a function of the cosine of the angle between them.

    Attributes
    ----------
    cap_fraction : float
        Area of the counting circle as a share of the hemisphere.
    scale : float
        Count that corresponds to a density of one.
    cutoff_deg : float
        Maximum angular distance of a pole that contributes, degrees.
    """

    method: str
    cap_fraction: float
    steepness: float
    scale: float
    cutoff_deg: float

    @classmethod
    def of(cls, method: str, n: int, sigma: float) -> _Kernel:
        if method not in DENSITY_METHODS:
            raise ValueError(f"unknown method {method!r}; use one of {DENSITY_METHODS}")
        cap_fraction = counting_area(n, method, sigma)
        if method == "schmidt":
            return cls(method, cap_fraction, 0.0, cap_fraction * n, _half_angle_deg(cap_fraction))
        if method != "exponential_kamb":
            return cls(
                method,
                cap_fraction,
                0.0,
                math.sqrt(n * cap_fraction * (1.0 - cap_fraction)),
                _half_angle_deg(cap_fraction),
            )
        steepness = 2.0 * (1.0 + n / sigma**2)
        scale = math.sqrt(n * (steepness / 2.0 - 1.0) / steepness**2)
        return cls(
            method, cap_fraction, steepness, scale, _half_angle_deg(NEGLIGIBLE_EXPONENT / steepness)
        )

    def count(self, cosine: FloatArray) -> FloatArray:
        """Return the counts (m,) for cosines (m, k), whose array is used as working memory."""
        if self.method in ("schmidt", "kamb"):
            return np.asarray((cosine >= 1.0 - self.cap_fraction).sum(axis=1), dtype=np.float64)
        if self.method == "linear_kamb":
            exceedance = np.maximum(cosine - (1.0 - self.cap_fraction), 0.0)
            return np.asarray(exceedance.sum(axis=1) * (2.0 / self.cap_fraction))
        cosine -= 1.0
        cosine *= self.steepness
        return np.asarray(np.exp(cosine, out=cosine).sum(axis=1))


def counting_area(n: int, method: str = "exponential_kamb", sigma: float = SIGMA) -> float:
    """Return the area of the counting circle as a fraction of the hemisphere.

    Parameters
    ----------
    n : int
        Number of data.
    method : str, optional
    sigma : float, optional
        Expected density of uniform data in their standard deviations.

    Returns
    -------
    float
    """
    return 0.01 if method == "schmidt" else sigma**2 / (n + sigma**2)


def _half_angle_deg(cap_fraction: float) -> float:
    """Return the half-angle of a circle that covers a fraction of the hemisphere, degrees."""
    return math.degrees(math.acos(max(1.0 - cap_fraction, 0.0)))


def _select_contributing_vectors(
    vectors: FloatArray, block: FloatArray, kernel: _Kernel
) -> FloatArray:
    """Select the data (n, 3) that contribute anywhere in a block of points (m, 3)."""
    direction = block.sum(axis=0)
    length = float(np.linalg.norm(direction))
    if length < 1e-9 or kernel.cutoff_deg >= 90.0:
        return vectors
    direction /= length
    block_radius_deg = math.degrees(
        math.acos(min(max(float((block @ direction).min()), -1.0), 1.0))
    )
    max_angle_deg = block_radius_deg + kernel.cutoff_deg + 1e-6
    if max_angle_deg >= 90.0:
        return vectors
    return np.asarray(vectors[np.abs(vectors @ direction) >= math.cos(math.radians(max_angle_deg))])


def density_grid(
    vectors: npt.ArrayLike,
    method: str = "exponential_kamb",
    size: int | None = None,
    sigma: float = SIGMA,
) -> tuple[FloatArray, FloatArray]:
    """Compute the density on a square grid of the lower hemisphere.

    Parameters
    ----------
    vectors : (n, 3) array_like
        Axial data.
    method : str
    size : int, optional
        Number of grid points per side; by default `grid_size`.
    sigma : float

    Returns
    -------
    steps : (size,) ndarray
        Longitudes of the columns and latitudes of the rows. See `hemisphere_grid`.
    density : (size, size) ndarray
    """
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    n = grid_size(len(v), method, sigma) if size is None else size
    steps, positions = hemisphere_grid(n)
    # Process the grid in tiles, because only few data contribute to a block of adjacent points.
    row, column = np.indices((n, n)) // TILE_SIZE
    tiles = (row * n + column).ravel()
    order = np.argsort(tiles, kind="stable")
    starts = np.searchsorted(tiles[order], np.unique(tiles))
    kernel = _Kernel.of(method, len(v), sigma)
    values = np.zeros(n * n)
    values[order] = _density_of_blocks(v, positions.reshape(-1, 3)[order], starts, kernel)
    return steps, values.reshape(n, n)


def grid_size(n: int, method: str = "exponential_kamb", sigma: float = SIGMA) -> int:
    """Return the number of grid points per side, between 61 and 161.

    Their spacing is a third of the radius of the counting circle.

    Parameters
    ----------
    n : int
        Number of data.
    method : str, optional
    sigma : float, optional
        See `counting_area`.

    Returns
    -------
    int
    """
    spacing_deg = _half_angle_deg(counting_area(n, method, sigma)) / 3.0
    return int(min(max(2 * round(90.0 / spacing_deg) + 1, 61), 161))


def choose_round_levels(maximum: float, method: str) -> list[float]:
    """Return up to seven round contour levels below the maximum density.

    The levels are multiples of 2 (or more) standard deviations, or round shares. There is only one
    level if the maximum is very large.

    Parameters
    ----------
    maximum : float
    method : str

    Returns
    -------
    list of float
    """
    steps = (2, 4, 5, 10, 20, 50, 100, 200, 500) if method != "schmidt" else (1, 2, 5, 10, 20, 50)
    for step in steps:
        if maximum / step <= MAX_LEVELS:
            count = math.ceil(maximum / step) - 1
            return [float(step * (i + 1)) for i in range(max(count, 0))]
    return [float(steps[-1])]


def find_maximum(
    vectors: npt.ArrayLike,
    method: str = "exponential_kamb",
    sigma: float = SIGMA,
    grid: FloatArray | None = None,
) -> tuple[FloatArray, float]:
    """Find the direction of maximum density of axial data.

    Parameters
    ----------
    vectors : (n, 3) array_like
    method : str
    sigma : float
    grid : (size, size) ndarray, optional
        The density as returned by `density_grid` for the same data, method and sigma. With the
        exponential kernel it replaces the search on a lattice, which takes as long as the
        computation of the grid.

    Returns
    -------
    direction : (3,) ndarray
        Unit vector that points down. If the density is constant over an area (the counts of Kamb
        and Schmidt have steps), it is the centre of the area, provided that the density there is
        the same.
    density : float
    """
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    if grid is not None and method == "exponential_kamb":
        return _ascend_from_grid(v, grid, _Kernel.of(method, len(v), sigma), method, sigma)
    positions = _sort_by_position(np.vstack([_spiral_lattice(4000), v[:: max(1, len(v) // 2000)]]))
    densities = density(v, positions, method, sigma)
    best_position, maximum = positions[int(np.argmax(densities))], float(densities.max())
    half_angle_deg = _half_angle_deg(counting_area(len(v), method, sigma))
    if method in ("kamb", "schmidt"):
        equal_maxima = positions[densities >= maximum - 1e-9]
        equal_maxima = (
            equal_maxima * np.where(equal_maxima @ best_position < 0.0, -1.0, 1.0)[:, None]
        )
        min_cosine = math.cos(math.radians(min(2.0 * half_angle_deg, 90.0)))
        direction = equal_maxima[equal_maxima @ best_position >= min_cosine].sum(axis=0)
        direction /= np.linalg.norm(direction)
        if density(v, direction, method, sigma)[0] >= maximum - 1e-9:
            best_position = direction
    else:
        best_position = _ascend_density(v, best_position, _Kernel.of(method, len(v), sigma))
        maximum = max(maximum, float(density(v, best_position, method, sigma)[0]))
    return (-best_position if best_position[2] > 0 else best_position), maximum


def _ascend_from_grid(
    vectors: FloatArray, grid: FloatArray, kernel: _Kernel, method: str, sigma: float
) -> tuple[FloatArray, float]:
    """Find the maximum by ascent from the highest local maxima of a density grid."""
    neighbours = sliding_window_view(np.pad(grid, 1, constant_values=-np.inf), (3, 3))
    peaks = np.argwhere(
        (grid >= neighbours.max(axis=(2, 3))) & (grid >= MIN_PEAK_SHARE * grid.max())
    )
    highest_peaks = peaks[np.argsort(-grid[tuple(peaks.T)], kind="stable")][:MAX_PEAKS]
    _, positions = hemisphere_grid(len(grid))
    maxima = np.array([_ascend_density(vectors, positions[i, j], kernel) for i, j in highest_peaks])
    densities = density(vectors, maxima, method, sigma)
    best_position = maxima[int(np.argmax(densities))]
    return (-best_position if best_position[2] > 0 else best_position), float(densities.max())


def _spiral_lattice(n: int) -> FloatArray:
    """Return n unit vectors (n, 3) on a spiral, evenly distributed over the lower hemisphere."""
    i = np.arange(n) + 0.5
    z, angle = -i / n, np.pi * (1.0 + math.sqrt(5.0)) * i
    h = np.sqrt(1.0 - z**2)
    return np.stack([h * np.cos(angle), h * np.sin(angle), z], axis=-1)


def _sort_by_position(positions: FloatArray) -> FloatArray:
    """Sort axes (n, 3) so that most axes of a block are adjacent on the net."""
    lower_positions = np.where(positions[:, 2:] > 0.0, -positions, positions)
    equal_area_coordinates = lower_positions[:, :2] / np.sqrt(
        1.0 - np.minimum(lower_positions[:, 2:], 0.0)
    )
    column, row = np.floor((equal_area_coordinates + 1.0) * 8.0).astype(int).T
    return np.asarray(lower_positions[np.lexsort((row, column))])


def _ascend_density(vectors: FloatArray, start: FloatArray, kernel: _Kernel) -> FloatArray:
    """Find the local maximum of the density near a unit vector by ascent.

    A step leads to the direction of the sum of the data, weighted by the slopes of their kernels.
    Both smooth kernels are convex functions of position, so the density never decreases. A step of
    Newton's method is used if it ascends more.
    """
    position = start
    # The maximum is as wide as the kernel, so a few kernel radii include all relevant data.
    radius_deg = min(3.0 * kernel.cutoff_deg, 90.0)
    vectors = vectors[np.abs(vectors @ start) >= math.cos(math.radians(radius_deg)) - 1e-12]
    for _ in range(2000):
        cosine = vectors @ position
        if kernel.method == "linear_kamb":
            slope = (np.abs(cosine) >= 1.0 - kernel.cap_fraction).astype(np.float64)
        else:
            slope = np.exp(kernel.steepness * (np.abs(cosine) - 1.0))
        gradient = (slope * np.where(cosine < 0.0, -1.0, 1.0)) @ vectors
        next_position = gradient / np.linalg.norm(gradient)
        if kernel.method == "exponential_kamb":
            newton_position = _newton_step(vectors, position, slope, gradient, kernel.steepness)
            candidates = np.stack([next_position, newton_position])
            next_position = candidates[np.argmax(kernel.count(np.abs(candidates @ vectors.T)))]
        change = float(np.abs(next_position - position).max())
        position = next_position
        if change < 1e-12:
            break
    return np.asarray(position)


def _newton_step(
    vectors: FloatArray,
    position: FloatArray,
    slope: FloatArray,
    gradient: FloatArray,
    steepness: float,
) -> FloatArray:
    """Return the unit vector (3,) to which Newton's method moves on the sphere.

    Parameters
    ----------
    vectors : (n, 3) ndarray
    position : (3,) ndarray
    slope : (n,) ndarray
        Weights of the data.
    gradient : (3,) ndarray
        Weighted sum of the data, flipped into the hemisphere of `position`.
    steepness : float

    Returns
    -------
    (3,) ndarray
        `position` if the density is not concave there.
    """
    basis = np.linalg.svd(position[None])[2][1:]
    tangents = vectors @ basis.T
    curvature = steepness * (tangents.T * slope) @ tangents - (gradient @ position) * np.eye(2)
    if np.linalg.eigvalsh(curvature)[-1] >= 0.0:
        return position
    next_position = position - np.linalg.solve(curvature, basis @ gradient) @ basis
    return np.asarray(next_position / np.linalg.norm(next_position))
