"""Results that the workers hand over incrementally to the drawing thread.

After that, only the drawing thread may use them. VTK is not imported here, because the window
uses these classes before VTK is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from vomstudio.core.arrays import FloatArray, Int32Array
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import CloudNodes, CloudView, NodePoints
from vomstudio.rendering.prepare.textures import Texture
from vomstudio.rendering.view.scalars import FieldStyle, Scale
from vomstudio.rendering.view.spatial_blocks import FaceChunk, PointChunk

if TYPE_CHECKING:
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator


class Stopped(Exception):
    """Raised in a worker whose model has been removed."""


@dataclass(frozen=True, eq=False)
class ModelBounds:
    """Bounds (2, 3) of a model in its file frame."""

    data: Mesh | PointCloud
    bounds: FloatArray
    origin: FloatArray


@dataclass(frozen=True, eq=False)
class ProxyReady:
    """Simplified mesh that is drawn while the camera moves.

    `rows` contains the mesh vertex that corresponds to each point of `data`.
    """

    data: vtkPolyData
    rows: Int32Array


@dataclass(frozen=True, eq=False)
class MeshChunkReady:
    """Chunk of a mesh that is ready for drawing."""

    chunk: FaceChunk
    data: vtkPolyData
    uv_per_metre: float


@dataclass(frozen=True, eq=False)
class NodeReady:
    """Node of a cloud; `piece` contains its points in the order of `data`."""

    chunk: PointChunk
    data: vtkPolyData
    spacing: float
    """Distance between neighbouring points in the file frame, metres."""
    row: int
    piece: NodePoints


@dataclass(frozen=True, eq=False)
class NodesDropped:
    """Nodes that are no longer needed; their actors are removed once they are off screen."""

    pieces: dict[int, NodePoints]
    nodes: CloudNodes


class NodeStream(Protocol):
    """Stream of the nodes of a cloud, for the window's thread; see `Streamer`."""

    request_number: int
    """Number of the last view that required different nodes."""

    def needed_nodes(self, view: CloudView) -> dict[int, float]: ...

    def closing(self, rows: list[int]) -> dict[int, float]: ...

    def look(self, view: CloudView) -> dict[int, float] | None: ...


@dataclass(frozen=True, eq=False)
class StreamStarted:
    """Event after all nodes for an overview of a cloud have been handed over."""

    streamer: NodeStream


@dataclass(frozen=True)
class ViewDone:
    """Event after all nodes that were requested with this number have been handed over."""

    request_number: int


@dataclass(frozen=True)
class ChunksDone:
    """Event after the last chunk, with the number of chunks."""

    count: int


@dataclass(frozen=True, eq=False)
class TextureReady:
    """Texture of a material."""

    material: int
    texture: Texture | None
    """Decoded texture, or None if the file could not be read."""


@dataclass(frozen=True)
class TexturesDone:
    """Event after all textures have been handed over."""


@dataclass(frozen=True, eq=False)
class LocatorReady:
    """Cell locators of a model."""

    locators: list[vtkStaticCellLocator]
    """One locator per chunk of a mesh, in order; empty for a cloud."""


@dataclass(frozen=True)
class Problem:
    """Finding that is reported to the user."""

    finding: Finding


@dataclass(frozen=True, eq=False)
class FieldReady:
    """Colours of a model's field: one array per proxy and per chunk, in their order."""

    style: FieldStyle
    scale: Scale
    proxies: list[vtkUnsignedCharArray]
    parts: list[vtkUnsignedCharArray]


Event = (
    ModelBounds
    | ProxyReady
    | MeshChunkReady
    | NodeReady
    | NodesDropped
    | StreamStarted
    | ViewDone
    | ChunksDone
    | TextureReady
    | TexturesDone
    | LocatorReady
    | Problem
    | FieldReady
)
Emit = Callable[[Event], None]
Submit = Callable[[Callable[[], None]], object]
"""Callable that schedules jobs, which run one after another."""
