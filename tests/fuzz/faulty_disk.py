"""A disk that fails on demand: `faulty_disk.c`, loaded before the C library.

A process that is started with `environment(...)` has it; in it `fail` says where, when and how.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

_SOURCE = Path(__file__).with_suffix(".c")


def unavailable_reason() -> str | None:
    """Why there can be no faulty disk here; None where there can."""
    if not sys.platform.startswith("linux"):
        return "disks fail on demand on Linux only"
    return None if shutil.which("cc") else "there is no C compiler"


def library() -> Path:
    """The compiled library, made once for each version of its source."""
    import hashlib

    name = hashlib.sha256(_SOURCE.read_bytes()).hexdigest()[:16]
    made = Path(tempfile.gettempdir()) / f"faulty-disk-{os.getuid()}-{name}.so"
    if not made.is_file():
        part = made.with_suffix(f".{os.getpid()}.part")
        subprocess.run(
            ["cc", "-O1", "-shared", "-fPIC", "-o", str(part), str(_SOURCE), "-ldl"], check=True
        )
        part.replace(made)
    return made


def environment() -> dict[str, str]:
    """For a process whose disk can fail."""
    return {**os.environ, "LD_PRELOAD": str(library())}


def is_loaded() -> bool:
    """Whether the disk of this process can fail."""
    return os.environ.get("LD_PRELOAD", "") == str(library())


@contextlib.contextmanager
def fail(folder: Path, at: int, number: int, *, goes_on: bool) -> Iterator[None]:
    """Inside, the writing call number `at` below a folder fails with an errno, and all later ones
    if it `goes_on`; 0 for none."""
    disk = ctypes.CDLL(None)
    disk.faulty_disk_set(os.fsencode(folder), ctypes.c_long(at), number, int(goes_on))
    try:
        yield
    finally:
        disk.faulty_disk_set(b"", ctypes.c_long(0), 0, 0)


def calls() -> int:
    """How many writing calls there were since the last `fail`; to be asked inside of it."""
    disk = ctypes.CDLL(None)
    disk.faulty_disk_calls.restype = ctypes.c_long
    return int(disk.faulty_disk_calls())
