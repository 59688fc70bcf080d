"""Decoding of single LAS points according to the LAS 1.4 specification (R15)."""

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
from vomstudio.io.models.formats._common import to_uint8_colors
from vomstudio.io.models.formats._las_header import LasHeader

_XYZ = [("X", "<i4"), ("Y", "<i4"), ("Z", "<i4"), ("intensity", "<u2"), ("returns", "u1")]
_LEGACY_FIELDS = [*_XYZ, ("class", "u1"), ("angle", "i1"), ("user", "u1"), ("source", "<u2")]
_MODERN_FIELDS = [
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
_WAVE_PACKET = [("wave", "V29")]
_FORMATS: dict[int, list[Any]] = {
    0: _LEGACY_FIELDS,
    1: _LEGACY_FIELDS + _TIME,
    2: _LEGACY_FIELDS + _RGB,
    3: _LEGACY_FIELDS + _TIME + _RGB,
    4: _LEGACY_FIELDS + _TIME + _WAVE_PACKET,
    5: _LEGACY_FIELDS + _TIME + _RGB + _WAVE_PACKET,
    6: _MODERN_FIELDS,
    7: _MODERN_FIELDS + _RGB,
    8: _MODERN_FIELDS + _RGB + _NIR,
    9: _MODERN_FIELDS + _WAVE_PACKET,
    10: _MODERN_FIELDS + _RGB + _NIR + _WAVE_PACKET,
}
_EXTRA_TYPES = ["u1", "i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f4", "<f8"]
_EXTRA_BYTES = 192
# Used only if the values are not all 0.
STANDARD_FIELDS = ("intensity", "classification", "return_number", "gps_time")


@dataclass(frozen=True, eq=False)
class RecordLayout:
    """Layout of the records in one file.

    `extra_fields` maps names to (scale, offset) if values are stored as scaled integers. `no_data`
    contains the stored values that represent missing values of extra fields, as in
    `read_no_data_values`.
    """

    kind: np.dtype[Any]
    is_extended_format: bool
    extra_fields: dict[str, tuple[float, float] | None]
    no_data: dict[str, tuple[float, ...]]


def record_layout(header: LasHeader, path: Path) -> RecordLayout:
    """Return the layout of the records. Raises InputError for an unknown format."""
    fields = _FORMATS.get(header.point_format)
    if fields is None or np.dtype(fields).itemsize > header.record_bytes:
        raise InputError(
            Finding(
                "model.unsupported", feature=tr("point format {number}", number=header.point_format)
            ),
            file=path,
            field="LAS header",
        )
    columns = list(fields)
    extra_fields: dict[str, tuple[float, float] | None] = {}
    remaining_bytes = header.record_bytes - np.dtype(fields).itemsize
    record = header.records.get(("LASF_Spec", 4), b"")
    for position in range(0, len(record) - _EXTRA_BYTES + 1, _EXTRA_BYTES):
        data_type, options = record[position + 2], record[position + 3]
        name = record[position + 4 : position + 36].split(b"\0")[0].decode("utf-8", "replace")
        used_names = {column[0] for column in columns} | set(STANDARD_FIELDS)
        if not 1 <= data_type <= len(_EXTRA_TYPES) or not name or name in used_names:
            break
        kind = _EXTRA_TYPES[data_type - 1]
        width = np.dtype(kind).itemsize
        if width > remaining_bytes:
            break
        remaining_bytes -= width
        columns.append((name, kind))
        (scale,) = struct.unpack_from("<d", record, position + 112)
        (offset,) = struct.unpack_from("<d", record, position + 136)
        has_scaling = options & 0b11000
        extra_fields[name] = (
            (scale if options & 0b1000 else 1.0, offset if options & 0b10000 else 0.0)
            if has_scaling
            else None
        )
    if remaining_bytes:
        columns.append((" rest", f"V{remaining_bytes}"))
    return RecordLayout(
        np.dtype(columns), header.point_format >= 6, extra_fields, read_no_data_values(record)
    )


def read_no_data_values(record: bytes) -> dict[str, tuple[float, ...]]:
    """Return the "no data" values of each field that declares them in the extra bytes record.

    There is one value per component, as stored (before applying scale and offset).
    """
    no_data: dict[str, tuple[float, ...]] = {}
    for offset in range(0, len(record) - _EXTRA_BYTES + 1, _EXTRA_BYTES):
        data_type, options = record[offset + 2], record[offset + 3]
        name = record[offset + 4 : offset + 36].split(b"\0")[0].decode("utf-8", "replace")
        if not options & 1 or not 1 <= data_type <= 3 * len(_EXTRA_TYPES):
            continue
        component_index, type_index = divmod(data_type - 1, len(_EXTRA_TYPES))
        format_code = {"u": "Q", "i": "q", "f": "d"}[_EXTRA_TYPES[type_index][-2]]
        no_data.setdefault(
            name, struct.unpack_from(f"<{component_index + 1}{format_code}", record, offset + 40)
        )
    return no_data


def mask_no_data(values: AnyArray, stored_array: AnyArray, no_data: tuple[float, ...]) -> AnyArray:
    """Return floats (n,) or (n, k), NaN where the stored value means "no data"."""
    kind = stored_array.dtype
    is_no_data = np.zeros(stored_array.shape, bool)
    for k, no_data_value in enumerate(
        no_data[: 1 if stored_array.ndim == 1 else stored_array.shape[1]]
    ):
        column = stored_array if stored_array.ndim == 1 else stored_array[:, k]
        is_gap = (
            np.isnan(column)
            if no_data_value != no_data_value
            else column == np.array(no_data_value).astype(kind)
        )
        is_no_data[(...,) if stored_array.ndim == 1 else (slice(None), k)] = is_gap
    floats = np.array(values, np.float32 if values.dtype == np.float32 else np.float64)
    floats[is_no_data] = np.nan
    return floats


def replacement_rows(is_withheld: AnyArray) -> AnyArray | None:
    """Return rows (n,) that replace each withheld point by the previous valid point.

    Points before the first valid point are replaced by that point. This is for files whose rows
    must keep their numbers. Returns None if no point or every point is withheld.
    """
    if not is_withheld.any() or is_withheld.all():
        return None
    rows = np.where(is_withheld, -1, np.arange(len(is_withheld)))
    rows = np.maximum.accumulate(rows)
    return np.where(rows < 0, np.flatnonzero(~is_withheld)[0], rows)


def withheld_mask(records: AnyArray, layout: RecordLayout) -> AnyArray:
    """Return a mask (n,) of the points marked as withheld (LAS 1.4 R15, tables 8 and 16)."""
    is_withheld: AnyArray = (
        (records["flags"] & 0x04) != 0
        if layout.is_extended_format
        else (records["class"] & 0x80) != 0
    )
    return is_withheld


@dataclass(frozen=True)
class FieldSelection:
    """Selected parts of the records.

    They are the same for all pieces of a file so that the pieces can be joined.

    `has_wide_colors` states whether the colours use all 16 bits.
    """

    has_colors: bool
    has_wide_colors: bool
    fields: tuple[str, ...]


def choose_fields(records: AnyArray, layout: RecordLayout) -> FieldSelection:
    """Select colours if there are any, standard fields with values, and extra fields.

    A standard field is omitted if it is 0 everywhere, and the return number also if it is 1
    everywhere. `records` is a sample of the records in the file.
    """
    names = layout.kind.names or ()
    max_color = max(
        (
            int(records[color].max(initial=0))
            for color in ("red", "green", "blue")
            if color in names
        ),
        default=0,
    )
    fields = []
    for name in STANDARD_FIELDS:
        values = _field(records, layout, name)
        is_uninformative = (
            values is None or not values.any() or (name == "return_number" and values.max() == 1)
        )
        if not is_uninformative:
            fields.append(name)
    return FieldSelection(max_color > 0, max_color > 255, (*fields, *layout.extra_fields))


def build_cloud(
    records: AnyArray, layout: RecordLayout, header: LasHeader, selection: FieldSelection
) -> PointCloud:
    rows = replacement_rows(withheld_mask(records, layout))
    if rows is not None:
        records = records[rows]
    points = np.empty((len(records), 3))
    for j, axis in enumerate("XYZ"):
        np.multiply(records[axis], header.scales[j], out=points[:, j])
        points[:, j] += header.offsets[j]
    colors = None
    if selection.has_colors:
        colors = np.empty((len(records), 3), np.uint8)
        for j, channel in enumerate(("red", "green", "blue")):
            width = records[channel]
            colors[:, j] = width >> 8 if selection.has_wide_colors else to_uint8_colors(width)
    fields = {}
    for name in selection.fields:
        values = _field(records, layout, name)
        if values is not None:
            fields[name] = values
    return PointCloud(points, colors, None, fields)


def _field(records: AnyArray, layout: RecordLayout, name: str) -> AnyArray | None:
    if name == "classification":
        return records["class"] & (0xFF if layout.is_extended_format else 0x1F)
    if name == "return_number":
        return records["returns"] & (0x0F if layout.is_extended_format else 0x07)
    if name not in (layout.kind.names or ()):
        return None
    values: AnyArray = np.ascontiguousarray(records[name])
    scaling = layout.extra_fields.get(name)
    scaled_array = values if scaling is None else values * scaling[0] + scaling[1]
    if name in layout.no_data:
        return mask_no_data(scaled_array, values, layout.no_data[name])
    return scaled_array
