"""Drawn masks: their format, and the location where `read_photos` finds them.

A mask is an 8-bit PNG with the size of the stored photo, in which white pixels are used and black
pixels are not.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.files.backup import back_up
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.untrusted.pictures import MASK_BYTES
from vomstudio.core.findings import Finding
from vomstudio.io.photos.photo import Photo
from vomstudio.io.photos.pixels import open_photo, read_mask

_SOFTWARE = "VOM Studio"


def mask_path(photo: Path, other_paths: Iterable[Path] = ()) -> Path:
    """Return the path that is searched first for the mask of a photo.

    `other_paths` are the photos of the set: two photos in one folder that differ only in their
    suffix have separate masks.
    """
    stem = photo.stem.casefold()
    has_twin = any(
        other_path != photo
        and other_path.parent == photo.parent
        and other_path.stem.casefold() == stem
        for other_path in other_paths
    )
    return photo.with_name(f"{photo.name}.mask.png" if has_twin else f"{photo.stem}_mask.png")


def load_mask(mask: Path, width: int, height: int) -> BoolArray:
    """Return the mask (height, width) of a photo; True marks the used part.

    Raises InputError.
    """
    mask_array = read_mask(Photo(mask, mask.name, width, height, mask=mask))
    assert mask_array is not None
    return mask_array


def mask_png(is_used: BoolArray) -> bytes:
    """Return a mask (height, width), True where the photo is used, as a 1-bit PNG."""
    import io

    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(is_used).save(stream, format="PNG", compress_level=1)
    return stream.getvalue()


def write_mask(path: Path, is_used: BoolArray) -> Path | None:
    """Write a mask (height, width) atomically; True marks the used part of the photo.

    Returns the new path of an existing mask from another program or person, or None. Raises
    TargetError.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    check_generated_path(path)
    backup = back_up(path) if path.exists() and not is_own_mask(path) else None
    png_info = PngInfo()
    png_info.add_text("Software", _SOFTWARE)
    image = Image.fromarray(is_used.astype(np.uint8) * np.uint8(255))
    with atomic_write(path, force=True) as temporary:
        image.save(temporary, format="PNG", compress_level=3, pnginfo=png_info)
    return backup


def is_own_mask(path: Path) -> bool:
    """Return whether a mask was written by this program."""
    try:
        with open_photo(path, min_pixel_bytes=MASK_BYTES) as image:
            return image.info.get("Software") == _SOFTWARE
    except InputError:
        return False


def store_mask(
    path: Path, is_used: BoolArray, previous_path: Path | None
) -> tuple[Path | None, Path | None]:
    """Write a mask, or remove the file if nothing is masked.

    An empty mask is still written if another file would otherwise be used as a mask.

    Parameters
    ----------
    path : Path
        Path of the mask.
    is_used : (h, w) ndarray of bool
        True for used pixels.
    previous_path : Path or None
        Previous mask of the photo.

    Returns
    -------
    tuple of Path or None
        Path of the mask, and new path of an existing mask that was created by another program or
        person.

    Raises
    ------
    TargetError
        If a file cannot be written or removed.
    """
    if not is_used.all() or (previous_path is not None and previous_path != path):
        return path, write_mask(path, is_used)
    if not path.exists():
        return None, None
    backup = None if is_own_mask(path) else back_up(path)
    try:
        path.unlink()
    except OSError as error:
        raise TargetError(Finding("file.not-removed", reason=error.strerror), file=path) from error
    return None, backup
