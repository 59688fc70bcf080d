"""Tree widget whose features can be dragged between groups."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtCore import (
    QEvent,
    QItemSelection,
    QItemSelectionRange,
    QMimeData,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QSignalBlocker,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import (
    QBrush,
    QDrag,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDragMoveEvent,
    QDropEvent,
    QPalette,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTreeWidget, QTreeWidgetItem

from vomstudio.core.words import tr_n
from vomstudio.ui.base.controls import Label
from vomstudio.ui.panels.features.row_runs import find_runs

ID_ROLE = Qt.ItemDataRole.UserRole
SORT_ROLE = Qt.ItemDataRole.UserRole + 1
NAME, ORIENTATION, SET = 0, 1, 2
MAX_SET_WIDTH_PX = 80
# A narrower column would show only an ellipsis.
MIN_SET_WIDTH_PX = 34
FIT_DELAY_MS = 100
INDENTATION_PX, NARROW_INDENTATION_PX = 14, 6
_FEATURES_MIME = "application/x-vomstudio-features"
# Above this number, selecting ranges is faster than selecting single items.
MAX_SINGLE_ITEMS = 20


class TreeItem(QTreeWidgetItem):
    """Item that is sorted by its SORT_ROLE data."""

    def __lt__(self, other: QTreeWidgetItem) -> bool:
        return bool(self.data(NAME, SORT_ROLE) < other.data(NAME, SORT_ROLE))


class FeatureItem(TreeItem):
    """Item of a feature, which requests its content when it is painted.

    An edit of thousands of features therefore takes time only for the visible rows.

    Parameters
    ----------
    content : callable
        Returns the data of a feature for a column and a role.
    apply : callable
        Applies a value that the user has entered in a column, given the item and the role.
    """

    def __init__(
        self,
        id_: str,
        content: Callable[[str, int, int], Any],
        apply: Callable[[FeatureItem, int, int, Any], None],
    ) -> None:
        super().__init__()
        self.id, self.name, self.group = id_, "", ""
        self.sort_key: Any = None
        self._content, self._apply = content, apply

    def data(self, column: int, role: int) -> Any:
        if role == ID_ROLE:
            return self.id
        if role == SORT_ROLE:
            return self.sort_key
        return self._content(self.id, column, role)

    def setData(self, column: int, role: int, value: Any) -> None:  # noqa: N802 - Qt's name
        self._apply(self, column, role, value)

    def __lt__(self, other: QTreeWidgetItem) -> bool:
        if isinstance(other, FeatureItem):
            return bool(self.sort_key < other.sort_key)
        return super().__lt__(other)


class FeatureTree(QTreeWidget):
    """Tree whose features can be dragged onto feature types."""

    features_dropped = Signal(str)
    """Emitted with the id of the group onto which the selected features were dropped."""

    def __init__(self, is_target: Callable[[str], bool]) -> None:
        super().__init__()
        self._is_target = is_target
        self._target_group: QTreeWidgetItem | None = None
        self._has_sets = False
        self.setDragEnabled(True)
        self.setAcceptDrops(True)
        self.setDragDropMode(QAbstractItemView.DragDropMode.DragDrop)
        self.setDropIndicatorShown(False)
        self.setAutoExpandDelay(600)
        self.setHeaderHidden(True)
        self.setColumnCount(3)
        self.setUniformRowHeights(True)
        header = self.header()
        header.setStretchLastSection(False)
        header.moveSection(SET, ORIENTATION)
        header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(ORIENTATION, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(SET, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(SET, MAX_SET_WIDTH_PX)
        header.hideSection(SET)
        self._fit_timer = QTimer(self, singleShot=True, interval=FIT_DELAY_MS)
        self._fit_timer.timeout.connect(self._fit_set_column)
        self._longest_items: dict[int, QTreeWidgetItem] = {}
        """Item with the longest name of each group that was measured, by the row of the group."""
        self.model().rowsInserted.connect(self._fit_timer.start)
        self.model().rowsInserted.connect(self._add_names)
        self.model().rowsAboutToBeRemoved.connect(self._forget_names)
        self.model().layoutChanged.connect(self._longest_items.clear)
        self.model().modelReset.connect(self._longest_items.clear)
        # Limits the number of hidden rows that are measured for the column width.
        header.setResizeContentsPrecision(MAX_SINGLE_ITEMS)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.EditKeyPressed
            | QAbstractItemView.EditTrigger.SelectedClicked
        )
        self.setIndentation(INDENTATION_PX)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        # Qt lays out the rows after this event.
        self._fit_timer.start()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        self._fit_timer.start()

    def show_set_column(self, has_sets: bool) -> None:
        """Show the set column if there are sets and the names leave enough width."""
        if has_sets != self._has_sets:
            self._has_sets = has_sets
            self._fit_set_column()

    def _fit_set_column(self) -> None:
        """Fit the set column to the width that the names and orientations leave."""
        header = self.header()
        available_width = self.viewport().width() - header.sectionSize(ORIENTATION)
        self.setIndentation(INDENTATION_PX)
        name_width = self._name_width()
        if name_width > available_width:
            # In a narrow inspector, names need the space before them.
            self.setIndentation(NARROW_INDENTATION_PX)
            name_width = self._name_width()
        width = available_width - name_width
        header.setSectionHidden(SET, not self._has_sets or width < MIN_SET_WIDTH_PX)
        header.resizeSection(SET, max(MIN_SET_WIDTH_PX, min(width, MAX_SET_WIDTH_PX)))

    def _name_width(self) -> int:
        """Return the width of the longest name, including invisible rows, which Qt ignores."""
        width = self.sizeHintForColumn(NAME)
        for row in range(self.topLevelItemCount()):
            if row not in self._longest_items:
                self._measure_names(row)
            if (item := self._longest_items.get(row)) is not None:
                hint = self.sizeHintForIndex(self.indexFromItem(item)).width()
                width = max(width, 2 * self.indentation() + hint)
        return width

    def _measure_names(self, row: int) -> None:
        """Find the longest name of a group."""
        group = self.topLevelItem(row)
        children = [] if group is None else map(group.child, range(group.childCount()))
        items = [item for item in children if item is not None]
        if items:
            self._longest_items[row] = max(items, key=_name_length)

    def _add_names(self, parent: QModelIndex, first_row: int, last_row: int) -> None:
        """Compare new or changed names of a group with its longest name."""
        if not parent.isValid():
            self._longest_items.clear()
            return
        longest_item, group = self._longest_items.get(parent.row()), self.itemFromIndex(parent)
        if longest_item is None or group is None:
            return
        for row in range(first_row, last_row + 1):
            item = group.child(row)
            if item is longest_item:
                # It may have become shorter.
                del self._longest_items[parent.row()]
                return
            if item is not None and _name_length(item) > _name_length(longest_item):
                self._longest_items[parent.row()] = longest_item = item

    def _forget_names(self, parent: QModelIndex, first_row: int, last_row: int) -> None:
        """Forget the longest name of a group if its item is about to be removed."""
        if not parent.isValid():
            self._longest_items.clear()
            return
        longest_item = self._longest_items.get(parent.row())
        if longest_item and first_row <= self.indexFromItem(longest_item).row() <= last_row:
            del self._longest_items[parent.row()]

    def edit(  # type: ignore[override]
        self,
        index: QModelIndex | QPersistentModelIndex,
        trigger: QAbstractItemView.EditTrigger,
        event: QEvent,
    ) -> bool:
        """Start editing a name or set; orientations are read-only."""
        if index.isValid() and index.column() == ORIENTATION:
            return False
        return super().edit(index, trigger, event)

    def find_ranges(self, ids: set[str]) -> QItemSelection:
        """Return the rows of these features as the smallest number of ranges.

        Parameters
        ----------
        ids : set of str

        Returns
        -------
        QItemSelection
        """
        selection = QItemSelection()
        model = self.model()
        for i in range(self.topLevelItemCount()):
            group = self.topLevelItem(i)
            assert group is not None
            parent = self.indexFromItem(group)
            children = map(group.child, range(group.childCount()))
            rows = (k for k, item in enumerate(children) if item and _record_id(item) in ids)
            for first_row, last_row in find_runs(rows):
                selection.append(
                    QItemSelectionRange(
                        model.index(first_row, 0, parent), model.index(last_row, SET, parent)
                    )
                )
        return selection

    def update_items(self, items: Sequence[QTreeWidgetItem]) -> None:
        """Repaint items whose content has changed, or all rows if many items have changed."""
        model = self.model()
        ranges: list[tuple[QModelIndex, int, int]] = []
        if len(items) > MAX_SINGLE_ITEMS:
            groups = (model.index(row, 0) for row in range(self.topLevelItemCount()))
            ranges += [(group, 0, model.rowCount(group) - 1) for group in groups]
        else:
            indexes = map(self.indexFromItem, items)
            ranges += [(index.parent(), index.row(), index.row()) for index in indexes]
        for parent, first_row, last_row in ranges:
            if parent.isValid() and last_row >= first_row:
                model.dataChanged.emit(
                    model.index(first_row, 0, parent), model.index(last_row, SET, parent)
                )

    def startDrag(self, actions: Qt.DropAction) -> None:  # noqa: N802 - Qt's name
        items = [i for i in self.selectedItems() if i.flags() & Qt.ItemFlag.ItemIsDragEnabled]
        if not items:
            return
        data = QMimeData()
        data.setData(_FEATURES_MIME, b"")
        drag = QDrag(self)
        drag.setMimeData(data)
        label = Label(
            f" {items[0].text(NAME)} "
            if len(items) == 1
            else " {} ".format(tr_n("{count} feature", "{count} features", len(items)))
        )
        label.setAutoFillBackground(True)
        label.setBackgroundRole(QPalette.ColorRole.Highlight)
        label.setForegroundRole(QPalette.ColorRole.HighlightedText)
        label.adjustSize()
        drag.setPixmap(label.grab())
        drag.setHotSpot(QPoint(-12, 4))
        # A move action would make Qt remove the rows, but the edit does that.
        drag.exec(Qt.DropAction.CopyAction)
        self._highlight(None)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        if event.mimeData().hasFormat(_FEATURES_MIME):
            event.acceptProposedAction()
        else:
            event.ignore()

    def dragMoveEvent(self, event: QDragMoveEvent) -> None:  # noqa: N802
        if not event.mimeData().hasFormat(_FEATURES_MIME):
            event.ignore()
            return
        # Qt scrolls when the cursor is near an edge.
        super().dragMoveEvent(event)
        group = self._group_at(event.position().toPoint())
        self._highlight(group)
        event.setDropAction(Qt.DropAction.CopyAction)
        event.setAccepted(group is not None)

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:  # noqa: N802
        super().dragLeaveEvent(event)
        self._highlight(None)

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        self.stopAutoScroll()
        self.setState(QAbstractItemView.State.NoState)
        group = self._group_at(event.position().toPoint())
        self._highlight(None)
        if group is None or not event.mimeData().hasFormat(_FEATURES_MIME):
            event.ignore()
            return
        event.setDropAction(Qt.DropAction.CopyAction)
        event.accept()
        self.features_dropped.emit(str(group.data(NAME, ID_ROLE)))

    def _group_at(self, position: QPoint) -> QTreeWidgetItem | None:
        item = self.itemAt(position)
        group = item.parent() or item if item is not None else None
        if group is not None and self._is_target(str(group.data(NAME, ID_ROLE))):
            return group
        return None

    def _highlight(self, group: QTreeWidgetItem | None) -> None:
        """Highlight the group that receives the dropped features; None ends highlighting."""
        if group is self._target_group:
            return
        with QSignalBlocker(self):
            for item, brush in (
                (self._target_group, QBrush()),
                (group, self.palette().brush(QPalette.ColorRole.Highlight)),
            ):
                if item is not None:
                    for column in range(self.columnCount()):
                        item.setBackground(column, brush)
        self._target_group = group


def _record_id(item: QTreeWidgetItem) -> str:
    return item.id if isinstance(item, FeatureItem) else str(item.data(NAME, ID_ROLE))


def _name_length(item: QTreeWidgetItem) -> int:
    return len(item.name if isinstance(item, FeatureItem) else item.text(NAME))


def sort_children(parent: QTreeWidgetItem, items: list[QTreeWidgetItem]) -> None:
    """Move these children to their sorted positions, assuming that all others are in order."""
    if len(items) > MAX_SINGLE_ITEMS:
        parent.sortChildren(NAME, Qt.SortOrder.AscendingOrder)
        return
    for item in items:
        parent.removeChild(item)
    for item in items:
        low, high = 0, parent.childCount()
        while low < high:
            middle = (low + high) // 2
            other_item = parent.child(middle)
            if other_item is not None and item < other_item:
                high = middle
            else:
                low = middle + 1
        parent.insertChild(low, item)


def remove_from_parent(item: QTreeWidgetItem) -> None:
    """Remove an item from its parent, if any."""
    parent = item.parent()
    if parent is not None:
        parent.removeChild(item)


def remove_items(items: list[QTreeWidgetItem]) -> list[QTreeWidgetItem]:
    """Remove items from their parents.

    Returns
    -------
    list of QTreeWidgetItem
        Siblings that were removed and added again.
    """
    if len(items) <= MAX_SINGLE_ITEMS:
        for item in items:
            remove_from_parent(item)
        return []
    groups = {id(group): group for item in items if (group := item.parent()) is not None}
    removed_ids, remaining_items = set(map(id, items)), []
    for group in groups.values():
        # Removing many items one by one takes time for each of the others.
        siblings = [item for item in group.takeChildren() if id(item) not in removed_ids]
        group.addChildren(siblings)
        remaining_items += siblings
    return remaining_items
