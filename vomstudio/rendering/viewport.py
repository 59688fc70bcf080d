"""The 3-D view: a plain Qt widget over an off-screen VTK scene.

VTK draws into a window of its own that never appears; its pixels become a QImage, and the widget
paints that and, over it, labels, compass, scale bar and preview. So there is one graphics context
that Qt knows nothing of: nothing to be torn down in the right order, a grab of the window is never
black, and moving the cursor repaints the overlays without drawing the outcrop again.

The scene is drawn only inside `paintEvent` while the camera moves (once per step, coalesced by
`update()`), and by a zero timer, piece by piece, after it has come to rest. An idle view draws
nothing.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QCloseEvent,
    QColor,
    QHideEvent,
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QShowEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frusta import Frustum, frustum_at
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.octree import POINT_BUDGET
from vomstudio.rendering import painting
from vomstudio.rendering.camera import STANDARD_VIEWS, VIEW_ALIASES, Camera
from vomstudio.rendering.cliphandles import ClipHandles
from vomstudio.rendering.clipping import ClipBox
from vomstudio.rendering.drawing import FeatureDrawing
from vomstudio.rendering.featurepicking import feature_at
from vomstudio.rendering.gestures import Gestures
from vomstudio.rendering.modelwork import ModelWork, Registered
from vomstudio.rendering.overlays import Overlays
from vomstudio.rendering.previewpainting import PreviewPainter
from vomstudio.rendering.scalars import ELEVATION, FieldStyle, Scale
from vomstudio.tools.types import Hit, Preview

if TYPE_CHECKING:
    from vomstudio.rendering.scene import Scene

Array = npt.NDArray[np.float64]

CAMERA_PIXELS = 9.0
REST_MS = 250
BACKGROUND = QColor.fromRgbF(0.36, 0.375, 0.39)
"""The scene's own, until there is a scene."""


