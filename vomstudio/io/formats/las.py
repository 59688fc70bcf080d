"""LAS and LAZ point clouds, through laspy and lazrs."""

from __future__ import annotations

import io
import logging
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import Cancelled, InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.formats._clean import drop_unsound_points, scale_colors
from vomstudio.io.registry import LoadedModel, Reader
from vomstudio.progress import Progress

Array = npt.NDArray[np.generic]

POINTS_PER_STEP = 500_000
# Kept where they say something, that is, are not 0 everywhere.
STANDARD_FIELDS = ("intensity", "classification", "return_number", "gps_time")
MIN_HEADER_BYTES = 227
POINTS_PER_CAREFUL_STEP = 200
MIN_POINT_BYTES = 20
USUAL_CHUNK_POINTS = 50_000
MAX_CHUNK_POINTS = 10_000_000
VARIABLE = 2**32 - 1
POINT_FORMAT_AT, COMPRESSED = 104, 0x80

# laspy logs what it raises as well; without any handler Python would print it.
logging.getLogger("laspy").addHandler(logging.NullHandler())


def matches(path: Path, head: bytes) -> bool:
    return head.startswith(b"LASF")


def read(path: Path, progress: Progress) -> LoadedModel:
    """The points of a LAS or LAZ file: float64 from the file's integers, scale and offset.

    Colours are 8 bit; fields are the standard ones that are not 0 everywhere, and all extra ones.
    The reference system is the file's own. A file that is cut short gives the points it has, with a
    warning. Raises InputError where there are none.
    """
    import laspy
    import lazrs

    said: list[str] = []
    size = _check_header(path)
    try:
        cloud, crs = _read(path, size, progress, said)
    except (Cancelled, InputError):
        raise
    except (
        laspy.errors.LaspyException,
        lazrs.LazrsError,
        OSError,
        ValueError,
        struct.error,
        IndexError,
        KeyError,
        TypeError,
        AttributeError,
        OverflowError,
        MemoryError,
        RuntimeError,
        NotImplementedError,
        UnicodeError,
    ) as error:
        raise _damaged(path, error) from error
    except BaseException as error:
        # Rust's panics arrive outside of Exception.
        if type(error).__name__ != "PanicException":
            raise
        raise _damaged(path, error) from error
    return LoadedModel(drop_unsound_points(cloud, said, path), "cloud", crs, tuple(said), path)


def _damaged(path: Path, error: BaseException) -> InputError:
    return InputError(
        f"The LAS/LAZ file is damaged and cannot be read ({_short(error)}); copy or export it"
        " again.",
        file=path,
    )


