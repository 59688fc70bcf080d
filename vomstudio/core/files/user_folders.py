"""Where the program keeps what has no name yet, also for a user whose home cannot be written."""

from __future__ import annotations

import os
import stat
import tempfile
from functools import cache
from pathlib import Path


def state_folder() -> Path:
    """Of this user: that of the system's conventions, else one among the temporary files."""
    return _usable(_wanted())


def home_is_writable() -> bool:
    """Whether `state_folder` is where it belongs, and not where the system may empty it."""
    return state_folder() == _wanted()


def _wanted() -> Path:
    from platformdirs import user_state_path

    return user_state_path("vomstudio", appauthor=False)


@cache
def _usable(wanted: Path) -> Path:
    if _can_be_written(wanted):
        return wanted
    # A name that comes again, so that what a crash leaves behind is found.
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    mine = Path(tempfile.gettempdir()) / f"vomstudio-{user}"
    if _is_mine(mine):
        return mine
    try:
        return Path(tempfile.mkdtemp(prefix="vomstudio-"))
    except OSError:
        # Whoever writes there says why that is not possible.
        return wanted


def _can_be_written(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _is_mine(folder: Path) -> bool:
    """Made by and for this user alone: everybody may write beside it."""
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return False
    if not stat.S_ISDIR(found.st_mode):
        return False
    return not hasattr(os, "getuid") or (found.st_uid == os.getuid() and not found.st_mode & 0o077)
