"""Collapsible section of rarely used settings at the end of a tool page."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLayout, QSizePolicy, QToolButton, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme


class MoreSection(QWidget):
    """Button "More" with settings below it, which are hidden at first.

    Attributes
    ----------
    body : QWidget
        Widget that is hidden while the section is closed.
    """

    def __init__(self, *contents: QWidget | QLayout) -> None:
        super().__init__()
        self.toggle = QToolButton()
        self.toggle.setObjectName("more")
        self.toggle.setText(tr("More"))
        self.toggle.setCheckable(True)
        self.toggle.setAutoRaise(True)
        self.toggle.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.toggle.toggled.connect(self.set_open)
        self.body = QWidget()
        body_layout = QVBoxLayout(self.body)
        body_layout.setContentsMargins(0, 0, 0, 0)
        body_layout.setSpacing(4)
        for item in contents:
            if isinstance(item, QLayout):
                body_layout.addLayout(item)
            else:
                body_layout.addWidget(item)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.toggle)
        column.addWidget(self.body, 1)
        self.set_open(False)

    def set_open(self, is_open: bool) -> None:
        """Show or hide the settings."""
        self.toggle.setChecked(is_open)
        arrow = Qt.ArrowType.DownArrow if is_open else Qt.ArrowType.RightArrow
        self.toggle.setArrowType(arrow)
        self.body.setVisible(is_open)
        height = QSizePolicy.Policy.Preferred if is_open else QSizePolicy.Policy.Maximum
        self.setSizePolicy(QSizePolicy.Policy.Preferred, height)


class ModeBar(QWidget):
    """Row of buttons for the exclusive states of one setting, with icons or with names."""

    def __init__(self, actions: Sequence[QAction], names: Sequence[str] = ()) -> None:
        super().__init__()
        for action, name in zip(actions, names, strict=False):
            action.setIconText(name)
        style = Qt.ToolButtonStyle
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        for action in actions:
            button = QToolButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(
                style.ToolButtonTextBesideIcon if names else style.ToolButtonIconOnly
            )
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            theme.highlight_toggles(button)
            row.addWidget(button)
