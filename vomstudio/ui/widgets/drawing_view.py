"""A drawing in a plane on the screen: to scale, in a frame with ticks and named ends; a drag marks
a part of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geometry.units import bar_text, round_length
from vomstudio.products.ortho.vector_drawing import Drawing, choose_ticks
from vomstudio.studio.tools.interaction_types import is_click

_TICK = 5.0
_DIP_TICK = 14.0
_INK = QColor("#141414")
_PAPER = QColor("#ffffff")
_MARK = QColor("#d55e00")
_MOST_LABELS = 60
"""More would hide what they name."""


@dataclass(frozen=True, eq=False)
class DrawingMark:
    """What is marked on a drawing: a line or ring through `points` (n, 2), or a circle about the
    first of them through the second."""

    points: FloatArray
    closed: bool = False
    circle: bool = False


class DrawingView(QWidget):
    """dragged : from where to where, (2, 2) in the drawing's plane, while marking is on
    dragging : the same, before the button is let go"""

    dragged = Signal(object)
    dragging = Signal(object)

    def __init__(self, empty: str) -> None:
        """empty : what is said while there is no drawing"""
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._empty = empty
        self.shown: Drawing | None = None
        self.mark: DrawingMark | None = None
        self._marking = False
        self._from: QPointF | None = None

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(360, 220)

    def show_drawing(self, drawing: Drawing | None, instead: str = "") -> None:
        """instead : what is said where there is none"""
        self.shown = drawing
        self._said = instead or self._empty
        self.update()

    def show_mark(self, mark: DrawingMark | None) -> None:
        self.mark = mark
        self.update()

    def let_mark(self, on: bool) -> None:
        self._marking = on
        self.setCursor(Qt.CursorShape.CrossCursor if on else Qt.CursorShape.ArrowCursor)

    # --- places ------------------------------------------------------------------------------
    def _room(self) -> QRectF:
        """Of the frame on the widget."""
        high = self.fontMetrics().height()
        left = self.fontMetrics().horizontalAdvance("-00000.0") + high + 12
        return QRectF(
            left,
            high + 8,
            max(self.width() - left - 14, 20.0),
            max(self.height() - 3 * high - 20, 20.0),
        )

    def _seen(self) -> tuple[FloatArray, FloatArray, float]:
        """Lowest and highest corner of what the frame holds, with the drawing to scale in its
        middle, and pixels for a metre."""
        assert self.shown is not None
        room = self._room()
        low, high = self.shown.bounds
        size = np.maximum(high - low, 1e-12)
        frame = np.array([room.width(), room.height()])
        scale = float((frame / size).min())
        half = 0.5 * frame / scale
        middle = 0.5 * (low + high)
        return middle - half, middle + half, scale

    def place_of(self, points: FloatArray) -> FloatArray:
        """(n, 2) pixels of the widget of points (n, 2) of the drawing."""
        room = self._room()
        low, _, scale = self._seen()
        return np.stack(
            [
                room.left() + (points[:, 0] - low[0]) * scale,
                room.bottom() - (points[:, 1] - low[1]) * scale,
            ],
            axis=1,
        )

    def _to_plane(self, at: QPointF) -> FloatArray:
        room = self._room()
        low, _, scale = self._seen()
        return low + np.array([at.x() - room.left(), room.bottom() - at.y()]) / scale

    # --- marking -----------------------------------------------------------------------------
    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._marking and self.shown is not None and event.button() == Qt.MouseButton.LeftButton:
            self._from = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._from is not None and self.shown is not None:
            self.dragging.emit(
                np.stack([self._to_plane(self._from), self._to_plane(event.position())])
            )

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        begun, self._from = self._from, None
        if begun is None or self.shown is None:
            return
        step = event.position() - begun
        if not is_click(step.x(), step.y()):
            self.dragged.emit(np.stack([self._to_plane(begun), self._to_plane(event.position())]))

    # --- drawing -----------------------------------------------------------------------------
    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        if self.shown is None:
            painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
            text = getattr(self, "_said", self._empty)
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, text)
            return
        painter.fillRect(self.rect(), _PAPER)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        room = self._room()
        painter.save()
        painter.setClipRect(room)
        self._draw_shapes(painter)
        self._draw_mark(painter)
        painter.restore()
        self._draw_frame(painter, room)

    def _draw_shapes(self, painter: QPainter) -> None:
        assert self.shown is not None
        labels: list[tuple[QPointF, str, QColor]] = []
        for shape in self.shown.shapes:
            at = self.place_of(shape.points)
            color = QColor(shape.color)
            painter.setPen(QPen(color, 1.4))
            if len(at) == 1:
                centre = QPointF(*at[0].tolist())
                for line in shape.marks(_DIP_TICK / self._seen()[2]):
                    there = self.place_of(line).tolist()
                    painter.drawPolyline(QPolygonF([QPointF(x, y) for x, y in there]))
                painter.setBrush(color)
                painter.drawEllipse(centre, 2.4, 2.4)
                painter.setBrush(Qt.BrushStyle.NoBrush)
            else:
                polygon = QPolygonF([QPointF(x, y) for x, y in at.tolist()])
                draw = painter.drawPolygon if shape.closed else painter.drawPolyline
                draw(polygon)
            if shape.label:
                labels.append((QPointF(*at[len(at) // 2].tolist()), shape.label, color))
        self._draw_labels(painter, labels)

    def _draw_labels(self, painter: QPainter, labels: list[tuple[QPointF, str, QColor]]) -> None:
        """Those that find room beside what they name; none over another."""
        taken: list[QRectF] = []
        metrics = painter.fontMetrics()
        for at, text, color in labels[:_MOST_LABELS]:
            size = QSize(metrics.horizontalAdvance(text) + 4, metrics.height())
            for dx, dy in (
                (5, -size.height() - 2),
                (5, 3),
                (-size.width() - 5, -size.height() - 2),
                (-size.width() - 5, 3),
            ):
                box = QRectF(at.x() + dx, at.y() + dy, size.width(), size.height())
                if not any(box.intersects(other) for other in taken):
                    taken.append(box)
                    painter.fillRect(box, QColor(255, 255, 255, 190))
                    painter.setPen(color)
                    painter.drawText(box, int(Qt.AlignmentFlag.AlignCenter), text)
                    break

    def _draw_mark(self, painter: QPainter) -> None:
        if self.mark is None or not len(self.mark.points):
            return
        at = [QPointF(x, y) for x, y in self.place_of(self.mark.points).tolist()]
        painter.setPen(QPen(_MARK, 2.0))
        if self.mark.circle:
            step = at[1] - at[0]
            reach = math.hypot(step.x(), step.y())
            painter.drawEllipse(at[0], reach, reach)
        elif self.mark.closed:
            painter.drawPolygon(QPolygonF(at))
        else:
            painter.drawPolyline(QPolygonF(at))

    def _draw_frame(self, painter: QPainter, room: QRectF) -> None:
        shown = self.shown
        assert shown is not None
        painter.setPen(QPen(_INK, 1.0))
        painter.drawRect(room)
        metrics = painter.fontMetrics()
        high = metrics.height()
        low, top, scale = self._seen()
        wide = metrics.horizontalAdvance("-0000")
        for value in spaced(choose_ticks(float(low[0]), float(top[0])), wide / scale):
            x = room.left() + (value - float(low[0])) * scale
            painter.drawLine(QPointF(x, room.bottom()), QPointF(x, room.bottom() + _TICK))
            box = QRectF(x - 50, room.bottom() + _TICK, 100, high)
            painter.drawText(box, int(Qt.AlignmentFlag.AlignHCenter), f"{value:g}")
        for value in spaced(choose_ticks(float(low[1]), float(top[1])), high / scale):
            y = room.bottom() - (value - float(low[1])) * scale
            painter.drawLine(QPointF(room.left() - _TICK, y), QPointF(room.left(), y))
            box = QRectF(0, y - high / 2, room.left() - _TICK - 2, high)
            flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(box, int(flags), f"{value:g}")
        above = QRectF(room.left(), room.top() - high - 4, room.width(), high)
        painter.drawText(above, int(Qt.AlignmentFlag.AlignLeft), shown.ends[0])
        painter.drawText(above, int(Qt.AlignmentFlag.AlignRight), shown.ends[1])
        self._draw_below(painter, room, scale)
        painter.save()
        # In a low dock the frame is lower than its title is long.
        painter.translate(high * 0.2, self.height() / 2)
        painter.rotate(-90)
        box = QRectF(-self.height() / 2, 0, self.height(), high)
        title = metrics.elidedText(shown.axes[1], Qt.TextElideMode.ElideRight, self.height())
        painter.drawText(box, int(Qt.AlignmentFlag.AlignCenter), title)
        painter.restore()

    def _draw_below(self, painter: QPainter, room: QRectF, per_metre: float) -> None:
        shown = self.shown
        assert shown is not None
        high = painter.fontMetrics().height()
        metrics = painter.fontMetrics()
        row = QRectF(room.left(), room.bottom() + _TICK + high + 2, room.width(), high)
        length = round_length(0.2 * room.width() / per_metre)
        bar = QRectF(room.left(), row.center().y(), length * per_metre, 4)
        said = bar_text(length, metric=shown.metric)
        free = room.right() - bar.right() - metrics.horizontalAdvance(shown.axes[0]) - 20
        full = tr("{length}, true to scale", length=said)
        painter.drawText(row, int(Qt.AlignmentFlag.AlignRight), shown.axes[0])
        if metrics.horizontalAdvance(said) > free:
            return
        said = full if metrics.horizontalAdvance(full) <= free else said
        painter.fillRect(bar, _INK)
        painter.drawText(
            QRectF(bar.right() + 6, bar.center().y() - high / 2, free, high),
            int(Qt.AlignmentFlag.AlignVCenter),
            said,
        )


def spaced(ticks: FloatArray, least: float) -> list[float]:
    """Of equally spaced ticks as many as stand at least so far apart: every second, every third
    and so on, counted from zero."""
    if len(ticks) < 2:
        return [float(tick) for tick in ticks]
    step = float(ticks[1] - ticks[0])
    every = max(1, math.ceil(least / step))
    return [float(tick) for tick in ticks if round(tick / step) % every == 0]
