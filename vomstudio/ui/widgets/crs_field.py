"""A field for a projected reference system, which is chosen by code, name or country."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QStringListModel, Qt
from PySide6.QtWidgets import QCompleter, QLineEdit, QListView

from vomstudio.core.words import tr
from vomstudio.io.gis.crs_names import NamedCrs, search_systems

_LEAST_LETTERS = 2


class CrsField(QLineEdit):
    """What is typed is looked for in codes, names and areas; choosing one writes its code.

    popup : the list of what was found
    """

    def __init__(self, code: str = "") -> None:
        super().__init__(code)
        self.setToolTip(tr("Code, name or country, such as “32633”, “UTM 33N” or “Iceland”."))
        self._found: list[NamedCrs] = []
        self._list = QStringListModel(self)
        self.popup = QListView()
        self.popup.setTextElideMode(Qt.TextElideMode.ElideRight)
        self._completer = QCompleter(self._list, self)
        self._completer.setPopup(self.popup)
        self._completer.setCompletionMode(QCompleter.CompletionMode.UnfilteredPopupCompletion)
        self._completer.setMaxVisibleItems(12)
        self._completer.setWidget(self)
        chosen = self._completer.activated[QModelIndex]  # type: ignore[index]  # Qt has two of the name
        chosen.connect(self._chosen)
        self.textEdited.connect(self._typed)

    def _typed(self, text: str) -> None:
        self._found = search_systems(text) if len(text.strip()) >= _LEAST_LETTERS else []
        # A whole code is no search: Enter is the dialog's then.
        if any(each.code.casefold() == text.strip().casefold() for each in self._found):
            self._found = []
        self._list.setStringList([f"{f.name}  ({f.code}; {f.area})" for f in self._found])
        if self._found:
            self._completer.complete()
        else:
            self.popup.hide()

    def _chosen(self, index: QModelIndex) -> None:
        self.setText(self._found[index.row()].code)
        # As when the code had been typed.
        self.textEdited.emit(self.text())
