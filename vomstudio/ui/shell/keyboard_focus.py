"""Keyboard focus of the main window, which follows the user's attention.

This module decides when the outcrop has the focus, or the photo that is open in its place. In
the following, "outcrop" means whichever of the two is visible.

Outside the outcrop, only a text that is being edited keeps the keyboard focus. The following
rules apply to all docks of the window, and to the widgets around an open photo:

- The cursor or the wheel over the outcrop moves the focus there, unless a text has been changed
  and not yet confirmed. A field loses the focus only after the cursor has moved. Otherwise a field
  that is to be filled in after a click would lose it when a hint closes.
- A choice in a combo box, and Enter or Esc in a field, return the focus to the outcrop. Esc
  restores the previous text of the field and has no other effect.
- A letter that is pressed in a combo box, a list or on a button is passed to the outcrop. Arrow
  keys open a combo box instead of changing its hidden selection.
- A number field keeps digits, and the letters of a unit after a length ("30 cm"); other letters
  are passed to the outcrop.
- In an editable table, typed text goes into the current cell; a number cell accepts only numeric
  characters. Enter in a cell returns the focus to the outcrop.
- A widget that is hidden or disabled passes the focus to the outcrop.

Dialogs and other windows, cells that are being edited in a table, and widgets with their own
keys (such as the photo in a panel) are not affected.
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

from vomstudio.ui.base.controls import DoubleSpinBox, SpinBox, continues_unit

_ENTER_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
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
_CONNECTED_PROPERTY = "hands_the_keyboard_back"
_NUMBER_CHARACTERS = "0123456789+-.,eE \N{MINUS SIGN}\N{DEGREE SIGN}"


class KeyboardFocus(QObject):
    """Watcher of the focus widget of a window, which moves the focus to the outcrop."""

    def __init__(
        self,
        window: QMainWindow,
        center_widget: Callable[[], QWidget],
        *opened_signals: SignalInstance,
    ) -> None:
        """Watch the focus of a window.

        Parameters
        ----------
        window : QMainWindow
        center_widget : callable
            Returns the visible widget in the centre of the window, outcrop or photo.
        *opened_signals : SignalInstance
            Signals emitted after data have been opened in the centre, which then gets the focus.
        """
        super().__init__(window)
        self._window, self._center_widget = window, center_widget
        self._entered_widget: QWidget | None = None
        self._watched_editor: QWidget | None = None
        self._filtered_widget: QWidget | None = None
        self._cell: QWidget | None = None
        self._is_confirmed = False
        self._text = ""
        self._has_typed = False
        self._cursor = QCursor.pos()
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._focus_changed)
        for signal in opened_signals:
            signal.connect(self.focus_outcrop)
        self.focus_new_center()

    @property
    def _outcrop(self) -> QWidget:
        return self._center_widget()

    def focus_new_center(self) -> None:
        """Move the focus to a new centre widget, now and whenever the cursor enters it."""
        if self._entered_widget is not None and shiboken6.isValid(self._entered_widget):
            self._entered_widget.removeEventFilter(self)
        self._entered_widget = self._outcrop
        self._entered_widget.installEventFilter(self)
        self.focus_outcrop()

    def focus_outcrop(self, *_: object) -> None:
        """Give the outcrop the focus, unless text is being edited."""
        if self._outcrop.isVisible() and not self._is_editing():
            self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)

    def _is_editing(self) -> bool:
        """Return whether a text field has the focus and may have uncommitted changes."""
        focus_widget = self._window.focusWidget()
        if focus_widget is None or not focus_widget.isVisible():
            return False
        if focus_widget is not self._watched_editor or not _is_text(focus_widget):
            # The editor of a cell must be closed by its table.
            return _is_text(focus_widget)
        # The arrow buttons of a number field change its value permanently.
        is_changed = (
            not isinstance(focus_widget, QAbstractSpinBox)
            and _editor_text(focus_widget) != self._text
        )
        return self._has_typed or is_changed

    def _keeps_focus(self, event: QEnterEvent) -> bool:
        """Return whether a field has the focus and the cursor has not moved since it was focused.

        In this case, the outcrop was entered only because a widget above it disappeared.
        """
        focus_widget = self._window.focusWidget()
        position = event.globalPosition().toPoint()
        return focus_widget is not None and _is_text(focus_widget) and position == self._cursor

    # --- who has it --------------------------------------------------------------------------
    def _focus_changed(self, old: QWidget | None, new: QWidget | None) -> None:
        self._leave()
        if new is None:
            return
        if self._has_left_cell(old, new):
            self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)
            return
        if not self._is_in_widget(new):
            return
        if old is not None and self._is_gone(old):
            # Qt would pass the focus to the next widget, which the user has not requested.
            self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)
            return
        self._watched_editor, self._text, self._has_typed = new, _editor_text(new), False
        self._cursor = QCursor.pos()
        new.installEventFilter(self)
        if isinstance(new, QComboBox) and not new.property(_CONNECTED_PROPERTY):
            new.setProperty(_CONNECTED_PROPERTY, True)
            new.activated.connect(self._return_focus)

    def _leave(self) -> None:
        previous_state = (self._watched_editor, self._filtered_widget)
        self._watched_editor = self._filtered_widget = None
        for widget in previous_state:
            # The panel may have been rebuilt after the confirmation.
            if widget is not None and shiboken6.isValid(widget):
                widget.removeEventFilter(self)

    def _has_left_cell(self, old: QWidget | None, new: QWidget) -> bool:
        """Return whether Enter has closed a cell editor, so that its table gets the focus."""
        confirmed = old is not None and old is self._cell and self._is_confirmed
        if self._cell is not None and shiboken6.isValid(self._cell):
            self._cell.removeEventFilter(self)
        self._cell, self._is_confirmed = None, False
        table = _find_table(new)
        if table is not None and self._is_in_widget(table):
            self._cell = new
            # Handled before the delegate, which closes the editor.
            new.installEventFilter(self)
        return confirmed and isinstance(new, QAbstractItemView) and self._is_in_widget(new)

    def _is_gone(self, widget: QWidget) -> bool:
        """Return whether a widget lost the focus because it was deleted, hidden or disabled."""
        if not shiboken6.isValid(widget):
            return True
        is_in_window = self._window.isAncestorOf(widget) and self._is_in_widget(widget)
        return is_in_window and not (widget.isVisible() and widget.isEnabled())

    def _is_in_widget(self, widget: QWidget) -> bool:
        """Return whether a widget is in a dock or bar of the window and has no keys of its own."""
        if widget is self._outcrop or isinstance(widget, QMenuBar | QMenu) or _has_own_keys(widget):
            return False
        ancestor: QWidget | None = widget
        while ancestor is not None and ancestor is not self._window:
            if ancestor is not widget and isinstance(ancestor, QAbstractItemView):
                return False
            if ancestor.isWindow() and not isinstance(ancestor, QDockWidget):
                return False
            ancestor = ancestor.parentWidget()
        return ancestor is self._window

    # --- what it does with its keys ----------------------------------------------------------
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        event_type = event.type()
        if watched is self._entered_widget:
            is_entering = isinstance(event, QEnterEvent) and not self._keeps_focus(event)
            if (is_entering or event_type == QEvent.Type.Wheel) and self._window_is_active():
                self.focus_outcrop()
            return False
        if not isinstance(event, QKeyEvent):
            return False
        if watched is self._cell:
            if event_type == QEvent.Type.KeyPress:
                self._is_confirmed = event.key() in _ENTER_KEYS
            return False
        if watched is not self._watched_editor:
            # This key was passed on and does not belong to a command.
            return watched is self._filtered_widget and event_type == QEvent.Type.KeyPress
        if event_type == QEvent.Type.ShortcutOverride:
            return self._pass_on(self._watched_editor, event)
        return event_type == QEvent.Type.KeyPress and self._press_key(self._watched_editor, event)

    def _pass_on(self, widget: QWidget, event: QKeyEvent) -> bool:
        """Move the focus to the outcrop if a pressed key belongs to it; return whether it does."""
        if not self._belongs_to_outcrop(widget, event):
            return False
        # Qt searches for the command next, using the focus at that time.
        self._outcrop.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self._filtered_widget = widget
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
            allowed_characters = (
                _NUMBER_CHARACTERS + widget.locale().decimalPoint() + _affix_text(widget)
            )
            if isinstance(widget, SpinBox | DoubleSpinBox) and continues_unit(widget, letter):
                return False
            return bool(letter) and letter not in allowed_characters
        if _is_text(widget):
            return False
        if isinstance(widget, QAbstractItemView) and (
            event.key() in _ENTER_KEYS or _is_cell_input(widget, letter)
        ):
            return False
        if event.key() in _ENTER_KEYS:
            return True
        return bool(letter) and event.key() != Qt.Key.Key_Space

    def _press_key(self, widget: QWidget, event: QKeyEvent) -> bool:
        """Handle a pressed key, and return whether it was handled."""
        if isinstance(widget, QComboBox) and not widget.isEditable():
            if event.key() in _STEPS and not event.modifiers() & _COMMAND_KEYS:
                widget.showPopup()
                return True
            return False
        if not _is_text(widget):
            return False
        if event.key() == Qt.Key.Key_Escape:
            _restore_text(widget, self._text)
        elif event.key() in _ENTER_KEYS and not isinstance(widget, QPlainTextEdit | QTextEdit):
            # The key only confirms the field and does not finish a feature.
            widget.event(event)
        else:
            self._has_typed |= bool(event.text()) and event.key() != Qt.Key.Key_Tab
            return False
        self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)
        return True

    def _return_focus(self) -> None:
        self._outcrop.setFocus(Qt.FocusReason.OtherFocusReason)


def _has_own_keys(widget: QWidget) -> bool:
    """Return whether plain keys are assigned to a widget, such as the photo.

    A button also has an action, but this action triggers the button itself.
    """
    contexts = (Qt.ShortcutContext.WidgetShortcut, Qt.ShortcutContext.WidgetWithChildrenShortcut)
    return not isinstance(widget, QAbstractButton) and any(
        action.shortcuts() and action.shortcutContext() in contexts for action in widget.actions()
    )


def _find_table(widget: QWidget) -> QAbstractItemView | None:
    """Return the item view in which a widget is a cell editor, or None if it is not one."""
    ancestor_widget = widget.parentWidget()
    view = None if ancestor_widget is None else ancestor_widget.parentWidget()
    return (
        view if isinstance(view, QAbstractItemView) and view.viewport() is ancestor_widget else None
    )


def _is_cell_input(view: QAbstractItemView, letter: str) -> bool:
    """Return whether a view is editable and its current cell accepts a typed letter."""
    cell = view.currentIndex()
    edit_trigger = QAbstractItemView.EditTrigger.AnyKeyPressed
    if not letter or not view.editTriggers() & edit_trigger or not cell.isValid():
        return False
    if not cell.flags() & Qt.ItemFlag.ItemIsEditable:
        return False
    alignment = cell.data(Qt.ItemDataRole.TextAlignmentRole)
    is_number = alignment is not None and bool(
        Qt.AlignmentFlag(alignment) & Qt.AlignmentFlag.AlignRight
    )
    return letter in _NUMBER_CHARACTERS or not is_number


def _is_text(widget: QWidget) -> bool:
    if isinstance(widget, QComboBox):
        return widget.isEditable()
    if isinstance(widget, QLineEdit | QPlainTextEdit | QTextEdit):
        return not widget.isReadOnly()
    return isinstance(widget, QAbstractSpinBox)


def _editor_text(widget: QWidget) -> str:
    if isinstance(widget, QComboBox):
        return widget.currentText()
    if isinstance(widget, QLineEdit | QAbstractSpinBox):
        return widget.text()
    if isinstance(widget, QPlainTextEdit | QTextEdit):
        return widget.toPlainText()
    return ""


def _restore_text(widget: QWidget, text: str) -> None:
    if _editor_text(widget) == text:
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


def _affix_text(widget: QAbstractSpinBox) -> str:
    """Return the letters that a number field shows beside its number."""
    parts = (getattr(widget, name, None) for name in ("prefix", "suffix"))
    return "".join(part() for part in parts if part is not None) + widget.specialValueText()


def _has_shortcut(widget: QWidget, event: QKeyEvent) -> bool:
    """Return whether a widget itself has a shortcut with this key."""
    key_sequence = QKeySequence(event.keyCombination())
    shortcuts = (child for child in widget.children() if isinstance(child, QShortcut))
    return any(key == key_sequence for shortcut in shortcuts for key in QShortcut.keys(shortcut))
