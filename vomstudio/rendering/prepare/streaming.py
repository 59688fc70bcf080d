"""Background streaming of the cloud nodes that are required for the current view.

The scene passes the view to the streamer and receives the list of required nodes. The streamer
hands over the missing nodes. To stay within the point budget, it drops the least recently used
nodes. It is idle once a view is complete.
"""

from __future__ import annotations

import threading

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, VomError
from vomstudio.core.failures.error_collector import ERRORS
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.streaming.octree import CloudNodes, CloudView, NodePoints, StreamedCloud
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.prepare.cloud_colors import make_coloring
from vomstudio.rendering.prepare.events import (
    ChunksDone,
    Emit,
    LocatorReady,
    NodeReady,
    NodesDropped,
    Problem,
    Stopped,
    StreamStarted,
    Submit,
    TexturesDone,
    ViewDone,
)
from vomstudio.rendering.view import spatial_blocks
from vomstudio.rendering.view.camera import Camera, Eye
from vomstudio.rendering.view.spatial_blocks import PointChunk

MAX_SHOWN_SHARE = 0.5
"""Maximum share of the point budget that is drawn; the remainder caches nodes of earlier views."""
MAX_SHOWN_POINTS = 3_000_000


def cloud_view(
    eye: Eye, camera: Camera, size: tuple[int, int], to_world: FloatArray, from_world: FloatArray
) -> CloudView:
    """Transform the view of an eye to the file frame of a cloud."""
    linear_part = to_world[:3, :3]
    scale = float(np.cbrt(abs(np.linalg.det(linear_part)))) or 1.0
    position = from_world[:3, :3] @ eye.position + from_world[:3, 3]
    axes = np.stack([eye.right, eye.up, eye.direction]) @ linear_part / scale
    half_height = eye.half_height / scale if eye.orthographic else eye.half_height
    # The near plane is closer than any realistic view, because the true near plane depends on
    # the loaded nodes.
    near_depth = max(1e-3 * camera.distance, 1e-6) / scale
    return CloudView(
        tuple(position.tolist()),
        tuple(tuple(row) for row in axes.tolist()),
        float(half_height),
        size[0] / max(size[1], 1),
        eye.orthographic,
        near_depth,
        size[1],
    )


