"""The window's thread as the owner of a workspace: Qt's event loop makes the calls."""

from __future__ import annotations

import contextlib

from PySide6.QtCore import QObject, Qt, QTimer, Signal

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

    def later(self, seconds: float, call: Call) -> Timer:
        return QtTimer(self, seconds, call)
