"""Owner's thread: calls that other threads post to it, and delayed calls.

A window uses its event loop; a program without one needs a queue and a clock.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

Call = Callable[[], object]

PICTURE_FIRST_S = 1.0
"""Delay of unrequested work after something has been opened: a thread that imports or builds keeps
the interpreter from the drawing thread, whatever its priority."""


class Post(Protocol):
    """Passes calls to the owner's thread."""

    def __call__(self, call: Call) -> None:
        """Make a call in the owner's thread, in the order of the posts. For any thread."""


class Timer(Protocol):
    """Makes a call once after a delay; `start` restarts the delay."""

    def start(self, seconds: float | None = None) -> None:
        """Start with a delay, by default that of the timer's creation."""

    def stop(self) -> None: ...

    @property
    def active(self) -> bool: ...


def run_immediately(work: Call) -> None:
    """Run the work at once: an `BlockingRunner` for an owner without an event loop."""
    work()


class BlockingRunner(Protocol):
    """Runs long work while the owner waits for it but continues to paint."""

    def __call__(self, work: Call) -> None:
        """Return when the work is done, in this thread or another; raise its errors."""


class Later(Protocol):
    """Creates timers of the owner's thread."""

    def __call__(self, seconds: float, call: Call) -> Timer:
        """Create a stopped timer for a call in the owner's thread."""
