"""Selection of a connected piece of a surface inside a ball.

The brush does not extend to a wall behind the surface. Faces of a mesh are connected if they share
a vertex; coincident vertices count as one, because texture seams split vertices. Points of a cloud
are connected if they are within MAX_LINK_SPACINGS mean spacings of each other.
"""

from __future__ import annotations

from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray, IntegerArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import position_keys, weld_points
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.outlines.surface_area import area_inside, clip_to_outline
from vomstudio.geometry.patches import face_areas, face_points
from vomstudio.geometry.surface import Surface, VertexSurface

# Random points on a surface are connected if each point has about 4.5 others within the linking
# distance (continuum percolation). A distance of 1.8 mean spacings contains 10 points and includes
# the diagonal neighbours in a grid.
MAX_LINK_SPACINGS = 1.8
N_NEIGHBOURS = 16
BLOCK_SIZE = 1_000_000
# Some faces of a model, such as those that close holes, are far longer than the others.
LONG_FACE_RATIO = 8.0


class SelectableSurface(Surface, Protocol):
    """Surface whose faces or points can be selected, in the model's file frame."""

    @property
    def element(self) -> Literal["face", "point"]: ...

    @property
    def count(self) -> int:
        """Number of faces or points."""

    @property
    def extent(self) -> float:
        """Diagonal of the bounding box."""

    def connected_ids_in_ball(self, index: int, centre: npt.ArrayLike, radius: float) -> IntArray:
        """Return sorted ids of the faces (by centroid) or points in a ball connected to `index`.

        The connecting path must not leave the ball. `index` itself is always included.
        """

    def weighted_points(self, ids: IntArray) -> tuple[FloatArray, FloatArray | None]:
        """Return the points (k, 3) of a selection and their areas.

        The areas are None if they are equal.
        """

    def selected_area(self, ids: IntArray) -> float | None: ...

    def corners(self, ids: IntArray) -> FloatArray:
        """Return the vertices (k, 3, 3) of faces, or the points (k, 3) of a cloud."""

    def border(self, ids: IntArray) -> FloatArray:
        """Return the edges (k, 2, 3) that belong to only one selected face; empty for points."""

    def area_inside(self, ring: npt.ArrayLike) -> float | None:
        """Return the area inside a ring (n, 3).

        The result is None for points, and under the conditions of
        `outlines.surface_area.area_inside`.
        """

    def clip_to_outline(self, ring: npt.ArrayLike) -> FloatArray | None:
        """Return the triangles (k, 3, 3) inside a ring.

        The result is None for points and for an invalid ring.
        """

    def local_normal(self, index: int, centre: npt.ArrayLike, radius: float) -> FloatArray | None:
        """Return the unit normal (3,) of the surface in a ball; its sign is arbitrary.

        The result is None if the normal is unknown.
        """


