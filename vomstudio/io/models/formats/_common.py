"""What the readers share: whole files, colours, and leaving out what is unsound."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray, ByteArray, FloatArray, Int32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_unbuffered
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.threads import map_parallel
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import place_keys
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.text.encodings import MARKS, convert_to_utf8

BLOCK_BYTES = 8 * 1024 * 1024
READERS = 3
ROWS_AT_FIRST = 2_000_000
ROWS_AT_ONCE = 1 << 17


def read_whole(path: Path, progress: Progress, tail: bytes = b"") -> ByteArray:
    """All bytes of a file, then `tail`; read in steps, so that it can be stopped.

    Not mapped: a file that shrinks under a map, or a network drive that drops out, kills a process.
    """
    try:
        size = os.stat(path).st_size
        data = np.empty(size + len(tail), np.uint8)
        view = data.data
        progress.stage(tr("Reading the file"), size)

        def fill(start: int) -> int:
            stop = min(start + BLOCK_BYTES, size)
            with open_unbuffered(path) as file:
                file.seek(start)
                at = start
                while at < stop and (n := file.readinto(view[at:stop])):
                    at += n
            return at

        done = 0
        for done in map_parallel(fill, range(0, size, BLOCK_BYTES), READERS):
            progress.step(done)
            if done % BLOCK_BYTES and done < size:
                break  # the file has become shorter meanwhile
    except PermissionError:
        raise InputError(Finding("file.no-permission"), file=path) from None
    except MemoryError:
        raise InputError(Finding("file.exceeds-memory"), file=path) from None
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    data = data[: done + len(tail)]
    data[done:] = np.frombuffer(tail, np.uint8)
    return data


def in_utf8(data: ByteArray, tail: bytes = b"") -> ByteArray:
    """What `read_whole` gave, with the same tail: UTF-16 text, told by its mark, as UTF-8."""
    if data[:2].tobytes() not in MARKS:
        return data
    raw = data[: len(data) - len(tail)].tobytes()
    return np.frombuffer(bytearray(convert_to_utf8(raw) + tail), np.uint8)


_DECIMAL_COMMA = re.compile(rb"(?<![\w.,])[+-]?\d+,\d+(?:[eE][+-]?\d+)?(?![\w.,])")


def refuse_decimal_commas(path: Path, text: bytes, line: int | None = None) -> None:
    """Of formats whose numbers are parted by blanks. text : the line or word that is no number.

    Raises InputError where it holds a number as a program with a comma locale writes it: left out,
    most of the model would be lost, and the rest would be wrong.
    """
    found = _DECIMAL_COMMA.search(text)
    if found is not None:
        raise InputError(
            Finding("table.decimal-comma", cell=found.group().decode("ascii")), file=path, line=line
        )


def points_missing(found: int, promised: int) -> Finding:
    """Return the message about a truncated cloud."""
    return Finding("model.incomplete", count=found, promised=promised, element=tr("points"))


def scale_colors(colors: AnyArray) -> ByteArray:
    """(n, 3) uint8 from bytes, 16-bit values, or floats in 0..1 or 0..255. NaN becomes white."""
    if colors.dtype == np.uint8:
        return np.ascontiguousarray(colors, dtype=np.uint8)
    if colors.dtype == np.uint16:
        if colors.size and colors.max() > 255:
            return (colors >> 8).astype(np.uint8)
        return colors.astype(np.uint8)
    scaled, top = np.empty(colors.shape, np.uint8), 0.0
    blocks = [slice(at, at + ROWS_AT_ONCE) for at in range(0, len(colors), ROWS_AT_ONCE)]
    for block in blocks:
        values = np.asarray(colors[block], np.float32)
        top = max(top, float(values.max(initial=0.0, where=np.isfinite(values))))
    scale = 255.0 if top <= 1.0 else 1.0 if top <= 255.0 else 255.0 / 65535.0
    for block in blocks:
        values = np.asarray(colors[block], np.float32)
        finite = np.isfinite(values)
        scaled[block] = np.clip(np.where(finite, values * scale + 0.5, 255.0), 0, 255)
    return scaled


def drop_unsound(mesh: Mesh, messages: list[Finding], path: Path) -> Mesh | PointCloud:
    """Without vertices that are no numbers and the faces that use them; a cloud if no face is left.

    Faces must lie within the vertices. Appends to `messages`. Raises InputError if nothing is left.
    """
    vertices, faces = mesh.vertices, mesh.faces
    finite = np.logical_and.reduce(np.isfinite(vertices), axis=1)
    offsets, uv, colors, fields = mesh.material_offsets, mesh.uv, mesh.colors, dict(mesh.fields)
    n_bad = int(len(finite) - np.count_nonzero(finite))
    if n_bad:
        keep = finite[faces].all(axis=1)
        n_faces = int(len(keep) - np.count_nonzero(keep))
        rows = np.cumsum(finite, dtype=np.int64).astype(np.int32) - 1
        faces = rows[faces[keep]]
        offsets = np.concatenate([[0], np.cumsum(keep)])[offsets].astype(np.int64)
        vertices = vertices[finite]
        uv = None if uv is None else uv[finite]
        colors = None if colors is None else colors[finite]
        fields = {name: values[finite] for name, values in fields.items()}
        messages.append(Finding("model.points-invalid", count=n_bad))
        if n_faces:
            messages.append(Finding("model.faces-invalid", count=n_faces))
    if len(vertices) == 0:
        raise InputError(Finding("model.no-points"), file=path)
    if len(faces) == 0:
        messages.append(Finding("model.opened-as-cloud"))
        return PointCloud(vertices, colors, None, fields)
    a, b, c = faces[:, 0], faces[:, 1], faces[:, 2]
    n_degenerate = int(np.count_nonzero((a == b) | (b == c) | (c == a)))
    if n_degenerate:
        messages.append(Finding("model.faces-without-area", count=n_degenerate))
    return Mesh(vertices, np.ascontiguousarray(faces), mesh.materials, offsets, uv, colors, fields)


def drop_unsound_points(cloud: PointCloud, messages: list[Finding], path: Path) -> PointCloud:
    """Without points that are no numbers. Raises InputError if none is left."""
    sound = np.isfinite(cloud.points)
    if len(sound) and sound.all():
        return cloud
    finite = np.logical_and.reduce(sound, axis=1)
    n_bad = int(len(finite) - np.count_nonzero(finite))
    if n_bad == len(finite):
        raise InputError(Finding("model.no-points"), file=path)
    messages.append(Finding("model.points-invalid", count=n_bad))
    return cloud.of_rows(finite)


def join_corners(
    corners: npt.NDArray[np.float32 | np.float64],
) -> tuple[FloatArray, Int32Array]:
    """Join equal corners of triangles.

    Parameters
    ----------
    corners : (3 m, 3) coordinates, three rows a triangle

    Returns
    -------
    vertices : (n, 3) array
        In the order in which they first occur.
    faces : (m, 3) array of int32
    """
    keys = place_keys(corners)
    order = np.argsort(keys, kind="stable")
    fresh = np.append(True, np.diff(keys[order]) != 0)
    del keys
    first = order[fresh]
    rank = np.empty(len(first), np.int32)
    by_place = np.argsort(first)
    rank[by_place] = np.arange(len(first), dtype=np.int32)
    faces = np.empty(len(order), np.int32)
    faces[order] = rank[np.cumsum(fresh) - 1]
    # -0 and 0 are one place.
    return corners[first[by_place]].astype(np.float64) + 0.0, faces.reshape(-1, 3)


class Columns:
    """Arrays that grow with what was really read, never with what a header promises, each as wide
    as its widest piece needs, and of objects where one holds more than numbers."""

    def __init__(self, at_first: int = ROWS_AT_FIRST) -> None:
        """at_first : rows to make room for at once; each time that an array grows it is copied."""
        self._at_first = at_first
        self._arrays: dict[str, AnyArray] = {}
        self._filled: dict[str, int] = {}

    def add(self, name: str, values: AnyArray, limit: int | None = None) -> None:
        """limit : rows that there can be at most, where that is known"""
        filled = self._filled.get(name, 0)
        needed = filled + len(values)
        array = self._arrays.get(name, values[:0])
        wide = _wide_enough(array.dtype, values.dtype)
        if len(array) < needed or wide != array.dtype:
            # What is not filled yet takes no memory.
            room = max(needed, 2 * filled, self._at_first)
            room = room if limit is None else max(min(limit, room), needed)
            wider = np.empty((room, *values.shape[1:]), wide)
            wider[:filled] = array[:filled]
            self._arrays[name] = array = wider
        array[filled:needed] = values
        self._filled[name] = needed

    def take(self, name: str, n: int) -> AnyArray | None:
        array = self._arrays.pop(name, None)
        if array is None:
            return None
        return array if len(array) == n else array[:n].copy()


def _wide_enough(one: np.dtype[Any], other: np.dtype[Any]) -> np.dtype[Any]:
    if one == other:
        return one
    return np.result_type(one, other) if {one.kind, other.kind} <= set("iuf") else np.dtype(object)
