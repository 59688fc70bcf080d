"""Project tree with models, photo sets and features by type, each with a visibility box."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any

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
from vomstudio.project.kinds import GROUPS, KINDS, get_kind, group_and_set, visibility_group
from vomstudio.project.records import Feature, FeatureType, Model, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, escape_markup
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import natural_sort_key, orientation_text
from vomstudio.ui.base.qt_owner import IncrementalWork
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.feature_row import Row, create_row
from vomstudio.ui.panels.features.filter_line import FilterLine
from vomstudio.ui.panels.features.record_menus import RecordMenus
from vomstudio.ui.panels.features.tree_photos import TreePhotos
from vomstudio.ui.panels.features.tree_view import (
    ID_ROLE,
    MAX_SINGLE_ITEMS,
    NAME,
    ORIENTATION,
    SET,
    SORT_ROLE,
    FeatureItem,
    FeatureTree,
    TreeItem,
    remove_from_parent,
    remove_items,
    sort_children,
)

_TEXT_ROLES = (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole)
_FEATURE_FLAGS = (
    Qt.ItemFlag.ItemIsEnabled
    | Qt.ItemFlag.ItemIsSelectable
    | Qt.ItemFlag.ItemIsUserCheckable
    | Qt.ItemFlag.ItemIsEditable
)
# Number of features added to the tree between two events.
_PORTION = 1000
_OVERTURNED_MARK = "\N{CLOCKWISE TOP SEMICIRCLE ARROW}"


class ProjectTree(QWidget):
    """Tree that shows the records of the project and edits them in place.

    Parameters
    ----------
    edit_feature : QAction
        Action for a double click on a feature.
    """

    def __init__(
        self,
        studio: Studio,
        menus: RecordMenus,
        photos: TreePhotos,
        edit_feature: QAction,
    ) -> None:
        super().__init__()
        set_help_topic(self, "projects.md")
        self._studio, self._photos = studio, photos
        self._menus = menus
        self._items: dict[str, QTreeWidgetItem] = {}
        self._hidden_ids: set[str] = set()
        self._rows: dict[str, Row] = {}
        self._icons: dict[str, QIcon] = {}
        self._is_selecting = False
        self._filling_work = IncrementalWork(self)
        self.tree = FeatureTree(lambda id_: isinstance(studio.records.get(id_), FeatureType))
        self.tree.setObjectName("project_tree")
        self.tree.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.tree.customContextMenuRequested.connect(self._open_menu)
        self.tree.itemSelectionChanged.connect(self._apply_selection)
        self.tree.itemChanged.connect(self._apply_item_edit)
        self.tree.features_dropped.connect(self._apply_drop)
        self.tree.itemDoubleClicked.connect(
            lambda item, _: self._edit(str(item.data(NAME, ID_ROLE)), edit_feature)
        )
        photos.attach(self.tree)
        self.filter = FilterLine(tr("Filter: words, or dip>30"), has_word_wrap=True)
        self.filter.changed.connect(self._apply_filter)
        studio.filters.append((self, lambda ids: self._hidden_ids.intersection(ids)))
        self.empty_types_button = QToolButton()
        self.empty_types_button.setIcon(theme.icon("shape-plus-outline"))
        self.empty_types_button.setToolTip(tr("Show feature types without features."))
        self.empty_types_button.setAccessibleName(tr("Show empty feature types"))
        self.empty_types_button.setCheckable(True)
        theme.highlight_toggles(self.empty_types_button)
        self.empty_types_button.toggled.connect(lambda _: self._update_counts())
        self._empty_label = Label(
            tr("Open an outcrop model\n(Ctrl+O), or drop a file\nonto the window.")
        )
        self._empty_label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._empty_label.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        page = QWidget()
        self._stack = QStackedWidget()
        self._stack.addWidget(self._empty_label)
        self._stack.addWidget(page)
        row = QHBoxLayout()
        row.setContentsMargins(2, 2, 2, 0)
        row.setSpacing(2)
        row.addWidget(self.filter)
        row.addWidget(self.empty_types_button)
        page_layout = QVBoxLayout(page)
        page_layout.setContentsMargins(0, 0, 0, 0)
        page_layout.setSpacing(2)
        page_layout.addLayout(row)
        page_layout.addWidget(self.filter.problem)
        page_layout.addWidget(self.tree, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._stack)
        studio.project_opened.connect(self._begin_project)
        studio.edited.connect(self._apply_edit)
        studio.selection_changed.connect(self._show_selection)
        studio.visibility_changed.connect(self._show_visibility)
        studio.settings_changed.connect(self._apply_settings)
        studio.next_type_changed.connect(self._update_counts)
        self._notation = studio.settings.notation

    # --- display -----------------------------------------------------------------------------
    def _begin_project(self) -> None:
        self.filter.clear()
        self.empty_types_button.setChecked(False)
        self.rebuild()

    def rebuild(self) -> None:
        """Rebuild the tree from the project; the features are added in batches."""
        with QSignalBlocker(self.tree):
            self.tree.clear()
            self._items.clear()
            self._hidden_ids.clear()
            self._rows.clear()
            models_item = self._add_group("models", tr("Models"), "0")
            models_item.setIcon(NAME, theme.icon("image-filter-hdr"))
            self._photos.rebuild()
            for feature_type in self._studio.session.of(FeatureType):
                item = self._add_group(feature_type.id, feature_type.name, "1")
                item.setIcon(NAME, theme.type_icon(feature_type.color, feature_type.symbol))
            for group in GROUPS:
                item = self._add_group(group.id, tr(group.title), "2")
                item.setIcon(NAME, theme.icon(group.icon))
            self._icons = {
                feature_type.name: theme.icon(feature_type.icon) for feature_type in KINDS
            }
            for record in self._studio.session.of(Model):
                self._show_model(record)
            for id_, _, _ in self._studio.session.records.count_by(group_and_set):
                # The feature types may be missing from a damaged journal.
                if id_ not in self._items:
                    self._add_group(id_, id_.capitalize(), "1")
            self.tree.sortItems(NAME, Qt.SortOrder.AscendingOrder)
        self._filling_work.start(self._fill())

    def _fill(self) -> Iterator[None]:
        """Add the features in order, yielding after each batch."""
        features = list(self._studio.session.features())
        if len(features) > _PORTION:
            # All panels refresh when a project opens; this one lets them go first.
            yield
        features.sort(key=lambda f: natural_sort_key(f.name))
        for start in range(0, len(features), _PORTION):
            batch = features[start : start + _PORTION]
            with QSignalBlocker(self.tree):
                self._show_features(batch)
            if start + _PORTION < len(features):
                if start == 0:
                    self._update_counts()
                yield
        self._update_counts()
        self._show_selection(self._studio.selection.ids)

    def _apply_settings(self) -> None:
        if self._notation != self._studio.settings.notation:
            self._notation = self._studio.settings.notation
            self.rebuild()

    def _add_group(self, id_: str, text: str, order: str) -> QTreeWidgetItem:
        item = TreeItem(self.tree, [text, "", ""])
        item.setData(NAME, ID_ROLE, id_)
        item.setData(NAME, SORT_ROLE, (order, len(self._items)))
        item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(NAME, _check_state(self._studio.visible(id_)))
        item.setExpanded(True)
        item.setFirstColumnSpanned(True)
        self._items[id_] = item
        return item

    def _find_or_create_item(
        self, record: Model | Feature, group: str
    ) -> tuple[QTreeWidgetItem, QTreeWidgetItem | None]:
        """Return the item of a record, which is created if necessary, and its new parent.

        The new parent is None if the item is already in the right group.
        """
        parent = self._items.get(group) or self._add_group(group, group.capitalize(), "1")
        item = self._items.get(record.id)
        if item is not None and item.parent() is parent:
            return item, None
        if item is not None:
            remove_from_parent(item)
        if isinstance(record, Feature):
            item = FeatureItem(record.id, self._content, self._apply_feature_edit)
            item.setFlags(_FEATURE_FLAGS | _drag_flag(record))
        else:
            item = TreeItem()
            item.setData(NAME, ID_ROLE, record.id)
        self._items[record.id] = item
        return item, parent

    def _show_model(self, model: Model) -> None:
        item, new_parent = self._find_or_create_item(model, "models")
        item.setData(NAME, SORT_ROLE, natural_sort_key(model.name))
        item.setText(NAME, model.name)
        item.setCheckState(NAME, _check_state(self._studio.visible(model.id)))
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
        )
        item.setText(ORIENTATION, "" if model.frame.has_north else tr("no frame"))
        item.setToolTip(NAME, escape_markup(model.path))
        if new_parent is not None:
            new_parent.addChild(item)

    def _show_features(self, features: Iterable[Feature]) -> list[QTreeWidgetItem]:
        """Update the items of features, and return those that must be sorted into their groups.

        New items are added at the end of their groups.
        """
        new_tree_items: dict[str, tuple[QTreeWidgetItem, list[QTreeWidgetItem]]] = {}
        updated_items: list[QTreeWidgetItem] = []
        unsorted_items: list[QTreeWidgetItem] = []
        for feature in features:
            group, item = visibility_group(feature), self._items.get(feature.id)
            if isinstance(item, FeatureItem) and item.group == group:
                updated_items.append(item)
                if item.name == feature.name:
                    continue
            else:
                item, parent = self._find_or_create_item(feature, group)
                assert isinstance(item, FeatureItem)
                item.group = group
                if parent is not None:
                    new_tree_items.setdefault(group, (parent, []))[1].append(item)
            item.name, item.sort_key = feature.name, natural_sort_key(feature.name)
            unsorted_items.append(item)
        for parent, items in new_tree_items.values():
            parent.addChildren(items)
        self.tree.update_items(updated_items)
        return unsorted_items

    # --- content of the visible rows ---------------------------------------------------------
    def _cached_row(self, feature: Feature) -> Row:
        """Return the cached row of a feature, or a new row if the feature has changed."""
        measurement = self._studio.measured([feature.id])[feature.id]
        row = self._rows.get(feature.id)
        if row is None or row.feature is not feature or row.measured is not measurement:
            row = create_row(self._studio, feature, measurement)
        return row

    def _content(self, id_: str, column: int, role: int) -> Any:
        """Return the content of a feature's item for a column and a Qt role, or None."""
        # Most of the roles that Qt requests for every cell have no content.
        if (read_content := _CONTENT_READERS.get((column, role))) is None:
            return None
        feature = get_feature(self._studio.records, id_)
        # A deleted feature may be painted until its item is removed.
        return None if feature is None else read_content(self, feature)

    def _check_state(self, feature: Feature) -> Qt.CheckState:
        return _check_state(self._studio.visible(feature.id))

    def _feature_icon(self, feature: Feature) -> QIcon:
        return self._icons[get_kind(feature).name]

    def _orientation(self, feature: Feature) -> str:
        row = self._cached_row(feature)
        text = orientation_text(row.measured, self._studio.settings.notation)
        return f"{text} {_OVERTURNED_MARK}" if row.overturned else text

    def _verdict_icon(self, feature: Feature) -> QIcon:
        row = self._cached_row(feature)
        is_judged = row.measured.verdict is not None or row.measured.problem is not None
        return theme.verdict_icon(row.quality) if is_judged else QIcon()

    def _orientation_tip(self, feature: Feature) -> str:
        row = self._cached_row(feature)
        verdict = row.measured.verdict
        findings = (*verdict.reasons, *verdict.notes) if verdict else (row.measured.problem or "",)
        notes = [tr("Overturned")] if row.overturned else []
        return escape_markup("\n".join([*notes, *map(str, findings)]))

    def _name_tip(self, feature: Feature) -> str:
        row = self._cached_row(feature)
        lines = [f"{feature.name}: {row.class_name}"]
        if row.overturned:
            lines.append(tr("Overturned"))
        if row.set_name:
            lines.append(tr("Set: {set_name}", set_name=row.set_name))
        if feature.notes:
            lines.append(feature.notes)
        return escape_markup("\n".join(lines))

    def _update_counts(self) -> bool:
        """Update the feature counts, hide empty types and apply the filter.

        Returns
        -------
        bool
            Whether any feature has become hidden or visible.
        """
        studio = self._studio
        features = studio.session.features()
        totals: Counter[str] = Counter()
        has_sets = False
        for (group, set_name, _), count in studio.session.records.count_by(group_and_set).items():
            totals[group] += count
            has_sets = has_sets or bool(set_name)
        hidden_ids, passing_counts = self._test_features(features, totals)
        with QSignalBlocker(self.tree):
            changed_ids = self._hidden_ids ^ hidden_ids
            for id_ in changed_ids:
                item = self._items.get(id_)
                if item is not None:
                    item.setHidden(id_ in hidden_ids)
            # Items that are added later are hidden once filling ends.
            self._hidden_ids = {id_ for id_ in hidden_ids if id_ in self._items}
            for feature_type in studio.session.of(FeatureType):
                self._show_type(
                    feature_type,
                    totals.get(feature_type.id, 0),
                    passing_counts.get(feature_type.id, 0),
                )
            self._items["models"].setHidden(self._items["models"].childCount() == 0)
            for group_kind in GROUPS:
                self._items[group_kind.id].setHidden(passing_counts.get(group_kind.id, 0) == 0)
        self.tree.show_set_column(has_sets)
        is_empty = not (studio.session.of(Model) or features or self._photos.has_photos)
        self._stack.setCurrentIndex(0 if is_empty else 1)
        return bool(changed_ids)

    def _test_features(
        self, features: list[Feature], totals: dict[str, int]
    ) -> tuple[set[str], dict[str, int]]:
        """Apply the filter to features.

        Returns
        -------
        set of str
            Ids of the features that fail the filter.
        dict
            Number of features that pass the filter, by group.
        """
        test = self.filter.test
        if test is None:
            return set(), totals
        measurements = self._studio.measured(f.id for f in features)
        hidden_ids: set[str] = set()
        passing_counts: dict[str, int] = {}
        rows: dict[str, Row] = {}
        for feature in features:
            row, measurement = self._rows.get(feature.id), measurements[feature.id]
            if row is None or row.feature is not feature or row.measured is not measurement:
                row = create_row(self._studio, feature, measurement)
            rows[feature.id] = row
            if test(row):
                group = visibility_group(feature)
                passing_counts[group] = passing_counts.get(group, 0) + 1
            else:
                hidden_ids.add(feature.id)
        self._rows = rows
        return hidden_ids, passing_counts

    def _show_type(self, feature_type: FeatureType, count: int, passing_count: int) -> None:
        """Show a feature type with its number of features and the number that pass the filter."""
        item = self._items.get(feature_type.id)
        if item is None:
            return
        count_text = (
            str(count)
            if passing_count == count
            else tr("{shown} of {total}", shown=passing_count, total=count)
        )
        is_next = feature_type.id == self._studio.next_type_id
        item.setText(NAME, f"{feature_type.name} ({count_text})" if count else feature_type.name)
        item.setHidden(passing_count == 0 and not self.empty_types_button.isChecked())
        font = item.font(NAME)
        font.setBold(is_next)
        item.setFont(NAME, font)
        item.setToolTip(NAME, tr("The next feature gets this type.") if is_next else "")

    def _apply_edit(self, edit: Edit) -> None:
        if any(isinstance(r, FeatureType) for r in (*edit.before.values(), *edit.after.values())):
            self.rebuild()
            return
        # Changed items are inserted among sorted siblings.
        self._filling_work.finish()
        unsorted_by_parent: dict[int, tuple[QTreeWidgetItem, list[QTreeWidgetItem]]] = {}
        with QSignalBlocker(self.tree):
            self.tree.setUpdatesEnabled(False)
            ids = list(dict.fromkeys((*edit.ids, *self._studio.affected_ids(edit))))
            records = self._studio.records
            unsorted_items: list[QTreeWidgetItem] = []
            removed_items: list[QTreeWidgetItem] = []
            for id_ in ids:
                record = records.get(id_)
                previous_item = self._items.get(id_)
                if isinstance(record, Model):
                    old_name = None if previous_item is None else previous_item.text(NAME)
                    self._show_model(record)
                    if old_name != record.name:
                        unsorted_items.append(self._items[id_])
                elif previous_item is not None and not isinstance(record, Feature):
                    removed_items.append(self._items.pop(id_))
                    self._hidden_ids.discard(id_)
            # Qt resets the hidden state of the items that remain.
            self._hidden_ids.difference_update(
                str(item.data(NAME, ID_ROLE)) for item in remove_items(removed_items)
            )
            unsorted_items += self._show_features(
                f for id_ in ids if isinstance(f := records.get(id_), Feature)
            )
            for item in unsorted_items:
                if (parent := item.parent()) is not None:
                    unsorted_by_parent.setdefault(id(parent), (parent, []))[1].append(item)
                    # Qt resets the hidden state of an item that is moved.
                    self._hidden_ids.discard(str(item.data(NAME, ID_ROLE)))
            for parent, items in unsorted_by_parent.values():
                sort_children(parent, items)
            self.tree.setUpdatesEnabled(True)
        self._photos.apply_edit(edit)
        is_filter_changed = self._update_counts()
        if unsorted_items or removed_items or is_filter_changed:
            # Qt deselects the items that are moved or hidden.
            self._show_selection(self._studio.selection.ids)

    def _apply_filter(self) -> None:
        self._update_counts()
        # Qt deselects hidden rows; the studio keeps them selected.
        self._show_selection(self._studio.selection.ids)

    def _show_selection(self, ids: tuple[str, ...]) -> None:
        if self._is_selecting:
            return
        with QSignalBlocker(self.tree):
            if len(ids) < MAX_SINGLE_ITEMS:
                items = [item for id_ in ids if (item := self._items.get(id_))]
                # Clearing the selection takes time for every row; most edits do not change it.
                if self.tree.selectedItems() != items:
                    self.tree.clearSelection()
                    for item in items:
                        item.setSelected(True)
            else:
                # Otherwise Qt would compute the position of every range.
                self.tree.setUpdatesEnabled(False)
                # Qt would compare every new range with every old one.
                self.tree.clearSelection()
                self.tree.selectionModel().select(
                    self.tree.find_ranges(set(ids)), QItemSelectionModel.SelectionFlag.Select
                )
                self.tree.setUpdatesEnabled(True)
            if ids and (item := self._items.get(ids[-1])) and not item.isHidden():
                self.tree.scrollToItem(item)

    def _show_visibility(self, ids: tuple[str, ...]) -> None:
        items = [item for id_ in ids if (item := self._items.get(id_))]
        with QSignalBlocker(self.tree):
            self.tree.update_items([item for item in items if isinstance(item, FeatureItem)])
            for item in items:
                if not isinstance(item, FeatureItem):
                    is_visible = self._studio.visible(str(item.data(NAME, ID_ROLE)))
                    item.setCheckState(NAME, _check_state(is_visible))

    # --- actions -----------------------------------------------------------------------------
    def _apply_selection(self) -> None:
        ids = [str(i.data(NAME, ID_ROLE)) for i in self.tree.selectedItems()]
        # A photo is not a record, so it remains selected here when the selection changes.
        self._is_selecting = True
        self._studio.selection.set(id_ for id_ in ids if id_ in self._items)
        self._is_selecting = False

    def _apply_item_edit(self, item: QTreeWidgetItem, _: int) -> None:
        """Apply the visibility box of a group or model."""
        if not isinstance(item, FeatureItem):
            self._set_visible(item, item.checkState(NAME))

    def _set_visible(self, item: QTreeWidgetItem, state: Qt.CheckState) -> None:
        id_, is_visible = str(item.data(NAME, ID_ROLE)), state == Qt.CheckState.Checked
        if is_visible != self._studio.visible(id_):
            self._studio.set_visible([id_], is_visible)

    def _apply_feature_edit(self, item: FeatureItem, column: int, role: int, value: Any) -> None:
        """Apply the visibility box, name or set that the user has entered for a feature."""
        if role == Qt.ItemDataRole.CheckStateRole:
            self._set_visible(item, Qt.CheckState(value))
            return
        feature = get_feature(self._studio.records, item.id)
        if feature is None or role not in _TEXT_ROLES or column not in (NAME, SET):
            return
        field = "name" if column == NAME else "set_name"
        if str(value).strip() != getattr(feature, field, ""):
            self._studio.attempt(edits.set_attributes, [item.id], **{field: str(value).strip()})

    def _apply_drop(self, type_id: str) -> None:
        ids = [str(i.data(NAME, ID_ROLE)) for i in self.tree.selectedItems()]
        self._menus.change_type(ids, type_id)

    def _edit(self, id_: str, edit_feature: QAction) -> None:
        if isinstance(self._studio.records.get(id_), Feature) and edit_feature.isEnabled():
            edit_feature.trigger()

    # --- context menu -----------------------------------------------------
    def _open_menu(self, position: QPoint) -> None:
        item = self.tree.itemAt(position)
        menu = self.create_item_menu(item)
        if not menu.isEmpty():
            menu.exec(self.tree.viewport().mapToGlobal(position))

    def create_item_menu(self, item: QTreeWidgetItem | None) -> QMenu:
        """Create the context menu of an item, or of the whole tree if no item is given."""
        photo_menu = QMenu(self)
        photo_menu.setToolTipsVisible(True)
        if item is not None and self._photos.fill_menu(photo_menu, item):
            return photo_menu
        return self.create_menu("" if item is None else str(item.data(NAME, ID_ROLE)))

    def create_menu(self, id_: str) -> QMenu:
        """Create the context menu of a record or group, or of the whole tree if `id_` is empty."""
        return self._menus.create_menu(id_)


