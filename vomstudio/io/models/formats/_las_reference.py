"""Coordinate reference system of a LAS, LAZ or COPC file.

It is stored as WKT or GeoTIFF keys in the variable length records, or in the extended records after
the points (LAS 1.4 R15).
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gis.axis_units import StatedAxes, stated_axes, unit_text
from vomstudio.io.gis.geo_keys import Keys, decode_keys
from vomstudio.io.models.reader import Reference
from vomstudio.io.text.encodings import convert_to_utf8

_WKT, _DIRECTORY, _DOUBLES, _TEXTS = 2112, 34735, 34736, 34737
MAX_RECORD_BYTES = 1_000_000
MAX_RECORDS = 1000
_WKT_BIT, _FIRST_FORMAT_WITH_WKT = 0x10, 6
MAX_DEVIATION_DEG = 1e-4
"""About ten metres, which is more than the difference between nearly equal datums."""


def las_reference(path: Path) -> Reference:
    """Return the reference (WKT or keys) selected by the header, or else the readable one.

    A difference between the two is reported (LAS 1.4 R15, global encoding). If the selected
    reference does not define heights, they are taken from the other one. The function never raises
    errors because the points are valid; it reports problems as warnings.
    """
    try:
        records, has_wkt_priority, centre = _records(path)
    except (OSError, struct.error, IndexError):
        return Reference()
    read_errors: list[str] = []
    references = [
        reference
        for reference in (
            _wkt_reference(records, read_errors),
            _keys_reference(records, read_errors),
        )
        if reference is not None
    ]
    if not references:
        return Reference(
            warnings=tuple(Finding("frame.crs-unreadable", crs=text) for text in read_errors[:1])
        )
    if len(references) == 1:
        return references[0]
    first_reference, second_reference = references if has_wkt_priority else reversed(references)
    return _combine(first_reference, second_reference, centre)


def _wkt_reference(records: Mapping[int, bytes], read_errors: list[str]) -> Reference | None:
    text = convert_to_utf8(records.get(_WKT, b"")).decode("utf-8", "replace").strip("\0 \r\n\t")
    try:
        stated_axes(text)
    except InputError:
        read_errors.append(" ".join(text.split())[:80])
        return None
    return Reference(text) if text else None


def _keys_reference(records: Mapping[int, bytes], read_errors: list[str]) -> Reference | None:
    keys = Keys(*(records.get(record_id, b"") for record_id in (_DIRECTORY, _DOUBLES, _TEXTS)))
    try:
        reference = decode_keys(keys)
    except InputError:
        read_errors.append("GeoTIFF")
        return None
    if reference.crs is None and reference.height_unit is None and not reference.warnings:
        return None
    return Reference(reference.crs, reference.height_unit, reference.warnings)


def _combine(
    first_reference: Reference, second_reference: Reference, centre: tuple[float, float]
) -> Reference:
    if first_reference.text is None:
        first_reference, second_reference = second_reference, first_reference
    first_axes, other_axes = (
        stated_axes(reference.text, reference.height_unit)
        for reference in (first_reference, second_reference)
    )
    if (
        not first_axes.has_heights
        and other_axes.has_heights
        and other_axes.units[2] in METRES_PER_UNIT
    ):
        unit = other_axes.units[2]
        first_reference = replace(
            first_reference, height_unit=None if unit == first_axes.units[2] else unit
        )
        first_axes = stated_axes(first_reference.text, first_reference.height_unit)
    has_other_heights = other_axes.has_heights and first_axes.units[2] != other_axes.units[2]
    if second_reference.text is not None and (
        has_other_heights or _are_different(first_axes, other_axes, centre)
    ):
        warning = Finding("frame.two-crs", one=_axes_text(first_axes), other=_axes_text(other_axes))
        first_reference = replace(first_reference, warnings=(*first_reference.warnings, warning))
    return first_reference


def _axes_text(axes: StatedAxes) -> str:
    from pyproj import CRS

    name = tr("one without a position") if axes.crs is None else CRS.from_user_input(axes.crs).name
    units = axes.units if len(set(axes.units)) > 1 else axes.units[:1]
    return f"{name} ({', '.join(map(unit_text, units))})"


def _are_different(
    first_axes: StatedAxes, second_axes: StatedAxes, centre: tuple[float, float]
) -> bool:
    """Return whether the kinds, the units of x and y, or the positions (by 10 m) differ."""
    if first_axes.kind != second_axes.kind or first_axes.units[:2] != second_axes.units[:2]:
        return True
    if first_axes.kind != "projected" or first_axes.crs == second_axes.crs:
        return False
    if first_axes.crs is None or second_axes.crs is None:
        return True
    from pyproj import Proj
    from pyproj.exceptions import ProjError

    try:
        positions = [
            Proj(axes.crs)(*centre, inverse=True, errcheck=True)
            for axes in (first_axes, second_axes)
        ]
    except ProjError:
        return True
    return any(
        abs(first_angle - second_angle) > MAX_DEVIATION_DEG
        for first_angle, second_angle in zip(*positions, strict=True)
    )


def _records(path: Path) -> tuple[dict[int, bytes], bool, tuple[float, float]]:
    """Return the LASF_Projection records by number, whether WKT has priority, and the centre.

    The first record of each number is used; the centre is the x and y of the midpoint of the
    bounds.
    """
    records: dict[int, bytes] = {}
    with open_regular_file(path) as file:
        file_size = file.seek(0, os.SEEK_END)
        file.seek(0)
        header_bytes = file.read(375)
        has_wkt_priority = (
            bool(header_bytes[6] & _WKT_BIT) or (header_bytes[104] & 0x3F) >= _FIRST_FORMAT_WITH_WKT
        )
        east, west, north, south = struct.unpack_from("<4d", header_bytes, 179)
        header_size, _, count = struct.unpack_from("<HII", header_bytes, 94)
        record_areas = [(header_size, count, "<16sHH", 54)]
        if header_bytes[25] >= 4 and len(header_bytes) >= 247:
            start, extended_count = struct.unpack_from("<QI", header_bytes, 235)
            record_areas.append((start, extended_count, "<16sHQ", 60))
        for offset, record_count, record_format, size in record_areas:
            for _ in range(min(record_count, MAX_RECORDS)):
                if offset >= file_size:
                    break
                file.seek(offset)
                header = file.read(size)
                if len(header) < size:
                    break
                user_id, record_id, length = struct.unpack_from(record_format, header, 2)
                if user_id.split(b"\0")[0] == b"LASF_Projection" and length <= MAX_RECORD_BYTES:
                    records.setdefault(record_id, file.read(length))
                offset += size + length
    return records, has_wkt_priority, ((east + west) / 2, (north + south) / 2)
