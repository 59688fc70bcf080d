"""Dialog that imports field measurements: columns, notation, north, and a preview of the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPlainTextEdit,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.io.gate.points import ModelFrame
from vomstudio.io.gis.crs import crs_name, degrees_to_grid
from vomstudio.project.edits import suggest_type
from vomstudio.project.imports.field_columns import guess
from vomstudio.project.imports.field_table import FieldTable
from vomstudio.project.imports.readings import (
    FieldReadings,
    make_readings,
    missing_choice,
    read_readings,
)
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.records import FeatureType, Record
from vomstudio.registration.north import North, NorthCorrection, parse_angle, place_of
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, Label, allow, rich_label, rich_lines
from vomstudio.ui.base.help_links import explain

_PREVIEW_ROWS = 200
_FAR_M = 10_000.0
_UNREADABLE = "#d55e00"

_NOTATIONS = (
    (to_translate("Dip direction / dip"), "dipdir/dip"),
    (to_translate("Strike / dip, right-hand rule"), "strike/dip"),
    (to_translate("Strike / dip, left-hand rule"), "strike/dip lhr"),
    (to_translate("Strike / dip and dip quadrant"), "quadrant"),
    (to_translate("Trend / plunge (lines)"), "trend/plunge"),
)
_AZIMUTH = {
    "dipdir/dip": to_translate("Dip direction"),
    "strike/dip": to_translate("Strike (right-hand)"),
    "strike/dip lhr": to_translate("Strike (left-hand)"),
    "quadrant": to_translate("Strike"),
    "trend/plunge": to_translate("Trend"),
}
_ROLES = (
    (to_translate("Not used"), ""),
    (to_translate("Name"), "name"),
    (to_translate("Azimuth"), "azimuth"),
    (to_translate("Dip"), "inclination"),
    (to_translate("Quadrant"), "quadrant"),
    (to_translate("Both angles"), "text"),
    (to_translate("Trend of a line"), "trend"),
    (to_translate("Plunge of a line"), "plunge"),
    (to_translate("Plane or line"), "element"),
    (to_translate("Type"), "type"),
    (to_translate("Set"), "set"),
    (to_translate("Overturned"), "overturned"),
    (to_translate("X (east)"), "x"),
    (to_translate("Y (north)"), "y"),
    (to_translate("Z (height)"), "z"),
    (to_translate("Longitude"), "longitude"),
    (to_translate("Latitude"), "latitude"),
    (to_translate("Notes"), "notes"),
)


@dataclass(frozen=True)
class Place:
    """Where the project is: its CRS, None where unknown, and a World position in it, where
    `has_position`."""

    crs: str | None = None
    x: float = 0.0
    y: float = 0.0
    has_position: bool = False


class ReadingsDialog(QDialog):
    """`readings` and `types` hold what is to be added once it is accepted."""

    def __init__(
        self,
        parent: QWidget | None,
        table: FieldTable,
        records: dict[str, Record],
        place: Place,
        *,
        type_id: str = "bedding",
        declination: str = "",
    ) -> None:
        super().__init__(parent)
        explain(self, "conventions.md#angles")
        self.setWindowTitle(tr("Import field measurements: {path}", path=table.path.name))
        self.resize(820, 680)
        self._table, self._records, self._place = table, records, place
        self._kinds = [r for r in records.values() if isinstance(r, FeatureType)]
        self._to_grid = None if place.crs is None else degrees_to_grid(place.crs)
        self._understood = FieldReadings((), (), ())
        self.readings: list[Reading] = []
        self.types: list[FeatureType] = []
        self._guess = guess(table)
        layout = QVBoxLayout(self)
        layout.addLayout(self._make_angles())
        layout.addWidget(self._make_preview(), 1)
        layout.addLayout(self._make_rest(type_id, declination))
        self._says = rich_label()
        self._says.setWordWrap(True)
        self._says.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        layout.addWidget(self._says)
        self._bad = QPlainTextEdit()
        self._bad.setObjectName("readings_bad")
        self._bad.setReadOnly(True)
        self._bad.setMaximumHeight(110)
        self._bad_title = Label()
        layout.addWidget(self._bad_title)
        layout.addWidget(self._bad)
        self._buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self._buttons.accepted.connect(self.accept)
        self._buttons.rejected.connect(self.reject)
        layout.addWidget(self._buttons)
        self._read()

    # --- parts -------------------------------------------------------------------------------
    def _make_angles(self) -> QHBoxLayout:
        self._notation = ComboBox()
        self._notation.setObjectName("readings_notation")
        self._notation.addItem(tr("Choose…"), None)
        for text, value in _NOTATIONS:
            self._notation.addItem(tr(text), value)
        self._notation.setCurrentIndex(max(0, self._notation.findData(self._guess.notation)))
        self._notation.activated.connect(lambda _: self._read())
        row = QHBoxLayout()
        label = Label(tr("Notation"))
        label.setBuddy(self._notation)
        row.addWidget(label)
        row.addWidget(self._notation)
        row.addStretch()
        row.addWidget(Label(tr_n("{count:,} row", "{count:,} rows", len(self._table.rows))))
        return row

    def _make_preview(self) -> QTableWidget:
        table = self._table
        shown = min(len(table.rows), _PREVIEW_ROWS)
        view = QTableWidget(shown + 1, table.width)
        view.setHorizontalHeaderLabels([table.label(c) for c in range(table.width)])
        view.setVerticalHeaderLabels(["", *(str(n) for n in table.lines[:shown])])
        view.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        view.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        view.setMinimumHeight(170)
        self._column_roles: list[QComboBox] = []
        role_of = {column: role for role, column in self._guess.columns.items()}
        for column in range(table.width):
            combo = ComboBox()
            combo.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
            combo.setAccessibleName(tr("Meaning of column {column}", column=table.label(column)))
            for text, role in _ROLES:
                combo.addItem(tr(text), role)
            combo.setCurrentIndex(max(0, combo.findData(role_of.get(column, ""))))
            combo.activated.connect(lambda _, c=column: self._assigned(c))
            self._column_roles.append(combo)
            view.setCellWidget(0, column, combo)
        for i in range(shown):
            for column in range(table.width):
                view.setItem(i + 1, column, QTableWidgetItem(table.rows[i][column]))
        view.resizeColumnsToContents()
        for column in range(table.width):
            width = max(view.columnWidth(column), self._column_roles[column].sizeHint().width() + 6)
            view.setColumnWidth(column, min(width, 260))
        view.verticalHeader().setDefaultSectionSize(26)
        self._preview = view
        return view

    def _make_rest(self, type_id: str, declination: str) -> QHBoxLayout:
        self._type = ComboBox()
        self._type.setObjectName("readings_type")
        for kind in self._kinds:
            self._type.addItem(theme.swatch(kind.color), kind.name, kind.id)
        self._type.setCurrentIndex(max(0, self._type.findData(type_id)))
        self._type.activated.connect(lambda _: self._say())
        self._set = QLineEdit()
        self._set.setPlaceholderText(tr("none"))
        self._left = QFormLayout()
        self._left.addRow(tr("Type"), self._type)
        self._left.addRow(tr("Set"), self._set)
        self._unknown: dict[str, QComboBox] = {}
        self._north = ComboBox()
        self._north.setObjectName("readings_north")
        for text, value in (
            (tr("Choose…"), None),
            (tr("Magnetic north, as a compass reads"), "magnetic"),
            (tr("True north (declination was set on the compass)"), "true"),
            (tr("Grid north of the project"), "grid"),
        ):
            self._north.addItem(text, value)
        self._north.activated.connect(lambda _: self._say())
        self._declination = QLineEdit(declination)
        self._declination.setObjectName("readings_declination")
        self._declination.setPlaceholderText(tr("Degrees east, such as 2.6; west is negative"))
        self._declination.textChanged.connect(lambda _: self._say())
        self._convergence = Label()
        self._convergence.setWordWrap(True)
        right = QFormLayout()
        right.addRow(tr("Azimuths refer to"), self._north)
        right.addRow(tr("Declination"), self._declination)
        right.addRow(tr("Convergence"), self._convergence)
        row = QHBoxLayout()
        row.addLayout(self._left, 2)
        row.addSpacing(16)
        row.addLayout(right, 3)
        return row

    # --- reading the table -----------------------------------------------------------------------
    def _assigned(self, column: int) -> None:
        """A role belongs to one column: the one that was chosen last."""
        role = self._column_roles[column].currentData()
        for other, combo in enumerate(self._column_roles):
            if role and other != column and combo.currentData() == role:
                combo.setCurrentIndex(0)
        self._read()

    def columns(self) -> dict[str, int]:
        """The column of each role that has been assigned."""
        return {
            str(combo.currentData()): column
            for column, combo in enumerate(self._column_roles)
            if combo.currentData()
        }

    def _read(self) -> None:
        notation = self._notation.currentData()
        for combo in self._column_roles:
            azimuth = tr(_AZIMUTH[notation]) if notation in _AZIMUTH else tr("Azimuth")
            combo.setItemText(combo.findData("azimuth"), azimuth)
            inclination = tr("Plunge") if notation == "trend/plunge" else tr("Dip")
            combo.setItemText(combo.findData("inclination"), inclination)
        self._missing = missing_choice(self.columns(), notation)
        self._understood = (
            FieldReadings((), (), ())
            if self._missing
            else read_readings(
                self._table, self.columns(), notation, self._to_grid, ModelFrame(self._place.crs)
            )
        )
        self._ask_for_types()
        self._show_bad()
        self._show_convergence()
        self._say()

    def _ask_for_types(self) -> None:
        known = {kind.name.casefold() for kind in self._kinds}
        names = [n for n in self._understood.type_names if n.casefold() not in known]
        wanted = list({n.casefold(): n for n in names}.values())
        if [n.casefold() for n in wanted] == list(self._unknown):
            return
        while self._left.rowCount() > 2:
            self._left.removeRow(2)
        self._unknown = {}
        for name in wanted[:8]:
            combo = ComboBox()
            combo.addItem(tr("New feature type"), None)
            for kind in self._kinds:
                combo.addItem(theme.swatch(kind.color), kind.name, kind.id)
            combo.activated.connect(lambda _: self._say())
            self._unknown[name.casefold()] = combo
            self._left.addRow(f"“{name}”", combo)
        if len(wanted) > 8:
            self._left.addRow(
                Label(
                    tr_n(
                        "{count} further name becomes a new feature type.",
                        "{count} further names become new feature types.",
                        len(wanted) - 8,
                    )
                )
            )

    def _show_bad(self) -> None:
        bad = self._understood.bad
        self._bad.setPlainText("\n".join(str(row) for row in bad))
        self._bad.setVisible(bool(bad))
        self._bad_title.setVisible(bool(bad))
        self._bad_title.setText(
            tr_n(
                "{count} row cannot be read and is left out:",
                "{count} rows cannot be read and are left out:",
                len(bad),
            )
        )
        reasons = {row.line: row.reason for row in bad}
        red = QColor(_UNREADABLE)
        plain = self.palette().color(QPalette.ColorRole.Text)
        with QSignalBlocker(self._preview):
            for i in range(1, self._preview.rowCount()):
                reason = str(reasons.get(self._table.lines[i - 1], ""))
                for column in range(self._preview.columnCount()):
                    item = self._preview.item(i, column)
                    if item is not None:
                        item.setForeground(red if reason else plain)
                        item.setToolTip(reason)

    def _show_convergence(self) -> None:
        """At the readings' own place where they have one, else at the project's."""
        place = self._place
        self._known = North(place.crs)
        if place.crs is None:
            self._convergence.setText(tr("Unknown: the project has no CRS."))
            return
        places = [row.position for row in self._understood.rows if row.position is not None]
        if not places and not place.has_position:
            self._convergence.setText(tr("Unknown: neither model nor readings have a position."))
            return
        world = np.asarray([p[:2] for p in places] or [(place.x, place.y)])
        self._known = North(place.crs, place_of(place.crs, world))
        convergence = self._known.convergence_deg()
        if convergence is None:
            self._convergence.setText(
                tr("Unknown: the readings are outside {crs}.", crs=place.crs)
                if places
                else tr("Unknown: the model is outside {crs}.", crs=place.crs)
            )
        else:
            sign = "−" if convergence < 0 else "+"
            angle, crs = f"{sign}{abs(convergence):.2f}°", crs_name(place.crs)
            self._convergence.setText(
                tr("{angle} at the readings ({crs})", angle=angle, crs=crs)
                if places
                else tr("{angle} at the model ({crs})", angle=angle, crs=crs)
            )

    def turn(self) -> NorthCorrection | None:
        """The correction from the chosen north to grid north; None until it is known."""
        north = self._north.currentData()
        if north is None:
            return None
        known = self._known
        if north == "magnetic":
            try:
                angle = parse_angle(self._declination.text())
            except UsageError:
                return None
            known = replace(known, declination_deg=angle)
        return known.correction(north)

    def _say(self) -> None:
        magnetic = self._north.currentData() == "magnetic"
        allow(self._declination, None if magnetic else Finding("action.not-magnetic"))
        turn, n = self.turn(), len(self._understood.rows)
        ok = self._buttons.button(QDialogButtonBox.StandardButton.Ok)
        ok.setText(tr_n("Add {count} reading", "Add {count} readings", n))
        ok.setEnabled(turn is not None and n > 0)
        lines: list[str] = []
        if self._missing:
            lines.append(self._missing.message)
        elif turn is not None:
            lines.append(turn.summary)
        elif self._north.currentData() is None:
            lines.append(Finding("reading.north-missing").message)
        elif not magnetic:
            lines.append(Finding("north.no-convergence").message)
        else:
            lines.append(Finding("reading.declination-missing").message)
        bold = lines[:]
        lines += [
            *map(str, self._guess.findings),
            *map(str, self._understood.findings),
            *map(str, self._far()),
        ]
        self._says.setText(rich_lines(lines, bold))

    def _far(self) -> Sequence[Finding]:
        if not self._place.has_position:
            return ()
        away = [
            ((p[0] - self._place.x) ** 2 + (p[1] - self._place.y) ** 2) ** 0.5
            for row in self._understood.rows
            if (p := row.position) is not None
        ]
        if not away or min(away) < _FAR_M:
            return ()
        return (Finding("reading.far-from-model", distance_m=min(away)),)

    # --- the answer --------------------------------------------------------------------------
    def accept(self) -> None:
        """Make `readings` and `types` of the table."""
        turn = self.turn()
        if turn is None:
            return
        records = dict(self._records)
        ids = {kind.name.casefold(): kind.id for kind in self._kinds}
        self.types = []
        for name in self._understood.type_names:
            low = name.casefold()
            if low in ids:
                continue
            combo = self._unknown.get(low)
            chosen = combo.currentData() if combo is not None else None
            if chosen is None:
                own = [r for r in self._understood.rows if r.type_name.casefold() == low]
                lines = all(r.geometry == "line" for r in own)
                kind = suggest_type(records, name, "line" if lines else "plane")
                self.types.append(kind)
                records[kind.id] = kind
                chosen = kind.id
            ids[low] = str(chosen)
        self.readings = make_readings(
            self._understood.rows,
            type_ids=ids,
            type_id=str(self._type.currentData()),
            set_name=self._set.text().strip(),
            turn_deg=turn.deg,
            source=self._table.path.name,
        )
        super().accept()
