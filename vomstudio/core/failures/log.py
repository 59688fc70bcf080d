"""The one log file of a user, into which the window, its workers and the command line write."""

from __future__ import annotations

import logging
import os
from pathlib import Path

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
    _handler = _Waiting()
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


class _Waiting(logging.Handler):
    """Opens the log when there is something to say: most commands have nothing, and what turns log
    files over takes time to import."""

    def __init__(self) -> None:
        super().__init__()
        self._file: logging.Handler | None = None
        self._tried = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self._tried:
            self._tried = True
            self._file = self._opened()
        if self._file is not None:
            self._file.handle(record)

    def _opened(self) -> logging.Handler | None:
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
