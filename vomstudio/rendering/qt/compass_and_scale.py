"""Compass and scale bar over the outcrop, in logical pixels from the top left corner."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.rendering.qt import painting

MARGIN = 16.0


def compass_box(height: float) -> QRectF:
    """Return the rectangle of the compass."""
    return QRectF(MARGIN - 4.0, height - MARGIN - 92.0, 96.0, 96.0)


def draw_compass(painter: QPainter, frame: FloatArray, height: float, is_north_known: bool) -> None:
    """Draw a horizontal ring with a needle pointing North, as seen by the camera.

    The rows of `frame` are the right, up and view directions of the camera in the World frame.
    """
    box = compass_box(height)
    centre = box.center()
    radius = 31.0
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(18, 20, 23, 95))
    painter.drawEllipse(centre, 46.0, 46.0)

    def to_pixel(vector: Sequence[float] | FloatArray, max_distance: float = radius) -> QPointF:
        x, y = (frame[:2] @ np.asarray(vector, float)) * max_distance
        return QPointF(centre.x() + float(x), centre.y() - float(y))

    angles = np.linspace(0.0, 2.0 * np.pi, 49)
    ring = QPolygonF([to_pixel((math.sin(a), math.cos(a), 0.0)) for a in angles])
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(painting.DARK, 3.2))
    painter.drawPolyline(ring)
    painter.setPen(QPen(QColor(225, 225, 225), 1.4))
    painter.drawPolyline(ring)
    needle = np.array([0.0, 1.0, 0.0])
    half_width = np.array([1.0, 0.0, 0.0]) * 0.3
    north = QPolygonF([to_pixel(needle), to_pixel(half_width), to_pixel(-half_width)])
    south_needle = QPolygonF([to_pixel(-needle), to_pixel(half_width), to_pixel(-half_width)])
    painter.setPen(QPen(painting.DARK, 1.2))
    painter.setBrush(QColor(235, 235, 235))
    painter.drawPolygon(south_needle)
    painter.setBrush(QColor("#e0402a") if is_north_known else QColor("#f0a500"))
    painter.drawPolygon(north)
    bold, plain_font = painting.system_font(bold=True), painting.system_font()
    letters = (tr("N"), tr("E"), tr("S"), tr("W")) if is_north_known else ("y", "x", "", "")
    occupied_points: list[QPointF] = []
    for k, letter in enumerate(letters):
        if not letter:
            continue
        azimuth_rad = math.radians(90.0 * k)
        position = to_pixel((math.sin(azimuth_rad), math.cos(azimuth_rad), 0.0), radius + 9.0)
        # In a horizontal view the letters meet at the needle, and only the first one is drawn.
        if any(
            math.hypot(position.x() - q.x(), position.y() - q.y()) < 13.0 for q in occupied_points
        ):
            continue
        occupied_points.append(position)
        font = bold if k == 0 else plain_font
        metrics = QFontMetricsF(font)
        painting.outlined_text(
            painter,
            position.x() - metrics.horizontalAdvance(letter) / 2.0,
            position.y() + metrics.capHeight() / 2.0,
            letter,
            font,
        )
    if not is_north_known:
        small_font = painting.system_font()
        text = tr("local frame")
        width = QFontMetricsF(small_font).horizontalAdvance(text)
        painting.outlined_text(
            painter, max(box.left(), centre.x() - width / 2.0), box.top() - 4.0, text, small_font
        )
    painter.restore()


def scale_bar(metres_per_pixel: float, width: float) -> tuple[float, float]:
    """Return a round length in metres and its pixels.

    The maximum is a sixth of the view's width, but at least 60 and at most 220 pixels.
    """
    max_length = max(60.0, min(220.0, width / 6.0)) * metres_per_pixel
    length = round_length(max(max_length, 1e-6))
    return length, length / metres_per_pixel


def scale_bar_box(width: float, height: float) -> QRectF:
    """Return the rectangle of the scale bar."""
    return QRectF(width - MARGIN - 240.0, height - MARGIN - 52.0, 240.0, 56.0)


def draw_scale_bar(
    painter: QPainter,
    metres_per_pixel: float,
    width: float,
    height: float,
    *,
    note: str = "",
    is_unit_known: bool = True,
) -> None:
    """Draw a scale bar with a round length, and a note above it."""
    length, pixels = scale_bar(metres_per_pixel, width)
    right = width - MARGIN
    left = right - pixels
    y = height - MARGIN - 4.0
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    bar = QPainterPath()
    bar.moveTo(left, y - 6.0)
    bar.lineTo(left, y)
    bar.lineTo(right, y)
    bar.lineTo(right, y - 6.0)
    for color, line_width in ((painting.DARK, 5.0), (painting.TEXT, 2.2)):
        pen = QPen(color, line_width)
        pen.setCapStyle(Qt.PenCapStyle.FlatCap if line_width < 3 else Qt.PenCapStyle.SquareCap)
        pen.setJoinStyle(Qt.PenJoinStyle.MiterJoin)
        painter.setPen(pen)
        painter.drawPath(bar)
    text = scale_bar_text(length, is_metric=is_unit_known)
    font = painting.system_font(bold=True)
    painting.outlined_text(
        painter,
        (left + right - QFontMetricsF(font).horizontalAdvance(text)) / 2.0,
        y - 9.0,
        text,
        font,
    )
    if note:
        small_font = painting.system_font()
        painting.outlined_text(
            painter,
            right - QFontMetricsF(small_font).horizontalAdvance(note),
            y - 11.0 - QFontMetricsF(font).height(),
            note,
            small_font,
        )
    painter.restore()
