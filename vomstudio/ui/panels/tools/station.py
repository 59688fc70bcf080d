"""Panel of the station tool: kind, number and photos of the next station or sample."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QToolButton, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds.station import PHOTO_SEPARATOR, STATION_KINDS
from vomstudio.studio.tools.station import StationTool
from vomstudio.ui.base import file_filters, theme
from vomstudio.ui.base.controls import ComboBox, set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.picking_panel import PickingPanel


class StationPanel(PickingPanel[StationTool]):
    """Panel that shows the station tool and sets kind, number and photos of the next station."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        topic = "window.md#stations-contact-lines-and-rock-areas"
        super().__init__(studio, studio.get_tool(StationTool), topic)
        self.kind_box = ComboBox()
        self.kind_box.setObjectName("station_what")
        for station_kind, name in STATION_KINDS:
            self.kind_box.addItem(tr(name), station_kind)
        self.kind_box.activated.connect(self._apply_fields)
        self.number_edit, self.photo_edit = QLineEdit(), QLineEdit()
        self.number_edit.setPlaceholderText(tr("such as KB-17"))
        self.photo_edit.setPlaceholderText(tr("labels or files, separated by ;"))
        for edit in (self.number_edit, self.photo_edit):
            edit.editingFinished.connect(self._apply_fields)
        self.form.addRow(tr("Kind"), self.kind_box)
        self.form.addRow(tr("Number"), self.number_edit)
        self.form.addRow(tr("Photos"), self._create_photo_row())
        self._arrange_widgets(actions, QWidget())

    def _create_photo_row(self) -> QWidget:
        """Create the photo field and a button that opens the file dialog."""
        row = QWidget()
        layout = QHBoxLayout(row)
        layout.setContentsMargins(0, 0, 0, 0)
        self.browse = QToolButton()
        self.browse.setIcon(theme.icon("folder-open-outline"))
        self.browse.setToolTip(tr("Choose photo files."))
        self.browse.setAccessibleName(tr("Choose photo files."))
        self.browse.clicked.connect(self._browse)
        layout.addWidget(self.photo_edit)
        layout.addWidget(self.browse)
        return row

    def _browse(self) -> None:
        from PySide6.QtWidgets import QFileDialog

        paths, _ = QFileDialog.getOpenFileNames(
            self, tr("Photos of the station"), "", file_filters.photos()
        )
        if paths:
            names = filter(None, (self.photo_edit.text(), *paths))
            self.photo_edit.setText(PHOTO_SEPARATOR.join(names))
            self._apply_fields()

    def _apply_fields(self) -> None:
        self._tool.choose(
            what=str(self.kind_box.currentData()),
            number=self.number_edit.text().strip(),
            photo=self.photo_edit.text().strip(),
        )

    def refresh(self, *_: object) -> None:
        """Show the attributes of the open station, or else of the next one."""
        tool, station = self._tool, self._tool.feature or self._tool.next_station
        self.kind_box.setCurrentIndex(self.kind_box.findData(station.what))
        for edit, text in ((self.number_edit, station.number), (self.photo_edit, station.photo)):
            if edit.text() != text and not (edit.hasFocus() and edit.isModified()):
                edit.setText(text)
        reason = Finding("feature.continued") if tool.is_continued else None
        for field in (self.kind_box, self.number_edit, self.photo_edit, self.browse):
            set_enabled(field, reason)
        self._refresh_picking(
            tr(
                "Each click on the outcrop adds a station or sample. Numbers increase"
                " automatically; enter notes in Properties."
            )
        )


PANEL = StationPanel
