"""Signed distances from points to a mesh: to the nearest point of its triangles.

The side is told by the angle-weighted pseudonormal of the face, edge or corner on which the nearest
point lies, which is never wrong where the mesh is wound throughout alike (Baerentzen & Aanaes 2005,
IEEE TVCG 11, 243). Copies of a vertex with several texture coordinates are one place.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import in_blocks
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.registration.surface_points import Opposite

_BLOCK = 100_000
# Weights of a nearest point below this are those of an edge or corner.
_ON_EDGE = 1e-12


class MeshSides:
    """A mesh, ready to be asked on which side of it places lie, and how far."""

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh
        self._tree = RayTree(mesh)
        corners = [mesh.vertices[mesh.faces[:, k]] for k in range(3)]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        self._faces: FloatArray = normal / np.where(size > 0, size, 1.0)
        self.areas: FloatArray = size[:, 0] / 2
        self._places = welded(mesh.vertices)[mesh.faces]
        self._corners = self._corner_normals(corners)
        self._edge_keys, self._edges, self._alone = self._edge_normals()
        on_border = np.zeros(len(self._corners), bool)
        ends = self._edge_keys[self._alone]
        on_border[ends // len(self._corners)] = True
        on_border[ends % len(self._corners)] = True
        self._on_border = on_border

    @property
    def mean_normal(self) -> FloatArray:
        """(3,) the sum of its faces' normals times their areas."""
        return np.asarray(self.areas @ self._faces, np.float64)

    @property
    def total(self) -> float:
        """As long as that sum would be if all faces lay alike."""
        return float(self.areas.sum())

    def _corner_normals(self, corners: list[FloatArray]) -> FloatArray:
        found = np.zeros((int(self._places.max(initial=-1)) + 1, 3))
        for k in range(3):
            a, b = corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]
            across = np.linalg.norm(np.cross(a, b), axis=1)
            angle = np.arctan2(across, np.einsum("ij,ij->i", a, b))
            for axis in range(3):
                found[:, axis] += np.bincount(
                    self._places[:, k], angle * self._faces[:, axis], len(found)
                )
        return found

    def _edge_normals(self) -> tuple[IntArray, FloatArray, BoolArray]:
        """Sorted keys of the edges, the sum of the normals of the faces at each, and whether it
        belongs to one face alone."""
        keys = np.concatenate([self._edge_key(slice(None), k) for k in range(3)])
        named, which, count = np.unique(keys, return_inverse=True, return_counts=True)
        faces = np.tile(np.arange(len(self._faces)), 3)
        sums: FloatArray = np.zeros((len(named), 3))
        for axis in range(3):
            sums[:, axis] = np.bincount(which, self._faces[faces, axis], len(named))
        return np.asarray(named, np.int64), sums, np.asarray(count == 1, np.bool_)

    def _edge_key(self, rows: slice | IntArray, opposite: int) -> IntArray:
        """Of the edge that does not have this corner of the faces."""
        a = self._places[rows, (opposite + 1) % 3]
        b = self._places[rows, (opposite + 2) % 3]
        return np.asarray(np.minimum(a, b) * len(self._corners) + np.maximum(a, b), np.int64)

    def opposite(self, places: FloatArray, progress: Progress | None = None) -> Opposite:
        """What of the mesh lies opposite the places (n, 3). Raises Cancelled through `progress`,
        whose steps are places."""
        n = len(places)
        distance, beside, normal = np.full(n, np.nan), np.zeros(n), np.full((n, 3), np.nan)

        def work(rows: slice) -> None:
            distance[rows], beside[rows], normal[rows] = self._block(places[rows])

        in_blocks(work, n, progress or Silent(), _BLOCK)
        return Opposite(distance, beside, normal)

    def _block(self, places: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        near = self._tree.nearest(places)
        n = len(places)
        distance, beside, normal = np.full(n, np.nan), np.zeros(n), np.full((n, 3), np.nan)
        rows = np.flatnonzero(near.index >= 0)
        face, weights = near.index[rows], near.weights[rows]
        corners = self._mesh.vertices[self._mesh.faces[face]]
        off = places[rows] - np.einsum("nk,nkx->nx", weights, corners)
        length = np.linalg.norm(off, axis=1)
        way, at_border = self._faces[face].copy(), np.zeros(len(rows), bool)
        nothing = weights <= _ON_EDGE
        for k in range(3):
            on = np.flatnonzero(nothing[:, k] & (nothing.sum(axis=1) == 1))
            edge = np.searchsorted(self._edge_keys, self._edge_key(face[on], k))
            way[on], at_border[on] = self._edges[edge], self._alone[edge]
            on = np.flatnonzero(~nothing[:, k] & (nothing.sum(axis=1) == 2))
            corner = self._places[face[on], k]
            way[on], at_border[on] = self._corners[corner], self._on_border[corner]
        side = np.where(np.einsum("ij,ij->i", off, way) < 0, -1.0, 1.0)
        size = np.linalg.norm(way, axis=1, keepdims=True)
        way = way / np.where(size > 0, size, 1.0)
        along = np.einsum("ij,ij->i", off, way)
        aside = np.sqrt(np.maximum(length**2 - along**2, 0.0))
        distance[rows] = side * length
        beside[rows] = np.where(at_border, aside, 0.0)
        normal[rows] = way
        return distance, beside, normal
