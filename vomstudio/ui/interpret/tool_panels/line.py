"""The panel of the line tool: what is made next, the plane it lies on, the live line."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFormLayout, QLabel, QLineEdit, QVBoxLayout, QWidget

from vomstudio.document.edit import Edit
from vomstudio.document.records import FeatureType
from vomstudio.tools.line import LineTool
from vomstudio.ui.common import theme
from vomstudio.ui.common.fit_view import FitView
from vomstudio.ui.common.plane_box import PlaneBox
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.vertex_table import VertexTable
from vomstudio.ui.common.widgets import ComboBox, action_buttons
from vomstudio.ui.common.wording import slip_names


class LinePanel(QWidget):
    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        self._studio = studio
        self._tool = studio.tool_of(LineTool)
        self.type_box = ComboBox()
        self.type_box.setObjectName("line_type")
        self.type_box.activated.connect(self._chosen)
        self.set_edit = QLineEdit()
        self.set_edit.setPlaceholderText(self.tr("none"))
        self.set_edit.editingFinished.connect(self._chosen)
        self.plane_box = PlaneBox(studio, self.tr("none"), follow=False)
        self.plane_box.setObjectName("line_plane")
        self.plane_box.chosen.connect(lambda id_: self._tool.choose(plane_id=id_))
        self.slip_box = ComboBox()
        self.slip_box.setObjectName("line_slip")
        for value, text in slip_names().items():
            self.slip_box.addItem(text, value)
        self.slip_box.keep_narrow()
        self.slip_box.activated.connect(self._chosen)
        self._form = form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(3)
        form.addRow(self.tr("Type"), self.type_box)
        form.addRow(self.tr("Set"), self.set_edit)
        form.addRow(self.tr("On plane"), self.plane_box)
        form.addRow(self.tr("Slip"), self.slip_box)
        self.fit_view = FitView(reasons_shown=2)
        self.table = VertexTable(studio, self._tool)
        self.table.setObjectName("line_vertices")
        self._hint = QLabel()
        self._hint.setWordWrap(True)
        names = ("finish", "cancel", "continue_trace", "delete_vertex")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.setSpacing(4)
        layout.addLayout(form)
        layout.addWidget(self.fit_view)
        layout.addWidget(self.table, 1)
        layout.addWidget(self._hint)
        layout.addStretch()
        layout.addLayout(action_buttons([actions[name] for name in names]))
        studio.project_opened.connect(self._fill_types)
        studio.edited.connect(self._edited)
        studio.tool_changed_signal.connect(self.refresh)

    def _fill_types(self) -> None:
        """Those that are lines by nature come first."""
        kinds = self._studio.session.of(FeatureType)
        with QSignalBlocker(self.type_box):
            self.type_box.clear()
            for kind in sorted(kinds, key=lambda k: k.geometry != "line"):
                self.type_box.addItem(theme.type_icon(kind.color, kind.symbol), kind.name, kind.id)
        if kinds and self.type_box.findData(self._tool.next.type_id) < 0:
            self._tool.choose(type_id=str(self.type_box.itemData(0)))
        self.refresh()

    def _edited(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self._fill_types()
        self.refresh()

    def _chosen(self) -> None:
        self.set_edit.setModified(False)
        self._tool.choose(
            type_id=str(self.type_box.currentData()),
            set_name=self.set_edit.text().strip(),
            slip=str(self.slip_box.currentData() or ""),
        )

    def refresh(self) -> None:
        tool, now = self._tool, self._tool.attributes
        measured = tool.measurement if len(tool.vertices) > 1 else None
        self.fit_view.show_measurement(
            measured, self._studio.settings.notation, local=not self._studio.north_known()
        )
        self.fit_view.setVisible(measured is not None)
        self._hint.setText(
            self.tr(
                "Choose Line (L), then click along a striation, a hinge or another lineation. Two "
                "points give its trend and plunge, more its error. On a plane it has a rake."
            )
        )
        self._hint.setVisible(not tool.open)
        with QSignalBlocker(self.type_box):
            self.type_box.setCurrentIndex(max(0, self.type_box.findData(now.type_id)))
        if not self.set_edit.isModified():
            self.set_edit.setText(now.set_name)
        self.plane_box.show_plane(now.plane_id)
        self.slip_box.setCurrentIndex(self.slip_box.findData(now.slip))
        why = (
            self.tr("Not now: a continued line keeps what it is; see Properties")
            if tool.continued
            else ""
        )
        for field in (self.type_box, self.set_edit, self.plane_box):
            field.setEnabled(not why)
            if field is not self.plane_box or why:
                field.setToolTip(why)
        if not why and not now.plane_id:
            why = self.tr("Not now: choose the plane it lies on first")
        self.slip_box.setEnabled(not why)
        self.slip_box.setToolTip(why or self.tr("How the hanging wall moved along the line"))
        self.table.refresh()


PANEL = LinePanel
