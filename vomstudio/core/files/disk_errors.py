"""Causes of write failures: a full disk, a read-only disk or missing permissions."""

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

_DISK_FULL_ERRNOS = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FORBIDDEN_ERRNOS = {errno.EACCES, errno.EPERM}
_UNSPECIFIC_ERRNOS = {0, errno.EIO}
_DISK_MESSAGES = (
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
"""Messages of SQLite in COLMAP, of COLMAP itself and of C++ streams."""
_PROBE_BYTES = 64 * 1024
"""Size of the test file; less free space is not enough for a database or a picture."""


def is_full(folder: Path, error: BaseException) -> bool:
    """Return whether an error while writing in `folder` means that the disk is full."""
    if _sqlite_code(error) == sqlite3.SQLITE_FULL:
        return True
    return _error_number(folder, error) in _DISK_FULL_ERRNOS


def is_read_only(folder: Path, error: BaseException) -> bool:
    """Return whether an error while writing in `folder` means that the disk is read-only."""
    return _error_number(folder, error) == errno.EROFS


def is_forbidden(folder: Path, error: BaseException) -> bool:
    """Return whether an error while writing in `folder` means that permission is missing."""
    return _error_number(folder, error) in _FORBIDDEN_ERRNOS


def _error_number(folder: Path, error: BaseException) -> int | None:
    """Return the errno of a failure, or else that of writing a test file; None if unknown."""
    errno_ = getattr(error, "errno", None)
    if errno_ is None:
        # The program raised this error because of a system error.
        errno_ = getattr(error.__cause__, "errno", None)
    if isinstance(errno_, int) and errno_ not in _UNSPECIFIC_ERRNOS:
        return errno_
    return probe_write_errno(folder) or errno_


def probe_write_errno(folder: Path) -> int | None:
    """Return the errno of writing a test file in `folder`, or None if writing succeeds."""
    probe = folder / f".vom-{secrets.token_hex(6)}.part"
    try:
        with open(probe, "xb", buffering=0) as stream:
            remaining_bytes = memoryview(bytes(_PROBE_BYTES))
            while remaining_bytes:
                # A nearly full disk first accepts a part of the data without an error.
                remaining_bytes = remaining_bytes[stream.write(remaining_bytes) :]
            os.fsync(stream.fileno())
    except OSError as error:
        return error.errno
    except ValueError:
        return None
    finally:
        with contextlib.suppress(OSError, ValueError):
            probe.unlink(missing_ok=True)
    return None


def is_disk_message(message: object) -> bool:
    """Return whether a message of a library reports a failure to write."""
    return any(text in str(message) for text in _DISK_MESSAGES)


def _sqlite_code(error: BaseException) -> int:
    return int(getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF


def failure_reason(folder: Path, error: BaseException) -> str:
    """Return the cause of a failure in a few words, to be shown in brackets in a sentence."""
    if is_full(folder, error):
        return tr("the disk is full")
    if is_read_only(folder, error):
        return tr("the disk is read-only")
    if not isinstance(error, OSError | sqlite3.Error) and is_disk_message(error):
        # Messages of C++ libraries are not intended for users.
        return tr("a library reported a write error")
    return str(getattr(error, "strerror", None) or error)


def damage_reason(error: BaseException) -> str:
    """Describe the damage of a file in a few words, to be shown in brackets in a sentence.

    Parameters
    ----------
    error : BaseException

    Returns
    -------
    str
    """
    if isinstance(error, KeyError) and error.args:
        return tr("{name} is missing", name=error.args[0])
    return str(getattr(error, "strerror", None) or error)


def write_error(path: str | Path, error: BaseException) -> TargetError:
    """Return the error for an output that could not be written, with its cause."""
    target_path = Path(path)
    errno_ = _error_number(target_path.parent, error)
    if errno_ in _DISK_FULL_ERRNOS or _sqlite_code(error) == sqlite3.SQLITE_FULL:
        finding = Finding("disk.full")
    elif errno_ == errno.EROFS:
        finding = Finding("disk.read-only")
    elif errno_ in _FORBIDDEN_ERRNOS:
        finding = Finding("disk.no-permission")
    elif errno_ == errno.ENAMETOOLONG:
        finding = Finding("disk.name-too-long")
    else:
        reason = getattr(error, "strerror", None) or error
        finding = Finding("output.unwritable", reason=reason)
    return TargetError(finding, file=target_path)


def folder_write_error(folder: str | Path, error: BaseException) -> TargetError:
    """Return the error for a results folder that a library could not write to."""
    target_folder = Path(folder)
    return TargetError(
        Finding("disk.failed", reason=failure_reason(target_folder, error)), file=target_folder
    )
