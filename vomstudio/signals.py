"""Telling others that something has happened, without knowing them. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVarTuple

Values = TypeVarTuple("Values")


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
        for listener in tuple(self._listeners):
            listener(*values)