class Viewport(QWidget):
    """See the module. Pixels in the interface are logical, from the widget's top left corner."""

    pointer = Signal(object)
    """PointerEvent"""
    camera_changed = Signal()
    first_frame = Signal()
    model_stage = Signal(str, str)
    """model id and "shown", "complete" or "pickable" """
    problem = Signal(str)
    """One sentence about something that cannot be drawn as it should."""
    field_shown = Signal(str)
    """model id: the colours of its field are there, and `scale_of` tells them"""
    clip_changed = Signal(object)
    """ClipBox, while a handle is dragged"""

    _handed = Signal()
    _imported = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setMinimumSize(160, 120)
        self.point_budget = POINT_BUDGET
        """How many points of a cloud may be there to be drawn."""

        self._scene: Scene | None = None
        self._closed = False
        self.camera = Camera()
        self.preview: Preview | None = None
        self.overlays = Overlays(self.camera)
        self.clip = ClipHandles(self.camera)
        self.gestures = Gestures(self)
        self.gestures.pointer.connect(self.pointer)
        self._waiting: list[Callable[[], None]] = []
        self._features: dict[str, FeatureDrawing] = {}
        self._selected: frozenset[str] = frozenset()
        self._frusta: tuple[Frustum, ...] = ()
        self._chosen_cameras: frozenset[str] = frozenset()
        self._hot_camera: str | None = None
        self._fitted: Array | None = None
        self._frame_dirty = True
        self._features_dirty = False
        self._moving = False
        self._picture: QImage | None = None
        self._pixels: npt.NDArray[np.uint8] | None = None
        self._base: QImage | None = None
        self._first_done = False
        self._warming: Iterator[None] = iter(())
        self._stages: dict[str, set[str]] = {}

        self._work = ModelWork(lambda: self._handed.emit())
        self._framing: set[str] = set()
        self._hidden: set[str] = set()
        self._transforms: dict[str, Array] = {}
        self._styles: dict[str, FieldStyle] = {}
        self._mode = "textured"

        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(REST_MS)
        self._rest.timeout.connect(self._come_to_rest)
        self._refine = QTimer(self)
        self._refine.setSingleShot(True)
        self._refine.setInterval(0)
        self._refine.timeout.connect(self._refine_step)
        self._handed.connect(self._take, Qt.ConnectionType.QueuedConnection)
        self._imported.connect(self._start, Qt.ConnectionType.QueuedConnection)
        self._importer: threading.Thread | None = None

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(900, 600)

    # -- start and end

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        if self._importer is None and self._scene is None and not self._closed:
            self._importer = threading.Thread(target=self._import, name="vtk import", daemon=True)
            QTimer.singleShot(0, self._importer.start)

    def _import(self) -> None:
        import vomstudio.rendering.preparation
        import vomstudio.rendering.scene  # noqa: F401 - so that the window's thread finds it ready

        if not self._closed:
            self._imported.emit()
        # Wanted as soon as a model is opened.
        import PIL.JpegImagePlugin  # noqa: F401
        import vtkmodules.vtkFiltersCore  # noqa: F401

    def _start(self) -> None:
        if self._scene is not None or self._closed:
            return
        from vomstudio.rendering.scene import Scene

        scene = Scene()
        scene.camera = self.camera
        ratio = self.devicePixelRatioF()
        scene.look.point_scale = ratio
        scene.start(max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio)))
        scene.features.set_scale(ratio)
        scene.cameras.set_scale(ratio)
        scene.cameras.show(self._frusta)
        scene.cameras.choose(self._chosen_cameras)
        self._scene = scene
        if self._features:
            scene.set_features(self._features)
        scene.set_selected(self._selected)
        waiting, self._waiting = self._waiting, []
        for job in waiting:
            job()
        self._frame_dirty = True
        self.update()

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        self.shutdown()
        super().closeEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802 - Qt's name
        self._refine.stop()
        super().hideEvent(event)

    def shutdown(self) -> None:
        """Stop every worker and release VTK. The view cannot be used afterwards; calling it again
        does nothing. The window calls it before it closes."""
        if self._closed:
            return
        self._closed = True
        for timer in (self._rest, self._refine):
            timer.stop()
        self.gestures.stop()
        if self._importer is not None and self._importer.is_alive():
            self._importer.join()
        self._work.close()
        self._waiting.clear()
        # Half way through it would keep the scene.
        self._warming = iter(())
        if self._scene is not None:
            self._scene.close()
            self._scene = None

    # -- models

    def add_model(
        self,
        model_id: str,
        data: Mesh | PointCloud,
        to_world: npt.NDArray[np.float64],
        *,
        frame_camera: bool,
    ) -> None:
        """Show a model; returns at once and prepares it beside the window.

        to_world : (4, 4) float64 similarity from the file's frame to World
        frame_camera : look at the whole of it as soon as its size is known
        """
        if self._closed:
            return
        self.remove_model(model_id)
        stop = self._work.expect(model_id)
        self._stages[model_id] = set()
        self._transforms[model_id] = np.array(to_world, np.float64)
        if frame_camera:
            self._framing.add(model_id)

        def begin() -> None:
            if not stop.is_set() and self._scene is not None:
                self._work.prepare(
                    model_id,
                    data,
                    texture_limit=self._scene.texture_limit,
                    whole_side=self._scene.whole_texture_side,
                    budget=self.point_budget,
                )

        self._when_started(begin)

    def _when_started(self, job: Callable[[], None]) -> None:
        if self._scene is not None:
            job()
        else:
            self._waiting.append(job)

    def _take(self) -> None:
        """Accept what the workers have handed over, for a few milliseconds at a time."""
        if self._scene is None or self._closed:
            return
        from vomstudio.rendering import preparation

        until = time.perf_counter() + 0.010
        changed = False
        while time.perf_counter() < until and (found := self._work.next()):
            model_id, event = found
            if isinstance(event, preparation.Problem):
                self.problem.emit(event.text)
                continue
            if isinstance(event, Registered):
                self._register(model_id, event)
            elif isinstance(event, preparation.FieldReady):
                self._take_field(model_id, event)
                continue
            else:
                self._scene.take(model_id, event)
            if isinstance(event, preparation.ChunksDone):
                self._color(model_id)
            if isinstance(event, preparation.LocatorReady):
                self._reach(model_id, "pickable")
            else:
                changed = True
        if self._work.waiting:
            self._handed.emit()
        if changed:
            self._content_changed()

    def _register(self, model_id: str, event: Registered) -> None:
        assert self._scene is not None
        self._scene.add_model(
            model_id, event.data, self._transforms[model_id], event.bounds, event.origin
        )
        self._scene.set_visible(model_id, model_id not in self._hidden)
        if model_id in self._framing:
            self._framing.discard(model_id)
            self.camera.fit(self._scene.models[model_id].corners_world(), self.extent())
            self.moved()
            # Nobody is moving it: what comes now is to be drawn as it will stay.
            self._moving = False
            self._rest.start(30)

    def _content_changed(self) -> None:
        """Something new can be drawn: soon, but not for every single piece of it."""
        assert self._scene is not None
        first = not all(
            "shown" in self._stages.get(m.model_id, ()) for m in self._scene.models.values()
        )
        if first and any(m.proxies or m.parts for m in self._scene.models.values()):
            self._frame_dirty = True
            self.update()
        if not self._rest.isActive():
            self._rest.start(30)

    def _reach(self, model_id: str, stage: str) -> None:
        reached = self._stages.setdefault(model_id, set())
        if stage not in reached:
            reached.add(stage)
            self.model_stage.emit(model_id, stage)

    def remove_model(self, model_id: str) -> None:
        """Forget a model; an unknown id is ignored."""
        self._work.forget(model_id)
        self._stages.pop(model_id, None)
        self._transforms.pop(model_id, None)
        self._forget_field(model_id)
        self._framing.discard(model_id)
        self._hidden.discard(model_id)
        if self._scene is not None and model_id in self._scene.models:
            self._scene.remove_model(model_id)
            self._redraw()

    def set_model_visible(self, model_id: str, visible: bool) -> None:
        (self._hidden.discard if visible else self._hidden.add)(model_id)
        if self._scene is not None and model_id in self._scene.models:
            self._scene.set_visible(model_id, visible)
            self._redraw()

    def set_model_to_world(self, model_id: str, to_world: npt.NDArray[np.float64]) -> None:
        """Place a model anew, as after registering it."""
        if model_id not in self._transforms:
            return
        self._transforms[model_id] = np.array(to_world, np.float64)
        if self._scene is not None and model_id in self._scene.models:
            self._scene.set_to_world(model_id, self._transforms[model_id])
            self._redraw()
            if model_id in self._styles and self._styles[model_id].name == ELEVATION:
                self._color(model_id)

    # -- display

    def set_display(self, mode: str) -> None:
        """ "textured", "vertex_colors", "plain shaded", "wireframe", "points" or "field"."""
        self._mode = mode

        def apply(scene: Scene) -> None:
            if mode != "field":
                # The colours would only take memory.
                for model_id in list(scene.models):
                    scene.set_field(model_id, None)
            scene.set_mode(mode)
            for model_id in self._styles:
                self._color(model_id)

        self._display(apply)

    def set_lit(self, mode: str, lit: bool) -> None:
        """Whether a light at the viewer shades the meshes in a display mode."""
        self._display(lambda scene: scene.set_lit(mode, lit))

    def set_point_size(self, pixels: float | None) -> None:
        """Size of the points of clouds in logical pixels; None closes their surface."""
        self._display(lambda scene: scene.set_point_size(pixels))

    def set_eye_dome(self, on: bool) -> None:
        """Shade clouds at rest by how far pixels lie behind their neighbours."""
        self._display(lambda scene: scene.set_eye_dome(on))

    def _display(self, change: Callable[[Scene], None]) -> None:
        def apply() -> None:
            assert self._scene is not None
            change(self._scene)
            self._renew()

        self._when_started(apply)

    def _renew(self) -> None:
        """The models look different: draw the whole picture anew. The old one stays until it is
        there, unless something can stand for the models at once."""
        assert self._scene is not None
        if any(m.visible and m.proxies for m in self._scene.models.values()):
            self._redraw()
            return
        self._scene.abandon()
        self._refine.stop()
        if not self._frame_dirty:
            self._rest.start(1)

    # -- fields

    def set_field(self, model_id: str, style: FieldStyle | None, caption: str = "") -> None:
        """The field that the display mode "field" shows of a model; None for none.

        caption : names the model where several of them show a field
        """
        self.overlays.captions[model_id] = caption
        if style == self._styles.get(model_id):
            return
        self._forget_field(model_id)
        if style is not None:
            self._styles[model_id] = style
            self._color(model_id)
        elif self._scene is not None and model_id in self._scene.models:
            self._scene.set_field(model_id, None)
            self._renew()

    def _forget_field(self, model_id: str) -> None:
        self._styles.pop(model_id, None)
        self._work.forget_field(model_id)

    def scale_of(self, model_id: str) -> Scale | None:
        """What the colours of a model mean, where it shows a field."""
        model = None if self._scene is None else self._scene.models.get(model_id)
        if model is None or model.field is None or self._mode != "field":
            return None
        return model.field.scale

    def _color(self, model_id: str) -> None:
        """Have a worker make the colours of a model's field, where they are wanted now."""
        model = None if self._scene is None else self._scene.models.get(model_id)
        style = self._styles.get(model_id)
        if model is None or style is None or self._mode != "field" or not model.chunks_done:
            return
        self._work.color(
            model_id,
            model.data,
            style,
            model.to_world.copy(),
            [part.rows for part in model.proxies],
            [part.rows for part in model.parts],
        )

    def _take_field(self, model_id: str, event: Any) -> None:
        assert self._scene is not None
        if self._mode == "field" and self._styles.get(model_id) == event.style:
            self._scene.take(model_id, event)
            self._renew()
            self.field_shown.emit(model_id)

    # -- clipping box

    @property
    def clip_box(self) -> ClipBox | None:
        return self.clip.box

    def set_clip_box(self, box: ClipBox | None, *, handles: bool = True) -> None:
        """Show and pick only what lies in a box; None for everything. `handles` to drag its faces
        with are drawn or not."""
        if handles != self.clip.handles:
            self.clip.handles = handles
            self.update()
        if box != self.clip.box:
            self.clip.box = box
            self.overlays.annotations.forget()

            def apply() -> None:
                assert self._scene is not None
                self._scene.set_clip(self.clip.box)
                self._redraw()

            self._when_started(apply)

    def face_at(self, x: float, y: float) -> int | None:
        """Which handle of the clipping box lies under a pixel."""
        return self.clip.face_at(x, y, self.extent())

    def drag_face(self, face: int, x: float, y: float) -> None:
        """Move a face of the clipping box to a pixel."""
        if self.clip.drag(face, x, y, self.extent()):
            self.overlays.annotations.forget()
            if self._scene is not None:
                self._scene.set_clip(self.clip.box)
            self._stir()
            self.clip_changed.emit(self.clip.box)

    def face_left(self) -> None:
        """The face that was dragged is let go."""
        self._rest.start(30)
        self.update()

    # -- picking and projecting

    def extent(self) -> tuple[float, float]:
        return float(max(self.width(), 1)), float(max(self.height(), 1))

    def pick(self, x: float, y: float) -> Hit | None:
        """The front-most point of a visible model at a pixel."""
        if self._scene is None:
            return None
        return self._scene.pick(x, y, self.extent())

    def world_of(self, hit: Hit) -> Array:
        """World position (3,) of a hit."""
        m = self._transforms[hit.model_id]
        return np.asarray(m[:3, :3] @ np.array(hit.position) + m[:3, 3])

    def project(
        self, points_world: npt.NDArray[np.float64]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
        """Pixels (n, 2) of World points (n, 3), and whether each lies inside the view and not
        behind the surface as it was last drawn."""
        points = np.asarray(points_world, np.float64).reshape(-1, 3)
        pixels, depth = self.camera.project(points, self.extent())
        if self._scene is not None:
            return pixels, self._scene.seen(points)
        width, height = self.extent()
        with np.errstate(invalid="ignore"):
            inside = (
                (depth > 0)
                & (pixels[:, 0] >= 0)
                & (pixels[:, 0] < width)
                & (pixels[:, 1] >= 0)
                & (pixels[:, 1] < height)
            )
        return pixels, inside

    def ray(self, x: float, y: float) -> tuple[Array, Array]:
        """Origin and unit direction in World of the line of sight through a pixel."""
        return self.camera.ray(x, y, self.extent())

    # -- features

    def set_features(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add, replace or (None) remove drawings by id, all at once."""
        for key, drawing in changes.items():
            if drawing is None:
                self._features.pop(key, None)
            else:
                self._features[key] = drawing
        self.overlays.annotations.forget()
        if self._scene is not None:
            self._scene.set_features(changes)
        self._features_dirty = True
        self.update()

    @property
    def features(self) -> Mapping[str, FeatureDrawing]:
        """What is drawn, by id."""
        return self._features

    def set_selected(self, ids: Iterable[str]) -> None:
        """Emphasise these features, and no others."""
        self._selected = frozenset(ids)
        if self._scene is not None:
            self._scene.set_selected(self._selected)
        self._features_dirty = True
        self.update()

    def pick_feature(self, x: float, y: float, *, discs: bool = True) -> str | None:
        """Id of the feature whose label, symbol, line or disc lies under a pixel, in this order."""
        if (found := self.overlays.annotations.at(x, y)) is not None:
            return found
        # What is cut away cannot be meant.
        shown = [d for d in self._features.values() if d.visible and self.clip.meets(d)]
        return feature_at(shown, x, y, self.camera, self.extent(), discs=discs)

    # -- cameras of photos

    def set_cameras(self, frusta: Sequence[Frustum]) -> None:
        """Where photos were taken, in World; none for nothing."""
        before = self._frusta
        self._frusta, self._hot_camera = tuple(frusta), None
        if not before and not self._frusta:
            return
        if self._scene is not None:
            self._scene.cameras.show(self._frusta)
            # What is far from the models asks for another range of depths.
            self._redraw()

    def set_chosen_cameras(self, names: Iterable[str]) -> None:
        """Emphasise the cameras of these photos, and no others."""
        chosen = frozenset(names)
        if chosen == self._chosen_cameras:
            return
        self._chosen_cameras = chosen
        if self._scene is not None:
            self._scene.cameras.choose(chosen)
        if self._frusta:
            self._features_dirty = True
            self.update()

    def camera_at(self, x: float, y: float) -> str | None:
        """The photo whose camera lies under a pixel."""
        if not self._frusta:
            return None
        extent = self.extent()
        tips, _ = self.camera.project(np.stack([f.tip for f in self._frusta]), extent)
        bases = np.concatenate([f.corners for f in self._frusta])
        corners = self.camera.project(bases, extent)[0].reshape(-1, 4, 2)
        found = frustum_at(tips, corners, x, y, CAMERA_PIXELS)
        return None if found is None else self._frusta[found].name

    def _show_hot_camera(self, x: float, y: float) -> None:
        name = self.camera_at(x, y)
        if name != self._hot_camera:
            self._hot_camera = name
            self.update()

    def _paint_hot_camera(self, painter: QPainter) -> None:
        place = next((f.tip for f in self._frusta if f.name == self._hot_camera), None)
        if place is None or self._hot_camera is None:
            return
        (at,), _ = self.camera.project(place[None], self.extent())
        if np.isfinite(at).all():
            painting.draw_name(painter, float(at[0]), float(at[1]), self._hot_camera, self.rect())

    def set_preview(self, preview: Preview | None) -> None:
        """What an unfinished tool shows; None for nothing."""
        before, self.preview = self.preview, preview
        area = None if preview is None else preview.area
        if area is not (None if before is None else before.area) and self._scene is not None:
            color = (1.0, 1.0, 1.0) if preview is None else preview.color
            self._scene.features.areas.set_live(area, color)
            self._features_dirty = True
        self.update()

    # -- camera

    @property
    def orthographic(self) -> bool:
        return self.camera.orthographic

    def set_orthographic(self, orthographic: bool) -> None:
        """Switch the projection; what lies at the pivot's distance keeps its size."""
        if orthographic != self.camera.orthographic:
            self.camera.orthographic = orthographic
            self.moved()

    def home(self) -> None:
        """See all visible models from the south and a little above, as on first sight."""
        self.camera.look_along(0.0, 35.0)
        self._fit_all()

    def _fit_all(self) -> None:
        corners = np.zeros((0, 3))
        if self._scene is not None:
            corners = self._scene.corners(close=True)
            if not len(corners):
                corners = self._scene.features.corners()
            corners = np.concatenate([corners, self._scene.cameras.corners()])
        self._show_all(corners)

    def _show_all(self, points: npt.NDArray[np.float64]) -> None:
        self.camera.fit(points, self.extent())
        self.moved()
        self._fitted = points

    def frame(self, points_world: npt.NDArray[np.float64]) -> None:
        """Show all these World points (n, 3), keeping the direction of view."""
        self._show_all(np.asarray(points_world, float))

    def set_pivot(self, point_world: npt.NDArray[np.float64]) -> None:
        """Orbit about this World point from now on; the view stays as it is."""
        self.camera.set_pivot(np.asarray(point_world, float))
        self._frame_dirty = True
        self.update()

    def standard_view(self, name: str) -> None:
        """Look in a direction named by where the viewer looks ("north" stands in the south):
        north, northeast, east, southeast, south, southwest, west, northwest, down, up; "top" is
        "down" and "bottom" is "up". Everything visible is framed."""
        trend, plunge = STANDARD_VIEWS[VIEW_ALIASES.get(name, name)]
        self.camera.look_along(trend, plunge)
        self._fit_all()

    def look_along(self, trend_deg: float, plunge_deg: float) -> None:
        """Look along a direction; the pivot keeps its place. Image up is Up projected, North
        where the view is within 1 degree of vertical."""
        self.camera.look_along(trend_deg, plunge_deg)
        self.moved()

    def view_direction(self) -> tuple[float, float]:
        """Trend and plunge (degrees, plunge positive downwards) of where the viewer looks."""
        return self.camera.trend_plunge()

    def metres_per_pixel(self) -> float:
        """Metres across one logical pixel at the pivot's distance (anywhere if orthographic)."""
        return self.camera.metres_per_pixel(self.extent()[1])

    def seen(self) -> tuple[Array, float, float]:
        """The middle of the view at the pivot's distance (3,), World, and the width and height in
        metres that are seen there."""
        camera, scale = self.camera, self.metres_per_pixel()
        centre = camera.position + camera.distance * camera.direction
        return centre, scale * self.width(), scale * self.height()

    def camera_state(self) -> dict[str, Any]:
        """The view as JSON-able values, for `set_camera_state`."""
        return self.camera.as_dict()

    def set_camera_state(self, state: dict[str, Any]) -> None:
        """Take back a view; raises ValueError where it is none, and changes nothing then."""
        self.camera.restore(state)
        self._framing.clear()
        self.moved()

    def set_frame(self, *, north_known: bool, unit_known: bool = True) -> None:
        """Whether World's y is North; if not, the compass says "local frame". Whether its unit is
        the metre; if not, the scale bar counts units."""
        self.overlays.north_known = north_known
        self.overlays.unit_known = unit_known
        self._features_dirty = True
        self.update()

    def moved(self) -> None:
        """The camera has changed: draw once in the next paint, rest a little later."""
        self._fitted = None
        self._stir()
        self.camera_changed.emit()

    def _stir(self) -> None:
        self._moving = True
        self._frame_dirty = True
        if self._scene is not None:
            self._scene.abandon()
        self._refine.stop()
        self._rest.start(REST_MS)
        self.update()

    def _redraw(self) -> None:
        """The models have changed: draw again."""
        self._frame_dirty = True
        self._refine.stop()
        if not self._rest.isActive():
            self._rest.start(30)
        self.update()

    # -- drawing

    def _come_to_rest(self) -> None:
        scene = self._scene
        self._moving = False
        if scene is None or self._closed or not self.isVisible():
            return
        if not self._frame_dirty:
            scene.look_around()
        if scene.complete and not self._frame_dirty:
            # The picture stands; labels that had no room while it moved may have some now.
            self._base = None
            self.update()
            self._report_stages()
            return
        unfinished = any(
            m.visible and m.proxies and not m.chunks_done for m in scene.models.values()
        )
        if unfinished:
            if self._frame_dirty:
                self.update()
            return
        if scene.waits:
            self._rest.start(50)
            return
        scene.begin_rest()
        self._refine.start()

    def _refine_step(self) -> None:
        scene = self._scene
        if scene is None or self._closed:
            return
        if not scene.refining:
            return
        if scene.refine():
            self._frame_dirty = False
            self._features_dirty = False
            self._grab_picture()
            self._report_stages()
            self.update()
            if not scene.complete:
                # More has arrived while this frame was being made.
                self._rest.start(30)
        else:
            self._refine.start()

    def _grab_picture(self) -> None:
        assert self._scene is not None
        # The picture's memory is the array's, which therefore has to live as long.
        self._pixels = np.ascontiguousarray(self._scene.pixels()[::-1])
        height, width = self._pixels.shape[:2]
        self._picture = QImage(
            self._pixels.data, width, height, 4 * width, QImage.Format.Format_RGBX8888
        )
        self._picture.setDevicePixelRatio(self.devicePixelRatioF())
        self._base = None

    def _report_stages(self) -> None:
        assert self._scene is not None
        # Whoever is told may take a model away.
        for model in list(self._scene.models.values()):
            if (model.proxies and self._scene.showing_proxy) or any(
                p.uploaded for p in model.parts
            ):
                self._reach(model.model_id, "shown")
            if self._scene.complete and model.chunks_done and model.textures_done and model.settled:
                self._reach(model.model_id, "complete")

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        scene = self._scene
        if scene is not None and not self._closed:
            if self._frame_dirty and not scene.refining:
                self._frame_dirty = self._features_dirty = False
                scene.draw(moving=self._moving)
                self._grab_picture()
                self._report_stages()
                if scene.more_to_come:
                    self._frame_dirty = True
                    QTimer.singleShot(0, self.update)
                if not scene.complete and not self._rest.isActive():
                    self._rest.start(30)
            elif self._features_dirty:
                self._features_dirty = False
                scene.draw_features()
                self._grab_picture()
                if not scene.complete and not scene.refining and not self._rest.isActive():
                    self._rest.start(30)
        if self._base is None:
            self._compose()
        painter = QPainter(self)
        if self._base is not None:
            painter.drawImage(QPointF(0.0, 0.0), self._base)
        letters = "ENZ" if self.overlays.north_known else "xyz"
        self.clip.paint(painter, self.extent(), self.gestures.held_face, letters)
        if self._hot_camera is not None:
            self._paint_hot_camera(painter)
        if self.preview is not None:
            PreviewPainter(painter, self.camera, self.extent(), self.project).paint(
                self.preview, self.gestures.cursor, self.gestures.hot_handle
            )
        painter.end()
        if scene is not None and not self._first_done:
            self._first_done = True
            self.first_frame.emit()
            self._warming = scene.warm_up()
            QTimer.singleShot(0, self._warm)

    def _warm(self) -> None:
        if self._scene is not None and not self._closed and not self._scene.models:
            for _ in self._warming:
                self._frame_dirty = True
                QTimer.singleShot(0, self._warm)
                return
            self.update()

    def _compose(self) -> None:
        """The picture with all that moves only with the camera."""
        width, height = self.extent()
        if self._picture is not None:
            # Qt paints quickest upon its own order of bytes, and the screen takes it as it is.
            base = self._picture.convertToFormat(QImage.Format.Format_RGB32)
        else:
            ratio = self.devicePixelRatioF()
            base = QImage(
                max(1, round(width * ratio)),
                max(1, round(height * ratio)),
                QImage.Format.Format_RGBX8888,
            )
            base.setDevicePixelRatio(ratio)
        painter = QPainter(base)
        if self._picture is None:
            painter.fillRect(QRectF(0.0, 0.0, width, height), BACKGROUND)
        elif self._scene is not None and (self._scene.models or self._features):
            self.overlays.paint(
                painter,
                (width, height),
                {k: d for k, d in self._features.items() if self.clip.meets(d)},
                self._selected,
                self._scales(),
                self._project_unclipped,
                moving=self._moving,
            )
        painter.end()
        self._base = base

    def _scales(self) -> list[tuple[Scale, str]]:
        assert self._scene is not None
        return [
            (m.field.scale, m.model_id)
            for m in self._scene.models.values()
            if m.visible and m.field is not None and self._scene.look.shows_field(m)
        ]

    def _project_unclipped(self, points: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        pixels, seen = self.project(points)
        box = self.clip.box
        return pixels, seen if box is None else seen & box.holds(points)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        if self._fitted is not None:
            # Nobody has moved since everything was brought into view: keep it in view.
            self._show_all(self._fitted)
        self._rescale()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.overlays.annotations.forget_font()
            self._features_dirty = True

    def _rescale(self) -> None:
        self._base = None
        if self._scene is None:
            return
        ratio = self.devicePixelRatioF()
        self._scene.look.point_scale = ratio
        self._scene.features.set_scale(ratio)
        self._scene.cameras.set_scale(ratio)
        self._scene.resize(
            max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio))
        )
        self._moving = True
        self._frame_dirty = True
        self._refine.stop()
        self._rest.start(REST_MS)
        self.update()

    # -- mouse

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.press(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.move(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.release(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.double_click(event)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.wheel(event)

    def hover(self, x: float, y: float, *, free: bool) -> None:
        """The cursor stands at a pixel; `free` where no vertex of the preview is under it."""
        face = self.face_at(x, y) if free else None
        if face != self.clip.hot:
            self.clip.hot = face
            self.update()
        if self._frusta:
            self._show_hot_camera(x, y)

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.leave()
        if self.preview is not None or self._hot_camera is not None:
            self._hot_camera = None
            self.update()
        super().leaveEvent(event)
