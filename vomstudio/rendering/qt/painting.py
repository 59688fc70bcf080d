"""What lies over the drawn outcrop: letters, labels, preview. Qt, but no VTK.

Everything is in logical pixels from the top left corner, so it keeps its size and stays sharp at
any scaling of the screen.
"""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtCore import QPointF, QRect, QRectF, Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QFont,
    QFontDatabase,
    QFontMetricsF,
    QImage,
    QPainter,
    QPainterPath,
    QPen,
    QPixmap,
    QPolygonF,
)

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.studio.tools.interaction_types import Outline

SMALLEST_POINT_SIZE = 9.0

# Okabe and Ito's colour-blind safe set; each verdict also has a shape and a word of its own.
VERDICT_COLORS = {"good": "#00a878", "doubtful": "#f0a500", "poor": "#e0402a"}

PANEL = QColor(18, 20, 23, 205)
TEXT = QColor(245, 245, 245)
DARK = QColor(20, 20, 22)


def system_font(factor: float = 1.0, *, bold: bool = False) -> QFont:
    """The system's font, never under 9 pt."""
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    size = font.pointSizeF() if font.pointSizeF() > 0 else SMALLEST_POINT_SIZE
    font.setPointSizeF(max(SMALLEST_POINT_SIZE, size * factor))
    font.setBold(bold)
    return font


def to_color(rgb: tuple[float, float, float], alpha: float = 1.0) -> QColor:
    r, g, b = (min(max(float(v), 0.0), 1.0) for v in rgb)
    return QColor.fromRgbF(r, g, b, alpha)


_letters: dict[tuple[str, str, float], QImage] = {}


def outlined_text(painter: QPainter, x: float, baseline: float, text: str, font: QFont) -> None:
    """White letters with a dark rim, readable on any rock.

    Kept as small images: stroking the outlines anew took 3 ms of every step of a drag.
    """
    ratio = painter.device().devicePixelRatioF()
    metrics = QFontMetricsF(font)
    rim = 2.0
    key = (text, font.key(), ratio)
    image = _letters.get(key)
    if image is None:
        if len(_letters) > 200:
            _letters.clear()
        wide = math.ceil((metrics.horizontalAdvance(text) + 2.0 * rim) * ratio)
        tall = math.ceil((metrics.height() + 2.0 * rim) * ratio)
        image = QImage(wide, tall, QImage.Format.Format_ARGB32_Premultiplied)
        image.setDevicePixelRatio(ratio)
        image.fill(Qt.GlobalColor.transparent)
        path = QPainterPath()
        path.addText(QPointF(rim, rim + metrics.ascent()), font, text)
        pen = QPen(DARK, 3.0)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        inner = QPainter(image)
        inner.setRenderHint(QPainter.RenderHint.Antialiasing)
        inner.strokePath(path, pen)
        inner.fillPath(path, TEXT)
        inner.end()
        _letters[key] = image
    # Whole device pixels keep the letters sharp.
    left = round((x - rim) * ratio) / ratio
    top = round((baseline - metrics.ascent() - rim) * ratio) / ratio
    painter.drawImage(QPointF(left, top), image)


# -- labels


class LabelCache:
    """Labels as small pictures, so that a drag with many of them stays quick."""

    def __init__(self) -> None:
        self._pictures: dict[tuple[str, int, bool, float], QPixmap] = {}
        self._sizes: dict[str, tuple[float, float]] = {}
        self._font: QFont | None = None
        self._metrics: QFontMetricsF | None = None

    def clear(self) -> None:
        self._pictures.clear()
        self._sizes.clear()
        self._font = self._metrics = None

    def _ready(self) -> QFontMetricsF:
        if self._metrics is None:
            self._font = system_font()
            self._metrics = QFontMetricsF(self._font)
        return self._metrics

    def size(self, text: str) -> tuple[float, float]:
        if text not in self._sizes:
            metrics = self._ready()
            self._sizes[text] = (
                math.ceil(metrics.horizontalAdvance(text)) + 19.0,
                math.ceil(metrics.height()) + 4.0,
            )
        return self._sizes[text]

    def picture(
        self, text: str, rgb: tuple[float, float, float], selected: bool, ratio: float
    ) -> QPixmap:
        color = to_color(rgb)
        key = (text, color.rgb(), selected, ratio)
        found = self._pictures.get(key)
        if found is not None:
            return found
        if len(self._pictures) > 4000:
            self._pictures.clear()
        metrics = self._ready()
        width, height = self.size(text)
        out = QPixmap(math.ceil(width * ratio), math.ceil(height * ratio))
        out.setDevicePixelRatio(ratio)
        out.fill(Qt.GlobalColor.transparent)
        painter = QPainter(out)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(TEXT, 1.6) if selected else Qt.PenStyle.NoPen)
        painter.setBrush(PANEL)
        painter.drawRoundedRect(QRectF(0.8, 0.8, width - 1.6, height - 1.6), 3.5, 3.5)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(color)
        painter.drawRoundedRect(QRectF(4.0, 4.0, 5.0, height - 8.0), 2.0, 2.0)
        assert self._font is not None
        painter.setFont(self._font)
        painter.setPen(TEXT)
        painter.drawText(QPointF(13.0, 2.0 + metrics.ascent()), text)
        painter.end()
        self._pictures[key] = out
        return out


# -- preview


def polyline(points: FloatArray) -> QPolygonF:
    return QPolygonF([QPointF(float(x), float(y)) for x, y in points])


