"""The log as a file that several processes write to."""

from __future__ import annotations

import contextlib
import logging
import os
from logging.handlers import RotatingFileHandler
from pathlib import Path

_BYTES = 1_000_000
_OLDER = 2


class SharedFile(RotatingFileHandler):
    """A log file that several processes write to: one of them turns it over, the others follow."""

    def __init__(self, file: Path) -> None:
        super().__init__(file, maxBytes=_BYTES, backupCount=_OLDER, encoding="utf-8", delay=True)

    def emit(self, record: logging.LogRecord) -> None:
        if self.stream is not None and self._turned_over(self.stream.fileno()):
            self.stream.close()
            self.stream = self._open()
        super().emit(record)

    def _turned_over(self, descriptor: int) -> bool:
        try:
            there, mine = os.stat(self.baseFilename), os.fstat(descriptor)
        except OSError:
            return True
        return (there.st_dev, there.st_ino) != (mine.st_dev, mine.st_ino)

    def rotate(self, source: str, dest: str) -> None:
        # Windows renames no file that another process has open: it grows until it is alone.
        with contextlib.suppress(OSError):
            super().rotate(source, dest)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - its name in logging
        """A full disk is told of where the user's own work meets it."""
