"""LAS 1.4 and LAZ."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import Cancelled
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.writer import Outgoing, Writer
from vomstudio.io.models.writers._common import (
    bare_points,
    field_names,
    positions_of,
    step_rows,
)

MAX_INTEGER = 2**31 - 1
# Of coordinates that are no decimals of some length: float noise, or the result of a calculation.
USUAL_SCALE = 1e-5
# Fields that have a place of their own in every point, with what fits there.
STANDARD = {
    "intensity": np.uint16,
    "classification": np.uint8,
    "gps_time": np.float64,
    "user_data": np.uint8,
    "point_source_id": np.uint16,
}
NAME_BYTES = 32


def write(out: Outgoing) -> list[Finding]:
    """Integers of a scale that keeps the coordinates; the CRS as WKT; colours in 16 bit; fields in
    their places or as extra dimensions of their own types."""
    import laspy

    messages: list[Finding] = []
    data = out.data
    bare_points(data, messages)
    points = positions_of(data)
    grids = [_grid(points[:, k]) for k in range(3)]
    offset, scales = np.array(grids).T
    rounding = _rounding(points, offset, scales)
    if rounding > 1e-9 * max(1.0, float(np.abs(data.bounds).max()) * 1e-6):
        messages.append(Finding("model.positions-rounded", rounding_mm=scales.max() * 1000))
    header = laspy.LasHeader(version="1.4", point_format=7 if data.colors is not None else 6)
    header.scales, header.offsets = scales, offset
    columns = _columns(data, header, messages)
    if out.crs is not None:
        from pyproj import CRS

        header.add_crs(CRS.from_user_input(out.crs))
    compressed = out.path.suffix.lower() == ".laz"
    with (
        atomic_write(out.path, out.force) as temporary,
        _honest(temporary) as file,
        laspy.open(
            file,
            mode="w",
            header=header,
            do_compress=compressed,
            laz_backend=laspy.LazBackend.LazrsParallel if compressed else None,
            closefd=False,
        ) as writer,
    ):
        for rows in step_rows(len(points), out, tr("Writing points")):
            record = laspy.ScaleAwarePointRecord.zeros(rows.stop - rows.start, header=header)
            whole = np.rint((points[rows] - offset) / scales).astype(np.int32)
            record.X, record.Y, record.Z = whole.T
            if data.colors is not None:
                wide = data.colors[rows].astype(np.uint16) * 257
                record.red, record.green, record.blue = wide.T
            record.return_number[:] = 1
            record.number_of_returns[:] = 1
            for name, values in columns:
                record[name] = values[rows]
            writer.write_points(record)
    return messages


class _Remembering(io.FileIO):
    """A file that knows why a write failed: what comes back through the compressor is only that
    it did."""

    failure: OSError | None = None

    def write(self, content: Any) -> int:
        left = memoryview(content).cast("B")
        try:
            while left:
                left = left[super().write(left) :]
        except OSError as error:
            self.failure = error
            raise
        return memoryview(content).nbytes


@contextlib.contextmanager
def _honest(path: Path) -> Iterator[_Remembering]:
    with _Remembering(path, "w+") as file:
        try:
            yield file
        except Cancelled:
            raise
        except BaseException as error:
            if file.failure is not None and file.failure is not error:
                raise file.failure from error
            raise


def _grid(values: AnyArray) -> tuple[float, float]:
    """(offset, scale): the coarsest power of ten that gives back the coordinates, counted from a
    whole number or from the first point (as in files whose own offset was no whole number); else
    `USUAL_SCALE`, or what the width of the model leaves."""
    low, high = float(values.min()), float(values.max())
    centre = float(np.floor((low + high) / 2))
    ulp = 4 * np.spacing(max(abs(low), abs(high), 1e-300))
    for power in range(3, 10):
        scale = float(f"1e-{power}")
        for offset in (centre, float(values[0])):
            local = values - offset
            if np.abs(local).max() / scale > MAX_INTEGER:
                continue
            if np.abs(np.rint(local / scale) * scale + offset - values).max() <= ulp:
                return offset, scale
    scale = USUAL_SCALE
    while max(high - centre, centre - low) / scale > MAX_INTEGER:
        scale *= 10
    return centre, float(f"{scale:.0e}")


def _rounding(points: AnyArray, offset: AnyArray, scales: AnyArray) -> float:
    back = np.rint((points - offset) / scales) * scales + offset
    return float(np.abs(back - points).max(initial=0.0))


def _columns(
    data: Mesh | PointCloud, header: Any, messages: list[Finding]
) -> list[tuple[str, AnyArray]]:
    import laspy

    columns: list[tuple[str, AnyArray]] = []
    rest: dict[str, AnyArray] = {}
    for name, values in data.fields.items():
        kind = STANDARD.get(name)
        if kind is not None and _fits(values, kind):
            columns.append((name, values.astype(kind)))
        elif name == "return_number" and _fits(values, np.uint8) and values.max(initial=0) < 16:
            columns.append((name, values.astype(np.uint8)))
            columns.append(("number_of_returns", np.maximum(values, 1).astype(np.uint8)))
        else:
            rest[name] = values
    if isinstance(data, PointCloud) and data.normals is not None:
        messages.append(Finding("model.normals-as-fields"))
        for k, axis in enumerate("xyz"):
            rest.setdefault(f"normal_{axis}", data.normals[:, k])
    short = _short_names(rest, messages)
    names = field_names(short, header.point_format.dimension_names, messages)
    extra = []
    for name, label in names.items():
        values = short[name]
        usual: dict[str, Any] = {"?": np.dtype(np.uint8), "e": np.dtype(np.float32)}
        stored = usual.get(values.dtype.char, values.dtype.newbyteorder("="))
        extra.append(laspy.ExtraBytesParams(label, stored))
        columns.append((label, values.astype(stored)))
    if extra:
        header.add_extra_dims(extra)
    return columns


def _fits(values: AnyArray, kind: Any) -> bool:
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        return bool(np.dtype(kind).kind == "f")
    with np.errstate(all="ignore"):
        return bool((values.astype(kind).astype(values.dtype) == values).all())


def _short_names(fields: dict[str, AnyArray], messages: list[Finding]) -> dict[str, AnyArray]:
    """Names that fit into the 32 bytes which the format has for them."""
    result: dict[str, AnyArray] = {}
    for name, values in fields.items():
        short = name.encode()[: NAME_BYTES - 8].decode(errors="ignore")
        label = name if len(name.encode()) <= NAME_BYTES - 8 else short
        number = 2
        while label in result or (label != name and label in fields):
            label, number = f"{short}_{number}", number + 1
        if label != name:
            messages.append(Finding("model.field-renamed", field=name, new=label))
        result[label] = values
    return result


WRITER = Writer(to_translate("LAS/LAZ point cloud"), (".las", ".laz"), write)
