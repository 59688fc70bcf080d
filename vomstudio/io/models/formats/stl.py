"""STL, as text or binary data: separate triangles whose equal corners are merged."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import ByteArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.formats._common import (
    BLOCK_BYTES,
    drop_invalid_vertices,
    join_corners,
    read_whole_file,
    refuse_decimal_commas,
    to_utf8,
)
from vomstudio.io.models.formats._decimals import python_number
from vomstudio.io.models.offset_file import read_offset
from vomstudio.io.models.reader import LoadedModel, Reader
from vomstudio.io.text.encodings import MARKS, convert_to_utf8

HEADER_BYTES, RECORD_BYTES = 84, 50
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
MAX_FAST_WORD_LENGTH = 64
MAX_FACES = 2**31 // 3
_VERTEX = re.compile(rb"(?i)\bvertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)")
_LOOP = re.compile(rb"(?i)\bouter\s+loop\b")
LOOK_BACK_BYTES = 64 * 1024


def matches(path: Path, head: bytes) -> bool:
    """Return whether the file is STL text; binary files may begin with the same word."""
    return b"\0" not in head and head.lstrip()[:5].lower() == b"solid" and b"facet" in head.lower()


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read the triangles of an STL file and merge equal corners.

    The origin in `NAME.offset.txt` is added in float64. Raises InputError if the file contains
    no valid triangles.
    """
    data = read_whole_file(path, progress)
    findings: list[Finding] = []
    corners = (
        _read_binary(data, path, findings)
        if _is_binary(data)
        else _read_text(data, path, progress, findings)
    )
    del data
    if len(corners) == 0:
        raise InputError(Finding("model.no-faces"), file=path)
    vertices, faces = join_corners(corners)
    offset = read_offset(path)
    if offset.origin is not None:
        vertices += offset.origin
    if offset.problem:
        findings.append(offset.problem)
    model = drop_invalid_vertices(Mesh(vertices, faces), findings, path)
    kind: Literal["mesh", "cloud"] = "mesh" if isinstance(model, Mesh) else "cloud"
    return LoadedModel(model, kind, offset.crs, tuple(findings), path)


def _is_binary(data: ByteArray) -> bool:
    """Return whether a file is binary.

    This is the case if its length matches its count, or if it does not begin like text.
    """
    if len(data) >= HEADER_BYTES:
        (count,) = struct.unpack_from("<I", data.data, 80)
        if len(data) == HEADER_BYTES + RECORD_BYTES * count:
            return True
    head = data[:4096].tobytes()
    if head[:2] in MARKS:
        return False
    head = convert_to_utf8(head)
    return b"\0" in head or head.lstrip()[:5].lower() != b"solid"


def _read_binary(
    data: ByteArray, path: Path, findings: list[Finding]
) -> npt.NDArray[np.float32 | np.float64]:
    if len(data) < HEADER_BYTES:
        raise InputError(Finding("file.other-format", format="STL"), file=path)
    (stated_records,) = struct.unpack_from("<I", data.data, 80)
    available_records = (len(data) - HEADER_BYTES) // RECORD_BYTES
    count = min(stated_records, available_records)
    if count > MAX_FACES:
        raise InputError(Finding("model.too-many-elements", limit=MAX_FACES), file=path)
    if available_records < stated_records:
        findings.append(
            Finding(
                "model.incomplete",
                count=available_records,
                promised=stated_records,
                element=tr("faces"),
            )
        )
    elif available_records > stated_records:
        findings.append(Finding("model.trailing-bytes", count=stated_records))
    records = data[HEADER_BYTES : HEADER_BYTES + count * RECORD_BYTES].view(RECORD)
    if records["attribute"].any():
        findings.append(Finding("model.face-colors-unused"))
    return np.ascontiguousarray(records["corners"]).reshape(-1, 3)


def _read_text(
    data: ByteArray, path: Path, progress: Progress, findings: list[Finding]
) -> npt.NDArray[np.float32 | np.float64]:
    # The keywords separate the loops: a missing or additional corner must not shift the others.
    text = to_utf8(data)
    progress.stage(tr("Reading the triangles"), len(text))
    numbers, loop_counts, facet_count, is_checked = [], [], 0, False
    for start, block in _blocks(text):
        vertex_matches = list(_VERTEX.finditer(block))
        starts = np.array([match.start() for match in vertex_matches], np.int64)
        loop_starts = np.array([match.start() for match in _LOOP.finditer(block)], np.int64)
        number_texts = [match.groups() for match in vertex_matches]
        values = _numbers(number_texts) if number_texts else np.empty((0, 3))
        invalid_rows = np.flatnonzero(np.isnan(values).any(axis=1))
        if len(invalid_rows) and not is_checked:
            is_checked, position = True, start + int(starts[invalid_rows[0]])
            line = 1 + int(np.count_nonzero(text[:position] == ord("\n")))
            refuse_decimal_commas(path, b" ".join(number_texts[invalid_rows[0]]), line)
        numbers.append(values)
        loop_counts.append((facet_count + np.searchsorted(loop_starts, starts)).astype(np.int32))
        facet_count += len(loop_starts)
        progress.step(start + len(block))
    corners, loop_ids = np.concatenate(numbers), np.concatenate(loop_counts)
    del numbers, loop_counts
    if not len(corners):
        raise InputError(Finding("model.no-faces"), file=path)
    # They are in order, so the corners of a loop are contiguous.
    first_rows = np.flatnonzero(np.diff(loop_ids, prepend=-1))
    counts = np.diff(first_rows, append=len(loop_ids))
    is_triangle = (counts == 3) & (loop_ids[first_rows] > 0)
    incomplete_count = int(len(first_rows) - np.count_nonzero(is_triangle))
    if incomplete_count:
        findings.append(Finding("model.faces-incomplete", count=incomplete_count))
    if b"endsolid" not in text[-4096:].tobytes().lower():
        findings.append(Finding("model.maybe-cut-short", end="endsolid"))
    if incomplete_count:
        corners = corners[(first_rows[is_triangle][:, None] + np.arange(3)).reshape(-1)]
    return corners


def _blocks(text: ByteArray) -> Iterator[tuple[int, bytes]]:
    """Yield start and bytes of each block; all but the last end before a vertex keyword."""
    start, size = 0, BLOCK_BYTES
    while start < len(text):
        block = text[start : start + size].tobytes()
        if start + size < len(text):
            last_row = 0
            for match in _VERTEX.finditer(block, max(0, len(block) - LOOK_BACK_BYTES)):
                last_row = match.start()
            if last_row == 0:
                # Enlarge the block until it contains a corner near its end.
                size *= 2
                continue
            block = block[:last_row]
        yield start, block
        start, size = start + len(block), BLOCK_BYTES


def _numbers(number_texts: Sequence[tuple[bytes, ...]]) -> FloatArray:
    """Return coordinates (n, 3), NaN for words that are not numbers.

    A fixed width would truncate longer words, and the beginning of
    1.00000000000000000000000000000000e5 is also a number.
    """
    max_length = max(len(word) for row in number_texts for word in row)
    if max_length <= MAX_FAST_WORD_LENGTH:
        try:
            return np.array(number_texts, dtype=f"S{max_length}").astype(np.float64)
        except ValueError:
            pass
    values = [python_number(word) for row in number_texts for word in row]
    return np.array([np.nan if value is None else value for value in values]).reshape(-1, 3)


READER = Reader(to_translate("STL mesh"), (".stl",), matches, read)
