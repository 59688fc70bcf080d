"""Everything that VTK draws, off screen, without Qt.

What there is comes in here and is placed; `Picture` draws it. All of this belongs to one thread.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - registers the drawing classes

from vomstudio.core.arrays import BoolArray, FloatArray, FloatingArray
from vomstudio.extraction.selection.visible_region import Looking
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.rendering.prepare.events import Event, FieldReady
from vomstudio.rendering.scene import hidden_elements, picking
from vomstudio.rendering.scene.actor_creation import Intake
from vomstudio.rendering.scene.appearance import DISPLAY_MODES
from vomstudio.rendering.scene.camera_visibility import Sight
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.frame_drawing import Picture
from vomstudio.rendering.scene.frame_progress import Frame
from vomstudio.rendering.scene.model_scene import ModelScene
from vomstudio.rendering.scene.shader_warmup import warm_up
from vomstudio.rendering.scene.visible_nodes import NodesInView
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.drawing import PREVIEW, FeatureDrawing
from vomstudio.studio.tools.interaction_types import Hit


class Scene:
    """The drawn world of one viewport.

    models : by id, what is drawn of each; features, cameras : what is drawn over them; look : how
        models look
    canvas : where it is drawn; picture : draws it; nodes : which nodes of clouds the view needs
    """

    def __init__(self, camera: Camera | None = None) -> None:
        self.camera = Camera() if camera is None else camera
        self.canvas = Canvas()
        self._contents = Contents()
        self.models = self._contents.models
        self.look = self._contents.look
        self.features = self._contents.features
        self.cameras = self._contents.cameras
        self._planes = self._contents.planes
        self._sight = Sight(self.camera, self.canvas, self._contents)
        self.nodes = NodesInView(self.canvas, self._contents, self._sight)
        frame = Frame()
        self.picture = Picture(self.canvas, self._contents, self._sight, self.nodes, frame)
        self._intake = Intake(self.canvas, self._contents, self._sight, frame)

    # -- life

    def start(self, width: int, height: int) -> None:
        """Make the off-screen window and learn what the graphics driver is."""
        canvas = self.canvas
        canvas.open(width, height)
        self.features.attach(canvas.layer, canvas.chosen)
        self.cameras.attach(canvas.layer)
        self._sight.apply()
        canvas.learn_driver()

    def warm_up(self) -> Iterator[None]:
        """Have the driver compile its programs, one per step."""
        return warm_up(self.canvas, self._contents, self._sight, self._intake)

    def close(self) -> None:
        """Release every graphics resource; the scene cannot be started again."""
        if not self.canvas.is_open:
            return
        self.canvas.make_current()
        for model_id in list(self.models):
            self.remove_model(model_id)
        self.picture.release()
        self.canvas.close()

    def resize(self, width: int, height: int) -> None:
        self.canvas.resize(width, height)
        self.picture.abandon()

    def set_scale(self, scale: float) -> None:
        """Device pixels per logical pixel: widths and sizes of points are logical."""
        self.look.point_scale = scale
        self.features.set_scale(scale)
        self.cameras.set_scale(scale)

    # -- models

    def add_model(
        self,
        model_id: str,
        data: Mesh | PointCloud,
        to_world: FloatArray,
        bounds: FloatArray,
        origin: FloatArray,
    ) -> ModelScene:
        """Register a model that will be filled by `take`; bounds (2, 3) in its file frame."""
        self.remove_model(model_id)
        if isinstance(data, StreamedCloud):
            bounds = data.bounds
        model = ModelScene(
            model_id, data, origin, bounds[0] - origin, bounds[1] - origin, to_world, to_world
        )
        self.models[model_id] = model
        self.set_to_world(model_id, to_world)
        return model

    def take(self, model_id: str, event: Event) -> None:
        """Accept what a worker has prepared; from here on it belongs to this thread."""
        model = self.models.get(model_id)
        if model is None:
            return
        if isinstance(event, FieldReady):
            self.set_field(model_id, event)
        else:
            self._intake.take(model, event)

    def remove_model(self, model_id: str) -> None:
        model = self.models.pop(model_id, None)
        if model is None:
            return
        self.picture.abandon()
        for part in model.parts + model.proxies:
            self._intake.drop(part)
        window = self.canvas.window if self.canvas.is_open else None
        for skin in model.skins.values():
            skin.release(window)
        if not self.models:
            self.canvas.origin = None

    def set_to_world(self, model_id: str, to_world: FloatArray) -> None:
        """to_world : (4, 4) similarity from the file's frame to World"""
        model = self.models[model_id]
        model.to_world = np.array(to_world, np.float64)
        model.from_world = np.asarray(np.linalg.inv(model.to_world), np.float64)
        if self.canvas.origin is None:
            self.set_origin(np.round(model.corners_world().mean(axis=0)))
        self._place(model)
        self._place_planes()
        self.picture.abandon()

    def set_visible(self, model_id: str, visible: bool) -> None:
        self.models[model_id].visible = visible
        self.picture.abandon()

    def set_hidden(self, model_id: str, hidden: BoolArray | None) -> None:
        """Draw and pick a model without these faces or points (n,); None for all of it."""
        hidden_elements.hide(self.models[model_id], hidden)
        self.picture.abandon()

    def corners(self, *, close: bool = False) -> FloatArray:
        """(n, 3) World corners of the visible models; see `ModelScene.corners_world`."""
        return self._contents.corners(close=close)

    def everything(self) -> FloatArray:
        """(n, 3) World corners of the visible models or, without any, of the features; and of the
        cameras of photos."""
        corners = self.corners(close=True)
        if not len(corners):
            corners = self.features.corners()
        return np.concatenate([corners, self.cameras.corners()])

    # -- how models look

    def set_mode(self, mode: str) -> None:
        """See DISPLAY_MODES."""
        if mode not in DISPLAY_MODES:
            raise ValueError(f"display mode {mode!r}; one of {', '.join(DISPLAY_MODES)}")
        self.look.mode = mode
        for model in self.models.values():
            if any(p.tinted for p in model.parts + model.proxies) != self.look.shows_field(model):
                self.look.tint(model)
        self._redress()

    def set_lit(self, mode: str, lit: bool) -> None:
        """Whether a light at the viewer shades the meshes in a display mode."""
        self.look.lit[mode] = lit
        self._redress()

    def set_point_size(self, pixels: float | None) -> None:
        """In logical pixels; None closes the surface that the points lie on."""
        self.look.point_size = pixels
        self._redress()

    def _redress(self) -> None:
        for model in self.models.values():
            for part in model.parts + model.proxies:
                self.look.dress(model, part)
        self.picture.abandon()

    def set_eye_dome(self, on: bool) -> None:
        """Shade clouds at rest by how far pixels lie behind their neighbours."""
        self.picture.eye_dome = on
        self.picture.abandon()

    def set_field(self, model_id: str, ready: FieldReady | None) -> None:
        """Give a model the colours of a field, or take them away."""
        model = self.models[model_id]
        model.field = ready
        self.look.tint(model)
        self.picture.abandon()

    # -- features

    def set_features(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add, replace or (None) remove drawings by id."""
        if self.canvas.origin is None:
            for drawing in changes.values():
                if drawing is not None and len(drawing.line):
                    self.set_origin(np.round(np.asarray(drawing.line, float)[0]))
                    break
        self.features.change(changes)

    def set_selected(self, ids: Iterable[str]) -> None:
        """Emphasise these features, and no others."""
        self.features.select(frozenset(ids))

    # -- where VTK draws it

    def set_origin(self, origin: FloatingArray) -> None:
        """(3,) World, from where VTK counts in its 32 bits."""
        place = self.canvas.origin = np.asarray(origin, np.float64)
        self.features.set_origin(place)
        self.cameras.set_origin(place)
        self._place_planes()
        for model in self.models.values():
            self._place(model)

    def _place(self, model: ModelScene) -> None:
        placement = self.canvas.placement(model.to_world, model.origin)
        for part in model.parts + model.proxies:
            part.actor.SetUserMatrix(placement)

    def set_clip(self, box: ClipBox | None) -> None:
        """Draw and pick only what lies in a box; None for everything."""
        before, self._planes.box = self._planes.box, box
        self._place_planes()
        if (before is None) != (box is None):
            self.features.clip(None if box is None else self._planes.every())
        self.picture.abandon()

    def _place_planes(self) -> None:
        corners = (model.corners_world() for model in self.models.values())
        if self._planes.place(corners, self.canvas.start):
            for model in self.models.values():
                for part in model.parts + model.proxies:
                    self._planes.cut(part.actor)

    # -- what is seen

    def seen(self, points: FloatArray, slack: float = 0.0) -> BoolArray:
        """Whether World points (n, 3) are not behind the surface as it was last drawn."""
        return self._sight.in_front(points, slack)

    def pick(self, x: float, y: float, size: tuple[float, float]) -> Hit | None:
        """The front-most point of a visible model at a pixel of an image of `size`."""
        models = self._contents.visible()
        shown = [model for model in models if not model.model_id.startswith(PREVIEW)]
        return picking.pick_front(shown, self.camera, x, y, size, self._planes.box)

    def looking(self, ratio: float) -> Looking | None:
        """What is seen now, as numbers; None before anything was drawn. ratio : pixels of the
        device for a logical one"""
        eye, canvas = self._sight.eye, self.canvas
        if eye is None:
            return None
        while self.picture.refining and not self.picture.refine():
            # What is not drawn yet would count as free air.
            pass
        buffer = canvas.surface_depth()[::-1].astype(np.float64)
        depth = np.where(buffer < 1.0, eye.depth_from_buffer(buffer), np.inf).astype(np.float32)
        return Looking(
            eye.position,
            eye.right,
            eye.up,
            eye.direction,
            eye.half_height,
            eye.orthographic,
            canvas.size,
            ratio,
            depth,
            self._planes.box,
        )
