"""Combo box of the feature types of the project."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QSignalBlocker

from vomstudio.project.edit import Edit
from vomstudio.project.records import FeatureType, get
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio


class TypeBox(ComboBox):
    """List of types; `currentData` is the id of a type.

    No signal is emitted when edits of the project change the list.

    Parameters
    ----------
    geometry : {"plane", "line"}, optional
        Geometry of the listed types; by default all types are listed. If the project has no such
        type, all types are listed.
    """

    def __init__(self, studio: Studio, geometry: Literal["plane", "line"] | None = None) -> None:
        super().__init__()
        self._studio, self._geometry = studio, geometry
        studio.project_opened.connect(self.fill)
        studio.edited.connect(self._follow_edit)
        if studio.has_project:
            self.fill()

    def fill(self) -> None:
        """List the types, keeping the selected type if it still exists."""
        previous, types = self.currentData(), self._studio.session.of(FeatureType)
        suitable_types = [type_ for type_ in types if self._geometry in (None, type_.geometry)]
        with QSignalBlocker(self):
            self.clear()
            for type_ in suitable_types or types:
                self._add(type_)
            self.select_type(previous)

    def set_geometry(self, geometry: Literal["plane", "line"] | None) -> None:
        """List the types of a geometry, or all types if None."""
        if geometry != self._geometry:
            self._geometry = geometry
            with QSignalBlocker(self):
                # The present type may have the other geometry.
                self.clear()
            self.fill()

    def _add(self, type_: FeatureType) -> None:
        self.addItem(theme.type_icon(type_.color, type_.symbol), type_.name, type_.id)

    def select_type(self, type_id: object) -> None:
        """Show a type, which is added to the list if it has another geometry."""
        with QSignalBlocker(self):
            if self.findData(type_id) < 0:
                type_ = get(self._studio.records, str(type_id), FeatureType)
                if type_ is not None:
                    self._add(type_)
            self.setCurrentIndex(max(0, self.findData(type_id)))

    def choose(self, row: int) -> None:
        """Select the type in a row, as the user does in the list."""
        self.setCurrentIndex(row)
        self.activated.emit(row)

    def _follow_edit(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self.fill()
