"""Title bars of the docks, with inspector tabs and buttons to float, enlarge and close."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtWidgets import QDockWidget, QHBoxLayout, QMenu, QSizePolicy, QToolButton, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ElidedLabel
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.shell.layout import INSPECTOR_TABS, REGIONS

_MARGIN = 2


class DockTitle(QWidget):
    """Title bar of a dock, with tabs in the inspector or else the name of the page."""

    def __init__(self, dock: QDockWidget, docks: Docks) -> None:
        super().__init__(dock)
        self._dock, self._docks = dock, docks
        self._name = dock.objectName()
        self._tabs: dict[str, QToolButton] = {}
        row = QHBoxLayout(self)
        row.setContentsMargins(_MARGIN, 2, 2, 2)
        row.setSpacing(0)
        if REGIONS[self._name] == "inspector":
            for name in (*INSPECTOR_TABS, *({self._name} - set(INSPECTOR_TABS))):
                self._tabs[name] = self._create_tab(name)
                row.addWidget(self._tabs[name])
        self._title = ElidedLabel()
        self._title.setText(dock.windowTitle())
        font = self._title.font()
        font.setBold(True)
        self._title.setFont(font)
        self._title.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        row.addWidget(self._title, 1)
        self._button_space = QWidget()
        self._button_space.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._button_space.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        row.addWidget(self._button_space, 1)
        if self._tabs:
            row.addWidget(self._pages_button())
        self._enlarge = self._button("arrow-expand", tr("Show in the centre (F12)"))
        self._enlarge.clicked.connect(lambda: docks.toggle_center(self._name))
        self._float_button = self._button("dock-window", tr("Float, or dock again"))
        self._float_button.clicked.connect(lambda: dock.setFloating(not dock.isFloating()))
        self._close = self._button("close", tr("Close"))
        self._close.clicked.connect(lambda: docks.close_page(self._name))
        for button in (self._enlarge, self._float_button, self._close):
            row.addWidget(button)
        dock.windowTitleChanged.connect(self._title.setText)
        dock.topLevelChanged.connect(self._refresh)
        self._refresh()

    def _create_tab(self, name: str) -> QToolButton:
        button = QToolButton()
        button.setObjectName(f"tab_{name}")
        button.setCheckable(True)
        button.setChecked(name == self._name)
        button.setAutoRaise(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        theme.highlight_toggles(button)
        button.clicked.connect(lambda: self._show_dock_page(name))
        return button

    def _show_dock_page(self, name: str) -> None:
        self._tabs[name].setChecked(name == self._name)
        self._docks.bring_forward(name)

    def _button(self, icon: str, text: str) -> QToolButton:
        button = QToolButton()
        button.setIcon(theme.icon(icon))
        button.setIconSize(QSize(14, 14))
        button.setAutoRaise(True)
        button.setToolTip(text)
        button.setAccessibleName(text)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        return button

    def _pages_button(self) -> QToolButton:
        button = self._button("dots-horizontal", tr("More pages"))
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        button.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        menu = QMenu(button)
        menu.aboutToShow.connect(lambda: self._fill(menu))
        button.setMenu(menu)
        return button

    def _fill(self, menu: QMenu) -> None:
        menu.clear()
        for name, title in self._docks.titles().items():
            if REGIONS[name] == "inspector" and name not in INSPECTOR_TABS:
                action = menu.addAction(title)
                action.triggered.connect(lambda _=False, page=name: self._docks.bring_forward(page))

    def _refresh(self, *_: object) -> None:
        is_floating = self._dock.isFloating()
        has_tabs = bool(self._tabs) and not is_floating
        for button in self._tabs.values():
            button.setVisible(has_tabs)
        self._title.setVisible(not has_tabs)
        self._button_space.setVisible(has_tabs)
        # The inspector is closed as a whole with its key.
        self._close.setVisible(is_floating or not self._tabs)
        self._enlarge.setVisible(not is_floating and not has_tabs)
        self._float_button.setIcon(theme.icon("dock-right" if is_floating else "dock-window"))

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Show:
            self.name_tabs()
        return super().event(event)

    def name_tabs(self) -> None:
        """Update the titles of the tabs, which change with the tool."""
        titles = self._docks.titles()
        for name, button in self._tabs.items():
            button.setText(titles.get(name, ""))
