"""Compiled loops for pictures of meshes."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel

MIN_EDGE_STEP_PIXELS = 3.0
"""Minimum depth step at an edge, measured from both neighbouring planes, in pixels."""


@kernel("void(f8[:,::1], i4[:,::1], f8, f8, f8, f8, i8, i8, i8[::1], i4[::1])")
def bin_faces(view, faces, left, top, cell_size, margin, columns, rows, starts, members):  # type: ignore[no-untyped-def]
    """Assign faces to tiles (columns x rows, each `cell_size` metres wide).

    The function is called twice. If `members` is empty, the faces of tile t are counted in starts[t
    + 1]. In the second call, with cumulative starts, `members` is filled and starts[t] moves to the
    end of tile t.
    """
    is_filling = len(members) > 0
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        x_low = min(view[a, 0], view[b, 0], view[c, 0]) - margin
        x_high = max(view[a, 0], view[b, 0], view[c, 0]) + margin
        y_low = min(view[a, 1], view[b, 1], view[c, 1]) - margin
        y_high = max(view[a, 1], view[b, 1], view[c, 1]) + margin
        i0 = max(math.floor((x_low - left) / cell_size), 0)
        i1 = min(math.floor((x_high - left) / cell_size), columns - 1)
        j0 = max(math.floor((y_low - top) / cell_size), 0)
        j1 = min(math.floor((y_high - top) / cell_size), rows - 1)
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                t = j * columns + i
                if is_filling:
                    members[starts[t]] = f
                    starts[t] += 1
                else:
                    starts[t + 1] += 1


@kernel("void(f8[:,::1], i4[:,::1], i4[:,::1], f8[:,::1], f8, b1[:,::1])")
def find_edges(view, faces, face, depth, gsd, edge):  # type: ignore[no-untyped-def]
    """Mark pixels beside a jump in depth or beside empty pixels.

    A jump exceeds `MIN_EDGE_STEP_PIXELS` times the pixel size as measured from the planes of both
    adjacent triangles, so that a slope is not an edge.
    """
    h, w = face.shape
    for j in range(h):
        for i in range(w):
            for axis in range(2):
                j2, i2 = j + axis, i + 1 - axis
                if j2 >= h or i2 >= w:
                    continue
                f, g = face[j, i], face[j2, i2]
                if f == g:
                    continue
                is_jump = f < 0 or g < 0
                if not is_jump:
                    step = depth[j2, i2] - depth[j, i]
                    min_step = math.inf
                    for k in (f, g):
                        a, b, c = faces[k, 0], faces[k, 1], faces[k, 2]
                        ex, ey = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1]
                        fx, fy = view[c, 0] - view[a, 0], view[c, 1] - view[a, 1]
                        ez, fz = view[b, 2] - view[a, 2], view[c, 2] - view[a, 2]
                        det = ex * fy - ey * fx
                        if det != 0.0:
                            if axis == 0:
                                slope = (ez * fy - ey * fz) / det
                            else:
                                slope = (ex * fz - ez * fx) / det
                            # A face seen almost edge-on can explain any step.
                            if abs(slope) < 20.0:
                                min_step = min(min_step, abs(step - slope * gsd))
                    is_jump = min(min_step, abs(step)) > MIN_EDGE_STEP_PIXELS * gsd
                if is_jump:
                    edge[j, i] = True
                    edge[j2, i2] = True


@kernel("void(i8[::1], i4[::1], f8[:,::1], i4[:,::1], u1[:,::1], u1[:,::1])")
def blend_corners(rows, face, weights, faces, colors, rgb):  # type: ignore[no-untyped-def]
    """Interpolate the colours of the pixels `rows` between those of the face corners.

    `colors` are the vertex colours (n, 3).
    """
    for index in range(len(rows)):
        k = rows[index]
        f = face[k]
        u, v = weights[k, 0], weights[k, 1]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        for i in range(3):
            x = (1 - u - v) * colors[a, i] + u * colors[b, i] + v * colors[c, i]
            rgb[k, i] = int(min(max(x + 0.5, 0.0), 255.0))