class MeshSurface(VertexSurface):
    """Paintable mesh; `build` also indexes the faces of each vertex."""

    element: Literal["face", "point"] = "face"

    def __init__(self, mesh: Mesh) -> None:
        super().__init__(mesh.vertices, lambda: mesh.undivided.vertices)
        self._mesh = mesh
        self._faces_by_vertex: tuple[Int32Array, IntegerArray] | None = None
        # Position of each vertex among the vertices being examined, -1 for all other vertices.
        self._local_index: Int32Array | None = None
        self._lengths: tuple[float, IntArray] | None = None

    @property
    def count(self) -> int:
        return len(self._mesh.faces)

    def build(self) -> None:
        super().build()
        import scipy.sparse.csgraph  # noqa: F401 - otherwise the first stroke would wait for it
        from scipy.sparse import csr_array

        faces = np.asarray(self._mesh.faces)
        starts = np.arange(0, faces.size + 1, 3, dtype=np.int32)
        shape = (len(faces), len(self._vertices))
        # Compressing by column is a counting sort, which runs in C and releases the GIL.
        columns = csr_array((np.ones(faces.size, np.bool_), faces.ravel(), starts), shape).tocsc()
        self._faces_by_vertex = (columns.indices, columns.indptr)
        self._long_faces()

    def connected_ids_in_ball(self, index: int, centre: npt.ArrayLike, radius: float) -> IntArray:
        centre = np.asarray(centre, dtype=np.float64)
        local_indices = self._local_indices()
        hit_corners = self.corners(np.array([index]))[0]
        longest_edge = float(
            np.linalg.norm(hit_corners - np.roll(hit_corners, 1, axis=0), axis=1).max()
        )
        vertices = _union_ids(
            self._ids_in_ball(centre, radius + longest_edge), self._vertices_at(hit_corners)
        )
        local_indices[vertices] = np.arange(len(vertices), dtype=np.int32)
        try:
            inner_faces = self._select_in_ball(self._faces_at(vertices), index, centre, radius)
            while True:
                corners = self._mesh.faces[inner_faces]
                # Faces much longer than the hit face extend beyond the vertices found so far.
                missing_vertices = _unique_ids(corners[local_indices[corners] < 0])
                if not len(missing_vertices):
                    break
                new_vertices = self._vertices_at(self._vertices[missing_vertices])
                new_vertices = new_vertices[local_indices[new_vertices] < 0]
                local_indices[new_vertices] = np.arange(
                    len(vertices), len(vertices) + len(new_vertices), dtype=np.int32
                )
                vertices = np.concatenate([vertices, new_vertices])
                new_faces = self._select_in_ball(
                    self._faces_at(new_vertices), index, centre, radius
                )
                inner_faces = _union_ids(inner_faces, new_faces)
            nodes = weld_points(self._vertices[vertices])[
                local_indices[self._mesh.faces[inner_faces]]
            ]
        finally:
            local_indices[vertices] = -1
        return inner_faces[_is_connected_face(nodes, int(np.searchsorted(inner_faces, index)))]

    def weighted_points(self, ids: IntArray) -> tuple[FloatArray, FloatArray | None]:
        return face_points(self._mesh, ids)

    def selected_area(self, ids: IntArray) -> float | None:
        return float(face_areas(self._mesh, ids).sum())

    def corners(self, ids: IntArray) -> FloatArray:
        return np.asarray(self._vertices[self._mesh.faces[ids]], dtype=np.float64)

    def border(self, ids: IntArray) -> FloatArray:
        if not len(ids):
            return np.zeros((0, 2, 3))
        corners = self.corners(ids)
        nodes = weld_points(corners.reshape(-1, 3)).reshape(-1, 3)
        ends = np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=2).reshape(-1, 2)
        first_ends, second_ends = ends.T
        # Process the two ends separately: a reduction along rows of two is many times slower.
        key = np.minimum(first_ends, second_ends) * (int(nodes.max()) + 1) + np.maximum(
            first_ends, second_ends
        )
        order = np.argsort(key)
        is_different = np.diff(key[order]) != 0
        border_sides = order[np.append(True, is_different) & np.append(is_different, True)]
        edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
        return np.asarray(edges[border_sides])

    def local_normal(self, index: int, centre: npt.ArrayLike, radius: float) -> FloatArray | None:
        a, b, c = self.corners(np.array([index]))[0]
        face_normal = np.cross(b - a, c - a)
        size = float(np.linalg.norm(face_normal))
        normal = self._normal(np.asarray(centre, dtype=np.float64), radius)
        if normal is not None:
            return normal
        return face_normal / size if size > 0.0 else None

    def area_inside(self, ring: npt.ArrayLike) -> float | None:
        nearby_corners = self._nearby_face_corners(ring)
        return None if nearby_corners is None else area_inside(nearby_corners, ring)

    def clip_to_outline(self, ring: npt.ArrayLike) -> FloatArray | None:
        nearby_corners = self._nearby_face_corners(ring)
        return None if nearby_corners is None else clip_to_outline(nearby_corners, ring)

    def _nearby_face_corners(self, ring: npt.ArrayLike) -> FloatArray | None:
        """Return the vertices (k, 3, 3) of all faces that an outline may enclose.

        Return None if the outline has fewer than three vertices or the mesh has no faces.
        """
        xyz = np.asarray(ring, np.float64).reshape(-1, 3)
        if len(xyz) < 3 or not self.count:
            return None
        centre = xyz.mean(axis=0)
        radius = float(np.linalg.norm(xyz - centre, axis=1).max())
        max_edge_length, long_faces = self._long_faces()
        # A face that intersects the ball has a vertex within its length of it.
        near_faces = self._faces_at(self._ids_in_ball(centre, radius + max_edge_length))
        return self.corners(_union_ids(near_faces, long_faces))

    def _long_faces(self) -> tuple[float, IntArray]:
        """Return the maximum edge length of typical faces, and the sorted ids of longer faces."""
        if self._lengths is None:
            longest_edges = np.empty(self.count)
            for start in range(0, self.count, BLOCK_SIZE):
                corners = self.corners(np.arange(start, min(start + BLOCK_SIZE, self.count)))
                edges = corners - np.roll(corners, 1, axis=1)
                longest_edges[start : start + BLOCK_SIZE] = np.sqrt(
                    (edges**2).sum(axis=2).max(axis=1)
                )
            max_length = (
                LONG_FACE_RATIO * float(np.median(longest_edges)) if len(longest_edges) else 0.0
            )
            self._lengths = max_length, np.flatnonzero(longest_edges > max_length)
        return self._lengths

    def _local_indices(self) -> Int32Array:
        if self._local_index is None:
            self._local_index = np.full(len(self._vertices), -1, np.int32)
        return self._local_index

    def _vertices_at(self, points: FloatArray) -> IntArray:
        """Return the ids of all vertices that coincide with points (k, 3)."""
        if self._tree is not None:
            ids_by_point = self._tree.query_ball_point(points, 0.0)
            return _unique_ids(
                np.concatenate([np.asarray(item, np.int64) for item in ids_by_point])
            )
        keys, id_blocks = position_keys(points), []
        low, high = points.min(axis=0), points.max(axis=0)
        for start in range(0, len(self._vertices), BLOCK_SIZE):
            part = np.asarray(self._vertices[start : start + BLOCK_SIZE])
            near_indices = np.flatnonzero(((part >= low) & (part <= high)).all(axis=1))
            id_blocks.append(start + near_indices[np.isin(position_keys(part[near_indices]), keys)])
        return np.concatenate(id_blocks)

    def _faces_at(self, vertices: IntArray) -> IntArray:
        """Return the sorted ids of the faces that have any of these vertices."""
        if self._faces_by_vertex is not None:
            faces, starts = self._faces_by_vertex
            first_rows = starts[vertices].astype(np.int64)
            size = starts[vertices + 1] - first_rows
            shift = np.repeat(first_rows - (np.cumsum(size) - size), size)
            return _unique_ids(faces[np.arange(int(size.sum())) + shift])
        is_marked = np.zeros(len(self._vertices), np.bool_)
        is_marked[vertices] = True
        face_blocks = []
        for start in range(0, self.count, BLOCK_SIZE):
            a, b, c = self._mesh.faces[start : start + BLOCK_SIZE].T
            face_blocks.append(start + np.flatnonzero(is_marked[a] | is_marked[b] | is_marked[c]))
        return np.concatenate(face_blocks)

    def _select_in_ball(
        self, faces: IntArray, index: int, centre: FloatArray, radius: float
    ) -> IntArray:
        offsets = self.corners(faces).mean(axis=1) - centre
        is_inside = np.einsum("ij,ij->i", offsets, offsets) <= radius**2
        return np.asarray(faces[is_inside | (faces == index)])


