"""Which faces or points of a model lie beside each other: to grow a piece of its surface from one
of them, and to make what is chosen wider or narrower by a ring.

Faces are beside each other where they share an edge, however many have it, or for a ring a corner;
corners at one place are one, since a seam of the texture splits them. So a mesh that is no manifold
is as good as another. Points are where they stand in cells of a grid that touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vomstudio.core.arrays import BoolArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Silent
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.jit import for_kernels, for_reading
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import PointGrid, run_in_blocks
from vomstudio.geometry.nearby.shared_corners import neighbours_across_gaps
from vomstudio.geometry.streaming.octree import StreamedCloud

MOST = 2_000_000
"""So many faces or points a piece has at most that grows from one click."""
CELL = 2.0
"""Mean spacings on a side of the cells in which points stand: about 4 points each, and 30 in those
that touch one, of which a normal is worked out."""
_APART = 0.7
"""Of sides that are of one face only: where more are, the faces do not hang together."""
_AT_ONCE = 1_000_000
_FEW = 8


@dataclass(frozen=True, eq=False)
class Piece:
    """mask : (n,) which faces or points belong to it; count : how many; stopped : it would have
    grown on, but for the most it may have"""

    mask: BoolArray
    count: int
    stopped: bool


class Neighbours(Protocol):
    """Of all the faces or points of one model. Lengths are in the file's unit."""

    def piece(
        self, seed: int, *, angle_deg: float, distance: float, left_out: BoolArray | None
    ) -> Piece:
        """The surface around `seed` as far as it is even: what hangs together, with normals within
        the angle of its plane and places within the distance of that. The plane is fitted anew as
        the piece grows. left_out : (n,) what takes no part"""

    def wider(self, chosen: BoolArray) -> BoolArray:
        """With those beside the chosen ones."""

    def narrower(self, chosen: BoolArray) -> BoolArray:
        """Without those that have one beside them which is not chosen."""


def neighbours_of(data: Mesh | PointCloud, spacing: float) -> Neighbours:
    """Takes seconds for millions. spacing : usual distance between points, 0 where it is not known.
    Raises GeometryError where nothing can grow."""
    if isinstance(data, Mesh):
        return MeshNeighbours(data)
    if isinstance(data, StreamedCloud):
        raise GeometryError(Finding("cloud.streamed"))
    return CloudNeighbours(data, spacing)


