"""The project tree: models, sets of photos, and features under their types, each with its eye."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from PySide6.QtCore import (
    QItemSelectionModel,
    QPoint,
    QSignalBlocker,
    Qt,
)
from PySide6.QtGui import (
    QAction,
    QIcon,
    QPalette,
)
from PySide6.QtWidgets import (
    QHBoxLayout,
    QMenu,
    QStackedWidget,
    QToolButton,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import GROUPS, KINDS, group_and_set, group_of, kind_of
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, FeatureType, Model, Record, Typed
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, escape_markup
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.number_formatting import natural_sort_key, orientation_text
from vomstudio.ui.base.qt_owner import IncrementalWork
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.feature_row import Row, row_of
from vomstudio.ui.panels.features.filter_line import FilterLine
from vomstudio.ui.panels.features.tree_menus import TreeMenus
from vomstudio.ui.panels.features.tree_photos import TreePhotos
from vomstudio.ui.panels.features.tree_view import (
    ID,
    MANY,
    NAME,
    ORIENTATION,
    SET,
    SORT,
    FeatureTree,
    TreeItem,
    put_in_order,
    take_out,
)

# So many features are put into the tree between one event and the next.
_PORTION = 500
_OVERTURNED = "\N{CLOCKWISE TOP SEMICIRCLE ARROW}"


class ProjectTree(QWidget):
    """`menu_actions` gives the actions of the context menu for a record, `edit_type` opens the
    dialog of feature types at one of them ("" for the present one)."""

    def __init__(
        self,
        studio: Studio,
        menu_actions: Callable[[Record], list[QAction]],
        edit_type: Callable[[str], object],
        photos: TreePhotos,
    ) -> None:
        super().__init__()
        explain(self, "projects.md")
        self._studio, self._photos = studio, photos
        self._menus = TreeMenus(studio, self, menu_actions, edit_type, self.change_type)
        self._items: dict[str, QTreeWidgetItem] = {}
        self._hidden: set[str] = set()
        self._rows: dict[str, Row] = {}
        self._icons: dict[str, QIcon] = {}
        self._selecting = False
        self._portions = IncrementalWork(self)
        self.tree = FeatureTree(lambda id_: isinstance(studio.records.get(id_), FeatureType))
        self.tree.setObjectName("project_tree")
        self.tree.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.tree.customContextMenuRequested.connect(self._menu)
        self.tree.itemSelectionChanged.connect(self._selected)
        self.tree.itemChanged.connect(self._changed)
        self.tree.dropped.connect(self._dropped)
        photos.join(self.tree)
        self.filter = FilterLine(tr("Filter: words, or dip>30"), wraps=True)
        self.filter.changed.connect(self._filtered)
        studio.filters.append((self, lambda ids: self._hidden.intersection(ids)))
        self.empty_types = QToolButton()
        self.empty_types.setIcon(theme.icon("shape-plus-outline"))
        self.empty_types.setToolTip(
            tr(
                "Show feature types without features, to drop features onto them or to choose one "
                "for the next feature."
            )
        )
        self.empty_types.setAccessibleName(tr("Show empty feature types"))
        self.empty_types.setCheckable(True)
        theme.highlight_toggles(self.empty_types)
        self.empty_types.toggled.connect(lambda _: self._finish())
        self._empty = Label(tr("Open an outcrop model\n(Ctrl+O), or drop a file\nonto the window."))
        self._empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._empty.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        page = QWidget()
        self._stack = QStackedWidget()
        self._stack.addWidget(self._empty)
        self._stack.addWidget(page)
        row = QHBoxLayout()
        row.setContentsMargins(2, 2, 2, 0)
        row.setSpacing(2)
        row.addWidget(self.filter)
        row.addWidget(self.empty_types)
        inner = QVBoxLayout(page)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.setSpacing(2)
        inner.addLayout(row)
        inner.addWidget(self.filter.problem)
        inner.addWidget(self.tree, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._stack)
        studio.project_opened.connect(self.rebuild)
        studio.edited.connect(self._edited)
        studio.selection_changed.connect(self._show_selection)
        studio.visibility_changed.connect(self._show_visibility)
        studio.settings_changed.connect(self._settings_changed)
        studio.next_changed.connect(self._finish)
        self._notation = studio.settings.notation

    # --- what is shown -----------------------------------------------------------------------
    def rebuild(self) -> None:
        """Fill the tree anew from the project; thousands of features come by and by."""
        with QSignalBlocker(self.tree):
            self.tree.clear()
            self._items.clear()
            self._hidden.clear()
            self._rows.clear()
            models = self._group("models", tr("Models"), "0")
            models.setIcon(NAME, theme.icon("image-filter-hdr"))
            self._photos.rebuild()
            for kind in self._studio.session.of(FeatureType):
                item = self._group(kind.id, kind.name, "1")
                item.setIcon(NAME, theme.type_icon(kind.color, kind.symbol))
            for group in GROUPS:
                item = self._group(group.id, tr(group.title), "2")
                item.setIcon(NAME, theme.icon(group.icon))
            self._icons = {kind.name: theme.icon(kind.icon) for kind in KINDS}
            for record in self._studio.session.of(Model):
                self._put_model(record)
            for id_, _, _ in self._studio.session.records.count_by(group_and_set):
                # A damaged journal may have lost the type; its features are here all the same.
                if id_ not in self._items:
                    self._group(id_, id_.capitalize(), "1")
            self.tree.sortItems(NAME, Qt.SortOrder.AscendingOrder)
        self._portions.start(self._fill())

    def _fill(self) -> Iterator[None]:
        """Put the features in, in their order, a portion after the other."""
        features = list(self._studio.session.features())
        if len(features) > _PORTION:
            # Every panel has work of its own when a project opens: not in the same moment.
            yield
        features.sort(key=lambda f: natural_sort_key(f.name))
        for start in range(0, len(features), _PORTION):
            some = features[start : start + _PORTION]
            with QSignalBlocker(self.tree):
                self._put(some)
            if start + _PORTION < len(features):
                if start == 0:
                    self._finish()
                yield
        self._finish()
        self._show_selection(self._studio.selection.ids)

    def _settings_changed(self) -> None:
        if self._notation != self._studio.settings.notation:
            self._notation = self._studio.settings.notation
            self.rebuild()

    def _group(self, id_: str, text: str, order: str) -> QTreeWidgetItem:
        item = TreeItem(self.tree, [text, "", ""])
        item.setData(NAME, ID, id_)
        item.setData(NAME, SORT, (order, len(self._items)))
        item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(NAME, _check(self._studio.visible(id_)))
        item.setExpanded(True)
        item.setFirstColumnSpanned(True)
        self._items[id_] = item
        return item

    def _item(
        self, record: Model | Feature, group: str
    ) -> tuple[QTreeWidgetItem, QTreeWidgetItem | None]:
        """The record's item, and where it has to be added: None where it stands in its group."""
        parent = self._items.get(group) or self._group(group, group.capitalize(), "1")
        item = self._items.get(record.id)
        home = None
        if item is None or item.parent() is not parent:
            if item is not None:
                take_out(item)
            item, home = TreeItem(), parent
            item.setData(NAME, ID, record.id)
            self._items[record.id] = item
        item.setData(NAME, SORT, natural_sort_key(record.name))
        item.setText(NAME, record.name)
        item.setCheckState(NAME, _check(self._studio.visible(record.id)))
        return item, home

    def _put_model(self, model: Model) -> None:
        item, home = self._item(model, "models")
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
        )
        item.setText(ORIENTATION, "" if model.frame.has_north else tr("no frame"))
        item.setToolTip(NAME, escape_markup(model.path))
        if home is not None:
            home.addChild(item)

    def _put(self, features: Iterable[Feature]) -> None:
        """Show these features as they are now, each in its group: new ones as its last."""
        new: dict[str, tuple[QTreeWidgetItem, list[QTreeWidgetItem]]] = {}
        features = list(features)
        measured = self._studio.measured(feature.id for feature in features)
        for feature in features:
            item, home = self._item(feature, group_of(feature))
            self._describe(item, feature, measured[feature.id])
            if home is not None:
                new.setdefault(group_of(feature), (home, []))[1].append(item)
        for home, items in new.values():
            home.addChildren(items)

    def _describe(self, item: QTreeWidgetItem, feature: Feature, measured: Measurement) -> None:
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
            | Qt.ItemFlag.ItemIsEditable
            | (
                Qt.ItemFlag.ItemIsDragEnabled
                if kind_of(feature).has_feature_type
                else Qt.ItemFlag.NoItemFlags
            )
        )
        row = row_of(self._studio, feature, measured)
        item.setIcon(NAME, self._icons[kind_of(feature).name])
        text = orientation_text(measured, self._studio.settings.notation)
        item.setText(ORIENTATION, f"{text} {_OVERTURNED}" if row.overturned else text)
        item.setText(SET, row.set_name)
        item.setToolTip(SET, escape_markup(row.set_name))
        judged = measured.verdict is not None or measured.problem is not None
        item.setIcon(ORIENTATION, theme.verdict_icon(row.quality) if judged else QIcon())
        says = [tr("Overturned")] if row.overturned else []
        judged_so = measured.verdict
        findings = (
            (*judged_so.reasons, *judged_so.notes) if judged_so else (measured.problem or "",)
        )
        reasons = map(str, findings)
        item.setToolTip(ORIENTATION, escape_markup("\n".join([*says, *reasons])))
        about = [f"{feature.name}: {row.class_name}", *says]
        if row.set_name:
            about.append(tr("Set: {set_name}", set_name=row.set_name))
        if feature.notes:
            about.append(feature.notes)
        item.setToolTip(NAME, escape_markup("\n".join(about)))

    def _finish(self) -> None:
        """Show counts, hide empty types, and apply the filter."""
        studio = self._studio
        features = studio.session.features()
        total: Counter[str] = Counter()
        sets = False
        for (group, set_name, _), count in studio.session.records.count_by(group_and_set).items():
            total[group] += count
            sets = sets or bool(set_name)
        hidden, shown = self._failing(features, total)
        with QSignalBlocker(self.tree):
            for id_ in self._hidden ^ hidden:
                item = self._items.get(id_)
                if item is not None:
                    item.setHidden(id_ in hidden)
            # Of those that are not put in yet, the end of the filling takes care.
            self._hidden = {id_ for id_ in hidden if id_ in self._items}
            for kind in studio.session.of(FeatureType):
                self._show_type(kind, total.get(kind.id, 0), shown.get(kind.id, 0))
            self._items["models"].setHidden(self._items["models"].childCount() == 0)
            for own in GROUPS:
                self._items[own.id].setHidden(shown.get(own.id, 0) == 0)
        self.tree.setColumnHidden(SET, not sets)
        empty = not (studio.session.of(Model) or features or self._photos.any)
        self._stack.setCurrentIndex(0 if empty else 1)

    def _failing(
        self, features: list[Feature], total: dict[str, int]
    ) -> tuple[set[str], dict[str, int]]:
        """Ids of the features that fail the filter, and how many of each group pass."""
        test = self.filter.test
        if test is None:
            return set(), total
        measured = self._studio.measured(f.id for f in features)
        hidden: set[str] = set()
        shown: dict[str, int] = {}
        rows: dict[str, Row] = {}
        for feature in features:
            # Texts of a row are kept with it from one letter of the filter to the next.
            row, of = self._rows.get(feature.id), measured[feature.id]
            if row is None or row.feature is not feature or row.measured is not of:
                row = row_of(self._studio, feature, of)
            rows[feature.id] = row
            if test(row):
                group = group_of(feature)
                shown[group] = shown.get(group, 0) + 1
            else:
                hidden.add(feature.id)
        self._rows = rows
        return hidden, shown

    def _show_type(self, kind: FeatureType, count: int, seen: int) -> None:
        """A feature type with the number of its features, and of those that pass the filter."""
        item = self._items.get(kind.id)
        if item is None:
            return
        many = str(count) if seen == count else tr("{shown} of {total}", shown=seen, total=count)
        is_next = kind.id == self._studio.next_type_id
        item.setText(NAME, f"{kind.name} ({many})" if count else kind.name)
        item.setHidden(seen == 0 and not self.empty_types.isChecked())
        font = item.font(NAME)
        font.setBold(is_next)
        item.setFont(NAME, font)
        item.setToolTip(NAME, tr("The next feature is of this type.") if is_next else "")

    def _edited(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self.rebuild()
            return
        # Items find their places among those that stand in order.
        self._portions.finish()
        unsorted: dict[int, tuple[QTreeWidgetItem, list[QTreeWidgetItem]]] = {}
        with QSignalBlocker(self.tree):
            self.tree.setUpdatesEnabled(False)
            ids = list(dict.fromkeys((*edit.ids, *self._studio.affected(edit))))
            records = self._studio.records
            before = {i: (item, item.text(NAME)) for i in ids if (item := self._items.get(i))}
            for id_ in ids:
                record = records.get(id_)
                if isinstance(record, Model):
                    self._put_model(record)
                elif id_ in before and not isinstance(record, Feature):
                    take_out(self._items.pop(id_))
                    self._hidden.discard(id_)
            self._put(f for id_ in ids if isinstance(f := records.get(id_), Feature))
            for id_ in ids:
                after = self._items.get(id_)
                parent = None if after is None else after.parent()
                if after is None or parent is None:
                    continue
                if before.get(id_) != (after, after.text(NAME)):
                    unsorted.setdefault(id(parent), (parent, []))[1].append(after)
                    # Qt forgets that of an item that changes its place.
                    self._hidden.discard(id_)
            for parent, moved in unsorted.values():
                put_in_order(parent, moved)
            self.tree.setUpdatesEnabled(True)
        self._photos.edited(edit)
        self._finish()
        self._show_selection(self._studio.selection.ids)

    def _filtered(self) -> None:
        self._finish()
        # Qt lets go of rows that are hidden: a feature out of sight stays selected.
        self._show_selection(self._studio.selection.ids)

    def _show_selection(self, ids: tuple[str, ...]) -> None:
        if self._selecting:
            return
        with QSignalBlocker(self.tree):
            if len(ids) < MANY:
                wanted = [item for id_ in ids if (item := self._items.get(id_))]
                # Qt goes through all rows to clear a selection; most edits leave it as it is.
                if self.tree.selectedItems() != wanted:
                    self.tree.clearSelection()
                    for item in wanted:
                        item.setSelected(True)
            else:
                self.tree.selectionModel().select(
                    self.tree.ranges(set(ids)),
                    QItemSelectionModel.SelectionFlag.ClearAndSelect
                    | QItemSelectionModel.SelectionFlag.Rows,
                )
            if ids and (item := self._items.get(ids[-1])) and not item.isHidden():
                self.tree.scrollToItem(item)

    def _show_visibility(self, ids: tuple[str, ...]) -> None:
        with QSignalBlocker(self.tree):
            for id_ in ids:
                if item := self._items.get(id_):
                    item.setCheckState(NAME, _check(self._studio.visible(id_)))

    # --- what is done ------------------------------------------------------------------------
    def _selected(self) -> None:
        ids = [str(i.data(NAME, ID)) for i in self.tree.selectedItems()]
        # A photo is no record: it stays selected here while the selection changes.
        self._selecting = True
        self._studio.selection.set(id_ for id_ in ids if id_ in self._items)
        self._selecting = False

    def _changed(self, item: QTreeWidgetItem, column: int) -> None:
        id_ = str(item.data(NAME, ID))
        visible = item.checkState(NAME) == Qt.CheckState.Checked
        if visible != self._studio.visible(id_):
            self._studio.set_visible([id_], visible)
            return
        record = self._studio.records.get(id_)
        if not isinstance(record, Feature):
            return
        field, before = (
            ("set_name", getattr(record, "set_name", ""))
            if column == SET
            else ("name", record.name)
        )
        text = item.text(column).strip()
        if column in (NAME, SET) and item.text(column) != before:
            done = text == before or self._studio.attempt(
                edits.set_attributes, [id_], **{field: text}
            )
            if not done or text == before:
                with QSignalBlocker(self.tree):
                    item.setText(column, before)

    def _dropped(self, type_id: str) -> None:
        ids = [str(i.data(NAME, ID)) for i in self.tree.selectedItems()]
        self.change_type(ids, type_id)

    def change_type(self, ids: Iterable[str], type_id: str) -> None:
        """Give features another type, all in one edit."""
        ids = [
            i
            for i in ids
            if isinstance(f := self._studio.records.get(i), Typed) and f.type_id != type_id
        ]
        if ids:
            self._studio.attempt(edits.set_attributes, ids, type_id=type_id)

    # --- context menu -----------------------------------------------------
    def _menu(self, at: QPoint) -> None:
        item = self.tree.itemAt(at)
        menu = self.menu_of(item)
        if not menu.isEmpty():
            menu.exec(self.tree.viewport().mapToGlobal(at))

    def menu_of(self, item: QTreeWidgetItem | None) -> QMenu:
        """The context menu of a row; of the tree where there is none."""
        photos = QMenu(self)
        photos.setToolTipsVisible(True)
        if item is not None and self._photos.menu_for(photos, item):
            return photos
        return self.menu_for("" if item is None else str(item.data(NAME, ID)))

    def menu_for(self, id_: str) -> QMenu:
        """The context menu of a record or group; of the tree where `id_` is empty."""
        return self._menus.menu_for(id_)


def _check(visible: bool) -> Qt.CheckState:
    return Qt.CheckState.Checked if visible else Qt.CheckState.Unchecked
