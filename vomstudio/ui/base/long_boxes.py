"""Boxes that are larger than the screen: they get smaller, and what is long in them scrolls."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QRect, QSize, Qt, QTimer
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLayout,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from vomstudio.ui.base.controls import PanelScrollArea

# Of the frame that the system draws around a window, with its title.
_FRAME = QSize(8, 40)
_TEXT_WIDTH = 560


def available_area(window: QWidget) -> QRect:
    """Where a window can stand on its screen with its frame, in logical pixels."""
    area = window.screen().availableGeometry()
    return QRect(area.topLeft(), area.size() - _FRAME)


def fit_height_to_text(window: QWidget) -> None:
    """Make a window as high as its texts need, whose lines depend on its width: Qt asks for less,
    and squeezes what stands below them."""
    layout = window.layout()
    if layout is None or not layout.hasHeightForWidth():
        return
    size = _size_when_shown(window)
    layout.activate()
    needed = layout.totalHeightForWidth(size.width())
    if needed > size.height():
        window.resize(size.width(), min(needed, available_area(window).height()))


def _size_when_shown(window: QWidget) -> QSize:
    """Before a window is shown, Qt tells a size that it will not have."""
    if window.isVisible() or window.testAttribute(Qt.WidgetAttribute.WA_Resized):
        return window.size()
    return window.sizeHint().expandedTo(window.minimumSize())


def _polish(widget: QWidget) -> None:
    """Sizes follow from the style, which Qt gives to widgets only as they are shown."""
    widget.ensurePolished()
    for child in widget.children():
        if isinstance(child, QWidget):
            _polish(child)


def fit_to_screen(window: QWidget) -> None:
    """Make a window that is about to be shown no larger than its screen, and let a dialog scroll
    whose contents need more height than that, now or once they have grown."""
    _polish(window)
    fit_height_to_text(window)
    if isinstance(window, QDialog):
        _make_room(window)
        _Growth(window)
    window.resize(window.size().boundedTo(available_area(window).size()))


class _Growth(QObject):
    """Makes a dialog higher as its texts grow, and lets it scroll where the screen ends."""

    def __init__(self, dialog: QDialog) -> None:
        super().__init__(dialog)
        self._dialog = dialog
        dialog.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.LayoutRequest:
            # Widgets are not moved while Qt arranges them.
            QTimer.singleShot(0, self, lambda: _make_room(self._dialog))
        return super().eventFilter(watched, event)


def _make_room(dialog: QDialog) -> None:
    """Make it as high as it must be for nothing to be squeezed, or let it scroll."""
    layout, room = dialog.layout(), available_area(dialog)
    if layout is None:
        return
    needed = _needed_height(dialog, layout)
    if needed > room.height():
        _scroll(dialog, layout, room)
    elif needed > dialog.height():
        dialog.resize(dialog.width(), needed)


def _scroll(dialog: QDialog, layout: QLayout, room: QRect) -> None:
    """Put all but the buttons at the end, which stay in sight, into a place that scrolls."""
    width = min(_size_when_shown(dialog).width(), room.width())
    margins = layout.contentsMargins()
    buttons = _buttons_at_end(layout)
    page = QWidget()
    page.setLayout(layout)
    column = QVBoxLayout(dialog)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(PanelScrollArea(page))
    if buttons is not None:
        below = QVBoxLayout()
        below.setContentsMargins(margins)
        below.addWidget(buttons)
        column.addLayout(below)
    # Until then the dialog may be no smaller than all its contents.
    column.activate()
    # All of the room: its contents would need more.
    dialog.resize(width, room.height())


def _needed_height(dialog: QDialog, layout: QLayout) -> int:
    """Lines of texts are counted at the width that the dialog will have."""
    least = dialog.minimumSizeHint().height()
    if not layout.hasHeightForWidth():
        return least
    width = min(dialog.width(), available_area(dialog).width())
    return max(least, layout.totalMinimumHeightForWidth(width))


def _buttons_at_end(layout: QLayout) -> QDialogButtonBox | None:
    """Taken out of the layout."""
    item = layout.itemAt(layout.count() - 1)
    found = None if item is None else item.widget()
    if not isinstance(layout, QVBoxLayout) or not isinstance(found, QDialogButtonBox):
        return None
    layout.removeWidget(found)
    return found


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
