"""One model fitted to another: the same points clicked in two views side by side, then the
surfaces."""

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
from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.registration.results import Placed
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.registration_tasks import FIT_TO_REFERENCE, FitRequest, FittedModel
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.qt_background import NewestResult, QtBackground
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

_FEW = 20
"""So many points are solved in less time than a thread takes to hand over."""


class FitDialog(QDialog):
    """placed : by the clicked points alone; fitted : by the surfaces too. Register is one edit."""

    def __init__(self, parent: QWidget, studio: Studio, model: Model) -> None:
        super().__init__(parent)
        explain(self, "registration.md#one-model-by-another")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.setWindowTitle(tr("Fit {model} to another model", model=model.name))
        self.resize(1240, 800)
        self._studio, self._model_id = studio, model.id
        self.points = PointPairs()
        self.placed: Placed | None = None
        self.fitted: FittedModel | None = None
        self._problem: Finding | None = None
        self._job: RunningJob | None = None
        self._background = QtBackground(self)
        self._solving = NewestResult(
            self, self._solved, self._unsolved, lambda: self.said.setText(tr("Solving…"))
        )
        self.other = OtherModelBox(studio, model.id)
        self.stable = StablePartBox(studio, model.id)
        self.here, self.there = PickingView(), PickingView()
        self._arrange(model)
        self._connect()
        self.here.show_model(project_model(studio, model))
        self._reference_chosen()

    # --- parts -------------------------------------------------------------------------------
    def _arrange(self, model: Model) -> None:
        sides = QSplitter()
        self._titles = []
        for view, title in ((self.here, model.name), (self.there, "")):
            side = QWidget()
            column = QVBoxLayout(side)
            column.setContentsMargins(0, 0, 0, 0)
            label = Label(title)
            self._titles.append(label)
            column.addWidget(label)
            column.addWidget(view, 1)
            sides.addWidget(side)
        sides.setChildrenCollapsible(False)
        self.step = Label()
        self.step.setObjectName("fit_step")
        self.table = PairTable()
        self.undo = QPushButton(theme.icon("undo"), tr("Undo"))
        self.redo = QPushButton(theme.icon("redo"), tr("Redo"))
        self.remove = QPushButton(theme.icon("delete-outline"), tr("Remove point"))
        self.fit = QPushButton(theme.icon("vector-combine"), tr("Fit the surfaces"))
        self.register = QPushButton(theme.icon("check"), tr("Register"))
        self.close_ = QPushButton(tr("Close"))
        self.copy = FitCopyButton(self._studio, self.stable, self.points, self._model, self.there)
        buttons = (self.undo, self.redo, self.remove, self.fit, self.register, self.close_)
        for button in buttons:
            # Enter in a field is no wish to leave.
            button.setAutoDefault(False)
        self.said = Label()
        self.said.setObjectName("fit_said")
        self.said.setWordWrap(True)
        self.said.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.said.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        edit = QHBoxLayout()
        for button in buttons[:3]:
            edit.addWidget(button)
        left = QVBoxLayout()
        left.addWidget(self.table, 1)
        left.addLayout(edit)
        form = QGridLayout()
        form.addWidget(Label(tr("Fitted to")), 0, 0)
        form.addWidget(self.other, 0, 1)
        form.addWidget(Label(tr("Stable part")), 1, 0)
        form.addWidget(self.stable, 1, 1)
        form.setColumnStretch(1, 1)
        last = QHBoxLayout()
        for each in (self.fit, self.copy, self.register, self.close_):
            last.addWidget(each)
        last.insertStretch(2)
        right = QVBoxLayout()
        right.addLayout(form)
        right.addWidget(self.said, 1)
        right.addLayout(last)
        below = QHBoxLayout()
        below.addLayout(left, 2)
        below.addLayout(right, 3)
        column = QVBoxLayout(self)
        column.addWidget(self.step)
        column.addWidget(sides, 1)
        column.addLayout(below)

    def _connect(self) -> None:
        self.here.picked.connect(lambda place: self._clicked(place, on_model=True))
        self.there.picked.connect(lambda place: self._clicked(place, on_model=False))
        for view in (self.here, self.there):
            view.problem.connect(self.said.setText)
        self.other.model_changed.connect(self._reference_chosen)
        self.other.status_changed.connect(self.said.setText)
        self.stable.changed.connect(self._stable_changed)
        self.stable.said.connect(self.said.setText)
        self.undo.clicked.connect(self._undo)
        self.redo.clicked.connect(self._redo)
        self.remove.clicked.connect(self._remove)
        self.fit.clicked.connect(self._fit_or_stop)
        self.register.clicked.connect(self.accept)
        self.close_.clicked.connect(self.reject)
        self.table.itemSelectionChanged.connect(self._explain_buttons)
        for key, call in (
            (QKeySequence.StandardKey.Undo, self._undo),
            (QKeySequence.StandardKey.Redo, self._redo),
            (QKeySequence.StandardKey.Delete, self._remove),
        ):
            QShortcut(QKeySequence(key), self).activated.connect(call)
        studio = self._studio
        studio.project_opened.connect(self.reject)
        studio.edited.connect(self._edited)
        self._forget_jobs = studio.jobs.closed.connect(self.reject)

    # --- what is clicked ---------------------------------------------------------------------
    @property
    def reference(self) -> OtherModel | None:
        """What the model is fitted to."""
        return self.there.model

    def _model(self) -> Model | None:
        record = self._studio.records.get(self._model_id)
        return record if isinstance(record, Model) else None

    def _reference_chosen(self, *_: object) -> None:
        if self._job is not None:
            # It was for another one, or for another place of it.
            self._studio.jobs.cancel(self._job)
            self._job = None
        found = self.other.current()
        why = None
        if found is not None and not found.frame.has_north:
            why = Finding("registration.reference-undeclared", model=found.name)
            found = None
        self.there.show_model(found)
        self._titles[1].setText(
            tr("Nothing to fit it to yet") if found is None else self._titled(found)
        )
        self.points.clear()
        self._changed()
        if why is not None:
            self.said.setText(why.message)

    def _titled(self, found: OtherModel) -> str:
        return tr("{model} ({frame})", model=found.name, frame=found.frame.name())

    def _clicked(self, place: FloatArray, *, on_model: bool) -> None:
        if self.reference is None or self._job is not None:
            return
        if not on_model:
            place = transform.apply(transform.matrix(self.reference.to_world), place[None])[0]
        self.points.click(place, on_model=on_model)
        self._changed()

    def _undo(self) -> None:
        if self._job is None:
            self.points.undo()
            self._changed()

    def _redo(self) -> None:
        if self._job is None:
            self.points.redo()
            self._changed()

    def _remove(self) -> None:
        row = self.table.chosen()
        if row is not None and self._job is None:
            self.points.remove(self.points.pairs[row].label)
            self._changed()

    def _stable_changed(self) -> None:
        self.fitted = None
        self._show()

    def _edited(self, *_: object) -> None:
        """Another one may have been moved or taken away meanwhile."""
        model, reference = self._model(), self.reference
        if model is None:
            self.reject()
        elif reference is not None and reference.id:
            now = self._studio.records.get(reference.id)
            if not isinstance(now, Model) or now.placement != reference.placement:
                self._reference_chosen()

    # --- what comes of it --------------------------------------------------------------------
    def _changed(self) -> None:
        """Other points: place the model by them, and what was fitted is no more."""
        from vomstudio.registration.surface_points import some_points
        from vomstudio.studio.placing.registering import place_by_points

        self.placed = self.fitted = self._problem = None
        model, reference = self._model(), self.reference
        pairs = self.points.as_pairs()
        if model is None or reference is None or len(pairs.labels) < 3:
            self._solving.cancel()
            self._show()
            return
        opened = self._studio.models.get(model.id)
        bounds = None if opened is None else opened.data.bounds
        crs = reference.to_placed_model(self._studio.project.cache).crs

        def work() -> Placed:
            extent = None if opened is None else some_points(opened.data)
            return place_by_points(pairs, bounds, model, crs, extent)

        if len(pairs.labels) <= _FEW:
            self._solving.run_now(work)
        else:
            self._show()
            self._solving.request(work)

    def _solved(self, placed: Placed) -> None:
        self.placed, self._problem = placed, None
        self._show()

    def _unsolved(self, error: VomError) -> None:
        self.placed, self._problem = None, finding_of(error)
        self._show()

    def _show(self) -> None:
        placed = self.fitted.placed if self.fitted is not None else self.placed
        self.table.show_pairs(self.points.pairs, placed)
        self._show_marks()
        if self._job is None:
            self.said.setText(self._result_text())
        self._explain_buttons()

    def _show_marks(self) -> None:
        reference = self.reference
        points = self.points
        here = None if points.here is None else np.array(points.here)
        there = None if points.there is None else np.array(points.there)
        should_here = should_there = None
        if self.placed is not None:
            matrix = np.array(self.placed.matrix)
            if here is not None:
                should_there = transform.apply(matrix, here[None])[0]
            elif there is not None:
                should_here = transform.apply(transform.invert(matrix), there[None])[0]
        marks = {pair.label: np.array(pair.model) for pair in points.pairs}
        self.here.show_marks(marks, here, should_here)
        if reference is None:
            return
        back = transform.invert(transform.matrix(reference.to_world))

        def own(place: FloatArray | None) -> FloatArray | None:
            return None if place is None else transform.apply(back, place[None])[0]

        marks = {p.label: transform.apply(back, np.array([p.there]))[0] for p in points.pairs}
        self.there.show_marks(marks, own(there), own(should_there))

    def _result_text(self) -> str:
        if self._problem is not None:
            return self._problem.message
        if self.fitted is not None:
            return fit_summary(self.fitted, self._record())
        return "" if self.placed is None else placement_summary(self.placed)

    # --- buttons -----------------------------------------------------------------------------
    def _explain_buttons(self) -> None:
        points, busy = self.points, self._job is not None
        wait = Finding("action.busy") if busy else None
        allow(self.undo, wait or (None if points.can_undo else Finding("edit.nothing-to-undo")))
        allow(self.redo, wait or (None if points.can_redo else Finding("edit.nothing-to-redo")))
        chosen = self.table.chosen() is not None
        allow(self.remove, wait or (None if chosen else Finding("action.no-row")))
        self.fit.setText(tr("Stop") if busy else tr("Fit the surfaces"))
        allow(self.fit, None if busy else self._why_no_fit())
        none = None if self.fitted is not None else Finding("action.not-computed")
        allow(self.register, wait or none)
        self.copy.refresh(wait)
        for part in (self.other, self.stable):
            allow(part, wait)
        self.step.setText(self._next_step())

    def _next_step(self) -> str:
        if self.reference is None:
            return tr(
                "Choose what the model is fitted to: another model of the project, or a file."
            )
        if self._job is not None:
            return tr("The surfaces are being fitted.")
        if self.points.here is not None:
            return tr("Click the same point on the right.")
        if self.points.there is not None:
            return tr("Click the same point on the left.")
        if self.fitted is not None:
            return tr("Register the model by this fit, or click more points and fit it again.")
        if len(self.points.pairs) < 3:
            return tr(
                "Click a point on the left and the same one on the right; three or more, far "
                "apart and not on a line. Where the model lies on the other one already, fewer "
                "will do, or none."
            )
        return tr(
            "Fit the surfaces, or click more points; where the counterpart should be is ringed."
        )

    def _why_no_fit(self) -> Finding | None:
        if self.reference is None:
            return Finding("action.no-other-model")
        count = len(self.points.pairs)
        if count >= 3 and self.placed is None:
            return self._problem or Finding("action.busy")
        return self.stable.why_not(self.points.pairs)

    # --- the fit -----------------------------------------------------------------------------
    def _fit_or_stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)
            return
        model, reference = self._model(), self.reference
        own = None if model is None else project_model(self._studio, model)
        if own is None or model is None or reference is None:
            self.said.setText(Finding("model.not-open").message)
            return
        cache = self._studio.project.cache
        self.fitted = None
        self.said.setText(tr("Fitting the surfaces…"))
        order = FitRequest(
            own.to_placed_model(cache),
            reference.to_placed_model(cache),
            not model.frame.has_metres,
            self.points.pairs,
            self.stable.part(self.points.pairs),
        )

        def ended(made: FittedModel | Failed) -> None:
            if self._job is not None and self._job.number == job.number:
                self._job = None
                self._came(made)

        job = self._job = self._studio.jobs.submit(
            FIT_TO_REFERENCE,
            order,
            title=tr("Fitting {model} to {other}", model=model.name, other=reference.name),
            on_done=self._background.guard(ended),
            on_failed=self._background.guard(ended),
        )
        self._explain_buttons()

    def _came(self, made: FittedModel | Failed) -> None:
        self.fitted = made if isinstance(made, FittedModel) else None
        self._show()
        if isinstance(made, Failed):
            self.said.setText(str(Finding("job.stopped")) if made.cancelled else made.message)

    def _record(self) -> Registration | None:
        """What was found, with the error of what the model was fitted to."""
        from vomstudio.studio.placing.registering import add_reference_error, create_registration

        model, reference = self._model(), self.reference
        if model is None or reference is None or self.fitted is None:
            return None
        pairs = self.points.as_pairs() if self.points.pairs else None
        crs = reference.to_placed_model(self._studio.project.cache).crs
        record = create_registration(self.fitted.placed, pairs, model, crs, reference.name)
        return add_reference_error(
            record, reference.registration, scale_fitted=not model.frame.has_metres
        )

    def accept(self) -> None:
        """Register the model by what was found."""
        from vomstudio.studio.placing.registering import (
            rotation_deg,
            set_rotation_finding,
            set_rotations_deg,
        )

        studio, before, reference = self._studio, self._model(), self.reference
        if before is None or reference is None or self.fitted is None:
            return
        record = self._record()
        if record is None or not studio.attempt(edits.set_registration, record, [before.id]):
            return
        after = studio.records[before.id]
        assert isinstance(after, Model)
        measured = studio.measured(f.id for f in studio.session.features())
        turn_deg = rotation_deg(before, after)
        names = {"model": before.name, "other": reference.name}
        studio.info(Finding("registration.fitted", **names, turn_deg=turn_deg))
        turned = set_rotations_deg(studio.records, before, after, measured)
        if (sets := set_rotation_finding(turned)) is not None:
            studio.info(sets)
        super().accept()

    def done(self, result: int) -> None:
        """However it is closed: what both views hold in the graphics memory is freed at once."""
        with ExitStack() as steps:
            steps.callback(super().done, result)
            if self._background.is_stopped:
                return
            for view in (self.there, self.here):
                steps.callback(view.shutdown)
            if self._job is not None:
                steps.callback(self._studio.jobs.cancel, self._job)
            for part in (self.stable, self.other):
                steps.callback(part.close_reading)
            for close in (self._solving.close, self._background.stop, self._forget_jobs):
                steps.callback(close)
