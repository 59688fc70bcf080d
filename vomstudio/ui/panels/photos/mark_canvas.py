"""A photo on which masks are drawn and points are marked, with a magnifier at the cursor."""

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
from vomstudio.ui.widgets.photo_canvas import HANDLE_PIXELS, PhotoCanvas

LOOK, MARK, POLYGON, BRUSH = "look", "mark", "polygon", "brush"
COLORS = {CONTROL: "#e69f00", CHECK: "#56b4e9", TIE: "#f0e442"}
"""Okabe and Ito's; with the role in words wherever they are listed."""

_HIDDEN = (213, 60, 40, 110)
_LOUPE = 84.0
_LOUPE_TIMES = 5.0
_LOUPE_LEAST, _LOUPE_MOST = 4.0, 40.0
_FINE = 10.0
"""With Shift held, a mark moves so many times slower than the mouse."""
_NUDGE, _FAR_NUDGE = 0.1, 1.0
_ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, -1.0),
    Qt.Key.Key_Down: (0.0, 1.0),
}


@dataclass(frozen=True)
class ShownMark:
    """A mark as it is drawn. pixel : of the photo as stored; expected : not a mark, but where the
    aligned cameras predict one. worst : it has the largest residual of its point."""

    label: str
    role: str
    pixel: Pixel
    chosen: bool
    expected: bool = False
    residual_px: float | None = None
    worst: bool = False


