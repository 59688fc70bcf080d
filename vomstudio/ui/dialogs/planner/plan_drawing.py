"""Drawing of a survey plan in two views."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from vomstudio.core.words import tr
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.photogrammetry.survey.planning import CameraStation, SurveyPlan
from vomstudio.products.report.field_sheet import (
    CONTROL_COLOR,
    FACE_COLOR,
    OBLIQUE_COLOR,
    PERPENDICULAR_COLOR,
)

_MARGIN_PX, _TITLE_PX, _LEGEND_PX = 18.0, 22.0, 26.0
_ARROW_PX = 13.0
# Maximum numbers of arrows and labels; more would overlap.
_MAX_ARROWS, _MAX_LABELS = 400, 40


class PlanDrawing(QWidget):
    """Two aligned views of a survey plan at the same scale.

    These are a front view and a plan view of a face, or a plan view and a side view of terrain.
    """

    def __init__(self) -> None:
        super().__init__()
        self._plan: SurveyPlan | None = None
        self.setMinimumSize(360, 300)

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(560, 520)

    def show_plan(self, plan: SurveyPlan | None) -> None:
        """Draw a plan, or clear the drawing if no plan is given."""
        self._plan = plan
        self.update()

    # --- layout ------------------------------------------------------------------------------
    def _extents(self, plan: SurveyPlan) -> tuple[float, float, float, float, float]:
        """Return the ranges along the face and upwards, and the largest distance, in metres."""
        horizontal_m = [s.along_m for s in plan.positions]
        heights_m = [s.up_m for s in plan.positions]
        first_station = plan.select_kind("perpendicular")[0]
        half_width_m, half_height_m = plan.footprint_m[0] / 2, plan.footprint_m[1] / 2
        return (
            min(*horizontal_m, 0.0, first_station.along_m - half_width_m),
            max(*horizontal_m, plan.width_m, first_station.along_m + half_width_m),
            min(*heights_m, 0.0, first_station.up_m - half_height_m),
            max(*heights_m, plan.height_m, first_station.up_m + half_height_m),
            max(s.away_m for s in plan.positions),
        )

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().base())
        plan = self._plan
        if plan is None:
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            hint = tr("Choose a camera and a target to draw the plan.")
            flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, hint)
            return
        left_m, right_m, bottom_m, top_m, max_distance_m = self._extents(plan)
        width_m = max(right_m - left_m, 1e-6)
        height_m = max(top_m - bottom_m + max_distance_m, 1e-6)
        max_width = self.width() - 2 * _MARGIN_PX
        max_height = self.height() - 2 * _TITLE_PX - _LEGEND_PX - 3 * _MARGIN_PX
        scale = max(min(max_width / width_m, max_height / height_m), 1e-9)
        x0 = (self.width() - width_m * scale) / 2 - left_m * scale
        first_view_y = _TITLE_PX + _MARGIN_PX / 2 + top_m * scale
        second_view_y = first_view_y - bottom_m * scale + _MARGIN_PX + _TITLE_PX
        is_terrain = plan.manner == "terrain"
        text_color = self.palette().text().color()
        painter.setPen(text_color)
        titles = (
            (tr("Plan view"), tr("Side view"))
            if is_terrain
            else (tr("Front view"), tr("Plan view"))
        )
        painter.drawText(QPointF(_MARGIN_PX, _TITLE_PX - 6), titles[0])
        painter.drawText(QPointF(_MARGIN_PX, second_view_y - 8), titles[1])
        self._draw_first_view(painter, plan, x0=x0, y0=first_view_y, scale=scale)
        self._draw_second_view(
            painter, plan, x0=x0, y0=second_view_y, scale=scale, is_terrain=is_terrain
        )
        self._draw_legend(painter, plan, scale, text_color)

    def _draw_first_view(
        self, painter: QPainter, plan: SurveyPlan, x0: float, y0: float, scale: float
    ) -> None:
        self._draw_rock(
            painter,
            QRectF(x0, y0 - plan.height_m * scale, plan.width_m * scale, plan.height_m * scale),
        )
        first_station = plan.select_kind("perpendicular")[0]
        width, height = (side * scale for side in plan.footprint_m)
        pen = QPen(QColor(PERPENDICULAR_COLOR), 1.0, Qt.PenStyle.DashLine)
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(
            QRectF(
                x0 + first_station.along_m * scale - width / 2,
                y0 - first_station.up_m * scale - height / 2,
                width,
                height,
            )
        )
        for station in plan.positions:
            position = QPointF(x0 + station.along_m * scale, y0 - station.up_m * scale)
            dx = station.target_along_m - station.along_m
            dy = -(station.target_up_m - station.up_m)
            self._draw_station(painter, plan, station=station, position=position, dx=dx, dy=dy)
        painter.setPen(QPen(QColor(CONTROL_COLOR), 1.5))
        for point in plan.control_points:
            position = QPointF(x0 + point.along_m * scale, y0 - point.up_m * scale)
            painter.setBrush(QColor(CONTROL_COLOR if point.use == "control" else "#ffffff"))
            painter.drawRect(QRectF(position.x() - 3.5, position.y() - 3.5, 7, 7))
            if len(plan.control_points) <= _MAX_LABELS:
                painter.drawText(position + QPointF(6, -5), point.label)

    def _draw_second_view(
        self,
        painter: QPainter,
        plan: SurveyPlan,
        x0: float,
        y0: float,
        scale: float,
        is_terrain: bool,
    ) -> None:
        """Draw the rock as a band, with the cameras below it or, for terrain, above it."""
        max_distance_m = max(s.away_m for s in plan.positions)
        rock_y = y0 + max_distance_m * scale if is_terrain else y0
        self._draw_rock(
            painter, QRectF(x0, rock_y if is_terrain else rock_y - 6, plan.width_m * scale, 6)
        )
        sign = -1.0 if is_terrain else 1.0
        for station in plan.positions:
            position = QPointF(x0 + station.along_m * scale, rock_y + sign * station.away_m * scale)
            dx = station.target_along_m - station.along_m
            self._draw_station(
                painter, plan, station=station, position=position, dx=dx, dy=-sign * station.away_m
            )

    def _draw_rock(self, painter: QPainter, box: QRectF) -> None:
        painter.setPen(QPen(self.palette().text().color(), 1.0))
        painter.setBrush(QColor(FACE_COLOR))
        painter.drawRect(box)

    def _draw_station(
        self,
        painter: QPainter,
        plan: SurveyPlan,
        station: CameraStation,
        position: QPointF,
        dx: float,
        dy: float,
    ) -> None:
        is_oblique = station.kind == "oblique"
        color = QColor(OBLIQUE_COLOR if is_oblique else PERPENDICULAR_COLOR)
        painter.setPen(QPen(color, 1.2))
        painter.setBrush(color)
        length = math.hypot(dx, dy)
        if length > 1e-3 * plan.distance_m and len(plan.positions) <= _MAX_ARROWS:
            painter.drawLine(position, position + QPointF(dx, dy) * (_ARROW_PX / length))
        _draw_mark(painter, position, is_oblique)

    def _draw_legend(
        self, painter: QPainter, plan: SurveyPlan, scale: float, text_color: QColor
    ) -> None:
        y = self.height() - _LEGEND_PX / 2
        x = _MARGIN_PX
        length = round_length(90 / scale)
        painter.setPen(QPen(text_color, 1.5))
        painter.drawLine(QPointF(x, y), QPointF(x + length * scale, y))
        for end in (x, x + length * scale):
            painter.drawLine(QPointF(end, y - 3), QPointF(end, y + 3))
        label = scale_bar_text(length)
        x += length * scale + 6
        painter.drawText(QPointF(x, y + 4), label)
        x += painter.fontMetrics().horizontalAdvance(label) + 22
        for kind, name, color in (
            ("perpendicular", tr("perpendicular"), PERPENDICULAR_COLOR),
            ("oblique", tr("oblique"), OBLIQUE_COLOR),
        ):
            if not plan.select_kind(kind):
                continue
            painter.setPen(QPen(QColor(color), 1.2))
            painter.setBrush(QColor(color))
            _draw_mark(painter, QPointF(x, y), kind == "oblique")
            x = self._draw_legend_text(painter, color=text_color, label=name, x=x, y=y)
        painter.setPen(QPen(QColor(PERPENDICULAR_COLOR), 1.0, Qt.PenStyle.DashLine))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(QRectF(x - 5, y - 4, 12, 8))
        x = self._draw_legend_text(painter, color=text_color, label=tr("footprint"), x=x + 4, y=y)
        for is_filled, name in ((True, tr("control point")), (False, tr("check point"))):
            painter.setPen(QPen(QColor(CONTROL_COLOR), 1.5))
            painter.setBrush(QColor(CONTROL_COLOR if is_filled else "#ffffff"))
            painter.drawRect(QRectF(x - 3.5, y - 3.5, 7, 7))
            x = self._draw_legend_text(painter, color=text_color, label=name, x=x, y=y)

    def _draw_legend_text(
        self, painter: QPainter, color: QColor, label: str, x: float, y: float
    ) -> float:
        painter.setPen(color)
        painter.drawText(QPointF(x + 9, y + 4), label)
        return x + 9 + painter.fontMetrics().horizontalAdvance(label) + 18


def _draw_mark(painter: QPainter, position: QPointF, is_oblique: bool) -> None:
    if is_oblique:
        painter.drawPolygon(
            QPolygonF(
                [position + QPointF(0, -4), position + QPointF(3.6, 3), position + QPointF(-3.6, 3)]
            )
        )
    else:
        painter.drawEllipse(position, 2.8, 2.8)
