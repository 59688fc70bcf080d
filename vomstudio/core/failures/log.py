"""Per-user log file, shared by the window, its workers and the command line."""

from __future__ import annotations

import logging
import os
from pathlib import Path

_PROGRAM_LOGGER = logging.getLogger("vomstudio")
# Without a handler, Python prints log messages to the terminal, but a command prints only one
# sentence.
_PROGRAM_LOGGER.addHandler(logging.NullHandler())

_handler: logging.Handler | None = None


def folder() -> Path:
    """Return the folder of the log and the crash traces; it may not exist yet."""
    from platformdirs import user_log_path

    return user_log_path("vomstudio", appauthor=False)


def path() -> Path:
    """Return the path of the log file."""
    return folder() / "vomstudio.log"


def start(role: str) -> None:
    """Log the program's messages and the warnings of its libraries until `stop` is called.

    No error is raised if the log cannot be written.

    Parameters
    ----------
    role : str
        Role of this process, which is written into each line.
    """
    global _handler
    if _handler is not None:
        return
    _handler = _LazyHandler()
    _handler.setLevel(logging.INFO)
    format_string = f"%(asctime)s {role} %(process)d %(levelname)s %(name)s: %(message)s"
    _handler.setFormatter(logging.Formatter(format_string, "%Y-%m-%d %H:%M:%S"))
    _PROGRAM_LOGGER.setLevel(logging.INFO)
    logging.getLogger().addHandler(_handler)


def stop() -> None:
    """Close the log file."""
    global _handler
    if _handler is not None:
        logging.getLogger().removeHandler(_handler)
        _handler.close()
        _handler = None
        _PROGRAM_LOGGER.setLevel(logging.NOTSET)


def tail(lines: int) -> str:
    """Return the last lines of the log, or an empty text if it is missing or unreadable."""
    try:
        with path().open("rb") as stream:
            stream.seek(0, os.SEEK_END)
            stream.seek(max(0, stream.tell() - 400 * lines))
            text = stream.read().decode("utf-8", "replace")
    except OSError:
        return ""
    return "\n".join(text.splitlines()[-lines:])


class _LazyHandler(logging.Handler):
    """Handler that opens the log when the first message arrives.

    Most commands log nothing, and importing the rotating file handler takes time.
    """

    def __init__(self) -> None:
        super().__init__()
        self._file: logging.Handler | None = None
        self._is_opened = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self._is_opened:
            self._is_opened = True
            self._file = self._open_file()
        if self._file is not None:
            self._file.handle(record)

    def _open_file(self) -> logging.Handler | None:
        try:
            path().parent.mkdir(parents=True, exist_ok=True)
        except OSError:
            return None
        from vomstudio.core.failures.log_file import SharedFile

        file = SharedFile(path())
        file.setFormatter(self.formatter)
        return file

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
        super().close()
