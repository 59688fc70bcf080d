"""Histogram of signed distances in the colours of the model."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.arrays import ByteArray, FloatArray, IndexArray
from vomstudio.core.words import tr
from vomstudio.rendering.view.scalars import PALETTES, colormap_table

_BIN_COUNT = 51
_MARGIN_PX = 8.0


def count_distances(distances: FloatArray, limit_m: float) -> IndexArray:
    """Count distances (n,) in bins from -limit_m to limit_m.

    Values that are not finite are ignored. Distances beyond the limits are counted in the
    outermost bins.
    """
    clipped_distances = np.clip(distances[np.isfinite(distances)], -limit_m, limit_m)
    return np.histogram(clipped_distances, bins=_BIN_COUNT, range=(-limit_m, limit_m))[0]


class Histogram(QWidget):
    """Histogram with a thin line at zero and a dashed line at the median."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Histogram of the distances"))
        self.setMinimumHeight(110)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.counts: IndexArray = np.zeros(0, np.intp)
        self._limit_m = self._median_m = 0.0

    @cached_property
    def _bar_colors(self) -> ByteArray:
        """Colour table; reading it loads Matplotlib on first use."""
        return colormap_table(PALETTES["diverging"][0])

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(220, 130)

    def show_counts(self, counts: IndexArray, limit_m: float, median_m: float) -> None:
        """Show the counts returned by `count_distances`."""
        self.counts, self._limit_m, self._median_m = counts, limit_m, median_m
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
        if not len(self.counts) or self._limit_m <= 0.0:
            return
        text_color = self.palette().color(QPalette.ColorRole.WindowText)
        label_height = painter.fontMetrics().height() + 4.0
        plot = QRectF(self.rect()).adjusted(_MARGIN_PX, _MARGIN_PX, -_MARGIN_PX, -label_height)
        bar_width = plot.width() / _BIN_COUNT
        max_count = max(int(self.counts.max()), 1)
        for bin_index, count in enumerate(self.counts.tolist()):
            red, green, blue = self._bar_colors[
                int((bin_index + 0.5) / _BIN_COUNT * len(self._bar_colors))
            ]
            bar_height = plot.height() * count / max_count
            bar = QRectF(
                plot.left() + bin_index * bar_width,
                plot.bottom() - bar_height,
                bar_width,
                bar_height,
            )
            painter.fillRect(bar, QColor(int(red), int(green), int(blue)))
        # A base line is drawn because pale bars are barely visible.
        painter.setPen(QPen(text_color, 1.0))
        painter.drawLine(plot.bottomLeft(), plot.bottomRight())
        self._draw_line(painter, plot, 0.0, QPen(text_color, 1.0))
        self._draw_line(painter, plot, self._median_m, QPen(text_color, 1.4, Qt.PenStyle.DashLine))
        label_rect = QRectF(plot.left(), plot.bottom() + 2.0, plot.width(), label_height)
        for alignment, label in (
            (Qt.AlignmentFlag.AlignLeft, f"−{self._limit_m:.3g} m"),
            (Qt.AlignmentFlag.AlignHCenter, "0"),
            (Qt.AlignmentFlag.AlignRight, f"{self._limit_m:.3g} m"),
        ):
            painter.drawText(label_rect, int(alignment | Qt.AlignmentFlag.AlignTop), label)

    def _draw_line(self, painter: QPainter, plot: QRectF, value_m: float, pen: QPen) -> None:
        position = 0.5 + 0.5 * float(np.clip(value_m / self._limit_m, -1.0, 1.0))
        x = plot.left() + position * plot.width()
        painter.setPen(pen)
        painter.drawLine(QPointF(x, plot.top()), QPointF(x, plot.bottom()))
