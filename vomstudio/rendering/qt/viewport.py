"""3-D view, a plain Qt widget that shows an off-screen VTK scene.

VTK draws into an invisible window, whose pixels are copied to a QImage. The widget paints the
image and, over it, the labels, compass, scale bar and preview. Because Qt does not use the
graphics context, the order of teardown is irrelevant, a screenshot of the window is never black,
and moving the cursor repaints the overlays without drawing the outcrop again.

`ScenePicture` schedules the drawing of the scene.
"""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRect, QRectF, QSize, Qt, Signal
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

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.words import tr
from vomstudio.extraction.selection.visible_region import ViewSnapshot
from vomstudio.rendering.qt.camera_moves import CameraMoves
from vomstudio.rendering.qt.clip_handles import ClipHandles
from vomstudio.rendering.qt.display import ModelAppearance
from vomstudio.rendering.qt.gestures import Gestures
from vomstudio.rendering.qt.legend_painting import ColorLegend
from vomstudio.rendering.qt.overlays import Overlays
from vomstudio.rendering.qt.photo_cameras import PhotoCameras
from vomstudio.rendering.qt.preview_painting import PreviewPainter
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.shown_features import ShownFeatures
from vomstudio.rendering.qt.shown_models import ShownModels
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.readout_position import ReadingPosition
from vomstudio.studio.tools.interaction_types import Area, Hit, Preview

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


BACKGROUND = QColor.fromRgbF(0.36, 0.375, 0.39)
"""Background colour of the view before the scene exists."""


