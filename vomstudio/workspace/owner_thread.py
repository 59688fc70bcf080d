"""The thread that owns a workspace: how other threads post calls to it, and how calls are delayed.

A window brings its event loop; a program without one needs a queue and a clock.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

Call = Callable[[], object]

PICTURE_FIRST_S = 1.0
"""After something has been opened, what nobody waits for waits so long: a thread that imports or
builds keeps Python from the one that draws, however low its priority."""


class Post(Protocol):
    """Hands calls over to the owner's thread."""

    def __call__(self, call: Call) -> None:
        """From any thread: `call` is made in the owner's, in the order of the posts."""


class Timer(Protocol):
    """Calls once when its time is over; starting it again begins anew."""

    def start(self, seconds: float | None = None) -> None:
        """seconds : this time, None for as long as it was made for"""

    def stop(self) -> None: ...

    @property
    def active(self) -> bool: ...


def in_the_way(work: Call) -> None:
    """An `Aside` for an owner that has nothing else to do."""
    work()


class Aside(Protocol):
    """Does work that takes long while the owner waits for it, and goes on painting if it paints."""

    def __call__(self, work: Call) -> None:
        """The work is done when this returns, maybe in another thread; what it raises is raised."""


class Later(Protocol):
    """Makes timers of the owner's thread."""

    def __call__(self, seconds: float, call: Call) -> Timer:
        """A timer, not yet started, that makes the call in the owner's thread."""
