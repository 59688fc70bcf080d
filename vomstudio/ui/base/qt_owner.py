"""The window's thread as the owner of a workspace: Qt's event loop makes the calls."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from PySide6.QtCore import QEventLoop, QMetaObject, QObject, Qt, QTimer
from PySide6.QtGui import QGuiApplication
from shiboken6 import isValid

from vomstudio.core.threads import run_in_thread
from vomstudio.rendering.qt.thread_calls import poster
from vomstudio.studio.owner_thread import Call, Timer


class QtTimer:
    def __init__(self, parent: QObject, seconds: float, call: Call) -> None:
        self._timer = QTimer(parent)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(lambda: call())
        self._seconds = seconds

    def start(self, seconds: float | None = None) -> None:
        self._timer.start(round(1000 * (self._seconds if seconds is None else seconds)))

    def stop(self) -> None:
        self._timer.stop()

    @property
    def active(self) -> bool:
        return self._timer.isActive()


class QtOwner(QObject):
    """`post` and `later` as `studio.owner_thread` describes them."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._poster = poster(self)

    def post(self, call: Call) -> None:
        self._poster(call)

    def aside(self, work: Call) -> None:
        """Work in a thread while the window is painted and its timers run; input waits."""
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
    """Long work of the window's own thread, done in portions between the events, so that the window
    answers meanwhile: one portion of all that is under way at a time, each in its turn. A portion
    is what an iterator does for one of its items."""

    _under_way: ClassVar[list[IncrementalWork]] = []

    def __init__(self, parent: QObject) -> None:
        self._timer = QTimer(parent)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self._in_turn)
        self._work: Iterator[object] = iter(())

    @property
    def is_running(self) -> bool:
        """Whether some of the work is left."""
        return self in self._under_way

    def begin(self, work: Iterator[object]) -> None:
        """Do the first portion at once and the others by and by, in place of what was left of
        earlier work."""
        self.drop()
        self._work = work
        self._under_way.append(self)
        self._step()
        self._next()

    def drop(self) -> None:
        """Leave what is left undone: nobody wants it any more."""
        self._timer.stop()
        self._work = iter(())
        if self.is_running:
            self._under_way.remove(self)
            self._next()

    def finish(self) -> None:
        """Do what is left at once: something is wanted that needs all of it."""
        while self.is_running:
            self._step()

    def _in_turn(self) -> None:
        if self.is_running:
            self._under_way.append(self._under_way.pop(self._under_way.index(self)))
            self._step()
            self._next()

    @classmethod
    def _next(cls) -> None:
        """Let the first in the line be called at the next events, and only that one."""
        # A window that was closed meanwhile has left its place.
        cls._under_way[:] = [each for each in cls._under_way if isValid(each._timer)]
        if cls._under_way:
            cls._under_way[0]._timer.start(0)

    def _step(self) -> None:
        try:
            next(self._work)
        except StopIteration:
            self.drop()
        except BaseException:
            # Told like any failure, and not once more at every event.
            self.drop()
            raise
