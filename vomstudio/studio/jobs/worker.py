"""Worker process that receives jobs and sends events.

Commands arrive as JSON lines on stdin; events are sent as JSON lines to the original stdout.
Because libraries print to descriptor 1, it is redirected to stderr first. End of file on stdin
ends the process, so that no worker outlives a killed window.
"""

from __future__ import annotations

import json
import locale
import os
import queue
import signal
import sys
import threading
import traceback
from typing import Any, TextIO

from vomstudio.core.errors import VomError, WorkerError
from vomstudio.core.failures import crashes, exception_hooks
from vomstudio.core.failures.error_collector import ERRORS
from vomstudio.core.failures.lifeline import end_with_parent
from vomstudio.core.files import memory_limit
from vomstudio.core.findings import Finding
from vomstudio.core.progress import CancelToken
from vomstudio.core.threads import start_thread
from vomstudio.core.words import tr
from vomstudio.studio.jobs.events import Done, Event, Failed, InternalError, Stage, Step, to_line
from vomstudio.studio.jobs.job import Job
from vomstudio.studio.jobs.tasks import find_task
from vomstudio.studio.jobs.worker_exits import out_of_memory_error


class _Reporter:
    """Progress that is reported as events."""

    def __init__(self, job: int, token: CancelToken, send: Any) -> None:
        self._job, self._token, self._send = job, token, send

    def stage(self, name: str, total: int | None = None) -> None:
        self._token.check()
        self._send(Stage(self._job, name, total))

    def step(self, done_count: int) -> None:
        self._token.check()
        self._send(Step(self._job, done_count))


def main() -> int:
    """Serve jobs until stdin ends, and return the exit status."""
    # Ctrl+C in a terminal may reach every process; only the parent decides what to stop.
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    end_with_parent()
    memory_limit.enable_limits()
    # Some native readers misread decimal points in a locale with decimal commas.
    locale.setlocale(locale.LC_NUMERIC, "C")
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lock = threading.Lock()

    def send(event: Event | InternalError) -> None:
        with lock:
            out.write(to_line(event))
            out.flush()

    job = 0
    exception_hooks.install(crashes.WORKER)
    ERRORS.listen(lambda failure: send(InternalError(job, failure.what)))
    jobs: queue.SimpleQueue[tuple[int, str, dict[str, Any], CancelToken]] = queue.SimpleQueue()
    start_thread(_listen, sys.stdin, jobs, name="commands")
    while True:
        job = 0
        task: Job[Any, Any] | None = None
        job, name, args, token = jobs.get()
        try:
            token.check()
            task = find_task(name)
            if task is None:
                raise WorkerError(Finding("job.unknown-task", task=name))
            with memory_limit.limit_to_free_memory():
                result = task.run_plain(args, _Reporter(job, token, send))
            send(Done(job, result))
        except VomError as error:
            send(Failed(job, error.to_dict(), error.exit_code))
        except BrokenPipeError:
            exception_hooks.uninstall()
            return 0
        except Exception as error:  # noqa: BLE001  a worker answers for every job it was given
            if task is not None and memory_limit.is_memory_error(error):
                job_error = out_of_memory_error(task)
                send(Failed(job, job_error.to_dict(), job_error.exit_code))
                continue
            traceback.print_exc(file=sys.stderr)
            ERRORS.report(error, tr("in the task {task}", task=name))
            job_error = WorkerError(
                Finding("job.failed", task=name, type=type(error).__name__, error=error)
            )
            send(Failed(job, job_error.to_dict(), job_error.exit_code))


def _listen(stdin: TextIO, jobs: queue.SimpleQueue[Any]) -> None:
    tokens: dict[int, CancelToken] = {}
    for line in stdin:
        try:
            command = json.loads(line)
            if "cancel" in command:
                if token := tokens.get(command["cancel"]):
                    token.cancel()
                continue
            job = (command["job"], command["task"], command["args"])
        except (ValueError, KeyError, TypeError) as error:
            # This thread must survive, because it detects that the window has been closed.
            print(f"not a command: {line[:80]!r} ({error})", file=sys.stderr)
            continue
        token = tokens[job[0]] = CancelToken()
        jobs.put((*job, token))
    exception_hooks.uninstall()
    os._exit(0)
