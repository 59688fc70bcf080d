"""Events of worker jobs, brought to the GUI thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal

from vomstudio.errors import WorkerError
from vomstudio.failures.desk import DESK
from vomstudio.jobs.events import Done, Event, Failed, Fault, Stage, Step
from vomstudio.jobs.supervisor import Worker


@dataclass
class Job:
    """A running job as the window shows it."""

    number: int
    title: str
    worker: Worker
    on_done: Callable[[dict[str, Any]], None]
    on_failed: Callable[[Failed], None]
    quiet: bool = False
    stage: str = ""
    total: int | None = None
    done: int = 0
    faults: list[Fault] = field(default_factory=list)

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
    closed = Signal()
    _arrived = Signal(object, object)

    def __init__(self) -> None:
        super().__init__()
        lanes = ("models", "files", "products", "photos", "reconstruction", "inspection")
        self._workers = {lane: Worker(partial(self._arrived.emit, lane)) for lane in lanes}
        self.jobs: dict[tuple[str, int], Job] = {}
        self._refused = 0
        self._arrived.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    def submit(
        self,
        lane: str,
        task: str,
        args: Mapping[str, Any],
        *,
        title: str,
        on_done: Callable[[dict[str, Any]], None],
        on_failed: Callable[[Failed], None],
        quiet: bool = False,
    ) -> Job:
        worker = self._workers[lane]
        try:
            number = worker.submit(task, args, lambda event: self._arrived.emit(lane, event))
        except WorkerError as error:
            # Told like every other failure, once the caller has its job.
            self._refused -= 1
            number = self._refused
            self._arrived.emit(lane, Failed(number, error.as_dict(), error.exit_code))
        job = Job(number, title, worker, on_done, on_failed, quiet)
        self.jobs[lane, number] = job
        self.changed.emit()
        return job

    def cancel(self, job: Job) -> None:
        job.worker.cancel(job.number)

    def visible(self) -> list[Job]:
        return [job for job in self.jobs.values() if not job.quiet]

    def _deliver(self, lane: str, event: Event | Fault) -> None:
        job = self.jobs.get((lane, event.job))
        if job is None:
            if isinstance(event, Fault):
                _tell("Work beside the window", event)
            return
        if isinstance(event, Fault):
            # What the job's owner says at its end comes first.
            job.faults.append(event)
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
            for fault in job.faults:
                _tell(f"“{job.title}”", fault)
        self.changed.emit()

    def finish(self, lane: str, timeout_s: float) -> None:
        """Wait for what a lane is doing; nobody is told of it before the event loop runs."""
        self._workers[lane].finish(timeout_s)

    def close(self) -> None:
        self._arrived.disconnect(self._deliver)
        for worker in self._workers.values():
            worker.close()
        self.closed.emit()


def _tell(who: str, fault: Fault) -> None:
    DESK.tell(
        f"{who} met a mistake of the program ({fault.what}): your project is as it was, and a "
        "report helps to mend it.",
        fault.what,
    )
