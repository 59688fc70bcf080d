"""Panel of the contact tool: type and set of the next contact line, and path following."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.length_figures import words
from vomstudio.studio.tools.contact import ContactTool
from vomstudio.ui.base.controls import set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import create_set_field, hint_label
from vomstudio.ui.panels.tools.picking_panel import FollowingPanel
from vomstudio.ui.widgets.type_box import TypeBox


class ContactPanel(FollowingPanel[ContactTool]):
    """Panel that shows the contact tool and sets the type and set of the next line."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        topic = "window.md#stations-contact-lines-and-rock-areas"
        super().__init__(studio, studio.get_tool(ContactTool), topic)
        self.type_box = TypeBox(studio, geometry="plane")
        self.type_box.setObjectName("contact_type")
        self.type_box.activated.connect(self._apply_fields)
        self.set_name_edit = create_set_field(self._apply_fields)
        self.form.addRow(tr("Type"), self.type_box)
        self.form.addRow(tr("Set"), self.set_name_edit)
        self.figures = hint_label()
        self._arrange_widgets(actions, self.figures)

    def _follow_records(self, *_: object) -> None:
        if self.type_box.count() and self.type_box.findData(self._tool.next_contact.type_id) < 0:
            self._tool.choose(type_id=str(self.type_box.itemData(0)))
        self.refresh()

    def _apply_fields(self) -> None:
        self.set_name_edit.setModified(False)
        self._tool.choose(
            type_id=str(self.type_box.currentData()), set_name=self.set_name_edit.text().strip()
        )

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool, attributes = self._tool, self._tool.attributes
        measurement = tool.measurement
        lines = words(measurement) if measurement and measurement.dimension else []
        self._show_lines(self.figures, lines)
        self.type_box.select_type(attributes.type_id)
        if not self.set_name_edit.isModified():
            self.set_name_edit.setText(attributes.set_name)
        for field in (self.type_box, self.set_name_edit):
            set_enabled(field, Finding("feature.continued") if tool.is_continued else None)
        self._refresh_picking(
            tr(
                "Click along a contact or fault, then press Enter. The line has a length, but no"
                " plane."
            )
        )


PANEL = ContactPanel
