"""One table of actions: menus, toolbar, palette, shortcuts and tests all run these."""

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
    """Something the user can do, under a name that menus, keys and tests know. All texts are given
    in the user's language.

    text: as in a menu, with `&` before the letter of its key. tip: a line for its tooltip.
    why_not: None if it can run now, else the reason, which the tooltip shows.
    in_viewport: the shortcut is a plain key that acts only while the viewport has the focus.
    checked: whether it is switched on, for a command that is a switch. what: to what it would be
    done now, for the tooltip. text_now: where the text says what it would do now. everywhere: the
    shortcut acts in dialogs beside the window too."""

    name: str
    text: str
    run: Callable[[], object]
    icon: str | None = None
    shortcut: str | tuple[str, ...] = ()
    tip: str = ""
    why_not: Callable[[], Finding | None] = lambda: None
    is_viewport_key: bool = False
    is_checked: Callable[[], bool] | None = None
    target: Callable[[], str | None] = lambda: None
    current_text: Callable[[], str] | None = None
    is_global: bool = False


@dataclass(frozen=True)
class _State:
    """What an action shows of its command now."""

    text: str
    why_not: Finding | None
    target: str | None
    is_checked: bool | None


class Actions(QObject):
    """The commands of a window with the QAction of each, under its name.

    refused : a plain key was pressed whose command cannot run now; the reason
    """

    refused = Signal(object)  # Finding

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._commands: dict[str, Command] = {}
        self._states: dict[str, _State] = {}
        self.all: dict[str, QAction] = {}

    def add(self, command: Command) -> None:
        """Make the QAction of a command, with its icon and keys."""
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
            reach = context.ApplicationShortcut if command.is_global else context.WindowShortcut
            action.setShortcutContext(reach)
            self._window.addAction(action)
        action.setCheckable(command.is_checked is not None)
        action.triggered.connect(lambda *_: self.run(command.name))
        self._commands[command.name] = command
        self.all[command.name] = action

    def assign_viewport_keys(self, viewport: QWidget) -> None:
        """Plain keys belong to the viewport, so that typing in a field types."""
        for name, command in self._commands.items():
            if command.is_viewport_key:
                viewport.addAction(self.all[name])
        viewport.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """A key comes as such only where no command that can run has taken it."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyPress:
            return False
        # Esc with nothing to cancel is no mistake.
        if event.key() != Qt.Key.Key_Escape and not event.isAutoRepeat():
            self._say_why_not(QKeySequence(event.keyCombination()))
        return False

    def _say_why_not(self, pressed: QKeySequence) -> None:
        for name, command in self._commands.items():
            if command.is_viewport_key and pressed in self.all[name].shortcuts():
                reason = command.why_not()
                if reason is not None:
                    self.refused.emit(reason)
                    return

    def viewport_actions(self) -> list[QAction]:
        """The actions of the commands whose plain keys belong to the viewport."""
        return [self.all[name] for name, each in self._commands.items() if each.is_viewport_key]

    def why_not(self, name: str) -> Finding | None:
        """Return why a command cannot run now; None if it can."""
        return self._commands[name].why_not()

    def target(self, name: str) -> str | None:
        """To what a command would be done now."""
        return self._commands[name].target()

    def run(self, name: str) -> None:
        """Run an action if it can run now."""
        command = self._commands[name]
        if command.why_not() is None:
            _log.info("action %s", name)
            command.run()
        self.refresh()

    def refresh(self) -> None:
        """Enable what can run now, check what is switched on, and renew all tooltips: once for all
        that is being told."""
        call_after_notifications(self._refresh)

    def _refresh(self) -> None:
        for name, command in self._commands.items():
            shown = command.text if command.current_text is None else command.current_text()
            state = _State(
                shown,
                self.why_not(command.name),
                command.target(),
                None if command.is_checked is None else command.is_checked(),
            )
            if state != self._states.get(name):
                self._states[name] = state
                _show(self.all[name], command, state)
            elif state.is_checked is not None:
                # Qt has checked it the other way round where it was chosen.
                self.all[name].setChecked(state.is_checked)

    def commands(self) -> list[Command]:
        return list(self._commands.values())


def _show(action: QAction, command: Command, state: _State) -> None:
    action.setEnabled(state.why_not is None)
    action.setText(state.text)
    keys = ", ".join(
        key.toString(QKeySequence.SequenceFormat.NativeText) for key in action.shortcuts()
    )
    text = strip_mnemonic(state.text).rstrip("…")
    lines = [f"{text} ({keys})" if keys else text]
    lines += [line for line in (command.tip, state.target) if line]
    if state.why_not is not None:
        lines.append(tr("Not now: {reason}", reason=state.why_not))
    action.setToolTip(escape_markup("\n".join(lines)))
    if state.is_checked is not None:
        action.setChecked(state.is_checked)


def strip_mnemonic(text: str) -> str:
    """A text of a menu without the `&` before the letter of its key."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&")
