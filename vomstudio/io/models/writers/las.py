"""Writer of LAS 1.4 and LAZ files."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray, Int32Array
from vomstudio.core.errors import Cancelled
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.las_library import import_laspy
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.models.writers._common import (
    field_names,
    model_positions,
    report_unwritten_faces,
    step_rows,
)

MAX_INTEGER = 2**31 - 1
# For coordinates without a finite number of decimals: float noise or computed values.
DEFAULT_SCALE = 1e-5
# Fields with a standard position in every point, and their types.
STANDARD_TYPES = {
    "intensity": np.uint16,
    "classification": np.uint8,
    "gps_time": np.float64,
    "user_data": np.uint8,
    "point_source_id": np.uint16,
}
NAME_BYTES = 32
SAMPLE_POINTS = 1000


def write(request: WriteRequest) -> list[Finding]:
    """Write a model as LAS or LAZ.

    The scale of the integers preserves the coordinates; the CRS is stored as WKT; colours have 16
    bits; fields are stored as standard fields or as extra dimensions with their own types.
    """
    laspy = import_laspy()

    findings: list[Finding] = []
    data = request.data
    report_unwritten_faces(data, findings)
    points = model_positions(data)
    axes = [quantise_axis(points[:, k]) for k in range(3)]
    offsets, scales = (
        np.array([axis.offset for axis in axes]),
        np.array([axis.scale for axis in axes]),
    )
    rounding = max(axis.rounding for axis in axes)
    if rounding > 1e-9 * max(1.0, float(np.abs(data.bounds).max()) * 1e-6):
        findings.append(Finding("model.positions-rounded", rounding_mm=scales.max() * 1000))
    header = laspy.LasHeader(version="1.4", point_format=7 if data.colors is not None else 6)
    header.scales, header.offsets = scales, offsets
    columns = _columns(data, header, findings)
    if request.crs is not None:
        from pyproj import CRS

        header.add_crs(CRS.from_user_input(request.crs))
    is_compressed = request.path.suffix.lower() == ".laz"
    with (
        atomic_write(request.path, request.force) as temporary,
        _preserve_errors(temporary) as file,
        laspy.open(
            file,
            mode="w",
            header=header,
            do_compress=is_compressed,
            laz_backend=laspy.LazBackend.LazrsParallel if is_compressed else None,
            closefd=False,
        ) as writer,
    ):
        for rows in step_rows(len(points), request, tr("Writing points")):
            record = laspy.ScaleAwarePointRecord.zeros(rows.stop - rows.start, header=header)
            record.X, record.Y, record.Z = (axis.integers[rows] for axis in axes)
            if data.colors is not None:
                colors_16_bit = data.colors[rows].astype(np.uint16) * 257
                record.red, record.green, record.blue = colors_16_bit.T
            record.return_number[:] = 1
            record.number_of_returns[:] = 1
            for name, values in columns:
                record[name] = values[rows]
            writer.write_points(record)
    return findings


class _ErrorRecordingFile(io.FileIO):
    """File that records the reason why a write failed.

    The compressor reports only that writing failed.
    """

    failure: OSError | None = None

    def write(self, content: Any) -> int:
        remaining_bytes = memoryview(content).cast("B")
        try:
            while remaining_bytes:
                remaining_bytes = remaining_bytes[super().write(remaining_bytes) :]
        except OSError as error:
            self.failure = error
            raise
        return memoryview(content).nbytes


@contextlib.contextmanager
def _preserve_errors(path: Path) -> Iterator[_ErrorRecordingFile]:
    with _ErrorRecordingFile(path, "w+") as file:
        try:
            yield file
        except Cancelled:
            raise
        except BaseException as error:
            if file.failure is not None and file.failure is not error:
                raise file.failure from error
            raise


@dataclass(frozen=True, eq=False)
class QuantisedAxis:
    """Coordinates (n,) along one axis as integers: integers * scale + offset.

    `rounding` is the largest difference from the coordinates.
    """

    offset: float
    scale: float
    integers: Int32Array
    rounding: float


def quantise_axis(values: FloatArray) -> QuantisedAxis:
    """Convert coordinates (n,) to integers that preserve them if possible.

    The scale is the coarsest power of ten from 1e-3 to 1e-9 that preserves them with an integer
    offset, or with the first point as offset (for files whose offset was not an integer).
    Otherwise, it is `DEFAULT_SCALE`, or the smallest larger power of ten that the extent allows.

    Parameters
    ----------
    values : (n,) ndarray

    Returns
    -------
    QuantisedAxis
    """
    low, high = float(values.min()), float(values.max())
    centre = float(np.floor((low + high) / 2))
    ulp = 4 * np.spacing(max(abs(low), abs(high), 1e-300))
    # A few points suffice to exclude most scales.
    sample = values[:: max(1, len(values) // SAMPLE_POINTS)]
    for power in range(3, 10):
        scale = float(f"1e-{power}")
        for offset in (centre, float(values[0])):
            if max(high - offset, offset - low) / scale > MAX_INTEGER:
                continue
            if _quantise_at_scale(sample, offset, scale).rounding > ulp:
                continue
            axis = _quantise_at_scale(values, offset, scale)
            if axis.rounding <= ulp:
                return axis
    scale = DEFAULT_SCALE
    while max(high - centre, centre - low) / scale > MAX_INTEGER:
        scale *= 10
    return _quantise_at_scale(values, centre, float(f"{scale:.0e}"))


def _quantise_at_scale(values: FloatArray, offset: float, scale: float) -> QuantisedAxis:
    offsets = values - offset
    offsets /= scale
    np.rint(offsets, out=offsets)
    integers = offsets.astype(np.int32)
    offsets *= scale
    offsets += offset
    offsets -= values
    # The largest and the smallest value need no further array.
    return QuantisedAxis(offset, scale, integers, float(max(offsets.max(), -offsets.min())))


def _columns(
    data: Mesh | PointCloud, header: Any, findings: list[Finding]
) -> list[tuple[str, AnyArray]]:
    laspy = import_laspy()

    columns: list[tuple[str, AnyArray]] = []
    extra_fields: dict[str, AnyArray] = {}
    for name, values in data.fields.items():
        kind = STANDARD_TYPES.get(name)
        if kind is not None and _can_store(values, kind):
            columns.append((name, values.astype(kind)))
        elif (
            name == "return_number" and _can_store(values, np.uint8) and values.max(initial=0) < 16
        ):
            columns.append((name, values.astype(np.uint8)))
            columns.append(("number_of_returns", np.maximum(values, 1).astype(np.uint8)))
        else:
            extra_fields[name] = values
    if isinstance(data, PointCloud) and data.normals is not None:
        findings.append(Finding("model.normals-as-fields"))
        for k, axis in enumerate("xyz"):
            extra_fields.setdefault(f"normal_{axis}", data.normals[:, k])
    short_fields = _short_names(extra_fields, findings)
    names = field_names(short_fields, header.point_format.dimension_names, findings)
    extra_columns = []
    for name, label in names.items():
        values = short_fields[name]
        replacements: dict[str, Any] = {"?": np.dtype(np.uint8), "e": np.dtype(np.float32)}
        stored_type = replacements.get(values.dtype.char, values.dtype.newbyteorder("="))
        extra_columns.append(laspy.ExtraBytesParams(label, stored_type))
        columns.append((label, values.astype(stored_type)))
    if extra_columns:
        header.add_extra_dims(extra_columns)
    return columns


def _can_store(values: AnyArray, kind: Any) -> bool:
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        return bool(np.dtype(kind).kind == "f")
    with np.errstate(all="ignore"):
        return bool((values.astype(kind).astype(values.dtype) == values).all())


def _short_names(fields: dict[str, AnyArray], findings: list[Finding]) -> dict[str, AnyArray]:
    """Shorten names to 24 bytes, so that suffixes fit in the 32 bytes of the format."""
    result: dict[str, AnyArray] = {}
    for name, values in fields.items():
        short_name = name.encode()[: NAME_BYTES - 8].decode(errors="ignore")
        label = name if len(name.encode()) <= NAME_BYTES - 8 else short_name
        suffix = 2
        while label in result or (label != name and label in fields):
            label, suffix = f"{short_name}_{suffix}", suffix + 1
        if label != name:
            findings.append(Finding("model.field-renamed", field=name, new=label))
        result[label] = values
    return result


WRITER = Writer(to_translate("LAS/LAZ point cloud"), (".las", ".laz"), write)
