"""Sorted and filtered rows of the orientation table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import count
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionRange,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
)

from vomstudio.ui.panels.features.feature_filter import Test
from vomstudio.ui.panels.features.row_runs import find_runs
from vomstudio.ui.panels.features.table_model import COLUMNS, OrientationModel, column_flags

_Index = QModelIndex | QPersistentModelIndex
# The view is reset if a larger number of rows is added, removed or moved.
MAX_SINGLE_UPDATES = 200
# Changed rows in more ranges are reported as one range.
MAX_RANGES = 20


class SortedRows(QAbstractTableModel):
    """Model that sorts and filters the rows of a source table.

    Each row is evaluated once. Qt's proxy model reads two values per comparison, which takes a
    second for thousands of rows. A source row is the number of a row in the unsorted table.
    """

    def __init__(self, source: OrientationModel) -> None:
        super().__init__()
        self.test: Test | None = None
        self._source = source
        self._column, self._order = -1, Qt.SortOrder.AscendingOrder
        self._keys: list[Any] = []
        self._passing_flags: list[bool] = []
        self._shown_rows: list[int] = []
        self._positions: dict[int, int] = {}
        source.modelAboutToBeReset.connect(self.beginResetModel)
        source.modelReset.connect(self._reset_rows)
        source.rowsInserted.connect(self._insert_rows)
        source.rowsAboutToBeRemoved.connect(self._hide_rows)
        source.rowsRemoved.connect(self._delete_rows)
        source.rows_changed.connect(self._update_rows)
        source.dataChanged.connect(self._update_range)

    def set_test(self, test: Test | None) -> None:
        """Show only the rows that pass the test; None shows all rows."""
        self.test = test
        self._passing_flags = [
            self._passes_test(source_row) for source_row in range(self._source.rowCount())
        ]
        self._update_shown_rows(self._sort_rows())

    def mapToSource(self, index: _Index) -> QModelIndex:  # noqa: N802 - as Qt's proxies have it
        """Return the corresponding index in the unsorted table."""
        if not index.isValid():
            return QModelIndex()
        return self._source.index(self._shown_rows[index.row()], index.column())

    def mapFromSource(self, index: _Index) -> QModelIndex:  # noqa: N802 - as Qt's proxies have it
        """Return the index in this model of a source index, invalid if its row is not shown."""
        row = self._positions.get(index.row()) if index.isValid() else None
        return QModelIndex() if row is None else self.index(row, index.column())

    def find_row(self, source_row: int | None) -> int | None:
        """Return the position of a source row, or None if it is not shown."""
        return None if source_row is None else self._positions.get(source_row)

    def find_rows(self, source_rows: Iterable[int | None]) -> list[int]:
        """Return the positions of those source rows that are shown, in the same order.

        Parameters
        ----------
        source_rows : iterable of int or None
            None stands for a feature that is not listed.

        Returns
        -------
        list of int
        """
        positions = map(self._positions.get, source_rows)  # type: ignore[arg-type]
        return [row for row in positions if row is not None]

    def create_selection(self, rows: Iterable[int]) -> QItemSelection:
        """Return rows, given by their positions, as the smallest number of ranges.

        Parameters
        ----------
        rows : iterable of int

        Returns
        -------
        QItemSelection
        """
        ranges = QItemSelection()
        last_column = len(COLUMNS) - 1
        for first_row, last_row in find_runs(rows):
            # Faster than `index`, which requests the size of the table.
            ranges.append(
                QItemSelectionRange(
                    self.createIndex(first_row, 0), self.createIndex(last_row, last_column)
                )
            )
        return ranges

    # --- order -------------------------------------------------------------------------------
    def _key(self, source_row: int) -> Any:
        return (
            None if self._column < 0 else COLUMNS[self._column].value(self._source.row(source_row))
        )

    def _passes_test(self, source_row: int) -> bool:
        return self.test is None or self.test(self._source.row(source_row))

    def _sort_rows(self) -> list[int]:
        """Return the sorted source rows that pass the filter, undefined values always last."""
        passing_rows = [
            source_row for source_row, is_passing in enumerate(self._passing_flags) if is_passing
        ]
        if self._column < 0:
            return passing_rows
        keys = self._keys
        defined_rows = [source_row for source_row in passing_rows if keys[source_row] is not None]
        defined_rows.sort(key=keys.__getitem__, reverse=self._order == Qt.SortOrder.DescendingOrder)
        if len(defined_rows) == len(passing_rows):
            return defined_rows
        return defined_rows + [
            source_row for source_row in passing_rows if keys[source_row] is None
        ]

    def _set_shown_rows(self, source_rows: list[int]) -> None:
        self._shown_rows = source_rows
        self._positions = dict(zip(source_rows, count(), strict=False))

    def _update_shown_rows(self, target: list[int]) -> None:
        """Show these source rows in order.

        Up to `MAX_SINGLE_UPDATES` changed rows are updated one by one, otherwise all rows are
        replaced.
        """
        if target == self._shown_rows:
            return
        target_set = set(target)
        removed_rows = [
            row for row, source_row in enumerate(self._shown_rows) if source_row not in target_set
        ]
        new_rows = [
            row for row, source_row in enumerate(target) if source_row not in self._positions
        ]
        if max(len(removed_rows), len(new_rows)) > MAX_SINGLE_UPDATES:
            self._replace_shown_rows(target)
            return
        for row in reversed(removed_rows):
            self.beginRemoveRows(QModelIndex(), row, row)
            self._set_shown_rows(self._shown_rows[:row] + self._shown_rows[row + 1 :])
            self.endRemoveRows()
        remaining_rows = [source_row for source_row in target if source_row in self._positions]
        if remaining_rows != self._shown_rows:
            moved_count = sum(a != b for a, b in zip(remaining_rows, self._shown_rows, strict=True))
            if moved_count > MAX_SINGLE_UPDATES:
                # Qt's selection model would store every cell of the selected rows.
                self._replace_shown_rows(target)
                return
            self._reorder_rows(remaining_rows)
        for row in new_rows:
            self.beginInsertRows(QModelIndex(), row, row)
            self._set_shown_rows([*self._shown_rows[:row], target[row], *self._shown_rows[row:]])
            self.endInsertRows()

    def _replace_shown_rows(self, target: list[int]) -> None:
        self.beginResetModel()
        self._set_shown_rows(target)
        self.endResetModel()

    def _reorder_rows(self, target: list[int]) -> None:
        self.layoutAboutToBeChanged.emit()
        previous_shown_rows = self._shown_rows
        old_indexes = self.persistentIndexList()
        self._set_shown_rows(target)
        new_indexes = [
            self.index(self._positions[previous_shown_rows[i.row()]], i.column())
            for i in old_indexes
        ]
        self.changePersistentIndexList(old_indexes, new_indexes)
        self.layoutChanged.emit()

    # --- changes of the source table ---------------------------------------------------------
    def _reset_rows(self) -> None:
        source_rows = range(self._source.rowCount())
        self._keys = [self._key(source_row) for source_row in source_rows]
        self._passing_flags = [self._passes_test(source_row) for source_row in source_rows]
        self._set_shown_rows(self._sort_rows())
        self.endResetModel()

    def _insert_rows(self, _: QModelIndex, first_row: int, last_row: int) -> None:
        row_count = last_row - first_row + 1
        self._set_shown_rows(
            [row + row_count if row >= first_row else row for row in self._shown_rows]
        )
        self._keys[first_row:first_row] = [
            self._key(source_row) for source_row in range(first_row, last_row + 1)
        ]
        self._passing_flags[first_row:first_row] = [
            self._passes_test(source_row) for source_row in range(first_row, last_row + 1)
        ]
        self._update_shown_rows(self._sort_rows())

    def _hide_rows(self, _: QModelIndex, first_row: int, last_row: int) -> None:
        self._passing_flags[first_row : last_row + 1] = [False] * (last_row - first_row + 1)
        # The remaining rows keep their order.
        self._update_shown_rows(
            [
                source_row
                for source_row in self._shown_rows
                if not first_row <= source_row <= last_row
            ]
        )

    def _delete_rows(self, _: QModelIndex, first_row: int, last_row: int) -> None:
        del self._keys[first_row : last_row + 1], self._passing_flags[first_row : last_row + 1]
        row_count = last_row - first_row + 1
        self._set_shown_rows(
            [row - row_count if row > last_row else row for row in self._shown_rows]
        )

    def _update_range(self, first_index: QModelIndex, last_index: QModelIndex) -> None:
        source_rows = range(first_index.row(), last_index.row() + 1)
        self._update_rows(source_rows, first_index.column(), last_index.column())

    def _update_rows(
        self,
        source_rows: Sequence[int],
        first_column: int = 0,
        last_column: int = len(COLUMNS) - 1,
    ) -> None:
        """Evaluate changed source rows, and report them in ranges."""
        is_order_changed = False
        for source_row in source_rows:
            key, is_passing = self._key(source_row), self._passes_test(source_row)
            if (key, is_passing) != (self._keys[source_row], self._passing_flags[source_row]):
                self._keys[source_row], self._passing_flags[source_row] = key, is_passing
                is_order_changed = True
        if is_order_changed:
            self._update_shown_rows(self._sort_rows())
        # Views repaint only the visible rows.
        for first_row, last_row in find_runs(self.find_rows(source_rows), MAX_RANGES):
            self.dataChanged.emit(
                self.index(first_row, first_column), self.index(last_row, last_column)
            )

    # --- Qt interface ------------------------------------------------------------------------
    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort the rows by the values of a column."""
        self._column, self._order = column, order
        self._keys = [self._key(source_row) for source_row in range(self._source.rowCount())]
        self._update_shown_rows(self._sort_rows())

    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(self._shown_rows)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(COLUMNS)

    def headerData(  # noqa: N802
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        return self._source.headerData(section, orientation, role)

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        return self._source.cell(self._shown_rows[index.row()], index.column(), role)

    def flags(self, index: _Index) -> Qt.ItemFlag:
        return column_flags(index)

    def setData(  # noqa: N802
        self, index: _Index, value: Any, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        return self._source.setData(self.mapToSource(index), value, role)
