"""Effective resolution of points on a surface: the larger of mean spacing and noise.

The mean spacing is the inverse square root of the density, and the noise is the scatter about local
planes. Vertices added by subdivision are excluded. The distance to the nearest neighbour is not a
resolution: for random points it is half the mean spacing (Clark and Evans 1954), and it does not
include noise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray, FloatingArray, IntArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

NEIGHBOUR_COUNTS = (33, 129, 513, 2049)
"""Numbers of neighbours for spacing and noise; more are used if noise turns them into a ball."""
MIN_INNER_SHARE = 0.2
"""Threshold between a quarter (sheet) and an eighth (ball): noise of half the spacing gives 0.22,
noise of twice the spacing 0.13.
"""


def resolving_points(data: Mesh | PointCloud) -> FloatArray:
    """Return the points that determine the resolution.

    These are all points of a cloud, or the vertices of a mesh that are not interpolated.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    (n, 3) ndarray
    """
    points = data.undivided.vertices if isinstance(data, Mesh) else data.points
    return np.asarray(points, np.float64)


class NeighbourTree(Protocol):
    """Interface of scipy's search tree."""

    n: int

    def query(self, x: FloatArray, k: int) -> tuple[FloatArray, IntArray]: ...


class SmallPointTree:
    """Search tree for few points that avoids the slow import of SciPy."""

    def __init__(self, points: FloatArray) -> None:
        self._points, self.n = points, len(points)

    def query(self, x: FloatArray, k: int) -> tuple[FloatArray, IntArray]:
        square = np.zeros((len(x), self.n))
        for axis in range(self._points.shape[1]):
            offset = x[:, axis, None] - self._points[None, :, axis]
            square += offset * offset
        rows = np.argpartition(square, k - 1, axis=1)[:, :k]
        distance = np.take_along_axis(square, rows, axis=1)
        order = np.argsort(distance, axis=1, kind="stable")
        return (
            np.sqrt(np.take_along_axis(distance, order, axis=1)),
            np.take_along_axis(rows, order, axis=1),
        )


def effective_resolution(
    points: FloatingArray, tree: NeighbourTree, positions: FloatArray
) -> float | None:
    """Return the median resolution around positions on a surface.

    Parameters
    ----------
    points : (n, 3) ndarray of float
    tree : NeighbourTree
        Index of the points.
    positions : (q, 3) ndarray

    Returns
    -------
    float or None
        In the unit of the points; None if the neighbouring points coincide, or if there are no
        positions or fewer than two points.
    """
    query_points = np.asarray(positions, np.float64).reshape(-1, 3)

    def neighbours(count: int) -> FloatArray | None:
        k = min(count, tree.n)
        if k < 2 or not len(query_points):
            return None
        rows = tree.query(query_points, k=k)[1]
        return np.asarray(np.asarray(points)[rows.reshape(len(query_points), k)])

    return resolution_from_neighbours(neighbours)


def resolution_from_neighbours(neighbours: Callable[[int], FloatArray | None]) -> float | None:
    """Return the median resolution at positions from their nearest points.

    The smallest neighbourhoods that resemble a sheet are used: on a sheet, a quarter of the points
    within a radius are within half of it, even at ledges and corners, whose relief is not noise.
    Noise turns smaller neighbourhoods into balls, for which the share is an eighth.

    Parameters
    ----------
    neighbours : callable
        Function that returns the k nearest points (q, k, 3) of the positions, fewer if the surface
        has fewer, or None.

    Returns
    -------
    float or None
        None if there are no neighbours or all of them coincide.
    """
    areas_and_noises: tuple[FloatArray, FloatArray] | None = None
    for count in NEIGHBOUR_COUNTS:
        neighbour_points = neighbours(count)
        if neighbour_points is None or neighbour_points.shape[1] < 2:
            break
        areas_and_noises = neighbour_statistics(neighbour_points)
        if _inner_share(neighbour_points) >= MIN_INNER_SHARE or neighbour_points.shape[1] < count:
            break
    return (
        None if areas_and_noises is None else _resolution_from_areas_and_noises(*areas_and_noises)
    )


def _inner_share(neighbour_points: FloatArray) -> float:
    """Return the share of neighbours within half the distance of the farthest neighbour.

    The neighbours (q, k, 3) are sorted, nearest first.
    """
    distance = np.linalg.norm(neighbour_points[:, 1:] - neighbour_points[:, :1], axis=2)
    return float((distance < 0.5 * distance[:, -1:]).mean())


def _resolution_from_areas_and_noises(areas: FloatArray, noises: FloatArray) -> float | None:
    """Return the larger of the median spacing and the median noise; None if unknown."""
    is_known = np.isfinite(areas) & (areas > 0)
    if not is_known.any():
        return None
    return float(max(np.sqrt(np.median(areas[is_known])), np.median(noises[is_known])))


def neighbour_statistics(neighbour_points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the area per point and the noise about the local plane.

    The area is computed from the ellipse that has the variances of the points; it is accurate to a
    few percent even at borders. Coincident points count once.

    Parameters
    ----------
    neighbour_points : (q, k, 3) ndarray
        Nearest points of q positions, nearest first.

    Returns
    -------
    area : (q,) ndarray
        NaN if all points coincide.
    noise : (q,) ndarray
    """
    nearest_points = neighbour_points[:, :1]
    offsets = neighbour_points - nearest_points
    square = np.einsum("qkx,qkx->qk", offsets, offsets)
    distinct_counts = np.full(len(neighbour_points), neighbour_points.shape[1], np.float64)
    for row in np.flatnonzero((square[:, 1:] == 0.0).any(axis=1)):
        distinct_counts[row] = len(np.unique(neighbour_points[row], axis=0))
    centred_offsets = offsets - offsets.mean(axis=1, keepdims=True)
    values = np.linalg.eigvalsh(
        np.einsum("qkx,qky->qxy", centred_offsets, centred_offsets) / neighbour_points.shape[1]
    )
    values = np.maximum(values, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        n_gaps = np.where(distinct_counts > 1, distinct_counts - 1.0, np.nan)
        # Uniform in an ellipse, the variances are a quarter of the squared semi-axes; on a line,
        # a twelfth of the squared length.
        bias_factor = distinct_counts / n_gaps
        ellipse_area = 4.0 * np.pi * bias_factor * np.sqrt(values[:, 1] * values[:, 2]) / n_gaps
        area = np.maximum(ellipse_area, 12.0 * values[:, 2] / n_gaps**2)
        variance_factor = np.where(
            distinct_counts > 3, distinct_counts / (distinct_counts - 3.0), np.nan
        )
        noise = np.sqrt(values[:, 0] * np.where(distinct_counts > 3, variance_factor, 0.0))
    return area, noise
