"""HEIF photos with HEVC pixels, such as those of iPhones.

The boxes of the header are parsed here (ISO/IEC 14496-12 and 23008-12), because a folder of photos
is listed without decoding: starting the decoder takes 0.3 s per photo, the header 0.2 ms. The
pixels are decoded by libheif in a separate process (`reader_process`), which can be ended.

`python -m vomstudio.core.files.untrusted.heif` is that process.
"""

from __future__ import annotations

import base64
import io
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from vomstudio.core.arrays import ByteArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted import reader_process
from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress

FORMAT = "HEIF"
_BRANDS = frozenset([b"heic", b"heix", b"heim", b"heis", b"mif1"])
_MAX_HEADER_BYTES = 8 << 20
_MAX_BOXES = 20_000
_MAX_EXIF_BYTES = 4 << 20
_ORIENTATIONS = {0: 1, 1: 8, 2: 3, 3: 6}
"""EXIF orientation that corresponds to a number of anticlockwise quarter turns."""
_ORIENTATION_TAG = 0x0112


@dataclass(frozen=True)
class HeifHeader:
    """Header of a HEIF photo.

    Parameters
    ----------
    width, height : int
        Size of the photo as stored by the sensor, in pixels.
    quarter_turns : int
        Anticlockwise quarter turns from the stored to the upright photo, 0 to 3.
    exif : bytes or None
        EXIF metadata beginning with ``Exif``. Its orientation describes the stored photo.
    """

    width: int
    height: int
    quarter_turns: int = 0
    exif: bytes | None = None


def is_heif(header: bytes) -> bool:
    """Return whether a file is a HEIF photo.

    Parameters
    ----------
    header : bytes
        First 12 bytes of the file.

    Returns
    -------
    bool
    """
    return header[4:8] == b"ftyp" and header[8:12] in _BRANDS


def read_header(file: BinaryIO) -> HeifHeader | None:
    """Read the header of a HEIF photo.

    Parameters
    ----------
    file : BinaryIO
        The whole file, which can be searched.

    Returns
    -------
    HeifHeader or None
        None if the file is not a HEIF photo with HEVC pixels, or if its header is damaged.

    Raises
    ------
    InputError
        With the code ``photo.truncated`` if pixels or metadata lie beyond the end of the file.
    OSError
        If the file cannot be read.
    """
    file.seek(0)
    if not is_heif(file.read(12)):
        return None
    size = file.seek(0, io.SEEK_END)
    try:
        boxes = dict(_boxes(file, 0, size))
        start, end = boxes[b"meta"]
        if end - start > _MAX_HEADER_BYTES:
            return None
        return _read_meta(file, start + 4, end)
    except (struct.error, KeyError, IndexError, ValueError):
        return None


def decode(content: bytes, name: str) -> ByteArray:
    """Decode a HEIF photo in a separate process.

    Parameters
    ----------
    content : bytes
    name : str
        File name for error messages.

    Returns
    -------
    (height, width, 3) ndarray of uint8
        RGB pixels as stored by the sensor.

    Raises
    ------
    ValueError
        If the photo is damaged.
    InputError
        With the code ``photo.truncated``, or ``file.memory-exceeded`` if the process did not end
        normally.
    """
    header = read_header(io.BytesIO(content))
    if header is None:
        raise ValueError("not a HEIF photo")
    request = {"content": base64.b64encode(content).decode("ascii")}
    raw = reader_process.run_reader(__name__, request, SilentProgress(), Path(name))
    if not raw:
        raise ValueError("the photo cannot be decoded")
    width, height = struct.unpack("<II", raw[:8])
    pixels = np.frombuffer(raw, np.uint8, offset=8).reshape(height, width, 3)
    pixels = np.rot90(pixels, -header.quarter_turns)
    if pixels.shape[:2] != (header.height, header.width):
        raise ValueError("the size differs from that of the header")
    return np.ascontiguousarray(pixels)


def register_pillow_format() -> None:
    """Let Pillow open HEIF photos; their pixels are decoded in a separate process."""
    from PIL import Image, ImageFile

    if FORMAT in Image.OPEN:
        return

    class HeifImageFile(ImageFile.ImageFile):
        format = FORMAT
        format_description = "HEIF photo"

        def _open(self) -> None:
            header = read_header(cast("BinaryIO", self.fp))
            if header is None:
                raise SyntaxError("not a HEIF photo")
            self._size = (header.width, header.height)
            self._mode = "RGB"
            if header.exif is not None:
                self.info["exif"] = header.exif
            self.tile = [ImageFile._Tile("raw", (0, 0, *self._size), 0, "RGB")]
            self._is_decoded = False

        def load(self) -> Any:
            if self.tile and not self._is_decoded:
                assert self.fp is not None
                self.fp.seek(0)
                name = str(getattr(self.fp, "name", "") or "photo")
                pixels = decode(self.fp.read(), name)
                self.fp = io.BytesIO(pixels.tobytes())
                self._is_decoded = True
            return super().load()

    Image.register_open(FORMAT, HeifImageFile, is_heif)


