"""Painting of text, labels and previews over the outcrop, with Qt only.

Sizes and positions are in logical pixels from the upper-left corner, so that the overlays are
sharp at any screen scaling.
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

MIN_POINT_SIZE = 9.0

# Colour-blind safe palette by Okabe and Ito; each verdict also has a shape and a word.
VERDICT_COLORS = {"good": "#00a878", "doubtful": "#f0a500", "poor": "#e0402a"}

PANEL = QColor(18, 20, 23, 205)
TEXT = QColor(245, 245, 245)
DARK = QColor(20, 20, 22)


def system_font(factor: float = 1.0, *, bold: bool = False) -> QFont:
    """Return the system font with a size of at least 9 pt."""
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    size = font.pointSizeF() if font.pointSizeF() > 0 else MIN_POINT_SIZE
    font.setPointSizeF(max(MIN_POINT_SIZE, size * factor))
    font.setBold(bold)
    return font


def to_color(rgb: tuple[float, float, float], alpha: float = 1.0) -> QColor:
    """Convert red, green and blue values from 0 to 1 to a QColor."""
    r, g, b = (min(max(float(v), 0.0), 1.0) for v in rgb)
    return QColor.fromRgbF(r, g, b, alpha)


_text_images: dict[tuple[str, str, float], QImage] = {}


def outlined_text(painter: QPainter, x: float, baseline: float, text: str, font: QFont) -> None:
    """Draw white text with a dark outline, which is legible on any background.

    Texts are cached as small images, because stroking the outlines took 3 ms per step of a drag.
    """
    ratio = painter.device().devicePixelRatioF()
    metrics = QFontMetricsF(font)
    rim_width = 2.0
    key = (text, font.key(), ratio)
    image = _text_images.get(key)
    if image is None:
        if len(_text_images) > 200:
            _text_images.clear()
        width = math.ceil((metrics.horizontalAdvance(text) + 2.0 * rim_width) * ratio)
        height = math.ceil((metrics.height() + 2.0 * rim_width) * ratio)
        image = QImage(width, height, QImage.Format.Format_ARGB32_Premultiplied)
        image.setDevicePixelRatio(ratio)
        image.fill(Qt.GlobalColor.transparent)
        path = QPainterPath()
        path.addText(QPointF(rim_width, rim_width + metrics.ascent()), font, text)
        pen = QPen(DARK, 3.0)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        image_painter = QPainter(image)
        image_painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        image_painter.strokePath(path, pen)
        image_painter.fillPath(path, TEXT)
        image_painter.end()
        _text_images[key] = image
    # Integer device pixels keep the letters sharp.
    x_left = round((x - rim_width) * ratio) / ratio
    top = round((baseline - metrics.ascent() - rim_width) * ratio) / ratio
    painter.drawImage(QPointF(x_left, top), image)


# -- labels

_MARK_SIZE = 9.0
"""Size of the mark of a verdict in a label."""


class LabelCache:
    """Cache of labels as small pictures, so that a drag with many labels stays fast."""

    def __init__(self) -> None:
        self._pictures: dict[tuple[str, str, int, bool, float], QPixmap] = {}
        self._sizes: dict[tuple[str, bool], tuple[float, float]] = {}
        self._font: QFont | None = None
        self._metrics: QFontMetricsF | None = None

    def clear(self) -> None:
        self._pictures.clear()
        self._sizes.clear()
        self._font = self._metrics = None

    def _load_font(self) -> QFontMetricsF:
        if self._metrics is None:
            self._font = system_font()
            self._metrics = QFontMetricsF(self._font)
        return self._metrics

    def size(self, text: str, verdict: str | None = None) -> tuple[float, float]:
        key = (text, bool(verdict))
        if key not in self._sizes:
            metrics = self._load_font()
            width = math.ceil(metrics.horizontalAdvance(text)) + 19.0
            self._sizes[key] = (
                width + (_MARK_SIZE + 4.0 if verdict else 0.0),
                math.ceil(metrics.height()) + 4.0,
            )
        return self._sizes[key]

    def picture(
        self,
        text: str,
        rgb: tuple[float, float, float],
        is_selected: bool,
        ratio: float,
        verdict: str | None = None,
    ) -> QPixmap:
        """Return a label with a stripe in the colour of the feature and the mark of a verdict."""
        color = to_color(rgb)
        key = (text, verdict or "", color.rgb(), is_selected, ratio)
        pixmap = self._pictures.get(key)
        if pixmap is not None:
            return pixmap
        if len(self._pictures) > 4000:
            self._pictures.clear()
        metrics = self._load_font()
        width, height = self.size(text, verdict)
        out = QPixmap(math.ceil(width * ratio), math.ceil(height * ratio))
        out.setDevicePixelRatio(ratio)
        out.fill(Qt.GlobalColor.transparent)
        painter = QPainter(out)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(TEXT, 1.6) if is_selected else Qt.PenStyle.NoPen)
        painter.setBrush(PANEL)
        painter.drawRoundedRect(QRectF(0.8, 0.8, width - 1.6, height - 1.6), 3.5, 3.5)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(color)
        painter.drawRoundedRect(QRectF(4.0, 4.0, 5.0, height - 8.0), 2.0, 2.0)
        assert self._font is not None
        painter.setFont(self._font)
        painter.setPen(TEXT)
        painter.drawText(QPointF(13.0, 2.0 + metrics.ascent()), text)
        if verdict:
            top = (height - _MARK_SIZE) / 2.0
            box = QRectF(width - _MARK_SIZE - 5.0, top, _MARK_SIZE, _MARK_SIZE)
            draw_verdict_shape(painter, box, verdict)
        painter.end()
        self._pictures[key] = out
        return out


# -- preview


def polyline(points: FloatArray) -> QPolygonF:
    """Convert points (n, 2) to a Qt polygon."""
    return QPolygonF([QPointF(float(x), float(y)) for x, y in points])


def draw_runs(
    painter: QPainter, pixels: FloatArray, is_visible: BoolArray, color: QColor, width: float
) -> None:
    """Draw a line through pixels (n, 2), with a halo if visible, and faint if hidden."""
    if len(pixels) < 2:
        return
    is_visible_segment = is_visible[:-1] & is_visible[1:]
    edges = np.flatnonzero(np.diff(is_visible_segment.astype(np.int8)))
    starts = np.concatenate([[0], edges + 1])
    ends = np.concatenate([edges + 1, [len(is_visible_segment)]])
    faint_color = QColor(color)
    faint_color.setAlphaF(0.45)
    shadow_color = QColor(DARK)
    shadow_color.setAlphaF(0.8)
    for is_halo in (True, False):
        for a, b in zip(starts, ends, strict=True):
            run = pixels[a : b + 1]
            if not np.isfinite(run).all():
                continue
            visible = bool(is_visible_segment[a])
            if is_halo and not visible:
                continue
            tint = shadow_color if is_halo else (color if visible else faint_color)
            pen = QPen(tint, width + 2.6 if is_halo else width)
            pen.setCapStyle(Qt.PenCapStyle.RoundCap)
            pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
            if not visible:
                pen.setStyle(Qt.PenStyle.DotLine)
            painter.setPen(pen)
            painter.drawPolyline(polyline(run))


def draw_rubber_band(painter: QPainter, pixels: FloatArray, color: QColor) -> None:
    """Draw a dashed line through pixels (n, 2), such as the rubber band to the cursor."""
    for tint, width in ((DARK, 3.6), (color, 1.8)):
        pen = QPen(tint, width)
        if tint is not DARK:
            pen.setStyle(Qt.PenStyle.DashLine)
        painter.setPen(pen)
        painter.drawPolyline(polyline(pixels))


def draw_ring(painter: QPainter, pixels: FloatArray, color: QColor) -> None:
    """Draw a translucent convex ring."""
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


def draw_brush(painter: QPainter, pixels: FloatArray, color: QColor, *, is_removing: bool) -> None:
    """Draw the ring of a brush, dashed if it erases."""
    if len(pixels) < 3 or not np.isfinite(pixels).all():
        return
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for tint, width in ((DARK, 3.8), (TEXT if is_removing else color.lighter(130), 1.8)):
        pen = QPen(tint, width)
        if is_removing and tint is not DARK:
            pen.setDashPattern([4.0, 3.0])
        painter.setPen(pen)
        painter.drawPolygon(polyline(pixels))


def draw_outline(painter: QPainter, outline: Outline, color: QColor) -> None:
    """Draw an unfinished shape, dashed if it removes elements."""
    ring = QPolygonF([QPointF(x, y) for x, y in outline.pixels])
    fill = QColor(TEXT if outline.is_subtracting else color)
    fill.setAlphaF(0.12)
    painter.setBrush(fill)
    for tint, width in ((DARK, 3.4), (TEXT if outline.is_subtracting else color.lighter(130), 1.6)):
        pen = QPen(tint, width)
        if outline.is_subtracting and tint is not DARK:
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
    is_visible: bool,
    is_hovered: bool,
    is_marked: bool = False,
) -> None:
    """Draw a vertex, which is larger under the cursor and has a second ring if marked."""
    radius = 6.5 if is_hovered else 4.6
    fill = QColor(color)
    if not is_visible:
        fill.setAlphaF(0.35)
    painter.setPen(QPen(DARK, 3.4))
    painter.setBrush(QBrush(fill))
    painter.drawEllipse(QPointF(x, y), radius, radius)
    painter.setPen(QPen(TEXT, 1.5))
    painter.drawEllipse(QPointF(x, y), radius, radius)
    if is_marked:
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for pen in (QPen(DARK, 4.0), QPen(TEXT, 2.0)):
            painter.setPen(pen)
            painter.drawEllipse(QPointF(x, y), radius + 5.0, radius + 5.0)


def draw_pending_click(painter: QPainter, x: float, y: float, color: QColor) -> None:
    """Mark a click that has not taken effect yet by a dashed ring with a dot.

    Parameters
    ----------
    painter : QPainter
    x, y : float
        Logical pixels.
    color : QColor
    """
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for tint, width in ((DARK, 3.8), (TEXT, 1.8)):
        pen = QPen(tint, width)
        if tint is not DARK:
            pen.setDashPattern([2.0, 1.5])
        painter.setPen(pen)
        painter.drawEllipse(QPointF(x, y), 8.0, 8.0)
    painter.setPen(QPen(DARK, 1.2))
    painter.setBrush(QBrush(color))
    painter.drawEllipse(QPointF(x, y), 3.0, 3.0)


def draw_name(painter: QPainter, x: float, y: float, text: str, available_rect: QRect) -> None:
    """Draw a name on a dark background above or below a position, inside `available_rect`."""
    font = system_font()
    metrics = QFontMetricsF(font)
    width, high = metrics.horizontalAdvance(text) + 14.0, metrics.height() + 6.0
    x_left = min(
        max(x - width / 2.0, available_rect.left() + 4.0), available_rect.right() - width - 4.0
    )
    top = y - high - 12.0 if y - high - 12.0 > available_rect.top() + 4.0 else y + 12.0
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setFont(font)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PANEL)
    painter.drawRoundedRect(QRectF(x_left, top, width, high), 4.0, 4.0)
    painter.setPen(TEXT)
    painter.drawText(QPointF(x_left + 7.0, top + 3.0 + metrics.ascent()), text)


def draw_verdict_shape(painter: QPainter, box: QRectF, verdict: str) -> None:
    """Draw the shape of a verdict: circle for good, triangle for doubtful, square for poor."""
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
