"""List of the planes of the project, with an entry for the selected plane."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Signal

from vomstudio.core.words import tr
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import has_plane
from vomstudio.ui.base.controls import ComboBox, escape_markup
from vomstudio.ui.base.number_formatting import natural_sort_key, orientation_text
from vomstudio.ui.base.studio import Studio

SELECTED = "*"


class PlaneBox(ComboBox):
    """List of planes.

    Parameters
    ----------
    empty_text : str or None
        Text of the entry for no plane, or None if a plane is required.
    follows_selection : bool
        Whether to start with the entry "selected". While the selection is not a plane (for
        example, a new feature), the last plane is kept.
    """

    plane_selected = Signal(str)  # id of a plane, empty for none

    def __init__(self, studio: Studio, empty_text: str | None, follows_selection: bool) -> None:
        super().__init__()
        self._studio = studio
        self._empty_text = empty_text
        self._last = ""
        self._plane_id = ""
        self._follows = follows_selection
        self.keep_narrow()
        self.activated.connect(self._activated)
        studio.selection_changed.connect(self._selected)
        studio.edited.connect(self._edited)
        studio.project_opened.connect(self._opened)
        studio.settings_changed.connect(self._settings_changed)
        self.show_plane("")

    def show_plane(self, plane_id: str) -> None:
        """Show a plane without emitting a signal."""
        self._plane_id = plane_id
        if plane_id != self._last:
            self._follows = self._follows and not plane_id
        self._fill([plane_id] if plane_id else [])

    def showPopup(self) -> None:  # noqa: N802
        """List all planes only when the popup opens, because there may be thousands."""
        features = self._studio.session.features()
        planes = sorted(
            (f for f in features if has_plane(f)), key=lambda f: natural_sort_key(f.name)
        )
        self._studio.measured(f.id for f in planes)
        self._fill([f.id for f in planes])
        super().showPopup()

    def _fill(self, ids: list[str]) -> None:
        with QSignalBlocker(self):
            self.clear()
            if self._empty_text is not None:
                self.addItem(self._empty_text, "")
            last = self._text(self._last) if self._last else tr("none yet")
            self.addItem(tr("selected: {plane}", plane=last), SELECTED)
            for id_ in ids:
                self.addItem(self._text(id_), id_)
            if self._follows and (not self._plane_id or self._plane_id == self._last):
                self.setCurrentIndex(self.findData(SELECTED))
            else:
                self.setCurrentIndex(self.findData(self._plane_id))
        self.setToolTip(escape_markup(self.currentText()))

    def _text(self, id_: str) -> str:
        record = self._studio.records.get(id_)
        if not has_plane(record) or record is None:
            return tr("a deleted plane")
        measured = self._studio.measured([id_])[id_]
        return f"{record.name}  {orientation_text(measured, self._studio.settings.notation)}"

    def _activated(self, index: int) -> None:
        data = str(self.itemData(index))
        self._follows = data == SELECTED
        self._plane_id = self._last if self._follows else data
        self.setToolTip(escape_markup(self.currentText()))
        self.plane_selected.emit(self._plane_id)

    def _selected(self, ids: tuple[str, ...]) -> None:
        records = self._studio.records
        last = next((i for i in reversed(ids) if has_plane(records.get(i))), None)
        if last is None or last == self._last:
            return
        self._last = last
        if self._follows:
            self._plane_id = self._last
            self.plane_selected.emit(self._last)
        self.show_plane(self._plane_id)

    def _edited(self, edit: Edit) -> None:
        if not {self._last, self._plane_id} & set(self._studio.affected(edit)):
            return
        if self._last and not has_plane(self._studio.records.get(self._last)):
            self._last = ""
            if self._follows:
                self._plane_id = ""
                self.plane_selected.emit("")
        self.show_plane(self._plane_id)

    def _settings_changed(self) -> None:
        self.show_plane(self._plane_id)

    def _opened(self) -> None:
        self._last = ""
        self.show_plane("")
