"""A plan of the camera positions."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QHelpEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QToolTip, QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import bar_text, round_length
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_MARGIN = 26.0
_GOOD, _FLAGGED, _CHOSEN = "#0072b2", "#e69f00", "#d55e00"


class PlanView(QWidget):
    """Each photo at its position with a line along its heading; those with findings in another
    colour and shape. clicked : called with a photo's name."""

    def __init__(self, clicked: object = None) -> None:
        super().__init__()
        self._rows: list[PhotoRow] = []
        self._chosen: set[str] = set()
        self._has_north = True
        self._clicked = clicked
        self.setMinimumSize(180, 120)
        self.setMouseTracking(True)

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(260, 220)

    def show_rows(self, rows: Sequence[PhotoRow], chosen: set[str], has_north: bool) -> None:
        """has_north: places are metres, with north upwards; else of a local frame without scale."""
        self._has_north = has_north
        self._rows = [row for row in rows if row.place is not None]
        self._chosen = chosen
        self.update()

    def _scale(self) -> tuple[float, float, float]:
        """Pixels per metre, and the middle in metres."""
        xs = [row.place[0] for row in self._rows if row.place]
        ys = [row.place[1] for row in self._rows if row.place]
        wide, high = max(xs) - min(xs), max(ys) - min(ys)
        room_x, room_y = self.width() - 2 * _MARGIN, self.height() - 2 * _MARGIN
        span = max(wide / max(room_x, 1.0), high / max(room_y, 1.0), 1e-3)
        return 1 / span, (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2

    def _at(self, row: PhotoRow, scale: float, cx: float, cy: float) -> QPointF:
        assert row.place is not None
        return QPointF(
            self.width() / 2 + (row.place[0] - cx) * scale,
            self.height() / 2 - (row.place[1] - cy) * scale,
        )

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().base())
        text = self.palette().text().color()
        painter.setPen(text)
        if not self._rows:
            painter.drawText(
                QRectF(self.rect()).adjusted(12, 8, -12, -8),
                int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap),
                tr("The photos have no GPS positions. The plan is drawn once they are aligned."),
            )
            return
        scale, cx, cy = self._scale()
        for row in self._rows:
            self._draw(painter, row, self._at(row, scale, cx, cy))
        painter.setPen(QPen(text, 1.5))
        if not self._has_north:
            words = tr("Local frame: scale and north unknown.")
            painter.drawText(QPointF(8, self.height() - 6), words)
            return
        length = round_length(70 / scale)
        y = self.height() - 9.0
        painter.drawLine(QPointF(8, y), QPointF(8 + length * scale, y))
        painter.drawText(QPointF(12 + length * scale, y + 4), bar_text(length))
        painter.drawText(QPointF(self.width() - 18, 16), "N")
        painter.drawLine(QPointF(self.width() - 13, 36), QPointF(self.width() - 13, 20))

    def _draw(self, painter: QPainter, row: PhotoRow, at: QPointF) -> None:
        color = QColor(_FLAGGED if row.findings else _GOOD)
        if row.name in self._chosen:
            color = QColor(_CHOSEN)
        painter.setPen(QPen(color, 2.0))
        painter.setBrush(color)
        if row.looks is not None:
            dx, dy = row.looks
            painter.drawLine(at, at + QPointF(16 * dx, -16 * dy))
        if row.findings:
            painter.drawPolygon(
                QPolygonF([at + QPointF(0, -5.5), at + QPointF(5, 4), at + QPointF(-5, 4)])
            )
        else:
            painter.drawEllipse(at, 4, 4)

    def _nearest(self, position: QPointF) -> PhotoRow | None:
        if not self._rows:
            return None
        where = self._scale()
        nearest = min(
            self._rows, key=lambda row: (self._at(row, *where) - position).manhattanLength()
        )
        near = (self._at(nearest, *where) - position).manhattanLength() < 14
        return nearest if near else None

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        row = self._nearest(event.position())
        if row is not None and callable(self._clicked):
            self._clicked(row.name)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QHelpEvent):
            row = self._nearest(QPointF(event.pos()))
            words = "" if row is None else "\n".join([row.name, *row.findings])
            QToolTip.showText(event.globalPos(), escape_markup(words), self)
            return True
        return super().event(event)
