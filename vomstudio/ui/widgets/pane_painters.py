"""What is drawn over the panes of photos: dots, and vectors with the length of a pixel beside."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.qt.painting import PANEL, TEXT, system_font

Painter = Callable[[QPainter, QRectF, Callable[[FloatArray], FloatArray], float], None]
"""Draws over a pane: painter, the pane, its pixels to screen, screen pixels for one of them."""


def mask_inside(box: QRectF, at: FloatArray) -> BoolArray:
    """Which points (n, 2) of the screen lie in a box."""
    x, y = at[:, 0], at[:, 1]
    across, down = (x >= box.left()) & (x <= box.right()), (y >= box.top()) & (y <= box.bottom())
    return np.asarray(across & down)


def paint_nothing(
    painter: QPainter, box: QRectF, place: Callable[[FloatArray], FloatArray], zoom: float
) -> None:
    return


def _premultiplied(color: QColor) -> int:
    """As a pixel of Format_ARGB32_Premultiplied."""
    alpha = color.alpha()
    red, green, blue = (round(v * alpha / 255) for v in (color.red(), color.green(), color.blue()))
    return alpha << 24 | red << 16 | green << 8 | blue


def dot_painter(places: FloatArray, color: QColor, size: float) -> Painter:
    """Marks at places (n, 2) of a picture."""

    def paint(
        painter: QPainter, box: QRectF, on_screen: Callable[[FloatArray], FloatArray], zoom: float
    ) -> None:
        ratio = painter.device().devicePixelRatioF()
        at = on_screen(places)
        at = (at[mask_inside(box, at)] - [box.left(), box.top()]) * ratio
        wide, high = max(1, int(box.width() * ratio)), max(1, int(box.height() * ratio))
        # Thousands of marks: written into a picture, since drawing them takes half a second.
        marks = np.zeros((high, wide), np.uint32)
        reach = max(1, round(size * ratio / 2))
        columns, rows = at.astype(np.intp).T
        for ring, tint in ((reach + 1, QColor(0, 0, 0, 120)), (reach, color)):
            value = _premultiplied(tint)
            for dx in range(-ring, ring + 1):
                for dy in range(-ring, ring + 1):
                    if dx * dx + dy * dy <= ring * ring:
                        x, y = (columns + dx).clip(0, wide - 1), (rows + dy).clip(0, high - 1)
                        marks[y, x] = value
        shown = QImage(marks.data, wide, high, 4 * wide, QImage.Format.Format_ARGB32_Premultiplied)
        shown.setDevicePixelRatio(ratio)
        painter.drawImage(box.topLeft(), shown)

    return paint


def combined_painter(*painters: Painter) -> Painter:
    """One after the other."""

    def paint(
        painter: QPainter, box: QRectF, on_screen: Callable[[FloatArray], FloatArray], zoom: float
    ) -> None:
        for each in painters:
            each(painter, box, on_screen, zoom)

    return paint


def vector_painter(
    places: FloatArray, offsets: FloatArray, factor: float, color: QColor
) -> Painter:
    """Lines from places (n, 2) along `offsets` (n, 2) times `factor`, each with a dot at its begin,
    and the length of a pixel at the bottom left."""

    def paint(
        painter: QPainter, box: QRectF, on_screen: Callable[[FloatArray], FloatArray], zoom: float
    ) -> None:
        ends = np.hstack([on_screen(places), on_screen(places + factor * offsets)])
        lines = [QLineF(*row) for row in ends.tolist()]
        for tint, wide in ((QColor(0, 0, 0, 130), 2.8), (color, 1.4)):
            painter.setPen(QPen(tint, wide))
            painter.drawLines(lines)
        dot_painter(places, color, 2.0)(painter, box, on_screen, zoom)
        _key(painter, box, factor * zoom)

    return paint


def _key(painter: QPainter, box: QRectF, per_pixel: float) -> None:
    """The length at which an error of a round number of pixels is drawn."""
    power = 10.0 ** math.floor(math.log10(110.0 / per_pixel))
    error = max(step * power for step in (1, 2, 5) if step * power * per_pixel <= 111.0)
    font = system_font()
    metrics = QFontMetricsF(font)
    text = f"{error:g} px"
    long = error * per_pixel
    wide = max(long, 20.0) + metrics.horizontalAdvance(text) + 26.0
    ground = QRectF(
        box.left() + 6, box.bottom() - metrics.height() - 16, wide, metrics.height() + 10
    )
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PANEL)
    painter.drawRoundedRect(ground, 4, 4)
    y = ground.center().y()
    painter.setPen(QPen(TEXT, 2.0))
    painter.drawLine(QPointF(ground.left() + 8, y), QPointF(ground.left() + 8 + long, y))
    painter.setFont(font)
    painter.drawText(QPointF(ground.left() + 16 + long, y + metrics.ascent() / 2 - 1), text)
