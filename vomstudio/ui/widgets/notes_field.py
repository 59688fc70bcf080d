"""Field for notes of several lines."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import QPlainTextEdit, QSizePolicy

from vomstudio.core.words import tr

_LINES = 3


class NotesField(QPlainTextEdit):
    """Text of several lines, with the interface of a line edit.

    `finished` is emitted when the field loses the focus or Ctrl+Enter is pressed.
    """

    finished = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setTabChangesFocus(True)
        self.setToolTip(tr("Ctrl+Enter saves the notes."))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        frame = 2 * self.frameWidth() + 2 * round(self.document().documentMargin())
        return QSize(120, _LINES * self.fontMetrics().lineSpacing() + frame)

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(60, self.sizeHint().height())

    def text(self) -> str:
        """Return the text."""
        return self.toPlainText()

    def setText(self, text: str) -> None:  # noqa: N802 - as a line edit has it
        """Show a text, which counts as not modified."""
        if text != self.toPlainText():
            self.setPlainText(text)
        self.setModified(False)

    def isModified(self) -> bool:  # noqa: N802 - as a line edit has it
        """Return whether the user has changed the text."""
        return self.document().isModified()

    def setModified(self, is_modified: bool) -> None:  # noqa: N802 - as a line edit has it
        """Set whether the text counts as changed by the user."""
        self.document().setModified(is_modified)

    def focusOutEvent(self, event: QFocusEvent) -> None:  # noqa: N802 - Qt's name
        super().focusOutEvent(event)
        if event.reason() != Qt.FocusReason.PopupFocusReason:
            self.finished.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802 - Qt's name
        is_enter = event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter)
        if is_enter and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self.finished.emit()
        else:
            super().keyPressEvent(event)