class CloudSurface(VertexSurface):
    """Paintable surface of a point cloud."""

    element: Literal["face", "point"] = "point"

    def __init__(self, cloud: PointCloud) -> None:
        super().__init__(cloud.points)

    @property
    def count(self) -> int:
        return len(self._vertices)

    def build(self) -> None:
        super().build()
        import scipy.sparse.csgraph  # noqa: F401 - as above

    def connected_ids_in_ball(self, index: int, centre: npt.ArrayLike, radius: float) -> IntArray:
        from scipy.spatial import cKDTree

        ids = np.sort(self._ids_in_ball(np.asarray(centre, dtype=np.float64), radius))
        ids = _union_ids(ids, np.array([index]))
        points = self.corners(ids)
        start = int(np.searchsorted(ids, index))
        tree = cKDTree(points, compact_nodes=False, balanced_tree=False)
        count = min(N_NEIGHBOURS + 1, len(ids))
        max_neighbour_distance = float(np.max(tree.query(points[start], k=count)[0]))
        if max_neighbour_distance <= 0.0:
            return ids
        # Mean spacing on a surface with this number of points within this distance.
        max_distance = (
            MAX_LINK_SPACINGS * max_neighbour_distance * float(np.sqrt(np.pi / max(count - 1, 1)))
        )
        pairs = tree.query_pairs(max_distance, output_type="ndarray")
        return ids[_is_connected_point(pairs, len(ids), start)]

    def weighted_points(self, ids: IntArray) -> tuple[FloatArray, FloatArray | None]:
        return self.corners(ids), None

    def selected_area(self, ids: IntArray) -> float | None:
        return None

    def corners(self, ids: IntArray) -> FloatArray:
        return np.asarray(self._vertices[ids], dtype=np.float64)

    def border(self, ids: IntArray) -> FloatArray:
        return np.zeros((0, 2, 3))

    def area_inside(self, ring: npt.ArrayLike) -> float | None:
        return None

    def clip_to_outline(self, ring: npt.ArrayLike) -> FloatArray | None:
        return None

    def local_normal(self, index: int, centre: npt.ArrayLike, radius: float) -> FloatArray | None:
        return self._normal(np.asarray(centre, dtype=np.float64), radius)


def _union_ids(a: IntArray, b: IntArray) -> IntArray:
    return _unique_ids(np.concatenate([a, b]))


def _unique_ids(ids: IntegerArray) -> IntArray:
    """Return the sorted distinct ids.

    Sorting is several times faster than the hash table of NumPy.
    """
    ids = np.sort(ids)
    is_first = np.ones(len(ids), np.bool_)
    np.not_equal(ids[1:], ids[:-1], out=is_first[1:])
    return ids[is_first].astype(np.int64)


def _is_connected_face(nodes: IntArray, start: int) -> BoolArray:
    """Return a mask of the faces (k, 3) of nodes that are connected to the face `start`."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    k = len(nodes)
    size = k + int(nodes.max()) + 1
    starts = np.full(size + 1, 3 * k, np.int32)
    starts[: k + 1] = np.arange(0, 3 * k + 1, 3)
    graph = csr_array((np.ones(3 * k), (nodes + k).ravel(), starts), (size, size))
    label = connected_components(graph, directed=False)[1][:k]
    return np.asarray(label == label[start])


def _is_connected_point(pairs: IntArray, count: int, start: int) -> BoolArray:
    """Return a mask of the points, among `count` points, connected to the point `start`."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(pairs))
    graph = coo_array((ones, (pairs[:, 0], pairs[:, 1])), (count, count)).tocsr()
    label = connected_components(graph, directed=False)[1]
    return np.asarray(label == label[start])
