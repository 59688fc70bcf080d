"""Choice of a plane, which is kept while other features are selected."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds import has_plane
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ElidedLabel, set_enabled
from vomstudio.ui.base.number_formatting import marked_attitude
from vomstudio.ui.base.studio import Studio


class PlaneChoice(QWidget):
    """Label of a plane, with buttons to use the selected plane and to clear it.

    Parameters
    ----------
    empty_text : str
        Text shown while no plane is set.

    Attributes
    ----------
    id : str
        Id of the plane, or "" if no plane is set.
    changed : Signal
        Emitted when the plane is set, cleared or deleted.
    """

    changed = Signal()

    def __init__(self, studio: Studio, name: str, empty_text: str) -> None:
        super().__init__()
        self._studio, self._empty_text = studio, empty_text
        self.setObjectName(name)
        self.id = ""
        self.label = ElidedLabel()
        self.take_button = QToolButton()
        self.take_button.setToolTip(tr("Use the selected plane."))
        self.take_button.setIcon(theme.icon("cursor-default-click-outline"))
        self.take_button.setAccessibleName(tr("Use selected"))
        self.take_button.clicked.connect(lambda _=False: self.use_selected_plane())
        self.clear_button = QToolButton()
        self.clear_button.setIcon(theme.icon("close"))
        self.clear_button.setAccessibleName(tr("None"))
        self.clear_button.setToolTip(tr("Clear the plane."))
        self.clear_button.clicked.connect(lambda _=False: self._choose(""))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(3)
        row.addWidget(self.label, 1)
        row.addWidget(self.take_button)
        row.addWidget(self.clear_button)
        studio.selection_changed.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        self.refresh()

    def use_selected_plane(self) -> None:
        if selected_plane_id := self._selected_plane_id():
            self._choose(selected_plane_id)

    def _selected_plane_id(self) -> str:
        studio = self._studio
        current = studio.selection.current if studio.has_project else None
        return current if current and has_plane(studio.records.get(current)) else ""

    def _choose(self, id_: str) -> None:
        self.id = id_
        self.refresh()
        self.changed.emit()

    def refresh(self) -> None:
        """Show the orientation of the plane, or clear the choice if the plane was deleted."""
        records = self._studio.records if self._studio.has_project else {}
        record = records.get(self.id)
        if self.id and (record is None or not has_plane(record)):
            self.id, record = "", None
            self.changed.emit()
        if record is None:
            self.label.setText(self._empty_text)
        else:
            measurements = self._studio.measured([self.id])[self.id]
            orientation = marked_attitude(measurements, self._studio.settings.notation)
            self.label.setText(f"{record.name or self.id}  {orientation}")
        set_enabled(
            self.take_button, None if self._selected_plane_id() else Finding("selection.no-plane")
        )
        self.clear_button.setVisible(record is not None)
