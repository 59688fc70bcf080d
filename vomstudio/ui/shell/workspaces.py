"""Current workspace, and the arrangement of the window."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QByteArray, QEvent, QObject, QTimer, Signal
from PySide6.QtGui import QGuiApplication, QScreen
from PySide6.QtWidgets import QMainWindow

from vomstudio.ui.shell import screens
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.layout import (
    DEFAULT_WORKSPACE,
    REGIONS,
    WORKSPACES,
    Region,
    WorkspaceLayout,
    find_workspace,
)

_GEOMETRY_KEY, _WORKSPACE_KEY, _DOCKS_KEY, _PAGES_KEY, _NET_KEY = (
    "geometry",
    "workspace",
    "docks",
    "pages",
    "net",
)
_OVERLAY, _DOCKED, _HIDDEN = "overlay", "docked", "hidden"
# Long enough for a drag to end, and short enough to lose little in a crash.
_SETTLE_DELAY_MS = 300
_STORED_REGIONS: tuple[Region, Region] = ("inspector", "drawer")


class Workspaces(QObject):
    """Current workspace, and the pages that were last open in each workspace.

    A workspace determines the pages of inspector and drawer. Sizes, floating docks and the net
    are set by the user and do not change with the workspace.

    Attributes
    ----------
    leaving : Signal
        Emitted before another workspace is shown.
    changed : Signal of str
        Emitted after a workspace was shown, or its panels were hidden or reset.
    settled : Signal
        Emitted when the position, size or docks of the window have stopped changing.
    """

    leaving = Signal()
    changed = Signal(str)
    settled = Signal()

    def __init__(
        self, window: QMainWindow, docks: WindowDocks, stored_state: Mapping[str, str]
    ) -> None:
        """Create workspaces from the state that `export_state` returned in an earlier session."""
        super().__init__(window)
        self._window, self._docks = window, docks
        self._state = screens.from_text(stored_state.get(_DOCKS_KEY, ""))
        self._pages = {item.name: _read_pages(stored_state, item) for item in WORKSPACES}
        self._shown_workspace = find_workspace(stored_state.get(_WORKSPACE_KEY, DEFAULT_WORKSPACE))
        self._hidden_docks: tuple[QByteArray, bool] | None = None
        self._net = stored_state.get(_NET_KEY, "")
        self._has_begun = False
        self._timer = QTimer(self, singleShot=True, interval=_SETTLE_DELAY_MS)
        self._timer.timeout.connect(self._settle)

    @property
    def current_workspace(self) -> WorkspaceLayout:
        """Current workspace."""
        return self._shown_workspace

    @property
    def is_only_outcrop_visible(self) -> bool:
        """Whether all docks are hidden."""
        return self._hidden_docks is not None

    # --- showing -----------------------------------------------------------------------------
    def begin(self) -> None:
        """Restore the stored arrangement of the docks, or use the initial one."""
        # Sizes take effect only once the viewport is in the centre.
        QTimer.singleShot(0, self._restore_state)

    def _restore_state(self) -> None:
        # Photos of the command line have taken the centre before.
        center_page = self._docks.center_page
        is_restored = self._state is not None and self._docks.restore(self._state)
        if not is_restored:
            self._docks.arrange()
        if is_restored and self._net == _DOCKED:
            self._docks.dock_net(True)
        elif not is_restored or self._net != _HIDDEN:
            self._docks.bring_forward("stereonet")
        self._show_pages()
        if not is_restored:
            self._set_initial_sizes()
        if center_page:
            self._docks.move_to_center(center_page)
        self._has_begun = True
        self._window.installEventFilter(self)
        self._docks.rearranged.connect(self._change)
        self._docks.changed.connect(self._change)
        application = QGuiApplication.instance()
        assert isinstance(application, QGuiApplication)
        application.screenRemoved.connect(self._handle_screen_change)
        application.screenAdded.connect(self._watch_screen)
        for screen in application.screens():
            self._watch_screen(screen)

    def _watch_screen(self, screen: QScreen) -> None:
        screen.availableGeometryChanged.connect(self._handle_screen_change)

    def _handle_screen_change(self) -> None:
        QTimer.singleShot(0, self._window, self._bring_on_screen)

    def switch(self, name: str) -> None:
        """Switch to a workspace, with the pages that were last open in it."""
        workspace = find_workspace(name)
        if workspace is self._shown_workspace and self._hidden_docks is None:
            return
        if self._hidden_docks is not None:
            self.show_only_outcrop()
        self._remember()
        self.leaving.emit()
        self._docks.restore_from_center()
        self._shown_workspace = workspace
        self._show_pages()
        self._docks.bring_on_screen()
        self.changed.emit(workspace.name)

    def reset(self) -> None:
        """Restore the initial arrangement of the window and of the current workspace."""
        self._hidden_docks = None
        self._pages[self._shown_workspace.name] = _initial_pages()
        self._docks.arrange()
        self._docks.is_net_docked = False
        self._docks.bring_forward("stereonet")
        self._show_pages()
        self._set_initial_sizes()
        self.changed.emit(self._shown_workspace.name)

    def show_only_outcrop(self) -> None:
        """Hide all panels, or show the previously visible panels again."""
        if self._hidden_docks is None:
            self._docks.restore_from_center()
            self._remember()
            self._hidden_docks = (self._docks.state(), self._docks.is_shown("stereonet"))
            self._docks.hide_all()
        else:
            (state, has_net), self._hidden_docks = self._hidden_docks, None
            self._docks.restore(state)
            if has_net:
                self._docks.bring_forward("stereonet")
        self.changed.emit(self._shown_workspace.name)

    def _show_pages(self) -> None:
        pages = self._pages[self._shown_workspace.name]
        for region in _STORED_REGIONS:
            if name := pages[region]:
                self._docks.bring_forward(name)
            else:
                self._docks.close_region(region)

    def _set_initial_sizes(self) -> None:
        self._docks.set_initial_sizes()
        # Docks that were never shown get their sizes only after the layout.
        QTimer.singleShot(0, self._window, self._docks.set_initial_sizes)

    # --- storing -----------------------------------------------------------------------------
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Move):
            self._change()
        return False

    def _change(self) -> None:
        if self._has_begun:
            self._timer.start()

    def _settle(self) -> None:
        if self._window.isVisible() and not self._window.isMinimized():
            self._remember()
            self.settled.emit()

    def _remember(self) -> None:
        if self._has_begun and self._hidden_docks is None:
            self._pages[self._shown_workspace.name] = {
                r: self._docks.page(r) for r in _STORED_REGIONS
            }
            self._state = self._docks.state()
            is_shown = self._docks.is_shown("stereonet")
            self._net = _DOCKED if self._docks.is_net_docked else _OVERLAY if is_shown else _HIDDEN

    def _bring_on_screen(self) -> None:
        screens.bring_on_screen(self._window)
        self._docks.bring_on_screen()

    def stop(self) -> None:
        """Stop watching the window because it is closing."""
        self._remember()
        self._has_begun = False
        self._timer.stop()

    def export_state(self) -> dict[str, str]:
        """Return the geometry, workspace, docks and pages of the window for the settings."""
        return {
            _GEOMETRY_KEY: screens.to_text(self._window.saveGeometry()),
            _WORKSPACE_KEY: self._shown_workspace.name,
            _NET_KEY: self._net,
            _DOCKS_KEY: "" if self._state is None else screens.to_text(self._state),
            **{f"{_PAGES_KEY} {name}": ",".join(p.values()) for name, p in self._pages.items()},
        }


def stored_geometry(stored_state: Mapping[str, str]) -> str | None:
    """Return the window position and size contained in a result of `export_state`."""
    return stored_state.get(_GEOMETRY_KEY)


def _initial_pages() -> dict[Region, str]:
    return {"inspector": "project", "drawer": ""}


def _read_pages(stored_state: Mapping[str, str], workspace: WorkspaceLayout) -> dict[Region, str]:
    inspector, _, drawer = stored_state.get(f"{_PAGES_KEY} {workspace.name}", "project,").partition(
        ","
    )
    pages = _initial_pages()
    if REGIONS.get(inspector) == "inspector":
        pages["inspector"] = inspector
    if REGIONS.get(drawer) == "drawer":
        pages["drawer"] = drawer
    return pages
