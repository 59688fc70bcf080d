"""Records of finished reconstructions, and copying of their files for "Save as"."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.files.containment import special_files
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.lock import FolderLock
from vomstudio.core.files.regular import MAX_JSON_BYTES, read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.reconstruction_file import (
    CURRENT_FILE,
    RESULT,
    WORK,
    finite_number,
    result_registration,
)
from vomstudio.project.records import ReconstructionRecord

RECONSTRUCTIONS = "reconstruction"
"""Folder of the reconstructions, with a subfolder for each photo set and quality."""
REQUEST = "request.json"
# Larger files are written once under a new name; a reconstruction appends only to small ones.
MAX_COPY_BYTES = 1 << 20


def read_reconstruction(
    folder: Path, photo_set_id: str, name: str
) -> tuple[ReconstructionRecord, Registration]:
    """Return the records for the results of a run in `folder`. Raises InputError."""
    path = folder / RESULT
    try:
        data = read_small_file(path, MAX_JSON_BYTES)
        result = json.loads(data)
        finished_at = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(
            timespec="seconds"
        )
    except (InputError, OSError, ValueError, RecursionError) as error:
        raise InputError(Finding("reconstruction.unreadable"), file=path) from (error)
    if not isinstance(result, dict):
        raise InputError(Finding("reconstruction.invalid"), file=path)
    settings = result.get("settings")
    versions = result.get("versions")
    reconstruction = ReconstructionRecord(
        new_id("reconstruction"),
        photo_set_id,
        name,
        folder.name,
        str(settings.get("quality", "")) if isinstance(settings, dict) else "",
        hashlib.sha256(data).hexdigest(),
        _pairs(settings),
        _count(result.get("photos")),
        _count(result.get("registered")),
        finite_number(result.get("reprojection_error_px")),
        str(versions.get("vomstudio", "")) if isinstance(versions, dict) else "",
        finished_at,
    )
    return reconstruction, result_registration(result, reconstruction.name, reconstruction.id)


def _pairs(settings: object) -> tuple[tuple[str, str], ...]:
    if not isinstance(settings, dict):
        return ()
    return tuple((str(k), "" if v is None else str(v)) for k, v in settings.items())


def _count(value: object) -> int:
    return value if isinstance(value, int) else 0


# --- files -------------------------------------------------------------------------------
def copy_reconstructions(source: Path, target: Path) -> None:
    """Copy reconstructions, without locks and unfinished files.

    Large files are hard-linked if the disk supports it, because they are replaced by new files and
    never modified.
    """

    def copy_or_link(source_file: str, target_file: str) -> object:
        if Path(source_file).stat().st_size > MAX_COPY_BYTES:
            try:
                os.link(source_file, target_file)
                return target_file
            except OSError:
                pass
        return shutil.copy2(source_file, target_file)

    def ignore(folder: str, names: list[str]) -> set[str]:
        links = special_files(folder, names)
        parts = Path(folder).relative_to(source / RECONSTRUCTIONS).parts
        if parts[1:2] != (WORK,):
            return links
        locks = {name for name in names if name.startswith("lock")} if len(parts) == 2 else set()
        return links | locks | {name for name in names if name.endswith(".part")}

    if (source / RECONSTRUCTIONS).is_dir():
        shutil.copytree(
            source / RECONSTRUCTIONS,
            target / RECONSTRUCTIONS,
            copy_function=copy_or_link,
            ignore=ignore,
        )


def move_reconstructions(source: Path, target: Path) -> None:
    """Move reconstructions. If this fails, raise TargetError and leave them unchanged."""
    if not (source / RECONSTRUCTIONS).is_dir():
        return
    try:
        (source / RECONSTRUCTIONS).rename(target / RECONSTRUCTIONS)
        return
    except OSError:
        # The folder may be a mount point of the same disk, or a file may be open.
        pass
    try:
        copy_reconstructions(source, target)
    except OSError as error:
        shutil.rmtree(target / RECONSTRUCTIONS, ignore_errors=True)
        raise TargetError(
            Finding(
                "reconstruction.not-moved",
                reason=failure_reason(target, error),
                source=source / RECONSTRUCTIONS,
            ),
            file=target,
        ) from error


def unused_stages(folder: Path) -> list[Path]:
    """Return the folders of stages that the newest results in a project do not use.

    Parameters
    ----------
    folder : Path
        Folder of the project.

    Returns
    -------
    list of Path
        Without unfinished stages that are newer than the results, and without reconstructions
        that have no results.
    """
    unused = []
    for current_file in sorted((folder / RECONSTRUCTIONS).glob(f"*/{WORK}/{CURRENT_FILE}")):
        try:
            content = json.loads(read_small_file(current_file, MAX_JSON_BYTES))
            current = set(content["folders"])
            finished_at = current_file.stat().st_mtime
            names = sorted(path.name for path in current_file.parent.iterdir() if path.is_dir())
            links = special_files(str(current_file.parent), names)
        except (InputError, OSError, ValueError, KeyError, TypeError):
            continue
        for name in names:
            path = current_file.parent / name
            is_newer = name.endswith(".part") and path.stat().st_mtime > finished_at
            if name not in current and name not in links and not is_newer:
                unused.append(path)
    return unused


def delete_unused_stages(folder: Path) -> None:
    """Delete the folders of `unused_stages`, except those of running reconstructions.

    Parameters
    ----------
    folder : Path
        Folder of the project.
    """
    for path in unused_stages(folder):
        try:
            lock = FolderLock(
                path.parent / "lock",
                busy_code="output.folder-in-use",
                unwritable_code="output.unwritable",
            )
        except VomError:
            continue
        try:
            shutil.rmtree(path, ignore_errors=True)
        finally:
            lock.release()


def folder_bytes(folders: Iterable[Path]) -> int:
    """Return the total size of the files in some folders.

    Parameters
    ----------
    folders : iterable of Path

    Returns
    -------
    int
        Size in bytes.
    """
    return sum(
        path.stat().st_size for folder in folders for path in folder.rglob("*") if path.is_file()
    )
