"""Panel that computes fault displacement from cut-off traces on both sides of a fault."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError, VomError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import escape_formula
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.geology.faults.displacement_options import DisplacementOptions
from vomstudio.geology.notation import format_attitude, format_exact_line, format_exact_plane
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.units import Axes
from vomstudio.io.gate.stated_crs import WORLD_COMMENT
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import has_plane
from vomstudio.project.measurement import Measurement, common_error_deg, pick_scatter_m
from vomstudio.project.records import PickedFeature, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import (
    CompactTable,
    button_row,
    limit_width,
    narrow_form,
    set_enabled,
)
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.tools.common import narrow_column
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit, project_axes
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    CopyCommandButton,
    copy_with_file,
    format_numbers,
)
from vomstudio.ui.widgets.line_field import LineField
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.plane_choice import PlaneChoice

if TYPE_CHECKING:
    from vomstudio.geology.faults.cutoffs import Cutoffs
    from vomstudio.geology.faults.displacement import Displacement
    from vomstudio.geology.faults.displacement_pairs import Displacements, Pair
    from vomstudio.geology.measured_value import MeasuredValue

_COLUMNS = ("net_m", "throw_m", "heave_m", "strike_slip_m")
_MIN_TABLE_HEIGHT_PX = 96


@dataclass(frozen=True, eq=False)
class DisplacementResult:
    """Input and result of the analysis; `names` and `cuts` have one item per trace pair."""

    names: tuple[str, ...]
    cuts: tuple[Cutoffs, ...]
    fault: Plane
    bed: Plane
    rake_deg: float | None
    options: DisplacementOptions
    displacements: Displacements


@dataclass(frozen=True, eq=False)
class DisplacementRequest:
    """Input of the analysis; `names` and `traces` have one item per trace pair."""

    names: tuple[str, ...]
    traces: tuple[tuple[Measurement, Measurement], ...]
    fault: Plane
    fault_point: FloatArray
    bed: Plane
    rake_deg: float | None
    options: DisplacementOptions


class DisplacementPanel(AnalysisPanel[DisplacementRequest, DisplacementResult]):
    """Panel that computes the displacement along a fault.

    Attributes
    ----------
    pairs : list of (str, str)
        Ids of two traces of the same bed, one on each side of the fault.
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__(
            studio,
            "displacement",
            "window.md#fault-displacement",
            tr("Computing the displacement…"),
        )
        self.pairs: list[tuple[str, str]] = []
        self.fault = PlaneChoice(studio, "displacement_fault", tr("select and use it"))
        self.bed = PlaneChoice(studio, "displacement_bed", tr("fitted to the cut-offs"))
        self.slip = LineField(studio, "displacement_slip", tr("unknown (separations only)"))
        self.slip.line.setToolTip(tr("Trend/plunge of the slip lineation, or its rake (0 to 180)."))
        defaults = DisplacementOptions(fault="000/90")
        self.options = OptionFields(DisplacementOptions, "displacement", defaults)
        self.add = QPushButton(theme.icon("plus"), tr("Add selected traces"))
        self.add.setToolTip(tr("Add the two selected cut-offs of one bed."))
        self.remove = QPushButton(theme.icon("minus"), tr("Remove"))
        self.table = _create_table()
        follow_axes(self, studio, self._show_axes)
        self.copy = CopyCommandButton(
            self.copy_command, tr("save the points as a table and copy the command")
        )
        self._arrange_widgets()
        self.options.changed.connect(self._schedule_refresh)
        self.slip.changed.connect(self._schedule_refresh)
        self.slip.take_button.clicked.connect(lambda _=False: self._copy_slip_error())
        for field in (self.fault, self.bed):
            field.changed.connect(self._schedule_refresh)
        self.add.clicked.connect(lambda _=False: self.add_pair())
        self.remove.clicked.connect(lambda _=False: self._remove())
        self.table.itemSelectionChanged.connect(self._refresh)
        studio.edited.connect(self._follow_edit)
        studio.settings_changed.connect(self._schedule_refresh)
        studio.selection_changed.connect(self._refresh)
        # There is nothing to copy before the first result.
        self._refresh()

    def _arrange_widgets(self) -> None:
        form = narrow_form()
        form.addRow(tr("Fault"), self.fault)
        form.addRow(tr("Bed"), self.bed)
        form.addRow(tr("Slip"), self.slip)
        self.options.add_rows(form)
        buttons = button_row(self.add, self.remove, self.copy)
        column = narrow_column(self)
        column.addLayout(limit_width(form))
        column.addLayout(buttons)
        column.addWidget(self.table, 1)
        column.addWidget(self.message)
        self._column = column

    # --- pairs -------------------------------------------------------------------------------
    def _selected_pair(self) -> tuple[str, str] | None:
        records, ids = self._studio.records, self._studio.selection.ids
        fault = self.fault.id
        traces = (
            i for i in ids if i != fault and isinstance(get_feature(records, i), PickedFeature)
        )
        # Thousands of traces may be selected.
        trace_ids = tuple(islice(traces, 3))
        return (trace_ids[0], trace_ids[1]) if len(trace_ids) == 2 else None

    def add_pair(self) -> None:
        pair = self._selected_pair()
        if pair is not None and not {pair, pair[::-1]} & set(self.pairs):
            self.pairs.append(pair)
            self.refresh()

    def _remove(self) -> None:
        row = self.table.currentRow()
        if 0 <= row < len(self.pairs):
            del self.pairs[row]
            self.refresh()

    def _copy_slip_error(self) -> None:
        current_id = self._studio.selection.current
        if current_id is not None and self.slip.selected_line() is not None:
            error = self._studio.measured([current_id])[current_id].total95_deg
            self.options.show_value("rake_error_deg", error or 0.0)

    def _follow_edit(self, edit: Edit) -> None:
        records = self._studio.records
        self.pairs = [pair for pair in self.pairs if all(i in records for i in pair)]
        super()._follow_edit(edit)

    # --- result ------------------------------------------------------------------------------
    def _create_request(self) -> DisplacementRequest:
        if not self.pairs:
            raise InputError(Finding("displacement.no-pairs"))
        studio = self._studio
        if not has_plane(studio.records.get(self.fault.id)):
            raise InputError(Finding("displacement.no-fault"))
        measurements = studio.measured(
            {i for pair in self.pairs for i in pair} | {self.fault.id, self.bed.id} - {""}
        )
        fault_measurement = measurements[self.fault.id]
        fault = _require_plane(fault_measurement)
        rake, slip = self._parse_slip(fault)
        traces = tuple((measurements[a], measurements[b]) for a, b in self.pairs)
        bed, bed_error95_deg = _find_bed(measurements[self.bed.id] if self.bed.id else None, traces)
        return DisplacementRequest(
            names=tuple(self._trace_names()),
            traces=traces,
            fault=fault,
            fault_point=fault_measurement.points.mean(axis=0),
            bed=bed,
            rake_deg=rake,
            options=self.options.options(
                fault=format_exact_plane(fault),
                bed=format_exact_plane(bed),
                rake_deg=rake if slip is None else None,
                slip=None if slip is None else format_exact_line(slip),
                fault_error_deg=fault_measurement.total95_deg or 0.0,
                bed_error_deg=bed_error95_deg or 0.0,
            ),
        )

    def _compute_result(self, request: DisplacementRequest) -> DisplacementResult:
        from vomstudio.geology.faults.displacement_pairs import displacements

        names, fault, options = request.names, request.fault, request.options
        cuts = tuple(
            _find_cutoffs(name, first_trace.points, second_trace.points, fault, request.fault_point)
            for name, (first_trace, second_trace) in zip(names, request.traces, strict=True)
        )
        measurements = [trace for pair in request.traces for trace in pair]
        if options.sigma_m is None:
            options = replace(options, sigma_m=pick_scatter_m(measurements))
        result = displacements(
            names,
            np.array([section_cut.hanging_wall for section_cut in cuts]),
            np.array([section_cut.footwall for section_cut in cuts]),
            options,
        )
        return DisplacementResult(
            names=names,
            cuts=cuts,
            fault=fault,
            bed=request.bed,
            rake_deg=request.rake_deg,
            options=options,
            displacements=result,
        )

    def _trace_names(self) -> list[str]:
        """Return a unique name for each pair of traces."""
        records = self._studio.records

        def name(id_: str) -> str:
            return getattr(get_feature(records, id_), "name", "") or id_

        return [f"{k}: {name(a)} / {name(b)}" for k, (a, b) in enumerate(self.pairs, 1)]

    def _parse_slip(self, fault: Plane) -> tuple[float | None, Line | None]:
        """Parse the typed slip.

        Returns
        -------
        float or None
            Rake in degrees, or None if no slip was typed.
        Line or None
            Line of the slip, or None if it was not typed as a line.

        Raises
        ------
        InputError
            If the text is neither a rake from 0 to 180 degrees nor a line.
        """
        from vomstudio.geology.orientation import compute_rake

        text = self.slip.line.text().strip()
        if not text:
            return None, None
        rake = parse_number(text)
        if rake is not None:
            if not 0.0 <= rake <= 180.0:
                raise InputError(Finding("displacement.not-a-rake", value=rake))
            return rake, None
        line = self.slip.direction()
        assert isinstance(line, Line)
        return compute_rake(line, fault), line

    def _show_axes(self, axes: Axes) -> None:
        _show_unit(self.table, length_unit(axes))
        self.options.show_unit(length_unit(axes))

    def _show_error(self, error: VomError) -> None:
        # The location names the pair of traces.
        self._set_result(None, str(error))

    def _draw(self) -> None:
        result = self.result
        pairs = {} if result is None else {pair.name: pair for pair in result.displacements.pairs}
        self.table.setRowCount(len(self.pairs))
        for row, name in enumerate(self._trace_names()):
            cells = _cell_texts(pairs.get(name))
            for column, text in enumerate((name, *cells)):
                item = QTableWidgetItem(text)
                if column:
                    alignment = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                    item.setTextAlignment(alignment)
                self.table.setItem(row, column, item)
        # In a low window the text below the table is out of sight, so errors are shown above it.
        self._column.removeWidget(self.message)
        table_index = self._column.indexOf(self.table)
        self._column.insertWidget(table_index if result is None else table_index + 1, self.message)

    def _result_text(self, result: DisplacementResult) -> str:
        displacements, notation = result.displacements, self._studio.settings.notation
        unit = length_unit(project_axes(self._studio))
        code = "displacement.separation" if result.rake_deg is None else "displacement.net-slip"
        lines = [
            Finding(code, unit=unit).message,
            tr(
                "Fault {fault}, bed {bed} (95 %), points ± {sigma:.3g} {unit} (1σ).",
                fault=format_attitude(result.fault, result.options.fault_error_deg, notation),
                bed=format_attitude(result.bed, result.options.bed_error_deg, notation),
                sigma=result.options.sigma_m,
                unit=unit,
            ),
        ]
        separations = [p.separations for p in displacements.pairs if p.separations is not None]
        if separations:
            lines.append(
                tr(
                    "Stratigraphic separation {values} {unit}.",
                    values=", ".join(_value_text(s.stratigraphic_m) for s in separations),
                    unit=unit,
                )
            )
        if displacements.n > 1:
            lines.append(
                tr(
                    "Mean of {n} pairs: net {net:.3f} ± {std:.3f} {unit} (standard deviation).",
                    n=displacements.n,
                    net=displacements.mean_net_m,
                    std=displacements.std_net_m or 0.0,
                    unit=unit,
                )
            )
        lines += map(str, displacements.warnings)
        lines += [f"{pair['id']}: {pair['reason']}" for pair in displacements.skipped]
        return "\n".join(lines)

    def _refresh(self) -> None:
        pair = self._selected_pair() if self._studio.has_project else None
        reason = Finding("action.not-two-traces")
        set_enabled(self.add, None if pair is not None else reason)
        is_row_selected = 0 <= self.table.currentRow() < len(self.pairs)
        set_enabled(self.remove, None if is_row_selected else Finding("action.no-row"))
        self.copy.set_enabled(None if self.result is not None else Finding("action.no-result"))

    # --- command -----------------------------------------------------------------------------
    def copy_command(self) -> None:
        """Write the point table to a file selected by the user, and copy the command."""
        result = self.result
        if result is not None:
            copy_with_file(
                self,
                self._studio,
                "cutoffs.csv",
                partial(_write_points, result),
                partial(displacement_command, result),
            )


