"""The window's thread as the owner of a workspace: Qt's event loop makes the calls."""

from __future__ import annotations

import contextlib
import threading

from PySide6.QtCore import QEventLoop, QMetaObject, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication

from vomstudio.workspace.owner_thread import Call, Timer


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
    """`post` and `later` as `workspace.owner_thread` describes them."""

    _posted = Signal(object)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._posted.connect(self._make, Qt.ConnectionType.QueuedConnection)

    def post(self, call: Call) -> None:
        # The window may be gone, and Qt's side of this with it.
        with contextlib.suppress(RuntimeError):
            self._posted.emit(call)

    def _make(self, call: Call) -> None:
        call()

    def aside(self, work: Call) -> None:
        """In a thread, while the window is painted and its timers run; keys and the mouse wait."""
        loop, failed = QEventLoop(), []

        def run() -> None:
            try:
                work()
            except BaseException as error:  # noqa: BLE001 - raised where the work is waited for
                failed.append(error)
            finally:
                QMetaObject.invokeMethod(loop, "quit", Qt.ConnectionType.QueuedConnection)

        thread = threading.Thread(target=run, name="aside", daemon=True)
        QGuiApplication.setOverrideCursor(Qt.CursorShape.BusyCursor)
        try:
            thread.start()
            loop.exec(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)
            thread.join()
        finally:
            QGuiApplication.restoreOverrideCursor()
        if failed:
            raise failed[0]

    def later(self, seconds: float, call: Call) -> Timer:
        return QtTimer(self, seconds, call)
