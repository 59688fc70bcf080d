"""E57 scans (ASTM E2807), read with pye57 if it is installed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, ByteArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.names import utf8_name
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.formats._budget import Budget
from vomstudio.io.models.formats._common import (
    Columns,
    drop_invalid_points,
    missing_points_finding,
)
from vomstudio.io.models.reader import LoadedModel, Reader

POINTS_PER_STEP = 500_000
CARTESIAN_FIELDS = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL_FIELDS = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
COLOR_FIELDS = ("colorRed", "colorGreen", "colorBlue")
INVALID_STATES = ("cartesianInvalidState", "sphericalInvalidState")
METRIC_UNITS = ("m", "m", "m")
"""Units of the format (E57 8.3.2), which apply unless a CRS states others."""


def matches(path: Path, head: bytes) -> bool:
    """Return whether a file begins like an E57 file."""
    return head.startswith(b"ASTM-E57")


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read all scans of a file, each in its pose, as a single point cloud.

    Cartesian or spherical coordinates become float64 x, y, z; colours are scaled to 8 bits
    according to the limits stated in the file; the fields are `intensity` and, if there are several
    scans, `scan` (0, 1, ...). Points marked as invalid are dropped. Raises InputError if the file
    is damaged or pye57 is not installed.
    """
    with open_regular_file(path) as file:
        if not file.read(8) == b"ASTM-E57":
            raise InputError(Finding("file.other-format", format="E57"), file=path)
    try:
        from pye57 import libe57
    except ImportError as error:
        raise InputError(Finding("file.package-missing"), file=path) from error
    findings: list[Finding] = []
    try:
        with utf8_name(path) as safe_path:
            image = libe57.ImageFile(str(safe_path), "r")
        try:
            cloud = _read_scans(libe57, image, path, progress, findings)
            crs = _crs(image)
        finally:
            image.close()
    except MemoryError as error:
        raise InputError(Finding("file.exceeds-memory"), file=path) from error
    except (
        libe57.E57Exception,
        RuntimeError,
        ValueError,
        TypeError,
        KeyError,
    ) as error:
        raise InputError(
            Finding("file.damaged", format="E57", reason=tr("its data cannot be decoded")),
            file=path,
        ) from error
    return LoadedModel(
        drop_invalid_points(cloud, findings, path),
        "cloud",
        crs,
        tuple(findings),
        path,
        units=METRIC_UNITS,
    )


def _read_scans(
    e57: Any, image: Any, path: Path, progress: Progress, findings: list[Finding]
) -> PointCloud:
    scans = list(image.root()["data3D"]) if image.root().isDefined("data3D") else []
    point_count = sum(int(scan["points"].childCount()) for scan in scans)
    progress.stage(tr("Reading the points"), point_count)
    columns = Columns()
    done_count = n_invalid = 0
    names = [_names(e57, scan) for scan in scans]
    is_colored = all(set(COLOR_FIELDS) <= scan_fields for scan_fields in names)
    has_intensity = all("intensity" in scan_fields for scan_fields in names)
    unread_fields = set()
    # A constant value takes no bits in the file, whatever the number of points.
    budget = Budget(path, path.stat().st_size)
    for index, (scan, scan_fields) in enumerate(zip(scans, names, strict=True)):
        coordinate_names = next(
            (axes for axes in (CARTESIAN_FIELDS, SPHERICAL_FIELDS) if set(axes) <= scan_fields),
            None,
        )
        if coordinate_names is None:
            findings.append(Finding("model.scan-left-out", number=index + 1))
            continue
        column_names = [
            *coordinate_names,
            *(c for c in COLOR_FIELDS if is_colored),
            *(["intensity"] if has_intensity else []),
        ]
        flags = [
            name
            for name in INVALID_STATES
            if name in scan_fields and name[:4] == coordinate_names[0][:4]
        ]
        unread_fields |= (
            scan_fields - set(column_names) - set(flags) - {"rowIndex", "columnIndex", "intensity"}
        )
        rotation, shift = _pose(scan)
        limits = _color_limits(scan)
        for block in _blocks(e57, image, scan, [*column_names, *flags]):
            read_count = len(block[coordinate_names[0]])
            budget.take(8 * read_count * len(column_names), "points")
            xyz = np.column_stack([block[name] for name in coordinate_names])
            if coordinate_names is SPHERICAL_FIELDS:
                xyz = _to_cartesian(xyz)
            xyz = xyz @ rotation.T + shift
            is_kept = np.ones(read_count, bool)
            for name in flags:
                is_kept &= block[name] == 0
            n_invalid += read_count - int(np.count_nonzero(is_kept))
            columns.add("points", xyz[is_kept], point_count)
            if is_colored:
                rgb = np.column_stack([block[name] for name in COLOR_FIELDS])[is_kept]
                columns.add("colors", _scale_to_bytes(rgb, limits), point_count)
            if has_intensity:
                columns.add("intensity", block["intensity"][is_kept], point_count)
            if len(scans) > 1:
                columns.add("scan", np.full(int(is_kept.sum()), index, np.int32), point_count)
            done_count += read_count
            progress.step(min(done_count, point_count))
    n = done_count - n_invalid
    if n == 0:
        raise InputError(Finding("model.no-points"), file=path)
    if n_invalid:
        findings.append(Finding("model.points-withheld", count=n_invalid))
    if done_count < point_count:
        findings.append(missing_points_finding(done_count, point_count))
    if unread_fields:
        findings.append(Finding("model.fields-left-out", fields=sorted(unread_fields)))
    points = columns.take("points", n)
    assert points is not None
    fields: dict[str, AnyArray] = {}
    for name in ("intensity", "scan"):
        values = columns.take(name, n)
        if values is not None and (values.any() or name == "scan"):
            fields[name] = values
    return PointCloud(points, columns.take("colors", n), None, fields)