def displacement_command(result: DisplacementResult, points: Path) -> CommandArguments:
    """Return the command that reproduces the result from a table of points."""
    return ["displacement", points, *option_words(result.options)]


def _write_points(result: DisplacementResult, path: Path) -> None:
    import csv
    import io

    file = io.StringIO()
    file.write(WORLD_COMMENT)
    writer = csv.writer(file, lineterminator="\n")
    sides = [f"{side}_{axis}" for side in ("hanging", "footwall") for axis in "xyz"]
    writer.writerow(["name", *sides])
    for name, section_cut in zip(result.names, result.cuts, strict=True):
        points = [*section_cut.hanging_wall.tolist(), *section_cut.footwall.tolist()]
        writer.writerow([escape_formula(name), *format_numbers(points).split(",")])
    write_bytes(path, file.getvalue().encode(), force=True)


def _find_bed(
    measured_bed: Measurement | None, traces: Sequence[tuple[Measurement, Measurement]]
) -> tuple[Plane, float | None]:
    """Return the measured bed, or else a plane common to all traces.

    Returns
    -------
    Plane
        Plane of the bed.
    float or None
        95 % error of the plane in degrees, or None if it is unknown.
    """
    from vomstudio.geology.beds.common_attitude import fit_common_bed

    if measured_bed is not None:
        return _require_plane(measured_bed), measured_bed.total95_deg
    measurements = [trace for pair in traces for trace in pair]
    common_bed = fit_common_bed([trace.points for trace in measurements])
    error95_deg = common_error_deg(common_bed.max_confidence95_deg, measurements)
    return common_bed.plane, error95_deg


