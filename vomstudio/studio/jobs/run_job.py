"""Execution of one job in a worker process."""

from __future__ import annotations

import contextlib
import queue

from vomstudio.core.errors import Cancelled, from_dict
from vomstudio.core.progress import CancelToken, Progress
from vomstudio.studio.jobs.events import Done, Event, Failed, Stage
from vomstudio.studio.jobs.job import Job, Request, Result
from vomstudio.studio.jobs.supervisor import WorkerSupervisor

# Interval for checking whether the job was cancelled.
POLL_INTERVAL_S = 0.1


def run_job(
    job: Job[Request, Result],
    request: Request,
    progress: Progress,
    cancel: CancelToken | None = None,
) -> Result:
    """Run a job in a worker process and return its result.

    A crash of native code ends only the worker process, and raises WorkerError in the caller.
    Ctrl+C, a progress that raises Cancelled, or a token that is set in another thread stops the
    job and raises Cancelled. Errors of the job are raised unchanged.
    """
    events: queue.SimpleQueue[Event] = queue.SimpleQueue()
    worker = WorkerSupervisor()
    try:
        number = worker.submit(job, request, events.put)
        try:
            while True:
                event = _next_event(events, cancel)
                if isinstance(event, Done):
                    result: Result = event.result
                    return result
                if isinstance(event, Failed):
                    raise from_dict(event.error, event.exit_code)
                if isinstance(event, Stage):
                    progress.stage(event.name, event.total)
                else:
                    progress.step(event.done)
        except (KeyboardInterrupt, Cancelled) as error:
            worker.cancel(number)
            while not isinstance(events.get(), Done | Failed):
                pass
            raise Cancelled() from error
    finally:
        worker.close()


def _next_event(events: queue.SimpleQueue[Event], cancel: CancelToken | None) -> Event:
    """Return the next event. Raises Cancelled once the token is set."""
    while cancel is not None:
        cancel.check()
        with contextlib.suppress(queue.Empty):
            return events.get(timeout=POLL_INTERVAL_S)
    return events.get()