class Streamer:
    """Streamer of the nodes of a cloud.

    `begin` and submitted jobs run one after another in a background thread. All other methods
    run in the window's thread.
    """

    def __init__(
        self,
        cloud: PointCloud,
        nodes: CloudNodes,
        origin: FloatArray,
        stop_event: threading.Event,
        emit: Emit,
        submit: Submit,
    ) -> None:
        self._nodes, self._origin = nodes, origin
        self._stop_event, self._emit, self._submit = stop_event, emit, submit
        sample = cloud.overview() if isinstance(cloud, StreamedCloud) else cloud
        self._colors = make_coloring(sample)
        self._view: CloudView | None = None
        self._requested_rows: tuple[int, ...] = ()
        self._fetched_nodes: dict[int, NodePoints] = {}
        self._last_requests: dict[int, int] = {}
        self._unreadable_rows: set[int] = set()
        self.request_number = 0
        """Number of the last view that required different nodes."""

    def begin(self) -> None:
        """Hand over the nodes for an overview."""
        for row, piece in zip(self._nodes.first, self._nodes.fetch(self._nodes.first), strict=True):
            self._hand_over(row, piece)
        self._emit(StreamStarted(self))
        self._emit(ChunksDone(len(self._nodes.first)))
        self._emit(TexturesDone())
        self._emit(LocatorReady([]))

    def needed_nodes(self, view: CloudView) -> dict[int, float]:
        """Return the required nodes of a view, most important first, with their spacing.

        At this point spacing, a node and the other required nodes together appear as a closed
        surface.
        """
        max_points = min(int(self._nodes.budget * MAX_SHOWN_SHARE), MAX_SHOWN_POINTS)
        rows = self._nodes.select_nodes(view, max_points)
        if self._unreadable_rows:
            rows = rows[[row not in self._unreadable_rows for row in rows.tolist()]]
        return self._nodes.closing_spacings(rows)

    def closing(self, rows: list[int]) -> dict[int, float]:
        """Return the spacing, as `needed_nodes` does, for given nodes."""
        return self._nodes.closing_spacings(np.array(rows, np.int64))

    def look(self, view: CloudView) -> dict[int, float] | None:
        """Request and return the required nodes, or return None if the view is unchanged.

        After all nodes have been handed over, a `ViewDone` event with `request_number` follows.
        """
        if view == self._view:
            return None
        self._view = view
        needed_nodes = self.needed_nodes(view)
        rows = tuple(needed_nodes)
        if rows != self._requested_rows:
            self._requested_rows = rows
            self.request_number += 1
            request_number = self.request_number
            self._submit(lambda: self._follow(rows, request_number))
        return needed_nodes

    def _follow(self, rows: tuple[int, ...], request_number: int) -> None:
        try:
            self._last_requests.update(dict.fromkeys(rows, request_number))
            missing_rows = [
                row
                for row in rows
                if row not in self._fetched_nodes and row not in self._unreadable_rows
            ]
            while missing_rows:
                if request_number != self.request_number:
                    return
                if self._stop_event.is_set():
                    raise Stopped
                points = np.cumsum(self._nodes.counts[missing_rows])
                count = max(1, int(np.searchsorted(points, self._nodes.batch_points, side="right")))
                self._drop_nodes(int(points[count - 1]), request_number)
                self._fetch(missing_rows[:count])
                missing_rows = missing_rows[count:]
            self._emit(ViewDone(request_number))
        except Stopped:
            pass
        except Exception as error:  # noqa: BLE001 - a thread has no caller to handle the error
            if not isinstance(error, VomError):
                ERRORS.report(error, "while points of a cloud were read")
            try:
                self._emit(Problem(Finding("display.points-missing", reason=str(error))))
                self._emit(ViewDone(request_number))
            except Stopped:
                pass

    def _fetch(self, rows: list[int]) -> None:
        try:
            pieces = self._nodes.fetch(rows)
        except InputError as error:
            if len(rows) > 1:
                for row in rows:
                    self._fetch([row])
                return
            if not self._unreadable_rows:
                self._emit(Problem(Finding("display.part-missing", reason=str(error))))
            self._unreadable_rows.add(rows[0])
            return
        for row, piece in zip(rows, pieces, strict=True):
            self._hand_over(row, piece)

    def _drop_nodes(self, requested_points: int, request_number: int) -> None:
        point_count = sum(int(self._nodes.counts[row]) for row in self._fetched_nodes)
        kept_rows = set(self._nodes.first)
        dropped_nodes: dict[int, NodePoints] = {}
        for row in sorted(
            self._fetched_nodes.keys() - kept_rows, key=lambda r: self._last_requests.get(r, 0)
        ):
            if (
                point_count + requested_points <= self._nodes.budget
                or self._last_requests.get(row) == request_number
            ):
                break
            dropped_nodes[row] = self._fetched_nodes.pop(row)
            point_count -= int(self._nodes.counts[row])
        if dropped_nodes:
            self._emit(NodesDropped(dropped_nodes, self._nodes))

    def _hand_over(self, row: int, piece: NodePoints) -> None:
        rows, ids = piece.rows, piece.ids
        position = (piece.cloud.points.take(rows, axis=0) - self._origin).astype(np.float32)
        if not self._nodes.is_ordered:
            low, high = position.min(axis=0), position.max(axis=0)
            order = np.argsort(
                spatial_blocks.morton(position, low, float((high - low).max()) or 1.0)
            )
            position, rows, ids = position[order], rows[order], ids[order]
        boxes = spatial_blocks.block_boxes(position, position, spatial_blocks.POINTS_PER_BLOCK)
        chunk = PointChunk(position, ids, boxes)
        data = vtk_data.point_set(position, self._colors(piece.cloud, rows))
        spacing = float(self._nodes.spacing[row])
        self._emit(NodeReady(chunk, data, spacing, row, NodePoints(piece.cloud, rows, ids)))
        self._fetched_nodes[row] = piece
