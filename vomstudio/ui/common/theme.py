"""Icons, badges and sizes that every panel shares."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import (
    QColor,
    QFont,
    QIcon,
    QPainter,
    QPalette,
    QPen,
    QPixmap,
    QPixmapCache,
    QPolygonF,
)
from PySide6.QtWidgets import QApplication

from vomstudio.words import to_translate


def icon(name: str) -> QIcon:
    """A Material Design icon in the palette's text colour."""
    import qtawesome

    palette = QApplication.palette()
    made: QIcon = qtawesome.icon(
        f"mdi6.{name}",
        color=palette.color(QPalette.ColorRole.ButtonText),
        color_disabled=palette.color(QPalette.ColorGroup.Disabled, QPalette.ColorRole.ButtonText),
    )
    return made


def verdict_icon(verdict: str | None) -> QIcon:
    """Green circle, amber triangle, red square; empty where nothing is judged."""

    def draw(painter: QPainter) -> None:
        if verdict is not None:
            from vomstudio.rendering.qt.painting import draw_verdict_shape

            draw_verdict_shape(painter, QRectF(4, 4, 24, 24), verdict)

    return _painted(f"verdict {verdict}", draw)


def picture_icon(path: str | None, size: QSize) -> QIcon:
    """A picture file in the middle of a box of this size, so that texts beside icons line up. (An
    icon that is made of a JPEG's name is stretched by Qt.)"""
    box = QPixmap(size)
    box.fill(Qt.GlobalColor.transparent)
    picture = QPixmap(path or "")
    if not picture.isNull():
        mode = Qt.TransformationMode.SmoothTransformation
        picture = picture.scaled(size, Qt.AspectRatioMode.KeepAspectRatio, mode)
        painter = QPainter(box)
        off = (size - picture.size()) / 2
        painter.drawPixmap(off.width(), off.height(), picture)
        painter.end()
    icon = QIcon(box)
    # A chosen row must not tint it.
    icon.addPixmap(box, QIcon.Mode.Selected)
    return icon


def swatch(color: str) -> QIcon:
    """A small disc in a feature type's colour."""

    def draw(painter: QPainter) -> None:
        painter.setBrush(QColor(color))
        painter.setPen(QPen(QColor(0, 0, 0, 140), 1.5))
        painter.drawEllipse(QPointF(16, 16), 11, 11)

    return _painted(f"swatch {color}", draw)


def type_icon(color: str, symbol: str) -> QIcon:
    """A feature type's symbol in its colour, as the net and the legend show it."""

    def draw(painter: QPainter) -> None:
        painter.setBrush(QColor(color))
        painter.setPen(QPen(QColor(0, 0, 0, 140), 1.5))
        corners = _CORNERS.get(symbol)
        if corners is None:
            painter.drawEllipse(QPointF(16, 16), 11, 11)
            return
        count, start_deg, inner = corners
        radii = (13.5, 13.5 * inner) if inner else (13.5,)
        steps = count * len(radii)
        painter.drawPolygon(
            QPolygonF(
                [
                    QPointF(
                        16 + radii[k % len(radii)] * math.cos(turn),
                        16 - radii[k % len(radii)] * math.sin(turn),
                    )
                    for k in range(steps)
                    for turn in (math.radians(start_deg + 360.0 * k / steps),)
                ]
            )
        )

    return _painted(f"type {color} {symbol}", draw)


# Corners, the angle of the first, and how far in the corners between them lie.
_CORNERS: dict[str, tuple[int, float, float]] = {
    "square": (4, 45.0, 0.0),
    "triangle": (3, 90.0, 0.0),
    "diamond": (4, 90.0, 0.0),
    "pentagon": (5, 90.0, 0.0),
    "star": (5, 90.0, 0.42),
}
SYMBOLS: tuple[str, ...] = ("circle", *_CORNERS)

# Okabe-Ito (2008) and its grey: colours that colour-blind readers can tell apart.
COLORS: tuple[tuple[str, str], ...] = (
    (to_translate("Blue"), "#0072b2"),
    (to_translate("Vermilion"), "#d55e00"),
    (to_translate("Green"), "#009e73"),
    (to_translate("Purple"), "#cc79a7"),
    (to_translate("Sky blue"), "#56b4e9"),
    (to_translate("Orange"), "#e69f00"),
    (to_translate("Yellow"), "#f0e442"),
    (to_translate("Grey"), "#999999"),
)


def _painted(key: str, draw: Callable[[QPainter], None]) -> QIcon:
    """Painted once: a table asks for its icons at every repaint."""
    pixmap = QPixmap()
    if not QPixmapCache.find(f"vomstudio {key}", pixmap):
        pixmap = QPixmap(QSize(32, 32))
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw(painter)
        painter.end()
        QPixmapCache.insert(f"vomstudio {key}", pixmap)
    icon = QIcon(pixmap)
    # A selected row must not tint it: the colour is what it says.
    icon.addPixmap(pixmap, QIcon.Mode.Selected)
    return icon


def at_least_nine_points(application: QApplication) -> None:
    """Enlarge the font of the program where it is smaller than 9 points."""
    font: QFont = application.font()
    if font.pointSizeF() < 9.0:
        font.setPointSizeF(9.0)
        application.setFont(font)
