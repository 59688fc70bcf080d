"""Texture pyramids for accurate pictures at any scale."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import ByteArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.pictures import convert_to_rgb, copy_pixels, open_picture

if TYPE_CHECKING:
    from PIL import Image

MEMORY_BYTES = 1_500_000_000
"""Memory limit for decoded textures, beyond which the least recently used are dropped."""


@dataclass(frozen=True, eq=False)
class Pyramid:
    """Pyramid of a texture, RGB, packed row by row from the top.

    Parameters
    ----------
    texels : uint8 array
    offsets : (levels,) int64 array
        Offset of each level in `texels`.
    sizes : (levels, 2) int64 array
        Width and height of each level.
    size : (float, float)
        Size of the finest level, in texels of this pyramid.
    """

    texels: ByteArray
    offsets: IntArray
    sizes: IntArray
    size: tuple[float, float]


def picture_size(path: Path) -> tuple[int, int] | None:
    """Return the width and height of an image file, or None if it cannot be read."""
    try:
        with open_picture(path, header_only=True) as picture:
            return picture.size
    except (InputError, OSError, ValueError, SyntaxError):
        return None


def load_pyramid(path: Path, skipped_count: int) -> Pyramid | None:
    """Load the pyramid of an image without its `skipped_count` finest levels.

    Returns None if the image cannot be read.
    """
    try:
        with open_picture(path) as picture:
            image: Image.Image = convert_to_rgb(picture)
    except (InputError, OSError, ValueError, SyntaxError):
        return None
    del picture
    size = (image.width / 2**skipped_count, image.height / 2**skipped_count)
    if skipped_count:
        image = image.reduce(2**skipped_count)
    # If a side is odd, the last texel is averaged from the existing ones. Texel i of a level always
    # covers texels 2i and 2i + 1 of the previous level.
    sizes = [image.size]
    while max(sizes[-1]) > 1:
        sizes.append(((sizes[-1][0] + 1) // 2, (sizes[-1][1] + 1) // 2))
    ends = np.cumsum([3 * width * height for width, height in sizes])
    offsets = np.concatenate([np.zeros(1, np.int64), ends[:-1]])
    texels = np.empty(ends[-1], np.uint8)
    for offset, end, (width, height) in zip(offsets, ends, sizes, strict=True):
        if image.size != (width, height):
            image = image.reduce(2)
        copy_pixels(image, texels[offset:end].reshape(height, width, 3))
    return Pyramid(texels, offsets, np.array(sizes, np.int64), size)


class TextureStore:
    """Thread-safe cache of pyramids by path."""

    def __init__(self, skipped_levels: dict[Path, int]) -> None:
        """Store, for each path, the number of finest levels that no pixel requires."""
        self._skipped_levels = skipped_levels
        self._cache: OrderedDict[Path, Pyramid | None] = OrderedDict()
        self._lock = threading.Lock()
        self.unreadable_paths: set[Path] = set()

    def get(self, path: Path) -> Pyramid | None:
        with self._lock:
            if path in self._cache:
                self._cache.move_to_end(path)
                return self._cache[path]
            pyramid = load_pyramid(path, self._skipped_levels.get(path, 0))
            if pyramid is None:
                self.unreadable_paths.add(path)
            self._cache[path] = pyramid
            while len(self._cache) > 1 and self._used_bytes() > MEMORY_BYTES:
                self._cache.popitem(last=False)
            return pyramid

    def _used_bytes(self) -> int:
        return sum(pyramid.texels.nbytes for pyramid in self._cache.values() if pyramid is not None)
