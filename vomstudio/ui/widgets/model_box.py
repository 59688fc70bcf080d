"""List of the models of the project whose files are open."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker

from vomstudio.project.records import Model
from vomstudio.ui.base.command_targets import current_model
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio


class ModelBox(ComboBox):
    """List of open models; the selected model stays selected while it is open."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.keep_narrow()

    def list_models(self) -> None:
        """List the open models; initially, the current model is selected."""
        studio = self._studio
        entries = [(m.name, m.id) for m in studio.session.of(Model) if m.id in studio.models]
        if [(self.itemText(i), self.itemData(i)) for i in range(self.count())] == entries:
            return
        previous = self.currentData()
        with QSignalBlocker(self):
            self.clear()
            for name, id_ in entries:
                self.addItem(name, id_)
            current = current_model(studio)
            index = self.findData(previous)
            if index < 0 and current is not None:
                index = self.findData(current.id)
            self.setCurrentIndex(max(index, 0) if entries else -1)

    def selected_model(self) -> Model | None:
        """Return the selected model, or None if no model is selected."""
        record = self._studio.records.get(str(self.currentData() or ""))
        is_open = isinstance(record, Model) and record.id in self._studio.models
        return record if isinstance(record, Model) and is_open else None
