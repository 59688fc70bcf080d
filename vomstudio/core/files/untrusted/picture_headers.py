"""Checks of picture headers before decoding, for memory and malicious structures.

Some headers keep a decoder busy for minutes or make it allocate memory without any content:
thousands of empty segments, tags that share the same bytes, endlessly repeated scans, or a tile of
several gigabytes in a picture of one pixel.
"""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

from vomstudio.core.files.untrusted import heif
from vomstudio.core.words import tr

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
JPEG_SIGNATURE = b"\xff\xd8"
TIFF_SIGNATURES = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

_MAX_PARTS = 10_000
_MAX_SKIPPED_BYTES = 1 << 20
_MAX_EXIF_BYTES = 4 << 20
_MAX_TAG_VALUES = 1_000_000
_MAX_SCANS = 100
"""Maximum number of scans of a progressive JPEG; encoders write about ten for a picture."""
_MAX_DIRECTORIES = 1000
# Bytes per value, by the type of a TIFF tag (TIFF 6.0, page 15; BigTIFF).
_VALUE_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4}
_VALUE_SIZES |= {16: 8, 17: 8, 18: 8}
_BYTE_TYPES = {1, 2, 6, 7}
_EXIF_DIRECTORIES = {0x8769, 0x8825, 0xA005}
_SUB_DIRECTORIES_TAG = 0x014A
_SCAN_MARKER, _END_MARKER = 0xDA, 0xD9
_FRAME_MARKERS = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""Markers of JPEG frame headers, which contain the size (ITU T.81, table B.1)."""
_PROGRESSIVE_MARKERS = {0xC2, 0xC6, 0xCA, 0xCE}
_MARKER_PATTERN = re.compile(rb"\xff[^\x00\xff]")
_SEGMENT_PATTERN = re.compile(rb"\xff[\x02-\xcf\xd9-\xfe]")
"""Segment markers, excluding restart markers between pixels and markers without content."""
_BLOCK_BYTES = 1 << 16


class HeaderError(ValueError):
    """The header does not match a valid file; the message states the reason."""


@dataclass(frozen=True)
class PictureSize:
    """Size of a picture according to its header.

    Parameters
    ----------
    width, height : int
        Size in pixels.
    pixel_bytes : int
        Decompressed bytes per pixel, as stored.
    extra_bytes : int
        Additional memory that the decoder needs: a strip or tile, the coefficients of a
        progressive JPEG, or the canvas of a WebP picture.
    tile_bytes : int
        Total bytes of all tiles, which may extend far beyond the picture; 0 if the picture is not
        tiled.
    """

    width: int
    height: int
    pixel_bytes: int
    extra_bytes: int = 0
    tile_bytes: int = 0

    @property
    def stored_bytes(self) -> int:
        """Decompressed bytes of all pixels, as the file stores them."""
        return max(self.width * self.height * self.pixel_bytes, self.tile_bytes)

    def decoded_bytes(self, min_pixel_bytes: int) -> int:
        """Return the memory needed to decode the picture, in bytes.

        Pillow pads rows to a multiple of four bytes and stores a pointer to each row, which
        matters for pictures that are one pixel wide.
        """
        row = self.width * max(self.pixel_bytes, min_pixel_bytes)
        pixels = self.height * ((row + 3) // 4 * 4 + 8)
        return max(pixels, self.tile_bytes) + self.extra_bytes


def read_size(file: BinaryIO) -> PictureSize | None:
    """Read the header of a JPEG, PNG, TIFF, HEIF, WebP or BMP picture.

    Returns
    -------
    PictureSize or None
        None if the file has another format or is so damaged that the size is unknown; decoders
        reject the file.

    Raises
    ------
    HeaderError
        If the header is not like that of a valid file.
    OSError
        If the file cannot be read.
    """
    file.seek(0)
    header = file.read(32)
    if heif.is_heif(header):
        photo = heif.read_header(file)
        # The pixels arrive as bytes and are turned once.
        if photo is None:
            return None
        return PictureSize(photo.width, photo.height, 3, 6 * photo.width * photo.height)
    for mark, read in _READERS.items():
        if header.startswith(mark):
            try:
                return read(file, header)
            except struct.error:
                return None
    return None


def check_exif(exif: bytes) -> None:
    """Check the tags of EXIF metadata, which is a TIFF file. Raises HeaderError."""
    try:
        _check_tags(io.BytesIO(exif.removeprefix(b"Exif\0\0")))
    except struct.error:
        return


def block_sizes(file: BinaryIO) -> Iterator[PictureSize]:
    """Yield the sizes of all pictures of a TIFF (pages, overviews, masks). Raises HeaderError."""
    _check_tags(file)
    for _, directory in zip(range(_MAX_DIRECTORIES + 1), _directories(file), strict=False):
        yield _tiff_size(directory)


def jpeg_scan_start(file: BinaryIO) -> int | None:
    """Return the offset of the first scan of a JPEG, after all headers and the thumbnail.

    Returns None if the file is not a JPEG or has no scan. Raises HeaderError.
    """
    file.seek(0)
    if file.read(2) != JPEG_SIGNATURE:
        return None
    return next(
        (offset - 4 for marker, offset, _ in _segments(file) if marker == _SCAN_MARKER), None
    )


# --- JPEG -----------------------------------------------------------------------------------------
def _jpeg_size(file: BinaryIO, head: bytes) -> PictureSize | None:
    exif, size, components = bytearray(), None, 0
    is_progressive = has_several_scans = False
    for index, (marker, start, length) in enumerate(_segments(file)):
        if index > _MAX_PARTS:
            raise HeaderError(_too_many_parts_text())
        file.seek(start)
        if marker == 0xE1 and file.read(6) == b"Exif\0\0":
            exif += file.read(length - 6)
            if len(exif) > _MAX_EXIF_BYTES:
                raise HeaderError(tr("its EXIF data are implausibly large"))
        elif marker in _FRAME_MARKERS:
            precision, height, width, components = struct.unpack(">BHHB", file.read(6))
            size = PictureSize(width, height, components * (1 if precision <= 8 else 2))
            is_progressive = marker in _PROGRESSIVE_MARKERS
        elif marker == _SCAN_MARKER:
            has_several_scans = is_progressive or file.read(1) < bytes([components])
            if has_several_scans:
                _check_scans(file, start)
    if exif:
        check_exif(bytes(exif))
    if size is None or not has_several_scans:
        return size
    # libjpeg keeps all 16-bit coefficients in memory until the last scan.
    coefficients = 2 * size.width * size.height * components
    return PictureSize(size.width, size.height, size.pixel_bytes, coefficients)


def _segments(file: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Yield (marker, content offset, content length) of each segment up to the first scan.

    See ITU T.81, B.1.1. Raises HeaderError if the segments are too far apart, because Pillow
    searches for the next marker byte by byte.
    """
    offset, skipped_count = 2, 0
    while True:
        file.seek(offset)
        header = file.read(4)
        if len(header) < 4:
            return
        if header[0] != 0xFF or header[1] in (0x00, 0xFF):
            file.seek(offset)
            block = file.read(1 << 16)
            match = _MARKER_PATTERN.search(block)
            step = match.start() if match else max(1, len(block) - 1)
            offset, skipped_count = offset + step, skipped_count + step
            if skipped_count > _MAX_SKIPPED_BYTES:
                raise HeaderError(tr("its header contains invalid bytes"))
            continue
        marker = header[1]
        if marker in (0x01, 0xD8, 0xD9) or 0xD0 <= marker <= 0xD7:
            yield marker, offset + 2, 0
            offset += 2
            continue
        length = int.from_bytes(header[2:4], "big")
        if length < 2:
            return
        yield marker, offset + 4, length - 2
        if marker == _SCAN_MARKER:
            return
        offset += 2 + length


