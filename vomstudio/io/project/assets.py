"""Files that rows of the journal name: masks, and what else is too large for a row.

Each is named by the SHA-256 of its content, written whole before the row that names it, and never
written again; undoing finds it where it was. `compact` alone removes those that no row names.
"""

from __future__ import annotations

import contextlib
import hashlib
from pathlib import Path

from vomstudio.document.edit import Edit
from vomstudio.document.records import Asset, Mask
from vomstudio.errors import InputError
from vomstudio.files.atomic import write_bytes
from vomstudio.files.inside import make_folder
from vomstudio.words import tr

FOLDER = "assets"
_MOST_HELD = 64 * 1024 * 1024


def keep_asset(project: Path, data: bytes, suffix: str) -> Asset:
    """Keep the content in the project's folder. suffix: with its dot. Raises TargetError."""
    name = hashlib.sha256(data).hexdigest()
    path = project / FOLDER / f"{name}{suffix}"
    if not path.is_file() or path.stat().st_size != len(data):
        make_folder(path.parent, project)
        write_bytes(path, data, force=True)
    return Asset(f"{FOLDER}/{path.name}", len(data))


def asset_path(project: Path, asset: Asset) -> Path:
    """Where it is. Raises InputError where it is not there any more, or names another place."""
    path = project / asset.path
    if Path(asset.path).parts[:-1] != (FOLDER,):
        raise InputError(
            tr("The name points to a file outside of the project's assets."), file=project
        )
    if not path.is_file():
        raise InputError(
            tr("The file is missing from the project. It held the mask of a photo."), file=path
        )
    return path


def is_sound(path: Path) -> bool:
    """Whether an asset holds what its name says."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest() == path.stem


class HeldAssets:
    """The content of a project's assets in memory, for the case that its folder goes away while it
    is open: masks are hours of work."""

    def __init__(self) -> None:
        self._held: dict[str, bytes] = {}
        self._bytes = 0

    def hold_all(self, project: Path) -> None:
        """Hold what is there, up to a limit."""
        folder = project / FOLDER
        if folder.is_dir():
            for path in folder.iterdir():
                self._take(project, f"{FOLDER}/{path.name}")

    def hold(self, project: Path, edit: Edit) -> None:
        """Hold what an edit names for the first time."""
        for record in edit.after.values():
            if isinstance(record, Mask):
                self._take(project, record.file.path)

    def _take(self, project: Path, name: str) -> None:
        if name in self._held or self._bytes > _MOST_HELD:
            return
        with contextlib.suppress(OSError, InputError):
            self._held[name] = asset_path(project, Asset(name, 0)).read_bytes()
            self._bytes += len(self._held[name])

    def write(self, project: Path) -> None:
        """Into another folder, what is not there whole. Raises TargetError, OSError."""
        for name, data in self._held.items():
            path = project / name
            if not path.is_file() or path.stat().st_size != len(data):
                (project / FOLDER).mkdir(exist_ok=True)
                write_bytes(path, data, force=True)
