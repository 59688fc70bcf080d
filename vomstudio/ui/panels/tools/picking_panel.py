"""Base class of the panels of tools that pick vertices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from vomstudio.core.words import tr
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.studio.tools.polyline import PolylineTool
from vomstudio.ui.base.controls import Label, action_buttons, narrow_form
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import END_COMMANDS, hint_label, narrow_column
from vomstudio.ui.panels.tools.photo_follow_box import PhotoFollowBox
from vomstudio.ui.widgets.follow_box import FollowBox
from vomstudio.ui.widgets.more_section import MoreSection
from vomstudio.ui.widgets.vertex_table import VertexTable

Tool = TypeVar("Tool", bound=PolylineTool[Any])

_EDITING_COMMANDS = ("edit_feature", "delete_vertex")


class PickingPanel(QWidget, Generic[Tool]):
    """Panel of a tool that picks vertices.

    Subclasses add rows to `form`, call `_arrange_widgets`, and implement `refresh`.

    Parameters
    ----------
    studio : Studio
    tool : PolylineTool
    topic : str
        Help page of the panel.
    """

    def __init__(self, studio: Studio, tool: Tool, topic: str) -> None:
        super().__init__()
        set_help_topic(self, topic)
        self._studio, self._tool = studio, tool
        self.form = narrow_form()
        self.table = VertexTable(studio, tool)
        self.table.setObjectName(f"{tool.name}_vertices")
        self._hint = hint_label()

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        raise NotImplementedError

    def _arrange_widgets(
        self,
        actions: Mapping[str, QAction],
        figures: QWidget,
        more_settings: Sequence[QWidget] = (),
    ) -> None:
        """Lay out the panel and keep it up to date.

        The vertices, `more_settings` and the commands for editing are in a collapsible section.
        """
        column = narrow_column(self)
        column.addLayout(self.form)
        column.addWidget(figures)
        column.addLayout(action_buttons([actions[name] for name in END_COMMANDS]))
        column.addWidget(self._hint)
        editing = action_buttons([actions[name] for name in _EDITING_COMMANDS])
        column.addWidget(MoreSection(*more_settings, self.table, editing), 1)
        column.addStretch()
        studio = self._studio
        # The boxes of the form are connected, and therefore updated, before.
        studio.project_opened.connect(self._follow_records)
        studio.edited.connect(self._follow_records)
        studio.tool_changed_signal.connect(self.refresh)

    def _follow_records(self, *_: object) -> None:
        self.refresh()

    def _refresh_picking(self, hint: str) -> None:
        """Show the vertices, and the hint while no feature is open."""
        self._hint.setText(hint)
        self._hint.setVisible(not self._tool.is_open)
        self.table.refresh()

    def _show_lines(self, figures: Label, lines: Sequence[str]) -> None:
        """Show the figures of the open feature as lines of text."""
        figures.setText("\n".join(lines))
        figures.setVisible(bool(lines))


FollowedTool = TypeVar("FollowedTool", bound=FollowingTool[Any])


class FollowingPanel(PickingPanel[FollowedTool]):
    """Panel of a tool whose lines may follow contacts."""

    def __init__(self, studio: Studio, tool: FollowedTool, topic: str) -> None:
        super().__init__(studio, tool, topic)
        self.follow_box = FollowBox(studio, tool)
        self.photo_follow_box = PhotoFollowBox(studio, tool)

    def _arrange_widgets(
        self,
        actions: Mapping[str, QAction],
        figures: QWidget,
        more_settings: Sequence[QWidget] = (),
    ) -> None:
        self.form.addRow(tr("Follow"), self.follow_box)
        super()._arrange_widgets(actions, figures, (*more_settings, self.photo_follow_box))

    def _refresh_picking(self, hint: str) -> None:
        super()._refresh_picking(hint)
        self.follow_box.refresh()
        self.photo_follow_box.refresh()
