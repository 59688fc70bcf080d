"""Small legend of the colours of features over the outcrop, painted with Qt only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen

from vomstudio.rendering.qt import painting

MARGIN, PADDING = 16.0, 8.0
TOP = 56.0
"""Distance from the top, with space for a message of two lines."""
SWATCH, GAP = 11.0, 7.0


@dataclass(frozen=True)
class ColorEntry:
    """Row of a legend.

    Parameters
    ----------
    color : str
        Colour as "#rrggbb".
    text : str
    verdict : str
        Verdict whose mark replaces the swatch, or "".
    """

    color: str
    text: str
    verdict: str = ""


class ColorLegend:
    """Title and entries of a legend in the upper left corner."""

    def __init__(self, title: str = "", entries: Sequence[ColorEntry] = ()) -> None:
        self.title, self.entries = title, tuple(entries)

    def box(self) -> QRectF:
        """Return the rectangle of the legend; empty if there are no entries."""
        if not self.entries:
            return QRectF()
        bold = QFontMetricsF(painting.system_font(bold=True))
        plain_metrics = QFontMetricsF(painting.system_font())
        rows = [
            SWATCH + GAP + plain_metrics.horizontalAdvance(entry.text) for entry in self.entries
        ]
        width = max(bold.horizontalAdvance(self.title), *rows) + 2.0 * PADDING
        height = bold.height() + plain_metrics.height() * len(self.entries) + 2.0 * PADDING
        return QRectF(MARGIN, TOP, width, height)

    def paint(self, painter: QPainter) -> None:
        """Paint the legend."""
        box = self.box()
        if box.isEmpty():
            return
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(painting.PANEL)
        painter.drawRoundedRect(box, 5.0, 5.0)
        bold, plain_font = painting.system_font(bold=True), painting.system_font()
        metrics = QFontMetricsF(bold)
        x, y = box.left() + PADDING, box.top() + PADDING
        painter.setFont(bold)
        painter.setPen(painting.TEXT)
        painter.drawText(QPointF(x, y + metrics.ascent()), self.title)
        y += metrics.height()
        metrics = QFontMetricsF(plain_font)
        painter.setFont(plain_font)
        for entry in self.entries:
            swatch = QRectF(x, y + (metrics.height() - SWATCH) / 2.0, SWATCH, SWATCH)
            if entry.verdict:
                painting.draw_verdict_shape(painter, swatch, entry.verdict)
            else:
                painter.setPen(QPen(painting.TEXT, 0.8))
                painter.setBrush(QColor(entry.color))
                painter.drawRoundedRect(swatch, 2.0, 2.0)
            painter.setPen(painting.TEXT)
            painter.drawText(QPointF(x + SWATCH + GAP, y + metrics.ascent()), entry.text)
            y += metrics.height()
        painter.restore()
