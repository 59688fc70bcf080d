"""The dock of facets: near-planar pieces of the outcrop, proposed, accepted or rejected."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtGui import QIcon, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QProgressBar,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QWidget,
)

from vomstudio.document import catalogue
from vomstudio.document.records import Model
from vomstudio.extraction.facet_options import DEFAULT_ANGLE_DEG, FacetOptions
from vomstudio.geology.agreement_both_ways import agreement_both_ways
from vomstudio.geometry.patches import has_id
from vomstudio.geometry.units import Axes
from vomstudio.tools.interaction_types import Hit, Preview
from vomstudio.tools.painted_area import area_of
from vomstudio.ui.analyse.seen_panel import SeenPanel
from vomstudio.ui.common import theme
from vomstudio.ui.common.command_targets import current_model
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.number_formatting import area as area_text
from vomstudio.ui.common.number_formatting import degrees
from vomstudio.ui.common.number_table import Column, NumberTable
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.type_box import TypeBox
from vomstudio.ui.common.widgets import ComboBox, Label
from vomstudio.ui.forms.copied_command import CopyCommandButton
from vomstudio.ui.forms.model_axes import axes_of, follow_axes, unit_of
from vomstudio.ui.forms.options_form import OptionFields
from vomstudio.ui.interpret.measured_planes import measured_planes, planes_of
from vomstudio.ui.interpret.tool_panels.common import hint_label, narrow_column
from vomstudio.ui.surface.facet_words import (
    agreement_in_words,
    share_in_words,
    summary_in_words,
)
from vomstudio.ui.surface.facets_command import copy_facets
from vomstudio.ui.surface.part_in_view import part_in_view
from vomstudio.words import to_translate, tr
from vomstudio.workspace.surfaces.facet_proposals import Proposals

_LIVE_MS = 350
_LEAST_HEIGHT = 200
_LEAST_WIDTH = 50
_DOUBT = {"good": 0, "doubtful": 1, "poor": 2, None: 3}
_VERDICTS = {
    "good": to_translate("good"),
    "doubtful": to_translate("doubtful"),
    "poor": to_translate("poor"),
}
_COLOURS = {
    "label": to_translate("Colours by facet"),
    "dip direction": to_translate("Colours by dip direction"),
    "error": to_translate("Colours by 95 % error"),
    "exposure": to_translate("Colours by exposure"),
}


class FacetsPanel(SeenPanel):
    """Asks `facet_proposals`; nothing is changed before something is accepted."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(studio)
        explain(self, "conventions.md#facets-proposed")
        self._facets = studio.facets
        self._model: Model | None = None
        self._filled: tuple[Proposals | None, int] = (None, 0)
        self._live = QTimer(self)
        self._live.setSingleShot(True)
        self._live.setInterval(_LIVE_MS)
        self._live.timeout.connect(self._try_part)
        self._make_limits()
        self._make_list()
        self._arrange()
        for signal in (studio.project_opened, studio.model_loaded, studio.selection_changed):
            signal.connect(self._soon)
        studio.edited.connect(self._soon)
        studio.jobs_changed.connect(self._show_progress)
        studio.surface_clicked.connect(self._clicked)
        self._facets.changed.connect(self.refresh)
        self.show_now()

    # --- parts -------------------------------------------------------------------------------
    def _make_limits(self) -> None:
        self.title = hint_label()
        self.limits = OptionFields(FacetOptions, "facet", FacetOptions(angle_deg=DEFAULT_ANGLE_DEG))
        self.limits.changed.connect(self._limits_changed)
        follow_axes(self._studio, self._show_axes)
        self.live = QCheckBox(tr("Try on the part in view"))
        self.live.setObjectName("facet_live")
        self.live.setToolTip(
            tr("Every change of a threshold is shown on a part in the middle of the view.")
        )
        self.live.clicked.connect(lambda on: self._live.start() if on else None)
        self.start = QPushButton(theme.icon("vector-polygon"), tr("Find on all"))
        self.start.setObjectName("facet_start")
        self.start.clicked.connect(lambda _: self._start_or_stop())
        self.copy = CopyCommandButton(
            lambda: copy_facets(self._studio, self._model, self.limits.options()),
            tr("the command that finds these facets"),
        )
        self.progress = QProgressBar()
        self.summary, self.said = hint_label(), hint_label()
        self.said.setObjectName("facet_said")

    def _make_list(self) -> None:
        self.colours = ComboBox()
        self.colours.setObjectName("facet_colours")
        for key, text in _COLOURS.items():
            self.colours.addItem(tr(text), key)
        self.colours.keep_narrow()
        self.colours.activated.connect(lambda _: self._paint())
        self.type = TypeBox(self._studio)
        self.type.setObjectName("facet_type")
        self.type.setToolTip(tr("Of what is accepted."))
        self.table = NumberTable(
            (
                Column(tr("Doubt"), _verdict_text, tr("The most doubtful facets come first."),
                       number=False, icon=_verdict_icon),
                Column(tr("95 % error"), degrees, tr("How far the plane may be off, with 95 %.")),
                Column(tr("Plane"), str, tr("In the notation of the project."), number=False),
                Column(tr("Area"), self._area_text, tr("Area of the facet.")),
                Column("#", lambda v: f"{v}", tr("1 is the largest.")),
            ),
            0,
            descending=True,
        )  # fmt: skip
        self.table.setObjectName("facet_table")
        self.table.setAccessibleName(tr("Proposed facets"))
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.setMinimumHeight(_LEAST_HEIGHT)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._chosen())
        self.table.installEventFilter(self)
        self.accept = QPushButton(theme.icon("check"), tr("Accept"))
        self.accept.clicked.connect(lambda _: self._accept(self._rows()))
        self.reject = QPushButton(theme.icon("close"), tr("Reject"))
        self.reject.clicked.connect(lambda _: self._reject(self._rows()))
        self.accept_all = QPushButton(tr("Accept all"))
        self.accept_all.setIcon(theme.icon("check-all"))
        self.accept_all.clicked.connect(lambda _: self._accept(sorted(self._facets.open)))
        self.reject_all = QPushButton(tr("Reject all"))
        self.reject_all.setIcon(theme.icon("close-box-multiple-outline"))
        self.reject_all.clicked.connect(lambda _: self._facets.drop())

    def _show_axes(self, axes: Axes) -> None:
        self.limits.show_unit(unit_of(axes))

    def _area_text(self, value: float) -> str:
        return area_text(value, 2, metric=axes_of(self._studio).metric)

    def _arrange(self) -> None:
        limits = QGridLayout()
        limits.setContentsMargins(0, 0, 0, 0)
        limits.setSpacing(3)
        for k, (name, box) in enumerate(self.limits.fields.items()):
            box.setMinimumWidth(_LEAST_WIDTH)
            # Both columns the same: a distance in metres is as wide as an angle.
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            limits.addWidget(self.limits.labels[name], k // 2, 2 * (k % 2))
            limits.addWidget(box, k // 2, 2 * (k % 2) + 1)
        self.start.setMinimumWidth(_LEAST_WIDTH)
        limits.addWidget(_row(self.start, self.copy), 2, 2, 1, 2)
        limits.setColumnStretch(1, 1)
        limits.setColumnStretch(3, 1)
        # Or the dock would take its width from the outcrop once something is found.
        for part in (self.accept, self.reject, self.accept_all, self.reject_all):
            part.setMinimumWidth(_LEAST_WIDTH)
        for choice in (self.colours, self.type):
            choice.setMinimumWidth(_LEAST_WIDTH)
        self._choose = _row(self.colours, Label(tr("as")), self.type)
        self._decide = _row(self.accept, self.reject, self.accept_all, self.reject_all)
        column = narrow_column(self)
        column.addWidget(self.title)
        column.addLayout(limits)
        column.addWidget(self.live)
        column.addWidget(self.progress)
        column.addWidget(self.summary)
        # Before the buttons: whoever accepts all should see what they become.
        column.addWidget(self._choose)
        column.addWidget(self._decide)
        column.addWidget(self.table, 1)
        column.addWidget(self.said)
        column.addStretch()

    # --- what is there -----------------------------------------------------------------------
    def show_now(self) -> None:
        """Follow the model, and what was found, decided or given up."""
        studio = self._studio
        self._model = current_model(studio) if studio.has_project else None
        self.title.setText(
            tr("Open an outcrop model first.")
            if self._model is None
            else tr("On {model}", model=self._model.name)
        )
        self._show_progress()
        self._show_found()

    def _why_not(self) -> str | None:
        if self._model is None:
            return tr("Open an outcrop model first.")
        why = self._studio.fields.why_not(self._model.id)
        return None if why is None else str(why)

    def _refresh_buttons(self) -> None:
        busy = self._facets.waiting
        why = None if busy else self._why_not()
        self.start.setText(tr("Stop") if busy else tr("Find on all"))
        self.start.setEnabled(why is None)
        self.start.setToolTip(why or "")
        self.copy.allow(self._why_not())
        found, chosen = self._facets.found, self._rows()
        none_chosen = tr("Choose facets in the list first.")
        for button, on, tip, reason in (
            (self.accept, bool(chosen),
             tr("Make what is chosen in the list patches (Enter); undo takes it back."),
             none_chosen),
            (self.reject, bool(chosen), tr("Leave out what is chosen in the list (Delete)."),
             none_chosen),
            (self.accept_all, bool(self._facets.open),
             tr("Make all facets patches, as one step; undo takes it back."),
             tr("There is no facet to accept.")),
            (self.reject_all, found is not None, tr("Forget all facets; nothing is changed."),
             tr("There is nothing to reject.")),
        ):  # fmt: skip
            button.setEnabled(on)
            button.setToolTip(tip if on else reason)
        if found is not None and not found.whole:
            self.accept_all.setToolTip(tr("Make all facets of the part in view patches."))

    def _show_progress(self) -> None:
        job = self._facets.running
        self.progress.setVisible(job is not None)
        if job is None or self.visibleRegion().isEmpty():
            return
        self.progress.setRange(0, job.total or 0)
        self.progress.setValue(job.done)
        self.progress.setFormat(job.stage)

    # --- looking -----------------------------------------------------------------------------
    def _limits_changed(self) -> None:
        self._refresh_buttons()
        if self.live.isChecked():
            self._live.start()

    def _try_part(self) -> None:
        model, sight = self._model, part_in_view(self._studio)
        if model is not None and self._why_not() is None and sight is not None:
            self._facets.find(model.id, self.limits.options(), sight)

    def _start_or_stop(self) -> None:
        if self._facets.waiting:
            self._facets.stop()
        elif self._model is not None:
            self._facets.find(self._model.id, self.limits.options(), None)

    # --- what was found ----------------------------------------------------------------------
    def _show_found(self) -> None:
        found, facets = self._facets.found, self._facets
        for part in (self.table, self._decide, self._choose, self.summary):
            part.setVisible(found is not None)
        state = (found, len(facets.open))
        if state != self._filled:
            self._filled = state
            self._fill(found)
            if found is not None:
                self._paint()
        if found is not None:
            self.summary.setText(summary_in_words(found, facets.open, facets.accepted))
        self.said.setText(self._in_words(found))
        self._refresh_buttons()

    def _fill(self, found: Proposals | None) -> None:
        notation = self._studio.settings.notation
        rows = []
        for row in sorted(self._facets.open) if found is not None else ():
            assert found is not None
            measured = found.measured[row]
            if measured.plane is None or measured.verdict is None:
                continue
            verdict = measured.verdict.quality
            error = catalogue.TOTAL.value(self._studio.subject(found.patches[row], measured))
            doubt = (_DOUBT[verdict], 90.0 if error is None else error)
            plane = measured.attitude(notation, bare=True)
            area = measured.area_m2
            if area is None:
                area = found.exposed_area_of(row)
            why = (
                " ".join(each.message for each in measured.verdict.reasons)
                if verdict != "good"
                else ""
            )
            rows.append(((doubt, error, plane, area, row + 1), why))
        self.table.fill(rows)

    def _paint(self) -> None:
        by = str(self.colours.currentData())
        self._facets.paint(by, "hsv" if by == "dip direction" else None)

    def _in_words(self, found: Proposals | None) -> str:
        if found is None or self._facets.said:
            return str(self._facets.said)
        studio = self._studio
        lines = [share_in_words(found, self._facets.open, self._facets.accepted)]
        lines += map(str, found.told.warnings)
        same = {patch.runs for patch in found.patches}
        picks = [
            f
            for f in studio.session.features()
            if getattr(f, "model_id", "") == found.model_id and getattr(f, "runs", None) not in same
        ]
        chosen = [(found.patches[i], found.measured[i]) for i in sorted(self._facets.open)]
        held = agreement_both_ways(measured_planes(studio, picks), planes_of(studio, chosen))
        if held.picked:
            lines.append(agreement_in_words(held))
        return "\n".join(line for line in lines if line)

    # --- deciding ----------------------------------------------------------------------------
    def _rows(self) -> list[int]:
        """Places among what was found, of the rows that are chosen in the list."""
        numbers = self.table.numbers.rows
        chosen = self.table.selectionModel().selectedRows()
        return [int(numbers[index.row()][0][4]) - 1 for index in chosen]

    def _chosen(self) -> None:
        """The facet that was chosen last stands out on the outcrop."""
        self._refresh_buttons()
        found, index = self._facets.found, self.table.currentIndex()
        opened = None if found is None else self._studio.models.get(found.model_id)
        model = None if found is None else self._studio.records.get(found.model_id)
        area = None
        if index.isValid() and found is not None and opened and isinstance(model, Model):
            row = int(self.table.numbers.rows[index.row()][0][4]) - 1
            area = area_of(found.patches[row], model, opened.surface)
        self._studio.preview.emit(
            None if area is None else Preview(np.zeros((0, 3)), color=(1.0, 1.0, 1.0), area=area)
        )

    def _clicked(self, hit: Hit) -> None:
        """On the outcrop: the facet there is chosen in the list."""
        found = self._facets.found
        unseen = self.visibleRegion().isEmpty()
        if found is None or unseen or hit.model_id != found.model_id:
            return
        there = [r for r in self._facets.open if has_id(found.patches[r].runs, hit.index)]
        if there:
            self.table.choose(lambda values: bool(values[4] == there[0] + 1))
            self._show_table()
        else:
            self.table.clearSelection()

    def _show_table(self) -> None:
        """The row that was chosen on the outcrop comes in sight where the dock is low."""
        around = self.parentWidget()
        while around is not None and not isinstance(around, QScrollArea):
            around = around.parentWidget()
        if isinstance(around, QScrollArea):
            around.ensureWidgetVisible(self.table, 0, 0)

    def _accept(self, rows: list[int]) -> None:
        at = self.table.currentIndex().row()
        if self._facets.accept(rows, str(self.type.currentData())):
            self._go_on(at)

    def _reject(self, rows: list[int]) -> None:
        at = self.table.currentIndex().row()
        self._facets.reject(rows)
        self._go_on(at)

    def _go_on(self, row: int) -> None:
        """To the one that has come to stand in that row."""
        count = self.table.numbers.rowCount()
        if count and row >= 0:
            self.table.selectRow(min(row, count - 1))
        else:
            self._studio.preview.emit(None)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Enter accepts what is chosen in the list, Delete rejects it."""
        if watched is self.table and isinstance(event, QKeyEvent):
            if event.type() == QEvent.Type.ShortcutOverride and event.key() in _KEYS:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress and event.key() in _KEYS:
                decide = self._reject if event.key() == Qt.Key.Key_Delete else self._accept
                decide(self._rows())
                return True
        return super().eventFilter(watched, event)


_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Delete)


def _row(*widgets: QWidget) -> QWidget:
    row = QWidget()
    line = QHBoxLayout(row)
    line.setContentsMargins(0, 0, 0, 0)
    line.setSpacing(4)
    for widget in widgets:
        line.addWidget(widget)
    return row


def _verdict_of(doubt: tuple[int, float]) -> str | None:
    return next((name for name, place in _DOUBT.items() if place == doubt[0]), None)


def _verdict_text(doubt: tuple[int, float]) -> str:
    name = _verdict_of(doubt)
    return "–" if name is None else tr(_VERDICTS[name])


def _verdict_icon(doubt: tuple[int, float]) -> QIcon:
    return theme.verdict_icon(_verdict_of(doubt))
