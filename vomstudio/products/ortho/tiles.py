"""The grid of a picture and its tiles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import ByteArray, Float32Array, Int32Array, IntArray
from vomstudio.core.findings import Finding

TILE = 1024

Drawn_co = TypeVar("Drawn_co", covariant=True)


@dataclass(frozen=True)
class Grid:
    """Pixels over the view plane: column i covers left + i gsd .. left + (i + 1) gsd metres to the
    right of the reference point, row j covers top + j gsd .. below it."""

    left: float
    top: float
    gsd: float
    width: int
    height: int

    @classmethod
    def over(cls, low: npt.ArrayLike, high: npt.ArrayLike, gsd: float) -> Grid:
        """The grid over (x, y) from `low` to `high`, what is left over of the last pixels shared
        between both sides: so the other side's view is a mirror image, pixel by pixel."""
        lowest, highest = (np.asarray(corner, np.float64)[:2] for corner in (low, high))
        width, height = (max(1, math.ceil(v / gsd - 1e-6)) for v in (highest - lowest).tolist())
        middle = lowest + (highest - lowest) / 2
        left, top = (middle - np.array([width, height]) * gsd / 2).tolist()
        return cls(left, top, gsd, width, height)

    @property
    def columns(self) -> int:
        return -(-self.width // TILE)

    @property
    def rows(self) -> int:
        return -(-self.height // TILE)

    def tiles(self) -> list[Tile]:
        return [
            Tile(
                j * self.columns + i,
                i * TILE,
                j * TILE,
                min(TILE, self.width - i * TILE),
                min(TILE, self.height - j * TILE),
            )
            for j in range(self.rows)
            for i in range(self.columns)
        ]


@dataclass(frozen=True)
class Tile:
    """Pixels of a grid: `number` counts along the rows, (column, row) is the top left one."""

    number: int
    column: int
    row: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Members:
    """What each tile of a grid shows: rows of faces or of points."""

    rows: Int32Array
    starts: IntArray

    @classmethod
    def of(
        cls, bin_: Callable[..., None], view: object, what: object, grid: Grid, margin: float
    ) -> Members:
        """bin_ : the kernel that bins, of faces (`what` : (m, 3)) or of points (`what` : (n,) their
        reach, metres); margin : how far beyond a tile what it shows may lie, metres"""
        starts = np.zeros(grid.columns * grid.rows + 1, np.int64)
        where = (view, what, grid.left, grid.top, TILE * grid.gsd, margin, grid.columns, grid.rows)
        bin_(*where, starts, np.empty(0, np.int32))
        starts = np.cumsum(starts)
        rows = np.empty(starts[-1], np.int32)
        if len(rows):
            bin_(*where, starts[:-1].copy(), rows)
        return cls(rows, starts)

    def in_tile(self, tile: Tile) -> Int32Array:
        return self.rows[self.starts[tile.number] : self.starts[tile.number + 1]]


@dataclass(frozen=True, eq=False)
class TilePicture:
    """rgba : (h, w, 4) uint8. depth : (h, w) float32, NaN exactly where the opacity is 0.
    filled : how many pixels were closed over holes."""

    rgba: ByteArray
    depth: Float32Array
    filled: int = 0


def empty(tile: Tile) -> TilePicture:
    shape = (tile.height, tile.width)
    return TilePicture(np.zeros((*shape, 4), np.uint8), np.full(shape, np.nan, np.float32))


class Drawer(Protocol[Drawn_co]):
    """What can draw a tile; called from several threads."""

    def draw(self, tile: Tile) -> Drawn_co: ...


class Source(Drawer[TilePicture], Protocol):
    """What can draw a tile of a picture."""

    def warnings(self) -> list[Finding]:
        """What was noticed while drawing."""
