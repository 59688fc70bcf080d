"""Compiled parts of the ray caster."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel

INSIDE_TOLERANCE = -1e-9
"""A ray through an edge hits both triangles despite rounding; the nearer hit is used."""


@kernel("void(f8[:,::1], i4[:,::1], i4[::1], f8, f8, f8, i4[:,::1], f8[:,::1], f8[:,:,::1])")
def find_grid_hits(points, faces, selected_triangles, left, top, step, face, depth, weights):  # type: ignore[no-untyped-def]
    """Find the first hits of rays along +z through the centres of a grid's pixels.

    See `cast_grid`. `face` is -1 and `depth` infinity on entry.
    """
    h, w = face.shape
    for k in range(len(selected_triangles)):
        f = selected_triangles[k]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = points[a, 0], points[a, 1], points[a, 2]
        ex, ey, ez = points[b, 0] - ax, points[b, 1] - ay, points[b, 2] - az
        fx, fy, fz = points[c, 0] - ax, points[c, 1] - ay, points[c, 2] - az
        det = ex * fy - ey * fx
        if det == 0.0:
            continue
        low, high = ax + min(0.0, ex, fx), ax + max(0.0, ex, fx)
        i0 = max(math.ceil((low - left) / step - 0.5 - 1e-6), 0)
        i1 = min(math.floor((high - left) / step - 0.5 + 1e-6), w - 1)
        low, high = ay + min(0.0, ey, fy), ay + max(0.0, ey, fy)
        j0 = max(math.ceil((low - top) / step - 0.5 - 1e-6), 0)
        j1 = min(math.floor((high - top) / step - 0.5 + 1e-6), h - 1)
        inverse = 1.0 / det
        for j in range(j0, j1 + 1):
            y = top + (j + 0.5) * step - ay
            for i in range(i0, i1 + 1):
                x = left + (i + 0.5) * step - ax
                u = (x * fy - y * fx) * inverse
                v = (ex * y - ey * x) * inverse
                if u < INSIDE_TOLERANCE or v < INSIDE_TOLERANCE or u + v > 1.0 - INSIDE_TOLERANCE:
                    continue
                z = az + u * ez + v * fz
                if z < depth[j, i]:
                    depth[j, i] = z
                    face[j, i] = f
                    weights[j, i, 0] = u
                    weights[j, i, 1] = v


@kernel(
    "void(f8[:,::1], i4[:,::1], i4[::1], f8, f8, f8, i4[:,::1], i4[:,::1], f8[:,::1], f8[:,:,::1])"
)
def find_quarter_hits(  # type: ignore[no-untyped-def]
    points, faces, selected_triangles, left, top, step, slot, face, depth, weights
):
    """Find the first hits of four rays in each pixel whose slot is not -1.

    Same as `find_grid_hits`, except that the slot of a pixel is its row in the results.
    """
    h, w = slot.shape
    for k in range(len(selected_triangles)):
        f = selected_triangles[k]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = points[a, 0], points[a, 1], points[a, 2]
        ex, ey, ez = points[b, 0] - ax, points[b, 1] - ay, points[b, 2] - az
        fx, fy, fz = points[c, 0] - ax, points[c, 1] - ay, points[c, 2] - az
        det = ex * fy - ey * fx
        if det == 0.0:
            continue
        i0 = max(math.floor((ax + min(0.0, ex, fx) - left) / step - 1e-6), 0)
        i1 = min(math.floor((ax + max(0.0, ex, fx) - left) / step + 1e-6), w - 1)
        j0 = max(math.floor((ay + min(0.0, ey, fy) - top) / step - 1e-6), 0)
        j1 = min(math.floor((ay + max(0.0, ey, fy) - top) / step + 1e-6), h - 1)
        inverse = 1.0 / det
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                s = slot[j, i]
                if s < 0:
                    continue
                for q in range(4):
                    x = left + (i + 0.25 + 0.5 * (q % 2)) * step - ax
                    y = top + (j + 0.25 + 0.5 * (q // 2)) * step - ay
                    u = (x * fy - y * fx) * inverse
                    v = (ex * y - ey * x) * inverse
                    if (
                        u < INSIDE_TOLERANCE
                        or v < INSIDE_TOLERANCE
                        or u + v > 1.0 - INSIDE_TOLERANCE
                    ):
                        continue
                    z = az + u * ez + v * fz
                    if z < depth[s, q]:
                        depth[s, q] = z
                        face[s, q] = f
                        weights[s, q, 0] = u
                        weights[s, q, 1] = v
