"""What a finished reconstruction is to the document: its record, and the registration it found;
and how its files go along when a project is saved elsewhere."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from datetime import UTC, datetime
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import special_files
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.regular import JSON_BYTES, read_small
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.reconstruction_file import RESULT, finite_number, result_registration
from vomstudio.project.records import Reconstruction

RECONSTRUCTIONS = "reconstruction"
"""The folder of what is made of photos, one folder in it for each set and quality."""
REQUEST = "request.json"
# What a reconstruction adds lines to; all else is written once, under another name.
_LARGEST_COPIED = 1 << 20


def read_reconstruction(
    folder: Path, photo_set_id: str, name: str
) -> tuple[Reconstruction, Registration]:
    """The records of what a run has left in `folder`. Raises InputError."""
    path = folder / RESULT
    try:
        data = read_small(path, JSON_BYTES)
        found = json.loads(data)
        finished = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds")
    except (InputError, OSError, ValueError, RecursionError) as error:
        raise InputError(Finding("reconstruction.unreadable"), file=path) from (error)
    if not isinstance(found, dict):
        raise InputError(Finding("reconstruction.invalid"), file=path)
    settings = found.get("settings")
    versions = found.get("versions")
    reconstruction = Reconstruction(
        new_id("reconstruction"),
        photo_set_id,
        name,
        folder.name,
        str(settings.get("quality", "")) if isinstance(settings, dict) else "",
        hashlib.sha256(data).hexdigest(),
        _pairs(settings),
        _count(found.get("photos")),
        _count(found.get("registered")),
        finite_number(found.get("reprojection_error_px")),
        str(versions.get("vomstudio", "")) if isinstance(versions, dict) else "",
        finished,
    )
    return reconstruction, result_registration(found, reconstruction.name, reconstruction.id)


def _pairs(settings: object) -> tuple[tuple[str, str], ...]:
    if not isinstance(settings, dict):
        return ()
    return tuple((str(k), "" if v is None else str(v)) for k, v in settings.items())


def _count(value: object) -> int:
    return value if isinstance(value, int) else 0


# --- their files -------------------------------------------------------------------------
def copy_reconstructions(source: Path, target: Path) -> None:
    """What is finished. Large files are shared where the disk can do it: none is ever changed, a
    new one takes its place."""

    def take(one: str, other: str) -> object:
        if Path(one).stat().st_size > _LARGEST_COPIED:
            try:
                os.link(one, other)
                return other
            except OSError:
                pass
        return shutil.copy2(one, other)

    def unfinished(folder: str, names: list[str]) -> set[str]:
        links = special_files(folder, names)
        below = Path(folder).relative_to(source / RECONSTRUCTIONS).parts
        if below[1:2] != ("work",):
            return links
        locks = {n for n in names if n.startswith("lock")} if len(below) == 2 else set()
        return links | locks | {n for n in names if n.endswith(".part")}

    if (source / RECONSTRUCTIONS).is_dir():
        shutil.copytree(
            source / RECONSTRUCTIONS,
            target / RECONSTRUCTIONS,
            copy_function=take,
            ignore=unfinished,
        )


def move_reconstructions(source: Path, target: Path) -> None:
    """Raises TargetError; then they are where they were."""
    if not (source / RECONSTRUCTIONS).is_dir():
        return
    try:
        (source / RECONSTRUCTIONS).rename(target / RECONSTRUCTIONS)
        return
    except OSError:
        # A folder of the same disk that is mounted elsewhere, or a file that somebody has open.
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
