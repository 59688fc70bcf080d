"""Limits on what reading a file, or a job, may take of memory, as the last net.

Readers look at what a file declares before they make room for it, and jobs on photos choose a size
that fits. Where one of them, or a library beneath it, is wrong nevertheless, it gets a MemoryError
here, instead of the memory that all programs of the machine share. Only on Linux, where a process
can be held to private memory alone (RLIMIT_DATA, getrlimit(2)), and only in processes that are this
program's own.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from vomstudio.core.files.available_memory import free_bytes, held_bytes, machine_bytes

_FREE = 1 << 30
"""For libraries that are loaded and kernels that are compiled meanwhile."""
_PER_BYTE = 128
"""The richest sound files: points of LAZ of a byte and a half are eighty bytes, held twice."""
_PER_BYTE_OF = {".tif": 2064, ".tiff": 2064}
"""Deflate's 1032 for flat ground, twice."""
_PER_PROCESSOR = 64 << 20
"""Stacks and heaps of the threads that libraries start, hardly any of which is ever touched."""

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
    try:
        with _held_to(limit):
            yield
    finally:
        _lock.release()


@contextlib.contextmanager
def limited_to_what_is_free() -> Iterator[None]:
    """Inside, this process gets no more memory than there is now, swap included: for a worker,
    which the system would otherwise end, or another program in its place. A file that is read
    inside may be limited further."""
    held, free = held_bytes(), free_bytes()
    if not _ours or held is None or free is None:
        yield
        return
    with _held_to(held + free + _FREE + _PER_PROCESSOR * (os.cpu_count() or 1)):
        yield


def is_shortage(error: BaseException) -> bool:
    """Whether an error says that memory is short: libraries in C++ say it in words of their own."""
    if isinstance(error, MemoryError):
        return True
    if isinstance(error, OSError) and error.errno == errno.ENOMEM:
        return True
    return any(words in str(error) for words in _SAID_OF_MEMORY)


_SAID_OF_MEMORY = (
    "bad_alloc",
    "bad allocation",
    "Insufficient memory",
    "Cannot allocate memory",
    "can't start new thread",
    "Resource temporarily unavailable",
    "out of memory",
    "cannot map zero-fill pages",
    "failed to map segment",
    "cannot allocate memory",
)
"""Of the C++ library, OpenCV, the system, Python, CUDA, and the loader of libraries."""


@contextlib.contextmanager
def _held_to(limit: int) -> Iterator[None]:
    """Inside, this process gets no more private memory than so many bytes, or than before."""
    import resource

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


def _limit(path: Path) -> int | None:
    """Bytes of private memory, or None where the system cannot hold a process to it."""
    held, all_there_is = held_bytes(), machine_bytes()
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
