"""A limit on what reading a file may take of memory, as the last net.

Readers look at what a file declares before they make room for it. Where one of them, or a library
beneath it, believes a file nevertheless, it gets a MemoryError here, instead of the memory that all
programs of the machine share. Only on Linux, where a process can be held to private memory alone
(RLIMIT_DATA, getrlimit(2)), and only in processes that are this program's own.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path

_FREE = 1 << 30
"""For libraries that are loaded and kernels that are compiled meanwhile."""
_PER_BYTE = 128
"""The richest sound files: points of LAZ of a byte and a half are eighty bytes, held twice."""
_PER_BYTE_OF = {".tif": 2064, ".tiff": 2064}
"""Deflate's 1032 for flat ground, twice."""

_lock = threading.Lock()
_ours = False


def take_charge() -> None:
    """This process is the program's own: its readers are limited from now on."""
    global _ours
    _ours = True


@contextlib.contextmanager
def limited_by(path: Path) -> Iterator[None]:
    """Inside, this process gets no more memory than a file of its size, read, can be worth."""
    limit = _limit(path) if _ours else None
    # One limit at a time: it is the process's.
    if limit is None or not _lock.acquire(blocking=False):
        yield
        return
    import resource

    try:
        before = resource.getrlimit(resource.RLIMIT_DATA)
        if before[0] != resource.RLIM_INFINITY:
            limit = min(limit, before[0])
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_DATA, (limit, before[1]))
        try:
            yield
        finally:
            with contextlib.suppress(OSError, ValueError):
                resource.setrlimit(resource.RLIMIT_DATA, before)
    finally:
        _lock.release()


def _limit(path: Path) -> int | None:
    """Bytes of private memory, or None where the system cannot hold a process to it."""
    held = _number("/proc/self/status", "VmData")
    all_there_is = _number("/proc/meminfo", "MemTotal")
    if held is None or all_there_is is None:
        return None
    try:
        size = path.stat().st_size
        if path.suffix.lower() == ".gltf":
            # What it describes lies beside it.
            size = sum(entry.stat().st_size for entry in os.scandir(path.parent))
    except OSError:
        return None
    worth = _FREE + size * _PER_BYTE_OF.get(path.suffix.lower(), _PER_BYTE)
    return held + min(worth, all_there_is)


def _number(file: str, name: str) -> int | None:
    """Bytes of a line of /proc."""
    try:
        for line in Path(file).read_text(encoding="ascii").splitlines():
            if line.startswith(name):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return None
