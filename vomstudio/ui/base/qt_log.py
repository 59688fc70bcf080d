"""What Qt itself says goes into the log, and its warnings to the terminal as before."""

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

_here = threading.local()
_before: list[Any] = []


def install() -> None:
    _before.append(qInstallMessageHandler(_take))


def uninstall() -> None:
    """Whoever heard Qt before hears it again."""
    if _before:
        qInstallMessageHandler(_before.pop())


def _take(kind: QtMsgType, context: QMessageLogContext, message: str) -> None:
    if getattr(_here, "busy", False):
        return
    _here.busy = True
    try:
        level = _LEVELS.get(kind, logging.WARNING)
        category = context.category
        where = f"{category}: " if category and category != "default" else ""
        _log.log(level, "%s%s", where, message)
        if level >= logging.WARNING and sys.stderr is not None:
            with contextlib.suppress(OSError, ValueError):
                print(message, file=sys.stderr)
    finally:
        _here.busy = False