def _check_state(is_visible: bool) -> Qt.CheckState:
    return Qt.CheckState.Checked if is_visible else Qt.CheckState.Unchecked


def _drag_flag(feature: Feature) -> Qt.ItemFlag:
    """Return the drag flag if a feature can be dragged onto another type, or no flag."""
    can_drag = get_kind(feature).has_feature_type
    return Qt.ItemFlag.ItemIsDragEnabled if can_drag else Qt.ItemFlag.NoItemFlags


def _set_name_text(_: ProjectTree, feature: Feature) -> str:
    return str(getattr(feature, "set_name", ""))


def _set_name_tip(_: ProjectTree, feature: Feature) -> str:
    return escape_markup(str(getattr(feature, "set_name", "")))


_CONTENT_READERS: dict[tuple[int, int], Callable[[ProjectTree, Feature], Any]] = {
    (NAME, Qt.ItemDataRole.DisplayRole): lambda _, feature: feature.name,
    (NAME, Qt.ItemDataRole.EditRole): lambda _, feature: feature.name,
    (NAME, Qt.ItemDataRole.CheckStateRole): ProjectTree._check_state,
    (NAME, Qt.ItemDataRole.DecorationRole): ProjectTree._feature_icon,
    (NAME, Qt.ItemDataRole.ToolTipRole): ProjectTree._name_tip,
    (ORIENTATION, Qt.ItemDataRole.DisplayRole): ProjectTree._orientation,
    (ORIENTATION, Qt.ItemDataRole.DecorationRole): ProjectTree._verdict_icon,
    (ORIENTATION, Qt.ItemDataRole.ToolTipRole): ProjectTree._orientation_tip,
    (SET, Qt.ItemDataRole.DisplayRole): _set_name_text,
    (SET, Qt.ItemDataRole.EditRole): _set_name_text,
    (SET, Qt.ItemDataRole.ToolTipRole): _set_name_tip,
}
"""Content of a feature's item by column and role."""
