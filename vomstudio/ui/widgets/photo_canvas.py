"""Photo with pan and zoom, over which the features of the model are drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QEvent, QLineF, QPoint, QPointF, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
    QTransform,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.qt import painting
from vomstudio.rendering.qt.preview_painting import PreviewPainter
from vomstudio.rendering.view.readout_position import ReadingPosition
from vomstudio.studio.tools.interaction_types import Button, Pointer, Preview, is_click
from vomstudio.ui.base.photo_images import PhotoPyramid

HANDLE_PICK_DISTANCE_PIXELS = 9.0
MAX_LINE_DISTANCE_PIXELS = 7.0
_ZOOM_PER_NOTCH = 1.2
_HOVER_MS = 30
_STROKE_STEP_PIXELS, _MAX_STEPS = 6.0, 40
_MAX_ZOOM = 24.0  # screen pixels per photo pixel
_BUTTONS = {
    Qt.MouseButton.LeftButton: Button.LEFT,
    Qt.MouseButton.MiddleButton: Button.MIDDLE,
    Qt.MouseButton.RightButton: Button.RIGHT,
}


@dataclass(frozen=True, eq=False)
class Drawn:
    """Feature as drawn in the photo.

    Attributes
    ----------
    pixels : (k, 2) array
        Vertices in pixels of the photo.
    is_visible : (k,) bool array
        Whether each vertex is visible in the photo.
    anchor : (2,) array or None
        Anchor of the label, or None if it is hidden.
    is_edge_list : bool
        Whether `pixels` contains the ends of separate edges (two rows each) instead of a
        polyline.
    """

    id: str
    pixels: FloatArray
    is_visible: BoolArray
    color: tuple[float, float, float]
    label: str
    anchor: FloatArray | None
    is_edge_list: bool = False


@dataclass(frozen=True)
class PhotoPointer:
    """Gesture at (x, y) in the stored photo; (0.5, 0.5) is the centre of the first pixel."""

    kind: Pointer
    x: float
    y: float
    button: Button = Button.NONE
    shift: bool = False
    ctrl: bool = False
    handle: int | None = None
    is_continued: bool = False
    """Whether another event of the same drag follows immediately."""
    alt: bool = False


class PhotoCanvas(QWidget):
    """Canvas that pans on drags, zooms with the wheel, and emits other gestures.

    `projection` returns the pixels (n, 2) of World points, and whether each is visible in the
    photo (n,).

    Attributes
    ----------
    pointed : Signal
        Emitted with a `PhotoPointer`.
    """

    pointed = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 110)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setObjectName("photo_canvas")
        self.is_left_button_painting = False
        """Whether the left button paints, while the other buttons pan."""
        self.projection: Callable[[FloatArray], tuple[FloatArray, BoolArray]] | None = None
        self.direction: FloatArray = np.array([0.0, 0.0, 1.0])
        """Viewing direction of the photo in the World frame."""
        self.message = ""
        self._size = (1, 1)
        self._picture: PhotoPyramid | None = None
        self._turn = QTransform()
        self._upright_size = QSize(1, 1)
        self._scale, self._offset = 1.0, QPointF()
        self._is_fitted = True
        self._drawn_features: Sequence[Drawn] = ()
        self._selected: frozenset[str] = frozenset()
        self._preview: Preview | None = None
        self._reading_position = ReadingPosition()
        self._cross: FloatArray | None = None
        self._marker_position: FloatArray | None = None
        self._cursor: QPointF | None = None
        self._press_position: QPointF | None = None
        self._last_position = QPointF()
        self._button = Qt.MouseButton.NoButton
        self._action: str | None = None
        self._handle: int | None = None
        self._is_double_click = False
        # Throttled, because tools fit planes at each move of the cursor.
        self._hover_event: PhotoPointer | None = None
        self._hover_timer = QTimer(self, singleShot=True, interval=_HOVER_MS)
        self._hover_timer.timeout.connect(self._emit_hover)

    # --- content -----------------------------------------------------------------------------
    def set_photo(self, width: int, height: int) -> None:
        """Set the size of another photo, in pixels, and remove the previous picture."""
        self._size, self._picture = (width, height), None
        self._drawn_features, self._cross = (), None
        self._set_upright_transform(QTransform())
        self.fit()

    def set_picture(self, picture: PhotoPyramid | None) -> None:
        """Draw a picture of the current photo, or no picture if `picture` is None."""
        previous = self._upright_size
        self._picture = picture
        if picture is not None:
            # The cameras may refer to photos of another size.
            to_upright, (w, h) = picture.to_upright, self._size
            reduction = QTransform.fromScale(picture.width / w, picture.height / h)
            enlargement = QTransform.fromScale(w / picture.width, h / picture.height)
            if abs(to_upright.m11()) < 0.5:
                enlargement = QTransform.fromScale(h / picture.height, w / picture.width)
            self._set_upright_transform(reduction * to_upright * enlargement)
            if self._upright_size != previous:
                self.fit()
        self.update()

    def _set_upright_transform(self, to_upright: QTransform) -> None:
        self._turn = to_upright
        box = to_upright.mapRect(QRectF(0, 0, *self._size))
        self._upright_size = QSize(round(box.width()), round(box.height()))

    def set_features(self, drawn_features: Sequence[Drawn], selected_names: frozenset[str]) -> None:
        self._drawn_features, self._selected = drawn_features, selected_names
        self.update()

    def set_preview(self, preview: Preview | None) -> None:
        self._preview = preview
        self.update()

    def set_cross(self, pixel: FloatArray | None) -> None:
        """Mark the pixel of the cursor over the outcrop, or remove the mark if `pixel` is None."""
        if pixel is not None or self._cross is not None:
            self._cross = pixel
            self.update()

    def set_marker(self, pixel: FloatArray | None) -> None:
        """Mark the pixel of the target, or remove the mark if `pixel` is None."""
        self._marker_position = pixel
        self.update()

    # --- view --------------------------------------------------------------------------------
    @property
    def to_screen(self) -> QTransform:
        """Transform from pixels of the stored photo to widget pixels."""
        x, y = self._offset.x(), self._offset.y()
        return self._turn * QTransform(self._scale, 0, 0, self._scale, x, y)

    def pixel_at(self, position: QPointF | QPoint) -> tuple[float, float]:
        inverse, _ = self.to_screen.inverted()
        pixel = inverse.map(QPointF(position))
        return pixel.x(), pixel.y()

    def to_widget(self, pixels: npt.ArrayLike) -> FloatArray:
        """Convert pixels (n, 2) of the stored photo to widget pixels (n, 2)."""
        m = self.to_screen
        x, y = np.asarray(pixels, np.float64).reshape(-1, 2).T
        return np.column_stack(
            [m.m11() * x + m.m21() * y + m.dx(), m.m12() * x + m.m22() * y + m.dy()]
        )

    def fit(self) -> None:
        """Show the whole photo."""
        self._is_fitted = True
        size = self.size()
        self._scale = min(
            size.width() / self._upright_size.width(), size.height() / self._upright_size.height()
        )
        self._centre(QPointF(self._upright_size.width() / 2, self._upright_size.height() / 2))

    def look_at(self, pixels: FloatArray) -> None:
        """Show pixels (n, 2) of the stored photo with a margin, at a scale of at most 1:1.

        Show the whole photo if no pixel is finite, or if this would enlarge it by less than 20 %.
        """
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        if not len(pixels):
            self.fit()
            return
        upright = [self._turn.map(QPointF(*p)) for p in pixels.tolist()]
        x, y = np.array([[p.x(), p.y()] for p in upright]).T
        width, height = float(np.ptp(x)) * 1.6 + 120.0, float(np.ptp(y)) * 1.6 + 120.0
        self.fit()
        fitted_scale, ratio = self._scale, self.devicePixelRatioF()
        scale = min(self.width() / width, self.height() / height, 1.0 / ratio)
        if scale > 1.2 * fitted_scale:
            self._is_fitted = False
            self._scale = scale
            self._centre(QPointF((x.min() + x.max()) / 2, (y.min() + y.max()) / 2))

    def contains_pixels(self, pixels: FloatArray) -> bool:
        """Return whether all pixels (n, 2) of the stored photo are inside the widget."""
        widget_pixels = self.to_widget(pixels)
        return bool(
            (widget_pixels > 0).all()
            and (widget_pixels[:, 0] < self.width()).all()
            and (widget_pixels[:, 1] < self.height()).all()
        )

    def zoom(self, factor: float, zoom_centre: QPointF | None = None) -> None:
        """Zoom by a factor about a point of the widget, by default its centre."""
        zoom_centre = zoom_centre or QPointF(self.width() / 2, self.height() / 2)
        min_scale = 0.5 * min(
            self.width() / self._upright_size.width(), self.height() / self._upright_size.height()
        )
        scale = min(max(self._scale * factor, min_scale), _MAX_ZOOM)
        self._offset = zoom_centre + (self._offset - zoom_centre) * (scale / self._scale)
        self._scale, self._is_fitted = scale, False
        self.update()

    def _centre(self, upright: QPointF) -> None:
        self._offset = QPointF(self.width() / 2, self.height() / 2) - upright * self._scale
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        if self._is_fitted:
            self.fit()
        elif event.oldSize().isValid():
            size_change = event.size() - event.oldSize()
            self._offset += QPointF(size_change.width() / 2, size_change.height() / 2)
        super().resizeEvent(event)

    # --- painting ----------------------------------------------------------------------------
    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(38, 40, 43))
        if self._picture is not None:
            self._paint_picture(painter, self._picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.save()
        painter.setClipRect(self.to_screen.mapRect(QRectF(0, 0, *self._size)))
        for drawing in sorted(self._drawn_features, key=lambda d: d.id in self._selected):
            self._paint_feature(painter, drawing)
        painter.restore()
        self._paint_labels(painter)
        if self._marker_position is not None:
            self._paint_cross(painter, self._marker_position, 11.0, QColor("#56b4e9"))
        if self._preview is not None and self.projection is not None:
            extent = float(self.width()), float(self.height())
            eye = PreviewPainter(
                painter, _PhotoCamera(self), extent, self._project, self._reading_position
            )
            cursor = self._cursor if self.underMouse() else None
            handle = self._handle_at(cursor) if cursor is not None else None
            self._paint_border(painter, self._preview)
            eye.paint(self._preview, cursor, handle)
        if self._cross is not None:
            self._paint_cross(painter, self._cross, 7.0, QColor(255, 255, 255))
        if self.message:
            painter.setPen(QColor(235, 235, 235))
            painter.setFont(painting.system_font())
            box = self.rect().adjusted(16, 12, -16, -12)
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(box, int(flags), self.message)

    def _paint_border(self, painter: QPainter, preview: Preview) -> None:
        """Paint the visible border edges of the previewed area."""
        area = preview.area
        if area is None or not len(area.border):
            return
        positions = area.border.reshape(-1, 3).astype(np.float64) + area.origin
        pixels, is_visible = self._project(positions)
        is_drawn = is_visible & np.isfinite(pixels).all(axis=1)
        edges = pixels.reshape(-1, 2, 2)[is_drawn.reshape(-1, 2).all(axis=1)]
        painter.setPen(QPen(painting.to_color(preview.color), 2.0))
        painter.drawLines([QLineF(*start, *end) for start, end in edges])

    def _paint_picture(self, painter: QPainter, picture: PhotoPyramid) -> None:
        painter.save()
        painter.setTransform(self.to_screen, True)
        pixel_ratio = self._scale * self.devicePixelRatioF()
        picture_rect = QRectF(0, 0, *self._size)
        # Use the smallest level with at least the resolution of the screen.
        fine_levels = [i for i in picture.levels if i.width() >= 0.98 * pixel_ratio * self._size[0]]
        level = fine_levels[-1] if fine_levels else picture.levels[0]
        hint = QPainter.RenderHint.SmoothPixmapTransform
        painter.setRenderHint(hint, pixel_ratio < 4.0 or not picture.is_complete)
        painter.drawImage(picture_rect, level)
        painter.restore()

    def _paint_feature(self, painter: QPainter, drawing: Drawn) -> None:
        color = painting.to_color(drawing.color)
        is_selected = drawing.id in self._selected
        pixels = self.to_widget(drawing.pixels)
        if drawing.is_edge_list:
            edges = pixels.reshape(-1, 4)[drawing.is_visible.reshape(-1, 2).all(axis=1)]
            lines = [QLineF(*edge) for edge in edges.tolist()]
            width = 3.0 if is_selected else 1.8
            for pen in (QPen(QColor(20, 20, 22, 200), width + 2.4), QPen(color, width)):
                painter.setPen(pen)
                painter.drawLines(lines)
        else:
            painting.draw_runs(
                painter, pixels, drawing.is_visible, color, 3.4 if is_selected else 2.0
            )

    def _paint_labels(self, painter: QPainter) -> None:
        """Draw the labels that do not overlap, starting with those of selected features."""
        boxes: list[QRectF] = []
        for drawing in sorted(self._drawn_features, key=lambda d: d.id not in self._selected):
            if drawing.anchor is None or not drawing.label:
                continue
            font = painting.system_font(bold=drawing.id in self._selected)
            metrics = QFontMetricsF(font)
            x, y = self.to_widget(drawing.anchor)[0] + (8.0, -7.0)
            width, height = metrics.horizontalAdvance(drawing.label), metrics.height()
            x = min(x, self.width() - width - 4.0)
            box = QRectF(x, y - metrics.ascent(), width, height)
            if self.rect().toRectF().contains(box) and not any(box.intersects(b) for b in boxes):
                boxes.append(box)
                painting.outlined_text(painter, x, y, drawing.label, font)

    def _paint_cross(
        self, painter: QPainter, pixel: FloatArray, size: float, color: QColor
    ) -> None:
        x, y = self.to_widget(pixel)[0]
        if not (np.isfinite(x) and np.isfinite(y)):
            return
        centre = QPointF(x, y)
        for tint, width in ((QColor(20, 20, 22), 3.6), (color, 1.6)):
            painter.setPen(QPen(tint, width))
            for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                direction = QPointF(dx, dy)
                painter.drawLine(centre + direction * 3.0, centre + direction * size)

    def _project(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        assert self.projection is not None
        pixels, is_visible = self.projection(points)
        return self.to_widget(pixels), is_visible

    # --- gestures ----------------------------------------------------------------------------
    def _create_pointer(
        self, action: Pointer, position: QPointF, button: Qt.MouseButton, event: QMouseEvent
    ) -> PhotoPointer:
        modifiers = event.modifiers()
        x, y = self.pixel_at(position)
        return PhotoPointer(
            action,
            x,
            y,
            _BUTTONS.get(button, Button.NONE),
            bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            self._handle_at(position),
            alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
        )

    def _handle_at(self, position: QPointF) -> int | None:
        if self._preview is None or self.projection is None or not len(self._preview.line):
            return None
        pixels, is_visible = self._project(np.asarray(self._preview.line, np.float64))
        distances = np.hypot(pixels[:, 0] - position.x(), pixels[:, 1] - position.y())
        distances = np.where(is_visible & np.isfinite(distances), distances, np.inf)
        return int(distances.argmin()) if distances.min() <= HANDLE_PICK_DISTANCE_PIXELS else None

    def feature_at(self, x: float, y: float) -> str | None:
        """Return the id of the feature at a photo pixel, or None if no feature is there."""
        position = self.to_widget([x, y])[0]
        best_distance, feature_id = MAX_LINE_DISTANCE_PIXELS, None
        for drawing in self._drawn_features:
            is_segment_visible = drawing.is_visible[:-1] & drawing.is_visible[1:]
            widget_pixels = self.to_widget(drawing.pixels)
            if drawing.is_edge_list:
                distances = np.hypot(*(widget_pixels[drawing.is_visible] - position).T)
            else:
                a, ab = (
                    widget_pixels[:-1][is_segment_visible],
                    np.diff(widget_pixels, axis=0)[is_segment_visible],
                )
                squared_lengths = np.maximum((ab**2).sum(axis=1), 1e-12)
                t = np.clip(((position - a) * ab).sum(axis=1) / squared_lengths, 0.0, 1.0)
                distances = np.hypot(*(a + t[:, None] * ab - position).T)
            if len(distances) and distances.min() < best_distance:
                best_distance, feature_id = float(distances.min()), drawing.id
        return feature_id

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._press_position is not None:
            return
        self._press_position = self._last_position = event.position()
        self._button, self._action = event.button(), None
        is_left_button = event.button() == Qt.MouseButton.LeftButton
        self._handle = self._handle_at(event.position()) if is_left_button else None
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        cursor = self._cursor = event.position()
        if self._press_position is None:
            self._hover_event = self._create_pointer(
                Pointer.MOVE, cursor, Qt.MouseButton.NoButton, event
            )
            if not self._hover_timer.isActive():
                self._hover_timer.start()
            self.update()
            return
        if self._action is None:
            if is_click(
                cursor.x() - self._press_position.x(), cursor.y() - self._press_position.y()
            ):
                return
            self._action = self._begin_drag(event)
            self._last_position = self._press_position
        if self._action == "pan":
            self._offset += cursor - self._last_position
            self._is_fitted = False
        else:
            motion = cursor - self._last_position
            # A brush leaves no gaps.
            length = motion.manhattanLength() if self._handle is None else 0.0
            steps = min(max(1, math.ceil(length / _STROKE_STEP_PIXELS)), _MAX_STEPS)
            for step in range(1, steps + 1):
                position = self._last_position + motion * (step / steps)
                self._drag(Pointer.DRAG_MOVE, position, event, is_continued=step < steps)
        self._last_position = cursor
        self.update()

    def _emit_hover(self) -> None:
        if self._press_position is None and self._hover_event is not None:
            self.pointed.emit(self._hover_event)

    def _begin_drag(self, event: QMouseEvent) -> str:
        assert self._press_position is not None
        is_left_button = self._button == Qt.MouseButton.LeftButton
        if self._handle is None and not (is_left_button and self.is_left_button_painting):
            return "pan"
        self._drag(Pointer.DRAG_START, self._press_position, event)
        return "tool"

    def _drag(
        self, action: Pointer, position: QPointF, event: QMouseEvent, *, is_continued: bool = False
    ) -> None:
        pointer = self._create_pointer(action, position, self._button, event)
        self.pointed.emit(replace(pointer, handle=self._handle, is_continued=is_continued))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._press_position is None or event.button() != self._button:
            return
        press, self._press_position = self._press_position, None
        if self._action == "tool":
            self._drag(Pointer.DRAG_END, event.position(), event)
        elif self._action is None and not self._is_double_click:
            self.pointed.emit(self._create_pointer(Pointer.CLICK, press, event.button(), event))
        self._action, self._handle, self._is_double_click = None, None, False

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self.is_left_button_painting:
            self.mousePressEvent(event)
            return
        self._press_position = self._last_position = event.position()
        self._button, self._action, self._is_double_click = event.button(), None, True
        self.pointed.emit(
            self._create_pointer(Pointer.DOUBLE_CLICK, event.position(), event.button(), event)
        )

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        self.zoom(_ZOOM_PER_NOTCH ** (event.angleDelta().y() / 120.0), event.position())
        event.accept()

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802
        self._cursor, self._hover_event = None, None
        self.update()
        super().leaveEvent(event)


class _PhotoCamera:
    """Camera interface of the photo for the painter of previews."""

    def __init__(self, canvas: PhotoCanvas) -> None:
        self._canvas = canvas

    @property
    def direction(self) -> FloatArray:
        return self._canvas.direction

    def project(
        self, points: FloatArray, size: tuple[float, float]
    ) -> tuple[FloatArray, FloatArray]:
        projection = self._canvas.projection
        assert projection is not None
        pixels, _ = projection(points)
        return self._canvas.to_widget(pixels), np.ones(len(pixels))