class MeshNeighbours:
    def __init__(self, mesh: Mesh) -> None:
        from vomstudio.extraction.selection.region_kernels import (
            across_edges,
            face_normals,
            smooth_normals,
        )

        self._faces = faces = for_reading(mesh.faces, np.int32)
        self._vertices = for_reading(mesh.vertices, np.float64)
        if not len(faces):
            raise GeometryError(Finding("model.no-faces"))
        nodes = welded(self._vertices).astype(np.int32)
        self._corners = for_kernels(nodes[faces], np.int32)
        self._places = int(nodes.max()) + 1
        starts, near = _faces_at(self._corners, self._places)
        raw = np.empty((len(faces), 3), np.float32)
        self._normals = np.empty((len(faces), 3), np.float32)
        self._beside = np.empty((len(faces), 3), np.int32)

        def own(rows: slice) -> None:
            face_normals(self._vertices, faces[rows], raw[rows])

        def mean(rows: slice) -> None:
            smooth_normals(self._corners[rows], starts, near, raw, rows.start, self._normals[rows])
            across_edges(self._corners, starts, near, rows.start, self._beside[rows])

        run_in_blocks(own, len(faces), Silent(), _AT_ONCE)
        run_in_blocks(mean, len(faces), Silent(), _AT_ONCE)
        self._reach_over_gaps(nodes)

    def _reach_over_gaps(self, nodes: Int32Array) -> None:
        """Tiles that share no corners are one surface all the same. nodes : of the vertices"""
        alone = self._beside < 0
        if alone.mean() > _APART:
            return
        free = np.flatnonzero(alone.any(axis=1))
        own = self._vertices[self._faces[free]]
        sound = np.isfinite(own).all(axis=(1, 2))
        free, own = free[sound], own[sound]
        corners = nodes[self._faces[free]].astype(np.int64)
        row, side, other = neighbours_across_gaps(corners, own, alone[free])
        self._beside[free[row], side] = free[other]

    def piece(
        self, seed: int, *, angle_deg: float, distance: float, left_out: BoolArray | None
    ) -> Piece:
        from vomstudio.extraction.selection.region_kernels import grow_faces

        n = len(self._faces)
        taken = np.zeros(n, np.bool_) if left_out is None else left_out.copy()
        queue = np.empty(min(MOST, n), np.int32)
        if not np.isfinite(self._normals[seed, 0]):
            # A face without an area: one of those around it begins.
            beside = np.flatnonzero(self.wider(_only(seed, n)))
            sound = beside[np.isfinite(self._normals[beside, 0])]
            if not len(sound):
                return Piece(_only(seed, n), 1, False)
            seed = int(sound[0])
        count = grow_faces(
            self._vertices,
            self._faces,
            self._beside,
            self._normals,
            taken,
            seed,
            float(np.cos(np.radians(angle_deg))),
            distance,
            np.zeros(6),
            np.zeros(10),
            queue,
        )
        mask = np.zeros(n, np.bool_)
        mask[queue[:count]] = True
        return Piece(mask, count, count == len(queue) < n)

    def wider(self, chosen: BoolArray) -> BoolArray:
        from vomstudio.extraction.selection.region_kernels import at_marked, mark_nodes

        given = for_kernels(chosen, np.bool_)
        marked = np.zeros(self._places, np.bool_)
        out = np.zeros(len(chosen), np.bool_)

        def mark(rows: slice) -> None:
            mark_nodes(self._corners[rows], given[rows], marked)

        def read(rows: slice) -> None:
            at_marked(self._corners[rows], marked, out[rows])

        run_in_blocks(mark, len(out), Silent(), _AT_ONCE)
        run_in_blocks(read, len(out), Silent(), _AT_ONCE)
        return out

    def narrower(self, chosen: BoolArray) -> BoolArray:
        return chosen & ~self.wider(~chosen)


