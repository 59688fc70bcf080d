"""Pictures from anywhere: opened by the decoders that are named here, and by no other.

Pillow chooses a decoder by the content, whatever the file is called; one of them starts Ghostscript
to run the program that a PostScript file is. Before a decoder begins, the headers are walked here:
those that would keep it busy for minutes, or have it reserve memory that the bytes of the file
cannot fill, are refused.
"""

from __future__ import annotations

import io
import os
import re
import struct
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from vomstudio.files.regular import require_regular
from vomstudio.words import tr

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

PHOTOS = ("JPEG", "PNG", "TIFF")
"""What photos and their masks may be. Among JPEG is MPO, of cameras that keep a preview in it."""
TEXTURES = (*PHOTOS, "WEBP", "BMP", "TGA")

_MOST_PARTS = 10_000
_MOST_SKIPPED = 1 << 20
_MOST_EXIF = 4 << 20
_MOST_VALUES = 1_000_000
# Bytes of one value, by the type of a TIFF tag (TIFF 6.0, page 15; BigTIFF).
_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}
_SIZES |= {16: 8, 17: 8, 18: 8}
_BYTES = {1, 2, 6, 7}
_DIRECTORIES = {0x8769, 0x8825, 0xA005}
_SCAN = 0xDA
_MARKER = re.compile(rb"\xff[^\x00\xff]")
_RICHEST = {"JPEG": 2048, "MPO": 2048, "PNG": 8 * 1032, "BMP": 8 * 128, "TGA": 128}
"""Pixels that one byte of a file can stand for: a block of 64 in a quarter of a bit's scan of a
JPEG, deflate's 1032 bytes of eight pixels, and the runs of BMP and TGA."""


