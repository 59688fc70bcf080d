"""Preview of a large point cloud before it has been read completely."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.gis.axis_units import stated_axes
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.copc import CopcFile
from vomstudio.io.models.formats._las_header import (
    LasHeader,
    decompress,
    is_copc,
    is_valid_chunk,
    read_las_header,
    replace_chunk_table,
)
from vomstudio.io.models.formats._las_records import build_cloud, choose_fields, record_layout
from vomstudio.io.models.formats._las_reference import las_reference

MAX_CHUNKS = 256
"""Maximum number of chunks read: about a tenth of a file of 100 million points."""
MAX_UNPACKED_POINTS = 600_000
"""Maximum number of points to unpack. Neighbours in a file are also neighbours in space, so
unpacking more points than are displayed and thinning them covers more locations."""
RUN_POINTS = 500


def preview(path: str | Path, count: int = 200_000) -> PointCloud | None:
    """Return at most `count` points distributed over a LAS, LAZ or COPC file, quickly.

    For COPC, these are the first levels of the octree; for LAZ, the thinned beginnings of chunks
    that are evenly spaced over the file; for LAS, short runs of points at even spacing. Returns
    None for other or damaged files; reading the whole file then reports the error.
    """
    path = Path(path)
    try:
        if is_copc(path):
            return _copc_points(path, count)
        with open_regular_file(path) as file:
            if file.read(4) != b"LASF":
                return None
        header = _convert_units(read_las_header(path), path)
        if header.is_compressed and replace_chunk_table(path, header.size) is not None:
            return None
        records = (
            _laz_records(path, header, count)
            if header.is_compressed
            else _las_records(path, header, count)
        )
        layout = record_layout(header, path)
        if not len(records):
            return None
        typed_records = records.view(layout.kind).reshape(-1)
        cloud = build_cloud(typed_records, layout, header, choose_fields(typed_records, layout))
    except (InputError, OSError):
        return None
    return cloud if np.isfinite(cloud.points).all() else None


def _convert_units(header: LasHeader, path: Path) -> LasHeader:
    """Convert heights to the unit of x and y, as in the complete model."""
    reference = las_reference(path)
    axes = stated_axes(reference.text or sidecar_crs(path)[0], reference.height_unit)
    factors = axes.unit_factor * np.array([1.0, 1.0, axes.height_factor])
    if (factors == 1.0).all():
        return header
    return replace(
        header,
        scales=header.scales * factors,
        offsets=header.offsets * factors,
        bounds=header.bounds * factors,
    )


def _copc_points(path: Path, count: int) -> PointCloud | None:
    with CopcFile(path) as file:
        cloud = file.read(file.overview(count))
    if not len(cloud.points):
        return None
    return cloud.select_rows(_evenly_spaced_rows(len(cloud.points), count))


def _evenly_spaced_rows(n: int, count: int) -> AnyArray:
    """Return at most `count` evenly spaced row numbers out of n."""
    return np.linspace(0, n - 1, min(n, count)).astype(np.int64)


def _las_records(path: Path, header: LasHeader, count: int) -> AnyArray:
    available_records = min(
        header.points, (header.size - header.points_offset) // header.record_bytes
    )
    run_count = max(1, min(count, available_records) // RUN_POINTS)
    length = min(RUN_POINTS, count, available_records)
    record_runs = []
    with open_regular_file(path) as file:
        for first_record in (
            np.linspace(0, max(0, available_records - length), run_count).astype(np.int64).tolist()
        ):
            file.seek(header.points_offset + first_record * header.record_bytes)
            record_runs.append(file.read(length * header.record_bytes))
    content = np.frombuffer(b"".join(record_runs), np.uint8)
    return content[: len(content) // header.record_bytes * header.record_bytes]


def _laz_records(path: Path, header: LasHeader, count: int) -> AnyArray:
    import lazrs

    with open_regular_file(path) as file:
        file.seek(header.points_offset)
        try:
            table = lazrs.read_chunk_table(file, lazrs.LazVlr(header.laszip))
        except lazrs.LazrsError:
            return np.empty(0, np.uint8)
        sizes = np.array([size for _, size in table], np.int64)
        chunk_points = np.array([points for points, _ in table], np.int64)
        if not len(sizes) or (sizes <= 0).any() or sizes.sum() > os.path.getsize(path):
            return np.empty(0, np.uint8)
        # A table of fixed chunks counts the last chunk as full.
        chunk_points = np.minimum(
            chunk_points, header.points - np.concatenate([[0], np.cumsum(chunk_points)[:-1]])
        )
        starts = header.points_offset + 8 + np.concatenate([[0], np.cumsum(sizes)[:-1]])
        rows = np.unique(np.linspace(0, len(sizes) - 1, MAX_CHUNKS).astype(np.int64))
        rows = rows[chunk_points[rows] > 0]
        if not len(rows):
            return np.empty(0, np.uint8)
        points_per_chunk = max(1, max(count, MAX_UNPACKED_POINTS) // len(rows))
        chunks = []
        for row in rows.tolist():
            file.seek(int(starts[row]))
            chunk = file.read(int(sizes[row]))
            if header.layer_count and not is_valid_chunk(chunk, int(chunk_points[row]), header):
                return np.empty(0, np.uint8)
            chunks.append(chunk)
    records = decompress(chunks, np.minimum(chunk_points[rows], points_per_chunk).tolist(), header)
    if records is None:
        return np.empty(0, np.uint8)
    return records[_evenly_spaced_rows(len(records), count)].reshape(-1)
