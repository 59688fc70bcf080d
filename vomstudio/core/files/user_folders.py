"""Folder for state and untitled projects, even if the home folder is not writable."""

from __future__ import annotations

import os
import stat
import tempfile
from functools import cache
from pathlib import Path


def state_folder() -> Path:
    """Return the user's state folder, or a temporary folder if it is not writable."""
    return _first_writable_folder(_default_folder())


def is_home_writable() -> bool:
    """Return whether `state_folder` is the permanent folder, which the system does not clear."""
    return state_folder() == _default_folder()


def _default_folder() -> Path:
    from platformdirs import user_state_path

    return user_state_path("vomstudio", appauthor=False)


@cache
def _first_writable_folder(default_folder: Path) -> Path:
    if _is_writable(default_folder):
        return default_folder
    # Use a fixed name so that work can be found after a crash.
    user_name = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    temporary_folder = Path(tempfile.gettempdir()) / f"vomstudio-{user_name}"
    if _is_private(temporary_folder):
        return temporary_folder
    try:
        return Path(tempfile.mkdtemp(prefix="vomstudio-"))
    except OSError:
        # Writing to the folder will raise an error that states the reason.
        return default_folder


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _is_private(folder: Path) -> bool:
    """Create a folder and return whether it belongs to this user alone.

    Its parent folder is shared with other users.
    """
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return False
    if not stat.S_ISDIR(status.st_mode):
        return False
    return not hasattr(os, "getuid") or (
        status.st_uid == os.getuid() and not status.st_mode & 0o077
    )
