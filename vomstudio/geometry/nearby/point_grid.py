"""Points sorted by grid cell, for parallel sums over the neighbours of many positions.

Search trees return lists of neighbours, which do not fit into memory for millions of positions. A
compiled loop over the cells stores only the sums.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.threads import PROCESSOR_COUNT, map_parallel
from vomstudio.geometry.kernels.jit import to_kernel_array

MAX_CELLS_PER_AXIS = 2_000_000
"""Limit at which cell numbers still fit into 63 bits."""
POSITIONS_PER_BLOCK = 20_000
_MAX_THREADS = 4


@dataclass(frozen=True, eq=False)
class LocalPlanes:
    """Planes fitted to the points around each of k positions.

    Attributes
    ----------
    count : (k,) ndarray of int
    mean, normal : (k, 3) ndarray
        Centroid, and unit normal of arbitrary sign.
    spread : (k, 3) ndarray
        Eigenvalues of the covariance (divisor n), ascending; NaN if there are too few points.
    """

    count: IntArray
    mean: FloatArray
    normal: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False)
class CylinderStatistics:
    """Statistics of the points in a cylinder around each of k positions.

    Points are measured along the axis of the cylinder, relative to its position.

    Attributes
    ----------
    count : (k,) ndarray of int
    mean, deviation : (k,) ndarray
        Mean and standard deviation (divisor n - 1); NaN if there are too few points.
    """

    count: IntArray
    mean: FloatArray
    deviation: FloatArray


class PointGrid:
    """Grid of points (n, 3) in any unit; non-finite points are ignored.

    `cell` is the side length of a cell, ideally the search radius.
    """

    def __init__(self, points: FloatArray, cell: float) -> None:
        from vomstudio.geometry.kernels.cells import fill_row_table

        is_finite = np.isfinite(points).all(axis=1)
        finite_points = points[is_finite]
        self.corner: FloatArray = (
            np.floor(finite_points.min(axis=0)) if len(finite_points) else np.zeros(3)
        )
        local_points = finite_points - self.corner
        high = local_points.max(axis=0) if len(finite_points) else np.zeros(3)
        self.cell = float(max(cell, high.max() / MAX_CELLS_PER_AXIS, 1e-12))
        self.counts = np.floor(high / self.cell).astype(np.int64) + 1
        keys = self._cell_numbers(local_points)
        order = np.argsort(keys, kind="stable")
        self._row_order = order if is_finite.all() else np.flatnonzero(is_finite)[order]
        self._points = to_kernel_array(local_points[order], np.float64)
        rows, columns = np.divmod(keys[order], self.counts[0])
        self._columns = to_kernel_array(columns, np.int32)
        names, starts = np.unique(rows, return_index=True)
        size = 1 << (2 * len(names) + 1).bit_length()
        self._names, self._ends = np.full(size, -1, np.int64), np.zeros((size, 2), np.int64)
        fill_row_table(
            to_kernel_array(names, np.int64),
            to_kernel_array([*starts, len(rows)], np.int64),
            self._names,
            self._ends,
        )

    def tables(self) -> tuple[FloatArray, Int32Array, IntArray, IntArray, IntArray]:
        """Return the tables of the grid for kernels.

        The tables are the points minus `corner`, sorted by cell; the cell of each point along x;
        the names and ends of the rows of cells, as in `kernels.cells.find_slot`; and the input rows
        of the points.
        """
        return (*self._sorted_tables(), self._row_order)

    def planes(
        self, positions: FloatArray, radius: float, progress: Progress | None = None
    ) -> LocalPlanes:
        """Fit planes to the points within `radius` of each of the positions (k, 3).

        Each step of `progress`, which may raise Cancelled, is one position.
        """
        from vomstudio.geometry.kernels.cells import fit_local_planes

        k = len(positions)
        count = np.zeros(k, np.int64)
        mean, normal, spread = (np.full((k, 3), np.nan) for _ in range(3))

        order = self._order_positions(positions)

        def process_block(block: slice) -> None:
            rows = order[block]
            near_points = to_kernel_array(positions[rows] - self.corner, np.float64)
            n, results = np.zeros(len(rows), np.int64), np.full((3, len(rows), 3), np.nan)
            fit_local_planes(
                *self._sorted_tables(), self.cell, *self._size(), near_points, radius, n, *results
            )
            count[rows] = n
            mean[rows], normal[rows], spread[rows] = results

        run_in_blocks(process_block, k, progress or SilentProgress())
        return LocalPlanes(count, mean + self.corner, normal, spread)

    def curvatures(
        self,
        positions: FloatArray,
        normals: FloatArray,
        radius: float,
        progress: Progress | None = None,
    ) -> FloatArray:
        """Compute the mean curvature (k,) of quadrics fitted to the points near each position.

        The points within `radius` of a position are used. The curvature is in inverse units of the
        points, positive if the surface bends away from the unit normal (k, 3), and NaN for fewer
        than ten points. Each step of `progress`, which may raise Cancelled, is one position.
        """
        from vomstudio.geometry.kernels.quadrics import fit_local_curvatures

        curvatures = np.full(len(positions), np.nan)
        order = self._order_positions(positions)

        def process_block(block: slice) -> None:
            rows = order[block]
            near_points = to_kernel_array(positions[rows] - self.corner, np.float64)
            block_normals, block_curvatures = (
                to_kernel_array(normals[rows], np.float64),
                np.full(len(rows), np.nan),
            )
            fit_local_curvatures(
                *self._sorted_tables(),
                self.cell,
                *self._size(),
                near_points,
                block_normals,
                radius,
                np.zeros((6, 7)),
                block_curvatures,
            )
            curvatures[rows] = block_curvatures

        run_in_blocks(process_block, len(positions), progress or SilentProgress())
        return curvatures

    def along(
        self,
        positions: FloatArray,
        axes: FloatArray,
        radius: float,
        max_distance: float,
        progress: Progress | None = None,
    ) -> CylinderStatistics:
        """Measure the points in cylinders around positions (k, 3) along unit axes (k, 3).

        The cylinders extend by `max_distance` in both directions. Each step of `progress`, which
        may raise Cancelled, is one position.
        """
        from vomstudio.geometry.kernels.cells import measure_along_axes

        k = len(positions)
        count = np.zeros(k, np.int64)
        mean, deviation = np.full(k, np.nan), np.full(k, np.nan)

        order = self._order_positions(positions)

        def process_block(block: slice) -> None:
            rows = order[block]
            near_points = to_kernel_array(positions[rows] - self.corner, np.float64)
            block_axes = to_kernel_array(axes[rows], np.float64)
            n, results = np.zeros(len(rows), np.int64), np.full((2, len(rows)), np.nan)
            measure_along_axes(
                *self._sorted_tables(),
                self.cell,
                *self._size(),
                near_points,
                block_axes,
                radius,
                max_distance,
                n,
                *results,
            )
            count[rows] = n
            mean[rows], deviation[rows] = results

        run_in_blocks(process_block, k, progress or SilentProgress())
        return CylinderStatistics(count, mean, deviation)

    def _cell_numbers(self, local_points: FloatArray) -> IntArray:
        cells = np.clip((local_points / self.cell).astype(np.int64), 0, self.counts - 1)
        return np.asarray(
            cells[:, 0] + self.counts[0] * (cells[:, 1] + self.counts[1] * cells[:, 2]), np.int64
        )

    def _order_positions(self, positions: FloatArray) -> IntArray:
        """Order positions so that points shared by neighbours remain in the processor cache."""
        with np.errstate(invalid="ignore"):
            return np.argsort(self._cell_numbers(positions - self.corner), kind="stable")

    def _sorted_tables(self) -> tuple[FloatArray, Int32Array, IntArray, IntArray]:
        return self._points, self._columns, self._names, self._ends

    def _size(self) -> tuple[int, int, int]:
        x, y, z = (int(count) for count in self.counts)
        return x, y, z


def run_in_blocks(
    process_block: Callable[[slice], Any],
    k: int,
    progress: Progress,
    size: int = POSITIONS_PER_BLOCK,
) -> None:
    """Process rows in blocks, in several threads.

    Parameters
    ----------
    process_block : callable
        Called with the slice of each block; must release the GIL.
    k : int
        Number of rows.
    progress : Progress
        Progress indicator; each step is one row.
    size : int, optional
        Number of rows per block.

    Raises
    ------
    Cancelled
        If the user cancels through `progress`.
    """
    blocks = [slice(start, min(start + size, k)) for start in range(0, k, size)]
    results = map_parallel(process_block, blocks, min(_MAX_THREADS, PROCESSOR_COUNT))
    for block, _ in zip(blocks, results, strict=True):
        progress.step(block.stop)
    if not blocks:
        progress.step(k)
