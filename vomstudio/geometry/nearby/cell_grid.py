"""Points of a cloud sorted by cubic cells, each with the cells around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.cell_lists import has_twins, near_cells
from vomstudio.geometry.kernels.jit import for_kernels

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_MOST_CELLS = 1_000_000
"""Along an axis, so that the number of a cell fits into 63 bits."""
_ODD = np.int64(0x9E3779B97F4A7C15 - (1 << 64))
_MOST_TWINS = 200
"""In cells with more points it takes too long to compare each with each."""


@dataclass(frozen=True, eq=False)
class CellGrid:
    """rows : (n,) of the points given, one of each place, sorted by cells; places : (n, 3) theirs;
    begins : (cells + 1,) where those of each cell begin; keys : (cells,) sorted numbers of the
    cells, i + row j + layer k; row_of : (points given,) the place of each"""

    rows: Ints
    places: Array
    begins: Ints
    keys: Ints
    row: int
    layer: int
    row_of: Ints

    def around(self) -> tuple[Ints, npt.NDArray[np.int32]]:
        """The up to 26 cells around each, as starts and list."""
        starts = np.empty(len(self.keys) + 1, np.int64)
        near = np.empty(26 * len(self.keys), np.int32)
        total = near_cells(self.keys, self.row, self.layer, np.zeros(9, np.int64), starts, near)
        return starts, near[:total].copy()


def grid_of(local: Array, per_cell: float) -> CellGrid:
    """Of points (n, 3) from 0 on, with about that many in the cell in which the median point lies.
    Points at one place become one."""
    side = _side(local, per_cell)
    grid = _sorted(local, side)
    crowded = int(np.diff(grid.begins).max()) > _MOST_TWINS
    if not crowded and not has_twins(grid.places, grid.begins):
        return grid
    which = welded(local)
    first = np.full(int(which.max()) + 1, -1, np.int64)
    first[which[::-1]] = np.arange(len(which))[::-1]
    if len(first) == len(local):
        return grid
    own = _sorted(local[first], side)
    return CellGrid(
        first[own.rows], own.places, own.begins, own.keys, own.row, own.layer,
        own.row_of[which],
    )  # fmt: skip


def _side(local: Array, per_cell: float) -> float:
    """By trial: on a surface the points of a cell are as the square of its side."""
    n = len(local)
    size = np.sort(local.max(axis=0))[::-1]
    least = max(float(size[0]) / _MOST_CELLS, 1e-12)
    side = max(float(np.sqrt(size[0] * max(size[1], 1e-12) * per_cell / n)), least)
    for _ in range(4):
        keys = _keys(local, side)[0]
        # Of every sixteenth cell, wherever it lies.
        some = keys[(keys * _ODD).view(np.uint64) >> np.uint64(60) == 0] if n > 10_000 else keys
        count = np.sort(np.unique(some, return_counts=True)[1])
        usual = count[np.searchsorted(np.cumsum(count), 0.5 * len(some))] if len(count) else 1
        ratio = float(np.sqrt(per_cell / usual))
        side = max(side * min(max(ratio, 0.2), 5.0), least)
        if 0.8 < ratio < 1.25:
            break
    return side


def _keys(local: Array, side: float) -> tuple[Ints, int, int]:
    cell = (local * (1.0 / side)).astype(np.int64)
    # An empty cell at both ends, so that the neighbours of a cell are not those beyond a row.
    row, rows = int(cell[:, 0].max()) + 3, int(cell[:, 1].max()) + 3
    layer = row * rows
    return cell[:, 0] + 1 + row * (cell[:, 1] + 1) + layer * (cell[:, 2] + 1), row, layer


def _sorted(local: Array, side: float) -> CellGrid:
    keys, row, layer = _keys(local, side)
    order = np.argsort(keys)
    keys = keys[order]
    changes = np.flatnonzero(keys[1:] != keys[:-1]) + 1
    row_of = np.empty(len(order), np.int64)
    row_of[order] = np.arange(len(order))
    begins = np.concatenate([[0], changes, [len(keys)]]).astype(np.int64)
    return CellGrid(
        order, for_kernels(local[order], np.float64), begins,
        for_kernels(keys[begins[:-1]], np.int64), row, layer, row_of,
    )  # fmt: skip
