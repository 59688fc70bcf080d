"""Folders of the program: resources, documentation and cache."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.words import tr

LAUNCHER = "VOMSTUDIO_LAUNCHER"
_PACKAGE = Path(__file__).resolve().parents[1]
# An installed package contains the files; in a checkout they are next to the package.
_RESOURCE_FOLDERS = (_PACKAGE / "resources", _PACKAGE.parent / "resources")


def resource(*parts: str) -> Path:
    """Return the path of a file or folder in `resources/`, both in a checkout and in a wheel.

    Parameters
    ----------
    *parts : str
        Parts of the path, such as ``"outcrop", "picks.csv"``. Without parts, the folder itself is
        returned.

    Raises
    ------
    InputError
        If the path does not exist, which means that the installation is damaged.
    """
    for folder in _RESOURCE_FOLDERS:
        path = folder.joinpath(*parts)
        if path.exists():
            return path
    raise InputError(
        tr("This program file is missing. Reinstall VOM Studio."),
        file=_RESOURCE_FOLDERS[0].joinpath(*parts),
    )


def documentation() -> Path:
    """Return the folder of the documentation pages.

    Raises
    ------
    InputError
        If the folder does not exist.
    """
    checkout_docs = _PACKAGE.parent / "docs"
    if (checkout_docs / "index.md").is_file() and not (_PACKAGE / "resources").is_dir():
        return checkout_docs
    return resource("docs")


def user_cache(*parts: str) -> Path:
    """Return the user's cache folder of the program or a path inside it, which may not exist."""
    from platformdirs import user_cache_path

    return user_cache_path("vomstudio", appauthor=False).joinpath(*parts)


def program_command() -> list[str]:
    """Return a command that starts the program from any folder.

    A bundle has a launcher, whose path is in VOMSTUDIO_LAUNCHER: the interpreter inside an image
    may be gone at the next start if the image is then mounted elsewhere.
    """
    launcher = os.environ.get(LAUNCHER)
    return [launcher] if launcher else [sys.executable, "-P", "-m", "vomstudio"]


def import_folders() -> list[str]:
    """Return the import path for a child process, without the current folder.

    The child process imports the same package as this process, whatever its current folder is.
    """
    working_folder = Path.cwd()
    search_paths = [p for p in sys.path if p and Path(p) not in (working_folder, _PACKAGE.parent)]
    return [str(_PACKAGE.parent), *search_paths]
