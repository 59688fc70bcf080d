"""Calls from other threads into the thread of the window."""

from __future__ import annotations

import atexit
import threading
from functools import cache, partial

from PySide6.QtCore import QObject, Qt, Signal
from shiboken6 import isValid

from vomstudio.studio.owner_thread import Call, Post


class _Courier(QObject):
    """Carries calls into the thread that it was created in, until the program ends.

    A thread must not emit a signal of an object that a window deletes: if Qt deletes it at that
    moment, the process dies.
    """

    _called = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._called.connect(self._make, Qt.ConnectionType.QueuedConnection)
        self._sending, self._closed = threading.Lock(), False
        # Before PySide deletes the objects of Qt, which it also does at exit.
        atexit.register(self.close)

    def close(self) -> None:
        with self._sending:
            self._closed = True

    def carry(self, call: Call) -> None:
        with self._sending:
            if not self._closed:
                self._called.emit(call)

    def _make(self, call: Call) -> None:
        call()


_courier = cache(_Courier)


def poster(owner: QObject) -> Post:
    """Return a function that makes calls in the GUI thread, unless the owner has been deleted.

    Call this in the GUI thread.
    """
    return partial(_post, _courier(), owner)


def _post(courier: _Courier, owner: QObject, call: Call) -> None:
    courier.carry(partial(_unless_gone, owner, call))


def _unless_gone(owner: QObject, call: Call) -> None:
    if isValid(owner):
        call()
