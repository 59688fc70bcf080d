"""Collects the program's unexpected errors from all threads: logs, counts and passes them on."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, finding_of

_log = logging.getLogger(__name__)

QUIET_S = 3.0
"""An error that repeats, as in every paint, is passed on again only after a pause this long."""


@dataclass(frozen=True)
class Failure:
    """An unexpected error.

    finding : for the user
    what : the error in a few words, such as "ValueError in tasks.py, line 40"; its key
    count : how often it has happened in this run
    """

    finding: Finding
    what: str
    count: int

    @property
    def repetitions(self) -> tuple[Finding, ...]:
        """How often it has happened, if more than once."""
        return (Finding("program.repeated", count=self.count),) if self.count > 1 else ()


Listener = Callable[[Failure], None]


class ErrorCollector:
    """Any thread may report; the listener is called in that thread and must only pass on."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._seen: dict[str, tuple[int, float]] = {}
        self._listener: Listener | None = None
        self._here = threading.local()

    def listen(self, listener: Listener | None) -> None:
        """Pass failures on to `listener` in place of the present one; None for nobody."""
        self._listener = listener

    def forget(self) -> None:
        """Set all counts to zero."""
        with self._lock:
            self._seen.clear()

    def report(self, error: BaseException, where: str = "") -> bool:
        """Log and count an unexpected error, and pass it on; `where` is for the log. True where it
        was passed on, False where it repeats one. Never raises."""
        what, finding = "an unknown error", Finding("program.internal-error", error="unknown")
        with contextlib.suppress(Exception):
            what = place_of(error)
            finding = _finding_of(error, what)

        def details() -> str:
            return f"{where}\n{''.join(traceback.format_exception(error))}".strip()

        return self.tell(finding, what, details)

    def tell(self, finding: Finding, what: str, details: Callable[[], str] = str) -> bool:
        """Pass on an error that is identified by `what`; see `report`."""
        if getattr(self._here, "busy", False):
            # Passing an error on has raised another one: it must not recur for ever.
            return False
        self._here.busy = True
        try:
            return self._tell(finding, what, details)
        except Exception:  # noqa: BLE001 - nothing is left that could report it
            return False
        finally:
            self._here.busy = False

    def _tell(self, finding: Finding, what: str, details: Callable[[], str]) -> bool:
        now = self._clock()
        with self._lock:
            count, last = self._seen.get(what, (0, -float("inf")))
            count += 1
            self._seen[what] = count, now
        if count == 1:
            _log.error("%s", "\n".join(part for part in (what, details()) if part))
        elif count in (10, 100, 1000, 10_000):
            _log.error("%s: %d times by now", what, count)
        if now - last < QUIET_S:
            return False
        if self._listener is not None:
            self._listener(Failure(finding, what, count))
        return True


ERRORS = ErrorCollector()
"""The collector of this process."""


def place_of(error: BaseException) -> str:
    """The error's kind and the line that raised it, of the program's own where there is one."""
    frames = traceback.extract_tb(error.__traceback__)
    name = type(error).__name__
    if not frames:
        return name
    package = str(Path(__file__).resolve().parents[2])
    own = [frame for frame in frames if frame.filename.startswith(package)]
    frame = (own or frames)[-1]
    return f"{name} in {Path(frame.filename).name}, line {frame.lineno}"


def _finding_of(error: BaseException, what: str) -> Finding:
    if isinstance(error, VomError):
        return finding_of(error)
    if isinstance(error, MemoryError):
        return Finding("program.memory-full")
    return Finding("program.internal-error", error=what)
