"""A field for a projected reference system, which is chosen by code, name or country."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QStringListModel, Qt
from PySide6.QtWidgets import QCompleter, QLineEdit

from vomstudio.io.gis.crs_names import NamedCrs, matching
from vomstudio.words import tr

_LEAST_LETTERS = 2


class CrsField(QLineEdit):
    """What is typed is looked for in codes, names and areas; choosing one writes its code."""

    def __init__(self, code: str = "") -> None:
        super().__init__(code)
        self.setToolTip(tr("Code, name or country, such as “32633”, “UTM 33N” or “Iceland”."))
        self._found: list[NamedCrs] = []
        self._list = QStringListModel(self)
        self.completer_ = QCompleter(self._list, self)
        self.completer_.setCompletionMode(QCompleter.CompletionMode.UnfilteredPopupCompletion)
        self.completer_.setMaxVisibleItems(12)
        self.completer_.setWidget(self)
        self.completer_.popup().setTextElideMode(Qt.TextElideMode.ElideRight)
        self.completer_.activated[QModelIndex].connect(self._chosen)
        self.textEdited.connect(self._typed)

    def _typed(self, text: str) -> None:
        self._found = matching(text) if len(text.strip()) >= _LEAST_LETTERS else []
        if len(self._found) == 1 and self._found[0].code.casefold() == text.strip().casefold():
            self._found = []
        self._list.setStringList([f"{f.name}  ({f.code}; {f.area})" for f in self._found])
        if self._found:
            self.completer_.complete()
        else:
            self.completer_.popup().hide()

    def _chosen(self, index: QModelIndex) -> None:
        self.setText(self._found[index.row()].code)
        # As when the code had been typed.
        self.textEdited.emit(self.text())
