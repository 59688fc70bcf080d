"""Parts that the panels of the tools share."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFormLayout, QLineEdit, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import Label, action_buttons

_PICKING = ("finish", "cancel", "continue_trace", "delete_vertex")


def set_field(typed: Callable[[], None]) -> QLineEdit:
    """Line edit for the set of the next feature."""
    field = QLineEdit()
    field.setPlaceholderText(tr("none"))
    field.editingFinished.connect(typed)
    return field


def hint_label(text: str = "") -> Label:
    """A label of several lines."""
    label = Label(text)
    label.setWordWrap(True)
    return label


def narrow_column(panel: QWidget) -> QVBoxLayout:
    """A column layout for a dock, with narrow margins."""
    column = QVBoxLayout(panel)
    column.setContentsMargins(6, 4, 6, 4)
    column.setSpacing(4)
    return column


def lay_out_picking(
    panel: QWidget,
    actions: Mapping[str, QAction],
    form: QFormLayout,
    figures: QWidget,
    table: QWidget,
    hint: Label,
) -> None:
    """Panel of a tool that picks vertices: fields, live figures, vertices, hint, buttons."""
    column = narrow_column(panel)
    column.addLayout(form)
    column.addWidget(figures)
    column.addWidget(table, 1)
    column.addWidget(hint)
    column.addStretch()
    column.addLayout(action_buttons([actions[name] for name in _PICKING]))
