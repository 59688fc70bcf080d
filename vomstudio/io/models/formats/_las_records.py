"""The bytes of single LAS points, by the tables of the LAS 1.4 specification (R15)."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.formats._common import scale_colors
from vomstudio.io.models.formats._las_header import Top

_XYZ = [("X", "<i4"), ("Y", "<i4"), ("Z", "<i4"), ("intensity", "<u2"), ("returns", "u1")]
_OLD = [*_XYZ, ("class", "u1"), ("angle", "i1"), ("user", "u1"), ("source", "<u2")]
_NEW = [
    *_XYZ,
    ("flags", "u1"),
    ("class", "u1"),
    ("user", "u1"),
    ("angle", "<i2"),
    ("source", "<u2"),
    ("gps_time", "<f8"),
]
_TIME = [("gps_time", "<f8")]
_RGB = [("red", "<u2"), ("green", "<u2"), ("blue", "<u2")]
_NIR = [("nir", "<u2")]
_WAVE = [("wave", "V29")]
_FORMATS: dict[int, list[Any]] = {
    0: _OLD,
    1: _OLD + _TIME,
    2: _OLD + _RGB,
    3: _OLD + _TIME + _RGB,
    4: _OLD + _TIME + _WAVE,
    5: _OLD + _TIME + _RGB + _WAVE,
    6: _NEW,
    7: _NEW + _RGB,
    8: _NEW + _RGB + _NIR,
    9: _NEW + _WAVE,
    10: _NEW + _RGB + _NIR + _WAVE,
}
_EXTRA = ["u1", "i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f4", "<f8"]
_EXTRA_BYTES = 192
# Kept where they say something, that is, are not 0 everywhere.
STANDARD_FIELDS = ("intensity", "classification", "return_number", "gps_time")


@dataclass(frozen=True, eq=False)
class Layout:
    """How the records of one file are read.

    extra : name, and (scale, offset) where the values are stored as integers of a scale
    no_data : what is stored of an extra field where it has no value, as `no_data_of` gives it
    """

    kind: np.dtype[Any]
    new: bool
    extra: dict[str, tuple[float, float] | None]
    no_data: dict[str, tuple[float, ...]]


def layout_of(top: Top, path: Path) -> Layout:
    """Raises InputError for a format that is not known."""
    known = _FORMATS.get(top.point_format)
    if known is None or np.dtype(known).itemsize > top.record_bytes:
        raise InputError(
            Finding(
                "model.unsupported", feature=tr("point format {number}", number=top.point_format)
            ),
            file=path,
            field="LAS header",
        )
    columns = list(known)
    extra: dict[str, tuple[float, float] | None] = {}
    left = top.record_bytes - np.dtype(known).itemsize
    record = top.records.get(("LASF_Spec", 4), b"")
    for at in range(0, len(record) - _EXTRA_BYTES + 1, _EXTRA_BYTES):
        number, options = record[at + 2], record[at + 3]
        name = record[at + 4 : at + 36].split(b"\0")[0].decode("utf-8", "replace")
        taken = {column[0] for column in columns} | set(STANDARD_FIELDS)
        if not 1 <= number <= len(_EXTRA) or not name or name in taken:
            break
        kind = _EXTRA[number - 1]
        width = np.dtype(kind).itemsize
        if width > left:
            break
        left -= width
        columns.append((name, kind))
        (scale,) = struct.unpack_from("<d", record, at + 112)
        (offset,) = struct.unpack_from("<d", record, at + 136)
        scaled = options & 0b11000
        extra[name] = (
            (scale if options & 0b1000 else 1.0, offset if options & 0b10000 else 0.0)
            if scaled
            else None
        )
    if left:
        columns.append((" rest", f"V{left}"))
    return Layout(np.dtype(columns), top.point_format >= 6, extra, no_data_of(record))


def no_data_of(record: bytes) -> dict[str, tuple[float, ...]]:
    """Of the record of extra bytes: what stands for "no value" in each field that says so, for each
    of its components, as it is stored (before scale and offset)."""
    found: dict[str, tuple[float, ...]] = {}
    for at in range(0, len(record) - _EXTRA_BYTES + 1, _EXTRA_BYTES):
        number, options = record[at + 2], record[at + 3]
        name = record[at + 4 : at + 36].split(b"\0")[0].decode("utf-8", "replace")
        if not options & 1 or not 1 <= number <= 3 * len(_EXTRA):
            continue
        several, which = divmod(number - 1, len(_EXTRA))
        form = {"u": "Q", "i": "q", "f": "d"}[_EXTRA[which][-2]]
        found.setdefault(name, struct.unpack_from(f"<{several + 1}{form}", record, at + 40))
    return found


def without_no_data(values: AnyArray, stored: AnyArray, no_data: tuple[float, ...]) -> AnyArray:
    """(n,) or (n, k) floats with NaN where what is stored means that there is none."""
    kind = stored.dtype
    gaps = np.zeros(stored.shape, bool)
    for k, nothing in enumerate(no_data[: 1 if stored.ndim == 1 else stored.shape[1]]):
        column = stored if stored.ndim == 1 else stored[:, k]
        gap = np.isnan(column) if nothing != nothing else column == np.array(nothing).astype(kind)
        gaps[(...,) if stored.ndim == 1 else (slice(None), k)] = gap
    wide = np.array(values, np.float32 if values.dtype == np.float32 else np.float64)
    wide[gaps] = np.nan
    return wide


def stand_ins(withheld: AnyArray) -> AnyArray | None:
    """(n,) rows in which each withheld point is the sound one before it, for files whose rows must
    keep their numbers; None where nothing is to be done, or nothing is sound."""
    if not withheld.any() or withheld.all():
        return None
    rows = np.where(withheld, -1, np.arange(len(withheld)))
    rows = np.maximum.accumulate(rows)
    return np.where(rows < 0, np.flatnonzero(~withheld)[0], rows)


def withheld_of(records: AnyArray, layout: Layout) -> AnyArray:
    """(n,) which points the file marks as not to be used (LAS 1.4 R15, tables 8 and 16)."""
    flagged: AnyArray = (
        (records["flags"] & 0x04) != 0 if layout.new else (records["class"] & 0x80) != 0
    )
    return flagged


@dataclass(frozen=True)
class Choice:
    """What of the records is shown; the same for all pieces of a file, so that they can be joined.

    wide_colors : whether they use all of their 16 bits
    """

    colors: bool
    wide_colors: bool
    fields: tuple[str, ...]


def choose(records: AnyArray, layout: Layout) -> Choice:
    """From a sample: colours where there are any, standard fields that are not 0 everywhere, and
    all extra ones."""
    names = layout.kind.names or ()
    top = max(
        (int(records[c].max(initial=0)) for c in ("red", "green", "blue") if c in names), default=0
    )
    fields = []
    for name in STANDARD_FIELDS:
        values = _field(records, layout, name)
        idle = values is None or not values.any() or (name == "return_number" and values.max() == 1)
        if not idle:
            fields.append(name)
    return Choice(top > 0, top > 255, (*fields, *layout.extra))


def cloud_of(records: AnyArray, layout: Layout, top: Top, choice: Choice) -> PointCloud:
    rows = stand_ins(withheld_of(records, layout))
    if rows is not None:
        records = records[rows]
    points = np.empty((len(records), 3))
    for j, axis in enumerate("XYZ"):
        np.multiply(records[axis], top.scales[j], out=points[:, j])
        points[:, j] += top.offsets[j]
    colors = None
    if choice.colors:
        colors = np.empty((len(records), 3), np.uint8)
        for j, channel in enumerate(("red", "green", "blue")):
            wide = records[channel]
            colors[:, j] = wide >> 8 if choice.wide_colors else scale_colors(wide)
    fields = {}
    for name in choice.fields:
        values = _field(records, layout, name)
        if values is not None:
            fields[name] = values
    return PointCloud(points, colors, None, fields)


def _field(records: AnyArray, layout: Layout, name: str) -> AnyArray | None:
    if name == "classification":
        return records["class"] & (0xFF if layout.new else 0x1F)
    if name == "return_number":
        return records["returns"] & (0x0F if layout.new else 0x07)
    if name not in (layout.kind.names or ()):
        return None
    values: AnyArray = np.ascontiguousarray(records[name])
    scaling = layout.extra.get(name)
    shown = values if scaling is None else values * scaling[0] + scaling[1]
    if name in layout.no_data:
        return without_no_data(shown, values, layout.no_data[name])
    return shown
