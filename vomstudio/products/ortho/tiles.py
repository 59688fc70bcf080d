"""Pixel grid of a picture, and its tiles."""

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

TileResult_co = TypeVar("TileResult_co", covariant=True)


@dataclass(frozen=True)
class Grid:
    """Pixel grid in the view plane.

    Column i extends from left + i gsd to left + (i + 1) gsd metres to the right of the reference
    point. Row j extends from top + j gsd to top + (j + 1) gsd metres below it.
    """

    left: float
    top: float
    gsd: float
    width: int
    height: int

    @classmethod
    def from_bounds(cls, low: npt.ArrayLike, high: npt.ArrayLike, gsd: float) -> Grid:
        """Build the grid that covers (x, y) from `low` to `high`.

        The excess of the last pixels is distributed equally to both sides, so that the opposite
        view is an exact mirror image.
        """
        lowest, highest = (np.asarray(corner, np.float64)[:2] for corner in (low, high))
        width, height = (max(1, math.ceil(v / gsd - 1e-6)) for v in (highest - lowest).tolist())
        centre = lowest + (highest - lowest) / 2
        x_left, y_top = (centre - np.array([width, height]) * gsd / 2).tolist()
        return cls(x_left, y_top, gsd, width, height)

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
    """Tile of a grid, numbered row by row; (column, row) is its top left pixel."""

    number: int
    column: int
    row: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Members:
    """Rows of the faces or points in each tile of a grid."""

    rows: Int32Array
    starts: IntArray

    @classmethod
    def of(
        cls,
        bin_elements: Callable[..., None],
        view: object,
        elements: object,
        grid: Grid,
        margin: float,
    ) -> Members:
        """Assign faces or points to tiles.

        Parameters
        ----------
        bin_elements : callable
            Kernel `bin_faces` or `bin_points`.
        view : (n, 3) array
        elements : (m, 3) or (n,) array
            Faces, or radii of points in metres.
        grid : Grid
        margin : float
            Maximum distance of a member from its tile, m.
        """
        starts = np.zeros(grid.columns * grid.rows + 1, np.int64)
        bin_arguments = (
            view,
            elements,
            grid.left,
            grid.top,
            TILE * grid.gsd,
            margin,
            grid.columns,
            grid.rows,
        )
        bin_elements(*bin_arguments, starts, np.empty(0, np.int32))
        starts = np.cumsum(starts)
        rows = np.empty(starts[-1], np.int32)
        if len(rows):
            bin_elements(*bin_arguments, starts[:-1].copy(), rows)
        return cls(rows, starts)

    def tile_rows(self, tile: Tile) -> Int32Array:
        return self.rows[self.starts[tile.number] : self.starts[tile.number + 1]]


@dataclass(frozen=True, eq=False)
class TilePicture:
    """Picture of a tile.

    Parameters
    ----------
    rgba : (h, w, 4) uint8 array
    depth : (h, w) float32 array
        Depth of each pixel; NaN exactly where the opacity is 0.
    filled : int
        Number of pixels in holes that were filled.
    """

    rgba: ByteArray
    depth: Float32Array
    filled: int = 0


def empty_picture(tile: Tile) -> TilePicture:
    """Return an empty picture of a tile."""
    shape = (tile.height, tile.width)
    return TilePicture(np.zeros((*shape, 4), np.uint8), np.full(shape, np.nan, np.float32))


class Drawer(Protocol[TileResult_co]):
    """Protocol of objects that draw a tile; they are called from several threads."""

    def draw(self, tile: Tile) -> TileResult_co: ...


class TileSource(Drawer[TilePicture], Protocol):
    """Protocol of objects that draw the picture of a tile."""

    def warnings(self) -> list[Finding]:
        """Return findings about the drawing."""
