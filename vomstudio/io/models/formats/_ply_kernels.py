"""Compiled passes over PLY records with lists of different lengths, and over text rows."""

from __future__ import annotations

import numpy as np

from vomstudio.geometry.kernels.jit import kernel, part
from vomstudio.io.models.formats._decimals import READY, is_space, number


@part
def _read_count(data, offset, size, is_signed, is_little_endian):  # type: ignore[no-untyped-def]
    value = np.int64(0)
    for k in range(size):
        byte = data[offset + (size - 1 - k if is_little_endian else k)]
        value = value * 256 + np.int64(byte)
    if is_signed and value >= np.int64(1) << (8 * size - 1):
        value -= np.int64(1) << (8 * size)
    return value


@kernel(
    "int64(uint8[::1], int64, int64[::1], int64[::1], boolean[::1], boolean, int64[:,::1],"
    " int64[:,::1])"
)
def locate_values(  # type: ignore[no-untyped-def]
    data, offset, sizes, count_sizes, is_count_signed, is_little_endian, positions, counts
):
    """Find the start of each value of each record, filling `positions` and `counts` (n, k).

    sizes (k,): bytes of a value or of a list item; count_sizes (k,): bytes of a list length, 0 for
    a plain value. Returns the number of complete records.
    """
    end = data.shape[0]
    for i in range(positions.shape[0]):
        for j in range(sizes.shape[0]):
            n = np.int64(1)
            if count_sizes[j] > 0:
                if offset + count_sizes[j] > end:
                    return i
                n = _read_count(data, offset, count_sizes[j], is_count_signed[j], is_little_endian)
                offset += count_sizes[j]
            if n < 0 or n > (end - offset) // sizes[j]:
                return i
            positions[i, j] = offset
            counts[i, j] = n
            offset += n * sizes[j]
    return positions.shape[0]


@kernel("void(uint8[::1], int64[:], int64[:], int64, uint8[::1])")
def gather(data, positions, counts, size, out):  # type: ignore[no-untyped-def]
    """Copy the bytes of lists with items of `size` bytes, one list after the other."""
    offset = 0
    for i in range(positions.shape[0]):
        n = counts[i] * size
        for k in range(n):
            out[offset + k] = data[positions[i] + k]
        offset += n


@kernel(
    "Tuple((int64, int64, int64))(uint8[::1], int64, int64, int64[::1], float64[::1], int64[:,::1])"
)
def rows(data, offset, max_rows, starts, values, unparsed):  # type: ignore[no-untyped-def]
    """Parse the numbers of up to `max_rows` text lines, or until `values` could overflow.

    Parsing begins at byte `offset`; starts (max_rows + 1,) receives the index in `values` at which
    each row begins. unparsed (any, 3): index of the value, start and end, terminated by -1. `data`
    ends with a newline. Returns the next byte, row and value.
    """
    end = data.shape[0]
    unparsed_count = 0
    row = 0
    filled_count = 0
    while offset < end and row < max_rows:
        stop = offset
        while data[stop] != 10:
            stop += 1
        if filled_count + (stop - offset) // 2 + 1 > values.shape[0]:
            break
        if unparsed_count + (stop - offset) // 2 + 1 > unparsed.shape[0]:
            break
        first_value = filled_count
        i = offset
        while True:
            while is_space(data[i]):
                i += 1
            if i >= stop:
                break
            start = i
            value, state, i = number(data, i, stop)
            if state != READY:
                value = np.nan
                unparsed[unparsed_count, 0] = filled_count
                unparsed[unparsed_count, 1] = start
                unparsed[unparsed_count, 2] = i
                unparsed_count += 1
            values[filled_count] = value
            filled_count += 1
        offset = stop + 1
        if filled_count > first_value:
            starts[row] = first_value
            row += 1
            starts[row] = filled_count
    if unparsed_count < unparsed.shape[0]:
        unparsed[unparsed_count, 0] = -1
    return offset, row, filled_count


@kernel("void(float64[::1], int64[::1], boolean[::1], int64[:,::1], int64[:,::1])")
def locate_row_values(values, starts, is_list, positions, counts):  # type: ignore[no-untyped-def]
    """Apply `locate_values` to rows of numbers. Rows that are too short get counts of 0."""
    for i in range(positions.shape[0]):
        offset = starts[i]
        end = starts[i + 1]
        is_valid = True
        for j in range(is_list.shape[0]):
            n = np.int64(1)
            if is_list[j]:
                if offset >= end or not 0 <= values[offset] <= end - offset - 1:
                    is_valid = False
                    break
                n = np.int64(values[offset])
                offset += 1
            if n > end - offset:
                is_valid = False
                break
            positions[i, j] = offset
            counts[i, j] = n
            offset += n
        if not is_valid:
            for j in range(is_list.shape[0]):
                positions[i, j] = 0
                counts[i, j] = 0


@kernel("void(float64[::1], int64[:], int64[:], float64[::1])")
def gather_values(values, positions, counts, out):  # type: ignore[no-untyped-def]
    offset = 0
    for i in range(positions.shape[0]):
        for k in range(counts[i]):
            out[offset] = values[positions[i] + k]
            offset += 1


@kernel(
    "Tuple((int64, int64, int64, int64))(int64[::1], int64[::1], int64, int64[::1], int32[:,::1],"
    " int32[:,::1], int32[::1], int64[:,::1])"
)
def triangulate_fans(  # type: ignore[no-untyped-def]
    counts, indices, n_vertices, uv_counts, corners, uv_corners, face_rows, polygons
):
    """Convert polygons to fans of triangles, omitting those with invalid vertex indices.

    counts (n,), indices (sum of counts,); uv_counts (n,): length of the list of texture coordinates
    of each face, or no rows. corners, uv_corners and face_rows have space for every triangle;
    uv_corners may have no rows. Returns the numbers of triangles, of polygons with more than 3
    corners, of faces out of range, and of faces with fewer than 3 corners.
    """
    t = 0
    p = 0
    n_out_of_range = 0
    n_short = 0
    offset = 0
    uv_offset = 0
    needs_uv = uv_corners.shape[0] > 0
    for i in range(counts.shape[0]):
        n = counts[i]
        has_uv = needs_uv and uv_counts[i] == 2 * n
        is_invalid = False
        for k in range(n):
            if indices[offset + k] < 0 or indices[offset + k] >= n_vertices:
                is_invalid = True
        if n < 3:
            n_short += 1
        elif is_invalid:
            n_out_of_range += 1
        else:
            if n > 3:
                polygons[p, 0] = t
                polygons[p, 1] = n
                p += 1
            for k in range(1, n - 1):
                corners[t, 0] = indices[offset]
                corners[t, 1] = indices[offset + k]
                corners[t, 2] = indices[offset + k + 1]
                if needs_uv:
                    uv_corners[t, 0] = uv_offset // 2 if has_uv else -1
                    uv_corners[t, 1] = uv_offset // 2 + k if has_uv else -1
                    uv_corners[t, 2] = uv_offset // 2 + k + 1 if has_uv else -1
                face_rows[t] = i
                t += 1
        offset += n
        if needs_uv:
            uv_offset += uv_counts[i]
    return t, p, n_out_of_range, n_short
