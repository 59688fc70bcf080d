"""Docks of the window: the inspector on the right and the drawer at the bottom."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import Protocol

from PySide6.QtCore import QByteArray, QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

from vomstudio.ui.base.controls import LazyScrollArea, PanelScrollArea
from vomstudio.ui.shell.dock_titles import DockTitle
from vomstudio.ui.shell.layout import (
    REGIONS,
    Region,
    drawer_height,
    inspector_width,
)
from vomstudio.ui.shell.screens import bring_on_screen

_LAYOUT_VERSION = 6
_LEFT, _RIGHT = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
_BOTTOM = Qt.DockWidgetArea.BottomDockWidgetArea
_AREAS: dict[Region, Qt.DockWidgetArea] = {
    "inspector": _RIGHT,
    "drawer": _BOTTOM,
    "overlay": _RIGHT,
    "beside": _LEFT,
}


class PageHost(Protocol):
    """Host of a page outside the docks: the centre of the window or an overlay."""

    def show_page(self, name: str, title: str, widget: QWidget) -> None:
        """Take over the widget of a page and show it."""

    def release_page(self) -> QWidget | None:
        """Remove the page and return its widget, or None if the host has no page."""


class OverlayHost(PageHost, Protocol):
    """Host of a page over the outcrop."""

    is_shown: bool
    """Whether the page is in the overlay; it is visible only together with the outcrop."""


class WindowDocks(Mapping[str, QDockWidget]):
    """Docks of a window, keyed by page name, which is also their object name."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._docks: dict[str, QDockWidget] = {}
        self._lazy_areas: list[LazyScrollArea] = []
        self._watcher = _Watcher(window)
        self.changed = self._watcher.changed
        """Emitted when a page has appeared, disappeared or moved to another host."""
        self.rearranged = self._watcher.rearranged
        """Emitted when a dock has been moved or resized."""
        self._center: PageHost | None = None
        self._overlay: OverlayHost | None = None
        self.center_page = ""
        """Name of the page in the centre of the window, or ""."""
        self._was_docked = False
        self._halved_docks: set[str] = set()
        """Pages beside the outcrop that have been given half of its width."""
        self._folded_page = ""
        self.is_net_docked = False
        for corner in (Qt.Corner.BottomLeftCorner, Qt.Corner.BottomRightCorner):
            window.setCorner(corner, _BOTTOM)

    def __getitem__(self, name: str) -> QDockWidget:
        return self._docks[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._docks)

    def __len__(self) -> int:
        return len(self._docks)

    def titles(self) -> dict[str, str]:
        """Return the titles of the pages, keyed by page name."""
        return {name: dock.windowTitle() for name, dock in self._docks.items()}

    # --- pages -------------------------------------------------------------------------------
    def add(self, name: str, title: str, widget: QWidget, *, is_scrollable: bool = False) -> None:
        """Add a page; if `is_scrollable`, it scrolls when it is longer than its dock."""
        self._add(name, title, PanelScrollArea(widget) if is_scrollable else widget)

    def add_lazy_page(
        self, name: str, title: str, make: Callable[[], QWidget], *, is_permanent: bool = False
    ) -> None:
        """Add a scrolling page that is created when it is first shown in a project.

        Parameters
        ----------
        is_permanent : bool
            Whether the page is kept when another project is opened.
        """
        area = LazyScrollArea(make)
        if not is_permanent:
            self._lazy_areas.append(area)
        self._add(name, title, area)

    def renew_pages(self) -> None:
        """Discard the pages that were added with `add_lazy_page` and are not permanent.

        Their inputs, results and messages belong to one project; new pages start empty.
        """
        for area in self._lazy_areas:
            area.discard_panel()

    def _add(self, name: str, title: str, widget: QWidget) -> None:
        dock = QDockWidget(title, self._window)
        dock.setObjectName(name)
        dock.setTitleBarWidget(DockTitle(dock, self))
        dock.setWidget(widget)
        self._window.addDockWidget(_AREAS[REGIONS[name]], dock)
        for other_dock in self._docks.values():
            if REGIONS[other_dock.objectName()] == REGIONS[name]:
                self._window.tabifyDockWidget(other_dock, dock)
                break
        dock.hide()
        self._docks[name] = dock
        dock.windowTitleChanged.connect(self._name_tabs)
        self._watcher.watch(dock)

    def _name_tabs(self, _: str) -> None:
        for dock in self._docks.values():
            title = dock.titleBarWidget()
            if isinstance(title, DockTitle):
                title.name_tabs()

    def set_hosts(self, center: PageHost, overlay: OverlayHost) -> None:
        """Set the hosts of pages outside the docks."""
        self._center, self._overlay = center, overlay

    def is_shown(self, name: str) -> bool:
        """Return whether a page is visible in the centre, an overlay or a dock."""
        if self.center_page == name:
            return True
        if REGIONS[name] == "overlay" and not self.is_net_docked:
            return self._overlay is not None and self._overlay.is_shown
        return not self._docks[name].isHidden()

    def find_page_widget(self, name: str) -> QWidget | None:
        """Return the visible host of a page (dock, overlay or centre), or None if it is hidden."""
        if name == self.center_page:
            place: QWidget | None = self._window.centralWidget()
        elif REGIONS[name] == "overlay" and not self.is_net_docked:
            place = self._overlay if isinstance(self._overlay, QWidget) else None
        else:
            place = self[name]
        return place if place is not None and place.isVisible() else None

    def toggle(self, name: str, is_visible: bool) -> None:
        """Show or close a page."""
        if is_visible:
            self.bring_forward(name)
        else:
            self.close_page(name)

    def page(self, region: Region) -> str:
        """Return the name of the page that is docked and visible in a region, or ""."""
        names = (name for name in self._docks if REGIONS[name] == region)
        return next((name for name in names if self._is_docked(name)), "")

    def _is_docked(self, name: str) -> bool:
        dock = self._docks[name]
        return not dock.isHidden() and not dock.isFloating()

    def bring_forward(self, name: str) -> None:
        """Show a page in its region, replacing the page docked there."""
        if name == self.center_page:
            return
        self._make(name)
        if REGIONS[name] == "overlay" and not self.is_net_docked:
            if self._overlay is not None and not self._overlay.is_shown:
                self._overlay.show_page(name, self[name].windowTitle(), self._release_page(name))
            self.changed.emit()
            return
        dock = self[name]
        if dock.isFloating():
            dock.show()
            dock.raise_()
            self.changed.emit()
            return
        was_open, center_width = bool(self.page(REGIONS[name])), self._center_width()
        are_updates_enabled = self._window.updatesEnabled()
        self._window.setUpdatesEnabled(False)
        try:
            dock.show()
            for other_dock in self._docks:
                if (
                    other_dock != name
                    and REGIONS[other_dock] == REGIONS[name]
                    and self._is_docked(other_dock)
                ):
                    self[other_dock].hide()
            dock.raise_()
            if not was_open and not self._was_docked and REGIONS[name] == "drawer":
                self.set_initial_sizes()
                self._was_docked = True
            if REGIONS[name] == "beside" and name not in self._halved_docks:
                self._halved_docks.add(name)
                self._window.resizeDocks([dock], [center_width // 2], Qt.Orientation.Horizontal)
        finally:
            self._window.setUpdatesEnabled(are_updates_enabled)
        self.changed.emit()

    def _center_width(self) -> int:
        center: QWidget | None = self._window.centralWidget()
        return 0 if center is None else center.width()

    def close_page(self, name: str) -> None:
        """Hide a page; a page in the centre first returns to its dock."""
        if name == self.center_page:
            self.restore_from_center()
        self._leave_overlay(name)
        self[name].hide()
        self.changed.emit()

    def _leave_overlay(self, name: str) -> None:
        """Return a page from the overlay to its dock."""
        if REGIONS[name] == "overlay" and self._overlay is not None:
            widget = self._overlay.release_page()
            if widget is not None:
                self[name].setWidget(widget)

    def close_region(self, region: Region) -> None:
        """Hide the docked page of a region."""
        if name := self.page(region):
            self.close_page(name)

    def fold_inspector(self, is_folded: bool) -> None:
        """Hide the inspector to give its width to the centre, or show it again."""
        if is_folded:
            self._folded_page = self.page("inspector") or self._folded_page
            self.close_region("inspector")
        elif self._folded_page:
            page, self._folded_page = self._folded_page, ""
            if not self.page("inspector"):
                self.bring_forward(page)

    def _make(self, name: str) -> None:
        """Create a page that was added with `add_lazy_page`, because a caller needs it now."""
        if isinstance(place := self._widget(name), LazyScrollArea):
            place.widget()

    def _widget(self, name: str) -> QWidget | None:
        widget: QWidget | None = self[name].widget()
        return widget

    def _release_page(self, name: str) -> QWidget:
        widget = self[name].widget()
        self[name].hide()
        return widget

    def ensure_height(self, name: str, height: int) -> None:
        """Ensure a minimum height of a docked page, in pixels."""
        dock = self[name]
        if dock.height() < height and dock.isVisible() and not dock.isFloating():
            self._window.resizeDocks([dock], [height], Qt.Orientation.Vertical)

    def replace_page(self, name: str, widget: QWidget) -> None:
        """Replace the widget of a page in its present host."""
        was_shown, was_in_center = self.is_shown(name), name == self.center_page
        self.close_page(name)
        old_page = self[name].widget()
        self[name].setWidget(widget)
        if old_page is not None:
            old_page.deleteLater()
        if was_in_center:
            self.move_to_center(name)
        elif was_shown:
            self.bring_forward(name)

    # --- centre ------------------------------------------------------------------------------
    def toggle_center(self, name: str) -> None:
        """Move a page to the centre of the window, or back to its dock."""
        if name == self.center_page:
            self.restore_from_center()
            self.bring_forward(name)
        else:
            self.move_to_center(name)

    def move_to_center(self, name: str) -> None:
        """Show a page in the centre of the window."""
        if self._center is None or name == self.center_page:
            return
        self.restore_from_center()
        self._make(name)
        self._leave_overlay(name)
        self.center_page = name
        self._center.show_page(name, self[name].windowTitle(), self._release_page(name))
        self.changed.emit()

    def restore_from_center(self) -> str:
        """Return the page in the centre to its dock, which stays hidden, and return its name."""
        name, self.center_page = self.center_page, ""
        if name and self._center is not None:
            if (widget := self._center.release_page()) is not None:
                self[name].setWidget(widget)
            self.changed.emit()
        return name

    def focused_page(self) -> str:
        """Return the name of the page with the focus, or else the drawer's page, or the net."""
        focus = self._window.focusWidget()
        for name, dock in self._docks.items():
            if focus is not None and self._is_docked(name) and dock.isAncestorOf(focus):
                return name
        return self.page("drawer") or "stereonet"

    def dock_net(self, is_docked: bool) -> None:
        """Show the net in a dock or as an overlay over the outcrop."""
        if is_docked == self.is_net_docked:
            return
        self.close_page("stereonet")
        self.is_net_docked = is_docked
        self.bring_forward("stereonet")

    # --- arrangement -------------------------------------------------------------------------
    def state(self) -> QByteArray:
        """Return the arrangement of the docks for `restore`."""
        return self._window.saveState(self._version())

    def restore(self, state: QByteArray) -> bool:
        """Restore an arrangement. Return False if it belongs to a different set of docks."""
        is_restored = self._window.restoreState(state, self._version())
        if is_restored:
            self._was_docked = True
            self.keep_one_page()
        self.bring_on_screen()
        return is_restored

    def keep_one_page(self) -> None:
        """Hide all docked pages except the first one of each region."""
        for region in _AREAS:
            docked_names = [n for n in self._docks if REGIONS[n] == region and self._is_docked(n)]
            for name in docked_names[1:]:
                self[name].hide()

    def _version(self) -> int:
        """Return a number that identifies this set of pages, because arrangements depend on it."""
        return zlib.crc32(",".join(sorted(self._docks)).encode(), _LAYOUT_VERSION) & 0x7FFFFFFF

    def bring_on_screen(self) -> None:
        """Move floating docks that are outside all screens onto a screen."""
        for dock in self._docks.values():
            if dock.isFloating() and not dock.isHidden():
                bring_on_screen(dock)

    def arrange(self) -> None:
        """Dock all pages in their regions, and hide all but open views beside the outcrop."""
        self.restore_from_center()
        open_views = [n for n in self._docks if REGIONS[n] == "beside" and not self[n].isHidden()]
        first: dict[Region, QDockWidget] = {}
        for name, dock in self._docks.items():
            region = REGIONS[name]
            dock.setFloating(False)
            self._window.removeDockWidget(dock)
            self._window.addDockWidget(_AREAS[region], dock)
            if region in first:
                self._window.tabifyDockWidget(first[region], dock)
            else:
                first[region] = dock
            dock.hide()
        self._was_docked = False
        self._halved_docks.clear()
        for name in open_views:
            self.bring_forward(name)

    def set_initial_sizes(self) -> None:
        """Set the initial sizes of the inspector and drawer."""
        size = self._window.size()
        if name := self.page("inspector"):
            width = inspector_width(size.width())
            self._window.resizeDocks([self[name]], [width], Qt.Orientation.Horizontal)
        if name := self.page("drawer"):
            height = drawer_height(size.height())
            self._window.resizeDocks([self[name]], [height], Qt.Orientation.Vertical)

    def hide_all(self) -> None:
        """Hide every dock and overlay."""
        self.restore_from_center()
        for name, dock in self._docks.items():
            if REGIONS[name] == "overlay":
                self.close_page(name)
            dock.hide()
        self.changed.emit()


class _Watcher(QObject):
    """Watcher that reports changes of docks.

    `changed` is emitted at most once per iteration of the event loop.
    """

    changed = Signal()
    rearranged = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._timer = QTimer(self, singleShot=True, interval=0)
        self._timer.timeout.connect(self.changed)

    def watch(self, dock: QDockWidget) -> None:
        """Watch a dock."""
        dock.installEventFilter(self)
        dock.dockLocationChanged.connect(lambda _: self.rearranged.emit())
        for signal in (dock.topLevelChanged, dock.visibilityChanged):
            signal.connect(lambda _: self._timer.start())
            signal.connect(lambda _: self.rearranged.emit())

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Move):
            self.rearranged.emit()
        return False