def open_picture(source: str | Path | bytes, formats: tuple[str, ...] = TEXTURES) -> ImageFile:
    """A picture with only its header read, of any number of pixels; to be closed by the caller.

    source: a file, or its content. formats: of Pillow, `PHOTOS` or `TEXTURES`.

    Raises InputError where the file is no regular one, PIL.UnidentifiedImageError where it is no
    picture of these formats, and OSError, ValueError or SyntaxError where it is damaged, as
    Pillow's decoders do.
    """
    from PIL import Image, UnidentifiedImageError

    # Photos and textures are larger than Pillow's idea of an attack.
    Image.MAX_IMAGE_PIXELS = None
    if not isinstance(source, bytes):
        require_regular(source)
    given = io.BytesIO(source) if isinstance(source, bytes) else _Unmapped(source)
    try:
        _check_headers(given)
        size = given.seek(0, io.SEEK_END)
        given.seek(0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = Image.open(given, formats=formats)
    except UnidentifiedImageError as error:
        given.close()
        if isinstance(source, bytes):
            raise
        # Pillow would name the object that is read.
        said = f"cannot identify image file {os.fspath(source)!r}"
        raise UnidentifiedImageError(said) from error
    except BaseException:
        given.close()
        raise
    try:
        width, height = image.size
        richest = _RICHEST.get(image.format or "")
        if richest is not None and width * height > richest * size:
            raise OSError(
                tr(
                    "it says that it has {width} × {height} pixels, which its {size} bytes cannot "
                    "hold",
                    width=width,
                    height=height,
                    size=size,
                )
            )
        exif = image.info.get("exif")
        if image.format not in ("JPEG", "MPO", "TIFF") and isinstance(exif, bytes):
            _check_tags(io.BytesIO(exif.removeprefix(b"Exif\0\0")))
    except BaseException:
        image.close()
        raise
    return image


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


def _check_headers(file: BinaryIO) -> None:
    """Raises OSError for headers that no program writes and that would take minutes to read."""
    head = file.read(8)
    if head[:2] == b"\xff\xd8":
        exif = bytearray()
        for number, (marker, start, length) in enumerate(_segments(file)):
            if number > _MOST_PARTS:
                raise OSError(_too_many())
            if marker == 0xE1:
                file.seek(start)
                if file.read(6) == b"Exif\0\0":
                    exif += file.read(length - 6)
                    if len(exif) > _MOST_EXIF:
                        raise OSError(tr("its EXIF is larger than any camera writes"))
        if exif:
            _check_tags(io.BytesIO(bytes(exif)))
    elif head == b"\x89PNG\r\n\x1a\n":
        _check_chunks(file)
    elif head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
        _check_tags(file)


def _too_many() -> str:
    return tr("its header has more parts than any program writes")


def jpeg_scan_start(file: BinaryIO) -> int | None:
    """Where the first scan of a JPEG begins, past all headers and the thumbnail in them; None where
    there is none. Raises OSError as `open_picture`."""
    file.seek(0)
    if file.read(2) != b"\xff\xd8":
        return None
    return next((at - 4 for marker, at, _ in _segments(file) if marker == _SCAN), None)


def _segments(file: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """(marker, where its content begins, length of that) of a JPEG, up to the first scan (ITU T.81,
    B.1.1). Raises OSError where more lies between them than any program leaves: Pillow looks for
    the next marker byte by byte."""
    at, skipped = 2, 0
    while True:
        file.seek(at)
        head = file.read(4)
        if len(head) < 4:
            return
        if head[0] != 0xFF or head[1] in (0x00, 0xFF):
            file.seek(at)
            block = file.read(1 << 16)
            found = _MARKER.search(block)
            step = found.start() if found else max(1, len(block) - 1)
            at, skipped = at + step, skipped + step
            if skipped > _MOST_SKIPPED:
                raise OSError(tr("its header is filled with bytes that mean nothing"))
            continue
        marker = head[1]
        if marker in (0x01, 0xD8, 0xD9) or 0xD0 <= marker <= 0xD7:
            yield marker, at + 2, 0
            at += 2
            continue
        length = int.from_bytes(head[2:4], "big")
        if length < 2:
            return
        yield marker, at + 4, length - 2
        if marker == _SCAN:
            return
        at += 2 + length


def _check_chunks(file: BinaryIO) -> None:
    """Of a PNG (PNG specification, 5.3): each is read by itself."""
    at, others, all_of_them = 8, 0, 0
    size = file.seek(0, io.SEEK_END)
    most = 200_000 + size // 4096
    while at + 8 <= size:
        file.seek(at)
        length, kind = struct.unpack(">I4s", file.read(8))
        others += kind != b"IDAT"
        all_of_them += 1
        if others > _MOST_PARTS or all_of_them > most:
            raise OSError(_too_many())
        if kind == b"IEND":
            return
        at += 12 + length


def _check_tags(file: BinaryIO) -> None:
    """Of a TIFF, or of EXIF, which is one: what the tags hold together is not more than there is.
    Each may name the same bytes, and is read whole."""
    size = file.seek(0, io.SEEK_END)
    file.seek(0)
    head = file.read(16)
    order = {b"II": "<", b"MM": ">"}.get(head[:2])
    if order is None or len(head) < 8:
        return
    big = head[2:4] in (b"+\0", b"\0+")
    if big and len(head) < 16:
        return
    (first,) = struct.unpack(order + ("Q" if big else "I"), head[8:16] if big else head[4:8])
    waiting, seen, held = [first], set[int](), 0
    while waiting:
        at = waiting.pop()
        if at in seen or at >= size:
            continue
        seen.add(at)
        for kind, count, tag, pointed in _entries(file, at, order, big):
            taken = count * _SIZES.get(kind, 1)
            # What reaches beyond the end is dropped by readers, as cameras write such.
            if taken > size - min(pointed, size):
                continue
            held += taken
            if held > 2 * size + (1 << 16) or (kind not in _BYTES and count > _MOST_VALUES):
                raise OSError(tr("its tags claim more than the file holds"))
            if tag in _DIRECTORIES:
                waiting.append(pointed)


def _entries(file: BinaryIO, at: int, order: str, big: bool) -> Iterator[tuple[int, int, int, int]]:
    """(type, number of values, tag, value or where it is) of one directory."""
    file.seek(at)
    wide, entry = ("Q", "HHQQ") if big else ("H", "HHII")
    head = file.read(struct.calcsize(order + wide))
    if len(head) < struct.calcsize(order + wide):
        return
    (number,) = struct.unpack(order + wide, head)
    step = struct.calcsize(order + entry)
    rows = file.read(step * min(number, 1 << 16))
    for tag, kind, count, value in struct.iter_unpack(
        order + entry, rows[: len(rows) // step * step]
    ):
        yield kind, count, tag, value
