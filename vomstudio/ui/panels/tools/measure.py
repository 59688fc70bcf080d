"""Panel of the measure tool: kind of measurement, plane and live figures."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project.kinds.dimension import KINDS
from vomstudio.project.length_figures import words
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.ui.base.controls import ComboBox, rich_lines, set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label
from vomstudio.ui.panels.tools.picking_panel import PickingPanel
from vomstudio.ui.widgets.plane_box import PlaneBox

_HINTS = {
    "distance": to_translate(
        "Click two points to measure the distance between them, with horizontal and vertical"
        " components."
    ),
    "polyline": to_translate("Click along a line, then press Enter to measure its length."),
    "area": to_translate(
        "Click the corners of a polygon, then press Enter. The area is that of the"
        " polygon's largest projection onto a plane."
    ),
    "thickness": to_translate(
        "Choose a plane, then click the base and the top of the bed. The error is smallest if the"
        " line is perpendicular to the bed."
    ),
}


class MeasurePanel(PickingPanel[MeasureTool]):
    """Panel that shows the state of the measure tool and sets the kind and the plane."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__(studio, studio.get_tool(MeasureTool), "window.md#lines-and-lengths")
        self.kind_box = ComboBox()
        self.kind_box.setObjectName("measure_kind")
        for dimension_kind, name in KINDS:
            self.kind_box.addItem(tr(name), dimension_kind)
        self.kind_box.activated.connect(self._apply_fields)
        self.plane_box = PlaneBox(studio, None, includes_selection=True)
        self.plane_box.setObjectName("measure_plane")
        self.plane_box.plane_selected.connect(lambda id_: self._tool.choose(plane_id=id_))
        self.form.addRow(tr("Measure"), self.kind_box)
        self.form.addRow(tr("Across"), self.plane_box)
        self.figures = hint_label()
        self.figures.setTextFormat(Qt.TextFormat.RichText)
        self.figures.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._arrange_widgets(actions, self.figures)

    def _apply_fields(self) -> None:
        dimension_kind: Any = self.kind_box.currentData()
        self._tool.choose(kind=dimension_kind)

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool = self._tool
        with QSignalBlocker(self.kind_box):
            self.kind_box.setCurrentIndex(self.kind_box.findData(tool.kind))
        is_thickness = tool.kind == "thickness"
        self.form.setRowVisible(self.plane_box, is_thickness)
        if is_thickness:
            self.plane_box.show_plane(tool.plane_id)
        reason = Finding("measurement.continued") if tool.is_continued else None
        for field in (self.kind_box, self.plane_box):
            set_enabled(field, reason)
        measurement = tool.measurement
        lines = words(measurement) if measurement and measurement.dimension else []
        bold = lines[:1]
        if not lines and tool.measurement and tool.measurement.problem and len(tool.vertices) > 1:
            lines = [str(tool.measurement.problem)]
        self.figures.setText(rich_lines(lines, bold))
        self.figures.setVisible(bool(lines))
        self._refresh_picking(tr(_HINTS[tool.kind]))


PANEL = MeasurePanel
