"""What stands before and after the points of a LAS or LAZ file, doubted before it is believed.

lazrs asks for whatever memory a file promises to need and ends the process where it gets none, so
lies must be found here. laspy is not needed for any of this, and takes time to import.
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
USUAL_CHUNK_POINTS = 50_000
_LARGEST_CUT = 64 << 20
MAX_CHUNK_POINTS = 10_000_000
VARIABLE = 2**32 - 1
POINT_FORMAT_AT, COMPRESSED = 104, 0x80


def check_header(path: Path) -> int:
    """Size of the file. Refuses what cannot be a LAS file before any library sees it."""
    try:
        with open_regular(path) as file:
            head = file.read(MIN_HEADER_BYTES)
            size = file.seek(0, 2)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    if not head.startswith(b"LASF"):
        raise InputError(Finding("file.other-format", format="LAS"), file=path)
    if len(head) < MIN_HEADER_BYTES:
        raise InputError(
            Finding("file.truncated", size=len(head), expected=MIN_HEADER_BYTES), file=path
        )
    header_size, points_at, n_records = struct.unpack_from("<HII", head, 94)
    if header_size < MIN_HEADER_BYTES or points_at < header_size or points_at > size:
        raise InputError(
            Finding("file.truncated", size=size, expected=points_at), file=path, field="LAS header"
        )
    (record_bytes,) = struct.unpack_from("<H", head, 105)
    if record_bytes < MIN_POINT_BYTES:
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("its header states {count} bytes for a point", count=record_bytes),
            ),
            file=path,
            field="LAS header",
        )
    if n_records * 54 > size:
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("its header promises more records than the file can hold"),
            ),
            file=path,
            field="LAS header",
        )
    return size


def mended(path: Path, size: int) -> io.BytesIO | None:
    """A LAZ file whose table of chunks is cut off or senseless, with an empty one in its place.

    The table lies at the end of the file, and the decoder wants it first; but from front to back it
    can do without. None where the file needs no mending. lazrs believes what it reads here and
    aborts the process when it asks for too much memory, so this is where lies must be found.
    """
    with open_regular(path) as file:
        head = file.read(MIN_HEADER_BYTES)
        if not head[POINT_FORMAT_AT] & COMPRESSED:
            return None
        header_size, points_at, n_records = struct.unpack_from("<HII", head, 94)
        (record_bytes,) = struct.unpack_from("<H", head, 105)
        (promised,) = struct.unpack_from("<I", head, 107)
        file.seek(0)
        top = file.read(points_at + 8)
        if len(top) < points_at + 8:
            raise InputError(
                Finding("file.truncated", size=len(top), expected=points_at + 8), file=path
            )
        if head[25] >= 4 and len(top) >= 255:
            (promised,) = struct.unpack_from("<Q", top, 247)
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
            # Each chunk begins with a whole point.
            fits = n_chunks <= (table_at - points_at) // MIN_POINT_BYTES
            if fits and chunk_points in (VARIABLE, 0):
                return None
            if fits and n_chunks == -(-promised // chunk_points):
                return None
        if chunk_points != USUAL_CHUNK_POINTS:
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


def laszip_chunk_points(top: bytes, at: int, n_records: int, record_bytes: int) -> int | None:
    """Points per chunk from the laszip record (0: not in chunks); None where it makes no sense."""
    for _ in range(n_records):
        if at + 54 > len(top):
            return None
        user, number, length = struct.unpack_from("<16sHH", top, at + 2)
        at += 54
        if user.rstrip(b"\0") == b"laszip encoded" and number == 22204:
            if length < 34 or at + length > len(top):
                return None
            (compressor,) = struct.unpack_from("<H", top, at)
            (points,) = struct.unpack_from("<I", top, at + 12)
            (n_items,) = struct.unpack_from("<H", top, at + 32)
            if length < 34 + 6 * n_items:
                return None
            item_bytes = sum(
                struct.unpack_from("<H", top, at + 36 + 6 * k)[0] for k in range(n_items)
            )
            if item_bytes != record_bytes:
                return None
            if compressor == 1:
                return 0
            return points if 0 < points <= MAX_CHUNK_POINTS or points == VARIABLE else None
        at += length
    return None


def is_layered(path: Path) -> bool:
    """Whether the points are compressed, and of a format that is compressed in layers."""
    with open_regular(path) as file:
        file.seek(POINT_FORMAT_AT)
        kind = file.read(1)[0]
    return bool(kind & COMPRESSED) and kind & 0x3F >= 6


def check_layers(path: Path, top: Top) -> None:
    """Chunks of the layered formats state the length of each layer, for which lazrs makes room
    unseen. Raises InputError where one states far more than is left of the file; a last chunk that
    is cut off passes."""
    if not top.layers or is_copc(path):
        return
    form = f"<{top.layers}I"
    with open_regular(path) as file:
        file.seek(top.points_at)
        (end,) = struct.unpack("<q", file.read(8).ljust(8, b"\0"))
        if end == -1:
            file.seek(top.size - 8)
            (end,) = struct.unpack("<q", file.read(8))
        # The table of chunks follows the last one.
        end = end if top.points_at < end < top.size else top.size
        at = top.points_at + 8
        while at < end:
            file.seek(at + top.record_bytes + 4)
            sizes = file.read(struct.calcsize(form))
            if len(sizes) < struct.calcsize(form):
                return
            held = sum(struct.unpack(form, sizes))
            at += top.record_bytes + 4 + len(sizes) + held
            if at > top.size + _LARGEST_CUT:
                raise _contradiction(path)


_BLOCK = 2 << 20
_TOLD_EVERY = 8
_BLANK_BYTES = 128
_ONES = np.uint64(2**64 - 1)


def _blank(record_bytes: int) -> bytes:
    """A run of ones that no coder writes, and no first point of a chunk is either: memory cards
    have it where they have nothing. lazrs goes beyond its own memory on it, which ends the
    process."""
    return b"\xff" * max(_BLANK_BYTES, record_bytes + 64)


def refuse_blank(path: Path, progress: Progress) -> None:
    """Raises InputError where a part of a LAZ file holds ones and nothing else."""
    with open_regular(path) as file:
        head = file.read(MIN_HEADER_BYTES)
        if not head[POINT_FORMAT_AT] & COMPRESSED:
            return
        header_size, points_at = struct.unpack_from("<HI", head, 94)
        blank = _blank(struct.unpack_from("<H", head, 105)[0])
        file.seek(max(points_at, header_size))
        # One piece of memory for all blocks, each after the end of the one before it.
        buffer = bytearray(len(blank) + _BLOCK)
        view, words = memoryview(buffer), np.frombuffer(buffer, np.uint64, len(buffer) // 8)
        held, at, count = 0, file.tell(), 0
        while got := file.readinto(view[held : held + _BLOCK]):
            full = held + got
            # A blank is so long that one of every eight words lies in it: the others need no look.
            if (words[: full // 8 : 8] == _ONES).any():
                found = buffer.find(blank, 0, full)
                if found >= 0:
                    raise InputError(Finding("file.blank", byte=at - held + found + 1), file=path)
            at += got
            held = min(full, len(blank))
            view[:held] = bytes(view[full - held : full])
            count += 1
            if count % _TOLD_EVERY == 0:
                progress.stage(tr("Checking the file"))


def is_copc(path: str | Path) -> bool:
    """Whether the first record of a LAZ file is the one of COPC; not that of what is no file."""
    try:
        with open_regular(path) as file:
            head = file.read(393)
    except (OSError, InputError):
        return False
    return head[:4] == b"LASF" and head[377:381] == b"copc"


# --- for readers that look into the middle of a file --------------------------------------------


@dataclass(frozen=True, eq=False)
class Top:
    """The header and what stands between it and the points.

    bounds : (2, 3) as the header says, which may be anything
    records : the bytes of the variable length records by (user, number); the first of each
    layers : how many streams a chunk of the layered formats (6 and above) is made of; 0 in others
    """

    size: int
    point_format: int
    record_bytes: int
    compressed: bool
    points: int
    points_at: int
    scales: FloatArray
    offsets: FloatArray
    bounds: FloatArray
    records: dict[tuple[str, int], bytes]
    layers: int

    @property
    def laszip(self) -> bytes:
        return self.records.get(("laszip encoded", 22204), b"")


def read_top(path: Path) -> Top:
    """Raises InputError where it cannot be the top of a LAS file with points."""
    size = check_header(path)
    with open_regular(path) as file:
        head = file.read(375)
        header_size, points_at, n_records = struct.unpack_from("<HII", head, 94)
        file.seek(0)
        top = file.read(points_at)
    kind, record_bytes, promised = struct.unpack_from("<BHI", head, POINT_FORMAT_AT)
    if head[25] >= 4 and len(head) >= 255:
        (promised,) = struct.unpack_from("<Q", head, 247)
    numbers = np.array(struct.unpack_from("<6d", head, 131))
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
    box = np.array(struct.unpack_from("<6d", head, 179)).reshape(3, 2)
    records: dict[tuple[str, int], bytes] = {}
    at = header_size
    for _ in range(n_records):
        if at + 54 > len(top):
            raise _contradiction(path)
        user, number, length = struct.unpack_from("<16sHH", top, at + 2)
        name = user.split(b"\0")[0].decode("ascii", "replace")
        records.setdefault((name, number), top[at + 54 : at + 54 + length])
        at += 54 + length
    compressed = bool(kind & COMPRESSED)
    layers = 0
    if compressed:
        if laszip_chunk_points(top, header_size, n_records, record_bytes) is None:
            raise _contradiction(path)
        layers = _layers(records[("laszip encoded", 22204)])
    return Top(
        size,
        kind & 0x3F,
        record_bytes,
        compressed,
        promised,
        points_at,
        numbers[:3],
        numbers[3:],
        box[:, ::-1].T,
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
    """From the items of the laszip record (LAZ 1.4 specification, layered items 10 to 14)."""
    (n_items,) = struct.unpack_from("<H", laszip, 32)
    total = 0
    for k in range(n_items):
        kind, size = struct.unpack_from("<HH", laszip, 34 + 6 * k)
        total += {10: 9, 11: 1, 12: 2, 13: 1, 14: size}.get(kind, 0)
    return total


def is_sound_chunk(chunk: bytes, points: int, top: Top) -> bool:
    """Whether a chunk of a layered format is as long, and holds as many points, as it says."""
    start = top.record_bytes
    head = start + 4 + 4 * top.layers
    if top.layers == 0 or len(chunk) < head:
        return False
    (count,) = struct.unpack_from("<I", chunk, start)
    sizes = struct.unpack_from(f"<{top.layers}I", chunk, start + 4)
    return int(count) == points and head + sum(sizes) == len(chunk)


UNPACKED_AT_ONCE = 100_000


def unpack(
    chunks: Sequence[bytes], points: Sequence[int], top: Top, at_once: int = UNPACKED_AT_ONCE
) -> ByteArray | None:
    """(points, record_bytes) of the first `points` of each chunk; None where they cannot be
    unpacked. lazrs keeps the interpreter for itself meanwhile, so it is called for a few chunks,
    of so many points, at a time: other threads get their turn in between."""
    import lazrs

    found = np.zeros((sum(points), top.record_bytes), np.uint8)
    everything = lazrs.DecompressionSelection(lazrs.SELECTIVE_DECOMPRESS_ALL)
    first = row = 0
    while first < len(chunks):
        stop, n = first + 1, points[first]
        while stop < len(chunks) and n + points[stop] <= at_once:
            n += points[stop]
            stop += 1
        table = [
            (k, len(chunk)) for k, chunk in zip(points[first:stop], chunks[first:stop], strict=True)
        ]
        part = np.zeros(n * top.record_bytes, np.uint8)
        if any(_blank(top.record_bytes) in chunk for chunk in chunks[first:stop]):
            return None
        try:
            lazrs.decompress_points_with_chunk_table(
                b"".join(chunks[first:stop]), top.laszip, part, table, everything
            )
        except BaseException as error:
            # Rust's panics arrive outside of Exception.
            if not isinstance(error, Exception) and type(error).__name__ != "PanicException":
                raise
            return None
        found[row : row + n] = part.reshape(n, top.record_bytes)
        first, row = stop, row + n
    return found