# --- Boxes ----------------------------------------------------------------------------------------
def _boxes(file: BinaryIO, start: int, end: int) -> Iterator[tuple[bytes, tuple[int, int]]]:
    """Yield the type and the content, as start and end offsets, of each box."""
    offset = start
    for _ in range(_MAX_BOXES):
        if offset + 8 > end:
            return
        file.seek(offset)
        length, kind = struct.unpack(">I4s", file.read(8))
        header = 8
        if length == 1:
            (length,) = struct.unpack(">Q", file.read(8))
            header = 16
        elif length == 0:
            length = end - offset
        if length < header or offset + length > end:
            return
        yield kind, (offset + header, offset + length)
        offset += length


def _read_meta(file: BinaryIO, start: int, end: int) -> HeifHeader | None:
    boxes = dict(_boxes(file, start, end))
    primary_id = _read_primary_id(_content(file, boxes[b"pitm"]))
    kinds = _read_item_kinds(file, *boxes[b"iinf"])
    if kinds.get(primary_id) not in (b"hvc1", b"grid", b"iden"):
        return None
    size, quarter_turns = _read_transforms(file, *boxes[b"iprp"], primary_id)
    if size is None:
        return None
    locations = list(_locations(_content(file, boxes[b"iloc"])))
    file_size = file.seek(0, io.SEEK_END)
    if any(
        sum(extent) > file_size for _, method, spans in locations if not method for extent in spans
    ):
        raise InputError(Finding("photo.truncated"))
    exif_id = next((id_ for id_, kind in kinds.items() if kind == b"Exif"), None)
    exif = None if exif_id is None else _read_exif(file, locations, exif_id)
    if quarter_turns and (exif is None or _orientation(exif) != _ORIENTATIONS[quarter_turns]):
        # The turn is part of the picture only: keep the upright photo.
        size, quarter_turns = (size if quarter_turns == 2 else size[::-1]), 0
        exif = None if exif is None else _replace_orientation(exif, 1)
    elif not quarter_turns and exif is not None:
        exif = _replace_orientation(exif, 1)
    return HeifHeader(size[0], size[1], quarter_turns, exif)


def _content(file: BinaryIO, span: tuple[int, int]) -> bytes:
    file.seek(span[0])
    return file.read(span[1] - span[0])


def _read_primary_id(content: bytes) -> int:
    (number,) = struct.unpack_from(">H" if content[0] == 0 else ">I", content, 4)
    return int(number)


def _read_item_kinds(file: BinaryIO, start: int, end: int) -> dict[int, bytes]:
    """Return the type of each item by its number."""
    file.seek(start)
    version = file.read(4)[0]
    first_box = start + 4 + (2 if version == 0 else 4)
    kinds = {}
    for kind, span in _boxes(file, first_box, end):
        content = _content(file, span)
        if kind == b"infe" and content[0] >= 2:
            number, offset = (
                (struct.unpack_from(">H", content, 4)[0], 8)
                if content[0] == 2
                else (struct.unpack_from(">I", content, 4)[0], 10)
            )
            kinds[number] = content[offset : offset + 4]
    return kinds


def _read_transforms(
    file: BinaryIO, start: int, end: int, item: int
) -> tuple[tuple[int, int] | None, int]:
    """Return the size of an item before it is rotated, and its anticlockwise quarter turns."""
    boxes = dict(_boxes(file, start, end))
    properties = list(_boxes(file, *boxes[b"ipco"]))
    size, quarter_turns = None, 0
    for index in _property_indices(_content(file, boxes[b"ipma"]), item):
        kind, span = properties[index - 1]
        content = _content(file, span)
        if kind == b"ispe":
            size = struct.unpack_from(">II", content, 4)
        elif kind == b"irot":
            quarter_turns = content[0] & 3
        elif kind in (b"imir", b"clap"):
            # Mirrored and cropped photos do not come from cameras.
            return None, 0
    return size, quarter_turns


