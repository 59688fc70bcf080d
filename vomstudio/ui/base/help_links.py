"""What on the screen the documentation explains: F1 opens it there."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QApplication, QWidget

from vomstudio.project.figures import Figure

_PROPERTY = "explained_by"

Explained = str | Figure
"""A place in the documentation, "PAGE.md#HEADING", or a figure."""
At = Callable[[QPoint], Explained | None]
"""From a place in the widget, in pixels, to what is explained of it."""


def explain(widget: QWidget, what: Explained | At) -> None:
    """From now on F1 explains this widget. what : or what tells it for a place in the widget"""
    widget.setProperty(_PROPERTY, _Holder(what))


def explained_here() -> Explained | None:
    """What lies under the cursor, else what has the focus, and is explained somewhere."""
    at = QCursor.pos()
    under = QApplication.widgetAt(at)
    found = None if under is None else explanation_of(under, at)
    focused = QApplication.focusWidget()
    if found is None and focused is not None:
        found = explanation_of(focused, focused.mapToGlobal(focused.rect().center()))
    return found


def explanation_of(widget: QWidget, at: QPoint) -> Explained | None:
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

    def __init__(self, what: Explained | At) -> None:
        self.what = what
