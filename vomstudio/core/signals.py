"""Telling others that something has happened, without knowing them. No Qt."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVarTuple

Values = TypeVarTuple("Values")


class _Telling(threading.local):
    """depth : of the signals that are being told in this thread, one of which brought the next
    about; waiting : what is to be done once all are told"""

    def __init__(self) -> None:
        self.depth = 0
        self.waiting: dict[Callable[[], object], None] = {}


_telling = _Telling()


@contextmanager
def telling() -> Iterator[None]:
    """What belongs together is told inside; what `once_told` is asked for is done at its end."""
    _telling.depth += 1
    try:
        yield
    finally:
        try:
            while _telling.depth == 1 and _telling.waiting:
                do = next(iter(_telling.waiting))
                del _telling.waiting[do]
                do()
        finally:
            _telling.depth -= 1


def once_told(do: Callable[[], object]) -> None:
    """Do something once all listeners have been told of what is being told, however often it is
    asked for meanwhile; at once if nothing is."""
    if _telling.depth:
        _telling.waiting[do] = None
    else:
        do()


class Signal(Generic[*Values]):
    """A list of listeners; they are told in the order in which they came.

    `Signal[Edit]` tells of an edit, `Signal[str, int]` of two things, `Signal[()]` of nothing but
    that it has happened.
    """

    def __init__(self) -> None:
        self._listeners: list[Callable[[*Values], object]] = []

    def connect(self, listener: Callable[[*Values], object]) -> Callable[[], None]:
        """Returns the call that disconnects it again."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def emit(self, *values: *Values) -> None:
        with telling():
            for listener in tuple(self._listeners):
                listener(*values)
