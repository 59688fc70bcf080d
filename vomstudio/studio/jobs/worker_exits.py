"""Causes of the end of a worker process, from its exit status and standard error.

A C++ library that fails in one of its threads terminates the whole process, and prints the
reason with a stack of addresses to standard error. This module extracts the reason, and returns
the same error that the failure would raise elsewhere. The output is shown only if
VOMSTUDIO_DEBUG is set.
"""

from __future__ import annotations

import collections
import os
import sys
from pathlib import Path
from typing import IO, Any

from vomstudio.core.errors import VomError, WorkerError
from vomstudio.core.files.disk_errors import folder_write_error, is_disk_message
from vomstudio.core.files.memory_limit import is_memory_error
from vomstudio.core.findings import Finding
from vomstudio.core.threads import start_thread
from vomstudio.core.words import tr
from vomstudio.studio.jobs.job import Job

_KILL_CODE = -9
"""Exit status after SIGKILL, which the system sends when memory runs out."""
_CRASH_CODES = {-11, -7}
"""Exit statuses after SIGSEGV or SIGBUS, caused by C libraries that ignore failed allocations."""
MAX_LINES = 60
MAX_LINE_LENGTH = 2000
MAX_CAUSE_LINES = 8
READ_TIMEOUT_S = 2.0


class StderrTail:
    """Last lines that a process writes to standard error before it ends."""

    def __init__(self, stream: IO[str]) -> None:
        self._lines: collections.deque[str] = collections.deque(maxlen=MAX_LINES)
        self._stream = stream
        self._thread = start_thread(self._read_lines, name="worker errors")

    def _read_lines(self) -> None:
        should_echo = (
            os.environ.get("VOMSTUDIO_DEBUG", "") not in ("", "0") and sys.stderr is not None
        )
        with self._stream:
            while line := self._stream.readline(MAX_LINE_LENGTH):
                self._lines.append(line)
                if should_echo:
                    print(line, end="", file=sys.stderr, flush=True)

    def text(self) -> str:
        """Return the last lines after the process has ended."""
        # A child process may keep the stream open.
        self._thread.join(READ_TIMEOUT_S)
        return "".join(list(self._lines))


def exit_error(code: int, stderr_text: str, job: Job[Any, Any], request: Any) -> VomError:
    """Return the error of a job whose process ended with a given status and output."""
    cause = RuntimeError(_last_line(stderr_text))
    out = getattr(request, "out", None)
    if isinstance(out, Path) and is_disk_message(cause):
        return folder_write_error(out if out.is_dir() else out.parent, cause)
    if is_memory_error(cause):
        return out_of_memory_error(job)
    remedy = tr("Try again.")
    if code == _KILL_CODE:
        remedy = job.memory_advice()
    elif code in _CRASH_CODES and job.memory_hint:
        remedy = tr("This may be caused by a lack of memory. {remedy}", remedy=job.memory_advice())
    return WorkerError(Finding("job.worker-died", ending=exit_text(code), remedy=remedy))


def _last_line(stderr_text: str) -> str:
    """Return the reason in the last lines of stderr, without the stack of addresses."""
    error_text = stderr_text.rpartition("terminate called")[2].partition("*** Aborted")[0]
    return "\n".join(error_text.splitlines()[-MAX_CAUSE_LINES:])


def out_of_memory_error(job: Job[Any, Any]) -> WorkerError:
    """Return the error for a job that ran out of memory."""
    return WorkerError(Finding("job.out-of-memory", remedy=job.memory_advice()))


def exit_text(code: int) -> str:
    """Describe an exit status."""
    if code == _KILL_CODE:
        return tr("killed by the system, probably for lack of memory")
    return tr("exit code {code}", code=code)
