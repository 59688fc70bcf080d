"""Line edit that filters features and reports invalid filters."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QLineEdit, QSizePolicy

from vomstudio.core.errors import UsageError
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label
from vomstudio.ui.panels.features.feature_filter import Test, help_text, parse_filter


class FilterLine(QLineEdit):
    """Line edit that parses its text into a test of rows.

    Attributes
    ----------
    test : callable or None
        Last valid test, or None if there is no filter.
    problem : Label
        Error message of an invalid filter; the owner adds it to a layout.
    """

    changed = Signal()

    def __init__(self, placeholder: str, *, has_word_wrap: bool = False) -> None:
        super().__init__()
        self.test: Test | None = None
        self.problem = Label()
        self.problem.setWordWrap(has_word_wrap)
        if not has_word_wrap:
            # The label must not widen the panel; its tooltip contains the full text.
            self.problem.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.problem.hide()
        self.setPlaceholderText(placeholder)
        self.setClearButtonEnabled(True)
        self.setToolTip(help_text())
        self.textChanged.connect(self._parse)

    def _parse(self, text: str) -> None:
        try:
            self.test = parse_filter(text) if text.strip() else None
            message = ""
        except UsageError as error:
            message = error.message
        self.problem.setText(message)
        self.problem.setToolTip(message)
        self.problem.setVisible(bool(message))
        palette = QPalette()
        if message:
            palette.setColor(QPalette.ColorRole.Text, theme.error_color())
        self.setPalette(palette)
        if not message:
            self.changed.emit()
