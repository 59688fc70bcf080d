"""The owner of a workspace where there is no window."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable

from vomstudio.studio.owner_thread import Call


class LoopTimer:
    def __init__(self, seconds: float, call: Call) -> None:
        self._seconds, self._call = seconds, call
        self._due: float | None = None

    def start(self, seconds: float | None = None) -> None:
        self._due = time.monotonic() + (self._seconds if seconds is None else seconds)

    def stop(self) -> None:
        self._due = None

    @property
    def is_active(self) -> bool:
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
        self._calls.put(call)

    def later(self, seconds: float, call: Call) -> LoopTimer:
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
