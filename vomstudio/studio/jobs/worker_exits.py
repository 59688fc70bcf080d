"""How a worker process ended, and why: from its exit status and from its last words.

A library in C++ that fails in a thread of its own ends the whole process, and says why on standard
error, with a stack of addresses. That is read here, and turned into the sentence that the same
failure has elsewhere; it is shown to nobody, unless VOMSTUDIO_DEBUG asks for it.
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

_KILLED = -9
"""By SIGKILL, as the system does where memory runs out."""
_CRASHED = {-11, -7}
"""By SIGSEGV or SIGBUS: libraries in C that get no memory and do not look."""
_LAST_LINES = 60
_LONGEST_LINE = 2000
_LINES_OF_A_CAUSE = 8
_PATIENCE_S = 2.0


class LastWords:
    """The end of what a process says on standard error, read until it ends."""

    def __init__(self, stream: IO[str]) -> None:
        self._lines: collections.deque[str] = collections.deque(maxlen=_LAST_LINES)
        self._stream = stream
        self._thread = start_thread(self._read, name="worker errors")

    def _read(self) -> None:
        shown = os.environ.get("VOMSTUDIO_DEBUG", "") not in ("", "0") and sys.stderr is not None
        with self._stream:
            while line := self._stream.readline(_LONGEST_LINE):
                self._lines.append(line)
                if shown:
                    print(line, end="", file=sys.stderr, flush=True)

    def text(self) -> str:
        """All that was said last, once the process has ended."""
        # A process that it has left behind may keep the stream open.
        self._thread.join(_PATIENCE_S)
        return "".join(list(self._lines))


def failure_of(code: int, said: str, job: Job[Any, Any], request: Any) -> VomError:
    """What a job failed of whose process ended with a status while it said `said`."""
    cause = RuntimeError(_last_word(said))
    out = getattr(request, "out", None)
    if isinstance(out, Path) and is_disk_message(cause):
        return folder_write_error(out if out.is_dir() else out.parent, cause)
    if is_memory_error(cause):
        return short_of_memory(job)
    remedy = tr("Try again.")
    if code == _KILLED:
        remedy = job.if_memory_is_short()
    elif code in _CRASHED and job.smaller:
        remedy = tr("This can be a lack of memory. {remedy}", remedy=job.if_memory_is_short())
    return WorkerError(Finding("job.worker-died", ending=ending(code), remedy=remedy))


def _last_word(said: str) -> str:
    """Without the stack of addresses, and what was said of other things before."""
    words = said.rpartition("terminate called")[2].partition("*** Aborted")[0]
    return "\n".join(words.splitlines()[-_LINES_OF_A_CAUSE:])


def short_of_memory(job: Job[Any, Any]) -> WorkerError:
    """The sentence on a job for which there is not enough memory."""
    return WorkerError(Finding("job.out-of-memory", remedy=job.if_memory_is_short()))


def ending(code: int) -> str:
    """An exit status in words."""
    if code == _KILLED:
        return tr("killed by the system, probably out of memory")
    return tr("code {code}", code=code)
