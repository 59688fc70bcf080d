"""Panel for control points, known lines and compass readings.

It shows the coordinates, the residuals, a map and the accuracy of the placement, and updates them
after every edit.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QPushButton,
    QTableWidgetItem,
    QWidget,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import tr
from vomstudio.geometry.coordinate_limits import check_coordinates
from vomstudio.geometry.registrations import NorthReference
from vomstudio.project import edits
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import CLICKED_KINDS, KINDS, KnownKind, KnownLine
from vomstudio.project.records import Compass, Model
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.studio.tools.control import ControlTool
from vomstudio.studio.tools.known_line import KnownLineTool
from vomstudio.ui.base import file_filters, theme
from vomstudio.ui.base.command_targets import current_model, start_folder
from vomstudio.ui.base.controls import ComboBox, narrow_form, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.qt_background import LatestRequestRunner
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.panels.tools.compass_box import CompassBox
from vomstudio.ui.panels.tools.control_command import copy_register_command
from vomstudio.ui.panels.tools.control_map import ControlMap, MapPoint
from vomstudio.ui.panels.tools.control_messages import (
    format_placement,
    placement_problem,
    reading_tips,
)
from vomstudio.ui.panels.tools.control_table import LABEL, TICK, ControlTable
from vomstudio.ui.panels.tools.known_table import KnownTable, apply_cell
from vomstudio.ui.panels.tools.readings import (
    Readings,
    find_north_inputs,
    has_azimuths,
    placement_north,
)
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.crs_field import CrsField
from vomstudio.ui.widgets.more_section import MoreSection
from vomstudio.ui.widgets.options_form import OptionFields

if TYPE_CHECKING:
    from vomstudio.registration.north import NorthInputs
    from vomstudio.registration.results import ModelPlacement

MAX_IMMEDIATE_POINTS = 20
"""Up to this number of points, placing a model takes less time than starting a thread."""

RING_RADIUS_SHARE = 0.04
"""Radius of the ring at the expected position, as a fraction of the extent of the points."""


class ControlPanel(QWidget):
    """Panel that places a model by control points, known lines and compass readings.

    Attributes
    ----------
    placed : ModelPlacement or None
        Placement computed from the ticked observations, or None if they do not determine one.
    crs : str or None
        CRS of the coordinates, or None for a local frame.
    readings : Readings
        Compass readings with their directions in model coordinates.
    """

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        set_help_topic(self, "registration.md")
        self._studio = studio
        self._tool = studio.get_tool(ControlTool)
        self._lines_tool = studio.get_tool(KnownLineTool)
        self._points: list[ControlPoint] = []
        self._lines: list[KnownLine] = []
        self._pair_count, self._extent = 0, 0.0
        self._photo_up_cache: tuple[Path | None, FloatArray | None] | None = None
        self._solving = LatestRequestRunner(
            self, self._show_result, self._show_error, self._show_progress
        )
        self.model: Model | None = None
        self.placed: ModelPlacement | None = None
        self.crs: str | None = None
        self.readings = Readings.empty()
        self.north: NorthReference | None = None
        self._north_text = ""
        self.load = QPushButton(theme.icon("table-arrow-left"), tr("Coordinates…"))
        self.load.setToolTip(tr("Read labels and coordinates from a table or ground control file."))
        self.load.clicked.connect(self.choose_points_file)
        self.table = ControlTable()
        self.table.itemChanged.connect(self._apply_point_edit)
        self.table.itemSelectionChanged.connect(self._choose_point)
        self.click_box = ComboBox()
        self.click_box.setObjectName("what_is_clicked")
        self.click_box.addItem(tr("Control points"), "")
        for known_kind, name in CLICKED_KINDS:
            self.click_box.addItem(tr(name), known_kind)
        self.click_box.addItem(tr("Plane or line by compass"), "plane")
        self.click_box.activated.connect(self._choose_click_target)
        self.lines = KnownTable()
        self.lines.itemChanged.connect(self._apply_line_edit)
        self.lines.itemSelectionChanged.connect(self._select_line)
        self.crs_field = CrsField()
        self.crs_field.setPlaceholderText(tr("none: local metres, x east, y north"))
        self.crs_field.textChanged.connect(self._solve)
        self.options = OptionFields(RegisterOptions, "register")
        self.options.changed.connect(self._solve)
        self.compass = CompassBox(studio, self._list_labels, self._find_north_inputs)
        self.map = ControlMap()
        self.summary = hint_label()
        self.summary.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.register = QPushButton(theme.icon("vector-point-select"), tr("Register"))
        self.register.clicked.connect(self.apply)
        self.copy = CopyCommandButton(
            self._copy_command, tr("save the points as a table and copy the command")
        )
        row = QHBoxLayout()
        row.addWidget(self.load)
        row.addWidget(self.register)
        form = QFormLayout()
        form.addRow(tr("Click"), self.click_box)
        form.addRow(tr("CRS"), self.crs_field)
        details = narrow_form()
        self.options.add_rows(details)
        details.addRow(self.copy)
        column = narrow_column(self)
        column.addLayout(row)
        column.addLayout(form)
        column.addWidget(MoreSection(details))
        column.addWidget(self.compass)
        column.addWidget(self.table, 3)
        column.addWidget(self.lines)
        column.addWidget(self.summary)
        column.addWidget(self.map, 2)
        # The table and the map are hidden without points.
        column.addStretch(0)
        for signal in (studio.project_opened, studio.edited, studio.selection_changed):
            signal.connect(self.refresh)
        studio.tool_changed_signal.connect(self._select_current_point)
        studio.active_tool_changed.connect(self._follow_tool)

    # --- display -----------------------------------------------------------------------------
    def refresh(self, *_: object) -> None:
        """Show the points, lines and planes of the current model.

        The panel is not updated while neither of its tools is active.
        """
        if self._studio.tool_name not in (self._tool.name, self._lines_tool.name):
            # The panel is updated when its tool is activated.
            return
        model = current_model(self._studio)
        points = [] if model is None else self._points_on(model)
        lines = [] if model is None else self._model_lines(model)
        readings = Readings.create(self._studio, model, lines)
        is_unchanged = (model, points, lines) == (self.model, self._points, self._lines)
        if is_unchanged and readings.is_equivalent(self.readings):
            return
        known_ids = {line.id for line in self._lines}
        is_same_model = model is not None and self.model is not None and model.id == self.model.id
        new_rows = [
            row
            for row, line in enumerate(lines)
            if line.id not in known_ids and not line.is_complete
        ]
        if model is None or self.model is None or model.id != self.model.id:
            self.crs_field.preferred_names = self._studio.crs_codes()
            with QSignalBlocker(self.crs_field), QSignalBlocker(self.options):
                self.crs_field.setText("" if model is None else model.frame.crs or "")
                self.options.reset()
        if lines != self._lines:
            self.lines.show_lines(lines, self._studio.settings.notation)
        if points != self._points:
            self.table.show_points(points)
        self.model, self._points, self._lines = model, points, lines
        self.readings = readings
        self._solve()
        self._select_current_point()
        if is_same_model and len(new_rows) == 1 and self._studio.tool_name == self._lines_tool.name:
            self.lines.edit_value(new_rows[0])

    def _points_on(self, model: Model) -> list[ControlPoint]:
        return [p for p in self._studio.session.of(ControlPoint) if p.model_id == model.id]

    def _model_lines(self, model: Model) -> list[KnownLine]:
        return [line for line in self._studio.session.of(KnownLine) if line.model_id == model.id]

    def _follow_tool(self, name: str) -> None:
        if name == self._tool.name:
            self._tool.begin()
        if name in (self._tool.name, self._lines_tool.name):
            known_kind = self._lines_tool.kind if name == self._lines_tool.name else ""
            self.click_box.setCurrentIndex(self.click_box.findData(known_kind))
            self.refresh()
            self._show_compass()

    def _choose_click_target(self) -> None:
        known_kind: KnownKind | str = self.click_box.currentData()
        for item, _ in KINDS:
            if item == known_kind:
                self._lines_tool.choose(item)
        self._studio.activate(self._lines_tool.name if known_kind else self._tool.name)
        self._show_compass()

    def _solve(self) -> None:
        """Place the model by the ticked observations and show the accuracy.

        The computation runs immediately if it takes milliseconds, otherwise in a worker thread.
        """
        from vomstudio.registration.surface_points import sample_points
        from vomstudio.studio.placing.known_planes import compass_table
        from vomstudio.studio.placing.registering import control_pairs, place_by_points

        model = self.model
        open_model = None if model is None else self._studio.models.get(model.id)
        bounds = None if open_model is None else open_model.data.bounds
        pairs, lines = control_pairs(self._points), tuple(self._lines)
        self._pair_count = len(pairs.labels)
        self._extent = float(np.ptp(pairs.model, axis=0).max()) if self._pair_count > 1 else 0.0
        table = compass_table(lines, self.readings.directions)
        options = self.options.options()
        resolution = None if open_model is None else open_model.resolution
        photo_up = self._find_photo_up(model)

        def work() -> ModelPlacement:
            if model is None:
                raise GeometryError(Finding("action.no-model"))
            extent = None if open_model is None else sample_points(open_model.data)
            return place_by_points(
                pairs=pairs,
                bounds=bounds,
                model=model,
                crs=self.crs,
                extent=extent,
                lines=lines,
                north_doubt_deg=north.doubt_deg,
                compass=table,
                turned_deg=north.turned_deg,
                is_north_sigma_stated=is_sigma_stated,
                photo_up=photo_up,
                keep_scale=options.keep_scale,
                click_sigma_m=options.click_sigma_m,
                resolution=resolution,
            )

        self.north, self._north_text = None, ""
        try:
            self.crs = self._parse_crs()
            if has_azimuths(lines):
                self.north, self._north_text = self.readings.resolve_north(self._find_north_inputs)
        except VomError as error:
            self._show_compass()
            self._solving.cancel()
            self._show_error(error)
            return
        north = self.north or NorthReference("grid")
        compass = self.readings.compass
        is_sigma_stated = compass is not None and compass.doubt_deg is not None
        self._show_compass()
        # Recomputing the placement without each direction in turn takes a second.
        if self._pair_count <= MAX_IMMEDIATE_POINTS and table is None:
            self._solving.run_now(work)
        else:
            # The previous placement does not belong to these observations.
            self.placed = None
            self._allow_buttons(Finding("registration.pending"))
            self._solving.request(work)

    def _find_photo_up(self, model: Model | None) -> FloatArray | None:
        """Return the result of `known_lines.photo_up`, which is computed once per model file."""
        from vomstudio.studio.placing.known_lines import photo_up

        path = None if model is None else self._studio.project.find_model(model)
        if self._photo_up_cache is None or self._photo_up_cache[0] != path:
            self._photo_up_cache = (path, None if path is None else photo_up(path))
        return self._photo_up_cache[1]

    def _show_progress(self) -> None:
        count = self._pair_count + len(self.readings.directions)
        self.summary.setText(tr("Placing the model with {count} observations…", count=f"{count:,}"))

    def _show_result(self, placement: ModelPlacement) -> None:
        if placement.click_sigma_m and self.options.options().click_sigma_m is None:
            self.options.show_automatic("click_sigma_m", placement.click_sigma_m)
        text = format_placement(placement, self.model, self.crs)
        self._show_placement(placement, "\n".join(filter(None, [text, self._north_text])))
        self._allow_buttons(None)

    def _show_error(self, error: VomError) -> None:
        problem = (
            cause_finding(error)
            if self.model is None
            else placement_problem(
                points=self._points,
                lines=self._lines,
                pair_count=self._pair_count,
                error=error,
                readings=self.readings,
            )
        )
        self._show_placement(None, problem.message)
        self._allow_buttons(problem)

    def _show_placement(self, placement: ModelPlacement | None, text: str) -> None:
        from vomstudio.studio.placing.registering import expected_positions

        self.placed = placement
        self.summary.setText(text)
        self._show_residuals()
        self._show_map()
        positions = (
            {} if self.model is None else expected_positions(self._points, self.placed, self.model)
        )
        self._tool.expect(positions, RING_RADIUS_SHARE * self._extent * self._metres_per_unit())

    def _show_residuals(self) -> None:
        from vomstudio.studio.placing.known_lines import line_residuals

        placement = self.placed
        self.table.show_residuals(self._points, placement)
        directions, turned_deg = (
            self.readings.directions,
            0.0 if self.north is None else self.north.turned_deg,
        )
        residuals = (
            []
            if placement is None
            else line_residuals(self._lines, placement, directions, turned_deg)
        )
        blunders = set() if placement is None else {blunder.label for blunder in placement.blunders}
        tips = reading_tips(
            lines=self._lines,
            readings=self.readings,
            placement=placement,
            turned_deg=turned_deg,
            studio=self._studio,
        )
        self.lines.show_residuals(
            self._lines, {residual.id: residual.deviation for residual in residuals}, blunders, tips
        )

    def _allow_buttons(self, disabled_reason: Finding | None) -> None:
        set_enabled(self.register, disabled_reason)
        self.copy.set_enabled(disabled_reason)

    def _metres_per_unit(self) -> float:
        from vomstudio.geometry import transform

        return 1.0 if self.model is None else transform.scale_factor(self.model.to_world)

    def _parse_crs(self) -> str | None:
        from vomstudio.io.gis.crs import metric_crs

        text = self.crs_field.text().strip()
        return metric_crs(text, tr("CRS")) if text else None

    def _list_labels(self) -> list[str]:
        return [item.name for item in (*self._points, *self._lines)]

    def _find_north_inputs(self, compass: Compass) -> NorthInputs:
        assert self.model is not None
        return find_north_inputs(
            studio=self._studio,
            compass=compass,
            model=self.model,
            points=self._points,
            crs=self.crs,
        )

    def _show_compass(self) -> None:
        self.load.setVisible(not self.click_box.currentData())
        lines_tool = self._lines_tool
        is_reading = self._studio.tool_name == lines_tool.name and lines_tool.selects_feature
        self.compass.show_model(self.model, self._lines, self.north, is_reading=is_reading)
        for widget in (self.table, self.map):
            widget.setVisible(bool(self._points) or not (self._lines or is_reading))

    def _show_map(self) -> None:
        residuals = () if self.placed is None else (*self.placed.control, *self.placed.check)
        offsets = {p.label: (p.dx, p.dy) for p in residuals}
        self.map.show_points(
            [
                MapPoint(
                    label=p.name,
                    x=p.position[0],
                    y=p.position[1],
                    is_used=not p.check,
                    is_on_model=bool(p.vertices),
                    residual=offsets.get(p.name),
                )
                for p in self._points
                if p.position is not None
            ],
            self.placed,
        )

    def _select_current_point(self, *_: object) -> None:
        current = self._tool.current
        with QSignalBlocker(self.table):
            self.table.clearSelection()
            for row in (i for i, p in enumerate(self._points) if current and p.id == current.id):
                self.table.choose_row(row)

    # --- command -----------------------------------------------------------------------------
    def _copy_command(self) -> None:
        """Save the observations as tables and copy the equivalent command to the clipboard."""
        studio, model = self._studio, self.model
        path = None if model is None else studio.project.find_model(model)
        if path is not None:
            options = self.options.options()
            copy_register_command(
                parent=self,
                studio=studio,
                model=path,
                points=self._points,
                lines=self._lines,
                crs=self.crs,
                readings=self.readings,
                north=self.north,
                fixed_scale=self._metres_per_unit() if options.keep_scale else None,
                click_sigma_m=options.click_sigma_m,
            )

    # --- actions -----------------------------------------------------------------------------
    def choose_points_file(self) -> None:
        """Open a file dialog for a table of coordinates and import the selected file."""
        model = self.model or current_model(self._studio)
        if model is None:
            self._studio.warn(Finding("action.no-model"))
            return
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Points on {model}", model=model.name),
            start_folder(self._studio),
            file_filters.ground_control(),
        )
        if name:
            self.import_points(model, Path(name))

    def import_points(self, model: Model, path: Path) -> None:
        """Import the points in a file as control points of a model."""
        from vomstudio.io.control.control_files import read_crs
        from vomstudio.io.control.observation_tables import read_points
        from vomstudio.studio.placing.registering import import_control_points

        try:
            pairs = read_points(path)
            crs = pairs.crs if np.isfinite(pairs.model).any() else read_crs(path)
        except VomError as error:
            self._studio.warn(error, "error")
            return
        if not self._studio.attempt(import_control_points, model, pairs, self._points_on(model)):
            return
        if crs:
            self.crs_field.setText(crs)
        for note in pairs.notes:
            self._studio.warn(note.with_file(path.name))
        first_id = next((p.id for p in self._points if not p.vertices), "")
        self._tool.choose(first_id)

    def _choose_point(self) -> None:
        rows = self.table.selectionModel().selectedRows()
        if rows:
            self._tool.choose(self._points[rows[0].row()].id)

    def _select_line(self) -> None:
        rows = self.lines.selectionModel().selectedRows()
        if rows:
            self._studio.selection.set([self._lines[rows[0].row()].id])

    def _apply_line_edit(self, item: QTableWidgetItem) -> None:
        line = self._lines[item.row()]
        try:
            new_line = apply_cell(line, item.column(), item, self._studio.settings.notation)
        except VomError as error:
            self._studio.warn(error)
            new_line = line
        if new_line != line:
            self._studio.attempt(edits.change_feature, new_line)
            return
        self.lines.show_lines(self._lines, self._studio.settings.notation)
        self._show_residuals()

    def _apply_point_edit(self, item: QTableWidgetItem) -> None:
        point = self._points[item.row()]
        if item.column() == TICK:
            new_point = replace(point, check=item.checkState() != Qt.CheckState.Checked)
        elif item.column() == LABEL:
            new_point = replace(point, name=item.text().strip() or point.name)
        else:
            cells = self.table.coordinates(item.row())
            if not all(cell.strip() for cell in cells):
                return
            x, y, z = (parse_number(cell) for cell in cells)
            if x is None or y is None or z is None:
                self._refuse_cell(item, Finding("number.invalid", text=item.text()))
                return
            if (problem := check_coordinates((x, y, z))) is not None:
                self._refuse_cell(item, problem)
                return
            new_point = replace(point, position=(x, y, z))
        if new_point != point:
            self._studio.attempt(edits.change_feature, new_point)

    def _refuse_cell(self, item: QTableWidgetItem, reason: Finding) -> None:
        """Report an invalid coordinate, and restore the previous value or clear the cell."""
        self._studio.warn(reason)
        if self._points[item.row()].position is None:
            # The coordinates that were typed before remain.
            with QSignalBlocker(self.table):
                item.setText("")
            return
        self.table.show_points(self._points)
        self.table.show_residuals(self._points, self.placed)

    def apply(self) -> None:
        """Register the model by the points, lines and planes."""
        from vomstudio.studio.placing.known_lines import placement_lines
        from vomstudio.studio.placing.known_planes import placement_readings
        from vomstudio.studio.placing.registering import (
            control_pairs,
            create_registration,
            rotation_deg,
            set_rotation_finding,
            set_rotations_deg,
        )

        previous_model, placement = self.model, self.placed
        if previous_model is None or placement is None:
            return
        north = None if self.north is None else placement_north(self.north, self._lines)
        record = create_registration(
            placement, control_pairs(self._points), previous_model, self.crs, read_north=north
        )
        if not self._studio.attempt(edits.set_registration, record, [previous_model.id]):
            return
        registered_model = self._studio.records[previous_model.id]
        assert isinstance(registered_model, Model)
        studio = self._studio
        measurements = studio.measured(f.id for f in studio.session.features())
        points, lines = len(placement.control), len(placement_lines(self._lines))
        readings = len(placement_readings(self._lines, self.readings.directions))
        studio.info(
            Finding(
                "registration.applied",
                model=previous_model.name,
                count=points + lines + readings,
                points=points,
                lines=lines,
                readings=readings,
                turn_deg=rotation_deg(previous_model, registered_model),
            )
        )
        finding = set_rotation_finding(
            set_rotations_deg(studio.records, previous_model, registered_model, measurements)
        )
        if finding is not None:
            studio.info(finding)


PANEL = ControlPanel
