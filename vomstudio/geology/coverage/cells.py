"""Grid of square cells over an outcrop face, and the area of a surface in each cell.

The grid lies in a plane of any attitude and is viewed against its normal. Areas are exact:
triangles are cut along the grid lines.
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

MAX_CELLS = 40_000
FACES_PER_BLOCK = 200_000


@dataclass(frozen=True, eq=False)
class SquareGrid:
    """Grid of square cells in any frame and unit, numbered row by row from 0 at the origin.

    Attributes
    ----------
    origin : (3,) ndarray
        Lower-left corner.
    right, up : (3,) ndarray
        Perpendicular unit vectors.
    cell : float
        Side length of a cell.
    columns, rows : int
        Number of columns to the right, and of rows upward.
    """

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
        """Unit vector (3,) that points toward the viewer."""
        return np.cross(self.right, self.up)

    def local_coordinates(self, points: FloatArray) -> FloatArray:
        """Return coordinates (..., 3) to the right, up and toward the viewer, in cell sides."""
        axes = np.stack([self.right, self.up, self.normal], axis=-1)
        return np.asarray((points - self.origin) @ axes / self.cell)

    def find_cells(self, points: FloatArray) -> IntArray:
        """Return the cell (n,) that contains each point (n, 3) in the view; -1 if it is outside."""
        return self.numbers(np.floor(self.local_coordinates(points)[:, :2]))

    def numbers(self, positions: FloatArray) -> IntArray:
        """Return the cells (n,) for integer columns and rows (n, 2); -1 if outside."""
        is_inside = ((positions >= 0) & (positions < [self.columns, self.rows])).all(axis=1)
        cell_numbers = np.full(len(positions), -1, np.int64)
        column, row = positions[is_inside].astype(np.int64).T
        cell_numbers[is_inside] = row * self.columns + column
        return cell_numbers

    def corners(self, numbers: IntArray) -> FloatArray:
        """Return the corners (n, 4, 3) of cells in the grid plane, starting at the lower left."""
        row, column = np.divmod(numbers, self.columns)
        steps = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)
        plane_corners = (np.stack([column, row], axis=1)[:, None] + steps) * self.cell
        return np.asarray(
            self.origin + plane_corners[..., :1] * self.right + plane_corners[..., 1:] * self.up,
            np.float64,
        )


@dataclass(frozen=True, eq=False)
class ExposedArea:
    """Exposed area of a surface in each cell, in the squared unit of the grid.

    Attributes
    ----------
    surface : (cells,) ndarray
        Area of the surface that faces the viewer.
    covered : (cells,) ndarray
        Part of the cell area that is covered by the surface in the view.
    pieces : (k, 3, 3) ndarray
        Triangles cut along the grid lines, in the local axes of the grid and in cell sides; empty
        unless requested.
    cell : (k,) ndarray of int
        Cell that each piece belongs to.
    lines : (l, 2, 3) ndarray
        Grid lines on the surface, in the same axes.
    """

    surface: FloatArray
    covered: FloatArray
    pieces: FloatArray
    cell: IntArray
    lines: FloatArray


def create_grid(
    points: FloatArray, right: FloatArray, up: FloatArray, cell: float, margin: float = 0.0
) -> SquareGrid:
    """Create a grid of whole cells that covers given points.

    The plane of the grid contains the point nearest to the viewer.

    Parameters
    ----------
    points : (n, 3) ndarray
    right, up : (3,) ndarray
        Perpendicular unit vectors.
    cell : float
        Side length of a cell in the unit of the points.
    margin : float
        Minimum distance between the points and the edge of the grid.

    Returns
    -------
    SquareGrid

    Raises
    ------
    GeometryError
        If there are no points or too many cells, or if the cell size is not positive.
    """
    if not (math.isfinite(cell) and cell > 0.0):
        raise GeometryError(Finding("grid.cell-size"), field="cell")
    if not len(points):
        raise GeometryError(Finding("grid.no-points"))
    axes = np.stack([right, up, np.cross(right, up)], axis=-1)
    grid_coordinates = points @ axes
    low, high = (
        grid_coordinates[:, :2].min(axis=0) - margin,
        grid_coordinates[:, :2].max(axis=0) + margin,
    )
    counts = (high - low) / cell
    if not counts.max() < MAX_CELLS or math.prod(np.ceil(counts).tolist()) > MAX_CELLS:
        min_cell_size = math.sqrt(float(np.prod(np.maximum(high - low, 1e-12))) / MAX_CELLS)
        raise GeometryError(
            Finding("grid.too-many-cells", maximum=MAX_CELLS, minimum=min_cell_size),
            field="cell",
        )
    columns, rows = (max(1, math.ceil(count - 1e-9)) for count in counts.tolist())
    # The excess is distributed equally to both sides.
    corner = (low + high - cell * np.array([columns, rows])) / 2.0
    origin = axes @ np.array([*corner, float(grid_coordinates[:, 2].max())])
    return SquareGrid(origin, right, up, float(cell), columns, rows)


def measure_faces(
    grid: SquareGrid,
    points: FloatArray,
    faces: npt.NDArray[np.integer[Any]],
    *,
    include_pieces: bool = False,
) -> ExposedArea:
    """Measure the area of triangles in each cell of a grid.

    Faces that point away from the viewer are not exposed. The side with the larger
    area in the view is regarded as exposed, because files differ in the orientation of faces.

    Parameters
    ----------
    grid : SquareGrid
    points : (n, 3) ndarray
    faces : (m, 3) ndarray of int
    include_pieces : bool
        Whether to return the cut triangles and lines as well.

    Returns
    -------
    ExposedArea
    """
    front_sums, back_sums = _AreaSums(grid, include_pieces), _AreaSums(grid, include_pieces)
    for start in range(0, len(faces), FACES_PER_BLOCK):
        local_points = grid.local_coordinates(points[faces[start : start + FACES_PER_BLOCK]])
        local_points = local_points[np.isfinite(local_points).all(axis=(1, 2))]
        a, b = local_points[:, 1] - local_points[:, 0], local_points[:, 2] - local_points[:, 0]
        direction = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        front_sums.add(local_points[direction > 0.0])
        back_sums.add(local_points[direction < 0.0])
    visible_sums = front_sums if front_sums.covered.sum() >= back_sums.covered.sum() else back_sums
    return visible_sums.result()


def measure_points(grid: SquareGrid, points: FloatArray, spacing: float) -> ExposedArea:
    """Measure the area of a cloud whose points represent squares as wide as the spacing.

    Parameters
    ----------
    grid : SquareGrid
    points : (n, 3) ndarray
    spacing : float

    Returns
    -------
    ExposedArea
    """
    cells = grid.find_cells(points)
    counts = np.bincount(cells[cells >= 0], minlength=grid.count).astype(np.float64)
    area = counts * spacing**2
    no_triangles = np.zeros((0, 3, 3))
    return ExposedArea(
        area,
        np.minimum(area, grid.cell**2),
        no_triangles,
        np.zeros(0, np.int64),
        no_triangles[:, :2],
    )


class _AreaSums:
    def __init__(self, grid: SquareGrid, include_pieces: bool) -> None:
        self.grid, self._include_pieces = grid, include_pieces
        self.surface, self.covered = np.zeros(grid.count), np.zeros(grid.count)
        self._pieces: list[FloatArray] = []
        self._cells: list[IntArray] = []
        self._lines: list[FloatArray] = []

    def add(self, local_points: FloatArray) -> None:
        """Add the areas of triangles (m, 3, 3) in the local axes of the grid."""
        pieces = local_points
        for axis, count in ((0, self.grid.columns), (1, self.grid.rows)):
            lines: list[FloatArray] = []
            pieces = np.concatenate(
                [np.zeros((0, 3, 3)), *_cut_triangles(pieces, axis, count, lines)]
            )
            if self._include_pieces:
                # Lines of the first axis may extend beyond the ends of the second axis.
                self._lines += (
                    lines
                    if axis
                    else [_clip_to_rows(segments, self.grid.rows) for segments in lines]
                )
        cells = self.grid.numbers(np.floor(pieces.mean(axis=1)[:, :2]))
        pieces, cells = pieces[cells >= 0], cells[cells >= 0]
        cross_products = np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0])
        for sums, areas in (
            (self.surface, np.linalg.norm(cross_products, axis=1)),
            (self.covered, np.abs(cross_products[:, 2])),
        ):
            sums += np.bincount(cells, areas / 2.0, minlength=self.grid.count)
        if self._include_pieces:
            self._pieces.append(pieces)
            self._cells.append(cells)

    def result(self) -> ExposedArea:
        unit = self.grid.cell**2
        no_triangles = np.zeros((0, 3, 3))
        return ExposedArea(
            self.surface * unit,
            # Count the area behind an overhang only once.
            np.minimum(self.covered, 1.0) * unit,
            np.concatenate([no_triangles, *self._pieces]),
            np.concatenate([np.zeros(0, np.int64), *self._cells]),
            np.concatenate([no_triangles[:, :2], *self._lines]),
        )


def _cut_triangles(
    triangles: FloatArray, axis: int, count: int, lines: list[FloatArray]
) -> Iterator[FloatArray]:
    """Yield the pieces between adjacent grid lines 0 to `count` along an axis.

    The cuts are appended to `lines`.
    """
    remaining_triangles = triangles
    while len(remaining_triangles):
        order = np.argsort(remaining_triangles[:, :, axis], axis=1, kind="stable")
        remaining_triangles = np.take_along_axis(remaining_triangles, order[..., None], axis=1)
        low, high = remaining_triangles[:, 0, axis], remaining_triangles[:, 2, axis]
        is_inside = (high > 0.0) & (low < count)
        remaining_triangles, low, high = (
            remaining_triangles[is_inside],
            low[is_inside],
            high[is_inside],
        )
        line = np.minimum(np.maximum(np.floor(low) + 1.0, 0.0), float(count))
        is_crossed = (low < line) & (line < high)
        # A piece that ends on the last line does not have to be cut.
        yield remaining_triangles[~is_crossed]
        remaining_triangles, line = remaining_triangles[is_crossed], line[is_crossed]
        if not len(remaining_triangles):
            return
        parts_below, parts_above, cuts = _split_triangles(remaining_triangles, line, axis)
        lines.append(cuts)
        yield parts_below[parts_below[..., axis].max(axis=1) > 0.0]
        remaining_triangles = parts_above


def _split_triangles(
    sorted_corners: FloatArray, line: FloatArray, axis: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Split each triangle, whose corners are sorted along an axis, by a grid line.

    Return the pieces below and above the lines, and the cuts (m, 2, 3).
    """
    a, b, c = sorted_corners[:, 0], sorted_corners[:, 1], sorted_corners[:, 2]
    p = _points_on_line(a, c, line, axis)
    low = line <= b[:, axis]
    q = np.where(low[:, None], _points_on_line(a, b, line, axis), _points_on_line(b, c, line, axis))
    is_low, is_high = low, ~low
    parts_below = [
        _stack_triangles(a[is_low], q[is_low], p[is_low]),
        _stack_triangles(a[is_high], b[is_high], q[is_high]),
        _stack_triangles(a[is_high], q[is_high], p[is_high]),
    ]
    parts_above = [
        _stack_triangles(q[is_low], b[is_low], c[is_low]),
        _stack_triangles(q[is_low], c[is_low], p[is_low]),
        _stack_triangles(q[is_high], c[is_high], p[is_high]),
    ]
    return np.concatenate(parts_below), np.concatenate(parts_above), np.stack([q, p], axis=1)