def _short(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text[:160] or type(error).__name__


def _check_header(path: Path) -> int:
    """Size of the file. Refuses what cannot be a LAS file before any library sees it."""
    try:
        with open(path, "rb") as file:
            head = file.read(MIN_HEADER_BYTES)
            size = file.seek(0, 2)
    except OSError as error:
        raise InputError(f"The file cannot be read ({error.strerror}).", file=path) from error
    if not head.startswith(b"LASF"):
        raise InputError("This is not a LAS or LAZ file: it does not begin with 'LASF'.", file=path)
    if len(head) < MIN_HEADER_BYTES:
        raise InputError("The file ends within its LAS header; copy it again.", file=path)
    header_size, points_at, n_records = struct.unpack_from("<HII", head, 94)
    if header_size < MIN_HEADER_BYTES or points_at < header_size or points_at > size:
        raise InputError(
            "The file ends before its first point; copy it again.", file=path, field="LAS header"
        )
    if n_records * 54 > size:
        raise InputError(
            f"The LAS header promises {n_records:,} records that the file cannot hold; export it"
            " again.",
            file=path,
            field="LAS header",
        )
    return size


def _read(
    path: Path, size: int, progress: Progress, said: list[str]
) -> tuple[PointCloud, str | None]:
    import laspy

    stream = _mended(path, size)
    if stream is None:
        with laspy.open(path, laz_backend=laspy.LazBackend.LazrsParallel, read_evlrs=False) as r:
            return _read_points(r, path, size, POINTS_PER_STEP, progress, said)
    with laspy.open(stream, laz_backend=laspy.LazBackend.Lazrs, read_evlrs=False) as reader:
        return _read_points(reader, path, size, POINTS_PER_CAREFUL_STEP, progress, said)


def _mended(path: Path, size: int) -> io.BytesIO | None:
    """A LAZ file whose table of chunks is cut off or senseless, with an empty one in its place.

    The table lies at the end of the file, and the decoder wants it first; but from front to back it
    can do without. None where the file needs no mending. lazrs believes what it reads here and
    aborts the process when it asks for too much memory, so this is where lies must be found.
    """
    with open(path, "rb") as file:
        head = file.read(MIN_HEADER_BYTES)
        if not head[POINT_FORMAT_AT] & COMPRESSED:
            return None
        header_size, points_at, n_records = struct.unpack_from("<HII", head, 94)
        (record_bytes,) = struct.unpack_from("<H", head, 105)
        (promised,) = struct.unpack_from("<I", head, 107)
        file.seek(0)
        top = file.read(points_at + 8)
        if len(top) < points_at + 8:
            raise InputError("The file ends before its first point; copy it again.", file=path)
        if head[25] >= 4 and len(top) >= 255:
            (promised,) = struct.unpack_from("<Q", top, 247)
        chunk_points = _chunk_points(top, header_size, n_records, record_bytes)
        if chunk_points is None:
            raise InputError(
                "Its LAZ header contradicts itself; copy or export it again.",
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
                "The chunks of the LAZ file do not add up to its points; copy or export it again.",
                file=path,
            )
        file.seek(0)
        content = bytearray(file.read())
    struct.pack_into("<q", content, points_at, len(content))
    content += struct.pack("<II", 0, 0)
    return io.BytesIO(content)


def _chunk_points(top: bytes, at: int, n_records: int, record_bytes: int) -> int | None:
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


def _read_points(
    reader: Any, path: Path, size: int, at_once: int, progress: Progress, said: list[str]
) -> tuple[PointCloud, str | None]:
    header = reader.header
    promised = int(header.point_count)
    record = int(header.point_format.size)
    limit = promised
    if not header.are_points_compressed:
        limit = min(promised, max(0, size - int(header.offset_to_point_data)) // record)
    scales, offsets = np.asarray(header.scales, float), np.asarray(header.offsets, float)
    if not (np.isfinite(scales).all() and np.isfinite(offsets).all() and (scales != 0).all()):
        raise InputError(
            "The scale or offset of its coordinates is no number; export it again.",
            file=path,
            field="LAS header",
        )
    names = set(header.point_format.dimension_names)
    extra = list(header.point_format.extra_dimension_names)
    wanted = [n for n in STANDARD_FIELDS if n in names] + [n for n in extra]
    colored = {"red", "green", "blue"} <= names
    columns = _Columns()
    done = 0
    progress.stage("Reading the points", limit)
    while done < limit:
        n = min(at_once, limit - done)
        try:
            chunk = reader.read_points(n)
        except Exception:
            # The last points before the end may have been decoded from bytes that are not theirs.
            done -= min(done, at_once)
            if done == 0:
                raise
            break
        got = len(chunk)
        if got == 0:
            break
        xyz = np.empty((got, 3))
        for j, axis in enumerate("XYZ"):
            np.multiply(np.asarray(chunk[axis]), scales[j], out=xyz[:, j])
            xyz[:, j] += offsets[j]
        columns.add("points", xyz, limit)
        if colored:
            rgb = np.empty((got, 3), np.uint16)
            for j, channel in enumerate(("red", "green", "blue")):
                rgb[:, j] = chunk[channel]
            columns.add("colors", rgb, limit)
        for name in wanted:
            columns.add(f"field {name}", np.asarray(chunk[name]), limit)
        done += got
        if done == limit or done % POINTS_PER_STEP < got:
            progress.step(done)
    if done == 0:
        raise InputError(
            "The file holds no points that can be read; copy or export it again.", file=path
        )
    if done < promised:
        said.append(f"The file is cut short: {done:,} of {promised:,} promised points are there.")
    rgb16 = columns.take("colors", done)
    colors = None
    if rgb16 is not None:
        if rgb16.any():
            colors = scale_colors(rgb16)
        else:
            said.append("Its colours are all black and are not used.")
    fields: dict[str, Array] = {}
    for name in wanted:
        values = columns.take(f"field {name}", done)
        assert values is not None
        # First returns only is what every cloud from photographs says, and says nothing.
        if name == "return_number" and (values == 1).all():
            continue
        if name in extra or values.any():
            for j in range(values.shape[1] if values.ndim == 2 else 0):
                fields[f"{name} {j + 1}"] = np.ascontiguousarray(values[:, j])
            if values.ndim == 1:
                fields[name] = values
    points = columns.take("points", done)
    assert points is not None
    return PointCloud(points, colors, None, fields), _crs(header, said)


class _Columns:
    """Arrays that grow with what was really read, never with what a header promises."""

    def __init__(self) -> None:
        self._arrays: dict[str, npt.NDArray[Any]] = {}
        self._filled: dict[str, int] = {}

    def add(self, name: str, values: npt.NDArray[Any], limit: int) -> None:
        filled = self._filled.get(name, 0)
        needed = filled + len(values)
        array = self._arrays.get(name)
        if array is None or len(array) < needed:
            room = min(limit, max(needed, 2 * filled, 4 * POINTS_PER_STEP))
            wider = np.empty((max(room, needed), *values.shape[1:]), values.dtype)
            if array is not None:
                wider[:filled] = array[:filled]
            self._arrays[name] = array = wider
        array[filled:needed] = values
        self._filled[name] = needed

    def take(self, name: str, n: int) -> npt.NDArray[Any] | None:
        array = self._arrays.pop(name, None)
        if array is None:
            return None
        return array if len(array) == n else array[:n].copy()


def _crs(header: Any, said: list[str]) -> str | None:
    """EPSG:n where it can be told, else WKT, else None."""
    try:
        found = header.parse_crs()
        if found is None:
            return None
        code = found.to_epsg()
        return f"EPSG:{code}" if code else str(found.to_wkt())
    except Exception as error:  # noqa: BLE001  whatever pyproj dislikes, the points are sound
        said.append(f"Its coordinate reference system cannot be understood ({_short(error)}).")
        return None


READER = Reader("LAS/LAZ point cloud", (".las", ".laz"), matches, read)
