"""Compiled kernels for surfaces from clouds."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel

N_ROUNDS = 3
NORMAL_WIDTH = 0.5
"""Difference of normals (about 30 degrees) above which neighbours are on another facet."""


@kernel("void(f8[:,::1], f8[:,::1], i8[:,::1], f8[:,::1], f4[:,::1], f8, f8)")
def move_onto_points(vertices, normals, neighbour_rows, points, point_normals, width, max_distance):  # type: ignore[no-untyped-def]
    """Move each vertex along the normal of its facet onto the points near it.

    The points define an implicit moving least squares surface. Its weights decrease with the
    distance, the residual and the difference of the normals, so that edges between facets remain
    sharp (Oztireli, Guennebaud and Gross 2009, Feature preserving point set surfaces).

    neighbour_rows : rows of the nearest `points` of each vertex, sorted by distance
    width : width of the weights
    max_distance : maximum shift; vertices that would move farther are unchanged
    """
    k = neighbour_rows.shape[1]
    spread = 0.5 * width
    for v in range(len(vertices)):
        x0, y0, z0 = vertices[v, 0], vertices[v, 1], vertices[v, 2]
        x, y, z = x0, y0, z0
        gx, gy, gz = normals[v, 0], normals[v, 1], normals[v, 2]
        is_valid = True
        for outer_round in range(N_ROUNDS):
            value = 0.0
            for inner_round in range(2):
                total, f = 0.0, 0.0
                nx, ny, nz = 0.0, 0.0, 0.0
                for j in range(k):
                    p = neighbour_rows[v, j]
                    dx, dy, dz = x - points[p, 0], y - points[p, 1], z - points[p, 2]
                    ax, ay, az = point_normals[p, 0], point_normals[p, 1], point_normals[p, 2]
                    offset = dx * ax + dy * ay + dz * az
                    w = math.exp(-(dx * dx + dy * dy + dz * dz) / (2 * width * width))
                    ux, uy, uz = ax - gx, ay - gy, az - gz
                    w *= math.exp(-(ux * ux + uy * uy + uz * uz) / (NORMAL_WIDTH * NORMAL_WIDTH))
                    if outer_round > 0 or inner_round > 0:
                        w *= math.exp(-((offset - value) ** 2) / (spread * spread))
                    total += w
                    f += w * offset
                    nx += w * ax
                    ny += w * ay
                    nz += w * az
                if total < 1e-9:
                    is_valid = False
                    break
                value = f / total
                length = math.sqrt(nx * nx + ny * ny + nz * nz)
                if length < 1e-12:
                    is_valid = False
                    break
                gx, gy, gz = nx / length, ny / length, nz / length
            if not is_valid:
                break
            x, y, z = x - value * gx, y - value * gy, z - value * gz
        shift = math.sqrt((x - x0) ** 2 + (y - y0) ** 2 + (z - z0) ** 2)
        if is_valid and shift <= max_distance:
            vertices[v, 0], vertices[v, 1], vertices[v, 2] = x, y, z
