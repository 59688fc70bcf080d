"""Panel of the rock area tool: lithology of the next area, and path following."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds.lithology import CHOICES, words
from vomstudio.studio.tools.lithology import LithologyTool
from vomstudio.ui.base.controls import ComboBox, allow, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, lay_out_picking
from vomstudio.ui.panels.tools.photo_follow_box import PhotoFollowBox
from vomstudio.ui.widgets.follow_box import FollowBox
from vomstudio.ui.widgets.vertex_table import VertexTable


class LithologyPanel(QWidget):
    """Panel that shows the state of the rock area tool and sets the lithology."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#stations-contact-lines-and-rock-areas")
        self._tool = studio.tool_of(LithologyTool)
        self.lithology_box = ComboBox()
        self.lithology_box.setObjectName("lithology_word")
        for value, title in CHOICES:
            self.lithology_box.addItem(tr(title), value)
        self.lithology_box.setToolTip(tr("Lithologies of the StraboSpot list."))
        self.lithology_box.keep_narrow()
        self.lithology_box.activated.connect(self._apply_fields)
        self.follow_box = FollowBox(studio, self._tool)
        form = narrow_form()
        form.addRow(tr("Rock"), self.lithology_box)
        form.addRow(tr("Follow"), self.follow_box)
        self.photo_follow_box = PhotoFollowBox(studio, self._tool)
        self.figures = hint_label()
        self.table = VertexTable(studio, self._tool)
        self._hint = hint_label(
            tr(
                "Click around an area of a single rock, then press Enter. The area is measured on"
                " the surface inside the outline."
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
        for signal in (studio.project_opened, studio.edited, studio.tool_changed_signal):
            signal.connect(self.refresh)

    def _apply_fields(self) -> None:
        self._tool.choose(str(self.lithology_box.currentData() or ""))

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool = self._tool
        self.lithology_box.setCurrentIndex(self.lithology_box.findData(tool.lithology))
        if self.lithology_box.currentIndex() < 0:
            self.lithology_box.show_text(tool.lithology)
        allow(self.lithology_box, Finding("feature.continued") if tool.continued else None)
        measurement = tool.measurement
        lines = words(measurement) if measurement and measurement.dimension else []
        self.figures.setText("\n".join(lines))
        self.figures.setVisible(bool(lines))
        self._hint.setVisible(not tool.open)
        self.follow_box.refresh()
        self.photo_follow_box.refresh()
        self.table.refresh()


PANEL = LithologyPanel
