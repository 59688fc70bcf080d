"""The table of known lines and planes: which are used, what is known of them, and what is left
over."""

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

TICK, LABEL, WHAT, VALUE, SIGMA, LEFT = range(6)
_READ_ONLY = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
_WORDS = dict(KINDS)
_UNITS = {"length": " m"}
_DIGITS = {"length": 3, "plane": 1, "lineation": 1}
_MOST_DEG = {"level": 45.0, "plumb": 45.0, "azimuth": 90.0, "plane": 90.0, "lineation": 90.0}


class KnownTable(QTableWidget):
    """A row for each line; it is as high as its rows, and hidden without any."""

    def __init__(self) -> None:
        super().__init__(0, LEFT + 1)
        self.setObjectName("known_lines")
        self.setAccessibleName(tr("Known lines and planes"))
        self.setHorizontalHeaderLabels(
            [tr("Use"), tr("Label"), tr("Known"), tr("Value"), "± (1σ)", tr("Residual")]
        )
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(23)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(LEFT, QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(34)
        for column, tip in (
            (TICK, tr("Ticked ones place the model, the others judge it.")),
            (
                VALUE,
                tr(
                    "Azimuth (°) from the first end to the second, length (m), or what was read "
                    "by compass, such as 213/45."
                ),
            ),
            (
                SIGMA,
                tr(
                    "One standard error; empty for what is usual: 0.5° of a level or plumb "
                    "line, 3° of an azimuth, 0.5 % of a length. Of planes and lines by compass "
                    "it is then taken from what is left over."
                ),
            ),
            (
                LEFT,
                tr(
                    "What is left over: placed less known; of planes and lines by compass the "
                    "angle between the two."
                ),
            ),
        ):
            item = self.horizontalHeaderItem(column)
            if item is not None:
                item.setToolTip(tip)
        self.hide()

    def show_lines(self, lines: Sequence[KnownLine], notation: str) -> None:
        """notation : of planes"""
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        with QSignalBlocker(self):
            self.setRowCount(len(lines))
            for row, line in enumerate(lines):
                tick = QTableWidgetItem()
                tick.setFlags(_READ_ONLY | Qt.ItemFlag.ItemIsUserCheckable)
                tick.setCheckState(Qt.CheckState.Unchecked if line.check else Qt.CheckState.Checked)
                what = QTableWidgetItem(tr(_WORDS[line.kind]))
                what.setFlags(_READ_ONLY)
                value = QTableWidgetItem(value_text(line, notation))
                if not line.has_value:
                    value = QTableWidgetItem("–")
                    value.setFlags(_READ_ONLY)
                sigma = QTableWidgetItem("" if line.sigma is None else _short(line.sigma))
                left = QTableWidgetItem()
                left.setFlags(_READ_ONLY)
                for item in (value, sigma, left):
                    item.setTextAlignment(right)
                cells = (tick, QTableWidgetItem(line.name), what, value, sigma, left)
                for column, item in enumerate(cells):
                    self.setItem(row, column, item)
        self.setVisible(bool(lines))
        shown = min(len(lines), 6)
        self.setFixedHeight(self.horizontalHeader().sizeHint().height() + 23 * shown + 6)

    def show_residuals(
        self,
        lines: Sequence[KnownLine],
        off: Mapping[str, float],
        wrong: set[str],
        tips: Mapping[str, str],
    ) -> None:
        """off, tips : by id; wrong : labels"""
        alert = theme.icon("alert-outline")
        with QSignalBlocker(self):
            for row, line in enumerate(lines):
                left, label = self.item(row, LEFT), self.item(row, LABEL)
                if left is None or label is None:
                    continue
                miss = off.get(line.id)
                unit, digits = _UNITS.get(line.kind, "°"), _DIGITS.get(line.kind, 2)
                sign = "" if line.is_read else "+"
                # Without a sign where nothing is left over.
                miss = None if miss is None else round(miss, digits) or 0.0
                left.setText(
                    "" if miss is None else f"{miss:{sign}.{digits}f}{unit}" if miss else "0"
                )
                if not line.is_complete:
                    left.setText(tr("type its value"))
                elif line.is_read and miss is None and line.id in tips:
                    left.setText(tr("not there"))
                left.setToolTip(tips.get(line.id, ""))
                label.setIcon(alert if line.name in wrong else QIcon())

    def ask_for_value(self, row: int) -> None:
        """Let the user type what is known of a new line."""
        item = self.item(row, VALUE)
        if item is not None:
            self.setCurrentItem(item)
            self.setFocus()
            self.editItem(item)


def typed(line: KnownLine, column: int, item: QTableWidgetItem, notation: str) -> KnownLine:
    """The line with what was typed or ticked; a plane in the notation. Raises UsageError,
    InputError."""
    if column == TICK:
        return replace(line, check=item.checkState() != Qt.CheckState.Checked)
    text = item.text().strip()
    if column == LABEL:
        return replace(line, name=text or line.name)
    if line.is_read and column == VALUE:
        return _read_anew(line, text, notation)
    if not text:
        return replace(line, value=None) if column == VALUE else replace(line, sigma=None)
    try:
        number = float(text.rstrip("°m ").replace(",", "."))
    except ValueError:
        number = float("nan")
    wrong = "number.not-a-length" if line.kind == "length" else "number.not-an-angle"
    if column == SIGMA:
        if not 0.0 < number <= _MOST_DEG.get(line.kind, 1e6):
            raise UsageError(Finding(wrong, text=text))
        return replace(line, sigma=number)
    if line.kind == "azimuth" and not -360.0 <= number <= 360.0:
        raise UsageError(Finding(wrong, text=text))
    if line.kind == "length" and not 0.0 < number < 1e9:
        raise UsageError(Finding(wrong, text=text))
    return replace(line, value=number % 360.0 if line.kind == "azimuth" else number)


def value_text(line: KnownLine, notation: str) -> str:
    """What is known of a line or plane, as it is typed."""
    if line.is_read:
        return format_reading(line, notation)
    return "" if line.value is None else _short(line.value)


def _read_anew(line: KnownLine, text: str, notation: str) -> KnownLine:
    from vomstudio.studio.placing.known_planes import parse_reading

    said = parse_reading(text, "plane" if line.kind == "plane" else "lineation", notation)
    return replace(
        line,
        value=said.azimuth_deg,
        inclination_deg=said.inclination_deg,
        sigma=line.sigma if said.sigma_deg is None else said.sigma_deg,
    )


def _short(value: float) -> str:
    return f"{value:.10g}"
