"""The keyboard goes where the eye is: one place decides when the outcrop has it, or the photo that
is open in its place. Whichever of the two is seen is called the outcrop below.

Outside the outcrop only text that is being edited keeps the keys. All docks of the window are
served alike, whatever stands in them, and so is what stands around an open photo:

- the cursor or the wheel over the outcrop takes the focus from everything but a text that has been
  changed and not yet been confirmed; from a field only when the cursor has been moved, since one
  that is to be filled in for what was clicked would lose it to a hint that closes;
- a choice in a combo box, and Enter or Esc in a field, hand it back; Esc brings the field's old
  text back first and does no more;
- a letter pressed in a combo box, a list or on a button does in the outcrop what it means there,
  and arrow keys open a combo box instead of changing what it hides;
- where a table is filled in by hand, what is typed goes into its current cell, digits alone into
  one for a number; Enter in a cell hands the focus back;
- what loses the focus because it disappears or is disabled leaves it to the outcrop.

Dialogs and other windows, cells that are edited in a table, and widgets that have keys of their own
(the photo in a panel) are left alone.
"""

from __future__ import annotations

from collections.abc import Callable

import shiboken6
from PySide6.QtCore import QEvent, QObject, Qt, SignalInstance
from PySide6.QtGui import QCursor, QEnterEvent, QKeyEvent, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QLineEdit,
    QMainWindow,
    QMenu,
    QMenuBar,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_STEPS = (
    Qt.Key.Key_Up,
    Qt.Key.Key_Down,
    Qt.Key.Key_PageUp,
    Qt.Key.Key_PageDown,
    Qt.Key.Key_Home,
    Qt.Key.Key_End,
)
_COMMAND_KEYS = (
    Qt.KeyboardModifier.ControlModifier
    | Qt.KeyboardModifier.AltModifier
    | Qt.KeyboardModifier.MetaModifier
)
_KNOWN = "hands_the_keyboard_back"
_IN_NUMBERS = "0123456789+-.,eE \N{MINUS SIGN}\N{DEGREE SIGN}"


