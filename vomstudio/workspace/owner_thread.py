"""The thread that owns a workspace: how other threads post calls to it, and how calls are delayed.

A window uses Qt's event loop, a program without a window a `Loop`.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from typing import Protocol

Call = Callable[[], object]


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


class Later(Protocol):
    """Makes timers of the owner's thread."""

    def __call__(self, seconds: float, call: Call) -> Timer:
        """A timer, not yet started, that makes the call in the owner's thread."""


class LoopTimer:
    """A `Timer` that a `Loop` looks after."""

    def __init__(self, seconds: float, call: Call) -> None:
        self._seconds, self._call = seconds, call
        self._due: float | None = None

    def start(self, seconds: float | None = None) -> None:
        self._due = time.monotonic() + (self._seconds if seconds is None else seconds)

    def stop(self) -> None:
        self._due = None

    @property
    def active(self) -> bool:
        return self._due is not None

    def look(self) -> None:
        """Make the call where its time has come."""
        if self._due is not None and time.monotonic() >= self._due:
            self._due = None
            self._call()


class Loop:
    """The owner of a workspace without a window: calls are made while it runs."""

    def __init__(self) -> None:
        self._calls: queue.SimpleQueue[Call] = queue.SimpleQueue()
        self._timers: list[LoopTimer] = []

    def post(self, call: Call) -> None:
        """See `Post`."""
        self._calls.put(call)

    def later(self, seconds: float, call: Call) -> LoopTimer:
        """See `Later`."""
        timer = LoopTimer(seconds, call)
        self._timers.append(timer)
        return timer

    def run_until(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Make the calls that come until `done`; False where it was not in time."""
        end = time.monotonic() + timeout_s
        while not done():
            if time.monotonic() > end:
                return False
            try:
                call = self._calls.get(timeout=0.02)
            except queue.Empty:
                call = None
            if call is not None:
                call()
            for timer in self._timers:
                timer.look()
        return True
