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


INSIDE = -1e-9
"""A ray through an edge belongs to both triangles, whatever rounding says; the nearer one wins."""


@kernel("void(f8[:,::1], i4[:,::1], i4[::1], f8, f8, f8, i4[:,::1], f8[:,::1], f8[:,:,::1])")
def grid_hits(points, faces, chosen, left, top, step, face, depth, weights):  # type: ignore[no-untyped-def]
    """First hits of rays along +z through the centres of a grid's pixels; see `cast_grid`. face
    comes full of -1, depth of infinity."""
    h, w = face.shape
    for at in range(len(chosen)):
        f = chosen[at]
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
                if u < INSIDE or v < INSIDE or u + v > 1.0 - INSIDE:
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
def quarter_hits(points, faces, chosen, left, top, step, slot, face, depth, weights):  # type: ignore[no-untyped-def]
    """As `grid_hits`, four rays in each pixel whose slot is not -1: row `slot` of the results."""
    h, w = slot.shape
    for at in range(len(chosen)):
        f = chosen[at]
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
                    if u < INSIDE or v < INSIDE or u + v > 1.0 - INSIDE:
                        continue
                    z = az + u * ez + v * fz
                    if z < depth[s, q]:
                        depth[s, q] = z
                        face[s, q] = f
                        weights[s, q, 0] = u
                        weights[s, q, 1] = v
