"""The dock of logs: boundaries of beds along a line on the outcrop, and the thickness between."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtGui import QImage
from PySide6.QtWidgets import (
    QHBoxLayout,
    QPushButton,
    QSplitter,
    QToolButton,
)

from vomstudio.core.findings import Finding
from vomstudio.document.bed_words import describe_bed
from vomstudio.document.edit import Edit
from vomstudio.document.kinds.dimension import Dimension
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import Feature, Logged, get, get_feature
from vomstudio.document.registration_errors import model_of
from vomstudio.errors import VomError
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.notation import format_attitude
from vomstudio.geometry.units import Axes
from vomstudio.products.section.line_log import (
    BOTH,
    POINTS,
    TRACES,
    LogAnswer,
    LogQuestion,
    RockWords,
    answer,
    words_along,
)
from vomstudio.tools.measure import MeasureTool
from vomstudio.ui.analyse.group_box import SELECTED, GroupBox
from vomstudio.ui.analyse.seen_panel import SeenPanel
from vomstudio.ui.common import theme
from vomstudio.ui.common.command_targets import ask_for_target
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.qt_background import NewestResult, QtBackground
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.widgets import ComboBox, ElidedLabel, allow, narrow_form
from vomstudio.ui.forms.copied_command import CopyCommandButton, copy_with_file
from vomstudio.ui.forms.error_fields import error_field, number_in
from vomstudio.ui.forms.fitting_picture import FittingPicture
from vomstudio.ui.forms.form_beside import FormBeside
from vomstudio.ui.forms.model_axes import add_length_row, follow_axes, unit_of
from vomstudio.ui.forms.options_form import OptionFields
from vomstudio.ui.forms.taken_plane import TakenPlane
from vomstudio.ui.interpret.tool_panels.common import hint_label
from vomstudio.ui.sections.bed_log_answer import draw_figure, words_of, write, write_boundaries
from vomstudio.ui.sections.bed_log_table import BedLogTable
from vomstudio.words import tr, tr_n

_FORMATS = {"csv": "CSV", "svg": "SVG", "pdf": "PDF", "png": "PNG"}


class BedLogPanel(SeenPanel):
    """line_id : of the line along which the log runs, empty for none; answered : None where there
    is nothing to say"""

    def __init__(self, studio: Studio) -> None:
        super().__init__(studio)
        explain(self, "window.md#log")
        self.line_id = ""
        self.answered: LogAnswer | None = None
        self._picking = False
        self._drawn: LogAnswer | None = None
        self._background = QtBackground(self)
        self._asked = NewestResult(
            self, self._came, self._failed, lambda: self.said.setText(tr("Computing…"))
        )
        self.line = ElidedLabel()
        self.line.setObjectName("log_line")
        self.take = QToolButton()
        self.take.setIcon(theme.icon("cursor-default-click-outline"))
        self.take.setAccessibleName(tr("Take selected"))
        self.pick = QPushButton(theme.icon("vector-polyline"), tr("Pick…"))
        self.pick.setObjectName("log_pick")
        self.pick.setToolTip(
            tr("Click a point on each boundary, from bed to bed, then press Enter.")
        )
        self.of = ComboBox()
        self.of.setObjectName("log_of")
        for name, title in (
            (TRACES, tr("traces across the line")), (POINTS, tr("the points of the line")),
            (BOTH, tr("traces and points")),
        ):  # fmt: skip
            self.of.addItem(title, name)
        self.of.keep_narrow()
        self.group = GroupBox(studio)
        self.group.setAccessibleName(tr("Traces"))
        self.group.setToolTip(tr("Which traces are boundaries, and which tell the bedding."))
        self.reach = error_field(
            "log_reach", tr("automatic"),
            tr("How near to the line a trace has to come; by itself a twentieth of the "
               "line."),
        )  # fmt: skip
        self.bed = TakenPlane(studio, "log_bed", tr("fitted to the traces"))
        self.options = OptionFields(LogOptions, "log")
        self.said = hint_label()
        self.said.setObjectName("log_said")
        self.write = QPushButton(theme.icon("export"), tr("Write…"))
        self.copy = CopyCommandButton(
            self.copy_command, tr("keep the boundaries as a table, and copy the command")
        )
        self.table = BedLogTable()
        follow_axes(studio, self._show_axes)
        self.picture = FittingPicture()
        self._arrange()
        self._connect()
        self._show(None, "")

    def _arrange(self) -> None:
        line = QHBoxLayout()
        line.setSpacing(3)
        for part in (self.line, self.take, self.pick):
            line.addWidget(part, 1 if part is self.line else 0)
        traces = QHBoxLayout()
        traces.setSpacing(3)
        traces.addWidget(self.group, 2)
        traces.addWidget(self.reach, 1)
        form = narrow_form()
        form.addRow(tr("Line"), line)
        form.addRow(tr("Boundaries"), self.of)
        add_length_row(form, self._studio, lambda u: tr("Traces within ({unit})", unit=u), traces)
        form.addRow(tr("Bed"), self.bed)
        self.options.add_rows(form)
        buttons = QHBoxLayout()
        buttons.addWidget(self.write)
        buttons.addWidget(self.copy)
        buttons.addStretch()
        body = FormBeside(self)
        body.column.addLayout(form)
        body.column.addWidget(self.options.fields["overturned"])
        body.column.addLayout(buttons)
        body.column.addWidget(self.said)
        shown = QSplitter()
        shown.setChildrenCollapsible(False)
        shown.addWidget(self.table)
        shown.addWidget(self.picture)
        shown.setSizes([400, 150])
        shown.setStretchFactor(0, 2)
        shown.setStretchFactor(1, 1)
        self.picture.setMinimumWidth(120)
        body.put_beside(shown)

    def _show_axes(self, axes: Axes) -> None:
        self.table.show_unit(unit_of(axes))
        self.options.show_unit(unit_of(axes))

    def _connect(self) -> None:
        studio, soon = self._studio, self._soon
        self.take.clicked.connect(lambda _=False: self._take(self._selected_line()))
        self.pick.clicked.connect(lambda _=False: self._pick())
        for box in (self.of, self.group):
            box.activated.connect(soon)
        self.reach.textChanged.connect(soon)
        self.options.changed.connect(soon)
        self.bed.changed.connect(soon)
        self.table.said.connect(self._words_typed)
        self.write.clicked.connect(lambda _=False: self._ask_for_file())
        studio.project_opened.connect(self._opened)
        studio.edited.connect(self._edited)
        studio.settings_changed.connect(soon)
        studio.selection_changed.connect(lambda _: self._selected())
        studio.jobs.closed.connect(self._close)

    # --- the line ----------------------------------------------------------------------------
    def _selected_line(self) -> Feature | None:
        studio = self._studio
        current = studio.selection.current if studio.has_project else None
        found = None if current is None else get_feature(studio.records, current)
        return found if isinstance(found, Logged) and len(found.vertices) > 1 else None

    def _take(self, feature: Feature | None) -> None:
        if feature is not None:
            self.line_id = feature.id
            self._soon()

    def _pick(self) -> None:
        """The measure tool picks the boundaries; they are kept as what they are: a measured
        polyline."""
        self._studio.tool_of(MeasureTool).choose(kind="polyline")
        self._studio.activate("measure")
        self._picking = True
        self.said.setText(tr("Click a point on each boundary, then press Enter."))

    def _edited(self, edit: Edit) -> None:
        if self._picking:
            new = [get(edit.after, i, Dimension) for i in edit.after if edit.before[i] is None]
            picked = [r for r in new if r is not None and r.kind == "polyline"]
            if picked:
                self._picking = False
                self.of.setCurrentIndex(self.of.findData(POINTS))
                self._take(picked[-1])
        super()._edited(edit)

    def _selected(self) -> None:
        if self.group.choice() == SELECTED:
            self._soon()
        self._refresh()

    def _opened(self) -> None:
        """Another project."""
        self.line_id, self._picking = "", False
        self.reach.clear()
        self.options.reset()
        self._soon()

    def _words_typed(self, key: str, said: object) -> None:
        """Kept with the line, as one step that can be undone."""
        assert isinstance(said, RockWords)
        line = get_feature(self._studio.records, self.line_id)
        if line is not None and words_along(line).get(key, RockWords()) != said:
            self._studio.attempt(describe_bed, line.id, key, said.lithology, said.notes)

    # --- the question ------------------------------------------------------------------------
    def show_now(self) -> None:
        if not self._studio.has_project:
            return
        self.group.list_groups()
        if self.line_id and self.line_id not in self._studio.records:
            self.line_id = ""
        why = self._asked.answer(self._question(), answer)
        if why is None:
            self._refresh()
        else:
            self._show(None, why)

    def _question(self) -> LogQuestion | str:
        """Or why there is none."""
        studio = self._studio
        line = get_feature(studio.records, self.line_id) if self.line_id else None
        if line is None:
            return Finding("bed.no-line").message
        each = (get(studio.records, f.id, Trace) for f in self.group.features())
        traces = [trace for trace in each if trace is not None]
        measured = studio.measured({f.id for f in traces} | {line.id, self.bed.id} - {""})
        bed = measured[self.bed.id] if self.bed.id else None
        if bed is not None and bed.plane is None:
            return str(bed.problem or Finding("field.no-plane"))
        try:
            reach = number_in(self.reach, "number.not-a-length")
            options = self.options.options(bed_error_deg=None if bed is None else bed.total95_deg)
        except VomError as error:
            return error.message
        model = model_of(studio.records, line)
        return LogQuestion(
            line.id, measured[line.id], str(self.of.currentData()),
            {f.id: measured[f.id] for f in traces}, {f.id: f.name or f.id for f in traces},
            None if bed is None else bed.plane,
            options, reach, words_along(line),
            model is None or model.frame.has_metres,
            frozenset(f.id for f in traces if f.overturned),
        )  # fmt: skip

    # --- the answer --------------------------------------------------------------------------
    def _came(self, made: LogAnswer) -> None:
        self._show(made, self._result_text(made))

    def _failed(self, error: VomError) -> None:
        self._show(None, error.message)

    def _result_text(self, made: LogAnswer) -> str:
        from vomstudio.products.section.decimals import with_error

        q, total = made.question, made.log.total_m
        unit = "m" if q.metric else tr("units")
        said = [
            tr_n(
                "{count} bed, {total} {unit} across the bedding (95 %).",
                "{count} beds, {total} {unit} across the bedding (95 %).",
                len(made.log.intervals),
                total=with_error(total.value, total.error95),
                unit=unit,
            ),
            tr(
                "Bedding {bed} (95 %), points ± {sigma:.3g} {unit} (1σ).",
                bed=format_attitude(made.bed, made.bed95_deg, self._studio.settings.notation),
                sigma=made.sigma_m,
                unit=unit,
            ),
        ]
        if q.of != POINTS:
            said.append(
                tr("Traces within {reach:.3g} {unit} of the line.", reach=made.reach_m, unit=unit)
            )
        return "\n".join([*said, *map(str, made.log.warnings)])

    def _show(self, answered: LogAnswer | None, said: str) -> None:
        self.answered = answered
        self.said.setText(said)
        self.table.show_log(answered)
        self._draw()
        self._refresh()

    def _draw(self) -> None:
        answered = self._drawn = self.answered
        if answered is None:
            self.picture.show_image(QImage())
        else:
            self._background.run(partial(draw_figure, answered), partial(self._drawn_now, answered))

    def _drawn_now(self, of: LogAnswer, png: bytes) -> None:
        if of is self._drawn:
            self.picture.show_image(QImage.fromData(png))

    def _refresh(self) -> None:
        studio = self._studio
        there = self._selected_line() is not None
        self.take.setEnabled(there)
        self.take.setToolTip(
            tr("The log runs along the selected trace or polyline.")
            if there
            else tr("Select a trace or a measured polyline first.")
        )
        line = get_feature(studio.records, self.line_id) if studio.has_project else None
        self.line.setText(tr("none") if line is None else line.name or tr("the picked line"))
        self.pick.setEnabled(bool(studio.models))
        self.pick.setToolTip(
            tr("Click a point on each boundary, from bed to bed, then press Enter.")
            if studio.models
            else tr("Open a model first.")
        )
        by_points = tr("The boundaries are the points of the line.")
        allow(self.reach, by_points if self.of.currentData() == POINTS else None)
        why = None
        if self._asked.waiting:
            why = tr("the log is being computed")
        elif self.answered is None:
            why = tr("there is no log yet")
        self.write.setEnabled(why is None)
        self.write.setToolTip(
            tr("The table as CSV, or the column of beds as SVG, PDF or PNG.")
            if why is None
            else tr("Not now: {reason}", reason=why)
        )
        self.copy.allow(why)

    # --- what is taken away ------------------------------------------------------------------
    def _ask_for_file(self) -> None:
        title = tr("Write the log")
        path = ask_for_target(self, self._studio, title, "log.csv", _FORMATS)
        if path is not None:
            self.write_to(path)

    def write_to(self, path: Path) -> None:
        """The log that is shown, in a thread."""
        if self.answered is not None:
            said = tr("The log was written to {file}.", file=path)
            studio = self._studio
            work = partial(write, self.answered, path)
            self._background.run(work, lambda _: studio.info(said), studio.fail)

    def copy_command(self) -> None:
        """Ask for the table of the boundaries, and put the command on the clipboard."""
        answered = self.answered
        if answered is not None:
            copy_with_file(
                self, self._studio, "boundaries.csv", partial(write_boundaries, answered),
                partial(words_of, answered),
            )  # fmt: skip

    def _close(self) -> None:
        self._timer.stop()
        self._asked.close()
        self._background.stop()
