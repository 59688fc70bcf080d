"""Pixels of photos: upright thumbnails for display, grey values for measurements, masks."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray, BoolArray, ByteArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.pictures import (
    COLOR_BYTES,
    MASK_BYTES,
    PHOTO_FORMATS,
    convert_to_8_bits,
    open_picture,
)
from vomstudio.core.findings import Finding

if TYPE_CHECKING:
    from PIL import Image

    from vomstudio.io.photos.photo import Photo


@contextlib.contextmanager
def open_photo(path: str | Path, *, min_pixel_bytes: int = COLOR_BYTES) -> Iterator[Image.Image]:
    """Open a photo, reading only its header.

    Errors raised before the end of the block become an InputError that contains the file name.
    `min_pixel_bytes` is the same as for `open_picture`.
    """
    import warnings

    from PIL import UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with open_picture(path, PHOTO_FORMATS, min_pixel_bytes=min_pixel_bytes) as image:
                yield image
    except FileNotFoundError as error:
        raise InputError(Finding("file.missing"), file=path) from error
    except UnidentifiedImageError as error:
        is_tiff = Path(path).suffix.lower() in (".tif", ".tiff")
        code = "picture.unknown-tiff" if is_tiff else "picture.unknown-kind"
        raise InputError(Finding(code), file=path) from error
    except MemoryError as error:
        raise InputError(Finding("file.exceeds-memory"), file=path) from error
    except (OSError, ValueError, SyntaxError, EOFError, IndexError, TypeError, KeyError) as error:
        # Exceptions that Pillow's decoders raise for damaged data.
        reason = str(error) or type(error).__name__
        raise InputError(
            Finding("file.damaged", reason=reason, format=Path(path).suffix.lstrip(".").upper()),
            file=path,
        ) from error


def rotate_upright(pixels: AnyArray, orientation: int) -> AnyArray:
    """Rotate stored pixels upright according to the EXIF orientation (tag 0x0112)."""
    transforms: dict[int, Callable[[AnyArray], AnyArray]] = {
        1: lambda pixels: pixels,
        2: lambda pixels: pixels[:, ::-1],
        3: lambda pixels: pixels[::-1, ::-1],
        4: lambda pixels: pixels[::-1],
        5: lambda pixels: pixels.swapaxes(0, 1),
        6: lambda pixels: pixels.swapaxes(0, 1)[:, ::-1],
        7: lambda pixels: pixels.swapaxes(0, 1)[::-1, ::-1],
        8: lambda pixels: pixels.swapaxes(0, 1)[::-1],
    }
    transpose = transforms[orientation if orientation in range(1, 9) else 1]
    return np.ascontiguousarray(transpose(pixels))


def rotate_pixels_upright(
    pixels: npt.ArrayLike, orientation: int, width: int, height: int
) -> FloatArray:
    """Return the positions of stored pixels (n, 2) in the upright image, in pixels."""
    x, y = np.asarray(pixels, np.float64).reshape(-1, 2).T
    a, b = {
        1: (x, y),
        2: (width - x, y),
        3: (width - x, height - y),
        4: (x, height - y),
        5: (y, x),
        6: (height - y, x),
        7: (height - y, width - x),
        8: (y, width - x),
    }[orientation if orientation in range(1, 9) else 1]
    return np.column_stack([a, b])


def read_orientation(photo: str | Path) -> int:
    """Return the EXIF orientation, 1 to 8. Raises InputError."""
    from vomstudio.io.photos.exif import read_exif

    with open_photo(photo) as image:
        return read_exif(image).orientation


def read_stored_image(photo: str | Path, size: int) -> tuple[ByteArray, tuple[int, int], int]:
    """Return a reduced image in the stored orientation.

    Returns
    -------
    pixels : (h, w, 3) uint8
        Pixels of the image, whose long side is at most `size`.
    size : tuple of int
        Width and height of the photo.
    orientation : int
        EXIF orientation.

    Raises
    ------
    InputError
        If the photo cannot be read.
    """
    from vomstudio.io.photos.exif import read_exif

    with open_photo(photo) as image:
        full_size = (image.width, image.height)
        orientation = read_exif(image).orientation
        return np.asarray(_reduced_image(image, size, "RGB")), full_size, orientation


def thumbnail(photo: Photo | str | Path, size: int = 256) -> ByteArray:
    """Return an upright image (h, w, 3) uint8 whose long side is at most `size` pixels.

    JPEG photos are decoded at an eighth, a quarter or half of their size, which avoids most of the
    work. The thumbnail embedded by cameras is not used because it is too small and often has black
    borders. Raises InputError.
    """
    from vomstudio.io.photos.exif import read_exif

    path = Path(photo) if isinstance(photo, str | Path) else photo.path
    with open_photo(path) as image:
        orientation = read_exif(image).orientation
        return rotate_upright(np.asarray(_reduced_image(image, size, "RGB")), orientation)


def grey(photo: Photo | str | Path, size: int | None = None) -> ByteArray:
    """Return stored grey values (h, w) uint8, reduced to a long side of at most `size`.

    If `size` is None, they are not reduced. Raises InputError.
    """
    path = Path(photo) if isinstance(photo, str | Path) else photo.path
    with open_photo(path) as image:
        return np.asarray(_reduced_image(image, size, "L"))


def read_mask(photo: Photo) -> BoolArray | None:
    """Return the mask (height, width) of the stored photo, True where it is used, or None.

    White pixels are used, and black pixels are not. A mask of a different size is resized. Raises
    InputError.
    """
    if photo.mask is None:
        return None
    from PIL import Image

    with open_photo(photo.mask, min_pixel_bytes=MASK_BYTES) as image:
        band = image.getchannel("A") if image.mode in ("LA", "PA") else image
        if band.mode not in ("L", "1", "I", "I;16"):
            band = band.convert("L")
        if band.size != (photo.width, photo.height):
            band = band.resize((photo.width, photo.height), Image.Resampling.NEAREST)
        values = np.asarray(band)
    # Some programs write 0 and 1, and others 0 and 255.
    return np.asarray(values > (0 if values.max(initial=0) <= 1 else 127))


def _reduced_image(image: Image.Image, size: int | None, mode: str) -> Image.Image:
    from PIL import Image

    if size is not None and max(image.size) > size:
        image.draft(mode, (size, size))
    image = convert_to_8_bits(image)
    if size is not None and max(image.size) > size:
        reduction = max(image.size) // (2 * size)
        if reduction > 1:
            image = image.reduce(reduction)
        scale = size / max(image.size)
        reduced_size = tuple(max(1, round(size * scale)) for size in image.size)
        image = image.resize((reduced_size[0], reduced_size[1]), Image.Resampling.BILINEAR)
    return image if image.mode == mode else image.convert(mode)
