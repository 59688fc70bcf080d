"""Signed distances from points to the triangles of a mesh.

The sign follows from the angle-weighted pseudonormal of the face, edge or corner that contains the
nearest point, which is always correct for a consistently wound mesh (Baerentzen & Aanaes 2005, IEEE
TVCG 11, 243). Copies of a vertex with several texture coordinates are merged.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import run_in_blocks
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.registration.surface_points import Counterparts

_BLOCK_SIZE = 100_000
# Barycentric weight below which the nearest point is on an edge or corner.
_EDGE_WEIGHT = 1e-12


class OrientedMesh:
    """Mesh with pseudonormals, for signed distances."""

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh
        self._tree = RayTree(mesh)
        corners = [mesh.vertices[mesh.faces[:, k]] for k in range(3)]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        self._faces: FloatArray = normal / np.where(size > 0, size, 1.0)
        self.areas: FloatArray = size[:, 0] / 2
        self._corner_ids = weld_points(mesh.vertices)[mesh.faces]
        self._corners = self._corner_normals(corners)
        self._edge_keys, self._edges, self._has_one_face = self._edge_normals()
        is_border = np.zeros(len(self._corners), bool)
        ends = self._edge_keys[self._has_one_face]
        is_border[ends // len(self._corners)] = True
        is_border[ends % len(self._corners)] = True
        self._is_border = is_border

    @property
    def mean_normal(self) -> FloatArray:
        """Area-weighted sum (3,) of the face normals."""
        return np.asarray(self.areas @ self._faces, np.float64)

    @property
    def total(self) -> float:
        """Length that the sum of the normals would have if the faces were parallel."""
        return float(self.areas.sum())

    def _corner_normals(self, corners: list[FloatArray]) -> FloatArray:
        normals = np.zeros((int(self._corner_ids.max(initial=-1)) + 1, 3))
        for k in range(3):
            a, b = corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]
            sine = np.linalg.norm(np.cross(a, b), axis=1)
            angle = np.arctan2(sine, np.einsum("ij,ij->i", a, b))
            for axis in range(3):
                normals[:, axis] += np.bincount(
                    self._corner_ids[:, k], angle * self._faces[:, axis], len(normals)
                )
        return normals

    def _edge_normals(self) -> tuple[IntArray, FloatArray, BoolArray]:
        """Return sorted edge keys, summed adjacent normals, and a mask of edges with one face."""
        keys = np.concatenate([self._edge_key(slice(None), k) for k in range(3)])
        unique_keys, inverse, count = np.unique(keys, return_inverse=True, return_counts=True)
        faces = np.tile(np.arange(len(self._faces)), 3)
        sums: FloatArray = np.zeros((len(unique_keys), 3))
        for axis in range(3):
            sums[:, axis] = np.bincount(inverse, self._faces[faces, axis], len(unique_keys))
        return np.asarray(unique_keys, np.int64), sums, np.asarray(count == 1, np.bool_)

    def _edge_key(self, rows: slice | IntArray, opposite: int) -> IntArray:
        """Return the keys of the edges opposite a corner of the faces."""
        a = self._corner_ids[rows, (opposite + 1) % 3]
        b = self._corner_ids[rows, (opposite + 2) % 3]
        return np.asarray(np.minimum(a, b) * len(self._corners) + np.maximum(a, b), np.int64)

    def find_counterparts(
        self, positions: FloatArray, progress: Progress | None = None
    ) -> Counterparts:
        """Return the signed distances of positions (n, 3).

        Each step of `progress`, which may raise Cancelled, is one position.
        """
        n = len(positions)
        distance, distance_beyond_edge, normal = (
            np.full(n, np.nan),
            np.zeros(n),
            np.full((n, 3), np.nan),
        )

        def process_rows(rows: slice) -> None:
            distance[rows], distance_beyond_edge[rows], normal[rows] = self._measure_block(
                positions[rows]
            )

        run_in_blocks(process_rows, n, progress or SilentProgress(), _BLOCK_SIZE)
        return Counterparts(distance, distance_beyond_edge, normal)

    def _measure_block(self, positions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        nearest_faces = self._tree.nearest(positions)
        n = len(positions)
        distance, distance_beyond_edge, normal = (
            np.full(n, np.nan),
            np.zeros(n),
            np.full((n, 3), np.nan),
        )
        rows = np.flatnonzero(nearest_faces.index >= 0)
        face, weights = nearest_faces.index[rows], nearest_faces.weights[rows]
        corners = self._mesh.vertices[self._mesh.faces[face]]
        offset = positions[rows] - np.einsum("nk,nkx->nx", weights, corners)
        length = np.linalg.norm(offset, axis=1)
        pseudonormal, is_border = self._faces[face].copy(), np.zeros(len(rows), bool)
        is_zero = weights <= _EDGE_WEIGHT
        for k in range(3):
            selected_rows = np.flatnonzero(is_zero[:, k] & (is_zero.sum(axis=1) == 1))
            edge = np.searchsorted(self._edge_keys, self._edge_key(face[selected_rows], k))
            pseudonormal[selected_rows], is_border[selected_rows] = (
                self._edges[edge],
                self._has_one_face[edge],
            )
            selected_rows = np.flatnonzero(~is_zero[:, k] & (is_zero.sum(axis=1) == 2))
            corner = self._corner_ids[face[selected_rows], k]
            pseudonormal[selected_rows], is_border[selected_rows] = (
                self._corners[corner],
                self._is_border[corner],
            )
        sign = np.where(np.einsum("ij,ij->i", offset, pseudonormal) < 0, -1.0, 1.0)
        size = np.linalg.norm(pseudonormal, axis=1, keepdims=True)
        pseudonormal = pseudonormal / np.where(size > 0, size, 1.0)
        height = np.einsum("ij,ij->i", offset, pseudonormal)
        tangential_distance = np.sqrt(np.maximum(length**2 - height**2, 0.0))
        distance[rows] = sign * length
        distance_beyond_edge[rows] = np.where(is_border, tangential_distance, 0.0)
        normal[rows] = pseudonormal
        return distance, distance_beyond_edge, normal
