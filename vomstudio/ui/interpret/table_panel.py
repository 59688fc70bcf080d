"""The orientation table: all planes and lines with errors and verdict, sorted and filtered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QSortFilterProxyModel,
    Qt,
)
from PySide6.QtGui import QAction, QGuiApplication, QKeySequence, QPalette, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QMenu,
    QTableView,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document import edits
from vomstudio.document.edit import Edit
from vomstudio.document.records import TYPED, Reading
from vomstudio.ui.common import theme
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.wording import area, degrees, length, natural, number, orientation_text
from vomstudio.ui.interpret.feature_filter import Test
from vomstudio.ui.interpret.feature_row import Row, row_of
from vomstudio.ui.interpret.filter_line import FilterLine

_Index = QModelIndex | QPersistentModelIndex
_SORT = Qt.ItemDataRole.UserRole
# Column widths are taken from so many rows: all of a thousand would hold the window up.
_MEASURED_ROWS = 50
# More rows than this are sorted in anew together, not one by one.
_AT_ONCE = 200
_QUALITY_ORDER = {"good": 0, "doubtful": 1, "poor": 2, None: 3}


@dataclass(frozen=True)
class Column:
    """text: what is shown; value: what is sorted by; field: the attribute that can be typed."""

    title: str
    tip: str
    text: Callable[[Row], str]
    value: Callable[[Row], Any]
    field: str | None = None
    left: bool = False


def _fit(title: str, name: str, tip: str, words: Callable[[Any], str]) -> Column:
    return Column(title, tip, lambda r: words(r.fit(name)), lambda r: r.fit(name))


def _measured(title: str, name: str, tip: str, words: Callable[[Any], str]) -> Column:
    return Column(
        title, tip, lambda r: words(getattr(r.measured, name)), lambda r: getattr(r.measured, name)
    )


COLUMNS: tuple[Column, ...] = (
    Column("Name", "Name", lambda r: r.feature.name, lambda r: natural(r.feature.name),
           "name", True),
    Column(
        "Type",
        "Feature type",
        lambda r: r.type_name,
        lambda r: r.type_name,
        None,
        True,
    ),
    Column("Set", "Set", lambda r: r.set_name, lambda r: r.set_name,
           "set_name", True),
    Column(
        "Orientation",
        "Plane in the notation chosen under View > Notation; trend/plunge of a line",
        lambda r: orientation_text(r.measured, r.notation),
        lambda r: r.azimuth,
    ),
    Column(
        "Quality",
        "Verdict on the plane or line, with its reasons",
        lambda r: r.quality or ("no plane" if r.measured.problem else "–"),
        lambda r: _QUALITY_ORDER[r.quality],
        None,
        True,
    ),
    Column(
        "Overturned",
        "The bed is upside down: its younging is known",
        lambda r: "yes" if r.overturned else "",
        lambda r: None if r.overturned is None else not r.overturned,
        None,
        True,
    ),
    _measured(
        "95 % max",
        "max_confidence95_deg",
        "Largest tilt inside the joint 95 % confidence region of the plane or line",
        degrees,
    ),
    _measured("95 % min", "min_confidence95_deg", "The same, in the best known direction", degrees),
    _fit("± dip", "dip_error_deg", "95 % error of the dip", degrees),
    _fit(
        "± dip dir.",
        "dip_direction_error_deg",
        "95 % error of the dip direction; undefined near horizontal",
        degrees,
    ),
    _fit("M", "M", "ln(l1/l3): over 4 is well defined", number),
    _fit("K", "K", "ln(l1/l2)/ln(l2/l3): under 0.8 is not a line", number),
    _fit("Coplan.", "coplanarity", "Coplanarity index 1/l3 (textbook eq. 20)", number),
    _fit("Collin.", "collinearity", "Collinearity index l1/l2 (textbook eq. 21)", number),
    _fit("n", "n", "Number of points", lambda v: "–" if v is None else str(v)),
    Column(
        "Extent",
        "Longest axis of the trace, diameter of the patch",
        lambda r: length(r.fit("extent"), metric=r.measured.metric),
        lambda r: r.fit("extent"),
    ),
    Column(
        "Area",
        "Area of the patch's faces",
        lambda r: area(r.measured.area_m2, metric=r.measured.metric),
        lambda r: r.measured.area_m2,
    ),
    Column(
        "Rake",
        "Of a line in its plane, from the right-hand-rule strike; of a slip -180 to 180, positive "
        "reverse",
        lambda r: degrees(r.rake),
        lambda r: r.rake,
    ),
    Column(
        "To pick",
        "Of a compass reading: its angle from the nearest pick of the same type, or from the most "
        "alike where the reading has no position",
        lambda r: degrees(r.to_pick),
        lambda r: r.to_pick,
    ),
    Column(
        "Ext./res.",
        "Extent over the model's resolution: 100 is wanted",
        lambda r: number(r.ratio, 2),
        lambda r: r.ratio,
    ),
    Column(
        "RMS",
        "Root mean square distance from the plane",
        lambda r: length(r.fit("rms"), metric=r.measured.metric),
        lambda r: r.fit("rms"),
    ),
    Column("Reasons", "Why the verdict is what it is", lambda r: r.reasons, lambda r: r.reasons,
           None, True),
    Column("Notes", "Notes", lambda r: r.feature.notes, lambda r: r.feature.notes, "notes", True),
)  # fmt: skip

_TO_PICK = next(i for i, column in enumerate(COLUMNS) if column.title == "To pick")


class OrientationModel(QAbstractTableModel):
    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._rows: list[Row] = []
        self._places: dict[str, int] = {}

    def reset(self) -> None:
        self.beginResetModel()
        features = [f for f in self._studio.session.features() if isinstance(f, TYPED)]
        measured = self._studio.measured(feature.id for feature in features)
        self._rows = [row_of(self._studio, feature, measured[feature.id]) for feature in features]
        self._places = {row.feature.id: i for i, row in enumerate(self._rows)}
        self.endResetModel()

    def update(self, ids: list[str]) -> None:
        """Some features are new, other, or gone."""
        if len(ids) > _AT_ONCE or any(self._studio.records.get(i) is None for i in ids):
            self.reset()
            return
        measured = self._studio.measured(ids)
        for id_ in ids:
            feature = self._studio.records[id_]
            if not isinstance(feature, TYPED):
                continue
            row = row_of(self._studio, feature, measured[id_])
            place = self._places.get(id_)
            if place is None:
                place = len(self._rows)
                self.beginInsertRows(QModelIndex(), place, place)
                self._rows.append(row)
                self._places[id_] = place
                self.endInsertRows()
            else:
                self._rows[place] = row
                self.dataChanged.emit(self.index(place, 0), self.index(place, len(COLUMNS) - 1))

    def row(self, place: int) -> Row:
        return self._rows[place]

    def compare_again(self) -> None:
        """Readings are compared with other rows, which have changed."""
        if any(isinstance(row.feature, Reading) for row in self._rows):
            self.dataChanged.emit(
                self.index(0, _TO_PICK), self.index(len(self._rows) - 1, _TO_PICK)
            )

    def id_at(self, row: int) -> str:
        return self._rows[row].feature.id

    def place(self, id_: str) -> int | None:
        return self._places.get(id_)

    # --- Qt's names ---------------------------------------------------------------------------
    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(COLUMNS)

    def headerData(  # noqa: N802
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Horizontal:
            if role == Qt.ItemDataRole.DisplayRole:
                return COLUMNS[section].title
            if role == Qt.ItemDataRole.ToolTipRole:
                return COLUMNS[section].tip
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row, column = self._rows[index.row()], COLUMNS[index.column()]
        if column.title == "Overturned":
            if role == Qt.ItemDataRole.CheckStateRole and row.overturned is not None:
                return Qt.CheckState.Checked if row.overturned else Qt.CheckState.Unchecked
            if role == Qt.ItemDataRole.DisplayRole:
                # The box says it.
                return None
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return column.text(row)
        if role == _SORT:
            return column.value(row)
        if role == Qt.ItemDataRole.DecorationRole:
            if column.title == "Quality":
                return theme.verdict_icon(row.quality)
            if column.title == "Type" and row.kind:
                return theme.type_icon(row.kind.color, row.kind.symbol)
        if role == Qt.ItemDataRole.TextAlignmentRole and not column.left:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        if role == Qt.ItemDataRole.ToolTipRole:
            return row.reasons or column.tip
        return None

    def flags(self, index: _Index) -> Qt.ItemFlag:
        flags = super().flags(index)
        if COLUMNS[index.column()].field:
            flags |= Qt.ItemFlag.ItemIsEditable
        if COLUMNS[index.column()].title == "Overturned":
            flags |= Qt.ItemFlag.ItemIsUserCheckable
        return flags

    def setData(  # noqa: N802
        self, index: _Index, value: Any, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        field = COLUMNS[index.column()].field
        row = self._rows[index.row()]
        if role == Qt.ItemDataRole.CheckStateRole and row.overturned is not None:
            # Qt hands over a plain number.
            on = Qt.CheckState(value) == Qt.CheckState.Checked
            return self._studio.attempt(edits.set_attributes, [row.feature.id], overturned=on)
        if field is None or value == getattr(row.feature, field):
            return False
        return self._studio.attempt(
            edits.set_attributes, [row.feature.id], **{field: value.strip()}
        )


class _Sorted(QSortFilterProxyModel):
    test: Test | None = None

    def set_test(self, test: Test | None) -> None:
        """Rows stay that pass the test; all of them without one."""
        self.test = test
        self.invalidate()

    def lessThan(self, left: _Index, right: _Index) -> bool:  # noqa: N802
        a, b = left.data(_SORT), right.data(_SORT)
        if a is None or b is None:
            # What is undefined stands last either way round.
            first, second = a is None, b is None
            descending = self.sortOrder() == Qt.SortOrder.DescendingOrder
            return first and not second if descending else second and not first
        return bool(a < b)

    def filterAcceptsRow(self, row: int, parent: _Index) -> bool:  # noqa: N802
        model = self.sourceModel()
        assert isinstance(model, OrientationModel)
        return self.test is None or self.test(model.row(row))


class TablePanel(QWidget):
    def __init__(self, studio: Studio, export: QAction) -> None:
        super().__init__()
        self._studio = studio
        self._showing = False
        self._seen_settings: tuple[str, list[str]] = ("", [])
        self.model = OrientationModel(studio)
        self._sorted = _Sorted()
        self._sorted.setSourceModel(self.model)
        self.view = QTableView()
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
        copy = QShortcut(QKeySequence.StandardKey.Copy, self.view)
        copy.setContext(Qt.ShortcutContext.WidgetShortcut)
        copy.activated.connect(self.copy_rows)
        self._filter = FilterLine(self.tr("Filter: words, or dip>30 quality:good"))
        self._filter.setMaximumWidth(360)
        self._filter.changed.connect(self._filtered)
        self._count = QLabel()
        button = QToolButton()
        button.setDefaultAction(export)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._empty = QLabel(
            self.tr("Planes appear here. Choose Trace (T) and click along a bed on the outcrop.")
        )
        self._empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
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

    def _settings_changed(self) -> None:
        settings = self._studio.settings
        if self._seen_settings != (settings.notation, settings.hidden_columns):
            self.rebuild()

    def rebuild(self) -> None:
        settings = self._studio.settings
        self._seen_settings = (settings.notation, settings.hidden_columns)
        self.model.reset()
        self._counted()
        self._fit_columns()
        self._show_selection(self._studio.selection.ids)

    # --- columns and copies ------------------------------------------------------------------
    def column_menu(self) -> QMenu:
        """Which columns are shown."""
        menu = QMenu(self)
        hidden = self._studio.settings.hidden_columns
        for column in COLUMNS[1:]:
            action = menu.addAction(column.title)
            action.setToolTip(column.tip)
            action.setCheckable(True)
            action.setChecked(column.title not in hidden)
            action.toggled.connect(partial(self._show_column, column.title))
        menu.setToolTipsVisible(True)
        menu.addSeparator()
        menu.addAction(self.tr("Show all columns"), lambda: self._hide_columns([]))
        return menu

    def _show_column(self, title: str, shown: bool) -> None:
        hidden = [t for t in self._studio.settings.hidden_columns if t != title]
        self._hide_columns(hidden if shown else [*hidden, title])

    def _hide_columns(self, titles: list[str]) -> None:
        self._studio.settings.hidden_columns = titles
        self._studio.keep_settings()

    def copy_rows(self) -> None:
        """The selected rows as they are shown, under their titles, for a spreadsheet."""
        rows = sorted(self.view.selectionModel().selectedRows(), key=lambda i: i.row())
        if not rows:
            return
        columns = [i for i in range(len(COLUMNS)) if not self.view.isColumnHidden(i)]
        lines = [[COLUMNS[i].title for i in columns]]
        for index in rows:
            row = self.model.row(self._sorted.mapToSource(index).row())
            lines.append([" ".join(COLUMNS[i].text(row).split()) for i in columns])
        QGuiApplication.clipboard().setText("\n".join("\t".join(line) for line in lines) + "\n")
        many = "s" if len(rows) != 1 else ""
        self._studio.info(f"Copied {len(rows)} row{many} of the table.")

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
        first = self.model.rowCount() == 0
        self.model.update(ids)
        self.model.compare_again()
        self._counted()
        if first:
            self._fit_columns()
        self._widen(ids)
        self._show_selection(self._studio.selection.ids)

    def _widen(self, ids: list[str]) -> None:
        """Nothing of these rows is cut off; what the user has made wider stays."""
        places = [p for id_ in ids[:_MEASURED_ROWS] if (p := self.model.place(id_)) is not None]
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
            f"{total} feature{'s' if total != 1 else ''}"
            if shown == total
            else f"{shown} of {total} features"
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
        last = QModelIndex()
        rows = []
        for id_ in ids:
            place = self.model.place(id_)
            if place is not None:
                index = self._sorted.mapFromSource(self.model.index(place, 0))
                if index.isValid():
                    rows.append(index.row())
                    last = index
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
