"""A form with a picture beside it where there is room, else below it."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QLayout, QVBoxLayout, QWidget

from vomstudio.ui.base.controls import PanelScrollArea

_BESIDE_FROM = 620
_FORM_WIDTH, _FORM_SHARE = 330, 0.44
_LEAST_PICTURE = 120
_NO_LIMIT = 16_777_215


class FormWithPicture(QWidget):
    """It fills a panel. column : of the form, which scrolls by itself beside the picture"""

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
        self._scrolls = PanelScrollArea(self._form)
        self._form.installEventFilter(self)
        self._beside = False

    @classmethod
    def fill(cls, panel: QWidget, *parts: QWidget | QLayout, picture: QWidget) -> FormWithPicture:
        """Fill a panel with a column of parts and a picture, table or text beside it."""
        body = cls(panel)
        for part in parts:
            if isinstance(part, QLayout):
                body.column.addLayout(part)
            else:
                body.column.addWidget(part)
        body.add_picture(picture)
        return body

    def add_picture(self, picture: QWidget) -> None:
        """Once the column of the form is full."""
        self.column.addStretch()
        picture.setMinimumHeight(_LEAST_PICTURE)
        self._sides.addWidget(self._scrolls)
        self._sides.addWidget(picture, 1)
        self._fit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.LayoutRequest:
            self._fit()
        return False

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        beside = self.width() >= _BESIDE_FROM
        ways = QBoxLayout.Direction
        self._sides.setDirection(ways.LeftToRight if beside else ways.TopToBottom)
        self._beside = beside
        self._scrolls.setMaximumWidth(_FORM_WIDTH if beside else _NO_LIMIT)
        # The hints of empty fields are read to their end where there is room.
        least = min(_FORM_WIDTH, round(_FORM_SHARE * self.width()))
        self._scrolls.setMinimumWidth(least if beside else 0)
        self._fit()

    def _fit(self) -> None:
        """Above the picture all of the form is in sight, and the panel scrolls as a whole."""
        size = self._form.sizeHint()
        height = self._form.heightForWidth(max(self._scrolls.width(), size.width()))
        needed = QSize(size.width(), max(size.height(), height))
        self._scrolls.setMinimumHeight(0 if self._beside else needed.height())
