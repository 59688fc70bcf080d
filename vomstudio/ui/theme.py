"""Icons, badges and sizes that every panel shares."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QIcon, QPainter, QPalette, QPen, QPixmap
from PySide6.QtWidgets import QApplication


def icon(name: str) -> QIcon:
    """A Material Design icon in the palette's text colour."""
    import qtawesome

    palette = QApplication.palette()
    return qtawesome.icon(
        f"mdi6.{name}",
        color=palette.color(QPalette.ColorRole.ButtonText),
        color_disabled=palette.color(QPalette.ColorGroup.Disabled, QPalette.ColorRole.ButtonText),
    )


def verdict_icon(verdict: str | None) -> QIcon:
    """Green circle, amber triangle, red square; empty where nothing is judged."""
    pixmap = QPixmap(QSize(32, 32))
    pixmap.fill(Qt.GlobalColor.transparent)
    if verdict is not None:
        from vomstudio.rendering.painting import draw_verdict_shape

        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw_verdict_shape(painter, QRectF(4, 4, 24, 24), verdict)
        painter.end()
    return QIcon(pixmap)


def swatch(color: str) -> QIcon:
    """A small disc in a feature type's colour."""
    pixmap = QPixmap(QSize(32, 32))
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(QColor(color))
    painter.setPen(QPen(QColor(0, 0, 0, 140), 1.5))
    painter.drawEllipse(QPointF(16, 16), 11, 11)
    painter.end()
    return QIcon(pixmap)


def at_least_nine_points(application: QApplication) -> None:
    font: QFont = application.font()
    if font.pointSizeF() < 9.0:
        font.setPointSizeF(9.0)
        application.setFont(font)