class KeyboardFocus(QObject):
    """Watches the one widget of a window that has the focus, and the outcrop."""

    def __init__(
        self, window: QMainWindow, center_widget: Callable[[], QWidget], *opened: SignalInstance
    ) -> None:
        """seen : gives what stands in the middle of the window, outcrop or photo. opened : sent
        when something was opened, which is then looked at"""
        super().__init__(window)
        self._window, self._center_widget = window, center_widget
        self._entered: QWidget | None = None
        self._watched: QWidget | None = None
        self._passed_on: QWidget | None = None
        self._cell: QWidget | None = None
        self._confirmed = False
        self._text = ""
        self._has_typed = False
        self._cursor = QCursor.pos()
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._focus_changed)
        for signal in opened:
            signal.connect(self.to_outcrop)
        self.look()

    @property
    def _outcrop(self) -> QWidget:
        return self._center_widget()

    def look(self) -> None:
        """Something else is seen: it takes the keyboard, and again when the cursor comes over
        it."""
        if self._entered is not None and shiboken6.isValid(self._entered):
            self._entered.removeEventFilter(self)
        self._entered = self._outcrop
        self._entered.installEventFilter(self)
        self.to_outcrop()

    def to_outcrop(self, *_: object) -> None:
        """Give the outcrop the focus, unless text is being edited."""
        if self._outcrop.isVisible() and not self._editing():
            self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)

    def _editing(self) -> bool:
        """The text of the field that has the focus was changed and is not confirmed yet."""
        now = self._window.focusWidget()
        if now is None or not now.isVisible():
            return False
        if now is not self._watched or not _is_text(now):
            # The editor of a cell is not ours to end.
            return _is_text(now)
        # The arrows of a number's field change it for good.
        changed = not isinstance(now, QAbstractSpinBox) and _text_of(now) != self._text
        return self._has_typed or changed

    def _rests(self, entered: QEnterEvent) -> bool:
        """A field has the focus, and the cursor has not been moved since: what lay over the
        outcrop went away, and nobody went there."""
        now = self._window.focusWidget()
        position = entered.globalPosition().toPoint()
        return now is not None and _is_text(now) and position == self._cursor

    # --- who has it --------------------------------------------------------------------------
    def _focus_changed(self, old: QWidget | None, new: QWidget | None) -> None:
        self._leave()
        if new is None:
            return
        if self._left_cell(old, new):
            self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)
            return
        if not self._serves(new):
            return
        if old is not None and self._is_gone(old):
            # Qt hands it to whatever comes next, which nobody has asked for.
            self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)
            return
        self._watched, self._text, self._has_typed = new, _text_of(new), False
        self._cursor = QCursor.pos()
        new.installEventFilter(self)
        if isinstance(new, QComboBox) and not new.property(_KNOWN):
            new.setProperty(_KNOWN, True)
            new.activated.connect(self._return_focus)

    def _leave(self) -> None:
        before = (self._watched, self._passed_on)
        self._watched = self._passed_on = None
        for widget in before:
            # What was confirmed may have had its panel built anew.
            if widget is not None and shiboken6.isValid(widget):
                widget.removeEventFilter(self)

    def _left_cell(self, old: QWidget | None, new: QWidget) -> bool:
        """Enter has ended the editor of a cell, which leaves the focus to its table."""
        confirmed = old is not None and old is self._cell and self._confirmed
        if self._cell is not None and shiboken6.isValid(self._cell):
            self._cell.removeEventFilter(self)
        self._cell, self._confirmed = None, False
        table = _table_of(new)
        if table is not None and self._serves(table):
            self._cell = new
            # Before the delegate, which ends it.
            new.installEventFilter(self)
        return confirmed and isinstance(new, QAbstractItemView) and self._serves(new)

    def _is_gone(self, widget: QWidget) -> bool:
        """It lost the focus because it cannot have it any more; not where its window was closed."""
        if not shiboken6.isValid(widget):
            return True
        is_in_window = self._window.isAncestorOf(widget) and self._serves(widget)
        return is_in_window and not (widget.isVisible() and widget.isEnabled())

    def _serves(self, widget: QWidget) -> bool:
        """It stands in a dock or bar of the window, and has no keys of its own."""
        if widget is self._outcrop or isinstance(widget, QMenuBar | QMenu) or _has_own_keys(widget):
            return False
        above: QWidget | None = widget
        while above is not None and above is not self._window:
            if above is not widget and isinstance(above, QAbstractItemView):
                return False
            if above.isWindow() and not isinstance(above, QDockWidget):
                return False
            above = above.parentWidget()
        return above is self._window

    # --- what it does with its keys ----------------------------------------------------------
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        kind = event.type()
        if watched is self._entered:
            come = isinstance(event, QEnterEvent) and not self._rests(event)
            if (come or kind == QEvent.Type.Wheel) and self._window_is_active():
                self.to_outcrop()
            return False
        if not isinstance(event, QKeyEvent):
            return False
        if watched is self._cell:
            if kind == QEvent.Type.KeyPress:
                self._confirmed = event.key() in _ENTER
            return False
        if watched is not self._watched:
            # A key that was passed on, and is no command.
            return watched is self._passed_on and kind == QEvent.Type.KeyPress
        if kind == QEvent.Type.ShortcutOverride:
            return self._pass_on(self._watched, event)
        return kind == QEvent.Type.KeyPress and self._press(self._watched, event)

    def _pass_on(self, widget: QWidget, event: QKeyEvent) -> bool:
        """Whether a key that is pressed shall do what it means in the outcrop."""
        if not self._belongs_to_outcrop(widget, event):
            return False
        # Qt looks for the command next, with the focus as it then is.
        self._outcrop.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self._passed_on = widget
        widget.installEventFilter(self)
        event.ignore()
        return True

    def _window_is_active(self) -> bool:
        active = QApplication.activeWindow()
        return active is self._window or isinstance(active, QDockWidget)

    def _belongs_to_outcrop(self, widget: QWidget, event: QKeyEvent) -> bool:
        if event.modifiers() & _COMMAND_KEYS or _has_shortcut(widget, event):
            return False
        letter = event.text() if event.text().isprintable() else ""
        if isinstance(widget, QAbstractSpinBox):
            allowed = _IN_NUMBERS + widget.locale().decimalPoint() + _around(widget)
            return bool(letter) and letter not in allowed
        if _is_text(widget):
            return False
        if isinstance(widget, QAbstractItemView) and (
            event.key() in _ENTER or _goes_into_cell(widget, letter)
        ):
            return False
        if event.key() in _ENTER:
            return True
        return bool(letter) and event.key() != Qt.Key.Key_Space

    def _press(self, widget: QWidget, event: QKeyEvent) -> bool:
        """Whether the key was dealt with."""
        if isinstance(widget, QComboBox) and not widget.isEditable():
            if event.key() in _STEPS and not event.modifiers() & _COMMAND_KEYS:
                widget.showPopup()
                return True
            return False
        if not _is_text(widget):
            return False
        if event.key() == Qt.Key.Key_Escape:
            _put_back(widget, self._text)
        elif event.key() in _ENTER and not isinstance(widget, QPlainTextEdit | QTextEdit):
            # The field confirms it first, and has it for itself: it finishes nothing else.
            widget.event(event)
        else:
            self._has_typed |= bool(event.text()) and event.key() != Qt.Key.Key_Tab
            return False
        self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)
        return True

    def _return_focus(self) -> None:
        self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)


