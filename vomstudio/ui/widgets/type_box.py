"""Combo box of the feature types of the project."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker

from vomstudio.project.edit import Edit
from vomstudio.project.records import FeatureType
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio


class TypeBox(ComboBox):
    """List of types; `currentData` is the id of a type.

    No signal is emitted when edits of the project change the list.

    Parameters
    ----------
    lines_first : bool
        Whether types of lines are listed before the others.
    """

    def __init__(self, studio: Studio, *, lines_first: bool = False) -> None:
        super().__init__()
        self._studio, self._lines_first = studio, lines_first
        studio.project_opened.connect(self.fill)
        studio.edited.connect(self._edited)
        if studio.has_project:
            self.fill()

    def fill(self) -> None:
        """List the types, keeping the selected type if it still exists."""
        previous, types = self.currentData(), self._studio.session.of(FeatureType)
        if self._lines_first:
            types.sort(key=lambda type_: type_.geometry != "line")
        with QSignalBlocker(self):
            self.clear()
            for type_ in types:
                self.addItem(theme.type_icon(type_.color, type_.symbol), type_.name, type_.id)
            self.select_type(previous)

    def select_type(self, type_id: object) -> None:
        with QSignalBlocker(self):
            self.setCurrentIndex(max(0, self.findData(type_id)))

    def choose(self, row: int) -> None:
        """Select the type in a row, as the user does in the list."""
        self.setCurrentIndex(row)
        self.activated.emit(row)

    def _edited(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self.fill()
