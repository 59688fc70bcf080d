"""Painting of colour bars and the clipping box over the outcrop, with Qt only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.rendering.qt.compass_and_scale import MARGIN, scale_bar_box
from vomstudio.rendering.qt.painting import DARK, PANEL, TEXT, system_font
from vomstudio.rendering.view.clipping import BOX_EDGES, BOX_FACES
from vomstudio.rendering.view.scalars import MISSING_COLOR, Scale

BAR_WIDTH = 16.0
MAX_BAR_HEIGHT = 300.0
TOP = 42.0
"""Top of the colour bars, below the message bar."""
PAD = 9.0
MAX_TITLE_WIDTH = 190.0
MAX_ROWS = 40
"""Maximum number of classes that are listed."""
MISSING_TEXT = to_translate("no value")

BOX_COLOR = QColor("#f0e442")
HANDLE_RADIUS = 12.5


class ColorBar:
    """Colour bar whose upper-right corner is at (right, top) and which ends above `bottom`.

    `captions` contains the title and further lines, such as the model's name.
    """

    def __init__(
        self, scale: Scale, captions: Sequence[str], right: float, top: float, bottom: float
    ) -> None:
        self.scale = scale
        self._bold_font, self._font = system_font(bold=True), system_font()
        bold, plain_metrics = QFontMetricsF(self._bold_font), QFontMetricsF(self._font)
        self._line = plain_metrics.height()
        title = captions[0] + (f" [{scale.unit}]" if scale.unit else "")
        elide_mode = Qt.TextElideMode.ElideRight
        self._captions = [bold.elidedText(title, elide_mode, MAX_TITLE_WIDTH)]
        self._captions += [
            plain_metrics.elidedText(t, elide_mode, MAX_TITLE_WIDTH) for t in captions[1:] if t
        ]
        self._header_height = bold.height() + self._line * (len(self._captions) - 1) + 5.0
        self._footer_height = self._line + 5.0 if scale.missing else 0.0
        row_widths = [bold.horizontalAdvance(self._captions[0])]
        row_widths += [plain_metrics.horizontalAdvance(t) for t in self._captions[1:]]
        available_space = max(bottom - top, 40.0)
        self._omitted_count = 0
        if scale.kind == "categories":
            row = self._line + 3.0
            max_rows = max(
                1,
                int(
                    (available_space - self._header_height - self._footer_height - 2.0 * PAD) / row
                ),
            )
            self._rows = list(scale.categories)
            if len(self._rows) > MAX_ROWS:
                # Borders distinguish categories with similar colours.
                self._omitted_count, self._rows = len(self._rows), []
            elif len(self._rows) > max_rows:
                self._omitted_count = len(self._rows) - (max_rows - 1)
                self._rows = self._rows[: max_rows - 1]
            labels = [c.name for c in self._rows] + self._omitted_text()
            inner_height = row * len(labels)
        else:
            inner_height = (
                min(MAX_BAR_HEIGHT, available_space)
                - self._header_height
                - self._footer_height
                - 2.0 * PAD
            )
            labels = [text for _, text in self._ticks(inner_height)]
        text_width = max([plain_metrics.horizontalAdvance(w) for w in labels], default=0.0)
        row_widths.append(BAR_WIDTH + 8.0 + text_width)
        if scale.missing:
            row_widths.append(BAR_WIDTH + 8.0 + plain_metrics.horizontalAdvance(tr(MISSING_TEXT)))
        width = max(row_widths) + 2.0 * PAD
        height = self._header_height + inner_height + self._footer_height + 2.0 * PAD
        self._inner_height = inner_height
        self.box = QRectF(right - width, top, width, height)

    def _omitted_text(self) -> list[str]:
        if self._omitted_count and not self._rows:
            return [tr_n("{count} class", "{count} classes", self._omitted_count)]
        return (
            [tr_n("and {count} more", "and {count} more", self._omitted_count)]
            if self._omitted_count
            else []
        )

    def _ticks(self, height: float) -> list[tuple[float, str]]:
        """Return the position (0 to 1 from the bottom) and the text of each tick.

        The ticks are both ends of the scale, and round values whose texts do not overlap.
        """
        scale, width = self.scale, self.scale.high - self.scale.low
        if width <= 0.0:
            return []
        if scale.kind == "cyclic":
            return [((v - scale.low) / width, text) for v, text in scale.ticks()]
        low, high = scale.end_texts()
        ends = [
            (0.0, ("≤ " if scale.has_lower_values else "") + low),
            (1.0, ("≥ " if scale.has_higher_values else "") + high),
        ]
        clearance = 1.25 * self._line / max(height, 1.0)
        max_ticks = max(1, int(1.0 / max(1.6 * clearance, 0.14)))
        minor_ticks = [
            ((v - scale.low) / width, text)
            for v, text in scale.ticks(max_ticks)
            if clearance <= (v - scale.low) / width <= 1.0 - clearance
        ]
        return [ends[0], *minor_ticks, ends[1]]

    def paint(self, painter: QPainter) -> None:
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(PANEL)
        painter.drawRoundedRect(self.box, 5.0, 5.0)
        left, y = self.box.left() + PAD, self.box.top() + PAD
        painter.setPen(TEXT)
        for k, text in enumerate(self._captions):
            font = self._font if k else self._bold_font
            metrics = QFontMetricsF(font)
            painter.setFont(font)
            painter.drawText(QPointF(left, y + metrics.ascent()), text)
            y += metrics.height()
        top = self.box.top() + PAD + self._header_height
        painter.setFont(self._font)
        if self.scale.kind == "categories":
            self._paint_categories(painter, left, top)
        else:
            self._paint_ramp(painter, left, top)
        if self.scale.missing:
            self._swatch(
                painter, left, top + self._inner_height + 5.0, MISSING_COLOR, tr(MISSING_TEXT)
            )
        painter.restore()

    def _swatch(
        self, painter: QPainter, left: float, y: float, rgb: Iterable[int], text: str
    ) -> None:
        metrics = QFontMetricsF(self._font)
        painter.setPen(QPen(TEXT, 0.6))
        painter.setBrush(QColor(*rgb))
        side = metrics.ascent()
        painter.drawRect(QRectF(left + 1.0, y + 1.0, BAR_WIDTH - 2.0, side - 1.0))
        painter.setPen(TEXT)
        painter.drawText(QPointF(left + BAR_WIDTH + 8.0, y + metrics.ascent()), text)

    def _paint_categories(self, painter: QPainter, left: float, top: float) -> None:
        row = self._line + 3.0
        for k, category in enumerate(self._rows):
            self._swatch(painter, left, top + k * row, category.rgb, category.name)
        for text in self._omitted_text():
            y = top + len(self._rows) * row + QFontMetricsF(self._font).ascent()
            painter.drawText(QPointF(left, y), text)

    def _paint_ramp(self, painter: QPainter, left: float, top: float) -> None:
        table = np.ascontiguousarray(self.scale.table[::-1])
        strip = QImage(table.data, 1, len(table), 3, QImage.Format.Format_RGB888)
        metrics = QFontMetricsF(self._font)
        # Adds half a line above and below, because the texts of the ends extend beyond the bar.
        half_height = metrics.capHeight() / 2.0 + 1.0
        ramp = QRectF(left, top + half_height, BAR_WIDTH, self._inner_height - 2.0 * half_height)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
        painter.drawImage(ramp, strip)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(TEXT, 0.8))
        painter.drawRect(ramp)
        for ratio, text in self._ticks(self._inner_height):
            y = ramp.bottom() - ratio * ramp.height()
            painter.setPen(QPen(TEXT, 1.0))
            painter.drawLine(QPointF(ramp.right(), y), QPointF(ramp.right() + 4.0, y))
            position = QPointF(ramp.right() + 8.0, y + metrics.capHeight() / 2.0)
            painter.drawText(position, text)


def lay_out_bars(
    shown_pairs: Sequence[tuple[Scale, Sequence[str]]],
    width: float,
    height: float,
    covered_rect: QRectF | None = None,
) -> list[ColorBar]:
    """Lay out colour bars from right to left above the scale bar.

    Bars that do not fit are omitted. A bar that would intersect `covered_rect`, which another
    widget covers, is placed to its left.
    """
    bars: list[ColorBar] = []
    right, bottom = width - MARGIN, scale_bar_box(width, height).top() - 10.0
    for scale, captions in shown_pairs:
        bar = ColorBar(scale, captions, right, TOP, bottom)
        if covered_rect is not None and bar.box.intersects(covered_rect):
            bar = ColorBar(scale, captions, covered_rect.left() - 8.0, TOP, bottom)
        if bar.box.left() < MARGIN or (bars and bar.box.left() < width / 2.0):
            break
        bars.append(bar)
        right = bar.box.left() - 8.0
    return bars


# -- clipping box


def draw_clip_box(
    painter: QPainter,
    corners: FloatArray,
    centres: FloatArray,
    usable_flags: Sequence[bool],
    hovered: int | None,
    letters: Sequence[str],
) -> None:
    """Draw the edges and handles of a clipping box.

    Parameters
    ----------
    painter : QPainter
    corners : (8, 2) float64
        Pixels of `ClipBox.corners`; NaN for corners behind the viewer.
    centres : (6, 2) float64
        Pixels of the handles, in the order of `BOX_FACES`.
    usable_flags : sequence of bool
        Whether each handle can be dragged.
    hovered : int or None
        Handle under the cursor.
    letters : sequence of str
        Names of the three axes.
    """
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for tint, width in ((QColor(20, 20, 22, 150), 3.0), (BOX_COLOR, 1.2)):
        painter.setPen(QPen(tint, width))
        for a, b in BOX_EDGES:
            if np.isfinite(corners[[a, b]]).all():
                painter.drawLine(QPointF(*corners[a]), QPointF(*corners[b]))
    font = system_font(bold=True)
    metrics = QFontMetricsF(font)
    painter.setFont(font)
    for k, (axis, side) in enumerate(BOX_FACES):
        if not np.isfinite(centres[k]).all():
            continue
        x, y = centres[k]
        radius = HANDLE_RADIUS + (1.5 if k == hovered else 0.0)
        fill = QColor(BOX_COLOR if k == hovered else "#ffffff")
        fill.setAlphaF(0.95 if usable_flags[k] else 0.35)
        painter.setPen(QPen(DARK, 1.6))
        painter.setBrush(fill)
        painter.drawEllipse(QPointF(x, y), radius, radius)
        letter = letters[axis] + ("+" if side else "−")
        painter.setPen(DARK)
        painter.drawText(
            QPointF(x - metrics.horizontalAdvance(letter) / 2.0, y + metrics.capHeight() / 2.0),
            letter,
        )
    painter.setBrush(Qt.BrushStyle.NoBrush)
