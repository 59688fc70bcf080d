"""Clouds as octrees, of whose nodes only those that a view needs are drawn or even there.

Every node holds a thin, even sample of the points in its cube; its children fill in what is
between. A point is known by its row in the whole file. Of a cloud that is too large to be held that
is the number of points in the nodes that stand before its own in the file, plus its place within
the node: ids stay the same whatever is loaded, and are the rows of the same file read whole.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray, IntegerArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.progressive_order import Arrangement

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


POINT_BUDGET = 5_000_000
"""Points of a cloud that may be there at a time, unless told otherwise."""
FETCHED_AT_ONCE = 50_000
"""Points of a file that are unpacked together: several nodes use several processors, but whoever
unpacks them keeps every other thread waiting meanwhile."""
FINE_PIXELS = 1.5
"""Nodes are asked for until neighbouring points of the node above are no further apart."""


@dataclass(frozen=True)
class View:
    """What a viewer sees of a cloud, all in the cloud's file frame.

    right, up, direction : rows of a rotation; direction points away from the viewer
    half_height : tangent of the half angle, or half the height of the picture where orthographic
    pixels : height of the picture
    """

    position: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], ...]
    half_height: float
    aspect: float
    orthographic: bool
    near: float
    pixels: int


@dataclass(frozen=True, eq=False)
class Piece:
    """The points of a node: `rows` of `cloud`, which are `ids` of the whole."""

    cloud: PointCloud
    rows: IntegerArray
    ids: IntegerArray


class CloudNodes:
    """The nodes of a cloud, of which a view needs some.

    bounds : (n, 2, 3) boxes; spacing : (n,) distance of neighbouring points of a node
    counts : (n,) points of each node; parents : (n,) row of the node above, -1 for none
    budget : how many points may be there at a time
    first : rows of the nodes that stand for the whole
    in_order : points that follow each other in a node are neighbours
    at_once : nodes with so many points together are best fetched at once
    """

    in_order = False
    at_once = 0

    def __init__(
        self,
        bounds: FloatArray,
        spacing: FloatArray,
        counts: IntArray,
        parents: IntArray,
        budget: int,
        first: tuple[int, ...],
    ) -> None:
        self.bounds, self.spacing, self.counts = bounds, spacing, counts
        self.parents, self.budget, self.first = parents, budget, first
        self.total = int(counts.sum())

    def __len__(self) -> int:
        return len(self.counts)

    def fetch(self, rows: Sequence[int]) -> list[Piece]:
        """The points of nodes, from wherever they are. Raises InputError."""
        raise NotImplementedError

    def let_go(self, row: int, piece: Piece) -> None:
        """A node that has been fetched is not needed any more."""

    def choose(self, view: View, most: int) -> IntArray:
        """Rows of the nodes that a picture needs, the most needed first, of at most `most` points:
        those in view whose parents' points are more than FINE_PIXELS apart."""
        position = np.array(view.position)
        low, high = self.bounds[:, 0], self.bounds[:, 1]
        q = ((low + high) / 2.0 - position) @ np.array(view.axes).T
        radius = np.linalg.norm(high - low, axis=1) / 2.0
        off = np.maximum(np.maximum(low - position, position - high), 0.0)
        distance = np.maximum(np.sqrt(np.einsum("ij,ij->i", off, off)), view.near)
        reach = np.ones(len(self)) if view.orthographic else distance
        apart = 2.0 * self.spacing * view.pixels / (2.0 * view.half_height * reach)
        tall = view.half_height * (1.0 if view.orthographic else np.maximum(q[:, 2], 0.0))
        # The planes that bound a view in perspective lean: a ball reaches further across them.
        up = 1.0 if view.orthographic else np.hypot(1.0, view.half_height)
        side = 1.0 if view.orthographic else np.hypot(1.0, view.half_height * view.aspect)
        seen = (
            (np.abs(q[:, 1]) <= tall + radius * up)
            & (np.abs(q[:, 0]) <= tall * view.aspect + radius * side)
            & (q[:, 2] + radius > 0.0)
        )
        rows = np.flatnonzero(seen & ((apart > FINE_PIXELS) | (self.parents < 0)))
        rows = rows[np.lexsort((-self.spacing[rows], -apart[rows]))]
        return np.asarray(rows[np.cumsum(self.counts[rows]) <= most])

    def closing(self, rows: IntArray) -> dict[int, float]:
        """The spacing at which the points of shown nodes close the surface together: of each the
        finest spacing of those shown below it."""
        finest = dict(zip(rows.tolist(), self.spacing[rows].tolist(), strict=True))
        for row in sorted(finest, key=lambda r: float(self.spacing[r])):
            parent = int(self.parents[row])
            if parent in finest:
                finest[parent] = min(finest[parent], finest[row])
        return finest


class ArrangedNodes(CloudNodes):
    """Of a cloud that is there as a whole."""

    in_order = True

    def __init__(self, cloud: PointCloud, arrangement: Arrangement, budget: int) -> None:
        self._cloud, self._arrangement = cloud, arrangement
        super().__init__(
            arrangement.bounds,
            arrangement.spacing,
            np.diff(arrangement.starts),
            arrangement.parents,
            budget,
            tuple(np.flatnonzero(arrangement.parents < 0).tolist()),
        )

    def fetch(self, rows: Sequence[int]) -> list[Piece]:
        starts, order = self._arrangement.starts, self._arrangement.rows
        points = [order[starts[row] : starts[row + 1]] for row in rows]
        return [Piece(self._cloud, own, own) for own in points]


