"""The panel of the tool of stations and samples: what the next click makes."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QToolButton, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds.station import STATION_KINDS
from vomstudio.studio.tools.station import StationTool
from vomstudio.ui.base import file_filters, theme
from vomstudio.ui.base.controls import ComboBox, allow, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, lay_out_picking
from vomstudio.ui.widgets.vertex_table import VertexTable


class StationPanel(QWidget):
    """Shows the tool and sets kind, number and photo of the next station."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#stations-contact-lines-and-rock-areas")
        self._tool = studio.tool_of(StationTool)
        self.what_box = ComboBox()
        self.what_box.setObjectName("station_what")
        for what, name in STATION_KINDS:
            self.what_box.addItem(tr(name), what)
        self.what_box.activated.connect(self._chosen)
        self.number_edit, self.photo_edit = QLineEdit(), QLineEdit()
        self.number_edit.setPlaceholderText(tr("such as KB-17"))
        self.photo_edit.setPlaceholderText(tr("its label or file"))
        for edit in (self.number_edit, self.photo_edit):
            edit.editingFinished.connect(self._chosen)
        form = narrow_form()
        form.addRow(tr("Make"), self.what_box)
        form.addRow(tr("Number"), self.number_edit)
        form.addRow(tr("Photo"), self._with_browser())
        self.table = VertexTable(studio, self._tool)
        self._hint = hint_label(
            tr(
                "Each click on the outcrop is a station or a sample. A number with digits goes on "
                "by itself; notes are written in Properties."
            )
        )
        lay_out_picking(self, actions, form, QWidget(), self.table, self._hint)
        for signal in (studio.project_opened, studio.edited, studio.tool_changed_signal):
            signal.connect(self.refresh)

    def _with_browser(self) -> QWidget:
        """The field of the photo, with a button that looks for its file."""
        row = QWidget()
        layout = QHBoxLayout(row)
        layout.setContentsMargins(0, 0, 0, 0)
        self.browse = QToolButton()
        self.browse.setIcon(theme.icon("folder-open-outline"))
        self.browse.setToolTip(tr("Choose the file of the photo."))
        self.browse.setAccessibleName(tr("Choose the file of the photo."))
        self.browse.clicked.connect(self._browse)
        layout.addWidget(self.photo_edit)
        layout.addWidget(self.browse)
        return row

    def _browse(self) -> None:
        from PySide6.QtWidgets import QFileDialog

        path, _ = QFileDialog.getOpenFileName(
            self, tr("Photo of the station"), "", file_filters.photos()
        )
        if path:
            self.photo_edit.setText(path)
            self._chosen()

    def _chosen(self) -> None:
        self._tool.choose(
            what=str(self.what_box.currentData()),
            number=self.number_edit.text().strip(),
            photo=self.photo_edit.text().strip(),
        )

    def refresh(self, *_: object) -> None:
        """Show what is made next."""
        tool, now = self._tool, self._tool.feature or self._tool.next
        self.what_box.setCurrentIndex(self.what_box.findData(now.what))
        for edit, text in ((self.number_edit, now.number), (self.photo_edit, now.photo)):
            if edit.text() != text and not (edit.hasFocus() and edit.isModified()):
                edit.setText(text)
        why = Finding("feature.continued") if tool.continued else None
        for field in (self.what_box, self.number_edit, self.photo_edit, self.browse):
            allow(field, why)
        self._hint.setVisible(not tool.open)
        self.table.refresh()


PANEL = StationPanel
