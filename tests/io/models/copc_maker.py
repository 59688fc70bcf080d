"""Writes small COPC files for tests, by the specification at https://copc.io (version 1.0)."""

from __future__ import annotations

import struct
from pathlib import Path

import laspy
import lazrs
import numpy as np
from pyproj import CRS

CELLS = 64
"""Per side of a node: the root's spacing is its side by this."""


def levels_of(points: np.ndarray, low: np.ndarray, side: float, deepest: int) -> np.ndarray:
    """The level of each point: the first at which it is the first of its cell."""
    level = np.full(len(points), deepest)
    left = np.arange(len(points))
    for number in range(deepest):
        cell = ((points[left] - low) / (side / 2**number / CELLS)).astype(np.int64)
        code = (cell[:, 0] * 2**40 + cell[:, 1] * 2**20) + cell[:, 2]
        _, first = np.unique(code, return_index=True)
        level[left[first]] = number
        left = np.delete(left, first)
    return level


def write_copc(
    path: Path,
    las: laspy.LasData,
    deepest: int = 3,
    split_pages_at: int | None = None,
    crs: int | str | None = 32615,
) -> None:
    """`las` of point format 6 to 8. split_pages_at : the level whose nodes begin pages of their own
    in the table of nodes."""
    points = np.asarray(las.xyz)
    low, high = points.min(axis=0), points.max(axis=0)
    half = float((high - low).max()) / 2 * 1.0001
    centre = (low + high) / 2
    level = levels_of(points, centre - half, 2 * half, deepest)
    cube = np.clip(((points - (centre - half)) / (2 * half)), 0, 1 - 1e-12)
    number = (cube * (2**level)[:, None]).astype(np.int64)
    order = np.lexsort((*number.T, level))
    keys = np.column_stack([level, number])[order]
    starts = np.flatnonzero(np.r_[True, (np.diff(keys, axis=0) != 0).any(axis=1)])

    header = laspy.LasHeader(version="1.4", point_format=las.point_format.id)
    header.scales, header.offsets = las.header.scales, las.header.offsets
    extra = list(las.point_format.extra_dimensions)
    vlr = lazrs.LazVlr.new_for_compression(
        las.point_format.id, sum(d.num_bytes for d in extra), True
    )
    others: list[tuple[bytes, int, bytes]] = []
    if extra:
        others.append(
            (b"LASF_Spec", 4, las.header.vlrs.get("ExtraBytesVlr")[0].record_data_bytes())
        )
    if crs is not None:
        others.append(
            (b"LASF_Projection", 2112, CRS.from_user_input(crs).to_wkt().encode() + b"\0")
        )
    records = [(b"copc", 1, bytes(160)), (b"laszip encoded", 22204, bytes(vlr.record_data()))]
    records += others
    points_at = 375 + sum(54 + len(content) for _, _, content in records)
    with open(path, "w+b") as file:
        file.write(bytes(points_at))
        compressor = lazrs.LasZipCompressor(file, vlr)
        compressor.reserve_offset_to_chunk_table()
        raw = las.points.array[order]
        chunks = []
        for start, stop in zip(starts, [*starts[1:], len(raw)], strict=True):
            at = file.tell()
            compressor.compress_many(np.frombuffer(raw[start:stop].tobytes(), np.uint8))
            compressor.finish_current_chunk()
            chunks.append((keys[start], at, file.tell() - at, stop - start))
        compressor.done()
        file.seek(0, 2)
        evlr_at = file.tell()
        root_at, root_bytes = write_pages(file, chunks, split_pages_at)
        info = struct.pack(
            "<5d2Q2d88x", *centre, half, 2 * half / CELLS, root_at, root_bytes, 0.0, 0.0
        )
        records[0] = (b"copc", 1, info)
        file.seek(0)
        file.write(header_bytes(las, points_at, len(records), evlr_at, low, high))
        for user, record_id, content in records:
            file.write(struct.pack("<H16sHH32s", 0, user, record_id, len(content), b"") + content)


def write_pages(file, chunks, split_at: int | None) -> tuple[int, int]:
    """The hierarchy as an extended record: pages of subtrees first, the root page last."""
    start = file.tell()
    file.write(bytes(60))
    entry = struct.Struct("<4iQ2i")
    pages: dict[tuple[int, ...] | None, list[bytes]] = {None: []}
    for key, at, size, count in chunks:
        owner = None
        if split_at is not None and key[0] >= split_at:
            up = int(key[0]) - split_at
            owner = (split_at, *(int(k) >> up for k in key[1:]))
        pages.setdefault(owner, []).append(entry.pack(*map(int, key), at, size, int(count)))
    for owner, entries in pages.items():
        if owner is not None:
            pages[None].append(entry.pack(*owner, file.tell(), len(entries) * 32, -1))
            file.write(b"".join(entries))
    at = file.tell()
    file.write(b"".join(pages[None]))
    end = file.tell()
    file.seek(start)
    file.write(struct.pack("<H16sHQ32s", 0, b"copc", 1000, end - start - 60, b""))
    file.seek(end)
    return at, end - at


def header_bytes(las, points_at: int, n_records: int, evlr_at: int, low, high) -> bytes:
    box = [value for axis in range(3) for value in (high[axis], low[axis])]
    return struct.pack(
        "<4sHH16sBB32s32sHHHIIBHI5I3d3d6dQQIQ15Q",
        b"LASF",
        0,
        16,
        b"",
        1,
        4,
        b"test",
        b"test",
        1,
        2026,
        375,
        points_at,
        n_records,
        las.point_format.id | 0x80,
        las.point_format.size,
        0,
        0,
        0,
        0,
        0,
        0,
        *las.header.scales,
        *las.header.offsets,
        *box,
        0,
        evlr_at,
        1,
        len(las.points),
        len(las.points),
        *[0] * 14,
    )
