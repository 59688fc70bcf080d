"""A line edit that filters features and shows why a filter cannot be read."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QLineEdit, QSizePolicy

from vomstudio.core.errors import UsageError
from vomstudio.ui.base.controls import Label
from vomstudio.ui.panels.features.feature_filter import Test, help_text, parse_filter


class FilterLine(QLineEdit):
    """`test` is None while nothing is filtered. A filter that cannot be read leaves the last test
    unchanged; `problem`, a label for its owner to place, says why."""

    changed = Signal()

    def __init__(self, placeholder: str, *, wraps: bool = False) -> None:
        super().__init__()
        self.test: Test | None = None
        self.problem = Label()
        self.problem.setWordWrap(wraps)
        if not wraps:
            # Cut off rather than make the panel wider; the tip has all of it.
            self.problem.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.problem.hide()
        self.setPlaceholderText(placeholder)
        self.setClearButtonEnabled(True)
        self.setToolTip(help_text())
        self.textChanged.connect(self._read)

    def _read(self, text: str) -> None:
        try:
            self.test = parse_filter(text) if text.strip() else None
            says = ""
        except UsageError as error:
            says = error.message
        self.problem.setText(says)
        self.problem.setToolTip(says)
        self.problem.setVisible(bool(says))
        palette = QPalette()
        if says:
            # Amber: the same as what is doubtful.
            dark = palette.color(QPalette.ColorRole.Base).lightness() < 128
            palette.setColor(QPalette.ColorRole.Text, QColor("#ffb938" if dark else "#a35f00"))
        self.setPalette(palette)
        if not says:
            self.changed.emit()
