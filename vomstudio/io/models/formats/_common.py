"""Helpers of the readers: reading of whole files, colours, and removal of invalid data."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray, ByteArray, FloatArray, Int32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_unbuffered
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.threads import map_parallel
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import position_keys
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.text.encodings import MARKS, convert_to_utf8

BLOCK_BYTES = 8 * 1024 * 1024
READER_THREADS = 3
INITIAL_ROWS = 2_000_000
BLOCK_ROWS = 1 << 17


def read_whole_file(path: Path, progress: Progress, padding: bytes = b"") -> ByteArray:
    """Return all bytes of a file followed by `padding`.

    Blocks are read so that the user can cancel. The file is not memory-mapped: if a mapped file
    shrinks or a network drive disconnects, the process ends. Raises InputError.
    """
    try:
        size = os.stat(path).st_size
        data = np.empty(size + len(padding), np.uint8)
        view = data.data
        progress.stage(tr("Reading the file"), size)

        def fill(start: int) -> int:
            stop = min(start + BLOCK_BYTES, size)
            with open_unbuffered(path) as file:
                file.seek(start)
                position = start
                while position < stop and (n := file.readinto(view[position:stop])):
                    position += n
            return position

        read_count = 0
        for read_count in map_parallel(fill, range(0, size, BLOCK_BYTES), READER_THREADS):
            progress.step(read_count)
            if read_count % BLOCK_BYTES and read_count < size:
                break  # the file has become shorter in the meantime
    except PermissionError:
        raise InputError(Finding("file.no-permission"), file=path) from None
    except MemoryError:
        raise InputError(Finding("file.exceeds-memory"), file=path) from None
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    data = data[: read_count + len(padding)]
    data[read_count:] = np.frombuffer(padding, np.uint8)
    return data


def to_utf8(data: ByteArray, padding: bytes = b"") -> ByteArray:
    """Convert UTF-16 data from `read_whole_file` to UTF-8; other data are unchanged.

    `padding` is the padding at the end of the data.
    """
    if data[:2].tobytes() not in MARKS:
        return data
    raw_data = data[: len(data) - len(padding)].tobytes()
    return np.frombuffer(bytearray(convert_to_utf8(raw_data) + padding), np.uint8)


_DECIMAL_COMMA = re.compile(rb"(?<![\w.,])[+-]?\d+,\d+(?:[eE][+-]?\d+)?(?![\w.,])")


def refuse_decimal_commas(path: Path, text: bytes, line: int | None = None) -> None:
    """Reject numbers with decimal commas in formats whose numbers are separated by spaces.

    `text` is the line or word that is not a number. Raises InputError if it contains such a number:
    skipping it would lose most of the model and corrupt the remainder.
    """
    match = _DECIMAL_COMMA.search(text)
    if match is not None:
        raise InputError(
            Finding("table.decimal-comma", cell=match.group().decode("ascii")), file=path, line=line
        )


def missing_points_finding(count: int, declared_count: int) -> Finding:
    """Return the finding about a truncated point cloud."""
    return Finding("model.incomplete", count=count, promised=declared_count, element=tr("points"))


def to_uint8_colors(colors: AnyArray) -> ByteArray:
    """Return colours (n, 3) as uint8.

    The colours are bytes, 16-bit values, or floats in 0..1, 0..255 or 0..65535. Floats that are not
    finite become 255.
    """
    if colors.dtype == np.uint8:
        return np.ascontiguousarray(colors, dtype=np.uint8)
    if colors.dtype == np.uint16:
        if colors.size and colors.max() > 255:
            return (colors >> 8).astype(np.uint8)
        return colors.astype(np.uint8)
    scaled_colors, maximum = np.empty(colors.shape, np.uint8), 0.0
    blocks = [slice(offset, offset + BLOCK_ROWS) for offset in range(0, len(colors), BLOCK_ROWS)]
    for block in blocks:
        values = np.asarray(colors[block], np.float32)
        maximum = max(maximum, float(values.max(initial=0.0, where=np.isfinite(values))))
    scale = 255.0 if maximum <= 1.0 else 1.0 if maximum <= 255.0 else 255.0 / 65535.0
    for block in blocks:
        values = np.asarray(colors[block], np.float32)
        is_finite = np.isfinite(values)
        scaled_colors[block] = np.clip(np.where(is_finite, values * scale + 0.5, 255.0), 0, 255)
    return scaled_colors


def drop_invalid_vertices(mesh: Mesh, findings: list[Finding], path: Path) -> Mesh | PointCloud:
    """Remove non-finite vertices and their faces; return a cloud if no faces remain.

    Faces must refer to existing vertices. Findings are appended to `findings`. Raises InputError if
    nothing remains.
    """
    vertices, faces = mesh.vertices, mesh.faces
    is_finite_vertex = np.logical_and.reduce(np.isfinite(vertices), axis=1)
    offsets, uv, colors, fields = mesh.material_offsets, mesh.uv, mesh.colors, dict(mesh.fields)
    n_invalid = int(len(is_finite_vertex) - np.count_nonzero(is_finite_vertex))
    if n_invalid:
        is_valid_face = is_finite_vertex[faces].all(axis=1)
        n_invalid_faces = int(len(is_valid_face) - np.count_nonzero(is_valid_face))
        rows = np.cumsum(is_finite_vertex, dtype=np.int64).astype(np.int32) - 1
        faces = rows[faces[is_valid_face]]
        offsets = np.concatenate([[0], np.cumsum(is_valid_face)])[offsets].astype(np.int64)
        vertices = vertices[is_finite_vertex]
        uv = None if uv is None else uv[is_finite_vertex]
        colors = None if colors is None else colors[is_finite_vertex]
        fields = {name: values[is_finite_vertex] for name, values in fields.items()}
        findings.append(Finding("model.points-invalid", count=n_invalid))
        if n_invalid_faces:
            findings.append(Finding("model.faces-invalid", count=n_invalid_faces))
    if len(vertices) == 0:
        raise InputError(Finding("model.no-points"), file=path)
    if len(faces) == 0:
        findings.append(Finding("model.opened-as-cloud"))
        return PointCloud(vertices, colors, None, fields)
    a, b, c = faces[:, 0], faces[:, 1], faces[:, 2]
    n_degenerate = int(np.count_nonzero((a == b) | (b == c) | (c == a)))
    if n_degenerate:
        findings.append(Finding("model.faces-without-area", count=n_degenerate))
    return Mesh(vertices, np.ascontiguousarray(faces), mesh.materials, offsets, uv, colors, fields)


def drop_invalid_points(cloud: PointCloud, findings: list[Finding], path: Path) -> PointCloud:
    """Remove points that are not finite. Raises InputError if no points remain."""
    is_finite = np.isfinite(cloud.points)
    if len(is_finite) and is_finite.all():
        return cloud
    is_finite_point = np.logical_and.reduce(is_finite, axis=1)
    n_invalid = int(len(is_finite_point) - np.count_nonzero(is_finite_point))
    if n_invalid == len(is_finite_point):
        raise InputError(Finding("model.no-points"), file=path)
    findings.append(Finding("model.points-invalid", count=n_invalid))
    return cloud.select_rows(is_finite_point)


def join_corners(
    corners: npt.NDArray[np.float32 | np.float64],
) -> tuple[FloatArray, Int32Array]:
    """Merge equal corners of triangles.

    Parameters
    ----------
    corners : (3 m, 3) array
        Coordinates, three rows per triangle.

    Returns
    -------
    vertices : (n, 3) array
        Distinct corners in the order of their first occurrence.
    faces : (m, 3) array of int32
    """
    keys = position_keys(corners)
    order = np.argsort(keys, kind="stable")
    is_first = np.append(True, np.diff(keys[order]) != 0)
    del keys
    first_rows = order[is_first]
    rank = np.empty(len(first_rows), np.int32)
    occurrence_order = np.argsort(first_rows)
    rank[occurrence_order] = np.arange(len(first_rows), dtype=np.int32)
    faces = np.empty(len(order), np.int32)
    faces[order] = rank[np.cumsum(is_first) - 1]
    # -0 and 0 represent the same coordinate.
    return corners[first_rows[occurrence_order]].astype(np.float64) + 0.0, faces.reshape(-1, 3)


class Columns:
    """Arrays that grow with the values that are read, regardless of what a header states.

    Each array has the type required by its widest part, or the object type if a part contains
    anything other than numbers.
    """

    def __init__(self, initial_rows: int = INITIAL_ROWS) -> None:
        """Create columns with space for `initial_rows` rows, which is doubled when it is full."""
        self._initial_rows = initial_rows
        self._arrays: dict[str, AnyArray] = {}
        self._row_counts: dict[str, int] = {}

    def add(self, name: str, values: AnyArray, limit: int | None = None) -> None:
        """Append values. `limit` is the maximum number of rows, if known."""
        n_filled = self._row_counts.get(name, 0)
        needed_size = n_filled + len(values)
        array = self._arrays.get(name, values[:0])
        common_type = _common_type(array.dtype, values.dtype)
        if len(array) < needed_size or common_type != array.dtype:
            # Unfilled rows do not use memory.
            capacity = max(needed_size, 2 * n_filled, self._initial_rows)
            capacity = capacity if limit is None else max(min(limit, capacity), needed_size)
            enlarged_array = np.empty((capacity, *values.shape[1:]), common_type)
            enlarged_array[:n_filled] = array[:n_filled]
            self._arrays[name] = array = enlarged_array
        array[n_filled:needed_size] = values
        self._row_counts[name] = needed_size

    def take(self, name: str, n: int) -> AnyArray | None:
        array = self._arrays.pop(name, None)
        if array is None:
            return None
        return array if len(array) == n else array[:n].copy()


def _common_type(dtype: np.dtype[Any], other_dtype: np.dtype[Any]) -> np.dtype[Any]:
    if dtype == other_dtype:
        return dtype
    return (
        np.result_type(dtype, other_dtype)
        if {dtype.kind, other_dtype.kind} <= set("iuf")
        else np.dtype(object)
    )
