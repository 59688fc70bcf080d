"""Small widgets that several panels use."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QWheelEvent
from PySide6.QtWidgets import QComboBox, QGridLayout, QSizePolicy, QToolButton


class ComboBox(QComboBox):
    """The wheel scrolls the panel: it must not change what the cursor happens to pass over."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def keep_narrow(self) -> None:
        """Long entries are read in the popup: they must not widen the panel."""
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.setSizeAdjustPolicy(policy)
        self.setMinimumContentsLength(10)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


def action_buttons(actions: Sequence[QAction]) -> QGridLayout:
    """Two buttons in a row, each with its icon and text."""
    grid = QGridLayout()
    grid.setSpacing(4)
    for i, action in enumerate(actions):
        button = QToolButton()
        button.setDefaultAction(action)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        grid.addWidget(button, i // 2, i % 2)
    return grid
