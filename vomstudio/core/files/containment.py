"""Checks that, in a folder from an unknown source, the program writes only inside it.

A project, model folder or photo folder may contain links. Files that the program names itself must
stay inside the folder: the program never writes through a link, whether the link is the file or a
folder on its path. Links in paths that a user enters are followed (`atomic.check_target`), except
inside a project.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from vomstudio.core.errors import TargetError
from vomstudio.core.files.regular import is_folder, is_regular_file
from vomstudio.core.findings import Finding

PROJECT_SUFFIX = ".vom"


def require_inside(path: str | Path, root: str | Path) -> Path:
    """Return `path` if writing to it stays inside the folder `root`.

    Parameters
    ----------
    path : str or Path
    root : str or Path
        Folder, whose own path may contain links.

    Raises
    ------
    TargetError
        If the path leads out of `root`, or if the file or a folder on its path is a link.
    """
    shown_path, folder = Path(path), Path(root)
    try:
        parts = shown_path.relative_to(folder).parts
    except ValueError:
        parts = ("..",)
    if ".." in parts:
        raise TargetError(Finding("output.outside-folder", folder=folder), file=shown_path)
    place = folder
    for part in parts:
        place = place / part
        if _is_link(place):
            raise TargetError(Finding("output.link", link=place), file=shown_path)
    return shown_path


def check_generated_path(path: str | Path) -> Path:
    """Return the path of a generated file, or raise TargetError as `require_inside` does.

    The file must stay inside the project in its path, or else inside its own folder.
    """
    shown_path = Path(path)
    root = enclosing_project(shown_path)
    if root is None:
        return require_inside(shown_path, shown_path.parent)
    require_inside(Path.cwd() / shown_path, root)
    return shown_path


def enclosing_project(path: str | Path) -> Path | None:
    """Return the outermost project folder in a path, without resolving links, or None."""
    shown_path = Path(path)
    absolute_path = shown_path if shown_path.is_absolute() else Path.cwd() / shown_path
    return next(
        (parent for parent in reversed(absolute_path.parents) if parent.suffix == PROJECT_SUFFIX),
        None,
    )


def check_in_project(path: str | Path) -> None:
    """Check a path inside a project with `require_inside`, and accept all other paths."""
    root = enclosing_project(path)
    if root is not None:
        require_inside(Path.cwd() / path, root)


def make_folder(path: str | Path, root: str | Path | None = None) -> Path:
    """Create a folder with its missing parents and return its path.

    Parameters
    ----------
    path : str or Path
    root : str or Path, optional
        Folder that must contain the new folder. If None, the project in its path is used.

    Raises
    ------
    TargetError
        As for `require_inside`, or if the folder of the project does not exist.
    OSError
        If the folder cannot be created.
    """
    if root is None:
        check_in_project(path)
    else:
        require_inside(path, root)
    project = enclosing_project(path)
    if project is not None and not project.is_dir():
        # A new folder that contains only a cache would look like a project.
        raise TargetError(Finding("project.folder-missing"), file=project)
    new_folder = Path(path)
    new_folder.mkdir(parents=True, exist_ok=True)
    return new_folder


def refuse_links(folder: str | Path) -> None:
    """Raise TargetError if a folder or any of its subfolders contains a link, pipe or device."""
    for folder_path, folders, names in os.walk(folder):
        for name in (*folders, *names):
            place = require_inside(Path(folder_path, name), folder_path)
            if name in names and place.exists() and not is_regular_file(place):
                raise TargetError(Finding("file.device-in-folder"), file=place)


def special_files(folder: str, names: Iterable[str]) -> set[str]:
    """Return the names of links, pipes and devices, for `ignore` of `shutil.copytree`."""
    return {name for name in names if _is_special(Path(folder, name))}


def _is_special(path: Path) -> bool:
    return _is_link(path) or not (is_regular_file(path) or is_folder(path))


def _is_link(path: Path) -> bool:
    try:
        return path.is_symlink() or (hasattr(os.path, "isjunction") and os.path.isjunction(path))
    except (OSError, ValueError):
        return False
