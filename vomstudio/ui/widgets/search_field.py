"""Text field with a list of matches below it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QModelIndex, QStringListModel, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QCompleter, QLineEdit, QListView

Match = tuple[str, str]
"""Line of the list, and the text that it inserts into the field."""


class SearchField(QLineEdit):
    """Field with a list of matches of its text; a selected match replaces the text.

    The list opens when the user types or presses the Down key. Enter accepts the selected match.

    Parameters
    ----------
    search : callable
        Returns the matches of a text, the best first.
    text : str
        Initial text.

    Attributes
    ----------
    popup : QListView
        List of matches.
    """

    def __init__(self, search: Callable[[str], Sequence[Match]], text: str = "") -> None:
        super().__init__(text)
        self._search = search
        self._matches: Sequence[Match] = ()
        self._list = QStringListModel(self)
        self.popup = QListView()
        self.popup.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.popup.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._completer = QCompleter(self._list, self)
        self._completer.setPopup(self.popup)
        self._completer.setCompletionMode(QCompleter.CompletionMode.UnfilteredPopupCompletion)
        self._completer.setMaxVisibleItems(12)
        self._completer.setWidget(self)
        activated = self._completer.activated[QModelIndex]  # type: ignore[index]  # overloaded
        activated.connect(self._select)
        self.textEdited.connect(self._show_matches)

    def _show_matches(self, text: str) -> None:
        self._matches = self._search(text)
        # A complete text needs no list, so that Enter accepts the dialog.
        if any(entry.casefold() == text.strip().casefold() for _, entry in self._matches):
            self._matches = ()
        self._list.setStringList([line for line, _ in self._matches])
        if self._matches:
            self._completer.complete()
        else:
            self.popup.hide()

    def _select(self, index: QModelIndex) -> None:
        self.setText(self._matches[index.row()][1])
        # Handled as if the user had typed the text.
        self.textEdited.emit(self.text())

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        if event.key() != Qt.Key.Key_Down or self.popup.isVisible():
            super().keyPressEvent(event)
            return
        self._show_matches(self.text())
        if self._matches:
            self.popup.setCurrentIndex(self._list.index(0))
