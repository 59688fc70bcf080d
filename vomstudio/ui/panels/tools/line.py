"""Panel of the line tool: attributes of the next line, its plane and the live fit."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.line import LineTool
from vomstudio.ui.base.controls import ComboBox, set_enabled
from vomstudio.ui.base.number_formatting import slip_names
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import (
    create_set_field,
)
from vomstudio.ui.panels.tools.picking_panel import PickingPanel
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.plane_box import PlaneBox
from vomstudio.ui.widgets.type_box import TypeBox


class LinePanel(PickingPanel[LineTool]):
    """Panel that shows the state of the line tool and sets the attributes of the next line."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__(studio, studio.get_tool(LineTool), "window.md#lines-and-lengths")
        self.type_box = TypeBox(studio, geometry="line")
        self.type_box.setObjectName("line_type")
        self.type_box.activated.connect(self._apply_fields)
        self.set_name_edit = create_set_field(self._apply_fields)
        self.plane_box = PlaneBox(studio, tr("none"), includes_selection=False)
        self.plane_box.setObjectName("line_plane")
        self.plane_box.plane_selected.connect(lambda id_: self._tool.choose(plane_id=id_))
        self.slip_box = ComboBox()
        self.slip_box.setObjectName("line_slip")
        self.slip_box.setToolTip(tr("Movement of the hanging wall along the line."))
        for value, text in slip_names().items():
            self.slip_box.addItem(text, value)
        self.slip_box.keep_narrow()
        self.slip_box.activated.connect(self._apply_fields)
        self.form.addRow(tr("Type"), self.type_box)
        self.form.addRow(tr("Set"), self.set_name_edit)
        self.form.addRow(tr("On plane"), self.plane_box)
        self.form.addRow(tr("Slip"), self.slip_box)
        self.fit_view = FitView(actions)
        self._arrange_widgets(actions, self.fit_view)

    def _follow_records(self, *_: object) -> None:
        if self.type_box.count() and self.type_box.findData(self._tool.next_line.type_id) < 0:
            self._tool.choose(type_id=str(self.type_box.itemData(0)))
        self.refresh()

    def _apply_fields(self) -> None:
        self.set_name_edit.setModified(False)
        self._tool.choose(
            type_id=str(self.type_box.currentData()),
            set_name=self.set_name_edit.text().strip(),
            slip=str(self.slip_box.currentData() or ""),
        )

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool, attributes = self._tool, self._tool.attributes
        measurement = tool.measurement if len(tool.vertices) > 1 else None
        self.fit_view.show_measurement(
            measurement, self._studio.settings.notation, is_local=not self._studio.is_north_known()
        )
        self.fit_view.setVisible(measurement is not None)
        self.type_box.select_type(attributes.type_id)
        if not self.set_name_edit.isModified():
            self.set_name_edit.setText(attributes.set_name)
        self.plane_box.show_plane(attributes.plane_id)
        self.slip_box.setCurrentIndex(self.slip_box.findData(attributes.slip))
        reason = Finding("feature.continued") if tool.is_continued else None
        for field in (self.type_box, self.set_name_edit, self.plane_box):
            set_enabled(field, reason)
        if reason is None and not attributes.plane_id:
            reason = Finding("slip.no-plane")
        set_enabled(self.slip_box, reason)
        self._refresh_picking(
            tr(
                "Click along a lineation. Two points give trend and plunge; more points also give"
                " their error. On a plane, the line also has a rake."
            )
        )


PANEL = LinePanel
