"""Short work, such as reading a file, done in a thread so that the window stays responsive."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from PySide6.QtCore import QObject, QRunnable, Qt, QThreadPool, Signal

from vomstudio.failures import exception_hooks

Work = Callable[[], object]
Then = Callable[[object], None]


class Background(QObject):
    """Runs work in a thread and passes what it returns to a function in the GUI's thread, unless
    the owner is gone by then. Work must not raise; expected errors are returned. An exception is
    reported as a fault of the program, and nothing is passed on."""

    _done = Signal(object, object)

    def __init__(self, owner: QObject) -> None:
        super().__init__(owner)
        self._closed = False
        self._done.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    def run(self, work: Work, then: Then) -> None:
        """Do `work` in a thread, then call `then` with its result in the GUI's thread."""
        QThreadPool.globalInstance().start(_Task(self, work, then))

    def close(self) -> None:
        """No result is passed on any more."""
        self._closed = True

    def _deliver(self, then: Then, made: object) -> None:
        if not self._closed:
            then(made)


class _Task(QRunnable):
    def __init__(self, owner: Background, work: Work, then: Then) -> None:
        super().__init__()
        self._owner, self._work, self._then = owner, work, then

    def run(self) -> None:
        try:
            made = self._work()
        except Exception as error:  # noqa: BLE001 - a thread of Qt's has nobody above it
            exception_hooks.report_as_uncaught(error)
            return
        # The window may be gone, and Qt's side of the owner with it.
        with contextlib.suppress(RuntimeError):
            self._owner._done.emit(self._then, made)
