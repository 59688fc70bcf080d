"""A worker process and the jobs it has been given."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

from vomstudio.errors import Cancelled, WorkerError
from vomstudio.jobs.events import Done, Event, Failed, from_line

Listener = Callable[[Event], None]

# Native code that does not look at its token is stopped the hard way after this long.
_GRACE_S = 3.0


class Worker:
    """Runs jobs in a child process, one after the other. A child that dies fails its jobs with a
    WorkerError and is replaced for the next one.

    Listeners are called in a thread of the supervisor; each job's last event is Done or Failed.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._numbers = itertools.count(1)
        self._process: subprocess.Popen[str] | None = None
        self._listeners: dict[int, Listener] = {}
        self._timers: dict[int, threading.Timer] = {}
        self._closed = False

    def submit(self, task: str, args: Mapping[str, Any], listener: Listener) -> int:
        """Returns the job's number."""
        with self._lock:
            job = next(self._numbers)
            self._listeners[job] = listener
            try:
                self._write({"job": job, "task": task, "args": dict(args)})
            except OSError as error:
                self._listeners.pop(job)
                raise WorkerError(f"the worker process cannot be started: {error}") from error
            return job

    def cancel(self, job: int) -> None:
        """Ask a job to stop; if it does not listen, its process is ended."""
        with self._lock:
            if job not in self._listeners or job in self._timers:
                return
            with contextlib.suppress(OSError):
                self._write({"cancel": job})
            timer = threading.Timer(_GRACE_S, self._kill, args=(job,))
            timer.daemon = True
            self._timers[job] = timer
            timer.start()

    def close(self) -> None:
        """End the process; unfinished jobs are not told."""
        with self._lock:
            self._closed = True
            self._listeners.clear()
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
    def _write(self, command: Mapping[str, Any]) -> None:
        if self._process is None or self._process.poll() is not None:
            self._start()
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(command) + "\n")
        self._process.stdin.flush()

    def _start(self) -> None:
        environment = dict(os.environ)
        # The child finds the same package, wherever the window was started from.
        environment["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "vomstudio", "--worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            env=environment,
        )
        threading.Thread(target=self._read, args=(self._process,), daemon=True).start()

    def _read(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            try:
                self._deliver(from_line(line))
            except ValueError:
                continue
        process.wait()
        process.stdout.close()
        self._died(process)

    def _deliver(self, event: Event) -> None:
        with self._lock:
            listener = self._listeners.get(event.job)
            if isinstance(event, Done | Failed):
                self._listeners.pop(event.job, None)
                if timer := self._timers.pop(event.job, None):
                    timer.cancel()
        if listener is not None:
            listener(event)

    def _died(self, process: subprocess.Popen[str]) -> None:
        with self._lock:
            if self._closed or self._process is not process:
                return
            self._process = None
            lost = list(self._listeners)
            cancelled = set(self._timers)
        for job in lost:
            fault = (
                Cancelled()
                if job in cancelled
                else WorkerError(
                    f"the worker process ended unexpectedly (code {process.returncode}); "
                    "nothing of the project is lost, try again"
                )
            )
            self._deliver(Failed(job, fault.as_dict(), fault.exit_code))

    def _kill(self, job: int) -> None:
        with self._lock:
            process = self._process if job in self._listeners else None
        if process is not None:
            process.kill()
