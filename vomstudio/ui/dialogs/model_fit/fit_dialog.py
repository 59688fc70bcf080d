"""Dialog that fits one model to another by clicked points and by surfaces."""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QDialog,
    QGridLayout,
    QHBoxLayout,
    QPushButton,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.registration.results import ModelPlacement
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.registration_tasks import FIT_TO_REFERENCE, FitRequest, FittedModel
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import LatestRequestRunner, QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.dialogs.model_fit.fit_command import FitCopyButton
from vomstudio.ui.dialogs.model_fit.pair_table import (
    PairTable,
    fit_summary,
    placement_summary,
)
from vomstudio.ui.dialogs.model_fit.picking_view import PickingView
from vomstudio.ui.dialogs.model_fit.point_pairs import PointPairs
from vomstudio.ui.dialogs.model_fit.stable_part import StablePartBox
from vomstudio.ui.widgets.other_model_box import OtherModel, OtherModelBox, project_model

MIN_PAIRS = 3
"""Minimum number of point pairs required to place a model."""
_MAX_IMMEDIATE_POINTS = 20
"""Maximum number of points solved immediately; starting a thread would take longer."""


class FitDialog(QDialog):
    """Dialog that fits a model to a reference, with the same points clicked in both views.

    `placement` is computed from the points alone, and `fit_result` from points and surfaces.
    Registering the model is a single edit.
    """

    def __init__(self, parent: QWidget, studio: Studio, model: Model) -> None:
        super().__init__(parent)
        set_help_topic(self, "registration.md#one-model-by-another")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.setWindowTitle(tr("Fit {model}", model=model.name))
        self.resize(1240, 800)
        self._studio, self._model_id = studio, model.id
        self.points = PointPairs()
        self.placement: ModelPlacement | None = None
        self.fit_result: FittedModel | None = None
        self._problem: Finding | None = None
        self._job: RunningJob | None = None
        self._background = QtBackground(self)
        self._solver = LatestRequestRunner(
            self,
            self._show_placement,
            self._show_problem,
            lambda: self.message.setText(tr("Solving…")),
        )
        self.other = OtherModelBox(studio, model.id)
        self.stable = StablePartBox(studio, model.id)
        self.model_view, self.reference_view = PickingView(), PickingView()
        self._arrange_widgets(model)
        self._connect_signals()
        self.model_view.show_model(project_model(studio, model))
        self._use_reference()

    # --- widgets -----------------------------------------------------------------------------
    def _arrange_widgets(self, model: Model) -> None:
        views = QSplitter()
        self._titles = []
        for view, title in ((self.model_view, model.name), (self.reference_view, "")):
            side_widget = QWidget()
            column = QVBoxLayout(side_widget)
            column.setContentsMargins(0, 0, 0, 0)
            label = Label(title)
            self._titles.append(label)
            column.addWidget(label)
            column.addWidget(view, 1)
            views.addWidget(side_widget)
        views.setChildrenCollapsible(False)
        self.instruction = Label()
        self.instruction.setObjectName("fit_step")
        self.table = PairTable()
        self.undo_button = QPushButton(theme.icon("undo"), tr("Undo"))
        self.redo_button = QPushButton(theme.icon("redo"), tr("Redo"))
        self.remove_button = QPushButton(theme.icon("delete-outline"), tr("Remove point"))
        self.fit_button = QPushButton(theme.icon("vector-combine"), tr("Fit surfaces"))
        self.register_button = QPushButton(theme.icon("check"), tr("Register"))
        self.close_button = QPushButton(tr("Close"))
        self.copy_button = FitCopyButton(
            studio=self._studio,
            stable_part_box=self.stable,
            points=self.points,
            find_model=self._find_model,
            reference_view=self.reference_view,
        )
        buttons = (
            self.undo_button,
            self.redo_button,
            self.remove_button,
            self.fit_button,
            self.register_button,
            self.close_button,
        )
        for button in buttons:
            # Enter in a field must not close the dialog.
            button.setAutoDefault(False)
        self.message = Label()
        self.message.setObjectName("fit_said")
        self.message.setWordWrap(True)
        self.message.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.message.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        edit_row = QHBoxLayout()
        for button in buttons[:3]:
            edit_row.addWidget(button)
        left_column = QVBoxLayout()
        left_column.addWidget(self.table, 1)
        left_column.addLayout(edit_row)
        form = QGridLayout()
        form.addWidget(Label(tr("Fitted to")), 0, 0)
        form.addWidget(self.other, 0, 1)
        form.addWidget(Label(tr("Stable part")), 1, 0)
        form.addWidget(self.stable, 1, 1)
        form.setColumnStretch(1, 1)
        button_row = QHBoxLayout()
        for widget in (self.fit_button, self.copy_button, self.register_button, self.close_button):
            button_row.addWidget(widget)
        button_row.insertStretch(2)
        right_column = QVBoxLayout()
        right_column.addLayout(form)
        right_column.addWidget(self.message, 1)
        right_column.addLayout(button_row)
        bottom_row = QHBoxLayout()
        bottom_row.addLayout(left_column, 2)
        bottom_row.addLayout(right_column, 3)
        column = QVBoxLayout(self)
        column.addWidget(self.instruction)
        column.addWidget(views, 1)
        column.addLayout(bottom_row)

    def _connect_signals(self) -> None:
        self.model_view.picked.connect(lambda point: self._add_click(point, is_model=True))
        self.reference_view.picked.connect(lambda point: self._add_click(point, is_model=False))
        for view in (self.model_view, self.reference_view):
            view.problem.connect(self.message.setText)
        self.other.model_changed.connect(self._use_reference)
        self.other.status_changed.connect(self.message.setText)
        self.stable.changed.connect(self._handle_stable_change)
        self.stable.message.connect(self.message.setText)
        self.undo_button.clicked.connect(self._undo_click)
        self.redo_button.clicked.connect(self._redo_click)
        self.remove_button.clicked.connect(self._remove_pair)
        self.fit_button.clicked.connect(self._fit_or_stop)
        self.register_button.clicked.connect(self.accept)
        self.close_button.clicked.connect(self.reject)
        self.table.itemSelectionChanged.connect(self._refresh_buttons)
        for key, callback in (
            (QKeySequence.StandardKey.Undo, self._undo_click),
            (QKeySequence.StandardKey.Redo, self._redo_click),
            (QKeySequence.StandardKey.Delete, self._remove_pair),
        ):
            QShortcut(QKeySequence(key), self).activated.connect(callback)
        studio = self._studio
        studio.edited.connect(self._handle_edit)
        self._disconnect_jobs = studio.jobs.closed.connect(self.reject)

    # --- points ------------------------------------------------------------------------------
    @property
    def reference(self) -> OtherModel | None:
        """Reference model, or None if no usable model is selected."""
        return self.reference_view.model

    def _find_model(self) -> Model | None:
        record = self._studio.records.get(self._model_id)
        return record if isinstance(record, Model) else None

    def _use_reference(self, *_: object) -> None:
        if self._job is not None:
            # The job uses another reference, or the same reference at another position.
            self._studio.jobs.cancel(self._job)
            self._job = None
        reference = self.other.current()
        problem = None
        if reference is not None and not reference.frame.has_north:
            problem = Finding("registration.reference-undeclared", model=reference.name)
            reference = None
        self.reference_view.show_model(reference)
        self._titles[1].setText(
            tr("No reference selected") if reference is None else self._reference_title(reference)
        )
        self.points.clear()
        self._update_placement()
        if problem is not None:
            self.message.setText(problem.message)

    def _reference_title(self, reference: OtherModel) -> str:
        return tr("{model} ({frame})", model=reference.name, frame=reference.frame.name())

    def _add_click(self, point: FloatArray, *, is_model: bool) -> None:
        if self.reference is None or self._job is not None:
            return
        if not is_model:
            point = transform.apply(transform.matrix(self.reference.to_world), point[None])[0]
        self.points.click(point, is_model=is_model)
        self._update_placement()

    def _undo_click(self) -> None:
        if self._job is None:
            self.points.undo()
            self._update_placement()

    def _redo_click(self) -> None:
        if self._job is None:
            self.points.redo()
            self._update_placement()

    def _remove_pair(self) -> None:
        row = self.table.selected_row()
        if row is not None and self._job is None:
            self.points.remove(self.points.pairs[row].label)
            self._update_placement()

    def _handle_stable_change(self) -> None:
        self.fit_result = None
        self._show_pairs()

    def _handle_edit(self, *_: object) -> None:
        """Reset the reference if an edit moved or removed it; close if the model was removed."""
        model, reference = self._find_model(), self.reference
        if model is None:
            self.reject()
        elif reference is not None and reference.id:
            current_reference = self._studio.records.get(reference.id)
            if (
                not isinstance(current_reference, Model)
                or current_reference.placement != reference.placement
            ):
                self._use_reference()

    # --- results -----------------------------------------------------------------------------
    def _update_placement(self) -> None:
        """Compute the placement from the current points, and discard the surface fit."""
        from vomstudio.registration.surface_points import sample_points
        from vomstudio.studio.placing.registering import place_by_points

        self.placement = self.fit_result = self._problem = None
        model, reference = self._find_model(), self.reference
        pairs = self.points.to_pairs()
        if model is None or reference is None or len(pairs.labels) < 3:
            self._solver.cancel()
            self._show_pairs()
            return
        open_model = self._studio.models.get(model.id)
        bounds = None if open_model is None else open_model.data.bounds
        crs = reference.to_placed_model(self._studio.project.cache).crs

        def solve() -> ModelPlacement:
            extent = None if open_model is None else sample_points(open_model.data)
            return place_by_points(pairs, bounds, model, crs, extent)

        if len(pairs.labels) <= _MAX_IMMEDIATE_POINTS:
            self._solver.run_now(solve)
        else:
            self._show_pairs()
            self._solver.request(solve)

    def _show_placement(self, placement: ModelPlacement) -> None:
        self.placement, self._problem = placement, None
        self._show_pairs()

    def _show_problem(self, error: VomError) -> None:
        self.placement, self._problem = None, to_finding(error)
        self._show_pairs()

    def _show_pairs(self) -> None:
        placement = self.fit_result.placed if self.fit_result is not None else self.placement
        self.table.show_pairs(self.points.pairs, placement)
        self._show_marks()
        if self._job is None:
            self.message.setText(self._result_text())
        self._refresh_buttons()

    def _show_marks(self) -> None:
        reference = self.reference
        points = self.points
        model_point = None if points.model_point is None else np.array(points.model_point)
        reference_point = (
            None if points.reference_point is None else np.array(points.reference_point)
        )
        expected_model_point = expected_reference_point = None
        if self.placement is not None:
            matrix = np.array(self.placement.matrix)
            if model_point is not None:
                expected_reference_point = transform.apply(matrix, model_point[None])[0]
            elif reference_point is not None:
                expected_model_point = transform.apply(
                    transform.invert(matrix), reference_point[None]
                )[0]
        marks = {pair.label: np.array(pair.model) for pair in points.pairs}
        self.model_view.show_marks(marks, model_point, expected_model_point)
        if reference is None:
            return
        reference_matrix = transform.invert(transform.matrix(reference.to_world))

        def to_reference(point: FloatArray | None) -> FloatArray | None:
            return None if point is None else transform.apply(reference_matrix, point[None])[0]

        marks = {
            p.label: transform.apply(reference_matrix, np.array([p.reference_point]))[0]
            for p in points.pairs
        }
        self.reference_view.show_marks(
            marks, to_reference(reference_point), to_reference(expected_reference_point)
        )

    def _result_text(self) -> str:
        if self._problem is not None:
            return self._problem.message
        if self.fit_result is not None:
            return fit_summary(self.fit_result, self._create_record())
        return "" if self.placement is None else placement_summary(self.placement)

    # --- buttons -----------------------------------------------------------------------------
    def _refresh_buttons(self) -> None:
        points, is_busy = self.points, self._job is not None
        busy_finding = Finding("action.busy") if is_busy else None
        set_enabled(
            self.undo_button,
            busy_finding or (None if points.can_undo else Finding("edit.nothing-to-undo")),
        )
        set_enabled(
            self.redo_button,
            busy_finding or (None if points.can_redo else Finding("edit.nothing-to-redo")),
        )
        has_row = self.table.selected_row() is not None
        set_enabled(
            self.remove_button, busy_finding or (None if has_row else Finding("action.no-row"))
        )
        self.fit_button.setText(tr("Stop") if is_busy else tr("Fit surfaces"))
        set_enabled(self.fit_button, None if is_busy else self._fit_problem())
        missing_result_finding = (
            None if self.fit_result is not None else Finding("action.not-computed")
        )
        set_enabled(self.register_button, busy_finding or missing_result_finding)
        self.copy_button.refresh(busy_finding)
        for box in (self.other, self.stable):
            set_enabled(box, busy_finding)
        self.instruction.setText(self._next_step().message)

    def _next_step(self) -> Finding:
        if self.reference is None:
            return Finding("fit.choose-reference")
        if self._job is not None:
            return Finding("fit.running")
        if self.points.model_point is not None:
            return Finding("fit.click-right")
        if self.points.reference_point is not None:
            return Finding("fit.click-left")
        if self.fit_result is not None:
            return Finding("fit.finished")
        if len(self.points.pairs) < MIN_PAIRS:
            return Finding("fit.click-pairs", minimum=MIN_PAIRS)
        return Finding("fit.ready")

    def _fit_problem(self) -> Finding | None:
        if self.reference is None:
            return Finding("action.no-other-model")
        count = len(self.points.pairs)
        if count >= MIN_PAIRS and self.placement is None:
            return self._problem or Finding("action.busy")
        return self.stable.disabled_reason(self.points.pairs)

    # --- surface fit -------------------------------------------------------------------------
    def _fit_or_stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)
            return
        model, reference = self._find_model(), self.reference
        fitted_model = None if model is None else project_model(self._studio, model)
        if fitted_model is None or model is None or reference is None:
            self.message.setText(Finding("model.not-open").message)
            return
        cache = self._studio.project.cache
        self.fit_result = None
        self.message.setText(tr("Fitting the surfaces…"))
        request = FitRequest(
            model=fitted_model.to_placed_model(cache),
            reference=reference.to_placed_model(cache),
            scale=not model.frame.has_metres,
            pairs=self.points.pairs,
            stable=self.stable.selected_part(self.points.pairs),
        )

        def handle_end(result: FittedModel | Failed) -> None:
            if self._job is not None and self._job.number == job.number:
                self._job = None
                self._show_fit(result)

        job = self._job = self._studio.jobs.submit(
            FIT_TO_REFERENCE,
            request,
            title=tr("Fitting {model} to {other}", model=model.name, other=reference.name),
            on_done=self._background.guard(handle_end),
            on_failed=self._background.guard(handle_end),
        )
        self._refresh_buttons()

    def _show_fit(self, result: FittedModel | Failed) -> None:
        self.fit_result = result if isinstance(result, FittedModel) else None
        self._show_pairs()
        if isinstance(result, Failed):
            self.message.setText(
                str(Finding("job.stopped")) if result.cancelled else result.message
            )

    def _create_record(self) -> Registration | None:
        """Return the registration with the error of the reference, or None before a fit."""
        from vomstudio.studio.placing.registering import add_reference_error, create_registration

        model, reference = self._find_model(), self.reference
        if model is None or reference is None or self.fit_result is None:
            return None
        pairs = self.points.to_pairs() if self.points.pairs else None
        crs = reference.to_placed_model(self._studio.project.cache).crs
        record = create_registration(self.fit_result.placed, pairs, model, crs, reference.name)
        return add_reference_error(
            record, reference.registration, scale_fitted=not model.frame.has_metres
        )

    def accept(self) -> None:
        """Register the model with the surface fit, and close."""
        from vomstudio.studio.placing.registering import (
            rotation_deg,
            set_rotation_finding,
            set_rotations_deg,
        )

        studio, model_before, reference = self._studio, self._find_model(), self.reference
        if model_before is None or reference is None or self.fit_result is None:
            return
        record = self._create_record()
        if record is None or not studio.attempt(edits.set_registration, record, [model_before.id]):
            return
        model_after = studio.records[model_before.id]
        assert isinstance(model_after, Model)
        measurements = studio.measured(f.id for f in studio.session.features())
        turn_deg = rotation_deg(model_before, model_after)
        names = {"model": model_before.name, "other": reference.name}
        studio.info(Finding("registration.fitted", **names, turn_deg=turn_deg))
        set_rotations = set_rotations_deg(studio.records, model_before, model_after, measurements)
        if (finding := set_rotation_finding(set_rotations)) is not None:
            studio.info(finding)
        super().accept()

    def done(self, result: int) -> None:
        """Close the dialog and free the graphics memory of both views."""
        with ExitStack() as steps:
            steps.callback(super().done, result)
            if self._background.is_stopped:
                return
            for view in (self.reference_view, self.model_view):
                steps.callback(view.shutdown)
            if self._job is not None:
                steps.callback(self._studio.jobs.cancel, self._job)
            for box in (self.stable, self.other):
                steps.callback(box.cancel_reading)
            for close_step in (self._solver.close, self._background.stop, self._disconnect_jobs):
                steps.callback(close_step)
