"""Points sorted by the cells of a grid: sums over all that are near many places, in parallel.

Where a search tree hands out lists of neighbours, which for millions of places do not fit into
memory, a compiled walk over the cells keeps the sums alone.
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

_MOST_CELLS = 2_000_000
"""Along an axis, so that the number of a cell fits into 63 bits."""
_PLACES_AT_ONCE = 20_000
_MAX_THREADS = 4


@dataclass(frozen=True, eq=False)
class LocalPlanes:
    """Of the points around each of k places.

    count : (k,) of them; mean : (k, 3), normal : (k, 3) unit vector of no particular side,
    spread : (k, 3) eigenvalues of their covariance (divisor n), from the least on; NaN where there
        are too few
    """

    count: IntArray
    mean: FloatArray
    normal: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False)
class AlongAxes:
    """Of the points in a cylinder around each of k places.

    count : (k,); mean : (k,) of their positions along the axis, from the place on; deviation : (k,)
        standard, divisor n - 1; NaN where there are too few
    """

    count: IntArray
    mean: FloatArray
    deviation: FloatArray


class PointGrid:
    """points : (n, 3) in any unit; cell : length of a cell's side, best the radius that is asked
    for. Points that are not finite are left out."""

    def __init__(self, points: FloatArray, cell: float) -> None:
        from vomstudio.geometry.kernels.cells import tabulate

        finite = np.isfinite(points).all(axis=1)
        sound = points[finite]
        self.corner: FloatArray = np.floor(sound.min(axis=0)) if len(sound) else np.zeros(3)
        local = sound - self.corner
        high = local.max(axis=0) if len(sound) else np.zeros(3)
        self.cell = float(max(cell, high.max() / _MOST_CELLS, 1e-12))
        self.counts = np.floor(high / self.cell).astype(np.int64) + 1
        keys = self._cells_of(local)
        order = np.argsort(keys, kind="stable")
        self._order_given = order if finite.all() else np.flatnonzero(finite)[order]
        self._points = for_kernels(local[order], np.float64)
        rows, columns = np.divmod(keys[order], self.counts[0])
        self._columns = for_kernels(columns, np.int32)
        named, begins = np.unique(rows, return_index=True)
        size = 1 << (2 * len(named) + 1).bit_length()
        self._names, self._ends = np.full(size, -1, np.int64), np.zeros((size, 2), np.int64)
        tabulate(
            for_kernels(named, np.int64),
            for_kernels([*begins, len(rows)], np.int64),
            self._names,
            self._ends,
        )

    def tables(self) -> tuple[FloatArray, Int32Array, IntArray, IntArray, IntArray]:
        """The points less `corner`, sorted by their cells; the cell of each along x; names and ends
        of rows of cells, as `kernels.cells.slot_of` looks them up; and which points these are."""
        return (*self._sorted(), self._order_given)

    def planes(
        self, places: FloatArray, radius: float, progress: Progress | None = None
    ) -> LocalPlanes:
        """Of the points within `radius` of each of the places (k, 3).

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
            n, found = np.zeros(len(rows), np.int64), np.full((3, len(rows), 3), np.nan)
            planes_near(*self._sorted(), self.cell, *self._size(), near, radius, n, *found)
            count[rows] = n
            mean[rows], normal[rows], spread[rows] = found

        in_blocks(work, k, progress or Silent())
        return LocalPlanes(count, mean + self.corner, normal, spread)

    def curvatures(
        self,
        places: FloatArray,
        normals: FloatArray,
        radius: float,
        progress: Progress | None = None,
    ) -> FloatArray:
        """(k,) mean curvature at the places (k, 3) of the quadric through the points within
        `radius`, one over the unit of the points; positive where the surface bends away from the
        unit normals (k, 3). NaN where fewer than ten points tell none.

        Raises Cancelled through `progress`, whose steps are places.
        """
        from vomstudio.geometry.kernels.quadrics import curvatures_near

        found = np.full(len(places), np.nan)
        order = self._order(places)

        def work(block: slice) -> None:
            rows = order[block]
            near = for_kernels(places[rows] - self.corner, np.float64)
            ways, own = for_kernels(normals[rows], np.float64), np.full(len(rows), np.nan)
            curvatures_near(
                *self._sorted(), self.cell, *self._size(), near, ways, radius, np.zeros((6, 7)), own
            )
            found[rows] = own

        in_blocks(work, len(places), progress or Silent())
        return found

    def along(
        self,
        places: FloatArray,
        axes: FloatArray,
        radius: float,
        reach: float,
        progress: Progress | None = None,
    ) -> AlongAxes:
        """Of the points in cylinders around the places (k, 3), along unit axes (k, 3), `reach` to
        either side. Raises Cancelled through `progress`, whose steps are places."""
        from vomstudio.geometry.kernels.cells import along_axes

        k = len(places)
        count = np.zeros(k, np.int64)
        mean, deviation = np.full(k, np.nan), np.full(k, np.nan)

        order = self._order(places)

        def work(block: slice) -> None:
            rows = order[block]
            near = for_kernels(places[rows] - self.corner, np.float64)
            ways = for_kernels(axes[rows], np.float64)
            n, found = np.zeros(len(rows), np.int64), np.full((2, len(rows)), np.nan)
            along_axes(
                *self._sorted(), self.cell, *self._size(), near, ways, radius, reach, n, *found
            )
            count[rows] = n
            mean[rows], deviation[rows] = found

        in_blocks(work, k, progress or Silent())
        return AlongAxes(count, mean, deviation)

    def _cells_of(self, local: FloatArray) -> IntArray:
        cells = np.clip((local / self.cell).astype(np.int64), 0, self.counts - 1)
        return np.asarray(
            cells[:, 0] + self.counts[0] * (cells[:, 1] + self.counts[1] * cells[:, 2]), np.int64
        )

    def _order(self, places: FloatArray) -> IntArray:
        """Neighbours one after the other, whose points are still in the processor's cache."""
        with np.errstate(invalid="ignore"):
            return np.argsort(self._cells_of(places - self.corner), kind="stable")

    def _sorted(self) -> tuple[FloatArray, Int32Array, IntArray, IntArray]:
        return self._points, self._columns, self._names, self._ends

    def _size(self) -> tuple[int, int, int]:
        x, y, z = (int(v) for v in self.counts)
        return x, y, z


def in_blocks(
    work: Callable[[slice], Any], k: int, progress: Progress, size: int = _PLACES_AT_ONCE
) -> None:
    """Do work on k rows, in blocks of `size` rows and in threads: it must release the GIL.

    The steps of `progress` are rows. Raises Cancelled through `progress`.
    """
    blocks = [slice(at, min(at + size, k)) for at in range(0, k, size)]
    results = map_parallel(work, blocks, min(_MAX_THREADS, PROCESSORS))
    for block, _ in zip(blocks, results, strict=True):
        progress.step(block.stop)
    if not blocks:
        progress.step(k)
