"""A tree whose features can be dragged from one group to another."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import (
    QEvent,
    QItemSelection,
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

ID = Qt.ItemDataRole.UserRole
SORT = Qt.ItemDataRole.UserRole + 1
NAME, ORIENTATION, SET = 0, 1, 2
_SET_WIDTH = 80
# Below that a set's name is a few dots.
_LEAST_SET_WIDTH = 34
_FIT_MS = 100
_FEATURES_MIME = "application/x-vomstudio-features"
# Above so many, one selection of ranges is quicker than one after the other.
MANY = 20


class TreeItem(QTreeWidgetItem):
    """An item that is sorted by its SORT data."""

    def __lt__(self, other: QTreeWidgetItem) -> bool:
        return bool(self.data(NAME, SORT) < other.data(NAME, SORT))


class FeatureTree(QTreeWidget):
    """A tree whose features are dragged onto types."""

    dropped = Signal(str)
    """The id of the group onto which the selected features were dropped."""

    def __init__(self, can_take: Callable[[str], bool]) -> None:
        super().__init__()
        self._can_take = can_take
        self._target: QTreeWidgetItem | None = None
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
        header.resizeSection(SET, _SET_WIDTH)
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.setInterval(_FIT_MS)
        self._soon.timeout.connect(self._fit_sets)
        self.model().rowsInserted.connect(self._soon.start)
        # Of rows out of sight only so many are measured for the column's width.
        header.setResizeContentsPrecision(MANY)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.EditKeyPressed
            | QAbstractItemView.EditTrigger.SelectedClicked
        )
        self.setIndentation(14)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        # Rows are laid out later.
        self._soon.start()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        self._soon.start()

    def _fit_sets(self) -> None:
        """Names come first: sets have what names and orientations leave."""
        header = self.header()
        left = self.viewport().width() - header.sectionSize(ORIENTATION)
        left -= self.sizeHintForColumn(NAME)
        header.setSectionHidden(SET, left < _LEAST_SET_WIDTH)
        header.resizeSection(SET, max(_LEAST_SET_WIDTH, min(left, _SET_WIDTH)))

    def edit(  # type: ignore[override]
        self,
        index: QModelIndex | QPersistentModelIndex,
        trigger: QAbstractItemView.EditTrigger,
        event: QEvent,
    ) -> bool:
        """Names and sets can be typed, figures cannot."""
        if index.isValid() and index.column() == ORIENTATION:
            return False
        return super().edit(index, trigger, event)

    def ranges(self, ids: set[str]) -> QItemSelection:
        """The rows of these ids, as few runs as there are."""
        chosen = QItemSelection()
        for i in range(self.topLevelItemCount()):
            group = self.topLevelItem(i)
            assert group is not None
            parent = self.indexFromItem(group)
            model = self.model()
            start = None
            for row in range(group.childCount() + 1):
                child = group.child(row) if row < group.childCount() else None
                inside = child is not None and child.data(NAME, ID) in ids
                if inside and start is None:
                    start = row
                elif not inside and start is not None:
                    chosen.select(model.index(start, 0, parent), model.index(row - 1, SET, parent))
                    start = None
        return chosen

    def startDrag(self, actions: Qt.DropAction) -> None:  # noqa: N802 - Qt's name
        chosen = [i for i in self.selectedItems() if i.flags() & Qt.ItemFlag.ItemIsDragEnabled]
        if not chosen:
            return
        data = QMimeData()
        data.setData(_FEATURES_MIME, b"")
        drag = QDrag(self)
        drag.setMimeData(data)
        label = Label(
            f" {chosen[0].text(NAME)} "
            if len(chosen) == 1
            else " {} ".format(tr_n("{count} feature", "{count} features", len(chosen)))
        )
        label.setAutoFillBackground(True)
        label.setBackgroundRole(QPalette.ColorRole.Highlight)
        label.setForegroundRole(QPalette.ColorRole.HighlightedText)
        label.adjustSize()
        drag.setPixmap(label.grab())
        drag.setHotSpot(QPoint(-12, 4))
        # Copied, or Qt would take the rows out of the tree: the edit does all there is to do.
        drag.exec(Qt.DropAction.CopyAction)
        self._mark(None)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        if event.mimeData().hasFormat(_FEATURES_MIME):
            event.acceptProposedAction()
        else:
            event.ignore()

    def dragMoveEvent(self, event: QDragMoveEvent) -> None:  # noqa: N802
        if not event.mimeData().hasFormat(_FEATURES_MIME):
            event.ignore()
            return
        # For the scrolling at the edges.
        super().dragMoveEvent(event)
        group = self._group_at(event.position().toPoint())
        self._mark(group)
        event.setDropAction(Qt.DropAction.CopyAction)
        event.setAccepted(group is not None)

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:  # noqa: N802
        super().dragLeaveEvent(event)
        self._mark(None)

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        self.stopAutoScroll()
        self.setState(QAbstractItemView.State.NoState)
        group = self._group_at(event.position().toPoint())
        self._mark(None)
        if group is None or not event.mimeData().hasFormat(_FEATURES_MIME):
            event.ignore()
            return
        event.setDropAction(Qt.DropAction.CopyAction)
        event.accept()
        self.dropped.emit(str(group.data(NAME, ID)))

    def _group_at(self, at: QPoint) -> QTreeWidgetItem | None:
        item = self.itemAt(at)
        group = item.parent() or item if item is not None else None
        if group is not None and self._can_take(str(group.data(NAME, ID))):
            return group
        return None

    def _mark(self, group: QTreeWidgetItem | None) -> None:
        """Show where a drop would go."""
        if group is self._target:
            return
        with QSignalBlocker(self):
            for item, brush in (
                (self._target, QBrush()),
                (group, self.palette().brush(QPalette.ColorRole.Highlight)),
            ):
                if item is not None:
                    for column in range(self.columnCount()):
                        item.setBackground(column, brush)
        self._target = group


def put_in_order(parent: QTreeWidgetItem, moved: list[QTreeWidgetItem]) -> None:
    """Put these children in their places: all others are in order."""
    if len(moved) > MANY:
        parent.sortChildren(NAME, Qt.SortOrder.AscendingOrder)
        return
    for item in moved:
        parent.removeChild(item)
    for item in moved:
        low, high = 0, parent.childCount()
        while low < high:
            middle = (low + high) // 2
            other = parent.child(middle)
            if other is not None and item < other:
                high = middle
            else:
                low = middle + 1
        parent.insertChild(low, item)


def take_out(item: QTreeWidgetItem) -> None:
    """Of its group, where it has one."""
    parent = item.parent()
    if parent is not None:
        parent.removeChild(item)
