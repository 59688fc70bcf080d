"""Page of figures with a hint while it is empty."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QTextBrowser


class FiguresPage(QTextBrowser):
    def __init__(self, empty_text: str) -> None:
        super().__init__()
        self.placeholder = empty_text

    def show_reason(self, reason: str) -> None:
        """Clear the page and show why the figures are missing."""
        self.placeholder = reason
        self.clear()
        self.viewport().update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        super().paintEvent(event)
        if not self.document().isEmpty():
            return
        # Qt truncates its own placeholder text after the first line.
        painter = QPainter(self.viewport())
        painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
        flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
        painter.drawText(self.viewport().rect().adjusted(12, 12, -12, -12), flags, self.placeholder)
