"""Open photo, shown as a tab beside the outcrop or in a separate window."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.actions import Actions, Command
from vomstudio.ui.base.window_fitting import fit_to_screen
from vomstudio.ui.panels.photos.photo_commands import PhotoOpening
from vomstudio.ui.panels.photos.photo_page_commands import photo_command
from vomstudio.ui.shell.central_area import CentralArea
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.workspaces import Workspaces

if TYPE_CHECKING:
    from vomstudio.ui.panels.photos.photo_page import PhotoPage

_TOOL_COMMANDS = ("navigate", *(entry.name for entry in TOOLS))
_WINDOW_SIZE = (1400, 860)


class PhotoTab(QObject):
    """Tab of the open photo, which replaces the outcrop while it is visible.

    `changed` is emitted when the state that commands depend on has changed, `visible_page_changed`
    when another widget is visible and should get the focus, and `photo_hint_changed` with the
    status text of the visible photo, or "" if no photo is visible.
    """

    changed = Signal()
    photo_hint_changed = Signal(str)
    visible_page_changed = Signal()

    def __init__(
        self,
        opening: PhotoOpening,
        docks: WindowDocks,
        workspaces: Workspaces,
        parent: QWidget,
    ) -> None:
        """Create the tab. `parent` is the parent of the separate window."""
        super().__init__(parent)
        self._opening, self._docks, self._parent = opening, docks, parent
        self._place: CentralArea | None = None
        self._reported_page: PhotoPage | None = None
        self._previous_page = ""
        opening.page_shown.connect(self._show_page)
        docks.changed.connect(self._follow)
        workspaces.changed.connect(self._workspace_changed)

    def commands(self) -> list[Command]:
        def open_photo_problem() -> Finding | None:
            return None if self._opening.page is not None else Finding("action.no-open-photo")

        return [
            Command(
                "outcrop_or_photo",
                tr("Outcrop or p&hoto"),
                self.toggle_photo,
                None,
                "F8",
                tr("Switch between the outcrop and the open photo."),
                open_photo_problem,
            ),
            Command(
                "close_photo",
                tr("&Close photo"),
                self._opening.may_close,
                None,
                "Ctrl+W",
                tr("Close the photo; its masks and marks are saved."),
                open_photo_problem,
            ),
        ]

    def adapt_commands(self, commands: Iterable[Command]) -> list[Command]:
        """Adapt commands of the main window to act on the photo while it is visible."""
        return [self._adapt_command(photo_command(command, self._table)) for command in commands]

    def _adapt_command(self, command: Command) -> Command:
        is_checked = command.is_checked
        if command.name not in _TOOL_COMMANDS or is_checked is None:
            return command
        # The tool in use belongs to the photo.
        return replace(command, is_checked=lambda: is_checked() and self.visible_page is None)

    def join(self, place: CentralArea, outcrop_actions: Iterable[QAction]) -> None:
        """Add the photo to the central area. `outcrop_actions` show the outcrop when triggered."""
        self._place = place
        place.outcrop_requested.connect(self.show_outcrop)
        place.photo_requested.connect(self.show_photo)
        place.photo_close_requested.connect(self._opening.may_close)
        for action in outcrop_actions:
            action.triggered.connect(self._handle_outcrop_use)

    # --- visible photo -----------------------------------------------------------------------
    @property
    def visible_page(self) -> PhotoPage | None:
        """Page of the photo in the centre of the main window, or None if no photo is visible."""
        place = self._place
        return self._opening.page if place is not None and place.shows_photo else None

    @property
    def canvas(self) -> QWidget | None:
        """Canvas of the visible photo, for the keyboard focus, or None if no photo is visible."""
        return None if (page := self.visible_page) is None else page.canvas

    def _table(self) -> Actions | None:
        return None if (page := self.visible_page) is None else page.actions_table

    def toggle_photo(self) -> None:
        """Switch from the photo to the outcrop or vice versa."""
        if self.visible_page is not None:
            self.leave_photo()
        else:
            self.show_photo()

    def show_photo(self) -> None:
        """Show the open photo; the page in the centre returns after the photo is left."""
        page, place = self._opening.page, self._place
        if page is None or place is None:
            return
        if page.isWindow():
            page.raise_()
            page.activateWindow()
            return
        self._previous_page = self._docks.restore_from_center() or self._previous_page
        place.show_photo(True)
        self._follow()

    def leave_photo(self) -> None:
        """Show the page that was in the centre before the photo, or else the outcrop."""
        previous_page, self._previous_page = self._previous_page, ""
        self.show_outcrop()
        if previous_page:
            self._docks.move_to_center(previous_page)

    def show_outcrop(self) -> None:
        """Show the outcrop."""
        self._previous_page = ""
        if self._place is not None:
            self._docks.restore_from_center()
            self._place.show_photo(False)
            self._follow()

    def _handle_outcrop_use(self) -> None:
        if self.visible_page is not None:
            self.show_outcrop()

    def _workspace_changed(self, _: str) -> None:
        self._docks.fold_inspector(self.visible_page is not None)

    def _follow(self) -> None:
        """Emit signals if another widget has become visible."""
        if self._reported_page is not self.visible_page:
            self._report()

    def _report(self) -> None:
        self._reported_page = self.visible_page
        # A photo has its own lists and needs the width of the inspector.
        self._docks.fold_inspector(self.visible_page is not None)
        self.visible_page_changed.emit()
        self.changed.emit()
        self._show_hint()

    # --- coming and going --------------------------------------------------------------------
    def _show_page(self, page: PhotoPage) -> None:
        if self._place is not None and page.parentWidget() is None:
            page.windowTitleChanged.connect(self._set_title)
            page.changed.connect(self.changed)
            page.hint_changed.connect(self._show_hint)
            page.attention_requested.connect(self.show_photo)
            page.window_toggle_requested.connect(self._toggle_window)
            page.closed.connect(self._handle_close)
            self._place.set_photo(page, page.toolbar)
        self.show_photo()

    def _set_title(self, title: str) -> None:
        page, place = self._opening.page, self._place
        if page is not None and place is not None:
            place.name_photo(page.photo.rpartition("/")[2], title)

    def _show_hint(self, *_: object) -> None:
        page = self.visible_page
        self.photo_hint_changed.emit("" if page is None else page.hint)

    def _toggle_window(self) -> None:
        """Move the photo to a separate window or back."""
        page, place = self._opening.page, self._place
        if page is None or place is None:
            return
        if page.isWindow():
            page.set_own_window(False)
            place.set_photo(page, page.toolbar)
            self.show_photo()
        else:
            place.set_photo(None)
            page.setParent(self._parent, Qt.WindowType.Window)
            page.set_own_window(True)
            page.resize(*_WINDOW_SIZE)
            fit_to_screen(page)
            page.show()
            page.activateWindow()
            self._handle_photo_closed()
        page.actions_table.refresh()
        page.canvas.setFocus()

    def _handle_close(self) -> None:
        if self._place is not None:
            self._place.set_photo(None)
            self._handle_photo_closed()

    def _handle_photo_closed(self) -> None:
        previous_page, self._previous_page = self._previous_page, ""
        if previous_page:
            self._docks.move_to_center(previous_page)
        self._report()


def create_center_widget_getter(tab: PhotoTab, outcrop: QWidget) -> Callable[[], QWidget]:
    """Return a function that returns the visible photo's canvas, or else the outcrop."""
    return lambda: tab.canvas or outcrop
