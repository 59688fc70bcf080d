"""What a LAS, LAZ or COPC file says of its coordinate reference system: WKT, or GeoTIFF keys, in
its variable length records or in the extended ones behind the points (LAS 1.4 R15)."""

from __future__ import annotations

import os
import struct
from pathlib import Path

from vomstudio.errors import InputError
from vomstudio.io.gis.axis_units import stated_axes, unreadable_crs
from vomstudio.io.gis.geo_keys import crs_of_keys, vertical_unit_of_keys
from vomstudio.io.models.reader import Reference

_WKT, _DIRECTORY, _DOUBLES, _TEXTS = 2112, 34735, 34736, 34737
_LONGEST = 1_000_000
_RECORDS_AT_MOST = 1000


def las_reference(path: Path) -> Reference:
    """Never raises for what is wrong there: the points are sound, and the warnings say it."""
    try:
        records = _records(path)
    except (OSError, struct.error):
        return Reference()
    text = records.get(_WKT, b"").strip(b"\0 \r\n\t").decode("utf-8", "replace")
    directory = records.get(_DIRECTORY, b"")
    wrong = ""
    if text:
        try:
            stated_axes(text)
            return Reference(text)
        except InputError:
            wrong = " ".join(text.split())[:80]
    if directory:
        try:
            named = crs_of_keys(directory, records.get(_DOUBLES, b""), records.get(_TEXTS, b""))
            unit = vertical_unit_of_keys(directory)
            return Reference(named, None if unit == stated_axes(named).units[2] else unit)
        except InputError:
            wrong = "GeoTIFF"
    return Reference(warnings=(unreadable_crs(wrong),) if wrong else ())


def _records(path: Path) -> dict[int, bytes]:
    """The contents of the records of LASF_Projection by number; the first of each."""
    found: dict[int, bytes] = {}
    with open(path, "rb") as file:
        size_of_file = file.seek(0, os.SEEK_END)
        file.seek(0)
        head = file.read(375)
        header_size, _, count = struct.unpack_from("<HII", head, 94)
        places = [(header_size, count, "<16sHH", 54)]
        if head[25] >= 4 and len(head) >= 247:
            start, extended = struct.unpack_from("<QI", head, 235)
            places.append((start, extended, "<16sHQ", 60))
        for at, number, form, size in places:
            for _ in range(min(number, _RECORDS_AT_MOST)):
                if at >= size_of_file:
                    break
                file.seek(at)
                top = file.read(size)
                if len(top) < size:
                    break
                user, record, length = struct.unpack_from(form, top, 2)
                if user.split(b"\0")[0] == b"LASF_Projection" and length <= _LONGEST:
                    found.setdefault(record, file.read(length))
                at += size + length
    return found
