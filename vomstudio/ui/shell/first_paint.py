"""Work that starts once a window is visible."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget

MAX_WAIT_MS = 1000
"""Time after which the work starts without a paint, because a minimised window is not painted."""


class FirstPaint(QObject):
    """Trigger that calls a function once, after the first paint is on the screen.

    A window manager shows a window some time after `QWidget.show` has returned. Work that started
    at once would block the event loop, and the window would stay empty until it ends.
    """

    def __init__(self, window: QWidget, callback: Callable[[], object]) -> None:
        super().__init__(window)
        self._window, self._callback = window, callback
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._run)
        self._timer.start(MAX_WAIT_MS)
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        if event.type() == QEvent.Type.Paint:
            watched.removeEventFilter(self)
            # The widgets inside the window are painted after this event.
            self._timer.start(0)
        return False

    def _run(self) -> None:
        self._window.removeEventFilter(self)
        # Sends the picture to the screen and applies the size that the window manager has chosen.
        QGuiApplication.sync()
        self._callback()
