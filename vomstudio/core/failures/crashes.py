"""Traces of native crashes: Python's faulthandler writes them while the process dies.

Each process has a file of its own, empty until it crashes, and takes it away when it ends well.
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
_TOLD = "told"
_KEPT = 5

_file: TextIO | None = None


def folder() -> Path:
    """Where traces lie, whether or not it exists."""
    return log.folder() / "crashes"


def begin(role: str) -> None:
    """Write a trace if this process crashes, until `end`. role : WINDOW or WORKER."""
    global _file
    name = f"{role}-{os.getpid()}-{time.strftime('%Y%m%d%H%M%S')}.txt"
    try:
        folder().mkdir(parents=True, exist_ok=True)
        # Open as long as the process lives: the system's own signal handler writes to it.
        _file = (folder() / name).open("w", encoding="utf-8")
    except OSError:
        return
    faulthandler.enable(_file, all_threads=True)


def end() -> None:
    """The process ends well: remove its empty file."""
    global _file
    if _file is None:
        return
    faulthandler.disable()
    _file.close()
    with contextlib.suppress(OSError):
        Path(_file.name).unlink(missing_ok=True)
    _file = None


def newly_found() -> bool:
    """Whether a window has crashed since the last call. Removes old and empty files."""
    found = False
    for file in _files("*.txt"):
        role, pid = file.name.split("-")[:2]
        # A number that is longer than those of processes is none of ours.
        if not (pid.isascii() and pid.isdigit() and len(pid) < 10) or _runs(int(pid)):
            continue
        with contextlib.suppress(OSError):
            if file.stat().st_size == 0:
                # Ended by force: there is nothing to learn from it.
                file.unlink()
                continue
            found = found or role == WINDOW
            file.rename(file.with_suffix(f".{_TOLD}"))
    for old in _files(f"*.{_TOLD}")[:-_KEPT]:
        with contextlib.suppress(OSError):
            old.unlink()
    return found


def _runs(pid: int) -> bool:
    # Every start comes here, and the library takes its time.
    if pid == os.getpid():
        return True
    import psutil

    return bool(psutil.pid_exists(pid))


def texts() -> list[tuple[str, str]]:
    """Role and trace of each crash, the oldest first."""
    found = []
    for file in _files("*"):
        with contextlib.suppress(OSError):
            if text := file.read_text(encoding="utf-8", errors="replace").strip():
                found.append((file.name.split("-")[0], text))
    return found[-_KEPT:]


def _files(pattern: str) -> list[Path]:
    return sorted(
        (file for file in folder().glob(pattern) if file.name.count("-") == 2),
        key=lambda file: file.name.rsplit("-", 1)[1],
    )
