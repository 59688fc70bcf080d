"""Storage of images embedded in model files as separate files.

Code that draws or writes textures needs the path of an image. Therefore images embedded in a GLB
file are stored in the user's cache folder under the hash of their content, so that each image is
stored only once. The folder may be deleted at any time; the images are then extracted again.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
from pathlib import Path

from vomstudio.core.paths import user_cache

MAX_NAME_LENGTH = 60
_MAGIC = (
    (b"\xff\xd8\xff", ".jpg"),
    (b"\x89PNG\r\n\x1a\n", ".png"),
    (b"GIF8", ".gif"),
    (b"BM", ".bmp"),
    (b"II*\0", ".tif"),
    (b"MM\0*", ".tif"),
)


def folder() -> Path:
    """Return the folder of the images, which may not exist yet."""
    return user_cache("images")


def image_suffix(content: bytes) -> str:
    """Return the file suffix for the first bytes of an image; ".img" if unknown."""
    if content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        return ".webp"
    return next((suffix for magic, suffix in _MAGIC if content.startswith(magic)), ".img")


def store_image(content: bytes, name: str) -> Path:
    """Store `content` under `name` and return its path. Raises OSError."""
    stem = plain_name(name) or "image"
    target_folder = folder() / hashlib.sha256(content).hexdigest()[:32]
    path = target_folder / f"{stem}{image_suffix(content)}"
    if path.is_file() and path.stat().st_size == len(content):
        return path
    target_folder.mkdir(parents=True, exist_ok=True)
    draft = target_folder / f".{secrets.token_hex(6)}.part"
    try:
        draft.write_bytes(content)
        os.replace(draft, path)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)
    return path


def plain_name(name: str) -> str:
    """Return `name` with characters valid on every system (letters, digits, `_`, `-`, dots)."""
    safe_name = re.sub(r"[^\w.-]+", "_", name)[:MAX_NAME_LENGTH].strip("._-")
    return (
        f"_{safe_name}"
        if re.fullmatch(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?", safe_name)
        else safe_name
    )
