"""The project tree: models, and features under their types, each with its eye."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint, QSignalBlocker, Qt
from PySide6.QtGui import QAction, QIcon, QPalette
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QMenu,
    QStackedLayout,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from vomstudio.document import edits
from vomstudio.document.edit import Edit
from vomstudio.document.records import (
    FEATURES,
    Dimension,
    Feature,
    FeatureType,
    Model,
    Record,
)
from vomstudio.ui import theme
from vomstudio.ui.studio import Studio
from vomstudio.ui.wording import natural, orientation_text

_ID = Qt.ItemDataRole.UserRole
_SORT = Qt.ItemDataRole.UserRole + 1
DIMENSIONS = "dimensions"


class _Item(QTreeWidgetItem):
    def __lt__(self, other: QTreeWidgetItem) -> bool:
        return bool(self.data(0, _SORT) < other.data(0, _SORT))


class ProjectTree(QWidget):
    """`menu_actions` gives the actions of the menu under the right button for a record."""

    def __init__(self, studio: Studio, menu_actions: Callable[[Record], list[QAction]]) -> None:
        super().__init__()
        self._studio = studio
        self._menu_actions = menu_actions
        self._items: dict[str, QTreeWidgetItem] = {}
        self.tree = QTreeWidget()
        self.tree.setObjectName("project_tree")
        self.tree.setHeaderHidden(True)
        self.tree.setColumnCount(2)
        self.tree.header().setStretchLastSection(False)
        self.tree.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.tree.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.tree.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.tree.setEditTriggers(
            QAbstractItemView.EditTrigger.EditKeyPressed
            | QAbstractItemView.EditTrigger.SelectedClicked
        )
        self.tree.setIndentation(14)
        self.tree.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.tree.customContextMenuRequested.connect(self._menu)
        self.tree.itemSelectionChanged.connect(self._selected)
        self.tree.itemChanged.connect(self._changed)
        self._empty = QLabel(
            self.tr("Open an outcrop model\n(Ctrl+O), or drop a file\nonto the window.")
        )
        self._empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._empty.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._empty)
        self._stack.addWidget(self.tree)
        studio.project_opened.connect(self.rebuild)
        studio.edited.connect(self._edited)
        studio.selection_changed.connect(self._show_selection)
        studio.visibility_changed.connect(self._show_visibility)
        studio.settings_changed.connect(self.rebuild)

    def rebuild(self) -> None:
        with QSignalBlocker(self.tree):
            self.tree.clear()
            self._items.clear()
            models = self._group("models", self.tr("Models"), "0")
            models.setIcon(0, theme.icon("image-filter-hdr"))
            for kind in self._studio.session.of(FeatureType):
                item = self._group(kind.id, kind.name, "1")
                item.setIcon(0, theme.swatch(kind.color))
            dimensions = self._group(DIMENSIONS, self.tr("Measurements"), "2")
            dimensions.setIcon(0, theme.icon("ruler"))
            for record in self._studio.session.of(Model):
                self._put(record)
            features = self._studio.session.features()
            self._studio.measured(feature.id for feature in features)
            for feature in features:
                self._put(feature)
            self._finish()
            self.tree.sortItems(0, Qt.SortOrder.AscendingOrder)
        self._show_selection(self._studio.selection.ids)

    def _group(self, id_: str, text: str, order: str) -> QTreeWidgetItem:
        item = _Item(self.tree, [text, ""])
        item.setData(0, _ID, id_)
        item.setData(0, _SORT, (order, len(self._items)))
        item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(0, _check(self._studio.visible(id_)))
        item.setExpanded(True)
        self._items[id_] = item
        return item

    def _put(self, record: Model | Feature) -> None:
        item = self._items.get(record.id)
        group = (
            "models"
            if isinstance(record, Model)
            else DIMENSIONS
            if isinstance(record, Dimension)
            else record.type_id
        )
        # A damaged journal may have lost the type; its features are here all the same.
        parent = self._items.get(group) or self._group(group, group.capitalize(), "1")
        if item is not None and item.parent() is not parent:
            _take_out(item)
            item = None
        if item is None:
            item = _Item(parent)
            self._items[record.id] = item
        item.setData(0, _ID, record.id)
        item.setData(0, _SORT, natural(record.name))
        item.setText(0, record.name)
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
            | (Qt.ItemFlag.NoItemFlags if isinstance(record, Model) else Qt.ItemFlag.ItemIsEditable)
        )
        item.setCheckState(0, _check(self._studio.visible(record.id)))
        if not isinstance(record, Model):
            measured = self._studio.measured([record.id])[record.id]
            item.setIcon(0, theme.icon(theme.FEATURE_ICONS[type(record).__name__]))
            item.setText(1, orientation_text(measured, self._studio.settings.notation))
            quality = measured.verdict.quality if measured.verdict else None
            judged = measured.verdict is not None or measured.problem is not None
            item.setIcon(1, theme.verdict_icon(quality) if judged else QIcon())
            reasons = measured.verdict.reasons if measured.verdict else (measured.problem or "",)
            item.setToolTip(1, "\n".join(reasons))
        else:
            item.setText(1, "" if record.frame.has_north else self.tr("no frame"))
            item.setToolTip(0, record.path)

    def _finish(self) -> None:
        for id_, item in self._items.items():
            record = self._studio.records.get(id_)
            if isinstance(record, FeatureType):
                count = item.childCount()
                item.setText(0, f"{record.name} ({count})" if count else record.name)
                item.setHidden(count == 0)
        for group in ("models", DIMENSIONS):
            self._items[group].setHidden(self._items[group].childCount() == 0)
        session = self._studio.session
        empty = not session.of(Model) and not session.features()
        self._stack.setCurrentIndex(0 if empty else 1)

    def _edited(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self.rebuild()
            return
        with QSignalBlocker(self.tree):
            for id_ in {*edit.ids, *self._studio.affected(edit)}:
                record = self._studio.records.get(id_)
                if isinstance(record, (Model, *FEATURES)):
                    self._put(record)
                elif (item := self._items.pop(id_, None)) is not None:
                    _take_out(item)
            self._finish()
            for parent in {item.parent() for i in edit.ids if (item := self._items.get(i))}:
                if parent is not None:
                    parent.sortChildren(0, Qt.SortOrder.AscendingOrder)
        self._show_selection(self._studio.selection.ids)

    def _show_selection(self, ids: tuple[str, ...]) -> None:
        with QSignalBlocker(self.tree):
            self.tree.clearSelection()
            for id_ in ids:
                if item := self._items.get(id_):
                    item.setSelected(True)
            if ids and (item := self._items.get(ids[-1])):
                self.tree.scrollToItem(item)

    def _show_visibility(self, ids: tuple[str, ...]) -> None:
        with QSignalBlocker(self.tree):
            for id_ in ids:
                if item := self._items.get(id_):
                    item.setCheckState(0, _check(self._studio.visible(id_)))

    def _selected(self) -> None:
        self._studio.selection.set(str(i.data(0, _ID)) for i in self.tree.selectedItems())

    def _changed(self, item: QTreeWidgetItem, column: int) -> None:
        id_ = str(item.data(0, _ID))
        visible = item.checkState(0) == Qt.CheckState.Checked
        if visible != self._studio.visible(id_):
            self._studio.set_visible([id_], visible)
            return
        record = self._studio.records.get(id_)
        if isinstance(record, FEATURES) and item.text(0) != record.name:
            name = item.text(0).strip()
            if not self._studio.attempt(edits.set_attributes, [id_], name=name):
                with QSignalBlocker(self.tree):
                    item.setText(0, record.name)

    def _menu(self, at: QPoint) -> None:
        item = self.tree.itemAt(at)
        record = self._studio.records.get(str(item.data(0, _ID))) if item else None
        if record is None:
            return
        menu = QMenu(self)
        menu.addActions(self._menu_actions(record))
        if not menu.isEmpty():
            menu.exec(self.tree.viewport().mapToGlobal(at))


def _take_out(item: QTreeWidgetItem) -> None:
    parent = item.parent()
    if parent is not None:
        parent.removeChild(item)


def _check(visible: bool) -> Qt.CheckState:
    return Qt.CheckState.Checked if visible else Qt.CheckState.Unchecked
