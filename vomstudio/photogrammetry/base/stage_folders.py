"""Result folders of reconstruction stages."""

from __future__ import annotations

import re
from pathlib import Path

from vomstudio.io.models.reconstruction_file import WORK

FEATURES = "features"
"""Folder of the features of all photos, which all alignments share."""


def stage_folder(out: Path, name: str) -> Path | None:
    """Return the newest complete folder of a stage of the reconstruction in `out`.

    Returns None if the stage is not finished. A run updates the time of every folder that it uses,
    and folders of earlier photos and settings are kept.
    """
    name_pattern = re.compile(rf"{re.escape(name)}-[0-9a-f]+")
    folders = []
    try:
        for path in (out / WORK).iterdir():
            if name_pattern.fullmatch(path.name) and path.is_dir():
                folders.append((path.stat().st_mtime_ns, path))
    except OSError:
        return None
    return max(folders)[1] if folders else None


def is_aligned(out: Path) -> bool:
    """Return whether the photos of the reconstruction in `out` have been aligned and placed."""
    return stage_folder(out, "frame") is not None
