"""A photo that can be moved about and looked into, with the model's features drawn over it."""

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

HANDLE_PIXELS = 9.0
LINE_PIXELS = 7.0
_PER_NOTCH = 1.2
_HOVER_MS = 30
_STROKE_PIXELS, _MOST_STEPS = 6.0, 40
_CLOSEST = 24.0  # screen pixels of one of the photo
_BUTTONS = {
    Qt.MouseButton.LeftButton: Button.LEFT,
    Qt.MouseButton.MiddleButton: Button.MIDDLE,
    Qt.MouseButton.RightButton: Button.RIGHT,
}


@dataclass(frozen=True, eq=False)
class Drawn:
    """A feature over the photo: its course, pixels (k, 2) of the photo, and which are seen (k,);
    the anchor (2,) of its label, None where that is hidden; pairs: no course, but edges, each of
    two pixels.
    """

    id: str
    pixels: FloatArray
    seen: BoolArray
    color: tuple[float, float, float]
    label: str
    anchor: FloatArray | None
    pairs: bool = False


@dataclass(frozen=True)
class PhotoPointer:
    """A gesture at a pixel (x, y) of the stored photo, (0.5, 0.5) the centre of its first one."""

    kind: Pointer
    x: float
    y: float
    button: Button = Button.NONE
    shift: bool = False
    ctrl: bool = False
    handle: int | None = None
    more: bool = False
    """Another one of the same drag follows at once."""


