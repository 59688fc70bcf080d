"""Photo canvas for drawing masks and marking points, with a magnifier at the cursor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QPolygonF,
    QTransform,
    QWheelEvent,
)

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.photogrammetry.georeferencing.mark_prediction import CHECK, CONTROL, TIE, Pixel
from vomstudio.rendering.qt import painting
from vomstudio.ui.widgets.photo_canvas import HANDLE_PICK_DISTANCE_PIXELS, PhotoCanvas

LOOK, MARK, POLYGON, BRUSH = "look", "mark", "polygon", "brush"
COLORS = {CONTROL: "#e69f00", CHECK: "#56b4e9", TIE: "#f0e442"}
"""Colour of each role of a point (Okabe-Ito); lists also show the role as text."""

_MASK_RGBA = (213, 60, 40, 110)
_LOUPE_RADIUS_PX = 84.0
_LOUPE_ZOOM = 5.0
_MIN_LOUPE_SCALE, _MAX_LOUPE_SCALE = 4.0, 40.0
_SLOW_FACTOR = 10.0
"""Factor by which a mark moves more slowly than the mouse while Shift is pressed."""
_NUDGE_PX, _LARGE_NUDGE_PX = 0.1, 1.0
_ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, -1.0),
    Qt.Key.Key_Down: (0.0, 1.0),
}


@dataclass(frozen=True)
class ShownMark:
    """Mark as drawn on the canvas.

    Attributes
    ----------
    pixel : Pixel
        Position in pixels of the stored photo.
    is_predicted : bool
        Whether this is a predicted position rather than a mark.
    is_worst : bool
        Whether this mark has the largest residual of its point, and the residual is not good.
    """

    label: str
    role: str
    pixel: Pixel
    is_selected: bool
    is_predicted: bool = False
    residual_px: float | None = None
    is_worst: bool = False


class MarkCanvas(PhotoCanvas):
    """Photo canvas with a coloured mask, marks, and a magnifier at the cursor.

    Attributes
    ----------
    nudged : Signal
        Emitted with the shift (x, y) of the selected mark in pixels of the stored photo.
    brush_scaled : Signal
        Emitted with the factor by which the brush radius is to change.
    is_masking : bool
        Whether drawing masks pixels; otherwise it unmasks them.
    """

    nudged = Signal(float, float)
    brush_scaled = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("mark_canvas")
        self.tool = LOOK
        self.radius = 20.0
        """Radius of the brush in pixels of the photo."""
        self.is_masking = True
        self._mask: BoolArray | None = None
        self._tint: QImage | None = None
        self._tint_key: tuple[object, ...] = ()
        self._version = 0
        self._marks: Sequence[ShownMark] = ()
        self._corners: list[Pixel] = []
        self._epipolar_line = np.zeros((0, 2))
        self._grab: tuple[QPointF, Pixel] | None = None
        self._is_slow = False

    # --- display -----------------------------------------------------------------------------
    def set_tool(self, tool: str) -> None:
        """Set the tool to LOOK, MARK, POLYGON or BRUSH."""
        self.tool = tool
        self.is_left_button_painting = tool == BRUSH
        shape = Qt.CursorShape.ArrowCursor if tool == LOOK else Qt.CursorShape.CrossCursor
        self.setCursor(shape)
        self.update()

    def set_used(self, is_used: BoolArray | None) -> None:
        """Set the array (h, w) that is True at used pixels, or None if no mask is shown.

        Call `update_mask` after changing its values.
        """
        self._mask = is_used
        self.update_mask()

    def update_mask(self) -> None:
        """Redraw the mask after its values have changed."""
        self._version += 1
        self.update()

    def set_marks(self, marks: Sequence[ShownMark]) -> None:
        self._marks = marks
        self.update()

    @property
    def used(self) -> BoolArray | None:
        return self._mask

    @property
    def marks(self) -> Sequence[ShownMark]:
        return self._marks

    def set_epipolar_line(self, pixels: FloatArray) -> None:
        """Set the epipolar line (k, 2) of the selected point, in pixels of the stored photo."""
        self._epipolar_line = pixels
        self.update()

    def set_corners(self, corners: Sequence[Pixel]) -> None:
        """Set the vertices of the unfinished polygon."""
        self._corners = list(corners)
        self.update()

    def zoom_to_pixel(self, pixel: Pixel) -> None:
        """Centre the view on a pixel at a scale of at least one to one."""
        self.fit()
        scale = max(1.0, 2.5 * self._scale)
        centre = self._turn.map(QPointF(*pixel))
        self._is_fitted, self._scale = False, scale
        self._centre(centre)

    def zoom_to_full_resolution(self) -> None:
        """Zoom until one pixel of the photo covers one pixel of the screen."""
        self.zoom(1.0 / (self._scale * self.devicePixelRatioF()), self._cursor)

    # --- handles -----------------------------------------------------------------------------
    def _handle_at(self, position: QPointF) -> int | None:
        if self.tool == MARK:
            pixels = [m.pixel if not m.is_predicted else (np.nan, np.nan) for m in self._marks]
        elif self.tool == POLYGON:
            pixels = list(self._corners)
        else:
            return None
        if not pixels:
            return None
        distances = np.hypot(*(self.to_widget(pixels) - [position.x(), position.y()]).T)
        distances = np.where(np.isfinite(distances), distances, np.inf)
        return int(distances.argmin()) if distances.min() <= HANDLE_PICK_DISTANCE_PIXELS else None

    def dragged_pixel(self, position: Pixel) -> Pixel:
        """Return the position of a dragged mark for a cursor position.

        The offset between mark and cursor is constant; with Shift the mark moves more slowly.
        """
        if self._grab is None:
            return position
        start, mark = self._grab
        speed = 1.0 / _SLOW_FACTOR if self._is_slow else 1.0
        return (
            mark[0] + (position[0] - start.x()) * speed,
            mark[1] + (position[1] - start.y()) * speed,
        )

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        super().mousePressEvent(event)
        self._grab = None
        self._is_slow = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        if self.tool == MARK and self._handle is not None:
            mark = self._marks[self._handle].pixel
            self._grab = (QPointF(*self.pixel_at(event.position())), mark)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        is_slow = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        if self._grab is not None and is_slow != self._is_slow and self._handle is not None:
            mark = self._marks[self._handle].pixel
            self._grab = (QPointF(*self.pixel_at(event.position())), mark)
        self._is_slow = is_slow
        super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        super().mouseReleaseEvent(event)
        self._grab = None
        self.update()

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        if self.tool == BRUSH and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self.brush_scaled.emit(1.15 ** (event.angleDelta().y() / 120.0))
            event.accept()
            return
        super().wheelEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        direction = _ARROWS.get(Qt.Key(event.key()))
        if direction is None or self.tool != MARK:
            super().keyPressEvent(event)
            return
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        step = _LARGE_NUDGE_PX if shift else _NUDGE_PX
        # The arrow keys refer to the screen, whatever the orientation of the stored photo.
        t = self._turn
        inverse_transform, _ = QTransform(t.m11(), t.m12(), t.m21(), t.m22(), 0, 0).inverted()
        vector = inverse_transform.map(QPointF(*direction))
        length = math.hypot(vector.x(), vector.y())
        self.nudged.emit(step * vector.x() / length, step * vector.y() / length)

    # --- painting ----------------------------------------------------------------------------
    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        super().paintEvent(event)
        painter = QPainter(self)
        self._paint_mask(painter)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if len(self._epipolar_line) > 1:
            line = QPolygonF(
                [QPointF(x, y) for x, y in self.to_widget(self._epipolar_line).tolist()]
            )
            for pen in (QPen(painting.DARK, 3.2), QPen(QColor("white"), 1.4, Qt.PenStyle.DashLine)):
                painter.setPen(pen)
                painter.drawPolyline(line)
        for mark in sorted(self._marks, key=lambda m: (m.is_selected, not m.is_predicted)):
            self._paint_mark(painter, mark)
        self._paint_polygon(painter)
        if self._cursor is not None and self.underMouse():
            if self.tool == BRUSH:
                self._paint_brush(painter, self._cursor)
            elif self.tool == MARK and self._scale < 12.0:
                self._paint_loupe(painter, self._cursor)
        painter.end()

    def _paint_mask(self, painter: QPainter) -> None:
        mask, m = self._mask, self.to_screen
        if mask is None or self._picture is None:
            return
        key = (self._version, self.size(), m.m11(), m.m12(), m.m21(), m.m22(), m.dx(), m.dy())
        if key != self._tint_key:
            self._tint_key = key
            self._tint = _tint_mask(
                mask=mask, size=self._size, m=m, width=self.width(), height=self.height()
            )
        if self._tint is not None:
            painter.drawImage(0, 0, self._tint)

    def _paint_mark(self, painter: QPainter, mark: ShownMark) -> None:
        x, y = (float(v) for v in self.to_widget(mark.pixel)[0])
        color = QColor(COLORS[mark.role])
        if mark.is_predicted:
            for pen in (QPen(painting.DARK, 3.6), QPen(color, 1.6, Qt.PenStyle.DashLine)):
                painter.setPen(pen)
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.drawEllipse(QPointF(x, y), 12.0, 12.0)
        else:
            self._paint_cross(
                painter, np.array(mark.pixel), 13.0 if mark.is_selected else 9.0, color
            )
            if mark.is_selected or mark.is_worst:
                ring = QColor(painting.VERDICT_COLORS["poor"]) if mark.is_worst else QColor("white")
                for tint, width in ((painting.DARK, 3.2), (ring, 1.6)):
                    painter.setPen(QPen(tint, width))
                    painter.setBrush(Qt.BrushStyle.NoBrush)
                    painter.drawEllipse(QPointF(x, y), 16.0, 16.0)
        text = mark.label
        if mark.is_predicted:
            text += " ?"
        elif mark.residual_px is not None and (mark.is_selected or mark.is_worst):
            text += f"  {mark.residual_px:.2f} px"
        font = painting.system_font(bold=mark.is_selected)
        width = QFontMetricsF(font).horizontalAdvance(text)
        text_x = x + 18.0 if x + 18.0 + width < self.width() - 4.0 else x - 18.0 - width
        painting.outlined_text(painter, text_x, y - 9.0, text, font)

    def _paint_polygon(self, painter: QPainter) -> None:
        if not self._corners:
            return
        points = [QPointF(x, y) for x, y in self.to_widget(self._corners).tolist()]
        line = list(points)
        if self._cursor is not None and self.underMouse() and self._press_position is None:
            line.append(self._cursor)
        fill = QColor(*_MASK_RGBA) if self.is_masking else QColor(0, 158, 115, 90)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(fill)
        if len(line) > 2:
            painter.drawPolygon(QPolygonF(line))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for tint, width in ((painting.DARK, 3.4), (QColor("white"), 1.6)):
            painter.setPen(QPen(tint, width))
            painter.drawPolyline(QPolygonF(line))
        painter.setPen(QPen(painting.DARK, 1.2))
        for number, position in enumerate(points):
            # A click on the first vertex closes the polygon.
            is_first = number == 0 and len(points) > 2
            painter.setBrush(QColor(COLORS[CONTROL]) if is_first else QColor("white"))
            painter.drawEllipse(position, 5.5 if is_first else 4.0, 5.5 if is_first else 4.0)

    def _paint_brush(self, painter: QPainter, position: QPointF) -> None:
        radius = max(self.radius * self._scale, 1.5)
        tint = QColor(213, 60, 40) if self.is_masking else QColor(0, 158, 115)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for color, width in ((QColor(255, 255, 255, 220), 3.0), (tint, 1.6)):
            painter.setPen(QPen(color, width))
            painter.drawEllipse(position, radius, radius)

    def _paint_loupe(self, painter: QPainter, cursor: QPointF) -> None:
        picture = self._picture
        if picture is None:
            return
        position = self.pixel_at(cursor)
        if self._grab is not None and self._handle is not None:
            position = self.dragged_pixel(position)
        zoom = min(max(self._scale * _LOUPE_ZOOM, _MIN_LOUPE_SCALE), _MAX_LOUPE_SCALE)
        gap = _LOUPE_RADIUS_PX + 34.0
        fits_right = cursor.x() + gap + _LOUPE_RADIUS_PX < self.width()
        fits_above = cursor.y() - gap - _LOUPE_RADIUS_PX > 0
        midpoint = QPointF(
            cursor.x() + (gap if fits_right else -gap), cursor.y() + (-gap if fits_above else gap)
        )
        t = self._turn
        loupe_transform = QTransform(
            t.m11(), t.m12(), t.m21(), t.m22(), 0, 0
        ) * QTransform.fromScale(zoom, zoom)
        target = loupe_transform.map(QPointF(*position))
        loupe_transform = loupe_transform * QTransform.fromTranslate(
            midpoint.x() - target.x(), midpoint.y() - target.y()
        )
        circle = QPainterPath()
        circle.addEllipse(midpoint, _LOUPE_RADIUS_PX, _LOUPE_RADIUS_PX)
        painter.save()
        painter.setClipPath(circle)
        painter.fillPath(circle, QColor(38, 40, 43))
        painter.setTransform(loupe_transform, True)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, zoom < 16.0)
        # Scaling the whole photo would take a second.
        half_width = _LOUPE_RADIUS_PX / zoom + 2.0
        w, h = self._size
        part = QRectF(
            position[0] - half_width, position[1] - half_width, 2 * half_width, 2 * half_width
        ) & QRectF(0, 0, w, h)
        level = picture.levels[0]
        scale_x, scale_y = level.width() / w, level.height() / h
        source = QRectF(
            part.x() * scale_x, part.y() * scale_y, part.width() * scale_x, part.height() * scale_y
        )
        painter.drawImage(part, level, source)
        painter.setTransform(QTransform())
        for mark in self._marks:
            if not mark.is_predicted:
                centre = loupe_transform.map(QPointF(*mark.pixel))
                painter.setPen(QPen(QColor(COLORS[mark.role]), 1.4))
                for offset in (QPointF(7, 0), QPointF(0, 7)):
                    painter.drawLine(centre - offset, centre + offset)
        painter.restore()
        for tint, width in ((QColor(0, 0, 0, 160), 2.6), (QColor(255, 255, 255, 230), 1.0)):
            painter.setPen(QPen(tint, width))
            for offset in (QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)):
                painter.drawLine(midpoint + offset * 4.0, midpoint + offset * 20.0)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for tint, width in ((painting.DARK, 5.0), (QColor(235, 235, 235), 2.4)):
            painter.setPen(QPen(tint, width))
            painter.drawEllipse(midpoint, _LOUPE_RADIUS_PX, _LOUPE_RADIUS_PX)
        font = painting.system_font()
        text = f"{position[0]:.1f}, {position[1]:.1f}"
        width = QFontMetricsF(font).horizontalAdvance(text)
        painting.outlined_text(
            painter, midpoint.x() - width / 2, midpoint.y() + _LOUPE_RADIUS_PX - 10.0, text, font
        )


def _tint_mask(
    mask: BoolArray, size: tuple[int, int], m: QTransform, width: int, height: int
) -> QImage | None:
    """Return the masked pixels as a coloured screen image, or None if no mask is visible.

    Only the pixels of the screen are sampled, so the time does not depend on the size of the photo.
    """
    mask_height, mask_width = mask.shape
    screen_x, screen_y = np.arange(width) + 0.5, np.arange(height) + 0.5
    scale_x, scale_y = mask_width / size[0], mask_height / size[1]
    is_upright = abs(m.m11()) > abs(m.m12())
    if is_upright:
        x, y = (screen_x - m.dx()) / m.m11() * scale_x, (screen_y - m.dy()) / m.m22() * scale_y
    else:
        x, y = (screen_y - m.dy()) / m.m12() * scale_x, (screen_x - m.dx()) / m.m21() * scale_y
    is_inside_x, is_inside_y = (x >= 0) & (x < mask_width), (y >= 0) & (y < mask_height)
    column = np.clip(x, 0, mask_width - 1).astype(np.intp)
    row = np.clip(y, 0, mask_height - 1).astype(np.intp)
    if is_upright:
        is_hidden = ~mask[row[:, None], column] & is_inside_y[:, None] & is_inside_x
    else:
        is_hidden = ~mask[row, column[:, None]] & is_inside_x[:, None] & is_inside_y
    if not is_hidden.any():
        return None
    red, green, blue, alpha = _MASK_RGBA
    value = np.uint32(
        alpha << 24 | red * alpha // 255 << 16 | green * alpha // 255 << 8 | blue * alpha // 255
    )
    pixels = np.where(is_hidden, value, np.uint32(0))
    image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_ARGB32_Premultiplied)
    # QImage does not own the array.
    return image.copy()
