"""Files that rows of the journal name: masks, and what else is too large for a row.

Each is named by the SHA-256 of its content, written whole before the row that names it, and never
written again; undoing finds it where it was. `compact` alone removes those that no row names.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from vomstudio.document.records import Asset
from vomstudio.errors import InputError
from vomstudio.files.atomic import write_bytes
from vomstudio.files.inside import make_folder
from vomstudio.words import tr

FOLDER = "assets"


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