class PhotoCanvas(QWidget):
    """A drag moves the photo, the wheel zooms about the cursor; clicks and moves are `pointed`.

    `look_through` gives pixels (n, 2) of World points and which of them the photo shows (n,).
    """

    pointed = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 110)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setObjectName("photo_canvas")
        self.left_paints = False
        """The left button belongs to a brush; the others move the photo."""
        self.look_through: Callable[[FloatArray], tuple[FloatArray, BoolArray]] | None = None
        self.direction: FloatArray = np.array([0.0, 0.0, 1.0])
        """In World, of the photo's axis."""
        self.message = ""
        self._size = (1, 1)
        self._picture: PhotoPyramid | None = None
        self._turn = QTransform()
        self._upright = QSize(1, 1)
        self._scale, self._offset = 1.0, QPointF()
        self._fitted = True
        self._drawn: Sequence[Drawn] = ()
        self._selected: frozenset[str] = frozenset()
        self._preview: Preview | None = None
        self._reading_place = ReadingPosition()
        self._cross: FloatArray | None = None
        self._spot: FloatArray | None = None
        self._cursor: QPointF | None = None
        self._press: QPointF | None = None
        self._last = QPointF()
        self._button = Qt.MouseButton.NoButton
        self._action: str | None = None
        self._handle: int | None = None
        self._doubled = False
        # Tools fit planes as the cursor moves.
        self._hover_event: PhotoPointer | None = None
        self._hover = QTimer(self)
        self._hover.setSingleShot(True)
        self._hover.setInterval(_HOVER_MS)
        self._hover.timeout.connect(self._hovered)

    # --- what is shown -----------------------------------------------------------------------
    def set_photo(self, width: int, height: int) -> None:
        """Another photo, of so many pixels; its picture comes later."""
        self._size, self._picture = (width, height), None
        self._drawn, self._cross = (), None
        self._set_turn(QTransform())
        self.fit()

    def set_picture(self, picture: PhotoPyramid | None) -> None:
        """Draw this picture of the photo that was set."""
        before = self._upright
        self._picture = picture
        if picture is not None:
            # The cameras may have been found on photos of another size.
            turn, (w, h) = picture.turn, self._size
            shrink = QTransform.fromScale(picture.width / w, picture.height / h)
            grow = QTransform.fromScale(w / picture.width, h / picture.height)
            if abs(turn.m11()) < 0.5:
                grow = QTransform.fromScale(h / picture.height, w / picture.width)
            self._set_turn(shrink * turn * grow)
            if self._upright != before:
                self.fit()
        self.update()

    def _set_turn(self, turn: QTransform) -> None:
        self._turn = turn
        box = turn.mapRect(QRectF(0, 0, *self._size))
        self._upright = QSize(round(box.width()), round(box.height()))

    def set_drawn(self, drawn: Sequence[Drawn], selected: frozenset[str]) -> None:
        self._drawn, self._selected = drawn, selected
        self.update()

    def set_preview(self, preview: Preview | None) -> None:
        self._preview = preview
        self.update()

    def set_cross(self, pixel: FloatArray | None) -> None:
        """Where the cursor over the outcrop is in this photo."""
        if pixel is not None or self._cross is not None:
            self._cross = pixel
            self.update()

    def set_spot(self, pixel: FloatArray | None) -> None:
        """The place that was asked for."""
        self._spot = pixel
        self.update()

    # --- where one looks ---------------------------------------------------------------------
    @property
    def to_screen(self) -> QTransform:
        """From pixels of the stored photo to those of the widget."""
        x, y = self._offset.x(), self._offset.y()
        return self._turn * QTransform(self._scale, 0, 0, self._scale, x, y)

    def pixel_at(self, at: QPointF | QPoint) -> tuple[float, float]:
        inverse, _ = self.to_screen.inverted()
        there = inverse.map(QPointF(at))
        return there.x(), there.y()

    def screen_of(self, pixels: npt.ArrayLike) -> FloatArray:
        """(n, 2) of pixels (n, 2) of the stored photo."""
        m = self.to_screen
        x, y = np.asarray(pixels, np.float64).reshape(-1, 2).T
        return np.column_stack(
            [m.m11() * x + m.m21() * y + m.dx(), m.m12() * x + m.m22() * y + m.dy()]
        )

    def fit(self) -> None:
        """The whole photo."""
        self._fitted = True
        room = self.size()
        self._scale = min(
            room.width() / self._upright.width(), room.height() / self._upright.height()
        )
        self._centre(QPointF(self._upright.width() / 2, self._upright.height() / 2))

    def look_at(self, pixels: FloatArray) -> None:
        """Bring pixels (n, 2) of the stored photo into sight, with room around them, no larger than
        one to one."""
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        if not len(pixels):
            self.fit()
            return
        there = [self._turn.map(QPointF(*p)) for p in pixels.tolist()]
        x, y = np.array([[p.x(), p.y()] for p in there]).T
        wide, high = float(np.ptp(x)) * 1.6 + 120.0, float(np.ptp(y)) * 1.6 + 120.0
        self.fit()
        least, ratio = self._scale, self.devicePixelRatioF()
        wanted = min(self.width() / wide, self.height() / high, 1.0 / ratio)
        if wanted > 1.2 * least:
            self._fitted = False
            self._scale = wanted
            self._centre(QPointF((x.min() + x.max()) / 2, (y.min() + y.max()) / 2))

    def sees(self, pixels: FloatArray) -> bool:
        """All of these pixels are within the widget."""
        on = self.screen_of(pixels)
        return bool(
            (on > 0).all() and (on[:, 0] < self.width()).all() and (on[:, 1] < self.height()).all()
        )

    def zoom(self, factor: float, about: QPointF | None = None) -> None:
        """Enlarge by a factor about a point of the widget, by default its middle."""
        about = about or QPointF(self.width() / 2, self.height() / 2)
        least = 0.5 * min(
            self.width() / self._upright.width(), self.height() / self._upright.height()
        )
        scale = min(max(self._scale * factor, least), _CLOSEST)
        self._offset = about + (self._offset - about) * (scale / self._scale)
        self._scale, self._fitted = scale, False
        self.update()

    def _centre(self, there: QPointF) -> None:
        self._offset = QPointF(self.width() / 2, self.height() / 2) - there * self._scale
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        if self._fitted:
            self.fit()
        elif event.oldSize().isValid():
            grown = event.size() - event.oldSize()
            self._offset += QPointF(grown.width() / 2, grown.height() / 2)
        super().resizeEvent(event)

    # --- painting ----------------------------------------------------------------------------
    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(38, 40, 43))
        if self._picture is not None:
            self._paint_picture(painter, self._picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for drawn in sorted(self._drawn, key=lambda d: d.id in self._selected):
            self._paint_feature(painter, drawn)
        self._paint_labels(painter)
        if self._spot is not None:
            self._paint_cross(painter, self._spot, 11.0, QColor("#56b4e9"))
        if self._preview is not None and self.look_through is not None:
            extent = float(self.width()), float(self.height())
            eye = PreviewPainter(painter, _Eye(self), extent, self._project, self._reading_place)
            shown = self._cursor if self.underMouse() else None
            hot = self._handle_at(shown) if shown is not None else None
            eye.paint(self._preview, shown, hot)
        if self._cross is not None:
            self._paint_cross(painter, self._cross, 7.0, QColor(255, 255, 255))
        if self.message:
            painter.setPen(QColor(235, 235, 235))
            painter.setFont(painting.system_font())
            room = self.rect().adjusted(16, 12, -16, -12)
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(room, int(flags), self.message)

    def _paint_picture(self, painter: QPainter, picture: PhotoPyramid) -> None:
        painter.save()
        painter.setTransform(self.to_screen, True)
        near = self._scale * self.devicePixelRatioF()
        whole = QRectF(0, 0, *self._size)
        # The smallest that is still as fine as the screen.
        fine = [i for i in picture.levels if i.width() >= 0.98 * near * self._size[0]]
        level = fine[-1] if fine else picture.levels[0]
        hint = QPainter.RenderHint.SmoothPixmapTransform
        painter.setRenderHint(hint, near < 4.0 or not picture.whole)
        painter.drawImage(whole, level)
        painter.restore()

    def _paint_feature(self, painter: QPainter, drawn: Drawn) -> None:
        color = painting.to_color(drawn.color)
        chosen = drawn.id in self._selected
        pixels = self.screen_of(drawn.pixels)
        if drawn.pairs:
            edges = pixels.reshape(-1, 4)[drawn.seen.reshape(-1, 2).all(axis=1)]
            lines = [QLineF(*edge) for edge in edges.tolist()]
            wide = 3.0 if chosen else 1.8
            for pen in (QPen(QColor(20, 20, 22, 200), wide + 2.4), QPen(color, wide)):
                painter.setPen(pen)
                painter.drawLines(lines)
        else:
            painting.draw_runs(painter, pixels, drawn.seen, color, 3.4 if chosen else 2.0)

    def _paint_labels(self, painter: QPainter) -> None:
        """Those of the selected features first; what finds no room is left out."""
        taken: list[QRectF] = []
        for drawn in sorted(self._drawn, key=lambda d: d.id not in self._selected):
            if drawn.anchor is None or not drawn.label:
                continue
            font = painting.system_font(bold=drawn.id in self._selected)
            metrics = QFontMetricsF(font)
            x, y = self.screen_of(drawn.anchor)[0] + (8.0, -7.0)
            wide, high = metrics.horizontalAdvance(drawn.label), metrics.height()
            x = min(x, self.width() - wide - 4.0)
            box = QRectF(x, y - metrics.ascent(), wide, high)
            if self.rect().toRectF().contains(box) and not any(box.intersects(b) for b in taken):
                taken.append(box)
                painting.outlined_text(painter, x, y, drawn.label, font)

    def _paint_cross(
        self, painter: QPainter, pixel: FloatArray, size: float, color: QColor
    ) -> None:
        x, y = self.screen_of(pixel)[0]
        if not (np.isfinite(x) and np.isfinite(y)):
            return
        at = QPointF(x, y)
        for tint, width in ((QColor(20, 20, 22), 3.6), (color, 1.6)):
            painter.setPen(QPen(tint, width))
            for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                way = QPointF(dx, dy)
                painter.drawLine(at + way * 3.0, at + way * size)

    def _project(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        assert self.look_through is not None
        pixels, seen = self.look_through(points)
        return self.screen_of(pixels), seen

    # --- gestures ----------------------------------------------------------------------------
    def _emit(
        self, kind: Pointer, at: QPointF, button: Qt.MouseButton, event: QMouseEvent
    ) -> PhotoPointer:
        modifiers = event.modifiers()
        x, y = self.pixel_at(at)
        return PhotoPointer(
            kind,
            x,
            y,
            _BUTTONS.get(button, Button.NONE),
            bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            self._handle_at(at),
        )

    def _handle_at(self, at: QPointF) -> int | None:
        if self._preview is None or self.look_through is None or not len(self._preview.line):
            return None
        pixels, seen = self._project(np.asarray(self._preview.line, np.float64))
        off = np.hypot(pixels[:, 0] - at.x(), pixels[:, 1] - at.y())
        off = np.where(seen & np.isfinite(off), off, np.inf)
        return int(off.argmin()) if off.min() <= HANDLE_PIXELS else None

    def feature_at(self, x: float, y: float) -> str | None:
        """The feature drawn at a pixel of the photo."""
        at = self.screen_of([x, y])[0]
        best, found = LINE_PIXELS, None
        for drawn in self._drawn:
            seen = drawn.seen[:-1] & drawn.seen[1:]
            on = self.screen_of(drawn.pixels)
            if drawn.pairs:
                off = np.hypot(*(on[drawn.seen] - at).T)
            else:
                a, ab = on[:-1][seen], np.diff(on, axis=0)[seen]
                square = np.maximum((ab**2).sum(axis=1), 1e-12)
                t = np.clip(((at - a) * ab).sum(axis=1) / square, 0.0, 1.0)
                off = np.hypot(*(a + t[:, None] * ab - at).T)
            if len(off) and off.min() < best:
                best, found = float(off.min()), drawn.id
        return found

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._press is not None:
            return
        self._press = self._last = event.position()
        self._button, self._action = event.button(), None
        left = event.button() == Qt.MouseButton.LeftButton
        self._handle = self._handle_at(event.position()) if left else None
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        at = self._cursor = event.position()
        if self._press is None:
            self._hover_event = self._emit(Pointer.MOVE, at, Qt.MouseButton.NoButton, event)
            if not self._hover.isActive():
                self._hover.start()
            self.update()
            return
        if self._action is None:
            if is_click(at.x() - self._press.x(), at.y() - self._press.y()):
                return
            self._action = self._begin(event)
            self._last = self._press
        if self._action == "pan":
            self._offset += at - self._last
            self._fitted = False
        else:
            way = at - self._last
            # A brush leaves no gaps.
            length = way.manhattanLength() if self._handle is None else 0.0
            steps = min(max(1, math.ceil(length / _STROKE_PIXELS)), _MOST_STEPS)
            for step in range(1, steps + 1):
                there = self._last + way * (step / steps)
                self._drag(Pointer.DRAG_MOVE, there, event, more=step < steps)
        self._last = at
        self.update()

    def _hovered(self) -> None:
        if self._press is None and self._hover_event is not None:
            self.pointed.emit(self._hover_event)

    def _begin(self, event: QMouseEvent) -> str:
        assert self._press is not None
        left = self._button == Qt.MouseButton.LeftButton
        if self._handle is None and not (left and self.left_paints):
            return "pan"
        self._drag(Pointer.DRAG_START, self._press, event)
        return "tool"

    def _drag(self, kind: Pointer, at: QPointF, event: QMouseEvent, *, more: bool = False) -> None:
        made = self._emit(kind, at, self._button, event)
        self.pointed.emit(replace(made, handle=self._handle, more=more))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._press is None or event.button() != self._button:
            return
        press, self._press = self._press, None
        if self._action == "tool":
            self._drag(Pointer.DRAG_END, event.position(), event)
        elif self._action is None and not self._doubled:
            self.pointed.emit(self._emit(Pointer.CLICK, press, event.button(), event))
        self._action, self._handle, self._doubled = None, None, False

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self.left_paints:
            self.mousePressEvent(event)
            return
        self._press = self._last = event.position()
        self._button, self._action, self._doubled = event.button(), None, True
        self.pointed.emit(self._emit(Pointer.DOUBLE_CLICK, event.position(), event.button(), event))

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        self.zoom(_PER_NOTCH ** (event.angleDelta().y() / 120.0), event.position())
        event.accept()

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802
        self._cursor, self._hover_event = None, None
        self.update()
        super().leaveEvent(event)


class _Eye:
    """The photo as the painter of previews wants it."""

    def __init__(self, canvas: PhotoCanvas) -> None:
        self._canvas = canvas

    @property
    def direction(self) -> FloatArray:
        return self._canvas.direction

    def project(
        self, points: FloatArray, size: tuple[float, float]
    ) -> tuple[FloatArray, FloatArray]:
        look = self._canvas.look_through
        assert look is not None
        pixels, _ = look(points)
        return self._canvas.screen_of(pixels), np.ones(len(pixels))
