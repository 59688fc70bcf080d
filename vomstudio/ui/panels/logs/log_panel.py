"""Panel for bed boundaries and thicknesses along a line on the outcrop."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtGui import QImage
from PySide6.QtWidgets import (
    QHBoxLayout,
    QPushButton,
    QSplitter,
)

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.beds.log_options import LogLine, LogOptions
from vomstudio.geology.notation import format_attitude
from vomstudio.geometry.units import Axes
from vomstudio.products.section.line_log import (
    POINTS,
    LogRequest,
    LogResult,
    RockDescription,
    compute_log,
    read_rock_descriptions,
)
from vomstudio.project.bed_descriptions import describe_bed
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Feature, LoggedFeature, get, get_feature
from vomstudio.project.registration_errors import get_model
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import current_line, missing_model_finding
from vomstudio.ui.base.controls import (
    ElidedLabel,
    button_row,
    icon_button,
    narrow_form,
    set_enabled,
)
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.logs.analysis import draw_figure, log_command, write, write_boundaries
from vomstudio.ui.panels.logs.log_table import BedLogTable
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import CopyCommandButton, copy_with_file
from vomstudio.ui.widgets.drawn_line import DrawnLine
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.group_box import SELECTED, GroupBox
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.plane_choice import PlaneChoice
from vomstudio.ui.widgets.scaled_picture import ScaledPicture

_FORMATS = {"csv": "CSV", "svg": "SVG", "pdf": "PDF", "png": "PNG"}


class BedLogPanel(AnalysisPanel[LogRequest, LogResult]):
    """Panel for the bed thickness log along a line.

    Attributes
    ----------
    line_id : str
        Id of the line along which the log runs, or an empty string if no line is selected.
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__(studio, "log", "window.md#log", tr("Computing…"))
        self.line_id = ""
        self._drawn_result: LogResult | None = None
        self._line = DrawnLine(self, studio)
        self.line = ElidedLabel()
        self.line.setObjectName("log_line")
        self.take = icon_button("cursor-default-click-outline", tr("Use selected"))
        self.take.setToolTip(tr("Draw the log along the selected trace or polyline."))
        self.pick = QPushButton(theme.icon("vector-polyline"), tr("Pick…"))
        self.pick.setObjectName("log_pick")
        self.pick.setToolTip(tr("Click one point per boundary in order, then press Enter."))
        self.line_options = OptionFields(LogLine, "log")
        self.group = GroupBox(studio)
        self.group.setAccessibleName(tr("Traces"))
        self.group.setToolTip(tr("Choose the boundaries and the source of the bedding attitude."))
        self.bed = PlaneChoice(studio, "log_bed", tr("fitted to the traces"))
        self.options = OptionFields(LogOptions, "log")
        self.write = QPushButton(theme.icon("export"), tr("Write…"))
        self.write.setToolTip(tr("Save a CSV table, or an SVG, PDF or PNG figure."))
        self.copy = CopyCommandButton(
            self.copy_command, tr("save the boundaries as a table and copy the command")
        )
        self.table = BedLogTable()
        follow_axes(self, studio, self._show_axes)
        self.picture = ScaledPicture()
        self._arrange_widgets()
        self._connect_signals()
        self._set_result(None, "")

    def _arrange_widgets(self) -> None:
        line_row = QHBoxLayout()
        line_row.setSpacing(3)
        for widget in (self.line, self.take, self.pick):
            line_row.addWidget(widget, 1 if widget is self.line else 0)
        traces_label, traces_row = self.line_options.place_row("reach_m")
        traces_row.insertWidget(0, self.group, 2)
        form = narrow_form()
        form.addRow(tr("Line"), line_row)
        self.line_options.add_rows(form)
        form.addRow(traces_label, traces_row)
        form.addRow(tr("Bed"), self.bed)
        overturned_field = self.options.place("overturned")
        self.options.add_rows(form)
        results = QSplitter()
        results.setChildrenCollapsible(False)
        results.addWidget(self.table)
        results.addWidget(self.picture)
        results.setSizes([400, 150])
        results.setStretchFactor(0, 2)
        results.setStretchFactor(1, 1)
        self.picture.setMinimumWidth(120)
        buttons = button_row(self.write, self.copy)
        FormWithPicture.fill(self, form, overturned_field, buttons, self.message, picture=results)

    def _show_axes(self, axes: Axes) -> None:
        self.table.show_unit(length_unit(axes))
        for fields in (self.line_options, self.options):
            fields.show_unit(length_unit(axes))

    def _connect_signals(self) -> None:
        studio, refresh = self._studio, self._schedule_refresh
        self.take.clicked.connect(
            lambda _=False: self._use_feature(current_line(studio, LoggedFeature))
        )
        self.pick.clicked.connect(lambda _=False: self._pick_line())
        self.group.activated.connect(refresh)
        self.line_options.changed.connect(refresh)
        self.options.changed.connect(refresh)
        self.bed.changed.connect(refresh)
        self.table.description_edited.connect(self._store_description)
        title = tr("Write the log")
        self.write.clicked.connect(lambda _=False: self._ask_for_file(title, "log.csv", _FORMATS))
        studio.edited.connect(self._follow_edit)
        studio.settings_changed.connect(refresh)
        studio.selection_changed.connect(self._follow_selection)
        self._line.finished.connect(self._use_picked_line)

    # --- line --------------------------------------------------------------------------------
    def _use_feature(self, feature: Feature | None) -> None:
        if feature is not None:
            self.line_id = feature.id
            self._schedule_refresh()

    def _pick_line(self) -> None:
        self._line.begin()
        self.message.setText(tr("Click one point on each boundary, then press Enter."))

    def _use_picked_line(self, line: Dimension) -> None:
        self.line_options.show_value("of", POINTS)
        self._use_feature(line)

    def _follow_selection(self) -> None:
        if self.group.choice() == SELECTED:
            self._schedule_refresh()
        self._refresh()

    def _store_description(self, key: str, description: object) -> None:
        """Store the description of a bed in the record of the line, as one edit."""
        assert isinstance(description, RockDescription)
        line = get_feature(self._studio.records, self.line_id)
        if (
            line is not None
            and read_rock_descriptions(line).get(key, RockDescription()) != description
        ):
            self._studio.attempt(
                describe_bed, line.id, key, description.lithology, description.notes
            )

    # --- input -------------------------------------------------------------------------------
    def _list_choices(self) -> None:
        self.group.list_groups()
        if self.line_id and self.line_id not in self._studio.records:
            self.line_id = ""

    def _compute_result(self, request: LogRequest) -> LogResult:
        return compute_log(request)

    def _create_request(self) -> LogRequest:
        studio = self._studio
        line = get_feature(studio.records, self.line_id) if self.line_id else None
        if line is None:
            raise InputError(Finding("bed.no-line"))
        group_traces = (get(studio.records, f.id, Trace) for f in self.group.features())
        traces = [trace for trace in group_traces if trace is not None]
        measurements = studio.measured({f.id for f in traces} | {line.id, self.bed.id} - {""})
        bed = measurements[self.bed.id] if self.bed.id else None
        if bed is not None and bed.plane is None:
            raise InputError(bed.problem or Finding("field.no-plane"))
        options = self.options.options(bed_error_deg=None if bed is None else bed.total95_deg)
        model = get_model(studio.records, line)
        return LogRequest(
            line.id,
            measurements[line.id],
            str(self.line_options.value("of")),
            {f.id: measurements[f.id] for f in traces},
            {f.id: f.name or f.id for f in traces},
            None if bed is None else bed.plane,
            options,
            self.line_options.value("reach_m"),
            read_rock_descriptions(line),
            model is None or model.frame.has_metres,
            frozenset(f.id for f in traces if f.overturned),
        )

    # --- result ------------------------------------------------------------------------------
    def _result_text(self, result: LogResult) -> str:
        from vomstudio.products.section.decimals import format_with_error

        q, total = result.request, result.log.total_m
        unit = "m" if q.is_metric else tr("units")
        lines = [
            tr_n(
                "{count} bed, true thickness {total} {unit} (95 %).",
                "{count} beds, true thickness {total} {unit} (95 %).",
                len(result.log.intervals),
                total=format_with_error(total.value, total.error95),
                unit=unit,
            ),
            tr(
                "Bedding {bed} (95 %), points ± {sigma:.3g} {unit} (1σ).",
                bed=format_attitude(result.bed, result.bed95_deg, self._studio.settings.notation),
                sigma=result.sigma_m,
                unit=unit,
            ),
        ]
        if q.of != POINTS:
            lines.append(
                tr("Traces within {reach:.3g} {unit} of the line.", reach=result.reach_m, unit=unit)
            )
        return "\n".join([*lines, *map(str, result.log.warnings)])

    def _draw(self) -> None:
        result = self._drawn_result = self.result
        self.table.show_log(result)
        if result is None:
            self.picture.show_image(QImage())
        else:
            self._background.run(partial(draw_figure, result), partial(self._show_figure, result))

    def _show_figure(self, result: LogResult, png: bytes) -> None:
        if result is self._drawn_result:
            self.picture.show_image(QImage.fromData(png))

    def _refresh(self) -> None:
        studio = self._studio
        is_line_selected = current_line(studio, LoggedFeature) is not None
        set_enabled(self.take, None if is_line_selected else Finding("action.no-line"))
        line = get_feature(studio.records, self.line_id) if studio.has_project else None
        self.line.setText(tr("none") if line is None else line.name or tr("the picked line"))
        set_enabled(self.pick, missing_model_finding(studio))
        reason = Finding("action.points-are-boundaries")
        is_unused = self.line_options.value("of") == POINTS
        set_enabled(self.line_options.fields["reach_m"], reason if is_unused else None)
        problem = None
        if self._requests.is_waiting:
            problem = Finding("action.busy")
        elif self.result is None:
            problem = Finding("action.no-result")
        set_enabled(self.write, problem)
        self.copy.set_enabled(problem)

    # --- export ------------------------------------------------------------------------------
    def write_result(self, path: Path) -> None:
        if self.result is not None:
            self._write(write, self.result, path)

    def copy_command(self) -> None:
        """Write the boundary table to a file selected by the user, and copy the command."""
        result = self.result
        if result is not None:
            copy_with_file(
                self,
                self._studio,
                "boundaries.csv",
                partial(write_boundaries, result),
                partial(log_command, result),
            )
