"""Panel of the cell tool: mark that a click sets, and number of marked cells."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QToolButton, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.coverage.face_coverage import (
    EMPTY_MARK,
    INSPECTED_MARK,
    MARK_TITLES,
    UNINSPECTED_MARK,
    UNMEASURABLE_MARK,
)
from vomstudio.project.records import FaceGrid
from vomstudio.studio.tools.cells import CellsTool
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, narrow_column

MARKS = {
    INSPECTED_MARK: (
        "done",
        "check",
        "Q",
        to_translate("The cell was inspected, whether or not features were found."),
    ),
    EMPTY_MARK: ("empty", "circle-outline", "W", to_translate("The cell contains no features.")),
    UNMEASURABLE_MARK: (
        "unmeasurable",
        "cancel",
        "X",
        to_translate("Vegetation, debris, shadow or a hole prevents measurements."),
    ),
    UNINSPECTED_MARK: ("open", "help", "Z", to_translate("The cell has not been inspected.")),
}
"""Name, icon, key and tooltip of the command that sets each mark, by mark."""


class CellsPanel(QWidget):
    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        set_help_topic(self, "fractures.md#coverage")
        self._studio = studio
        self.count = hint_label()
        column = narrow_column(self)
        column.addWidget(
            hint_label(
                tr(
                    "Click cells of the grid. A second click removes a mark; a key marks the cell"
                    " under the cursor."
                )
            )
        )
        self.buttons = {}
        for mark, (name, *_) in MARKS.items():
            button = QToolButton()
            button.setDefaultAction(actions[f"mark_{name}"])
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            self.buttons[mark] = button
            column.addWidget(button)
        column.addWidget(self.count)
        column.addStretch()
        for signal in (studio.project_opened, studio.edited):
            signal.connect(self.refresh)

    def refresh(self, *_: object) -> None:
        from vomstudio.project.grid_edits import grid_marks

        grids = self._studio.session.of(FaceGrid)
        marks = "".join(grid_marks(grid) for grid in grids)
        self.count.setText(
            tr(
                "{count} of {all} cells are marked.",
                count=len(marks) - marks.count(UNINSPECTED_MARK),
                all=len(marks),
            )
            if grids
            else Finding("action.no-grid").message
        )


def commands(studio: Studio) -> list[Command]:
    tool = studio.get_tool(CellsTool)

    def marking_problem() -> Finding | None:
        if studio.tool_name != CellsTool.name:
            return Finding("action.needs-tool", tool=tr("Cells"))
        return None if studio.session.of(FaceGrid) else Finding("action.no-grid")

    def is_mark_active(mark: str) -> bool:
        return tool.mark == mark

    return [
        Command(
            f"mark_{name}",
            tr("Cell {mark}", mark=tr(MARK_TITLES[mark])),
            partial(tool.mark_hovered_cell, mark),
            icon=icon,
            shortcut=key,
            tip=tr(tooltip),
            disabled_reason=marking_problem,
            is_viewport_key=True,
            is_checked=partial(is_mark_active, mark),
        )
        for mark, (name, icon, key, tooltip) in MARKS.items()
    ]


PANEL = CellsPanel
COMMANDS = commands
