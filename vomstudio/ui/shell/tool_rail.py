"""Tool rail on the left of the outcrop."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QToolBar, QToolButton

from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.layout import GENERAL_TOOLS, PAGE_TOOLS
from vomstudio.ui.shell.workspaces import Workspaces

_ICON_PX, _MIN_ICON_PX = 22, 12
_MARGIN_PX = 17
"""Height of a button in addition to its icon and text."""
_PADDING_PX = 7
_NAVIGATE = "navigate"
SHORT_NAMES = {
    "station": to_translate("Station"),
    "contact": to_translate("Contact"),
    "lithology": to_translate("Rock"),
    "control": to_translate("Control"),
    "known_line": to_translate("Lines"),
}
"""Short labels of the tools whose names are too long for the rail."""


class ToolRail(QToolBar):
    """Tool rail with one button per tool; some tools appear only in their workspace."""

    def __init__(
        self,
        studio: Studio,
        actions: Mapping[str, QAction],
        workspaces: Workspaces,
        docks: WindowDocks,
    ) -> None:
        super().__init__(tr("Tools"))
        self.setObjectName("tool_rail")
        self.setOrientation(Qt.Orientation.Vertical)
        self.setMovable(False)
        if (layout := self.layout()) is not None:
            layout.setContentsMargins(0, 0, 0, 0)
        self.toggleViewAction().setVisible(False)
        self._studio, self._workspaces, self._docks = studio, workspaces, docks
        names = [entry.name for entry in TOOLS]
        self._names = [*GENERAL_TOOLS, *(n for n in names if n not in GENERAL_TOOLS)]
        self.buttons = {name: self._button(actions[name]) for name in (_NAVIGATE, *self._names)}
        self._button_actions = {
            name: self.addWidget(button) for name, button in self.buttons.items()
        }
        general_buttons = [self.buttons[name] for name in (_NAVIGATE, *GENERAL_TOOLS)]
        text = max(self.fontMetrics().horizontalAdvance(b.text()) for b in general_buttons)
        width = text + 2 * _PADDING_PX
        for button in self.buttons.values():
            button.setFixedWidth(width)
        studio.active_tool_changed.connect(self.refresh)
        workspaces.changed.connect(self.refresh)
        docks.changed.connect(self.refresh)
        self.refresh()

    @staticmethod
    def _button(action: QAction) -> QToolButton:
        button = QToolButton()
        action.setIconText(tr(SHORT_NAMES.get(action.objectName(), "")) or action.iconText())
        button.setDefaultAction(action)
        button.setObjectName(f"rail_{action.objectName()}")
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        button.setAutoRaise(True)
        theme.highlight_toggles(button)
        return button

    def visible_tools(self) -> list[str]:
        """Return the names of the tools for the present task, in order."""
        task = (
            *self._workspaces.current_workspace.tools,
            *PAGE_TOOLS.get(self._docks.page("drawer"), ()),
            *PAGE_TOOLS.get(self._docks.center_page, ()),
            self._studio.tool_name,
        )
        return [name for name in self._names if name in GENERAL_TOOLS or name in task]

    def refresh(self, *_: object) -> None:
        """Show the buttons of the tools for the present task."""
        visible_tools = self.visible_tools()
        for name in self._names:
            self._button_actions[name].setVisible(name in visible_tools)
        self._fit()

    def _fit(self) -> None:
        """Use smaller icons if the rail is too short for all offered tools."""
        text_height = self.fontMetrics().height() + _MARGIN_PX
        layout = self.layout()
        spacing = 0 if layout is None else layout.spacing()
        available_height = (self.height() + spacing) // (1 + len(self.visible_tools())) - spacing
        icon_size = max(_MIN_ICON_PX, min(available_height - text_height, _ICON_PX))
        height = text_height + icon_size
        for button in self.buttons.values():
            button.setIconSize(QSize(icon_size, icon_size))
            button.setFixedHeight(height)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        # Before Qt hides the buttons that do not fit.
        self._fit()
        super().resizeEvent(event)
