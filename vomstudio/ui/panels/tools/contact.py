"""Panel of the contact tool: type and set of the next contact line, and path following."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.length_figures import words
from vomstudio.studio.tools.contact import ContactTool
from vomstudio.ui.base.controls import allow, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import create_set_field, hint_label, lay_out_picking
from vomstudio.ui.panels.tools.photo_follow_box import PhotoFollowBox
from vomstudio.ui.widgets.follow_box import FollowBox
from vomstudio.ui.widgets.type_box import TypeBox
from vomstudio.ui.widgets.vertex_table import VertexTable


class ContactPanel(QWidget):
    """Panel that shows the contact tool and sets the type and set of the next line."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#stations-contact-lines-and-rock-areas")
        self._tool = studio.tool_of(ContactTool)
        self.type_box = TypeBox(studio, geometry="plane")
        self.type_box.setObjectName("contact_type")
        self.type_box.activated.connect(self._apply_fields)
        self.set_edit = create_set_field(self._apply_fields)
        self.follow_box = FollowBox(studio, self._tool)
        form = narrow_form()
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_edit)
        form.addRow(tr("Follow"), self.follow_box)
        self.photo_follow_box = PhotoFollowBox(studio, self._tool)
        self.figures = hint_label()
        self.table = VertexTable(studio, self._tool)
        self._hint = hint_label(
            tr(
                "Click along a contact or fault, then press Enter. The line has a length, but no"
                " plane."
            )
        )
        lay_out_picking(
            panel=self,
            actions=actions,
            form=form,
            figures=self.figures,
            table=self.table,
            hint=self._hint,
            more_settings=[self.photo_follow_box],
        )
        # The box must be updated first, so it is connected first.
        studio.project_opened.connect(self._types_changed)
        studio.edited.connect(self._types_changed)
        studio.tool_changed_signal.connect(self.refresh)

    def _types_changed(self, *_: object) -> None:
        if self.type_box.count() and self.type_box.findData(self._tool.next_contact.type_id) < 0:
            self._tool.choose(type_id=str(self.type_box.itemData(0)))
        self.refresh()

    def _apply_fields(self) -> None:
        self.set_edit.setModified(False)
        self._tool.choose(
            type_id=str(self.type_box.currentData()), set_name=self.set_edit.text().strip()
        )

    def refresh(self) -> None:
        """Show the current state of the tool."""
        tool, attributes = self._tool, self._tool.attributes
        measurement = tool.measurement
        lines = words(measurement) if measurement and measurement.dimension else []
        self.figures.setText("\n".join(lines))
        self.figures.setVisible(bool(lines))
        self.type_box.select_type(attributes.type_id)
        if not self.set_edit.isModified():
            self.set_edit.setText(attributes.set_name)
        for field in (self.type_box, self.set_edit):
            allow(field, Finding("feature.continued") if tool.continued else None)
        self._hint.setVisible(not tool.open)
        self.follow_box.refresh()
        self.photo_follow_box.refresh()
        self.table.refresh()


PANEL = ContactPanel
