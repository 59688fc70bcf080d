"""A grid of square cells over the face of an outcrop, and what of the surface lies in each.

The grid lies in a plane of any attitude and is looked at against its normal. What it holds of a
surface is found exactly: triangles are cut along the lines of the grid.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding

MOST_CELLS = 40_000
_BLOCK = 200_000


@dataclass(frozen=True, eq=False)
class CellGrid:
    """origin : (3,) the lower left corner; right, up : (3,) unit vectors at right angles; cell :
    side of a cell; columns to the right, rows upward. Cells are numbered row by row from 0 at the
    origin. Any frame, any unit."""

    origin: FloatArray
    right: FloatArray
    up: FloatArray
    cell: float
    columns: int
    rows: int

    @property
    def count(self) -> int:
        return self.columns * self.rows

    @property
    def normal(self) -> FloatArray:
        """(3,) toward the viewer."""
        return np.cross(self.right, self.up)

    def local(self, points: FloatArray) -> FloatArray:
        """(..., 3) to the right, up and toward the viewer of points, in sides of a cell."""
        axes = np.stack([self.right, self.up, self.normal], axis=-1)
        return np.asarray((points - self.origin) @ axes / self.cell)

    def at(self, points: FloatArray) -> IntArray:
        """(n,) the cell of each point (n, 3) as it is seen; -1 outside."""
        return self.numbers(np.floor(self.local(points)[:, :2]))

    def numbers(self, places: FloatArray) -> IntArray:
        """(n,) of column and row (n, 2), whole numbers; -1 outside."""
        inside = ((places >= 0) & (places < [self.columns, self.rows])).all(axis=1)
        found = np.full(len(places), -1, np.int64)
        column, row = places[inside].astype(np.int64).T
        found[inside] = row * self.columns + column
        return found

    def corners(self, numbers: IntArray) -> FloatArray:
        """(n, 4, 3) of cells in the grid's plane, around from the lower left."""
        row, column = np.divmod(numbers, self.columns)
        steps = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)
        flat = (np.stack([column, row], axis=1)[:, None] + steps) * self.cell
        return np.asarray(
            self.origin + flat[..., :1] * self.right + flat[..., 1:] * self.up, np.float64
        )


@dataclass(frozen=True, eq=False)
class Exposed:
    """What of a surface lies in each cell, in the square of the grid's unit.

    surface : (cells,) area of what faces the viewer; covered : (cells,) of the cell, as it is seen
    pieces : (k, 3, 3) the triangles, cut along the lines of the grid, cell : (k,) of each; lines :
        (l, 2, 3) where these lines run on the surface. In the grid's local axes and unit (sides of
        a cell); empty where nobody asked for them
    """

    surface: FloatArray
    covered: FloatArray
    pieces: FloatArray
    cell: IntArray
    lines: FloatArray


def grid_around(
    points: FloatArray, right: FloatArray, up: FloatArray, cell: float, margin: float = 0.0
) -> CellGrid:
    """Whole cells around points (n, 3), in the plane through the one nearest to the viewer.

    Raises GeometryError where they are too many, or a cell has no size.
    """
    if not (math.isfinite(cell) and cell > 0.0):
        raise GeometryError(Finding("grid.cell-size"), field="cell")
    if not len(points):
        raise GeometryError(Finding("grid.no-points"))
    axes = np.stack([right, up, np.cross(right, up)], axis=-1)
    seen = points @ axes
    low, high = seen[:, :2].min(axis=0) - margin, seen[:, :2].max(axis=0) + margin
    wanted = (high - low) / cell
    if not wanted.max() < MOST_CELLS or math.prod(np.ceil(wanted).tolist()) > MOST_CELLS:
        least = math.sqrt(float(np.prod(np.maximum(high - low, 1e-12))) / MOST_CELLS)
        raise GeometryError(
            Finding("grid.too-many-cells", maximum=MOST_CELLS, minimum=least),
            field="cell",
        )
    columns, rows = (max(1, math.ceil(w - 1e-9)) for w in wanted.tolist())
    # What is left over stands out alike on both sides.
    corner = (low + high - cell * np.array([columns, rows])) / 2.0
    origin = axes @ np.array([*corner, float(seen[:, 2].max())])
    return CellGrid(origin, right, up, float(cell), columns, rows)


def exposed_faces(
    grid: CellGrid, points: FloatArray, faces: npt.NDArray[np.integer[Any]], *, pieces: bool = False
) -> Exposed:
    """Of triangles, (m, 3) rows of points (n, 3). What faces away from the viewer is not
    exposed; which way faces look is taken from most of their area, since files differ."""
    front, back = _Sums(grid, pieces), _Sums(grid, pieces)
    for start in range(0, len(faces), _BLOCK):
        local = grid.local(points[faces[start : start + _BLOCK]])
        local = local[np.isfinite(local).all(axis=(1, 2))]
        a, b = local[:, 1] - local[:, 0], local[:, 2] - local[:, 0]
        toward = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        front.add(local[toward > 0.0])
        back.add(local[toward < 0.0])
    seen = front if front.covered.sum() >= back.covered.sum() else back
    return seen.result()


def exposed_points(grid: CellGrid, points: FloatArray, spacing: float) -> Exposed:
    """Of a cloud (n, 3), each point of which stands for a square as wide as the spacing."""
    cells = grid.at(points)
    counts = np.bincount(cells[cells >= 0], minlength=grid.count).astype(np.float64)
    area = counts * spacing**2
    none = np.zeros((0, 3, 3))
    return Exposed(area, np.minimum(area, grid.cell**2), none, np.zeros(0, np.int64), none[:, :2])


