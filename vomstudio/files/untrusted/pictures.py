"""Pictures from anywhere: opened by the decoders that are named here, and by no other.

Pillow chooses a decoder by the content, whatever the file is called; one of them starts Ghostscript
to run the program that a PostScript file is. Before a decoder begins, the header is read here: it
is refused if it would keep the decoder busy for minutes, or if the picture takes more memory than
its file can be worth (`budgets.decoded_limit`).

Every picture is opened by `open_picture` (Pillow), `decode_picture` (OpenCV), or by a library that
opens names itself after `check_picture` or, for rasters that are read in windows, `check_raster`.
"""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding
from vomstudio.errors import InputError
from vomstudio.files.regular import open_regular, require_regular
from vomstudio.files.untrusted.budgets import compression_limit, decoded_limit
from vomstudio.files.untrusted.picture_headers import (
    JPEG_MARK,
    PNG_MARK,
    TIFF_MARKS,
    HeaderError,
    PictureSize,
    block_sizes,
    check_exif,
    read_size,
)

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFile import ImageFile

PHOTOS = ("JPEG", "PNG", "TIFF")
"""What photos and their masks may be. Among JPEG is MPO, of cameras that keep a preview in it."""
TEXTURES = (*PHOTOS, "WEBP", "BMP", "TGA")
COLOR_BYTES = 4
"""Of a pixel in memory, as Pillow and Qt hold red, green and blue."""
MASK_BYTES = 1
"""Of a pixel of a mask, which nobody turns into colours."""
RASTER_CACHE_BYTES = 256 << 20
"""For blocks that GDAL has decoded; 5 % of all memory otherwise."""

_ROWS = 512
_PHOTO_MARKS = (JPEG_MARK, PNG_MARK, *TIFF_MARKS)


