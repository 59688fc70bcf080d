"""Rotating log file that several processes write to."""

from __future__ import annotations

import contextlib
import logging
import os
from logging.handlers import RotatingFileHandler
from pathlib import Path

_MAX_BYTES = 1_000_000
_MAX_OLD_FILES = 2


class SharedFile(RotatingFileHandler):
    """Log file shared by several processes: one of them rotates it, and the others reopen it."""

    def __init__(self, file: Path) -> None:
        super().__init__(
            file, maxBytes=_MAX_BYTES, backupCount=_MAX_OLD_FILES, encoding="utf-8", delay=True
        )

    def emit(self, record: logging.LogRecord) -> None:
        if self.stream is not None and self._is_rotated(self.stream.fileno()):
            self.stream.close()
            self.stream = self._open()
        super().emit(record)

    def _is_rotated(self, descriptor: int) -> bool:
        try:
            current_status, opened_status = os.stat(self.baseFilename), os.fstat(descriptor)
        except OSError:
            return True
        return (current_status.st_dev, current_status.st_ino) != (
            opened_status.st_dev,
            opened_status.st_ino,
        )

    def rotate(self, source: str, dest: str) -> None:
        # Windows cannot rename a file that another process has open; the file continues to grow
        # until then.
        with contextlib.suppress(OSError):
            super().rotate(source, dest)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - its name in logging
        """Ignore errors: a full disk is reported when the user's work is saved."""
