"""Files that rows of the journal name: masks, and what else is too large for a row.

Each is named by the SHA-256 of its content, written whole before the row that names it, and never
written again; undoing finds it where it was. `compact` alone removes those that no row names.
"""

from __future__ import annotations

import contextlib
import hashlib
import tempfile
from collections.abc import Callable
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.containment import make_folder
from vomstudio.core.files.regular import open_regular, read_whole
from vomstudio.core.findings import Finding
from vomstudio.project.edit import Edit
from vomstudio.project.records import Asset, Mask

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
        raise InputError(Finding("asset.outside", asset=asset.path), file=project)
    if not path.is_file():
        raise InputError(Finding("asset.missing"), file=path)
    return path


def is_sound(path: Path) -> bool:
    """Whether an asset holds what its name says."""
    with open_regular(path) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest() == path.stem


class Assets:
    """The assets of an open project. Their content is in memory too, for the case that its folder
    goes away while it is open: masks are hours of work.

    folder : where the project is; ours : whether what lies there is what is open
    """

    def __init__(self, folder: Callable[[], Path], ours: Callable[[], bool]) -> None:
        self._folder, self._ours = folder, ours
        self._held: dict[str, bytes] = {}
        self._bytes = 0
        self._goes_on = False
        self._waiting: set[str] = set()
        self._stand_in: tempfile.TemporaryDirectory[str] | None = None

    def keep(self, data: bytes, suffix: str) -> Asset:
        """Keep the content in the project's folder; after `hold_all` in memory where it cannot be
        written, from where it goes along with the row that names it. Raises TargetError."""
        if not self._goes_on:
            return keep_asset(self._folder(), data, suffix)
        asset = Asset(f"{FOLDER}/{hashlib.sha256(data).hexdigest()}{suffix}", len(data))
        try:
            if self._ours():
                return keep_asset(self._folder(), data, suffix)
        except (TargetError, OSError):
            pass
        self._waiting.add(asset.path)
        self._held[asset.path] = data
        return asset

    def path(self, asset: Asset) -> Path:
        """As `asset_path`; of one that is in memory only, a file that holds it for now."""
        try:
            return asset_path(self._folder(), asset)
        except InputError:
            data = self._held.get(asset.path)
            if data is None:
                raise
        if self._stand_in is None:
            self._stand_in = tempfile.TemporaryDirectory(prefix="vomstudio-")
        copy = Path(self._stand_in.name, Path(asset.path).name)
        if not copy.is_file():
            write_bytes(copy, data, force=True)
        return copy

    def hold_all(self) -> None:
        """From now on work goes on where the folder cannot be written. Hold what is there, up to a
        limit."""
        self._goes_on = True
        folder = self._folder() / FOLDER
        if folder.is_dir():
            for path in folder.iterdir():
                self._take(f"{FOLDER}/{path.name}")

    def hold(self, edit: Edit) -> None:
        """Hold what an edit names for the first time."""
        for record in edit.after.values():
            if isinstance(record, Mask):
                self._take(record.file.path)

    def _take(self, name: str) -> None:
        if name in self._held or self._bytes > _MOST_HELD:
            return
        with contextlib.suppress(OSError, InputError):
            self._held[name] = read_whole(asset_path(self._folder(), Asset(name, 0)))
            self._bytes += len(self._held[name])

    def write_waiting(self) -> None:
        """Those that are in memory only, before a row that names them. Raises TargetError."""
        for name in sorted(self._waiting):
            keep_asset(self._folder(), self._held[name], Path(name).suffix)
            self._waiting.discard(name)

    def write(self, project: Path) -> None:
        """Into another folder, what is not there whole. Raises TargetError, OSError."""
        for name, data in self._held.items():
            path = project / name
            if not path.is_file() or path.stat().st_size != len(data):
                (project / FOLDER).mkdir(exist_ok=True)
                write_bytes(path, data, force=True)

    def close(self) -> None:
        # Whoever is asked for the folder refers to this: a project that is left goes at once, with
        # its thousands of records, and not when circles are looked for.
        folder = self._folder()
        self._folder, self._ours = lambda: folder, lambda: False
        if self._stand_in is not None:
            self._stand_in.cleanup()
        self._stand_in = None