class CloudNeighbours:
    """`estimated` : the cloud has no normals of its own, so that they are worked out from its
    points, cell by cell of a grid"""

    def __init__(self, cloud: PointCloud, spacing: float) -> None:
        points = np.asarray(cloud.points)
        if len(points) < 4:
            raise GeometryError(Finding("cloud.too-few-points", n=len(points), minimum=4))
        extent = float(np.linalg.norm(np.ptp(cloud.bounds, axis=0)))
        self._cell = CELL * (spacing or extent / np.sqrt(len(points)) or 1.0)
        grid = PointGrid(points, self._cell)
        self._cell = grid.cell
        self._points, columns, names, ends, self._rows = grid.tables()
        self._count, self._ny = len(points), int(grid.counts[1])
        self._begins, self._row, self._column, self._ends = _runs(columns, names, ends)
        self._names = names
        # Where each point stands among the sorted ones; -1 for one that is nowhere.
        self._place = np.full(len(points), -1, np.int32)
        self._place[self._rows] = np.arange(len(self._rows), dtype=np.int32)
        self._normals = np.full((len(self._row), 3), np.nan, np.float32)
        self.estimated = cloud.normals is None
        self._given = np.zeros((0, 3), np.float32)
        if cloud.normals is not None:
            self._given = for_kernels(np.asarray(cloud.normals)[self._rows], np.float32)

    def _grid(self) -> tuple[IntArray, IntArray, Int32Array, IntArray, IntArray, int]:
        return self._begins, self._row, self._column, self._names, self._ends, self._ny

    def piece(
        self, seed: int, *, angle_deg: float, distance: float, left_out: BoolArray | None
    ) -> Piece:
        from vomstudio.extraction.selection.region_kernels import grow_points

        n, cells = len(self._points), len(self._row)
        out = np.zeros(n, np.bool_) if left_out is None else left_out[self._rows]
        queue = np.empty(min(MOST, n), np.int32)
        mask = np.zeros(self._count, np.bool_)
        at = int(self._place[seed])
        if at < 0:
            return Piece(mask, 0, False)
        cell = int(np.searchsorted(self._begins, at, side="right")) - 1
        count = grow_points(
            self._points,
            self._given,
            *self._grid(),
            self._normals,
            out,
            np.zeros(cells, np.bool_),
            at,
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
            return Piece(mask, 0, False)
        mask[self._rows[queue[:count]]] = True
        return Piece(mask, count, count == len(queue) < n)

    def wider(self, chosen: BoolArray) -> BoolArray:
        return self._ring(chosen, gains=True)

    def narrower(self, chosen: BoolArray) -> BoolArray:
        return self._ring(chosen, gains=False)

    def _sorted(self, chosen: BoolArray) -> tuple[BoolArray, Int32Array]:
        """The chosen ones among the sorted points, and the cells that hold any."""
        ids = np.flatnonzero(chosen)
        if len(ids) * _FEW > len(chosen):
            own = chosen[self._rows]
            held = np.logical_or.reduceat(own, self._begins[:-1])
            return own, for_kernels(np.flatnonzero(held), np.int32)
        # Few of many millions are looked up one by one.
        own = np.zeros(len(self._points), np.bool_)
        at = np.sort(self._place[ids])
        at = at[at >= 0]
        own[at] = True
        cells = np.searchsorted(self._begins, at, side="right") - 1
        fresh = np.ones(len(cells), np.bool_)
        np.not_equal(cells[1:], cells[:-1], out=fresh[1:])
        return own, for_kernels(cells[fresh], np.int32)

    def _ring(self, chosen: BoolArray, *, gains: bool) -> BoolArray:
        from vomstudio.extraction.selection.region_kernels import ring_of_points

        own, some = self._sorted(chosen)
        gained, lost = np.zeros(len(own), np.bool_), np.zeros(len(own), np.bool_)

        def work(rows: slice) -> None:
            ring_of_points(
                self._points,
                *self._grid(),
                own,
                some[rows],
                self._cell,
                np.empty(27, np.int64),
                gained,
                lost,
            )

        run_in_blocks(work, len(some), Silent(), _AT_ONCE // 4)
        result = chosen.copy()
        result[self._rows[gained if gains else lost]] = gains
        return result


def _runs(
    columns: Int32Array, names: IntArray, ends: IntArray
) -> tuple[IntArray, IntArray, Int32Array, IntArray]:
    """Of points sorted by rows of cells and along these: where each cell begins (c + 1,), its row
    and its column (c,), and the runs of cells of each row in place of `ends`, runs of points."""
    fresh = np.ones(len(columns), np.bool_)
    np.not_equal(columns[1:], columns[:-1], out=fresh[1:])
    used = np.flatnonzero(names >= 0)
    fresh[ends[used, 0]] = True
    first = np.flatnonzero(fresh)
    runs = np.zeros_like(ends)
    runs[used] = np.searchsorted(first, ends[used])
    row = np.empty(len(first), np.int64)
    order = used[np.argsort(ends[used, 0])]
    row[:] = np.repeat(names[order], (runs[order, 1] - runs[order, 0]))
    return np.append(first, len(columns)), row, for_kernels(columns[first], np.int32), runs


def _only(row: int, count: int) -> BoolArray:
    mask = np.zeros(count, np.bool_)
    mask[row] = True
    return mask


def _faces_at(corners: Int32Array, count: int) -> tuple[IntArray, Int32Array]:
    """The faces at each of `count` places: runs of the second array that begin at the first."""
    from scipy.sparse import csr_array

    starts = np.arange(0, corners.size + 1, 3, dtype=np.int32)
    shape = (len(corners), count)
    # Compressing by columns is a counting sort, in C and without the interpreter's lock.
    columns = csr_array((np.ones(corners.size, np.bool_), corners.ravel(), starts), shape).tocsc()
    return for_kernels(columns.indptr, np.int64), for_kernels(columns.indices, np.int32)