def _check_scans(file: BinaryIO, start: int) -> None:
    """Raise HeaderError if a JPEG has too many scans after offset `start`."""
    offset, scan_count = start, 1
    for _ in range(_MAX_PARTS):
        position, marker = _next_segment(file, offset)
        if marker == _END_MARKER:
            return
        scan_count += marker == _SCAN_MARKER
        if scan_count > _MAX_SCANS:
            raise HeaderError(tr("it has an implausible number of scans"))
        file.seek(position + 2)
        offset = position + 2 + max(2, int.from_bytes(file.read(2), "big"))
    raise HeaderError(_too_many_parts_text())


def _next_segment(file: BinaryIO, offset: int) -> tuple[int, int]:
    """Return the offset and marker (`_END_MARKER` at the end) of the segment after the pixels."""
    file.seek(offset)
    while block := file.read(_BLOCK_BYTES):
        if match := _SEGMENT_PATTERN.search(block):
            return offset + match.start(), match[0][1]
        offset += max(1, len(block) - 1)
        file.seek(offset)
        if len(block) == 1:
            break
    return offset, _END_MARKER


# --- PNG, BMP, WebP -------------------------------------------------------------------------------
def _png_size(file: BinaryIO, head: bytes) -> PictureSize | None:
    _check_chunks(file)
    if head[12:16] != b"IHDR":
        return None
    width, height, depth, kind = struct.unpack(">IIBB", head[16:26])
    samples = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}.get(kind, 4)
    return PictureSize(width, height, samples * (2 if depth == 16 else 1))


