"""Running jobs, whose worker processes send events to the owner's thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

from vomstudio.core.errors import WorkerError
from vomstudio.core.failures.error_collector import ERRORS
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.core.words import tr
from vomstudio.studio.jobs.events import Done, Event, Failed, InternalError, Stage, Step
from vomstudio.studio.jobs.job import Job, Lane, Request, Result
from vomstudio.studio.jobs.supervisor import WorkerSupervisor
from vomstudio.studio.owner_thread import Post


@dataclass
class RunningJob:
    """State of a running job, as displayed to the user.

    Parameters
    ----------
    title, stage : str
        Translated title of the job and of its present stage.
    total : int or None
        Total number of steps in the stage, or None if unknown.
    done : int
        Number of completed steps.
    is_resumable : bool
        Whether stopping the job keeps the partial result, so that the job can be resumed.
    outcome : {"", "done", "stopped", "failed"}
        "" while it runs.
    """

    number: int
    title: str
    worker: WorkerSupervisor
    on_done: Callable[[Any], None]
    on_failed: Callable[[Failed], None]
    is_quiet: bool = False
    is_resumable: bool = False
    outcome: Literal["", "done", "stopped", "failed"] = ""
    stage: str = ""
    total: int | None = None
    done: int = 0
    internal_errors: list[InternalError] = field(default_factory=list)

    def status(self) -> str:
        """Return the stage, with its progress if it is known."""
        if not self.total:
            return self.stage
        return tr(
            "{stage}, {done:,} of {total:,}", stage=self.stage, done=self.done, total=self.total
        )

    def text(self) -> str:
        """Return the title and the status in one line."""
        return f"{self.title}: {self.status()}" if self.stage else self.title


class _EventForwarder:
    """Forwarder of the events of a job to its owner, which skips all but the newest step.

    Displaying hundreds of steps that arrive at once would block the owner for a second.
    """

    def __init__(self, post: Post, deliver: Callable[[Event], None]) -> None:
        self._post, self._deliver = post, deliver
        self._lock = threading.Lock()
        self._waiting: list[Event] | None = None

    def __call__(self, event: Event) -> None:
        """Receive an event in the thread of the worker."""
        with self._lock:
            if isinstance(event, Step) and self._waiting is not None:
                self._waiting[0] = event
                return
            forwarded_events = [event]
            # A step after another event must not overtake it.
            self._waiting = forwarded_events if isinstance(event, Step) else None
        self._post(partial(self._forward_event, forwarded_events))

    def _forward_event(self, passed_events: list[Event]) -> None:
        with self._lock:
            if self._waiting is passed_events:
                self._waiting = None
        self._deliver(passed_events[0])


class Jobs:
    """Worker processes, one per lane, started on demand."""

    def __init__(self, post: Post) -> None:
        self.changed: Signal[()] = Signal()
        self.closed: Signal[()] = Signal()
        self._post = post
        self.workers = {lane: WorkerSupervisor(partial(self._hand_over, lane)) for lane in Lane}
        self.jobs: dict[tuple[Lane, int], RunningJob] = {}
        self._next_refused_number = 0
        self._is_closed = False

    def submit(
        self,
        job: Job[Request, Result],
        request: Request,
        *,
        title: str,
        on_done: Callable[[Result], None],
        on_failed: Callable[[Failed], None],
        is_quiet: bool = False,
        is_resumable: bool = False,
    ) -> RunningJob:
        """Start a job.

        `on_done` or `on_failed` is called in the owner's thread when the job ends. After
        `close`, no job is started and no callback is called.

        Parameters
        ----------
        job : Job[Request, Result]
        request : Request
        title : str
            Name of the job for the user.
        on_done, on_failed : callable
            Called when the job has succeeded or failed.
        is_quiet : bool
            Whether to hide the job from the user.
        is_resumable : bool
            Whether the next job of this kind continues where this job was stopped.
        """
        lane = job.lane
        worker = self.workers[lane]
        try:
            number = worker.submit(
                job, request, _EventForwarder(self._post, partial(self._deliver, lane))
            )
        except WorkerError as error:
            # Reported like every other failure, after the caller has received the job.
            self._next_refused_number -= 1
            number = self._next_refused_number
            failure = Failed(number, error.to_dict(), error.exit_code)
            self._post(lambda: self._deliver(lane, failure))
        running_job = RunningJob(number, title, worker, on_done, on_failed, is_quiet, is_resumable)
        if not self._is_closed:
            self.jobs[lane, number] = running_job
            self.changed.emit()
        return running_job

    def cancel(self, job: RunningJob) -> None:
        """Request that a job stops; `on_failed` is called when it has stopped."""
        job.worker.cancel(job.number)

    def visible(self) -> list[RunningJob]:
        """Return the visible jobs, oldest first."""
        return [job for job in self.jobs.values() if not job.is_quiet]

    def _hand_over(self, lane: Lane, error: InternalError) -> None:
        self._post(lambda: self._deliver(lane, error))

    def _deliver(self, lane: Lane, event: Event | InternalError) -> None:
        job = self.jobs.get((lane, event.job))
        if self._is_closed:
            return
        if job is None:
            if isinstance(event, InternalError):
                _report(tr("Background work"), event)
            return
        if isinstance(event, InternalError):
            # The result of the job is reported before its defects.
            job.internal_errors.append(event)
            return
        if isinstance(event, Stage):
            job.stage, job.total, job.done = event.name, event.total, 0
        elif isinstance(event, Step):
            job.done = event.done
        else:
            del self.jobs[lane, event.job]
            if isinstance(event, Done):
                job.outcome = "done"
                job.on_done(event.result)
            else:
                job.outcome = "stopped" if event.cancelled else "failed"
                job.on_failed(event)
            for error in job.internal_errors:
                _report(job.title, error)
        self.changed.emit()

    def finish(self, lane: Lane, timeout_s: float) -> None:
        """Wait for the running job of a lane, for at most `timeout_s`.

        The event loop calls its callbacks later.
        """
        self.workers[lane].finish(timeout_s)

    def release(self, lane: Lane) -> None:
        """End the idle worker of a lane, to free its memory."""
        self.workers[lane].release()

    def close(self) -> None:
        """Stop all workers; no callback is called afterwards."""
        self._is_closed = True
        with ExitStack() as steps:
            steps.callback(self.closed.emit)
            for worker in self.workers.values():
                steps.callback(worker.close)


def _report(title: str, error: InternalError) -> None:
    ERRORS.report_finding(Finding("job.internal-error", job=title, error=error.cause), error.cause)
