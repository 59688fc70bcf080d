"""Masks that are drawn: where they are kept, so that `read_photos` finds them, and how.

A mask is a PNG of 8 bits and of the photo's size as it is stored: white is used, black is not.
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
from vomstudio.io.photos.pixels import opened, read_mask

_SOFTWARE = "VOM Studio"


def mask_place(photo: Path, others: Iterable[Path] = ()) -> Path:
    """Where the mask of a photo is looked for first. others : photos of the set; of two in one
    folder that differ in their ending only, each has a mask of its own."""
    stem = photo.stem.casefold()
    twins = any(
        other != photo and other.parent == photo.parent and other.stem.casefold() == stem
        for other in others
    )
    return photo.with_name(f"{photo.name}.mask.png" if twins else f"{photo.stem}_mask.png")


def load_mask(mask: Path, width: int, height: int) -> BoolArray:
    """(height, width) True where the photo of this size may be used. Raises InputError."""
    read = read_mask(Photo(mask, mask.name, width, height, mask=mask))
    assert read is not None
    return read


def mask_png(used: BoolArray) -> bytes:
    """A mask (height, width), True where the photo is used, as a PNG of one bit a pixel."""
    import io

    from PIL import Image

    made = io.BytesIO()
    Image.fromarray(used).save(made, format="PNG", compress_level=1)
    return made.getvalue()


def write_mask(path: Path, used: BoolArray) -> Path | None:
    """Write a mask (height, width), True where the photo is used, whole or not at all.

    Returns where a mask was put that another program, or a person, had made. Raises TargetError.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    check_generated_path(path)
    kept = back_up(path) if path.exists() and not is_ours(path) else None
    said = PngInfo()
    said.add_text("Software", _SOFTWARE)
    image = Image.fromarray(used.astype(np.uint8) * np.uint8(255))
    with atomic_write(path, force=True) as temporary:
        image.save(temporary, format="PNG", compress_level=3, pnginfo=said)
    return kept


def is_ours(path: Path) -> bool:
    """A mask that this program has written."""
    try:
        with opened(path, min_pixel_bytes=MASK_BYTES) as image:
            return image.info.get("Software") == _SOFTWARE
    except InputError:
        return False


def keep_mask(place: Path, used: BoolArray, found: Path | None) -> tuple[Path | None, Path | None]:
    """Write a mask to its place; where nothing is masked there is none afterwards, unless another
    file would then be taken for it. found : the photo's mask as it was found, if there was one.

    Returns where the mask is, and where one was put that somebody else had made. Raises
    TargetError.
    """
    if not used.all() or (found is not None and found != place):
        return place, write_mask(place, used)
    if not place.exists():
        return None, None
    kept = None if is_ours(place) else back_up(place)
    try:
        place.unlink()
    except OSError as error:
        raise TargetError(Finding("file.not-removed", reason=error.strerror), file=place) from error
    return None, kept
