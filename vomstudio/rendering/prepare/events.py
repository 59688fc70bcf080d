"""What the workers hand over to the thread that draws, piece by piece.

From then on it belongs to that thread alone. Nothing of VTK is imported here: the window knows
these before it has VTK.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from vomstudio.core.arrays import FloatArray, Int32Array
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import CloudNodes, Piece, View
from vomstudio.rendering.prepare.textures import Texture
from vomstudio.rendering.view.scalars import FieldStyle, Scale
from vomstudio.rendering.view.spatial_blocks import FaceChunk, PointChunk

if TYPE_CHECKING:
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator


class Stopped(Exception):
    """The model is no longer wanted."""


@dataclass(frozen=True, eq=False)
class Registered:
    """A worker knows how large the model is: bounds (2, 3) in its file frame."""

    data: Mesh | PointCloud
    bounds: FloatArray
    origin: FloatArray


@dataclass(frozen=True, eq=False)
class ProxyReady:
    """What stands for a mesh while the camera moves.

    rows : of the mesh's vertices, one for each point of `data`
    """

    data: vtkPolyData
    rows: Int32Array


@dataclass(frozen=True, eq=False)
class MeshChunkReady:
    chunk: FaceChunk
    data: vtkPolyData
    texels_per_metre: float


@dataclass(frozen=True, eq=False)
class NodeReady:
    """A node of a cloud, and what it is made of. `piece` is in the order of `data`."""

    chunk: PointChunk
    data: vtkPolyData
    spacing: float
    """Metres between neighbours, in the file's frame."""
    row: int
    piece: Piece


@dataclass(frozen=True, eq=False)
class NodesDropped:
    """Nodes that are not needed any more; who took them lets them go when they are off the
    screen."""

    pieces: dict[int, Piece]
    nodes: CloudNodes


class NodeStream(Protocol):
    """What fetches the nodes of a cloud beside the window; see `Streamer`. For the window's
    thread."""

    turn: int
    """Number of the last view that has asked for other nodes."""

    def needed(self, view: View) -> dict[int, float]: ...

    def closing(self, rows: list[int]) -> dict[int, float]: ...

    def look(self, view: View) -> dict[int, float] | None: ...


@dataclass(frozen=True, eq=False)
class StreamStarted:
    """The nodes that stand for the whole of a cloud have been handed over."""

    streamer: NodeStream


@dataclass(frozen=True)
class ViewDone:
    """All that the streamer was asked for with this number has been handed over."""

    turn: int


@dataclass(frozen=True)
class ChunksDone:
    count: int


@dataclass(frozen=True, eq=False)
class TextureReady:
    material: int
    texture: Texture | None
    """None where it could not be read."""


@dataclass(frozen=True)
class TexturesDone:
    pass


@dataclass(frozen=True, eq=False)
class LocatorReady:
    locators: list[vtkStaticCellLocator]
    """One for each chunk of a mesh, in order; empty for a cloud."""


@dataclass(frozen=True)
class Problem:
    finding: Finding


@dataclass(frozen=True, eq=False)
class FieldReady:
    """A model's field as colours: one array for each stand-in and each chunk, in their order."""

    style: FieldStyle
    scale: Scale
    proxies: list[vtkUnsignedCharArray]
    parts: list[vtkUnsignedCharArray]


Event = (
    Registered
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
"""Has a job run later, one after the other."""
