"""View of one model in which labelled points are clicked."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.first_view import first_view
from vomstudio.studio.tools.interaction_types import Button, Pointer, PointerEvent
from vomstudio.ui.widgets.other_model_box import OtherModel

_DOT_PX, _RING_PX = 4.5, 16.0
_PAIR_COLOR, _PENDING_COLOR, _EXPECTED_COLOR = (
    QColor("#f0e442"),
    QColor("#e69f00"),
    QColor("#56b4e9"),
)
_MODEL_ID = "shown"


class PickingView(Viewport):
    """View of one model. `picked` emits points (3,) in the file frame of the model."""

    picked = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(240, 200)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self.model: OtherModel | None = None
        self._marks: Mapping[str, FloatArray] = {}
        self._pending_point: FloatArray | None = None
        self._expected_point: FloatArray | None = None
        self.pointer.connect(self._handle_pointer)

    def show_model(self, model: OtherModel | None) -> None:
        """Show a model from its exposed side, or clear the view if no model is given."""
        self.models.remove(_MODEL_ID)
        self.model = model
        self.show_marks({}, None, None)
        if model is None:
            return
        to_world = transform.matrix(model.to_world)
        self.set_frame(is_north_known=model.frame.has_north, is_unit_known=model.frame.has_metres)
        self.moves.look_along(*first_view(model.data, to_world))
        self.models.add(_MODEL_ID, model.data, to_world, frame_camera=True)

    def show_marks(
        self,
        marks: Mapping[str, FloatArray],
        pending_point: FloatArray | None,
        expected_point: FloatArray | None,
    ) -> None:
        """Show labelled points (3,), given in the file frame of the model.

        Parameters
        ----------
        marks : mapping
            Points of the complete pairs, keyed by label.
        pending_point : ndarray or None
            Point whose counterpart has not been clicked yet.
        expected_point : ndarray or None
            Expected position of the next point.
        """
        self._marks, self._pending_point, self._expected_point = (
            marks,
            pending_point,
            expected_point,
        )
        self.update()

    def _handle_pointer(self, event: PointerEvent) -> None:
        if event.kind is Pointer.CLICK and event.button is Button.LEFT and event.hit is not None:
            self.picked.emit(np.array(event.hit.position, np.float64))

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        super().paintEvent(event)
        if self.model is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for label, point in self._marks.items():
            self._paint_mark(painter, point, _PAIR_COLOR, label)
        if self._pending_point is not None:
            self._paint_mark(painter, self._pending_point, _PENDING_COLOR, "?")
        if (
            self._expected_point is not None
            and (pixel := self._to_pixel(self._expected_point)) is not None
        ):
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for color, width in ((QColor(0, 0, 0, 160), 4.0), (_EXPECTED_COLOR, 2.0)):
                painter.setPen(QPen(color, width))
                painter.drawEllipse(pixel, _RING_PX, _RING_PX)

    def _paint_mark(self, painter: QPainter, point: FloatArray, color: QColor, label: str) -> None:
        pixel = self._to_pixel(point)
        if pixel is None:
            return
        painter.setPen(QPen(QColor(0, 0, 0, 200), 1.5))
        painter.setBrush(color)
        painter.drawEllipse(pixel, _DOT_PX, _DOT_PX)
        label_position = pixel + QPointF(_DOT_PX + 3.0, -_DOT_PX)
        width = painter.fontMetrics().horizontalAdvance(label)
        height = painter.fontMetrics().height()
        painter.fillRect(
            int(label_position.x()) - 2,
            int(label_position.y()) - height + 3,
            width + 5,
            height,
            QColor(0, 0, 0, 150),
        )
        painter.setPen(color)
        painter.drawText(label_position, label)

    def _to_pixel(self, point: FloatArray) -> QPointF | None:
        """Project a point of the model to a pixel; return None if it is behind the camera."""
        assert self.model is not None
        world = transform.apply(transform.matrix(self.model.to_world), point[None])
        (x, y), depth = (values[0] for values in self.camera.project(world, self.extent()))
        return QPointF(x, y) if depth > 0 and np.isfinite([x, y]).all() else None
