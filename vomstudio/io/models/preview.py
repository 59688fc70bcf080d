"""A first picture of a large point cloud, before it is read whole."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.gis.axis_units import stated_axes
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.copc import CopcFile
from vomstudio.io.models.formats._las_header import (
    Top,
    is_copc,
    is_sound_chunk,
    mended,
    read_top,
    unpack,
)
from vomstudio.io.models.formats._las_records import choose, cloud_of, layout_of
from vomstudio.io.models.formats._las_reference import las_reference

MOST_CHUNKS = 256
"""That are read at most: of a file of a hundred million points, every tenth or so."""
UNPACKED_POINTS = 600_000
"""Neighbours in a file are neighbours in space; more places are seen when more is unpacked and
thinned than is shown."""
RUN_POINTS = 500


def preview(path: str | Path, count: int = 200_000) -> PointCloud | None:
    """At most `count` points spread over a LAS, LAZ or COPC file, in a fraction of a second.

    COPC: the first levels of its octree. LAZ: the beginnings of chunks evenly spaced over the file,
    thinned. LAS: short runs of points, evenly spaced. None where the file is of another kind or
    not sound enough for this; reading it whole then says what is wrong.
    """
    path = Path(path)
    try:
        if is_copc(path):
            return _of_copc(path, count)
        with open_regular(path) as file:
            if file.read(4) != b"LASF":
                return None
        top = _of_one_unit(read_top(path), path)
        if top.compressed and mended(path, top.size) is not None:
            return None
        records = _of_laz(path, top, count) if top.compressed else _of_las(path, top, count)
        layout = layout_of(top, path)
        if not len(records):
            return None
        found = records.view(layout.kind).reshape(-1)
        cloud = cloud_of(found, layout, top, choose(found, layout))
    except (InputError, OSError):
        return None
    return cloud if np.isfinite(cloud.points).all() else None


def _of_one_unit(top: Top, path: Path) -> Top:
    """With heights in the unit of x and y, as the model will have them once it is read."""
    stated = las_reference(path)
    axes = stated_axes(stated.text or sidecar_crs(path)[0], stated.height_unit)
    factors = axes.unit_factor * np.array([1.0, 1.0, axes.height_factor])
    if (factors == 1.0).all():
        return top
    return replace(
        top,
        scales=top.scales * factors,
        offsets=top.offsets * factors,
        bounds=top.bounds * factors,
    )


def _of_copc(path: Path, count: int) -> PointCloud | None:
    with CopcFile(path) as file:
        cloud = file.read(file.overview(count))
    if not len(cloud.points):
        return None
    return cloud.of_rows(_spread(len(cloud.points), count))


def _spread(n: int, count: int) -> AnyArray:
    """`count` of n rows, evenly spaced; all where there are no more."""
    return np.linspace(0, n - 1, min(n, count)).astype(np.int64)


def _of_las(path: Path, top: Top, count: int) -> AnyArray:
    there = min(top.points, (top.size - top.points_at) // top.record_bytes)
    runs = max(1, min(count, there) // RUN_POINTS)
    length = min(RUN_POINTS, count, there)
    found = []
    with open_regular(path) as file:
        for first in np.linspace(0, max(0, there - length), runs).astype(np.int64).tolist():
            file.seek(top.points_at + first * top.record_bytes)
            found.append(file.read(length * top.record_bytes))
    content = np.frombuffer(b"".join(found), np.uint8)
    return content[: len(content) // top.record_bytes * top.record_bytes]


def _of_laz(path: Path, top: Top, count: int) -> AnyArray:
    import lazrs

    with open_regular(path) as file:
        file.seek(top.points_at)
        try:
            table = lazrs.read_chunk_table(file, lazrs.LazVlr(top.laszip))
        except lazrs.LazrsError:
            return np.empty(0, np.uint8)
        sizes = np.array([size for _, size in table], np.int64)
        held = np.array([points for points, _ in table], np.int64)
        if not len(sizes) or (sizes <= 0).any() or sizes.sum() > os.path.getsize(path):
            return np.empty(0, np.uint8)
        # The table of fixed chunks counts the last one as full.
        held = np.minimum(held, top.points - np.concatenate([[0], np.cumsum(held)[:-1]]))
        starts = top.points_at + 8 + np.concatenate([[0], np.cumsum(sizes)[:-1]])
        rows = np.unique(np.linspace(0, len(sizes) - 1, MOST_CHUNKS).astype(np.int64))
        rows = rows[held[rows] > 0]
        if not len(rows):
            return np.empty(0, np.uint8)
        each = max(1, max(count, UNPACKED_POINTS) // len(rows))
        chunks = []
        for row in rows.tolist():
            file.seek(int(starts[row]))
            chunk = file.read(int(sizes[row]))
            if top.layers and not is_sound_chunk(chunk, int(held[row]), top):
                return np.empty(0, np.uint8)
            chunks.append(chunk)
    found = unpack(chunks, np.minimum(held[rows], each).tolist(), top)
    if found is None:
        return np.empty(0, np.uint8)
    return found[_spread(len(found), count)].reshape(-1)
