"""The docks around the outcrop: where they stand at first, and how they come and go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from PySide6.QtCore import QByteArray, Qt, QTimer
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu, QWidget

_LAYOUT_VERSION = 4

# From left to right, each in front of those that share its place with it.
_TABBED = (
    ("stereonet", "view"),
    ("view", "display"),
    ("table", "photos"),
    ("photos", "in_photos"),
    ("in_photos", "jobs"),
    ("jobs", "messages"),
)
_IN_FRONT = ("trace", "stereonet", "table")


class WindowDocks(Mapping[str, QDockWidget]):
    """The docks of a window by their object names."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._docks: dict[str, QDockWidget] = {}
        self._behind: dict[str, str] = {}
        self._put_away: QByteArray | None = None
        left, right = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
        window.setCorner(Qt.Corner.BottomLeftCorner, left)
        window.setCorner(Qt.Corner.BottomRightCorner, right)

    def __getitem__(self, name: str) -> QDockWidget:
        return self._docks[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._docks)

    def __len__(self) -> int:
        return len(self._docks)

    def add(
        self,
        area: Qt.DockWidgetArea,
        name: str,
        title: str,
        widget: QWidget,
        behind: str | None = None,
    ) -> None:
        """behind : the dock that is in front of this one, in the same place, at first"""
        dock = QDockWidget(title, self._window)
        dock.setObjectName(name)
        dock.setWidget(widget)
        self._window.addDockWidget(area, dock)
        self._docks[name] = dock
        if behind is not None:
            self._behind[name] = behind

    def fill_menu(self, menu: QMenu) -> None:
        """Each panel with a tick where it is shown."""
        for dock in self._docks.values():
            menu.addAction(dock.toggleViewAction())

    # --- arrangement -------------------------------------------------------------------------
    def begin(self, kept: QByteArray | None) -> None:
        """Arrange the docks as they were left, or as they are at first."""
        # Docks that are tabbed before the window is shown leave a stray tab bar behind.
        if kept is None or not self._restore(kept):
            self._arrange()
            QTimer.singleShot(0, self.default_sizes)
        else:
            # Sizes hold only once the viewport stands in the centre and has its place.
            QTimer.singleShot(0, lambda: self._restore(kept))

    def _restore(self, state: QByteArray) -> bool:
        return self._window.restoreState(state, _LAYOUT_VERSION)

    def _arrange(self) -> None:
        for left, right in (*_TABBED, *((front, name) for name, front in self._behind.items())):
            self._window.tabifyDockWidget(self[left], self[right])
        for name in _IN_FRONT:
            self[name].raise_()

    def default_sizes(self) -> None:
        """Give the docks the sizes that they have in a first window."""
        resize, wide, high = (
            self._window.resizeDocks,
            Qt.Orientation.Horizontal,
            Qt.Orientation.Vertical,
        )
        resize([self["project"], self["stereonet"]], [288, 326], wide)
        resize([self["project"], self["trace"]], [300, 500], high)
        resize([self["stereonet"], self["properties"]], [400, 400], high)
        resize([self["table"]], [190], high)

    def state(self) -> QByteArray:
        """What `begin` takes, with the docks that are put away in their places."""
        return self._put_away or self._window.saveState(_LAYOUT_VERSION)

    # --- coming and going --------------------------------------------------------------------
    def bring_forward(self, name: str) -> None:
        """Show a panel, in front of those that share its place."""
        self[name].show()
        self[name].raise_()

    def make_room(self, name: str, height: int) -> None:
        """Let a panel that is docked in the window be at least so high, in pixels."""
        dock = self[name]
        if dock.height() < height and dock.isVisible() and not dock.isFloating():
            self._window.resizeDocks([dock], [height], Qt.Orientation.Vertical)

    def show_only_outcrop(self) -> None:
        """Hide every panel, or bring back those that were there."""
        if self._put_away is not None:
            # Shown one by one they would share the room anew.
            self._restore(self._put_away)
            self._put_away = None
        else:
            self._put_away = self._window.saveState(_LAYOUT_VERSION)
            for dock in self._docks.values():
                dock.hide()
