"""Effective resolution of points on a surface: the larger of their mean spacing, which is one over
the root of their density, and of their noise about local planes. Vertices that subdivision has put
between others are no such points.

The gap to the nearest neighbour is no resolution: it is half of the mean spacing where points lie
at random (Clark and Evans 1954), and knows nothing of noise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray, FloatingArray, IntArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

COUNTS = (33, 129, 513, 2049)
"""Neighbours from which spacing and noise are taken; more where noise makes a ball of them."""
_SHEET = 0.2
"""Between a quarter and an eighth: noise of half the spacing makes 0.22, of twice it 0.13."""


def resolving_points(data: Mesh | PointCloud) -> FloatArray:
    """Return the points that count for the resolution: all of a cloud, of a mesh the vertices that
    do not follow from others by linear interpolation."""
    points = data.undivided.vertices if isinstance(data, Mesh) else data.points
    return np.asarray(points, np.float64)


class Tree(Protocol):
    """A scipy tree of points."""

    n: int

    def query(self, x: FloatArray, k: int) -> tuple[FloatArray, IntArray]: ...


class FewPoints:
    """A tree of few points without the import of scipy, which takes longer than the search."""

    def __init__(self, points: FloatArray) -> None:
        self._points, self.n = points, len(points)

    def query(self, x: FloatArray, k: int) -> tuple[FloatArray, IntArray]:
        off = x[:, None] - self._points[None]
        square = (off * off).sum(axis=2)
        rows = np.argsort(square, axis=1, kind="stable")[:, :k]
        return np.sqrt(np.take_along_axis(square, rows, axis=1)), rows


def effective_resolution(points: FloatingArray, tree: Tree, places: FloatArray) -> float | None:
    """Typical resolution around places (q, 3) of a surface, in the unit of its points (n, 3); the
    tree is of these points. None where the points around stand at one place."""
    index = np.asarray(places, np.float64).reshape(-1, 3)

    def neighbours(count: int) -> FloatArray | None:
        k = min(count, tree.n)
        if k < 2 or not len(index):
            return None
        rows = tree.query(index, k=k)[1]
        return np.asarray(np.asarray(points)[rows.reshape(len(index), k)])

    return resolution_by(neighbours)


def resolution_by(neighbours: Callable[[int], FloatArray | None]) -> float | None:
    """Typical resolution of places whose nearest points `neighbours` gives: (q, k, 3), fewer than
    it is asked for where there are no more, None where there are none.

    Taken from the smallest neighbourhoods that are pieces of a sheet: of its points within a radius
    a quarter lie within half of it, at ledges and corners too, whose relief is no noise of the
    model. Noise makes a ball of neighbourhoods that are smaller than itself, with an eighth.
    """
    found: tuple[FloatArray, FloatArray] | None = None
    for count in COUNTS:
        near = neighbours(count)
        if near is None or near.shape[1] < 2:
            break
        found = of_neighbours(near)
        if _inner_share(near) >= _SHEET or near.shape[1] < count:
            break
    return None if found is None else _larger(*found)


def _inner_share(near: FloatArray) -> float:
    """Of the neighbours (q, k, 3) of the first point of each row, nearest first."""
    distance = np.linalg.norm(near[:, 1:] - near[:, :1], axis=2)
    return float((distance < 0.5 * distance[:, -1:]).mean())


def _larger(areas: FloatArray, noises: FloatArray) -> float | None:
    """The larger of spacing and noise, each the median of what the places tell."""
    known = np.isfinite(areas) & (areas > 0)
    if not known.any():
        return None
    return float(max(np.sqrt(np.median(areas[known])), np.median(noises[known])))


def of_neighbours(near: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Area that each point has for itself, and noise about the local plane, each (q,), for q places
    with their k nearest points (q, k, 3), nearest first.

    The area is that of the ellipse with the variances of the points, which holds within some
    percent at the rim of a surface too. Points that stand twice count once. NaN where all stand at
    one place.
    """
    first = near[:, :1]
    off = near - first
    square = np.einsum("qkx,qkx->qk", off, off)
    distinct = np.full(len(near), near.shape[1], np.float64)
    for row in np.flatnonzero((square[:, 1:] == 0.0).any(axis=1)):
        distinct[row] = len(np.unique(near[row], axis=0))
    centred = off - off.mean(axis=1, keepdims=True)
    values = np.linalg.eigvalsh(np.einsum("qkx,qky->qxy", centred, centred) / near.shape[1])
    values = np.maximum(values, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        gaps = np.where(distinct > 1, distinct - 1.0, np.nan)
        # Uniform in an ellipse, the variances are a quarter of the squared semi-axes; on a line,
        # a twelfth of the squared length.
        unbiased = distinct / gaps
        ellipse = 4.0 * np.pi * unbiased * np.sqrt(values[:, 1] * values[:, 2]) / gaps
        area = np.maximum(ellipse, 12.0 * values[:, 2] / gaps**2)
        free = np.where(distinct > 3, distinct / (distinct - 3.0), np.nan)
        noise = np.sqrt(values[:, 0] * np.where(distinct > 3, free, 0.0))
    return area, noise
