"""Fitting of windows to the screen; dialogs that are too large are shrunk and scroll."""

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

# Size of the frame and title bar that the system draws around a window.
_FRAME_SIZE = QSize(8, 40)
_TEXT_WIDTH_PX = 560


def available_area(window: QWidget) -> QRect:
    """Return the screen area for a window without its frame, in logical pixels."""
    area = window.screen().availableGeometry()
    return QRect(area.topLeft(), area.size() - _FRAME_SIZE)


def fit_height_to_text(window: QWidget) -> None:
    """Increase the height of a window to that required by its texts at its width.

    Qt requests less height for wrapped text, and squeezes the widgets below it.
    """
    layout = window.layout()
    if layout is None or not layout.hasHeightForWidth():
        return
    size = _expected_size(window)
    layout.activate()
    needed_height = layout.totalHeightForWidth(size.width())
    if needed_height > size.height():
        window.resize(size.width(), min(needed_height, available_area(window).height()))


def _expected_size(window: QWidget) -> QSize:
    """Return the size that a window will have; Qt reports another size before it is shown."""
    if window.isVisible() or window.testAttribute(Qt.WidgetAttribute.WA_Resized):
        return window.size()
    return window.sizeHint().expandedTo(window.minimumSize())


def _polish(widget: QWidget) -> None:
    """Apply the style now, because sizes depend on it; Qt applies it on showing a widget."""
    widget.ensurePolished()
    for child in widget.children():
        if isinstance(child, QWidget):
            _polish(child)


def fit_to_screen(window: QWidget) -> None:
    """Limit the size of a window to its screen before the window is shown.

    A dialog scrolls if its contents require more height, now or after they have grown.
    """
    _polish(window)
    fit_height_to_text(window)
    if isinstance(window, QDialog):
        _fit_height(window)
        _GrowthFilter(window)
    window.resize(window.size().boundedTo(available_area(window).size()))


class _GrowthFilter(QObject):
    """Event filter that resizes a dialog when its contents grow."""

    def __init__(self, dialog: QDialog) -> None:
        super().__init__(dialog)
        self._dialog = dialog
        dialog.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.LayoutRequest:
            # Widgets are not moved while Qt arranges them.
            QTimer.singleShot(0, self, lambda: _fit_height(self._dialog))
        return super().eventFilter(watched, event)


def _fit_height(dialog: QDialog) -> None:
    """Increase the height of a dialog to that of its contents, or let them scroll."""
    layout, area = dialog.layout(), available_area(dialog)
    if layout is None:
        return
    needed_height = _needed_height(dialog, layout)
    if needed_height > area.height():
        _make_scrollable(dialog, layout, area)
    elif needed_height > dialog.height():
        dialog.resize(dialog.width(), needed_height)


def _make_scrollable(dialog: QDialog, layout: QLayout, area: QRect) -> None:
    """Move all widgets of a dialog, except the buttons at its end, into a scroll area."""
    width = min(_expected_size(dialog).width(), area.width())
    margins = layout.contentsMargins()
    buttons = _take_button_box(layout)
    page = QWidget()
    page.setLayout(layout)
    column = QVBoxLayout(dialog)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(PanelScrollArea(page))
    if buttons is not None:
        box_layout = QVBoxLayout()
        box_layout.setContentsMargins(margins)
        box_layout.addWidget(buttons)
        column.addLayout(box_layout)
    # Until now, the minimum size of the dialog is that of its contents.
    column.activate()
    dialog.resize(width, area.height())


def _needed_height(dialog: QDialog, layout: QLayout) -> int:
    """Return the height that the contents require at the future width of the dialog."""
    minimum = dialog.minimumSizeHint().height()
    if not layout.hasHeightForWidth():
        return minimum
    width = min(dialog.width(), available_area(dialog).width())
    return max(minimum, layout.totalMinimumHeightForWidth(width))


def _take_button_box(layout: QLayout) -> QDialogButtonBox | None:
    """Remove the button box at the end of a layout and return it, or None if missing."""
    item = layout.itemAt(layout.count() - 1)
    button_box = None if item is None else item.widget()
    if not isinstance(layout, QVBoxLayout) or not isinstance(button_box, QDialogButtonBox):
        return None
    layout.removeWidget(button_box)
    return button_box


def show_long_text(parent: QWidget, title: str, html: str) -> None:
    """Show a text in a modal dialog that is as high as the text or the screen."""
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
    document.setTextWidth(_TEXT_WIDTH_PX)
    dialog.resize(_TEXT_WIDTH_PX + 60, round(document.size().height()) + 90)
    fit_to_screen(dialog)
    dialog.exec()
    dialog.deleteLater()