def draw_runs(
    painter: QPainter, pixels: FloatArray, seen: BoolArray, color: QColor, width: float
) -> None:
    """A line through pixels (n, 2): haloed where seen, faint where hidden."""
    if len(pixels) < 2:
        return
    both = seen[:-1] & seen[1:]
    edges = np.flatnonzero(np.diff(both.astype(np.int8)))
    starts = np.concatenate([[0], edges + 1])
    ends = np.concatenate([edges + 1, [len(both)]])
    faint = QColor(color)
    faint.setAlphaF(0.45)
    shadow = QColor(DARK)
    shadow.setAlphaF(0.8)
    for halo in (True, False):
        for a, b in zip(starts, ends, strict=True):
            run = pixels[a : b + 1]
            if not np.isfinite(run).all():
                continue
            visible = bool(both[a])
            if halo and not visible:
                continue
            tint = shadow if halo else (color if visible else faint)
            pen = QPen(tint, width + 2.6 if halo else width)
            pen.setCapStyle(Qt.PenCapStyle.RoundCap)
            pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
            if not visible:
                pen.setStyle(Qt.PenStyle.DotLine)
            painter.setPen(pen)
            painter.drawPolyline(polyline(run))


def draw_rubber(painter: QPainter, pixels: FloatArray, color: QColor) -> None:
    """The dashed band from the last vertex to the cursor."""
    for tint, width in ((DARK, 3.6), (color, 1.8)):
        pen = QPen(tint, width)
        if tint is not DARK:
            pen.setStyle(Qt.PenStyle.DashLine)
        painter.setPen(pen)
        painter.drawPolyline(polyline(pixels))


def draw_ring(painter: QPainter, pixels: FloatArray, color: QColor) -> None:
    """A translucent convex ring."""
    if len(pixels) < 3 or not np.isfinite(pixels).all():
        return
    fill = QColor(color)
    fill.setAlphaF(0.28)
    painter.setBrush(fill)
    edge = QColor(color)
    edge.setAlphaF(0.9)
    painter.setPen(QPen(edge, 1.3))
    painter.drawPolygon(polyline(pixels))
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_brush(painter: QPainter, pixels: FloatArray, color: QColor, *, removes: bool) -> None:
    """The ring of a brush; dashed where it takes away."""
    if len(pixels) < 3 or not np.isfinite(pixels).all():
        return
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for tint, width in ((DARK, 3.8), (TEXT if removes else color.lighter(130), 1.8)):
        pen = QPen(tint, width)
        if removes and tint is not DARK:
            pen.setDashPattern([4.0, 3.0])
        painter.setPen(pen)
        painter.drawPolygon(polyline(pixels))


def draw_outline(painter: QPainter, outline: Outline, color: QColor) -> None:
    """A shape that is being drawn over the picture; dashed where it takes away."""
    ring = QPolygonF([QPointF(x, y) for x, y in outline.pixels])
    fill = QColor(TEXT if outline.takes_away else color)
    fill.setAlphaF(0.12)
    painter.setBrush(fill)
    for tint, width in ((DARK, 3.4), (TEXT if outline.takes_away else color.lighter(130), 1.6)):
        pen = QPen(tint, width)
        if outline.takes_away and tint is not DARK:
            pen.setDashPattern([4.0, 3.0])
        painter.setPen(pen)
        if outline.closed:
            painter.drawPolygon(ring)
        else:
            painter.drawPolyline(ring)
        painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_handle(
    painter: QPainter,
    x: float,
    y: float,
    color: QColor,
    *,
    seen: bool,
    hot: bool,
    marked: bool = False,
) -> None:
    """A vertex: larger under the cursor, with a second ring where it is the marked one."""
    radius = 6.5 if hot else 4.6
    fill = QColor(color)
    if not seen:
        fill.setAlphaF(0.35)
    painter.setPen(QPen(DARK, 3.4))
    painter.setBrush(QBrush(fill))
    painter.drawEllipse(QPointF(x, y), radius, radius)
    painter.setPen(QPen(TEXT, 1.5))
    painter.drawEllipse(QPointF(x, y), radius, radius)
    if marked:
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for pen in (QPen(DARK, 4.0), QPen(TEXT, 2.0)):
            painter.setPen(pen)
            painter.drawEllipse(QPointF(x, y), radius + 5.0, radius + 5.0)


def draw_name(painter: QPainter, x: float, y: float, text: str, room: QRect) -> None:
    """A name on a dark ground above a place, inside `room`."""
    font = system_font()
    metrics = QFontMetricsF(font)
    wide, high = metrics.horizontalAdvance(text) + 14.0, metrics.height() + 6.0
    left = min(max(x - wide / 2.0, room.left() + 4.0), room.right() - wide - 4.0)
    top = y - high - 12.0 if y - high - 12.0 > room.top() + 4.0 else y + 12.0
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setFont(font)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PANEL)
    painter.drawRoundedRect(QRectF(left, top, wide, high), 4.0, 4.0)
    painter.setPen(TEXT)
    painter.drawText(QPointF(left + 7.0, top + 3.0 + metrics.ascent()), text)


def draw_verdict_shape(painter: QPainter, box: QRectF, verdict: str) -> None:
    """Good: circle; doubtful: triangle; poor: square."""
    painter.setPen(QPen(TEXT, 1.2))
    painter.setBrush(QColor(VERDICT_COLORS.get(verdict, "#9a9a9a")))
    if verdict == "good":
        painter.drawEllipse(box)
    elif verdict == "doubtful":
        painter.drawPolygon(
            QPolygonF([QPointF(box.center().x(), box.top()), box.bottomRight(), box.bottomLeft()])
        )
    else:
        painter.drawRect(box.adjusted(0.8, 0.8, -0.8, -0.8))
