"""Single rays against a model: what a line of sight meets first, in float64; and the nearest face.

Boxes over the faces (or points), sorted along a Morton curve and paired upward into a complete
binary tree (after Karras 2012, Maximizing parallelism in the construction of BVHs, octrees and k-d
trees, HPG). A million faces are ready within a second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray, UInt64Array
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.mesh import Mesh

_LEAF = 4
SURFACE_THICKNESS = 4.0
"""Points of a cloud that lie at most this many reaches behind the first one on a ray belong to the
same surface."""


@dataclass(frozen=True, eq=False)
class RayHits:
    """What n rays met first.

    index : (n,) int64 row of the face or point, -1 where nothing was met
    distance : (n,) from the start, in lengths of the direction; infinite where nothing was met
    weights : (n, 3) barycentric weights of the face's corners; NaN for points and where nothing
        was met
    """

    index: IntArray
    distance: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class NearestFaces:
    """The face of a mesh that is nearest to each of n places.

    index : (n,) int64 row of the face, -1 of a place that is not finite
    weights : (n, 3) barycentric weights of its corners at its nearest point, exactly 0 for corners
        that an edge or a corner on which it lies does not have; NaN with index -1
    """

    index: IntArray
    weights: FloatArray


class RayTree:
    """The faces of a mesh, or the points of a cloud with a reach, ready for rays.

    reach : m; how far from a ray a point may lie to be met. Unused for a mesh.

    Coordinates are the model's own. Sums are made relative to a whole-numbered corner, so that
    UTM costs no digits.
    """

    def __init__(self, data: Mesh | PointCloud, reach: float = 0.0) -> None:
        self.data = data
        self.reach = reach
        if isinstance(data, Mesh):
            points = data.vertices
            self._faces = for_kernels(data.faces, np.int32)
        else:
            points = data.points
            self._faces = np.zeros((0, 3), np.int32)
        low = data.bounds[0] if len(points) else np.zeros(3)
        if not np.isfinite(low).all():
            whole = points[np.isfinite(points).all(axis=1)]
            low = whole.min(axis=0) if len(whole) else np.zeros(3)
        self.corner: FloatArray = np.floor(low)
        self._points = for_kernels(points - self.corner, np.float64)
        if isinstance(data, Mesh):
            corners = [self._points[self._faces[:, k]] for k in range(3)]
            low = np.minimum(np.minimum(corners[0], corners[1]), corners[2])
            high = np.maximum(np.maximum(corners[0], corners[1]), corners[2])
        else:
            low, high = self._points - reach, self._points + reach
        self._order = _along_curve(0.5 * (low + high))
        self._low, self._high = _boxes(low[self._order], high[self._order])

    def cast(
        self, starts: npt.ArrayLike, ways: npt.ArrayLike, last: npt.ArrayLike = np.inf
    ) -> RayHits:
        """First hits of rays from starts (n, 3) or (3,) along ways (n, 3), before `last` (in
        lengths of the way). Of a cloud the point that is nearest to the ray on the first surface.
        Rays that are not finite meet nothing.
        """
        from vomstudio.geometry.kernels.raytree import first_faces, first_points, stack_space

        ways = for_kernels(np.array(ways, np.float64).reshape(-1, 3), np.float64)
        n = len(ways)
        begins = np.broadcast_to(np.asarray(starts, np.float64), (n, 3)) - self.corner
        begins = for_kernels(begins, np.float64)
        ends = for_kernels(np.broadcast_to(np.asarray(last, np.float64), (n,)).copy(), np.float64)
        index, distance = np.full(n, -1, np.int64), np.full(n, np.inf)
        weights = np.full((n, 3), np.nan)
        if not len(self._order):
            return RayHits(index, distance, weights)
        tree = (self._order, self._low, self._high)
        if len(self._faces):
            first_faces(
                self._points,
                self._faces,
                *tree,
                begins,
                ways,
                ends,
                index,
                distance,
                weights,
                *stack_space(),
            )
        elif isinstance(self.data, PointCloud):
            thick = SURFACE_THICKNESS * self.reach
            first_points(
                self._points,
                *tree,
                begins,
                ways,
                ends,
                self.reach,
                thick,
                index,
                distance,
                *stack_space(),
            )
        return RayHits(index, distance, weights)

    def nearest(self, places: FloatArray) -> NearestFaces:
        """Of a mesh, the nearest point of its surface to each of the places (n, 3)."""
        from vomstudio.geometry.kernels.nearest import nearest_faces
        from vomstudio.geometry.kernels.raytree import stack_space

        n = len(places)
        index, weights = np.full(n, -1, np.int64), np.full((n, 3), np.nan)
        if len(self._order) and isinstance(self.data, Mesh):
            local = places - self.corner
            # Along the curve, so that what one needs is still at hand for the next.
            rows = _along_curve(local)
            near = for_kernels(local[rows], np.float64)
            found, shares = np.full(len(rows), -1, np.int64), np.full((len(rows), 3), np.nan)
            tree = (self._order, self._low, self._high)
            nearest_faces(self._points, self._faces, *tree, near, found, shares, *stack_space())
            index[rows], weights[rows] = found, shares
        return NearestFaces(index, weights)

    def position(self, index: int, weights: FloatArray) -> FloatArray:
        """(3,) of a hit, from the model's own coordinates."""
        return np.asarray(self.positions(np.array([index]), weights[None])[0])

    def positions(self, index: IntArray, weights: FloatArray) -> FloatArray:
        """(n, 3) of hits, from the model's own coordinates."""
        if isinstance(self.data, Mesh):
            corners = self._points[self._faces[index]]
            return np.asarray(np.einsum("nk,nkc->nc", weights, corners) + self.corner)
        return np.array(self.data.points[index], np.float64)

    def normal(self, index: int) -> FloatArray | None:
        """(3,) unit normal of a face or point; None where it has none."""
        if isinstance(self.data, Mesh):
            a, b, c = self._points[self._faces[index]]
            normal = np.cross(b - a, c - a)
        elif self.data.normals is None:
            return None
        else:
            normal = self.data.normals[index].astype(np.float64)
        size = float(np.linalg.norm(normal))
        return normal / size if size > 0 and np.isfinite(size) else None


