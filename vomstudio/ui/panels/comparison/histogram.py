"""A histogram of signed distances, in the colours in which the model shows them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.arrays import ByteArray, FloatArray, IndexArray
from vomstudio.core.words import tr
from vomstudio.rendering.view.scalars import PALETTES, map_table

_BINS = 51
_MARGIN = 8.0


def counts_of(distances: FloatArray, reach: float) -> IndexArray:
    """Of distances (n,) in m, NaN where there is none, from -reach to reach; what lies beyond is
    counted with the last ones."""
    inside = np.clip(distances[np.isfinite(distances)], -reach, reach)
    return np.histogram(inside, bins=_BINS, range=(-reach, reach))[0]


class Histogram(QWidget):
    """From -reach to reach, with lines at zero (thin) and at the median (dashed)."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Histogram of the distances"))
        self.setMinimumHeight(110)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.counts: IndexArray = np.zeros(0, np.intp)
        self._reach = self._median = 0.0

    @cached_property
    def _colors(self) -> ByteArray:
        """Of the map, which matplotlib is loaded for: not before there is something to show."""
        return map_table(PALETTES["diverging"][0])

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(220, 130)

    def show_counts(self, counts: IndexArray, reach: float, median: float) -> None:
        """What `counts_of` gives; reach, median : m"""
        self.counts, self._reach, self._median = counts, reach, median
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
        if not len(self.counts) or self._reach <= 0.0:
            return
        text = self.palette().color(QPalette.ColorRole.WindowText)
        below = painter.fontMetrics().height() + 4.0
        room = QRectF(self.rect()).adjusted(_MARGIN, _MARGIN, -_MARGIN, -below)
        wide = room.width() / _BINS
        highest = max(int(self.counts.max()), 1)
        for number, count in enumerate(self.counts.tolist()):
            red, green, blue = self._colors[int((number + 0.5) / _BINS * len(self._colors))]
            high = room.height() * count / highest
            bar = QRectF(room.left() + number * wide, room.bottom() - high, wide, high)
            painter.fillRect(bar, QColor(int(red), int(green), int(blue)))
        # Pale bars have an edge too.
        painter.setPen(QPen(text, 1.0))
        painter.drawLine(room.bottomLeft(), room.bottomRight())
        self._line(painter, room, 0.0, QPen(text, 1.0))
        self._line(painter, room, self._median, QPen(text, 1.4, Qt.PenStyle.DashLine))
        line = QRectF(room.left(), room.bottom() + 2.0, room.width(), below)
        for align, words in (
            (Qt.AlignmentFlag.AlignLeft, f"−{self._reach:.3g} m"),
            (Qt.AlignmentFlag.AlignHCenter, "0"),
            (Qt.AlignmentFlag.AlignRight, f"{self._reach:.3g} m"),
        ):
            painter.drawText(line, int(align | Qt.AlignmentFlag.AlignTop), words)

    def _line(self, painter: QPainter, room: QRectF, at: float, pen: QPen) -> None:
        share = 0.5 + 0.5 * float(np.clip(at / self._reach, -1.0, 1.0))
        x = room.left() + share * room.width()
        painter.setPen(pen)
        painter.drawLine(QPointF(x, room.top()), QPointF(x, room.bottom()))
