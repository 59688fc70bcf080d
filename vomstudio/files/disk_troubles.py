"""Why the disk does not take what is written: full, read-only, forbidden."""

from __future__ import annotations

import errno
import os
import sqlite3
from pathlib import Path

from vomstudio.errors import TargetError
from vomstudio.words import tr

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FORBIDDEN = {errno.EACCES, errno.EPERM}
_LITTLE = 64 * 1024
"""Bytes with which neither a database nor a picture gets anywhere."""


def is_full(folder: Path, error: BaseException | None = None) -> bool:
    """Whether an error says that the disk is full, or the disk of `folder` has no room left."""
    if getattr(error, "errno", None) in _FULL or _sqlite_code(error) == sqlite3.SQLITE_FULL:
        return True
    try:
        found = os.statvfs(folder)
    except (OSError, AttributeError, ValueError):
        return False
    return found.f_blocks > 0 and found.f_bavail * found.f_frsize < _LITTLE


def is_read_only(folder: Path, error: BaseException | None = None) -> bool:
    """Whether an error says that the disk can only be read, or the disk of `folder` can."""
    if getattr(error, "errno", None) == errno.EROFS:
        return True
    if _sqlite_code(error) == sqlite3.SQLITE_READONLY and os.access(folder, os.W_OK):
        return True
    try:
        return bool(os.statvfs(folder).f_flag & os.ST_RDONLY)
    except (OSError, AttributeError, ValueError):
        return False


def _sqlite_code(error: BaseException | None) -> int:
    return int(getattr(error, "sqlite_errorcode", 0) or 0) & 0xFF


def not_written(path: str | Path, error: BaseException) -> TargetError:
    """The sentence on an output that could not be written: which one, why, and what to do."""
    shown = Path(path)
    number = getattr(error, "errno", None)
    if is_full(shown.parent, error):
        said = tr("The disk is full. Free some space, or write elsewhere.")
    elif is_read_only(shown.parent, error):
        said = tr("The disk can only be read (it is read-only). Choose another folder.")
    elif number in _FORBIDDEN:
        said = tr("There is no permission to write here. Choose another folder.")
    elif number == errno.ENAMETOOLONG:
        said = tr("This name is too long for the file system. Choose a shorter one.")
    else:
        reason = getattr(error, "strerror", None) or error
        said = tr("The file cannot be written ({reason}). Choose another place.", reason=reason)
    return TargetError(said, file=shown)
