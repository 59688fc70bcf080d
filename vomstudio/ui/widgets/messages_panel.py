"""List of all messages, and a bar above the viewport with the newest message."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime

from PySide6.QtCore import QEvent, QObject, QPoint, Qt, QTimer
from PySide6.QtGui import QGuiApplication, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QToolButton,
    QWidget,
)

from vomstudio.core.words import tr, tr_n
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.studio import Notice

_ICONS = {
    "info": "information-outline",
    "hint": "information-outline",
    "warning": "alert-outline",
    "error": "alert-octagon-outline",
}
_COLORS = {"info": "#56b4e9", "hint": "#56b4e9", "warning": "#e69f00", "error": "#d55e00"}
_HINT_MS, _REPORT_MS = 6000, 20_000


class MessagesPanel(QListWidget):
    """Panel with all notices since the project was opened, and their times."""

    def __init__(self) -> None:
        super().__init__()
        self.setWordWrap(True)
        self.setObjectName("messages")
        self.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)

    def add(self, notice: Notice) -> None:
        """Append a notice and scroll to it."""
        item = QListWidgetItem(
            theme.icon(_ICONS[notice.level]), f"{datetime.now():%H:%M:%S}  {notice.text}"
        )
        self.addItem(item)
        self.scrollToItem(item)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        super().paintEvent(event)
        if not self.count():
            painter = QPainter(self.viewport())
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            area = self.viewport().rect()
            painter.drawText(area, Qt.AlignmentFlag.AlignCenter, tr("No messages yet."))

    def copy(self) -> None:
        QGuiApplication.clipboard().setText("\n".join(i.text() for i in self.selectedItems()))


class MessageBar(QFrame):
    """Message bar over the top of the viewport, which keeps its size.

    Hints and reports disappear after a few seconds. Other notices remain, and are counted when a
    newer notice replaces them. `notice` is the current or last notice.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._tools: QWidget | None = None
        self._hint_timer = QTimer(self, singleShot=True)
        self._hint_timer.timeout.connect(self.hide)
        if parent is not None:
            parent.installEventFilter(self)
        self.setObjectName("message_bar")
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self._icon = Label()
        self._text = Label()
        self._text.setObjectName("message_text")
        self._text.setWordWrap(True)
        self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._buttons = QHBoxLayout()
        self._unread_count, self._has_history = 0, False
        self.notice: Notice | None = None
        self._earlier_button = QToolButton()
        self._earlier_button.setAutoRaise(True)
        self._earlier_button.setToolTip(tr("Show all messages."))
        self._earlier_button.hide()
        close_button = QToolButton()
        close_button.setIcon(theme.icon("close"))
        close_button.setAutoRaise(True)
        close_button.setToolTip(tr("Close this message."))
        close_button.clicked.connect(self.hide)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 3, 4, 3)
        layout.addWidget(self._icon)
        layout.addWidget(self._text, 1)
        layout.addLayout(self._buttons)
        layout.addWidget(self._earlier_button)
        layout.addWidget(close_button)
        self.hide()

    @property
    def text(self) -> str:
        return self._text.text()

    def show_notice(self, notice: Notice, *buttons: tuple[str, object]) -> None:
        """Show a notice.

        Parameters
        ----------
        *buttons : tuple of (str, callable)
            Text and action of buttons, which also close the bar.
        """
        is_unread = not self.isHidden() and not self._hint_timer.isActive()
        if notice.level == "hint":
            if self.isVisible() and is_unread:
                # An unread notice remains, and the hint is only listed.
                return
            self._hint_timer.start(_HINT_MS)
        elif notice.level == "info" and not is_unread:
            self._hint_timer.start(_REPORT_MS)
        else:
            self._hint_timer.stop()
        if not is_unread:
            self._unread_count = 0
        elif notice.text != self.text:
            self._unread_count += 1
        self._earlier_button.setText(
            tr_n("{count} earlier message", "{count} earlier messages", self._unread_count)
        )
        self._earlier_button.setVisible(self._has_history and self._unread_count > 0)
        while (item := self._buttons.takeAt(0)) is not None:
            if (old_widget := item.widget()) is not None:
                old_widget.hide()
                old_widget.deleteLater()
        for text, callback in buttons:
            self.add_button(text, callback)
        self._icon.setPixmap(theme.icon(_ICONS[notice.level]).pixmap(18, 18))
        self.setStyleSheet(f"#message_bar {{ border-left: 5px solid {_COLORS[notice.level]}; }}")
        self.notice = notice
        self._text.setText(notice.text)
        self.show()
        self._update_geometry()

    def clear(self) -> None:
        """Hide the notice, and discard the unread notices."""
        self._hint_timer.stop()
        self._unread_count = 0
        self.notice = None
        self.hide()

    def connect_history(self, callback: Callable[[], None]) -> None:
        """Set the function that shows all messages when the count of earlier ones is clicked."""
        self._has_history = True
        self._earlier_button.clicked.connect(lambda: callback())

    def add_button(self, text: str, callback: object) -> None:
        """Add a button that also closes the bar."""
        button = QPushButton(text)
        button.clicked.connect(self.hide)
        button.clicked.connect(callback)
        self._buttons.addWidget(button)

    def hide_hint(self) -> None:
        """Hide a hint or report when the user continues."""
        if self._hint_timer.isActive():
            self._hint_timer.stop()
            self.hide()

    def set_top_tools(self, tools: QWidget | None) -> None:
        """Place the bar below `tools`, or at the top of the parent if `tools` is None."""
        self._tools = tools
        self._update_geometry()

    def _update_geometry(self) -> None:
        """Place the bar across the top of the parent, with the height of its text."""
        parent, tools = self.parentWidget(), self._tools
        if parent is not None and not self.isHidden():
            width = parent.width()
            height = max(self.heightForWidth(width), self.minimumSizeHint().height())
            top = 0 if tools is None else tools.mapTo(parent, QPoint(0, tools.height())).y()
            self.setGeometry(0, top, width, height)
            self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Resize:
            self._update_geometry()
        return False
