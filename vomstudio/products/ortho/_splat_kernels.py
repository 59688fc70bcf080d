"""Compiled loops that splat points."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel

MAX_DEPTH_RADII = 3.0
"""Maximum depth of a point behind the nearest point of the same surface, in radii."""

MAX_SLOPE = 12.0
"""Maximum slope, depth per width (85 degrees); steeper surfaces are treated as this steep."""


@kernel("void(f8[:,::1], f8[::1], f8, f8, f8, f8, i8, i8, i8[::1], i4[::1])")
def bin_points(view, radius, left, top, cell_size, margin, columns, rows, starts, members):  # type: ignore[no-untyped-def]
    """Assign points to tiles as in `bin_faces`, with a radius per point and a margin, m."""
    is_filling = len(members) > 0
    for p in range(len(view)):
        r = radius[p] + margin
        i0 = max(math.floor((view[p, 0] - r - left) / cell_size), 0)
        i1 = min(math.floor((view[p, 0] + r - left) / cell_size), columns - 1)
        j0 = max(math.floor((view[p, 1] - r - top) / cell_size), 0)
        j1 = min(math.floor((view[p, 1] + r - top) / cell_size), rows - 1)
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                t = j * columns + i
                if is_filling:
                    members[starts[t]] = p
                    starts[t] += 1
                else:
                    starts[t + 1] += 1


@kernel(
    "void(i4[::1], f8[:,::1], f8[::1], u1[:,::1], f8, f8, f8, f4[:,::1], f4[:,::1], f4[:,:,::1],"
    " f4[:,::1], f8[:,::1])"
)
def splat(  # type: ignore[no-untyped-def]
    members, view, reach, colors, left, top, gsd, nearest, limit, color, weight, depth
):
    """Draw points as discs that face the viewer, in two passes.

    The first pass determines the depth of the surface in each pixel. The second pass averages the
    points at this depth, weighted by their distance from the pixel centre. Drawing only the nearest
    disc would shift a slope towards its near side, whereas a weighted mean of all points of the
    surface does not. On a steep surface, these points extend deeper behind the nearest one. The
    slope is computed from the nearest points of the surrounding pixels; the smaller of the
    differences to both sides is used, because the edge of a surface is not a slope. On entry,
    `nearest` must be infinite, and limit, color, weight and depth must be zero.
    """
    h, w = nearest.shape
    for pass_index in range(2):
        if pass_index == 1:
            for j in range(h):
                for i in range(w):
                    limit[j, i] = MAX_DEPTH_RADII
                    if nearest[j, i] == math.inf:
                        continue
                    depth_step_x, depth_step_y = 0.0, 0.0
                    if 0 < i < w - 1:
                        depth_step = abs(nearest[j, i] - nearest[j, i - 1])
                        depth_step_x = min(depth_step, abs(nearest[j, i + 1] - nearest[j, i]))
                    if 0 < j < h - 1:
                        depth_step = abs(nearest[j, i] - nearest[j - 1, i])
                        depth_step_y = min(depth_step, abs(nearest[j + 1, i] - nearest[j, i]))
                    slope = min(
                        math.sqrt(depth_step_x * depth_step_x + depth_step_y * depth_step_y) / gsd,
                        MAX_SLOPE,
                    )
                    limit[j, i] = max(MAX_DEPTH_RADII, 2.0 * slope)
        for index in range(len(members)):
            p = members[index]
            x = (view[p, 0] - left) / gsd
            y = (view[p, 1] - top) / gsd
            z = view[p, 2]
            r = reach[p] / gsd
            i0, i1 = max(math.ceil(x - r - 0.5), 0), min(math.floor(x + r - 0.5), w - 1)
            j0, j1 = max(math.ceil(y - r - 0.5), 0), min(math.floor(y + r - 0.5), h - 1)
            for j in range(j0, j1 + 1):
                for i in range(i0, i1 + 1):
                    dx, dy = i + 0.5 - x, j + 0.5 - y
                    k = 1.0 - (dx * dx + dy * dy) / (r * r)
                    if k <= 0.0:
                        continue
                    if pass_index == 0:
                        nearest[j, i] = min(nearest[j, i], z)
                    elif z - limit[j, i] * reach[p] <= nearest[j, i]:
                        k = k * k
                        weight[j, i] += k
                        depth[j, i] += k * z
                        for c in range(3):
                            color[j, i, c] += k * colors[p, c]
