"""Points of a cloud sorted into cubic cells with known neighbouring cells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.kernels.cell_lists import (
    cell_numbers,
    find_bounds,
    find_neighbouring_cells,
    has_coincident_points,
    number_points_in_cells,
    radix_sort,
    sort_points_by_cell,
)
from vomstudio.geometry.kernels.jit import to_kernel_array

MAX_CELLS_PER_AXIS = 1_000_000
"""Limit at which cell numbers still fit into 63 bits."""
MAX_COUNTED_POINTS = 10_000
"""Maximum number of points that are all used to determine the cell size; of a larger number, one
sixteenth is used.
"""
MAX_PAIRWISE_POINTS = 200
"""Maximum number of points of a cell in which all pairs are compared."""


@dataclass(frozen=True, eq=False)
class CellGrid:
    """Points sorted by cubic cell.

    Attributes
    ----------
    rows : (n,) ndarray of int
        Rows of the input points, one per distinct position, sorted by cell.
    places : (n, 3) ndarray
        Coordinates of these points.
    starts : (cells + 1,) ndarray of int
        First point of each cell.
    keys : (cells,) ndarray of int
        Sorted numbers of the cells, i + row j + layer k, counted from 1.
    inverse_rows : ndarray of int
        Index in `places` of each input point.
    cell_size : float
        Side length of a cell.
    """

    rows: IntArray
    places: FloatArray
    starts: IntArray
    keys: IntArray
    row: int
    layer: int
    inverse_rows: IntArray
    cell_size: float

    @cached_property
    def _neighbouring_cells(self) -> tuple[IntArray, Int32Array]:
        starts = np.empty(len(self.keys) + 1, np.int64)
        neighbours = np.empty(26 * len(self.keys), np.int32)
        neighbour_count = find_neighbouring_cells(
            self.keys, self.row, self.layer, np.zeros(9, np.int64), starts, neighbours
        )
        return starts, neighbours[:neighbour_count].copy()

    def neighbouring_cells(self) -> tuple[IntArray, Int32Array]:
        """Return the neighbouring cells (at most 26) of each cell, as start indices and a list."""
        return self._neighbouring_cells

    def count_neighbourhood_points(self) -> IntArray:
        """Return the number of points in each cell and its neighbours (cells,)."""
        starts, neighbours = self._neighbouring_cells
        count = np.diff(self.starts)
        return np.asarray(np.diff(np.append(0, np.cumsum(count[neighbours]))[starts]) + count)

    def find_cells(self, places: IntArray) -> IntArray:
        """Return the cell of each of the given rows of `places`."""
        return np.asarray(np.searchsorted(self.starts, places, side="right") - 1)


def create_cell_grid(local_points: FloatArray, points_per_cell: float) -> CellGrid:
    """Sort points into cubic cells.

    Coincident points become one.

    Parameters
    ----------
    local_points : (n, 3) ndarray
        Coordinates, not negative.
    points_per_cell : float
        Approximate number of points in the cell of the median point.

    Returns
    -------
    CellGrid
    """
    local_points = to_kernel_array(local_points, np.float64)
    high = np.full(3, -np.inf)
    find_bounds(local_points, np.full(3, np.inf), high)
    cell_size = _cell_size(local_points, high, points_per_cell)
    grid = _sort_into_cells(local_points, high, cell_size)
    is_crowded = int(np.diff(grid.starts).max()) > MAX_PAIRWISE_POINTS
    if not is_crowded and not has_coincident_points(grid.places, grid.starts):
        return grid
    position_ids = weld_points(local_points)
    first_point = np.full(int(position_ids.max()) + 1, -1, np.int64)
    first_point[position_ids[::-1]] = np.arange(len(position_ids))[::-1]
    if len(first_point) == len(local_points):
        return grid
    distinct_grid = _sort_into_cells(
        to_kernel_array(local_points[first_point], np.float64), high, cell_size
    )
    return CellGrid(
        first_point[distinct_grid.rows],
        distinct_grid.places,
        distinct_grid.starts,
        distinct_grid.keys,
        distinct_grid.row,
        distinct_grid.layer,
        distinct_grid.inverse_rows[position_ids],
        cell_size,
    )


def _cell_size(local_points: FloatArray, high: FloatArray, points_per_cell: float) -> float:
    """Determine the side of a cell iteratively.

    On a surface, counts grow with the square of the side.
    """
    n = len(local_points)
    size = np.sort(high)[::-1]
    min_side = max(float(size[0]) / MAX_CELLS_PER_AXIS, 1e-12)
    cell_size = max(float(np.sqrt(size[0] * max(size[1], 1e-12) * points_per_cell / n)), min_side)
    buffer = np.empty(n, np.int64)
    for _ in range(4):
        row, layer = _number_strides(high, cell_size)
        if n > MAX_COUNTED_POINTS:
            numbers = buffer[
                : number_points_in_cells(local_points, 1.0 / cell_size, row, layer, buffer)
            ]
        else:
            numbers = buffer
            cell_numbers(local_points, 1.0 / cell_size, row, layer, buffer)
        count = np.sort(np.unique(numbers, return_counts=True)[1])
        median_count = (
            count[np.searchsorted(np.cumsum(count), 0.5 * len(numbers))] if len(count) else 1
        )
        ratio = float(np.sqrt(points_per_cell / median_count))
        cell_size = max(cell_size * min(max(ratio, 0.2), 5.0), min_side)
        if 0.8 < ratio < 1.25:
            break
    return cell_size


def _number_strides(high: FloatArray, cell_size: float) -> tuple[int, int]:
    """Return the step of cell numbers to the next row and to the next layer."""
    # Empty cells at both ends of a row, so that neighbours do not wrap to the next row.
    row, rows = (int(high[i] * (1.0 / cell_size)) + 3 for i in range(2))
    return row, row * rows


def _sort_into_cells(local_points: FloatArray, high: FloatArray, cell_size: float) -> CellGrid:
    n = len(local_points)
    row, layer = _number_strides(high, cell_size)
    numbers, buffer = np.empty(n, np.int64), np.empty(n, np.int64)
    cell_numbers(local_points, 1.0 / cell_size, row, layer, numbers)
    bits = max(n - 1, 1).bit_length()
    length = int(numbers.max()).bit_length()
    if bits + length < 63:
        numbers <<= bits
        numbers |= np.arange(n)
        radix_sort(numbers, bits, bits + length, buffer, np.zeros(512, np.int64))
    else:
        order = np.argsort(numbers, kind="stable")
        names, inverse = np.unique(numbers, return_inverse=True)
        numbers = (inverse[order] << bits) | order
    rows, inverse_rows, keys = np.empty(n, np.int64), np.empty(n, np.int64), buffer
    positions, starts = np.empty((n, 3)), np.empty(n + 1, np.int64)
    count = sort_points_by_cell(
        numbers, bits, local_points, rows, inverse_rows, positions, keys, starts
    )
    keys = keys[:count].copy() if bits + length < 63 else names
    return CellGrid(
        rows, positions, starts[: count + 1].copy(), keys, row, layer, inverse_rows, cell_size
    )
