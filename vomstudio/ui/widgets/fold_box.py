"""Lists that filter the planes of the fold axis."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QHBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.options_form import OptionFields


class FoldBox(QWidget):
    """Lists for the quality and the set of the planes of the fold axis."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.options = OptionFields(FoldOptions, "fold")
        self.options.changed.connect(self._apply)
        self.set = ComboBox()
        self.set.keep_narrow()
        tooltip = tr("Use planes of this set for the fold axis.")
        self.set.setObjectName("fold_set")
        self.set.setToolTip(tooltip)
        self.set.setAccessibleName(tooltip)
        self.set.activated.connect(self._apply)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        for box in (*map(self.options.place, tuple(self.options.fields)), self.set):
            if isinstance(box, ComboBox):
                box.setMinimumContentsLength(6)
            row.addWidget(box, 1)
        connect_until_deleted(self, studio.fold.changed, self.refresh)
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        """Show the current filter and the existing sets."""
        fold = self._studio.fold
        names = fold.sets() if self._studio.has_project else []
        set_name = fold.fold_filter.set_name
        if set_name is not None and set_name not in names:
            names.append(set_name)
        with QSignalBlocker(self.set):
            self.set.clear()
            self.set.addItem(tr("All sets"), None)
            for name in names:
                self.set.addItem(name, name)
            self.set.setCurrentIndex(self.set.findData(set_name) if set_name is not None else 0)
        self.options.show_value("quality", fold.fold_filter.min_quality)

    def _apply(self, *_: object) -> None:
        fold = self._studio.fold
        fold_filter = FoldFilter(self.options.options().quality, self.set.currentData())
        fold.choose(fold_filter, is_selected=fold.is_selected)
