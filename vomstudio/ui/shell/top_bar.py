"""Right end of the menu bar, with workspaces, search and the view history."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QMainWindow, QSizePolicy, QToolButton, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import Command
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.layout import WORKSPACES
from vomstudio.ui.shell.workspaces import Workspaces

_ICON_PX = 16
_MIN_TEXT_WIDTH_PX = 1250
_TEXT_BESIDE_ICON, _ICON_ONLY = (
    Qt.ToolButtonStyle.ToolButtonTextBesideIcon,
    Qt.ToolButtonStyle.ToolButtonIconOnly,
)


def commands(workspaces: Workspaces, docks: WindowDocks) -> list[Command]:
    """Return a command for each workspace, and the commands that arrange pages."""

    def show(name: str) -> Command:
        workspace = next(item for item in WORKSPACES if item.name == name)
        number = WORKSPACES.index(workspace) + 1
        return Command(
            f"workspace_{name}",
            tr("Workspace {number}: {name}", number=f"&{number}", name=tr(workspace.title)),
            lambda: workspaces.switch(name),
            workspace.icon,
            f"Ctrl+{number}",
            tr(workspace.purpose),
            is_checked=lambda: workspaces.current_workspace is workspace,
        )

    def toggle_page() -> None:
        docks.toggle_center(docks.center_page or docks.focused_page())

    def dock_net() -> None:
        docks.dock_net(not docks.is_net_docked)

    return [
        *(show(workspace.name) for workspace in WORKSPACES),
        Command(
            "page_in_center",
            tr("Page in &centre"),
            toggle_page,
            "arrow-expand",
            "F12",
            tr("Show the active page in the centre, or put it back."),
        ),
        Command(
            "dock_net",
            tr("&Dock net"),
            dock_net,
            None,
            (),
            tr("Show the stereonet in a dock instead of over the outcrop."),
            is_checked=lambda: docks.is_net_docked,
        ),
        Command(
            "second_view",
            tr("Second view"),
            lambda: docks.toggle("second_view", not docks.is_shown("second_view")),
            "view-split-vertical",
            "F7",
            tr("Show the outcrop in a second view, such as from another direction."),
            is_checked=lambda: docks.is_shown("second_view"),
        ),
        Command(
            "reset_panels",
            tr("&Reset layout"),
            workspaces.reset,
            "view-dashboard-outline",
            (),
            tr("Return to the initial layout of this workspace."),
        ),
    ]


def command_names() -> list[str]:
    """Return the names of the workspace commands, in order."""
    return [f"workspace_{workspace.name}" for workspace in WORKSPACES]


class TopBar(QWidget):
    """Buttons beside the menu bar; the search button has no text in narrow windows."""

    def __init__(self, window: QMainWindow, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self.setObjectName("top_bar")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 6, 0)
        row.setSpacing(2)
        self.setSizePolicy(QSizePolicy.Policy.Minimum, QSizePolicy.Policy.Preferred)
        self.workspaces: dict[str, QToolButton] = {}
        for workspace, name in zip(WORKSPACES, command_names(), strict=True):
            actions[name].setIconText(tr(workspace.title))
            button = self._button(actions[name], Qt.ToolButtonStyle.ToolButtonTextOnly)
            self.workspaces[workspace.name] = button
            row.addWidget(button)
        row.addSpacing(12)
        self.search = self._button(actions["find_command"], _TEXT_BESIDE_ICON)
        actions["find_command"].setIconText(tr("Search (Ctrl+K)"))
        row.addWidget(self.search)
        for name in ("undo", "redo", "view_back", "view_forward", "home"):
            row.addWidget(self._button(actions[name], _ICON_ONLY))
        self._menu_bar = window.menuBar()
        self._menu_bar.setCornerWidget(self, Qt.Corner.TopRightCorner)
        window.installEventFilter(self)

    @staticmethod
    def _button(action: QAction, style: Qt.ToolButtonStyle) -> QToolButton:
        button = QToolButton()
        button.setDefaultAction(action)
        button.setToolButtonStyle(style)
        button.setIconSize(QSize(_ICON_PX, _ICON_PX))
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        theme.highlight_toggles(button)
        return button

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Resize and isinstance(watched, QWidget):
            style = _ICON_ONLY if watched.width() < _MIN_TEXT_WIDTH_PX else _TEXT_BESIDE_ICON
            if self.search.toolButtonStyle() != style:
                self.search.setToolButtonStyle(style)
                self.adjustSize()
                # The menu bar places its corner only when it is set.
                self._menu_bar.setCornerWidget(self, Qt.Corner.TopRightCorner)
        return False
