"""Boxes that are larger than the screen: they get smaller, and what is long in them scrolls."""

from __future__ import annotations

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QTextBrowser, QVBoxLayout, QWidget

from vomstudio.ui.common.widgets import Scrolling

# Of the frame that the system draws around a window, with its title.
_FRAME = QSize(8, 40)
_TEXT_WIDTH = 560


def room_for(window: QWidget) -> QRect:
    """Where a window can stand on its screen with its frame, in logical pixels."""
    area = window.screen().availableGeometry()
    return QRect(area.topLeft(), area.size() - _FRAME)


def make_room_for_text(window: QWidget) -> None:
    """Make a window as high as its texts need, whose lines depend on its width: Qt asks for less,
    and squeezes what stands below them."""
    layout = window.layout()
    if layout is None or not layout.hasHeightForWidth():
        return
    size = window.size()
    if not window.isVisible() and not window.testAttribute(Qt.WidgetAttribute.WA_Resized):
        size = window.sizeHint().expandedTo(window.minimumSize())
    layout.activate()
    needed = layout.totalHeightForWidth(size.width())
    if needed > size.height():
        window.resize(size.width(), min(needed, room_for(window).height()))


def fit_to_screen(window: QWidget) -> None:
    """Make a window that is about to be shown no larger than its screen, and let a dialog scroll
    whose contents need more height than that."""
    room = room_for(window)
    make_room_for_text(window)
    layout = window.layout()
    if (
        isinstance(window, QDialog)
        and layout is not None
        and window.minimumSizeHint().height() > room.height()
    ):
        page = QWidget()
        size = window.size()
        page.setLayout(layout)
        column = QVBoxLayout(window)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(Scrolling(page))
        window.resize(size)
    window.resize(window.size().boundedTo(room.size()))


def show_long_text(parent: QWidget, title: str, html: str) -> None:
    """Show a text in a dialog that is as high as there is room, and wait for its end."""
    dialog = QDialog(parent)
    dialog.setWindowTitle(title)
    text = QTextBrowser()
    text.setHtml(html)
    buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    buttons.rejected.connect(dialog.reject)
    column = QVBoxLayout(dialog)
    column.addWidget(text)
    column.addWidget(buttons)
    document = text.document()
    document.setTextWidth(_TEXT_WIDTH)
    dialog.resize(_TEXT_WIDTH + 60, round(document.size().height()) + 90)
    fit_to_screen(dialog)
    dialog.exec()
    dialog.deleteLater()
