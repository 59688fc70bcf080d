"""Off-screen VTK scene, independent of Qt.

The scene contains and positions its contents, and `FramePicture` draws it. Both may be used in
one thread only.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - registers the drawing classes

from vomstudio.core.arrays import BoolArray, FloatArray, FloatingArray
from vomstudio.extraction.selection.visible_region import ViewSnapshot
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.rendering.prepare.events import Event, FieldReady
from vomstudio.rendering.scene import hidden_elements, picking
from vomstudio.rendering.scene.actor_creation import ActorCreator
from vomstudio.rendering.scene.appearance import DISPLAY_MODES, Appearance
from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.frame_drawing import FramePicture
from vomstudio.rendering.scene.frame_progress import FrameProgress
from vomstudio.rendering.scene.model_scene import ModelScene
from vomstudio.rendering.scene.shader_warmup import warm_up
from vomstudio.rendering.scene.visible_nodes import VisibleNodes
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.drawing import PREVIEW, FeatureDrawing
from vomstudio.rendering.view.scalars import Scale
from vomstudio.studio.tools.interaction_types import Hit


class Scene:
    """Contents of one viewport, with their drawing.

    Attributes
    ----------
    models : dict of str to ModelScene
    features, cameras
        Layers that are drawn over the models.
    look : Appearance
    canvas, picture
        Window in which the scene is drawn, and its drawing.
    nodes : VisibleNodes
        Cloud nodes that are required for the view.
    """

    def __init__(
        self,
        camera: Camera | None = None,
        canvas: Canvas | None = None,
        style: Appearance | None = None,
    ) -> None:
        self.camera = Camera() if camera is None else camera
        self.canvas = Canvas() if canvas is None else canvas
        self._contents = Contents() if style is None else Contents(look=style)
        self.models = self._contents.models
        self.look = self._contents.look
        self.features = self._contents.features
        self.cameras = self._contents.cameras
        self._planes = self._contents.planes
        self._visibility = SceneVisibility(self.camera, self.canvas, self._contents)
        self.nodes = VisibleNodes(self.canvas, self._contents, self._visibility)
        frame = FrameProgress()
        self.picture = FramePicture(
            self.canvas, self._contents, self._visibility, self.nodes, frame
        )
        self._actor_creator = ActorCreator(self.canvas, self._contents, self._visibility, frame)

    # -- life cycle

    def start(self, width: int, height: int) -> None:
        """Open the canvas, attach the layers to it, and detect the graphics driver."""
        canvas = self.canvas
        canvas.open(width, height)
        self.features.attach(canvas.layer, canvas.emphasis)
        self.cameras.attach(canvas.layer)
        self._visibility.apply()
        canvas.detect_driver()

    def warm_up(self) -> Iterator[None]:
        """Compile the shader programs of the driver, one per step."""
        return warm_up(self.canvas, self._contents, self._visibility, self._actor_creator)

    def close(self) -> None:
        """Release all graphics resources; the scene cannot be started again."""
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
        """Set the device pixels per logical pixel; line widths and point sizes are logical."""
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
        """Register a model that is filled by `take`; bounds (2, 3) are in its file frame."""
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
        """Accept a worker's result, which then belongs to this thread."""
        model = self.models.get(model_id)
        if model is None:
            return
        if isinstance(event, FieldReady):
            self.set_field(model_id, event)
        else:
            self._actor_creator.take(model, event)

    def remove_model(self, model_id: str) -> None:
        model = self.models.pop(model_id, None)
        if model is None:
            return
        self.picture.abandon()
        for part in model.parts + model.proxies:
            self._actor_creator.drop(part)
        window = self.canvas.window if self.canvas.is_open else None
        for gpu_texture in model.gpu_textures.values():
            gpu_texture.release(window)
        if not self.models:
            self.canvas.origin = None

    def set_to_world(self, model_id: str, to_world: FloatArray) -> None:
        """Set the matrix (4, 4) from the file frame of a model to the World frame."""
        model = self.models[model_id]
        model.to_world = np.array(to_world, np.float64)
        model.from_world = np.asarray(np.linalg.inv(model.to_world), np.float64)
        if self.canvas.origin is None:
            self.set_origin(np.round(model.corners_world().mean(axis=0)))
        self._place_model(model)
        self._place_planes()
        self.picture.abandon()

    def set_visible(self, model_id: str, is_visible: bool) -> None:
        self.models[model_id].visible = is_visible
        self.picture.abandon()

    def set_hidden(self, model_id: str, is_hidden: BoolArray | None) -> None:
        """Hide the marked faces or points (n,) of a model; None shows all."""
        hidden_elements.hide(self.models[model_id], is_hidden)
        self.picture.abandon()

    def corners(self, *, is_closed: bool = False) -> FloatArray:
        """Return box corners (n, 3) of the visible models in the World frame.

        If `is_closed`, these are the corners of the models' chunks.
        """
        return self._contents.corners(is_closed=is_closed)

    def all_corners(self) -> FloatArray:
        """Return the World box corners (n, 3) of models (or else of features) and cameras."""
        corners = self.corners(is_closed=True)
        if not len(corners):
            corners = self.features.corners()
        return np.concatenate([corners, self.cameras.corners()])

    # -- appearance

    def set_mode(self, mode: str) -> None:
        """Set the display mode; see DISPLAY_MODES.

        Raises
        ------
        ValueError
            If there is no such mode.
        """
        if mode not in DISPLAY_MODES:
            raise ValueError(f"display mode {mode!r}; one of {', '.join(DISPLAY_MODES)}")
        self.look.mode = mode
        for model in self.models.values():
            if any(p.is_tinted for p in model.parts + model.proxies) != self.look.shows_field(
                model
            ):
                self.look.tint(model)
        self._restyle_parts()

    def set_lit(self, mode: str, is_lit: bool) -> None:
        """Set whether a light at the viewer shades the meshes in a display mode."""
        self.look.lit[mode] = is_lit
        self._restyle_parts()

    def set_point_size(self, pixels: float | None) -> None:
        """Set the point size in logical pixels; None closes the gaps between points."""
        self.look.point_size = pixels
        self._restyle_parts()

    def _restyle_parts(self) -> None:
        for model in self.models.values():
            for part in model.parts + model.proxies:
                self.look.style_part(model, part)
        self.picture.abandon()

    def set_eye_dome(self, is_enabled: bool) -> None:
        """Set whether clouds at rest have eye-dome lighting."""
        self.picture.eye_dome = is_enabled
        self.picture.abandon()

    def set_field(self, model_id: str, field: FieldReady | None) -> None:
        """Set the colours of a model's field, or remove them if None."""
        model = self.models[model_id]
        model.field = field
        self.look.tint(model)
        self.picture.abandon()

    def scales(self) -> list[tuple[Scale, str]]:
        """Return the colour scales of all displayed fields, with the ids of their models."""
        return [
            (model.field.scale, model.model_id)
            for model in self._contents.visible()
            if model.field is not None and self.look.shows_field(model)
        ]

    # -- features

    def set_features(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add or replace drawings by id, and remove those with the value None."""
        if self.canvas.origin is None:
            for drawing in changes.values():
                if drawing is not None and len(drawing.line):
                    self.set_origin(np.round(np.asarray(drawing.line, float)[0]))
                    break
        self.features.change(changes)

    def set_selected(self, ids: Iterable[str]) -> None:
        """Emphasise only these features."""
        self.features.select(frozenset(ids))

    # -- coordinates of VTK

    def set_origin(self, origin: FloatingArray) -> None:
        """Set the World position (3,) of the origin of VTK's 32-bit coordinates."""
        place = self.canvas.origin = np.asarray(origin, np.float64)
        self.features.set_origin(place)
        self.cameras.set_origin(place)
        self._place_planes()
        for model in self.models.values():
            self._place_model(model)

    def _place_model(self, model: ModelScene) -> None:
        placement = self.canvas.placement(model.to_world, model.origin)
        for part in model.parts + model.proxies:
            part.actor.SetUserMatrix(placement)

    def set_clip(self, box: ClipBox | None) -> None:
        """Set the clipping box for drawing and picking, or None for no clipping."""
        previous_box, self._planes.box = self._planes.box, box
        self._place_planes()
        if (previous_box is None) != (box is None):
            self.features.clip(None if box is None else self._planes.all_planes())
        self.picture.abandon()

    def _place_planes(self) -> None:
        corners = (model.corners_world() for model in self.models.values())
        if self._planes.place(corners, self.canvas.start):
            for model in self.models.values():
                for part in model.parts + model.proxies:
                    self._planes.cut(part.actor)

    @property
    def clip_box(self) -> ClipBox | None:
        """Clipping box, or None for no clipping."""
        return self._planes.box

    # -- visibility

    def visibility(self, points: FloatArray, depth_tolerance: float = 0.0) -> BoolArray:
        """Return which World points (n, 3) are in the picture and not behind its surface.

        `depth_tolerance` is the tolerated distance behind the surface, metres.
        """
        return self._visibility.is_in_front(points, depth_tolerance)

    def pick(self, x: float, y: float, size: tuple[float, float]) -> Hit | None:
        """Return the front-most point of the visible models at a pixel, or None."""
        models = self._contents.visible()
        candidates = [model for model in models if not model.model_id.startswith(PREVIEW)]
        return picking.pick_front(candidates, self.camera, x, y, size, self._planes.box)

    def view_snapshot(self, ratio: float) -> ViewSnapshot | None:
        """Return a numerical description of the current view, or None before the first picture.

        Parameters
        ----------
        ratio : float
            Device pixels per logical pixel.
        """
        eye, canvas = self._visibility.eye, self.canvas
        if eye is None:
            return None
        while self.picture.refining and not self.picture.refine():
            # Parts that are not drawn yet would be treated as empty space.
            pass
        buffer = canvas.surface_depth()[::-1].astype(np.float64)
        depth = np.where(buffer < 1.0, eye.depth_from_buffer(buffer), np.inf).astype(np.float32)
        return ViewSnapshot(
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
