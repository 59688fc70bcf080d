"""Events of worker jobs, brought to the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal

from vomstudio.errors import WorkerError
from vomstudio.jobs import job as jobs
from vomstudio.jobs.events import Done, Event, Failed, Stage, Step
from vomstudio.jobs.job import Lane, Request, Result
from vomstudio.jobs.supervisor import Worker


@dataclass
class Job:
    """A running job as the window shows it."""

    number: int
    title: str
    worker: Worker
    on_done: Callable[[Any], None]
    on_failed: Callable[[Failed], None]
    quiet: bool = False
    stage: str = ""
    total: int | None = None
    done: int = 0

    def words(self) -> str:
        if not self.stage:
            return self.title
        if self.total:
            return f"{self.title}: {self.stage}, {self.done:,} of {self.total:,}"
        return f"{self.title}: {self.stage}"


class JobBridge(QObject):
    """Worker processes, each begun when it is first needed and each for its own kind of work, so
    that reading a model never waits for a reconstruction."""

    changed = Signal()
    _arrived = Signal(object, object)

    def __init__(self) -> None:
        super().__init__()
        self._workers = {lane: Worker() for lane in Lane}
        self.jobs: dict[tuple[Lane, int], Job] = {}
        self._refused = 0
        self._arrived.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    def submit(
        self,
        job: jobs.Job[Request, Result],
        request: Request,
        *,
        title: str,
        on_done: Callable[[Result], None],
        on_failed: Callable[[Failed], None],
        quiet: bool = False,
    ) -> Job:
        lane = job.lane
        worker = self._workers[lane]
        try:
            number = worker.submit(job, request, lambda event: self._arrived.emit(lane, event))
        except WorkerError as error:
            # Told like every other failure, once the caller has its job.
            self._refused -= 1
            number = self._refused
            self._arrived.emit(lane, Failed(number, error.as_dict(), error.exit_code))
        begun = Job(number, title, worker, on_done, on_failed, quiet)
        self.jobs[lane, number] = begun
        self.changed.emit()
        return begun

    def cancel(self, job: Job) -> None:
        job.worker.cancel(job.number)

    def visible(self) -> list[Job]:
        return [job for job in self.jobs.values() if not job.quiet]

    def _deliver(self, lane: Lane, event: Event) -> None:
        job = self.jobs.get((lane, event.job))
        if job is None:
            return
        if isinstance(event, Stage):
            job.stage, job.total, job.done = event.name, event.total, 0
        elif isinstance(event, Step):
            job.done = event.done
        else:
            del self.jobs[lane, event.job]
            if isinstance(event, Done):
                job.on_done(event.result)
            else:
                job.on_failed(event)
        self.changed.emit()

    def finish(self, lane: Lane, timeout_s: float) -> None:
        """Wait for what a lane is doing; nobody is told of it before the event loop runs."""
        self._workers[lane].finish(timeout_s)

    def close(self) -> None:
        self._arrived.disconnect(self._deliver)
        for worker in self._workers.values():
            worker.close()
