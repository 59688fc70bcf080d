"""Files and folders that are dragged onto the window."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtGui import QDropEvent

_TEXTURED_MODEL_SUFFIXES = (".obj", ".gltf", ".ply")
_IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".heic", ".heif")
"""Suffixes of image files. TIFF is excluded, because its files may be height models."""
_COMPANION_SUFFIXES = (*_IMAGE_SUFFIXES, ".mtl", ".bin", ".prj")
"""Suffixes of files that belong to a textured model in the same folder."""


def dragged_files(event: QDropEvent) -> list[Path]:
    """Return the paths to open for the dragged local files and folders.

    A photo is replaced by its folder. Textures and materials that are dragged together with their
    model are omitted, because they are read with it.
    """
    paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
    folders = {path.parent for path in paths if path.suffix.lower() in _TEXTURED_MODEL_SUFFIXES}
    files = [
        p for p in paths if p.suffix.lower() not in _COMPANION_SUFFIXES or p.parent not in folders
    ]
    targets = [path.parent if path.suffix.lower() in _IMAGE_SUFFIXES else path for path in files]
    return list(dict.fromkeys(targets))