def _property_indices(content: bytes, item: int) -> list[int]:
    """Return the numbers of the properties of an item, from 1 on, in an `ipma` box."""
    version, has_wide_indices = content[0], content[3] & 1
    (count,) = struct.unpack_from(">I", content, 4)
    offset = 8
    for _ in range(min(count, _MAX_BOXES)):
        (number,) = struct.unpack_from(">H" if version == 0 else ">I", content, offset)
        offset += 2 if version == 0 else 4
        property_count = content[offset]
        offset += 1
        width = 2 if has_wide_indices else 1
        if number == item:
            values = struct.unpack_from(
                f">{property_count}{'H' if has_wide_indices else 'B'}", content, offset
            )
            mask = 0x7FFF if has_wide_indices else 0x7F
            return [value & mask for value in values if value & mask]
        offset += property_count * width
    return []


_Location = tuple[int, int, list[tuple[int, int]]]


def _read_exif(file: BinaryIO, locations: list[_Location], item: int) -> bytes | None:
    """Return the EXIF metadata of an item."""
    for number, method, extents in locations:
        if number != item or method != 0:
            continue
        if sum(length for _, length in extents) > _MAX_EXIF_BYTES:
            return None
        content = b"".join(_content(file, (start, start + length)) for start, length in extents)
        (skipped_count,) = struct.unpack_from(">I", content)
        tiff = content[4 + skipped_count :]
        return b"Exif\0\0" + tiff if tiff[:2] in (b"II", b"MM") else None
    return None


def _locations(content: bytes) -> Iterator[_Location]:
    """Yield number, construction method and extents (offset, length) of each item (`iloc`)."""
    version, sizes = content[0], struct.unpack_from(">H", content, 4)[0]
    offset_size, length_size = sizes >> 12, sizes >> 8 & 15
    base_size, index_size = sizes >> 4 & 15, (sizes & 15) if version in (1, 2) else 0
    position = 6

    def read(size: int) -> int:
        nonlocal position
        value = int.from_bytes(content[position : position + size], "big")
        if position + size > len(content):
            raise ValueError("the box is truncated")
        position += size
        return value

    wide = 2 if version < 2 else 4
    for _ in range(min(read(wide), _MAX_BOXES)):
        number = read(wide)
        method = read(2) & 15 if version in (1, 2) else 0
        read(2)
        base = read(base_size)
        extents = []
        for _ in range(min(read(2), _MAX_BOXES)):
            read(index_size)
            extents.append((base + read(offset_size), read(length_size)))
        yield number, method, extents


# --- EXIF orientation -----------------------------------------------------------------------------
def _orientation(exif: bytes) -> int | None:
    offset = _orientation_offset(exif)
    if offset is None:
        return None
    return int(struct.unpack_from(_byte_order(exif) + "H", exif, offset)[0])


def _replace_orientation(exif: bytes, orientation: int) -> bytes:
    offset = _orientation_offset(exif)
    if offset is None:
        return exif
    value = struct.pack(_byte_order(exif) + "H", orientation)
    return exif[:offset] + value + exif[offset + 2 :]


def _byte_order(exif: bytes) -> str:
    return "<" if exif[6:8] == b"II" else ">"


def _orientation_offset(exif: bytes) -> int | None:
    """Return the offset of the value of the orientation tag in the first directory."""
    order = _byte_order(exif)
    try:
        directory = 6 + int(struct.unpack_from(order + "I", exif, 10)[0])
        (count,) = struct.unpack_from(order + "H", exif, directory)
        for entry in range(min(count, 1000)):
            offset = directory + 2 + 12 * entry
            if struct.unpack_from(order + "H", exif, offset)[0] == _ORIENTATION_TAG:
                return offset + 8
    except struct.error:
        return None
    return None


# --- The separate process -------------------------------------------------------------------------
def _decode_request(request: dict[str, Any]) -> bytes:
    """Return width, height and the RGB pixels of the upright photo; empty if it is damaged."""
    import pi_heif

    content = base64.b64decode(request["content"])
    try:
        image = pi_heif.open_heif(io.BytesIO(content), convert_hdr_to_8bit=True)
        pixels = np.asarray(image)[..., :3]
    except (OSError, ValueError, SyntaxError, EOFError, RuntimeError):
        return b""
    height, width = pixels.shape[:2]
    return struct.pack("<II", width, height) + np.ascontiguousarray(pixels, np.uint8).tobytes()


if __name__ == "__main__":
    sys.exit(reader_process.serve(_decode_request))
