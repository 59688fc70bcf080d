"""Form with a picture beside it, or below it if the panel is narrow."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QLayout, QVBoxLayout, QWidget

from vomstudio.ui.base.controls import PanelScrollArea

_MIN_SIDE_BY_SIDE_WIDTH_PX = 620
_FORM_WIDTH_PX, _FORM_FRACTION = 330, 0.44
_MIN_PICTURE_HEIGHT_PX = 120
_MAX_WIDGET_WIDTH_PX = 16_777_215


class FormWithPicture(QWidget):
    """Form and picture that fill a panel.

    Attributes
    ----------
    column : QVBoxLayout
        Layout of the form, which scrolls independently beside the picture.
    """

    def __init__(self, panel: QWidget) -> None:
        super().__init__()
        outer_layout = QVBoxLayout(panel)
        outer_layout.setContentsMargins(0, 0, 0, 0)
        outer_layout.addWidget(self)
        self._side_layout = QBoxLayout(QBoxLayout.Direction.TopToBottom, self)
        self._side_layout.setContentsMargins(6, 4, 6, 4)
        self._side_layout.setSpacing(6)
        self._form = QWidget()
        self.column = QVBoxLayout(self._form)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(4)
        self._scroll_area = PanelScrollArea(self._form)
        self._form.installEventFilter(self)
        self._is_side_by_side = False

    @classmethod
    def fill(cls, panel: QWidget, *parts: QWidget | QLayout, picture: QWidget) -> FormWithPicture:
        """Fill a panel with a column of parts and a picture, table or text."""
        body = cls(panel)
        for part in parts:
            if isinstance(part, QLayout):
                body.column.addLayout(part)
            else:
                body.column.addWidget(part)
        body.add_picture(picture)
        return body

    def add_picture(self, picture: QWidget) -> None:
        """Add the picture after all parts of the form."""
        self.column.addStretch()
        picture.setMinimumHeight(_MIN_PICTURE_HEIGHT_PX)
        self._side_layout.addWidget(self._scroll_area)
        self._side_layout.addWidget(picture, 1)
        self._fit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.LayoutRequest:
            self._fit()
        return False

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        is_legend_beside = self.width() >= _MIN_SIDE_BY_SIDE_WIDTH_PX
        directions = QBoxLayout.Direction
        self._side_layout.setDirection(
            directions.LeftToRight if is_legend_beside else directions.TopToBottom
        )
        self._is_side_by_side = is_legend_beside
        self._scroll_area.setMaximumWidth(
            _FORM_WIDTH_PX if is_legend_beside else _MAX_WIDGET_WIDTH_PX
        )
        # Placeholders of fields must not be truncated if there is space.
        minimum = min(_FORM_WIDTH_PX, round(_FORM_FRACTION * self.width()))
        self._scroll_area.setMinimumWidth(minimum if is_legend_beside else 0)
        self._fit()

    def _fit(self) -> None:
        """Set the minimum height of the form, which is completely visible above a picture."""
        size = self._form.sizeHint()
        height = self._form.heightForWidth(max(self._scroll_area.width(), size.width()))
        needed_size = QSize(size.width(), max(size.height(), height))
        self._scroll_area.setMinimumHeight(0 if self._is_side_by_side else needed_size.height())