def _find_cutoffs(
    name: str,
    first_trace: FloatArray,
    second_trace: FloatArray,
    fault: Plane,
    fault_point: FloatArray,
) -> Cutoffs:
    """Find the cut-offs of a pair of traces. Raises InputError with the name of the pair."""
    from vomstudio.geology.faults.cutoffs import find_cutoffs

    try:
        return find_cutoffs(first_trace, second_trace, fault, fault_point)
    except GeometryError as error:
        raise InputError(cause_finding(error), field=name) from error


def _require_plane(measurement: Measurement) -> Plane:
    if measurement.plane is None:
        raise InputError(measurement.problem or Finding("field.no-plane"))
    return measurement.plane


def _pair_displacement(pair: Pair) -> Displacement | None:
    return pair.displacement if pair.separations is None else pair.separations.dip


def _cell_texts(pair: Pair | None) -> list[str]:
    displacement = None if pair is None else _pair_displacement(pair)
    if displacement is None:
        return [""] * (len(_COLUMNS) + 1)
    rake = displacement.slip_rake_deg
    return [
        *(_value_text(getattr(displacement, name)) for name in _COLUMNS),
        "–" if rake is None else f"{rake:.0f}°",
    ]


def _value_text(quantity: MeasuredValue) -> str:
    # Adding zero removes the sign of a negative zero.
    value = round(quantity.value, 3) + 0.0
    if quantity.error95 is None:
        return f"{value:.3f}"
    return f"{value:.3f} ± {quantity.error95:.3f}"