class MarkCanvas(PhotoCanvas):
    """A photo with its mask in colour, its marks, and a magnifier at the cursor.

    nudged: (x, y) in pixels of the stored photo by which the chosen mark is to move.
    radius_asked: the factor by which the brush is to grow. hides: what is drawn is masked, else
    unmasked.
    """

    nudged = Signal(float, float)
    radius_asked = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("mark_canvas")
        self.tool = LOOK
        self.radius = 20.0
        """Of the brush, in pixels of the photo."""
        self.hides = True
        self._mask: BoolArray | None = None
        self._tint: QImage | None = None
        self._tint_of: tuple[object, ...] = ()
        self._version = 0
        self._marks: Sequence[ShownMark] = ()
        self._corners: list[Pixel] = []
        self._epipolar_line = np.zeros((0, 2))
        self._grabbed: tuple[QPointF, Pixel] | None = None
        self._slow = False

    # --- what is shown -----------------------------------------------------------------------
    def set_tool(self, tool: str) -> None:
        """LOOK, MARK, POLYGON or BRUSH."""
        self.tool = tool
        self.is_left_button_painting = tool == BRUSH
        shape = Qt.CursorShape.ArrowCursor if tool == LOOK else Qt.CursorShape.CrossCursor
        self.setCursor(shape)
        self.update()

    def set_used(self, used: BoolArray | None) -> None:
        """(h, w) True where the photo is used; it may change afterwards, see `mask_changed`."""
        self._mask = used
        self.mask_changed()

    def mask_changed(self) -> None:
        """Draw the mask anew: its values have changed in place."""
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
        """(k, 2) pixels of the stored photo along which the chosen point must lie."""
        self._epipolar_line = pixels
        self.update()

    def set_corners(self, corners: Sequence[Pixel]) -> None:
        """Of the polygon that is being drawn."""
        self._corners = list(corners)
        self.update()

    def look_closely(self, pixel: Pixel) -> None:
        """Bring a place into the middle, at one to one or closer."""
        self.fit()
        wanted = max(1.0, 2.5 * self._scale)
        there = self._turn.map(QPointF(*pixel))
        self._fitted, self._scale = False, wanted
        self._centre(there)

    def one_to_one(self) -> None:
        """Zoom until a pixel of the photo is a pixel of the screen."""
        self.zoom(1.0 / (self._scale * self.devicePixelRatioF()), self._cursor)

    # --- handles -----------------------------------------------------------------------------
    def _handle_at(self, at: QPointF) -> int | None:
        if self.tool == MARK:
            places = [m.pixel if not m.expected else (np.nan, np.nan) for m in self._marks]
        elif self.tool == POLYGON:
            places = list(self._corners)
        else:
            return None
        if not places:
            return None
        off = np.hypot(*(self.to_widget(places) - [at.x(), at.y()]).T)
        off = np.where(np.isfinite(off), off, np.inf)
        return int(off.argmin()) if off.min() <= HANDLE_PIXELS else None

    def pixel_of_drag(self, at: Pixel) -> Pixel:
        """Where a dragged mark is while the cursor is at this pixel: it keeps its distance from the
        cursor, and with Shift held goes slower."""
        if self._grabbed is None:
            return at
        start, mark = self._grabbed
        share = 1.0 / _FINE if self._slow else 1.0
        return (mark[0] + (at[0] - start.x()) * share, mark[1] + (at[1] - start.y()) * share)

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        super().mousePressEvent(event)
        self._grabbed = None
        self._slow = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        if self.tool == MARK and self._handle is not None:
            mark = self._marks[self._handle].pixel
            self._grabbed = (QPointF(*self.pixel_at(event.position())), mark)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        slow = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        if self._grabbed is not None and slow != self._slow and self._handle is not None:
            mark = self._marks[self._handle].pixel
            self._grabbed = (QPointF(*self.pixel_at(event.position())), mark)
        self._slow = slow
        super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        super().mouseReleaseEvent(event)
        self._grabbed = None
        self.update()

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        if self.tool == BRUSH and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self.radius_asked.emit(1.15 ** (event.angleDelta().y() / 120.0))
            event.accept()
            return
        super().wheelEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        way = _ARROWS.get(Qt.Key(event.key()))
        if way is None or self.tool != MARK:
            super().keyPressEvent(event)
            return
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        step = _FAR_NUDGE if shift else _NUDGE
        # Up is up on the screen, however the photo is stored.
        t = self._turn
        back, _ = QTransform(t.m11(), t.m12(), t.m21(), t.m22(), 0, 0).inverted()
        there = back.map(QPointF(*way))
        length = math.hypot(there.x(), there.y())
        self.nudged.emit(step * there.x() / length, step * there.y() / length)

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
        for mark in sorted(self._marks, key=lambda m: (m.chosen, not m.expected)):
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
        if key != self._tint_of:
            self._tint_of = key
            self._tint = _tinted(mask, self._size, m, self.width(), self.height())
        if self._tint is not None:
            painter.drawImage(0, 0, self._tint)

    def _paint_mark(self, painter: QPainter, mark: ShownMark) -> None:
        x, y = (float(v) for v in self.to_widget(mark.pixel)[0])
        color = QColor(COLORS[mark.role])
        if mark.expected:
            for pen in (QPen(painting.DARK, 3.6), QPen(color, 1.6, Qt.PenStyle.DashLine)):
                painter.setPen(pen)
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.drawEllipse(QPointF(x, y), 12.0, 12.0)
        else:
            self._paint_cross(painter, np.array(mark.pixel), 13.0 if mark.chosen else 9.0, color)
            if mark.chosen or mark.worst:
                ring = QColor(painting.VERDICT_COLORS["poor"]) if mark.worst else QColor("white")
                for tint, wide in ((painting.DARK, 3.2), (ring, 1.6)):
                    painter.setPen(QPen(tint, wide))
                    painter.setBrush(Qt.BrushStyle.NoBrush)
                    painter.drawEllipse(QPointF(x, y), 16.0, 16.0)
        text = mark.label
        if mark.expected:
            text += " ?"
        elif mark.residual_px is not None and (mark.chosen or mark.worst):
            text += f"  {mark.residual_px:.2f} px"
        font = painting.system_font(bold=mark.chosen)
        wide = QFontMetricsF(font).horizontalAdvance(text)
        left = x + 18.0 if x + 18.0 + wide < self.width() - 4.0 else x - 18.0 - wide
        painting.outlined_text(painter, left, y - 9.0, text, font)

    def _paint_polygon(self, painter: QPainter) -> None:
        if not self._corners:
            return
        points = [QPointF(x, y) for x, y in self.to_widget(self._corners).tolist()]
        line = list(points)
        if self._cursor is not None and self.underMouse() and self._press is None:
            line.append(self._cursor)
        fill = QColor(*_HIDDEN) if self.hides else QColor(0, 158, 115, 90)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(fill)
        if len(line) > 2:
            painter.drawPolygon(QPolygonF(line))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for tint, wide in ((painting.DARK, 3.4), (QColor("white"), 1.6)):
            painter.setPen(QPen(tint, wide))
            painter.drawPolyline(QPolygonF(line))
        painter.setPen(QPen(painting.DARK, 1.2))
        for number, at in enumerate(points):
            # A click on the first one closes it.
            first = number == 0 and len(points) > 2
            painter.setBrush(QColor(COLORS[CONTROL]) if first else QColor("white"))
            painter.drawEllipse(at, 5.5 if first else 4.0, 5.5 if first else 4.0)

    def _paint_brush(self, painter: QPainter, at: QPointF) -> None:
        radius = max(self.radius * self._scale, 1.5)
        tint = QColor(213, 60, 40) if self.hides else QColor(0, 158, 115)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for color, wide in ((QColor(255, 255, 255, 220), 3.0), (tint, 1.6)):
            painter.setPen(QPen(color, wide))
            painter.drawEllipse(at, radius, radius)

    def _paint_loupe(self, painter: QPainter, cursor: QPointF) -> None:
        picture = self._picture
        if picture is None:
            return
        at = self.pixel_at(cursor)
        if self._grabbed is not None and self._handle is not None:
            at = self.pixel_of_drag(at)
        times = min(max(self._scale * _LOUPE_TIMES, _LOUPE_LEAST), _LOUPE_MOST)
        gap = _LOUPE + 34.0
        right = cursor.x() + gap + _LOUPE < self.width()
        above = cursor.y() - gap - _LOUPE > 0
        middle = QPointF(
            cursor.x() + (gap if right else -gap), cursor.y() + (-gap if above else gap)
        )
        t = self._turn
        close = QTransform(t.m11(), t.m12(), t.m21(), t.m22(), 0, 0) * QTransform.fromScale(
            times, times
        )
        here = close.map(QPointF(*at))
        close = close * QTransform.fromTranslate(middle.x() - here.x(), middle.y() - here.y())
        circle = QPainterPath()
        circle.addEllipse(middle, _LOUPE, _LOUPE)
        painter.save()
        painter.setClipPath(circle)
        painter.fillPath(circle, QColor(38, 40, 43))
        painter.setTransform(close, True)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, times < 16.0)
        # Only what it shows: scaling the whole photo would take a second.
        reach = _LOUPE / times + 2.0
        w, h = self._size
        part = QRectF(at[0] - reach, at[1] - reach, 2 * reach, 2 * reach) & QRectF(0, 0, w, h)
        level = picture.levels[0]
        kx, ky = level.width() / w, level.height() / h
        source = QRectF(part.x() * kx, part.y() * ky, part.width() * kx, part.height() * ky)
        painter.drawImage(part, level, source)
        painter.setTransform(QTransform())
        for mark in self._marks:
            if not mark.expected:
                there = close.map(QPointF(*mark.pixel))
                painter.setPen(QPen(QColor(COLORS[mark.role]), 1.4))
                for way in (QPointF(7, 0), QPointF(0, 7)):
                    painter.drawLine(there - way, there + way)
        painter.restore()
        for tint, wide in ((QColor(0, 0, 0, 160), 2.6), (QColor(255, 255, 255, 230), 1.0)):
            painter.setPen(QPen(tint, wide))
            for way in (QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)):
                painter.drawLine(middle + way * 4.0, middle + way * 20.0)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for tint, wide in ((painting.DARK, 5.0), (QColor(235, 235, 235), 2.4)):
            painter.setPen(QPen(tint, wide))
            painter.drawEllipse(middle, _LOUPE, _LOUPE)
        font = painting.system_font()
        text = f"{at[0]:.1f}, {at[1]:.1f}"
        wide = QFontMetricsF(font).horizontalAdvance(text)
        painting.outlined_text(
            painter, middle.x() - wide / 2, middle.y() + _LOUPE - 10.0, text, font
        )


