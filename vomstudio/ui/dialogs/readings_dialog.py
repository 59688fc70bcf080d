"""Dialog that imports field measurements: columns, notation, north and a preview."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QPalette
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
from vomstudio.project.imports.field_columns import geometry_of_type, guess
from vomstudio.project.imports.field_table import FieldTable
from vomstudio.project.imports.readings import (
    FieldReadings,
    make_readings,
    missing_choice,
    read_readings,
)
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.records import FeatureType, Record
from vomstudio.registration.north import (
    NorthCorrection,
    NorthInputs,
    centre_longitude_latitude,
    parse_angle,
)
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, Label, rich_label, rich_lines, set_enabled
from vomstudio.ui.base.help_links import set_help_topic

_PREVIEW_ROWS = 200
_MAX_DISTANCE_M = 10_000.0

NEW_PLANE, NEW_LINE = "new plane type", "new line type"
"""Choices for an unknown type name, in addition to the types of the project."""
_MAX_TYPE_BOXES = 8

_NOTATIONS = (
    (to_translate("Dip direction / dip"), "dipdir/dip"),
    (to_translate("Strike / dip, right-hand rule"), "strike/dip"),
    (to_translate("Strike / dip, left-hand rule"), "strike/dip lhr"),
    (to_translate("Strike / dip and dip quadrant"), "quadrant"),
    (to_translate("Trend / plunge (lines)"), "trend/plunge"),
)
_AZIMUTH_LABELS = {
    "dipdir/dip": to_translate("Dip direction"),
    "strike/dip": to_translate("Strike (right-hand)"),
    "strike/dip lhr": to_translate("Strike (left-hand)"),
    "quadrant": to_translate("Strike"),
    "trend/plunge": to_translate("Trend"),
}
_ROLES = (
    (to_translate("Not used"), ""),
    (to_translate("Name"), "name"),
    (to_translate("Station"), "station"),
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
class ProjectLocation:
    """Location of the project: its CRS if known, and (x, y) if `has_position` is True."""

    crs: str | None = None
    x: float = 0.0
    y: float = 0.0
    has_position: bool = False


class ReadingsDialog(QDialog):
    """Dialog that imports readings. `readings` and `types` are the records to add."""

    def __init__(
        self,
        parent: QWidget | None,
        table: FieldTable,
        records: dict[str, Record],
        location: ProjectLocation,
        *,
        type_id: str = "bedding",
        declination: str = "",
    ) -> None:
        super().__init__(parent)
        set_help_topic(self, "conventions.md#angles")
        self.setWindowTitle(tr("Import field measurements: {path}", path=table.path.name))
        self.resize(820, 680)
        self._table, self._records, self._location = table, records, location
        self._types = [r for r in records.values() if isinstance(r, FeatureType)]
        self._convert_to_grid = None if location.crs is None else degrees_to_grid(location.crs)
        self._field_readings = FieldReadings((), (), ())
        self.readings: list[Reading] = []
        self.types: list[FeatureType] = []
        self._proposed_roles = guess(table)
        layout = QVBoxLayout(self)
        layout.addLayout(self._make_notation_row())
        layout.addWidget(self._create_preview(), 1)
        layout.addLayout(self._make_settings(type_id, declination))
        self._summary = rich_label()
        self._summary.setWordWrap(True)
        self._summary.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        layout.addWidget(self._summary)
        self._unreadable_list = QPlainTextEdit()
        self._unreadable_list.setObjectName("readings_bad")
        self._unreadable_list.setReadOnly(True)
        self._unreadable_list.setMaximumHeight(110)
        self._unreadable_title = Label()
        layout.addWidget(self._unreadable_title)
        layout.addWidget(self._unreadable_list)
        self._buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self._buttons.accepted.connect(self.accept)
        self._buttons.rejected.connect(self.reject)
        layout.addWidget(self._buttons)
        self._update_readings()

    # --- widgets -----------------------------------------------------------------------------
    def _make_notation_row(self) -> QHBoxLayout:
        self._notation = ComboBox()
        self._notation.setObjectName("readings_notation")
        self._notation.addItem(tr("Choose…"), None)
        for text, value in _NOTATIONS:
            self._notation.addItem(tr(text), value)
        self._notation.setCurrentIndex(
            max(0, self._notation.findData(self._proposed_roles.notation))
        )
        self._notation.activated.connect(lambda _: self._update_readings())
        row = QHBoxLayout()
        label = Label(tr("Notation"))
        label.setBuddy(self._notation)
        row.addWidget(label)
        row.addWidget(self._notation)
        row.addStretch()
        row.addWidget(Label(tr_n("{count:,} row", "{count:,} rows", len(self._table.rows))))
        return row

    def _create_preview(self) -> QTableWidget:
        table = self._table
        row_count = min(len(table.rows), _PREVIEW_ROWS)
        view = QTableWidget(row_count + 1, table.width)
        view.setHorizontalHeaderLabels([table.label(c) for c in range(table.width)])
        view.setVerticalHeaderLabels(["", *(str(n) for n in table.lines[:row_count])])
        view.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        view.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        view.setMinimumHeight(170)
        self._role_boxes: list[QComboBox] = []
        roles_by_column = {column: role for role, column in self._proposed_roles.columns.items()}
        for column in range(table.width):
            combo = ComboBox()
            combo.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
            combo.setAccessibleName(tr("Meaning of column {column}", column=table.label(column)))
            for text, role in _ROLES:
                combo.addItem(tr(text), role)
            combo.setCurrentIndex(max(0, combo.findData(roles_by_column.get(column, ""))))
            combo.activated.connect(lambda _, c=column: self._assign_role(c))
            self._role_boxes.append(combo)
            view.setCellWidget(0, column, combo)
        for i in range(row_count):
            for column in range(table.width):
                view.setItem(i + 1, column, QTableWidgetItem(table.rows[i][column]))
        view.resizeColumnsToContents()
        for column in range(table.width):
            width = max(view.columnWidth(column), self._role_boxes[column].sizeHint().width() + 6)
            view.setColumnWidth(column, min(width, 260))
        view.verticalHeader().setDefaultSectionSize(26)
        self._preview = view
        return view

    def _make_settings(self, type_id: str, declination: str) -> QHBoxLayout:
        self._type_box = ComboBox()
        self._type_box.setObjectName("readings_type")
        for feature_type in self._types:
            self._type_box.addItem(
                theme.swatch(feature_type.color), feature_type.name, feature_type.id
            )
        self._type_box.setCurrentIndex(max(0, self._type_box.findData(type_id)))
        self._type_box.activated.connect(lambda _: self._refresh_summary())
        self._set_box = QLineEdit()
        self._set_box.setPlaceholderText(tr("none"))
        self._left_form = QFormLayout()
        self._left_form.addRow(tr("Type"), self._type_box)
        self._left_form.addRow(tr("Set"), self._set_box)
        self._new_type_boxes: dict[str, QComboBox] = {}
        self._north = ComboBox()
        self._north.setObjectName("readings_north")
        for text, value in (
            (tr("Choose…"), None),
            (tr("Magnetic north (compass)"), "magnetic"),
            (tr("True north (declination set on compass)"), "true"),
            (tr("Grid north of the project"), "grid"),
        ):
            self._north.addItem(text, value)
        self._north.activated.connect(lambda _: self._refresh_summary())
        self._declination = QLineEdit(declination)
        self._declination.setObjectName("readings_declination")
        self._declination.setPlaceholderText(tr("Degrees east, such as 2.6; west is negative"))
        self._declination.textChanged.connect(lambda _: self._refresh_summary())
        self._convergence = Label()
        self._convergence.setWordWrap(True)
        right_form = QFormLayout()
        right_form.addRow(tr("Azimuths refer to"), self._north)
        right_form.addRow(tr("Declination"), self._declination)
        right_form.addRow(tr("Convergence"), self._convergence)
        row = QHBoxLayout()
        row.addLayout(self._left_form, 2)
        row.addSpacing(16)
        row.addLayout(right_form, 3)
        return row

    # --- table -----------------------------------------------------------------------------------
    def _assign_role(self, column: int) -> None:
        """Assign the role that was selected for a column, and remove it from all other columns."""
        role = self._role_boxes[column].currentData()
        for other_column, combo in enumerate(self._role_boxes):
            if role and other_column != column and combo.currentData() == role:
                combo.setCurrentIndex(0)
        self._update_readings()

    def columns(self) -> dict[str, int]:
        """Return the column number of each assigned role."""
        return {
            str(combo.currentData()): column
            for column, combo in enumerate(self._role_boxes)
            if combo.currentData()
        }

    def _update_readings(self) -> None:
        notation = self._notation.currentData()
        for combo in self._role_boxes:
            azimuth = (
                tr(_AZIMUTH_LABELS[notation]) if notation in _AZIMUTH_LABELS else tr("Azimuth")
            )
            combo.setItemText(combo.findData("azimuth"), azimuth)
            inclination = tr("Plunge") if notation == "trend/plunge" else tr("Dip")
            combo.setItemText(combo.findData("inclination"), inclination)
        self._missing_choice = missing_choice(self.columns(), notation)
        self._show_new_types()
        self._field_readings = (
            FieldReadings((), (), ())
            if self._missing_choice
            else read_readings(
                self._table,
                self.columns(),
                notation,
                self._convert_to_grid,
                ModelFrame(self._location.crs),
                self._line_types(),
            )
        )
        self._show_unreadable()
        self._show_convergence()
        self._refresh_summary()

    def _type_names(self) -> list[str]:
        """Return the distinct names in the type column."""
        column = self.columns().get("type")
        if column is None:
            return []
        table = self._table
        names = [
            row[column] for i, row in enumerate(table.rows) if i not in table.ragged_row_findings
        ]
        return list({name.casefold(): name for name in names if name}.values())

    def _show_new_types(self) -> None:
        known_names = {feature_type.name.casefold() for feature_type in self._types}
        new_names = [n for n in self._type_names() if n.casefold() not in known_names]
        # Names that need a choice come first.
        new_names.sort(key=lambda name: geometry_of_type(name) is not None)
        if [n.casefold() for n in new_names[:_MAX_TYPE_BOXES]] == list(self._new_type_boxes):
            return
        while self._left_form.rowCount() > 2:
            self._left_form.removeRow(2)
        self._new_type_boxes = {}
        for name in new_names[:_MAX_TYPE_BOXES]:
            self._new_type_boxes[name.casefold()] = combo = self._create_type_box(name)
            self._left_form.addRow(f"“{name}”", combo)
        if len(new_names) > _MAX_TYPE_BOXES:
            self._left_form.addRow(
                Label(
                    tr_n(
                        "{count} further name becomes a new feature type.",
                        "{count} further names become new feature types.",
                        len(new_names) - _MAX_TYPE_BOXES,
                    )
                )
            )

    def _create_type_box(self, name: str) -> QComboBox:
        """Create the choice for an unknown type name; the user must resolve ambiguous names."""
        combo = ComboBox()
        geometry = geometry_of_type(name)
        if geometry is None:
            combo.addItem(tr("Choose…"), None)
        combo.addItem(tr("New plane type"), NEW_PLANE)
        combo.addItem(tr("New line type"), NEW_LINE)
        for feature_type in self._types:
            combo.addItem(theme.swatch(feature_type.color), feature_type.name, feature_type.id)
        if geometry is not None:
            is_line = geometry == "line" or self._has_only_lines(name)
            combo.setCurrentIndex(combo.findData(NEW_LINE if is_line else NEW_PLANE))
        combo.activated.connect(lambda _: self._update_readings())
        return combo

    def _has_only_lines(self, type_name: str) -> bool:
        """Return whether the notation or other columns state that all rows of a type are lines."""
        if self._notation.currentData() == "trend/plunge":
            return True
        columns, rows = self.columns(), self._table.rows
        type_column = columns["type"]

        def is_stated_line(row: list[str]) -> bool:
            cell = {role: row[column] for role, column in columns.items()}
            return cell.get("element", "").casefold().startswith("line") or (
                bool(cell.get("plunge")) and not cell.get("inclination") and not cell.get("text")
            )

        key = type_name.casefold()
        return all(is_stated_line(row) for row in rows if row[type_column].casefold() == key)

    def _type_geometry(self, key: str) -> str | None:
        """Return "plane" or "line" for a type name, or None if the user has to choose."""
        combo = self._new_type_boxes.get(key)
        choice = combo.currentData() if combo is not None else None
        if choice in (NEW_PLANE, NEW_LINE):
            return "line" if choice == NEW_LINE else "plane"
        for feature_type in self._types:
            if feature_type.id == choice or (combo is None and feature_type.name.casefold() == key):
                return feature_type.geometry
        return geometry_of_type(key) if combo is None else None

    def _line_types(self) -> set[str]:
        keys = (name.casefold() for name in self._type_names())
        return {key for key in keys if self._type_geometry(key) == "line"}

    def _type_findings(self) -> list[Finding]:
        """Return findings about rows that are lines, or may be lines, by their type."""
        notation, rows = self._notation.currentData(), self._field_readings.rows
        unclear_names = [n for n in self._type_names() if self._type_geometry(n.casefold()) is None]
        findings = [Finding("reading.type-unclear", types=unclear_names)] if unclear_names else []
        line_types = self._line_types()
        lines = [r for r in rows if r.type_name.casefold() in line_types and r.geometry == "line"]
        if lines and notation != "trend/plunge":
            names = list(dict.fromkeys(row.type_name for row in lines))
            findings.append(Finding("reading.lines-by-type", count=len(lines), types=names))
        return findings

    def _show_unreadable(self) -> None:
        rows = self._field_readings.bad_rows
        self._unreadable_list.setPlainText("\n".join(str(row) for row in rows))
        self._unreadable_list.setVisible(bool(rows))
        self._unreadable_title.setVisible(bool(rows))
        self._unreadable_title.setText(
            tr_n(
                "{count} row cannot be read and is left out:",
                "{count} rows cannot be read and are left out:",
                len(rows),
            )
        )
        reasons = {row.line: row.reason for row in rows}
        error_color = theme.error_color()
        text_color = self.palette().color(QPalette.ColorRole.Text)
        with QSignalBlocker(self._preview):
            for i in range(1, self._preview.rowCount()):
                reason = str(reasons.get(self._table.lines[i - 1], ""))
                for column in range(self._preview.columnCount()):
                    item = self._preview.item(i, column)
                    if item is not None:
                        item.setForeground(error_color if reason else text_color)
                        item.setToolTip(reason)

    def _show_convergence(self) -> None:
        """Show the convergence at the readings, or at the project if they have no positions."""
        location = self._location
        self._north_data = NorthInputs(location.crs)
        if location.crs is None:
            self._convergence.setText(tr("Unknown: the project has no CRS."))
            return
        positions = [row.position for row in self._field_readings.rows if row.position is not None]
        if not positions and not location.has_position:
            self._convergence.setText(tr("Unknown: neither model nor readings have a position."))
            return
        world = np.asarray([p[:2] for p in positions] or [(location.x, location.y)])
        self._north_data = NorthInputs(location.crs, centre_longitude_latitude(location.crs, world))
        convergence = self._north_data.convergence_deg()
        if convergence is None:
            self._convergence.setText(
                tr("Unknown: the readings are outside {crs}.", crs=location.crs)
                if positions
                else tr("Unknown: the model is outside {crs}.", crs=location.crs)
            )
        else:
            sign = "−" if convergence < 0 else "+"
            angle, crs = f"{sign}{abs(convergence):.2f}°", crs_name(location.crs)
            self._convergence.setText(
                tr("{angle} at the readings ({crs})", angle=angle, crs=crs)
                if positions
                else tr("{angle} at the model ({crs})", angle=angle, crs=crs)
            )

    def north_correction(self) -> NorthCorrection | None:
        """Return the correction to grid north, or None while it is unknown."""
        north = self._north.currentData()
        if north is None:
            return None
        north_data = self._north_data
        if north == "magnetic":
            try:
                angle = parse_angle(self._declination.text())
            except UsageError:
                return None
            north_data = replace(north_data, declination_deg=angle)
        return north_data.correction(north)

    def _refresh_summary(self) -> None:
        is_magnetic = self._north.currentData() == "magnetic"
        set_enabled(self._declination, None if is_magnetic else Finding("action.not-magnetic"))
        correction, count = self.north_correction(), len(self._field_readings.rows)
        ok_button = self._buttons.button(QDialogButtonBox.StandardButton.Ok)
        ok_button.setText(tr_n("Add {count} reading", "Add {count} readings", count))
        type_findings = self._type_findings()
        has_type_error = any(finding.severity == "error" for finding in type_findings)
        ok_button.setEnabled(correction is not None and count > 0 and not has_type_error)
        lines: list[str] = []
        if self._missing_choice:
            lines.append(self._missing_choice.message)
        elif correction is not None:
            lines.append(correction.summary)
        elif self._north.currentData() is None:
            lines.append(Finding("reading.north-missing").message)
        elif not is_magnetic:
            lines.append(Finding("north.no-convergence").message)
        else:
            lines.append(Finding("reading.declination-missing").message)
        bold_lines = lines[:]
        lines += [
            *map(str, type_findings),
            *map(str, self._proposed_roles.findings),
            *map(str, self._field_readings.findings),
            *map(str, self._distance_findings()),
        ]
        self._summary.setText(rich_lines(lines, bold_lines))

    def _distance_findings(self) -> Sequence[Finding]:
        if not self._location.has_position:
            return ()
        distances_m = [
            ((p[0] - self._location.x) ** 2 + (p[1] - self._location.y) ** 2) ** 0.5
            for row in self._field_readings.rows
            if (p := row.position) is not None
        ]
        if not distances_m or min(distances_m) < _MAX_DISTANCE_M:
            return ()
        return (Finding("reading.far-from-model", distance_m=min(distances_m)),)

    # --- result ------------------------------------------------------------------------------
    def accept(self) -> None:
        """Create `readings` and `types` from the table, and close."""
        correction = self.north_correction()
        if correction is None:
            return
        records = dict(self._records)
        ids = {feature_type.name.casefold(): feature_type.id for feature_type in self._types}
        self.types = []
        for name in self._field_readings.type_names:
            key = name.casefold()
            if key in ids:
                continue
            combo = self._new_type_boxes.get(key)
            selected_id = combo.currentData() if combo is not None else None
            if selected_id in (None, NEW_PLANE, NEW_LINE):
                rows = [r for r in self._field_readings.rows if r.type_name.casefold() == key]
                are_lines = all(r.geometry == "line" for r in rows)
                feature_type = suggest_type(records, name, "line" if are_lines else "plane")
                self.types.append(feature_type)
                records[feature_type.id] = feature_type
                selected_id = feature_type.id
            ids[key] = str(selected_id)
        self.readings = make_readings(
            self._field_readings.rows,
            type_ids=ids,
            type_id=str(self._type_box.currentData()),
            set_name=self._set_box.text().strip(),
            turn_deg=correction.deg,
            source=self._table.path.name,
        )
        super().accept()
