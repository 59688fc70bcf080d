"""Shapefiles as models: points with heights as a cloud or multipatches as a mesh.

The formats are those of the ESRI Shapefile Technical Description (1998) and dBase III. They are
parsed here and not by a library so that attributes keep every digit that
`vomstudio.io.gis.shapefile` writes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray, GenericArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files import regular
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.shapefile import POINT_BYTES, POINT_Z
from vomstudio.io.models.formats._common import (
    drop_invalid_points,
    drop_invalid_vertices,
    join_corners,
    read_whole_file,
    to_uint8_colors,
)
from vomstudio.io.models.reader import LoadedModel, Reader

Fields = dict[str, GenericArray]

_MAGIC = b"\0\0\x27\x0a"
_HEADER_BYTES = 100
_MULTI_POINT_Z, _MULTI_PATCH = 18, 31
_RECORD = np.dtype([("head", ">i4", 2), ("type", "<i4"), ("xyzm", "<f8", 4)])
_STRIP, _FAN = 0, 1
_UNSUPPORTED_SHAPES = {
    1: to_translate("points without heights"),
    3: to_translate("lines"),
    5: to_translate("polygons"),
    8: to_translate("points without heights"),
    13: to_translate("lines"),
    15: to_translate("polygons"),
    21: to_translate("points without heights"),
    23: to_translate("lines"),
    25: to_translate("polygons"),
    28: to_translate("points without heights"),
}
_COLORS, _NORMALS = ("red", "green", "blue"), ("normal_x", "normal_y", "normal_z")
_MAX_INTEGER_WIDTH = 18


@dataclass(frozen=True)
class _Record:
    kind: int
    content: memoryview


def matches(path: Path, head: bytes) -> bool:
    """Return whether the content is certainly that of a shapefile."""
    return head.startswith(_MAGIC) and len(head) >= _HEADER_BYTES


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read points with heights and their numeric attributes, or the faces of multipatches.

    Raises
    ------
    InputError
        If the file is damaged or contains other shapes (``model.other-shapes``).
    """
    data = read_whole_file(path, progress)
    if len(data) < _HEADER_BYTES or data[:4].tobytes() != _MAGIC:
        raise InputError(Finding("file.other-format", format="SHP"), file=path)
    (kind,) = struct.unpack_from("<i", data.data, 32)
    findings: list[Finding] = []
    if kind in _UNSUPPORTED_SHAPES:
        finding = Finding("model.other-shapes", shapes=tr(_UNSUPPORTED_SHAPES[kind]))
        raise InputError(finding, file=path)
    if kind == _MULTI_PATCH:
        corners = _patch_corners(data, findings)
        if not len(corners):
            raise InputError(Finding("model.no-faces"), file=path)
        mesh = drop_invalid_vertices(Mesh(*join_corners(corners.reshape(-1, 3))), findings, path)
        is_mesh = isinstance(mesh, Mesh)
        return LoadedModel(mesh, "mesh" if is_mesh else "cloud", None, tuple(findings), path)
    if kind not in (POINT_Z, _MULTI_POINT_Z):
        finding = Finding(
            "model.other-shapes", shapes=tr("shapes of an unknown type ({kind})", kind=kind)
        )
        raise InputError(finding, file=path)
    points, rows = _points(data, findings)
    if not len(points):
        raise InputError(Finding("model.no-points"), file=path)
    fields: Fields = {} if rows is None else _attributes(path, rows, findings)
    cloud = drop_invalid_points(_cloud(points, fields), findings, path)
    return LoadedModel(cloud, "cloud", None, tuple(findings), path)


def _cloud(points: FloatArray, fields: Fields) -> PointCloud:
    colors = normals = None
    if fields.keys() >= set(_COLORS):
        colors = to_uint8_colors(np.stack([fields.pop(name) for name in _COLORS], -1))
    if fields.keys() >= set(_NORMALS):
        normals = np.stack([fields.pop(name) for name in _NORMALS], -1).astype(np.float32)
    if list(fields) == ["id"] and np.array_equal(fields["id"], np.arange(1, len(points) + 1)):
        # Written only because the format requires a column.
        fields = {}
    return PointCloud(points, colors, normals, fields)


# --- shapes ------------------------------------------------------------------------------------


def _points(data: ByteArray, findings: list[Finding]) -> tuple[FloatArray, IntArray | None]:
    """Return points (n, 3) and their table rows, None if a row has several points."""
    body = data[_HEADER_BYTES:]
    if len(body) % POINT_BYTES == 0:
        records = body.view(_RECORD)
        if (records["type"] == POINT_Z).all() and (records["head"][:, 1] == 18).all():
            return np.ascontiguousarray(records["xyzm"][:, :3]), np.arange(len(records))
    positions: list[FloatArray] = []
    rows: list[int] = []
    is_single = True
    for row, record in enumerate(_records(data, findings)):
        if record.kind == POINT_Z and len(record.content) >= 28:
            positions.append(np.array([struct.unpack_from("<3d", record.content, 4)]))
            rows.append(row)
        elif record.kind == _MULTI_POINT_Z and len(record.content) >= 40:
            (n,) = struct.unpack_from("<i", record.content, 36)
            if n < 0 or len(record.content) < 40 + 16 * n + 16 + 8 * n:
                continue
            plane_coordinates = np.frombuffer(record.content, "<f8", 2 * n, 40).reshape(-1, 2)
            heights = np.frombuffer(record.content, "<f8", n, 40 + 16 * n + 16)
            positions.append(np.column_stack([plane_coordinates, heights]))
            is_single = False
    points = np.concatenate(positions) if positions else np.empty((0, 3))
    return points, np.array(rows, np.int64) if is_single else None


