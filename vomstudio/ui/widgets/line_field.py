"""Field for the trend and plunge of a line, typed or taken from the selected line."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QToolButton, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_line, parse_line
from vomstudio.geology.orientation import Line
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import current_measurement
from vomstudio.ui.base.controls import set_enabled
from vomstudio.ui.base.studio import Studio


class LineField(QWidget):
    """Field for the attitude of a line.

    Parameters
    ----------
    empty_text : str
        Placeholder of the empty field.

    Attributes
    ----------
    changed : Signal
        Emitted when the text changes.
    """

    changed = Signal()

    def __init__(self, studio: Studio, name: str, empty_text: str) -> None:
        super().__init__()
        self._studio = studio
        self.line = QLineEdit()
        self.line.setObjectName(name)
        self.line.setPlaceholderText(empty_text)
        self.line.textChanged.connect(lambda _: self.changed.emit())
        self.take_button = QToolButton()
        self.take_button.setToolTip(tr("Use the trend and plunge of the selected line."))
        self.take_button.setIcon(theme.icon("cursor-default-click-outline"))
        self.take_button.setAccessibleName(tr("Use selected"))
        self.take_button.clicked.connect(lambda _=False: self._use_selection())
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(3)
        row.addWidget(self.line, 1)
        row.addWidget(self.take_button)
        studio.selection_changed.connect(self._refresh)
        self._refresh()

    def direction(self) -> Line | None:
        """Return the line, or None if the field is empty. Raises InputError if it is invalid."""
        text = self.line.text().strip()
        return parse_line(text) if text else None

    def selected_line(self) -> Line | None:
        """Return the line of the selected feature, or None if it has no line."""
        measurement = current_measurement(self._studio)
        return None if measurement is None else measurement.line

    def _refresh(self) -> None:
        set_enabled(
            self.take_button, Finding("selection.no-line") if self.selected_line() is None else None
        )

    def _use_selection(self) -> None:
        if (line := self.selected_line()) is not None:
            self.line.setText(format_line(line, 1))
