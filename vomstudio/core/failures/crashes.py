"""Traces of native crashes, written by Python's faulthandler while the process dies.

Each process has its own file, which is empty until the process crashes and is removed when the
process exits normally.
"""

from __future__ import annotations

import contextlib
import faulthandler
import os
import time
from pathlib import Path
from typing import TextIO

from vomstudio.core.failures import log

WINDOW, WORKER = "window", "worker"
_REPORTED_SUFFIX = "told"
_MAX_FILES = 5

_file: TextIO | None = None


def folder() -> Path:
    """Return the folder of the crash traces, which may not exist."""
    return log.folder() / "crashes"


def begin(role: str) -> None:
    """Enable a trace of native crashes of this process until `end` is called.

    No error is raised if the file cannot be created.

    Parameters
    ----------
    role : str
        `WINDOW` or `WORKER`.
    """
    global _file
    name = f"{role}-{os.getpid()}-{time.strftime('%Y%m%d%H%M%S')}.txt"
    try:
        folder().mkdir(parents=True, exist_ok=True)
        # Stays open as long as the process lives because the signal handler writes to it.
        _file = (folder() / name).open("w", encoding="utf-8")
    except OSError:
        return
    faulthandler.enable(_file, all_threads=True)


def end() -> None:
    """Remove the empty trace file when the process exits normally."""
    global _file
    if _file is None:
        return
    faulthandler.disable()
    _file.close()
    with contextlib.suppress(OSError):
        Path(_file.name).unlink(missing_ok=True)
    _file = None


def has_new_crash() -> bool:
    """Return whether a window has crashed since the last call, and remove old and empty files."""
    has_crashed = False
    for file in _files("*.txt"):
        role, pid = file.name.split("-")[:2]
        # A longer number is not a process ID.
        if not (pid.isascii() and pid.isdigit() and len(pid) < 10) or _is_running(int(pid)):
            continue
        with contextlib.suppress(OSError):
            if file.stat().st_size == 0:
                # The process was killed without a trace.
                file.unlink()
                continue
            has_crashed = has_crashed or role == WINDOW
            file.rename(file.with_suffix(f".{_REPORTED_SUFFIX}"))
    for old_report in _files(f"*.{_REPORTED_SUFFIX}")[:-_MAX_FILES]:
        with contextlib.suppress(OSError):
            old_report.unlink()
    return has_crashed


def _is_running(pid: int) -> bool:
    # This runs at every start, and importing psutil is slow.
    if pid == os.getpid():
        return True
    import psutil

    return bool(psutil.pid_exists(pid))


def texts() -> list[tuple[str, str]]:
    """Return the role and the trace of each of the last crashes, the oldest first."""
    crashes = []
    for file in _files("*"):
        with contextlib.suppress(OSError):
            if text := file.read_text(encoding="utf-8", errors="replace").strip():
                crashes.append((file.name.split("-")[0], text))
    return crashes[-_MAX_FILES:]


def _files(pattern: str) -> list[Path]:
    return sorted(
        (file for file in folder().glob(pattern) if file.name.count("-") == 2),
        key=lambda file: file.name.rsplit("-", 1)[1],
    )
