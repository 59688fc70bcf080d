"""Cameras of Bundler: `bundle.out`, which many programs write.

The rotation and translation of a camera are from the World frame to the camera, with x right, y up,
z backward. Pixel coordinates are relative to the centre of the photo. Another file lists the photos
(Bundler User's Manual, version 0.4, "Output format and scene representation").
"""

from __future__ import annotations

import io
from itertools import islice
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.photo_sizes import (
    Size,
    placeholder_lens,
    read_sizes,
    unknown_size_findings,
)
from vomstudio.io.photos.own_cameras.result import view_from_pose
from vomstudio.io.text.file_text import MAX_OBJECTS, read_text

FILE_NAMES = ("bundle.out",)
_SIGNATURE = "# bundle file"
_MAX_LINES = 100_000_000
_AXES = np.diag([1.0, -1.0, -1.0])
"""Rotation from a camera frame with y up, z backward to one with y down, z forward."""


def is_bundler(head: bytes) -> bool:
    """Return whether the first bytes of a file are those of a Bundler file."""
    return head.decode("utf-8", "replace").lower().startswith(_SIGNATURE)


def read_bundler(path: Path) -> list[Candidate]:
    """Read the cameras; those with a focal length of zero are not aligned.

    Raises
    ------
    InputError
        If a line is not valid, or the list of photos is missing.
    """
    text, _ = read_text(path, _MAX_LINES, accepted_names=("bundler",))
    first_rows = _rows(text, 2)
    count = int(_numbers(path, first_rows, 0, 2)[0])
    # The points follow the cameras.
    lines = _rows(text, 5 * min(count, MAX_OBJECTS) + 2)
    poses = {}
    for index in range(count):
        first_row = 1 + 5 * index
        pose = np.array([_numbers(path, lines, first_row + row, 3) for row in range(5)])
        if pose[0, 0] != 0.0:
            poses[index] = (first_row, pose)
    names = _photo_names(path, count)
    used_names = [names[index] for index in poses]
    sizes = read_sizes(path, used_names)
    views = list[View]()
    for index, (first_row, pose) in poses.items():
        name = names[index]
        rotation, translation = _AXES @ pose[1:4], _AXES @ pose[4]
        try:
            lens = _lens(pose[0], sizes.get(name))
            views.append(view_from_pose(name, lens, rotation, translation))
        except (ValueError, GeometryError) as error:
            raise _damage_error(path, str(error), lines[first_row][0]) from error
    return [
        Candidate(
            tr("the frame of the file"), views, tuple(unknown_size_findings(sizes, used_names))
        )
    ]


def _lens(row: FloatArray, size: Size | None) -> Intrinsics:
    if size is None:
        return placeholder_lens()
    focal, k1, k2 = (float(value) for value in row)
    if not focal > 0:
        raise ValueError(tr("the focal length is missing or not positive"))
    width, height = size
    return Intrinsics("RADIAL", width, height, (focal, width / 2.0, height / 2.0, k1, k2))


def _rows(text: str, count: int) -> list[tuple[int, list[str]]]:
    """Return the line numbers and cells of the first `count` lines, skipping comments."""
    numbered_lines = ((n, line) for n, line in enumerate(io.StringIO(text), 1))
    lines = (
        row for row in numbered_lines if row[1].strip() and not row[1].lstrip().startswith("#")
    )
    return [(line_number, line.split()) for line_number, line in islice(lines, count)]


def _photo_names(path: Path, count: int) -> list[str]:
    """Return the names of the photos from a list (one per line) near the file.

    Raises InputError if no list has as many names as the file has cameras.
    """
    candidates = [path.with_name(path.name + ".list.txt"), path.with_suffix(".list.txt")]
    candidates += [path.with_name(name) for name in ("list.txt", "list_images.txt")]
    candidates += [path.parent.parent / "list.txt"]
    for candidate in candidates:
        if not candidate.is_file():
            continue
        text, _ = read_text(candidate)
        names = [line.split()[0].replace("\\", "/") for line in text.split("\n") if line.strip()]
        if len(names) == count:
            return [name.removeprefix("./") for name in names]
    raise InputError(Finding("cameras.no-photo-list", photos=count), file=path)


def _numbers(path: Path, lines: list[tuple[int, list[str]]], row: int, count: int) -> FloatArray:
    if row >= len(lines):
        raise _damage_error(path, tr("the file ends too early"), lines[-1][0] if lines else 1)
    line_number, cells = lines[row]
    try:
        values = np.array([float(cell) for cell in cells])
    except ValueError:
        values = np.array([])
    if len(values) != count or not np.isfinite(values).all():
        raise _damage_error(path, tr("{count} numbers are needed", count=count), line_number)
    return values


def _damage_error(path: Path, reason: str, line: int) -> InputError:
    finding = Finding("file.damaged", reason=reason.rstrip("."), format="Bundler")
    return InputError(finding, file=path, line=line)
