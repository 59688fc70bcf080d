"""Sizes of the photos of a camera file that does not state them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.io.photos.own_cameras.photos import find_photos
from vomstudio.io.photos.own_cameras.result import pinhole_lens
from vomstudio.io.photos.pixels import open_photo

Size = tuple[int, int]
"""Width and height in pixels, as stored in the file."""


def read_sizes(path: Path, names: Sequence[str]) -> dict[str, Size]:
    """Return the sizes of photos by name, omitting photos that cannot be read.

    Parameters
    ----------
    path : Path
        Camera file; the photos are searched for in folders near it.
    names : sequence of str
        Names of the photos.
    """
    sizes = {}
    for name, photo in find_photos(path, names).items():
        try:
            with open_photo(photo) as image:
                sizes[name] = image.size
        except InputError:
            continue
    return sizes


def unknown_size_findings(sizes: dict[str, Size], names: Sequence[str]) -> list[Finding]:
    """Return the finding about photos of unknown size.

    Returns
    -------
    list of Finding
        Empty if all sizes are known.
    """
    missing_names = [name for name in names if name not in sizes]
    return (
        [Finding("cameras.sizes-unknown", photos=missing_names, count=len(missing_names))]
        if missing_names
        else []
    )


def placeholder_lens() -> Intrinsics:
    """Return a lens for a photo that has a usable pose but no usable lens."""
    return pinhole_lens(2, 2, 2.0)
