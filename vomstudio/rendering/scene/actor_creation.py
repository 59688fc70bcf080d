"""Creation of actors from the results of the workers."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPointGaussianMapper, vtkPolyDataMapper

from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare.events import (
    ChunksDone,
    Event,
    LocatorReady,
    MeshChunkReady,
    NodeReady,
    NodesDropped,
    ProxyReady,
    StreamStarted,
    TextureReady,
    TexturesDone,
    ViewDone,
)
from vomstudio.rendering.scene import gpu_textures, hidden_elements
from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.frame_progress import FrameProgress
from vomstudio.rendering.scene.gpu_textures import GpuTexture
from vomstudio.rendering.scene.model_scene import ModelScene, Part


class ActorCreator:
    """Creator of the actors of a scene, in the thread that draws it."""

    def __init__(
        self,
        canvas: Canvas,
        scene_contents: Contents,
        visibility: SceneVisibility,
        frame: FrameProgress,
    ) -> None:
        self._canvas, self._contents = canvas, scene_contents
        self._visibility, self._frame = visibility, frame

    def take(self, model: ModelScene, event: Event) -> None:
        """Accept a worker's result for a model."""
        match event:
            case ProxyReady():
                self._add_proxy(model, event)
            case MeshChunkReady():
                self._add_chunk(model, event)
            case NodeReady():
                self._add_node(model, event)
            case NodesDropped():
                self._remove_nodes(model, event)
            case StreamStarted():
                model.streamer = event.streamer
                self._frame.mark_outdated()
            case ViewDone():
                self._finish_view(model, event)
            case ChunksDone():
                model.has_all_chunks = True
            case TextureReady():
                if event.texture is not None:
                    model.gpu_textures[event.material] = GpuTexture(event.texture)
                self._frame.mark_outdated()
            case TexturesDone():
                model.has_all_textures = True
            case LocatorReady():
                model.locators = event.locators

    def _add_proxy(self, model: ModelScene, event: ProxyReady) -> None:
        part = self.part(model, event.data)
        part.rows = event.rows
        model.proxies.append(part)
        self._contents.look.style_part(model, part)
        self._frame.mark_outdated()

    def _add_chunk(self, model: ModelScene, event: MeshChunkReady) -> None:
        part = self.part(model, event.data)
        part.material = event.chunk.material
        part.density = event.uv_per_metre
        part.has_uv = event.data.GetPointData().GetTCoords() is not None
        part.rows = event.chunk.vertex_ids
        model.face_chunks.append(event.chunk)
        model.parts.append(part)
        hidden_elements.hide_newest(model)
        self._contents.look.style_part(model, part)
        self._frame.mark_outdated()

    def _add_node(self, model: ModelScene, event: NodeReady) -> None:
        part = self.part(model, event.data)
        part.spacing, part.row, part.piece = event.spacing, event.row, event.piece
        part.rows = event.chunk.point_ids
        model.point_chunks.append(event.chunk)
        model.parts.append(part)
        hidden_elements.hide_newest(model)
        self._contents.look.style_part(model, part)
        if model.streamer is not None and part.row not in model.shown_rows:
            return
        if self._frame.add_part(model, part):
            self._visibility.set_part_point_size(model, part)
        else:
            self._frame.mark_outdated()

    def _remove_nodes(self, model: ModelScene, event: NodesDropped) -> None:
        dropped_pieces = model.drop(event.pieces)
        self._frame.remove_parts(dropped_pieces)
        for part in dropped_pieces:
            self.drop(part)
        for row, piece in event.pieces.items():
            event.nodes.release(row, piece)

    def _finish_view(self, model: ModelScene, event: ViewDone) -> None:
        if (
            model.is_settled
            or model.streamer is None
            or event.request_number != model.streamer.request_number
        ):
            return
        model.is_settled = True
        self._frame.mark_outdated()

    def part(self, model: ModelScene, data: vtkPolyData) -> Part:
        """Create a hidden actor on the canvas, and return it with its properties."""
        bounds = np.array(data.GetBounds()).reshape(3, 2)
        mapper: vtkPolyDataMapper
        if isinstance(model.data, Mesh):
            mapper = vtkPolyDataMapper()
            elements = data.GetNumberOfCells()
        else:
            mapper = points = vtkPointGaussianMapper()
            points.EmissiveOff()
            points.SetScaleFactor(0.0)
            elements = data.GetNumberOfPoints()
        mapper.SetInputData(data)
        mapper.SetStatic(1)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.ForceOpaqueOn()
        actor.SetVisibility(False)
        actor.SetUserMatrix(self._canvas.placement(model.to_world, model.origin))
        self._contents.planes.cut(actor)
        self._canvas.add(actor)
        part = Part(actor, bounds[:, 0], bounds[:, 1], elements)
        part.has_colors = data.GetPointData().GetScalars() is not None
        return part

    def drop(self, part: Part) -> None:
        """Remove an actor from the canvas."""
        gpu_textures.remove_textures(part.actor)
        self._canvas.remove(part.actor)
