"""Matrix that shows the number of inliers of each pair of photos."""

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
from vomstudio.rendering.view.scalars import colormap_table
from vomstudio.ui.base.controls import escape_markup

_MAX_CELL_PX, _MIN_CELL_PX = 34.0, 2.0
_MAX_HEIGHT_PX = 360.0
_WEAK_COLOR = QColor("#d55e00")


class PairMatrix(QWidget):
    """Matrix of photo pairs, coloured by the number of inliers.

    Weak pairs are framed if the cells are large enough, and pairs without inliers are grey.
    `pair_selected` emits rows (i, j) of two photos with i < j.
    """

    pair_selected = Signal(int, int)

    def __init__(self) -> None:
        super().__init__()
        self._names: list[str] = []
        self._pairs: dict[tuple[int, int], tuple[int, int]] = {}
        self._min_inliers, self._max_inliers = 0, 1
        self._current_pair: tuple[int, int] | None = None
        self._table = colormap_table("viridis")
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:  # noqa: N802
        label_height = QFontMetricsF(system_font()).height() + 6.0
        return QSize(
            320, round(min(_MAX_HEIGHT_PX, len(self._names) * _MAX_CELL_PX + label_height))
        )

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        return QSize(180, self.sizeHint().height())

    def fill(self, names: Sequence[str], pairs: Sequence[Sequence[int]], min_inliers: int) -> None:
        """Show pairs (i, j, matches, inliers) with i < j.

        Pairs with fewer inliers than `min_inliers` are weak.
        """
        self._names = list(names)
        self._pairs = {(i, j): (matches, inliers) for i, j, matches, inliers in pairs}
        self._max_inliers = max((inliers for _, inliers in self._pairs.values()), default=1)
        self._min_inliers = min_inliers
        self.updateGeometry()
        self.update()

    def show_pair(self, i: int, j: int) -> None:
        self._current_pair = (min(i, j), max(i, j))
        self.update()

    def _cell_layout(self) -> tuple[float, float, float]:
        """Return the left and top of the first cell, and the cell size, in pixels."""
        count = max(len(self._names), 1)
        metrics = QFontMetricsF(system_font())
        label_width = metrics.horizontalAdvance(str(count)) + 8.0
        cell_size = min(
            (self.width() - label_width) / count, (self.height() - metrics.height()) / count
        )
        cell_size = min(max(cell_size, _MIN_CELL_PX), _MAX_CELL_PX)
        return label_width, metrics.height() + 2.0, cell_size

    def _cell_rect(self, i: int, j: int) -> QRectF:
        x0, y0, cell_size = self._cell_layout()
        gap = 1.0 if cell_size > 6 else 0.0
        return QRectF(x0 + j * cell_size, y0 + i * cell_size, cell_size - gap, cell_size - gap)

    def _color(self, inliers: int) -> QColor:
        brightness = math.log1p(inliers) / math.log1p(max(self._max_inliers, 1))
        red, green, blue = (int(v) for v in self._table[round(255 * brightness)])
        return QColor(red, green, blue)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(system_font())
        metrics = QFontMetricsF(system_font())
        x0, y0, cell_size = self._cell_layout()
        text_color = self.palette().text().color()
        count = len(self._names)
        label_step = next(
            (s for s in (1, 5, 10, 20, 50, 100) if s * cell_size >= metrics.height() + 2), 100
        )
        painter.setPen(text_color)
        for row in range(count):
            if row % label_step == 0 or (
                label_step > 1 and row == count - 1 and row % label_step > label_step // 2
            ):
                label = str(row + 1)
                width = metrics.horizontalAdvance(label)
                y = y0 + (row + 0.5) * cell_size + metrics.capHeight() / 2
                painter.drawText(QPointF(x0 - width - 5, y), label)
                painter.drawText(QPointF(x0 + (row + 0.5) * cell_size - width / 2, y0 - 5), label)
        for (i, j), (_, inliers) in self._pairs.items():
            for cell in (self._cell_rect(i, j), self._cell_rect(j, i)):
                if inliers:
                    painter.fillRect(cell, self._color(inliers))
                else:
                    painter.fillRect(cell, self.palette().mid())
                if 0 < inliers < self._min_inliers and cell_size > 8:
                    painter.setPen(QPen(_WEAK_COLOR, 1.6))
                    painter.setBrush(Qt.BrushStyle.NoBrush)
                    painter.drawRect(cell.adjusted(1, 1, -1, -1))
        if self._current_pair is not None:
            i, j = self._current_pair
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for cell in (self._cell_rect(i, j), self._cell_rect(j, i)):
                for tint, width in ((QColor(0, 0, 0), 3.4), (QColor(255, 255, 255), 1.6)):
                    painter.setPen(QPen(tint, width))
                    painter.drawRect(cell.adjusted(-1, -1, 1, 1))

    def _pair_at(self, position: QPointF) -> tuple[int, int] | None:
        x0, y0, cell_size = self._cell_layout()
        j, i = (
            math.floor((position.x() - x0) / cell_size),
            math.floor((position.y() - y0) / cell_size),
        )
        pair = (min(i, j), max(i, j))
        return pair if pair in self._pairs else None

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if (pair := self._pair_at(event.position())) is not None:
            self.pair_selected.emit(*pair)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QHelpEvent):
            pair = self._pair_at(QPointF(event.pos()))
            text = ""
            if pair is not None:
                matches, inliers = self._pairs[pair]
                a, b = (self._names[k] for k in pair)
                text = tr(
                    "{a} and {b}\n{matches:,} matches, {inliers:,} inliers",
                    a=a,
                    b=b,
                    matches=matches,
                    inliers=inliers,
                )
            QToolTip.showText(event.globalPos(), escape_markup(text), self)
            return True
        return super().event(event)
