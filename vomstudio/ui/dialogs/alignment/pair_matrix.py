"""The number of inliers of each pair of photos as a matrix of colours."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QHelpEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
)
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from vomstudio.core.words import tr
from vomstudio.rendering.qt.painting import system_font
from vomstudio.rendering.view.scalars import map_table
from vomstudio.ui.base.controls import escape_markup

_LARGEST, _SMALLEST = 34.0, 2.0
_TALLEST = 360.0
_WEAK = QColor("#d55e00")


class PairMatrix(QWidget):
    """Rows and columns are numbered photos. Weak pairs have a frame, pairs that were not matched
    are empty. chosen : rows (i, j) of two photos, i < j."""

    chosen = Signal(int, int)

    def __init__(self) -> None:
        super().__init__()
        self._names: list[str] = []
        self._pairs: dict[tuple[int, int], tuple[int, int]] = {}
        self._weak_below, self._most = 0, 1
        self._now: tuple[int, int] | None = None
        self._table = map_table("viridis")
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:  # noqa: N802
        top = QFontMetricsF(system_font()).height() + 6.0
        return QSize(320, round(min(_TALLEST, len(self._names) * _LARGEST + top)))

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        return QSize(180, self.sizeHint().height())

    def fill(self, names: Sequence[str], pairs: Sequence[Sequence[int]], weak_below: int) -> None:
        """pairs: (i, j, matches, inliers) with i < j; weak_below: fewer inliers are weak"""
        self._names = list(names)
        self._pairs = {(i, j): (tried, kept) for i, j, tried, kept in pairs}
        self._most = max((kept for _, kept in self._pairs.values()), default=1)
        self._weak_below = weak_below
        self.updateGeometry()
        self.update()

    def show_pair(self, i: int, j: int) -> None:
        self._now = (min(i, j), max(i, j))
        self.update()

    def _layout(self) -> tuple[float, float, float]:
        """Left and top of the first cell, and the side of a cell."""
        count = max(len(self._names), 1)
        metrics = QFontMetricsF(system_font())
        label = metrics.horizontalAdvance(str(count)) + 8.0
        side = min((self.width() - label) / count, (self.height() - metrics.height()) / count)
        side = min(max(side, _SMALLEST), _LARGEST)
        return label, metrics.height() + 2.0, side

    def _cell(self, i: int, j: int) -> QRectF:
        left, top, side = self._layout()
        gap = 1.0 if side > 6 else 0.0
        return QRectF(left + j * side, top + i * side, side - gap, side - gap)

    def _color(self, kept: int) -> QColor:
        place = math.log1p(kept) / math.log1p(max(self._most, 1))
        red, green, blue = (int(v) for v in self._table[round(255 * place)])
        return QColor(red, green, blue)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(system_font())
        metrics = QFontMetricsF(system_font())
        left, top, side = self._layout()
        text = self.palette().text().color()
        count = len(self._names)
        every = next((s for s in (1, 5, 10, 20, 50, 100) if s * side >= metrics.height() + 2), 100)
        painter.setPen(text)
        for row in range(count):
            if row % every == 0 or (every > 1 and row == count - 1 and row % every > every // 2):
                words = str(row + 1)
                wide = metrics.horizontalAdvance(words)
                y = top + (row + 0.5) * side + metrics.capHeight() / 2
                painter.drawText(QPointF(left - wide - 5, y), words)
                painter.drawText(QPointF(left + (row + 0.5) * side - wide / 2, top - 5), words)
        for (i, j), (_, kept) in self._pairs.items():
            for cell in (self._cell(i, j), self._cell(j, i)):
                if kept:
                    painter.fillRect(cell, self._color(kept))
                else:
                    painter.fillRect(cell, self.palette().mid())
                if 0 < kept < self._weak_below and side > 8:
                    painter.setPen(QPen(_WEAK, 1.6))
                    painter.setBrush(Qt.BrushStyle.NoBrush)
                    painter.drawRect(cell.adjusted(1, 1, -1, -1))
        if self._now is not None:
            i, j = self._now
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for cell in (self._cell(i, j), self._cell(j, i)):
                for tint, wide in ((QColor(0, 0, 0), 3.4), (QColor(255, 255, 255), 1.6)):
                    painter.setPen(QPen(tint, wide))
                    painter.drawRect(cell.adjusted(-1, -1, 1, 1))

    def _pair_at(self, at: QPointF) -> tuple[int, int] | None:
        left, top, side = self._layout()
        j, i = math.floor((at.x() - left) / side), math.floor((at.y() - top) / side)
        pair = (min(i, j), max(i, j))
        return pair if pair in self._pairs else None

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if (pair := self._pair_at(event.position())) is not None:
            self.chosen.emit(*pair)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QHelpEvent):
            pair = self._pair_at(QPointF(event.pos()))
            words = ""
            if pair is not None:
                tried, kept = self._pairs[pair]
                a, b = (self._names[k] for k in pair)
                words = tr(
                    "{a} and {b}\n{matches:,} matches, {inliers:,} inliers",
                    a=a,
                    b=b,
                    matches=tried,
                    inliers=kept,
                )
            QToolTip.showText(event.globalPos(), escape_markup(words), self)
            return True
        return super().event(event)
