"""A choice among the models of the project whose files are open."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker

from vomstudio.project.records import Model
from vomstudio.ui.base.command_targets import current_model
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio


class ModelBox(ComboBox):
    """What was chosen stays chosen while it is there."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.keep_narrow()

    def list_models(self) -> None:
        """Those that there are now; at first the current one is chosen."""
        studio = self._studio
        there = [(m.name, m.id) for m in studio.session.of(Model) if m.id in studio.models]
        if [(self.itemText(i), self.itemData(i)) for i in range(self.count())] == there:
            return
        kept = self.currentData()
        with QSignalBlocker(self):
            self.clear()
            for name, id_ in there:
                self.addItem(name, id_)
            current = current_model(studio)
            at = self.findData(kept)
            if at < 0 and current is not None:
                at = self.findData(current.id)
            self.setCurrentIndex(max(at, 0) if there else -1)

    def selected_model(self) -> Model | None:
        """The chosen one, None where there is none."""
        record = self._studio.records.get(str(self.currentData() or ""))
        open_one = isinstance(record, Model) and record.id in self._studio.models
        return record if isinstance(record, Model) and open_one else None
