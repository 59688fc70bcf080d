"""Where the program's own files are, and those that it can make again."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.words import tr

LAUNCHER = "VOMSTUDIO_LAUNCHER"
_PACKAGE = Path(__file__).resolve().parents[1]
# An installed package carries the files inside; in a checkout they lie beside it.
_FOLDERS = (_PACKAGE / "resources", _PACKAGE.parent / "resources")


def resource(*parts: str) -> Path:
    """Path of a file or folder of `resources/`, in a checkout and in an installed wheel alike.

    `resource("outcrop", "picks.csv")`; without arguments the folder itself. Raises InputError
    where it is missing, which means a damaged installation.
    """
    for folder in _FOLDERS:
        path = folder.joinpath(*parts)
        if path.exists():
            return path
    raise InputError(
        tr("This file of the program is missing. Install VOM Studio again."),
        file=_FOLDERS[0].joinpath(*parts),
    )


def documentation() -> Path:
    """The folder of the documentation's pages. Raises InputError where it is missing."""
    in_the_checkout = _PACKAGE.parent / "docs"
    if (in_the_checkout / "index.md").is_file() and not (_PACKAGE / "resources").is_dir():
        return in_the_checkout
    return resource("docs")


def user_cache(*parts: str) -> Path:
    """Return the user's cache folder of the program, or a path in it; it need not exist."""
    from platformdirs import user_cache_path

    return user_cache_path("vomstudio", appauthor=False).joinpath(*parts)


def program_command() -> list[str]:
    """Return the command that starts the program from anywhere, as the user started it.

    A bundle has a launcher, which it names by VOMSTUDIO_LAUNCHER: the interpreter inside may be
    gone at the next start, when an image is mounted elsewhere.
    """
    launcher = os.environ.get(LAUNCHER)
    return [launcher] if launcher else [sys.executable, "-P", "-m", "vomstudio"]


def import_folders() -> list[str]:
    """Where a process that is started imports from: the same package as here, wherever the program
    was started from, and never that folder itself."""
    here = Path.cwd()
    others = [p for p in sys.path if p and Path(p) not in (here, _PACKAGE.parent)]
    return [str(_PACKAGE.parent), *others]