def _has_own_keys(widget: QWidget) -> bool:
    """Plain keys were given to it, as to the photo. A button has the action that it stands for."""
    contexts = (Qt.ShortcutContext.WidgetShortcut, Qt.ShortcutContext.WidgetWithChildrenShortcut)
    return not isinstance(widget, QAbstractButton) and any(
        action.shortcuts() and action.shortcutContext() in contexts for action in widget.actions()
    )


def _table_of(widget: QWidget) -> QAbstractItemView | None:
    """The view of which it is the editor of a cell."""
    room = widget.parentWidget()
    view = None if room is None else room.parentWidget()
    return view if isinstance(view, QAbstractItemView) and view.viewport() is room else None


def _goes_into_cell(view: QAbstractItemView, letter: str) -> bool:
    """The view is filled in by hand, and its current cell takes what was typed."""
    cell = view.currentIndex()
    edit_trigger = QAbstractItemView.EditTrigger.AnyKeyPressed
    if not letter or not view.editTriggers() & edit_trigger or not cell.isValid():
        return False
    if not cell.flags() & Qt.ItemFlag.ItemIsEditable:
        return False
    side = cell.data(Qt.ItemDataRole.TextAlignmentRole)
    is_number = side is not None and bool(Qt.AlignmentFlag(side) & Qt.AlignmentFlag.AlignRight)
    return letter in _IN_NUMBERS or not is_number


def _is_text(widget: QWidget) -> bool:
    if isinstance(widget, QComboBox):
        return widget.isEditable()
    if isinstance(widget, QLineEdit | QPlainTextEdit | QTextEdit):
        return not widget.isReadOnly()
    return isinstance(widget, QAbstractSpinBox)


def _text_of(widget: QWidget) -> str:
    if isinstance(widget, QComboBox):
        return widget.currentText()
    if isinstance(widget, QLineEdit | QAbstractSpinBox):
        return widget.text()
    if isinstance(widget, QPlainTextEdit | QTextEdit):
        return widget.toPlainText()
    return ""


def _put_back(widget: QWidget, text: str) -> None:
    if _text_of(widget) == text:
        return
    if isinstance(widget, QLineEdit):
        widget.setText(text)
    elif isinstance(widget, QAbstractSpinBox):
        widget.lineEdit().setText(text)
        widget.interpretText()
    elif isinstance(widget, QComboBox):
        widget.setEditText(text)
    elif isinstance(widget, QPlainTextEdit | QTextEdit):
        widget.setPlainText(text)


def _around(widget: QAbstractSpinBox) -> str:
    """The letters of what a number's field shows beside the number."""
    parts = (getattr(widget, name, None) for name in ("prefix", "suffix"))
    return "".join(part() for part in parts if part is not None) + widget.specialValueText()


def _has_shortcut(widget: QWidget, event: QKeyEvent) -> bool:
    """The widget itself has a shortcut on this key."""
    pressed = QKeySequence(event.keyCombination())
    shortcuts = (child for child in widget.children() if isinstance(child, QShortcut))
    return any(key == pressed for shortcut in shortcuts for key in QShortcut.keys(shortcut))
