"""What on the screen the documentation explains: F1 opens it there."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QApplication, QWidget

from vomstudio.project.figures import Figure

_PROPERTY = "explained_by"

HelpTopic = str | Figure
"""A place in the documentation, "PAGE.md#HEADING", or a figure."""
TopicFinder = Callable[[QPoint], HelpTopic | None]
"""From a place in the widget, in pixels, to what is explained of it."""


def explain(widget: QWidget, what: HelpTopic | TopicFinder) -> None:
    """From now on F1 explains this widget. what : or what tells it for a place in the widget"""
    widget.setProperty(_PROPERTY, _Holder(what))


def current_help_topic() -> HelpTopic | None:
    """What lies under the cursor, else what has the focus, and is explained somewhere."""
    at = QCursor.pos()
    under = QApplication.widgetAt(at)
    found = None if under is None else find_help_topic(under, at)
    focused = QApplication.focusWidget()
    if found is None and focused is not None:
        found = find_help_topic(focused, focused.mapToGlobal(focused.rect().center()))
    return found


def find_help_topic(widget: QWidget, at: QPoint) -> HelpTopic | None:
    """Of a widget, or of the nearest one in which it lies. at : on the screen"""
    above: QWidget | None = widget
    while above is not None:
        held = above.property(_PROPERTY)
        if isinstance(held, _Holder):
            what = held.what
            found = what(above.mapFromGlobal(at)) if callable(what) else what
            if found is not None:
                return found
        above = above.parentWidget()
    return None


class _Holder:
    """Qt would take a text or a list apart."""

    def __init__(self, what: HelpTopic | TopicFinder) -> None:
        self.what = what
