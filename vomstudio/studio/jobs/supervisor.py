"""Supervisor of a worker process and its jobs."""

from __future__ import annotations

import contextlib
import itertools
import json
import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from vomstudio.core.errors import Cancelled, VomError, WorkerError
from vomstudio.core.failures.lifeline import Lifeline
from vomstudio.core.findings import Finding
from vomstudio.core.paths import import_folders
from vomstudio.core.threads import start_thread, start_timer
from vomstudio.core.words import tr
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.events import Done, Event, Failed, InternalError, from_line
from vomstudio.studio.jobs.job import Job, Request, Result
from vomstudio.studio.jobs.worker_exits import StderrTail, exit_error, exit_text

Listener = Callable[[Event], None]
_log = logging.getLogger(__name__)

# Delay after which native code that ignores its cancel token is killed.
CANCEL_GRACE_S = 2.0


class WorkerSupervisor:
    """Supervisor that runs jobs one after another in a child process.

    If the child process dies, its jobs fail with a WorkerError, and the next job starts a new
    process. Listeners are called in a thread of the supervisor. The last event of each job is
    Done, with the result dataclass of the job, or Failed.
    """

    def __init__(self, on_internal_error: Callable[[InternalError], None] = lambda _: None) -> None:
        """Create a supervisor, which starts a process when needed.

        Parameters
        ----------
        on_internal_error : callable
            Receives each program defect in the child process, before the job concerned ends.
        """
        self._on_internal_error = on_internal_error
        self._lock = threading.RLock()
        self._numbers = itertools.count(1)
        self._process: subprocess.Popen[str] | None = None
        self._listeners: dict[int, Listener] = {}
        self._jobs: dict[int, tuple[Job[Any, Any], Any]] = {}
        self._owners: dict[int, subprocess.Popen[str]] = {}
        self._timers: dict[int, threading.Timer] = {}
        self._released_process: subprocess.Popen[str] | None = None
        self._is_closed = False

    def submit(self, job: Job[Request, Result], request: Request, listener: Listener) -> int:
        """Submit a job and return its number.

        Raises
        ------
        WorkerError
            If the request cannot be converted, no process can be started, or `close` was called.
        """
        args = serialisation.encode(request)
        with self._lock:
            if self._is_closed:
                raise WorkerError(Finding("job.closing"))
            number = next(self._numbers)
            command = {"job": number, "task": job.name, "args": args}
            try:
                try:
                    owner = self._write(command)
                except BrokenPipeError:
                    # The process is ending, and the reading thread has not noticed this yet.
                    self._process = None
                    owner = self._write(command)
            except OSError as error:
                raise WorkerError(Finding("job.no-worker", reason=error)) from error
            self._listeners[number], self._owners[number] = listener, owner
            self._jobs[number] = (job, request)
            return number

    def cancel(self, job: int) -> None:
        """Request that a job stops; its process is killed if it does not react."""
        with self._lock:
            if job not in self._listeners or job in self._timers:
                return
            stdin = self._owners[job].stdin
            assert stdin is not None
            with contextlib.suppress(OSError):
                stdin.write(json.dumps({"cancel": job}) + "\n")
                stdin.flush()
            self._schedule_kill(job)

    def _schedule_kill(self, job: int) -> None:
        self._timers[job] = start_timer(CANCEL_GRACE_S, self._kill, job)

    def finish(self, timeout_s: float) -> bool:
        """Wait for at most `timeout_s` until all jobs have ended, and return whether they have."""
        end = time.monotonic() + timeout_s
        while self._owners:
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def release(self) -> None:
        """End the process unless a job is running, to free its memory.

        The next job starts another process.
        """
        with self._lock:
            if self._owners or self._process is None:
                return
            process, self._process = self._process, None
            self._released_process = process
            assert process.stdin is not None
            with contextlib.suppress(OSError):
                process.stdin.close()

    def close(self) -> None:
        """End the process without further events for unfinished jobs."""
        with self._lock:
            self._is_closed = True
            self._listeners.clear()
            self._owners.clear()
            self._jobs.clear()
            for timer in self._timers.values():
                timer.cancel()
            process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.close()
        try:
            process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    # ------------------------------------------------------------------------------------------
    def _write(self, command: Mapping[str, Any]) -> subprocess.Popen[str]:
        """Send a command to the process, which is started if necessary, and return the process."""
        process = self._process
        if process is None or process.poll() is not None:
            process = self._process = self._start()
        assert process.stdin is not None
        process.stdin.write(json.dumps(command) + "\n")
        process.stdin.flush()
        return process

    def _start(self) -> subprocess.Popen[str]:
        environment = dict(os.environ)
        environment["PYTHONPATH"] = os.pathsep.join(import_folders())
        lifeline = Lifeline()
        environment.update(lifeline.environment())
        try:
            process = subprocess.Popen(
                # -P: a json.py beside the photos must not replace Python's own module.
                [sys.executable, "-P", "-m", "vomstudio", "--worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                errors="replace",
                env=environment,
                pass_fds=lifeline.descriptors,
            )
        except OSError:
            lifeline.close()
            raise
        lifeline.close_child_end()
        assert process.stderr is not None
        stderr_tail = StderrTail(process.stderr)
        start_thread(self._read_events, process, lifeline, stderr_tail, name="worker output")
        return process

    def _read_events(
        self, process: subprocess.Popen[str], lifeline: Lifeline, stderr_tail: StderrTail
    ) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            try:
                event = from_line(line)
            except ValueError:
                continue
            if isinstance(event, InternalError):
                self._on_internal_error(event)
            else:
                self._deliver(event)
        process.wait()
        lifeline.close()
        process.stdout.close()
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.close()
        self._handle_exit(process, stderr_tail.text())

    def _deliver(self, event: Event) -> None:
        with self._lock:
            listener = self._listeners.get(event.job)
            if isinstance(event, Done | Failed):
                entry = self._jobs.pop(event.job, None)
                self._listeners.pop(event.job, None)
                self._owners.pop(event.job, None)
                if timer := self._timers.pop(event.job, None):
                    timer.cancel()
        if listener is None:
            return
        if isinstance(event, Done) and entry is not None:
            event = _decode_result(event, entry[0].result)
        listener(event)

    def _handle_exit(self, process: subprocess.Popen[str], stderr_text: str) -> None:
        with self._lock:
            if self._process is process:
                self._process = None
            # Jobs that were submitted after the process had died have another process.
            lost_jobs = [job for job, owner in self._owners.items() if owner is process]
            cancelled = set(self._timers)
            is_expected = self._is_closed or process is self._released_process
        if not is_expected and not cancelled.intersection(lost_jobs):
            ending_text = exit_text(process.returncode)
            _log.error("the worker process %d ended (%s)", process.pid, ending_text)
            self._on_internal_error(
                InternalError(
                    lost_jobs[0] if lost_jobs else 0,
                    tr("the worker process ended: {ending}", ending=ending_text),
                )
            )
        for job in lost_jobs:
            error: VomError = Cancelled()
            if job not in cancelled and (entry := self._jobs.get(job)):
                error = exit_error(process.returncode, stderr_text, *entry)
            self._deliver(Failed(job, error.to_dict(), error.exit_code))

    def _kill(self, job: int) -> None:
        with self._lock:
            process = self._owners.get(job)
            if process is None:
                return
            if (
                min(job_number for job_number, owner in self._owners.items() if owner is process)
                < job
            ):
                # The job is queued behind one that was not cancelled.
                self._schedule_kill(job)
                return
        process.kill()


def _decode_result(event: Done, result: type[Any]) -> Event:
    try:
        return Done(event.job, serialisation.decode(result, event.result))
    except WorkerError as error:
        return Failed(event.job, error.to_dict(), error.exit_code)
