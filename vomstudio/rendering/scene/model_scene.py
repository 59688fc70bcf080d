"""State of a model in the scene, with its actors."""

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
from vomstudio.geometry.streaming.octree import NodePoints, StreamedCloud
from vomstudio.rendering.prepare.events import FieldReady, NodeStream
from vomstudio.rendering.scene.gpu_textures import GpuTexture
from vomstudio.rendering.view.spatial_blocks import FaceChunk, PointChunk


@dataclass(eq=False)
class Part:
    """Actor that draws a part of a model, with the properties required for drawing."""

    actor: vtkActor
    low: FloatArray
    high: FloatArray
    elements: int
    material: int = -1
    density: float = 0.0
    has_uv: bool = False
    spacing: float = 0.0
    """Distance between neighbouring points of a cloud, metres; 0 for a mesh."""
    has_colors: bool = False
    is_uploaded: bool = False
    weight: float = 1.0
    """Relative cost of drawing an element."""
    rows: IntegerArray = field(default_factory=lambda: np.zeros(0, np.int32))
    """Rows of the drawn vertices or points of the model, in order of drawing."""
    point_scalars: vtkDataArray | None = None
    """Original colours of the part while field colours are shown."""
    is_tinted: bool = False
    """Whether field colours are shown."""
    all_triangles: Int32Array | None = None
    """All triangles of a proxy, including hidden ones."""
    row: int = -1
    """Row of the node if the part is a node of a cloud."""
    piece: NodePoints | None = None
    """Points of the node if the part is a node of a cloud."""
    offset: float = 0.0
    """Increase of the depth-buffer values by which the part is pushed back."""
    source: Part | None = None
    """Part of another scene whose data this part shares."""


@dataclass(eq=False)
class ModelScene:
    """Parts of a model in the scene, bounded by `low` and `high` in the local frame."""

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
    gpu_textures: dict[int, GpuTexture] = field(default_factory=dict)
    locators: list[vtkStaticCellLocator] = field(default_factory=list)
    streamer: NodeStream | None = None
    shown_rows: dict[int, float] = field(default_factory=dict)
    """Nodes of a cloud that are required for the view, with their present spacing."""
    needed_nodes: dict[int, float] = field(default_factory=dict)
    """Nodes required for the last view for which nodes were fetched, with their final spacing."""
    is_settled: bool = True
    """Whether all required nodes are present."""
    has_all_chunks: bool = False
    has_all_textures: bool = False
    hidden: BoolArray | None = None
    """Faces or points that are neither drawn nor picked."""
    field: FieldReady | None = None
    """Colours of the model's field."""
    _boxes: tuple[FloatArray, FloatArray] | None = None

    def drop(self, rows: Iterable[int]) -> list[Part]:
        """Remove nodes of a cloud, and return their parts."""
        dropped_rows = set(rows)
        kept_indices = [k for k, part in enumerate(self.parts) if part.row not in dropped_rows]
        dropped_parts = [part for part in self.parts if part.row in dropped_rows]
        self.point_chunks = [self.point_chunks[k] for k in kept_indices]
        self.parts = [self.parts[k] for k in kept_indices]
        self.forget_boxes()
        return dropped_parts

    def forget_boxes(self) -> None:
        """Discard the boxes of the chunks because the parts have changed."""
        self._boxes = None

    def chunk_boxes(self) -> tuple[FloatArray, FloatArray]:
        """Return the minimum and maximum corners, (n, 3) each, of the chunks in the local frame."""
        if self._boxes is None or len(self._boxes[0]) != len(self.parts):
            self._boxes = (
                np.stack([p.low for p in self.parts]),
                np.stack([p.high for p in self.parts]),
            )
        return self._boxes

    def corners_world(self, *, is_closed: bool = False) -> FloatArray:
        """Return the box corners (n, 3) of the model in the World frame.

        If `is_closed`, these are the corners of its chunks, if present, which are closer to the
        surface.
        """
        low, high = self.low[None], self.high[None]
        is_streamed = isinstance(self.data, StreamedCloud)
        if is_closed and self.has_all_chunks and self.parts and not is_streamed:
            low, high = self.chunk_boxes()
        grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        local_points = np.where(grid[None] == 1, high[:, None], low[:, None]).reshape(-1, 3)
        file = local_points + self.origin
        return np.asarray(file @ self.to_world[:3, :3].T + self.to_world[:3, 3])
