"""Where the program may write inside a folder that somebody else may have packed.

A project, a model's folder or a folder of photos can come with links in it. What the program writes
there under names of its own must stay there: a link is never written through, neither as the file
nor as a folder on the way to it. Names that a user types are another matter; their links are kept
(`atomic.check_target`), except inside a project.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from vomstudio.core.errors import TargetError
from vomstudio.core.files.regular import is_folder, is_regular
from vomstudio.core.findings import Finding

PROJECT_SUFFIX = ".vom"


def place_inside(path: str | Path, root: str | Path) -> Path:
    """`path`, if writing there stays inside the folder `root`, whose own path may have links.

    Raises TargetError where it leads out of `root`, or it or a folder on the way is a link.
    """
    shown, folder = Path(path), Path(root)
    try:
        parts = shown.relative_to(folder).parts
    except ValueError:
        parts = ("..",)
    if ".." in parts:
        raise TargetError(Finding("output.outside-folder", folder=folder), file=shown)
    place = folder
    for part in parts:
        place = place / part
        if _is_link(place):
            raise TargetError(Finding("output.link", link=place), file=shown)
    return shown


def check_beside(path: str | Path) -> Path:
    """`place_inside` for a file whose name the program chose, in the folder that a user named."""
    shown = Path(path)
    root = project_of(shown)
    if root is None:
        return place_inside(shown, shown.parent)
    place_inside(Path.cwd() / shown, root)
    return shown


def project_of(path: str | Path) -> Path | None:
    """The outermost project folder that `path` is in, as it is written, or None."""
    shown = Path(path)
    absolute = shown if shown.is_absolute() else Path.cwd() / shown
    return next((p for p in reversed(absolute.parents) if p.suffix == PROJECT_SUFFIX), None)


def check_in_project(path: str | Path) -> None:
    """`place_inside` for whatever lies in a project; nothing for all other paths."""
    root = project_of(path)
    if root is not None:
        place_inside(Path.cwd() / path, root)


def make_folder(path: str | Path, root: str | Path | None = None) -> Path:
    """The folder `path`, made with those above it where they are missing; inside `root`, or the
    project that it is in. Raises TargetError as `place_inside`, and OSError."""
    if root is None:
        check_in_project(path)
    else:
        place_inside(path, root)
    project = project_of(path)
    if project is not None and not project.is_dir():
        # Made again with nothing but a cache in it, it would look like a project.
        raise TargetError(Finding("project.folder-missing"), file=project)
    made = Path(path)
    made.mkdir(parents=True, exist_ok=True)
    return made


def refuse_links(folder: str | Path) -> None:
    """Raises TargetError for the first link, pipe or device in a folder or in folders below it."""
    for here, folders, names in os.walk(folder):
        for name in (*folders, *names):
            place = place_inside(Path(here, name), here)
            if name in names and place.exists() and not is_regular(place):
                raise TargetError(Finding("file.device-in-folder"), file=place)


def links_of(folder: str, names: Iterable[str]) -> set[str]:
    """Those of `names` in a folder that are links, and the pipes and devices, for which nobody
    waits; to be left out by `shutil.copytree`."""
    return {name for name in names if _is_odd(Path(folder, name))}


def _is_odd(path: Path) -> bool:
    return _is_link(path) or not (is_regular(path) or is_folder(path))


def _is_link(path: Path) -> bool:
    try:
        return path.is_symlink() or (hasattr(os.path, "isjunction") and os.path.isjunction(path))
    except (OSError, ValueError):
        return False
