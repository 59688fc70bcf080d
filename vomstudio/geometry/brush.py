"""Choosing a piece of a surface with a ball: what lies inside it and hangs together with what was
hit, so that a brush does not reach through to the wall behind.

A mesh hangs together where faces share a corner; corners at one place are one corner, whatever
their numbers, since a seam of the texture splits them. A cloud hangs together where points lie
within LINK mean spacings of each other.
"""

from __future__ import annotations

from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray, IntegerArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import place_keys, welded
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.outlines.surface_area import area_inside, part_inside
from vomstudio.geometry.patches import face_areas, face_points
from vomstudio.geometry.surface import Surface, VertexSurface

# Random points on a surface hang together where about 4.5 of them lie within the reach of each
# (continuum percolation); 1.8 mean spacings have 10, and reach the diagonal neighbour of a grid.
LINK = 1.8
_AROUND = 16
_STEP = 1_000_000
# Some faces of a model, such as those that close a hole, are far longer than the others.
_LONG = 8.0


class PaintSurface(Surface, Protocol):
    """A surface whose faces or points can be chosen. All in the model's file frame."""

    @property
    def element(self) -> Literal["face", "point"]: ...

    @property
    def count(self) -> int:
        """Number of faces or points."""

    @property
    def extent(self) -> float:
        """Its size."""

    def within(self, index: int, centre: npt.ArrayLike, radius: float) -> IntArray:
        """Sorted ids of the faces whose centre of gravity, or of the points that, lie in the ball
        and can be reached from `index` without leaving it. `index` itself is always one of them."""

    def weighted(self, ids: IntArray) -> tuple[FloatArray, FloatArray | None]:
        """Points (k, 3) of the chosen ones, and the area each stands for; None where all count
        the same."""

    def area_of(self, ids: IntArray) -> float | None: ...

    def corners(self, ids: IntArray) -> FloatArray:
        """(k, 3, 3) corners of faces, or (k, 3) points."""

    def border(self, ids: IntArray) -> FloatArray:
        """(k, 2, 3) edges of the chosen faces that only one of them has; none for points."""

    def area_inside(self, ring: npt.ArrayLike) -> float | None:
        """Area of the surface that a ring (n, 3) on it encloses, as in
        `outlines.surface_area.area_inside`; None for points."""

    def part_inside(self, ring: npt.ArrayLike) -> FloatArray | None:
        """(k, 3, 3) triangles of that part; None for points, and where there is none."""

    def normal_near(self, index: int, centre: npt.ArrayLike, radius: float) -> FloatArray | None:
        """Unit normal (3,) of the surface inside the ball, of either sense; None where nothing is
        known yet."""


