"""Triangulation of polygons whose triangle fan extends outside the polygon."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.geometry.kernels.jit import kernel, part

# Ear clipping is cubic in the worst case; longer polygons keep their fan.
MAX_RING_VERTICES = 256


@part
def _signed_area(points, a, b, c, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Return twice the signed area of the triangle abc as seen against the normal.

    The area is negative for a clockwise triangle.
    """
    ux = points[b, 0] - points[a, 0]
    uy = points[b, 1] - points[a, 1]
    uz = points[b, 2] - points[a, 2]
    vx = points[c, 0] - points[a, 0]
    vy = points[c, 1] - points[a, 1]
    vz = points[c, 2] - points[a, 2]
    return (uy * vz - uz * vy) * nx + (uz * vx - ux * vz) * ny + (ux * vy - uy * vx) * nz


@part
def _load_ring(corners, t0, n, ring):  # type: ignore[no-untyped-def]
    """Load the corners of the polygon whose fan begins with triangle t0.

    Returns whether all corners are valid.
    """
    ring[0] = corners[t0, 0]
    ring[1] = corners[t0, 1]
    for k in range(n - 2):
        ring[k + 2] = corners[t0 + k, 2]
    is_valid = True
    for k in range(n):
        if ring[k] < 0:
            is_valid = False
    return is_valid


@part
def _is_ear(points, index, n_remaining, a, b, c, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Return whether the triangle abc is inside the remaining polygon."""
    if not _signed_area(points, a, b, c, nx, ny, nz) > 0:
        return False
    for j in range(n_remaining):
        o = index[j]
        if o in (a, b, c):
            continue
        if (
            _signed_area(points, a, b, o, nx, ny, nz) >= 0
            and _signed_area(points, b, c, o, nx, ny, nz) >= 0
            and _signed_area(points, c, a, o, nx, ny, nz) >= 0
        ):
            return False
    return True


def clip_concave_polygons(
    vertices: FloatArray,
    corners: Int32Array,
    uv_corners: Int32Array,
    polygons: IntArray,
) -> int:
    """Clip the ears of the concave polygons in place.

    The method is that of Meisters 1975, *Am. Math. Monthly* 82, 648.

    vertices (n, 3); corners, uv_corners (m, 3), where the latter may have no rows; polygons (p, 2):
    first triangle of the fan, number of corners. Polygons are left unchanged if they have an
    invalid corner (-1) or more than `MAX_RING_VERTICES` corners, or if no ear can be found
    (self-intersecting ones). Returns the number of polygons that were triangulated again.
    """
    return int(
        _cut_polygon(
            vertices,
            corners,
            uv_corners,
            polygons,
            np.empty((MAX_RING_VERTICES, 3)),
            np.empty((3, MAX_RING_VERTICES), np.int64),
            np.empty((MAX_RING_VERTICES, 3), np.int64),
        )
    )


@kernel(
    "int64(float64[:,::1], int32[:,::1], int32[:,::1], int64[:,::1], float64[:,::1],"
    " int64[:,::1], int64[:,::1])"
)
def _cut_polygon(vertices, corners, uv_corners, polygons, points, rings, ears):  # type: ignore[no-untyped-def]
    """Run `clip_concave_polygons` with work arrays sized for one polygon."""
    ring = rings[0]
    uv_ring = rings[1]
    index = rings[2]
    needs_uv = uv_corners.shape[0] > 0
    changed_count = 0
    for q in range(polygons.shape[0]):
        t0 = polygons[q, 0]
        n = polygons[q, 1]
        if n > MAX_RING_VERTICES:
            continue
        is_valid = _load_ring(corners, t0, n, ring)
        if needs_uv:
            _load_ring(uv_corners, t0, n, uv_ring)
        if not is_valid:
            continue
        for k in range(n):
            for c in range(3):
                points[k, c] = vertices[ring[k], c] - vertices[ring[0], c]
        # Newell's normal, which is also defined for concave and slightly warped polygons.
        nx = ny = nz = 0.0
        for k in range(n):
            m = (k + 1) % n
            nx += (points[k, 1] - points[m, 1]) * (points[k, 2] + points[m, 2])
            ny += (points[k, 2] - points[m, 2]) * (points[k, 0] + points[m, 0])
            nz += (points[k, 0] - points[m, 0]) * (points[k, 1] + points[m, 1])
        is_fan_valid = True
        for k in range(1, n - 1):
            if _signed_area(points, 0, k, k + 1, nx, ny, nz) < 0:
                is_fan_valid = False
        if is_fan_valid:
            continue
        for k in range(n):
            index[k] = k
        remaining_count = n
        n_ears = 0
        k = 0
        attempts = 0
        while remaining_count > 3 and attempts < remaining_count:
            a = index[(k + remaining_count - 1) % remaining_count]
            b = index[k % remaining_count]
            c = index[(k + 1) % remaining_count]
            if _is_ear(points, index, remaining_count, a, b, c, nx, ny, nz):
                ears[n_ears, 0] = a
                ears[n_ears, 1] = b
                ears[n_ears, 2] = c
                n_ears += 1
                for j in range(k % remaining_count, remaining_count - 1):
                    index[j] = index[j + 1]
                remaining_count -= 1
                attempts = 0
                k = k % remaining_count
            else:
                k = (k + 1) % remaining_count
                attempts += 1
        if remaining_count > 3:
            continue
        ears[n_ears, 0] = index[0]
        ears[n_ears, 1] = index[1]
        ears[n_ears, 2] = index[2]
        for k in range(n - 2):
            for c in range(3):
                corners[t0 + k, c] = ring[ears[k, c]]
                if needs_uv:
                    uv_corners[t0 + k, c] = uv_ring[ears[k, c]]
        changed_count += 1
    return changed_count
