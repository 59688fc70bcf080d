"""Signals that call listeners unknown to the sender, without Qt."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVarTuple

Values = TypeVarTuple("Values")


class _Notifications(threading.local):
    """State of the notifications in a thread.

    Attributes
    ----------
    depth : int
        Number of nested notifications, because a listener may emit another signal.
    callbacks : dict
        Functions to call after the outermost notification, in order.
    """

    def __init__(self) -> None:
        self.depth = 0
        self.callbacks: dict[Callable[[], object], None] = {}


_notifications = _Notifications()


@contextmanager
def group_notifications() -> Iterator[None]:
    """Group notifications: `call_after_notifications` takes effect at the end of the block."""
    _notifications.depth += 1
    try:
        yield
    finally:
        try:
            while _notifications.depth == 1 and _notifications.callbacks:
                callback = next(iter(_notifications.callbacks))
                del _notifications.callbacks[callback]
                callback()
        finally:
            _notifications.depth -= 1


def call_after_notifications(callback: Callable[[], object]) -> None:
    """Call a function after all running notifications, or immediately if none is running.

    The function is called once, even if it is passed several times in the meantime.
    """
    if _notifications.depth:
        _notifications.callbacks[callback] = None
    else:
        callback()


class Signal(Generic[*Values]):
    """List of listeners, which are called in the order in which they were connected.

    `Signal[Edit]` passes an edit, `Signal[str, int]` passes two values, and `Signal[()]` passes
    none.
    """

    def __init__(self) -> None:
        self._listeners: list[Callable[[*Values], object]] = []

    def connect(self, listener: Callable[[*Values], object]) -> Callable[[], None]:
        """Add a listener and return a function that disconnects it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def emit(self, *values: *Values) -> None:
        """Call all listeners with the values."""
        with group_notifications():
            for listener in tuple(self._listeners):
                listener(*values)
