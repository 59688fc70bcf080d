"""Table of many numbers, sortable by column."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView

from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.number_formatting import natural_sort_key

_Index = QModelIndex | QPersistentModelIndex


@dataclass(frozen=True)
class Column:
    """Column of a table.

    Attributes
    ----------
    title, tip : str
        Translated texts.
    text : callable
        Formats a value; None is shown as a dash.
    number : bool
        Whether the column is aligned to the right.
    icon : callable, optional
        Returns the icon of a value, which replaces the flag of a row with a note.
    """

    title: str
    text: Callable[[Any], str] = str
    tip: str = ""
    number: bool = True
    icon: Callable[[Any], QIcon] | None = None


class NumberModel(QAbstractTableModel):
    """Table model whose rows contain values, and a note that flags the row (or "")."""

    def __init__(self, columns: Sequence[Column]) -> None:
        super().__init__()
        self._columns = tuple(columns)
        self.rows: list[tuple[tuple[Any, ...], str]] = []

    def fill(self, rows: list[tuple[tuple[Any, ...], str]]) -> None:
        self.beginResetModel()
        self.rows = list(rows)
        self.endResetModel()

    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: B008, N802
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: B008, N802
        return len(self._columns)

    def headerData(  # noqa: N802
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return self._columns[section].title
        if role == Qt.ItemDataRole.ToolTipRole:
            return self._columns[section].tip or None
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        values, note = self.rows[index.row()]
        column, value = self._columns[index.column()], values[index.column()]
        if role == Qt.ItemDataRole.DisplayRole:
            return "–" if value is None else column.text(value)
        if role == Qt.ItemDataRole.TextAlignmentRole and column.number:
            return int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        if role == Qt.ItemDataRole.ToolTipRole:
            return escape_markup(note) or None
        if role == Qt.ItemDataRole.DecorationRole and column.icon is not None:
            return column.icon(value)
        if role == Qt.ItemDataRole.DecorationRole and note and index.column() == 0:
            return theme.icon("alert-outline")
        return None

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort by a column; rows without a value come last in both orders."""
        self.layoutAboutToBeChanged.emit()
        persistent_indexes = self.persistentIndexList()
        rows = [self.rows[index.row()] for index in persistent_indexes]

        def key(row: tuple[tuple[Any, ...], str]) -> Any:
            value = row[0][column]
            return natural_sort_key(value) if isinstance(value, str) else value

        rows_with_value = [row for row in self.rows if row[0][column] is not None]
        rows_with_value.sort(key=key, reverse=order == Qt.SortOrder.DescendingOrder)
        self.rows = rows_with_value + [row for row in self.rows if row[0][column] is None]
        positions = {id(row): number for number, row in enumerate(self.rows)}
        for index, row in zip(persistent_indexes, rows, strict=True):
            self.changePersistentIndex(index, self.index(positions[id(row)], index.column()))
        self.layoutChanged.emit()


class NumberTable(QTableView):
    """Table of numbers.

    Attributes
    ----------
    row_selected : Signal
        Emitted with the values of the row that becomes current.
    """

    row_selected = Signal(object)

    def __init__(
        self, columns: Sequence[Column], sort_by: int, *, is_descending: bool = False
    ) -> None:
        super().__init__()
        self.numbers = NumberModel(columns)
        self.setModel(self.numbers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setAlternatingRowColors(True)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setResizeContentsPrecision(200)
        header.setStretchLastSection(False)
        self.setSortingEnabled(True)
        order = Qt.SortOrder.DescendingOrder if is_descending else Qt.SortOrder.AscendingOrder
        header.setSortIndicator(sort_by, order)
        self.selectionModel().currentRowChanged.connect(self._current)

    def sizeHint(self) -> QSize:  # noqa: N802
        """Return the preferred size, whose height is the minimum height if this is set."""
        hint = super().sizeHint()
        return QSize(hint.width(), self.minimumHeight() or hint.height())

    def fill(self, rows: list[tuple[tuple[Any, ...], str]]) -> None:
        """Show other rows, in the order that the user selected."""
        header = self.horizontalHeader()
        self.numbers.fill(rows)
        self.sortByColumn(header.sortIndicatorSection(), header.sortIndicatorOrder())

    def select_rows(
        self, match: Callable[[tuple[Any, ...]], bool], *, is_adding: bool = False
    ) -> None:
        """Select all matching rows, in addition to the selected ones if `is_adding` is set."""
        flag = QItemSelectionModel.SelectionFlag
        rows = QItemSelection()
        first: QModelIndex | None = None
        for number, (values, _) in enumerate(self.numbers.rows):
            if match(values):
                index = self.numbers.index(number, 0)
                rows.select(index, index)
                first = index if first is None else first
        mode = flag.Rows | (flag.Select if is_adding else flag.ClearAndSelect)
        selection = self.selectionModel()
        if first is not None:
            selection.setCurrentIndex(first, flag.NoUpdate)
            self.scrollTo(first)
        selection.select(rows, mode)

    def set_value(self, match: Callable[[tuple[Any, ...]], bool], column: int, value: Any) -> None:
        """Set one cell of the first row whose values match."""
        for number, (values, note) in enumerate(self.numbers.rows):
            if match(values):
                changed_row = (*values[:column], value, *values[column + 1 :])
                self.numbers.rows[number] = (changed_row, note)
                index = self.numbers.index(number, column)
                self.numbers.dataChanged.emit(index, index)
                return

    def select_row(self, match: Callable[[tuple[Any, ...]], bool]) -> None:
        """Make the first matching row current."""
        for number, (values, _) in enumerate(self.numbers.rows):
            if match(values):
                self.setCurrentIndex(self.numbers.index(number, 0))
                self.scrollTo(self.numbers.index(number, 0))
                return

    def values(self) -> tuple[Any, ...] | None:
        index = self.currentIndex()
        return self.numbers.rows[index.row()][0] if index.isValid() else None

    def _current(self, index: QModelIndex, _: QModelIndex) -> None:
        if index.isValid():
            self.row_selected.emit(self.numbers.rows[index.row()][0])
