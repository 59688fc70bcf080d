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
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr

MIN_HEADER_BYTES = 227
MIN_POINT_BYTES = 20
DEFAULT_CHUNK_POINTS = 50_000
MAX_TRUNCATION_BYTES = 64 << 20
MAX_CHUNK_POINTS = 10_000_000
VARIABLE_CHUNKS = 2**32 - 1
POINT_FORMAT_OFFSET, COMPRESSED_BIT = 104, 0x80


def check_header(path: Path) -> int:
    """Reject invalid LAS files before a library reads them; return the size of the file."""
    try:
        with open_regular_file(path) as file:
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
    header_size, points_offset, n_records = struct.unpack_from("<HII", header, 94)
    if header_size < MIN_HEADER_BYTES or points_offset < header_size or points_offset > size:
        raise InputError(
            Finding("file.truncated", size=size, expected=points_offset),
            file=path,
            field="LAS header",
        )
    (record_bytes,) = struct.unpack_from("<H", header, 105)
    if record_bytes < MIN_POINT_BYTES:
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("its header states only {count} bytes per point", count=record_bytes),
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

    Returns None if the file does not need this. Raises InputError if the header is damaged, or if
    the table cannot be replaced because the chunks do not have the default size.

    The table is at the end of the file, and the decoder reads it first although it is not needed
    for sequential reading. lazrs trusts the table and aborts the process if it requires too much
    memory, so false values must be detected here.
    """
    with open_regular_file(path) as file:
        header = file.read(MIN_HEADER_BYTES)
        if not header[POINT_FORMAT_OFFSET] & COMPRESSED_BIT:
            return None
        header_size, points_offset, n_records = struct.unpack_from("<HII", header, 94)
        (record_bytes,) = struct.unpack_from("<H", header, 105)
        (point_count,) = struct.unpack_from("<I", header, 107)
        file.seek(0)
        header_records = file.read(points_offset + 8)
        if len(header_records) < points_offset + 8:
            raise InputError(
                Finding("file.truncated", size=len(header_records), expected=points_offset + 8),
                file=path,
            )
        if header[25] >= 4 and len(header_records) >= 255:
            (point_count,) = struct.unpack_from("<Q", header_records, 247)
        chunk_points = laszip_chunk_points(header_records, header_size, n_records, record_bytes)
        if chunk_points is None:
            raise InputError(
                Finding("file.damaged", format="LAZ", reason=tr("its header contradicts itself")),
                file=path,
                field="LAS header",
            )
        (chunk_table_offset,) = struct.unpack_from("<q", header_records, points_offset)
        if chunk_table_offset == -1:
            file.seek(size - 8)
            (chunk_table_offset,) = struct.unpack("<q", file.read(8))
        if points_offset < chunk_table_offset <= size - 8:
            file.seek(chunk_table_offset)
            _, n_chunks = struct.unpack("<II", file.read(8))
            # Each chunk begins with a complete point.
            is_plausible = n_chunks <= (chunk_table_offset - points_offset) // MIN_POINT_BYTES
            if is_plausible and chunk_points in (VARIABLE_CHUNKS, 0):
                return None
            if is_plausible and n_chunks == -(-point_count // chunk_points):
                return None
        if chunk_points != DEFAULT_CHUNK_POINTS:
            raise InputError(
                Finding(
                    "file.damaged",
                    format="LAZ",
                    reason=tr("its chunk table does not match its number of points"),
                ),
                file=path,
            )
        file.seek(0)
        content = bytearray(file.read())
    struct.pack_into("<q", content, points_offset, len(content))
    content += struct.pack("<II", 0, 0)
    return io.BytesIO(content)


def laszip_chunk_points(
    header_records: bytes, offset: int, n_records: int, record_bytes: int
) -> int | None:
    """Return the points per chunk in the laszip record (0: no chunks), or None if invalid."""
    for _ in range(n_records):
        if offset + 54 > len(header_records):
            return None
        user_id, record_id, length = struct.unpack_from("<16sHH", header_records, offset + 2)
        offset += 54
        if user_id.rstrip(b"\0") == b"laszip encoded" and record_id == 22204:
            if length < 34 or offset + length > len(header_records):
                return None
            (compressor,) = struct.unpack_from("<H", header_records, offset)
            (points,) = struct.unpack_from("<I", header_records, offset + 12)
            (item_count,) = struct.unpack_from("<H", header_records, offset + 32)
            if length < 34 + 6 * item_count:
                return None
            item_bytes = sum(
                struct.unpack_from("<H", header_records, offset + 36 + 6 * k)[0]
                for k in range(item_count)
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
    with open_regular_file(path) as file:
        file.seek(POINT_FORMAT_OFFSET)
        kind = file.read(1)[0]
    return bool(kind & COMPRESSED_BIT) and kind & 0x3F >= 6


def check_layers(path: Path, header: LasHeader) -> None:
    """Raise InputError if the layer lengths of a chunk far exceed the size of the file.

    lazrs allocates memory according to these lengths, which only the layered formats have. A
    truncated last chunk is allowed.
    """
    if not header.layer_count or is_copc(path):
        return
    format_ = f"<{header.layer_count}I"
    with open_regular_file(path) as file:
        file.seek(header.points_offset)
        (end,) = struct.unpack("<q", file.read(8).ljust(8, b"\0"))
        if end == -1:
            file.seek(header.size - 8)
            (end,) = struct.unpack("<q", file.read(8))
        # The chunk table follows the last chunk.
        end = end if header.points_offset < end < header.size else header.size
        offset = header.points_offset + 8
        while offset < end:
            file.seek(offset + header.record_bytes + 4)
            sizes = file.read(struct.calcsize(format_))
            if len(sizes) < struct.calcsize(format_):
                return
            layer_bytes = sum(struct.unpack(format_, sizes))
            offset += header.record_bytes + 4 + len(sizes) + layer_bytes
            if offset > header.size + MAX_TRUNCATION_BYTES:
                raise _contradiction_error(path)


BLOCK_BYTES = 2 << 20
BLOCKS_PER_REPORT = 8
MIN_BLANK_BYTES = 128
_ONES = np.uint64(2**64 - 1)


def _blank_bytes(record_bytes: int) -> bytes:
    """Return a run of bytes 255 that neither encoders nor first points of chunks produce.

    Memory cards contain such runs where nothing was written. lazrs reads beyond its memory when it
    decodes them, which ends the process.
    """
    return b"\xff" * max(MIN_BLANK_BYTES, record_bytes + 64)


def refuse_blank(path: Path, progress: Progress) -> None:
    """Raise InputError if a LAZ file contains the run of bytes of `_blank_bytes`."""
    with open_regular_file(path) as file:
        header = file.read(MIN_HEADER_BYTES)
        if not header[POINT_FORMAT_OFFSET] & COMPRESSED_BIT:
            return
        header_size, points_offset = struct.unpack_from("<HI", header, 94)
        blank_bytes = _blank_bytes(struct.unpack_from("<H", header, 105)[0])
        file.seek(max(points_offset, header_size))
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
        with open_regular_file(path) as file:
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
    layer_count : int
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
    with open_regular_file(path) as file:
        header = file.read(375)
        header_size, points_offset, n_records = struct.unpack_from("<HII", header, 94)
        file.seek(0)
        header_records = file.read(points_offset)
    kind, record_bytes, point_count = struct.unpack_from("<BHI", header, POINT_FORMAT_OFFSET)
    if header[25] >= 4 and len(header) >= 255:
        (point_count,) = struct.unpack_from("<Q", header, 247)
    numbers = np.array(struct.unpack_from("<6d", header, 131))
    if not (np.isfinite(numbers).all() and (numbers[:3] != 0).all()):
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("the scale or offset of the coordinates is not valid"),
            ),
            file=path,
            field="LAS header",
        )
    bounds = np.array(struct.unpack_from("<6d", header, 179)).reshape(3, 2)
    records: dict[tuple[str, int], bytes] = {}
    offset = header_size
    for _ in range(n_records):
        if offset + 54 > len(header_records):
            raise _contradiction_error(path)
        user_id, record_id, length = struct.unpack_from("<16sHH", header_records, offset + 2)
        name = user_id.split(b"\0")[0].decode("ascii", "replace")
        records.setdefault((name, record_id), header_records[offset + 54 : offset + 54 + length])
        offset += 54 + length
    is_compressed = bool(kind & COMPRESSED_BIT)
    layer_count = 0
    if is_compressed:
        if laszip_chunk_points(header_records, header_size, n_records, record_bytes) is None:
            raise _contradiction_error(path)
        layer_count = _count_layers(records[("laszip encoded", 22204)])
    return LasHeader(
        size,
        kind & 0x3F,
        record_bytes,
        is_compressed,
        point_count,
        points_offset,
        numbers[:3],
        numbers[3:],
        bounds[:, ::-1].T,
        records,
        layer_count,
    )


def _contradiction_error(path: Path) -> InputError:
    return InputError(
        Finding("file.damaged", format="LAZ", reason=tr("its header contradicts itself")),
        file=path,
        field="LAS header",
    )


def _count_layers(laszip: bytes) -> int:
    """Return the number of layers from the laszip record (LAZ 1.4, items 10 to 14)."""
    (item_count,) = struct.unpack_from("<H", laszip, 32)
    total_bytes = 0
    for k in range(item_count):
        kind, size = struct.unpack_from("<HH", laszip, 34 + 6 * k)
        total_bytes += {10: 9, 11: 1, 12: 2, 13: 1, 14: size}.get(kind, 0)
    return total_bytes


def is_valid_chunk(chunk: bytes, points: int, header: LasHeader) -> bool:
    """Return whether a chunk of a layered format has its stated length and number of points."""
    start = header.record_bytes
    header_end = start + 4 + 4 * header.layer_count
    if header.layer_count == 0 or len(chunk) < header_end:
        return False
    (count,) = struct.unpack_from("<I", chunk, start)
    sizes = struct.unpack_from(f"<{header.layer_count}I", chunk, start + 4)
    return int(count) == points and header_end + sum(sizes) == len(chunk)


POINTS_PER_DECOMPRESSION = 100_000


def decompress(
    chunks: Sequence[bytes],
    points: Sequence[int],
    header: LasHeader,
    max_points: int = POINTS_PER_DECOMPRESSION,
) -> ByteArray | None:
    """Return the records (n, record_bytes) of the first `points` of each chunk, or None.

    None means that a chunk cannot be decompressed. lazrs holds the GIL, so it is called for a few
    chunks with a limited number of points at a time, which lets other threads run in between.
    """
    import lazrs

    records = np.zeros((sum(points), header.record_bytes), np.uint8)
    selection = lazrs.DecompressionSelection(lazrs.SELECTIVE_DECOMPRESS_ALL)
    first_chunk = row = 0
    while first_chunk < len(chunks):
        stop, n = first_chunk + 1, points[first_chunk]
        while stop < len(chunks) and n + points[stop] <= max_points:
            n += points[stop]
            stop += 1
        table = [
            (k, len(chunk))
            for k, chunk in zip(points[first_chunk:stop], chunks[first_chunk:stop], strict=True)
        ]
        chunk_records = np.zeros(n * header.record_bytes, np.uint8)
        if any(_blank_bytes(header.record_bytes) in chunk for chunk in chunks[first_chunk:stop]):
            return None
        try:
            lazrs.decompress_points_with_chunk_table(
                b"".join(chunks[first_chunk:stop]), header.laszip, chunk_records, table, selection
            )
        except BaseException as error:
            # Rust panics are not derived from Exception.
            if not isinstance(error, Exception) and type(error).__name__ != "PanicException":
                raise
            return None
        records[row : row + n] = chunk_records.reshape(n, header.record_bytes)
        first_chunk, row = stop, row + n
    return records
