"""A combo box of the project's feature types that follows every edit of them."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker

from vomstudio.project.edit import Edit
from vomstudio.project.records import FeatureType
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio


class TypeBox(ComboBox):
    """`currentData` is a type's id. It says nothing of changes that the project makes in it."""

    def __init__(self, studio: Studio, *, lines_first: bool = False) -> None:
        """lines_first : types that are lines by nature stand above the others"""
        super().__init__()
        self._studio, self._lines_first = studio, lines_first
        studio.project_opened.connect(self.fill)
        studio.edited.connect(self._edited)
        if studio.has_project:
            self.fill()

    def fill(self) -> None:
        """The same type stays chosen where it is still there."""
        chosen, kinds = self.currentData(), self._studio.session.of(FeatureType)
        if self._lines_first:
            kinds.sort(key=lambda kind: kind.geometry != "line")
        with QSignalBlocker(self):
            self.clear()
            for kind in kinds:
                self.addItem(theme.type_icon(kind.color, kind.symbol), kind.name, kind.id)
            self.select_type(chosen)

    def select_type(self, type_id: object) -> None:
        with QSignalBlocker(self):
            self.setCurrentIndex(max(0, self.findData(type_id)))

    def _edited(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self.fill()