def _clip_to_rows(cuts: FloatArray, rows: int) -> FloatArray:
    """Clip lines (m, 2, 3) to the range between the first and the last row."""
    start_rows, end_rows = cuts[:, 0, 1], cuts[:, 1, 1]
    cuts = cuts[
        (np.maximum(start_rows, end_rows) > 0.0) & (np.minimum(start_rows, end_rows) < rows)
    ]
    directions = cuts[:, 1] - cuts[:, 0]
    height_differences = np.where(directions[:, 1] != 0.0, directions[:, 1], 1.0)
    bounds = np.stack(
        [-cuts[:, 0, 1] / height_differences, (rows - cuts[:, 0, 1]) / height_differences], axis=1
    )
    # A horizontal line is entirely inside.
    bounds[directions[:, 1] == 0.0] = 0.0, 1.0
    fraction = np.clip(np.sort(bounds, axis=1), 0.0, 1.0)
    return np.asarray(cuts[:, :1] + fraction[..., None] * directions[:, None])


def _points_on_line(a: FloatArray, b: FloatArray, line: FloatArray, axis: int) -> FloatArray:
    """Return the points (m, 3) at which the edges from a to b cross a grid line."""
    axis_differences = b[:, axis] - a[:, axis]
    fraction = np.where(
        axis_differences > 0.0,
        (line - a[:, axis]) / np.where(axis_differences > 0.0, axis_differences, 1.0),
        0.0,
    )
    points = a + np.clip(fraction, 0.0, 1.0)[:, None] * (b - a)
    points[:, axis] = line
    return np.asarray(points)


def _stack_triangles(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    return np.stack([a, b, c], axis=1)
