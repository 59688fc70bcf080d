"""Widgets and layouts shared by the panels of the tools."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFormLayout, QLineEdit, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import Label, action_buttons
from vomstudio.ui.widgets.more_section import MoreSection

MAX_CONTROLS = 6
"""Maximum number of controls of a tool page that are visible without opening *More*."""
END = ("finish", "cancel")
_EDITING = ("edit_feature", "delete_vertex")


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


def lay_out_picking(
    panel: QWidget,
    actions: Mapping[str, QAction],
    form: QFormLayout,
    figures: QWidget,
    table: QWidget,
    hint: Label,
    more_settings: Sequence[QWidget] = (),
) -> None:
    """Lay out the panel of a tool that picks vertices.

    The vertices, `more_settings` and the commands for editing are folded.
    """
    column = narrow_column(panel)
    column.addLayout(form)
    column.addWidget(figures)
    column.addLayout(action_buttons([actions[name] for name in END]))
    column.addWidget(hint)
    editing = action_buttons([actions[name] for name in _EDITING])
    column.addWidget(MoreSection(*more_settings, table, editing), 1)
    column.addStretch()