def _show_unit(table: QTableWidget, unit: str) -> None:
    titles = (
        tr("Net ({unit})", unit=unit),
        tr("Throw ({unit})", unit=unit),
        tr("Heave ({unit})", unit=unit),
        tr("Strike slip ({unit})", unit=unit),
    )
    for column, title in enumerate(titles, 1):
        header_item = table.horizontalHeaderItem(column)
        assert header_item is not None
        header_item.setText(title)


def _create_table() -> QTableWidget:
    columns = (
        (tr("Traces"), tr("Cut-offs of one bed on both sides of the fault.")),
        ("", tr("Distance the hanging wall moved relative to the footwall.")),
        ("", tr("Vertical component; down is positive.")),
        ("", tr("Horizontal component across the strike; extension is positive.")),
        ("", tr("Component along the strike; sinistral is positive.")),
        (tr("Slip rake"), tr("Rake of the motion on the fault; positive if reverse.")),
    )
    table = CompactTable(0, len(columns))
    table.setObjectName("displacement_table")
    table.setAccessibleName(tr("Pairs of cut-offs"))
    for column, (title, tooltip) in enumerate(columns):
        item = QTableWidgetItem(title)
        item.setToolTip(tooltip)
        table.setHorizontalHeaderItem(column, item)
    table.verticalHeader().hide()
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
    table.setTabKeyNavigation(False)
    header = table.horizontalHeader()
    header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    table.setMinimumHeight(_MIN_TABLE_HEIGHT_PX)
    return table
