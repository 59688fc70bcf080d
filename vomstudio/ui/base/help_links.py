"""Help topics of widgets: F1 opens the documentation of the widget under the cursor."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QApplication, QWidget

from vomstudio.project.figures import Figure

_PROPERTY = "explained_by"

HelpTopic = str | Figure
"""Address in the documentation, "PAGE.md#HEADING", or a figure."""
TopicFinder = Callable[[QPoint], HelpTopic | None]
"""Returns the topic at a position in a widget, in pixels."""


def explain(widget: QWidget, topic: HelpTopic | TopicFinder) -> None:
    """Set the help topic that F1 opens for a widget.

    Parameters
    ----------
    topic : HelpTopic or TopicFinder
        The topic, or a function that returns it for a position in the widget.
    """
    widget.setProperty(_PROPERTY, _Holder(topic))


def current_help_topic() -> HelpTopic | None:
    """Return the topic of the widget under the cursor, or else of the focus widget."""
    position = QCursor.pos()
    widget = QApplication.widgetAt(position)
    topic = None if widget is None else find_help_topic(widget, position)
    focused = QApplication.focusWidget()
    if topic is None and focused is not None:
        topic = find_help_topic(focused, focused.mapToGlobal(focused.rect().center()))
    return topic


def find_help_topic(widget: QWidget, position: QPoint) -> HelpTopic | None:
    """Return the topic of a widget or of its nearest ancestor that has one.

    Parameters
    ----------
    position : QPoint
        Global position in pixels.
    """
    ancestor: QWidget | None = widget
    while ancestor is not None:
        holder = ancestor.property(_PROPERTY)
        if isinstance(holder, _Holder):
            source = holder.topic
            topic = source(ancestor.mapFromGlobal(position)) if callable(source) else source
            if topic is not None:
                return topic
        ancestor = ancestor.parentWidget()
    return None


class _Holder:
    """Wrapper of a topic, because Qt would convert a string or a list."""

    def __init__(self, topic: HelpTopic | TopicFinder) -> None:
        self.topic = topic
