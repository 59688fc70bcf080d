"""Images that came inside a model's file, kept as files of their own.

Everything that draws or writes a texture wants the path of an image. What is embedded in a GLB is
therefore laid into the user's cache folder, under the hash of its content: the same image is kept
once, whichever files it came in. The folder may be deleted at any time; the images are taken out of
their models again then.
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
    """Where the images are; it need not exist yet."""
    return user_cache("images")


def ending_of(content: bytes) -> str:
    """The file ending that an image's first bytes call for; ".img" where they are unknown."""
    if content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        return ".webp"
    return next((ending for magic, ending in _MAGIC if content.startswith(magic)), ".img")


def keep(content: bytes, name: str) -> Path:
    """The path of a file that holds `content`, called after `name`. Raises OSError."""
    stem = plain_name(name) or "image"
    place = folder() / hashlib.sha256(content).hexdigest()[:32]
    path = place / f"{stem}{ending_of(content)}"
    if path.is_file() and path.stat().st_size == len(content):
        return path
    place.mkdir(parents=True, exist_ok=True)
    draft = place / f".{secrets.token_hex(6)}.part"
    try:
        draft.write_bytes(content)
        os.replace(draft, path)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)
    return path


def plain_name(name: str) -> str:
    """`name` as a file may be called on every system: letters, digits, `_`, `-` and dots inside."""
    plain = re.sub(r"[^\w.-]+", "_", name)[:MAX_NAME_LENGTH].strip("._-")
    return (
        f"_{plain}" if re.fullmatch(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?", plain) else plain
    )
