"""An elevation model on the screen: coloured and shaded, with scale, range, and the height under
the cursor."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import bar_text, round_length
from vomstudio.products.elevation.picture import ElevationPicture

_BAR_WIDTH = 12
_GAP = 6
_HALO = QColor(255, 255, 255, 200)


class ElevationView(QWidget):
    """pointed : what is under the cursor, in words; empty beside the model"""

    pointed = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Elevation model"))
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.shown: ElevationPicture | None = None
        self._image = QImage()
        self._metric = True

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(320, 220)

    def show_picture(self, picture: ElevationPicture | None, *, metric: bool = True) -> None:
        """metric : the unit of heights is known"""
        self.shown, self._metric = picture, metric
        if picture is None:
            self._image = QImage()
        else:
            h, w, _ = picture.rgba.shape
            form = QImage.Format.Format_RGBA8888
            self._image = QImage(picture.rgba.data, w, h, 4 * w, form).copy()
        self.update()

    def _place(self) -> QRectF:
        """Of the picture, as large as it fits beside its colours."""
        text = self.fontMetrics().horizontalAdvance("−00000.00 m") + _BAR_WIDTH + 3 * _GAP
        room = QRectF(0, 0, max(self.width() - text, 1), max(self.height(), 1))
        size = self._image.size().toSizeF()
        size.scale(room.size(), Qt.AspectRatioMode.KeepAspectRatio)
        place = QRectF(0, 0, size.width(), size.height())
        place.moveCenter(room.center())
        return place

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
        if self.shown is None:
            self._say(painter, tr("The elevation model will be shown here."))
            return
        place = self._place()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(place, self._image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._draw_scale(painter, place)
        self._draw_colors(painter, place)

    def _say(self, painter: QPainter, text: str) -> None:
        painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
        flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
        painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, text)

    def _draw_scale(self, painter: QPainter, place: QRectF) -> None:
        assert self.shown is not None
        per_pixel = self.shown.step * self.shown.rgba.shape[1] / max(place.width(), 1.0)
        length = round_length(0.25 * place.width() * per_pixel)
        words = bar_text(length, metric=self._metric)
        wide = length / per_pixel
        high = painter.fontMetrics().height()
        room = max(wide, painter.fontMetrics().horizontalAdvance(words)) + 10
        box = QRectF(place.left() + _GAP, place.bottom() - high - 14, room, high + 10)
        painter.fillRect(box, _HALO)
        painter.setPen(QPen(QColor("#141414"), 2.0))
        y = box.bottom() - 4
        painter.drawLine(
            QPoint(round(box.left() + 5), round(y)), QPoint(round(box.left() + 5 + wide), round(y))
        )
        painter.drawText(box.adjusted(5, 0, 0, 0), int(Qt.AlignmentFlag.AlignTop), words)

    def _draw_colors(self, painter: QPainter, place: QRectF) -> None:
        shown = self.shown
        assert shown is not None
        x = self.width() - self.fontMetrics().horizontalAdvance("−00000.00 m") - _BAR_WIDTH - _GAP
        high = min(float(self.height() - 24), 180.0)
        bar = QRectF(x, (self.height() - high) / 2, _BAR_WIDTH, high)
        count = len(shown.table)
        for k in range(count):
            color = QColor(*(int(v) for v in shown.table[count - 1 - k]))
            strip = QRectF(bar.left(), bar.top() + k * high / count, bar.width(), high / count + 1)
            painter.fillRect(strip, color)
        painter.setPen(self.palette().color(QPalette.ColorRole.WindowText))
        unit = "m" if self._metric else tr("units")
        middle = painter.fontMetrics().height() / 2
        for share in (0.0, 0.5, 1.0):
            value = shown.low + share * (shown.high - shown.low)
            y = bar.bottom() - share * high
            row = QRectF(bar.right() + _GAP, y - middle, self.width() - bar.right(), 2 * middle)
            painter.drawText(row, int(Qt.AlignmentFlag.AlignVCenter), f"{value:.2f} {unit}")

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        self.pointed.emit(self._words_at(event.position().x(), event.position().y()))

    def _words_at(self, x: float, y: float) -> str:
        place = self._place()
        if self.shown is None or not place.contains(x, y):
            return ""
        h, w = self.shown.heights.shape
        column = min(int((x - place.left()) / place.width() * w), w - 1)
        row = min(int((y - place.top()) / place.height() * h), h - 1)
        value = float(self.shown.heights[row, column])
        if value != value:
            return tr("no height here")
        return tr(
            "height {value:.3f} {unit}", value=value, unit="m" if self._metric else tr("units")
        )