class MeshSurface(VertexSurface):
    """`build` also notes which faces each vertex has, as rows into one array."""

    element: Literal["face", "point"] = "face"

    def __init__(self, mesh: Mesh) -> None:
        super().__init__(mesh.vertices, lambda: mesh.undivided.vertices)
        self._mesh = mesh
        self._faces_of: tuple[Int32Array, IntegerArray] | None = None
        # Place of each vertex among those that are being looked at, -1 for the others.
        self._place: Int32Array | None = None
        self._lengths: tuple[float, IntArray] | None = None

    @property
    def count(self) -> int:
        return len(self._mesh.faces)

    def build(self) -> None:
        super().build()
        import scipy.sparse.csgraph  # noqa: F401 - or the first stroke would wait for it
        from scipy.sparse import csr_array

        faces = np.asarray(self._mesh.faces)
        starts = np.arange(0, faces.size + 1, 3, dtype=np.int32)
        shape = (len(faces), len(self._vertices))
        # Compressing by columns is a counting sort, in C and without the interpreter's lock.
        columns = csr_array((np.ones(faces.size, np.bool_), faces.ravel(), starts), shape).tocsc()
        self._faces_of = (columns.indices, columns.indptr)
        self._long_faces()

    def within(self, index: int, centre: npt.ArrayLike, radius: float) -> IntArray:
        centre = np.asarray(centre, dtype=np.float64)
        place = self._places()
        own = self.corners(np.array([index]))[0]
        longest = float(np.linalg.norm(own - np.roll(own, 1, axis=0), axis=1).max())
        known = _join(self._in_ball(centre, radius + longest), self._at(own))
        place[known] = np.arange(len(known), dtype=np.int32)
        try:
            kept = self._inside(self._faces_at(known), index, centre, radius)
            while True:
                corners = self._mesh.faces[kept]
                # Faces far longer than the one that was hit reach out of what was looked at.
                far = _distinct(corners[place[corners] < 0])
                if not len(far):
                    break
                fresh = self._at(self._vertices[far])
                fresh = fresh[place[fresh] < 0]
                place[fresh] = np.arange(len(known), len(known) + len(fresh), dtype=np.int32)
                known = np.concatenate([known, fresh])
                more = self._inside(self._faces_at(fresh), index, centre, radius)
                kept = _join(kept, more)
            nodes = welded(self._vertices[known])[place[self._mesh.faces[kept]]]
        finally:
            place[known] = -1
        return kept[_reached(nodes, int(np.searchsorted(kept, index)))]

    def weighted(self, ids: IntArray) -> tuple[FloatArray, FloatArray | None]:
        return face_points(self._mesh, ids)

    def area_of(self, ids: IntArray) -> float | None:
        return float(face_areas(self._mesh, ids).sum())

    def corners(self, ids: IntArray) -> FloatArray:
        return np.asarray(self._vertices[self._mesh.faces[ids]], dtype=np.float64)

    def border(self, ids: IntArray) -> FloatArray:
        if not len(ids):
            return np.zeros((0, 2, 3))
        corners = self.corners(ids)
        nodes = welded(corners.reshape(-1, 3)).reshape(-1, 3)
        ends = np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=2).reshape(-1, 2)
        one, other = ends.T
        # Pair by pair: a reduction along rows of two is many times slower.
        key = np.minimum(one, other) * (int(nodes.max()) + 1) + np.maximum(one, other)
        order = np.argsort(key)
        alone = np.diff(key[order]) != 0
        single = order[np.append(True, alone) & np.append(alone, True)]
        edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
        return np.asarray(edges[single])

    def normal_near(self, index: int, centre: npt.ArrayLike, radius: float) -> FloatArray | None:
        a, b, c = self.corners(np.array([index]))[0]
        own = np.cross(b - a, c - a)
        size = float(np.linalg.norm(own))
        found = self._normal(np.asarray(centre, dtype=np.float64), radius)
        if found is not None:
            return found
        return own / size if size > 0.0 else None

    def area_inside(self, ring: npt.ArrayLike) -> float | None:
        around = self._around(ring)
        return None if around is None else area_inside(around, ring)

    def part_inside(self, ring: npt.ArrayLike) -> FloatArray | None:
        around = self._around(ring)
        return None if around is None else part_inside(around, ring)

    def _around(self, ring: npt.ArrayLike) -> FloatArray | None:
        """Corners of all the faces that an outline may enclose."""
        xyz = np.asarray(ring, np.float64).reshape(-1, 3)
        if len(xyz) < 3 or not self.count:
            return None
        middle = xyz.mean(axis=0)
        radius = float(np.linalg.norm(xyz - middle, axis=1).max())
        usual, long = self._long_faces()
        # A face that reaches into the ball has a corner within its own length of it.
        near = self._faces_at(self._in_ball(middle, radius + usual))
        return self.corners(_join(near, long))

    def _long_faces(self) -> tuple[float, IntArray]:
        """Length that most faces' edges do not surpass, and the sorted ids of those that do."""
        if self._lengths is None:
            longest = np.empty(self.count)
            for start in range(0, self.count, _STEP):
                corners = self.corners(np.arange(start, min(start + _STEP, self.count)))
                edges = corners - np.roll(corners, 1, axis=1)
                longest[start : start + _STEP] = np.sqrt((edges**2).sum(axis=2).max(axis=1))
            usual = _LONG * float(np.median(longest)) if len(longest) else 0.0
            self._lengths = usual, np.flatnonzero(longest > usual)
        return self._lengths

    def _places(self) -> Int32Array:
        if self._place is None:
            self._place = np.full(len(self._vertices), -1, np.int32)
        return self._place

    def _at(self, points: FloatArray) -> IntArray:
        """Ids of all the vertices at the places of `points` (k, 3)."""
        if self._tree is not None:
            found = self._tree.query_ball_point(points, 0.0)
            return _distinct(np.concatenate([np.asarray(each, np.int64) for each in found]))
        wanted, hits = place_keys(points), []
        low, high = points.min(axis=0), points.max(axis=0)
        for start in range(0, len(self._vertices), _STEP):
            part = np.asarray(self._vertices[start : start + _STEP])
            near = np.flatnonzero(((part >= low) & (part <= high)).all(axis=1))
            hits.append(start + near[np.isin(place_keys(part[near]), wanted)])
        return np.concatenate(hits)

    def _faces_at(self, vertices: IntArray) -> IntArray:
        """Sorted ids of the faces that have one of these vertices."""
        if self._faces_of is not None:
            faces, starts = self._faces_of
            first = starts[vertices].astype(np.int64)
            size = starts[vertices + 1] - first
            shift = np.repeat(first - (np.cumsum(size) - size), size)
            return _distinct(faces[np.arange(int(size.sum())) + shift])
        marked = np.zeros(len(self._vertices), np.bool_)
        marked[vertices] = True
        hits = []
        for start in range(0, self.count, _STEP):
            a, b, c = self._mesh.faces[start : start + _STEP].T
            hits.append(start + np.flatnonzero(marked[a] | marked[b] | marked[c]))
        return np.concatenate(hits)

    def _inside(self, faces: IntArray, index: int, centre: FloatArray, radius: float) -> IntArray:
        off = self.corners(faces).mean(axis=1) - centre
        inside = np.einsum("ij,ij->i", off, off) <= radius**2
        return np.asarray(faces[inside | (faces == index)])


