"""View of a coloured, shaded elevation model with a scale bar and a colour bar."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.products.elevation.picture import ElevationPicture

_BAR_WIDTH_PX = 12
_GAP_PX = 6
_HALO_COLOR = QColor(255, 255, 255, 200)


class ElevationView(QWidget):
    """View of an elevation model.

    `cursor_text_changed` is emitted with the height under the cursor.
    """

    cursor_text_changed = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Elevation model"))
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.picture: ElevationPicture | None = None
        self._image = QImage()
        self._is_metric = True

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(320, 220)

    def show_picture(self, picture: ElevationPicture | None, *, is_metric: bool = True) -> None:
        """Show a picture; `is_metric` is True if its heights are in metres."""
        self.picture, self._is_metric = picture, is_metric
        if picture is None:
            self._image = QImage()
        else:
            h, w, _ = picture.rgba.shape
            form = QImage.Format.Format_RGBA8888
            self._image = QImage(picture.rgba.data, w, h, 4 * w, form).copy()
        self.update()

    def _image_rect(self) -> QRectF:
        """Return the largest rectangle for the image that leaves space for the colour bar."""
        label_width = (
            self.fontMetrics().horizontalAdvance("−00000.00 m") + _BAR_WIDTH_PX + 3 * _GAP_PX
        )
        area = QRectF(0, 0, max(self.width() - label_width, 1), max(self.height(), 1))
        size = self._image.size().toSizeF()
        size.scale(area.size(), Qt.AspectRatioMode.KeepAspectRatio)
        rect = QRectF(0, 0, size.width(), size.height())
        rect.moveCenter(area.center())
        return rect

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
        if self.picture is None:
            self._draw_message(painter, tr("The elevation model will be shown here."))
            return
        rect = self._image_rect()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(rect, self._image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._draw_scale(painter, rect)
        self._draw_colors(painter, rect)

    def _draw_message(self, painter: QPainter, text: str) -> None:
        painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
        flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
        painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, text)

    def _draw_scale(self, painter: QPainter, rect: QRectF) -> None:
        assert self.picture is not None
        units_per_pixel = self.picture.step * self.picture.rgba.shape[1] / max(rect.width(), 1.0)
        length = round_length(0.25 * rect.width() * units_per_pixel)
        text = scale_bar_text(length, is_metric=self._is_metric)
        width = length / units_per_pixel
        height = painter.fontMetrics().height()
        box_width = max(width, painter.fontMetrics().horizontalAdvance(text)) + 10
        box = QRectF(rect.left() + _GAP_PX, rect.bottom() - height - 14, box_width, height + 10)
        painter.fillRect(box, _HALO_COLOR)
        painter.setPen(QPen(QColor("#141414"), 2.0))
        y = box.bottom() - 4
        painter.drawLine(
            QPoint(round(box.left() + 5), round(y)), QPoint(round(box.left() + 5 + width), round(y))
        )
        painter.drawText(box.adjusted(5, 0, 0, 0), int(Qt.AlignmentFlag.AlignTop), text)

    def _draw_colors(self, painter: QPainter, rect: QRectF) -> None:
        picture = self.picture
        assert picture is not None
        x = (
            self.width()
            - self.fontMetrics().horizontalAdvance("−00000.00 m")
            - _BAR_WIDTH_PX
            - _GAP_PX
        )
        height = min(float(self.height() - 24), 180.0)
        bar = QRectF(x, (self.height() - height) / 2, _BAR_WIDTH_PX, height)
        count = len(picture.table)
        for k in range(count):
            color = QColor(*(int(v) for v in picture.table[count - 1 - k]))
            strip = QRectF(
                bar.left(), bar.top() + k * height / count, bar.width(), height / count + 1
            )
            painter.fillRect(strip, color)
        painter.setPen(self.palette().color(QPalette.ColorRole.WindowText))
        unit = "m" if self._is_metric else tr("units")
        centre = painter.fontMetrics().height() / 2
        for fraction in (0.0, 0.5, 1.0):
            value = picture.low + fraction * (picture.high - picture.low)
            y = bar.bottom() - fraction * height
            row = QRectF(bar.right() + _GAP_PX, y - centre, self.width() - bar.right(), 2 * centre)
            painter.drawText(row, int(Qt.AlignmentFlag.AlignVCenter), f"{value:.2f} {unit}")

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        self.cursor_text_changed.emit(self._cursor_text(event.position().x(), event.position().y()))

    def _cursor_text(self, x: float, y: float) -> str:
        rect = self._image_rect()
        if self.picture is None or not rect.contains(x, y):
            return ""
        h, w = self.picture.heights.shape
        column = min(int((x - rect.left()) / rect.width() * w), w - 1)
        row = min(int((y - rect.top()) / rect.height() * h), h - 1)
        value = float(self.picture.heights[row, column])
        if value != value:
            return tr("no height")
        return tr(
            "height {value:.3f} {unit}", value=value, unit="m" if self._is_metric else tr("units")
        )
