"""The one log file of a user, into which the window, its workers and the command line write."""

from __future__ import annotations

import contextlib
import logging
import os
from logging.handlers import RotatingFileHandler
from pathlib import Path

_BYTES = 1_000_000
_OLDER = 2
_PROGRAM = logging.getLogger("vomstudio")
# Without any handler Python would print what is logged: the command line promises one sentence.
_PROGRAM.addHandler(logging.NullHandler())

_handler: logging.Handler | None = None


def folder() -> Path:
    """Where the log and the crash traces lie, whether or not it exists yet."""
    from platformdirs import user_log_path

    return user_log_path("vomstudio", appauthor=False)


def path() -> Path:
    """The log file."""
    return folder() / "vomstudio.log"


def start(role: str) -> None:
    """Log what the program says, and the warnings of its libraries, until `stop`.

    role : which of the program's processes this is, for each line. A log that cannot be written
    must not keep anybody from working: nothing is raised.
    """
    global _handler
    if _handler is not None:
        return
    try:
        path().parent.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    _handler = _SharedFile(path())
    _handler.setLevel(logging.INFO)
    form = f"%(asctime)s {role} %(process)d %(levelname)s %(name)s: %(message)s"
    _handler.setFormatter(logging.Formatter(form, "%Y-%m-%d %H:%M:%S"))
    _PROGRAM.setLevel(logging.INFO)
    logging.getLogger().addHandler(_handler)


def stop() -> None:
    """Close the log file."""
    global _handler
    if _handler is not None:
        logging.getLogger().removeHandler(_handler)
        _handler.close()
        _handler = None
        _PROGRAM.setLevel(logging.NOTSET)


def tail(lines: int) -> str:
    """The newest lines of the log; empty where there is no log."""
    try:
        with path().open("rb") as stream:
            stream.seek(0, os.SEEK_END)
            stream.seek(max(0, stream.tell() - 400 * lines))
            text = stream.read().decode("utf-8", "replace")
    except OSError:
        return ""
    return "\n".join(text.splitlines()[-lines:])


class _SharedFile(RotatingFileHandler):
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
