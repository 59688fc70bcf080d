"""Everything that VTK draws, off screen, without Qt.

One render window with two layers. Layer 0 holds the models, layer 1 the features drawn over them.
When layer 0 stands, colour and depth are kept aside; a later change of the features alone puts them
back instead of drawing the models again. A model that is slow to draw is shown by its proxy while
the camera moves; at rest its chunks are added batch by batch to the same buffers, and whoever owns
the scene calls `refine` between the events of its loop until the frame is whole.

All of this belongs to one thread.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np
import numpy.typing as npt
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - registers the drawing classes
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPlaneCollection
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLight,
    vtkPointGaussianMapper,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTexture,
)
from vtkmodules.vtkRenderingOpenGL2 import vtkTextureObject

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.rendering.scene import in_view, picking, skins, vtk_data
from vomstudio.rendering.scene.appearance import DISPLAY_MODES, Appearance
from vomstudio.rendering.scene.buffers import Buffers
from vomstudio.rendering.scene.camera_layer import CameraLayer
from vomstudio.rendering.scene.events import (
    ChunksDone,
    Event,
    FieldReady,
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
from vomstudio.rendering.scene.eyedome import BANDS, EyeDome
from vomstudio.rendering.scene.feature_layer import FeatureLayer
from vomstudio.rendering.scene.model_scene import ModelScene, Part
from vomstudio.rendering.scene.skins import Skin
from vomstudio.rendering.scene.streaming import view_of
from vomstudio.rendering.view.camera import Camera, Eye
from vomstudio.rendering.view.clipping import FACES, ClipBox
from vomstudio.rendering.view.drawing import PREVIEW, FeatureDrawing
from vomstudio.rendering.view.pace import SLOW_FRAME_S, Pace
from vomstudio.tools.types import Hit

Array = npt.NDArray[np.float64]

# One flat neutral: a gradient costs a software renderer 12 ms in every frame.
BACKGROUND = (0.36, 0.375, 0.39)

SOFTWARE_TEXTURE_SIDE = 4096
SOFTWARE_WHOLE_SIDE = 2048
"""A larger one goes to a software renderer in quarters."""

MOVING_SETS = 6
POINTS_PER_SET = 50_000

PATIENCE_S = 0.4
"""Nodes that come within this time after they were asked for are drawn in one frame."""


class Scene:
    """The drawn world of one viewport."""

    def __init__(self) -> None:
        self.camera = Camera()
        self.models: dict[str, ModelScene] = {}
        self.origin: Array | None = None
        self.look = Appearance()
        self.eye_dome = False
        self.clip: ClipBox | None = None
        self.features = FeatureLayer()
        self.cameras = CameraLayer()
        self.size = (1, 1)
        self.software = True
        self.texture_limit = SOFTWARE_TEXTURE_SIDE
        self.whole_texture_side: int | None = SOFTWARE_WHOLE_SIDE
        self.eye: Eye | None = None
        self.complete = False
        self.showing_proxy = False
        self.more_to_come = False
        """The last frame left out stand-ins that the next one will show."""
        self.pace = Pace()
        self.extra_points: Array = np.zeros((0, 3))
        self.frames = 0
        self._window: vtkRenderWindow | None = None
        self._pending: list[tuple[ModelScene, Part]] | None = None
        self._batch_first = False
        self._asked = 0.0
        self._bands: list[tuple[int, int]] | None = None
        self._dome = EyeDome()
        self._planes = [vtkPlane() for _ in FACES]
        self._cutting: list[int] = []
        self._outdated = False
        self._was_moving = False
        self._buffers: Buffers | None = None
        self._kept = False
        self._action: Callable[[], None] | None = None
        self._pixels = vtkUnsignedCharArray()
        self._depths = vtkFloatArray()
        self._depth: npt.NDArray[np.float32] | None = None

    # -- life

    @property
    def mode(self) -> str:
        """Display mode; see DISPLAY_MODES."""
        return self.look.mode

    @property
    def started(self) -> bool:
        return self._window is not None

    def start(self, width: int, height: int) -> None:
        """Make the off-screen window and learn what the graphics driver is."""
        window = vtkRenderWindow()
        window.SetOffScreenRendering(1)
        window.SetMultiSamples(0)
        window.SetSize(width, height)
        window.SetNumberOfLayers(2)
        self.size = (width, height)
        surface, layer = vtkRenderer(), vtkRenderer()
        surface.SetBackground(*BACKGROUND)
        layer.SetLayer(1)
        layer.PreserveDepthBufferOn()
        layer.PreserveColorBufferOn()
        layer.AddObserver("StartEvent", self._layer_starts)
        for renderer in (surface, layer):
            renderer.SetAutomaticLightCreation(0)
            # Plain blending: the weighted kind needs three more full-screen passes.
            renderer.SetUseOIT(False)
            window.AddRenderer(renderer)
        # A head light: what is seen is lit.
        light = vtkLight()
        light.SetLightTypeToHeadlight()
        surface.AddLight(light)
        surface.GetActiveCamera()
        layer.SetActiveCamera(surface.GetActiveCamera())
        self._window, self._surface, self._layer = window, surface, layer
        self._buffers = Buffers(window)
        self.features.attach(layer)
        self.cameras.attach(layer)
        self._apply_camera()
        window.Render()
        report = window.ReportCapabilities().lower()
        names = [line for line in report.splitlines() if "opengl renderer" in line]
        self.software = not names or any(
            word in names[0] for word in ("llvmpipe", "softpipe", "swrast", "basic render", "swr")
        )
        largest = int(vtkTextureObject.GetMaximumTextureSize(window))
        self.texture_limit = min(largest, SOFTWARE_TEXTURE_SIDE) if self.software else largest
        self.whole_texture_side = SOFTWARE_WHOLE_SIDE if self.software else None

    def warm_up(self) -> Iterator[None]:
        """Have the driver compile its programs, one per step, before the first model needs them:
        together they would hold up its first frame by a tenth of a second."""
        assert self._window is not None
        points = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1]], np.float32)
        corners = points.astype(np.float64)
        faces = np.array([[0, 1, 2]], np.int32)
        grey = np.full((3, 3), 128, np.uint8)
        samples = (
            (Mesh(corners, faces), vtk_data.triangles(points, faces, colors=grey), 0),
            (Mesh(corners, faces), vtk_data.triangles(points, faces, uv=points[:, ::2]), 1),
            (Mesh(corners, faces), vtk_data.triangles(points, faces, uv=points[:, ::2]), 4),
            (PointCloud(corners), vtk_data.point_set(points, grey), 0),
        )
        for holder, data, pictures in samples:
            if self.models or self._window is None:
                return
            zero = np.zeros(3)
            self.origin = zero
            model = ModelScene("", holder, zero, zero, zero + 1.0, np.eye(4), np.eye(4))
            part = self._part(model, data)
            self.origin = None
            self.look.dress(model, part)
            if pictures:
                square = vtk_data.image(np.full((4, 4, 3), 128, np.uint8))
                textures = [vtkTexture() for _ in range(pictures)]
                for texture in textures:
                    texture.SetInputData(square)
                    texture.InterpolateOn()
                skins.wear(part.actor, textures)
                part.actor.GetProperty().LightingOff()
            camera = self.camera
            self.camera = Camera()
            self._apply_camera()
            self.camera = camera
            part.actor.VisibilityOn()
            self._render(erase=True, surface=True, layer=False, action=None)
            self._window.WaitForCompletion()
            self._drop(part)
            self.frames -= 1
            yield

    def close(self) -> None:
        """Release every graphics resource; the scene cannot be started again."""
        if self._window is None:
            return
        window = self._window
        window.MakeCurrent()
        for model_id in list(self.models):
            self.remove_model(model_id)
        if self._buffers is not None:
            self._buffers.release()
        self._dome.release(window)
        self._layer.RemoveAllObservers()
        for renderer in (self._surface, self._layer):
            renderer.RemoveAllViewProps()
            window.RemoveRenderer(renderer)
        window.Finalize()
        self._window = None

    def resize(self, width: int, height: int) -> None:
        self.size = (width, height)
        if self._window is not None:
            self._window.SetSize(width, height)
            self._kept = False
            self.abandon()

    # -- models

    def add_model(
        self, model_id: str, data: Mesh | PointCloud, to_world: Array, bounds: Array, origin: Array
    ) -> ModelScene:
        """Register a model that will be filled by `take`; bounds (2, 3) in its file frame."""
        self.remove_model(model_id)
        if isinstance(data, StreamedCloud):
            bounds = data.bounds
        model = ModelScene(
            model_id, data, origin, bounds[0] - origin, bounds[1] - origin, to_world, to_world
        )
        self.models[model_id] = model
        self._place(model, to_world)
        return model

    def _place(self, model: ModelScene, to_world: Array) -> None:
        model.to_world = np.array(to_world, np.float64)
        model.from_world = np.asarray(np.linalg.inv(model.to_world), np.float64)
        if self.origin is None:
            self.set_origin(np.round(model.corners_world().mean(axis=0)))
        placement = self._placement(model)
        for part in model.parts + model.proxies:
            part.actor.SetUserMatrix(placement)
        self._place_planes()
        self.abandon()

    def set_origin(self, origin: npt.NDArray[np.floating]) -> None:
        self.origin = np.asarray(origin, np.float64)
        self.features.set_origin(self.origin)
        self.cameras.set_origin(self.origin)
        self._place_planes()
        for model in self.models.values():
            for part in model.parts + model.proxies:
                part.actor.SetUserMatrix(self._placement(model))

    def _placement(self, model: ModelScene):  # type: ignore[no-untyped-def]
        assert self.origin is not None
        values = model.to_world.copy()
        values[:3, 3] = model.to_world[:3, :3] @ model.origin + model.to_world[:3, 3] - self.origin
        return vtk_data.matrix(values)

    def set_to_world(self, model_id: str, to_world: Array) -> None:
        self._place(self.models[model_id], to_world)

    def set_visible(self, model_id: str, visible: bool) -> None:
        self.models[model_id].visible = visible
        self.abandon()

    def set_mode(self, mode: str) -> None:
        if mode not in DISPLAY_MODES:
            raise ValueError(f"display mode {mode!r}; one of {', '.join(DISPLAY_MODES)}")
        self.look.mode = mode
        for model in self.models.values():
            if any(p.tinted for p in model.parts + model.proxies) != self.look.shows_field(model):
                self.look.tint(model)
        self._redress()

    def _redress(self) -> None:
        for model in self.models.values():
            for part in model.parts + model.proxies:
                self.look.dress(model, part)
        self.abandon()

    def set_lit(self, mode: str, lit: bool) -> None:
        """Whether a light at the viewer shades the meshes in a display mode."""
        self.look.lit[mode] = lit
        self._redress()

    def set_point_size(self, pixels: float | None) -> None:
        self.look.point_size = pixels
        self._redress()

    def set_eye_dome(self, on: bool) -> None:
        self.eye_dome = on
        self.abandon()

    def set_clip(self, box: ClipBox | None) -> None:
        """Draw and pick only what lies in a box; None for everything."""
        before, self.clip = self.clip, box
        self._place_planes()
        if (before is None) != (box is None):
            self.features.clip(None if box is None else collection(self._planes))
        self.abandon()

    def _place_planes(self) -> None:
        """Bring the planes to the faces of the box. Models are cut only by those that they cross: a
        software renderer takes a third longer with all six."""
        cutting: list[int] = []
        if self.clip is not None:
            origin = np.zeros(3) if self.origin is None else self.origin
            corners = [m.corners_world() for m in self.models.values()]
            for k, (axis, side) in enumerate(FACES):
                normal = np.zeros(3)
                normal[axis] = -1.0 if side else 1.0
                at = self.clip.face_centre(axis, side)
                self._planes[k].SetNormal(*normal)
                self._planes[k].SetOrigin(*(at - origin))
                if any(((c - at) @ normal).min() < 0.0 for c in corners):
                    cutting.append(k)
        if cutting != self._cutting:
            self._cutting = cutting
            for model in self.models.values():
                for part in model.parts + model.proxies:
                    self._cut(part.actor)

    def _cut(self, actor: vtkActor) -> None:
        planes = collection([self._planes[k] for k in self._cutting]) if self._cutting else None
        vtk_data.clip(actor, planes)

    def set_field(self, model_id: str, ready: FieldReady | None) -> None:
        """Give a model the colours of a field, or take them away."""
        model = self.models[model_id]
        model.field = ready
        self.look.tint(model)
        self.abandon()

    def remove_model(self, model_id: str) -> None:
        model = self.models.pop(model_id, None)
        if model is None:
            return
        self.abandon()
        for part in model.parts + model.proxies:
            self._drop(part)
        for skin in model.skins.values():
            skin.release(self._window)
        if not self.models:
            self.origin = None

    def _drop(self, part: Part) -> None:
        skins.take_off(part.actor)
        if self._window is not None:
            self._surface.RemoveActor(part.actor)
            part.actor.ReleaseGraphicsResources(self._window)

    def take(self, model_id: str, event: Event) -> None:
        """Accept what a worker has prepared; from here on it belongs to this thread."""
        model = self.models.get(model_id)
        if model is None:
            return
        if isinstance(event, ProxyReady):
            model.proxies.append(self._part(model, event.data))
            model.proxies[-1].rows = event.rows
            self.look.dress(model, model.proxies[-1])
        elif isinstance(event, MeshChunkReady):
            part = self._part(model, event.data)
            part.material = event.chunk.material
            part.density = event.texels_per_metre
            part.has_uv = event.data.GetPointData().GetTCoords() is not None
            part.rows = event.chunk.vertex_ids
            model.face_chunks.append(event.chunk)
            model.parts.append(part)
            self.look.dress(model, part)
        elif isinstance(event, NodeReady):
            self._take_node(model, event)
        elif isinstance(event, NodesDropped):
            self._take_away(model, event)
        elif isinstance(event, StreamStarted):
            model.streamer = event.streamer
        elif isinstance(event, ViewDone):
            if model.settled or model.streamer is None or event.turn != model.streamer.turn:
                return
            model.settled = True
        elif isinstance(event, ChunksDone):
            model.chunks_done = True
        elif isinstance(event, TextureReady):
            if event.texture is not None:
                model.skins[event.material] = Skin(event.texture)
        elif isinstance(event, TexturesDone):
            model.textures_done = True
        elif isinstance(event, LocatorReady):
            model.locators = event.locators
        elif isinstance(event, FieldReady):
            self.set_field(model_id, event)
        if isinstance(event, (ProxyReady, MeshChunkReady, TextureReady, StreamStarted, ViewDone)):
            self.complete = False
            self._outdated = True

    def _take_node(self, model: ModelScene, event: NodeReady) -> None:
        part = self._part(model, event.data)
        part.spacing, part.row, part.piece = event.spacing, event.row, event.piece
        part.rows = event.chunk.point_ids
        model.point_chunks.append(event.chunk)
        model.parts.append(part)
        self.look.dress(model, part)
        if model.streamer is not None and part.row not in model.shown_rows:
            return
        if self._pending is not None and self._bands is None:
            # It becomes a part of the frame in the making.
            assert self.eye is not None
            in_view.size_points(model, part, self.eye, self.camera, self.size[1], self.look)
            self._pending.append((model, part))
        else:
            self.complete = False
            self._outdated = True

    def _take_away(self, model: ModelScene, event: NodesDropped) -> None:
        gone = model.drop(event.pieces)
        if self._pending is not None and gone:
            dropped = {id(part) for part in gone}
            self._pending = [entry for entry in self._pending if id(entry[1]) not in dropped]
        for part in gone:
            self._drop(part)
        for row, piece in event.pieces.items():
            event.nodes.let_go(row, piece)

    def look_around(self, *, fetch: bool = True) -> None:
        """Find out which nodes of clouds the view needs, and have those fetched that are not there.
        Until they are, those above them close the surface."""
        if self.eye is None:
            return
        for model in self.models.values():
            streamer = model.streamer
            if streamer is None or not model.visible:
                continue
            view = view_of(self.eye, self.camera, self.size, model.to_world, model.from_world)
            needed = streamer.look(view) if fetch else streamer.needed(view)
            there = {part.row for part in model.parts}
            if needed is None:
                needed = model.needed
            elif fetch:
                model.needed = needed
                model.settled = there.issuperset(needed)
                self._asked = time.perf_counter()
            model.shown_rows = needed
            if not there.issuperset(needed):
                model.shown_rows = needed | streamer.closing([r for r in needed if r in there])

    @property
    def settled(self) -> bool:
        """Whether the nodes are there that the view needs."""
        return all(m.settled or not m.visible for m in self.models.values())

    @property
    def waits(self) -> bool:
        """Whether so much is on its way that a frame had better wait for it."""
        return not self.settled and time.perf_counter() - self._asked < PATIENCE_S

    def _part(self, model: ModelScene, data) -> Part:  # type: ignore[no-untyped-def]
        bounds = np.array(data.GetBounds()).reshape(3, 2)
        if isinstance(model.data, Mesh):
            mapper = vtkPolyDataMapper()
            elements = data.GetNumberOfCells()
        else:
            mapper = vtkPointGaussianMapper()
            mapper.EmissiveOff()
            mapper.SetScaleFactor(0.0)
            elements = data.GetNumberOfPoints()
        mapper.SetInputData(data)
        mapper.SetStatic(1)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.ForceOpaqueOn()
        actor.SetVisibility(False)
        actor.SetUserMatrix(self._placement(model))
        self._cut(actor)
        if self._window is not None:
            self._surface.AddActor(actor)
        part = Part(actor, bounds[:, 0], bounds[:, 1], elements)
        part.has_colors = data.GetPointData().GetScalars() is not None
        return part

    # -- bounds

    def corners(self, *, close: bool = False) -> Array:
        """(n, 3) World corners of the visible models; see `ModelScene.corners_world`."""
        some = [m.corners_world(close=close) for m in self.models.values() if m.visible]
        return np.concatenate([np.zeros((0, 3)), *some])

    # -- features

    def set_features(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        if self.origin is None:
            for drawing in changes.values():
                if drawing is not None and len(drawing.line):
                    self.set_origin(np.round(np.asarray(drawing.line, float)[0]))
                    break
        self.features.change(changes)

    def set_selected(self, ids: Iterable[str]) -> None:
        self.features.select(frozenset(ids))

    # -- drawing

    def _apply_camera(self) -> None:
        over = (self.features.corners(), self.cameras.corners(), self.extra_points)
        corners = np.concatenate([self.corners(), *over])
        eye = self.camera.eye(corners)
        origin = np.zeros(3) if self.origin is None else self.origin
        position = eye.position - origin
        drawn = self._surface.GetActiveCamera()
        drawn.SetPosition(*position)
        drawn.SetFocalPoint(*(position + eye.direction * max(self.camera.distance, 1e-3)))
        drawn.SetViewUp(*eye.up)
        drawn.SetParallelProjection(eye.orthographic)
        drawn.SetViewAngle(self.camera.view_angle_deg)
        if eye.orthographic:
            drawn.SetParallelScale(eye.half_height)
        drawn.SetClippingRange(eye.near, eye.far)
        self.eye = eye

    @property
    def slow(self) -> bool:
        """Whether drawing everything takes too long to do at every step of a drag."""
        if any(m.visible and m.proxies and not m.chunks_done for m in self.models.values()):
            return True
        parts = [part for _, part in self._seen_parts()]
        return not all(p.uploaded for p in parts) or self.pace.expected(parts) > SLOW_FRAME_S

    def _seen_parts(self, *, every_node: bool = False) -> list[tuple[ModelScene, Part]]:
        assert self.eye is not None
        return in_view.parts_in_view(
            self.models.values(), self.eye, self.size, self.clip, every_node=every_node
        )

    def abandon(self) -> None:
        """Forget a frame that is being refined, and that the last one was whole."""
        self._pending = None
        self.complete = False

    def draw(self, *, moving: bool) -> None:
        """Draw a whole picture now: the models where that is quick, else what stands for them."""
        assert self._window is not None
        if moving and not self._was_moving:
            self.pace.begin_moving()
        self._was_moving = moving
        self.abandon()
        self._apply_camera()
        self.look_around(fetch=not moving)
        # Large points take longer, so their size comes before what can be afforded.
        self._size_points()
        proxy = self.slow
        self.more_to_come = False
        if proxy:
            show = self._stand_ins()
        else:
            self._choose_levels()
            show = self._tinted(self._seen_parts())
        fresh = any(not p.uploaded for p in show)
        started = time.perf_counter()
        self._show(show)
        self._kept = False
        self.features.thin = moving
        self._render(
            erase=True,
            surface=True,
            layer=True,
            action=None if moving else self._save_surface,
        )
        self.features.thin = False
        self._window.WaitForCompletion()
        spent = time.perf_counter() - started
        for part in show:
            part.uploaded = True
        self.showing_proxy = proxy
        if not proxy:
            self.pace.learn(show, spent)
            due = any(m.visible and self._skins_due(m) for m in self.models.values())
            self.complete = not due and not self.domed
        else:
            if not fresh:
                self.pace.learn_moving(spent, MOVING_SETS)
            if not any(m.visible and m.parts for m in self.models.values()):
                self.complete = True

    def _tinted(self, entries: Iterable[tuple[ModelScene, Part]]) -> list[Part]:
        found = []
        for model, part in entries:
            self.look.tint_node(model, part)
            found.append(part)
        return found

    def _stand_ins(self) -> list[Part]:
        """What stands for the models while drawing them takes too long."""
        visible = [m for m in self.models.values() if m.visible]
        show = [p for m in visible for p in m.proxies] + self._coarse_nodes()
        budget = 150_000
        for part in [p for m in visible if isinstance(m.data, Mesh) and not m.proxies
                     for p in m.parts]:  # fmt: skip
            if part.uploaded and budget > 0:
                show.append(part)
                budget -= part.elements
        return show

    def _coarse_nodes(self) -> list[Part]:
        """The coarse nodes of clouds in view, as many as there is time for."""
        seen = self._seen_parts(every_node=True)
        nodes = [entry for entry in seen if isinstance(entry[0].data, PointCloud)]
        nodes.sort(key=lambda entry: -entry[1].spacing)
        left = self.pace.moving_sets * POINTS_PER_SET
        show: list[tuple[ModelScene, Part]] = []
        fresh = 0
        for model, part in nodes:
            left -= part.elements
            if show and left < 0:
                break
            if not part.uploaded:
                # A few at a time: the first drawing takes it to the graphics card.
                fresh += part.elements
                if show and fresh > POINTS_PER_SET:
                    self.more_to_come = True
                    break
            show.append((model, part))
        return self._tinted(show)

    def draw_features(self) -> None:
        """Draw the features anew over the models as they last stood."""
        assert self._window is not None
        if not self._kept or self.eye is None:
            if self._pending is None:
                self.draw(moving=False)
            # Else the frame in the making will show them.
            return
        over = np.concatenate([self.features.corners(), self.cameras.corners()])
        depth = self.eye.depth(over)
        if len(depth) and (depth.min() < self.eye.near or depth.max() > self.eye.far):
            # The kept depths are of another range: these features would be cut off.
            self.draw(moving=False)
            return
        busy = self._pending is not None and not self._batch_first
        assert self._buffers is not None
        if busy:
            self._buffers.save("frame")
        self._render(erase=False, surface=False, layer=True, action=self._restore_surface)
        if busy:
            self.pixels()
            self._buffers.restore("frame")

    def begin_rest(self) -> None:
        """Start the whole frame of a camera that has come to rest."""
        if self.eye is not None and self._depth is None:
            self._read_depth()
        self._was_moving = False
        self._apply_camera()
        self.look_around()
        self._choose_levels()
        self._size_points()
        self._pending = self._seen_parts()
        self._bands = None
        self._batch_first = True
        self._outdated = False

    @property
    def refining(self) -> bool:
        return self._pending is not None

    def refine(self) -> bool:
        """Do one short piece of the rest frame; True once the frame is whole and drawn."""
        assert self._window is not None
        if self._pending is None:
            return True
        if self._upload_one_texture():
            return False
        if not self._pending and not self._batch_first and self._shade_band():
            return False
        started = time.perf_counter()
        # Features, and the copy of the surface below them, are a piece of their own.
        last = not self._pending
        count = self.pace.next_batch([part for _, part in self._pending])
        if any([self.look.tint_node(*entry) for entry in self._pending[:count]]):
            # They have to be taken to the graphics card anew.
            count = self.pace.next_batch([part for _, part in self._pending])
        batch = [part for _, part in self._pending[:count]]
        self._pending = self._pending[count:]
        self._show(batch)
        self._render(
            erase=self._batch_first,
            surface=True,
            layer=last,
            action=self._save_surface if last else None,
        )
        self._window.WaitForCompletion()
        self._batch_first = False
        self.pace.learn(batch, time.perf_counter() - started)
        for part in batch:
            part.uploaded = True
        if not last:
            return False
        self._pending = None
        self.complete = not self._outdated
        self.showing_proxy = False
        return True

    @property
    def domed(self) -> bool:
        """Whether the picture at rest is shaded by how far pixels lie behind their neighbours."""
        return self.eye_dome and any(
            m.visible and isinstance(m.data, PointCloud) for m in self.models.values()
        )

    def _shade_band(self) -> bool:
        """Eye-dome lighting of a part of the finished surface; False once there is nothing to do
        any more."""
        assert self._window is not None
        assert self.eye is not None
        if not self.domed:
            return False
        assert self._buffers is not None
        if self._bands is None:
            self._buffers.save("flat")
            self._bands = bands(self.size[1], BANDS if self.software else 1)
        if not self._bands:
            return False
        self._dome.shade(
            self._window,
            self._buffers["flat"],
            self.size,
            self._bands.pop(0),
            near=self.eye.near,
            far=self.eye.far,
            distance=self.camera.distance,
            orthographic=self.eye.orthographic,
            scale=self.look.point_scale,
        )
        self._window.WaitForCompletion()
        return True

    def _size_points(self) -> None:
        assert self.eye is not None
        for model, part in self._seen_parts():
            if part.spacing > 0.0 and isinstance(model.data, PointCloud):
                in_view.size_points(model, part, self.eye, self.camera, self.size[1], self.look)

    def _pixel_at(self, place: Array) -> float:
        """Metres of a device pixel at a place in World."""
        depth = float((place - self.camera.position) @ self.camera.direction)
        return self.camera.metres_per_pixel(self.size[1], max(depth, 1e-6))

    def _show(self, parts: list[Part]) -> None:
        wanted = {id(p) for p in parts}
        for model in self.models.values():
            for part in model.parts:
                part.actor.SetVisibility(id(part) in wanted)
            for part in model.proxies:
                part.actor.SetVisibility(id(part) in wanted)

    def _render(
        self, *, erase: bool, surface: bool, layer: bool, action: Callable[[], None] | None
    ) -> None:
        assert self._window is not None
        self._surface.SetDraw(surface)
        self._surface.SetErase(erase)
        self._layer.SetDraw(layer)
        if layer:
            self.features.refresh(self._pixel_at)
            self.cameras.refresh()
        self._action = action
        if layer:
            self._depth = None
        self._window.Render()
        self._action = None
        self.frames += 1

    # -- keeping the models' picture aside

    def _layer_starts(self, *_: object) -> None:
        if self._action is not None:
            self._action()

    def _save_surface(self) -> None:
        assert self._buffers is not None
        self._buffers.save("surface")
        self._kept = True

    def _restore_surface(self) -> None:
        assert self._buffers is not None
        self._buffers.restore("surface")

    # -- textures

    def _skins_due(self, model: ModelScene) -> bool:
        return self.look.textured(model) and any(s.too_coarse for s in model.skins.values())

    def _choose_levels(self) -> None:
        """Without hardware mipmaps: the coarsest level with about a texel per pixel."""
        needed: dict[int, float] = {}
        if self.software:
            assert self.eye is not None
            seen = self._seen_parts()
            needed = in_view.texels_per_pixel(seen, self.eye, self.camera, self.size[1])
        for model in self.models.values():
            for skin in model.skins.values():
                if self.software:
                    skin.want(needed.get(id(skin)))
                else:
                    skin.wanted = 0

    def _upload_one_texture(self) -> bool:
        """Bring one piece of a texture to the graphics card; False where none is due."""
        models = [m for m in self.models.values() if m.visible and self.look.textured(m)]
        if any(s.level is None for m in models for s in m.skins.values()):
            # A texture that has just come would go up in full, which holds the window up, only to
            # be replaced by the level that this view needs.
            self._choose_levels()
        for model in models:
            for material, skin in model.skins.items():
                if skin.level == skin.wanted:
                    skin.forget_pieces(self._window)
                    continue
                if skin.upload_piece(self._surface, mipmap=not self.software):
                    for part in model.parts:
                        if part.material == material:
                            self.look.dress(model, part)
                return True
        return False

    # -- what was drawn

    def pixels(self) -> npt.NDArray[np.uint8]:
        """(height, width, 4) of the last picture, first row at the bottom; valid until the next."""
        assert self._window is not None
        width, height = self.size
        self._window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, self._pixels, 0)
        return vtk_to_numpy(self._pixels).reshape(height, width, 4)

    def _read_depth(self) -> None:
        assert self._window is not None
        width, height = self.size
        self._window.GetZbufferData(0, 0, width - 1, height - 1, self._depths)
        self._depth = vtk_to_numpy(self._depths).reshape(height, width)

    def seen(self, points: Array, slack: float = 0.0) -> npt.NDArray[np.bool_]:
        """Whether World points (n, 3) are not behind the surface as it was last drawn."""
        width, height = self.size
        pixels, depth = self.camera.project(points, (width, height))
        ok = np.isfinite(pixels).all(axis=1) & (depth > 0.0)
        x, y = np.where(ok, pixels[:, 0], 0.0), np.where(ok, pixels[:, 1], 0.0)
        ok &= (x >= 0) & (x < width) & (y >= 0) & (y < height)
        if self.eye is None or not ok.any():
            return ok
        if self._depth is None:
            self._read_depth()
        assert self._depth is not None
        column = np.clip(x.astype(int), 0, width - 1)
        row = np.clip(height - 1 - y.astype(int), 0, height - 1)
        buffer = self._depth[row, column].astype(np.float64)
        surface = self.eye.depth_from_buffer(buffer)
        back = self.eye.depth(np.asarray(points, float).reshape(-1, 3))
        tolerance = 0.004 * np.abs(surface) + slack
        return ok & ((buffer >= 1.0) | (back <= surface + tolerance))

    def pick(self, x: float, y: float, size: tuple[float, float]) -> Hit | None:
        """The front-most point of a visible model at a pixel of an image of `size`."""
        shown = [
            model
            for model in self.models.values()
            if model.visible and not model.model_id.startswith(PREVIEW)
        ]
        return picking.pick_front(shown, self.camera, x, y, size, self.clip)


def collection(planes: list[vtkPlane]) -> vtkPlaneCollection:
    out = vtkPlaneCollection()
    for plane in planes:
        out.AddItem(plane)
    return out


def bands(height: int, count: int) -> list[tuple[int, int]]:
    """Rows from the bottom in `count` runs, first and one past the last of each."""
    ends = [round(k * height / count) for k in range(count + 1)]
    return list(itertools.pairwise(ends))