def _check_chunks(file: BinaryIO) -> None:
    """Check the number of chunks (PNG specification, 5.3). Raises HeaderError."""
    offset, other_chunk_count, chunks = 8, 0, 0
    size = file.seek(0, io.SEEK_END)
    max_chunks = 200_000 + size // 4096
    while offset + 8 <= size:
        file.seek(offset)
        length, kind = struct.unpack(">I4s", file.read(8))
        other_chunk_count += kind != b"IDAT"
        chunks += 1
        if other_chunk_count > _MAX_PARTS or chunks > max_chunks:
            raise HeaderError(_too_many_parts_text())
        if kind == b"IEND":
            return
        offset += 12 + length


def _bmp_size(file: BinaryIO, head: bytes) -> PictureSize:
    (header,) = struct.unpack_from("<I", head, 14)
    if header == 12:
        width, height, _, bits = struct.unpack_from("<HHHH", head, 18)
    else:
        width, height, _, bits = struct.unpack_from("<iiHH", head, 18)
    return PictureSize(abs(width), abs(height), max(1, bits // 8))


def _webp_size(file: BinaryIO, head: bytes) -> PictureSize | None:
    """Return the size, with the canvas, from a VP8X, VP8L or VP8 chunk, or None.

    See RFC 9649, 2.5 to 2.7.
    """
    kind = head[12:16]
    if head[8:12] != b"WEBP":
        return None
    if kind == b"VP8X":
        width, height = (
            int.from_bytes(head[offset : offset + 3], "little") + 1 for offset in (24, 27)
        )
    elif kind == b"VP8L":
        (packed_size,) = struct.unpack_from("<I", head, 21)
        width, height = (packed_size & 0x3FFF) + 1, (packed_size >> 14 & 0x3FFF) + 1
    elif kind == b"VP8 ":
        width, height = (value & 0x3FFF for value in struct.unpack_from("<HH", head, 26))
    else:
        return None
    return PictureSize(width, height, 4, 4 * width * height)


# --- TIFF -----------------------------------------------------------------------------------------
_Directory = dict[int, int]
"""Value of each tag, or the largest value if the tag has several."""
_WIDTH, _HEIGHT, _BITS, _PHOTOMETRIC, _SAMPLES = 256, 257, 258, 262, 277
_STRIP_ROWS, _PLANAR_CONFIGURATION, _TILE_WIDTH, _TILE_HEIGHT = 278, 284, 322, 323
_SIZE_TAGS = {
    _WIDTH,
    _HEIGHT,
    _BITS,
    _PHOTOMETRIC,
    _SAMPLES,
    _STRIP_ROWS,
    _PLANAR_CONFIGURATION,
    _TILE_WIDTH,
    _TILE_HEIGHT,
}
_YCBCR, _SEPARATE_PLANES = 6, 2


def _first_tiff_size(file: BinaryIO, head: bytes) -> PictureSize | None:
    _check_tags(file)
    directory = next(_directories(file), None)
    return None if directory is None else _tiff_size(directory)


def _tiff_size(directory: _Directory) -> PictureSize:
    width, height = directory.get(_WIDTH, 0), directory.get(_HEIGHT, 0)
    samples, bits = directory.get(_SAMPLES, 1), directory.get(_BITS, 1)
    is_contiguous = directory.get(_PLANAR_CONFIGURATION, 1) != _SEPARATE_PLANES
    tile_width = directory.get(_TILE_WIDTH) or width
    tile_height = directory.get(_TILE_HEIGHT) or min(directory.get(_STRIP_ROWS) or height, height)
    block = tile_width * tile_height * bits * (samples if is_contiguous else 1) // 8
    if directory.get(_PHOTOMETRIC) == _YCBCR:
        # libtiff converts the whole block to red, green, blue and opacity.
        block = max(block, 4 * tile_width * tile_height)
    tiles = 0
    if directory.get(_TILE_WIDTH) and directory.get(_TILE_HEIGHT):
        tiles = (
            -(-width // tile_width) * -(-height // tile_height) * (1 if is_contiguous else samples)
        )
    return PictureSize(width, height, max(1, samples * bits // 8), block, tiles * block)


def _check_tags(file: BinaryIO) -> None:
    """Raise HeaderError if the tags describe too much data or too many directories exist.

    Several tags may refer to the same bytes, and each of them is read completely.
    """
    size = file.seek(0, io.SEEK_END)
    total_count = 0
    for index, entries in enumerate(_all_directories(file)):
        if index > _MAX_DIRECTORIES:
            raise HeaderError(_too_many_parts_text())
        for kind, count, _, value_field in entries:
            needed_size = count * _VALUE_SIZES.get(kind, 1)
            # Some cameras write tags that extend beyond the end of the file; readers ignore them.
            if needed_size > size - min(value_field, size):
                continue
            total_count += needed_size
            if total_count > 2 * size + (1 << 16) or (
                kind not in _BYTE_TYPES and count > _MAX_TAG_VALUES
            ):
                raise HeaderError(tr("its tags describe more data than the file contains"))


def _directories(file: BinaryIO) -> Iterator[_Directory]:
    """Yield the tags of each directory of a TIFF that describe the size of its picture."""
    start = _tiff_start(file)
    if start is None:
        return
    byte_order, is_big_tiff, _ = start
    for entries in _all_directories(file, include_exif=False):
        yield {
            tag: max(_numbers(file, byte_order, is_big_tiff, kind, count, value), default=0)
            for kind, count, tag, value in entries
            if tag in _SIZE_TAGS
        }


def _all_directories(
    file: BinaryIO, *, include_exif: bool = True
) -> Iterator[list[tuple[int, int, int, int]]]:
    """Yield the entries of each directory of a TIFF file once, starting with the first."""
    start = _tiff_start(file)
    if start is None:
        return
    byte_order, is_big_tiff, first_offset = start
    size = file.seek(0, io.SEEK_END)
    pending, visited = [first_offset], set[int]()
    while pending:
        offset = pending.pop(0)
        if offset == 0 or offset in visited or offset >= size:
            continue
        visited.add(offset)
        entries, next_offset = _entries(file, offset, byte_order, is_big_tiff)
        yield entries
        for kind, count, tag, value in entries:
            if include_exif and tag in _EXIF_DIRECTORIES:
                pending.append(value)
            elif tag == _SUB_DIRECTORIES_TAG:
                pending += _numbers(file, byte_order, is_big_tiff, kind, count, value)
        pending.append(next_offset)


def _tiff_start(file: BinaryIO) -> tuple[str, bool, int] | None:
    """Return the byte order, whether a TIFF is a BigTIFF, and the first directory's offset.

    Returns None for other files.
    """
    file.seek(0)
    header = file.read(16)
    byte_order = {b"II": "<", b"MM": ">"}.get(header[:2])
    is_big_tiff = header[2:4] in (b"+\0", b"\0+")
    if byte_order is None or len(header) < (16 if is_big_tiff else 8):
        return None
    (first_offset,) = struct.unpack(
        byte_order + ("Q" if is_big_tiff else "I"), header[8:16] if is_big_tiff else header[4:8]
    )
    return byte_order, is_big_tiff, first_offset


def _entries(
    file: BinaryIO, offset: int, byte_order: str, is_big_tiff: bool
) -> tuple[list[tuple[int, int, int, int]], int]:
    """Return the entries (type, count, tag, value or offset) and the next directory's offset."""
    file.seek(offset)
    width, entry = ("Q", "HHQQ") if is_big_tiff else ("H", "HHII")
    header = file.read(struct.calcsize(byte_order + width))
    if len(header) < struct.calcsize(byte_order + width):
        return [], 0
    (entry_count,) = struct.unpack(byte_order + width, header)
    step = struct.calcsize(byte_order + entry)
    rows = file.read(step * min(entry_count, 1 << 16))
    whole_rows = rows[: len(rows) // step * step]
    entries = [
        (kind, count, tag, value)
        for tag, kind, count, value in struct.iter_unpack(byte_order + entry, whole_rows)
    ]
    value_field = file.read(8 if is_big_tiff else 4)
    if len(entries) < entry_count or len(value_field) < (8 if is_big_tiff else 4):
        return entries, 0
    return entries, struct.unpack(byte_order + ("Q" if is_big_tiff else "I"), value_field)[0]


def _numbers(
    file: BinaryIO, byte_order: str, is_big_tiff: bool, kind: int, count: int, value: int
) -> list[int]:
    """Return the integers that an entry contains or refers to, from at most 2048 bytes.

    Returns an empty list if the values are not unsigned integers.
    """
    code = {1: "B", 3: "H", 4: "I", 13: "I", 16: "Q", 18: "Q"}.get(kind)
    if code is None:
        return []
    size = _VALUE_SIZES[kind] * count
    raw = struct.pack(byte_order + ("Q" if is_big_tiff else "I"), value)
    if size > len(raw):
        file.seek(min(value, 1 << 62))
        raw = file.read(min(size, 2048))
    value_count = min(count, len(raw) // _VALUE_SIZES[kind])
    return list(
        struct.unpack(f"{byte_order}{value_count}{code}", raw[: value_count * _VALUE_SIZES[kind]])
    )


def _too_many_parts_text() -> str:
    return tr("its header has an implausible number of parts")


_READERS: dict[bytes, Callable[[BinaryIO, bytes], PictureSize | None]] = {
    JPEG_SIGNATURE: _jpeg_size,
    PNG_SIGNATURE: _png_size,
    b"BM": _bmp_size,
    b"RIFF": _webp_size,
    **dict.fromkeys(TIFF_SIGNATURES, _first_tiff_size),
}
