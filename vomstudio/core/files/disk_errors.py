"""Why the disk does not take what is written: full, read-only, forbidden."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import sqlite3
from pathlib import Path

from vomstudio.core.errors import TargetError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FORBIDDEN = {errno.EACCES, errno.EPERM}
_UNCLEAR = {0, errno.EIO}
_SAID_OF_DISK = (
    "disk I/O error",
    "disk is full",
    "readonly database",
    "unable to open database",
    "database factory",
    "(file).is_open()",
    "Input/output error",
    "Read-only file system",
    "No space left",
    "Permission denied",
)
"""What SQLite in COLMAP, COLMAP itself, and C++ streams say of a disk."""
_LITTLE = 64 * 1024
"""Bytes with which neither a database nor a picture gets anywhere."""


def is_full(folder: Path, error: BaseException) -> bool:
    """Whether `error`, met while something was written in `folder`, means that its disk is full."""
    if _sqlite_code(error) == sqlite3.SQLITE_FULL:
        return True
    return _number(folder, error) in _FULL


def is_read_only(folder: Path, error: BaseException) -> bool:
    """Whether `error`, met while something was written in `folder`, means that its disk can only
    be read."""
    return _number(folder, error) == errno.EROFS


def is_forbidden(folder: Path, error: BaseException) -> bool:
    """Whether `error`, met while something was written in `folder`, means that this user may not
    write there."""
    return _number(folder, error) in _FORBIDDEN


def _number(folder: Path, error: BaseException) -> int | None:
    """The number of a failure. Libraries hardly tell it: the same is tried again."""
    number = getattr(error, "errno", None)
    if number is None:
        # A sentence of ours, made of what the system said.
        number = getattr(error.__cause__, "errno", None)
    if isinstance(number, int) and number not in _UNCLEAR:
        return number
    return number_of_failure(folder) or number


def number_of_failure(folder: Path) -> int | None:
    """Why nothing can be written in `folder`, as the system numbers it; None where it can be."""
    probe = folder / f".vom-{secrets.token_hex(6)}.part"
    try:
        with open(probe, "xb", buffering=0) as stream:
            remaining = memoryview(bytes(_LITTLE))
            while remaining:
                # A disk that fills up takes a part first, without an error.
                remaining = remaining[stream.write(remaining) :]
            os.fsync(stream.fileno())
    except OSError as error:
        return error.errno
    except ValueError:
        return None
    finally:
        with contextlib.suppress(OSError, ValueError):
            probe.unlink(missing_ok=True)
    return None


def tells_of_disk(said: object) -> bool:
    """Whether what a library has said of a failure is about the disk that it wrote to."""
    return any(words in str(said) for words in _SAID_OF_DISK)


def _sqlite_code(error: BaseException) -> int:
    return int(getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF


def reason_of(folder: Path, error: BaseException) -> str:
    """The cause of a failure in a few words, to stand in brackets."""
    if is_full(folder, error):
        return tr("the disk is full")
    if is_read_only(folder, error):
        return tr("the disk is read-only")
    if not isinstance(error, OSError | sqlite3.Error) and tells_of_disk(error):
        # What a library in C++ says is for its programmers.
        return tr("a library could not write")
    return str(getattr(error, "strerror", None) or error)


def not_written(path: str | Path, error: BaseException) -> TargetError:
    """The sentence on an output that could not be written: which one, why, and what to do."""
    shown = Path(path)
    number = _number(shown.parent, error)
    if number in _FULL or _sqlite_code(error) == sqlite3.SQLITE_FULL:
        said = Finding("disk.full")
    elif number == errno.EROFS:
        said = Finding("disk.read-only")
    elif number in _FORBIDDEN:
        said = Finding("disk.no-permission")
    elif number == errno.ENAMETOOLONG:
        said = Finding("disk.name-too-long")
    else:
        reason = getattr(error, "strerror", None) or error
        said = Finding("output.unwritable", reason=reason)
    return TargetError(said, file=shown)


def not_taken(folder: str | Path, error: BaseException) -> TargetError:
    """The sentence on a folder of results that a library could not write to; it can be gone on with
    once the disk is well."""
    shown = Path(folder)
    return TargetError(Finding("disk.failed", reason=reason_of(shown, error)), file=shown)
