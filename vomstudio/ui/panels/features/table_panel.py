"""The orientation table: all planes and lines with errors and verdict, sorted and filtered."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial

from PySide6.QtCore import (
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
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
from vomstudio.project.edit import Edit
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.help_links import HelpTopic, explain
from vomstudio.ui.base.qt_owner import IncrementalWork
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.copied_rows import as_text
from vomstudio.ui.panels.features.filter_line import FilterLine
from vomstudio.ui.panels.features.sorted_rows import SortedRows
from vomstudio.ui.panels.features.table_model import COLUMNS, OrientationModel

# Column widths are taken from so many rows: all of a thousand would hold the window up.
_MEASURED_ROWS, _NEW_ROWS = 50, 15
# More features than this are listed and measured for the columns' widths one after the other.
_AT_ONCE = 200


class TablePanel(QWidget):
    """Filter line, count and export button above the table; its selection is the studio's."""

    def __init__(self, studio: Studio, export: QAction) -> None:
        super().__init__()
        self._studio = studio
        self._showing = False
        self._portions = IncrementalWork(self)
        self._seen_settings: tuple[str, list[str]] = ("", [])
        self.model = OrientationModel(studio)
        self._sorted = SortedRows(self.model)
        self.view = QTableView()
        # Letters are the outcrop's: it is read more than it is filled in.
        self.view.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        self.view.setObjectName("orientation_table")
        self.view.setModel(self._sorted)
        self.view.setSortingEnabled(True)
        self.view.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.view.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.view.setAlternatingRowColors(True)
        self.view.setWordWrap(False)
        self.view.verticalHeader().hide()
        self.view.verticalHeader().setDefaultSectionSize(24)
        self.view.horizontalHeader().setHighlightSections(False)
        self.view.horizontalHeader().setResizeContentsPrecision(_MEASURED_ROWS)
        self.view.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        self.view.selectionModel().selectionChanged.connect(self._selected)
        header = self.view.horizontalHeader()
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(
            lambda at: self.column_menu().exec(header.mapToGlobal(at))
        )
        explain(header, lambda at: self._explained(header.logicalIndexAt(at)))
        explain(self.view, lambda _: self._explained(self.view.currentIndex().column()))
        port = self.view.viewport()
        explain(port, lambda at: self._explained(self.view.columnAt(at.x())))
        copy = QShortcut(QKeySequence.StandardKey.Copy, self.view)
        copy.setContext(Qt.ShortcutContext.WidgetShortcut)
        copy.activated.connect(self.copy_rows)
        self._filter = FilterLine(tr("Filter: words, or dip>30 quality:good"))
        self._filter.setMaximumWidth(360)
        self._filter.changed.connect(self._filtered)
        self._count = Label()
        button = QToolButton()
        button.setDefaultAction(export)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._empty = Label(
            tr("No planes yet. Choose Trace (T) and click along a bed on the outcrop.")
        )
        self._empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._empty.setWordWrap(True)
        self._empty.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        top = QHBoxLayout()
        top.setContentsMargins(4, 2, 4, 0)
        top.addWidget(self._filter, 2)
        top.addWidget(self._count)
        top.addWidget(self._filter.problem, 3)
        top.addStretch(1)
        top.addWidget(button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addLayout(top)
        layout.addWidget(self._empty, 1)
        layout.addWidget(self.view, 1)
        self._sorted.rowsInserted.connect(self._counted)
        self._sorted.rowsRemoved.connect(self._counted)
        self._sorted.modelReset.connect(self._counted)
        studio.project_opened.connect(self.rebuild)
        studio.settings_changed.connect(self._settings_changed)
        studio.edited.connect(self._edited)
        studio.selection_changed.connect(self._show_selection)
        studio.filters.append((self, self._filtered_out))

    def _filtered_out(self, ids: Iterable[str]) -> set[str]:
        """Those of these features that the filter hides."""
        if self._filter.test is None:
            return set()
        return {id_ for id_ in ids if self._sorted.row_of(self.model.place(id_)) is None}

    def _explained(self, column: int) -> HelpTopic | None:
        if not 0 <= column < len(COLUMNS):
            return None
        return COLUMNS[column].figure or "numbers.md#orientation"

    def _settings_changed(self) -> None:
        settings = self._studio.settings
        if self._seen_settings != (settings.notation, settings.hidden_columns):
            self.rebuild()

    def rebuild(self) -> None:
        """Read rows and columns anew."""
        settings = self._studio.settings
        self._seen_settings = (settings.notation, settings.hidden_columns)
        self._portions.start(self._fill())

    def _fill(self) -> Iterator[None]:
        many, rows = len(self._studio.session.features()) > _AT_ONCE, None
        if many:
            self.model.clear()
            yield
            # An edit meanwhile has what is left of this done before its own rows are brought up.
            rows = self.model.read()
            yield
        self.model.reset(rows)
        self._counted()
        self._show_selection(self._studio.selection.ids)
        if many:
            yield
        self._fit_columns()

    # --- columns and copies ------------------------------------------------------------------
    def column_menu(self) -> QMenu:
        """Context menu of the header: which columns are shown."""
        menu = QMenu(self)
        hidden = self._studio.settings.hidden_columns
        for column in COLUMNS[1:]:
            action = menu.addAction(tr(column.title))
            action.setToolTip(tr(column.tip))
            action.setCheckable(True)
            action.setChecked(column.title not in hidden)
            action.toggled.connect(partial(self._show_column, column.title))
        menu.setToolTipsVisible(True)
        menu.addSeparator()
        menu.addAction(tr("Show all columns"), lambda: self._hide_columns([]))
        return menu

    def _show_column(self, title: str, shown: bool) -> None:
        hidden = [t for t in self._studio.settings.hidden_columns if t != title]
        self._hide_columns(hidden if shown else [*hidden, title])

    def _hide_columns(self, titles: list[str]) -> None:
        self._studio.settings.hidden_columns = titles
        self._studio.keep_settings()

    def copy_rows(self) -> None:
        """Copy the selected rows to the clipboard, as a spreadsheet takes them."""
        rows = sorted(self.view.selectionModel().selectedRows(), key=lambda i: i.row())
        if not rows:
            return
        columns = [i for i in range(len(COLUMNS)) if not self.view.isColumnHidden(i)]
        chosen = [self.model.row(self._sorted.mapToSource(index).row()) for index in rows]
        QGuiApplication.clipboard().setText(as_text(chosen, [COLUMNS[i] for i in columns]))
        self._studio.info(Finding("table.rows-copied", count=len(rows)))

    def _filtered(self) -> None:
        # A row that goes out of sight stays selected.
        self._showing = True
        self._sorted.set_test(self._filter.test)
        self._showing = False
        self._counted()
        self._show_selection(self._studio.selection.ids)

    def _edited(self, edit: Edit) -> None:
        ids = self._studio.affected(edit)
        if not ids:
            return
        self._portions.finish()
        first = self.model.rowCount() == 0
        self.model.update(ids)
        self.model.update_comparisons()
        self._counted()
        if first:
            self._fit_columns()
        self._widen(ids)
        self._show_selection(self._studio.selection.ids)

    def _widen(self, ids: list[str]) -> None:
        """Make columns wide enough for these rows; none becomes narrower."""
        places = [p for id_ in ids[:_NEW_ROWS] if (p := self.model.place(id_)) is not None]
        for i in range(len(COLUMNS)):
            shown = [self._sorted.mapFromSource(self.model.index(place, i)) for place in places]
            wanted = max((self.view.sizeHintForIndex(s).width() + 2 for s in shown), default=0)
            if min(420, wanted) > self.view.columnWidth(i):
                self.view.setColumnWidth(i, min(420, wanted))

    def _fit_columns(self) -> None:
        for i, column in enumerate(COLUMNS):
            self.view.setColumnHidden(i, column.title in self._studio.settings.hidden_columns)
        self.view.resizeColumnsToContents()
        for i, column in enumerate(COLUMNS):
            if column.title in ("Name", "Set", "Notes", "Quality"):
                self.view.setColumnWidth(i, max(90, self.view.columnWidth(i)))
            self.view.setColumnWidth(i, min(420, self.view.columnWidth(i)))

    def _counted(self) -> None:
        total, shown = self.model.rowCount(), self._sorted.rowCount()
        self._count.setText(
            tr_n("{count} feature", "{count} features", total)
            if shown == total
            else tr("{shown} of {total} features", shown=shown, total=total)
        )
        self._empty.setVisible(total == 0)
        self.view.setVisible(total > 0)

    def _selected(self) -> None:
        if self._showing:
            return
        rows = self.view.selectionModel().selectedRows()
        ids = [self.model.id_at(self._sorted.mapToSource(i).row()) for i in rows]
        current = self._sorted.mapToSource(self.view.currentIndex())
        if current.isValid() and (last := self.model.id_at(current.row())) in ids:
            ids = [i for i in ids if i != last] + [last]
        self._studio.selection.set(ids)

    def _show_selection(self, ids: tuple[str, ...]) -> None:
        shown = (self._sorted.row_of(self.model.place(id_)) for id_ in ids)
        rows = [row for row in shown if row is not None]
        last = self._sorted.index(rows[-1], 0) if rows else QModelIndex()
        # As runs of rows: Qt looks at every column of every range.
        rows.sort()
        chosen = QItemSelection()
        start = 0
        for i in range(1, len(rows) + 1):
            if i == len(rows) or rows[i] != rows[i - 1] + 1:
                first, end = rows[start], rows[i - 1]
                chosen.select(self._sorted.index(first, 0), self._sorted.index(end, 0))
                start = i
        selection = self.view.selectionModel()
        self._showing = True
        selection.select(
            chosen,
            QItemSelectionModel.SelectionFlag.ClearAndSelect
            | QItemSelectionModel.SelectionFlag.Rows,
        )
        if last.isValid():
            selection.setCurrentIndex(last, QItemSelectionModel.SelectionFlag.NoUpdate)
            self.view.scrollTo(last)
        self._showing = False
