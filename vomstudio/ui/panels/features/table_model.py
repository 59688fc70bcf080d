"""Qt model of the orientation table: figures of the catalogue in the window's order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
)

from vomstudio.core.words import to_translate, tr
from vomstudio.project import catalogue as of
from vomstudio.project import edits, slip_figures
from vomstudio.project.figures import Figure
from vomstudio.project.kinds import KINDS, kind_of
from vomstudio.project.kinds.lithology import LITHOLOGY
from vomstudio.project.kinds.station import NUMBER, PHOTO
from vomstudio.project.length_figures import LENGTH
from vomstudio.project.records import Feature, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import as_words
from vomstudio.ui.base.number_formatting import natural, orientation_text
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.feature_row import Row, row_of

_Index = QModelIndex | QPersistentModelIndex
# More rows than this are sorted in anew together, not one by one.
_AT_ONCE = 200
_QUALITY_ORDER = {"good": 0, "doubtful": 1, "poor": 2, None: 3}


@dataclass(frozen=True)
class FeatureColumn:
    """title, tip: noted for translation, title also names it in the settings; text: what is shown;
    value: what is sorted by; field: the attribute that can be edited; figure: the one of the
    catalogue that it shows, None where it is made of several."""

    title: str
    tip: str
    text: Callable[[Row], str]
    value: Callable[[Row], Any]
    field: str | None = None
    left: bool = False
    figure: Figure | None = None


def _of(figure: Figure, value: Callable[[Row], Any] | None = None) -> FeatureColumn:
    """A figure as a column; `value` where it is sorted by something else."""
    words = figure.form in ("text", "flag")
    typed = figure.attribute if figure.form == "text" else ""
    return FeatureColumn(
        figure.title,
        figure.explanation,
        lambda row: row.text(figure),
        value or (lambda row: row.text(figure) if words else row.value(figure)),
        typed or None,
        words,
        figure,
    )


ORIENTATION = FeatureColumn(
    to_translate("Orientation"),
    to_translate("Plane in the notation chosen under View > Notation; trend/plunge of a line"),
    lambda row: orientation_text(row.measured, row.notation) if row.oriented else "",
    lambda row: row.azimuth,
)
QUALITY = _of(of.QUALITY, lambda row: _QUALITY_ORDER[row.quality])
OVERTURNED = _of(of.OVERTURNED, lambda row: None if row.overturned is None else not row.overturned)
TYPE = _of(of.KIND)
TO_PICK = _of(of.TO_PICK)
COLUMNS: tuple[FeatureColumn, ...] = (
    _of(of.NAME, lambda row: natural(row.feature.name)),
    TYPE,
    _of(of.SET),
    ORIENTATION,
    QUALITY,
    OVERTURNED,
    _of(of.TOTAL),
    _of(of.MAX_CONFIDENCE),
    _of(of.MIN_CONFIDENCE),
    _of(of.DIP_ERROR),
    _of(of.DIP_DIRECTION_ERROR),
    _of(of.M),
    _of(of.K),
    _of(of.COPLANARITY),
    _of(of.COLLINEARITY),
    _of(of.N_POINTS),
    _of(of.EXTENT),
    _of(LENGTH),
    _of(of.AREA),
    _of(LITHOLOGY),
    _of(NUMBER),
    _of(PHOTO),
    _of(slip_figures.RAKE),
    _of(slip_figures.SLIP_RAKE),
    _of(slip_figures.SLIP_SENSE),
    _of(slip_figures.ON_PLANE),
    TO_PICK,
    _of(of.EXTENT_OVER_RESOLUTION),
    _of(of.RMS),
    _of(of.ATTITUDE_SCALE),
    _of(of.BEND),
    _of(of.REASONS),
    _of(of.PROFILE),
    _of(of.NOTES),
)
_TO_PICK = COLUMNS.index(TO_PICK)


_READ = tuple(kind.record for kind in KINDS if kind.orientations and kind.evidence == "read")
_LOOKED_AT = (
    Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemNeverHasChildren
)
_FLAGS = [
    _LOOKED_AT
    | (Qt.ItemFlag.ItemIsEditable if column.field else Qt.ItemFlag.NoItemFlags)
    | (Qt.ItemFlag.ItemIsUserCheckable if column is OVERTURNED else Qt.ItemFlag.NoItemFlags)
    for column in COLUMNS
]


def flags_of(index: _Index) -> Qt.ItemFlag:
    """What can be done with a cell: all of a column are alike, and Qt asks for each of them when
    thousands of rows are selected."""
    return _FLAGS[index.column()] if index.isValid() else Qt.ItemFlag.NoItemFlags


def _listed(feature: Feature) -> bool:
    """The table is one of planes and lines, and of what is interpreted without either."""
    kind = kind_of(feature)
    return bool(kind.orientations) or kind.listed


class OrientationModel(QAbstractTableModel):
    """A row for each feature that is interpreted, a column for each of COLUMNS."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._rows: list[Row] = []
        self._places: dict[str, int] = {}

    def clear(self) -> None:
        """No rows."""
        self.beginResetModel()
        self._rows, self._places = [], {}
        self.endResetModel()

    def read(self) -> list[Row]:
        """The rows of all features, which are not shown by this."""
        features = [f for f in self._studio.session.features() if _listed(f)]
        measured = self._studio.measured(feature.id for feature in features)
        return [row_of(self._studio, feature, measured[feature.id]) for feature in features]

    def reset(self, rows: list[Row] | None = None) -> None:
        """Show the rows that have been read; all, read anew, unless they are given."""
        self.beginResetModel()
        self._rows = self.read() if rows is None else rows
        self._places = {row.feature.id: i for i, row in enumerate(self._rows)}
        self.endResetModel()

    def update(self, ids: list[str]) -> None:
        """Features were added, changed or deleted."""
        if len(ids) > _AT_ONCE:
            self.reset()
            return
        self._remove([i for i in ids if self._studio.records.get(i) is None])
        measured = self._studio.measured(ids)
        for id_ in ids:
            feature = get_feature(self._studio.records, id_)
            if feature is None or not _listed(feature):
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

    def _remove(self, ids: list[str]) -> None:
        for id_ in ids:
            place = self._places.get(id_)
            if place is not None:
                self.beginRemoveRows(QModelIndex(), place, place)
                del self._rows[place], self._places[id_]
                after = (row.feature.id for row in self._rows[place:])
                self._places.update(zip(after, count(place), strict=False))
                self.endRemoveRows()

    def row(self, place: int) -> Row:
        """The row at a place, unsorted."""
        return self._rows[place]

    def update_comparisons(self) -> None:
        """Other rows have changed, with which readings are compared."""
        if self._rows and any(self._studio.session.of(record) for record in _READ):
            self.dataChanged.emit(
                self.index(0, _TO_PICK), self.index(len(self._rows) - 1, _TO_PICK)
            )

    def id_at(self, row: int) -> str:
        """Id of the feature at a place, unsorted."""
        return str(self._rows[row].feature.id)

    def place(self, id_: str) -> int | None:
        """Place of a feature, unsorted; None where it is not listed."""
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
                return tr(COLUMNS[section].title)
            if role == Qt.ItemDataRole.ToolTipRole:
                return tr(COLUMNS[section].tip)
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        return self.cell(index.row(), index.column(), role)

    def cell(self, place: int, number: int, role: int) -> Any:
        """What stands in a column of the row at a place, unsorted, for one of Qt's roles."""
        row, column = self._rows[place], COLUMNS[number]
        if column is OVERTURNED:
            if role == Qt.ItemDataRole.CheckStateRole and row.overturned is not None:
                return Qt.CheckState.Checked if row.overturned else Qt.CheckState.Unchecked
            if role == Qt.ItemDataRole.DisplayRole:
                # The box says it.
                return None
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return column.text(row)
        if role == Qt.ItemDataRole.DecorationRole:
            if column is QUALITY:
                return theme.verdict_icon(row.quality)
            if column is TYPE and row.type is not None:
                return theme.type_icon(row.type.color, row.type.symbol)
        if role == Qt.ItemDataRole.TextAlignmentRole and not column.left:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        if role == Qt.ItemDataRole.ToolTipRole:
            if column is QUALITY and (verdict := row.measured.verdict):
                return as_words("\n".join(filter(None, (row.reasons, verdict.limits.description))))
            return as_words(row.reasons or tr(column.tip))
        return None

    def flags(self, index: _Index) -> Qt.ItemFlag:
        return flags_of(index)

    def setData(  # noqa: N802
        self, index: _Index, value: Any, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        field = COLUMNS[index.column()].field
        row = self._rows[index.row()]
        if role == Qt.ItemDataRole.CheckStateRole and row.overturned is not None:
            # Qt hands over a plain number.
            on = Qt.CheckState(value) == Qt.CheckState.Checked
            return self._studio.attempt(edits.set_attributes, [row.feature.id], overturned=on)
        own = [attribute.field for attribute in kind_of(row.feature).attributes]
        if field is None or field not in own or value == getattr(row.feature, field):
            return False
        return self._studio.attempt(
            edits.set_attributes, [row.feature.id], **{field: value.strip()}
        )
