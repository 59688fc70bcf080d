"""Panel of the rock area tool: lithology of the next area, and path following."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds.lithology import CHOICES, words
from vomstudio.studio.tools.lithology import LithologyTool
from vomstudio.ui.base.controls import ComboBox, set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label
from vomstudio.ui.panels.tools.picking_panel import FollowingPanel


class LithologyPanel(FollowingPanel[LithologyTool]):
    """Panel that shows the state of the rock area tool and sets the lithology."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        topic = "window.md#stations-contact-lines-and-rock-areas"
        super().__init__(studio, studio.get_tool(LithologyTool), topic)
        self.lithology_box = ComboBox()
        self.lithology_box.setObjectName("lithology_word")
        for value, title in CHOICES:
            self.lithology_box.addItem(tr(title), value)
        self.lithology_box.setToolTip(tr("Lithologies from the StraboSpot list."))
        self.lithology_box.keep_narrow()
        self.lithology_box.activated.connect(self._apply_fields)
        self.form.addRow(tr("Rock"), self.lithology_box)
        self.figures = hint_label()
        self._arrange_widgets(actions, self.figures)

    def _apply_fields(self) -> None:
        self._tool.choose(str(self.lithology_box.currentData() or ""))

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool = self._tool
        self.lithology_box.setCurrentIndex(self.lithology_box.findData(tool.lithology))
        if self.lithology_box.currentIndex() < 0:
            self.lithology_box.show_text(tool.lithology)
        set_enabled(self.lithology_box, Finding("feature.continued") if tool.is_continued else None)
        measurement = tool.measurement
        lines = words(measurement) if measurement and measurement.dimension else []
        self._show_lines(self.figures, lines)
        self._refresh_picking(
            tr(
                "Click around an area of a single rock type, then press Enter. The area is measured"
                " on the surface inside the outline."
            )
        )


PANEL = LithologyPanel
