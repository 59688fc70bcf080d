"""Panel of the trace tool: type and set of the next trace, live fit and vertices."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.base.controls import allow, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import (
    create_set_field,
    hint_label,
    lay_out_picking,
)
from vomstudio.ui.panels.tools.photo_follow_box import PhotoFollowBox
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.follow_box import FollowBox
from vomstudio.ui.widgets.type_box import TypeBox
from vomstudio.ui.widgets.vertex_table import VertexTable


class TracePanel(QWidget):
    """Panel that shows the state of the trace tool and sets the type and set."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#pick-a-trace")
        self._studio = studio
        self._tool = studio.tool_of(TraceTool)
        self.type_box = TypeBox(studio, geometry="plane")
        self.type_box.setObjectName("trace_type")
        self.type_box.currentIndexChanged.connect(self._apply_fields)
        self.set_edit = create_set_field(self._apply_fields)
        form = narrow_form()
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_edit)
        self.follow_box = FollowBox(studio, self._tool)
        form.addRow(tr("Follow"), self.follow_box)
        self.photo_follow_box = PhotoFollowBox(studio, self._tool)

        self.fit_view = FitView(actions)

        self.table = VertexTable(studio, self._tool)
        self.table.setObjectName("trace_vertices")

        self._hint = hint_label()
        lay_out_picking(
            panel=self,
            actions=actions,
            form=form,
            figures=self.fit_view,
            table=self.table,
            hint=self._hint,
            more_settings=[self.photo_follow_box],
        )
        # The box must be updated first, so it is connected first.
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.next_changed.connect(self._show_kind)

    def _apply_fields(self) -> None:
        self.set_edit.setModified(False)
        self._studio.set_next(str(self.type_box.currentData()), self.set_edit.text().strip())

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool = self._tool
        has_fit = tool.followed or len(tool.vertices) > 2
        measurement = tool.measurement if has_fit and not tool.searching else None
        self.fit_view.show_measurement(
            measurement, self._studio.settings.notation, local=not self._studio.north_known()
        )
        self.fit_view.setVisible(tool.open)
        self._hint.setText(
            ""
            if tool.open
            else tr(
                "Click along a bed, fault or fracture. Three points define a plane; a long, curved "
                "trace defines it well."
            )
        )
        self._hint.setVisible(not tool.open)
        self._show_kind()
        self.table.refresh()
        self.follow_box.refresh()
        self.photo_follow_box.refresh()

    def _show_kind(self) -> None:
        """Show the type and set of the open trace, or else of the next one.

        When a stored trace is continued, its type and set are edited among its properties instead.
        """
        trace, studio = self._tool.trace, self._studio
        type_id = trace.type_id if trace else studio.next_type_id
        set_name = trace.set_name if trace else studio.next_set
        self.type_box.select_type(type_id)
        if not self.set_edit.isModified():
            self.set_edit.setText(set_name)
        for field in (self.type_box, self.set_edit):
            allow(field, Finding("feature.continued") if self._tool.continued else None)


PANEL = TracePanel
