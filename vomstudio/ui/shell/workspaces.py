"""The workspace that is shown, and the arrangement of the docks that each remembers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from PySide6.QtCore import QByteArray, QEvent, QObject, QSize, QTimer, Signal
from PySide6.QtGui import QGuiApplication, QScreen
from PySide6.QtWidgets import QMainWindow

from vomstudio.ui.shell import screens
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.workspace_table import (
    FIRST,
    WORKSPACES,
    Places,
    WorkspaceLayout,
    is_small,
    places_in,
    sizes_in,
    workspace_of,
)

_GEOMETRY, _SHOWN, _DOCKS = "geometry", "workspace", "docks"
_SMALL, _PHOTO = "small", "photo"
# Long enough for a drag to end, short enough for a crash to take little.
_SETTLED_MS = 300


class Workspaces(QObject):
    """leaving : another workspace is about to be shown; arranging : docks are about to be arranged
    around what then has the middle; changed : the workspace is shown, or a photo has come to its
    middle or gone. settled : place, size or docks of the window have changed and are at
    rest, so that `to_keep` is worth keeping. moved : at once, whenever a dock comes, goes or moves.

    A workspace remembers one arrangement for windows with room and one for small windows, in which
    docks fold together; what was left last at each of the two sizes comes back with it."""

    leaving = Signal()
    arranging = Signal()
    changed = Signal(str)
    settled = Signal()
    moved = Signal()

    def __init__(self, window: QMainWindow, docks: WindowDocks, kept: Mapping[str, str]) -> None:
        """kept : of `to_keep`, from the settings"""
        super().__init__(window)
        self._window, self._docks = window, docks
        self._states: dict[str, QByteArray] = {}
        for workspace in WORKSPACES:
            for key in _keys(workspace):
                if (data := screens.from_text(kept.get(key, ""))) is not None and data:
                    self._states[key] = data
        self._shown = workspace_of(kept.get(_SHOWN, FIRST))
        self._small = False
        self._with_photo: set[str] = set()
        self._put_away: QByteArray | None = None
        self._filling = ""
        self._begun = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(_SETTLED_MS)
        self._timer.timeout.connect(self._settle)

    @property
    def shown(self) -> WorkspaceLayout:
        return self._shown

    @property
    def only_outcrop(self) -> bool:
        """Whether all docks are put away."""
        return self._put_away is not None and not self._filling

    @property
    def filling(self) -> str:
        """The dock that has the place of the outcrop for now; empty where none has."""
        return self._filling

    # --- showing -----------------------------------------------------------------------------
    def begin(self) -> None:
        """Arrange the docks as they were left, or as they are at first."""
        # Sizes hold only once the viewport stands in the centre and has its place.
        QTimer.singleShot(0, self._begin)

    def _begin(self) -> None:
        self._small = self._is_small()
        self._show()
        self._begun = True
        self._window.installEventFilter(self)
        self._docks.watch(self._change)
        application = QGuiApplication.instance()
        assert isinstance(application, QGuiApplication)
        application.screenRemoved.connect(self._screens_changed)
        application.screenAdded.connect(self._watch_screen)
        for screen in application.screens():
            self._watch_screen(screen)

    def _watch_screen(self, screen: QScreen) -> None:
        screen.availableGeometryChanged.connect(self._screens_changed)

    def _screens_changed(self) -> None:
        QTimer.singleShot(0, self._window, self._come_on_screen)

    def switch(self, name: str) -> None:
        """Show a workspace with its docks as it was left."""
        wanted = workspace_of(name)
        if wanted is self._shown and self._put_away is None:
            return
        self._remember()
        self.leaving.emit()
        self._put_away, self._filling = None, ""
        self._shown = wanted
        self._small = self._is_small()
        self._show()
        self.changed.emit(name)

    @property
    def photo_in_front(self) -> bool:
        """Whether an open photo stands in the middle of the workspace that is shown."""
        return self._shown.name in self._with_photo

    def put_photo(self, in_front: bool) -> None:
        """Whether an open photo has the middle of this workspace, which remembers it, or the
        outcrop has."""
        if in_front != self.photo_in_front:
            self._with_other_photos(self._with_photo ^ {self._shown.name})

    def forget_photo(self) -> None:
        """No photo is open any more."""
        self._with_other_photos(set())

    def _with_other_photos(self, names: set[str]) -> None:
        shown = self._shown
        if not shown.beside_photo or (shown.name in names) == self.photo_in_front:
            self._with_photo = names
        else:
            was_away = self.only_outcrop
            self._remember()
            self._with_photo, self._put_away, self._filling = names, None, ""
            self._show()
            if was_away:
                self.show_only_outcrop()
        self.changed.emit(shown.name)

    def reset(self) -> None:
        """Arrange the docks of the workspace that is shown as they are at first."""
        self._put_away, self._filling = None, ""
        for key in _keys(self._shown):
            self._states.pop(key, None)
        self._show()
        self.changed.emit(self._shown.name)

    def show_only_outcrop(self) -> None:
        """Hide every panel, or bring back those that were there."""
        back = self.only_outcrop
        self._bring_back()
        if not back:
            self._put_away = self._docks.state()
            self._docks.hide_all()
        self.changed.emit(self._shown.name)

    def fill_middle(self, name: str) -> None:
        """Give a dock the place of the outcrop, beside the docks that stand at the sides; or put
        it back."""
        back = self._filling == name
        self._bring_back()
        if not back:
            self._put_away, self._filling = self._docks.state(), name
            places = self._places()
            below = [dock for stack in places["bottom"] for dock in stack if dock != name]
            sides: Places = {
                side: tuple(
                    rest
                    for stack in places[side]
                    if (rest := tuple(dock for dock in stack if dock != name))
                )
                for side in ("left", "right")
            }
            places = {**sides, "bottom": ((name, *below),)}
            # The outcrop goes first, or both would ask for room.
            self.changed.emit(self._shown.name)
            self._docks.arrange(places)
            sizes = sizes_in(self._shown, *self._size())
            self._docks.give_sizes({**sides, "bottom": ()}, sizes, self._shown.first_share)
        self.changed.emit(self._shown.name)

    def _bring_back(self) -> None:
        """Restore what was put away."""
        state, filled = self._put_away, bool(self._filling)
        self._put_away, self._filling = None, ""
        if filled:
            # The outcrop is there again first, or docks would keep its room.
            self.changed.emit(self._shown.name)
        if state is not None:
            # Shown one by one they would share the room anew.
            self._docks.restore(state)

    def _show(self) -> None:
        self._docks.own = self._shown.docks
        self.arranging.emit()
        self._window.setUpdatesEnabled(False)
        try:
            kept = self._states.get(self._key())
            if kept is None or not self._docks.restore(kept):
                self._docks.arrange(self._places())
                self.give_sizes()
                # Docks that have never been shown get their sizes only once they are laid out.
                # The window may be gone by then, and takes the call with it.
                again = partial(self._size_again, self._shown)
                QTimer.singleShot(0, self._window, again)
        finally:
            self._window.setUpdatesEnabled(True)

    def _size_again(self, shown: WorkspaceLayout) -> None:
        if shown is self._shown and self._put_away is None:
            self.give_sizes()

    def give_sizes(self) -> None:
        """Give the docks the sizes that they have at first in a window of this size."""
        shown = self._shown
        sizes = sizes_in(shown, *self._size(), photo=self.photo_in_front)
        self._docks.give_sizes(self._places(), sizes, shown.first_share)

    def _places(self) -> Places:
        return places_in(self._shown, *self._size(), photo=self.photo_in_front)

    def _key(self) -> str:
        return _key(self._shown, self._small, self.photo_in_front)

    def _size(self) -> tuple[int, int]:
        size: QSize = self._window.size()
        return size.width(), size.height()

    def _is_small(self) -> bool:
        return is_small(*self._size())

    # --- remembering -------------------------------------------------------------------------
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Move):
            self._change()
        return False

    def _change(self) -> None:
        if self._begun:
            self._timer.start()
            self.moved.emit()

    def _settle(self) -> None:
        if not self._window.isVisible() or self._window.isMinimized():
            return
        if self._put_away is None and self._small != self._is_small():
            # What the other size squeezed is not what the user arranged.
            self._small = self._is_small()
            self._show()
        else:
            self._remember()
        self.settled.emit()

    def _remember(self) -> None:
        if self._begun and self._small == self._is_small():
            # What is put away comes back: it is still the arrangement.
            state = self._put_away or self._docks.state()
            self._states[self._key()] = state

    def _come_on_screen(self) -> None:
        screens.bring_on_screen(self._window)
        self._docks.bring_on_screen()

    def stop(self) -> None:
        """The window is closing: what moves now is not the user's doing."""
        self._remember()
        self._begun = False
        self._timer.stop()

    def to_keep(self) -> dict[str, str]:
        """Place and size of the window, the workspace shown and all arrangements, for the
        settings."""
        return {
            _GEOMETRY: screens.to_text(self._window.saveGeometry()),
            _SHOWN: self._shown.name,
            **{key: screens.to_text(state) for key, state in self._states.items()},
        }


def geometry_of(kept: Mapping[str, str]) -> str | None:
    """What `to_keep` said of the window's place and size."""
    return kept.get(_GEOMETRY)


def _key(workspace: WorkspaceLayout, small: bool, photo: bool) -> str:
    own = (*((_SMALL,) if small else ()), *((_PHOTO,) if photo and workspace.beside_photo else ()))
    return " ".join((_DOCKS, workspace.name, *own))


def _keys(workspace: WorkspaceLayout) -> list[str]:
    return [_key(workspace, small, photo) for small in (False, True) for photo in (False, True)]
