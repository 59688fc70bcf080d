"""Sortable and filterable orientation table of planes and lines with errors and verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial

from PySide6.QtCore import (
    QItemSelectionModel,
    QModelIndex,
    QPoint,
    Qt,
)
from PySide6.QtGui import QAction, QGuiApplication, QKeySequence, QPalette, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QMenu,
    QTableView,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.io.settings import DETAIL_COLUMNS
from vomstudio.project.edit import Edit
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.help_links import HelpTopic, set_help_topic
from vomstudio.ui.base.qt_owner import IncrementalWork
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.copied_rows import format_rows
from vomstudio.ui.panels.features.filter_line import FilterLine
from vomstudio.ui.panels.features.record_menus import RecordMenus
from vomstudio.ui.panels.features.sorted_rows import SortedRows
from vomstudio.ui.panels.features.table_model import (
    COLUMNS,
    SPARSE_COLUMNS,
    OrientationModel,
)

# Column widths are measured on a sample of rows; measuring a thousand would block the window.
WIDTH_SAMPLE_ROWS, MAX_WIDENING_ROWS = 50, 15
# A larger number of features is listed in steps between events.
MAX_IMMEDIATE_FEATURES = 200
# Number of changed features that are updated between two events.
STEP_FEATURES = 1000


class TablePanel(QWidget):
    """Panel with the orientation table, a filter, a count and an export button.

    The table shares its selection with the other views.

    Parameters
    ----------
    menus : RecordMenus
        Context menus of the rows.
    edit_feature : QAction
        Action for a double click on a cell that cannot be edited.
    """

    def __init__(
        self, studio: Studio, export_action: QAction, menus: RecordMenus, edit_feature: QAction
    ) -> None:
        super().__init__()
        self._studio, self._menus, self._edit_feature = studio, menus, edit_feature
        self._is_updating = False
        self._filling_work = IncrementalWork(self)
        self._applied_settings: tuple[str, list[str]] = ("", [])
        self._used_columns: set[int] = set()
        self.model = OrientationModel(studio)
        self._sorted_rows = SortedRows(self.model)
        self.view = QTableView()
        # Typing a letter must not start editing, because letters are shortcuts of the outcrop view.
        self.view.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        self.view.setObjectName("orientation_table")
        self.view.setModel(self._sorted_rows)
        self.view.setSortingEnabled(True)
        self.view.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.view.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.view.setAlternatingRowColors(True)
        self.view.setWordWrap(False)
        self.view.verticalHeader().hide()
        self.view.verticalHeader().setDefaultSectionSize(24)
        self.view.horizontalHeader().setHighlightSections(False)
        self.view.horizontalHeader().setResizeContentsPrecision(WIDTH_SAMPLE_ROWS)
        self.view.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        self.view.selectionModel().selectionChanged.connect(self._apply_selection)
        self.view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.view.customContextMenuRequested.connect(self._open_menu)
        self.view.doubleClicked.connect(self._edit_row)
        header = self.view.horizontalHeader()
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(
            lambda position: self.create_column_menu().exec(header.mapToGlobal(position))
        )
        set_help_topic(
            header, lambda position: self._find_help_topic(header.logicalIndexAt(position))
        )
        set_help_topic(
            self.view, lambda _: self._find_help_topic(self.view.currentIndex().column())
        )
        viewport = self.view.viewport()
        set_help_topic(
            viewport, lambda position: self._find_help_topic(self.view.columnAt(position.x()))
        )
        copy_shortcut = QShortcut(QKeySequence.StandardKey.Copy, self.view)
        copy_shortcut.setContext(Qt.ShortcutContext.WidgetShortcut)
        copy_shortcut.activated.connect(self.copy_rows)
        self._filter = FilterLine(tr("Filter: words, or dip>30 quality:good"))
        self._filter.setMaximumWidth(360)
        self._filter.changed.connect(self._apply_filter)
        self._count_label = Label()
        button = QToolButton()
        button.setDefaultAction(export_action)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._empty_label = Label(
            tr("No planes yet. Choose Trace (T) and click along a bed on the outcrop.")
        )
        self._empty_label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._empty_label.setWordWrap(True)
        self._empty_label.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        top_row = QHBoxLayout()
        top_row.setContentsMargins(4, 2, 4, 0)
        top_row.addWidget(self._filter, 2)
        top_row.addWidget(self._count_label)
        top_row.addWidget(self._filter.problem, 3)
        top_row.addStretch(1)
        top_row.addWidget(button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addLayout(top_row)
        layout.addWidget(self._empty_label, 1)
        layout.addWidget(self.view, 1)
        self._sorted_rows.rowsInserted.connect(self._show_count)
        self._sorted_rows.rowsRemoved.connect(self._show_count)
        self._sorted_rows.modelReset.connect(self._show_count)
        # After the view, which loses its selection.
        self._sorted_rows.modelReset.connect(
            lambda: self._show_selection(self._studio.selection.ids)
        )
        studio.project_opened.connect(self._filter.clear)
        studio.project_opened.connect(self.rebuild)
        studio.settings_changed.connect(self._apply_settings)
        studio.edited.connect(self._apply_edit)
        studio.selection_changed.connect(self._show_selection)
        studio.filters.append((self, self._find_hidden_ids))

    def _find_hidden_ids(self, ids: Iterable[str]) -> set[str]:
        """Return the ids of the features among `ids` that the filter hides.

        While a filter is active, features that the table does not list count as hidden.
        """
        if self._filter.test is None:
            return set()
        return {
            id_
            for id_ in ids
            if self._sorted_rows.find_row(self.model.find_source_row(id_)) is None
        }

    def _find_help_topic(self, column: int) -> HelpTopic | None:
        if not 0 <= column < len(COLUMNS):
            return None
        return COLUMNS[column].figure or "numbers.md#orientation"

    def _apply_settings(self) -> None:
        settings = self._studio.settings
        if self._applied_settings != (settings.notation, settings.hidden_columns):
            self.rebuild()
        else:
            self.model.update_colors()

    def rebuild(self) -> None:
        """Rebuild rows and columns."""
        settings = self._studio.settings
        self._applied_settings = (settings.notation, settings.hidden_columns)
        self._filling_work.start(self._fill())

    def _fill(self) -> Iterator[None]:
        is_large_project, rows = len(self._studio.session.features()) > MAX_IMMEDIATE_FEATURES, None
        if is_large_project:
            self.model.clear()
            yield
            # An edit in the meantime completes this step before it updates its own rows.
            rows = self.model.read_rows()
            yield
        self.model.reset(rows)
        self._show_count()
        if is_large_project:
            yield
        self._fit_columns()

    # --- context menu ------------------------------------------------------------------------
    def _open_menu(self, position: QPoint) -> None:
        index = self.view.indexAt(position)
        if index.isValid():
            id_ = self.model.id_at(self._sorted_rows.mapToSource(index).row())
            self._menus.create_menu(id_).popup(self.view.viewport().mapToGlobal(position))

    def _edit_row(self, index: QModelIndex) -> None:
        """Edit the feature of a row, unless the cell itself can be edited."""
        is_editable = bool(index.flags() & Qt.ItemFlag.ItemIsEditable)
        if not is_editable and self._edit_feature.isEnabled():
            self._edit_feature.trigger()

    # --- columns and clipboard ---------------------------------------------------------------
    def create_column_menu(self) -> QMenu:
        """Create the header's context menu, with which columns are shown or hidden."""
        menu = QMenu(self)
        hidden_titles = self._studio.settings.hidden_columns
        for column in COLUMNS[1:]:
            action = menu.addAction(tr(column.title))
            action.setToolTip(tr(column.tip))
            action.setCheckable(True)
            action.setChecked(column.title not in hidden_titles)
            action.toggled.connect(partial(self._show_column, column.title))
        menu.setToolTipsVisible(True)
        menu.addSeparator()
        menu.addAction(tr("Show all columns"), lambda: self._hide_columns([]))
        return menu

    def _show_column(self, title: str, is_shown: bool) -> None:
        hidden_titles = [t for t in self._studio.settings.hidden_columns if t != title]
        self._hide_columns(hidden_titles if is_shown else [*hidden_titles, title])

    def _hide_columns(self, titles: list[str]) -> None:
        self._studio.settings.hidden_columns = titles
        self._studio.keep_settings()

    def copy_rows(self) -> None:
        """Copy the selected rows to the clipboard in a form for spreadsheets."""
        rows = sorted(self.view.selectionModel().selectedRows(), key=lambda i: i.row())
        if not rows:
            return
        # The columns of details are hidden for clarity only, unlike those that the user hides.
        hidden_titles = set(self._studio.settings.hidden_columns) - set(DETAIL_COLUMNS)
        columns = [
            i
            for i, column in enumerate(COLUMNS)
            if column.title not in hidden_titles
            and (i not in SPARSE_COLUMNS or i in self._used_columns)
        ]
        selected_rows = [
            self.model.row(self._sorted_rows.mapToSource(index).row()) for index in rows
        ]
        QGuiApplication.clipboard().setText(
            format_rows(selected_rows, [COLUMNS[i] for i in columns])
        )
        self._studio.info(Finding("table.rows-copied", count=len(rows)))

    def _apply_filter(self) -> None:
        # A row that the filter hides stays selected.
        self._is_updating = True
        self._sorted_rows.set_test(self._filter.test)
        self._is_updating = False
        self._show_count()
        self._show_selection(self._studio.selection.ids)

    def _apply_edit(self, edit: Edit) -> None:
        ids = self._studio.affected_ids(edit)
        if not ids:
            return
        self._filling_work.finish()
        self._filling_work.start(self._update(ids))

    def _update(self, ids: list[str]) -> Iterator[None]:
        """Update the rows of features; many rows are updated in steps between events."""
        was_empty = self.model.rowCount() == 0
        records = self._studio.records
        has_moved_rows = self.model.update([id_ for id_ in ids if id_ not in records])
        remaining_ids = [id_ for id_ in ids if id_ in records]
        if len(remaining_ids) > MAX_IMMEDIATE_FEATURES:
            # All panels refresh after an edit; this one lets them go first.
            yield
        for start in range(0, len(remaining_ids), STEP_FEATURES):
            if start:
                yield
            has_moved_rows |= self.model.update(remaining_ids[start : start + STEP_FEATURES])
        self.model.update_comparisons()
        if self._studio.settings.color_by == "set":
            # A new set may change the colours of all others.
            self.model.update_colors()
        self._show_count()
        if was_empty:
            self._fit_columns()
        elif new_columns := self.model.used_columns(ids) - self._used_columns:
            self._used_columns |= new_columns
            self._hide_unused_columns()
        self._widen_columns(ids)
        if has_moved_rows or self._sorted_rows.test is not None:
            # Qt keeps the selection of rows that remain.
            self._show_selection(self._studio.selection.ids)

    def _widen_columns(self, ids: list[str]) -> None:
        """Widen columns to fit the rows of the first `MAX_WIDENING_ROWS` of these features."""
        source_rows = [
            source_row
            for id_ in ids[:MAX_WIDENING_ROWS]
            if (source_row := self.model.find_source_row(id_)) is not None
        ]
        for i in range(len(COLUMNS)):
            if self.view.isColumnHidden(i):
                continue
            indexes = [
                self._sorted_rows.mapFromSource(self.model.index(source_row, i))
                for source_row in source_rows
            ]
            width = max(
                (self.view.sizeHintForIndex(index).width() + 2 for index in indexes), default=0
            )
            if min(420, width) > self.view.columnWidth(i):
                self.view.setColumnWidth(i, min(420, width))

    def _hide_unused_columns(self) -> None:
        """Hide the columns that the user has hidden, and sparse columns without values."""
        for i, column in enumerate(COLUMNS):
            is_unused = i in SPARSE_COLUMNS and i not in self._used_columns
            is_hidden = column.title in self._studio.settings.hidden_columns
            self.view.setColumnHidden(i, is_unused or is_hidden)

    def _fit_columns(self) -> None:
        self._used_columns = self.model.used_columns()
        self._hide_unused_columns()
        self.view.resizeColumnsToContents()
        for i, column in enumerate(COLUMNS):
            if column.title in ("Name", "Set", "Notes", "Quality"):
                self.view.setColumnWidth(i, max(90, self.view.columnWidth(i)))
            self.view.setColumnWidth(i, min(420, self.view.columnWidth(i)))

    def _show_count(self) -> None:
        total, shown_count = self.model.rowCount(), self._sorted_rows.rowCount()
        self._count_label.setText(
            tr_n("{count} feature", "{count} features", total)
            if shown_count == total
            else tr("{shown} of {total} features", shown=shown_count, total=total)
        )
        self._empty_label.setVisible(total == 0)
        self.view.setVisible(total > 0)

    def _apply_selection(self) -> None:
        if self._is_updating:
            return
        rows = self.view.selectionModel().selectedRows()
        ids = [self.model.id_at(self._sorted_rows.mapToSource(i).row()) for i in rows]
        current_index = self._sorted_rows.mapToSource(self.view.currentIndex())
        if current_index.isValid() and (last_id := self.model.id_at(current_index.row())) in ids:
            ids = [i for i in ids if i != last_id] + [last_id]
        self._studio.selection.set(ids)

    def _show_selection(self, ids: tuple[str, ...]) -> None:
        rows = self._sorted_rows.find_rows(self.model.find_source_rows(ids))
        selection_model = self.view.selectionModel()
        self._is_updating = True
        # Otherwise Qt would compute the position of every range.
        self.view.setUpdatesEnabled(False)
        # Qt would compare every new range with every old one.
        selection_model.clearSelection()
        # Qt would complete ranges of some columns itself, which takes longer.
        selection_model.select(
            self._sorted_rows.create_selection(rows), QItemSelectionModel.SelectionFlag.Select
        )
        if rows:
            last_index = self._sorted_rows.index(rows[-1], 0)
            selection_model.setCurrentIndex(last_index, QItemSelectionModel.SelectionFlag.NoUpdate)
            self.view.scrollTo(last_index)
        self.view.setUpdatesEnabled(True)
        self._is_updating = False
