"""Points of a cloud sorted by cubic cells, each with the cells around it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.cell_lists import (
    bounds_of,
    cell_numbers,
    has_twins,
    lined_up,
    near_cells,
    some_numbers,
    sort_upper,
)
from vomstudio.geometry.kernels.jit import for_kernels

_MOST_CELLS = 1_000_000
"""Along an axis, so that the number of a cell fits into 63 bits."""
_FEW = 10_000
"""Of more points a sixteenth tells the size of cells."""
_MOST_TWINS = 200
"""In cells with more points it takes too long to compare each with each."""


@dataclass(frozen=True, eq=False)
class CellGrid:
    """rows : (n,) of the points given, one of each place, sorted by cells; places : (n, 3) theirs;
    begins : (cells + 1,) where those of each cell begin; keys : (cells,) sorted numbers of the
    cells, i + row j + layer k, counted from 1 on; row_of : (points given,) the place of each;
    side : of a cell"""

    rows: IntArray
    places: FloatArray
    begins: IntArray
    keys: IntArray
    row: int
    layer: int
    row_of: IntArray
    side: float

    @cached_property
    def _around(self) -> tuple[IntArray, Int32Array]:
        starts = np.empty(len(self.keys) + 1, np.int64)
        near = np.empty(26 * len(self.keys), np.int32)
        total = near_cells(self.keys, self.row, self.layer, np.zeros(9, np.int64), starts, near)
        return starts, near[:total].copy()

    def around(self) -> tuple[IntArray, Int32Array]:
        """The up to 26 cells around each, as starts and list."""
        return self._around

    def count_around(self) -> IntArray:
        """(cells,) how many points are in each cell and those around it."""
        starts, near = self._around
        count = np.diff(self.begins)
        return np.asarray(np.diff(np.append(0, np.cumsum(count[near]))[starts]) + count)

    def cells_of(self, places: IntArray) -> IntArray:
        """The cell of each of these places."""
        return np.asarray(np.searchsorted(self.begins, places, side="right") - 1)


def grid_of(local: FloatArray, per_cell: float) -> CellGrid:
    """Of points (n, 3) from 0 on, with about that many in the cell in which the median point lies.
    Points at one place become one."""
    local = for_kernels(local, np.float64)
    high = np.full(3, -np.inf)
    bounds_of(local, np.full(3, np.inf), high)
    side = _side(local, high, per_cell)
    grid = _sorted(local, high, side)
    crowded = int(np.diff(grid.begins).max()) > _MOST_TWINS
    if not crowded and not has_twins(grid.places, grid.begins):
        return grid
    which = welded(local)
    first = np.full(int(which.max()) + 1, -1, np.int64)
    first[which[::-1]] = np.arange(len(which))[::-1]
    if len(first) == len(local):
        return grid
    own = _sorted(for_kernels(local[first], np.float64), high, side)
    return CellGrid(
        first[own.rows],
        own.places,
        own.begins,
        own.keys,
        own.row,
        own.layer,
        own.row_of[which],
        side,
    )


def _side(local: FloatArray, high: FloatArray, per_cell: float) -> float:
    """By trial: on a surface the points of a cell are as the square of its side."""
    n = len(local)
    size = np.sort(high)[::-1]
    least = max(float(size[0]) / _MOST_CELLS, 1e-12)
    side = max(float(np.sqrt(size[0] * max(size[1], 1e-12) * per_cell / n)), least)
    room = np.empty(n, np.int64)
    for _ in range(4):
        row, layer = _steps(high, side)
        if n > _FEW:
            some = room[: some_numbers(local, 1.0 / side, row, layer, room)]
        else:
            some = room
            cell_numbers(local, 1.0 / side, row, layer, room)
        count = np.sort(np.unique(some, return_counts=True)[1])
        usual = count[np.searchsorted(np.cumsum(count), 0.5 * len(some))] if len(count) else 1
        ratio = float(np.sqrt(per_cell / usual))
        side = max(side * min(max(ratio, 0.2), 5.0), least)
        if 0.8 < ratio < 1.25:
            break
    return side


def _steps(high: FloatArray, side: float) -> tuple[int, int]:
    """From a cell to those in the next row and in the next layer."""
    # An empty cell at both ends, so that the neighbours of a cell are not those beyond a row.
    row, rows = (int(high[i] * (1.0 / side)) + 3 for i in range(2))
    return row, row * rows


def _sorted(local: FloatArray, high: FloatArray, side: float) -> CellGrid:
    n = len(local)
    row, layer = _steps(high, side)
    numbers, room = np.empty(n, np.int64), np.empty(n, np.int64)
    cell_numbers(local, 1.0 / side, row, layer, numbers)
    bits = max(n - 1, 1).bit_length()
    length = int(numbers.max()).bit_length()
    if bits + length < 63:
        numbers <<= bits
        numbers |= np.arange(n)
        sort_upper(numbers, bits, bits + length, room, np.zeros(512, np.int64))
    else:
        order = np.argsort(numbers, kind="stable")
        named, which = np.unique(numbers, return_inverse=True)
        numbers = (which[order] << bits) | order
    rows, row_of, keys = np.empty(n, np.int64), np.empty(n, np.int64), room
    places, begins = np.empty((n, 3)), np.empty(n + 1, np.int64)
    count = lined_up(numbers, bits, local, rows, row_of, places, keys, begins)
    keys = keys[:count].copy() if bits + length < 63 else named
    return CellGrid(rows, places, begins[: count + 1].copy(), keys, row, layer, row_of, side)
