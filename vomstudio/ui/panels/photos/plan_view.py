"""Plan view of the camera positions."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QHelpEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QToolTip, QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_MARGIN = 26.0
_GPS_FRAME = Frame("local")
"""Frame of GPS positions, which are in metres with north up."""
_GOOD_COLOR, _FLAGGED_COLOR, _SELECTED_COLOR = "#0072b2", "#e69f00", "#d55e00"


class PlanView(QWidget):
    """Plan of the photos and their viewing directions; photos with findings are highlighted.

    Parameters
    ----------
    click_callback : callable, optional
        Called with the name of the photo that was clicked.
    """

    def __init__(self, click_callback: object = None) -> None:
        super().__init__()
        self._rows: list[PhotoRow] = []
        self._selection: set[str] = set()
        self._frame = _GPS_FRAME
        self._has_photos = False
        self._click_callback = click_callback
        self.setMinimumSize(180, 120)
        self.setMouseTracking(True)

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(260, 220)

    def show_rows(self, rows: Sequence[PhotoRow], selection: set[str], frame: Frame | None) -> None:
        """Show the photos of these rows; `frame` is None for GPS positions."""
        self._frame = _GPS_FRAME if frame is None else frame
        self._has_photos = bool(rows)
        self._rows = [row for row in rows if row.place is not None]
        self._selection = selection
        self.update()

    def _scale(self) -> tuple[float, float, float]:
        """Return the scale in pixels per metre, and the centre (x, y) in metres."""
        xs = [row.place[0] for row in self._rows if row.place]
        ys = [row.place[1] for row in self._rows if row.place]
        width, height = max(xs) - min(xs), max(ys) - min(ys)
        plot_width, plot_height = self.width() - 2 * _MARGIN, self.height() - 2 * _MARGIN
        span = max(width / max(plot_width, 1.0), height / max(plot_height, 1.0), 1e-3)
        return 1 / span, (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2

    def _screen_point(self, row: PhotoRow, scale: float, cx: float, cy: float) -> QPointF:
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
        if not self._has_photos:
            return
        if not self._rows:
            painter.drawText(
                QRectF(self.rect()).adjusted(12, 8, -12, -8),
                int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap),
                tr("The photos have no GPS positions. Align them to draw the plan."),
            )
            return
        scale, cx, cy = self._scale()
        for row in self._rows:
            self._draw(painter, row, self._screen_point(row, scale, cx, cy))
        painter.setPen(QPen(text, 1.5))
        frame = self._frame
        if frame.has_north:
            painter.drawText(QPointF(self.width() - 18, 16), "N")
            painter.drawLine(QPointF(self.width() - 13, 36), QPointF(self.width() - 13, 20))
        if not frame.has_metres:
            painter.drawText(QPointF(8, self.height() - 6), frame.name())
            return
        if not frame.has_north:
            painter.drawText(QPointF(8, 16), frame.name())
        length = round_length(70 / scale)
        y = self.height() - 9.0
        painter.drawLine(QPointF(8, y), QPointF(8 + length * scale, y))
        painter.drawText(QPointF(12 + length * scale, y + 4), scale_bar_text(length))

    def _draw(self, painter: QPainter, row: PhotoRow, position: QPointF) -> None:
        color = QColor(_FLAGGED_COLOR if row.findings else _GOOD_COLOR)
        if row.name in self._selection:
            color = QColor(_SELECTED_COLOR)
        painter.setPen(QPen(color, 2.0))
        painter.setBrush(color)
        if row.look_direction is not None:
            dx, dy = row.look_direction
            painter.drawLine(position, position + QPointF(16 * dx, -16 * dy))
        if row.findings:
            painter.drawPolygon(
                QPolygonF(
                    [
                        position + QPointF(0, -5.5),
                        position + QPointF(5, 4),
                        position + QPointF(-5, 4),
                    ]
                )
            )
        else:
            painter.drawEllipse(position, 4, 4)

    def _nearest(self, position: QPointF) -> PhotoRow | None:
        if not self._rows:
            return None
        scale = self._scale()
        nearest_photo = min(
            self._rows,
            key=lambda row: (self._screen_point(row, *scale) - position).manhattanLength(),
        )
        is_near = (self._screen_point(nearest_photo, *scale) - position).manhattanLength() < 14
        return nearest_photo if is_near else None

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        row = self._nearest(event.position())
        if row is not None and callable(self._click_callback):
            self._click_callback(row.name)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QHelpEvent):
            row = self._nearest(QPointF(event.pos()))
            text = "" if row is None else "\n".join([row.name, *row.findings])
            QToolTip.showText(event.globalPos(), escape_markup(text), self)
            return True
        return super().event(event)
