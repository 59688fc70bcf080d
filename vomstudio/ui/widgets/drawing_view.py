"""View of a drawing to scale, with ticks and named ends, in which a drag marks a part."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.products.ortho.vector_drawing import Drawing, choose_ticks
from vomstudio.studio.tools.interaction_types import is_click

_TICK_PX = 5.0
_DIP_TICK_PX = 14.0
_INK_COLOR = QColor("#141414")
_PAPER = QColor("#ffffff")
_MARK = QColor("#d55e00")
_MAX_LABELS = 60
"""Maximum number of labels; more would hide the drawing."""


@dataclass(frozen=True, eq=False)
class DrawingMark:
    """Mark on a drawing.

    It is a line or ring through `points` (n, 2), or a circle around the first point through the
    second.
    """

    points: FloatArray
    closed: bool = False
    circle: bool = False


class DrawingView(QWidget):
    """View of a drawing that reports drags while marking is enabled.

    Parameters
    ----------
    empty_text : str
        Text that is shown while there is no drawing.

    Attributes
    ----------
    dragged : Signal
        Emitted with the start and end of a drag, (2, 2), in the plane of the drawing.
    dragging : Signal
        Emitted with the same values during the drag.
    """

    dragged = Signal(object)
    dragging = Signal(object)

    def __init__(self, empty_text: str) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._empty_text = empty_text
        self.drawing: Drawing | None = None
        self.mark: DrawingMark | None = None
        self._is_marking = False
        self._drag_start: QPointF | None = None

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(360, 220)

    def show_drawing(self, drawing: Drawing | None) -> None:
        """Show a drawing, or the text of the empty view if no drawing is given."""
        self.drawing = drawing
        self.update()

    def show_mark(self, mark: DrawingMark | None) -> None:
        self.mark = mark
        self.update()

    def enable_marking(self, is_enabled: bool) -> None:
        self._is_marking = is_enabled
        self.setCursor(Qt.CursorShape.CrossCursor if is_enabled else Qt.CursorShape.ArrowCursor)

    # --- geometry ----------------------------------------------------------------------------
    def _frame_box(self) -> QRectF:
        """Return the frame of the drawing in pixels."""
        line_height = self.fontMetrics().height()
        left_margin = self.fontMetrics().horizontalAdvance("-00000.0") + line_height + 12
        return QRectF(
            left_margin,
            line_height + 8,
            max(self.width() - left_margin - 14, 20.0),
            max(self.height() - 3 * line_height - 20, 20.0),
        )

    def _drawing_extent(self) -> tuple[FloatArray, FloatArray, float]:
        """Return the minimum and maximum corners of the frame, and the pixels per metre."""
        assert self.drawing is not None
        box = self._frame_box()
        low, high = self.drawing.bounds
        size = np.maximum(high - low, 1e-12)
        frame = np.array([box.width(), box.height()])
        scale = float((frame / size).min())
        half_size = 0.5 * frame / scale
        centre = 0.5 * (low + high)
        return centre - half_size, centre + half_size, scale

    def to_widget(self, points: FloatArray) -> FloatArray:
        """Convert points (n, 2) of the drawing to widget pixels (n, 2)."""
        frame = self._frame_box()
        low, _, scale = self._drawing_extent()
        return np.stack(
            [
                frame.left() + (points[:, 0] - low[0]) * scale,
                frame.bottom() - (points[:, 1] - low[1]) * scale,
            ],
            axis=1,
        )

    def _to_plane(self, position: QPointF) -> FloatArray:
        frame = self._frame_box()
        low, _, scale = self._drawing_extent()
        return low + np.array([position.x() - frame.left(), frame.bottom() - position.y()]) / scale

    # --- marking -----------------------------------------------------------------------------
    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if (
            self._is_marking
            and self.drawing is not None
            and event.button() == Qt.MouseButton.LeftButton
        ):
            self._drag_start = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._drag_start is not None and self.drawing is not None:
            self.dragging.emit(
                np.stack([self._to_plane(self._drag_start), self._to_plane(event.position())])
            )

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        start, self._drag_start = self._drag_start, None
        if start is None or self.drawing is None:
            return
        step = event.position() - start
        if not is_click(step.x(), step.y()):
            self.dragged.emit(np.stack([self._to_plane(start), self._to_plane(event.position())]))

    # --- drawing -----------------------------------------------------------------------------
    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        if self.drawing is None:
            painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, self._empty_text)
            return
        painter.fillRect(self.rect(), _PAPER)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        frame = self._frame_box()
        painter.save()
        painter.setClipRect(frame)
        self._draw_shapes(painter)
        self._draw_mark(painter)
        painter.restore()
        self._draw_frame(painter, frame)

    def _draw_shapes(self, painter: QPainter) -> None:
        assert self.drawing is not None
        labels: list[tuple[QPointF, str, QColor]] = []
        for shape in self.drawing.shapes:
            vertices = self.to_widget(shape.points)
            color = QColor(shape.color)
            painter.setPen(QPen(color, 1.4))
            if len(vertices) == 1:
                centre = QPointF(*vertices[0].tolist())
                for line in shape.marks(_DIP_TICK_PX / self._drawing_extent()[2]):
                    pixels = self.to_widget(line).tolist()
                    painter.drawPolyline(QPolygonF([QPointF(x, y) for x, y in pixels]))
                painter.setBrush(color)
                painter.drawEllipse(centre, 2.4, 2.4)
                painter.setBrush(Qt.BrushStyle.NoBrush)
            else:
                polygon = QPolygonF([QPointF(x, y) for x, y in vertices.tolist()])
                draw = painter.drawPolygon if shape.is_closed else painter.drawPolyline
                draw(polygon)
            if shape.label:
                labels.append((QPointF(*vertices[len(vertices) // 2].tolist()), shape.label, color))
        self._draw_labels(painter, labels)

    def _draw_labels(self, painter: QPainter, labels: list[tuple[QPointF, str, QColor]]) -> None:
        """Draw the labels that do not overlap."""
        boxes: list[QRectF] = []
        metrics = painter.fontMetrics()
        for anchor, text, color in labels[:_MAX_LABELS]:
            size = QSize(metrics.horizontalAdvance(text) + 4, metrics.height())
            for dx, dy in (
                (5, -size.height() - 2),
                (5, 3),
                (-size.width() - 5, -size.height() - 2),
                (-size.width() - 5, 3),
            ):
                box = QRectF(anchor.x() + dx, anchor.y() + dy, size.width(), size.height())
                if not any(box.intersects(other_box) for other_box in boxes):
                    boxes.append(box)
                    painter.fillRect(box, QColor(255, 255, 255, 190))
                    painter.setPen(color)
                    painter.drawText(box, int(Qt.AlignmentFlag.AlignCenter), text)
                    break

    def _draw_mark(self, painter: QPainter) -> None:
        if self.mark is None or not len(self.mark.points):
            return
        vertices = [QPointF(x, y) for x, y in self.to_widget(self.mark.points).tolist()]
        painter.setPen(QPen(_MARK, 2.0))
        if self.mark.circle:
            offset = vertices[1] - vertices[0]
            radius = math.hypot(offset.x(), offset.y())
            painter.drawEllipse(vertices[0], radius, radius)
        elif self.mark.closed:
            painter.drawPolygon(QPolygonF(vertices))
        else:
            painter.drawPolyline(QPolygonF(vertices))

    def _draw_frame(self, painter: QPainter, frame: QRectF) -> None:
        drawing = self.drawing
        assert drawing is not None
        painter.setPen(QPen(_INK_COLOR, 1.0))
        painter.drawRect(frame)
        metrics = painter.fontMetrics()
        line_height = metrics.height()
        low, top, scale = self._drawing_extent()
        label_width = metrics.horizontalAdvance("-0000")
        for value in thin_ticks(choose_ticks(float(low[0]), float(top[0])), label_width / scale):
            x = frame.left() + (value - float(low[0])) * scale
            painter.drawLine(QPointF(x, frame.bottom()), QPointF(x, frame.bottom() + _TICK_PX))
            box = QRectF(x - 50, frame.bottom() + _TICK_PX, 100, line_height)
            painter.drawText(box, int(Qt.AlignmentFlag.AlignHCenter), f"{value:g}")
        for value in thin_ticks(choose_ticks(float(low[1]), float(top[1])), line_height / scale):
            y = frame.bottom() - (value - float(low[1])) * scale
            painter.drawLine(QPointF(frame.left() - _TICK_PX, y), QPointF(frame.left(), y))
            box = QRectF(0, y - line_height / 2, frame.left() - _TICK_PX - 2, line_height)
            flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(box, int(flags), f"{value:g}")
        title_box = QRectF(frame.left(), frame.top() - line_height - 4, frame.width(), line_height)
        painter.drawText(title_box, int(Qt.AlignmentFlag.AlignLeft), drawing.ends[0])
        painter.drawText(title_box, int(Qt.AlignmentFlag.AlignRight), drawing.ends[1])
        self._draw_scale_row(painter, frame, scale)
        painter.save()
        # In a low dock, the title may be longer than the height of the frame.
        painter.translate(line_height * 0.2, self.height() / 2)
        painter.rotate(-90)
        box = QRectF(-self.height() / 2, 0, self.height(), line_height)
        title = metrics.elidedText(drawing.axes[1], Qt.TextElideMode.ElideRight, self.height())
        painter.drawText(box, int(Qt.AlignmentFlag.AlignCenter), title)
        painter.restore()

    def _draw_scale_row(self, painter: QPainter, frame: QRectF, pixels_per_metre: float) -> None:
        drawing = self.drawing
        assert drawing is not None
        line_height = painter.fontMetrics().height()
        metrics = painter.fontMetrics()
        row = QRectF(
            frame.left(), frame.bottom() + _TICK_PX + line_height + 2, frame.width(), line_height
        )
        length = round_length(0.2 * frame.width() / pixels_per_metre)
        bar = QRectF(frame.left(), row.center().y(), length * pixels_per_metre, 4)
        text = scale_bar_text(length, is_metric=drawing.is_metric)
        available_width = (
            frame.right() - bar.right() - metrics.horizontalAdvance(drawing.axes[0]) - 20
        )
        scale_text = tr("{length}, true to scale", length=text)
        painter.drawText(row, int(Qt.AlignmentFlag.AlignRight), drawing.axes[0])
        if metrics.horizontalAdvance(text) > available_width:
            return
        text = scale_text if metrics.horizontalAdvance(scale_text) <= available_width else text
        painter.fillRect(bar, _INK_COLOR)
        painter.drawText(
            QRectF(
                bar.right() + 6, bar.center().y() - line_height / 2, available_width, line_height
            ),
            int(Qt.AlignmentFlag.AlignVCenter),
            text,
        )


def thin_ticks(ticks: FloatArray, min_spacing: float) -> list[float]:
    """Return every n-th tick, counted from zero.

    The ticks are at least `min_spacing` apart.
    """
    if len(ticks) < 2:
        return [float(tick) for tick in ticks]
    step = float(ticks[1] - ticks[0])
    stride = max(1, math.ceil(min_spacing / step))
    return [float(tick) for tick in ticks if round(tick / step) % stride == 0]
