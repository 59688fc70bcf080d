"""Redirection of Qt messages to the log, and of Qt warnings also to the terminal."""

from __future__ import annotations

import contextlib
import logging
import sys
import threading
from typing import Any

from PySide6.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler

_log = logging.getLogger("vomstudio.qt")
_LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtWarningMsg: logging.WARNING,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}

_thread_state = threading.local()
_previous_handlers: list[Any] = []


def install() -> None:
    _previous_handlers.append(qInstallMessageHandler(_log_message))


def uninstall() -> None:
    """Restore the previous message handler."""
    if _previous_handlers:
        qInstallMessageHandler(_previous_handlers.pop())


def _log_message(message_type: QtMsgType, context: QMessageLogContext, message: str) -> None:
    if getattr(_thread_state, "busy", False):
        return
    _thread_state.busy = True
    try:
        level = _LEVELS.get(message_type, logging.WARNING)
        category = context.category
        prefix = f"{category}: " if category and category != "default" else ""
        _log.log(level, "%s%s", prefix, message)
        if level >= logging.WARNING and sys.stderr is not None:
            with contextlib.suppress(OSError, ValueError):
                print(message, file=sys.stderr)
    finally:
        _thread_state.busy = False
