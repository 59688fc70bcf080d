"""Calls that other threads post to the thread of the window."""

from __future__ import annotations

import atexit
import threading
from functools import cache, partial

from PySide6.QtCore import QObject, Qt, Signal
from shiboken6 import isValid

from vomstudio.studio.owner_thread import Call, Post


class _CallDispatcher(QObject):
    """Dispatcher of calls to the thread in which it was created, until the program ends.

    A thread must not emit a signal of an object that a window may delete: if Qt deletes the
    object at that moment, the process crashes.
    """

    _call_requested = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._call_requested.connect(self._run_call, Qt.ConnectionType.QueuedConnection)
        self._lock, self._is_closed = threading.Lock(), False
        # Runs before PySide deletes the Qt objects, as it also does at exit.
        atexit.register(self.close)

    def close(self) -> None:
        with self._lock:
            self._is_closed = True

    def dispatch(self, call: Call) -> None:
        with self._lock:
            if not self._is_closed:
                self._call_requested.emit(call)

    def _run_call(self, call: Call) -> None:
        call()


_get_dispatcher = cache(_CallDispatcher)


def poster(owner: QObject) -> Post:
    """Return a function that posts calls to the GUI thread while the owner exists.

    `poster` itself must be called in the GUI thread.
    """
    return partial(_post, _get_dispatcher(), owner)


def _post(dispatcher: _CallDispatcher, owner: QObject, call: Call) -> None:
    dispatcher.dispatch(partial(_call_if_alive, owner, call))


def _call_if_alive(owner: QObject, call: Call) -> None:
    if isValid(owner):
        call()
