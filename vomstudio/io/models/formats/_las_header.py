"""Header and chunk table of LAS and LAZ files, which are checked before use.

lazrs allocates as much memory as a file states and ends the process if that fails, so false values
must be detected here. laspy is not needed for this and takes time to import.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr

MIN_HEADER_BYTES = 227
MIN_POINT_BYTES = 20
DEFAULT_CHUNK_POINTS = 50_000
MAX_TRUNCATION_BYTES = 64 << 20
MAX_CHUNK_POINTS = 10_000_000
VARIABLE_CHUNKS = 2**32 - 1
POINT_FORMAT_AT, COMPRESSED = 104, 0x80


def check_header(path: Path) -> int:
    """Reject invalid LAS files before a library reads them; return the size of the file."""
    try:
        with open_regular(path) as file:
            header = file.read(MIN_HEADER_BYTES)
            size = file.seek(0, 2)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    if not header.startswith(b"LASF"):
        raise InputError(Finding("file.other-format", format="LAS"), file=path)
    if len(header) < MIN_HEADER_BYTES:
        raise InputError(
            Finding("file.truncated", size=len(header), expected=MIN_HEADER_BYTES), file=path
        )
    header_size, points_at, n_records = struct.unpack_from("<HII", header, 94)
    if header_size < MIN_HEADER_BYTES or points_at < header_size or points_at > size:
        raise InputError(
            Finding("file.truncated", size=size, expected=points_at), file=path, field="LAS header"
        )
    (record_bytes,) = struct.unpack_from("<H", header, 105)
    if record_bytes < MIN_POINT_BYTES:
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("its header states {count} bytes per point", count=record_bytes),
            ),
            file=path,
            field="LAS header",
        )
    if n_records * 54 > size:
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("its header specifies more records than the file can contain"),
            ),
            file=path,
            field="LAS header",
        )
    return size


def replace_chunk_table(path: Path, size: int) -> io.BytesIO | None:
    """Return a LAZ file with an empty chunk table if its own is truncated or invalid.

    Returns None if the file does not need this.

    The table is at the end of the file, and the decoder reads it first although it is not needed
    for sequential reading. lazrs trusts the table and aborts the process if it requires too much
    memory, so false values must be detected here.
    """
    with open_regular(path) as file:
        header = file.read(MIN_HEADER_BYTES)
        if not header[POINT_FORMAT_AT] & COMPRESSED:
            return None
        header_size, points_at, n_records = struct.unpack_from("<HII", header, 94)
        (record_bytes,) = struct.unpack_from("<H", header, 105)
        (table_offset,) = struct.unpack_from("<I", header, 107)
        file.seek(0)
        top = file.read(points_at + 8)
        if len(top) < points_at + 8:
            raise InputError(
                Finding("file.truncated", size=len(top), expected=points_at + 8), file=path
            )
        if header[25] >= 4 and len(top) >= 255:
            (table_offset,) = struct.unpack_from("<Q", top, 247)
        chunk_points = laszip_chunk_points(top, header_size, n_records, record_bytes)
        if chunk_points is None:
            raise InputError(
                Finding("file.damaged", format="LAZ", reason=tr("its header contradicts itself")),
                file=path,
                field="LAS header",
            )
        (table_at,) = struct.unpack_from("<q", top, points_at)
        if table_at == -1:
            file.seek(size - 8)
            (table_at,) = struct.unpack("<q", file.read(8))
        if points_at < table_at <= size - 8:
            file.seek(table_at)
            _, n_chunks = struct.unpack("<II", file.read(8))
            # Each chunk begins with a complete point.
            fits = n_chunks <= (table_at - points_at) // MIN_POINT_BYTES
            if fits and chunk_points in (VARIABLE_CHUNKS, 0):
                return None
            if fits and n_chunks == -(-table_offset // chunk_points):
                return None
        if chunk_points != DEFAULT_CHUNK_POINTS:
            raise InputError(
                Finding(
                    "file.damaged",
                    format="LAZ",
                    reason=tr("its chunks do not add up to its points"),
                ),
                file=path,
            )
        file.seek(0)
        content = bytearray(file.read())
    struct.pack_into("<q", content, points_at, len(content))
    content += struct.pack("<II", 0, 0)
    return io.BytesIO(content)


def laszip_chunk_points(top: bytes, offset: int, n_records: int, record_bytes: int) -> int | None:
    """Return the points per chunk in the laszip record (0: no chunks), or None if invalid."""
    for _ in range(n_records):
        if offset + 54 > len(top):
            return None
        user_id, record_id, length = struct.unpack_from("<16sHH", top, offset + 2)
        offset += 54
        if user_id.rstrip(b"\0") == b"laszip encoded" and record_id == 22204:
            if length < 34 or offset + length > len(top):
                return None
            (compressor,) = struct.unpack_from("<H", top, offset)
            (points,) = struct.unpack_from("<I", top, offset + 12)
            (item_count,) = struct.unpack_from("<H", top, offset + 32)
            if length < 34 + 6 * item_count:
                return None
            item_bytes = sum(
                struct.unpack_from("<H", top, offset + 36 + 6 * k)[0] for k in range(item_count)
            )
            if item_bytes != record_bytes:
                return None
            if compressor == 1:
                return 0
            return points if 0 < points <= MAX_CHUNK_POINTS or points == VARIABLE_CHUNKS else None
        offset += length
    return None


def is_layered(path: Path) -> bool:
    """Return whether the points are compressed in a layered format."""
    with open_regular(path) as file:
        file.seek(POINT_FORMAT_AT)
        kind = file.read(1)[0]
    return bool(kind & COMPRESSED) and kind & 0x3F >= 6


def check_layers(path: Path, top: LasHeader) -> None:
    """Check the layer lengths of chunks, according to which lazrs allocates memory.

    Only the layered formats have layer lengths.

    Raises InputError if one of them is far larger than the remainder of the file; a truncated last
    chunk is allowed.
    """
    if not top.layer_count or is_copc(path):
        return
    format_ = f"<{top.layer_count}I"
    with open_regular(path) as file:
        file.seek(top.points_offset)
        (end,) = struct.unpack("<q", file.read(8).ljust(8, b"\0"))
        if end == -1:
            file.seek(top.size - 8)
            (end,) = struct.unpack("<q", file.read(8))
        # The chunk table follows the last chunk.
        end = end if top.points_offset < end < top.size else top.size
        offset = top.points_offset + 8
        while offset < end:
            file.seek(offset + top.record_bytes + 4)
            sizes = file.read(struct.calcsize(format_))
            if len(sizes) < struct.calcsize(format_):
                return
            layer_bytes = sum(struct.unpack(format_, sizes))
            offset += top.record_bytes + 4 + len(sizes) + layer_bytes
            if offset > top.size + MAX_TRUNCATION_BYTES:
                raise _contradiction(path)


BLOCK_BYTES = 2 << 20
BLOCKS_PER_REPORT = 8
MIN_BLANK_BYTES = 128
_ONES = np.uint64(2**64 - 1)


def _blank_bytes(record_bytes: int) -> bytes:
    """Return a run of one bits that neither encoders nor first points of chunks contain.

    Memory cards contain such runs where nothing was written. lazrs reads beyond its memory when it
    decodes them, which ends the process.
    """
    return b"\xff" * max(MIN_BLANK_BYTES, record_bytes + 64)


def refuse_blank(path: Path, progress: Progress) -> None:
    """Raise InputError if a part of a LAZ file consists only of one bits."""
    with open_regular(path) as file:
        header = file.read(MIN_HEADER_BYTES)
        if not header[POINT_FORMAT_AT] & COMPRESSED:
            return
        header_size, points_at = struct.unpack_from("<HI", header, 94)
        blank_bytes = _blank_bytes(struct.unpack_from("<H", header, 105)[0])
        file.seek(max(points_at, header_size))
        # Use one buffer for all blocks, each of which overlaps the end of the previous one.
        buffer = bytearray(len(blank_bytes) + BLOCK_BYTES)
        view, words = memoryview(buffer), np.frombuffer(buffer, np.uint64, len(buffer) // 8)
        carried_bytes, position, count = 0, file.tell(), 0
        while read_bytes := file.readinto(view[carried_bytes : carried_bytes + BLOCK_BYTES]):
            filled_bytes = carried_bytes + read_bytes
            # A blank part contains one of every eight words, so the others do not need to be
            # checked.
            if (words[: filled_bytes // 8 : 8] == _ONES).any():
                blank_offset = buffer.find(blank_bytes, 0, filled_bytes)
                if blank_offset >= 0:
                    raise InputError(
                        Finding("file.blank", byte=position - carried_bytes + blank_offset + 1),
                        file=path,
                    )
            position += read_bytes
            carried_bytes = min(filled_bytes, len(blank_bytes))
            view[:carried_bytes] = bytes(view[filled_bytes - carried_bytes : filled_bytes])
            count += 1
            if count % BLOCKS_PER_REPORT == 0:
                progress.stage(tr("Checking the file"))


def is_copc(path: str | Path) -> bool:
    """Return whether the first record of a LAZ file is the COPC record.

    Returns False if the path is not a file.
    """
    try:
        with open_regular(path) as file:
            header = file.read(393)
    except (OSError, InputError):
        return False
    return header[:4] == b"LASF" and header[377:381] == b"copc"


# --- for readers of parts of a file --------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LasHeader:
    """Header of a LAS file and the records between the header and the points.

    Attributes
    ----------
    bounds : (2, 3) float64
        Bounds as stated in the header, unchecked.
    records : dict
        Bytes of the variable length records by (user, number); only the first record of each.
    layers : int
        Number of streams in a chunk of the layered formats (6 and above); 0 for other formats.
    """

    size: int
    point_format: int
    record_bytes: int
    is_compressed: bool
    points: int
    points_offset: int
    scales: FloatArray
    offsets: FloatArray
    bounds: FloatArray
    records: dict[tuple[str, int], bytes]
    layer_count: int

    @property
    def laszip(self) -> bytes:
        return self.records.get(("laszip encoded", 22204), b"")


def read_las_header(path: Path) -> LasHeader:
    """Read the header. Raises InputError if it is not that of a LAS file with points."""
    size = check_header(path)
    with open_regular(path) as file:
        header = file.read(375)
        header_size, points_at, n_records = struct.unpack_from("<HII", header, 94)
        file.seek(0)
        top = file.read(points_at)
    kind, record_bytes, point_count = struct.unpack_from("<BHI", header, POINT_FORMAT_AT)
    if header[25] >= 4 and len(header) >= 255:
        (point_count,) = struct.unpack_from("<Q", header, 247)
    numbers = np.array(struct.unpack_from("<6d", header, 131))
    if not (np.isfinite(numbers).all() and (numbers[:3] != 0).all()):
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("the scale or offset of the coordinates is not a number"),
            ),
            file=path,
            field="LAS header",
        )
    bounds = np.array(struct.unpack_from("<6d", header, 179)).reshape(3, 2)
    records: dict[tuple[str, int], bytes] = {}
    offset = header_size
    for _ in range(n_records):
        if offset + 54 > len(top):
            raise _contradiction(path)
        user_id, record_id, length = struct.unpack_from("<16sHH", top, offset + 2)
        name = user_id.split(b"\0")[0].decode("ascii", "replace")
        records.setdefault((name, record_id), top[offset + 54 : offset + 54 + length])
        offset += 54 + length
    compressed = bool(kind & COMPRESSED)
    layers = 0
    if compressed:
        if laszip_chunk_points(top, header_size, n_records, record_bytes) is None:
            raise _contradiction(path)
        layers = _layers(records[("laszip encoded", 22204)])
    return LasHeader(
        size,
        kind & 0x3F,
        record_bytes,
        compressed,
        point_count,
        points_at,
        numbers[:3],
        numbers[3:],
        bounds[:, ::-1].T,
        records,
        layers,
    )


def _contradiction(path: Path) -> InputError:
    return InputError(
        Finding("file.damaged", format="LAZ", reason=tr("its header contradicts itself")),
        file=path,
        field="LAS header",
    )


def _layers(laszip: bytes) -> int:
    """Return the number of layers from the laszip record (LAZ 1.4, items 10 to 14)."""
    (item_count,) = struct.unpack_from("<H", laszip, 32)
    total_bytes = 0
    for k in range(item_count):
        kind, size = struct.unpack_from("<HH", laszip, 34 + 6 * k)
        total_bytes += {10: 9, 11: 1, 12: 2, 13: 1, 14: size}.get(kind, 0)
    return total_bytes


def is_valid_chunk(chunk: bytes, points: int, top: LasHeader) -> bool:
    """Return whether a chunk of a layered format has its stated length and number of points."""
    start = top.record_bytes
    header_end = start + 4 + 4 * top.layer_count
    if top.layer_count == 0 or len(chunk) < header_end:
        return False
    (count,) = struct.unpack_from("<I", chunk, start)
    sizes = struct.unpack_from(f"<{top.layer_count}I", chunk, start + 4)
    return int(count) == points and header_end + sum(sizes) == len(chunk)


POINTS_PER_DECOMPRESSION = 100_000


def decompress(
    chunks: Sequence[bytes],
    points: Sequence[int],
    top: LasHeader,
    max_points: int = POINTS_PER_DECOMPRESSION,
) -> ByteArray | None:
    """Return (points, record_bytes) of the first `points` of each chunk, or None on failure.

    lazrs holds the GIL, so it is called for a few chunks with a limited number of points at a time,
    which lets other threads run in between.
    """
    import lazrs

    records = np.zeros((sum(points), top.record_bytes), np.uint8)
    selection = lazrs.DecompressionSelection(lazrs.SELECTIVE_DECOMPRESS_ALL)
    first_point = row = 0
    while first_point < len(chunks):
        stop, n = first_point + 1, points[first_point]
        while stop < len(chunks) and n + points[stop] <= max_points:
            n += points[stop]
            stop += 1
        table = [
            (k, len(chunk))
            for k, chunk in zip(points[first_point:stop], chunks[first_point:stop], strict=True)
        ]
        part = np.zeros(n * top.record_bytes, np.uint8)
        if any(_blank_bytes(top.record_bytes) in chunk for chunk in chunks[first_point:stop]):
            return None
        try:
            lazrs.decompress_points_with_chunk_table(
                b"".join(chunks[first_point:stop]), top.laszip, part, table, selection
            )
        except BaseException as error:
            # Rust panics are not derived from Exception.
            if not isinstance(error, Exception) and type(error).__name__ != "PanicException":
                raise
            return None
        records[row : row + n] = part.reshape(n, top.record_bytes)
        first_point, row = stop, row + n
    return records
