"""Where every mistake of the program arrives, from whichever thread: logged, counted, told on."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.errors import VomError

_log = logging.getLogger(__name__)

QUIET_S = 3.0
"""What happens over and over, as in every paint, is told of again only after it has paused."""


@dataclass(frozen=True)
class Failure:
    """sentence : for a person
    what : the mistake itself in a few words, such as "ValueError in tasks.py, line 40"
    count : how often it has happened in this run
    """

    sentence: str
    what: str
    count: int


Listener = Callable[[Failure], None]


class Desk:
    """Any thread may call; the listener is called in that thread and must only hand on."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._seen: dict[str, tuple[int, float]] = {}
        self._listener: Listener | None = None
        self._here = threading.local()

    def listen(self, listener: Listener | None) -> None:
        """Who tells the user, in place of whoever did."""
        self._listener = listener

    def forget(self) -> None:
        """Count anew."""
        with self._lock:
            self._seen.clear()

    def report(self, error: BaseException, where: str = "") -> bool:
        """An error that nobody expected; `where` is for the log. True where it has been told of,
        False where it is one of many. Never raises."""
        what, sentence = "an unknown error", _sentence("")
        with contextlib.suppress(Exception):
            what = place_of(error)
            sentence = _sentence_of(error, what)

        def details() -> str:
            return f"{where}\n{''.join(traceback.format_exception(error))}".strip()

        return self.tell(sentence, what, details)

    def tell(self, sentence: str, what: str, details: Callable[[], str] = str) -> bool:
        """A mistake that is known by `what`; see `report`."""
        if getattr(self._here, "busy", False):
            # Telling of a mistake has made another one: it must not go round and round.
            return False
        self._here.busy = True
        try:
            return self._tell(sentence, what, details)
        except Exception:  # noqa: BLE001 - there is nobody left to tell
            return False
        finally:
            self._here.busy = False

    def _tell(self, sentence: str, what: str, details: Callable[[], str]) -> bool:
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
        if count > 1:
            sentence += f" (It has happened {count} times.)"
        if self._listener is not None:
            self._listener(Failure(sentence, what, count))
        return True


DESK = Desk()
"""The process's own."""


def place_of(error: BaseException) -> str:
    """The error's kind and the line that raised it, of the program's own where there is one."""
    frames = traceback.extract_tb(error.__traceback__)
    name = type(error).__name__
    if not frames:
        return name
    package = str(Path(__file__).resolve().parents[1])
    own = [frame for frame in frames if frame.filename.startswith(package)]
    frame = (own or frames)[-1]
    return f"{name} in {Path(frame.filename).name}, line {frame.lineno}"


def _sentence_of(error: BaseException, what: str) -> str:
    if isinstance(error, VomError):
        return str(error)
    if isinstance(error, MemoryError):
        return "There is not enough memory for what you did last; close other programs, try again."
    return _sentence(what)


def _sentence(what: str) -> str:
    """The journal is written before anything is shown, so that all that was seen is kept."""
    named = f" ({what})" if what else ""
    return (
        f"The program made a mistake{named}: what you did last may be missing, all before it is "
        "kept, and a report helps to mend it."
    )
