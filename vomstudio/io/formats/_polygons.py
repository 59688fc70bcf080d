"""Polygons that came as fans of triangles, cut again where the fan would leave the polygon."""

from __future__ import annotations

import numpy as np

from vomstudio.io.formats._jit import kernel

# Ear clipping is cubic at worst; longer polygons keep their fan.
MAX_RING = 256


@kernel("float64(float64[:,::1], int64, int64, int64, float64, float64, float64)")
def _turn(points, a, b, c, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Twice the area of triangle abc as seen against the normal: negative where it is clockwise."""
    ux = points[b, 0] - points[a, 0]
    uy = points[b, 1] - points[a, 1]
    uz = points[b, 2] - points[a, 2]
    vx = points[c, 0] - points[a, 0]
    vy = points[c, 1] - points[a, 1]
    vz = points[c, 2] - points[a, 2]
    return (uy * vz - uz * vy) * nx + (uz * vx - ux * vz) * ny + (ux * vy - uy * vx) * nz


@kernel("int64(float64[:,::1], int32[:,::1], int32[:,::1], int64[:,::1])")
def cut_concave(vertices, corners, uv_corners, polygons):  # type: ignore[no-untyped-def]
    """Ear clipping (Meisters 1975, *Am. Math. Monthly* 82, 648) of the concave polygons, in place.

    vertices (n, 3); corners, uv_corners (m, 3), the second possibly without rows; polygons (p, 2):
    first triangle of the fan, number of corners. Polygons with an unsound corner (-1) are left, so
    are those that no ear can be found in (crossing themselves). Returns how many were cut again.
    """
    want_uv = uv_corners.shape[0] > 0
    changed = 0
    for q in range(polygons.shape[0]):
        t0 = polygons[q, 0]
        n = polygons[q, 1]
        if n > MAX_RING:
            continue
        ring = np.empty(n, np.int32)
        uv_ring = np.full(n, -1, np.int32)
        ring[0] = corners[t0, 0]
        ring[1] = corners[t0, 1]
        for k in range(n - 2):
            ring[k + 2] = corners[t0 + k, 2]
        if want_uv:
            uv_ring[0] = uv_corners[t0, 0]
            uv_ring[1] = uv_corners[t0, 1]
            for k in range(n - 2):
                uv_ring[k + 2] = uv_corners[t0 + k, 2]
        sound = True
        for k in range(n):
            if ring[k] < 0:
                sound = False
        if not sound:
            continue
        points = np.empty((n, 3))
        for k in range(n):
            for c in range(3):
                points[k, c] = vertices[ring[k], c] - vertices[ring[0], c]
        # Newell's normal, which concave and slightly warped polygons have too.
        nx = ny = nz = 0.0
        for k in range(n):
            m = (k + 1) % n
            nx += (points[k, 1] - points[m, 1]) * (points[k, 2] + points[m, 2])
            ny += (points[k, 2] - points[m, 2]) * (points[k, 0] + points[m, 0])
            nz += (points[k, 0] - points[m, 0]) * (points[k, 1] + points[m, 1])
        fan_is_sound = True
        for k in range(1, n - 1):
            if _turn(points, 0, k, k + 1, nx, ny, nz) < 0:
                fan_is_sound = False
        if fan_is_sound:
            continue
        index = np.arange(n)
        left = n
        made = 0
        ears = np.empty((n - 2, 3), np.int64)
        k = 0
        tried = 0
        while left > 3 and tried < left:
            a = index[(k + left - 1) % left]
            b = index[k % left]
            c = index[(k + 1) % left]
            ear = _turn(points, a, b, c, nx, ny, nz) > 0
            if ear:
                for j in range(left):
                    o = index[j]
                    if o == a or o == b or o == c:
                        continue
                    if (
                        _turn(points, a, b, o, nx, ny, nz) >= 0
                        and _turn(points, b, c, o, nx, ny, nz) >= 0
                        and _turn(points, c, a, o, nx, ny, nz) >= 0
                    ):
                        ear = False
                        break
            if ear:
                ears[made, 0] = a
                ears[made, 1] = b
                ears[made, 2] = c
                made += 1
                for j in range(k % left, left - 1):
                    index[j] = index[j + 1]
                left -= 1
                tried = 0
                k = k % left
            else:
                k = (k + 1) % left
                tried += 1
        if left > 3:
            continue
        ears[made, 0] = index[0]
        ears[made, 1] = index[1]
        ears[made, 2] = index[2]
        for k in range(n - 2):
            for c in range(3):
                corners[t0 + k, c] = ring[ears[k, c]]
                if want_uv:
                    uv_corners[t0 + k, c] = uv_ring[ears[k, c]]
        changed += 1
    return changed
