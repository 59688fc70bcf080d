"""Textures that are decoded in the background."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.pictures import convert_to_rgb
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

OVERVIEW_SIDE_PIXELS = 512
MAX_FILE_PIXELS = 1 << 30


class TextureProblem(Exception):
    """Error for a texture that cannot be drawn; `finding` states its name and the reason."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(finding.message)
        self.finding = finding


@dataclass(frozen=True, eq=False)
class Level:
    """Mipmap level of a texture, with rows from bottom to top.

    Parameters
    ----------
    width, height : int
        Size of the complete picture, pixels.
    tiles : tuple of arrays
        The complete picture as one tile, or its quarters in the order lower left, lower right,
        upper left, upper right. Each quarter has a border of one pixel that repeats the adjacent
        pixels; at the edge of the picture, these are the pixels of the opposite edge.
    """

    width: int
    height: int
    tiles: tuple[ByteArray, ...]


@dataclass(frozen=True, eq=False)
class Texture:
    """Texture with its mipmap levels.

    The finest level is the first, and each level is half the size of the previous one.
    `note` is a finding if the picture had to be downsampled, otherwise None.
    """

    path: Path
    levels: tuple[Level, ...]
    note: Finding | None = None


def open_picture(path: Path):  # type: ignore[no-untyped-def]
    """Open the picture file of a texture.

    Raises
    ------
    TextureProblem
        If the file cannot be read or is too large.
    """
    from vomstudio.core.files.untrusted import pictures

    try:
        picture = pictures.open_picture(path)
    except (InputError, OSError, ValueError, SyntaxError) as error:
        raise TextureProblem(
            Finding("display.texture-unreadable", file=str(path), reason=reason(error))
        ) from error
    if picture.width * picture.height > MAX_FILE_PIXELS:
        raise TextureProblem(
            Finding(
                "display.texture-too-large",
                file=str(path),
                width=picture.width,
                height=picture.height,
            )
        )
    return picture


def reason(error: Exception) -> str:
    """Return the reason why a texture cannot be read."""
    if isinstance(error, FileNotFoundError):
        return tr("file not found")
    text = error.message if isinstance(error, InputError) else str(error)
    return text.splitlines()[0][:120].rstrip(".") if text else type(error).__name__


def overview(path: Path) -> ByteArray | None:
    """Return a small RGB picture for vertex colours, or None if it cannot be read."""
    try:
        with open_picture(path) as picture:
            picture.draft("RGB", (OVERVIEW_SIDE_PIXELS, OVERVIEW_SIDE_PIXELS))
            reduced_picture = convert_to_rgb(picture)
            factor = max(1, min(reduced_picture.size) // OVERVIEW_SIDE_PIXELS)
            return np.asarray(reduced_picture.reduce(factor) if factor > 1 else reduced_picture)
    except (TextureProblem, OSError, ValueError, SyntaxError):
        return None


def load_texture(path: Path, limit: int, max_whole_side: int | None = None) -> Texture:
    """Decode a texture and compute its coarser mipmap levels.

    Parameters
    ----------
    path : Path
    limit : int
        Maximum side length, pixels.
    max_whole_side : int, optional
        Maximum side length of undivided levels, pixels. Larger levels are divided into quarters.

    Raises
    ------
    TextureProblem
        If the file cannot be read, is damaged or is too large.
    """
    from PIL import Image

    note: Finding | None = None
    with open_picture(path) as picture:
        width, height = picture.size
        factor = 1
        while max(width, height) / factor > limit:
            factor *= 2
        try:
            if factor > 1:
                note = Finding(
                    "display.texture-reduced",
                    file=str(path),
                    width=width,
                    height=height,
                    limit=limit,
                    factor=factor,
                )
                picture.draft("RGB", (max(1, width // factor), max(1, height // factor)))
            image = convert_to_rgb(picture)
            reduction = max(1, -(-max(image.size) // limit))
            if reduction > 1:
                image = image.reduce(reduction)
        except (OSError, ValueError, SyntaxError) as error:
            raise TextureProblem(
                Finding("display.texture-damaged", file=str(path), reason=reason(error))
            ) from error
    # Copies are avoided, because a large texture takes a gigabyte.
    del picture
    image = image.transpose(Image.Transpose.FLIP_TOP_BOTTOM)
    levels = [make_level(np.asarray(image), max_whole_side)]
    while min(image.size) > 256 and len(levels) < 6:
        image = image.reduce(2)
        levels.append(make_level(np.asarray(image), max_whole_side))
    return Texture(path, tuple(levels), note)


def make_level(pixels: ByteArray, max_whole_side: int | None) -> Level:
    """Create a level from pixels (height, width, 3), whose first row is at the bottom."""
    height, width = pixels.shape[:2]
    if max_whole_side is None or max(height, width) <= max_whole_side or min(height, width) < 2:
        return Level(width, height, (pixels,))
    padded_pixels = np.pad(pixels, ((1, 1), (1, 1), (0, 0)), mode="wrap")
    rows = [(0, height // 2 + 2), (height // 2, height + 2)]
    columns = [(0, width // 2 + 2), (width // 2, width + 2)]
    tiles = tuple(
        np.ascontiguousarray(padded_pixels[a:b, c:d]) for a, b in rows for c, d in columns
    )
    return Level(width, height, tiles)
