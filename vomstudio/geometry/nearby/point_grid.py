"""Points sorted by grid cells, for parallel sums over the neighbours of many places.

Search trees return lists of neighbours, which for millions of places do not fit into memory; a
compiled loop over the cells stores only the sums.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.threads import PROCESSORS, map_parallel
from vomstudio.geometry.kernels.jit import for_kernels

MAX_CELLS_PER_AXIS = 2_000_000
"""Limit for cell numbers of 63 bits."""
PLACES_PER_BLOCK = 20_000
_MAX_THREADS = 4


@dataclass(frozen=True, eq=False)
class LocalPlanes:
    """Planes of the points around each of k places.

    Attributes
    ----------
    count : (k,) ndarray of int
    mean, normal : (k, 3) ndarray
        Centroid, and unit normal in either direction.
    spread : (k, 3) ndarray
        Eigenvalues of the covariance (divisor n), ascending; NaN for too few points.
    """

    count: IntArray
    mean: FloatArray
    normal: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False)
class CylinderStatistics:
    """Positions of points in a cylinder around each of k places, along its axis.

    They are relative to the place.

    Attributes
    ----------
    count : (k,) ndarray of int
    mean, deviation : (k,) ndarray
        Mean and standard deviation (divisor n - 1); NaN for too few points.
    """

    count: IntArray
    mean: FloatArray
    deviation: FloatArray


class PointGrid:
    """Grid of points (n, 3) in any unit; points that are not finite are ignored.

    `cell` is the side of a cell, ideally the search radius.
    """

    def __init__(self, points: FloatArray, cell: float) -> None:
        from vomstudio.geometry.kernels.cells import tabulate

        is_finite = np.isfinite(points).all(axis=1)
        finite_points = points[is_finite]
        self.corner: FloatArray = (
            np.floor(finite_points.min(axis=0)) if len(finite_points) else np.zeros(3)
        )
        local = finite_points - self.corner
        high = local.max(axis=0) if len(finite_points) else np.zeros(3)
        self.cell = float(max(cell, high.max() / MAX_CELLS_PER_AXIS, 1e-12))
        self.counts = np.floor(high / self.cell).astype(np.int64) + 1
        keys = self._cells_of(local)
        order = np.argsort(keys, kind="stable")
        self._order_given = order if is_finite.all() else np.flatnonzero(is_finite)[order]
        self._points = for_kernels(local[order], np.float64)
        rows, columns = np.divmod(keys[order], self.counts[0])
        self._columns = for_kernels(columns, np.int32)
        names, begins = np.unique(rows, return_index=True)
        size = 1 << (2 * len(names) + 1).bit_length()
        self._names, self._ends = np.full(size, -1, np.int64), np.zeros((size, 2), np.int64)
        tabulate(
            for_kernels(names, np.int64),
            for_kernels([*begins, len(rows)], np.int64),
            self._names,
            self._ends,
        )

    def tables(self) -> tuple[FloatArray, Int32Array, IntArray, IntArray, IntArray]:
        """Return the tables of the grid for kernels.

        The points minus `corner`, sorted by cells; the cell of each along x; names and ends of rows
        of cells, as in `kernels.cells.slot_of`; and the input rows of the points.
        """
        return (*self._sorted(), self._order_given)

    def planes(
        self, places: FloatArray, radius: float, progress: Progress | None = None
    ) -> LocalPlanes:
        """Fit planes to the points within `radius` of each of the places (k, 3).

        Raises Cancelled through `progress`, whose steps are places.
        """
        from vomstudio.geometry.kernels.cells import planes_near

        k = len(places)
        count = np.zeros(k, np.int64)
        mean, normal, spread = (np.full((k, 3), np.nan) for _ in range(3))

        order = self._order(places)

        def work(block: slice) -> None:
            rows = order[block]
            near = for_kernels(places[rows] - self.corner, np.float64)
            n, results = np.zeros(len(rows), np.int64), np.full((3, len(rows), 3), np.nan)
            planes_near(*self._sorted(), self.cell, *self._size(), near, radius, n, *results)
            count[rows] = n
            mean[rows], normal[rows], spread[rows] = results

        run_in_blocks(work, k, progress or Silent())
        return LocalPlanes(count, mean + self.corner, normal, spread)

    def curvatures(
        self,
        places: FloatArray,
        normals: FloatArray,
        radius: float,
        progress: Progress | None = None,
    ) -> FloatArray:
        """Compute the mean curvature (k,) of quadrics through the points near places.

        The points are within `radius`.

        In inverse units of the points, positive if the surface bends away from the unit normals (k,
        3); NaN for fewer than ten points. Raises Cancelled through `progress`, whose steps are
        places.
        """
        from vomstudio.geometry.kernels.quadrics import curvatures_near

        curvatures = np.full(len(places), np.nan)
        order = self._order(places)

        def work(block: slice) -> None:
            rows = order[block]
            near = for_kernels(places[rows] - self.corner, np.float64)
            block_normals, block_curvatures = (
                for_kernels(normals[rows], np.float64),
                np.full(len(rows), np.nan),
            )
            curvatures_near(
                *self._sorted(),
                self.cell,
                *self._size(),
                near,
                block_normals,
                radius,
                np.zeros((6, 7)),
                block_curvatures,
            )
            curvatures[rows] = block_curvatures

        run_in_blocks(work, len(places), progress or Silent())
        return curvatures

    def along(
        self,
        places: FloatArray,
        axes: FloatArray,
        radius: float,
        reach: float,
        progress: Progress | None = None,
    ) -> CylinderStatistics:
        """Measure the points in cylinders around places (k, 3), along unit axes (k, 3).

        The cylinders extend by `reach` to either side. Raises Cancelled through `progress`, whose
        steps are places.
        """
        from vomstudio.geometry.kernels.cells import along_axes

        k = len(places)
        count = np.zeros(k, np.int64)
        mean, deviation = np.full(k, np.nan), np.full(k, np.nan)

        order = self._order(places)

        def work(block: slice) -> None:
            rows = order[block]
            near = for_kernels(places[rows] - self.corner, np.float64)
            block_axes = for_kernels(axes[rows], np.float64)
            n, results = np.zeros(len(rows), np.int64), np.full((2, len(rows)), np.nan)
            along_axes(
                *self._sorted(),
                self.cell,
                *self._size(),
                near,
                block_axes,
                radius,
                reach,
                n,
                *results,
            )
            count[rows] = n
            mean[rows], deviation[rows] = results

        run_in_blocks(work, k, progress or Silent())
        return CylinderStatistics(count, mean, deviation)

    def _cells_of(self, local: FloatArray) -> IntArray:
        cells = np.clip((local / self.cell).astype(np.int64), 0, self.counts - 1)
        return np.asarray(
            cells[:, 0] + self.counts[0] * (cells[:, 1] + self.counts[1] * cells[:, 2]), np.int64
        )

    def _order(self, places: FloatArray) -> IntArray:
        """Order places so that the points of neighbours remain in the processor's cache."""
        with np.errstate(invalid="ignore"):
            return np.argsort(self._cells_of(places - self.corner), kind="stable")

    def _sorted(self) -> tuple[FloatArray, Int32Array, IntArray, IntArray]:
        return self._points, self._columns, self._names, self._ends

    def _size(self) -> tuple[int, int, int]:
        x, y, z = (int(v) for v in self.counts)
        return x, y, z


def run_in_blocks(
    work: Callable[[slice], Any], k: int, progress: Progress, size: int = PLACES_PER_BLOCK
) -> None:
    """Run work on rows in blocks and in threads.

    Parameters
    ----------
    work : callable
        Called with the slice of each block; must release the GIL.
    k : int
        Number of rows.
    progress : Progress
        Its steps are rows.
    size : int, optional
        Number of rows per block.

    Raises
    ------
    Cancelled
        If the user cancels through `progress`.
    """
    blocks = [slice(start, min(start + size, k)) for start in range(0, k, size)]
    results = map_parallel(work, blocks, min(_MAX_THREADS, PROCESSORS))
    for block, _ in zip(blocks, results, strict=True):
        progress.step(block.stop)
    if not blocks:
        progress.step(k)
