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

import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
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
from vomstudio.rendering import barpainting, painting
from vomstudio.rendering.annotations import Annotations
from vomstudio.rendering.camera import STANDARD_VIEWS, VIEW_ALIASES, Camera
from vomstudio.rendering.clipping import FACES, ClipBox, along_axis
from vomstudio.rendering.drawing import FeatureDrawing
from vomstudio.rendering.featurepicking import feature_at
from vomstudio.rendering.modelwork import ModelWork, Registered
from vomstudio.rendering.previewpainting import PreviewPainter
from vomstudio.rendering.scalars import ELEVATION, FieldStyle, Scale
from vomstudio.tools.types import Button, Hit, Pointer, PointerEvent, Preview

if TYPE_CHECKING:
    from vomstudio.rendering.scene import Scene

Array = npt.NDArray[np.float64]

CLICK_PIXELS = 4.0
HANDLE_PIXELS = 9.0
FACE_PIXELS = 14.0
CAMERA_PIXELS = 9.0
REST_MS = 250
BACKGROUND = QColor.fromRgbF(0.36, 0.375, 0.39)
"""The scene's own, until there is a scene."""
HOVER_S = 0.016
STILL_MS = 150
BRUSH_STEPS = 40
DEGREES_PER_PIXEL = 0.35
ZOOM_PER_NOTCH = 0.85

