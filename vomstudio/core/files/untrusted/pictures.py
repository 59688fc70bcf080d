"""Pictures from unknown sources, which are opened only by the decoders listed here.

Pillow chooses a decoder by the content and not by the file name; one of its decoders starts
Ghostscript to run a PostScript file. Therefore the header is parsed here before decoding. A picture
is rejected if it would keep the decoder busy for minutes, or if it needs more memory than the size
of its file justifies (`budgets.decoding_limit`).

HEIF photos are decoded in a separate process (`heif`).

Every picture is opened by `open_picture` (Pillow), by `decode_picture` (OpenCV), or by a library
that opens files by name after a call of `check_picture` or, for rasters that are read in windows,
of `check_raster`.
"""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from vomstudio.core.arrays import AnyArray, ByteArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file, require_regular_file
from vomstudio.core.files.untrusted import heif
from vomstudio.core.files.untrusted.budgets import compression_limit, decoding_limit
from vomstudio.core.files.untrusted.picture_headers import (
    JPEG_SIGNATURE,
    PNG_SIGNATURE,
    TIFF_SIGNATURES,
    HeaderError,
    PictureSize,
    block_sizes,
    check_exif,
    read_size,
)
from vomstudio.core.findings import Finding

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFile import ImageFile

PHOTO_FORMATS = ("JPEG", "PNG", "TIFF", heif.FORMAT)
"""Formats of photos and masks. JPEG includes MPO, which is a JPEG with a preview."""
TEXTURE_FORMATS = (*PHOTO_FORMATS, "WEBP", "BMP", "TGA")
COLOR_BYTES = 4
"""Bytes of an RGB pixel in memory, both in Pillow and in Qt."""
MASK_BYTES = 1
"""Bytes of a mask pixel in memory; masks are not converted to RGB."""
RASTER_CACHE_BYTES = 256 << 20
"""Size of GDAL's block cache, which is 5 % of the total memory by default."""

_ROWS_PER_BLOCK = 512
_PHOTO_SIGNATURES = (JPEG_SIGNATURE, PNG_SIGNATURE, *TIFF_SIGNATURES)