def _tinted(
    mask: BoolArray, size: tuple[int, int], m: QTransform, width: int, height: int
) -> QImage | None:
    """What the mask hides, in colour, as it is on a screen of this size. Only pixels of the screen
    are looked up: a photo of 100 megapixels is tinted as soon as a small one."""
    high, wide = mask.shape
    across, down = np.arange(width) + 0.5, np.arange(height) + 0.5
    kx, ky = wide / size[0], high / size[1]
    upright = abs(m.m11()) > abs(m.m12())
    if upright:
        x, y = (across - m.dx()) / m.m11() * kx, (down - m.dy()) / m.m22() * ky
    else:
        x, y = (down - m.dy()) / m.m12() * kx, (across - m.dx()) / m.m21() * ky
    on_x, on_y = (x >= 0) & (x < wide), (y >= 0) & (y < high)
    column = np.clip(x, 0, wide - 1).astype(np.intp)
    row = np.clip(y, 0, high - 1).astype(np.intp)
    if upright:
        hidden = ~mask[row[:, None], column] & on_y[:, None] & on_x
    else:
        hidden = ~mask[row, column[:, None]] & on_x[:, None] & on_y
    if not hidden.any():
        return None
    red, green, blue, alpha = _HIDDEN
    value = np.uint32(
        alpha << 24 | red * alpha // 255 << 16 | green * alpha // 255 << 8 | blue * alpha // 255
    )
    pixels = np.where(hidden, value, np.uint32(0))
    image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_ARGB32_Premultiplied)
    # The array goes at the end of this function.
    return image.copy()
