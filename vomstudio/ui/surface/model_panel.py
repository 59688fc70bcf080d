"""Panels of work on an open model, and of proposals that wait to be accepted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QProgressBar, QPushButton, QScrollArea

from vomstudio.core.findings import Finding, Message
from vomstudio.document.records import Model
from vomstudio.tools.interaction_types import Area, Hit, Preview
from vomstudio.ui.analyse.analysis_panel import LazyPanel
from vomstudio.ui.common import theme
from vomstudio.ui.common.command_targets import current_model
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.number_table import Column, NumberTable
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.type_box import TypeBox
from vomstudio.ui.interpret.tool_panels.common import hint_label
from vomstudio.words import tr
from vomstudio.workspace.surfaces.model_work import ModelWork, ProposalQueue

LEAST_WIDTH = 50
"""Or the dock would take its width from the outcrop once something is found."""
_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Delete)


class ModelPanel(LazyPanel):
    """A button that starts and stops work on the current model, and its progress.

    Parameters
    ----------
    studio : Studio
    work : ModelWork
    prefix : str
        Beginning of the object names.
    topic : str
        Page of the help.
    start : str
        Text of the button.
    icon : str
        Of the button.
    """

    def __init__(
        self, studio: Studio, work: ModelWork, prefix: str, topic: str, start: str, icon: str
    ) -> None:
        super().__init__(studio)
        explain(self, topic)
        self._work, self._start_text, self._prefix = work, start, prefix
        self._model: Model | None = None
        self.title = hint_label()
        self.start = QPushButton(theme.icon(icon), start)
        self.start.setObjectName(f"{prefix}_start")
        self.start.clicked.connect(lambda _: self._start_or_stop())
        self.progress = QProgressBar()

    def _follow(self) -> None:
        """Keep up with the studio and the work, from now on."""
        studio = self._studio
        for signal in (studio.project_opened, studio.model_loaded, studio.selection_changed):
            signal.connect(self._soon)
        studio.edited.connect(self._soon)
        studio.jobs_changed.connect(self._show_progress)
        self._work.changed.connect(self.refresh)
        self.show_now()

    def show_now(self) -> None:
        """Show the current model and the progress of the work."""
        studio = self._studio
        self._model = current_model(studio) if studio.has_project else None
        self.title.setText(
            tr("Open an outcrop model first.")
            if self._model is None
            else tr("On {model}", model=self._model.name)
        )
        self._show_progress()

    def _why_not(self) -> Message | None:
        """Return why the work cannot be done, None if it can."""
        if self._model is None:
            return Finding("display.no-model")
        return self._studio.fields.why_not(self._model.id)

    def _refresh_buttons(self) -> None:
        busy = self._work.running is not None
        why = None if busy else self._why_not()
        self.start.setText(tr("Stop") if busy else self._start_text)
        self.start.setEnabled(why is None)
        self.start.setToolTip("" if why is None else str(why))

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
        """Start the work on a model."""
        raise NotImplementedError


class ProposalsPanel(ModelPanel):
    """A table of proposals whose last column is their number, from 1, and what to do with them."""

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

    def _make_list(
        self, columns: Sequence[Column], title: str, height: int, *, descending: bool = False
    ) -> None:
        self.type = TypeBox(self._studio)
        self.type.setObjectName(f"{self._prefix}_type")
        self.type.setToolTip(tr("Of what is accepted."))
        self.table = NumberTable(columns, 0, descending=descending)
        self.table.setObjectName(f"{self._prefix}_table")
        self.table.setAccessibleName(title)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.setMinimumHeight(height)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._chosen())
        self.table.installEventFilter(self)
        self.accept = QPushButton(theme.icon("check"), tr("Accept"))
        self.accept.clicked.connect(lambda _: self._decide(self._accept_rows, self._rows()))
        self.reject = QPushButton(theme.icon("close"), tr("Reject"))
        self.reject.clicked.connect(lambda _: self._decide(self._reject_rows, self._rows()))
        self._studio.surface_clicked.connect(self._clicked)

    # --- what is chosen ----------------------------------------------------------------------
    def _place(self, row: int) -> int:
        """Return the place among what was found of a row of the table."""
        return int(self.table.numbers.rows[row][0][-1]) - 1

    def _rows(self) -> list[int]:
        """Return the places among what was found of the rows that are chosen in the table."""
        return [self._place(each.row()) for each in self.table.selectionModel().selectedRows()]

    def _current(self) -> int | None:
        """Return the place of the row that was chosen last."""
        index, rows = self.table.currentIndex(), self._rows()
        if not index.isValid() or not rows:
            return None
        place = self._place(index.row())
        return place if place in rows else rows[-1]

    def _chosen(self) -> None:
        """Highlight on the outcrop what was chosen last."""
        self._refresh_buttons()
        if self._studio.open_tool is not None:
            return
        place = self._current()
        area = None if place is None else self._area(place)
        self._studio.preview.emit(
            None if area is None else Preview(np.zeros((0, 3)), color=(1.0, 1.0, 1.0), area=area)
        )

    def _area(self, place: int) -> Area | None:
        """Return what is highlighted of a proposal."""
        raise NotImplementedError

    def _clicked(self, hit: Hit) -> None:
        """Choose in the table what was clicked on the outcrop."""
        found = self._queue.found
        if found is None or self.visibleRegion().isEmpty() or hit.model_id != found.model_id:
            return
        place = self._clicked_place(hit)
        if place is None:
            self.table.clearSelection()
            return
        self.table.choose(lambda values: bool(values[-1] == place + 1))
        # The chosen row comes in sight if the dock is low.
        around = self.parentWidget()
        while around is not None and not isinstance(around, QScrollArea):
            around = around.parentWidget()
        if isinstance(around, QScrollArea):
            around.ensureWidgetVisible(self.table, 0, 0)

    def _clicked_place(self, hit: Hit) -> int | None:
        """Return the place of the proposal at a point of the outcrop."""
        raise NotImplementedError

    # --- deciding ----------------------------------------------------------------------------
    def _accept_rows(self, places: list[int]) -> bool:
        """Make proposals features of the project; return whether that succeeded."""
        raise NotImplementedError

    def _reject_rows(self, places: list[int]) -> bool:
        raise NotImplementedError

    def _decide(self, decide: Callable[[list[int]], bool], places: list[int]) -> None:
        """Accept or reject proposals, and choose the one that then follows."""
        row = self.table.currentIndex().row()
        if not decide(places):
            return
        count = self.table.numbers.rowCount()
        if count and row >= 0:
            self.table.selectRow(min(row, count - 1))
        else:
            self._studio.preview.emit(None)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Enter accepts what is chosen in the table, Delete rejects it."""
        if watched is self.table and isinstance(event, QKeyEvent) and event.key() in _KEYS:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                is_delete = event.key() == Qt.Key.Key_Delete
                self._decide(self._reject_rows if is_delete else self._accept_rows, self._rows())
                return True
        return super().eventFilter(watched, event)
