"""The rows of the orientation table in their order, without those that fail the filter."""

from __future__ import annotations

from itertools import count
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt

from vomstudio.ui.panels.features.feature_filter import Test
from vomstudio.ui.panels.features.table_model import COLUMNS, OrientationModel, flags_of

_Index = QModelIndex | QPersistentModelIndex
# When more rows than this come or go, the view begins anew.
_ONE_BY_ONE = 200


class SortedRows(QAbstractTableModel):
    """Sorts and filters in Python, each row looked at once: Qt's own proxy asks for two values at
    every comparison, which takes a second for thousands of rows.

    A place is that of a row in the unsorted table.
    """

    def __init__(self, source: OrientationModel) -> None:
        super().__init__()
        self.test: Test | None = None
        self._source = source
        self._column, self._order = -1, Qt.SortOrder.AscendingOrder
        self._keys: list[Any] = []
        self._passes: list[bool] = []
        self._shown: list[int] = []
        self._rows: dict[int, int] = {}
        source.modelAboutToBeReset.connect(self.beginResetModel)
        source.modelReset.connect(self._reset)
        source.rowsInserted.connect(self._inserted)
        source.rowsAboutToBeRemoved.connect(self._removing)
        source.rowsRemoved.connect(self._removed)
        source.dataChanged.connect(self._changed)

    def set_test(self, test: Test | None) -> None:
        """Show the rows that pass the test; all rows where it is None."""
        self.test = test
        self._passes = [self._passed(place) for place in range(self._source.rowCount())]
        self._become(self._arranged())

    def mapToSource(self, index: _Index) -> QModelIndex:  # noqa: N802 - as Qt's proxies have it
        """The index in the unsorted table."""
        if not index.isValid():
            return QModelIndex()
        return self._source.index(self._shown[index.row()], index.column())

    def mapFromSource(self, index: _Index) -> QModelIndex:  # noqa: N802 - as Qt's proxies have it
        """The index of what has this one in the unsorted table; none where it is not shown."""
        row = self._rows.get(index.row()) if index.isValid() else None
        return QModelIndex() if row is None else self.index(row, index.column())

    def row_of(self, place: int | None) -> int | None:
        """Where a row of the unsorted table is shown; None where it is not."""
        return None if place is None else self._rows.get(place)

    # --- order -------------------------------------------------------------------------------
    def _key(self, place: int) -> Any:
        return None if self._column < 0 else COLUMNS[self._column].value(self._source.row(place))

    def _passed(self, place: int) -> bool:
        return self.test is None or self.test(self._source.row(place))

    def _arranged(self) -> list[int]:
        """The places in their order. What is undefined stands last either way round."""
        shown = [place for place, passes in enumerate(self._passes) if passes]
        if self._column < 0:
            return shown
        keys = self._keys
        known = [place for place in shown if keys[place] is not None]
        known.sort(key=keys.__getitem__, reverse=self._order == Qt.SortOrder.DescendingOrder)
        if len(known) == len(shown):
            return known
        return known + [place for place in shown if keys[place] is None]

    def _take(self, shown: list[int]) -> None:
        self._shown = shown
        self._rows = dict(zip(shown, count(), strict=False))

    def _become(self, wanted: list[int]) -> None:
        """Show these places in this order, and tell the views as little as is true."""
        if wanted == self._shown:
            return
        after = set(wanted)
        gone = [row for row, place in enumerate(self._shown) if place not in after]
        new = [row for row, place in enumerate(wanted) if place not in self._rows]
        if max(len(gone), len(new)) > _ONE_BY_ONE:
            self.beginResetModel()
            self._take(wanted)
            self.endResetModel()
            return
        for row in reversed(gone):
            self.beginRemoveRows(QModelIndex(), row, row)
            self._take(self._shown[:row] + self._shown[row + 1 :])
            self.endRemoveRows()
        stay = [place for place in wanted if place in self._rows]
        if stay != self._shown:
            self._reorder(stay)
        for row in new:
            self.beginInsertRows(QModelIndex(), row, row)
            self._take([*self._shown[:row], wanted[row], *self._shown[row:]])
            self.endInsertRows()

    def _reorder(self, wanted: list[int]) -> None:
        self.layoutAboutToBeChanged.emit()
        before = self._shown
        old = self.persistentIndexList()
        self._take(wanted)
        new = [self.index(self._rows[before[i.row()]], i.column()) for i in old]
        self.changePersistentIndexList(old, new)
        self.layoutChanged.emit()

    # --- the unsorted table has changed ------------------------------------------------------
    def _reset(self) -> None:
        places = range(self._source.rowCount())
        self._keys = [self._key(place) for place in places]
        self._passes = [self._passed(place) for place in places]
        self._take(self._arranged())
        self.endResetModel()

    def _inserted(self, _: QModelIndex, first: int, last: int) -> None:
        new = last - first + 1
        self._take([p + new if p >= first else p for p in self._shown])
        self._keys[first:first] = [self._key(place) for place in range(first, last + 1)]
        self._passes[first:first] = [self._passed(place) for place in range(first, last + 1)]
        self._become(self._arranged())

    def _removing(self, _: QModelIndex, first: int, last: int) -> None:
        self._passes[first : last + 1] = [False] * (last - first + 1)
        # The others stay in their order.
        self._become([place for place in self._shown if not first <= place <= last])

    def _removed(self, _: QModelIndex, first: int, last: int) -> None:
        del self._keys[first : last + 1], self._passes[first : last + 1]
        gone = last - first + 1
        self._take([p - gone if p > last else p for p in self._shown])

    def _changed(self, first: QModelIndex, last: QModelIndex) -> None:
        places = range(first.row(), last.row() + 1)
        start, end = first.row(), last.row() + 1
        before = self._keys[start:end], self._passes[start:end]
        self._keys[start:end] = [self._key(place) for place in places]
        self._passes[start:end] = [self._passed(place) for place in places]
        if before != (self._keys[start:end], self._passes[start:end]):
            self._become(self._arranged())
        rows = [row for place in places if (row := self._rows.get(place)) is not None]
        if rows:
            # Views paint what of it is in sight.
            self.dataChanged.emit(
                self.index(min(rows), first.column()), self.index(max(rows), last.column())
            )

    # --- Qt's names --------------------------------------------------------------------------
    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Put the rows in the order of a column's values."""
        self._column, self._order = column, order
        self._keys = [self._key(place) for place in range(self._source.rowCount())]
        self._become(self._arranged())

    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(self._shown)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(COLUMNS)

    def headerData(  # noqa: N802
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        return self._source.headerData(section, orientation, role)

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        return self._source.cell(self._shown[index.row()], index.column(), role)

    def flags(self, index: _Index) -> Qt.ItemFlag:
        return flags_of(index)

    def setData(  # noqa: N802
        self, index: _Index, value: Any, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        return self._source.setData(self.mapToSource(index), value, role)
