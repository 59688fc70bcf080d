"""Box beside the cursor with the reading of an unfinished feature."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen

from vomstudio.rendering.qt.painting import (
    TEXT,
    VERDICT_COLORS,
    draw_verdict_shape,
    system_font,
)

GAP = 7.0
_SIDE_PADDING, _TOP_PADDING = 10.0, 6.0


class ReadoutBox:
    """Reading that is painted in a box.

    Parameters
    ----------
    lines : sequence of str
        Lines of text, the most important line first.
    verdict : {"good", "doubtful", "poor"} or None
    """

    def __init__(self, lines: Sequence[str], verdict: str | None) -> None:
        self._lines = list(lines) or [""]
        self._verdict = verdict
        self._fonts: list[QFont] = [
            system_font(1.15, bold=True),
            *[system_font()] * (len(self._lines) - 1),
        ]
        self._metrics = [QFontMetricsF(font) for font in self._fonts]

    def size(self) -> tuple[float, float]:
        """Return width and height in pixels."""
        first_metrics = self._metrics[0]
        header_width = first_metrics.horizontalAdvance(self._lines[0])
        if self._verdict:
            header_width += (
                self._icon_width() + 2 * GAP + first_metrics.horizontalAdvance(self._verdict)
            )
        other_lines = zip(self._metrics[1:], self._lines[1:], strict=True)
        width = max([header_width] + [m.horizontalAdvance(text) for m, text in other_lines])
        return width + 2 * _SIDE_PADDING, sum(m.height() for m in self._metrics) + 2 * _TOP_PADDING

    def paint(self, painter: QPainter, box: QRectF) -> None:
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        edge = QColor(VERDICT_COLORS.get(self._verdict or "", "#c8c8c8"))
        painter.setPen(QPen(edge, 1.6))
        painter.setBrush(QColor(18, 20, 23, 225))
        painter.drawRoundedRect(box, 5.0, 5.0)
        line = self._paint_head(painter, box, edge)
        painter.setPen(QColor(225, 225, 225))
        other_lines = zip(self._metrics[1:], self._fonts[1:], self._lines[1:], strict=True)
        for metrics, font, text in other_lines:
            painter.setFont(font)
            painter.drawText(QPointF(box.left() + _SIDE_PADDING, line + metrics.ascent()), text)
            line += metrics.height()
        painter.restore()

    def _paint_head(self, painter: QPainter, box: QRectF, edge: QColor) -> float:
        """Paint the verdict as a shape and a word, and the first line of text.

        Return the y coordinate of the next line.
        """
        x, line = box.left() + _SIDE_PADDING, box.top() + _TOP_PADDING
        first_metrics, icon = self._metrics[0], self._icon_width()
        if self._verdict:
            top = line + (first_metrics.height() - icon) / 2.0
            draw_verdict_shape(painter, QRectF(x, top, icon, icon), self._verdict)
            x += icon + GAP
        painter.setFont(self._fonts[0])
        painter.setPen(TEXT)
        painter.drawText(QPointF(x, line + first_metrics.ascent()), self._lines[0])
        if self._verdict:
            x += first_metrics.horizontalAdvance(self._lines[0]) + GAP
            painter.setPen(edge.lighter(125))
            painter.drawText(QPointF(x, line + first_metrics.ascent()), self._verdict)
        return line + first_metrics.height()

    def _icon_width(self) -> float:
        return self._metrics[0].height() * 0.82 if self._verdict else 0.0
