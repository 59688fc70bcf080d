"""Compiled passes over the bytes of an OBJ file.

`count` returns the number of elements in a block of lines, so that `parse` can write directly into
the final arrays, with several blocks in parallel. Both must agree on what a line is.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.geometry.kernels.jit import kernel, part, step
from vomstudio.io.models.formats._decimals import READY, UNPARSED, is_space, number

# Rows of the result of `count`.
N_VERTICES, N_UVS, N_TRIANGLES, N_WORDS, N_POLYGONS, N_UNKNOWN, N_SHORT_FACES, N_COLORED = range(8)
N_LINE_ELEMENTS = 8
COUNT_SIZE = 9

# Rows of the report of `parse`.
R_UNPARSED, R_BAD_CORNERS, R_FIRST_BAD_CORNER, R_BAD_UVS, R_FIRST_BAD_UV = range(5)
R_NO_NUMBERS, R_FIRST_NO_NUMBER, R_COLORED = range(5, 8)
REPORT_SIZE = 8

# Target arrays of left-over numbers.
TO_VERTEX, TO_UV, TO_COLOR = range(3)

# Kinds of lines.
_NONE, _VERTEX, _UV, _FACE, _WORD, _IGNORED, _UNKNOWN, _LINE_ELEMENT = range(8)


@part
def _classify(data, i, end):  # type: ignore[no-untyped-def]
    """Return the kind of the line that starts at i, and the position of its values.

    data[end - 1] is a newline.
    """
    while is_space(data[i]):
        i += 1
    c = data[i]
    if c == 10 or c == 35:
        return _NONE, i
    d = data[i + 1] if i + 1 < end else np.uint8(10)
    is_separator = is_space(d) or d == 10
    if c == 118:  # v
        if is_separator:
            return _VERTEX, i + 1
        e = data[i + 2] if i + 2 < end else np.uint8(10)
        if d == 116 and (is_space(e) or e == 10):
            return _UV, i + 2
        if d == 110 or d == 112:  # vn, vp
            return _IGNORED, i
        return _UNKNOWN, i
    if c == 102 and is_separator:  # f
        return _FACE, i + 1
    if c == 117 or c == 109:  # usemtl, mtllib, mg ...
        return _WORD, i
    if (c == 103 or c == 111 or c == 115) and is_separator:  # g, o, s
        return _IGNORED, i
    if (c == 108 or c == 112) and is_separator:  # l, p
        return _LINE_ELEMENT, i
    return _UNKNOWN, i


@kernel("void(uint8[::1], int64, int64, int64[::1])")
def count(data, start, end, counts):  # type: ignore[no-untyped-def]
    """Count the elements in data[start:end].

    `start` is the beginning of a line; the last byte is a newline.
    """
    i = start
    while i < end:
        kind, i = _classify(data, i, end)
        if kind == _VERTEX:
            if counts[N_VERTICES] == 0 and counts[N_COLORED] == 0:
                # Colours are only detected on the first vertex of each block. If any block has
                # colours, `parse` reads them everywhere, and it reports those that it was not
                # expecting.
                values = 0
                is_inside = False
                while data[i] != 10 and data[i] != 35:
                    is_blank = is_space(data[i])
                    if not is_blank and not is_inside:
                        values += 1
                    is_inside = not is_blank
                    i += 1
                if values >= 6:
                    counts[N_COLORED] += 1
            counts[N_VERTICES] += 1
        elif kind == _UV:
            counts[N_UVS] += 1
        elif kind == _FACE:
            corners = 0
            is_inside = False
            while data[i] != 10:
                is_blank = is_space(data[i])
                if not is_blank and not is_inside:
                    if data[i] == 35:
                        break
                    corners += 1
                is_inside = not is_blank
                i += 1
            if corners >= 3:
                counts[N_TRIANGLES] += corners - 2
                if corners > 3:
                    counts[N_POLYGONS] += 1
            else:
                counts[N_SHORT_FACES] += 1
        elif kind == _WORD:
            counts[N_WORDS] += 1
        elif kind == _UNKNOWN:
            counts[N_UNKNOWN] += 1
        elif kind == _LINE_ELEMENT:
            counts[N_LINE_ELEMENTS] += 1
        while data[i] != 10:
            i += 1
        i += 1


@part
def _integer(data, i):  # type: ignore[no-untyped-def]
    is_negative = False
    if data[i] == 45:
        is_negative = True
        i += 1
    elif data[i] == 43:
        i += 1
    value = np.int64(0)
    first_digit = i
    while 48 <= data[i] <= 57:
        if value < 100000000000:
            value = value * 10 + (np.int64(data[i]) - 48)
        i += 1
    return (-value if is_negative else value), i > first_digit, i


@part
def _line_end(data, i):  # type: ignore[no-untyped-def]
    while data[i] != 10:
        i += 1
    return i


@part
def _record_problem(report, count_row, offset_row, offset):  # type: ignore[no-untyped-def]
    """Count a problem, and store the position of its first occurrence."""
    if report[count_row] == 0:
        report[offset_row] = offset
    report[count_row] += 1


@part
def _record_unparsed(unparsed, report, target, flat_index, start, end):  # type: ignore[no-untyped-def]
    """Record a number to be parsed by Python, as long as `unparsed` has space."""
    r = report[R_UNPARSED]
    if r < unparsed.shape[0]:
        unparsed[r, 0] = target
        unparsed[r, 1] = flat_index
        unparsed[r, 2] = start
        unparsed[r, 3] = end
    report[R_UNPARSED] += 1


@step
def _color(colors, v, n, value, token, state, unparsed, report):  # type: ignore[no-untyped-def]
    """Store the colour of a vertex, which follows the coordinates in a line of n numbers.

    The colour is NaN if the line has none.
    """
    for k in range(3):
        colors[v, k] = value[3 + k] if n >= 6 else np.nan
        if n >= 6 and state[3 + k] == UNPARSED:
            _record_unparsed(
                unparsed, report, TO_COLOR, v * 3 + k, token[3 + k, 0], token[3 + k, 1]
            )


@step
def _face(data, i, v, u, n_vertices, n_uvs, t, corners, uv_corners, report):  # type: ignore[no-untyped-def]
    """Parse the corners from i to the end of the line as a fan of triangles starting at t.

    Returns the number of corners, whether one is invalid, the next triangle, and the end of the
    last corner.
    """
    line = i
    n = 0
    is_invalid = False
    needs_uv = uv_corners.shape[0] > 0
    first_v = first_u = last_v = last_u = np.int64(-1)
    while True:
        while is_space(data[i]):
            i += 1
        if data[i] == 10 or data[i] == 35:
            break
        a, is_valid, i = _integer(data, i)
        b = np.int64(0)
        has_b = False
        if is_valid and data[i] == 47:
            b, has_b, i = _integer(data, i + 1)
            if data[i] == 47:
                _, _, i = _integer(data, i + 1)
        if data[i] != 10 and not is_space(data[i]):
            is_valid = False
            while data[i] != 10 and not is_space(data[i]):
                i += 1
        # 1 is the first row, -1 the last row so far, and 0 is not valid.
        row = np.int64(a - 1 if a > 0 else (a + v if a < 0 else -1))
        if not is_valid or row < 0 or row >= n_vertices:
            row = np.int64(-1)
            is_invalid = True
        uv_row = np.int64((b - 1 if b > 0 else (b + u if b < 0 else -1)) if has_b else -1)
        if uv_row < 0 or uv_row >= n_uvs:
            uv_row = np.int64(-1)
            if has_b:
                _record_problem(report, R_BAD_UVS, R_FIRST_BAD_UV, line)
        if n == 0:
            first_v = row
            first_u = uv_row
        elif n >= 2:
            corners[t, 0] = first_v
            corners[t, 1] = last_v
            corners[t, 2] = row
            if needs_uv:
                uv_corners[t, 0] = first_u
                uv_corners[t, 1] = last_u
                uv_corners[t, 2] = uv_row
            t += 1
        last_v = row
        last_u = uv_row
        n += 1
    return n, is_invalid, t, i


def create_line_buffers() -> tuple[FloatArray, IntArray, IntArray]:
    """Return work arrays for `parse`.

    They are allocated here because a kernel without allocations loads without numba.
    """
    return np.empty(8), np.empty((8, 2), np.int64), np.empty(8, np.int64)


@kernel(
    "void(uint8[::1], int64, int64, int64[::1], int64, int64, float64[:,::1], float64[:,::1],"
    " float32[:,::1], int32[:,::1], int32[:,::1], int64[:,::1], int64[:,::1], int64[:,::1],"
    " int64[::1], float64[::1], int64[:,::1], int64[::1])"
)
def parse(  # type: ignore[no-untyped-def]
    data,
    start,
    end,
    base,
    n_vertices,
    n_uvs,
    vertices,
    uvs,
    colors,
    corners,
    uv_corners,
    words,
    polygons,
    unparsed,
    report,
    value,
    token,
    state,
):
    """Parse one block into the final arrays, starting at the rows `base` (as in `count`).

    corners, uv_corners (m, 3): rows of vertices and uvs, -1 if invalid or missing; uv_corners and
    colors may have no rows, in which case they are not read. words (k, 3): start, end, and the
    triangle before which the line is located. polygons (p, 2): first triangle of the fan, number of
    corners. unparsed (any, 4): target, flat index, start, end; counting continues beyond its rows.
    value, token, state: working space for the numbers of a line, see `create_line_buffers`.
    """
    v, u, t = base[N_VERTICES], base[N_UVS], base[N_TRIANGLES]
    w, p = base[N_WORDS], base[N_POLYGONS]
    needs_colors = colors.shape[0] > 0
    i = start
    while i < end:
        kind, i = _classify(data, i, end)
        if kind in (_VERTEX, _UV):
            maximum = 8 if kind == _VERTEX else 2
            n = 0
            while n < maximum:
                while is_space(data[i]):
                    i += 1
                if data[i] == 10 or data[i] == 35:
                    break
                stop = i
                while data[stop] != 10 and not is_space(data[stop]):
                    stop += 1
                token[n, 0] = i
                value[n], state[n], i = number(data, i, stop)
                if state[n] != READY:
                    value[n] = np.nan
                    if state[n] != UNPARSED:
                        _record_problem(report, R_NO_NUMBERS, R_FIRST_NO_NUMBER, token[n, 0])
                token[n, 1] = i
                n += 1
            if kind == _UV and n == 1:
                value[1], state[1], n = 0.0, READY, 2  # a one-dimensional texture
            row, width = (v, 3) if kind == _VERTEX else (u, 2)
            for k in range(width):
                x = value[k] if k < n else np.nan
                if k < n and state[k] == UNPARSED:
                    target = TO_VERTEX if kind == _VERTEX else TO_UV
                    _record_unparsed(
                        unparsed, report, target, row * width + k, token[k, 0], token[k, 1]
                    )
                if kind == _VERTEX:
                    vertices[row, k] = x
                else:
                    uvs[row, k] = x
            if kind == _VERTEX and needs_colors:
                _color(colors, v, n, value, token, state, unparsed, report)
            elif kind == _VERTEX and n >= 6:
                report[R_COLORED] += 1
            if kind == _VERTEX:
                v += 1
            else:
                u += 1
        elif kind == _FACE:
            line = i
            t0 = t
            n, is_invalid, t, i = _face(
                data, i, v, u, n_vertices, n_uvs, t, corners, uv_corners, report
            )
            if n > 3:
                polygons[p, 0] = t0
                polygons[p, 1] = n
                p += 1
            if is_invalid and n >= 3:
                for k in range(t0, t):
                    corners[k, 0] = -1
                _record_problem(report, R_BAD_CORNERS, R_FIRST_BAD_CORNER, line)
        elif kind == _WORD:
            words[w, 0] = i
            words[w, 1] = _line_end(data, i)
            words[w, 2] = t
            w += 1
        i = _line_end(data, i) + 1


@kernel(
    "int64(int32[:,::1], int32[:,::1], int64, int32[::1], int32[::1], int32[::1], int32[:,::1])"
)
def split_rows(corners, uv_corners, n, source, texture, next_rows, out):  # type: ignore[no-untyped-def]
    """Run `split_vertices` on preallocated arrays; `next_rows` links rows of one position."""
    for i in range(n):
        source[i] = i
        texture[i] = -2
        next_rows[i] = -1
    for i in range(corners.shape[0]):
        for k in range(3):
            v = corners[i, k]
            u = uv_corners[i, k]
            if texture[v] == -2:
                texture[v] = u
                out[i, k] = v
                continue
            row = np.int64(v)
            while texture[row] != u and next_rows[row] >= 0:
                row = np.int64(next_rows[row])
            if texture[row] != u:
                source[n] = v
                texture[n] = u
                next_rows[n] = -1
                next_rows[row] = n
                row = np.int64(n)
                n += 1
            out[i, k] = row
    return n


def split_vertices(
    corners: Int32Array, uv_corners: Int32Array, n_vertices: int
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """Create one vertex for each pair of position and texture coordinate in corners (m, 3).

    A position keeps its row for its first texture coordinate; further ones get new rows at the end.
    Returns the corners with the new rows, and the position and texture coordinate (-1 if missing)
    of each row.
    """
    # Maximum possible size; memory that is not written to is not used.
    capacity = n_vertices + corners.size
    source, texture, next_rows = (np.empty(capacity, np.int32) for _ in range(3))
    out = np.empty(corners.shape, np.int32)
    n = split_rows(
        np.ascontiguousarray(corners),
        np.ascontiguousarray(uv_corners),
        n_vertices,
        source,
        texture,
        next_rows,
        out,
    )
    return out, source[:n], np.where(texture[:n] < 0, np.int32(-1), texture[:n])
