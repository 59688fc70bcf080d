"""Point clouds as octrees whose nodes are loaded and drawn only if a view needs them.

Every node contains a sparse, even sample of the points in its cube; its children add the points in
between. The id of a point is its row in the whole file. If a cloud does not fit into memory, the id
is the number of points in the preceding nodes of the file plus the row within the node. The ids
therefore do not depend on which nodes are loaded, and they equal the row numbers of the same file
read as a whole.
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
from vomstudio.geometry.progressive_order import ProgressiveOrder

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


POINT_BUDGET = 5_000_000
"""Default maximum number of points of a cloud in memory."""
FETCH_BATCH_POINTS = 50_000
"""Number of points of a file that are unpacked together. Unpacking several nodes uses several
processors, but blocks all other threads.
"""
MAX_SPACING_PIXELS = 1.5
"""Nodes are requested until the spacing of the points of their parent is below this value."""


@dataclass(frozen=True)
class CloudView:
    """View of a cloud in its file frame.

    Attributes
    ----------
    axes : (3, 3) tuple
        Rows of a rotation matrix: right, up, and the direction away from the viewer.
    half_height : float
        Tangent of half the view angle, or half the height of an orthographic view.
    pixels : int
        Height of the image, pixels.
    """

    position: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], ...]
    half_height: float
    aspect: float
    is_orthographic: bool
    near: float
    pixels: int


@dataclass(frozen=True, eq=False)
class NodePoints:
    """Points of a node: the `rows` of `cloud`, whose ids in the whole cloud are `ids`."""

    cloud: PointCloud
    rows: IntegerArray
    ids: IntegerArray


class CloudNodes:
    """Nodes of a cloud, from which those that a view needs are selected.

    Attributes
    ----------
    bounds : (n, 2, 3) ndarray
        Bounding boxes of the nodes.
    spacing : (n,) ndarray
        Distance between neighbouring points of a node.
    counts : (n,) ndarray of int
        Number of points of each node.
    parents : (n,) ndarray of int
        Row of the parent of each node, -1 if it has no parent.
    budget : int
        Maximum number of points in memory.
    first : tuple of int
        Rows of the nodes that represent the whole cloud.
    is_ordered : bool
        True if consecutive points of a node are neighbours.
    batch_points : int
        Number of points that are fetched in one batch.
    """

    is_ordered = False
    batch_points = 0

    def __init__(
        self,
        bounds: FloatArray,
        spacing: FloatArray,
        counts: IntArray,
        parents: IntArray,
        max_points: int,
        first: tuple[int, ...],
    ) -> None:
        self.bounds, self.spacing, self.counts = bounds, spacing, counts
        self.parents, self.budget, self.first = parents, max_points, first
        self.point_count = int(counts.sum())

    def __len__(self) -> int:
        return len(self.counts)

    def fetch(self, rows: Sequence[int]) -> list[NodePoints]:
        """Return the points of nodes.

        Raises
        ------
        InputError
            If a node cannot be read.
        """
        raise NotImplementedError

    def release(self, row: int, piece: NodePoints) -> None:
        """Release a fetched node."""

    def select_nodes(self, view: CloudView, max_points: int) -> IntArray:
        """Select the nodes needed to draw a view, most important first.

        These are the visible nodes that have no parent, or whose parents' points are more than
        MAX_SPACING_PIXELS apart, up to `max_points` points.
        """
        position = np.array(view.position)
        low, high = self.bounds[:, 0], self.bounds[:, 1]
        q = ((low + high) / 2.0 - position) @ np.array(view.axes).T
        radius = np.linalg.norm(high - low, axis=1) / 2.0
        offsets = np.maximum(np.maximum(low - position, position - high), 0.0)
        distance = np.maximum(np.sqrt(np.einsum("ij,ij->i", offsets, offsets)), view.near)
        max_distance = np.ones(len(self)) if view.is_orthographic else distance
        spacing_pixels = 2.0 * self.spacing * view.pixels / (2.0 * view.half_height * max_distance)
        half_width = view.half_height * (1.0 if view.is_orthographic else np.maximum(q[:, 2], 0.0))
        # The side planes of a perspective view are inclined, so a ball extends further across them.
        vertical_slope = 1.0 if view.is_orthographic else np.hypot(1.0, view.half_height)
        horizontal_slope = (
            1.0 if view.is_orthographic else np.hypot(1.0, view.half_height * view.aspect)
        )
        is_visible = (
            (np.abs(q[:, 1]) <= half_width + radius * vertical_slope)
            & (np.abs(q[:, 0]) <= half_width * view.aspect + radius * horizontal_slope)
            & (q[:, 2] + radius > 0.0)
        )
        rows = np.flatnonzero(
            is_visible & ((spacing_pixels > MAX_SPACING_PIXELS) | (self.parents < 0))
        )
        rows = rows[np.lexsort((-self.spacing[rows], -spacing_pixels[rows]))]
        return np.asarray(rows[np.cumsum(self.counts[rows]) <= max_points])

    def closing_spacings(self, rows: IntArray) -> dict[int, float]:
        """Return the spacing at which the points of the displayed nodes cover the surface.

        For each node, this is the finest spacing among the displayed nodes below it.
        """
        finest = dict(zip(rows.tolist(), self.spacing[rows].tolist(), strict=True))
        for row in sorted(finest, key=lambda r: float(self.spacing[r])):
            parent = int(self.parents[row])
            if parent in finest:
                finest[parent] = min(finest[parent], finest[row])
        return finest


class ArrangedNodes(CloudNodes):
    """Nodes of a cloud in memory."""

    is_ordered = True

    def __init__(self, cloud: PointCloud, arrangement: ProgressiveOrder, max_points: int) -> None:
        self._cloud, self._arrangement = cloud, arrangement
        super().__init__(
            arrangement.bounds,
            arrangement.spacing,
            np.diff(arrangement.starts),
            arrangement.parents,
            max_points,
            tuple(np.flatnonzero(arrangement.parents < 0).tolist()),
        )

    def fetch(self, rows: Sequence[int]) -> list[NodePoints]:
        starts, order = self._arrangement.starts, self._arrangement.rows
        points = [order[starts[row] : starts[row + 1]] for row in rows]
        return [NodePoints(self._cloud, point_rows, point_rows) for point_rows in points]


class NodeStore(CloudNodes):
    """Store of the loaded nodes of a file, usable from any thread.

    Parameters
    ----------
    bounds, spacing, counts, parents, max_points, first
        See `CloudNodes`; `max_points` is the budget.
    starts : (n,) ndarray of int
        Index in the file of the first point of each node.
    read : callable
        Function that reads the points of nodes in the given order; raises InputError if this fails.
    """

    batch_points = FETCH_BATCH_POINTS

    def __init__(
        self,
        bounds: FloatArray,
        spacing: FloatArray,
        counts: IntArray,
        starts: IntArray,
        parents: IntArray,
        read: Callable[[Sequence[int]], PointCloud],
        max_points: int,
        first: tuple[int, ...],
    ) -> None:
        super().__init__(bounds, spacing, counts, parents, max_points, first)
        self.starts = starts
        self._read = read
        self._order = np.argsort(starts)
        self._loaded: dict[int, PointCloud] = {}
        self._trees: dict[int, cKDTree] = {}
        self._lock = threading.Lock()

    @property
    def median_spacing(self) -> float:
        """Median spacing of the nodes, weighted by their number of points."""
        order = np.argsort(self.spacing)
        cumulative_counts = np.cumsum(self.counts[order])
        return float(
            self.spacing[order][np.searchsorted(cumulative_counts, self.point_count / 2.0)]
        )

    def loaded_nodes(self) -> dict[int, PointCloud]:
        """Return the loaded nodes, keyed by row."""
        with self._lock:
            return dict(self._loaded)

    def store_node(self, row: int, cloud: PointCloud) -> None:
        with self._lock:
            self._loaded[row] = cloud

    def fetch(self, rows: Sequence[int]) -> list[NodePoints]:
        loaded_nodes = self.loaded_nodes()
        missing_rows = [row for row in rows if row not in loaded_nodes]
        if missing_rows:
            clouds = split_cloud(self._read(missing_rows), self.counts[missing_rows].tolist())
            for row, cloud in zip(missing_rows, clouds, strict=True):
                loaded_nodes[row] = cloud
                self.store_node(row, cloud)
        pieces = []
        for row in rows:
            point_rows = np.arange(len(loaded_nodes[row].points))
            pieces.append(NodePoints(loaded_nodes[row], point_rows, point_rows + self.starts[row]))
        return pieces

    def release(self, row: int, piece: NodePoints) -> None:
        with self._lock:
            # Keep a node that has been read again in the meantime.
            if self._loaded.get(row) is piece.cloud:
                del self._loaded[row]
                self._trees.pop(row, None)

    def read(self, row: int) -> PointCloud:
        """Read a node from the file without storing it.

        Raises
        ------
        InputError
            If the node cannot be read.
        """
        return self._read([row])

    def node_rows(self, ids: IntArray) -> IntArray:
        """Return the row (k,) of the node that contains each point."""
        index = np.searchsorted(self.starts[self._order], ids, side="right") - 1
        return np.asarray(self._order[index], np.int64)

    def points_of(self, ids: IntArray) -> FloatArray:
        """Return the coordinates (k, 3) of points as float64; nodes not loaded are read.

        Raises
        ------
        InputError
            If a node cannot be read.
        """
        ids = np.asarray(ids, np.int64)
        points = np.empty((len(ids), 3))
        rows = self.node_rows(ids)
        order = np.argsort(rows, kind="stable")
        cuts = np.flatnonzero(np.diff(rows[order])) + 1
        for group in np.split(order, cuts) if len(ids) else ():
            row = int(rows[group[0]])
            cloud = self._loaded.get(row) or self.read(row)
            points[group] = cloud.points[ids[group] - self.starts[row]]
        return points

    def find_touching_nodes(
        self, low: FloatArray, high: FloatArray
    ) -> list[tuple[int, PointCloud]]:
        """Return the loaded nodes whose cubes touch a box."""
        loaded_nodes = self.loaded_nodes()
        rows = np.fromiter(loaded_nodes, np.int64, len(loaded_nodes))
        cubes = self.bounds[rows]
        is_touching = ((cubes[:, 0] <= high) & (cubes[:, 1] >= low)).all(axis=1)
        return [(row, loaded_nodes[row]) for row in rows[is_touching].tolist()]

    def tree(self, row: int, cloud: PointCloud) -> cKDTree:
        tree = self._trees.get(row)
        if tree is None:
            from scipy.spatial import cKDTree

            tree = cKDTree(cloud.points, leafsize=32, compact_nodes=False, balanced_tree=False)
            with self._lock:
                if self._loaded.get(row) is cloud:
                    self._trees[row] = tree
        return tree


def parent_rows(keys: IntegerArray) -> IntArray:
    """Return the rows of the parent nodes.

    Parameters
    ----------
    keys : (n, 4) ndarray of int
        Level, x, y and z of each node.

    Returns
    -------
    (n,) ndarray of int
        Row of the parent of each node, -1 if it has no parent.
    """
    rows = {tuple(key): row for row, key in enumerate(keys.tolist())}
    parent_keys = np.column_stack([keys[:, 0] - 1, keys[:, 1:] >> 1])
    return np.array([rows.get(tuple(key), -1) for key in parent_keys.tolist()], np.int64)


@dataclass(frozen=True, eq=False)
class StreamedCloud(PointCloud):
    """First levels of a large cloud, a sample that represents the whole cloud.

    The store contains all nodes of the cloud.
    """

    store: NodeStore = field(kw_only=True)
    """Store of all nodes. This cloud contains the points of its first nodes, in order."""
    box: FloatArray = field(kw_only=True)

    @cached_property
    def bounds(self) -> FloatArray:
        """Bounding box (2, 3) of the whole cloud."""
        return self.box

    @property
    def count(self) -> int:
        return self.store.point_count

    def position(self, row: int) -> FloatArray:
        return np.asarray(self.store.points_of(np.array([row]))[0])

    def overview(self) -> PointCloud:
        return PointCloud(self.points, self.colors, self.normals, self.fields)


def split_cloud(cloud: PointCloud, counts: Iterable[int]) -> list[PointCloud]:
    """Split a cloud into runs of consecutive points, which share its memory.

    Parameters
    ----------
    cloud : PointCloud
    counts : iterable of int
        Number of points of each run.

    Returns
    -------
    list of PointCloud
    """
    clouds, start = [], 0
    for count in counts:
        clouds.append(cloud.select_rows(slice(start, start + count)))
        start += count
    return clouds
