"""Compiled parts of the ray caster."""

from __future__ import annotations

import math

from vomstudio.geometry.jit import kernel


@kernel("void(f8[:,::1], f8[:,::1], f8[::1], f8, f4[:,::1], f4[:,::1])")
def float32_rays(starts, directions, origin, radius, near, along):  # type: ignore[no-untyped-def]
    """Rays relative to `origin`, moved forward to just outside the sphere about it."""
    for i in range(len(starts)):
        k = i if len(directions) > 1 else 0
        dx, dy, dz = directions[k, 0], directions[k, 1], directions[k, 2]
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        dx, dy, dz = dx / length, dy / length, dz / length
        x, y, z = starts[i, 0] - origin[0], starts[i, 1] - origin[1], starts[i, 2] - origin[2]
        ahead = -(x * dx + y * dy + z * dz) - radius
        if ahead > 0.0:
            x, y, z = x + ahead * dx, y + ahead * dy, z + ahead * dz
        near[i, 0], near[i, 1], near[i, 2] = x, y, z
        along[i, 0], along[i, 1], along[i, 2] = dx, dy, dz


@kernel("void(f8[:,::1], f8[:,::1], f8[:,:,::1], i4[::1], f8[:,::1], f8[::1])")
def exact_hits(starts, directions, corners, face, weights, distance):  # type: ignore[no-untyped-def]
    """Where each ray meets the plane of its triangle (Moller and Trumbore 1997, Journal of
    Graphics Tools 2, 21-28), in float64. A triangle seen edge-on keeps the weights it came with."""
    for i in range(len(starts)):
        f = face[i]
        if f < 0:
            distance[i] = math.inf
            continue
        k = i if len(directions) > 1 else 0
        dx, dy, dz = directions[k, 0], directions[k, 1], directions[k, 2]
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        dx, dy, dz = dx / length, dy / length, dz / length
        ax, ay, az = corners[f, 0, 0], corners[f, 0, 1], corners[f, 0, 2]
        bx, by, bz = corners[f, 1, 0] - ax, corners[f, 1, 1] - ay, corners[f, 1, 2] - az
        cx, cy, cz = corners[f, 2, 0] - ax, corners[f, 2, 1] - ay, corners[f, 2, 2] - az
        sx, sy, sz = starts[i, 0] - ax, starts[i, 1] - ay, starts[i, 2] - az
        px, py, pz = dy * cz - dz * cy, dz * cx - dx * cz, dx * cy - dy * cx
        det = bx * px + by * py + bz * pz
        scale = math.sqrt((bx * bx + by * by + bz * bz) * (cx * cx + cy * cy + cz * cz))
        u, v = weights[i, 0], weights[i, 1]
        if abs(det) > 1e-9 * scale:
            u = (sx * px + sy * py + sz * pz) / det
            qx, qy, qz = sy * bz - sz * by, sz * bx - sx * bz, sx * by - sy * bx
            v = (dx * qx + dy * qy + dz * qz) / det
        u = min(max(u, 0.0), 1.0)
        v = min(max(v, 0.0), 1.0 - u)
        weights[i, 0], weights[i, 1] = u, v
        hx, hy, hz = u * bx + v * cx - sx, u * by + v * cy - sy, u * bz + v * cz - sz
        distance[i] = hx * dx + hy * dy + hz * dz
