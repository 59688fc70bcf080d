"""Check that all rows of a table have the same number of cells as its first row.

pandas fills short rows and does not report cells without a header, so a row with decimal commas
between comma separators, or a truncated row, would become a different point.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vomstudio.core.arrays import ByteArray, IntArray

_BLOCK = 1 << 24
_NEWLINE = ord("\n")
_BLANKS = np.zeros(256, bool)
_BLANKS[[ord(c) for c in " \t\r\n"]] = True


def has_equal_widths(data: bytes, delimiter: str, n_skipped_lines: int) -> bool:
    """Return whether all rows after `n_skipped_lines` lines have the same number of cells.

    Empty lines and comments do not count as rows. A delimiter at the end of a row adds a cell.
    """
    width: int | None = None
    for lines in _blocks(data, n_skipped_lines):
        counts = _count_cells(lines, delimiter)
        counts = counts[counts > 0]
        if width is None and len(counts):
            width = int(counts[0])
        if (counts != width).any():
            return False
    return True


def _blocks(data: bytes, n_skipped_lines: int) -> Iterator[ByteArray]:
    """Yield whole lines in blocks of a few megabytes."""
    position = 0
    for _ in range(n_skipped_lines):
        position = data.index(b"\n", position) + 1
    while position < len(data):
        stop = data.find(b"\n", position + _BLOCK)
        stop = len(data) if stop < 0 else stop + 1
        yield np.frombuffer(data, np.uint8, stop - position, position)
        position = stop


def _count_cells(lines: ByteArray, delimiter: str) -> IntArray:
    """Return the number of cells in each line, or 0 for lines that are not rows."""
    ends = np.flatnonzero(lines == _NEWLINE)
    if not len(ends) or ends[-1] != len(lines) - 1:
        ends = np.append(ends, len(lines))
    starts = np.concatenate([[0], ends[:-1] + 1])
    is_blank = _BLANKS[lines]
    cell_starts = np.flatnonzero(~is_blank & np.concatenate([[True], is_blank[:-1]]))
    first_cells = np.searchsorted(cell_starts, starts)
    count = np.searchsorted(cell_starts, ends) - first_cells
    has_cells = count > 0
    has_cells[has_cells] &= lines[cell_starts[first_cells[has_cells]]] != ord("#")
    if delimiter == " ":
        return np.where(has_cells, count, 0)
    delimiters = np.flatnonzero(lines == ord(delimiter))
    cells = np.searchsorted(delimiters, ends) - np.searchsorted(delimiters, starts) + 1
    return np.where(has_cells, cells, 0)