class NodeStore(CloudNodes):
    """What has been read of a file's nodes. Any thread may use it.

    starts : (n,) number of each node's first point in the file
    read : reads the points of nodes, one after the other; raises InputError
    """

    at_once = FETCHED_AT_ONCE

    def __init__(
        self,
        bounds: FloatArray,
        spacing: FloatArray,
        counts: IntArray,
        starts: IntArray,
        parents: IntArray,
        read: Callable[[Sequence[int]], PointCloud],
        budget: int,
        first: tuple[int, ...],
    ) -> None:
        super().__init__(bounds, spacing, counts, parents, budget, first)
        self.starts = starts
        self._read = read
        self._order = np.argsort(starts)
        self._loaded: dict[int, PointCloud] = {}
        self._trees: dict[int, cKDTree] = {}
        self._lock = threading.Lock()

    @property
    def usual_spacing(self) -> float:
        """Of the nodes that hold most of the points: their median."""
        order = np.argsort(self.spacing)
        below = np.cumsum(self.counts[order])
        return float(self.spacing[order][np.searchsorted(below, self.total / 2.0)])

    def loaded(self) -> dict[int, PointCloud]:
        """What is there now, by row."""
        with self._lock:
            return dict(self._loaded)

    def put(self, row: int, cloud: PointCloud) -> None:
        with self._lock:
            self._loaded[row] = cloud

    def fetch(self, rows: Sequence[int]) -> list[Piece]:
        there = self.loaded()
        missing = [row for row in rows if row not in there]
        if missing:
            clouds = parts_of(self._read(missing), self.counts[missing].tolist())
            for row, cloud in zip(missing, clouds, strict=True):
                there[row] = cloud
                self.put(row, cloud)
        pieces = []
        for row in rows:
            own = np.arange(len(there[row].points))
            pieces.append(Piece(there[row], own, own + self.starts[row]))
        return pieces

    def let_go(self, row: int, piece: Piece) -> None:
        with self._lock:
            # Unless it has been read anew since.
            if self._loaded.get(row) is piece.cloud:
                del self._loaded[row]
                self._trees.pop(row, None)

    def read(self, row: int) -> PointCloud:
        """A node from the file; it is not kept. Raises InputError."""
        return self._read([row])

    def nodes_of(self, ids: IntArray) -> IntArray:
        """(k,) the row of the node that holds each point."""
        at = np.searchsorted(self.starts[self._order], ids, side="right") - 1
        return np.asarray(self._order[at], np.int64)

    def points_of(self, ids: IntArray) -> FloatArray:
        """(k, 3) float64 as in the file. What is not there is read. Raises InputError."""
        ids = np.asarray(ids, np.int64)
        out = np.empty((len(ids), 3))
        rows = self.nodes_of(ids)
        order = np.argsort(rows, kind="stable")
        cuts = np.flatnonzero(np.diff(rows[order])) + 1
        for group in np.split(order, cuts) if len(ids) else ():
            row = int(rows[group[0]])
            cloud = self._loaded.get(row) or self.read(row)
            out[group] = cloud.points[ids[group] - self.starts[row]]
        return out

    def touching(self, low: FloatArray, high: FloatArray) -> list[tuple[int, PointCloud]]:
        """The nodes that are there and whose cubes touch a box."""
        there = self.loaded()
        rows = np.fromiter(there, np.int64, len(there))
        cubes = self.bounds[rows]
        meets = ((cubes[:, 0] <= high) & (cubes[:, 1] >= low)).all(axis=1)
        return [(row, there[row]) for row in rows[meets].tolist()]

    def tree(self, row: int, cloud: PointCloud) -> cKDTree:
        found = self._trees.get(row)
        if found is None:
            from scipy.spatial import cKDTree

            found = cKDTree(cloud.points, leafsize=32, compact_nodes=False, balanced_tree=False)
            with self._lock:
                if self._loaded.get(row) is cloud:
                    self._trees[row] = found
        return found


def parents_of(keys: IntegerArray) -> IntArray:
    """(n,) rows of the nodes above those with keys (level, x, y, z) (n, 4), -1 where there is
    none."""
    rows = {tuple(key): row for row, key in enumerate(keys.tolist())}
    up = np.column_stack([keys[:, 0] - 1, keys[:, 1:] >> 1])
    return np.array([rows.get(tuple(key), -1) for key in up.tolist()], np.int64)


@dataclass(frozen=True, eq=False)
class StreamedCloud(PointCloud):
    """The first levels of a large cloud, which stand for all of it wherever a sample will do, and
    the store of its nodes."""

    store: NodeStore = field(kw_only=True)
    """Its first nodes, one after the other, are those whose points are here."""
    box: FloatArray = field(kw_only=True)

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 3) of the whole."""
        return self.box

    @property
    def count(self) -> int:
        return self.store.total

    def position(self, row: int) -> FloatArray:
        return np.asarray(self.store.points_of(np.array([row]))[0])

    def overview(self) -> PointCloud:
        return PointCloud(self.points, self.colors, self.normals, self.fields)


def parts_of(cloud: PointCloud, counts: Iterable[int]) -> list[PointCloud]:
    """A cloud in runs of so many points, which share its memory."""
    out, at = [], 0
    for count in counts:
        out.append(cloud.of_rows(slice(at, at + count)))
        at += count
    return out
