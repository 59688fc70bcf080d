"""LAS and LAZ point clouds, read with laspy and lazrs."""

from __future__ import annotations

import io
import logging
import struct
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import ByteArray, GenericArray
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.formats._common import (
    Columns,
    drop_invalid_points,
    missing_points_finding,
    to_uint8_colors,
)
from vomstudio.io.models.formats._las_extra import FileWithHiddenRecord, invalid_extra_record_offset
from vomstudio.io.models.formats._las_header import (
    check_header,
    check_layers,
    is_copc,
    is_layered,
    read_las_header,
    refuse_blank,
    replace_chunk_table,
)
from vomstudio.io.models.formats._las_records import (
    STANDARD_FIELDS,
    mask_no_data,
    read_no_data_values,
    replacement_rows,
)
from vomstudio.io.models.formats._las_reference import las_reference
from vomstudio.io.models.las_library import import_laspy
from vomstudio.io.models.reader import LoadedModel, Reader

POINTS_PER_STEP = 500_000
MAX_INITIAL_ROWS = 50_000_000
POINTS_PER_CAREFUL_STEP = 200

# laspy also logs the errors it raises; without a handler, Python would print them.
logging.getLogger("laspy").addHandler(logging.NullHandler())


def matches(path: Path, head: bytes) -> bool:
    """Return whether a file begins like a LAS file."""
    return head.startswith(b"LASF")


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read the points of a LAS or LAZ file.

    Coordinates are float64, computed from the integers, scale and offset of the file.

    Colours have 8 bits; the fields are those standard fields that are not 0 everywhere, and all
    extra fields. The CRS is that of the file. For a truncated file, the available points are
    returned with a warning. Raises InputError if the file is damaged or contains no points.
    """
    laspy = import_laspy()
    import lazrs

    findings: list[Finding] = []
    size = check_header(path)
    try:
        cloud = _read(path, size, progress, findings)
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
        raise _damage_error(path, error) from error
    except BaseException as error:
        # Rust panics are not derived from Exception.
        if type(error).__name__ != "PanicException":
            raise
        raise _damage_error(path, error) from error
    reference = las_reference(path)
    cloud = drop_invalid_points(cloud, findings, path)
    return LoadedModel(
        cloud,
        "cloud",
        reference.text,
        (*findings, *reference.warnings),
        path,
        height_unit=reference.height_unit,
    )


def _damage_error(path: Path, error: BaseException) -> InputError:
    return InputError(
        Finding("file.damaged", reason=_short_message(error), format="LAS"), file=path
    )


def _short_message(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text[:160] or type(error).__name__


def _read(path: Path, size: int, progress: Progress, findings: list[Finding]) -> PointCloud:
    laspy = import_laspy()

    stream: Any = replace_chunk_table(path, size)
    refuse_blank(path, progress)
    if is_layered(path):
        check_layers(path, read_las_header(path))
    record_offset = invalid_extra_record_offset(path)
    if record_offset is not None and stream is None:
        findings.append(Finding("model.fields-damaged"))
        stream = io.BufferedReader(FileWithHiddenRecord(path, record_offset))
    if stream is None:
        with (
            open_regular_file(path) as file,
            laspy.open(file, laz_backend=laspy.LazBackend.LazrsParallel, read_evlrs=False) as r,
        ):
            return _read_points(r, path, size, POINTS_PER_STEP, progress, findings)
    with laspy.open(stream, laz_backend=laspy.LazBackend.Lazrs, read_evlrs=False) as reader:
        return _read_points(reader, path, size, POINTS_PER_CAREFUL_STEP, progress, findings)


def _read_points(
    reader: Any, path: Path, size: int, max_points: int, progress: Progress, findings: list[Finding]
) -> PointCloud:
    header = reader.header
    stated_count = int(header.point_count)
    record_bytes = int(header.point_format.size)
    limit = stated_count
    if not header.are_points_compressed:
        limit = min(stated_count, max(0, size - int(header.offset_to_point_data)) // record_bytes)
    scales, offsets = np.asarray(header.scales, float), np.asarray(header.offsets, float)
    if not (np.isfinite(scales).all() and np.isfinite(offsets).all() and (scales != 0).all()):
        raise InputError(
            Finding(
                "file.damaged",
                format="LAS",
                reason=tr("the scale or offset of the coordinates is not valid"),
            ),
            file=path,
            field="LAS header",
        )
    names = set(header.point_format.dimension_names)
    has_valid_extra_record = invalid_extra_record_offset(path) is None
    extra_names = list(header.point_format.extra_dimension_names) if has_valid_extra_record else []
    field_names = [n for n in STANDARD_FIELDS if n in names] + extra_names
    no_data = _no_data_values(header)
    flag_names = ["withheld"] if "withheld" in names else []
    is_colored = {"red", "green", "blue"} <= names
    # Few files have more points than bytes, and unused capacity costs nothing.
    columns = Columns(min(size, MAX_INITIAL_ROWS))
    done_count = 0
    progress.stage(tr("Reading the points"), limit)
    while done_count < limit:
        n = min(max_points, limit - done_count)
        try:
            chunk = reader.read_points(n)
        except Exception:
            # The last points before the end may have been decoded from invalid bytes.
            done_count -= min(done_count, max_points)
            if done_count == 0:
                raise
            break
        read_count = len(chunk)
        if read_count == 0:
            break
        xyz = np.empty((read_count, 3))
        for j, axis in enumerate("XYZ"):
            np.multiply(np.asarray(chunk[axis]), scales[j], out=xyz[:, j])
            xyz[:, j] += offsets[j]
        columns.add("points", xyz, limit)
        if is_colored:
            rgb = np.empty((read_count, 3), np.uint16)
            for j, channel in enumerate(("red", "green", "blue")):
                rgb[:, j] = chunk[channel]
            columns.add("colors", rgb, limit)
        for name in [*field_names, *flag_names]:
            columns.add(f"field {name}", _values(chunk, name, no_data), limit)
        done_count += read_count
        if done_count == limit or done_count % POINTS_PER_STEP < read_count:
            progress.step(done_count)
    if done_count == 0:
        raise InputError(Finding("model.no-points"), file=path)
    if done_count < stated_count:
        findings.append(missing_points_finding(done_count, stated_count))
    colors = _colors(columns.take("colors", done_count), findings)
    fields: dict[str, GenericArray] = {}
    for name in field_names:
        values = columns.take(f"field {name}", done_count)
        assert values is not None
        # All clouds from photos contain only first returns, so the field is not informative.
        if name == "return_number" and (values == 1).all():
            continue
        if name in extra_names or values.any():
            for j in range(values.shape[1] if values.ndim == 2 else 0):
                fields[f"{name} {j + 1}"] = np.ascontiguousarray(values[:, j])
            if values.ndim == 1:
                fields[name] = values
    points = columns.take("points", done_count)
    assert points is not None
    cloud = PointCloud(points, colors, None, fields)
    withheld_values = columns.take("field withheld", done_count)
    return (
        cloud
        if withheld_values is None
        else _drop_withheld(cloud, withheld_values != 0, path, findings)
    )


def _colors(rgb16: GenericArray | None, findings: list[Finding]) -> ByteArray | None:
    if rgb16 is None:
        return None
    if rgb16.any():
        return to_uint8_colors(rgb16)
    findings.append(Finding("model.colors-black"))
    return None


def _no_data_values(header: Any) -> dict[str, tuple[float, ...]]:
    for record in header.vlrs:
        if record.user_id == "LASF_Spec" and record.record_id == 4:
            return read_no_data_values(record.record_data_bytes())
    return {}


def _values(chunk: Any, name: str, no_data: dict[str, tuple[float, ...]]) -> GenericArray:
    values: GenericArray = np.asarray(chunk[name])
    return mask_no_data(values, chunk.array[name], no_data[name]) if name in no_data else values


def _drop_withheld(
    cloud: PointCloud, is_withheld: GenericArray, path: Path, findings: list[Finding]
) -> PointCloud:
    """Remove the points that are marked as withheld.

    In a COPC file they are replaced by other points, so that row numbers are the same as in
    streaming. Raises InputError if all points are withheld.
    """
    count = int(np.count_nonzero(is_withheld))
    if not count:
        return cloud
    if count == len(is_withheld):
        raise InputError(Finding("model.all-withheld"), file=path)
    if is_copc(path):
        findings.append(Finding("model.withheld-hidden"))
        rows = replacement_rows(is_withheld)
        assert rows is not None
        return cloud.select_rows(rows)
    findings.append(Finding("model.points-withheld", count=count))
    return cloud.select_rows(np.logical_not(is_withheld))


READER = Reader(to_translate("LAS/LAZ point cloud"), (".las", ".laz"), matches, read)
