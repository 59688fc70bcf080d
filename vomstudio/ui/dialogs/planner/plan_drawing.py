"""The plan of a photo survey as a drawing: front view and plan view."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import bar_text, round_length
from vomstudio.photogrammetry.survey.planning import CameraStation, SurveyPlan
from vomstudio.products.report.field_sheet import CONTROL, FACE, OBLIQUE, PERPENDICULAR

_MARGIN, _TITLE, _LEGEND = 18.0, 22.0, 26.0
_ARROW = 13.0
# More than these would be one grey patch.
_MOST_ARROWS, _MOST_LABELS = 400, 40


class PlanDrawing(QWidget):
    """Front view and plan view of a survey plan. Both have the same scale, and what is at the same
    place along the outcrop stands above each other."""

    def __init__(self) -> None:
        super().__init__()
        self._plan: SurveyPlan | None = None
        self.setMinimumSize(360, 300)

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(560, 520)

    def show_plan(self, plan: SurveyPlan | None) -> None:
        """Draw this plan; None draws nothing."""
        self._plan = plan
        self.update()

    # --- where things are --------------------------------------------------------------------
    def _spans(self, plan: SurveyPlan) -> tuple[float, float, float, float, float]:
        """Least and largest along; least and largest up; largest away, m."""
        along = [s.along_m for s in plan.positions]
        up = [s.up_m for s in plan.positions]
        first = plan.select_kind("perpendicular")[0]
        wide, high = plan.footprint_m[0] / 2, plan.footprint_m[1] / 2
        return (
            min(*along, 0.0, first.along_m - wide),
            max(*along, plan.width_m, first.along_m + wide),
            min(*up, 0.0, first.up_m - high),
            max(*up, plan.height_m, first.up_m + high),
            max(s.away_m for s in plan.positions),
        )

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().base())
        plan = self._plan
        if plan is None:
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            said = tr("The plan is drawn here once a camera and its target are known.")
            flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, said)
            return
        left, right, low, high, away = self._spans(plan)
        wide = max(right - left, 1e-6)
        tall = max(high - low + away, 1e-6)
        room_x = self.width() - 2 * _MARGIN
        room_y = self.height() - 2 * _TITLE - _LEGEND - 3 * _MARGIN
        scale = max(min(room_x / wide, room_y / tall), 1e-9)
        x0 = (self.width() - wide * scale) / 2 - left * scale
        front = _TITLE + _MARGIN / 2 + high * scale
        above = front - low * scale + _MARGIN + _TITLE
        flat = plan.manner == "terrain"
        text = self.palette().text().color()
        painter.setPen(text)
        titles = (tr("Plan view"), tr("Side view")) if flat else (tr("Front view"), tr("Plan view"))
        painter.drawText(QPointF(_MARGIN, _TITLE - 6), titles[0])
        painter.drawText(QPointF(_MARGIN, above - 8), titles[1])
        self._draw_front(painter, plan, x0, front, scale)
        self._draw_above(painter, plan, x0, above, scale, flat)
        self._draw_legend(painter, plan, scale, text)

    def _draw_front(
        self, painter: QPainter, plan: SurveyPlan, x0: float, y0: float, scale: float
    ) -> None:
        self._rock(
            painter,
            QRectF(x0, y0 - plan.height_m * scale, plan.width_m * scale, plan.height_m * scale),
        )
        first = plan.select_kind("perpendicular")[0]
        w, h = (side * scale for side in plan.footprint_m)
        pen = QPen(QColor(PERPENDICULAR), 1.0, Qt.PenStyle.DashLine)
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(
            QRectF(x0 + first.along_m * scale - w / 2, y0 - first.up_m * scale - h / 2, w, h)
        )
        for station in plan.positions:
            at = QPointF(x0 + station.along_m * scale, y0 - station.up_m * scale)
            dx = station.target_along_m - station.along_m
            dy = -(station.target_up_m - station.up_m)
            self._station(painter, plan, station, at, dx, dy)
        painter.setPen(QPen(QColor(CONTROL), 1.5))
        for point in plan.control_points:
            at = QPointF(x0 + point.along_m * scale, y0 - point.up_m * scale)
            painter.setBrush(QColor(CONTROL if point.use == "control" else "#ffffff"))
            painter.drawRect(QRectF(at.x() - 3.5, at.y() - 3.5, 7, 7))
            if len(plan.control_points) <= _MOST_LABELS:
                painter.drawText(at + QPointF(6, -5), point.label)

    def _draw_above(
        self, painter: QPainter, plan: SurveyPlan, x0: float, y0: float, scale: float, flat: bool
    ) -> None:
        """The rock as a band; the camera stands below it, or above flat ground."""
        farthest = max(s.away_m for s in plan.positions)
        rock = y0 + farthest * scale if flat else y0
        self._rock(painter, QRectF(x0, rock if flat else rock - 6, plan.width_m * scale, 6))
        sign = -1.0 if flat else 1.0
        for station in plan.positions:
            at = QPointF(x0 + station.along_m * scale, rock + sign * station.away_m * scale)
            dx = station.target_along_m - station.along_m
            self._station(painter, plan, station, at, dx, -sign * station.away_m)

    def _rock(self, painter: QPainter, box: QRectF) -> None:
        painter.setPen(QPen(self.palette().text().color(), 1.0))
        painter.setBrush(QColor(FACE))
        painter.drawRect(box)

    def _station(
        self,
        painter: QPainter,
        plan: SurveyPlan,
        station: CameraStation,
        at: QPointF,
        dx: float,
        dy: float,
    ) -> None:
        oblique = station.kind == "oblique"
        color = QColor(OBLIQUE if oblique else PERPENDICULAR)
        painter.setPen(QPen(color, 1.2))
        painter.setBrush(color)
        size = math.hypot(dx, dy)
        if size > 1e-3 * plan.distance_m and len(plan.positions) <= _MOST_ARROWS:
            painter.drawLine(at, at + QPointF(dx, dy) * (_ARROW / size))
        _mark(painter, at, oblique)

    def _draw_legend(self, painter: QPainter, plan: SurveyPlan, scale: float, text: QColor) -> None:
        y = self.height() - _LEGEND / 2
        x = _MARGIN
        length = round_length(90 / scale)
        painter.setPen(QPen(text, 1.5))
        painter.drawLine(QPointF(x, y), QPointF(x + length * scale, y))
        for end in (x, x + length * scale):
            painter.drawLine(QPointF(end, y - 3), QPointF(end, y + 3))
        words = bar_text(length)
        x += length * scale + 6
        painter.drawText(QPointF(x, y + 4), words)
        x += painter.fontMetrics().horizontalAdvance(words) + 22
        for kind, name, color in (
            ("perpendicular", tr("perpendicular"), PERPENDICULAR),
            ("oblique", tr("oblique"), OBLIQUE),
        ):
            if not plan.select_kind(kind):
                continue
            painter.setPen(QPen(QColor(color), 1.2))
            painter.setBrush(QColor(color))
            _mark(painter, QPointF(x, y), kind == "oblique")
            x = self._legend_text(painter, text, name, x, y)
        painter.setPen(QPen(QColor(PERPENDICULAR), 1.0, Qt.PenStyle.DashLine))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(QRectF(x - 5, y - 4, 12, 8))
        x = self._legend_text(painter, text, tr("footprint"), x + 4, y)
        for filled, name in ((True, tr("control point")), (False, tr("check point"))):
            painter.setPen(QPen(QColor(CONTROL), 1.5))
            painter.setBrush(QColor(CONTROL if filled else "#ffffff"))
            painter.drawRect(QRectF(x - 3.5, y - 3.5, 7, 7))
            x = self._legend_text(painter, text, name, x, y)

    def _legend_text(
        self, painter: QPainter, color: QColor, words: str, x: float, y: float
    ) -> float:
        painter.setPen(color)
        painter.drawText(QPointF(x + 9, y + 4), words)
        return x + 9 + painter.fontMetrics().horizontalAdvance(words) + 18


def _mark(painter: QPainter, at: QPointF, oblique: bool) -> None:
    if oblique:
        painter.drawPolygon(
            QPolygonF([at + QPointF(0, -4), at + QPointF(3.6, 3), at + QPointF(-3.6, 3)])
        )
    else:
        painter.drawEllipse(at, 2.8, 2.8)
