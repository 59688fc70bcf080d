"""The panel of the tool of contact lines: type and set of the next one, what it follows."""

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
from vomstudio.ui.panels.tools.common import hint_label, lay_out_picking, set_field
from vomstudio.ui.panels.tools.in_photos_box import InPhotosBox
from vomstudio.ui.widgets.follow_box import FollowBox
from vomstudio.ui.widgets.type_box import TypeBox
from vomstudio.ui.widgets.vertex_table import VertexTable


class ContactPanel(QWidget):
    """Shows the tool and sets type and set."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#stations-contact-lines-and-rock-areas")
        self._tool = studio.tool_of(ContactTool)
        self.type_box = TypeBox(studio)
        self.type_box.setObjectName("contact_type")
        self.type_box.activated.connect(self._chosen)
        self.set_edit = set_field(self._chosen)
        self.follow_box = FollowBox(studio, self._tool)
        form = narrow_form()
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_edit)
        form.addRow(tr("Follow"), self.follow_box)
        self.in_photos = InPhotosBox(studio, self._tool)
        form.addRow(self.in_photos)
        self.figures = hint_label()
        self.table = VertexTable(studio, self._tool)
        self._hint = hint_label(
            tr(
                "Click along a contact or fault, then press Enter. The line is kept as it was "
                "drawn: it has a length, and no plane."
            )
        )
        lay_out_picking(self, actions, form, self.figures, self.table, self._hint)
        # After the box, which follows them first.
        studio.project_opened.connect(self._types_changed)
        studio.edited.connect(self._types_changed)
        studio.tool_changed_signal.connect(self.refresh)

    def _types_changed(self, *_: object) -> None:
        if self.type_box.count() and self.type_box.findData(self._tool.next.type_id) < 0:
            self._tool.choose(type_id=str(self.type_box.itemData(0)))
        self.refresh()

    def _chosen(self) -> None:
        self.set_edit.setModified(False)
        self._tool.choose(
            type_id=str(self.type_box.currentData()), set_name=self.set_edit.text().strip()
        )

    def refresh(self) -> None:
        """Show the tool as it is now."""
        tool, now = self._tool, self._tool.attributes
        measured = tool.measurement
        lines = words(measured) if measured and measured.dimension else []
        self.figures.setText("\n".join(lines))
        self.figures.setVisible(bool(lines))
        self.type_box.select_type(now.type_id)
        if not self.set_edit.isModified():
            self.set_edit.setText(now.set_name)
        for field in (self.type_box, self.set_edit):
            allow(field, Finding("feature.continued") if tool.continued else None)
        self._hint.setVisible(not tool.open)
        self.follow_box.refresh()
        self.in_photos.refresh()
        self.table.refresh()


PANEL = ContactPanel
