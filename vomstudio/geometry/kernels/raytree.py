"""Compiled traversal of a tree of boxes."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.kernels.jit import kernel, part

LEAF_SIZE_ITEMS = 4
INSIDE_TOLERANCE = -1e-12


def allocate_stack() -> tuple[IntArray, FloatArray]:
    """Allocate the working space of a traversal.

    A kernel that allocates no memory can be loaded without numba.
    """
    return np.empty(128, np.int64), np.empty(128, np.float64)


@part
def _is_finite(vector):  # type: ignore[no-untyped-def]
    return np.isfinite(vector[0]) and np.isfinite(vector[1]) and np.isfinite(vector[2])


@part
def _entry_distance(low, high, node, start, direction, max_distance):  # type: ignore[no-untyped-def]
    """Return the distance at which a ray enters a box.

    The distance is infinite if the ray misses the box or enters it beyond `max_distance`.
    """
    near_distance, far_distance = 0.0, max_distance
    for axis in range(3):
        a, b = low[node, axis], high[node, axis]
        if a > b:
            return np.inf
        w = direction[axis]
        if w == 0.0:
            if start[axis] < a or start[axis] > b:
                return np.inf
        else:
            t0, t1 = (a - start[axis]) / w, (b - start[axis]) / w
            if t0 > t1:
                t0, t1 = t1, t0
            tolerance = 1e-12 * (abs(t0) + abs(t1))
            near_distance, far_distance = (
                max(near_distance, t0 - tolerance),
                min(far_distance, t1 + tolerance),
            )
            if near_distance > far_distance:
                return np.inf
    return near_distance


@part
def _push_children(low, high, node, start, direction, max_distance, stack, entry, top):  # type: ignore[no-untyped-def]
    """Push the children of a node that a ray enters onto the stack, nearer child on top."""
    a, b = 2 * node + 1, 2 * node + 2
    ta, tb = (
        _entry_distance(low, high, a, start, direction, max_distance),
        _entry_distance(low, high, b, start, direction, max_distance),
    )
    if ta > tb:
        a, b, ta, tb = b, a, tb, ta
    if tb < np.inf:
        top += 1
        stack[top], entry[top] = b, tb
    if ta < np.inf:
        top += 1
        stack[top], entry[top] = a, ta
    return top


@kernel(
    "void(f8[:,::1], i4[:,::1], i8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1],"
    "i8[::1], f8[::1], f8[:,::1], i8[::1], f8[::1])"
)
def find_first_faces(  # type: ignore[no-untyped-def]
    points,
    faces,
    order,
    low,
    high,
    starts,
    directions,
    ends,
    index,
    distance,
    weights,
    stack,
    entry,
):
    """Find the first face that each ray hits, up to its end."""
    n_leaves = (len(low) + 1) // 2
    for ray in range(len(directions)):
        s, w = starts[ray], directions[ray]
        best_distance = ends[ray]
        if not (_is_finite(s) and _is_finite(w)):
            continue
        top = 0
        stack[0], entry[0] = 0, _entry_distance(low, high, 0, s, w, best_distance)
        while top >= 0:
            node, position = stack[top], entry[top]
            top -= 1
            if position == np.inf or position > best_distance:
                continue
            if node < n_leaves - 1:
                top = _push_children(low, high, node, s, w, best_distance, stack, entry, top)
                continue
            first_item = (node - (n_leaves - 1)) * LEAF_SIZE_ITEMS
            for k in range(first_item, min(first_item + LEAF_SIZE_ITEMS, len(order))):
                f = order[k]
                i, j, m = faces[f, 0], faces[f, 1], faces[f, 2]
                ex = points[j, 0] - points[i, 0]
                ey = points[j, 1] - points[i, 1]
                ez = points[j, 2] - points[i, 2]
                fx = points[m, 0] - points[i, 0]
                fy = points[m, 1] - points[i, 1]
                fz = points[m, 2] - points[i, 2]
                px, py, pz = w[1] * fz - w[2] * fy, w[2] * fx - w[0] * fz, w[0] * fy - w[1] * fx
                det = ex * px + ey * py + ez * pz
                if det == 0.0:
                    continue
                gx, gy, gz = s[0] - points[i, 0], s[1] - points[i, 1], s[2] - points[i, 2]
                u = (gx * px + gy * py + gz * pz) / det
                if u < INSIDE_TOLERANCE or u > 1.0 - INSIDE_TOLERANCE:
                    continue
                qx, qy, qz = gy * ez - gz * ey, gz * ex - gx * ez, gx * ey - gy * ex
                v = (w[0] * qx + w[1] * qy + w[2] * qz) / det
                if v < INSIDE_TOLERANCE or u + v > 1.0 - INSIDE_TOLERANCE:
                    continue
                t = (fx * qx + fy * qy + fz * qz) / det
                if 0.0 < t < best_distance:
                    best_distance = t
                    index[ray] = f
                    distance[ray] = t
                    weights[ray, 0] = 1.0 - u - v
                    weights[ray, 1] = u
                    weights[ray, 2] = v


@kernel(
    "void(f8[:,::1], i8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8[::1], f8, f8,"
    "i8[::1], f8[::1], i8[::1], f8[::1])"
)
def find_first_points(  # type: ignore[no-untyped-def]
    points,
    order,
    low,
    high,
    starts,
    directions,
    ends,
    max_offset,
    point_radius,
    index,
    distance,
    stack,
    entry,
):
    """Find the point nearest to each ray on the first surface of points that it hits.

    Only points up to the end of the ray are used.
    """
    n_leaves = (len(low) + 1) // 2
    for ray in range(len(directions)):
        s, w = starts[ray], directions[ray]
        if not (_is_finite(s) and _is_finite(w)):
            continue
        length = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
        if length == 0.0:
            continue
        # The first walk finds how far the first surface is, the second its best point.
        first_distance, closest_distance = ends[ray], np.inf
        for pass_index in range(2):
            limit = (
                first_distance
                if pass_index == 0
                else min(first_distance + point_radius / length, ends[ray])
            )
            top = 0
            stack[0], entry[0] = 0, _entry_distance(low, high, 0, s, w, limit)
            is_hit = False
            while top >= 0:
                node, position = stack[top], entry[top]
                top -= 1
                if position == np.inf or position > limit:
                    continue
                if node < n_leaves - 1:
                    top = _push_children(low, high, node, s, w, limit, stack, entry, top)
                    continue
                first_item = (node - (n_leaves - 1)) * LEAF_SIZE_ITEMS
                for k in range(first_item, min(first_item + LEAF_SIZE_ITEMS, len(order))):
                    p = order[k]
                    gx, gy, gz = points[p, 0] - s[0], points[p, 1] - s[1], points[p, 2] - s[2]
                    t = (gx * w[0] + gy * w[1] + gz * w[2]) / (length * length)
                    if t <= 0.0 or t > limit:
                        continue
                    dx, dy, dz = gx - t * w[0], gy - t * w[1], gz - t * w[2]
                    offset = np.sqrt(dx * dx + dy * dy + dz * dz)
                    if offset > max_offset:
                        continue
                    if pass_index == 0:
                        is_hit = True
                        limit = t
                    elif offset < closest_distance:
                        closest_distance = offset
                        index[ray] = p
                        distance[ray] = t
            if pass_index == 0:
                if not is_hit:
                    break
                first_distance = limit
