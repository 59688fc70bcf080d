"""What a LAS, LAZ or COPC file says of its coordinate reference system: WKT, or GeoTIFF keys, in
its variable length records or in the extended ones behind the points (LAS 1.4 R15)."""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.units import METRES
from vomstudio.io.gis.axis_units import StatedAxes, stated_axes, unit_text
from vomstudio.io.gis.geo_keys import Keys, decode_keys
from vomstudio.io.models.reader import Reference
from vomstudio.io.text.encodings import convert_to_utf8

_WKT, _DIRECTORY, _DOUBLES, _TEXTS = 2112, 34735, 34736, 34737
_LONGEST = 1_000_000
_RECORDS_AT_MOST = 1000
_WKT_BIT, _FIRST_FORMAT_WITH_WKT = 0x10, 6
_SAME_PLACE_DEG = 1e-4
"""Some ten metres, which is more than what is between nearly equal datums."""


def las_reference(path: Path) -> Reference:
    """Of WKT and keys the one that the header names (LAS 1.4 R15, global encoding), else the one
    that can be read; where both are there and differ, that is said. What the other states of
    heights is taken where the first says nothing of them. Never raises for what is wrong there: the
    points are sound, and the warnings say it."""
    try:
        records, by_wkt, centre = _records(path)
    except (OSError, struct.error, IndexError):
        return Reference()
    wrong: list[str] = []
    found = [
        reference
        for reference in (_of_wkt(records, wrong), _of_keys(records, wrong))
        if reference is not None
    ]
    if not found:
        return Reference(
            warnings=tuple(Finding("frame.crs-unreadable", crs=one) for one in wrong[:1])
        )
    if len(found) == 1:
        return found[0]
    first, other = found if by_wkt else reversed(found)
    return _joined(first, other, centre)


def _of_wkt(records: Mapping[int, bytes], wrong: list[str]) -> Reference | None:
    text = convert_to_utf8(records.get(_WKT, b"")).decode("utf-8", "replace").strip("\0 \r\n\t")
    try:
        stated_axes(text)
    except InputError:
        wrong.append(" ".join(text.split())[:80])
        return None
    return Reference(text) if text else None


def _of_keys(records: Mapping[int, bytes], wrong: list[str]) -> Reference | None:
    keys = Keys(*(records.get(number, b"") for number in (_DIRECTORY, _DOUBLES, _TEXTS)))
    try:
        named = decode_keys(keys)
    except InputError:
        wrong.append("GeoTIFF")
        return None
    if named.crs is None and named.height_unit is None and not named.warnings:
        return None
    return Reference(named.crs, named.height_unit, named.warnings)


def _joined(first: Reference, other: Reference, centre: tuple[float, float]) -> Reference:
    if first.text is None:
        first, other = other, first
    ours, theirs = (stated_axes(one.text, one.height_unit) for one in (first, other))
    if not ours.has_heights and theirs.has_heights and theirs.units[2] in METRES:
        unit = theirs.units[2]
        first = replace(first, height_unit=None if unit == ours.units[2] else unit)
        ours = stated_axes(first.text, first.height_unit)
    heights = theirs.has_heights and ours.units[2] != theirs.units[2]
    if other.text is not None and (heights or _differ(ours, theirs, centre)):
        warning = Finding("frame.two-crs", one=_axes_text(ours), other=_axes_text(theirs))
        first = replace(first, warnings=(*first.warnings, warning))
    return first


def _axes_text(axes: StatedAxes) -> str:
    from pyproj import CRS

    name = tr("one without a place") if axes.crs is None else CRS.from_user_input(axes.crs).name
    units = axes.units if len(set(axes.units)) > 1 else axes.units[:1]
    return f"{name} ({', '.join(map(unit_text, units))})"


def _differ(one: StatedAxes, other: StatedAxes, centre: tuple[float, float]) -> bool:
    """Whether x and y are in other units, or mean places that are not within some metres."""
    if one.kind != other.kind or one.units[:2] != other.units[:2]:
        return True
    if one.kind != "projected" or one.crs == other.crs:
        return False
    if one.crs is None or other.crs is None:
        return True
    from pyproj import Proj
    from pyproj.exceptions import ProjError

    try:
        places = [Proj(axes.crs)(*centre, inverse=True, errcheck=True) for axes in (one, other)]
    except ProjError:
        return True
    return any(abs(a - b) > _SAME_PLACE_DEG for a, b in zip(*places, strict=True))


def _records(path: Path) -> tuple[dict[int, bytes], bool, tuple[float, float]]:
    """The contents of the records of LASF_Projection by number, the first of each; whether the
    header says that WKT counts; and x and y of the middle of the points."""
    found: dict[int, bytes] = {}
    with open_regular(path) as file:
        size_of_file = file.seek(0, os.SEEK_END)
        file.seek(0)
        head = file.read(375)
        by_wkt = bool(head[6] & _WKT_BIT) or (head[104] & 0x3F) >= _FIRST_FORMAT_WITH_WKT
        east, west, north, south = struct.unpack_from("<4d", head, 179)
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
    return found, by_wkt, ((east + west) / 2, (north + south) / 2)
