"""Jobs in flight: worker processes, and their events brought to the thread that owns them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from vomstudio.errors import WorkerError
from vomstudio.failures.error_collector import DESK
from vomstudio.jobs.events import Done, Event, Failed, Fault, Stage, Step
from vomstudio.jobs.job import Job, Lane, Request, Result
from vomstudio.jobs.supervisor import Worker
from vomstudio.signals import Signal
from vomstudio.workspace.owner_thread import Post


@dataclass
class RunningJob:
    """A running job as it is shown."""

    number: int
    title: str
    worker: Worker
    on_done: Callable[[Any], None]
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


class Jobs:
    """Worker processes, each begun when it is first needed and each for its own lane."""

    def __init__(self, post: Post) -> None:
        self.changed: Signal[()] = Signal()
        self.closed: Signal[()] = Signal()
        self._post = post
        self.workers = {lane: Worker(partial(self._hand_over, lane)) for lane in Lane}
        self.jobs: dict[tuple[Lane, int], RunningJob] = {}
        self._refused = 0
        self._closed = False

    def submit(
        self,
        job: Job[Request, Result],
        request: Request,
        *,
        title: str,
        on_done: Callable[[Result], None],
        on_failed: Callable[[Failed], None],
        quiet: bool = False,
    ) -> RunningJob:
        """Begin a job; of its end the owner's thread is told. After `close` nothing is begun and
        nobody told."""
        lane = job.lane
        worker = self.workers[lane]
        try:
            number = worker.submit(
                job, request, lambda event: self._post(lambda: self._deliver(lane, event))
            )
        except WorkerError as error:
            # Told like every other failure, once the caller has its job.
            self._refused -= 1
            number = self._refused
            failed = Failed(number, error.as_dict(), error.exit_code)
            self._post(lambda: self._deliver(lane, failed))
        begun = RunningJob(number, title, worker, on_done, on_failed, quiet)
        if not self._closed:
            self.jobs[lane, number] = begun
            self.changed.emit()
        return begun

    def cancel(self, job: RunningJob) -> None:
        job.worker.cancel(job.number)

    def visible(self) -> list[RunningJob]:
        return [job for job in self.jobs.values() if not job.quiet]

    def _hand_over(self, lane: Lane, fault: Fault) -> None:
        self._post(lambda: self._deliver(lane, fault))

    def _deliver(self, lane: Lane, event: Event | Fault) -> None:
        job = self.jobs.get((lane, event.job))
        if self._closed:
            return
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

    def finish(self, lane: Lane, timeout_s: float) -> None:
        """Wait for what a lane is doing; nobody is told of it before the owner's loop runs."""
        self.workers[lane].finish(timeout_s)

    def close(self) -> None:
        self._closed = True
        for worker in self.workers.values():
            worker.close()
        self.closed.emit()


def _tell(who: str, fault: Fault) -> None:
    DESK.tell(
        f"{who} met a mistake of the program ({fault.what}): your project is as it was, and a "
        "report helps to mend it.",
        fault.what,
    )
