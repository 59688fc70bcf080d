"""A view of one model on which points are clicked, with their labels."""

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

_DOT, _RING = 4.5, 16.0
_FOUND, _OPEN, _EXPECTED = QColor("#f0e442"), QColor("#e69f00"), QColor("#56b4e9")
_SHOWN = "shown"


class PickingView(Viewport):
    """picked : a place (3,) in the model's own frame. Its graphics memory is free once it was
    closed."""

    picked = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(240, 200)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self.model: OtherModel | None = None
        self._marks: Mapping[str, FloatArray] = {}
        self._pending: FloatArray | None = None
        self._expected: FloatArray | None = None
        self.pointer.connect(self._pointed)

    def show_model(self, model: OtherModel | None) -> None:
        """Look at a model as it stands, from its exposed side; None for nothing."""
        self.models.remove(_SHOWN)
        self.model = model
        self.show_marks({}, None, None)
        if model is None:
            return
        to_world = transform.matrix(model.to_world)
        self.set_frame(north_known=model.frame.has_north, unit_known=model.frame.has_metres)
        self.moves.look_along(*first_view(model.data, to_world))
        self.models.add(_SHOWN, model.data, to_world, frame_camera=True)

    def show_marks(
        self,
        marks: Mapping[str, FloatArray],
        pending: FloatArray | None,
        expected: FloatArray | None,
    ) -> None:
        """Points by their labels, the one whose counterpart is still to be clicked, and where the
        next one should be: (3,) each, in the model's own frame."""
        self._marks, self._pending, self._expected = marks, pending, expected
        self.update()

    def _pointed(self, event: PointerEvent) -> None:
        if event.kind is Pointer.CLICK and event.button is Button.LEFT and event.hit is not None:
            self.picked.emit(np.array(event.hit.position, np.float64))

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        super().paintEvent(event)
        if self.model is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for label, place in self._marks.items():
            self._paint(painter, place, _FOUND, label)
        if self._pending is not None:
            self._paint(painter, self._pending, _OPEN, "?")
        if self._expected is not None and (at := self._at(self._expected)) is not None:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for color, wide in ((QColor(0, 0, 0, 160), 4.0), (_EXPECTED, 2.0)):
                painter.setPen(QPen(color, wide))
                painter.drawEllipse(at, _RING, _RING)

    def _paint(self, painter: QPainter, place: FloatArray, color: QColor, label: str) -> None:
        at = self._at(place)
        if at is None:
            return
        painter.setPen(QPen(QColor(0, 0, 0, 200), 1.5))
        painter.setBrush(color)
        painter.drawEllipse(at, _DOT, _DOT)
        beside = at + QPointF(_DOT + 3.0, -_DOT)
        wide = painter.fontMetrics().horizontalAdvance(label)
        high = painter.fontMetrics().height()
        painter.fillRect(
            int(beside.x()) - 2, int(beside.y()) - high + 3, wide + 5, high, QColor(0, 0, 0, 150)
        )
        painter.setPen(color)
        painter.drawText(beside, label)

    def _at(self, place: FloatArray) -> QPointF | None:
        """The pixel of a place of the model; None where it is not in sight."""
        assert self.model is not None
        world = transform.apply(transform.matrix(self.model.to_world), place[None])
        (x, y), depth = (part[0] for part in self.camera.project(world, self.extent()))
        return QPointF(x, y) if depth > 0 and np.isfinite([x, y]).all() else None
