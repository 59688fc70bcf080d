"""One panel for whatever tool is active: its content follows the tool."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QSizePolicy, QStackedWidget, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.controls import action_buttons
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, narrow_column

Panel = TypeVar("Panel", bound=QWidget)


class ActiveToolPanel(QStackedWidget):
    """Shows the panel of the active tool; while navigating that of the tool that has something
    open, else all tools to choose from. No tool makes the panel wider or higher than another."""

    def __init__(
        self, studio: Studio, panels: Mapping[str, QWidget], actions: Mapping[str, QAction]
    ) -> None:
        """panels : by the names of their tools"""
        super().__init__()
        self._studio, self.panels = studio, dict(panels)
        self._choice = _ToolChoice([actions[entry.name] for entry in TOOLS])
        self.addWidget(self._choice)
        for panel in dict.fromkeys(self.panels.values()):
            self.addWidget(panel)
        self._titles = {entry.name: entry.title for entry in TOOLS}
        self._told: Callable[[str], None] = lambda _: None
        # The dock begins as wide as the widest: it would grow, and move the outcrop, with a tool.
        self._take_size_of(self._choice, QSizePolicy.Policy.Preferred)
        studio.active_tool_changed.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.project_opened.connect(self.refresh)

    def tell_title(self, told: Callable[[str], None]) -> None:
        """told : called with the title for the dock whenever it changes"""
        self._told = told
        self.refresh()

    def panel(self, kind: type[Panel]) -> Panel:
        """The panel of a tool, by its class."""
        return next(panel for panel in self.panels.values() if isinstance(panel, kind))

    def refresh(self, *_: object) -> None:
        """Show the panel that goes with the tool as it is now."""
        name = self._studio.tool_name
        if name not in self.panels:
            unfinished = self._studio.open_tool
            name = "" if unfinished is None else unfinished.name
        shown = self.panels.get(name, self._choice)
        self._told(self._titles.get(name, tr("Tool")))
        if shown is self.currentWidget():
            return
        self._take_size_of(shown)
        self.setCurrentWidget(shown)

    def _take_size_of(
        self, shown: QWidget, width: QSizePolicy.Policy = QSizePolicy.Policy.Ignored
    ) -> None:
        """Or the highest panel would give all of them a scroll bar. width : of those not shown"""
        ignored, wanted = QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred
        for page in (self._choice, *self.panels.values()):
            if page is shown:
                page.setSizePolicy(wanted, wanted)
            else:
                page.setSizePolicy(width, ignored)


class _ToolChoice(QWidget):
    """The tools, while none is active."""

    def __init__(self, actions: list[QAction]) -> None:
        super().__init__()
        column: QVBoxLayout = narrow_column(self)
        column.addWidget(
            hint_label(tr("No tool is active: drag to orbit, click a feature to select it."))
        )
        column.addLayout(action_buttons(actions))
        column.addStretch()