class _Sums:
    def __init__(self, grid: CellGrid, keep: bool) -> None:
        self.grid, self._keep = grid, keep
        self.surface, self.covered = np.zeros(grid.count), np.zeros(grid.count)
        self._pieces: list[FloatArray] = []
        self._cells: list[IntArray] = []
        self._lines: list[FloatArray] = []

    def add(self, local: FloatArray) -> None:
        """Triangles (m, 3, 3) in the grid's local axes."""
        cut = local
        for axis, count in ((0, self.grid.columns), (1, self.grid.rows)):
            lines: list[FloatArray] = []
            cut = np.concatenate([np.zeros((0, 3, 3)), *_cut(cut, axis, count, lines)])
            if self._keep:
                # Cut along the first axis as yet, these may reach past the ends of the second.
                self._lines += (
                    lines if axis else [_within(found, self.grid.rows) for found in lines]
                )
        cells = self.grid.numbers(np.floor(cut.mean(axis=1)[:, :2]))
        cut, cells = cut[cells >= 0], cells[cells >= 0]
        across = np.cross(cut[:, 1] - cut[:, 0], cut[:, 2] - cut[:, 0])
        for sums, areas in (
            (self.surface, np.linalg.norm(across, axis=1)),
            (self.covered, np.abs(across[:, 2])),
        ):
            sums += np.bincount(cells, areas / 2.0, minlength=self.grid.count)
        if self._keep:
            self._pieces.append(cut)
            self._cells.append(cells)

    def result(self) -> Exposed:
        unit = self.grid.cell**2
        none = np.zeros((0, 3, 3))
        return Exposed(
            self.surface * unit,
            # What lies behind an overhang is seen once.
            np.minimum(self.covered, 1.0) * unit,
            np.concatenate([none, *self._pieces]),
            np.concatenate([np.zeros(0, np.int64), *self._cells]),
            np.concatenate([none[:, :2], *self._lines]),
        )


def _cut(
    triangles: FloatArray, axis: int, count: int, lines: list[FloatArray]
) -> Iterator[FloatArray]:
    """Pieces that lie between two neighbouring lines of the grid, 0 to `count`, along an axis;
    `lines` gets the cuts."""
    left = triangles
    while len(left):
        order = np.argsort(left[:, :, axis], axis=1, kind="stable")
        left = np.take_along_axis(left, order[..., None], axis=1)
        low, high = left[:, 0, axis], left[:, 2, axis]
        inside = (high > 0.0) & (low < count)
        left, low, high = left[inside], low[inside], high[inside]
        line = np.minimum(np.maximum(np.floor(low) + 1.0, 0.0), float(count))
        crossed = (low < line) & (line < high)
        # A piece that ends on the last line is whole.
        yield left[~crossed]
        left, line = left[crossed], line[crossed]
        if not len(left):
            return
        below, above, cuts = _halves(left, line, axis)
        lines.append(cuts)
        yield below[below[..., axis].max(axis=1) > 0.0]
        left = above


def _halves(
    sorted_: FloatArray, line: FloatArray, axis: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Triangles whose corners are in order along an axis, cut by a line each: what lies below and
    above, and (m, 2, 3) the cuts."""
    a, b, c = sorted_[:, 0], sorted_[:, 1], sorted_[:, 2]
    p = _between(a, c, line, axis)
    low = line <= b[:, axis]
    q = np.where(low[:, None], _between(a, b, line, axis), _between(b, c, line, axis))
    one, two = low, ~low
    below = [
        _stack(a[one], q[one], p[one]),
        _stack(a[two], b[two], q[two]),
        _stack(a[two], q[two], p[two]),
    ]
    above = [
        _stack(q[one], b[one], c[one]),
        _stack(q[one], c[one], p[one]),
        _stack(q[two], c[two], p[two]),
    ]
    return np.concatenate(below), np.concatenate(above), np.stack([q, p], axis=1)


def _within(cuts: FloatArray, rows: int) -> FloatArray:
    """What of lines (m, 2, 3) lies between the first and the last row."""
    first, last = cuts[:, 0, 1], cuts[:, 1, 1]
    cuts = cuts[(np.maximum(first, last) > 0.0) & (np.minimum(first, last) < rows)]
    up = cuts[:, 1] - cuts[:, 0]
    rise = np.where(up[:, 1] != 0.0, up[:, 1], 1.0)
    bounds = np.stack([-cuts[:, 0, 1] / rise, (rows - cuts[:, 0, 1]) / rise], axis=1)
    # A level line lies inside as a whole.
    bounds[up[:, 1] == 0.0] = 0.0, 1.0
    share = np.clip(np.sort(bounds, axis=1), 0.0, 1.0)
    return np.asarray(cuts[:, :1] + share[..., None] * up[:, None])


def _between(a: FloatArray, b: FloatArray, line: FloatArray, axis: int) -> FloatArray:
    """(m, 3) where the lines from a to b reach a height."""
    rise = b[:, axis] - a[:, axis]
    share = np.where(rise > 0.0, (line - a[:, axis]) / np.where(rise > 0.0, rise, 1.0), 0.0)
    found = a + np.clip(share, 0.0, 1.0)[:, None] * (b - a)
    found[:, axis] = line
    return np.asarray(found)


def _stack(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    return np.stack([a, b, c], axis=1)
