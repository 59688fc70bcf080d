"""Panel of running and finished background jobs."""

from __future__ import annotations

import time
from datetime import datetime

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QProgressBar,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
)

from vomstudio.core.words import to_translate, tr
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio

_COLUMNS = (
    to_translate("Job"),
    to_translate("Status"),
    to_translate("Progress"),
    to_translate("Time"),
    "",
)
_MAX_ENDED_JOBS = 50
# Shorter jobs are not listed once they have ended.
_MIN_DURATION_S = 2.0


class JobsPanel(QTableWidget):
    """Table of running jobs, each with a stop button, followed by finished jobs."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(0, len(_COLUMNS))
        self._jobs = jobs = studio.jobs
        self._start_times: dict[int, float] = {}
        self._running_jobs: dict[int, RunningJob] = {}
        self._history: list[tuple[str, str, str]] = []
        self.setObjectName("jobs")
        self.setHorizontalHeaderLabels([tr(title) if title else "" for title in _COLUMNS])
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        self._clock_timer = QTimer(self)
        self._clock_timer.setInterval(1000)
        self._clock_timer.timeout.connect(self._show_times)
        jobs.changed.connect(self._refresh)
        studio.project_opened.connect(self._begin_project)
        jobs.closed.connect(self._clock_timer.stop)

    def _begin_project(self) -> None:
        self._history.clear()
        self._build()
        self._refresh()

    def _refresh(self) -> None:
        running_jobs = {id(job): job for job in self._jobs.visible()}
        for key, job in self._running_jobs.items():
            if key not in running_jobs:
                duration_s = time.monotonic() - self._start_times.pop(key)
                if duration_s >= _MIN_DURATION_S:
                    status = _end_text(job)
                    self._history.insert(0, (job.title, status, _duration_text(duration_s)))
        del self._history[_MAX_ENDED_JOBS:]
        if list(running_jobs) != list(self._running_jobs):
            for key in running_jobs:
                self._start_times.setdefault(key, time.monotonic())
            self._running_jobs = running_jobs
            self._build()
        for row, job in enumerate(running_jobs.values()):
            self._show_job(row, job)
        if running_jobs and not self._clock_timer.isActive():
            self._clock_timer.start()
        elif not running_jobs:
            self._clock_timer.stop()

    def _build(self) -> None:
        self.setRowCount(0)
        self.setRowCount(len(self._running_jobs) + len(self._history))
        for row, job in enumerate(self._running_jobs.values()):
            for column in (0, 1, 3):
                self.setItem(row, column, QTableWidgetItem(job.title if column == 0 else ""))
            progress_bar = QProgressBar()
            progress_bar.setFixedWidth(160)
            self.setCellWidget(row, 2, progress_bar)
            stop_button = QToolButton()
            stop_button.setText(tr("Pause") if job.is_resumable else tr("Stop"))
            stop_button.setIcon(theme.icon("pause" if job.is_resumable else "stop"))
            stop_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            stop_button.clicked.connect(lambda _=False, j=job: self._jobs.cancel(j))
            self.setCellWidget(row, 4, stop_button)
        for row, (title, status, duration) in enumerate(
            self._history, start=len(self._running_jobs)
        ):
            for column, text in ((0, title), (1, status), (3, duration)):
                self.setItem(row, column, QTableWidgetItem(text))

    def _show_job(self, row: int, job: RunningJob) -> None:
        status, progress_bar = self.item(row, 1), self.cellWidget(row, 2)
        if status is not None:
            status.setText(job.status())
        if isinstance(progress_bar, QProgressBar):
            progress_bar.setRange(0, job.total or 0)
            progress_bar.setValue(job.done)

    def _show_times(self) -> None:
        for row, key in enumerate(self._running_jobs):
            item = self.item(row, 3)
            if item is not None:
                item.setText(_duration_text(time.monotonic() - self._start_times[key]))


def _end_text(job: RunningJob) -> str:
    """Return how a job ended, with the current time of day."""
    current_time = datetime.now()
    if job.outcome == "stopped" and job.is_resumable:
        return tr("Paused at {time:%H:%M}", time=current_time)
    if job.outcome == "stopped":
        return tr("Stopped at {time:%H:%M}", time=current_time)
    if job.outcome == "failed":
        return tr("Failed at {time:%H:%M}", time=current_time)
    return tr("Ended at {time:%H:%M}", time=current_time)


def _duration_text(seconds: float) -> str:
    minutes, remaining_seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return (
        f"{hours}:{minutes:02d}:{remaining_seconds:02d}"
        if hours
        else f"{minutes}:{remaining_seconds:02d}"
    )
