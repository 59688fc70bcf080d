"""Files and folders that are dragged onto the window."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtGui import QDropEvent

_TEXTURED_MODELS = (".obj", ".gltf", ".ply")
_IMAGES = (".jpg", ".jpeg", ".png")
"""Endings of images. TIFF is missing, because its files may be height models."""
_PARTS = (*_IMAGES, ".mtl", ".bin", ".prj")
"""Files that belong to a textured model in the same folder."""


def dragged_files(event: QDropEvent) -> list[Path]:
    """Return the paths to open of the dragged local files and folders.

    Photos are opened by their folder. Textures and materials that are dragged together with their
    model are read with it.
    """
    paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
    folders = {path.parent for path in paths if path.suffix.lower() in _TEXTURED_MODELS}
    files = [p for p in paths if p.suffix.lower() not in _PARTS or p.parent not in folders]
    targets = [path.parent if path.suffix.lower() in _IMAGES else path for path in files]
    return list(dict.fromkeys(targets))
