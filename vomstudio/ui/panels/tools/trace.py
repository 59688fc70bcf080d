"""Panel of the trace tool: type and set of the next trace, live fit and vertices."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.base.controls import set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import (
    create_set_field,
)
from vomstudio.ui.panels.tools.picking_panel import FollowingPanel
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.type_box import TypeBox


class TracePanel(FollowingPanel[TraceTool]):
    """Panel that shows the state of the trace tool and sets the type and set."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__(studio, studio.get_tool(TraceTool), "window.md#pick-a-trace")
        self.type_box = TypeBox(studio, geometry="plane")
        self.type_box.setObjectName("trace_type")
        self.type_box.currentIndexChanged.connect(self._apply_fields)
        self.set_name_edit = create_set_field(self._apply_fields)
        self.form.addRow(tr("Type"), self.type_box)
        self.form.addRow(tr("Set"), self.set_name_edit)
        self.fit_view = FitView(actions)
        self._arrange_widgets(actions, self.fit_view)
        studio.next_type_changed.connect(self._show_kind)

    def _apply_fields(self) -> None:
        self.set_name_edit.setModified(False)
        self._studio.set_next_type(
            str(self.type_box.currentData()), self.set_name_edit.text().strip()
        )

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool = self._tool
        has_fit = tool.is_path or len(tool.vertices) > 2
        measurement = tool.measurement if has_fit and not tool.is_searching else None
        self.fit_view.show_measurement(
            measurement, self._studio.settings.notation, is_local=not self._studio.is_north_known()
        )
        self.fit_view.setVisible(tool.is_open)
        self._show_kind()
        self._refresh_picking(
            tr(
                "Click along a bed, fault or fracture. Three points define a plane; a long, curved "
                "trace defines it well."
            )
        )

    def _show_kind(self) -> None:
        """Show the type and set of the open trace, or else of the next one.

        When a stored trace is continued, its type and set are edited among its properties instead.
        """
        trace, studio = self._tool.trace, self._studio
        type_id = trace.type_id if trace else studio.next_type_id
        set_name = trace.set_name if trace else studio.next_set
        self.type_box.select_type(type_id)
        if not self.set_name_edit.isModified():
            self.set_name_edit.setText(set_name)
        for field in (self.type_box, self.set_name_edit):
            set_enabled(field, Finding("feature.continued") if self._tool.is_continued else None)


PANEL = TracePanel
