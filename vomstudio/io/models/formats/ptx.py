"""PTX scans of Leica Cyclone and other programs: text with the pose of each scan.

A scan begins with its number of columns and rows, the position and the three axes of the scanner,
and a 4 x 4 matrix that maps from the scanner to the common frame, with the translation in its last
row. A line with x, y, z, intensity and perhaps red, green and blue follows for each point of the
grid; a point without a return is 0 0 0. Further scans follow (Leica Geosystems, "Cyclone PTX file
format").
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.formats._common import (
    Columns,
    drop_invalid_points,
    missing_points_finding,
    to_uint8_colors,
)
from vomstudio.io.models.reader import LoadedModel, Reader
from vomstudio.io.text.file_text import require_file

_HEADER_LINES = 10
_LINES_PER_BLOCK = 200_000
_MAX_LINE_BYTES = 1000
_MAX_ROTATION_DEVIATION = 1e-3
METRIC_UNITS = ("m", "m", "m")
"""Units of the format."""


@dataclass(frozen=True, eq=False)
class _Scan:
    """Header of a scan: number of points, and rotation (3, 3) and translation of row vectors."""

    count: int
    rotation: FloatArray
    shift: FloatArray


def matches(path: Path, head: bytes) -> bool:
    """Return whether a file begins with the header of a scan.

    Parameters
    ----------
    path : Path
    head : bytes
        First bytes of the file.

    Returns
    -------
    bool
    """
    lines = head.splitlines()[: _HEADER_LINES + 1]
    if len(lines) <= _HEADER_LINES:
        return False
    try:
        rows = [[float(cell) for cell in line.split()] for line in lines]
    except ValueError:
        return False
    widths = [len(row) for row in rows]
    has_counts = all(row[0] >= 1 and row[0].is_integer() for row in rows[:2] if row)
    return widths[:_HEADER_LINES] == [1, 1, *[3] * 4, *[4] * 4] and has_counts and widths[10] > 3


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read all scans of a file, each in its pose, as a single point cloud.

    The fields are `intensity` and, if there are several scans, `scan` (0, 1, ...). Points without a
    return are dropped.

    Parameters
    ----------
    path : Path
    progress : Progress

    Returns
    -------
    LoadedModel

    Raises
    ------
    InputError
        If the file is damaged; states the line.
    """
    size = require_file(path)
    messages: list[Finding] = []
    columns = Columns()
    read_count = expected_count = n_missing = number = 0
    is_colored = True
    progress.stage(tr("Reading the points"), size)
    with open_regular_file(path) as stream:
        line = 1
        while (scan := _read_header(path, stream, line)) is not None:
            line += _HEADER_LINES
            expected_count += scan.count
            for rows in _read_rows(path, stream, scan.count, line):
                line += len(rows)
                read_count += len(rows)
                has_return = (rows[:, :3] != 0.0).any(axis=1)
                n_missing += int(len(rows) - np.count_nonzero(has_return))
                points = rows[has_return]
                columns.add("points", points[:, :3] @ scan.rotation + scan.shift)
                if points.shape[1] > 3:
                    columns.add("intensity", points[:, 3].astype(np.float32))
                is_colored &= rows.shape[1] == 7
                if is_colored:
                    columns.add("colors", points[:, 4:7].astype(np.float32))
                columns.add("scan", np.full(len(points), number, np.int32))
                progress.step(min(stream.tell(), size))
            number += 1
    count = read_count - n_missing
    if count == 0:
        raise InputError(Finding("model.no-points"), file=path)
    if read_count < expected_count:
        messages.append(missing_points_finding(read_count, expected_count))
    positions = columns.take("points", count)
    assert positions is not None
    colors = columns.take("colors", count) if is_colored else None
    names = ("intensity", "scan") if number > 1 else ("intensity",)
    fields = {name: values for name in names if (values := columns.take(name, count)) is not None}
    cloud = PointCloud(positions, None if colors is None else to_uint8_colors(colors), None, fields)
    return LoadedModel(
        drop_invalid_points(cloud, messages, path),
        "cloud",
        None,
        tuple(messages),
        path,
        units=METRIC_UNITS,
    )


def _read_header(path: Path, stream: io.BufferedIOBase, line: int) -> _Scan | None:
    """Read the header of the next scan, or return None at the end of the file.

    Raises InputError if the header is damaged.
    """
    rows: list[list[float]] = []
    widths = [1, 1, 3, 3, 3, 3, 4, 4, 4, 4]
    for width in widths:
        text = stream.readline(_MAX_LINE_BYTES)
        while not rows and text and not text.strip():
            text = stream.readline(_MAX_LINE_BYTES)
        if not rows and not text:
            return None
        try:
            rows.append([float(cell) for cell in text.split()])
        except ValueError as error:
            raise _damage_error(path, line + len(rows), str(error)) from error
        if len(rows[-1]) != width:
            reason = tr("{count} numbers are needed", count=width)
            raise _damage_error(path, line + len(rows) - 1, reason)
    matrix = np.array(rows[6:])
    rotation = matrix[:3, :3]
    counts = np.array([rows[0][0], rows[1][0]])
    if not (np.isfinite(counts).all() and (counts >= 0).all()):
        raise _damage_error(path, line, tr("the number of points is not valid"))
    is_valid = np.isfinite(matrix).all()
    if not is_valid or np.abs(rotation @ rotation.T - np.eye(3)).max() > _MAX_ROTATION_DEVIATION:
        raise _damage_error(path, line + 6, tr("the pose matrix is not a rotation"))
    return _Scan(int(rows[0][0]) * int(rows[1][0]), rotation, matrix[3, :3])


def _read_rows(
    path: Path, stream: io.BufferedIOBase, count: int, line: int
) -> Iterator[FloatArray]:
    """Yield the points of a scan in blocks (k, 3), (k, 4) or (k, 7).

    Raises InputError if a row is damaged.
    """
    remaining_count = count
    while remaining_count:
        lines = []
        for _ in range(min(remaining_count, _LINES_PER_BLOCK)):
            text = stream.readline(_MAX_LINE_BYTES)
            if not text:
                remaining_count = 0
                break
            lines.append(text)
        if not lines:
            return
        try:
            rows = np.loadtxt(lines, ndmin=2, comments=None)
        except ValueError as error:
            raise _damage_error(path, line, str(error)) from error
        if rows.shape[1] not in (3, 4, 7) or len(rows) != len(lines):
            raise _damage_error(path, line, tr("{count} numbers are needed", count="4 or 7"))
        line += len(rows)
        remaining_count -= len(rows) if remaining_count else 0
        yield np.asarray(rows, np.float64)


def _damage_error(path: Path, line: int, reason: str) -> InputError:
    finding = Finding("file.damaged", format="PTX", reason=reason.rstrip("."))
    return InputError(finding, file=path, line=line)


READER = Reader("PTX", (".ptx",), matches, read)
