"""Table of known lines and planes: use, known quantity, value and residual."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds.known_line import KINDS, KnownLine, format_reading
from vomstudio.ui.base import theme
from vomstudio.ui.base.numbers import parse_quantity

TICK, LABEL, QUANTITY, VALUE, SIGMA, RESIDUAL = range(6)
_READ_ONLY = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
_KIND_NAMES = dict(KINDS)
_UNITS = {"length": " m"}
_DECIMALS = {"length": 3, "plane": 1, "lineation": 1}
MAX_SIGMA_DEG = {"level": 45.0, "plumb": 45.0, "azimuth": 90.0, "plane": 90.0, "lineation": 90.0}


class KnownTable(QTableWidget):
    """Table with one row per line, hidden if empty; its height fits up to six rows."""

    def __init__(self) -> None:
        super().__init__(0, RESIDUAL + 1)
        self.setObjectName("known_lines")
        self.setAccessibleName(tr("Known lines and planes"))
        self.setHorizontalHeaderLabels(
            [tr("Use"), tr("Label"), tr("Quantity"), tr("Value"), "± (1σ)", tr("Residual")]
        )
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(23)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(RESIDUAL, QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(34)
        for column, tooltip in (
            (TICK, tr("Ticked lines register the model; the others check it.")),
            (
                VALUE,
                tr("Azimuth (°), length (m), or compass reading, such as 213/45."),
            ),
            (
                SIGMA,
                tr("Standard error; if empty, the default (level 0.5°, azimuth 3°, length 0.5 %)."),
            ),
            (
                RESIDUAL,
                tr("Residual: fitted minus known, or the angle to a compass reading."),
            ),
        ):
            item = self.horizontalHeaderItem(column)
            if item is not None:
                item.setToolTip(tooltip)
        self.hide()

    def show_lines(self, lines: Sequence[KnownLine], notation: str) -> None:
        """Show the lines; planes are formatted in the given notation."""
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        with QSignalBlocker(self):
            self.setRowCount(len(lines))
            for row, line in enumerate(lines):
                tick = QTableWidgetItem()
                tick.setFlags(_READ_ONLY | Qt.ItemFlag.ItemIsUserCheckable)
                tick.setCheckState(Qt.CheckState.Unchecked if line.check else Qt.CheckState.Checked)
                quantity = QTableWidgetItem(tr(_KIND_NAMES[line.kind]))
                quantity.setFlags(_READ_ONLY)
                value = QTableWidgetItem(format_value(line, notation))
                if not line.has_value:
                    value = QTableWidgetItem("–")
                    value.setFlags(_READ_ONLY)
                sigma = QTableWidgetItem("" if line.sigma is None else _format_number(line.sigma))
                residual = QTableWidgetItem()
                residual.setFlags(_READ_ONLY)
                for item in (value, sigma, residual):
                    item.setTextAlignment(right)
                cells = (tick, QTableWidgetItem(line.name), quantity, value, sigma, residual)
                for column, item in enumerate(cells):
                    self.setItem(row, column, item)
        self.setVisible(bool(lines))
        row_count = min(len(lines), 6)
        self.setFixedHeight(self.horizontalHeader().sizeHint().height() + 23 * row_count + 6)

    def show_residuals(
        self,
        lines: Sequence[KnownLine],
        residuals: Mapping[str, float],
        blunders: set[str],
        tips: Mapping[str, str],
    ) -> None:
        """Show residuals and tooltips by line id, and mark blunders by label."""
        alert_icon = theme.icon("alert-outline")
        with QSignalBlocker(self):
            for row, line in enumerate(lines):
                residual_item, label_item = self.item(row, RESIDUAL), self.item(row, LABEL)
                if residual_item is None or label_item is None:
                    continue
                residual = residuals.get(line.id)
                unit, digits = _UNITS.get(line.kind, "°"), _DECIMALS.get(line.kind, 2)
                sign = "" if line.is_read else "+"
                # A residual that rounds to zero must not have a sign.
                residual = None if residual is None else round(residual, digits) or 0.0
                residual_item.setText(
                    ""
                    if residual is None
                    else f"{residual:{sign}.{digits}f}{unit}"
                    if residual
                    else "0"
                )
                if not line.is_complete:
                    residual_item.setText(tr("enter its value"))
                elif line.is_read and residual is None and line.id in tips:
                    residual_item.setText(tr("missing"))
                residual_item.setToolTip(tips.get(line.id, ""))
                label_item.setIcon(alert_icon if line.name in blunders else QIcon())

    def edit_value(self, row: int) -> None:
        """Open the editor for the value of a new line."""
        item = self.item(row, VALUE)
        if item is not None:
            self.setCurrentItem(item)
            self.setFocus()
            self.editItem(item)


def apply_cell(line: KnownLine, column: int, item: QTableWidgetItem, notation: str) -> KnownLine:
    """Return the line with the edited cell applied; planes are parsed in this notation.

    Raises
    ------
    UsageError, InputError
        If the text is not a valid value.
    """
    if column == TICK:
        return replace(line, check=item.checkState() != Qt.CheckState.Checked)
    text = item.text().strip()
    if column == LABEL:
        return replace(line, name=text or line.name)
    if line.is_read and column == VALUE:
        return _apply_reading(line, text, notation)
    if not text:
        return replace(line, value=None) if column == VALUE else replace(line, sigma=None)
    value = parse_quantity(text, "m" if line.kind == "length" else "°")
    number = float("nan") if value is None else value
    code = "number.not-a-length" if line.kind == "length" else "number.not-an-angle"
    if column == SIGMA:
        if not 0.0 < number <= MAX_SIGMA_DEG.get(line.kind, 1e6):
            raise UsageError(Finding(code, text=text))
        return replace(line, sigma=number)
    if line.kind == "azimuth" and not -360.0 <= number <= 360.0:
        raise UsageError(Finding(code, text=text))
    if line.kind == "length" and not 0.0 < number < 1e9:
        raise UsageError(Finding(code, text=text))
    return replace(line, value=number % 360.0 if line.kind == "azimuth" else number)


def format_value(line: KnownLine, notation: str) -> str:
    """Format the known value of a line or plane in the form in which it is typed."""
    if line.is_read:
        return format_reading(line, notation)
    return "" if line.value is None else _format_number(line.value)


def _apply_reading(line: KnownLine, text: str, notation: str) -> KnownLine:
    from vomstudio.studio.placing.known_planes import parse_reading

    reading = parse_reading(text, "plane" if line.kind == "plane" else "lineation", notation)
    return replace(
        line,
        value=reading.azimuth_deg,
        inclination_deg=reading.inclination_deg,
        sigma=line.sigma if reading.sigma_deg is None else reading.sigma_deg,
    )


def _format_number(value: float) -> str:
    return f"{value:.10g}"
