"""A form with a picture beside it where there is room, else below it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QVBoxLayout, QWidget

_BESIDE_FROM = 620
_FORM_WIDTH = 330
_LEAST_PICTURE = 170
_NO_LIMIT = 16_777_215


class FormBeside(QWidget):
    """It fills a panel. column : of the form"""

    def __init__(self, panel: QWidget) -> None:
        super().__init__()
        around = QVBoxLayout(panel)
        around.setContentsMargins(0, 0, 0, 0)
        around.addWidget(self)
        self._sides = QBoxLayout(QBoxLayout.Direction.TopToBottom, self)
        self._sides.setContentsMargins(6, 4, 6, 4)
        self._sides.setSpacing(6)
        self._form = QWidget()
        self.column = QVBoxLayout(self._form)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(4)

    def put_beside(self, picture: QWidget) -> None:
        """Once the column of the form is full."""
        self.column.addStretch()
        picture.setMinimumHeight(_LEAST_PICTURE)
        self._sides.addWidget(self._form, 0, Qt.AlignmentFlag.AlignTop)
        self._sides.addWidget(picture, 1)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        beside = self.width() >= _BESIDE_FROM
        ways = QBoxLayout.Direction
        self._sides.setDirection(ways.LeftToRight if beside else ways.TopToBottom)
        self._form.setMaximumWidth(_FORM_WIDTH if beside else _NO_LIMIT)
