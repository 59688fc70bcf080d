"""Qt model of the orientation table, whose columns are figures of the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import count
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
    Signal,
)

from vomstudio.core.words import to_translate, tr
from vomstudio.project import catalogue, edits, slip_figures
from vomstudio.project.figures import Figure
from vomstudio.project.kinds import KINDS, get_kind
from vomstudio.project.kinds.lithology import LITHOLOGY
from vomstudio.project.kinds.station import NUMBER, PHOTO
from vomstudio.project.length_figures import LENGTH
from vomstudio.project.records import Feature, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.feature_colors import feature_color
from vomstudio.ui.base.number_formatting import natural_sort_key, orientation_text
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.feature_row import Row, create_row, has_figure

_Index = QModelIndex | QPersistentModelIndex
# The table is reset if a larger number of rows is removed.
MAX_SINGLE_UPDATES = 200
_QUALITY_ORDER = {"good": 0, "doubtful": 1, "poor": 2, None: 3}


@dataclass(frozen=True)
class FeatureColumn:
    """Column of the orientation table.

    Attributes
    ----------
    title, tip : str
        Title and tooltip, marked for translation; the title is also the name in the settings.
    text : callable
        Returns the displayed text of a row.
    value : callable
        Returns the sort key of a row.
    field : str or None
        Attribute edited in this column, or None if the column is read-only.
    figure : Figure or None
        Figure of the catalogue, or None if the column combines several figures.
    """

    title: str
    tip: str
    text: Callable[[Row], str]
    value: Callable[[Row], Any]
    field: str | None = None
    is_left_aligned: bool = False
    figure: Figure | None = None


def _create_column(figure: Figure, value: Callable[[Row], Any] | None = None) -> FeatureColumn:
    """Create the column of a figure; `value` overrides the default sort key."""
    is_text = figure.form in ("text", "flag")
    field = figure.attribute if figure.form == "text" else ""
    return FeatureColumn(
        title=figure.title,
        tip=figure.explanation,
        text=lambda row: row.text(figure),
        value=value or (lambda row: row.text(figure) if is_text else row.value(figure)),
        field=field or None,
        is_left_aligned=is_text,
        figure=figure,
    )


ORIENTATION = FeatureColumn(
    to_translate("Orientation"),
    to_translate("Plane in the notation chosen under View > Notation; trend/plunge of a line"),
    lambda row: orientation_text(row.measured, row.notation) if row.has_orientation else "",
    lambda row: row.azimuth,
)
QUALITY = _create_column(catalogue.QUALITY, lambda row: _QUALITY_ORDER[row.quality])
OVERTURNED = _create_column(
    catalogue.OVERTURNED, lambda row: None if row.overturned is None else not row.overturned
)
TYPE = _create_column(catalogue.KIND)
ANGLE_TO_PICK = _create_column(catalogue.ANGLE_TO_PICK)
COLUMNS: tuple[FeatureColumn, ...] = (
    _create_column(catalogue.NAME, lambda row: natural_sort_key(row.feature.name)),
    TYPE,
    _create_column(catalogue.SET),
    ORIENTATION,
    QUALITY,
    OVERTURNED,
    _create_column(catalogue.TOTAL_ERROR),
    _create_column(catalogue.MAX_CONFIDENCE),
    _create_column(catalogue.MIN_CONFIDENCE),
    _create_column(catalogue.DIP_ERROR),
    _create_column(catalogue.DIP_DIRECTION_ERROR),
    _create_column(catalogue.M),
    _create_column(catalogue.K),
    _create_column(catalogue.COPLANARITY),
    _create_column(catalogue.COLLINEARITY),
    _create_column(catalogue.N_POINTS),
    _create_column(catalogue.EXTENT),
    _create_column(LENGTH),
    _create_column(catalogue.AREA),
    _create_column(LITHOLOGY),
    _create_column(catalogue.STATION),
    _create_column(NUMBER),
    _create_column(PHOTO),
    _create_column(slip_figures.RAKE),
    _create_column(slip_figures.SLIP_RAKE),
    _create_column(slip_figures.SLIP_SENSE),
    _create_column(slip_figures.ON_PLANE),
    ANGLE_TO_PICK,
    _create_column(catalogue.EXTENT_OVER_RESOLUTION),
    _create_column(catalogue.RMS),
    _create_column(catalogue.ATTITUDE_SCALE),
    _create_column(catalogue.BEND),
    _create_column(catalogue.PROFILE),
    _create_column(catalogue.NOTES),
    _create_column(catalogue.REASONS),
)
_TO_PICK_COLUMN = COLUMNS.index(ANGLE_TO_PICK)
_TYPE_COLUMN = COLUMNS.index(TYPE)
SPARSE_FIGURES = (
    catalogue.STATION,
    NUMBER,
    PHOTO,
    LENGTH,
    catalogue.AREA,
    LITHOLOGY,
    *slip_figures.SLIP,
)
SPARSE_COLUMNS = tuple(i for i, c in enumerate(COLUMNS) if c.figure in SPARSE_FIGURES)
"""Columns that only some kinds of features have; they are hidden while no row has a value."""


_READING_RECORDS = tuple(
    kind.record for kind in KINDS if kind.orientations and kind.evidence == "read"
)
_DEFAULT_FLAGS = (
    Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemNeverHasChildren
)
_FLAGS = [
    _DEFAULT_FLAGS
    | (Qt.ItemFlag.ItemIsEditable if column.field else Qt.ItemFlag.NoItemFlags)
    | (Qt.ItemFlag.ItemIsUserCheckable if column is OVERTURNED else Qt.ItemFlag.NoItemFlags)
    for column in COLUMNS
]


def column_flags(index: _Index) -> Qt.ItemFlag:
    """Return the flags of a cell, computed once per column.

    Qt reads the flags of every cell when thousands of rows are selected.
    """
    return _FLAGS[index.column()] if index.isValid() else Qt.ItemFlag.NoItemFlags


def _is_listed(feature: Feature) -> bool:
    """Return whether the table lists a feature: planes, lines and a few other kinds."""
    feature_kind = get_kind(feature)
    return bool(feature_kind.orientations) or feature_kind.listed


class OrientationModel(QAbstractTableModel):
    """Table with one row per listed feature and the columns in COLUMNS."""

    rows_changed = Signal(list)
    """Emits the source rows of changed features."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._rows: list[Row] = []
        self._source_rows: dict[str, int] = {}

    def clear(self) -> None:
        """Remove all rows."""
        self.beginResetModel()
        self._rows, self._source_rows = [], {}
        self.endResetModel()

    def read_rows(self) -> list[Row]:
        """Create the rows of all listed features without showing them."""
        features = [f for f in self._studio.session.features() if _is_listed(f)]
        measurements = self._studio.measured(feature.id for feature in features)
        return [create_row(self._studio, feature, measurements[feature.id]) for feature in features]

    def reset(self, rows: list[Row] | None = None) -> None:
        """Show the given rows, or the rows of all features."""
        self.beginResetModel()
        self._rows = self.read_rows() if rows is None else rows
        self._source_rows = {row.feature.id: i for i, row in enumerate(self._rows)}
        self.endResetModel()

    def update(self, ids: list[str]) -> bool:
        """Update the rows of added, changed or deleted features.

        Returns
        -------
        bool
            Whether rows have been added or removed.
        """
        records = self._studio.records
        removed_ids = [i for i in ids if i in self._source_rows and i not in records]
        if len(removed_ids) > MAX_SINGLE_UPDATES:
            self.reset()
            return True
        self._remove_rows(removed_ids)
        measurements = self._studio.measured(ids)
        changed_rows: list[int] = []
        new_rows: dict[str, Row] = {}
        for id_ in ids:
            feature = get_feature(records, id_)
            if feature is None or not _is_listed(feature):
                continue
            row = create_row(self._studio, feature, measurements[id_])
            source_row = self._source_rows.get(id_)
            if source_row is None:
                new_rows[id_] = row
            else:
                self._rows[source_row] = row
                changed_rows.append(source_row)
        if changed_rows:
            self.rows_changed.emit(changed_rows)
        self._append_rows(new_rows)
        return bool(removed_ids or new_rows)

    def _append_rows(self, rows: dict[str, Row]) -> None:
        if rows:
            start = len(self._rows)
            self.beginInsertRows(QModelIndex(), start, start + len(rows) - 1)
            self._rows += rows.values()
            self._source_rows.update(zip(rows, count(start), strict=False))
            self.endInsertRows()

    def _remove_rows(self, ids: list[str]) -> None:
        for id_ in ids:
            source_row = self._source_rows.get(id_)
            if source_row is not None:
                self.beginRemoveRows(QModelIndex(), source_row, source_row)
                del self._rows[source_row], self._source_rows[id_]
                later_ids = (row.feature.id for row in self._rows[source_row:])
                self._source_rows.update(zip(later_ids, count(source_row), strict=False))
                self.endRemoveRows()

    def row(self, source_row: int) -> Row:
        """Return the row with this number in the source table."""
        return self._rows[source_row]

    def update_comparisons(self) -> None:
        """Repaint the angles between readings and picks after other rows have changed."""
        if self._rows and any(self._studio.session.of(record) for record in _READING_RECORDS):
            self.dataChanged.emit(
                self.index(0, _TO_PICK_COLUMN), self.index(len(self._rows) - 1, _TO_PICK_COLUMN)
            )

    def used_columns(self, ids: Iterable[str] | None = None) -> set[int]:
        """Return the numbers of the sparse columns that are not empty in the rows of features.

        Parameters
        ----------
        ids : iterable of str, optional
            Ids of the features; by default, all rows are included.

        Returns
        -------
        set of int
        """
        rows = self._rows
        if ids is not None:
            rows = [self._rows[i] for id_ in ids if (i := self._source_rows.get(id_)) is not None]
        figures = {i: figure for i in SPARSE_COLUMNS if (figure := COLUMNS[i].figure) is not None}
        rows_by_kind: dict[str, list[Row]] = {}
        for row in rows:
            rows_by_kind.setdefault(get_kind(row.feature).name, []).append(row)
        return {
            i
            for i, figure in figures.items()
            for kind_name, kind_rows in rows_by_kind.items()
            if has_figure(kind_name, figure)
            and any(row.value(figure) not in (None, "") for row in kind_rows)
        }

    def update_colors(self) -> None:
        """Repaint the colours of all rows."""
        if self._rows:
            last_index = self.index(len(self._rows) - 1, _TYPE_COLUMN)
            self.dataChanged.emit(self.index(0, _TYPE_COLUMN), last_index)

    def id_at(self, source_row: int) -> str:
        """Return the feature id of a source row."""
        return str(self._rows[source_row].feature.id)

    def find_source_row(self, id_: str) -> int | None:
        """Return the source row of a feature, or None if the feature is not listed."""
        return self._source_rows.get(id_)

    def find_source_rows(self, ids: Iterable[str]) -> list[int | None]:
        """Return the source row of each feature.

        Parameters
        ----------
        ids : iterable of str

        Returns
        -------
        list of int or None
            None for a feature that is not listed.
        """
        return list(map(self._source_rows.get, ids))

    # --- Qt interface ------------------------------------------------------------------------
    def rowCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index = QModelIndex()) -> int:  # noqa: N802, B008
        return 0 if parent.isValid() else len(COLUMNS)

    def headerData(  # noqa: N802
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Horizontal:
            if role == Qt.ItemDataRole.DisplayRole:
                return tr(COLUMNS[section].title)
            if role == Qt.ItemDataRole.ToolTipRole:
                return tr(COLUMNS[section].tip)
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        return self.cell(index.row(), index.column(), role)

    def cell(self, source_row: int, column_number: int, role: int) -> Any:
        """Return the data of a cell of a source row for a Qt role, or None if it has no data."""
        row, column = self._rows[source_row], COLUMNS[column_number]
        if column is OVERTURNED:
            if role == Qt.ItemDataRole.CheckStateRole and row.overturned is not None:
                return Qt.CheckState.Checked if row.overturned else Qt.CheckState.Unchecked
            if role == Qt.ItemDataRole.DisplayRole:
                # The check box shows the value instead.
                return None
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return column.text(row)
        if role == Qt.ItemDataRole.DecorationRole:
            if column is QUALITY:
                return theme.verdict_icon(row.quality)
            if column is TYPE and row.type is not None:
                color = feature_color(self._studio, row.feature, row.measured)
                return theme.type_icon(color, row.type.symbol)
        if role == Qt.ItemDataRole.TextAlignmentRole and not column.is_left_aligned:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        if role == Qt.ItemDataRole.ToolTipRole:
            if column is QUALITY and (verdict := row.measured.verdict):
                return escape_markup(
                    "\n".join(filter(None, (row.reasons, verdict.limits.description)))
                )
            return escape_markup(row.reasons or tr(column.tip))
        return None

    def flags(self, index: _Index) -> Qt.ItemFlag:
        return column_flags(index)

    def setData(  # noqa: N802
        self, index: _Index, value: Any, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        field = COLUMNS[index.column()].field
        row = self._rows[index.row()]
        if role == Qt.ItemDataRole.CheckStateRole and row.overturned is not None:
            # Qt passes an int.
            is_overturned = Qt.CheckState(value) == Qt.CheckState.Checked
            return self._studio.attempt(
                edits.set_attributes, [row.feature.id], overturned=is_overturned
            )
        fields = [attribute.field for attribute in get_kind(row.feature).attributes]
        if field is None or field not in fields or value == getattr(row.feature, field):
            return False
        return self._studio.attempt(
            edits.set_attributes, [row.feature.id], **{field: value.strip()}
        )
