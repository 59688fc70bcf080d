"""Collector of unexpected errors from all threads, which logs, counts and forwards them."""

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
from vomstudio.core.findings import Finding, to_finding

_log = logging.getLogger(__name__)

MIN_REPEAT_INTERVAL_S = 3.0
"""Minimum interval between two reports of the same error, which may occur in every paint event."""


@dataclass(frozen=True)
class Failure:
    """Unexpected error.

    Parameters
    ----------
    finding : Finding
        Message for the user.
    what : str
        Short description of the error, such as "ValueError in tasks.py, line 40"; it identifies
        the error.
    count : int
        Number of occurrences in this session.
    """

    finding: Finding
    what: str
    count: int

    @property
    def repetitions(self) -> tuple[Finding, ...]:
        """Findings about the number of occurrences; empty if the error occurred only once."""
        return (Finding("program.repeated", count=self.count),) if self.count > 1 else ()


Listener = Callable[[Failure], None]


class ErrorCollector:
    """Collector of errors that any thread may report.

    The listener is called in the thread that reports the error and must return quickly.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._occurrences: dict[str, tuple[int, float]] = {}
        self._listener: Listener | None = None
        self._thread_state = threading.local()

    def listen(self, listener: Listener | None) -> None:
        """Forward failures to `listener` instead of the current listener; None removes it."""
        self._listener = listener

    def reset(self) -> None:
        """Reset all counts to zero."""
        with self._lock:
            self._occurrences.clear()

    def report(self, error: BaseException, context: str = "") -> bool:
        """Log, count and forward an unexpected error. Never raises.

        Parameters
        ----------
        error : BaseException
        context : str
            Context for the log.

        Returns
        -------
        bool
            Whether the error was forwarded; False if it repeats within `MIN_REPEAT_INTERVAL_S`.
        """
        description, finding = (
            "an unknown error",
            Finding("program.internal-error", error="unknown"),
        )
        with contextlib.suppress(Exception):
            description = error_location(error)
            finding = _error_finding(error, description)

        def details() -> str:
            return f"{context}\n{''.join(traceback.format_exception(error))}".strip()

        return self.report_finding(finding, description, details)

    def report_finding(
        self, finding: Finding, error_key: str, details: Callable[[], str] = str
    ) -> bool:
        """Forward an error that is identified by `error_key`, in the same way as `report`.

        Parameters
        ----------
        finding : Finding
        error_key : str
            Key of the error.
        details : callable
            Function that returns the text for the log.

        Returns
        -------
        bool
            Whether the error was forwarded, as for `report`.
        """
        if getattr(self._thread_state, "busy", False):
            # The listener itself has raised an error; avoid endless recursion.
            return False
        self._thread_state.busy = True
        try:
            return self._forward(finding, error_key, details)
        except Exception:  # noqa: BLE001 - no other way to report it is left
            return False
        finally:
            self._thread_state.busy = False

    def _forward(self, finding: Finding, error_key: str, details: Callable[[], str]) -> bool:
        now_s = self._clock()
        with self._lock:
            count, last_time_s = self._occurrences.get(error_key, (0, -float("inf")))
            count += 1
            self._occurrences[error_key] = count, now_s
        if count == 1:
            _log.error("%s", "\n".join(part for part in (error_key, details()) if part))
        elif count in (10, 100, 1000, 10_000):
            _log.error("%s: %d times by now", error_key, count)
        if now_s - last_time_s < MIN_REPEAT_INTERVAL_S:
            return False
        if self._listener is not None:
            self._listener(Failure(finding, error_key, count))
        return True


ERRORS = ErrorCollector()
"""Error collector of this process."""


def error_location(error: BaseException) -> str:
    """Return the type of an error and its location, preferably in the program's own code."""
    frames = traceback.extract_tb(error.__traceback__)
    name = type(error).__name__
    if not frames:
        return name
    package = str(Path(__file__).resolve().parents[2])
    program_frames = [frame for frame in frames if frame.filename.startswith(package)]
    frame = (program_frames or frames)[-1]
    return f"{name} in {Path(frame.filename).name}, line {frame.lineno}"


def _error_finding(error: BaseException, error_key: str) -> Finding:
    if isinstance(error, VomError):
        return to_finding(error)
    if isinstance(error, MemoryError):
        return Finding("program.memory-full")
    return Finding("program.internal-error", error=error_key)
