"""The owner's thread: how other threads post calls to it, and how calls are delayed.

A window brings its event loop; a program without one needs a queue and a clock.
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
    """Makes a call once after a delay; starting it again begins anew."""

    def start(self, seconds: float | None = None) -> None:
        """Start with this delay; None for the delay that the timer was created with."""

    def stop(self) -> None: ...

    @property
    def active(self) -> bool: ...


def in_the_way(work: Call) -> None:
    """Do work at once: an `Aside` for an owner that has nothing else to do."""
    work()


class Aside(Protocol):
    """Does long work while the owner waits for it, and goes on painting if it paints."""

    def __call__(self, work: Call) -> None:
        """Return when the work is done, in this thread or another; raise what it raises."""


class Later(Protocol):
    """Creates timers of the owner's thread."""

    def __call__(self, seconds: float, call: Call) -> Timer:
        """Create a timer, not yet started, that makes the call in the owner's thread."""
