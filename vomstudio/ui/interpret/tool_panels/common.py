"""What the panels of the tools have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QCoreApplication
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFormLayout, QLabel, QLineEdit, QVBoxLayout, QWidget

from vomstudio.ui.common.widgets import action_buttons

_PICKING = ("finish", "cancel", "continue_trace", "delete_vertex")


def narrow_form() -> QFormLayout:
    """For a dock, where height is dear."""
    form = QFormLayout()
    form.setContentsMargins(0, 0, 0, 0)
    form.setVerticalSpacing(3)
    return form


def set_field(typed: Callable[[], None]) -> QLineEdit:
    """Of the set of what is made next."""
    field = QLineEdit()
    field.setPlaceholderText(QCoreApplication.translate("ToolPanel", "none"))
    field.editingFinished.connect(typed)
    return field


def hint_label(text: str = "") -> QLabel:
    label = QLabel(text)
    label.setWordWrap(True)
    return label


def narrow_column(panel: QWidget) -> QVBoxLayout:
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
    hint: QLabel,
) -> None:
    """Of a tool that picks vertices: fields, live figures, vertices, what to do, buttons."""
    column = narrow_column(panel)
    column.addLayout(form)
    column.addWidget(figures)
    column.addWidget(table, 1)
    column.addWidget(hint)
    column.addStretch()
    column.addLayout(action_buttons([actions[name] for name in _PICKING]))
