"""Panel for the three-point problem: the plane through picked, typed or imported points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFileDialog,
    QHBoxLayout,
    QHeaderView,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, VomError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.options import option_words
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.faults.displacement_options import ThreePointOptions
from vomstudio.geology.notation import format_attitude
from vomstudio.geometry.units import Axes
from vomstudio.io.gate.stated_crs import WORLD_COMMENT
from vomstudio.io.text.log_reading import Boundaries
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import pick_scatter_m
from vomstudio.project.records import Feature, PickedFeature, get, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import current_line, missing_model_finding, start_folder
from vomstudio.ui.base.controls import CompactTable, narrow_form, set_enabled
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.tools.common import narrow_column
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import CopyCommandButton, copy_with_file, format_numbers
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.type_box import TypeBox

if TYPE_CHECKING:
    from vomstudio.geology.faults.three_points import ThreePoints


_MIN_POINTS = 3
_MIN_TABLE_HEIGHT_PX, _MIN_WIDTH_PX = 110, 32
_ROW_HEIGHT_PX = 24


@dataclass(frozen=True, eq=False)
class ThreePointsResult:
    """Points (n, 3) in the World frame, their options, and the plane through them."""

    points: FloatArray
    options: ThreePointOptions
    plane: ThreePoints


class ThreePointsPanel(AnalysisPanel[tuple[FloatArray, ThreePointOptions], ThreePointsResult]):
    """Panel for the three-point problem.

    Attributes
    ----------
    trace_id : str
        Id of the trace that supplied the points, or an empty string if they were typed or imported.
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__(
            studio, "three_points", "window.md#three-points", tr("Computing the plane…")
        )
        self.trace_id = ""
        self._is_picking = False
        self.pick = QPushButton(theme.icon("vector-polyline"), tr("Pick…"))
        self.pick.setToolTip(tr("Click three or more points on the outcrop, then press Enter."))
        self.take = QPushButton(tr("Use selected"))
        self.take.setToolTip(tr("Use the points of the selected trace or line."))
        self.read = QPushButton(tr("Read…"))
        self.read.setToolTip(tr("Read a table with x, y, z, such as well markers."))
        self.add_row = QPushButton(theme.icon("plus"), tr("Add row"))
        self.remove_row = QPushButton(theme.icon("minus"), tr("Remove"))
        self.table = _table()
        self.options = OptionFields(ThreePointOptions, "three_points")
        self.options.changed.connect(self._schedule_refresh)
        follow_axes(self, studio, self._show_axes)
        self.type = TypeBox(studio, geometry="plane")
        self.type.setObjectName("three_points_type")
        self.type.keep_narrow()
        self.add = QPushButton(theme.icon("check"), tr("Add to project"))
        self.add.setToolTip(tr("Add the plane, with its error in the notes."))
        self.copy = CopyCommandButton(
            self.copy_command, tr("save the points as a table and copy the command")
        )
        self._arrange_widgets()
        self._connect_signals()
        self._fill([])

    def _arrange_widgets(self) -> None:
        sources, rows, result = QHBoxLayout(), QHBoxLayout(), QHBoxLayout()
        for row, parts in (
            (sources, (self.pick, self.take, self.read)),
            (rows, (self.add_row, self.remove_row)),
            (result, (self.add, self.type, self.copy)),
        ):
            row.setSpacing(3)
            for part in parts:
                # Otherwise the dock would widen at the expense of the outcrop.
                part.setMinimumWidth(_MIN_WIDTH_PX)
                row.addWidget(part)
            row.addStretch()
        form = narrow_form()
        self.options.add_rows(form)
        column = narrow_column(self)
        column.addLayout(sources)
        column.addWidget(self.table, 1)
        column.addLayout(rows)
        column.addLayout(form)
        column.addWidget(self.message)
        column.addLayout(result)

    def _connect_signals(self) -> None:
        studio = self._studio
        self.pick.clicked.connect(lambda _=False: self._pick_points())
        self.take.clicked.connect(
            lambda _=False: self._take_feature(current_line(studio, PickedFeature, _MIN_POINTS))
        )
        self.read.clicked.connect(lambda _=False: self._open_table_file())
        self.add_row.clicked.connect(lambda _=False: self._add_row())
        self.remove_row.clicked.connect(lambda _=False: self._remove_row())
        self.add.clicked.connect(lambda _=False: self._add())
        self.table.itemChanged.connect(self._follow_typing)
        self.table.itemSelectionChanged.connect(self._refresh)
        studio.edited.connect(self._follow_edit)
        studio.settings_changed.connect(self._schedule_refresh)
        studio.selection_changed.connect(self._refresh)

    def _show_axes(self, axes: Axes) -> None:
        self.options.show_unit(length_unit(axes))
        tips = (tr("East."), tr("North."), tr("Height, positive upward."))
        for column, (title, tooltip) in enumerate(zip(axes.titles, tips, strict=True)):
            header_item = self.table.horizontalHeaderItem(column)
            assert header_item is not None
            header_item.setText(title)
            header_item.setToolTip(tooltip if axes.north else "")

    # --- points ------------------------------------------------------------------------------
    def _pick_points(self) -> None:
        """Pick the points with the trace tool, which stores them as a trace."""
        self._studio.activate("trace")
        self._is_picking = True
        self.message.setText(tr("Click three or more points on one surface, then press Enter."))

    def _follow_edit(self, edit: Edit) -> None:
        if self._is_picking:
            new_traces = [get(edit.after, i, Trace) for i in edit.after if edit.before[i] is None]
            picked_traces = [trace for trace in new_traces if trace is not None]
            if picked_traces:
                self._is_picking = False
                self._take_feature(picked_traces[-1])
                self._studio.page_requested.emit("three_points")
        if self.trace_id and self.trace_id in edit.after:
            self._take_feature(get_feature(self._studio.records, self.trace_id))
        super()._follow_edit(edit)

    def _take_feature(self, feature: Feature | None) -> None:
        """Copy the points of a feature and their estimated error; None clears the trace id."""
        if feature is None:
            self.trace_id = ""
            self._schedule_refresh()
            return
        measurements = self._studio.measured([feature.id])[feature.id]
        self._fill([[f"{value:.4f}" for value in point] for point in measurements.points.tolist()])
        self.trace_id = feature.id
        scatter, misfit = pick_scatter_m([measurements]), measurements.fit and measurements.fit.rms
        if len(measurements.points) > _MIN_POINTS and misfit and misfit >= scatter:
            # The misfit of a few points is uncertain, so it is not entered as a known sigma.
            scatter = 0.0
        self.options.show_value("sigma_m", scatter)
        self._schedule_refresh()

    def _open_table_file(self) -> None:
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Points of one surface"),
            str(start_folder(self._studio)),
            tr("Tables of x, y, z (*.csv *.txt *.tsv *.xyz);;All files (*)"),
        )
        if name:
            self._background.run(
                partial(_read_boundaries, Path(name)), self._show_table, self._studio.fail
            )

    def _show_table(self, table: Boundaries) -> None:
        self._fill([[repr(value) for value in row] for row in table.points.tolist()])
        for warning in table.warnings:
            self._studio.warn(warning)

    def _fill(self, rows: list[list[str]]) -> None:
        """Fill the table, adding empty rows up to the minimum number of points."""
        self.trace_id = ""
        rows = rows + [["", "", ""]] * (_MIN_POINTS - len(rows))
        was_blocked = self.table.blockSignals(True)
        self.table.setRowCount(len(rows))
        for i, row in enumerate(rows):
            for j, text in enumerate(row):
                self.table.setItem(i, j, _create_item(text))
        self.table.blockSignals(was_blocked)
        self._schedule_refresh()

    def _follow_typing(self, _: QTableWidgetItem) -> None:
        """Clear the trace id, because edited points no longer belong to the trace."""
        self.trace_id = ""
        self._schedule_refresh()

    def _add_row(self) -> None:
        self.trace_id = ""
        row = self.table.rowCount()
        self.table.setRowCount(row + 1)
        for column in range(3):
            self.table.setItem(row, column, _create_item(""))
        self.table.setCurrentCell(row, 0)
        self._schedule_refresh()

    def _remove_row(self) -> None:
        self.trace_id = ""
        self.table.removeRow(self.table.currentRow())
        self._schedule_refresh()

    # --- plane -------------------------------------------------------------------------------
    def _create_request(self) -> tuple[FloatArray, ThreePointOptions]:
        return self._numbers(), self.options.options()

    def _compute_result(self, request: tuple[FloatArray, ThreePointOptions]) -> ThreePointsResult:
        from vomstudio.geology.faults.three_points import plane_of_three_points

        points, options = request
        return ThreePointsResult(points, options, plane_of_three_points(points, options.sigma_m))

    def _result_text(self, result: ThreePointsResult) -> str:
        return self._plane_text(result.plane)

    def _show_error(self, error: VomError) -> None:
        # The location names the row.
        self._set_result(None, str(error))

    def _numbers(self) -> FloatArray:
        """Return the points (n, 3) of the rows in the World frame, skipping empty rows.

        Raises InputError if a number is invalid or there are fewer than three points.
        """
        rows = []
        for i in range(self.table.rowCount()):
            cells = [self.table.item(i, j) for j in range(3)]
            texts = ["" if cell is None else cell.text().strip() for cell in cells]
            if not any(texts):
                continue
            values = [parse_number(text) for text in texts]
            if any(value is None for value in values):
                invalid = next(t for t, v in zip(texts, values, strict=True) if v is None)
                position = tr("Row {row}", row=i + 1)
                raise InputError(Finding("number.invalid", text=invalid), field=position)
            rows.append([value or 0.0 for value in values])
        if len(rows) < _MIN_POINTS:
            raise InputError(Finding("three-points.too-few"))
        return np.array(rows)

    def _plane_text(self, result: ThreePoints) -> str:
        notation = self._studio.settings.notation
        plane = format_attitude(result.plane, result.max_confidence95_deg, notation)
        count_text = tr_n("{count} point", "{count} points", result.n)
        if result.max_confidence95_deg is None:
            text = tr("{plane} through {points}.", plane=plane, points=count_text)
            no_error_finding = Finding("three-points.no-error")
            return f"{text} {no_error_finding}{_warnings_text(result)}"
        direction_error_deg = result.dip_direction_error_deg
        text = tr(
            "{plane} (95 %, joint): dip ± {dip:.1f}°, dip direction {turn} (95 % each), "
            "through {points}.",
            plane=plane,
            dip=result.dip_error_deg,
            turn=tr("unknown") if direction_error_deg is None else f"± {direction_error_deg:.1f}°",
            points=count_text,
        )
        if result.rms_m is not None:
            text += " " + tr("The RMS residual is {rms:.3g} m.", rms=result.rms_m)
        return text + _warnings_text(result)

    def _refresh(self) -> None:
        studio = self._studio
        is_line_selected = current_line(studio, PickedFeature, _MIN_POINTS) is not None
        reason = Finding("action.line-too-short", minimum=_MIN_POINTS)
        set_enabled(self.take, None if is_line_selected else reason)
        set_enabled(self.pick, missing_model_finding(studio))
        set_enabled(
            self.remove_row, None if self.table.currentRow() >= 0 else Finding("action.no-row")
        )
        problem = None if self.result is not None else Finding("action.no-result")
        self.copy.set_enabled(problem)
        if problem is None and self.trace_id:
            problem = Finding("action.points-of-trace")
        set_enabled(self.add, problem)

    # --- export ------------------------------------------------------------------------------
    def _add(self) -> None:
        """Add the plane as a reading at the centroid of the points, with its error in the notes."""
        result = self.result
        if result is None:
            return
        x, y, z = result.points.mean(axis=0).tolist()
        reading = Reading(
            new_id("reading"),
            "",
            str(self.type.currentData()),
            "plane",
            result.plane.dip_direction_deg,
            result.plane.dip_deg,
            position=(x, y, z),
            source=tr("three-point problem"),
            notes=self._result_text(result),
        )
        if self._studio.attempt(edits.add_readings, [reading]):
            self._studio.selection.set((reading.id,))

    def copy_command(self) -> None:
        """Write the point table to a file selected by the user, and copy the command."""
        result = self.result
        if result is None:
            return

        def write(path: Path) -> None:
            rows = [
                WORLD_COMMENT.strip(),
                "x,y,z",
                *(format_numbers(point) for point in result.points.tolist()),
            ]
            write_bytes(path, ("\n".join(rows) + "\n").encode(), force=True)

        arguments = option_words(result.options)
        copy_with_file(
            self, self._studio, "points.csv", write, lambda path: ["threepoint", path, *arguments]
        )


def _warnings_text(result: ThreePoints) -> str:
    """Return the warnings as one text, each preceded by a space."""
    return "".join(f" {warning}" for warning in result.warnings)


def _read_boundaries(path: Path) -> Boundaries:
    from vomstudio.io.gate.point_tables import read_boundaries

    return read_boundaries(path)


def _create_item(text: str) -> QTableWidgetItem:
    item = QTableWidgetItem(text)
    item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return item


def _table() -> QTableWidget:
    table = CompactTable(0, 3)
    table.setObjectName("three_points_table")
    table.setAccessibleName(tr("Points on the surface"))
    for column in range(3):
        table.setHorizontalHeaderItem(column, QTableWidgetItem())
    table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
    table.verticalHeader().setDefaultSectionSize(_ROW_HEIGHT_PX)
    table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
    table.setTabKeyNavigation(False)
    table.setMinimumHeight(_MIN_TABLE_HEIGHT_PX)
    table.setMinimumWidth(2 * _MIN_WIDTH_PX)
    return table