class Viewport(QWidget):
    """3-D view. Pixels are logical, measured from the upper-left corner of the widget.

    Attributes
    ----------
    camera, moves, gestures
        Camera, its moves, and the mouse gestures.
    models, features, photos, display, clip
        Contents, their appearance, and the clipping box.
    overlays, reading_position
        Overlays, and the position of the reading box.
    """

    pointer = Signal(object)
    """Emits the PointerEvents of the gestures."""
    left = Signal()
    """Emitted when the cursor leaves the view."""
    camera_changed = Signal()
    first_frame = Signal()
    model_stage = Signal(str, str)
    """Emits the model id and the stage reached: "shown", "complete" or "pickable"."""
    problem = Signal(object)
    """Emits a finding about content that cannot be drawn correctly."""
    field_shown = Signal(str)
    """Emits the model id when the colour scale of its field is available from
    `display.color_scale`."""
    content_changed = Signal()
    """Emitted when the models, their appearance or the features have changed."""
    clip_changed = Signal(object)
    """Emits the ClipBox while a handle is dragged."""

    def __init__(self, parent: QWidget | None = None, *, is_lazy: bool = False) -> None:
        """Create the view; if `is_lazy`, its scene is not created before `begin_drawing`."""
        super().__init__(parent)
        self._is_lazy = is_lazy
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setMinimumSize(160, 120)
        self.camera = camera = Camera()
        self.preview: Preview | None = None
        self._preview_areas: list[tuple[Area, tuple[float, float, float]]] = []
        self.reading_position = ReadingPosition()
        self._base: QImage | None = None
        self._lifetime = lifetime = SceneLifetime(camera, self._fill_scene, self)
        self._picture = picture = ScenePicture(self, lifetime)
        self.moves = CameraMoves(camera, self, lifetime.all_corners, picture, self)
        self.models = ShownModels(lifetime, picture, self.moves, self)
        self.display = ModelAppearance(lifetime, picture, self.models, self)
        self.overlays = Overlays(camera, self.display.captions)
        notes = self.overlays.annotations
        self.clip = ClipHandles(camera, self, lifetime, picture, notes, self)
        self.features = ShownFeatures(
            camera,
            self,
            lifetime,
            picture,
            notes,
            self.clip.intersects,
            lambda: self.clip.box is not None,
        )
        self.photos = PhotoCameras(camera, self, lifetime, picture)
        self.gestures = Gestures(self, self.moves, self.clip, self)
        self._connect_signals()

    def _connect_signals(self) -> None:
        self._picture.outdated.connect(self._forget_base)
        self._picture.first_frame.connect(self.first_frame)
        self._picture.content_changed.connect(self.content_changed)
        self.gestures.pointer.connect(self.pointer)
        self.moves.changed.connect(self.camera_changed)
        self.models.stage.connect(self.model_stage)
        self.models.problem.connect(self.problem)
        self.display.field_shown.connect(self.field_shown)
        self.clip.changed.connect(self.clip_changed)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(900, 600)

    def extent(self) -> tuple[float, float]:
        """Return the width and height in logical pixels, at least 1 each."""
        return float(max(self.width(), 1)), float(max(self.height(), 1))

    # -- start and end

    @property
    def scene(self) -> Scene | None:
        """VTK scene, or None before its creation and after its release."""
        return self._lifetime.scene

    @property
    def is_still(self) -> bool:
        """Whether the picture is complete and nothing will be drawn until something changes."""
        return self._picture.is_still

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        if not self._is_lazy:
            self._lifetime.begin()

    def begin_drawing(self) -> None:
        """Create the scene of a lazy view, now or once the view is visible."""
        self._is_lazy = False
        if self.isVisible():
            self._lifetime.begin()

    def _fill_scene(self, scene: Scene) -> None:
        width, height = self._picture.device_size()
        scene.set_scale(self.devicePixelRatioF())
        scene.start(width, height)
        self.photos.attach_to(scene)
        self.features.attach_to(scene)

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        self.shutdown()
        super().closeEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802 - Qt's name
        self._picture.pause()
        super().hideEvent(event)

    def shutdown(self) -> None:
        """Stop all workers and release VTK.

        The view cannot be used afterwards; further calls have no effect. The window calls this
        method before it closes.
        """
        if self._lifetime.is_closed:
            return
        with ExitStack() as steps:
            steps.callback(self._lifetime.close)
            steps.callback(self.models.close)
            steps.callback(self._lifetime.stop)
            steps.callback(self.gestures.stop)
            steps.callback(self._picture.stop)

    # -- picking and projecting

    def pick(self, x: float, y: float) -> Hit | None:
        """Return the front-most point of a visible model at a pixel, or None."""
        scene = self._lifetime.scene
        return None if scene is None else scene.pick(x, y, self.extent())

    def feature_at(self, x: float, y: float, *, include_discs: bool = True) -> str | None:
        """Return the id of the feature with a label, symbol, line or disc at a pixel, or None."""
        return self.features.at(x, y, include_discs=include_discs)

    def world_position(self, hit: Hit) -> FloatArray:
        """Return the position (3,) of a hit in the World frame."""
        m = self.models.to_world(hit.model_id)
        return np.asarray(m[:3, :3] @ np.array(hit.position) + m[:3, 3])

    def project(self, points_world: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Project points (n, 3) of the World frame to pixels (n, 2), and test their visibility.

        A point is visible if it is inside the view and not behind the surface as last drawn.
        """
        points = np.asarray(points_world, np.float64).reshape(-1, 3)
        pixels, depth = self.camera.project(points, self.extent())
        scene = self._lifetime.scene
        if scene is not None:
            return pixels, scene.visibility(points)
        width, height = self.extent()
        with np.errstate(invalid="ignore"):
            is_inside = (
                (depth > 0)
                & (pixels[:, 0] >= 0)
                & (pixels[:, 0] < width)
                & (pixels[:, 1] >= 0)
                & (pixels[:, 1] < height)
            )
        return pixels, is_inside

    def _project_unclipped(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        pixels, is_visible = self.project(points)
        return pixels, is_visible & self.clip.contains(points)

    def ray(self, x: float, y: float) -> tuple[FloatArray, FloatArray]:
        """Return the World origin and unit direction of the line of sight through a pixel."""
        return self.camera.ray(x, y, self.extent())

    def view_snapshot(self) -> ViewSnapshot | None:
        """Return a numerical description of the current view, or None before the first picture."""
        scene = self._lifetime.scene
        return None if scene is None else scene.view_snapshot(self.devicePixelRatioF())

    # -- overlays

    def set_preview(self, preview: Preview | None) -> None:
        """Show the preview of an unfinished feature, or None to remove it."""
        self.preview = preview
        areas = [] if preview is None else preview.areas()
        # The areas are compared by identity, because their arrays may be large.
        if [(id(area), color) for area, color in areas] != [
            (id(a), c) for a, c in self._preview_areas
        ]:
            self._preview_areas = areas
            self.features.set_preview_areas(areas)
        self.update()

    def set_label_mode(self, mode: str) -> None:
        """Set which features are labelled; "auto" labels all if there are only a few."""
        self.overlays.annotations.label_mode = mode
        self._picture.redraw_features()

    def set_legend(self, legend: ColorLegend) -> None:
        """Show a legend of the colours of features, or hide it if there are no entries."""
        self.overlays.legend = legend
        self._picture.redraw_features()

    def set_covered(self, box: QRect) -> None:
        """Keep labels and colour bars out of a rectangle that another widget covers."""
        self.overlays.covered_rect = QRectF(box)
        self._forget_base()
        self.update()

    def set_frame(self, *, is_north_known: bool, is_unit_known: bool = True) -> None:
        """Set whether the y axis of the World frame points North and its unit is the metre.

        Otherwise the compass shows "local frame", and the scale bar shows model units.
        """
        self.overlays.is_north_known = is_north_known
        self.overlays.is_unit_known = is_unit_known
        self._picture.redraw_features()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        self._picture.draw_changes()
        if self._base is None:
            self._base = self._compose_base()
        painter = QPainter(self)
        painter.drawImage(QPointF(0.0, 0.0), self._base)
        letters = (tr("E"), tr("N"), tr("Z")) if self.overlays.is_north_known else ("x", "y", "z")
        self.clip.paint(painter, self.gestures.dragged_face, letters)
        self.photos.paint(painter, self.rect())
        self.features.paint_hovered(painter)
        if self.preview is not None:
            PreviewPainter(
                painter,
                self.camera,
                self.extent(),
                self.project,
                self.reading_position,
                self.overlays.covered_rect,
            ).paint(self.preview, self.gestures.cursor, self.gestures.hovered_handle)
        painter.end()
        self._picture.finish_paint()

    def _forget_base(self) -> None:
        self._base = None

    def _compose_base(self) -> QImage:
        """Return the picture with the overlays that change only with the camera."""
        width, height = self.extent()
        image, scene = self._picture.image, self._lifetime.scene
        if image is None:
            base = QImage(*self._picture.device_size(), QImage.Format.Format_RGBX8888)
            base.setDevicePixelRatio(self.devicePixelRatioF())
            painter = QPainter(base)
            painter.fillRect(QRectF(0.0, 0.0, width, height), BACKGROUND)
            painter.end()
            return base
        # Painting is fastest in the native byte order of Qt.
        base = image.convertToFormat(QImage.Format.Format_RGB32)
        if scene is not None and (scene.models or self.features.drawings):
            painter = QPainter(base)
            self.overlays.paint(
                painter,
                (width, height),
                self.features.unclipped_drawings(),
                self.features.selected,
                self.display.scales(),
                self._project_unclipped,
                is_moving=self._picture.is_moving,
            )
            painter.end()
        return base

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        self.moves.handle_resize()
        self._picture.rescale()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self.overlays.annotations.forget_font()
            self._picture.redraw_features()

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

    def hover(self, x: float, y: float, *, is_free: bool) -> None:
        """Handle the cursor at a pixel; `is_free` means that it is not over a preview vertex."""
        self.clip.hover(x, y, is_free=is_free)
        self.photos.hover(x, y)

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802 - Qt's name
        self.gestures.leave()
        self.photos.leave()
        self.features.hover(None)
        self.left.emit()
        if self.preview is not None:
            self.update()
        super().leaveEvent(event)
