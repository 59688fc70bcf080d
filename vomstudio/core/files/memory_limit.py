"""Memory limits for readers and jobs, as a last safeguard.

Readers check the sizes that a file declares before they allocate memory, and jobs on photos select
a size that fits into memory. If a reader, a job or a library does not do so, it gets a MemoryError
instead of exhausting the memory of the machine. The limits apply only on Linux, where the private
memory of a process can be limited (RLIMIT_DATA, getrlimit(2)), and only in processes of the
program itself.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from vomstudio.core.files.available_memory import free_bytes, machine_bytes, private_bytes

_ALLOWANCE_BYTES = 1 << 30
"""Allowance for libraries that are loaded and kernels that are compiled in the meantime."""
_BYTES_PER_FILE_BYTE = 128
"""Maximum for valid files: LAZ points of 1.5 bytes need 80 bytes in memory and are stored twice.
"""
_BYTES_PER_FILE_BYTE_BY_SUFFIX = {".tif": 2064, ".tiff": 2064}
"""Maximum compression ratio of Deflate (1032), reached by flat terrain that is stored twice."""
_BYTES_PER_PROCESSOR = 64 << 20
"""Stacks and heaps reserved by the threads of libraries, most of which remain unused."""

_lock = threading.Lock()
_is_enabled = False


def enable_limits() -> None:
    """Enable the limits in this process, which must be a process of the program itself."""
    global _is_enabled
    _is_enabled = True


@contextlib.contextmanager
def limit_for_file(path: Path) -> Iterator[None]:
    """Limit the memory of this process according to the size of a file while it is read."""
    limit = _file_limit(path) if _is_enabled else None
    # The limit applies to the whole process, so there can be only one at a time.
    if limit is None or not _lock.acquire(blocking=False):
        yield
        return
    try:
        with _limit_private_memory(limit):
            yield
    finally:
        _lock.release()


@contextlib.contextmanager
def limit_to_free_memory() -> Iterator[None]:
    """Limit the memory of this process to the free memory, including swap.

    Otherwise the operating system would end this or another process. Reading a file inside the
    block may lower the limit.
    """
    used_private_bytes, available_bytes = private_bytes(), free_bytes()
    if not _is_enabled or used_private_bytes is None or available_bytes is None:
        yield
        return
    with _limit_private_memory(
        used_private_bytes
        + available_bytes
        + _ALLOWANCE_BYTES
        + _BYTES_PER_PROCESSOR * (os.cpu_count() or 1)
    ):
        yield


def is_memory_error(error: BaseException) -> bool:
    """Return whether an error, possibly reported as text, is due to a lack of memory."""
    if isinstance(error, MemoryError):
        return True
    if isinstance(error, OSError) and error.errno == errno.ENOMEM:
        return True
    return any(text in str(error) for text in _MEMORY_MESSAGES)


_MEMORY_MESSAGES = (
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
"""Messages of the C++ library, OpenCV, the system, Python, CUDA and the library loader."""


@contextlib.contextmanager
def _limit_private_memory(limit: int) -> Iterator[None]:
    """Limit the private memory of this process in bytes, without raising an existing limit."""
    import resource

    previous_limits = resource.getrlimit(resource.RLIMIT_DATA)
    if previous_limits[0] != resource.RLIM_INFINITY:
        limit = min(limit, previous_limits[0])
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_DATA, (limit, previous_limits[1]))
    try:
        yield
    finally:
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_DATA, previous_limits)


def _file_limit(path: Path) -> int | None:
    """Return the limit of private memory in bytes, or None if it cannot be determined."""
    used_private_bytes, machine_memory_bytes = private_bytes(), machine_bytes()
    if used_private_bytes is None or machine_memory_bytes is None:
        return None
    try:
        size = path.stat().st_size
        if path.suffix.lower() == ".gltf":
            # The buffers and textures are separate files in the same folder.
            size = sum(entry.stat().st_size for entry in os.scandir(path.parent))
    except OSError:
        return None
    needed_bytes = _ALLOWANCE_BYTES + size * _BYTES_PER_FILE_BYTE_BY_SUFFIX.get(
        path.suffix.lower(), _BYTES_PER_FILE_BYTE
    )
    return used_private_bytes + min(needed_bytes, machine_memory_bytes)