def _along_curve(middles: FloatArray) -> IntArray:
    """Order of points (n, 3) along a Morton curve; those that are not finite are left out."""
    sound = np.flatnonzero(np.isfinite(middles).all(axis=1))
    if not len(sound):
        return np.zeros(0, np.int64)
    middles = middles[sound]
    low, high = middles.min(axis=0), middles.max(axis=0)
    size = max(float((high - low).max()), 1e-300)
    cells = ((middles - low) / size * ((1 << 20) - 1)).astype(np.uint64)
    code = np.zeros(len(sound), np.uint64)
    for axis in range(3):
        code |= _spread(cells[:, axis]) << np.uint64(axis)
    return np.asarray(sound[np.argsort(code, kind="stable")], np.int64)


def _spread(x: UInt64Array) -> UInt64Array:
    """Two zero bits after each of 20 bits."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x


def _boxes(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Boxes (2 k - 1, 3) of the complete tree over sorted items; node i has children 2 i + 1 and
    2 i + 2, the last k are leaves of _LEAF items each."""
    count = max(-(-len(low) // _LEAF), 1)
    leaves = 1 << (count - 1).bit_length()
    lows, highs = np.full((2 * leaves - 1, 3), np.inf), np.full((2 * leaves - 1, 3), -np.inf)
    if len(low):
        starts = np.arange(0, len(low), _LEAF)
        lows[leaves - 1 : leaves - 1 + count] = np.minimum.reduceat(low, starts)
        highs[leaves - 1 : leaves - 1 + count] = np.maximum.reduceat(high, starts)
    while leaves > 1:
        half = leaves // 2
        child = slice(leaves - 1, 2 * leaves - 1)
        lows[half - 1 : leaves - 1] = lows[child].reshape(half, 2, 3).min(axis=1)
        highs[half - 1 : leaves - 1] = highs[child].reshape(half, 2, 3).max(axis=1)
        leaves = half
    return lows, highs
