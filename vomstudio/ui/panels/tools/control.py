"""The panel of control points and known lines: coordinates and values, what is left over at each,
the map, and what the placement by them is worth, live as they are clicked and ticked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCheckBox,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QTableWidgetItem,
    QWidget,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr
from vomstudio.geometry.registrations import ReadNorth
from vomstudio.project import edits
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import CLICKED, KINDS, KnownKind, KnownLine
from vomstudio.project.records import Compass, Model
from vomstudio.studio.tools.control import ControlTool
from vomstudio.studio.tools.known_line import KnownLineTool
from vomstudio.ui.base import file_filters, theme
from vomstudio.ui.base.command_targets import current_model, start_folder
from vomstudio.ui.base.controls import ComboBox, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.qt_background import NewestResult
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.panels.tools.compass_box import CompassBox
from vomstudio.ui.panels.tools.control_command import copy_register
from vomstudio.ui.panels.tools.control_map import ControlMap, MapPoint
from vomstudio.ui.panels.tools.control_table import LABEL, TICK, ControlTable
from vomstudio.ui.panels.tools.control_words import in_short, placement_text, reading_tips
from vomstudio.ui.panels.tools.known_table import KnownTable, typed
from vomstudio.ui.panels.tools.readings import (
    Readings,
    counted,
    known_north,
    used_north,
)
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.crs_field import CrsField

if TYPE_CHECKING:
    from vomstudio.registration.north import North
    from vomstudio.registration.results import Placed

_FEW = 20
"""By so many points a model is placed in less time than a thread takes to hand over."""

_RING = 0.04
"""Radius of the ring where a point should be, as a share of the extent of the points."""


class ControlPanel(QWidget):
    """`placed` is the placement by the points, lines and planes that are ticked, None where they
    give none; `crs` that of the coordinates, None for a local frame; `readings` what was read by
    compass, as the model shows it."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "registration.md")
        self._studio = studio
        self._tool = studio.tool_of(ControlTool)
        self._lines_tool = studio.tool_of(KnownLineTool)
        self._points: list[ControlPoint] = []
        self._lines: list[KnownLine] = []
        self._found, self._reach = 0, 0.0
        self._photo_up_of: tuple[Path | None, FloatArray | None] | None = None
        self._solving = NewestResult(self, self._solved, self._unsolved, self._say_solving)
        self.model: Model | None = None
        self.placed: Placed | None = None
        self.crs: str | None = None
        self.readings = Readings.none()
        self.north: ReadNorth | None = None
        self._counted = ""
        self.load = QPushButton(theme.icon("table-arrow-left"), tr("Coordinates…"))
        self.load.setToolTip(
            tr("Read labels and coordinates from a table or a file of ground control.")
        )
        self.load.clicked.connect(self.ask_for_points)
        self.table = ControlTable()
        self.table.itemChanged.connect(self._typed)
        self.table.itemSelectionChanged.connect(self._chosen)
        self.clicked = ComboBox()
        self.clicked.setObjectName("what_is_clicked")
        self.clicked.addItem(tr("Control points"), "")
        for kind, name in CLICKED:
            self.clicked.addItem(tr(name), kind)
        self.clicked.addItem(tr("Plane or line by compass"), "plane")
        self.clicked.activated.connect(self._choose_clicked)
        self.lines = KnownTable()
        self.lines.itemChanged.connect(self._line_typed)
        self.lines.itemSelectionChanged.connect(self._line_chosen)
        self.field = CrsField()
        self.field.setPlaceholderText(tr("none: local metres, x east, y north"))
        self.field.textChanged.connect(self._solve)
        self.click_error = _click_error_field()
        self.click_error.editingFinished.connect(self._solve)
        self.keep_scale = _keep_scale_box()
        self.keep_scale.toggled.connect(self._solve)
        self.compass = CompassBox(studio, self._labels, self._known_north)
        self.map = ControlMap()
        self.said = hint_label()
        self.said.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.register = QPushButton(theme.icon("vector-point-select"), tr("Register"))
        self.register.clicked.connect(self.apply)
        self.copy = CopyCommandButton(
            self._copy_command, tr("keep the points as a table, and copy the command")
        )
        row = QHBoxLayout()
        row.addWidget(self.load)
        row.addWidget(self.register)
        row.addWidget(self.copy)
        self._form = form = QFormLayout()
        form.addRow(tr("Click"), self.clicked)
        form.addRow(tr("CRS of x, y, z"), self.field)
        form.addRow(tr("Click error"), self.click_error)
        form.addRow(self.keep_scale)
        column = narrow_column(self)
        column.addLayout(row)
        column.addLayout(form)
        column.addWidget(self.compass)
        column.addWidget(self.table, 3)
        column.addWidget(self.lines)
        column.addWidget(self.said)
        column.addWidget(self.map, 2)
        # Without points there is nothing that fills the panel.
        column.addStretch(0)
        for signal in (studio.project_opened, studio.edited, studio.selection_changed):
            signal.connect(self.refresh)
        studio.tool_changed_signal.connect(self._show_current)
        studio.active_tool_changed.connect(self._tool_chosen)

    # --- what is there -----------------------------------------------------------------------
    def refresh(self, *_: object) -> None:
        """Show the points, lines and planes of the current model."""
        if self._studio.tool_name not in (self._tool.name, self._lines_tool.name):
            # Nobody sees it; it is brought up to date when the tool is chosen.
            return
        model = current_model(self._studio)
        points = [] if model is None else self._points_on(model)
        lines = [] if model is None else self._lines_on(model)
        readings = Readings.of(self._studio, model, lines)
        there = (model, points, lines) == (self.model, self._points, self._lines)
        if there and readings.same_as(self.readings):
            return
        known = {line.id for line in self._lines}
        same = model is not None and self.model is not None and model.id == self.model.id
        new = [
            row for row, line in enumerate(lines) if line.id not in known and not line.is_complete
        ]
        if model is None or self.model is None or model.id != self.model.id:
            with QSignalBlocker(self.field), QSignalBlocker(self.keep_scale):
                self.field.setText("" if model is None else model.frame.crs or "")
                self.keep_scale.setChecked(False)
                self.click_error.clear()
        if lines != self._lines:
            self.lines.show_lines(lines, self._studio.settings.notation)
        if points != self._points:
            self.table.show_points(points)
        self.model, self._points, self._lines = model, points, lines
        self.readings = readings
        self._solve()
        self._show_current()
        if same and len(new) == 1 and self._studio.tool_name == self._lines_tool.name:
            self.lines.ask_for_value(new[0])

    def _points_on(self, model: Model) -> list[ControlPoint]:
        return [p for p in self._studio.session.of(ControlPoint) if p.model_id == model.id]

    def _lines_on(self, model: Model) -> list[KnownLine]:
        return [line for line in self._studio.session.of(KnownLine) if line.model_id == model.id]

    def _tool_chosen(self, name: str) -> None:
        if name == self._tool.name:
            self._tool.begin()
        if name in (self._tool.name, self._lines_tool.name):
            kind = self._lines_tool.kind if name == self._lines_tool.name else ""
            self.clicked.setCurrentIndex(self.clicked.findData(kind))
            self.refresh()
            self._show_compass()

    def _choose_clicked(self) -> None:
        kind: KnownKind | str = self.clicked.currentData()
        for each, _ in KINDS:
            if each == kind:
                self._lines_tool.choose(each)
        self._studio.activate(self._lines_tool.name if kind else self._tool.name)
        self._show_compass()

    def _solve(self) -> None:
        """Place the model anew by what is ticked, and say what that is worth: at once where that is
        a matter of milliseconds, else beside the window."""
        from vomstudio.registration.surface_points import some_points
        from vomstudio.studio.placing.known_planes import compass_table
        from vomstudio.studio.placing.registering import control_pairs, place_by_points

        model = self.model
        opened = None if model is None else self._studio.models.get(model.id)
        bounds = None if opened is None else opened.data.bounds
        pairs, lines = control_pairs(self._points), tuple(self._lines)
        self._found = len(pairs.labels)
        self._reach = float(np.ptp(pairs.model, axis=0).max()) if self._found > 1 else 0.0
        compass = compass_table(lines, self.readings.seen)
        keep_scale = self.keep_scale.isChecked()
        resolution = None if opened is None else opened.resolution
        photo_up = self._photo_up(model)

        def work() -> Placed:
            if model is None:
                raise GeometryError(Finding("action.no-model"))
            extent = None if opened is None else some_points(opened.data)
            return place_by_points(
                pairs,
                bounds,
                model,
                self.crs,
                extent,
                lines,
                north.doubt_deg,
                compass,
                north.turned_deg,
                north_sigma_stated=stated,
                photo_up=photo_up,
                keep_scale=keep_scale,
                click_sigma_m=click_m,
                resolution=resolution,
            )

        self.north, self._counted = None, ""
        try:
            self.crs = self._typed_crs()
            click_m = self._typed_click_error()
            if counted(lines):
                self.north, self._counted = self.readings.counted(self._known_north)
        except VomError as error:
            self._show_compass()
            self._solving.cancel()
            self._unsolved(error)
            return
        north = self.north or ReadNorth("grid")
        said = self.readings.compass
        stated = said is not None and said.doubt_deg is not None
        self._show_compass()
        # Directions are tried one without the other, which takes a second.
        if self._found <= _FEW and compass is None:
            self._solving.run_now(work)
        else:
            # It was the placement by something else.
            self.placed = None
            self._explain_button(Finding("registration.pending"))
            self._solving.request(work)

    def _photo_up(self, model: Model | None) -> FloatArray | None:
        """As of `known_lines.photo_up`, read once for each model."""
        from vomstudio.studio.placing.known_lines import photo_up

        path = None if model is None else self._studio.project.find_model(model)
        if self._photo_up_of is None or self._photo_up_of[0] != path:
            self._photo_up_of = (path, None if path is None else photo_up(path))
        return self._photo_up_of[1]

    def _say_solving(self) -> None:
        count = self._found + len(self.readings.seen)
        self.said.setText(tr("Placing the model by {count} observations…", count=f"{count:,}"))

    def _solved(self, placed: Placed) -> None:
        self._show_click_error(placed)
        text = placement_text(placed, self.model, self.crs)
        self._show_placed(placed, "\n".join(filter(None, [text, self._counted])))
        self._explain_button(None)

    def _unsolved(self, error: VomError) -> None:
        problem = (
            cause_of(error)
            if self.model is None
            else in_short(self._points, self._lines, self._found, error, self.readings)
        )
        self._show_placed(None, problem.message)
        self._explain_button(problem)

    def _show_placed(self, placed: Placed | None, text: str) -> None:
        from vomstudio.studio.placing.registering import expected_positions

        self.placed = placed
        self.said.setText(text)
        self._show_residuals()
        self._show_map()
        places = (
            {} if self.model is None else expected_positions(self._points, self.placed, self.model)
        )
        self._tool.expect(places, _RING * self._reach * self._metres())

    def _show_residuals(self) -> None:
        from vomstudio.studio.placing.known_lines import line_residuals

        placed = self.placed
        self.table.show_residuals(self._points, placed)
        seen, turned = self.readings.seen, 0.0 if self.north is None else self.north.turned_deg
        off = [] if placed is None else line_residuals(self._lines, placed, seen, turned)
        wrong = set() if placed is None else {blunder.label for blunder in placed.blunders}
        tips = reading_tips(self._lines, self.readings, placed, turned, self._studio)
        self.lines.show_residuals(self._lines, {miss.id: miss.off for miss in off}, wrong, tips)

    def _explain_button(self, why_not: Finding | None) -> None:
        allow(self.register, why_not)
        self.copy.allow(why_not)

    def _metres(self) -> float:
        from vomstudio.geometry import transform

        return 1.0 if self.model is None else transform.scale_of(self.model.to_world)

    def _typed_crs(self) -> str | None:
        from vomstudio.io.gis.crs import metric_crs

        text = self.field.text().strip()
        return metric_crs(text, tr("CRS of x, y, z")) if text else None

    def _typed_click_error(self) -> float | None:
        from vomstudio.studio.placing.registering import parse_click_sigma

        text = self.click_error.text().strip()
        return parse_click_sigma(text, tr("Click error (m)")) if text else None

    def _show_click_error(self, placed: Placed) -> None:
        """Show the default beside which nothing was typed."""
        default = tr("half the resolution of the model, m")
        if placed.click_sigma_m and not self.click_error.text().strip():
            default = tr(
                "{error:.2g} m: half the resolution of the model", error=placed.click_sigma_m
            )
        self.click_error.setPlaceholderText(default)

    def _labels(self) -> list[str]:
        return [each.name for each in (*self._points, *self._lines)]

    def _known_north(self, compass: Compass) -> North:
        assert self.model is not None
        return known_north(self._studio, compass, self.model, self._points, self.crs)

    def _show_compass(self) -> None:
        lines_tool = self._lines_tool
        reading = self._studio.tool_name == lines_tool.name and lines_tool.selects
        self.compass.show_for(self.model, self._lines, self.north, reading=reading)
        for points_alone in (self.table, self.map):
            points_alone.setVisible(bool(self._points) or not (self._lines or reading))

    def _show_map(self) -> None:
        known = () if self.placed is None else (*self.placed.control, *self.placed.check)
        off = {p.label: (p.dx, p.dy) for p in known}
        self.map.show_points(
            [
                MapPoint(
                    p.name,
                    p.position[0],
                    p.position[1],
                    not p.check,
                    bool(p.vertices),
                    off.get(p.name),
                )
                for p in self._points
                if p.position is not None
            ],
            self.placed,
        )

    def _show_current(self, *_: object) -> None:
        current = self._tool.current
        with QSignalBlocker(self.table):
            self.table.clearSelection()
            for row in (i for i, p in enumerate(self._points) if current and p.id == current.id):
                self.table.choose_row(row)

    # --- the command -------------------------------------------------------------------------
    def _copy_command(self) -> None:
        """Ask for the table of the points, and put the command on the clipboard."""
        studio, model = self._studio, self.model
        path = None if model is None else studio.project.find_model(model)
        if path is not None:
            copy_register(
                self,
                studio,
                path,
                self._points,
                self._lines,
                self.crs,
                self.readings,
                self.north,
                kept_scale=self._metres() if self.keep_scale.isChecked() else None,
                click_sigma_m=self._typed_click_error(),
            )

    # --- what is done ------------------------------------------------------------------------
    def ask_for_points(self) -> None:
        """Let the user choose a file with coordinates."""
        model = self.model or current_model(self._studio)
        if model is None:
            self._studio.warn(Finding("action.no-model"))
            return
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Points on {model}", model=model.name),
            start_folder(self._studio),
            file_filters.tables(),
        )
        if name:
            self.take_in(model, Path(name))

    def take_in(self, model: Model, path: Path) -> None:
        """The points of a file become control points of a model."""
        from vomstudio.io.control.control_files import crs_of
        from vomstudio.io.control.observation_tables import read_points
        from vomstudio.studio.placing.registering import import_control_points

        try:
            pairs = read_points(path)
            crs = pairs.crs if np.isfinite(pairs.model).any() else crs_of(path)
        except VomError as error:
            self._studio.warn(error, "error")
            return
        if not self._studio.attempt(import_control_points, model, pairs, self._points_on(model)):
            return
        if crs:
            self.field.setText(crs)
        for note in pairs.notes:
            self._studio.warn(note.with_file(path.name))
        first = next((p.id for p in self._points if not p.vertices), "")
        self._tool.choose(first)

    def _chosen(self) -> None:
        rows = self.table.selectionModel().selectedRows()
        if rows:
            self._tool.choose(self._points[rows[0].row()].id)

    def _line_chosen(self) -> None:
        rows = self.lines.selectionModel().selectedRows()
        if rows:
            self._studio.selection.set([self._lines[rows[0].row()].id])

    def _line_typed(self, item: QTableWidgetItem) -> None:
        line = self._lines[item.row()]
        try:
            changed = typed(line, item.column(), item, self._studio.settings.notation)
        except VomError as error:
            self._studio.warn(error)
            changed = line
        if changed != line:
            self._studio.attempt(edits.change_feature, changed)
            return
        self.lines.show_lines(self._lines, self._studio.settings.notation)
        self._show_residuals()

    def _typed(self, item: QTableWidgetItem) -> None:
        point = self._points[item.row()]
        if item.column() == TICK:
            changed = replace(point, check=item.checkState() != Qt.CheckState.Checked)
        elif item.column() == LABEL:
            changed = replace(point, name=item.text().strip() or point.name)
        else:
            cells = self.table.coordinates(item.row())
            if not all(cell.strip() for cell in cells):
                return
            try:
                x, y, z = (float(cell) for cell in cells)
            except ValueError:
                self._studio.warn(Finding("number.invalid", text=item.text()))
                self.table.show_points(self._points)
                self.table.show_residuals(self._points, self.placed)
                return
            changed = replace(point, position=(x, y, z))
        if changed != point:
            self._studio.attempt(edits.change_feature, changed)

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

        before, placed = self.model, self.placed
        if before is None or placed is None:
            return
        north = None if self.north is None else used_north(self.north, self._lines)
        record = create_registration(
            placed, control_pairs(self._points), before, self.crs, read_north=north
        )
        if not self._studio.attempt(edits.set_registration, record, [before.id]):
            return
        after = self._studio.records[before.id]
        assert isinstance(after, Model)
        studio = self._studio
        measured = studio.measured(f.id for f in studio.session.features())
        points, lines = len(placed.control), len(placement_lines(self._lines))
        readings = len(placement_readings(self._lines, self.readings.seen))
        studio.info(
            Finding(
                "registration.applied",
                model=before.name,
                count=points + lines + readings,
                points=points,
                lines=lines,
                readings=readings,
                turn_deg=rotation_deg(before, after),
            )
        )
        sets = set_rotation_finding(set_rotations_deg(studio.records, before, after, measured))
        if sets is not None:
            studio.info(sets)


def _click_error_field() -> QLineEdit:
    field = QLineEdit()
    field.setObjectName("click_error")
    field.setPlaceholderText(tr("half the resolution of the model"))
    field.setToolTip(
        tr("Error of a click on the model, one sigma, beside the accuracy of the points.")
    )
    return field


def _keep_scale_box() -> QCheckBox:
    box = QCheckBox(tr("Keep the scale of the model"))
    box.setObjectName("keep_scale")
    box.setToolTip(
        tr("Its lengths are right already, as a laser scanner's are: turn and shift it only.")
    )
    return box


PANEL = ControlPanel