def _names(e57: Any, scan: Any) -> set[str]:
    prototype = e57.StructureNode(scan["points"].prototype())
    return {prototype.get(i).elementName() for i in range(prototype.childCount())}


def _blocks(e57: Any, image: Any, scan: Any, names: list[str]) -> Any:
    """Yield arrays by name, block by block, in reused memory.

    The size of the memory does not depend on what a file states.
    """
    arrays: dict[str, AnyArray] = {}
    buffers = e57.VectorSourceDestBuffer()
    for name in names:
        kind = (
            "f"
            if name in COLOR_FIELDS or name == "intensity"
            else "b"
            if name in INVALID_STATES
            else "d"
        )
        arrays[name] = np.empty(POINTS_PER_STEP, kind)
        buffers.append(e57.SourceDestBuffer(image, name, arrays[name], POINTS_PER_STEP, True, True))
    reader = scan["points"].reader(buffers)
    try:
        while n := int(reader.read()):
            yield {name: values[:n] for name, values in arrays.items()}
    finally:
        reader.close()


def _pose(scan: Any) -> tuple[AnyArray, AnyArray]:
    """Return the rotation (3, 3) and translation of a scan, from local to global coordinates."""
    rotation, shift = np.eye(3), np.zeros(3)
    if not scan.isDefined("pose"):
        return rotation, shift
    pose = scan["pose"]
    if pose.isDefined("translation"):
        shift = np.array([pose["translation"][axis].value() for axis in "xyz"], float)
    if pose.isDefined("rotation"):
        q = np.array([pose["rotation"][part].value() for part in "wxyz"], float)
        length = float(np.linalg.norm(q))
        if np.isfinite(length) and length > 0:
            w, x, y, z = q / length
            rotation = np.array(
                [
                    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
                ]
            )
    return rotation, shift


def _to_cartesian(rae: AnyArray) -> AnyArray:
    """Convert range, azimuth from x to y, and elevation, in radians, to x, y, z (E57 8.4.4.1)."""
    distance, azimuth, elevation = rae.T
    horizontal_distance = distance * np.cos(elevation)
    return np.column_stack(
        [
            horizontal_distance * np.cos(azimuth),
            horizontal_distance * np.sin(azimuth),
            distance * np.sin(elevation),
        ]
    )


def _color_limits(scan: Any) -> tuple[AnyArray, AnyArray]:
    """Return minimum and maximum of red, green and blue; 0 and 255 if not stated."""
    low, high = np.zeros(3), np.full(3, 255.0)
    if scan.isDefined("colorLimits"):
        limits = scan["colorLimits"]
        for j, color in enumerate(COLOR_FIELDS):
            if limits.isDefined(f"{color}Minimum") and limits.isDefined(f"{color}Maximum"):
                low[j] = limits[f"{color}Minimum"].value()
                high[j] = limits[f"{color}Maximum"].value()
    is_invalid = ~(np.isfinite(low) & np.isfinite(high) & (high > low))
    low[is_invalid], high[is_invalid] = 0.0, 255.0
    return low, high


def _scale_to_bytes(rgb: AnyArray, limits: tuple[AnyArray, AnyArray]) -> ByteArray:
    low, high = limits
    values = np.nan_to_num((rgb - low) / (high - low) * 255.0)
    return np.asarray(np.clip(np.rint(values), 0, 255).astype(np.uint8))


def _crs(image: Any) -> str | None:
    root = image.root()
    text = root["coordinateMetadata"].value() if root.isDefined("coordinateMetadata") else ""
    return text.strip() or None


READER = Reader(to_translate("E57 scan"), (".e57",), matches, read)
