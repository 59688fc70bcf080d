"""The docks around the outcrop: how they come, go, and are laid out by a table of places."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping

from PySide6.QtCore import QByteArray, QChildEvent, QEvent, QObject, Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu, QTabBar, QWidget

from vomstudio.ui.base.controls import LazyScrollArea, PanelScrollArea
from vomstudio.ui.shell.screens import bring_on_screen
from vomstudio.ui.shell.workspace_table import HOMES, Area, Places

_LAYOUT_VERSION = 5
_AREAS: dict[Area, Qt.DockWidgetArea] = {
    "left": Qt.DockWidgetArea.LeftDockWidgetArea,
    "right": Qt.DockWidgetArea.RightDockWidgetArea,
    "bottom": Qt.DockWidgetArea.BottomDockWidgetArea,
}


class WindowDocks(Mapping[str, QDockWidget]):
    """The docks of a window by their object names."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._docks: dict[str, QDockWidget] = {}
        self.own: frozenset[str] = frozenset()
        """Names of the docks that have a place of their own in the workspace that is shown; the
        others come as tabs."""
        left, right = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
        window.setCorner(Qt.Corner.BottomLeftCorner, left)
        window.setCorner(Qt.Corner.BottomRightCorner, right)
        self._whole_names = _WholeNames()
        window.installEventFilter(self._whole_names)

    def __getitem__(self, name: str) -> QDockWidget:
        return self._docks[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._docks)

    def __len__(self) -> int:
        return len(self._docks)

    def add(self, name: str, title: str, widget: QWidget, *, scrolls: bool = False) -> None:
        """scrolls : a long panel may be higher than the place that it is given"""
        self._add(name, title, PanelScrollArea(widget) if scrolls else widget)

    def add_later(self, name: str, title: str, make: Callable[[], QWidget]) -> None:
        """A panel that scrolls and is made when it is first seen."""
        self._add(name, title, LazyScrollArea(make))

    def _add(self, name: str, title: str, widget: QWidget) -> None:
        dock = QDockWidget(title, self._window)
        dock.setObjectName(name)
        dock.setWidget(widget)
        self._window.addDockWidget(_AREAS[HOMES[name]], dock)
        dock.hide()
        self._docks[name] = dock
        # Qt has shown it by then, where it has room.
        dock.toggleViewAction().triggered.connect(lambda on: self._come(name) if on else None)

    def fill_menu(self, menu: QMenu) -> None:
        """Each panel with a tick where it is shown."""
        for dock in self._docks.values():
            menu.addAction(dock.toggleViewAction())

    def watch(self, changed: Callable[[], None]) -> None:
        """Call `changed` whenever a dock comes, goes, moves or gets another size."""
        self._watcher = _Watcher(changed)
        for dock in self._docks.values():
            dock.installEventFilter(self._watcher)
            dock.dockLocationChanged.connect(lambda _: changed())
            dock.topLevelChanged.connect(lambda _: changed())
            dock.visibilityChanged.connect(lambda _: changed())

    # --- arrangement -------------------------------------------------------------------------
    def state(self) -> QByteArray:
        """What `restore` takes."""
        return self._window.saveState(self._version())

    def restore(self, state: QByteArray) -> bool:
        """Put the docks where they were; False where the state is not one of these docks."""
        done = self._window.restoreState(state, self._version())
        self.bring_on_screen()
        return done

    def _version(self) -> int:
        """An arrangement that was kept without a panel that came since would hide it for good."""
        return zlib.crc32(",".join(sorted(self._docks)).encode(), _LAYOUT_VERSION) & 0x7FFFFFFF

    def bring_on_screen(self) -> None:
        """Move floating docks that no screen shows to one."""
        for dock in self._docks.values():
            if dock.isFloating() and not dock.isHidden():
                bring_on_screen(dock)

    def arrange(self, places: Places) -> None:
        """Show the docks of a table of places and hide the others, each where it belongs."""
        for dock in self._docks.values():
            dock.setFloating(False)
            self._window.removeDockWidget(dock)
        listed = {name for stacks in places.values() for stack in stacks for name in stack}
        for area, side in _AREAS.items():
            stacks = places.get(area, ())
            for stack in stacks:
                for name in stack:
                    self._window.addDockWidget(side, self[name])
                    if name != stack[0]:
                        self._window.tabifyDockWidget(self[stack[0]], self[name])
                    self[name].show()
            for stack in stacks:
                self[stack[0]].raise_()
                # Sizes are given to what it needs.
                self._make(stack[0])
        # Hidden docks among tabs would leave a stray bar of tabs behind.
        for name in self._docks.keys() - listed:
            self._window.addDockWidget(_AREAS[HOMES[name]], self[name])
            self[name].hide()

    def give_sizes(self, places: Places, sizes: Mapping[Area, int], first_share: float) -> None:
        """sizes : width of the sides, height of the bottom, in pixels. first_share : of the upper
        stack of a side in its height"""
        wide, high = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        fronts = {area: [self[stack[0]] for stack in stacks] for area, stacks in places.items()}
        for area, first in fronts.items():
            if not first:
                continue
            if area == "bottom":
                self._window.resizeDocks(first[:1], [sizes[area]], high)
            else:
                self._window.resizeDocks(first[:1], [sizes[area]], wide)
                below = (1.0 - first_share) / max(1, len(first) - 1)
                heights = [first_share, *[below] * (len(first) - 1)]
                self._window.resizeDocks(first, [round(1000 * each) for each in heights], high)

    # --- coming and going --------------------------------------------------------------------
    def bring_forward(self, name: str) -> None:
        """Show a panel, in front of those that share its place."""
        if self[name].isHidden():
            self[name].show()
            self._join(name)
        self[name].raise_()
        self._make(name)

    def _make(self, name: str) -> None:
        """Whoever brings a panel forward may speak to it at once."""
        if isinstance(place := self[name].widget(), LazyScrollArea):
            place.widget()

    def _come(self, name: str) -> None:
        """Bring a dock that was chosen in the menu in front of those that share its place."""
        self._join(name)
        self[name].raise_()

    def _join(self, name: str) -> None:
        """Make a dock that has just come from elsewhere a tab of those that are there."""
        dock = self[name]
        if name in self.own or dock.isFloating() or self._window.tabifiedDockWidgets(dock):
            return
        area = self._window.dockWidgetArea(dock)
        for other in self._docks.values():
            there = not other.isHidden() and not other.isFloating() and other is not dock
            if there and self._window.dockWidgetArea(other) == area:
                self._window.tabifyDockWidget(other, dock)
                return

    def ensure_height(self, name: str, height: int) -> None:
        """Let a panel that is docked in the window be at least so high, in pixels."""
        dock = self[name]
        if dock.height() < height and dock.isVisible() and not dock.isFloating():
            self._window.resizeDocks([dock], [height], Qt.Orientation.Vertical)

    def hide_all(self) -> None:
        for dock in self._docks.values():
            dock.hide()


class _WholeNames(QObject):
    """Tabs of docks that share a place show their whole names, and arrows where they are too many:
    Qt cuts them to a letter or two."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.ChildPolished and isinstance(event, QChildEvent):
            tabs = event.child()
            if isinstance(tabs, QTabBar):
                tabs.setElideMode(Qt.TextElideMode.ElideNone)
        return False


class _Watcher(QObject):
    """Hears of the sizes that the user gives to docks by dragging what is between them."""

    def __init__(self, changed: Callable[[], None]) -> None:
        super().__init__()
        self._changed = changed

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Move):
            self._changed()
        return False
