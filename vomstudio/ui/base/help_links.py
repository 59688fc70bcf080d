"""Help topics of widgets: F1 opens the documentation of the widget under the cursor."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QApplication, QWidget

from vomstudio.project.figures import Figure

_TOPIC_PROPERTY = "explained_by"

HelpTopic = str | Figure
"""Address in the documentation ("PAGE.md#HEADING"), or a figure of the catalogue."""
TopicFinder = Callable[[QPoint], HelpTopic | None]
"""Function that returns the topic at a position in a widget, in pixels."""


def set_help_topic(widget: QWidget, topic: HelpTopic | TopicFinder) -> None:
    """Set the help topic that F1 opens for a widget.

    Parameters
    ----------
    topic : HelpTopic or TopicFinder
        The topic, or a function that returns it for a position in the widget.
    """
    widget.setProperty(_TOPIC_PROPERTY, _TopicHolder(topic))


def current_help_topic() -> HelpTopic | None:
    """Return the topic of the widget under the cursor, else of the focus widget, or None."""
    position = QCursor.pos()
    widget = QApplication.widgetAt(position)
    topic = None if widget is None else find_help_topic(widget, position)
    focus_widget = QApplication.focusWidget()
    if topic is None and focus_widget is not None:
        topic = find_help_topic(
            focus_widget, focus_widget.mapToGlobal(focus_widget.rect().center())
        )
    return topic


def find_help_topic(widget: QWidget, position: QPoint) -> HelpTopic | None:
    """Return the topic of a widget or of its nearest ancestor with a topic, or None.

    Parameters
    ----------
    position : QPoint
        Global position in pixels.
    """
    ancestor: QWidget | None = widget
    while ancestor is not None:
        holder = ancestor.property(_TOPIC_PROPERTY)
        if isinstance(holder, _TopicHolder):
            source = holder.topic
            topic = source(ancestor.mapFromGlobal(position)) if callable(source) else source
            if topic is not None:
                return topic
        ancestor = ancestor.parentWidget()
    return None


class _TopicHolder:
    """Wrapper of a topic, because Qt would convert a string or a list."""

    def __init__(self, topic: HelpTopic | TopicFinder) -> None:
        self.topic = topic
