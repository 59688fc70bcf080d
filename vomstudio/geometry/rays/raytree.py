"""First hits of single rays on a model and nearest faces, in float64.

The bounding boxes of the faces (or points) are sorted along a Morton curve and merged pairwise into
a complete binary tree (after Karras 2012, Maximizing parallelism in the construction of BVHs,
octrees and k-d trees, HPG). Building the tree for a million faces takes less than a second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray, UInt64Array
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.mesh import Mesh

LEAF_SIZE = 4
SURFACE_THICKNESS = 4.0
"""Points of a cloud belong to the same surface if they are within this multiple of `max_distance`
behind the first point on a ray.
"""


@dataclass(frozen=True, eq=False)
class RayHits:
    """First hits of n rays.

    Attributes
    ----------
    index : (n,) ndarray of int
        Row of the face or point, or -1 for a miss.
    distance : (n,) ndarray
        Distance from the start, in multiples of the direction vector; infinity for a miss.
    weights : (n, 3) ndarray
        Barycentric weights of the vertices of the face; NaN for points and misses.
    """

    index: IntArray
    distance: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class NearestFaces:
    """Faces of a mesh nearest to n positions.

    Attributes
    ----------
    index : (n,) ndarray of int
        Row of the face; -1 if the position is not finite or the model has no faces.
    weights : (n, 3) ndarray
        Barycentric weights of its vertices at the nearest point; exactly 0 for vertices that do not
        belong to the nearest edge or vertex, and NaN if the index is -1.
    """

    index: IntArray
    weights: FloatArray


class RayTree:
    """Search tree of the faces of a mesh or the points of a cloud, for casting rays.

    `max_distance` is the maximum distance of a point from a ray that hits it, m; it is not used for
    a mesh. Coordinates are in the frame of the model. Sums are relative to an integer corner, so
    that UTM coordinates lose no digits.
    """

    def __init__(self, data: Mesh | PointCloud, max_distance: float = 0.0) -> None:
        self.data = data
        self.max_distance = max_distance
        if isinstance(data, Mesh):
            points = data.vertices
            self._faces = to_kernel_array(data.faces, np.int32)
        else:
            points = data.points
            self._faces = np.zeros((0, 3), np.int32)
        low = data.bounds[0] if len(points) else np.zeros(3)
        if not np.isfinite(low).all():
            finite_points = points[np.isfinite(points).all(axis=1)]
            low = finite_points.min(axis=0) if len(finite_points) else np.zeros(3)
        self.corner: FloatArray = np.floor(low)
        self._points = to_kernel_array(points - self.corner, np.float64)
        if isinstance(data, Mesh):
            corners = [self._points[self._faces[:, k]] for k in range(3)]
            low = np.minimum(np.minimum(corners[0], corners[1]), corners[2])
            high = np.maximum(np.maximum(corners[0], corners[1]), corners[2])
        else:
            low, high = self._points - max_distance, self._points + max_distance
        self._order = _morton_order(0.5 * (low + high))
        self._low, self._high = _build_boxes(low[self._order], high[self._order])

    def cast(
        self,
        starts: npt.ArrayLike,
        directions: npt.ArrayLike,
        max_distances: npt.ArrayLike = np.inf,
    ) -> RayHits:
        """Return the first hits of rays from starts (n, 3) or (3,) along vectors (n, 3).

        `max_distances` is the maximum distance, in multiples of the direction vector. For a cloud,
        the hit is the point on the first surface that is nearest to the ray. Non-finite rays have
        no hit.
        """
        from vomstudio.geometry.kernels.raytree import (
            allocate_stack,
            find_first_faces,
            find_first_points,
        )

        directions = to_kernel_array(np.array(directions, np.float64).reshape(-1, 3), np.float64)
        n = len(directions)
        begins = np.broadcast_to(np.asarray(starts, np.float64), (n, 3)) - self.corner
        begins = to_kernel_array(begins, np.float64)
        ends = to_kernel_array(
            np.broadcast_to(np.asarray(max_distances, np.float64), (n,)).copy(), np.float64
        )
        index, distance = np.full(n, -1, np.int64), np.full(n, np.inf)
        weights = np.full((n, 3), np.nan)
        if not len(self._order):
            return RayHits(index, distance, weights)
        tree = (self._order, self._low, self._high)
        if len(self._faces):
            find_first_faces(
                self._points,
                self._faces,
                *tree,
                begins,
                directions,
                ends,
                index,
                distance,
                weights,
                *allocate_stack(),
            )
        elif isinstance(self.data, PointCloud):
            thickness = SURFACE_THICKNESS * self.max_distance
            find_first_points(
                self._points,
                *tree,
                begins,
                directions,
                ends,
                self.max_distance,
                thickness,
                index,
                distance,
                *allocate_stack(),
            )
        return RayHits(index, distance, weights)

    def nearest(self, positions: FloatArray) -> NearestFaces:
        """Return the points of a mesh nearest to the positions (n, 3)."""
        from vomstudio.geometry.kernels.nearest import nearest_faces
        from vomstudio.geometry.kernels.raytree import allocate_stack

        n = len(positions)
        index, weights = np.full(n, -1, np.int64), np.full((n, 3), np.nan)
        if len(self._order) and isinstance(self.data, Mesh):
            local_points = positions - self.corner
            # Follow the order of the curve, so that neighbours use the same cached data.
            rows = _morton_order(local_points)
            near_points = to_kernel_array(local_points[rows], np.float64)
            nearest_rows, nearest_weights = (
                np.full(len(rows), -1, np.int64),
                np.full((len(rows), 3), np.nan),
            )
            tree = (self._order, self._low, self._high)
            nearest_faces(
                self._points,
                self._faces,
                *tree,
                near_points,
                nearest_rows,
                nearest_weights,
                *allocate_stack(),
            )
            index[rows], weights[rows] = nearest_rows, nearest_weights
        return NearestFaces(index, weights)

    def position(self, index: int, weights: FloatArray) -> FloatArray:
        """Return the position (3,) of a hit in the coordinates of the model."""
        return np.asarray(self.positions(np.array([index]), weights[None])[0])

    def positions(self, index: IntArray, weights: FloatArray) -> FloatArray:
        """Return the positions (n, 3) of hits in the coordinates of the model."""
        if isinstance(self.data, Mesh):
            corners = self._points[self._faces[index]]
            return np.asarray(np.einsum("nk,nkc->nc", weights, corners) + self.corner)
        return np.array(self.data.points[index], np.float64)

    def normal(self, index: int) -> FloatArray | None:
        """Return the unit normal (3,) of a face or point, or None if it has no normal."""
        if isinstance(self.data, Mesh):
            a, b, c = self._points[self._faces[index]]
            normal = np.cross(b - a, c - a)
        elif self.data.normals is None:
            return None
        else:
            normal = self.data.normals[index].astype(np.float64)
        size = float(np.linalg.norm(normal))
        return normal / size if size > 0 and np.isfinite(size) else None


def _morton_order(centres: FloatArray) -> IntArray:
    """Return the order of finite points (n, 3) along a Morton curve."""
    finite_indices = np.flatnonzero(np.isfinite(centres).all(axis=1))
    if not len(finite_indices):
        return np.zeros(0, np.int64)
    centres = centres[finite_indices]
    low, high = centres.min(axis=0), centres.max(axis=0)
    size = max(float((high - low).max()), 1e-300)
    cells = ((centres - low) / size * ((1 << 20) - 1)).astype(np.uint64)
    code = np.zeros(len(finite_indices), np.uint64)
    for axis in range(3):
        code |= _spread_bits(cells[:, axis]) << np.uint64(axis)
    return np.asarray(finite_indices[np.argsort(code, kind="stable")], np.int64)


def _spread_bits(x: UInt64Array) -> UInt64Array:
    """Insert two zero bits after each of 20 bits."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x


def _build_boxes(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the corners (2 k - 1, 3) of the boxes of the complete tree over sorted items.

    The children of node i are 2 i + 1 and 2 i + 2; the last k nodes are leaves with LEAF_SIZE items
    each.
    """
    count = max(-(-len(low) // LEAF_SIZE), 1)
    n_leaves = 1 << (count - 1).bit_length()
    lows, highs = np.full((2 * n_leaves - 1, 3), np.inf), np.full((2 * n_leaves - 1, 3), -np.inf)
    if len(low):
        starts = np.arange(0, len(low), LEAF_SIZE)
        lows[n_leaves - 1 : n_leaves - 1 + count] = np.minimum.reduceat(low, starts)
        highs[n_leaves - 1 : n_leaves - 1 + count] = np.maximum.reduceat(high, starts)
    while n_leaves > 1:
        half_count = n_leaves // 2
        child = slice(n_leaves - 1, 2 * n_leaves - 1)
        lows[half_count - 1 : n_leaves - 1] = lows[child].reshape(half_count, 2, 3).min(axis=1)
        highs[half_count - 1 : n_leaves - 1] = highs[child].reshape(half_count, 2, 3).max(axis=1)
        n_leaves = half_count
    return lows, highs
