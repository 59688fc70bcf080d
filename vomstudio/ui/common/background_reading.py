"""Short work, such as reading a file, done in a thread so that the window stays responsive."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, QRunnable, QThreadPool

from vomstudio.failures import exception_hooks
from vomstudio.ui.common.qt_owner import poster

Work = Callable[[], object]
Then = Callable[[object], None]


class Background(QObject):
    """Runs work in a thread and passes what it returns to a function in the GUI's thread, unless
    the owner is gone by then. Work must not raise; expected errors are returned. An exception is
    reported as a fault of the program, and nothing is passed on."""

    def __init__(self, owner: QObject) -> None:
        super().__init__(owner)
        self._closed = False
        self._post = poster(self)

    def run(self, work: Work, then: Then) -> None:
        """Do `work` in a thread, then call `then` with its result in the GUI's thread."""
        QThreadPool.globalInstance().start(_Task(work, partial(self._hand_over, then)))

    def close(self) -> None:
        """No result is passed on any more."""
        self._closed = True

    def _hand_over(self, then: Then, made: object) -> None:
        """From the thread."""
        self._post(partial(self._deliver, then, made))

    def _deliver(self, then: Then, made: object) -> None:
        if not self._closed:
            then(made)


class _Task(QRunnable):
    def __init__(self, work: Work, hand_over: Then) -> None:
        super().__init__()
        self._work, self._hand_over = work, hand_over

    def run(self) -> None:
        try:
            made = self._work()
        except Exception as error:  # noqa: BLE001 - a thread of Qt's has nobody above it
            exception_hooks.report_as_uncaught(error)
            return
        self._hand_over(made)
