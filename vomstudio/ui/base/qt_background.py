"""Background tasks of widgets, which keep the window responsive."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer
from shiboken6 import isValid

from vomstudio.core.errors import VomError
from vomstudio.core.threads import PROCESSOR_COUNT
from vomstudio.rendering.qt.thread_calls import poster
from vomstudio.studio.background import Background

Task = Callable[[], Any]

_SLOW_DELAY_MS = 200
_REQUEST_KEY = "newest"


class QtBackground(Background):
    """Background tasks of a widget, which also stop when Qt deletes the widget."""

    def __init__(
        self, owner: QObject, name: str = "background", *, threads: int = PROCESSOR_COUNT
    ) -> None:
        super().__init__(poster(owner), name, threads=threads)
        self._owner = owner

    @property
    def is_stopped(self) -> bool:
        """Whether the tasks have been stopped or the widget has been deleted."""
        return super().is_stopped or not isValid(self._owner)


class LatestRequestRunner:
    """Runner of one function at a time that delivers only the newest result.

    Parameters
    ----------
    owner : QObject
        Object whose deletion by Qt stops the runner.
    finished_callback, fail : callable
        Called with the result or the error.
    slow_callback : callable
        Called after 0.2 s without a result.
    """

    def __init__(
        self,
        owner: QObject,
        finished_callback: Callable[[Any], object],
        fail: Callable[[VomError], object],
        slow_callback: Callable[[], None],
    ) -> None:
        self._background = QtBackground(owner)
        self._finished_callback, self._fail = finished_callback, fail
        self._slow_timer = QTimer(owner, singleShot=True, interval=_SLOW_DELAY_MS)
        self._slow_timer.timeout.connect(slow_callback)

    @property
    def is_waiting(self) -> bool:
        """Whether a result is pending."""
        return self._background.is_waiting(_REQUEST_KEY)

    def run_now(self, task: Task) -> None:
        """Cancel earlier requests and run a short function in the calling thread."""
        self.cancel()
        try:
            result = task()
        except VomError as error:
            self._fail(error)
        else:
            self._finished_callback(result)

    def request(self, task: Task) -> None:
        """Cancel earlier requests and run a function in a worker thread."""
        if not self.is_waiting:
            self._slow_timer.start()
        self._background.run(
            task,
            partial(self._deliver_result, self._finished_callback),
            partial(self._deliver_result, self._fail),
            key=_REQUEST_KEY,
        )

    def cancel(self) -> None:
        """Cancel earlier requests."""
        self._slow_timer.stop()
        self._background.cancel(_REQUEST_KEY)

    def close(self) -> None:
        """Stop the delivery of results."""
        self.cancel()
        self._background.stop()

    def _deliver_result(self, finished_callback: Callable[[Any], object], result: object) -> None:
        self._slow_timer.stop()
        finished_callback(result)
