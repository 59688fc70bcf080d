"""Painting of the preview of an unfinished tool."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QColor, QPainter

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.plane_discs import disc
from vomstudio.rendering.qt import painting
from vomstudio.rendering.qt.readout_box import ReadoutBox
from vomstudio.rendering.view.readout_position import PickedPoints, ReadingPosition
from vomstudio.studio.tools.interaction_types import BrushRing, Preview


class Projector(Protocol):
    """Projection from the World frame to pixels, by the viewport's camera or a photo."""

    @property
    def direction(self) -> FloatArray: ...

    def project(
        self, points: FloatArray, size: tuple[float, float]
    ) -> tuple[FloatArray, FloatArray]: ...


MAX_DOTS = 200
"""Maximum number of border points of a painted area that the reading box avoids."""


class PreviewPainter:
    """Painter of a preview for one paint event.

    Parameters
    ----------
    project : callable
        Function that returns the pixels of points in the World frame, and whether each is visible.
    reading_position : ReadingPosition
        Stores the position of the reading box.
    covered_rect : QRectF, optional
        Rectangle that another widget covers.
    """

    def __init__(
        self,
        painter: QPainter,
        camera: Projector,
        extent: tuple[float, float],
        project: Callable[[FloatArray], tuple[FloatArray, BoolArray]],
        reading_position: ReadingPosition,
        covered_rect: QRectF | None = None,
    ) -> None:
        self._painter, self._camera = painter, camera
        self._extent, self._project = extent, project
        self._reading_position = reading_position
        self._widget = None
        if covered_rect is not None and not covered_rect.isEmpty():
            self._widget = (
                covered_rect.x(),
                covered_rect.y(),
                covered_rect.width(),
                covered_rect.height(),
            )

    def paint(self, preview: Preview, cursor: QPointF | None, hovered_handle: int | None) -> None:
        painter = self._painter
        width, height = self._extent
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        color = painting.to_color(preview.color)
        line = np.asarray(preview.line, float).reshape(-1, 3)
        if preview.patch is not None:
            ring, _ = self._camera.project(np.asarray(preview.patch, float), (width, height))
            tint = painting.VERDICT_COLORS.get(preview.verdict or "")
            painting.draw_ring(painter, ring, QColor(tint) if tint else color)
        path = line if preview.path is None else np.asarray(preview.path, float)
        if len(path) >= 2:
            self._paint_line(path, color, 2.4)
        for part in preview.doubtful:
            pixels, _ = self._camera.project(part, (width, height))
            if np.isfinite(pixels).all():
                painting.draw_rubber_band(
                    painter, pixels, QColor(painting.VERDICT_COLORS["doubtful"])
                )
        if preview.rubber is not None and len(line):
            band = np.stack([line[-1], np.asarray(preview.rubber, float)])
            if preview.ahead is not None:
                band = np.asarray(preview.ahead, float)
            pixels, _ = self._camera.project(band, (width, height))
            if np.isfinite(pixels).all():
                painting.draw_rubber_band(painter, pixels, color)
        if len(line):
            pixels, is_visible = self._project(line)
            for i, (x, y) in enumerate(pixels):
                if np.isfinite(x) and np.isfinite(y):
                    painting.draw_handle(
                        painter,
                        x,
                        y,
                        color,
                        is_visible=bool(is_visible[i]),
                        is_hovered=i == hovered_handle,
                        is_marked=i == preview.marked,
                    )
        self._paint_pending(preview, color)
        if preview.outline is not None:
            painting.draw_outline(painter, preview.outline, color)
        clearance = 0.0
        if preview.brush is not None:
            clearance = self._paint_brush(preview.brush, color)
        if cursor is None or not (preview.reading or preview.verdict):
            self._reading_position.clear_state()
            return
        clearance = min(clearance, 0.2 * width)
        pixels, _ = self._camera.project(line, (width, height))
        rubber = None
        if preview.rubber is not None:
            rubber = self._camera.project(np.asarray(preview.rubber, float), (width, height))[0][0]
        position = cursor.x(), cursor.y()
        border = self._border(preview)
        picked_points = PickedPoints(pixels, position, rubber, border, clearance, self._widget)
        self._paint_reading(preview, picked_points)

    def _paint_pending(self, preview: Preview, color: QColor) -> None:
        """Mark the clicks that have not taken effect yet."""
        if preview.pending_positions is None or not len(preview.pending_positions):
            return
        pixels, _ = self._camera.project(preview.pending_positions, self._extent)
        for x, y in pixels[np.isfinite(pixels).all(axis=1)]:
            painting.draw_pending_click(self._painter, x, y, color)

    def _paint_reading(self, preview: Preview, picked_points: PickedPoints) -> None:
        """Paint the reading, or only its first line if the complete text does not fit."""
        boxes = [ReadoutBox(preview.reading, preview.verdict)]
        if len(preview.reading) > 1:
            boxes.append(ReadoutBox(preview.reading[:1], preview.verdict))
        number, box = self._reading_position.choose(
            [b.size() for b in boxes], self._extent, picked_points
        )
        boxes[number].paint(self._painter, QRectF(*box))

    def _border(self, preview: Preview) -> FloatArray:
        """Return pixels (d, 2) along the border of the painted area."""
        if preview.area is None or not len(preview.area.border):
            return np.zeros((0, 2))
        edges = preview.area.border[:: len(preview.area.border) // MAX_DOTS + 1]
        positions = edges.mean(axis=1, dtype=np.float64) + preview.area.origin
        return self._camera.project(positions, self._extent)[0]

    def _paint_brush(self, brush: BrushRing, color: QColor) -> float:
        """Paint the brush ring parallel to the surface, or to the image if that is unknown.

        Return half the width of the ring in pixels; 0 if a part of it is behind the viewer.
        """
        normal = self._camera.direction if brush.normal is None else brush.normal
        ring, _ = self._camera.project(disc(brush.centre, normal, brush.radius), self._extent)
        painting.draw_brush(self._painter, ring, color, is_removing=brush.is_removing)
        return float(np.ptp(ring[:, 0])) / 2.0 if np.isfinite(ring).all() else 0.0

    def _paint_line(self, line: FloatArray, color: QColor, width: float) -> None:
        """Paint a line of the World frame, subdivided to distinguish its hidden parts."""
        pixels, _ = self._camera.project(line, self._extent)
        if not np.isfinite(pixels).all():
            return
        steps = np.clip(np.hypot(*np.diff(pixels, axis=0).T) / 6.0, 1, 400).astype(int)
        fine_points = [
            line[i] + (line[i + 1] - line[i]) * np.linspace(0.0, 1.0, n, endpoint=False)[:, None]
            for i, n in enumerate(steps)
        ]
        points = np.concatenate([*fine_points, line[-1:]])
        pixels, is_visible = self._project(points)
        painting.draw_runs(self._painter, pixels, is_visible, color, width)
