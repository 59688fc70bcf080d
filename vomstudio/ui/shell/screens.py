"""Initial sizes of windows, and recovery of windows from disconnected screens."""

from __future__ import annotations

import base64
import binascii

from PySide6.QtCore import QByteArray, QRect, QSize
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMainWindow, QWidget

_DEFAULT_SIZE = QSize(1400, 900)
MIN_SIZE = QSize(960, 480)
# Title bar, by which a window is moved.
_TITLE_HEIGHT_PX = 32
MIN_VISIBLE_SIZE = QSize(120, 16)


def set_default_size(window: QMainWindow) -> None:
    """Set the minimum and initial size of a window, limited to its screen."""
    available_rect = window.screen().availableSize() - QSize(0, _TITLE_HEIGHT_PX)
    window.setMinimumSize(MIN_SIZE.boundedTo(available_rect))
    window.resize(_DEFAULT_SIZE.boundedTo(available_rect))


def restore_geometry(window: QMainWindow, stored_text: str | None) -> None:
    """Restore the stored position and size of a window, and move it onto a screen.

    Without a valid text, the window has its default size.
    """
    set_default_size(window)
    if stored_text is not None and (data := from_text(stored_text)) is not None:
        window.restoreGeometry(data)
        bring_on_screen(window)


def bring_on_screen(widget: QWidget) -> None:
    """Move a window whose title bar is off screen to the main screen.

    The window is shrunk to fit. A window that is larger than all screens together is shrunk to
    their size.
    """
    _shrink_to_area(widget, widget.screen().availableVirtualGeometry())
    frame = widget.frameGeometry()
    title = QRect(frame.topLeft(), QSize(frame.width(), _TITLE_HEIGHT_PX))
    for screen in QGuiApplication.screens():
        visible = screen.availableGeometry().intersected(title).size()
        if visible.boundedTo(MIN_VISIBLE_SIZE) == MIN_VISIBLE_SIZE:
            return
    area = QGuiApplication.primaryScreen().availableGeometry()
    widget.resize(widget.size().boundedTo(area.size() - QSize(0, _TITLE_HEIGHT_PX)))
    place = QRect(area.topLeft(), widget.size())
    place.moveCenter(area.center())
    widget.move(place.topLeft())


def _shrink_to_area(widget: QWidget, area: QRect) -> None:
    frame = widget.frameGeometry()
    size = frame.size().boundedTo(area.size())
    if widget.isFullScreen() or widget.isMaximized() or size == frame.size():
        return
    # The thickness of the frame has not changed.
    widget.resize(size - (frame.size() - widget.size()))
    widget.move(
        max(area.left(), min(frame.left(), area.right() + 1 - size.width())),
        max(area.top(), min(frame.top(), area.bottom() + 1 - size.height())),
    )


def to_text(data: QByteArray) -> str:
    """Encode binary data of Qt as text for the settings."""
    return base64.b64encode(data.data()).decode("ascii")


def from_text(text: str) -> QByteArray | None:
    """Decode a text of `to_text`, or return None if the text is damaged."""
    try:
        return QByteArray(base64.b64decode(text, validate=True))
    except (binascii.Error, ValueError):
        return None
