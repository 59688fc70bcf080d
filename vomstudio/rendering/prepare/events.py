"""Results of the workers, which are handed over to the drawing thread piece by piece.

From then on only that thread uses them. VTK is not imported here, because the window uses these
classes before VTK is loaded.
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
    """The bounds (2, 3) of a model in its file frame are known."""

    data: Mesh | PointCloud
    bounds: FloatArray
    origin: FloatArray


@dataclass(frozen=True, eq=False)
class ProxyReady:
    """Simplified mesh that is drawn while the camera moves.

    `rows` contains the vertex of the mesh for each point of `data`.
    """

    data: vtkPolyData
    rows: Int32Array


@dataclass(frozen=True, eq=False)
class MeshChunkReady:
    """Chunk of a mesh, ready for drawing."""

    chunk: FaceChunk
    data: vtkPolyData
    texels_per_metre: float


@dataclass(frozen=True, eq=False)
class NodeReady:
    """Node of a cloud, with its points as `piece` in the order of `data`."""

    chunk: PointChunk
    data: vtkPolyData
    spacing: float
    """Metres between neighbours, in the file's frame."""
    row: int
    piece: NodePoints


@dataclass(frozen=True, eq=False)
class NodesDropped:
    """Nodes that are no longer needed; their actors are removed when they are off the screen."""

    pieces: dict[int, NodePoints]
    nodes: CloudNodes


class NodeStream(Protocol):
    """Fetches the nodes of a cloud in the background, see `Streamer`. For the window's thread."""

    turn: int
    """Number of the last view that needed other nodes."""

    def needed(self, view: CloudView) -> dict[int, float]: ...

    def closing(self, rows: list[int]) -> dict[int, float]: ...

    def look(self, view: CloudView) -> dict[int, float] | None: ...


@dataclass(frozen=True, eq=False)
class StreamStarted:
    """The nodes for an overview of a cloud have been handed over."""

    streamer: NodeStream


@dataclass(frozen=True)
class ViewDone:
    """All nodes requested under this number have been handed over."""

    turn: int


@dataclass(frozen=True)
class ChunksDone:
    """Number of chunks, after the last one."""

    count: int


@dataclass(frozen=True, eq=False)
class TextureReady:
    """Texture of a material."""

    material: int
    texture: Texture | None
    """None if it could not be read."""


@dataclass(frozen=True)
class TexturesDone:
    """All textures have been handed over."""


@dataclass(frozen=True, eq=False)
class LocatorReady:
    """Cell locators of a model."""

    locators: list[vtkStaticCellLocator]
    """One for each chunk of a mesh, in order; empty for a cloud."""


@dataclass(frozen=True)
class Problem:
    """Finding to report to the user."""

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
"""Runs jobs later, one after another."""
