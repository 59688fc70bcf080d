"""Field for a projected coordinate reference system, by code, name or country."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QStringListModel, Qt
from PySide6.QtWidgets import QCompleter, QLineEdit, QListView

from vomstudio.core.words import tr
from vomstudio.io.gis.crs_names import NamedCrs, search_systems

_MIN_LETTERS = 2


class CrsField(QLineEdit):
    """Field that searches codes, names and areas; a selected match is replaced by its code.

    Attributes
    ----------
    popup : QListView
        List of matches.
    """

    def __init__(self, code: str = "") -> None:
        super().__init__(code)
        self.setToolTip(tr("Code, name or country, such as “32633”, “UTM 33N” or “Iceland”."))
        self._matches: list[NamedCrs] = []
        self._list = QStringListModel(self)
        self.popup = QListView()
        self.popup.setTextElideMode(Qt.TextElideMode.ElideRight)
        self._completer = QCompleter(self._list, self)
        self._completer.setPopup(self.popup)
        self._completer.setCompletionMode(QCompleter.CompletionMode.UnfilteredPopupCompletion)
        self._completer.setMaxVisibleItems(12)
        self._completer.setWidget(self)
        activated = self._completer.activated[QModelIndex]  # type: ignore[index]  # Qt has two of the name
        activated.connect(self._select)
        self.textEdited.connect(self._search)

    def _search(self, text: str) -> None:
        self._matches = search_systems(text) if len(text.strip()) >= _MIN_LETTERS else []
        # A complete code needs no popup, so that Enter accepts the dialog.
        if any(each.code.casefold() == text.strip().casefold() for each in self._matches):
            self._matches = []
        self._list.setStringList([f"{f.name}  ({f.code}; {f.area})" for f in self._matches])
        if self._matches:
            self._completer.complete()
        else:
            self.popup.hide()

    def _select(self, index: QModelIndex) -> None:
        self.setText(self._matches[index.row()].code)
        # Handled as if the user had typed the code.
        self.textEdited.emit(self.text())
