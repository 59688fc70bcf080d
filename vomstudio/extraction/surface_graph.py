"""Surface graph for path searches: the edges of a mesh, or the neighbours in a cloud.

The whole graph is built when it is first required, and cached. Between two nearby points, only a
corridor is required: an ellipse that has these points as foci. On a textured mesh, the faces of the
corridor are subdivided until their edges are only a few pixels long, so that a path follows the
picture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.mesh import Mesh

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


N_NEIGHBOURS = 10
# Minimum length of an arc across a gap, in typical arcs.
_MIN_GAP_ARCS = 3.0
_MAX_NODES = 150_000
MAX_FINEST_NODES = 600_000
_MAX_LEVEL = 9
_EDGE_LENGTH_PX = 3.0
_NODES_PER_BLOCK = 200_000
_N_SAMPLE_ARCS = 1001
# Up to this fraction (1 / value) of all nodes, a search proceeds from neighbour to neighbour, which
# is slower per node but does not visit all nodes.
_LOCAL_SEARCH_DIVISOR = 50


@dataclass(frozen=True, eq=False)
class Graph:
    """Graph of n nodes on a surface.

    Parameters
    ----------
    places : (n, 3) float64 array
        Positions relative to the origin of the surface.
    starts, neighbours : int arrays
        The neighbours of node i are neighbours[starts[i]:starts[i + 1]]; the relation is symmetric.
    colours : (n, 3) array or None
        Colour components from 0 to 255.
    fields : mapping of str to (n,) array
    compute_roughness : callable
        Function that returns the roughness (n,): the bend of the surface in radians on a mesh, or
        the surface variation of a cloud.
    row : (n,) int array
        Point or vertex of the model; -1 for positions within faces.
    cache : dict
        Values derived from the graph, by name; each is computed once.
    """

    places: FloatArray
    starts: IntArray
    neighbours: Int32Array
    colours: FloatArray | None
    fields: Mapping[str, FloatArray]
    compute_roughness: Callable[[], FloatArray]
    row: IntArray
    cache: dict[str, FloatArray] = field(default_factory=dict)

    @cached_property
    def roughness(self) -> FloatArray:
        """Roughness (n,) of the nodes. See `compute_roughness`."""
        return self.compute_roughness()

    @cached_property
    def plane_coordinates(self) -> FloatArray:
        """Coordinates (n, 2) of the nodes in their best-fit plane."""
        offsets = self.places - self.places.mean(axis=0)
        _, axes = np.linalg.eigh(offsets.T @ offsets)
        return np.ascontiguousarray(offsets @ axes[:, 1:])

    @cached_property
    def typical_arc_length(self) -> float:
        """Median arc length in a regular sample of arcs; 0 if the graph has no arcs."""
        if not len(self.neighbours):
            return 0.0
        sample = np.linspace(
            0, len(self.neighbours) - 1, min(len(self.neighbours), _N_SAMPLE_ARCS)
        ).astype(np.int64)
        start = np.searchsorted(self.starts, sample, side="right") - 1
        arcs = self.places[self.neighbours[sample]] - self.places[start]
        return float(np.median(np.linalg.norm(arcs, axis=1)))


class SurfaceGraph:
    """Surface of a model as a graph for path searches.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame or in the frame of its file; lengths are in its unit.

    Raises
    ------
    GeometryError
        If the model has no surface.
    """

    def __init__(self, data: Mesh | PointCloud) -> None:
        self.data = data
        points = data.vertices if isinstance(data, Mesh) else data.points
        is_used = np.isfinite(points[:, 0])
        for axis in (1, 2):
            is_used &= np.isfinite(points[:, axis])
        if isinstance(data, Mesh) and len(data.faces):
            is_used_by_face = np.zeros(len(points), np.bool_)
            is_used_by_face[np.asarray(data.faces).ravel()] = True
            is_used &= is_used_by_face
        rows = np.flatnonzero(is_used)
        points_from_origin = np.asarray(points[rows], np.float64)
        # Column by column: a reduction along rows of three is many times slower.
        if len(rows) < 2 or not any(np.ptp(column) for column in points_from_origin.T):
            raise GeometryError(Finding("path.no-surface"))
        self.origin: FloatArray = np.floor([column.min() for column in points_from_origin.T])
        points_from_origin -= self.origin
        node_indices, first = _number_nodes(points_from_origin)
        self.places: FloatArray = np.ascontiguousarray(points_from_origin[first])
        self.row: IntArray = rows[first]
        self._point_nodes = np.full(len(points), -1, np.int64)
        self._point_nodes[rows] = node_indices
        self.cached_costs: dict[str, tuple[bytes, FloatArray, float]] = {}
        """Costs of `whole_graph` by name: the colours that they depend on, costs (n,), median."""
        self._scratch = np.full(len(self.places), -1, np.int64), np.empty(len(rows), np.int64)

    @cached_property
    def tree(self) -> cKDTree:
        """k-d tree of the node positions."""
        from scipy.spatial import cKDTree

        return cKDTree(self.places, leafsize=24, compact_nodes=False, balanced_tree=False)

    @cached_property
    def textures(self) -> TextureColours | None:
        """Textures of a mesh that has no vertex colours; otherwise None."""
        if isinstance(self.data, Mesh) and self.data.colors is None:
            textures = TextureColours(self.data)
            return textures if textures.has_textures else None
        return None

    @cached_property
    def is_mesh(self) -> bool:
        """Whether nodes are connected by faces rather than by distances between points."""
        return isinstance(self.data, Mesh) and len(self.data.faces) > 0

    # --- whole surface -----------------------------------------------------------------------
    @cached_property
    def whole_graph(self) -> Graph:
        """Graph of the whole surface with the colours of its points."""
        starts, neighbours = self._neighbours
        return self._build_graph(np.arange(len(self.places)), self.places, starts, neighbours)

    @cached_property
    def finest(self) -> Graph:
        """Graph of the whole surface; long edges of a textured mesh are subdivided.

        They are subdivided until all edges are a few pixels long, up to a maximum number of nodes.
        """
        if not self.can_refine:
            return self.whole_graph
        assert self.textures is not None
        faces = np.flatnonzero(self._is_valid_face)
        row, places, triangles, vertex_fields, material = self._textured_part(faces)
        vertex_fields = np.column_stack(
            [vertex_fields, self._vertex_roughness[self._point_nodes[row]]]
        )
        longest_edge = self._max_edge_length(places, vertex_fields[:, :2], triangles, material)
        for _ in range(_MAX_LEVEL):
            previous = len(places)
            places, vertex_fields, triangles, parent = _divide_long_edges(
                places, vertex_fields, triangles, longest_edge
            )
            if len(places) == previous:
                break
            row = np.concatenate([row, np.full(len(places) - previous, -1)])
            material = material[parent]
        colours = self.textures.at(vertex_fields[:, :2], triangles, material, 0)
        fields, roughness = vertex_fields[:, 2:-1], vertex_fields[:, -1]
        return self._build_welded_graph(places, triangles, colours, fields, row, lambda: roughness)

    def _max_edge_length(
        self, places: FloatArray, uv: FloatArray, triangles: IntArray, material: IntArray
    ) -> float:
        """Return the maximum edge length after the subdivision."""
        assert self.textures is not None
        a, b, c = (places[triangles[:, i]] for i in range(3))
        area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
        edge = float(np.median(np.linalg.norm(a - b, axis=1)))
        pixel = edge / max(self.textures.median_edge_px(uv, triangles, material), 1e-9)
        # Equilateral triangles have 1.15 nodes per squared edge length; subdivided triangles, with
        # edges between half the maximum and the maximum, have about four times as many.
        return max(float(np.sqrt(4.5 * area / MAX_FINEST_NODES)), _EDGE_LENGTH_PX * pixel)

    @cached_property
    def _faces(self) -> IntArray:
        """Faces of a mesh as node indices; -1 for unused vertices."""
        faces = self._point_nodes[np.asarray(self.data.faces, np.int64)]  # type: ignore[union-attr]
        return np.asarray(faces)

    @cached_property
    def _is_valid_face(self) -> BoolArray:
        a, b, c = self._faces.T
        return np.asarray((self._faces >= 0).all(axis=1) & (a != b) & (b != c) & (c != a))

    @cached_property
    def _neighbours(self) -> tuple[IntArray, Int32Array]:
        """Neighbours of the nodes: starts (n + 1,) and neighbouring nodes."""
        from vomstudio.extraction.path_kernels import remove_duplicates

        n = len(self.places)
        if self.is_mesh:
            return neighbour_lists(*_unique_edges(self._faces[self._is_valid_face], n), n)
        is_near = self._nearest_nodes >= 0
        source = np.repeat(np.arange(n), is_near.sum(axis=1))
        starts, neighbours = neighbour_lists(
            source, self._nearest_nodes[is_near].astype(np.int64), n
        )
        # Two points that are both among the nearest neighbours of each other have two arcs.
        return starts, neighbours[: remove_duplicates(starts, neighbours)].copy()

    @cached_property
    def _node_faces(self) -> tuple[IntArray, IntArray]:
        """Faces at each node, and their starts (n + 1,)."""
        from scipy.sparse import coo_array

        rows = np.flatnonzero(self._is_valid_face)
        nodes, corners = self._faces[rows].ravel(), np.arange(3 * len(rows))
        shape = len(self.places), len(corners)
        # The conversion is a counting sort, several times faster than np.argsort.
        corner_lists = coo_array((np.repeat(rows, 3), (nodes, corners)), shape=shape).tocsr()
        return corner_lists.data, np.asarray(corner_lists.indptr, np.int64)

    @cached_property
    def _nearest_nodes(self) -> Int32Array:
        """Neighbours (n, k) of the nodes of a cloud; -1 across a gap."""
        n = len(self.places)
        k = min(N_NEIGHBOURS, n - 1)
        neighbours, distances = np.empty((n, k), np.int32), np.empty((n, k), np.float32)
        for first in range(0, n, _NODES_PER_BLOCK):
            part = slice(first, first + _NODES_PER_BLOCK)
            distance, rows = self.tree.query(self.places[part], k=k + 1, workers=-1)
            neighbours[part], distances[part] = rows[:, 1:], distance[:, 1:]
        typical_distance = np.median(distances[neighbours[:, 0], min(3, k - 1)])
        local_spacings = np.maximum(distances[:, min(3, k - 1)], typical_distance)
        neighbours[distances > _MIN_GAP_ARCS * local_spacings[:, None]] = -1
        return neighbours

    def snap_distances(self, places: FloatArray) -> FloatArray:
        """Return the distances (w,) from positions (w, 3) in the data frame to nearest nodes."""
        positions_from_origin = np.asarray(places, np.float64).reshape(-1, 3) - self.origin
        return np.asarray(self.tree.query(positions_from_origin)[0], np.float64)

    def prepare(self) -> None:
        """Build the data for path searches.

        This is thread-safe and takes seconds for millions of points.
        """
        _ = self.tree, self.textures
        _ = self._node_faces if self.can_refine else self._neighbours

    # --- corridors ---------------------------------------------------------------------------
    def world(self, graph: Graph, nodes: IntArray) -> FloatArray:
        """Return the positions (k, 3) of nodes in the data frame.

        Positions of points or vertices of the model are exact.
        """
        points = self.data.vertices if isinstance(self.data, Mesh) else self.data.points
        places = graph.places[nodes] + self.origin
        rows = graph.row[nodes]
        places[rows >= 0] = points[rows[rows >= 0]]
        return np.asarray(places)

    @property
    def can_refine(self) -> bool:
        """Whether the faces of corridors are subdivided to the pixel size of textures."""
        return self.is_mesh and self.textures is not None

    def can_divide(self, start: FloatArray, end: FloatArray, max_length: float) -> bool:
        """Return whether a corridor has few enough faces to be subdivided.

        Parameters
        ----------
        start, end : (3,) arrays
            Positions relative to the origin.
        max_length : float
            Maximum length of the paths in the corridor.
        """
        if not self.can_refine:
            return False
        from vomstudio.extraction.path_kernels import list_nodes_in_ellipsoid

        ends = np.array(start, np.float64), np.array(end, np.float64)
        # A mesh has twice as many faces as vertices, apart from its border.
        return bool(
            list_nodes_in_ellipsoid(self.places, *ends, max_length, self._scratch[1])
            < 1.1 * _MAX_NODES / 4
        )

    def corridor(
        self, start: FloatArray, end: FloatArray, stretch_factor: float, margin: float
    ) -> Graph:
        """Build the graph of an ellipse around two positions.

        The ellipse contains all paths between the positions that are not longer than
        `stretch_factor` times the straight distance plus a margin. Unless the mesh is textured,
        only nodes connected to the first position are included.

        Parameters
        ----------
        start, end : (3,) arrays
            Positions relative to the origin.
        stretch_factor : float
        margin : float
            Margin in the unit of the data.

        Returns
        -------
        Graph
        """
        max_length = stretch_factor * float(np.linalg.norm(end - start)) + margin
        if not self.can_refine:
            return self._build_node_corridor(start, end, max_length)
        rows = np.asarray(
            self.tree.query_ball_point((start + end) / 2.0, max_length / 2.0), np.int64
        )
        near_positions = self.places[rows]
        is_in_ellipsoid = (
            np.linalg.norm(near_positions - start, axis=1)
            + np.linalg.norm(near_positions - end, axis=1)
            <= max_length
        )
        ends = np.asarray(self.tree.query(np.stack([start, end]))[1], np.int64)
        return self._build_refined_graph(np.append(rows[is_in_ellipsoid], ends))

    def _build_node_corridor(self, one: FloatArray, end: FloatArray, max_length: float) -> Graph:
        from vomstudio.extraction.path_kernels import (
            list_component_in_ellipsoid,
            list_nodes_in_ellipsoid,
            mark_component,
        )

        starts, neighbours = self._neighbours
        number, rows = self._scratch
        first = int(self.tree.query(one)[1])
        ends = np.array(one, np.float64), np.array(end, np.float64), max_length
        buffer = rows[: len(self.places) // _LOCAL_SEARCH_DIVISOR + 1]
        count = list_component_in_ellipsoid(
            self.places, starts, neighbours, first, *ends, number, buffer
        )
        is_too_large = count < 0
        if is_too_large:
            count = list_nodes_in_ellipsoid(self.places, *ends, rows)
            nodes = rows[:count].copy()
        else:
            nodes = np.sort(rows[:count])
        part = _extract_neighbours(nodes, starts, neighbours, number)
        if is_too_large:
            is_connected = np.zeros(count, np.bool_)
            first_row = int(np.searchsorted(nodes, first))
            if mark_component(*part, first_row, is_connected, rows) < count:
                nodes = nodes[is_connected]
                part = _extract_neighbours(nodes, starts, neighbours, number)
        return self._build_graph(nodes, self.places[nodes], *part)

    def _build_graph(
        self, rows: IntArray, places: FloatArray, starts: IntArray, neighbours: Int32Array
    ) -> Graph:
        row = self.row[rows]
        return Graph(
            places,
            starts,
            neighbours,
            self._point_colours(row),
            self._field_values(row),
            lambda: self._compute_roughness(rows, places),
            row,
        )

    def _build_refined_graph(self, rows: IntArray) -> Graph:
        """Build the graph of the faces at given nodes, with edges a few pixels long."""
        assert self.textures is not None
        node_faces, starts = self._node_faces
        first, count = starts[rows], starts[rows + 1] - starts[rows]
        face_rows = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(
            int(count.sum())
        )
        is_selected = np.zeros(len(self._faces), np.bool_)
        is_selected[node_faces[face_rows]] = True
        faces = np.flatnonzero(is_selected)
        row, places, triangles, vertex_fields, material = self._textured_part(faces)
        level = self._subdivision_level(places, vertex_fields[:, :2], triangles, material)
        undivided_mesh = row, places, triangles
        for _ in range(level):
            places, vertex_fields, triangles, added_count = _divide_all_triangles(
                places, vertex_fields, triangles
            )
            row = np.concatenate([row, np.full(added_count, -1)])
            material = np.tile(material, 4)
        colours = self.textures.at(vertex_fields[:, :2], triangles, material, level)
        return self._build_welded_graph(
            places,
            triangles,
            colours,
            vertex_fields[:, 2:],
            row,
            lambda: self._divided_roughness(*undivided_mesh, level),
        )

    def _divided_roughness(
        self, vertices: IntArray, places: FloatArray, triangles: IntArray, level: int
    ) -> FloatArray:
        """Return the roughness of vertices and of those added by subdividing their faces.

        Only a few costs require it, and computing it for the whole mesh takes seconds.
        """
        compute_roughness = self._vertex_roughness[self._point_nodes[vertices]][:, None]
        for _ in range(level):
            places, compute_roughness, triangles, _ = _divide_all_triangles(
                places, compute_roughness, triangles
            )
        return compute_roughness[:, 0]

    def _textured_part(
        self, faces: IntArray
    ) -> tuple[IntArray, FloatArray, IntArray, FloatArray, IntArray]:
        """Return vertices, places, triangles, vertex fields and materials of some faces.

        The vertex fields are the texture coordinates and the fields of the model.
        """
        assert isinstance(self.data, Mesh)
        assert self.textures is not None
        used_vertices, triangles = _select_used_vertices(
            self.data.faces[faces], len(self.data.vertices)
        )
        places = np.asarray(self.data.vertices[used_vertices], np.float64) - self.origin
        vertex_fields = np.column_stack(
            [self.textures.uv[used_vertices], *self._field_values(used_vertices).values()]
        )
        material = self.textures.face_materials(faces)
        return used_vertices, places, triangles, vertex_fields, material

    def _build_welded_graph(
        self,
        places: FloatArray,
        triangles: IntArray,
        colours: FloatArray,
        fields: FloatArray,
        row: IntArray,
        compute_roughness: Callable[[], FloatArray],
    ) -> Graph:
        node, first = _number_nodes(places)
        n = len(first)
        count = np.bincount(node, minlength=n)
        mean = np.stack([np.bincount(node, colours[:, i], n) / count for i in range(3)], axis=1)
        names = list(self.data.fields)
        return Graph(
            np.ascontiguousarray(places[first]),
            *neighbour_lists(*_unique_edges(node[triangles], n), n),
            mean,
            {name: fields[first, i] for i, name in enumerate(names)},
            lambda: compute_roughness()[first],
            row[first],
        )

    def _subdivision_level(
        self, places: FloatArray, uv: FloatArray, triangles: IntArray, material: IntArray
    ) -> int:
        """Return the required number of subdivisions, limited by the maximum number of nodes."""
        assert self.textures is not None
        pixels = self.textures.median_edge_px(uv, triangles, material)
        level = int(np.clip(np.ceil(np.log2(max(pixels / _EDGE_LENGTH_PX, 1.0))), 0, _MAX_LEVEL))
        while level > 0 and len(triangles) / 2 * 4**level > _MAX_NODES:
            level -= 1
        return level

    def _point_colours(self, row: IntArray) -> FloatArray | None:
        if self.data.colors is not None:
            return np.asarray(self.data.colors[row], np.float64)
        if self.textures is not None:
            return self.textures.vertex_colours[row]
        return None

    def _field_values(self, row: IntArray) -> dict[str, FloatArray]:
        return {
            name: np.asarray(values[row], np.float64) for name, values in self.data.fields.items()
        }

    @cached_property
    def _vertex_roughness(self) -> FloatArray:
        """Maximum angle between the normals of adjacent faces at each node of a mesh, radians."""
        rows = np.flatnonzero(self._is_valid_face)
        faces = self._faces[rows]
        a, b, c = (self.places[faces[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal, axis=1)
        unit = normal / np.where(size > 0.0, size, 1.0)[:, None]
        n = len(self.places)
        key = _edge_keys(faces, n)
        order = np.argsort(key, kind="stable")
        shared_rows = np.flatnonzero(np.diff(key[order]) == 0)
        first, second = order[shared_rows], order[shared_rows + 1]
        cosine = np.clip((unit[first // 3] * unit[second // 3]).sum(axis=1), -1.0, 1.0)
        angle = np.zeros(n)
        for end in (faces.ravel()[first], faces[:, [1, 2, 0]].ravel()[first]):
            np.maximum.at(angle, end, np.arccos(cosine))
        return angle

    def _compute_roughness(self, rows: IntArray, places: FloatArray) -> FloatArray:
        if self.is_mesh:
            return self._vertex_roughness[rows]
        from vomstudio.extraction.kernels import fit_local_planes

        neighbours = np.where(
            self._nearest_nodes[rows] < 0, rows[:, None], self._nearest_nodes[rows]
        )
        results = np.empty((len(rows), 3)), np.empty(len(rows))
        fit_local_planes(self.places, places, np.ascontiguousarray(neighbours, np.int32), *results)
        return np.nan_to_num(results[1])


def neighbour_lists(first: IntArray, second: IntArray, n: int) -> tuple[IntArray, Int32Array]:
    """Build the lists of neighbours of nodes. See `Graph`.

    Parameters
    ----------
    first, second : (m,) ndarray of int
        Nodes at the two ends of each arc.
    n : int
        Number of nodes.

    Returns
    -------
    starts : (n + 1,) ndarray of int
    neighbours : ndarray of int32
    """
    from vomstudio.extraction.path_kernels import list_neighbours

    starts, neighbours = np.zeros(n + 1, np.int64), np.empty(2 * len(first), np.int32)
    list_neighbours(np.ascontiguousarray(first), np.ascontiguousarray(second), starts, neighbours)
    return starts, neighbours


def _extract_neighbours(
    rows: IntArray, starts: IntArray, neighbours: Int32Array, number: IntArray
) -> tuple[IntArray, Int32Array]:
    """List the neighbours within a subset of nodes; `number` (n,) must be -1 and is restored."""
    from vomstudio.extraction.path_kernels import extract_subgraph

    number[rows] = np.arange(len(rows))
    part_starts = np.empty(len(rows) + 1, np.int64)
    part_neighbours = np.empty(int((starts[rows + 1] - starts[rows]).sum()), np.int32)
    length = extract_subgraph(starts, neighbours, rows, number, part_starts, part_neighbours)
    number[rows] = -1
    return part_starts, part_neighbours[:length]


def _select_used_vertices(faces: Int32Array, n: int) -> tuple[IntArray, IntArray]:
    """Return the vertices (k,) used by faces (m, 3), and the faces as rows of these vertices."""
    is_used = np.zeros(n, np.bool_)
    is_used[faces.ravel()] = True
    return np.flatnonzero(is_used), (np.cumsum(is_used) - 1)[faces]


def _number_nodes(places: FloatArray) -> tuple[IntArray, IntArray]:
    """Weld positions (k, 3); return their nodes (k,) and the first position (n,) of each node.

    Nodes are in order of appearance. Neighbours are therefore also neighbours in memory, which
    makes searches over millions of nodes several times faster.
    """
    key = weld_points(places)
    first = np.empty(int(key.max()) + 1, np.int64)
    first[key[::-1]] = np.arange(len(key))[::-1]
    is_first = np.zeros(len(key), np.bool_)
    is_first[first] = True
    return (np.cumsum(is_first) - 1)[first[key]], np.flatnonzero(is_first)


def _edge_keys(faces: IntArray, n: int) -> IntArray:
    """Return a key of the edge after each corner of faces (m, 3): smaller * n + larger node."""
    next_corners = faces[:, [1, 2, 0]]
    return np.asarray(np.minimum(faces, next_corners) * n + np.maximum(faces, next_corners)).ravel()


def _unique_edges(faces: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """Return the first and second nodes of the edges of faces (m, 3), without duplicates."""
    # `np.unique` finds distinct integers by a hash table, which takes ten times as long.
    key = np.sort(_edge_keys(faces, n))
    key = key[np.append(True, key[1:] != key[:-1])] if len(key) else key
    first = key // n
    return first, key - first * n


def _divide_all_triangles(
    places: FloatArray, vertex_fields: FloatArray, triangles: IntArray
) -> tuple[FloatArray, FloatArray, IntArray, int]:
    """Divide every triangle into four; also return the number of new nodes."""
    n = len(places)
    key, edge_indices = np.unique(_edge_keys(triangles, n), return_inverse=True)
    first, second = key // n, key % n
    midpoints = n + edge_indices.reshape(-1, 3)
    a, b, c = triangles.T
    ab, bc, ca = midpoints.T
    divided_triangles = np.concatenate(
        [
            np.stack([a, ab, ca], axis=1),
            np.stack([ab, b, bc], axis=1),
            np.stack([ca, bc, c], axis=1),
            np.stack([ab, bc, ca], axis=1),
        ]
    )
    return (
        np.concatenate([places, (places[first] + places[second]) / 2.0]),
        np.concatenate([vertex_fields, (vertex_fields[first] + vertex_fields[second]) / 2.0]),
        divided_triangles,
        len(key),
    )


def _divide_long_edges(
    places: FloatArray, vertex_fields: FloatArray, triangles: IntArray, max_edge_length: float
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Divide triangles at the midpoints of the edges that are longer than `max_edge_length`.

    The original triangle (m,) of each new triangle is also returned.
    """
    n = len(places)
    key, edge_indices = np.unique(_edge_keys(triangles, n), return_inverse=True)
    first, second = key // n, key % n
    is_long = np.linalg.norm(places[first] - places[second], axis=1) > max_edge_length
    midpoints = np.where(is_long, n + np.cumsum(is_long) - 1, -1)[edge_indices].reshape(-1, 3)
    first, second = first[is_long], second[is_long]
    count = (midpoints >= 0).sum(axis=1)
    rows = np.arange(len(triangles))
    # Rotate triangles to make a single divided edge the first, or a single undivided edge the last.
    rotation = np.where(
        count == 2, (np.argmin(midpoints, axis=1) + 1) % 3, np.argmax(midpoints, axis=1)
    )
    order = (rotation[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles, order, axis=1).T
    ab, bc, ca = np.take_along_axis(midpoints, order, axis=1).T
    pieces: list[IntArray] = [triangles[count == 0]]
    parents: list[IntArray] = [rows[count == 0]]
    for divided_count, part_corners in (
        (1, ((a, ab, c), (ab, b, c))),
        (2, ((ab, b, bc), (a, ab, bc), (a, bc, c))),
        (3, ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))),
    ):
        is_divided = count == divided_count
        for corner_columns in part_corners:
            pieces.append(
                np.stack([corner_rows[is_divided] for corner_rows in corner_columns], axis=1)
            )
            parents.append(rows[is_divided])
    return (
        np.concatenate([places, (places[first] + places[second]) / 2.0]),
        np.concatenate([vertex_fields, (vertex_fields[first] + vertex_fields[second]) / 2.0]),
        np.concatenate(pieces),
        np.concatenate(parents),
    )
