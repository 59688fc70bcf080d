"""Bar below the drawer, with one button for each page of the workspace."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QMenu, QToolBar, QToolButton

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.layout import REGIONS
from vomstudio.ui.shell.workspaces import Workspaces


class DrawerBar(QToolBar):
    """Bar of buttons that open and close the pages of the drawer."""

    def __init__(self, docks: WindowDocks, workspaces: Workspaces) -> None:
        super().__init__(tr("Drawer"))
        self.setObjectName("drawer_bar")
        self.setMovable(False)
        if (layout := self.layout()) is not None:
            layout.setContentsMargins(2, 0, 2, 0)
        self.toggleViewAction().setVisible(False)
        self.setIconSize(QSize(14, 14))
        theme.highlight_toggles(self)
        self._docks, self._workspaces = docks, workspaces
        names = [name for name, region in REGIONS.items() if region == "drawer"]
        self.buttons = {name: self._button(name) for name in names}
        self._button_actions = {
            name: self.addWidget(button) for name, button in self.buttons.items()
        }
        self._more_button = QToolButton()
        self._more_button.setText(tr("More"))
        self._more_button.setToolTip(tr("Show all pages of the drawer"))
        self._more_button.setAutoRaise(True)
        self._more_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(self._more_button)
        for name in names:
            title = docks[name].windowTitle()
            menu.addAction(title).triggered.connect(
                lambda _=False, page=name: docks.bring_forward(page)
            )
        self._more_button.setMenu(menu)
        self.addWidget(self._more_button)
        docks.changed.connect(self.refresh)
        workspaces.changed.connect(self.refresh)
        self.refresh()

    def _button(self, name: str) -> QToolButton:
        button = QToolButton()
        button.setObjectName(f"drawer_{name}")
        button.setText(self._docks[name].windowTitle())
        button.setCheckable(True)
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        theme.highlight_toggles(button)
        button.clicked.connect(lambda is_checked: self._docks.toggle(name, is_checked))
        return button

    def refresh(self, *_: object) -> None:
        """Update the buttons: show workspace pages and open pages, and check the open ones."""
        offered_pages = self._workspaces.current_workspace.drawer
        for name, button in self.buttons.items():
            is_shown = self._docks.is_shown(name)
            self._button_actions[name].setVisible(name in offered_pages or is_shown)
            button.setChecked(is_shown)
