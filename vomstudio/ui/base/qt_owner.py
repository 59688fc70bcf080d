"""Calls into the window's thread, which owns a workspace, through Qt's event loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import ClassVar, TypeVarTuple

from PySide6.QtCore import QEventLoop, QMetaObject, QObject, Qt, QTimer
from PySide6.QtGui import QGuiApplication
from shiboken6 import isValid

from vomstudio.core.signals import Signal
from vomstudio.core.threads import run_in_thread
from vomstudio.rendering.qt.thread_calls import poster
from vomstudio.studio.owner_thread import Call, Timer

Values = TypeVarTuple("Values")


def connect_until_deleted(
    owner: QObject, signal: Signal[*Values], slot: Callable[[*Values], object]
) -> None:
    """Connect a signal of the studio to a slot until Qt deletes the owner of the slot.

    Qt disconnects only its own signals.

    Parameters
    ----------
    owner : QObject
    signal : Signal
    slot : callable
    """
    disconnect = signal.connect(slot)
    owner.destroyed.connect(lambda *_: disconnect())


class QtTimer:
    def __init__(self, parent: QObject, seconds: float, call: Call) -> None:
        self._timer = QTimer(parent, singleShot=True)
        self._timer.timeout.connect(lambda: call())
        self._delay_s = seconds

    def start(self, seconds: float | None = None) -> None:
        self._timer.start(round(1000 * (self._delay_s if seconds is None else seconds)))

    def stop(self) -> None:
        self._timer.stop()

    @property
    def is_active(self) -> bool:
        return self._timer.isActive()


class QtOwner(QObject):
    """Implementation of the interfaces of `studio.owner_thread` with Qt's event loop."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._poster = poster(self)

    def post(self, call: Call) -> None:
        self._poster(call)

    def run_and_wait(self, work: Call) -> None:
        """Run a function in a thread while the window is painted; input is blocked."""
        loop = QEventLoop()

        def run() -> None:
            try:
                work()
            finally:
                QMetaObject.invokeMethod(loop, "quit", Qt.ConnectionType.QueuedConnection)

        QGuiApplication.setOverrideCursor(Qt.CursorShape.BusyCursor)
        try:
            future = run_in_thread(run, name="aside")
            loop.exec(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)
            future.result()
        finally:
            QGuiApplication.restoreOverrideCursor()

    def later(self, seconds: float, call: Call) -> Timer:
        return QtTimer(self, seconds, call)


class IncrementalWork:
    """Long-running task of the window's thread, done in steps between events.

    The instances take turns, with one step at a time. A step is one item of an iterator.
    """

    _running: ClassVar[list[IncrementalWork]] = []

    def __init__(self, parent: QObject) -> None:
        self._timer = QTimer(parent, singleShot=True)
        self._timer.timeout.connect(self._take_turn)
        self._work: Iterator[object] = iter(())

    @property
    def is_running(self) -> bool:
        """Whether steps remain."""
        return self in self._running

    def start(self, steps: Iterator[object]) -> None:
        """Run the first step now and the others later, cancelling an earlier task."""
        self.cancel()
        self._work = steps
        self._running.append(self)
        self._step()
        self._schedule_next()

    def cancel(self) -> None:
        """Discard the remaining steps."""
        self._timer.stop()
        self._work = iter(())
        if self.is_running:
            self._running.remove(self)
            self._schedule_next()

    def finish(self) -> None:
        """Run all remaining steps now."""
        while self.is_running:
            self._step()

    def _take_turn(self) -> None:
        if self.is_running:
            self._running.append(self._running.pop(self._running.index(self)))
            self._step()
            self._schedule_next()

    @classmethod
    def _schedule_next(cls) -> None:
        """Schedule only the first instance in the queue."""
        # The window of an instance may have been closed in the meantime.
        cls._running[:] = [item for item in cls._running if isValid(item._timer)]
        if cls._running:
            cls._running[0]._timer.start(0)

    def _step(self) -> None:
        try:
            next(self._work)
        except StopIteration:
            self.cancel()
        except BaseException:
            # Report the error once, not at every event.
            self.cancel()
            raise