def open_picture(
    source: str | Path | bytes,
    formats: tuple[str, ...] = TEXTURES,
    *,
    min_pixel_bytes: int = COLOR_BYTES,
    header_only: bool = False,
) -> ImageFile:
    """Open a picture with Pillow; only its header is read yet.

    Parameters
    ----------
    source : str, Path or bytes
        A file, or its content.
    formats : tuple of str
        Pillow's names: `PHOTOS` or `TEXTURES`.
    min_pixel_bytes : int
        What a pixel takes at least once it is decoded: `COLOR_BYTES` or `MASK_BYTES`.
    header_only : bool
        Nobody will decode it: the free memory does not count.

    Returns
    -------
    PIL.ImageFile.ImageFile
        To be closed by the caller.

    Raises
    ------
    InputError
        If it is not a regular file; with ``file.picture-too-large`` if the decoded picture would
        take more memory than the file can be worth, and with ``file.picture-header`` for a header
        that no honest program writes.
    PIL.UnidentifiedImageError
        If it is not a picture of these formats.
    OSError, ValueError, SyntaxError
        If it is damaged, as Pillow's decoders do.
    """
    from PIL import Image, UnidentifiedImageError

    # Photos and textures are larger than Pillow's idea of an attack.
    Image.MAX_IMAGE_PIXELS = None
    if not isinstance(source, bytes):
        require_regular(source)
    file = io.BytesIO(source) if isinstance(source, bytes) else _Unmapped(source)
    name = None if isinstance(source, bytes) else source
    pixel_bytes = None if header_only else min_pixel_bytes
    try:
        with _refusals(name):
            _check_size(file, read_size(file), pixel_bytes)
        file.seek(0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = Image.open(file, formats=formats)
    except UnidentifiedImageError as error:
        file.close()
        if isinstance(source, bytes):
            raise
        # Pillow would name the object that is read.
        said = f"cannot identify image file {os.fspath(source)!r}"
        raise UnidentifiedImageError(said) from error
    except BaseException:
        file.close()
        raise
    try:
        with _refusals(name):
            # Of formats without a header of their own (TGA), and as this decoder has understood it.
            _check_size(file, PictureSize(*image.size, 1), pixel_bytes)
            exif = image.info.get("exif")
            if image.format not in ("JPEG", "MPO", "TIFF") and isinstance(exif, bytes):
                check_exif(exif)
    except BaseException:
        image.close()
        raise
    return image


def check_picture(path: str | Path, *, min_pixel_bytes: int = COLOR_BYTES) -> None:
    """Check a photo that a library will open by its name and decode as a whole.

    Raises
    ------
    InputError
        As `open_picture`; also if the file is not a JPEG, PNG or TIFF.
    OSError
        If the file cannot be read.
    """
    with open_regular(path) as file, _refusals(path):
        _check_photo(file, min_pixel_bytes)


def check_raster(path: str | Path) -> None:
    """Check a GeoTIFF that rasterio will open by its name and read in windows.

    Of a raster that is read in windows only a block, a strip or a tile, is in memory at a time; no
    compression makes the whole of it larger than `budgets.compression_limit`.

    Raises
    ------
    InputError
        With ``file.picture-too-large`` or ``file.picture-header``.
    OSError
        If the file cannot be read.
    """
    with open_regular(path) as file, _refusals(path):
        if not file.read(4).startswith(TIFF_MARKS):
            # GDAL refuses it, as it is opened as a GeoTIFF only.
            return
        size = file.seek(0, io.SEEK_END)
        limit = decoded_limit(size)
        for picture in block_sizes(file):
            if picture.extra_bytes > limit:
                raise _TooLarge(picture, picture.extra_bytes, limit)
            if picture.stored_bytes > compression_limit(size):
                raise _TooLarge(picture, picture.stored_bytes, compression_limit(size))


def decode_picture(
    content: bytes, flags: int, name: str, *, min_pixel_bytes: int = COLOR_BYTES
) -> npt.NDArray[Any] | None:
    """Decode a JPEG, PNG or TIFF with OpenCV as it is stored: an orientation tag turns nothing.

    Parameters
    ----------
    content : bytes
    flags : int
        ``cv2.IMREAD_COLOR`` and its like.
    name : str
        Of the file, for errors.
    min_pixel_bytes : int
        As of `open_picture`.

    Returns
    -------
    array or None
        None if it cannot be decoded.

    Raises
    ------
    InputError
        As `check_picture`.
    """
    import cv2

    if not content.startswith(_PHOTO_MARKS):
        return None
    with _refusals(name):
        size = read_size(file := io.BytesIO(content))
        _check_size(file, size, min_pixel_bytes)
    if size is None:
        return None
    try:
        pixels = cv2.imdecode(
            np.frombuffer(content, np.uint8), flags | cv2.IMREAD_IGNORE_ORIENTATION
        )
    except cv2.error:
        return None
    return None if pixels is None else np.asarray(pixels)


class _TooLarge(Exception):
    def __init__(self, picture: PictureSize, needed: int, limit: int) -> None:
        super().__init__(needed)
        self.finding = Finding(
            "file.picture-too-large",
            width=picture.width,
            height=picture.height,
            needed_mb=-(-needed // 1_000_000),
            limit_mb=limit // 1_000_000,
        )


@contextmanager
def _refusals(file: str | Path | None) -> Iterator[None]:
    """Raise what the checks inside find as an InputError that names the file."""
    try:
        yield
    except _TooLarge as error:
        raise InputError.of_finding(error.finding, file=file) from None
    except HeaderError as error:
        finding = Finding("file.picture-header", reason=str(error))
        raise InputError.of_finding(finding, file=file) from None


def _check_photo(file: BinaryIO, min_pixel_bytes: int) -> None:
    file.seek(0)
    if not file.read(len(PNG_MARK)).startswith(_PHOTO_MARKS):
        raise HeaderError("it is not a JPEG, PNG or TIFF")
    size = read_size(file)
    if size is None:
        raise HeaderError("it does not state its size")
    _check_size(file, size, min_pixel_bytes)


def _check_size(file: BinaryIO, picture: PictureSize | None, min_pixel_bytes: int | None) -> None:
    """Raise _TooLarge for a picture that takes too much; min_pixel_bytes : None for a header."""
    if picture is None:
        return
    size = file.seek(0, io.SEEK_END)
    if min_pixel_bytes is None:
        needed, limit = picture.stored_bytes, compression_limit(size)
    else:
        needed, limit = picture.decoded_bytes(min_pixel_bytes), decoded_limit(size)
    if needed > limit:
        raise _TooLarge(picture, needed, limit)


class _Unmapped(io.BufferedReader):
    """A file that nothing maps: Pillow maps pixels that are not packed, libtiff whole files, and
    one that shrinks under a map, or whose drive is pulled out, ends the process. Closes itself, as
    Pillow closes only what it has opened."""

    _opened = False

    def __init__(self, path: str | Path) -> None:
        super().__init__(io.FileIO(path))
        self._opened = True

    def fileno(self) -> int:
        raise io.UnsupportedOperation("fileno")

    def __del__(self) -> None:
        if self._opened:
            self.close()


def as_rgb(picture: Image) -> Image:
    """Return a picture in red, green and blue, itself if it is: `convert` would copy it."""
    picture.load()
    return picture if picture.mode == "RGB" else picture.convert("RGB")


def copy_pixels(picture: Image, out: npt.NDArray[np.uint8]) -> None:
    """Copy the pixels of a picture into an array (height, width, bands), some rows at a time.

    `numpy.asarray` takes twice the memory of the result.
    """
    for top in range(0, picture.height, _ROWS):
        bottom = min(top + _ROWS, picture.height)
        out[top:bottom] = np.asarray(picture.crop((0, top, picture.width, bottom)))


def as_8_bits(picture: Image) -> Image:
    """Return the upper eight of 16 bits, colours of a palette, and grey of black and white.

    Other pictures are returned as they are. The result can be reduced, which Pillow does not do
    with palettes and with single bits.
    """
    from PIL import Image

    if picture.mode in ("P", "PA", "1"):
        return picture.convert("L" if picture.mode == "1" else "RGB")
    if picture.mode not in ("I;16", "I;16B", "I;16L", "I"):
        return picture
    upper = np.asarray(picture) >> 8
    if picture.mode == "I":
        np.clip(upper, 0, 255, out=upper)
    return Image.fromarray(upper.astype(np.uint8))
