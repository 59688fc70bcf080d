"""Interfaces to the owner's thread: calls posted from other threads and delayed calls.

A window implements them with its event loop; a program without one needs a queue and a clock.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

Call = Callable[[], object]

FIRST_PICTURE_DELAY_S = 1.0
"""Delay of background work after a project or model has been opened. A thread that imports modules
or compiles code blocks the drawing thread, whatever its priority."""


class Post(Protocol):
    """Callable that passes calls to the owner's thread."""

    def __call__(self, call: Call) -> None:
        """Schedule a call in the owner's thread; calls keep their order. Thread-safe."""


class Timer(Protocol):
    """Timer that makes a call once after a delay; `start` restarts the delay."""

    def start(self, seconds: float | None = None) -> None:
        """Start the timer with a delay, by default the delay given at its creation."""

    def stop(self) -> None: ...

    @property
    def is_active(self) -> bool: ...


def run_immediately(work: Call) -> None:
    """Run a task immediately; the `BlockingRunner` of an owner without an event loop."""
    work()


class BlockingRunner(Protocol):
    """Callable that runs a long task while its owner waits and continues to paint."""

    def __call__(self, work: Call) -> None:
        """Run a task in this thread or another, return when it is done, and raise its errors."""


class TimerFactory(Protocol):
    """Factory of timers in the owner's thread."""

    def __call__(self, seconds: float, call: Call) -> Timer:
        """Create a stopped timer for a call in the owner's thread."""
