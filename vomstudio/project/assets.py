"""Files referenced by journal rows: masks and other data that are too large for a row.

Each file is named by the SHA-256 of its content, written completely before the row that references
it, and never overwritten, so undo finds it unchanged. Only `compact` removes files that no row
references.
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
from vomstudio.core.files.regular import open_regular_file, read_whole_file
from vomstudio.core.findings import Finding
from vomstudio.project.edit import Edit
from vomstudio.project.records import Asset, Mask

FOLDER = "assets"
MAX_CACHED_BYTES = 64 * 1024 * 1024


def store_asset(project: Path, data: bytes, suffix: str) -> Asset:
    """Store content in the project folder. `suffix` includes its dot. Raises TargetError."""
    name = hashlib.sha256(data).hexdigest()
    path = project / FOLDER / f"{name}{suffix}"
    if not path.is_file() or path.stat().st_size != len(data):
        make_folder(path.parent, project)
        write_bytes(path, data, force=True)
    return Asset(f"{FOLDER}/{path.name}", len(data))


def asset_path(project: Path, asset: Asset) -> Path:
    """Return the path of an asset. Raises InputError if it is missing or outside the folder."""
    path = project / asset.path
    if Path(asset.path).parts[:-1] != (FOLDER,):
        raise InputError(Finding("asset.outside", asset=asset.path), file=project)
    if not path.is_file():
        raise InputError(Finding("asset.missing"), file=path)
    return path


def is_intact(path: Path) -> bool:
    """Return whether the content of an asset matches its name."""
    with open_regular_file(path) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest() == path.stem


class Assets:
    """Assets of an open project, which can be cached in memory in case the folder disappears.

    Masks represent hours of work. `folder` returns the project folder, and `is_current` returns
    whether it still contains the open project.
    """

    def __init__(self, folder: Callable[[], Path], is_current: Callable[[], bool]) -> None:
        self._folder, self._is_current = folder, is_current
        self._cached_contents: dict[str, bytes] = {}
        self._bytes = 0
        self._works_offline = False
        self._pending_paths: set[str] = set()
        self._temporary_folder: tempfile.TemporaryDirectory[str] | None = None

    def store(self, data: bytes, suffix: str) -> Asset:
        """Store content in the project folder. Raises TargetError.

        After `cache_all`, content that cannot be written stays in memory and is written together
        with the row that references it.
        """
        if not self._works_offline:
            return store_asset(self._folder(), data, suffix)
        asset = Asset(f"{FOLDER}/{hashlib.sha256(data).hexdigest()}{suffix}", len(data))
        try:
            if self._is_current():
                return store_asset(self._folder(), data, suffix)
        except (TargetError, OSError):
            pass
        self._pending_paths.add(asset.path)
        self._cached_contents[asset.path] = data
        return asset

    def path(self, asset: Asset) -> Path:
        """Return the path of an asset, or of a temporary copy if it exists only in memory.

        Raises InputError if it is in neither place.
        """
        try:
            return asset_path(self._folder(), asset)
        except InputError:
            data = self._cached_contents.get(asset.path)
            if data is None:
                raise
        if self._temporary_folder is None:
            self._temporary_folder = tempfile.TemporaryDirectory(prefix="vomstudio-")
        copy = Path(self._temporary_folder.name, Path(asset.path).name)
        if not copy.is_file():
            write_bytes(copy, data, force=True)
        return copy

    def cache_all(self) -> None:
        """Cache existing assets, up to a limit, so that work can continue without the folder."""
        self._works_offline = True
        folder = self._folder() / FOLDER
        if folder.is_dir():
            for path in folder.iterdir():
                self._cache(f"{FOLDER}/{path.name}")

    def cache_edit(self, edit: Edit) -> None:
        """Cache the assets that an edit references for the first time."""
        for record in edit.after.values():
            if isinstance(record, Mask):
                self._cache(record.file.path)

    def _cache(self, name: str) -> None:
        if name in self._cached_contents or self._bytes > MAX_CACHED_BYTES:
            return
        with contextlib.suppress(OSError, InputError):
            self._cached_contents[name] = read_whole_file(
                asset_path(self._folder(), Asset(name, 0))
            )
            self._bytes += len(self._cached_contents[name])

    def write_pending(self) -> None:
        """Write the assets that exist only in memory, before their row. Raises TargetError."""
        for name in sorted(self._pending_paths):
            store_asset(self._folder(), self._cached_contents[name], Path(name).suffix)
            self._pending_paths.discard(name)

    def write(self, project: Path) -> None:
        """Write missing or incomplete assets to another folder. Raises TargetError and OSError."""
        for name, data in self._cached_contents.items():
            path = project / name
            if not path.is_file() or path.stat().st_size != len(data):
                (project / FOLDER).mkdir(exist_ok=True)
                write_bytes(path, data, force=True)

    def close(self) -> None:
        # The callables reference the project. Drop them so that its thousands of records are freed
        # immediately and not by the next garbage collection.
        folder = self._folder()
        self._folder, self._is_current = lambda: folder, lambda: False
        if self._temporary_folder is not None:
            self._temporary_folder.cleanup()
        self._temporary_folder = None
