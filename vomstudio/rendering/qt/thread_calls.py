"""Calls that other threads post to the thread of the window."""

from __future__ import annotations

import atexit
import threading
from functools import cache, partial

from PySide6.QtCore import QObject, Qt, Signal
from shiboken6 import isValid

from vomstudio.studio.owner_thread import Call, Post


class _Courier(QObject):
    """Passes calls to the thread in which it was created, until the program ends.

    A thread must not emit a signal of an object that a window may delete: if Qt deletes the
    object at that moment, the process crashes.
    """

    _call_requested = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._call_requested.connect(self._make, Qt.ConnectionType.QueuedConnection)
        self._sending, self._is_closed = threading.Lock(), False
        # Runs before PySide deletes the Qt objects, as it also does at exit.
        atexit.register(self.close)

    def close(self) -> None:
        with self._sending:
            self._is_closed = True

    def carry(self, call: Call) -> None:
        with self._sending:
            if not self._is_closed:
                self._call_requested.emit(call)

    def _make(self, call: Call) -> None:
        call()


_courier = cache(_Courier)


def poster(owner: QObject) -> Post:
    """Return a function that posts calls to the GUI thread while the owner exists.

    `poster` itself must be called in the GUI thread.
    """
    return partial(_post, _courier(), owner)


def _post(courier: _Courier, owner: QObject, call: Call) -> None:
    courier.carry(partial(_unless_gone, owner, call))


def _unless_gone(owner: QObject, call: Call) -> None:
    if isValid(owner):
        call()