def _records(data: ByteArray, findings: list[Finding]) -> Iterator[_Record]:
    view, offset, record_number = data.data, _HEADER_BYTES, 0
    while offset + 12 <= len(data):
        _, word_count = struct.unpack_from(">2i", view, offset)
        end = offset + 8 + 2 * word_count
        if word_count < 2 or end > len(data):
            findings.append(Finding("model.cut-short", count=record_number))
            return
        (kind,) = struct.unpack_from("<i", view, offset + 8)
        yield _Record(kind, view[offset + 8 : end])
        offset, record_number = end, record_number + 1


def _patch_corners(data: ByteArray, findings: list[Finding]) -> FloatArray:
    """Return the triangles (n, 3, 3) of multipatches."""
    patches: list[FloatArray] = []
    n_skipped = 0
    for record in _records(data, findings):
        content = record.content
        if record.kind != _MULTI_PATCH or len(content) < 44:
            continue
        part_count, n = struct.unpack_from("<2i", content, 36)
        if part_count < 0 or n < 0 or len(content) < 44 + 8 * part_count + 24 * n + 16:
            continue
        starts = np.frombuffer(content, "<i4", part_count, 44)
        kinds = np.frombuffer(content, "<i4", part_count, 44 + 4 * part_count)
        offset = 44 + 8 * part_count
        plane_coordinates = np.frombuffer(content, "<f8", 2 * n, offset).reshape(-1, 2)
        points = np.column_stack(
            [plane_coordinates, np.frombuffer(content, "<f8", n, offset + 16 * n + 16)]
        )
        ends = np.append(starts[1:], n)
        for start, end, kind in zip(starts.tolist(), ends.tolist(), kinds.tolist(), strict=True):
            triangles = _part_triangles(points[start:end], kind)
            n_skipped += triangles is None
            patches += [] if triangles is None else [triangles]
    if n_skipped:
        findings.append(Finding("model.rings-left-out", count=n_skipped))
    return np.concatenate(patches) if patches else np.empty((0, 3, 3))


def _part_triangles(points: FloatArray, kind: int) -> FloatArray | None:
    """Return the triangles of a strip, a fan or a ring of up to four corners, or None."""
    if kind not in (_STRIP, _FAN):
        if len(points) > 1 and (points[0] == points[-1]).all():
            points = points[:-1]
        if len(points) > 4:
            return None
    n = max(len(points) - 2, 0)
    k = np.arange(n)
    if kind == _STRIP:
        # Every second triangle of a strip has the opposite orientation.
        rows = np.stack([k, k + 1 + k % 2, k + 2 - k % 2], -1)
    else:
        rows = np.stack([np.zeros(n, np.int64), k + 1, k + 2], -1)
    return np.asarray(points[rows], np.float64)


# --- attributes --------------------------------------------------------------------------------


def _attributes(path: Path, rows: IntArray, findings: list[Finding]) -> Fields:
    """Return the numeric columns of the table for the shapes, with one value per point."""
    table = _read_dbf(path)
    if table is None or len(table) < 33:
        return {}
    count, header_bytes, width = struct.unpack_from("<IHH", table, 4)
    if width < 1 or len(table) < header_bytes + width * (int(rows.max(initial=-1)) + 1):
        findings.append(Finding("model.attributes-unused"))
        return {}
    count = min(count, (len(table) - header_bytes) // width)
    cells = np.frombuffer(table, np.uint8, count * width, header_bytes).reshape(count, width)[rows]
    fields: Fields = {}
    other_names: list[str] = []
    offset = 1
    for descriptor_offset in range(32, header_bytes - 32 + 1, 32):
        if table[descriptor_offset] == 0x0D:
            break
        raw_name, kind, size, decimals = struct.unpack_from("<11sc4xBB", table, descriptor_offset)
        name = raw_name.split(b"\0")[0].decode("utf-8", "replace").strip()
        values = _parse_column(cells[:, offset : offset + size], kind, decimals) if size else None
        offset += size
        if values is None:
            other_names.append(name)
        else:
            fields[name] = values
    if other_names:
        findings.append(Finding("model.columns-left-out", columns=other_names))
    return fields


def _parse_column(cells: ByteArray, kind: bytes, decimals: int) -> GenericArray | None:
    """Return the numbers (n,) of a column, NaN if blank, or None if it contains text."""
    width = cells.shape[1]
    if kind == b"L":
        return np.isin(cells[:, 0], tuple(b"TtYy"))
    if kind not in (b"N", b"F"):
        return None
    texts = np.char.strip(np.ascontiguousarray(cells).view(f"S{width}")[:, 0])
    try:
        if decimals == 0 and width <= _MAX_INTEGER_WIDTH and (texts != b"").all():
            return texts.astype(np.int64)
    except ValueError:
        pass
    try:
        return np.where(texts == b"", b"nan", texts).astype(np.float64)
    except ValueError:
        return None


def _read_dbf(path: Path) -> bytes | None:
    for suffix in (".dbf", ".DBF"):
        table_path = path.with_suffix(suffix)
        if regular.is_regular_file(table_path):
            try:
                return regular.read_whole_file(table_path)
            except (InputError, OSError):
                return None
    return None


READER = Reader(to_translate("shapefile of points or faces"), (".shp",), matches, read)