class CloudSurface(VertexSurface):
    element: Literal["face", "point"] = "point"

    def __init__(self, cloud: PointCloud) -> None:
        super().__init__(cloud.points)

    @property
    def count(self) -> int:
        return len(self._vertices)

    def build(self) -> None:
        super().build()
        import scipy.sparse.csgraph  # noqa: F401 - as above

    def within(self, index: int, centre: npt.ArrayLike, radius: float) -> IntArray:
        from scipy.spatial import cKDTree

        ids = np.sort(self._in_ball(np.asarray(centre, dtype=np.float64), radius))
        ids = _join(ids, np.array([index]))
        points = self.corners(ids)
        at = int(np.searchsorted(ids, index))
        tree = cKDTree(points, compact_nodes=False, balanced_tree=False)
        count = min(_AROUND + 1, len(ids))
        farthest = float(np.max(tree.query(points[at], k=count)[0]))
        if farthest <= 0.0:
            return ids
        # Mean spacing of a surface that has this many points within that distance.
        reach = LINK * farthest * float(np.sqrt(np.pi / max(count - 1, 1)))
        pairs = tree.query_pairs(reach, output_type="ndarray")
        return ids[_linked(pairs, len(ids), at)]

    def weighted(self, ids: IntArray) -> tuple[FloatArray, FloatArray | None]:
        return self.corners(ids), None

    def area_of(self, ids: IntArray) -> float | None:
        return None

    def corners(self, ids: IntArray) -> FloatArray:
        return np.asarray(self._vertices[ids], dtype=np.float64)

    def border(self, ids: IntArray) -> FloatArray:
        return np.zeros((0, 2, 3))

    def area_inside(self, ring: npt.ArrayLike) -> float | None:
        return None

    def part_inside(self, ring: npt.ArrayLike) -> FloatArray | None:
        return None

    def normal_near(self, index: int, centre: npt.ArrayLike, radius: float) -> FloatArray | None:
        return self._normal(np.asarray(centre, dtype=np.float64), radius)


def _join(a: IntArray, b: IntArray) -> IntArray:
    return _distinct(np.concatenate([a, b]))


def _distinct(ids: IntegerArray) -> IntArray:
    """Sorted and once each: several times as fast as numpy's, which builds a hash table."""
    ids = np.sort(ids)
    new = np.ones(len(ids), np.bool_)
    np.not_equal(ids[1:], ids[:-1], out=new[1:])
    return ids[new].astype(np.int64)


def _reached(nodes: IntArray, start: int) -> BoolArray:
    """Which faces (k, 3 nodes) hang together with the face `start`."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    k = len(nodes)
    size = k + int(nodes.max()) + 1
    starts = np.full(size + 1, 3 * k, np.int32)
    starts[: k + 1] = np.arange(0, 3 * k + 1, 3)
    graph = csr_array((np.ones(3 * k), (nodes + k).ravel(), starts), (size, size))
    label = connected_components(graph, directed=False)[1][:k]
    return np.asarray(label == label[start])


def _linked(pairs: IntArray, count: int, start: int) -> BoolArray:
    """Which of `count` points hang together with the point `start`."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(pairs))
    graph = coo_array((ones, (pairs[:, 0], pairs[:, 1])), (count, count)).tocsr()
    label = connected_components(graph, directed=False)[1]
    return np.asarray(label == label[start])
