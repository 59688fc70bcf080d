"""Neighbour graph of the faces or points of a model, for growing selections.

It is used to grow a piece of the surface from a seed, and to expand or shrink a selection by one
ring. Faces are neighbours if they share an edge, regardless of the number of faces at this edge,
or, for a ring, a corner. Corners at the same position are treated as one, because texture seams
split them; meshes do not have to be manifold. Points are neighbours if they are in adjacent grid
cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vomstudio.core.arrays import BoolArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.kernels.jit import to_kernel_array, to_read_only_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import PointGrid, run_in_blocks
from vomstudio.geometry.nearby.shared_corners import neighbours_across_gaps
from vomstudio.geometry.streaming.octree import StreamedCloud

MAX_PIECE = 2_000_000
"""Maximum number of faces or points in a piece that is grown from one seed."""
CELL_SPACINGS = 2.0
"""Cell size in mean spacings, with about 4 points per cell, and 30 points for a normal."""
_MAX_FREE_SHARE = 0.7
"""Share of free sides above which the faces of a mesh are considered disconnected."""
_BLOCK_SIZE = 1_000_000
_SPARSE_RATIO = 8


@dataclass(frozen=True, eq=False)
class GrownPiece:
    """Piece of a surface that was grown from a seed.

    Parameters
    ----------
    mask : (n,) bool array
        Faces or points that belong to the piece.
    count : int
    is_truncated : bool
        Whether the piece reached the maximum size.
    """

    mask: BoolArray
    count: int
    is_truncated: bool


class NeighbourGraph(Protocol):
    """Neighbour graph of all faces or points of a model. Lengths are in the unit of the file."""

    def piece(
        self, seed: int, *, angle_deg: float, distance: float, is_excluded: BoolArray | None
    ) -> GrownPiece:
        """Grow the planar piece of the surface around a seed.

        The piece contains connected elements whose normals are within `angle_deg` of the normal of
        its plane and whose positions are within `distance` of the plane. The plane is refitted as
        the piece grows.

        Parameters
        ----------
        seed : int
        angle_deg, distance : float
        is_excluded : (n,) bool array or None
            Elements to exclude.
        """

    def expand(self, selection: BoolArray) -> BoolArray:
        """Add the neighbours of the selected elements (n,)."""

    def shrink(self, selection: BoolArray) -> BoolArray:
        """Remove selected elements (n,) that have a neighbour outside the selection."""


def build_neighbour_graph(data: Mesh | PointCloud, spacing: float) -> NeighbourGraph:
    """Build the neighbour graph of a model, which takes seconds for millions of elements.

    Parameters
    ----------
    data : Mesh or PointCloud
    spacing : float
        Typical distance between points; 0 if unknown.

    Raises
    ------
    GeometryError
        If a mesh has no faces, or if a cloud is streamed or has fewer than four points.
    """
    if isinstance(data, Mesh):
        return MeshNeighbourGraph(data)
    if isinstance(data, StreamedCloud):
        raise GeometryError(Finding("cloud.streamed"))
    return CloudNeighbourGraph(data, spacing)


class MeshNeighbourGraph:
    """Faces of a mesh with their normals and their neighbours across edges."""

    def __init__(self, mesh: Mesh) -> None:
        from vomstudio.extraction.selection.region_kernels import (
            compute_face_normals,
            find_adjacent_faces,
            smooth_normals,
        )

        self._faces = faces = to_read_only_array(mesh.faces, np.int32)
        self._vertices = to_read_only_array(mesh.vertices, np.float64)
        if not len(faces):
            raise GeometryError(Finding("model.no-faces"))
        nodes = weld_points(self._vertices).astype(np.int32)
        self._corners = to_kernel_array(nodes[faces], np.int32)
        self._corner_count = int(nodes.max()) + 1
        starts, neighbours = _list_faces_at_corners(self._corners, self._corner_count)
        raw_normals = np.empty((len(faces), 3), np.float32)
        self._normals = np.empty((len(faces), 3), np.float32)
        self._gap_neighbours = np.empty((len(faces), 3), np.int32)

        def compute_normals(rows: slice) -> None:
            compute_face_normals(self._vertices, faces[rows], raw_normals[rows])

        def average_normals(rows: slice) -> None:
            smooth_normals(
                self._corners[rows],
                starts,
                neighbours,
                raw_normals,
                rows.start,
                self._normals[rows],
            )
            find_adjacent_faces(
                self._corners, starts, neighbours, rows.start, self._gap_neighbours[rows]
            )

        run_in_blocks(compute_normals, len(faces), SilentProgress(), _BLOCK_SIZE)
        run_in_blocks(average_normals, len(faces), SilentProgress(), _BLOCK_SIZE)
        self._connect_across_gaps(nodes)

    def _connect_across_gaps(self, nodes: Int32Array) -> None:
        """Connect tiles that do not share corners but form one surface."""
        is_free = self._gap_neighbours < 0
        if is_free.mean() > _MAX_FREE_SHARE:
            return
        free_faces = np.flatnonzero(is_free.any(axis=1))
        corners_xyz = self._vertices[self._faces[free_faces]]
        is_finite = np.isfinite(corners_xyz).all(axis=(1, 2))
        free_faces, corners_xyz = free_faces[is_finite], corners_xyz[is_finite]
        corners = nodes[self._faces[free_faces]].astype(np.int64)
        row, side, second_row = neighbours_across_gaps(corners, corners_xyz, is_free[free_faces])
        self._gap_neighbours[free_faces[row], side] = free_faces[second_row]

    def piece(
        self, seed: int, *, angle_deg: float, distance: float, is_excluded: BoolArray | None
    ) -> GrownPiece:
        from vomstudio.extraction.selection.region_kernels import grow_faces

        n = len(self._faces)
        is_visited = np.zeros(n, np.bool_) if is_excluded is None else is_excluded.copy()
        queue = np.empty(min(MAX_PIECE, n), np.int32)
        if not np.isfinite(self._normals[seed, 0]):
            # If the face has no area, start from one of its neighbours.
            ring = np.flatnonzero(self.expand(_single_mask(seed, n)))
            usable_ring = ring[np.isfinite(self._normals[ring, 0])]
            if not len(usable_ring):
                return GrownPiece(_single_mask(seed, n), 1, False)
            seed = int(usable_ring[0])
        count = grow_faces(
            self._vertices,
            self._faces,
            self._gap_neighbours,
            self._normals,
            is_visited,
            seed,
            float(np.cos(np.radians(angle_deg))),
            distance,
            np.zeros(6),
            np.zeros(10),
            queue,
        )
        mask = np.zeros(n, np.bool_)
        mask[queue[:count]] = True
        return GrownPiece(mask, count, count == len(queue) < n)

    def expand(self, selection: BoolArray) -> BoolArray:
        from vomstudio.extraction.selection.region_kernels import find_marked_faces, mark_nodes

        is_selected = to_kernel_array(selection, np.bool_)
        is_marked = np.zeros(self._corner_count, np.bool_)
        out = np.zeros(len(selection), np.bool_)

        def mark(rows: slice) -> None:
            mark_nodes(self._corners[rows], is_selected[rows], is_marked)

        def read(rows: slice) -> None:
            find_marked_faces(self._corners[rows], is_marked, out[rows])

        run_in_blocks(mark, len(out), SilentProgress(), _BLOCK_SIZE)
        run_in_blocks(read, len(out), SilentProgress(), _BLOCK_SIZE)
        return out

    def shrink(self, selection: BoolArray) -> BoolArray:
        return selection & ~self.expand(~selection)


class CloudNeighbourGraph:
    """Neighbour graph of the points of a cloud.

    `has_estimated_normals` is True if the cloud has no normals; they are then estimated for each
    cell of a grid.
    """

    def __init__(self, cloud: PointCloud, spacing: float) -> None:
        points = np.asarray(cloud.points)
        if len(points) < 4:
            raise GeometryError(Finding("cloud.too-few-points", n=len(points), minimum=4))
        extent = float(np.linalg.norm(np.ptp(cloud.bounds, axis=0)))
        self._cell_size = CELL_SPACINGS * (spacing or extent / np.sqrt(len(points)) or 1.0)
        grid = PointGrid(points, self._cell_size)
        self._cell_size = grid.cell
        self._points, columns, names, ends, self._rows = grid.tables()
        self._count, self._ny = len(points), int(grid.counts[1])
        self._cell_starts, self._row, self._column, self._ends = _find_cells(columns, names, ends)
        self._names = names
        # Position of each point in the sorted order; -1 if the point is not finite.
        self._cell_positions = np.full(len(points), -1, np.int32)
        self._cell_positions[self._rows] = np.arange(len(self._rows), dtype=np.int32)
        self._normals = np.full((len(self._row), 3), np.nan, np.float32)
        self.has_estimated_normals = cloud.normals is None
        self._point_normals = np.zeros((0, 3), np.float32)
        if cloud.normals is not None:
            self._point_normals = to_kernel_array(np.asarray(cloud.normals)[self._rows], np.float32)

    def _cell_tables(self) -> tuple[IntArray, IntArray, Int32Array, IntArray, IntArray, int]:
        return self._cell_starts, self._row, self._column, self._names, self._ends, self._ny

    def piece(
        self, seed: int, *, angle_deg: float, distance: float, is_excluded: BoolArray | None
    ) -> GrownPiece:
        from vomstudio.extraction.selection.region_kernels import grow_points

        n, cells = len(self._points), len(self._row)
        out = np.zeros(n, np.bool_) if is_excluded is None else is_excluded[self._rows]
        queue = np.empty(min(MAX_PIECE, n), np.int32)
        mask = np.zeros(self._count, np.bool_)
        position = int(self._cell_positions[seed])
        if position < 0:
            return GrownPiece(mask, 0, False)
        cell = int(np.searchsorted(self._cell_starts, position, side="right")) - 1
        count = grow_points(
            self._points,
            self._point_normals,
            *self._cell_tables(),
            self._normals,
            out,
            np.zeros(cells, np.bool_),
            position,
            cell,
            float(np.cos(np.radians(angle_deg))),
            distance,
            np.zeros(6),
            np.zeros(10),
            np.empty(27, np.int64),
            np.empty(cells, np.int32),
            queue,
        )
        if count < 0:
            return GrownPiece(mask, 0, False)
        mask[self._rows[queue[:count]]] = True
        return GrownPiece(mask, count, count == len(queue) < n)

    def expand(self, selection: BoolArray) -> BoolArray:
        return self._change_ring(selection, includes_outer=True)

    def shrink(self, selection: BoolArray) -> BoolArray:
        return self._change_ring(selection, includes_outer=False)

    def _sort_selection(self, selection: BoolArray) -> tuple[BoolArray, Int32Array]:
        """Return a selection in the order of the cells, and the cells with selected points."""
        ids = np.flatnonzero(selection)
        if len(ids) * _SPARSE_RATIO > len(selection):
            sorted_selection = selection[self._rows]
            has_selected = np.logical_or.reduceat(sorted_selection, self._cell_starts[:-1])
            return sorted_selection, to_kernel_array(np.flatnonzero(has_selected), np.int32)
        # A few among many millions are looked up individually.
        sorted_selection = np.zeros(len(self._points), np.bool_)
        position = np.sort(self._cell_positions[ids])
        position = position[position >= 0]
        sorted_selection[position] = True
        cells = np.searchsorted(self._cell_starts, position, side="right") - 1
        is_first = np.ones(len(cells), np.bool_)
        np.not_equal(cells[1:], cells[:-1], out=is_first[1:])
        return sorted_selection, to_kernel_array(cells[is_first], np.int32)

    def _change_ring(self, selection: BoolArray, *, includes_outer: bool) -> BoolArray:
        from vomstudio.extraction.selection.region_kernels import mark_ring

        sorted_selection, cells = self._sort_selection(selection)
        is_gained, is_lost = (
            np.zeros(len(sorted_selection), np.bool_),
            np.zeros(len(sorted_selection), np.bool_),
        )

        def mark_rows(rows: slice) -> None:
            mark_ring(
                self._points,
                *self._cell_tables(),
                sorted_selection,
                cells[rows],
                self._cell_size,
                np.empty(27, np.int64),
                is_gained,
                is_lost,
            )

        run_in_blocks(mark_rows, len(cells), SilentProgress(), _BLOCK_SIZE // 4)
        result = selection.copy()
        result[self._rows[is_gained if includes_outer else is_lost]] = includes_outer
        return result


def _find_cells(
    columns: Int32Array, names: IntArray, ends: IntArray
) -> tuple[IntArray, IntArray, Int32Array, IntArray]:
    """Find the cells of points that are sorted by row and column.

    Return the start of each cell (c + 1,), its row and column (c,), and the runs of cells of each
    row, which replace the runs of points in `ends`.
    """
    is_first = np.ones(len(columns), np.bool_)
    np.not_equal(columns[1:], columns[:-1], out=is_first[1:])
    used_rows = np.flatnonzero(names >= 0)
    is_first[ends[used_rows, 0]] = True
    first_rows = np.flatnonzero(is_first)
    runs = np.zeros_like(ends)
    runs[used_rows] = np.searchsorted(first_rows, ends[used_rows])
    row = np.empty(len(first_rows), np.int64)
    order = used_rows[np.argsort(ends[used_rows, 0])]
    row[:] = np.repeat(names[order], (runs[order, 1] - runs[order, 0]))
    return (
        np.append(first_rows, len(columns)),
        row,
        to_kernel_array(columns[first_rows], np.int32),
        runs,
    )


def _single_mask(row: int, count: int) -> BoolArray:
    mask = np.zeros(count, np.bool_)
    mask[row] = True
    return mask


def _list_faces_at_corners(corners: Int32Array, count: int) -> tuple[IntArray, Int32Array]:
    """Return the faces at each of `count` positions as (starts, faces).

    The faces at position i are `faces[starts[i]:starts[i + 1]]`.
    """
    from scipy.sparse import csr_array

    starts = np.arange(0, corners.size + 1, 3, dtype=np.int32)
    shape = (len(corners), count)
    # Compressing by columns is a counting sort in C that releases the interpreter lock.
    columns = csr_array((np.ones(corners.size, np.bool_), corners.ravel(), starts), shape).tocsc()
    return to_kernel_array(columns.indptr, np.int64), to_kernel_array(columns.indices, np.int32)
