"""Map of the control points, their residuals and the weakest rotation axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.number_formatting import format_error_deg, length

if TYPE_CHECKING:
    from vomstudio.registration.results import ModelPlacement

_MARGIN_PX = 26.0
_MAX_ARROW_PX = 34.0
_DOT_RADIUS_PX = 4.5
_RESIDUAL_COLOR, _AXIS_COLOR = "#d55e00", "#0072b2"


@dataclass(frozen=True)
class MapPoint:
    """Control point on the map.

    Attributes
    ----------
    x, y : float
        Coordinates in the World frame, in metres.
    is_used : bool
        Whether the point is used to place the model; otherwise it is a check point.
    is_on_model : bool
        Whether the point has been clicked on the model.
    residual : tuple of float or None
        Residual (dx, dy) in metres, fitted minus given, or None if unknown.
    """

    label: str
    x: float
    y: float
    is_used: bool
    is_on_model: bool
    residual: tuple[float, float] | None


class ControlMap(QWidget):
    """Map with north up, on which residuals are drawn as exaggerated arrows."""

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumHeight(170)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        self._points: Sequence[MapPoint] = ()
        self._placement: ModelPlacement | None = None
        self.setAccessibleName(tr("Map of the control points"))

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(220, 190)

    def show_points(self, points: Sequence[MapPoint], placement: ModelPlacement | None) -> None:
        self._points, self._placement = points, placement
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Base))
        if not self._points:
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            painter.drawText(
                QRectF(self.rect()),
                int(Qt.AlignmentFlag.AlignCenter) | int(Qt.TextFlag.TextWordWrap),
                tr("Points with coordinates are shown here from above."),
            )
            return
        caption_height = 2.0 * painter.fontMetrics().height()
        plot_area = QRectF(self.rect()).adjusted(
            _MARGIN_PX, _MARGIN_PX, -_MARGIN_PX, -_MARGIN_PX - caption_height
        )
        positions = np.array([(p.x, p.y) for p in self._points])
        low, high = positions.min(axis=0), positions.max(axis=0)
        span = np.maximum(high - low, 1e-9)
        scale = min(max(plot_area.width(), 1.0) / span[0], max(plot_area.height(), 1.0) / span[1])
        if not np.isfinite(scale) or span.max() <= 1e-9:
            scale = 1.0
        center = 0.5 * (low + high)

        def to_widget(x: float, y: float) -> QPointF:
            return QPointF(
                plot_area.center().x() + scale * (x - center[0]),
                plot_area.center().y() - scale * (y - center[1]),
            )

        captions = self._paint_axis(painter, plot_area)
        captions += self._paint_points(painter, to_widget, scale)
        self._paint_north(painter)
        painter.setPen(self.palette().color(QPalette.ColorRole.WindowText))
        captions.append(tr("width {metres}", metres=length(float(high[0] - low[0]))))
        painter.drawText(
            QRectF(
                8.0, self.height() - caption_height - 4.0, self.width() - 16.0, caption_height + 2.0
            ),
            int(Qt.AlignmentFlag.AlignLeft)
            | int(Qt.AlignmentFlag.AlignBottom)
            | int(Qt.TextFlag.TextWordWrap),
            "; ".join(captions),
        )

    def _paint_axis(self, painter: QPainter, plot_area: QRectF) -> list[str]:
        axis = None if self._placement is None else self._placement.rotation_error_95_deg.weakest
        if axis is None or axis.error_deg is None:
            return []
        angle = np.radians(axis.trend_deg)
        direction = np.array([np.sin(angle), -np.cos(angle)]) * np.cos(np.radians(axis.plunge_deg))
        half_length = 0.5 * np.hypot(plot_area.width(), plot_area.height())
        step = QPointF(*(direction * half_length))
        painter.save()
        painter.setClipRect(plot_area.adjusted(-14, -14, 14, 14))
        painter.setPen(QPen(QColor(_AXIS_COLOR), 1.6, Qt.PenStyle.DashLine))
        painter.drawLine(plot_area.center() - step, plot_area.center() + step)
        painter.restore()
        return [
            tr(
                "Dashed: weakest axis, {error} (95 %)",
                error=format_error_deg(axis.error_deg),
            )
        ]

    def _paint_points(
        self, painter: QPainter, to_widget: Callable[[float, float], QPointF], scale: float
    ) -> list[str]:
        max_residual = max(
            (float(np.hypot(*p.residual)) for p in self._points if p.residual), default=0.0
        )
        factor = _MAX_ARROW_PX / (scale * max_residual) if max_residual * scale > 0.0 else 0.0
        text_color = self.palette().color(QPalette.ColorRole.WindowText)
        muted_color = self.palette().color(QPalette.ColorRole.PlaceholderText)
        line_height = painter.fontMetrics().height()
        occupied_cells: set[tuple[int, int]] = set()
        for point in self._points:
            position = to_widget(point.x, point.y)
            if point.residual is not None and factor:
                tooltip = to_widget(
                    point.x + factor * point.residual[0], point.y + factor * point.residual[1]
                )
                painter.setPen(QPen(QColor(_RESIDUAL_COLOR), 1.8))
                painter.drawLine(position, tooltip)
            painter.setPen(QPen(text_color if point.is_on_model else muted_color, 1.4))
            painter.setBrush(
                text_color if point.is_used and point.is_on_model else Qt.BrushStyle.NoBrush
            )
            painter.drawEllipse(position, _DOT_RADIUS_PX, _DOT_RADIUS_PX)
            label_width = painter.fontMetrics().horizontalAdvance(point.label)
            fits_right = position.x() + _DOT_RADIUS_PX + 3.0 + label_width < self.width() - 2.0
            label_dx = _DOT_RADIUS_PX + 3.0 if fits_right else -_DOT_RADIUS_PX - 3.0 - label_width
            # A label that would overlap another one is omitted.
            line = int(position.y() // line_height)
            first, last_point = (
                int((position.x() + label_dx) // line_height),
                int((position.x() + label_dx + label_width) // line_height),
            )
            label_cells = {(column, line) for column in range(first, last_point + 1)}
            if not label_cells & occupied_cells:
                occupied_cells |= label_cells
                painter.drawText(position + QPointF(label_dx, -_DOT_RADIUS_PX), point.label)
        if not factor:
            return []
        return [tr("residuals enlarged {times} times", times=_format_factor(factor))]

    def _paint_north(self, painter: QPainter) -> None:
        painter.setPen(QPen(self.palette().color(QPalette.ColorRole.WindowText), 1.4))
        top = QPointF(self.width() - 14.0, 18.0)
        painter.drawLine(top, top + QPointF(0.0, 16.0))
        painter.drawLine(top, top + QPointF(-3.0, 5.0))
        painter.drawLine(top, top + QPointF(3.0, 5.0))
        painter.drawText(QRectF(top.x() - 8.0, 2.0, 16.0, 14.0), Qt.AlignmentFlag.AlignCenter, "N")


def _format_factor(factor: float) -> str:
    """Format a factor with two significant digits."""
    step = 10.0 ** (np.floor(np.log10(factor)) - 1.0)
    return f"{np.round(factor / step) * step:,.0f}" if factor >= 10.0 else f"{factor:.1f}"
