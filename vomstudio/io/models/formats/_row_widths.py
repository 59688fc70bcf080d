"""Whether the rows of a table have as many cells as its first one.

pandas fills short rows up and says nothing of the cells that a header does not name: a row with
decimal commas between commas, or one that was cut off, would become another point.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vomstudio.core.arrays import ByteArray, IntArray

_BLOCK = 1 << 24
_NEWLINE = ord("\n")
_BLANKS = np.zeros(256, bool)
_BLANKS[[ord(c) for c in " \t\r\n"]] = True


def are_even(data: bytes, delimiter: str, skip: int) -> bool:
    """Whether all rows below the first `skip` lines are equally wide. Empty lines and comments are
    no rows; of rows that end in a delimiter all must."""
    wanted: int | None = None
    for lines in _blocks(data, skip):
        counts = _cells(lines, delimiter)
        counts = counts[counts > 0]
        if wanted is None and len(counts):
            wanted = int(counts[0])
        if (counts != wanted).any():
            return False
    return True


def _blocks(data: bytes, skip: int) -> Iterator[ByteArray]:
    """Whole lines, some megabytes at a time."""
    at = 0
    for _ in range(skip):
        at = data.index(b"\n", at) + 1
    while at < len(data):
        stop = data.find(b"\n", at + _BLOCK)
        stop = len(data) if stop < 0 else stop + 1
        yield np.frombuffer(data, np.uint8, stop - at, at)
        at = stop


def _cells(lines: ByteArray, delimiter: str) -> IntArray:
    """Of each line; 0 of those that are no rows."""
    ends = np.flatnonzero(lines == _NEWLINE)
    if not len(ends) or ends[-1] != len(lines) - 1:
        ends = np.append(ends, len(lines))
    starts = np.concatenate([[0], ends[:-1] + 1])
    blank = _BLANKS[lines]
    words = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    first = np.searchsorted(words, starts)
    count = np.searchsorted(words, ends) - first
    rows = count > 0
    rows[rows] &= lines[words[first[rows]]] != ord("#")
    if delimiter == " ":
        return np.where(rows, count, 0)
    parts = np.flatnonzero(lines == ord(delimiter))
    cells = np.searchsorted(parts, ends) - np.searchsorted(parts, starts) + 1
    return np.where(rows, cells, 0)
