"""Panels that run a job on an open model, and panels for reviewing proposals of a job."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt
from PySide6.QtGui import QHideEvent, QKeyEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QAbstractItemView, QProgressBar, QPushButton, QScrollArea

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Plane
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Model
from vomstudio.studio.surfaces.model_jobs import ModelWork, ProposalQueue
from vomstudio.studio.surfaces.proposed_planes import ProposedPlanes, proposal_indices
from vomstudio.studio.tools.interaction_types import Area, Hit, Preview
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import current_model
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import LazyPanel
from vomstudio.ui.panels.features.feature_row import Row
from vomstudio.ui.panels.features.feature_row import create_row as create_feature_row
from vomstudio.ui.panels.features.filter_line import FilterLine
from vomstudio.ui.panels.tools.common import hint_label
from vomstudio.ui.widgets.number_table import Column, NumberTable
from vomstudio.ui.widgets.type_box import TypeBox

MIN_WIDTH_PX = 50
"""Minimum width of buttons and fields, so that the dock does not grow with the proposals."""
_DECISION_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Delete)
_MAX_HIGHLIGHTED = 200
"""Maximum number of selected proposals that are highlighted on the outcrop."""


class ModelPanel(LazyPanel):
    """Panel that starts and stops a job on the current model and shows its progress.

    Parameters
    ----------
    studio : Studio
    model_work : ModelWork
        Work that the panel controls.
    prefix : str
        Prefix of the object names.
    topic : str
        Help page of the panel.
    start : str
        Text of the start button.
    icon : str
        Icon name of the start button.
    """

    def __init__(
        self, studio: Studio, model_work: ModelWork, prefix: str, topic: str, start: str, icon: str
    ) -> None:
        super().__init__(studio)
        set_help_topic(self, topic)
        self._work, self._start_text, self._prefix = model_work, start, prefix
        self._model: Model | None = None
        self.title = hint_label()
        self.start = QPushButton(theme.icon(icon), start)
        self.start.setObjectName(f"{prefix}_start")
        self.start.clicked.connect(lambda _: self._start_or_stop())
        self.progress = QProgressBar()

    def _follow(self) -> None:
        """Connect the panel to the signals of the studio and of the work."""
        studio = self._studio
        studio.model_loaded.connect(self._schedule_refresh)
        studio.selection_changed.connect(self._schedule_refresh)
        studio.edited.connect(self._schedule_refresh)
        studio.jobs_changed.connect(self._show_progress)
        connect_until_deleted(self, self._work.changed, self.refresh)
        self.update_widgets()

    def update_widgets(self) -> None:
        """Show the current model and the progress of its job."""
        studio = self._studio
        self._model = current_model(studio) if studio.has_project else None
        self.title.setText(
            tr("Open an outcrop model first.")
            if self._model is None
            else tr("On {model}", model=self._model.name)
        )
        self._show_progress()

    def _disabled_reason(self) -> Finding | None:
        """Return why the job cannot start, or None if it can."""
        if self._model is None:
            return Finding("action.no-model")
        return self._studio.fields.disabled_reason(self._model.id)

    def _refresh_buttons(self) -> None:
        is_busy = self._work.running is not None
        reason = None if is_busy else self._disabled_reason()
        self.start.setText(tr("Stop") if is_busy else self._start_text)
        self.start.setEnabled(reason is None)
        self.start.setToolTip("" if reason is None else str(reason))

    def _show_progress(self) -> None:
        job = self._work.running
        self.progress.setVisible(job is not None)
        if job is None or self.visibleRegion().isEmpty():
            return
        self.progress.setRange(0, job.total or 0)
        self.progress.setValue(job.done)
        self.progress.setFormat(job.stage)

    def _start_or_stop(self) -> None:
        if self._work.running is not None:
            self._work.stop()
        elif self._model is not None:
            self._start(self._model)

    def _start(self, model: Model) -> None:
        """Start the job on a model."""
        raise NotImplementedError


class ProposalsPanel(ModelPanel):
    """Panel with a table of proposals that the user accepts or rejects.

    The last table column contains the number of the proposal, starting at 1; indices start at 0.

    Parameters
    ----------
    studio : Studio
    queue : ProposalQueue
    prefix, topic, start, icon : str
        As in `ModelPanel`.
    """

    def __init__(
        self,
        studio: Studio,
        queue: ProposalQueue[Any],
        prefix: str,
        topic: str,
        start: str,
        icon: str,
    ) -> None:
        super().__init__(studio, queue, prefix, topic, start, icon)
        self._queue = queue
        self._rows: list[tuple[tuple[Any, ...], str]] = []
        self._listed_result: object = None

    def _make_list(
        self, columns: Sequence[Column], title: str, height: int, *, is_descending: bool = False
    ) -> None:
        self.type = TypeBox(self._studio, geometry="plane")
        self.type.setObjectName(f"{self._prefix}_type")
        self.type.setToolTip(tr("Feature type of accepted proposals."))
        self._studio.next_type_changed.connect(self._follow_type)
        self._follow_type()
        self.filter = FilterLine(tr("Filter"), has_word_wrap=True)
        self.filter.setObjectName(f"{self._prefix}_filter")
        self.filter.setAccessibleName(tr("Filter of the proposals"))
        self.filter.changed.connect(self._list_proposals)
        self.reason = WrappedLabel()
        self.reason.setObjectName(f"{self._prefix}_reason")
        self.table = NumberTable(columns, 0, is_descending=is_descending)
        self.table.setObjectName(f"{self._prefix}_table")
        self.table.setAccessibleName(title)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.setMinimumHeight(height)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._selection_changed())
        self.table.installEventFilter(self)
        self.accept = QPushButton(theme.icon("check"), tr("Accept"))
        self.accept.clicked.connect(lambda _: self._decide(self._accept, self._selection()))
        self.reject = QPushButton(theme.icon("close"), tr("Reject"))
        self.reject.clicked.connect(lambda _: self._decide(self._reject, self._selection()))
        self._studio.surface_clicked.connect(self._handle_click)
        self._studio.proposals_picked.connect(self._select_picked)

    def _follow_type(self) -> None:
        """Propose the active feature type for accepted features if it is a type of planes."""
        if self.type.findData(self._studio.next_type_id) >= 0:
            self.type.select_type(self._studio.next_type_id)

    # --- list --------------------------------------------------------------------------------
    def _show_rows(self, rows: list[tuple[tuple[Any, ...], str]]) -> None:
        """Show the rows of all undecided proposals that the filter accepts."""
        self._rows = rows
        if self._queue.proposals is not self._listed_result:
            # Rows of another result have the same indices but are other proposals. The listed rows
            # may have no counterpart in it, so the change is handled when the new rows are listed.
            self._listed_result = self._queue.proposals
            with QSignalBlocker(self.table.selectionModel()):
                self.table.clearSelection()
        self._list_proposals()

    def _list_proposals(self) -> None:
        """List the proposals that the filter accepts, and keep the selection."""
        test, selection = self.filter.test, set(self._selection())
        listed_rows = [row for row in self._rows if test is None or test(self._filter_row(row))]
        with QSignalBlocker(self.table.selectionModel()):
            self.table.fill(listed_rows)
            if selection:
                self.table.select_rows(lambda values: values[-1] - 1 in selection)
        self._selection_changed()

    def _filter_row(self, row: tuple[tuple[Any, ...], str]) -> Row:
        feature, measurement = self._measured_feature(int(row[0][-1]) - 1)
        return create_feature_row(self._studio, feature, measurement)

    def _measured_feature(self, index: int) -> tuple[Feature, Measurement]:
        """Return the feature that a proposal would become, with its measurement."""
        raise NotImplementedError

    def listed_indices(self) -> list[int]:
        """Return the indices of the listed proposals, in ascending order."""
        return sorted(self._index(row) for row in range(self.table.numbers.rowCount()))

    # --- net ---------------------------------------------------------------------------------
    def _show_on_net(self) -> None:
        """Show the planes of the listed proposals on the net while the panel is visible."""
        planes = None
        if self._queue.proposals is not None and self.isVisible():
            planes = self._proposed_planes()
        self._studio.planes_proposed.emit(self._prefix, planes)

    def _proposed_planes(self) -> ProposedPlanes:
        plane_by_index: dict[int, Plane] = {}
        for index in self.listed_indices():
            plane = self._measured_feature(index)[1].plane
            if plane is not None:
                plane_by_index[index] = plane
        return ProposedPlanes(
            owner=self._prefix,
            title=self.table.accessibleName(),
            planes=tuple(plane_by_index.values()),
            indices=tuple(plane_by_index),
            selection=frozenset(self._selection()),
        )

    def _select_picked(self, ids: Iterable[str], is_adding: bool) -> None:
        """Select the proposals that were picked on the net."""
        if self.isVisible() and self._queue.proposals is not None:
            picked_indices = set(proposal_indices(self._prefix, ids))
            self.table.select_rows(
                lambda values: values[-1] - 1 in picked_indices, is_adding=is_adding
            )

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._show_on_net()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        super().hideEvent(event)
        self._show_on_net()

    # --- selection ---------------------------------------------------------------------------
    def _index(self, row: int) -> int:
        """Return the index of the proposal in a row of the table."""
        return int(self.table.numbers.rows[row][0][-1]) - 1

    def _selection(self) -> list[int]:
        """Return the indices of the selected proposals."""
        return [self._index(item.row()) for item in self.table.selectionModel().selectedRows()]

    def _current(self) -> int | None:
        """Return the index of the proposal selected last, or None if none is selected."""
        current, selection = self.table.currentIndex(), self._selection()
        if not current.isValid() or not selection:
            return None
        index = self._index(current.row())
        return index if index in selection else selection[-1]

    def _selection_changed(self) -> None:
        """Highlight the selected proposals on the outcrop and the net, and show the reason."""
        self._refresh_buttons()
        self._show_on_net()
        index = self._current()
        reason = "" if index is None else self._reason_text(index)
        self.reason.setText(reason)
        self.reason.setVisible(bool(reason))
        if self._studio.open_tool is not None:
            return
        area = self._highlight_area(self._selection()[:_MAX_HIGHLIGHTED])
        self._studio.preview.emit(
            None if area is None else Preview(np.zeros((0, 3)), color=(1.0, 1.0, 1.0), area=area)
        )

    def _reason_text(self, index: int) -> str:
        """Return the evidence for a proposal or the reasons for doubt; empty if there are none."""
        raise NotImplementedError

    def _highlight_area(self, indices: Sequence[int]) -> Area | None:
        """Return the area of the outcrop to highlight for the given proposals, or None."""
        raise NotImplementedError

    def _handle_click(self, hit: Hit) -> None:
        """Select the table row of the proposal that was clicked on the outcrop."""
        proposals = self._queue.proposals
        if proposals is None or self.visibleRegion().isEmpty():
            return
        if hit.model_id != proposals.model_id:
            return
        index = self._index_at(hit)
        if index is None:
            self.table.clearSelection()
            return
        self.table.select_row(lambda values: bool(values[-1] == index + 1))
        # In a low dock the selected row may be out of view.
        ancestor = self.parentWidget()
        while ancestor is not None and not isinstance(ancestor, QScrollArea):
            ancestor = ancestor.parentWidget()
        if isinstance(ancestor, QScrollArea):
            ancestor.ensureWidgetVisible(self.table, 0, 0)

    def _index_at(self, hit: Hit) -> int | None:
        """Return the index of the proposal at an outcrop point, or None if there is no match."""
        raise NotImplementedError

    # --- decision ----------------------------------------------------------------------------
    def _accept(self, indices: list[int]) -> bool:
        """Add proposals to the project as features; return whether this succeeded."""
        raise NotImplementedError

    def _reject(self, indices: list[int]) -> bool:
        """Remove proposals from the list; return whether this succeeded."""
        raise NotImplementedError

    def _decide(self, decide: Callable[[list[int]], bool], indices: list[int]) -> None:
        """Accept or reject proposals, and select the next row of the table."""
        row = self.table.currentIndex().row()
        if not decide(indices):
            return
        self.table.clearSelection()
        count = self.table.numbers.rowCount()
        if count and row >= 0:
            self.table.selectRow(min(row, count - 1))
        else:
            self._studio.preview.emit(None)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Accept the selected proposals on Enter, and reject them on Delete."""
        if watched is self.table and isinstance(event, QKeyEvent) and event.key() in _DECISION_KEYS:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                is_delete = event.key() == Qt.Key.Key_Delete
                self._decide(self._reject if is_delete else self._accept, self._selection())
                return True
        return super().eventFilter(watched, event)


class WrappedLabel(Label):
    """Label that keeps the full height of its text when the panel is too small."""

    def __init__(self) -> None:
        super().__init__()
        self.setWordWrap(True)

    def setText(self, text: str) -> None:  # noqa: N802
        super().setText(text)
        self._keep_height()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self._keep_height()

    def _keep_height(self) -> None:
        self.setMinimumHeight(self.heightForWidth(self.width()) if self.text() else 0)
