"""Conversion of WKB to shapes, without the surfaces that GEOS cannot represent.

GDAL reads a polyface mesh as a PolyhedralSurface and a multipatch as a TIN. If a file contains one
of them, GEOS rejects all of its shapes.
"""

from __future__ import annotations

import struct

import numpy as np

from vomstudio.core.arrays import IntArray, ObjectArray
from vomstudio.core.findings import Finding

_POINT, _LINE, _POLYGON, _COLLECTION = 1, 2, 3, 7
_MULTI = (4, 5, 6, _COLLECTION)
_SURFACES = (15, 16, 17)
"""Type codes of PolyhedralSurface, TIN and Triangle (OGC 06-103r4)."""
_HAS_Z, _HAS_M, _HAS_SRID = 0x80000000, 0x40000000, 0x20000000
_MAX_DEPTH = 30


def shapes_from_wkb(
    rows: ObjectArray | None,
) -> tuple[ObjectArray, IntArray]:
    """Return the shapes of WKB rows and the number of surfaces excluded from each row.

    Parameters
    ----------
    rows : (n,) array of bytes or None

    Returns
    -------
    shapes : (n,) array of shapely geometries
        Shapes; None for a row that is a surface or cannot be read. A collection keeps its other
        members.
    surfaces : (n,) array of int
    """
    import shapely

    if rows is None:
        return np.empty(0, np.object_), np.empty(0, np.int64)
    shapes = np.asarray(shapely.from_wkb(rows, on_invalid="ignore"), np.object_)
    surfaces = np.zeros(len(shapes), np.int64)
    for row in np.flatnonzero(shapely.is_missing(shapes)).tolist():
        if rows[row] is None:
            continue
        try:
            remaining_bytes, _, count = _remove_surfaces(bytes(rows[row]), 0, 0)
        except (ValueError, struct.error):
            continue
        surfaces[row] = count
        if count and remaining_bytes is not None:
            shapes[row] = shapely.from_wkb(remaining_bytes, on_invalid="ignore")
    return shapes, surfaces


def excluded_surfaces_finding(count: int) -> Finding:
    """Return the finding about surfaces of a layer that are not read as lines."""
    return Finding("drawing.no-lines", count=count, entities=[f"{count} surface"])


def _remove_surfaces(data: bytes, offset: int, depth: int) -> tuple[bytes | None, int, int]:
    """Return a shape without surfaces (None if it is one), its end, and their number.

    Raises ValueError if the data are not valid WKB.
    """
    if depth > _MAX_DEPTH or offset >= len(data) or data[offset] > 1:
        raise ValueError("not WKB")
    byte_order = "<" if data[offset] else ">"
    (code,) = struct.unpack_from(f"{byte_order}I", data, offset + 1)
    kind, dimensions = _decode_type(code)
    start, offset = offset, offset + (9 if code & _HAS_SRID else 5)
    if kind == _POINT:
        return data[start : offset + 8 * dimensions], offset + 8 * dimensions, 0
    (count,) = struct.unpack_from(f"{byte_order}I", data, offset)
    offset += 4
    if kind == _LINE:
        end = offset + 8 * dimensions * count
        return data[start:end], end, 0
    if kind in (_POLYGON, 17):
        for _ in range(count):
            (points,) = struct.unpack_from(f"{byte_order}I", data, offset)
            offset += 4 + 8 * dimensions * points
        is_surface = kind != _POLYGON
        return None if is_surface else data[start:offset], offset, int(is_surface)
    if kind not in (*_MULTI, *_SURFACES):
        raise ValueError(f"unknown type {kind}")
    members, n_surfaces = [], 0
    for _ in range(count):
        member, offset, surface_count = _remove_surfaces(data, offset, depth + 1)
        members += [] if member is None else [member]
        n_surfaces += surface_count
    if kind in _SURFACES:
        return None, offset, 1
    header = data[start : start + (9 if code & _HAS_SRID else 5)]
    return (
        header + struct.pack(f"{byte_order}I", len(members)) + b"".join(members),
        offset,
        n_surfaces,
    )


def _decode_type(code: int) -> tuple[int, int]:
    """Return the type and number of dimensions of an ISO or EWKB type code."""
    thousands, kind = divmod(code & 0x1FFFFFFF, 1000)
    has_z = bool(code & _HAS_Z) or thousands in (1, 3)
    has_m = bool(code & _HAS_M) or thousands in (2, 3)
    return kind, 2 + has_z + has_m
