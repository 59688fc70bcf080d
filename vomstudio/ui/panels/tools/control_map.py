"""The control points from above: where they lie, what is left over at each, and the axis about
which they hold the model worst."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.number_formatting import degrees, length

if TYPE_CHECKING:
    from vomstudio.registration.results import Placed

_MARGIN = 26.0
_LONGEST_ARROW = 34.0
_DOT = 4.5
_RESIDUAL, _AXIS = "#d55e00", "#0072b2"


@dataclass(frozen=True)
class MapPoint:
    """x, y : World, metres. used : it places the model; found : it is on the model already; off :
    (dx, dy) fitted less given, None where not known"""

    label: str
    x: float
    y: float
    used: bool
    found: bool
    off: tuple[float, float] | None


class ControlMap(QWidget):
    """North is up. Arrows are drawn longer than they are, by what the text below says."""

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumHeight(170)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        self._points: Sequence[MapPoint] = ()
        self._placed: Placed | None = None
        self.setAccessibleName(tr("Map of the control points"))

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(220, 190)

    def show_points(self, points: Sequence[MapPoint], placed: Placed | None) -> None:
        self._points, self._placed = points, placed
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
        below = 2.0 * painter.fontMetrics().height()
        room = QRectF(self.rect()).adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN - below)
        places = np.array([(p.x, p.y) for p in self._points])
        low, high = places.min(axis=0), places.max(axis=0)
        span = np.maximum(high - low, 1e-9)
        scale = min(max(room.width(), 1.0) / span[0], max(room.height(), 1.0) / span[1])
        if not np.isfinite(scale) or span.max() <= 1e-9:
            scale = 1.0
        middle = 0.5 * (low + high)

        def at(x: float, y: float) -> QPointF:
            return QPointF(
                room.center().x() + scale * (x - middle[0]),
                room.center().y() - scale * (y - middle[1]),
            )

        said = self._paint_axis(painter, room)
        said += self._paint_points(painter, at, scale)
        self._paint_north(painter)
        painter.setPen(self.palette().color(QPalette.ColorRole.WindowText))
        said.append(tr("width {metres}", metres=length(float(high[0] - low[0]))))
        painter.drawText(
            QRectF(8.0, self.height() - below - 4.0, self.width() - 16.0, below + 2.0),
            int(Qt.AlignmentFlag.AlignLeft)
            | int(Qt.AlignmentFlag.AlignBottom)
            | int(Qt.TextFlag.TextWordWrap),
            "; ".join(said),
        )

    def _paint_axis(self, painter: QPainter, room: QRectF) -> list[str]:
        worst = None if self._placed is None else self._placed.rotation_error_95_deg.weakest
        if worst is None or worst.error_deg is None:
            return []
        angle = np.radians(worst.trend_deg)
        along = np.array([np.sin(angle), -np.cos(angle)]) * np.cos(np.radians(worst.plunge_deg))
        reach = 0.5 * np.hypot(room.width(), room.height())
        step = QPointF(*(along * reach))
        painter.save()
        painter.setClipRect(room.adjusted(-14, -14, 14, 14))
        painter.setPen(QPen(QColor(_AXIS), 1.6, Qt.PenStyle.DashLine))
        painter.drawLine(room.center() - step, room.center() + step)
        painter.restore()
        return [
            tr(
                "Dashed: the axis held worst, {error} (95 %)",
                error=degrees(worst.error_deg),
            )
        ]

    def _paint_points(
        self, painter: QPainter, at: Callable[[float, float], QPointF], scale: float
    ) -> list[str]:
        longest = max((float(np.hypot(*p.off)) for p in self._points if p.off), default=0.0)
        times = _LONGEST_ARROW / (scale * longest) if longest * scale > 0.0 else 0.0
        text = self.palette().color(QPalette.ColorRole.WindowText)
        dim = self.palette().color(QPalette.ColorRole.PlaceholderText)
        high = painter.fontMetrics().height()
        taken: set[tuple[int, int]] = set()
        for point in self._points:
            here = at(point.x, point.y)
            if point.off is not None and times:
                there = at(point.x + times * point.off[0], point.y + times * point.off[1])
                painter.setPen(QPen(QColor(_RESIDUAL), 1.8))
                painter.drawLine(here, there)
            painter.setPen(QPen(text if point.found else dim, 1.4))
            painter.setBrush(text if point.used and point.found else Qt.BrushStyle.NoBrush)
            painter.drawEllipse(here, _DOT, _DOT)
            wide = painter.fontMetrics().horizontalAdvance(point.label)
            right = here.x() + _DOT + 3.0 + wide < self.width() - 2.0
            aside = _DOT + 3.0 if right else -_DOT - 3.0 - wide
            # Labels on top of each other cannot be read.
            line = int(here.y() // high)
            first, last = int((here.x() + aside) // high), int((here.x() + aside + wide) // high)
            cells = {(column, line) for column in range(first, last + 1)}
            if not cells & taken:
                taken |= cells
                painter.drawText(here + QPointF(aside, -_DOT), point.label)
        return [tr("residuals {times} times", times=_round(times))] if times else []

    def _paint_north(self, painter: QPainter) -> None:
        painter.setPen(QPen(self.palette().color(QPalette.ColorRole.WindowText), 1.4))
        top = QPointF(self.width() - 14.0, 18.0)
        painter.drawLine(top, top + QPointF(0.0, 16.0))
        painter.drawLine(top, top + QPointF(-3.0, 5.0))
        painter.drawLine(top, top + QPointF(3.0, 5.0))
        painter.drawText(QRectF(top.x() - 8.0, 2.0, 16.0, 14.0), Qt.AlignmentFlag.AlignCenter, "N")


def _round(times: float) -> str:
    """Two digits are enough."""
    step = 10.0 ** (np.floor(np.log10(times)) - 1.0)
    return f"{np.round(times / step) * step:,.0f}" if times >= 10.0 else f"{times:.1f}"
