"""What the scene knows of a model and of the actors that it is drawn with."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from vtkmodules.vtkCommonCore import vtkDataArray
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator
from vtkmodules.vtkRenderingCore import vtkActor

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntegerArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import Piece, StreamedCloud
from vomstudio.rendering.prepare.events import FieldReady, NodeStream
from vomstudio.rendering.scene.gpu_textures import Skin
from vomstudio.rendering.view.spatial_blocks import FaceChunk, PointChunk


@dataclass(eq=False)
class Part:
    """One actor of a model and what is known about drawing it."""

    actor: vtkActor
    low: FloatArray
    high: FloatArray
    elements: int
    material: int = -1
    density: float = 0.0
    has_uv: bool = False
    spacing: float = 0.0
    """Metres between neighbouring points of a cloud; 0 for a mesh."""
    has_colors: bool = False
    uploaded: bool = False
    weight: float = 1.0
    """Cost of drawing an element, against one of least cost."""
    rows: IntegerArray = field(default_factory=lambda: np.zeros(0, np.int32))
    """The model's vertices or points that are drawn, in order."""
    own: vtkDataArray | None = None
    """Its own colours while those of a field are shown."""
    tinted: bool = False
    """The colours of a field are shown."""
    whole: Int32Array | None = None
    """Of a stand-in, all its triangles, while some may be left out."""
    row: int = -1
    """Of a node of a cloud."""
    piece: Piece | None = None
    """What that node is made of."""


@dataclass(eq=False)
class ModelScene:
    """What is drawn of one model. `low` and `high` bound it in its local frame."""

    model_id: str
    data: Mesh | PointCloud
    origin: FloatArray
    low: FloatArray
    high: FloatArray
    to_world: FloatArray
    from_world: FloatArray
    visible: bool = True
    parts: list[Part] = field(default_factory=list)
    proxies: list[Part] = field(default_factory=list)
    face_chunks: list[FaceChunk] = field(default_factory=list)
    point_chunks: list[PointChunk] = field(default_factory=list)
    skins: dict[int, Skin] = field(default_factory=dict)
    locators: list[vtkStaticCellLocator] = field(default_factory=list)
    streamer: NodeStream | None = None
    shown_rows: dict[int, float] = field(default_factory=dict)
    """Nodes of a cloud that the view needs, and the spacing that their points close now."""
    needed: dict[int, float] = field(default_factory=dict)
    """The same once all of them are there, for the last view that they were fetched for."""
    settled: bool = True
    """All of these are there."""
    chunks_done: bool = False
    textures_done: bool = False
    hidden: BoolArray | None = None
    """Which faces or points are not drawn and not picked."""
    field: FieldReady | None = None
    """The field's colours that the model has been given."""
    _boxes: tuple[FloatArray, FloatArray] | None = None

    def drop(self, rows: Iterable[int]) -> list[Part]:
        """Forget nodes of a cloud; their parts."""
        gone = set(rows)
        kept = [k for k, part in enumerate(self.parts) if part.row not in gone]
        dropped = [part for part in self.parts if part.row in gone]
        self.point_chunks = [self.point_chunks[k] for k in kept]
        self.parts = [self.parts[k] for k in kept]
        self._boxes = None
        return dropped

    def chunk_boxes(self) -> tuple[FloatArray, FloatArray]:
        """Corners (n, 3), (n, 3) of the chunks' boxes in the local frame."""
        if self._boxes is None or len(self._boxes[0]) != len(self.parts):
            self._boxes = (
                np.stack([p.low for p in self.parts]),
                np.stack([p.high for p in self.parts]),
            )
        return self._boxes

    def corners_world(self, *, close: bool = False) -> FloatArray:
        """(n, 3) corners in World of the model's box, or (close) of the boxes of its chunks once
        they are there, which lie nearer to the surface."""
        low, high = self.low[None], self.high[None]
        streamed = isinstance(self.data, StreamedCloud)
        if close and self.chunks_done and self.parts and not streamed:
            low, high = self.chunk_boxes()
        grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        local = np.where(grid[None] == 1, high[:, None], low[:, None]).reshape(-1, 3)
        file = local + self.origin
        return np.asarray(file @ self.to_world[:3, :3].T + self.to_world[:3, 3])
