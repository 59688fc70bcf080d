"""A worker process and the jobs it has been given."""

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
from vomstudio.studio.jobs.events import Done, Event, Failed, Fault, from_line
from vomstudio.studio.jobs.job import Job, Request, Result
from vomstudio.studio.jobs.worker_exits import LastWords, ending, failure_of

Listener = Callable[[Event], None]
_log = logging.getLogger(__name__)

# Native code that does not look at its token is stopped the hard way after this long.
_GRACE_S = 2.0


class Worker:
    """Runs jobs in a child process, one after the other. A child that dies fails its jobs with a
    WorkerError and is replaced for the next one.

    Listeners are called in a thread of the supervisor; each job's last event is Done, with the
    dataclass that the job answers with, or Failed.
    """

    def __init__(self, on_fault: Callable[[Fault], None] = lambda _: None) -> None:
        """on_fault : told, like a listener, of each mistake of the program in the child, before the
        end of the job that it concerns"""
        self._on_fault = on_fault
        self._lock = threading.RLock()
        self._numbers = itertools.count(1)
        self._process: subprocess.Popen[str] | None = None
        self._listeners: dict[int, Listener] = {}
        self._jobs: dict[int, tuple[Job[Any, Any], Any]] = {}
        self._owners: dict[int, subprocess.Popen[str]] = {}
        self._timers: dict[int, threading.Timer] = {}
        self._closed = False

    def submit(self, job: Job[Request, Result], request: Request, listener: Listener) -> int:
        """Returns the job's number. Raises WorkerError where the request cannot cross, or no
        process can be had for it."""
        args = serialisation.encode(request)
        with self._lock:
            if self._closed:
                raise WorkerError(Finding("job.closing"))
            number = next(self._numbers)
            command = {"job": number, "task": job.name, "args": args}
            try:
                try:
                    owner = self._write(command)
                except BrokenPipeError:
                    # It is dying, and nobody has noticed yet.
                    self._process = None
                    owner = self._write(command)
            except OSError as error:
                raise WorkerError(Finding("job.no-worker", reason=error)) from error
            self._listeners[number], self._owners[number] = listener, owner
            self._jobs[number] = (job, request)
            return number

    def cancel(self, job: int) -> None:
        """Ask a job to stop; if it does not listen, its process is ended."""
        with self._lock:
            if job not in self._listeners or job in self._timers:
                return
            stdin = self._owners[job].stdin
            assert stdin is not None
            with contextlib.suppress(OSError):
                stdin.write(json.dumps({"cancel": job}) + "\n")
                stdin.flush()
            self._end_later(job)

    def _end_later(self, job: int) -> None:
        self._timers[job] = start_timer(_GRACE_S, self._kill, job)

    def finish(self, timeout_s: float) -> bool:
        """Wait until every job has ended; False where some have not."""
        end = time.monotonic() + timeout_s
        while self._owners:
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def close(self) -> None:
        """End the process; unfinished jobs are not told."""
        with self._lock:
            self._closed = True
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
        """Give the command to a living process, which is returned."""
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
                # -P: a json.py beside the photos is not Python's.
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
        words = LastWords(process.stderr)
        start_thread(self._read, process, lifeline, words, name="worker output")
        return process

    def _read(self, process: subprocess.Popen[str], lifeline: Lifeline, words: LastWords) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            try:
                event = from_line(line)
            except ValueError:
                continue
            if isinstance(event, Fault):
                self._on_fault(event)
            else:
                self._deliver(event)
        process.wait()
        lifeline.close()
        process.stdout.close()
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.close()
        self._died(process, words.text())

    def _deliver(self, event: Event) -> None:
        with self._lock:
            listener = self._listeners.get(event.job)
            if isinstance(event, Done | Failed):
                asked = self._jobs.pop(event.job, None)
                self._listeners.pop(event.job, None)
                self._owners.pop(event.job, None)
                if timer := self._timers.pop(event.job, None):
                    timer.cancel()
        if listener is None:
            return
        if isinstance(event, Done) and asked is not None:
            event = _typed(event, asked[0].result)
        listener(event)

    def _died(self, process: subprocess.Popen[str], said: str) -> None:
        with self._lock:
            if self._process is process:
                self._process = None
            # Jobs that came after the death have a process of their own.
            lost = [job for job, owner in self._owners.items() if owner is process]
            cancelled, closed = set(self._timers), self._closed
        if not closed and not cancelled.intersection(lost):
            how = ending(process.returncode)
            _log.error("the worker process %d ended (%s)", process.pid, how)
            self._on_fault(
                Fault(lost[0] if lost else 0, tr("its process ended, {ending}", ending=how))
            )
        for job in lost:
            fault: VomError = Cancelled()
            if job not in cancelled and (asked := self._jobs.get(job)):
                fault = failure_of(process.returncode, said, *asked)
            self._deliver(Failed(job, fault.to_dict(), fault.exit_code))

    def _kill(self, job: int) -> None:
        with self._lock:
            process = self._owners.get(job)
            if process is None:
                return
            if min(each for each, owner in self._owners.items() if owner is process) < job:
                # It only waits behind a job that nobody has cancelled.
                self._end_later(job)
                return
        process.kill()


def _typed(event: Done, result: type[Any]) -> Event:
    try:
        return Done(event.job, serialisation.decode(result, event.result))
    except WorkerError as error:
        return Failed(event.job, error.to_dict(), error.exit_code)
