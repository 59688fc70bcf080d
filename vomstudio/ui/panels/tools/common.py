"""Widgets and layouts shared by the panels of the tools."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QLineEdit, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import Label

MAX_CONTROLS = 6
"""Maximum number of controls of a tool page that are visible without opening *More*."""
END_COMMANDS = ("finish", "cancel")


def create_set_field(callback: Callable[[], None]) -> QLineEdit:
    """Create a line edit for the set of the next feature."""
    field = QLineEdit()
    field.setPlaceholderText(tr("none"))
    field.editingFinished.connect(callback)
    return field


def hint_label(text: str = "") -> Label:
    """Create a label that wraps its text."""
    label = Label(text)
    label.setWordWrap(True)
    return label


def narrow_column(panel: QWidget) -> QVBoxLayout:
    """Create a vertical layout with narrow margins for a dock."""
    column = QVBoxLayout(panel)
    column.setContentsMargins(6, 4, 6, 4)
    column.setSpacing(4)
    return column
