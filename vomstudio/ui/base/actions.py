"""Table of actions for the menus, toolbars, search, shortcuts and tests."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.signals import call_after_notifications
from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import escape_markup

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Command:
    """Command of the user interface, with a name for menus, keys and tests.

    All texts are in the user's language.

    Attributes
    ----------
    text : str
        Menu text, with `&` before its mnemonic.
    tip : str
        Second line of the tooltip, below the menu text and the keys.
    disabled_reason : callable
        Returns the reason why the command cannot run now, which is shown in the tooltip, or None
        if it can.
    is_viewport_key : bool
        Whether the shortcut is a plain key that acts only while the viewport has the focus.
    is_checked : callable, optional
        Returns the state of a checkable command.
    target : callable
        Returns the name of the object that the command would change now, which is shown in the
        tooltip, or None.
    current_text : callable, optional
        Returns a menu text that depends on the current state.
    is_global : bool
        Whether the shortcut also acts in dialogs.
    depends_on_camera : bool
        Whether the state of the command changes when the camera moves.
    """

    name: str
    text: str
    run: Callable[[], object]
    icon: str | None = None
    shortcut: str | tuple[str, ...] = ()
    tip: str = ""
    disabled_reason: Callable[[], Finding | None] = lambda: None
    is_viewport_key: bool = False
    is_checked: Callable[[], bool] | None = None
    target: Callable[[], str | None] = lambda: None
    current_text: Callable[[], str] | None = None
    is_global: bool = False
    depends_on_camera: bool = False


@dataclass(frozen=True)
class _State:
    """State of a command as shown by its action."""

    text: str
    disabled_reason: Finding | None
    target: str | None
    is_checked: bool | None


class Actions(QObject):
    """Commands of a window and their `QAction` objects, keyed by name.

    Attributes
    ----------
    refused : Signal
        Emitted with the reason when a plain key is pressed whose command cannot run now.
    """

    refused = Signal(object)  # Finding

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._commands: dict[str, Command] = {}
        self._states: dict[str, _State] = {}
        self.all: dict[str, QAction] = {}
        self.recent_commands: list[str] = []
        """Keys of the search results that were last opened, newest first."""

    def add(self, command: Command) -> None:
        """Create the `QAction` of a command, with its icon and keys."""
        action = QAction(command.text, self._window)
        action.setObjectName(command.name)
        if command.icon:
            action.setIcon(theme.icon(command.icon))
        keys = (command.shortcut,) if isinstance(command.shortcut, str) else command.shortcut
        action.setShortcuts([QKeySequence(key) for key in keys])
        if command.is_viewport_key:
            action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        else:
            context = Qt.ShortcutContext
            scope = context.ApplicationShortcut if command.is_global else context.WindowShortcut
            action.setShortcutContext(scope)
            self._window.addAction(action)
        action.setCheckable(command.is_checked is not None)
        action.triggered.connect(lambda *_: self.run(command.name))
        self._commands[command.name] = command
        self.all[command.name] = action

    def assign_viewport_keys(self, viewport: QWidget) -> None:
        """Assign plain keys to the viewport, so that typing in fields does not run commands."""
        for name, command in self._commands.items():
            if command.is_viewport_key:
                viewport.addAction(self.all[name])
        viewport.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Report a plain key, except Esc, whose command cannot run now."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyPress:
            return False
        # A key arrives here only if it was not handled by an enabled command. Esc is never
        # reported.
        if event.key() != Qt.Key.Key_Escape and not event.isAutoRepeat():
            self._report_unavailable_command(QKeySequence(event.keyCombination()))
        return False

    def _report_unavailable_command(self, key_sequence: QKeySequence) -> None:
        for name, command in self._commands.items():
            if command.is_viewport_key and key_sequence in self.all[name].shortcuts():
                reason = command.disabled_reason()
                if reason is not None:
                    self.refused.emit(reason)
                    return

    def viewport_actions(self) -> list[QAction]:
        """Return the actions of commands with plain keys in the viewport."""
        return [self.all[name] for name, item in self._commands.items() if item.is_viewport_key]

    def disabled_reason(self, name: str) -> Finding | None:
        """Return why a command cannot run now, or None if it can."""
        return self._commands[name].disabled_reason()

    def target(self, name: str) -> str | None:
        """Return the name of the object that a command would change now, or None."""
        return self._commands[name].target()

    def run(self, name: str) -> None:
        """Run a command if it can run now, and update all actions."""
        command = self._commands[name]
        if command.disabled_reason() is None:
            _log.info("action %s", name)
            command.run()
        self.refresh()

    def refresh(self) -> None:
        """Update the state, text and tooltip of all actions once per batch of notifications."""
        call_after_notifications(self._refresh)

    def refresh_camera(self) -> None:
        """Update only the actions that depend on the camera, because updating all is slow."""
        for name, command in self._commands.items():
            if command.depends_on_camera:
                self._refresh_command(name, command)

    def _refresh(self) -> None:
        for name, command in self._commands.items():
            self._refresh_command(name, command)

    def _refresh_command(self, name: str, command: Command) -> None:
        text = command.text if command.current_text is None else command.current_text()
        state = _State(
            text,
            self.disabled_reason(command.name),
            command.target(),
            None if command.is_checked is None else command.is_checked(),
        )
        if state != self._states.get(name):
            self._states[name] = state
            _show_state(self.all[name], command, state)
        elif state.is_checked is not None:
            # Qt has toggled it when it was triggered.
            self.all[name].setChecked(state.is_checked)

    def commands(self) -> list[Command]:
        return list(self._commands.values())


def _show_state(action: QAction, command: Command, state: _State) -> None:
    action.setEnabled(state.disabled_reason is None)
    action.setText(state.text)
    keys = ", ".join(
        key.toString(QKeySequence.SequenceFormat.NativeText) for key in action.shortcuts()
    )
    text = strip_mnemonic(state.text).rstrip("…")
    lines = [f"{text} ({keys})" if keys else text]
    lines += [line for line in (command.tip, state.target) if line]
    if state.disabled_reason is not None:
        lines.append(tr("Not now: {reason}", reason=state.disabled_reason))
    action.setToolTip(escape_markup("\n".join(lines)))
    if state.is_checked is not None:
        action.setChecked(state.is_checked)


def strip_mnemonic(text: str) -> str:
    """Return a menu text without the `&` before its mnemonic."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&")
