"""The nodes of a streamed cloud that the present view needs, read in a thread of its own.

The scene tells the streamer what is seen; the streamer tells the scene which nodes to show, hands
over those that it has read, and takes back those that were not needed for longest, so that no more
points are there than the budget allows.
"""

from __future__ import annotations

import threading

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vomstudio.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.octree import StreamedCloud, View
from vomstudio.rendering import blocks, vtkdata
from vomstudio.rendering.blocks import PointChunk
from vomstudio.rendering.camera import Camera, Eye
from vomstudio.rendering.preparation import (
    ChunksDone,
    Emit,
    LocatorReady,
    NodeReady,
    NodesDropped,
    NodesShown,
    Problem,
    Stopped,
    StreamStarted,
    TexturesDone,
    coloring,
)

Array = npt.NDArray[np.float64]

SHOWN_SHARE = 0.5
"""Of the points that may be there, so many are shown at most: the rest is what was seen before."""
MOST_SHOWN = 3_000_000


def view_of(
    eye: Eye, camera: Camera, size: tuple[int, int], to_world: Array, from_world: Array
) -> View:
    """What the eye sees, in the file's frame."""
    linear = to_world[:3, :3]
    scale = float(np.cbrt(abs(np.linalg.det(linear)))) or 1.0
    position = from_world[:3, :3] @ eye.position + from_world[:3, 3]
    axes = np.stack([eye.right, eye.up, eye.direction]) @ linear / scale
    half = eye.half_height / scale if eye.orthographic else eye.half_height
    # A little nearer than anything will ever be seen from: the true near plane moves with what is
    # loaded.
    near = max(1e-3 * camera.distance, 1e-6) / scale
    return View(
        tuple(position.tolist()),
        tuple(tuple(row) for row in axes.tolist()),
        float(half),
        size[0] / max(size[1], 1),
        eye.orthographic,
        near,
        size[1],
    )


class Streamer(threading.Thread):
    """Runs until `stop` is set."""

    def __init__(
        self, cloud: StreamedCloud, origin: Array, stop: threading.Event, emit: Emit
    ) -> None:
        super().__init__(name="cloud stream", daemon=True)
        self._cloud, self._store, self._origin = cloud, cloud.store, origin
        self._stopped, self._emit = stop, emit
        self._colors = coloring(cloud.overview())
        self._wake = threading.Event()
        self._view: View | None = None
        self._seen: View | None = None
        self._shown: tuple[int, ...] = ()
        self._handed: dict[int, PointCloud] = {}
        self._used: dict[int, int] = {}
        self._turn = 0
        self._broken: set[int] = set()
        self._said = False
        self.idle = False
        """Everything that the last view needs is there."""

    def look(self, view: View) -> None:
        """The viewer has moved; may be called from any thread."""
        if view != self._view:
            self.idle = False
            self._view = view
            self._wake.set()

    def begin(self) -> None:
        """Hand over the overview, and go on in a thread."""
        self._emit(StreamStarted(self))
        for row in self._cloud.overview_rows:
            cloud = self._store.held(row)
            if cloud is None:
                # A window of another project has let it go.
                cloud = self._store.read(row)
                self._store.put(row, cloud)
            self._hand_over(row, cloud)
        self._emit(NodesShown(self._cloud.overview_rows, self._closing(self._cloud.overview_rows)))
        self._emit(ChunksDone(len(self._cloud.overview_rows)))
        self._emit(TexturesDone())
        self._emit(LocatorReady([]))
        self.start()

    def run(self) -> None:
        try:
            while not self._stopped.is_set():
                if self._wake.wait(0.2):
                    self._wake.clear()
                    self._follow()
        except Stopped:
            pass
        except Exception as error:  # noqa: BLE001 - a thread has nobody above it to tell
            self._say(f"Nothing more of a cloud can be shown: {error}")

    def _follow(self) -> None:
        view = self._view
        if view is None or view == self._seen:
            self.idle = True
            return
        most = min(int(self._store.budget * SHOWN_SHARE), MOST_SHOWN)
        rows = self._store.choose(view, most)
        rows = rows[[row not in self._broken for row in rows.tolist()]]
        shown = tuple(rows.tolist())
        self._turn += 1
        self._used.update(dict.fromkeys(shown, self._turn))
        if shown != self._shown:
            self._shown = shown
            self._emit(NodesShown(shown, self._closing(shown)))
        for row in shown:
            if self._stopped.is_set() or self._view is not view:
                return
            if row in self._handed or row in self._broken:
                continue
            self._make_room(int(self._store.counts[row]))
            try:
                cloud = self._store.read(row)
            except InputError as error:
                self._broken.add(row)
                if not self._said:
                    self._said = True
                    self._say(f"A part of a cloud is not shown. {error}")
                continue
            self._store.put(row, cloud)
            self._hand_over(row, cloud)
        self._seen = view
        self.idle = self._view is view

    def _closing(self, rows: tuple[int, ...]) -> dict[int, float]:
        spacing = self._store.closing(np.array(rows, np.int64))
        return dict(zip(rows, spacing.tolist(), strict=True))

    def _make_room(self, wanted: int) -> None:
        there = sum(int(self._store.counts[row]) for row in self._handed)
        if there + wanted <= self._store.budget:
            return
        dropped: dict[int, PointCloud] = {}
        kept = set(self._cloud.overview_rows)
        oldest = sorted(
            (r for r in self._handed if r not in kept), key=lambda r: self._used.get(r, 0)
        )
        for row in oldest:
            if there + wanted <= self._store.budget or self._used.get(row) == self._turn:
                break
            dropped[row] = self._handed.pop(row)
            there -= int(self._store.counts[row])
        if dropped:
            self._emit(NodesDropped(dropped, self._store))

    def _hand_over(self, row: int, cloud: PointCloud) -> None:
        self._emit(NodeReady(*self._chunk(row, cloud), row, cloud))
        self._handed[row] = cloud

    def _chunk(self, row: int, cloud: PointCloud) -> tuple[PointChunk, vtkPolyData, float]:
        at = (cloud.points - self._origin).astype(np.float32)
        low, high = at.min(axis=0), at.max(axis=0)
        order = np.argsort(blocks.morton(at, low, float((high - low).max()) or 1.0))
        at = at[order]
        boxes = blocks.block_boxes(at, at, blocks.POINTS_PER_BLOCK)
        data = vtkdata.point_set(at, self._colors(cloud, order))
        chunk = PointChunk(at, order + self._store.starts[row], boxes)
        return chunk, data, float(self._store.spacing[row])

    def _say(self, text: str) -> None:
        try:
            self._emit(Problem(text))
        except Stopped:
            return