BUTTONS = {
    Qt.MouseButton.LeftButton: Button.LEFT,
    Qt.MouseButton.MiddleButton: Button.MIDDLE,
    Qt.MouseButton.RightButton: Button.RIGHT,
}


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
        self.orbit_button = Qt.MouseButton.LeftButton
        """The right one leaves drags with the left one to the tool, from the press on."""
        self.navigation = "turntable"
        self.point_budget = POINT_BUDGET
        """How many points of a cloud may be there to be drawn."""

        self._scene: Scene | None = None
        self._closed = False
        self._camera = Camera()
        self._waiting: list[Callable[[], None]] = []
        self._features: dict[str, FeatureDrawing] = {}
        self._selected: frozenset[str] = frozenset()
        self._frusta: tuple[Frustum, ...] = ()
        self._chosen_cameras: frozenset[str] = frozenset()
        self._hot_camera: str | None = None
        self._preview: Preview | None = None
        self._fitted: Array | None = None
        self._north_known = True
        self._unit_known = True
        self._frame_dirty = True
        self._features_dirty = False
        self._moving = False
        self._picture: QImage | None = None
        self._pixels: npt.NDArray[np.uint8] | None = None
        self._base: QImage | None = None
        self._first_done = False
        self._warming: Iterator[None] = iter(())
        self._stages: dict[str, set[str]] = {}
        self._annotations = Annotations()
        self._cursor: QPointF | None = None

        self._press: QPointF | None = None
        self._press_button = Qt.MouseButton.NoButton
        self._press_handle: int | None = None
        self._last = QPointF()
        self._action: str | None = None
        self._action_depth: float | None = None
        self._last_hover = 0.0
        self._hover_event: PointerEvent | None = None
        self._hot_handle: int | None = None

        self._work = ModelWork(lambda: self._handed.emit())
        self._framing: set[str] = set()
        self._hidden: set[str] = set()
        self._transforms: dict[str, Array] = {}
        self._styles: dict[str, FieldStyle] = {}
        self._captions: dict[str, str] = {}
        self._bars: list[barpainting.ColorBar] = []
        self._mode = "textured"
        self._clip: ClipBox | None = None
        self._clip_handles = True
        self._press_face: int | None = None
        self._hot_face: int | None = None

        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(REST_MS)
        self._rest.timeout.connect(self._come_to_rest)
        self._refine = QTimer(self)
        self._refine.setSingleShot(True)
        self._refine.setInterval(0)
        self._refine.timeout.connect(self._refine_step)
        self._hover = QTimer(self)
        self._hover.setSingleShot(True)
        self._hover.timeout.connect(self._emit_hover)
        # A tool whose figures lag behind its drag catches up where the cursor stands still.
        self._still = QTimer(self)
        self._still.setInterval(STILL_MS)
        self._still.timeout.connect(self._stand_still)
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
        scene.camera = self._camera
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
        for timer in (self._rest, self._refine, self._hover, self._still):
            timer.stop()
        if self._importer is not None and self._importer.is_alive():
            self._importer.join()
        self._work.close()
        self._waiting.clear()
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
            self._camera.fit(self._scene.models[model_id].corners_world(), self._extent())
            self._moved()
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
        self._captions[model_id] = caption
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
        return self._clip

    def set_clip_box(self, box: ClipBox | None, *, handles: bool = True) -> None:
        """Show and pick only what lies in a box; None for everything. `handles` to drag its faces
        with are drawn or not."""
        if handles != self._clip_handles:
            self._clip_handles = handles
            self.update()
        if box != self._clip:
            self._clip = box
            self._annotations.forget()

            def apply() -> None:
                assert self._scene is not None
                self._scene.set_clip(self._clip)
                self._redraw()

            self._when_started(apply)

    def _clip_places(self) -> tuple[Array, Array, list[bool]]:
        """Pixels of the box's corners and handles, and which handles can be dragged from here."""
        assert self._clip is not None
        extent = self._extent()
        corners, _ = self._camera.project(self._clip.corners(), extent)
        centres = np.stack([self._clip.face_centre(*face) for face in FACES])
        pixels, _ = self._camera.project(centres, extent)
        usable = []
        for (axis, _side), at in zip(FACES, pixels, strict=True):
            good = bool(np.isfinite(at).all())
            if good:
                origin, direction = self._camera.ray(float(at[0]), float(at[1]), extent)
                good = along_axis(origin, direction, np.zeros(3), axis) is not None
            usable.append(good)
        return corners, pixels, usable

    def _face_at(self, x: float, y: float) -> int | None:
        """Which handle of the clipping box lies under a pixel."""
        if self._clip is None or not self._clip_handles:
            return None
        _, pixels, usable = self._clip_places()
        off = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        off = np.where(np.isfinite(off) & np.array(usable), off, np.inf)
        best = int(np.argmin(off))
        return best if off[best] <= FACE_PIXELS else None

    def _drag_face(self, at: QPointF) -> None:
        assert self._clip is not None
        assert self._press_face is not None
        axis, side = FACES[self._press_face]
        origin, direction = self._camera.ray(at.x(), at.y(), self._extent())
        value = along_axis(origin, direction, self._clip.face_centre(axis, side), axis)
        if value is None:
            return
        self._clip = self._clip.with_face(axis, side, value)
        self._annotations.forget()
        if self._scene is not None:
            self._scene.set_clip(self._clip)
        self._stir()
        self.clip_changed.emit(self._clip)

    # -- picking and projecting

    def _extent(self) -> tuple[float, float]:
        return float(max(self.width(), 1)), float(max(self.height(), 1))

    def pick(self, x: float, y: float) -> Hit | None:
        """The front-most point of a visible model at a pixel."""
        if self._scene is None:
            return None
        return self._scene.pick(x, y, self._extent())

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
        pixels, depth = self._camera.project(points, self._extent())
        if self._scene is not None:
            return pixels, self._scene.seen(points)
        width, height = self._extent()
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
        return self._camera.ray(x, y, self._extent())

    # -- features

    def set_features(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add, replace or (None) remove drawings by id, all at once."""
        for key, drawing in changes.items():
            if drawing is None:
                self._features.pop(key, None)
            else:
                self._features[key] = drawing
        self._annotations.forget()
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
        if (found := self._annotations.at(x, y)) is not None:
            return found
        # What is cut away cannot be meant.
        shown = [d for d in self._features.values() if d.visible and self._unclipped(d)]
        return feature_at(shown, x, y, self._camera, self._extent(), discs=discs)

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
        extent = self._extent()
        tips, _ = self._camera.project(np.stack([f.tip for f in self._frusta]), extent)
        bases = np.concatenate([f.corners for f in self._frusta])
        corners = self._camera.project(bases, extent)[0].reshape(-1, 4, 2)
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
        (at,), _ = self._camera.project(place[None], self._extent())
        if np.isfinite(at).all():
            painting.draw_name(painter, float(at[0]), float(at[1]), self._hot_camera, self.rect())

    def set_preview(self, preview: Preview | None) -> None:
        """What an unfinished tool shows; None for nothing."""
        before, self._preview = self._preview, preview
        area = None if preview is None else preview.area
        if area is not (None if before is None else before.area) and self._scene is not None:
            color = (1.0, 1.0, 1.0) if preview is None else preview.color
            self._scene.features.areas.set_live(area, color)
            self._features_dirty = True
        self.update()

    # -- camera

    @property
    def orthographic(self) -> bool:
        return self._camera.orthographic

    def set_orthographic(self, orthographic: bool) -> None:
        """Switch the projection; what lies at the pivot's distance keeps its size."""
        if orthographic != self._camera.orthographic:
            self._camera.orthographic = orthographic
            self._moved()

    def home(self) -> None:
        """See all visible models from the south and a little above, as on first sight."""
        self._camera.look_along(0.0, 35.0)
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
        self._camera.fit(points, self._extent())
        self._moved()
        self._fitted = points

    def frame(self, points_world: npt.NDArray[np.float64]) -> None:
        """Show all these World points (n, 3), keeping the direction of view."""
        self._show_all(np.asarray(points_world, float))

    def set_pivot(self, point_world: npt.NDArray[np.float64]) -> None:
        """Orbit about this World point from now on; the view stays as it is."""
        self._camera.set_pivot(np.asarray(point_world, float))
        self._frame_dirty = True
        self.update()

    def standard_view(self, name: str) -> None:
        """Look in a direction named by where the viewer looks ("north" stands in the south):
        north, northeast, east, southeast, south, southwest, west, northwest, down, up; "top" is
        "down" and "bottom" is "up". Everything visible is framed."""
        trend, plunge = STANDARD_VIEWS[VIEW_ALIASES.get(name, name)]
        self._camera.look_along(trend, plunge)
        self._fit_all()

    def look_along(self, trend_deg: float, plunge_deg: float) -> None:
        """Look along a direction; the pivot keeps its place. Image up is Up projected, North
        where the view is within 1 degree of vertical."""
        self._camera.look_along(trend_deg, plunge_deg)
        self._moved()

    def view_direction(self) -> tuple[float, float]:
        """Trend and plunge (degrees, plunge positive downwards) of where the viewer looks."""
        return self._camera.trend_plunge()

    def metres_per_pixel(self) -> float:
        """Metres across one logical pixel at the pivot's distance (anywhere if orthographic)."""
        return self._camera.metres_per_pixel(self._extent()[1])

    def seen(self) -> tuple[Array, float, float]:
        """The middle of the view at the pivot's distance (3,), World, and the width and height in
        metres that are seen there."""
        camera, scale = self._camera, self.metres_per_pixel()
        centre = camera.position + camera.distance * camera.direction
        return centre, scale * self.width(), scale * self.height()

    def camera_state(self) -> dict[str, Any]:
        """The view as JSON-able values, for `set_camera_state`."""
        return self._camera.as_dict()

    def set_camera_state(self, state: dict[str, Any]) -> None:
        """Take back a view; raises ValueError where it is none, and changes nothing then."""
        self._camera.restore(state)
        self._framing.clear()
        self._moved()

    def set_frame(self, *, north_known: bool, unit_known: bool = True) -> None:
        """Whether World's y is North; if not, the compass says "local frame". Whether its unit is
        the metre; if not, the scale bar counts units."""
        self._north_known = north_known
        self._unit_known = unit_known
        self._features_dirty = True
        self.update()

    def _moved(self) -> None:
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
        if self._clip is not None and self._clip_handles:
            corners, centres, usable = self._clip_places()
            letters = "ENZ" if self._north_known else "xyz"
            hot = self._hot_face if self._press_face is None else self._press_face
            barpainting.draw_clip_box(painter, corners, centres, usable, hot, letters)
        if self._hot_camera is not None:
            self._paint_hot_camera(painter)
        if self._preview is not None:
            PreviewPainter(painter, self._camera, self._extent(), self.project).paint(
                self._preview, self._cursor, self._hot_handle
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
        width, height = self._extent()
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
            self._bars = self._lay_out_bars(width, height)
            self._paint_labels(painter)
            for bar in self._bars:
                bar.paint(painter)
            painting.draw_compass(painter, self._camera.frame, height, self._north_known)
            painting.draw_scale_bar(
                painter,
                self.metres_per_pixel(),
                width,
                height,
                orthographic=self._camera.orthographic,
                unit_known=self._unit_known,
            )
        painter.end()
        self._base = base

    def _lay_out_bars(self, width: float, height: float) -> list[barpainting.ColorBar]:
        assert self._scene is not None
        shown = [
            (m.field.scale, m.model_id)
            for m in self._scene.models.values()
            if m.visible and m.field is not None and self._scene.look.shows_field(m)
        ]
        if not self._unit_known:
            shown = [(replace(s, unit="units") if s.unit == "m" else s, id_) for s, id_ in shown]
        several = len(shown) > 1
        return barpainting.lay_out_bars(
            [
                (scale, (scale.title, self._captions.get(model_id, "") if several else ""))
                for scale, model_id in shown
            ],
            width,
            height,
        )

    def _paint_labels(self, painter: QPainter) -> None:
        width, height = self._extent()
        features = {k: d for k, d in self._features.items() if self._unclipped(d)}
        self._annotations.paint(
            painter,
            features,
            self._selected,
            self._camera,
            self._project_unclipped,
            (width, height),
            kept_free=(
                painting.compass_box(height),
                painting.scale_bar_box(width, height),
                *(bar.box for bar in self._bars),
            ),
            moving=self._moving,
        )

    def _unclipped(self, drawing: FeatureDrawing) -> bool:
        """Whether a part of a feature is inside the clipping box."""
        if self._clip is None:
            return True
        points = drawing.line if len(drawing.line) else drawing.anchor
        return bool(self._clip.holds(points).any())

    def _project_unclipped(self, points: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        pixels, seen = self.project(points)
        return pixels, seen if self._clip is None else seen & self._clip.holds(points)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        if self._fitted is not None:
            # Nobody has moved since everything was brought into view: keep it in view.
            self._show_all(self._fitted)
        self._rescale()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._annotations.forget_font()
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

    def _handle_at(self, x: float, y: float) -> int | None:
        if self._preview is None or not len(self._preview.line):
            return None
        pixels, _ = self._camera.project(np.asarray(self._preview.line, float), self._extent())
        off = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        off = np.where(np.isfinite(off), off, np.inf)
        best = int(np.argmin(off))
        return best if off[best] <= HANDLE_PIXELS else None

    def _event(
        self,
        kind: Pointer,
        at: QPointF,
        button: Qt.MouseButton,
        event: QMouseEvent,
        hit: bool = True,
    ) -> PointerEvent:
        modifiers = event.modifiers()
        return PointerEvent(
            kind,
            at.x(),
            at.y(),
            BUTTONS.get(button, Button.NONE),
            bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            self.pick(at.x(), at.y()) if hit else None,
            self._handle_at(at.x(), at.y()),
        )

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        if self._press is not None:
            return
        self._press = self._last = event.position()
        self._press_button = event.button()
        self._action = None
        left = event.button() == Qt.MouseButton.LeftButton
        shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        at = event.position()
        self._press_handle = self._handle_at(at.x(), at.y()) if left and not shift else None
        free = left and not shift and self._press_handle is None
        self._press_face = self._face_at(at.x(), at.y()) if free else None
        event.accept()

    def _begin_action(self, event: QMouseEvent) -> None:
        """The button has moved far enough to be a drag: say what it does."""
        assert self._press is not None
        if self._press_face is not None:
            self._action = "face"
            return
        shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        button = self._press_button
        hit = self.pick(self._press.x(), self._press.y())
        at = None if hit is None else self.world_of(hit)
        if self._press_handle is not None:
            self._action = "handle"
            start = self._event(Pointer.DRAG_START, self._press, button, event)
            self.pointer.emit(replace(start, handle=self._press_handle))
        elif button == Qt.MouseButton.MiddleButton or (
            button == Qt.MouseButton.LeftButton and shift
        ):
            self._action = "pan"
            self._action_depth = (
                None if at is None else float((at - self._camera.position) @ self._camera.direction)
            )
        elif button == self.orbit_button:
            self._action = "orbit"
            if at is not None:
                self._camera.set_pivot(at)
        elif button == Qt.MouseButton.LeftButton:
            self._action = "tool"
            self.pointer.emit(self._event(Pointer.DRAG_START, self._press, button, event))
        elif button == Qt.MouseButton.RightButton:
            self._action = "zoom"
            if at is not None:
                self._camera.set_pivot(at)
        else:
            self._action = "none"

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        at = event.position()
        self._cursor = at
        if self._press is None:
            self._hover_later(event)
            return
        if self._action is None:
            if max(abs(at.x() - self._press.x()), abs(at.y() - self._press.y())) <= CLICK_PIXELS:
                return
            self._begin_action(event)
            self._last = self._press
        dx, dy = at.x() - self._last.x(), at.y() - self._last.y()
        self._last = at
        if self._action == "face":
            self._drag_face(at)
            return
        if self._action == "handle":
            move = self._event(Pointer.DRAG_MOVE, at, self._press_button, event)
            self.pointer.emit(replace(move, handle=self._press_handle))
            return
        if self._action == "tool":
            self._drag_tool(event, at, at - QPointF(dx, dy))
            return
        if self._action == "orbit":
            if self.navigation == "trackball":
                self._camera.tumble(dx * DEGREES_PER_PIXEL, dy * DEGREES_PER_PIXEL)
            else:
                self._camera.orbit(dx * DEGREES_PER_PIXEL, dy * DEGREES_PER_PIXEL)
        elif self._action == "pan":
            self._camera.pan(dx, dy, self._extent()[1], self._action_depth)
        elif self._action == "zoom":
            self._camera.zoom(ZOOM_PER_NOTCH ** (-dy / 30.0), self._camera.pivot)
        else:
            return
        self._moved()

    def _drag_tool(self, event: QMouseEvent, at: QPointF, last: QPointF) -> None:
        """Tell the tool of the way from `last` to `at`, in steps that leave no gap between the
        places of its brush."""
        way, steps = at - last, 1
        brush = self._preview.brush if self._preview is not None else None
        if brush is not None:
            depth = float((brush.centre - self._camera.position) @ self._camera.direction)
            pixels = brush.radius / self._camera.metres_per_pixel(self._extent()[1], depth)
            length = max(abs(way.x()), abs(way.y()))
            steps = min(max(1, math.ceil(2.0 * length / max(pixels, 2.0))), BRUSH_STEPS)
        self._still.start()
        for step in range(1, steps + 1):
            there = last + way * (step / steps)
            move = self._event(Pointer.DRAG_MOVE, there, self._press_button, event)
            self.pointer.emit(replace(move, handle=None, more=step < steps))

    def _stand_still(self) -> None:
        if self._action != "tool" or self._press is None or self._closed:
            self._still.stop()
            return
        x, y = self._last.x(), self._last.y()
        button = BUTTONS.get(self._press_button, Button.NONE)
        self.pointer.emit(PointerEvent(Pointer.DRAG_MOVE, x, y, button, hit=self.pick(x, y)))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        if self._press is None or event.button() != self._press_button:
            return
        action, self._action = self._action, None
        press, self._press = self._press, None
        face, self._press_face = self._press_face, None
        if face is not None:
            self._rest.start(30)
            self.update()
            return
        if action == "handle":
            end = self._event(Pointer.DRAG_END, event.position(), event.button(), event)
            self.pointer.emit(replace(end, handle=self._press_handle))
        elif action == "tool":
            end = self._event(Pointer.DRAG_END, event.position(), event.button(), event)
            self.pointer.emit(replace(end, handle=None))
        elif action is None and not self._after_double_click:
            click = self._event(Pointer.CLICK, press, event.button(), event)
            self.pointer.emit(click)
        self._after_double_click = False
        self._press_handle = None

    _after_double_click = False

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802 - Qt's name
        if self.orbit_button != Qt.MouseButton.LeftButton:
            # Quick strokes of a brush are strokes.
            self.mousePressEvent(event)
            return
        self._press = self._last = event.position()
        self._press_button = event.button()
        self._action = None
        self._press_handle = None
        self._after_double_click = True
        made = self._event(Pointer.DOUBLE_CLICK, event.position(), event.button(), event)
        if event.button() == Qt.MouseButton.LeftButton and made.hit is not None:
            self.set_pivot(self.world_of(made.hit))
        self.pointer.emit(made)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        notches = event.angleDelta().y() / 120.0
        if notches == 0.0:
            return
        at = event.position()
        hit = self.pick(at.x(), at.y())
        if hit is not None:
            about = self.world_of(hit)
        else:
            about = self._camera.at_depth(at.x(), at.y(), self._extent(), self._camera.distance)
        self._camera.zoom(ZOOM_PER_NOTCH**notches, about)
        self._moved()
        event.accept()

    def _hover_later(self, event: QMouseEvent) -> None:
        self._hover_event = self._event(
            Pointer.MOVE, event.position(), Qt.MouseButton.NoButton, event, hit=False
        )
        wait = self._last_hover + HOVER_S - time.perf_counter()
        if wait <= 0.0:
            self._emit_hover()
        elif not self._hover.isActive():
            self._hover.start(max(1, int(wait * 1000.0)))

    def _emit_hover(self) -> None:
        event, self._hover_event = self._hover_event, None
        if event is None or self._press is not None:
            return
        self._last_hover = time.perf_counter()
        face = self._face_at(event.x, event.y) if event.handle is None else None
        if (event.handle, face) != (self._hot_handle, self._hot_face):
            self._hot_handle, self._hot_face = event.handle, face
            self.update()
        if self._frusta:
            self._show_hot_camera(event.x, event.y)
        self.pointer.emit(replace(event, hit=self.pick(event.x, event.y)))

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        self._cursor = None
        self._hover_event = None
        if self._preview is not None or self._hot_camera is not None:
            self._hot_camera = None
            self.update()
        super().leaveEvent(event)