def open_picture(
    source: str | Path | bytes,
    formats: tuple[str, ...] = TEXTURE_FORMATS,
    *,
    min_pixel_bytes: int = COLOR_BYTES,
    header_only: bool = False,
) -> ImageFile:
    """Open a picture with Pillow, which reads only its header at first.

    Parameters
    ----------
    source : str, Path or bytes
        Path or content of the file.
    formats : tuple of str
        Pillow's format names: `PHOTO_FORMATS` or `TEXTURE_FORMATS`.
    min_pixel_bytes : int
        Minimum size of a decoded pixel: `COLOR_BYTES` or `MASK_BYTES`.
    header_only : bool
        Whether only the header is used. If True, the free memory is not checked.

    Returns
    -------
    PIL.ImageFile.ImageFile
        The opened picture, which the caller must close.

    Raises
    ------
    InputError
        If the path is not a regular file. The code is ``file.picture-too-large`` if the decoded
        picture needs more memory than the size of the file justifies, and ``file.picture-header``
        if the header is not like that of a valid file.
    PIL.UnidentifiedImageError
        If the file is not a picture of one of these formats.
    OSError, ValueError, SyntaxError
        If the file is damaged, as raised by Pillow's decoders.
    """
    from PIL import Image, UnidentifiedImageError

    # Photos and textures exceed Pillow's default limit.
    Image.MAX_IMAGE_PIXELS = None
    heif.register_pillow_format()
    if not isinstance(source, bytes):
        require_regular_file(source)
    file = io.BytesIO(source) if isinstance(source, bytes) else _UnmappedFile(source)
    name = None if isinstance(source, bytes) else source
    pixel_bytes = None if header_only else min_pixel_bytes
    try:
        with _convert_errors(name):
            _check_size(file, read_size(file), pixel_bytes)
        file.seek(0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = Image.open(file, formats=formats)
    except UnidentifiedImageError as error:
        file.close()
        if isinstance(source, bytes):
            raise
        # Pillow's message would contain the file object instead of the name.
        message = f"cannot identify image file {os.fspath(source)!r}"
        raise UnidentifiedImageError(message) from error
    except BaseException:
        file.close()
        raise
    try:
        with _convert_errors(name):
            # Covers formats whose header is not parsed here (TGA), and the size that Pillow read.
            _check_size(file, PictureSize(*image.size, 1), pixel_bytes)
            exif = image.info.get("exif")
            if image.format not in ("JPEG", "MPO", "TIFF") and isinstance(exif, bytes):
                check_exif(exif)
    except BaseException:
        image.close()
        raise
    return image


def check_picture(path: str | Path, *, min_pixel_bytes: int = COLOR_BYTES) -> None:
    """Check a photo that a library will open by name and decode completely.

    Raises
    ------
    InputError
        As for `open_picture`, or if the file is not a JPEG, PNG or TIFF picture.
    OSError
        If the file cannot be read.
    """
    with open_regular_file(path) as file, _convert_errors(path):
        _check_photo(file, min_pixel_bytes)


def check_raster(path: str | Path) -> None:
    """Check a GeoTIFF that rasterio will open by name and read in windows.

    Only one block (strip or tile) is in memory at a time. The size of the decompressed raster is
    limited by `budgets.compression_limit`.

    Raises
    ------
    InputError
        With the code ``file.picture-too-large`` or ``file.picture-header``.
    OSError
        If the file cannot be read.
    """
    with open_regular_file(path) as file, _convert_errors(path):
        if not file.read(4).startswith(TIFF_SIGNATURES):
            # GDAL will reject the file because it is opened as a GeoTIFF.
            return
        size = file.seek(0, io.SEEK_END)
        limit = decoding_limit(size)
        for picture in block_sizes(file):
            if picture.extra_bytes > limit:
                raise _PictureTooLargeError(picture, picture.extra_bytes, limit)
            if picture.stored_bytes > compression_limit(size):
                raise _PictureTooLargeError(picture, picture.stored_bytes, compression_limit(size))


def decode_picture(
    content: bytes, flags: int, name: str, *, min_pixel_bytes: int = COLOR_BYTES
) -> AnyArray | None:
    """Decode a JPEG, PNG, TIFF or HEIF with OpenCV's flags, ignoring the orientation tag.

    Parameters
    ----------
    content : bytes
    flags : int
        OpenCV flags such as ``cv2.IMREAD_COLOR``.
    name : str
        File name for error messages.
    min_pixel_bytes : int
        As for `open_picture`.

    Returns
    -------
    array or None
        Pixels, or None if the content has another format or cannot be decoded.

    Raises
    ------
    InputError
        With the code ``file.picture-too-large`` or ``file.picture-header``.
    """
    import cv2

    is_heif = heif.is_heif(content[:12])
    if not (is_heif or content.startswith(_PHOTO_SIGNATURES)):
        return None
    with _convert_errors(name):
        size = read_size(file := io.BytesIO(content))
        _check_size(file, size, min_pixel_bytes)
    if size is None:
        return None
    if is_heif:
        return _decode_heif(content, flags, name)
    try:
        pixels = cv2.imdecode(
            np.frombuffer(content, np.uint8), flags | cv2.IMREAD_IGNORE_ORIENTATION
        )
    except cv2.error:
        return None
    return None if pixels is None else np.asarray(pixels)


def _decode_heif(content: bytes, flags: int, name: str) -> AnyArray | None:
    import cv2

    try:
        pixels = heif.decode(content, name)
    except (OSError, ValueError):
        return None
    if flags == cv2.IMREAD_COLOR_RGB:
        return pixels
    is_grey = flags == cv2.IMREAD_GRAYSCALE
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY if is_grey else cv2.COLOR_RGB2BGR))


