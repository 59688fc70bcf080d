"""Overlay that shows the stereonet in a corner of the outcrop."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, QSize, Qt, QTimer, Signal, SignalInstance
from PySide6.QtGui import (
    QCursor,
    QHideEvent,
    QMouseEvent,
    QMoveEvent,
    QRegion,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import QFrame, QSizeGrip, QToolButton, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme

_MARGIN = 10
_TOP = 56
"""Initial distance from the top, which leaves space for a two-line message."""
_SCALE_BAR_PX = 60
"""Height of the scale bar, which a net near the top does not cover."""
_SIDE, _MIN_SIDE = 280, 140
_MAX_SHARE = 0.5
"""Maximum size of the overlay as a share of the outcrop's width and height."""
_HIDE_DELAY_MS = 400


@runtime_checkable
class OverlayPage(Protocol):
    """Page that shows its tools in the overlay only while the cursor is over it.

    Attributes
    ----------
    paper_changed : Signal
        Emitted with the area that the page covers, which is empty if it covers the whole overlay.
    """

    tools: QWidget
    paper_changed: SignalInstance

    def set_overlay(self, is_overlay: bool) -> None:
        """Enter or leave the overlay."""


class NetOverlay(QFrame):
    """Overlay with the net over the outcrop.

    It keeps its distance from the nearest corner when the window is resized. Its buttons appear
    while the cursor is over it. The outcrop beside the round net is visible and can be clicked.

    Attributes
    ----------
    center_requested, dock_requested, closed : Signal
        Emitted when the corresponding button was pressed.
    placement_changed : Signal
        Emitted with the rectangle that the overlay covers, which is empty while it is hidden.
    """

    placement_changed = Signal(QRect)
    center_requested = Signal()
    dock_requested = Signal()
    closed = Signal()

    def __init__(self, available_area: QWidget, message_bar: QWidget) -> None:
        super().__init__(available_area)
        self.setObjectName("net_overlay")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self._available_area, self._message_bar = available_area, message_bar
        self._widget: QWidget | None = None
        self.is_shown = False
        """Whether the overlay contains the net, which is visible only together with the outcrop."""
        self._is_covered = False
        self._side = _SIDE
        self._is_right, self._is_bottom = True, False
        self._offset = QPoint(_MARGIN, _TOP)
        self._drag: tuple[QPoint, QPoint] | None = None
        self._paper = QRegion()
        self._buttons = self._make_buttons()
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)
        self._grip = QSizeGrip(self)
        self._grip.resize(14, 14)
        self._grip.hide()
        self._timer = QTimer(self, singleShot=True, interval=_HIDE_DELAY_MS)
        self._timer.timeout.connect(self._hide_buttons)
        available_area.installEventFilter(self)
        self.setMinimumSize(_MIN_SIDE, _MIN_SIDE)
        self.hide()

    def _make_buttons(self) -> QWidget:
        bar = QWidget(self)
        bar.setObjectName("net_overlay_buttons")
        bar.setAutoFillBackground(True)
        # A column beside the round net does not cover it.
        column = QVBoxLayout(bar)
        column.setContentsMargins(1, 2, 1, 2)
        column.setSpacing(1)
        for icon, text, signal in (
            ("arrow-expand", tr("Show in the centre (Shift+F9)"), self.center_requested),
            ("dock-right", tr("Dock the net"), self.dock_requested),
            ("close", tr("Close"), self.closed),
        ):
            button = QToolButton()
            button.setIcon(theme.icon(icon))
            button.setIconSize(QSize(14, 14))
            button.setAutoRaise(True)
            button.setToolTip(text)
            button.setAccessibleName(text)
            button.clicked.connect(signal)
            column.addWidget(button)
        bar.setCursor(Qt.CursorShape.SizeAllCursor)
        bar.hide()
        return bar

    # --- the net -----------------------------------------------------------------------------
    def show_page(self, _name: str, _title: str, widget: QWidget) -> None:
        """Take over the widget of the net and show it."""
        if widget is not self._widget:
            self._widget = widget
            widget.setParent(self)
            self._column.addWidget(widget, 1)
            self._set_overlay(widget, True)
            if isinstance(widget, OverlayPage):
                widget.paper_changed.connect(self._follow_paper)
            widget.show()
        self.is_shown = True
        self._refresh()

    def release_page(self) -> QWidget | None:
        """Hide the overlay and return the widget of the net, or None if it has no net."""
        widget, self._widget = self._widget, None
        if widget is not None:
            self._column.removeWidget(widget)
            self._set_overlay(widget, False)
            if isinstance(widget, OverlayPage):
                widget.paper_changed.disconnect(self._follow_paper)
            self._follow_paper(QRegion())
            widget.hide()
            widget.setParent(None)
        self.is_shown = False
        self._refresh()
        return widget

    @staticmethod
    def _set_overlay(widget: QWidget, is_overlay: bool) -> None:
        # The placeholder that is shown before the net has no tools.
        if isinstance(widget, OverlayPage):
            widget.set_overlay(is_overlay)

    @property
    def _tools(self) -> QWidget | None:
        return self._widget.tools if isinstance(self._widget, OverlayPage) else None

    def _follow_paper(self, region: QRegion) -> None:
        self._paper = region
        self._update_mask()

    def _update_mask(self) -> None:
        """Restrict the overlay to the paper of the net, unless the buttons are visible."""
        if self._paper.isEmpty() or not self._buttons.isHidden():
            self.clearMask()
        else:
            self.setMask(self._paper)
        # Texts of the former paper would remain on the outcrop.
        self._available_area.update(self.geometry())

    def cover(self, is_covered: bool) -> None:
        """Hide the overlay while another widget covers the outcrop."""
        self._is_covered = is_covered
        self._refresh()

    def _refresh(self) -> None:
        self.setVisible(self.is_shown and not self._is_covered)
        self.place()

    # --- place and size ----------------------------------------------------------------------
    def place(self) -> None:
        """Position the overlay at its distance from the corner, inside the outcrop view."""
        available_rect = self._available_area.rect()
        limit = round(_MAX_SHARE * min(available_rect.width(), available_rect.height()))
        side = max(_MIN_SIDE, min(self._side, limit))
        right, bottom = (
            available_rect.width() - side - _MARGIN,
            available_rect.height() - side - _MARGIN,
        )
        x = available_rect.width() - side - self._offset.x() if self._is_right else self._offset.x()
        y = available_rect.height() - side - self._offset.y()
        if not self._is_bottom:
            y = max(_MARGIN, min(self._offset.y(), available_rect.height() - side - _SCALE_BAR_PX))
        place = QPoint(max(0, min(x, max(0, right + _MARGIN))), max(0, min(y, bottom + _MARGIN)))
        tools = self._tools
        if tools is None or tools.isHidden():
            self.setGeometry(QRect(place, QSize(side, side)))
        else:
            width = max(side, tools.minimumSizeHint().width())
            height = min(side + tools.sizeHint().height(), available_rect.height())
            place.setX(max(0, min(place.x(), available_rect.width() - width)))
            place.setY(max(0, min(place.y(), available_rect.height() - height)))
            self.setGeometry(QRect(place, QSize(width, height)))
        self.raise_()
        # The buttons of a message stay reachable.
        self._message_bar.raise_()

    def _anchor(self) -> None:
        """Store the size, and the distance from the nearest corner."""
        available_rect, box = self._available_area.rect(), self.geometry()
        self._side = box.width()
        self._is_right = box.center().x() > available_rect.center().x()
        self._is_bottom = box.center().y() > available_rect.center().y()
        x = available_rect.width() - box.right() - 1 if self._is_right else box.x()
        y = available_rect.height() - box.bottom() - 1 if self._is_bottom else box.y()
        self._offset = QPoint(max(0, x), max(0, y))

    def state(self) -> str:
        """Return the position and size as text for `restore`."""
        corner = ("b" if self._is_bottom else "t") + ("r" if self._is_right else "l")
        return f"{corner} {self._offset.x()} {self._offset.y()} {self._side}"

    def restore(self, text: str) -> None:
        """Restore the position and size; an invalid text has no effect."""
        corner, *numbers = text.split() or [""]
        if corner not in ("tl", "tr", "bl", "br") or len(numbers) != 3:
            return
        if not all(number.isdecimal() for number in numbers):
            return
        x, y, side = (min(int(number), 10_000) for number in numbers)
        self._is_bottom, self._is_right = corner[0] == "b", corner[1] == "r"
        self._offset, self._side = QPoint(x, y), max(_MIN_SIDE, side)
        self.place()

    def reset(self) -> None:
        """Reset the position and size to the initial values."""
        self._is_right, self._is_bottom, self._side = True, False, _SIDE
        self._offset = QPoint(_MARGIN, _TOP)
        self.place()

    # --- Qt ----------------------------------------------------------------------------------
    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._report_place()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        super().hideEvent(event)
        self._report_place()

    def moveEvent(self, event: QMoveEvent) -> None:  # noqa: N802
        super().moveEvent(event)
        self._report_place()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        # The net has not been drawn for the new size.
        self.clearMask()
        self._report_place()

    def _report_place(self) -> None:
        self.placement_changed.emit(QRect() if self.isHidden() else self.geometry())

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Resize and watched is self._available_area:
            self.place()
        return False

    def event(self, event: QEvent) -> bool:
        event_type = event.type()
        if event_type == QEvent.Type.Enter:
            self._timer.stop()
            self._show_tools(True)
            self._buttons.adjustSize()
            self._buttons.move(self.width() - self._buttons.width(), 0)
            self._buttons.show()
            self._buttons.raise_()
            self._update_mask()
            self._grip.move(0, self.height() - self._grip.height())
            self._grip.show()
            self._grip.raise_()
        elif event_type == QEvent.Type.Leave:
            self._timer.start()
        return super().event(event)

    def _show_tools(self, is_visible: bool) -> None:
        if (tools := self._tools) is not None and tools.isHidden() == is_visible:
            tools.setVisible(is_visible)
            self.place()

    def _hide_buttons(self) -> None:
        if self.rect().contains(self.mapFromGlobal(QCursor.pos())):
            self._timer.start()
        else:
            self._show_tools(False)
            self._buttons.hide()
            self._grip.hide()
            self._update_mask()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if event.button() == Qt.MouseButton.LeftButton:
            self._drag = (event.globalPosition().toPoint(), self.pos())
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._drag is not None:
            start, place = self._drag
            position = place + event.globalPosition().toPoint() - start
            limit = self._available_area.rect().bottomRight() - self.rect().bottomRight()
            self.move(max(0, min(position.x(), limit.x())), max(0, min(position.y(), limit.y())))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self._drag is not None:
            self._drag = None
            self._anchor()
        event.accept()
