"""Painters of overlays on photos: dots, and vectors with a scale bar in pixels."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.qt.painting import PANEL, TEXT, system_font

Painter = Callable[[QPainter, QRectF, Callable[[FloatArray], FloatArray], float], None]
"""Function that draws on a pane. Its arguments are the painter, the box of the pane, the transform
to the screen and the zoom."""


def inside_mask(box: QRectF, points: FloatArray) -> BoolArray:
    """Return which points (n, 2), in widget pixels, are inside a box."""
    x, y = points[:, 0], points[:, 1]
    is_in_x, is_in_y = (
        (x >= box.left()) & (x <= box.right()),
        (y >= box.top()) & (y <= box.bottom()),
    )
    return np.asarray(is_in_x & is_in_y)


def paint_nothing(
    painter: QPainter, box: QRectF, place: Callable[[FloatArray], FloatArray], zoom: float
) -> None:
    return


def _premultiply(color: QColor) -> int:
    """Return a colour as a pixel of Format_ARGB32_Premultiplied."""
    alpha = color.alpha()
    red, green, blue = (round(v * alpha / 255) for v in (color.red(), color.green(), color.blue()))
    return alpha << 24 | red << 16 | green << 8 | blue


def dot_painter(positions: FloatArray, color: QColor, size: float) -> Painter:
    """Return a painter of dots at positions (n, 2) of a picture."""

    def paint(
        painter: QPainter, box: QRectF, to_screen: Callable[[FloatArray], FloatArray], zoom: float
    ) -> None:
        ratio = painter.device().devicePixelRatioF()
        pixels = to_screen(positions)
        pixels = (pixels[inside_mask(box, pixels)] - [box.left(), box.top()]) * ratio
        width, height = max(1, int(box.width() * ratio)), max(1, int(box.height() * ratio))
        # Written to an image, because drawing thousands of dots takes half a second.
        marks = np.zeros((height, width), np.uint32)
        radius = max(1, round(size * ratio / 2))
        columns, rows = pixels.astype(np.intp).T
        for ring, tint in ((radius + 1, QColor(0, 0, 0, 120)), (radius, color)):
            value = _premultiply(tint)
            for dx in range(-ring, ring + 1):
                for dy in range(-ring, ring + 1):
                    if dx * dx + dy * dy <= ring * ring:
                        x, y = (columns + dx).clip(0, width - 1), (rows + dy).clip(0, height - 1)
                        marks[y, x] = value
        image = QImage(
            marks.data, width, height, 4 * width, QImage.Format.Format_ARGB32_Premultiplied
        )
        image.setDevicePixelRatio(ratio)
        painter.drawImage(box.topLeft(), image)

    return paint


def combined_painter(*painters: Painter) -> Painter:
    """Return a painter that runs several painters in turn."""

    def paint(
        painter: QPainter, box: QRectF, to_screen: Callable[[FloatArray], FloatArray], zoom: float
    ) -> None:
        for item in painters:
            item(painter, box, to_screen, zoom)

    return paint


def vector_painter(
    positions: FloatArray, offsets: FloatArray, factor: float, color: QColor
) -> Painter:
    """Return a painter of vectors with a scale bar.

    The lines start at `positions` (n, 2) with a dot and run along `offsets` (n, 2) times `factor`.
    """

    def paint(
        painter: QPainter, box: QRectF, to_screen: Callable[[FloatArray], FloatArray], zoom: float
    ) -> None:
        ends = np.hstack([to_screen(positions), to_screen(positions + factor * offsets)])
        lines = [QLineF(*row) for row in ends.tolist()]
        for tint, width in ((QColor(0, 0, 0, 130), 2.8), (color, 1.4)):
            painter.setPen(QPen(tint, width))
            painter.drawLines(lines)
        dot_painter(positions, color, 2.0)(painter, box, to_screen, zoom)
        _draw_scale_bar(painter, box, factor * zoom)

    return paint


def _draw_scale_bar(painter: QPainter, box: QRectF, pixels_per_unit: float) -> None:
    """Draw a scale bar for a round number of pixels."""
    power = 10.0 ** math.floor(math.log10(110.0 / pixels_per_unit))
    bar_units = max(step * power for step in (1, 2, 5) if step * power * pixels_per_unit <= 111.0)
    font = system_font()
    metrics = QFontMetricsF(font)
    text = f"{bar_units:g} px"
    length = bar_units * pixels_per_unit
    width = max(length, 20.0) + metrics.horizontalAdvance(text) + 26.0
    background = QRectF(
        box.left() + 6, box.bottom() - metrics.height() - 16, width, metrics.height() + 10
    )
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PANEL)
    painter.drawRoundedRect(background, 4, 4)
    y = background.center().y()
    painter.setPen(QPen(TEXT, 2.0))
    painter.drawLine(QPointF(background.left() + 8, y), QPointF(background.left() + 8 + length, y))
    painter.setFont(font)
    painter.drawText(QPointF(background.left() + 16 + length, y + metrics.ascent() / 2 - 1), text)
