"""A surface as a graph, for paths along it: the edges of a mesh, the neighbours in a cloud.

The whole graph is made when it is first needed and kept. Between two places that are near each
other only a corridor is needed: an ellipse with its foci there. Where a mesh wears textures, the
faces of the corridor are divided until their edges are a few pixels long, so that a path follows
what is seen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.mesh import Mesh

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


NEIGHBOURS = 10
# A neighbour farther off than this many usual distances is across a gap.
_GAP = 3.0
_MOST_NODES = 150_000
MOST_FINEST = 600_000
_DEEPEST = 9
_PIXELS_AN_EDGE = 3.0
_BLOCK = 200_000
_SOME_ARCS = 1001
# Up to so small a part of the nodes is looked for from neighbour to neighbour, which is slower for
# each, but does not look at all.
_FEW = 50


@dataclass(frozen=True, eq=False)
class Graph:
    """n nodes: places (n, 3) float64 from the surface's origin on; the neighbours of node i are
    near[starts[i]:starts[i + 1]], and it is one of each of theirs; colours (n, 3) 0 to 255 or None;
    fields (n,) by name; rough gives the roughness (n,): how sharply the surface bends there,
    radians on a mesh and the surface variation of a cloud; row (n,) of the point or vertex of the
    model, -1 for places within faces."""

    places: FloatArray
    starts: IntArray
    near: Int32Array
    colours: FloatArray | None
    fields: Mapping[str, FloatArray]
    rough: Callable[[], FloatArray]
    row: IntArray

    @cached_property
    def roughness(self) -> FloatArray:
        """(n,)"""
        return self.rough()

    @cached_property
    def flat(self) -> FloatArray:
        """(n, 2) the places in the plane that fits them best."""
        off = self.places - self.places.mean(axis=0)
        _, ways = np.linalg.eigh(off.T @ off)
        return np.ascontiguousarray(off @ ways[:, 1:])

    @cached_property
    def usual_arc(self) -> float:
        """Median length of some of the arcs, evenly chosen, 0 where there are none."""
        if not len(self.near):
            return 0.0
        some = np.linspace(0, len(self.near) - 1, min(len(self.near), _SOME_ARCS)).astype(np.int64)
        start = np.searchsorted(self.starts, some, side="right") - 1
        arcs = self.places[self.near[some]] - self.places[start]
        return float(np.median(np.linalg.norm(arcs, axis=1)))


class SurfaceGraph:
    """data : in World or in the file's frame; lengths are in its unit. Raises GeometryError where
    there is no surface."""

    def __init__(self, data: Mesh | PointCloud) -> None:
        self.data = data
        points = data.vertices if isinstance(data, Mesh) else data.points
        sound = np.isfinite(points).all(axis=1)
        if isinstance(data, Mesh) and len(data.faces):
            used = np.zeros(len(points), np.bool_)
            used[np.asarray(data.faces).ravel()] = True
            sound &= used
        rows = np.flatnonzero(sound)
        if len(rows) < 2 or not np.ptp(points[rows], axis=0).any():
            raise GeometryError(Finding("path.no-surface"))
        self.origin: FloatArray = np.floor(points[rows].min(axis=0))
        local = points[rows] - self.origin
        which = welded(local)
        first = np.full(int(which.max()) + 1, -1, np.int64)
        first[which[::-1]] = np.arange(len(which))[::-1]
        self.places: FloatArray = np.ascontiguousarray(local[first], np.float64)
        self.row: IntArray = rows[first]
        self._node = np.full(len(points), -1, np.int64)
        self._node[rows] = which
        self.kept_costs: dict[str, tuple[bytes, FloatArray]] = {}
        """Of a metre at each node of `whole`, by what is looked for: the colours that they are for,
        and the costs (n,)."""
        self._scratch = np.full(len(self.places), -1, np.int64), np.empty(len(rows), np.int64)

    @cached_property
    def tree(self) -> cKDTree:
        """Of the nodes' places."""
        from scipy.spatial import cKDTree

        return cKDTree(self.places, leafsize=24, compact_nodes=False, balanced_tree=False)

    @cached_property
    def textures(self) -> TextureColours | None:
        """Of a mesh that wears them and has no colours of its own."""
        if isinstance(self.data, Mesh) and self.data.colors is None:
            found = TextureColours(self.data)
            return found if found.any else None
        return None

    @cached_property
    def is_mesh(self) -> bool:
        """Faces hang it together; else the distances of its points do."""
        return isinstance(self.data, Mesh) and len(self.data.faces) > 0

    # --- the whole ---------------------------------------------------------------------------
    @cached_property
    def whole(self) -> Graph:
        """All of it, with the colours of its points."""
        starts, near = self._neighbours
        return self._graph(np.arange(len(self.places)), self.places, starts, near)

    @cached_property
    def finest(self) -> Graph:
        """All of it; of a mesh that wears textures with its long edges divided, until all are a few
        pixels long or the nodes are many."""
        if not self.refines:
            return self.whole
        assert isinstance(self.data, Mesh)
        assert self.textures is not None
        faces = np.flatnonzero(self._sound_faces)
        triangles = np.asarray(self.data.faces[faces], np.int64)
        used, which = np.unique(triangles, return_inverse=True)
        triangles = which.reshape(-1, 3)
        places = np.asarray(self.data.vertices[used], np.float64) - self.origin
        rough = self._vertex_roughness[self._node[used]]
        extra = np.column_stack([self.textures.uv[used], rough, *self._fields_of(used).values()])
        material = self.textures.material_of(faces)
        longest = self._longest_edge(places, extra[:, :2], triangles, material)
        row = used
        for _ in range(_DEEPEST):
            before = len(places)
            places, extra, triangles, parent = _divided_where_long(
                places, extra, triangles, longest
            )
            if len(places) == before:
                break
            row = np.concatenate([row, np.full(len(places) - before, -1)])
            material = material[parent]
        colours = self.textures.at(extra[:, :2], triangles, material, 0)
        return self._welded_graph(places, triangles, colours, extra[:, 2:], row)

    def _longest_edge(
        self, places: FloatArray, uv: FloatArray, triangles: IntArray, material: IntArray
    ) -> float:
        """To which edges are divided."""
        assert self.textures is not None
        a, b, c = (places[triangles[:, i]] for i in range(3))
        area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
        edge = float(np.median(np.linalg.norm(a - b, axis=1)))
        pixel = edge / max(self.textures.edge_pixels(uv, triangles, material), 1e-9)
        # Equilateral triangles have 1.15 nodes on the square of an edge; divided ones, with edges
        # between half of the longest and it, some four times as many.
        return max(float(np.sqrt(4.5 * area / MOST_FINEST)), _PIXELS_AN_EDGE * pixel)

    @cached_property
    def _faces(self) -> IntArray:
        """Faces of a mesh by nodes, those that are none left out."""
        faces = self._node[np.asarray(self.data.faces, np.int64)]  # type: ignore[union-attr]
        return np.asarray(faces)

    @cached_property
    def _sound_faces(self) -> BoolArray:
        a, b, c = self._faces.T
        return np.asarray((self._faces >= 0).all(axis=1) & (a != b) & (b != c) & (c != a))

    @cached_property
    def _neighbours(self) -> tuple[IntArray, Int32Array]:
        """Of each node: starts (n + 1,), and the nodes."""
        from vomstudio.extraction.path_kernels import without_repeats

        n = len(self.places)
        if self.is_mesh:
            return neighbours_of(*_edges(self._faces[self._sound_faces], n), n)
        there = self._near >= 0
        source = np.repeat(np.arange(n), there.sum(axis=1))
        starts, near = neighbours_of(source, self._near[there].astype(np.int64), n)
        # Two points that are each among the nearest of the other came as two arcs.
        return starts, near[: without_repeats(starts, near)].copy()

    @cached_property
    def _faces_of(self) -> tuple[IntArray, IntArray]:
        """Faces at each node: rows into one array, and its starts."""
        rows = np.flatnonzero(self._sound_faces)
        nodes = self._faces[rows].ravel()
        order = np.argsort(nodes, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(nodes, minlength=len(self.places)))])
        return rows[order // 3], starts

    @cached_property
    def _near(self) -> Int32Array:
        """(n, k) neighbours of a cloud's nodes, -1 for those across a gap."""
        n = len(self.places)
        k = min(NEIGHBOURS, n - 1)
        near, far = np.empty((n, k), np.int32), np.empty((n, k), np.float32)
        for first in range(0, n, _BLOCK):
            part = slice(first, first + _BLOCK)
            distance, rows = self.tree.query(self.places[part], k=k + 1, workers=-1)
            near[part], far[part] = rows[:, 1:], distance[:, 1:]
        usual = np.median(far[near[:, 0], min(3, k - 1)])
        own = np.maximum(far[:, min(3, k - 1)], usual)
        near[far > _GAP * own[:, None]] = -1
        return near

    def snapped(self, places: FloatArray) -> FloatArray:
        """(w,) distance of places (w, 3), in the frame of the data, from its nearest point."""
        given = np.asarray(places, np.float64).reshape(-1, 3) - self.origin
        return np.asarray(self.tree.query(given)[0], np.float64)

    def prepare(self) -> None:
        """Make what paths need, which takes seconds for millions of points; any thread."""
        _ = self.tree, self.textures
        _ = self._faces_of if self.refines else self._neighbours

    # --- a part ------------------------------------------------------------------------------
    def world(self, graph: Graph, nodes: IntArray) -> FloatArray:
        """(k, 3) places of a graph's nodes in the frame of the data, its own points to the bit."""
        points = self.data.vertices if isinstance(self.data, Mesh) else self.data.points
        found = graph.places[nodes] + self.origin
        own = graph.row[nodes]
        found[own >= 0] = points[own[own >= 0]]
        return np.asarray(found)

    @property
    def refines(self) -> bool:
        """The faces of corridors are divided to the pixels of textures."""
        return self.is_mesh and self.textures is not None

    def corridor(self, one: FloatArray, other: FloatArray, stretch: float, margin: float) -> Graph:
        """What lies within an ellipse around two places (3,), from the origin on: all paths from
        one to the other that are at most `stretch` times as long as the straight line, and a
        margin. Of points and vertices what hangs together with the first place."""
        reach = stretch * float(np.linalg.norm(other - one)) + margin
        if not self.refines:
            return self._corridor_of_nodes(one, other, reach)
        rows = np.asarray(self.tree.query_ball_point((one + other) / 2.0, reach / 2.0), np.int64)
        near = self.places[rows]
        inside = np.linalg.norm(near - one, axis=1) + np.linalg.norm(near - other, axis=1) <= reach
        ends = np.asarray(self.tree.query(np.stack([one, other]))[1], np.int64)
        return self._refined(np.append(rows[inside], ends))

    def _corridor_of_nodes(self, one: FloatArray, other: FloatArray, reach: float) -> Graph:
        from vomstudio.extraction.path_kernels import inside, together, within

        starts, near = self._neighbours
        number, rows = self._scratch
        first = int(self.tree.query(one)[1])
        ends = np.array(one, np.float64), np.array(other, np.float64), reach
        few = rows[: len(self.places) // _FEW + 1]
        count = within(self.places, starts, near, first, *ends, number, few)
        many = count < 0
        if many:
            count = inside(self.places, *ends, rows)
            found = rows[:count].copy()
        else:
            found = np.sort(rows[:count])
        part = _part(found, starts, near, number)
        if many:
            met = np.zeros(count, np.bool_)
            start = int(np.searchsorted(found, first))
            if together(*part, start, met, rows) < count:
                found = found[met]
                part = _part(found, starts, near, number)
        return self._graph(found, self.places[found], *part)

    def _graph(
        self, rows: IntArray, places: FloatArray, starts: IntArray, near: Int32Array
    ) -> Graph:
        row = self.row[rows]
        return Graph(
            places,
            starts,
            near,
            self._colours_of(row),
            self._fields_of(row),
            lambda: self._roughness(rows, places),
            row,
        )

    def _refined(self, rows: IntArray) -> Graph:
        """The faces at these nodes, divided until an edge is some pixels long."""
        assert isinstance(self.data, Mesh)
        assert self.textures is not None
        by_node, starts = self._faces_of
        first, count = starts[rows], starts[rows + 1] - starts[rows]
        at = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(int(count.sum()))
        chosen = np.zeros(len(self._faces), np.bool_)
        chosen[by_node[at]] = True
        faces = np.flatnonzero(chosen)
        corners = np.asarray(self.data.faces[faces], np.int64)
        used, which = np.unique(corners, return_inverse=True)
        places = np.asarray(self.data.vertices[used], np.float64) - self.origin
        rough = self._vertex_roughness[self._node[used]]
        extra = np.column_stack([self.textures.uv[used], rough, *self._fields_of(used).values()])
        triangles = which.reshape(-1, 3)
        material = self.textures.material_of(faces)
        level = self._level(places, extra[:, :2], triangles, material)
        row = used
        for _ in range(level):
            places, extra, triangles, fresh = _divided(places, extra, triangles)
            row = np.concatenate([row, np.full(fresh, -1)])
            material = np.tile(material, 4)
        colours = self.textures.at(extra[:, :2], triangles, material, level)
        return self._welded_graph(places, triangles, colours, extra[:, 2:], row)

    def _welded_graph(
        self,
        places: FloatArray,
        triangles: IntArray,
        colours: FloatArray,
        extra: FloatArray,
        row: IntArray,
    ) -> Graph:
        node = welded(places)
        n = int(node.max()) + 1
        first = np.full(n, -1, np.int64)
        first[node[::-1]] = np.arange(len(node))[::-1]
        number = np.bincount(node, minlength=n)
        mean = np.stack([np.bincount(node, colours[:, i], n) / number for i in range(3)], axis=1)
        names = list(self.data.fields)
        return Graph(
            np.ascontiguousarray(places[first]),
            *neighbours_of(*_edges(node[triangles], n), n),
            mean,
            {name: extra[first, 1 + i] for i, name in enumerate(names)},
            lambda: extra[first, 0],
            row[first],
        )

    def _level(
        self, places: FloatArray, uv: FloatArray, triangles: IntArray, material: IntArray
    ) -> int:
        """How often to divide the faces: to some pixels an edge, while the nodes stay few."""
        assert self.textures is not None
        pixels = self.textures.edge_pixels(uv, triangles, material)
        level = int(np.clip(np.ceil(np.log2(max(pixels / _PIXELS_AN_EDGE, 1.0))), 0, _DEEPEST))
        while level > 0 and len(triangles) / 2 * 4**level > _MOST_NODES:
            level -= 1
        return level

    def _colours_of(self, row: IntArray) -> FloatArray | None:
        if self.data.colors is not None:
            return np.asarray(self.data.colors[row], np.float64)
        if self.textures is not None:
            return self.textures.of_vertices[row]
        return None

    def _fields_of(self, row: IntArray) -> dict[str, FloatArray]:
        return {
            name: np.asarray(values[row], np.float64) for name, values in self.data.fields.items()
        }

    @cached_property
    def _vertex_roughness(self) -> FloatArray:
        """Of a mesh's nodes: the widest angle between the normals of faces at them, radians."""
        rows = np.flatnonzero(self._sound_faces)
        faces = self._faces[rows]
        a, b, c = (self.places[faces[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal, axis=1)
        unit = normal / np.where(size > 0.0, size, 1.0)[:, None]
        n = len(self.places)
        ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        key = ends.min(axis=1) * n + ends.max(axis=1)
        order = np.argsort(key, kind="stable")
        same = np.flatnonzero(np.diff(key[order]) == 0)
        one, two = order[same], order[same + 1]
        cosine = np.clip((unit[one // 3] * unit[two // 3]).sum(axis=1), -1.0, 1.0)
        angle = np.zeros(n)
        for end in ends[one].T:
            np.maximum.at(angle, end, np.arccos(cosine))
        return angle

    def _roughness(self, rows: IntArray, places: FloatArray) -> FloatArray:
        if self.is_mesh:
            return self._vertex_roughness[rows]
        from vomstudio.extraction.kernels import local_planes

        near = np.where(self._near[rows] < 0, rows[:, None], self._near[rows])
        found = np.empty((len(rows), 3)), np.empty(len(rows))
        local_planes(self.places, places, np.ascontiguousarray(near, np.int32), *found)
        return np.nan_to_num(found[1])


def neighbours_of(first: IntArray, second: IntArray, n: int) -> tuple[IntArray, Int32Array]:
    """Lists of neighbours of n nodes, as a Graph has them, from the ends of each arc."""
    from vomstudio.extraction.path_kernels import neighbours

    starts, near = np.zeros(n + 1, np.int64), np.empty(2 * len(first), np.int32)
    neighbours(np.ascontiguousarray(first), np.ascontiguousarray(second), starts, near)
    return starts, near


def _part(
    rows: IntArray, starts: IntArray, near: Int32Array, number: IntArray
) -> tuple[IntArray, Int32Array]:
    """Lists of neighbours of some nodes alone. number (n,) is -1 on the way in and out."""
    from vomstudio.extraction.path_kernels import part_of

    number[rows] = np.arange(len(rows))
    own_starts = np.empty(len(rows) + 1, np.int64)
    own_near = np.empty(int((starts[rows + 1] - starts[rows]).sum()), np.int32)
    length = part_of(starts, near, rows, number, own_starts, own_near)
    number[rows] = -1
    return own_starts, own_near[:length]


def _edges(faces: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """(first, second) node of each edge of faces (m, 3), once."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    key = np.unique(ends.min(axis=1) * n + ends.max(axis=1))
    return key // n, key % n


def _divided(
    places: FloatArray, extra: FloatArray, triangles: IntArray
) -> tuple[FloatArray, FloatArray, IntArray, int]:
    """Every triangle in four, with nodes at the middles of its edges; how many these are."""
    n = len(places)
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    key, which = np.unique(ends.min(axis=1) * n + ends.max(axis=1), return_inverse=True)
    one, two = key // n, key % n
    middle = n + which.reshape(-1, 3)
    a, b, c = triangles.T
    ab, bc, ca = middle.T
    four = np.concatenate(
        [
            np.stack([a, ab, ca], axis=1),
            np.stack([ab, b, bc], axis=1),
            np.stack([ca, bc, c], axis=1),
            np.stack([ab, bc, ca], axis=1),
        ]
    )
    return (
        np.concatenate([places, (places[one] + places[two]) / 2.0]),
        np.concatenate([extra, (extra[one] + extra[two]) / 2.0]),
        four,
        len(key),
    )


def _divided_where_long(
    places: FloatArray, extra: FloatArray, triangles: IntArray, longest: float
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Edges that are longer have a node in their middle, and triangles are divided in two, three or
    four by these; parent : (m,) the triangle that each comes from."""
    n = len(places)
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    key, which = np.unique(ends.min(axis=1) * n + ends.max(axis=1), return_inverse=True)
    one, two = key // n, key % n
    long = np.linalg.norm(places[one] - places[two], axis=1) > longest
    middle = np.where(long, n + np.cumsum(long) - 1, -1)[which].reshape(-1, 3)
    one, two = one[long], two[long]
    count = (middle >= 0).sum(axis=1)
    rows = np.arange(len(triangles))
    # Turned so that of one node in a middle it is the first edge's, and of two not the last one's.
    first = np.where(count == 2, (np.argmin(middle, axis=1) + 1) % 3, np.argmax(middle, axis=1))
    order = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles, order, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, order, axis=1).T
    pieces: list[IntArray] = [triangles[count == 0]]
    parents: list[IntArray] = [rows[count == 0]]
    for wanted, corners in (
        (1, ((a, ab, c), (ab, b, c))),
        (2, ((ab, b, bc), (a, ab, bc), (a, bc, c))),
        (3, ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))),
    ):
        of = count == wanted
        for corner in corners:
            pieces.append(np.stack([each[of] for each in corner], axis=1))
            parents.append(rows[of])
    return (
        np.concatenate([places, (places[one] + places[two]) / 2.0]),
        np.concatenate([extra, (extra[one] + extra[two]) / 2.0]),
        np.concatenate(pieces),
        np.concatenate(parents),
    )