class _PictureTooLargeError(Exception):
    def __init__(self, picture: PictureSize, needed_bytes: int, limit: int) -> None:
        super().__init__(needed_bytes)
        self.finding = Finding(
            "file.picture-too-large",
            width=picture.width,
            height=picture.height,
            needed_mb=-(-needed_bytes // 1_000_000),
            limit_mb=limit // 1_000_000,
        )


@contextmanager
def _convert_errors(file: str | Path | None) -> Iterator[None]:
    """Convert errors of the checks to an InputError that contains the file name."""
    try:
        yield
    except _PictureTooLargeError as error:
        raise InputError(error.finding, file=file) from None
    except HeaderError as error:
        finding = Finding("file.picture-header", reason=str(error))
        raise InputError(finding, file=file) from None


def _check_photo(file: BinaryIO, min_pixel_bytes: int) -> None:
    file.seek(0)
    if not file.read(len(PNG_SIGNATURE)).startswith(_PHOTO_SIGNATURES):
        raise HeaderError("it is not a JPEG, PNG or TIFF")
    size = read_size(file)
    if size is None:
        raise HeaderError("it does not state its size")
    _check_size(file, size, min_pixel_bytes)


def _check_size(file: BinaryIO, picture: PictureSize | None, min_pixel_bytes: int | None) -> None:
    """Raise _PictureTooLargeError if a picture exceeds its limit.

    Pass None as `min_pixel_bytes` if only the header is read.
    """
    if picture is None:
        return
    size = file.seek(0, io.SEEK_END)
    if min_pixel_bytes is None:
        needed_stored_bytes, limit = picture.stored_bytes, compression_limit(size)
    else:
        needed_stored_bytes, limit = picture.decoded_bytes(min_pixel_bytes), decoding_limit(size)
    if needed_stored_bytes > limit:
        raise _PictureTooLargeError(picture, needed_stored_bytes, limit)


class _UnmappedFile(io.BufferedReader):
    """File without a descriptor, so that Pillow and libtiff cannot memory-map it.

    If a memory-mapped file is truncated or its drive is removed, the process crashes. The file
    closes itself because Pillow closes only the files that it opened.
    """

    _is_opened = False

    def __init__(self, path: str | Path) -> None:
        super().__init__(io.FileIO(path))
        self._is_opened = True

    def fileno(self) -> int:
        raise io.UnsupportedOperation("fileno")

    def __del__(self) -> None:
        if self._is_opened:
            self.close()


def convert_to_rgb(picture: Image) -> Image:
    """Convert a picture to RGB; return an RGB picture itself, because `convert` would copy it."""
    picture.load()
    return picture if picture.mode == "RGB" else picture.convert("RGB")


def copy_pixels(picture: Image, out: ByteArray) -> None:
    """Copy the pixels of a picture into an array (height, width, bands), in blocks of rows.

    `numpy.asarray` needs twice the memory of the result.
    """
    for top in range(0, picture.height, _ROWS_PER_BLOCK):
        bottom = min(top + _ROWS_PER_BLOCK, picture.height)
        out[top:bottom] = np.asarray(picture.crop((0, top, picture.width, bottom)))


def convert_to_8_bits(picture: Image) -> Image:
    """Convert 16-bit, palette and black-and-white pictures to 8-bit grey or RGB.

    Other pictures are returned unchanged. Pillow cannot downscale palette and 1-bit pictures.
    """
    from PIL import Image

    if picture.mode in ("P", "PA", "1"):
        return picture.convert("L" if picture.mode == "1" else "RGB")
    if picture.mode not in ("I;16", "I;16B", "I;16L", "I"):
        return picture
    high_bytes = np.asarray(picture) >> 8
    if picture.mode == "I":
        np.clip(high_bytes, 0, 255, out=high_bytes)
    return Image.fromarray(high_bytes.astype(np.uint8))
