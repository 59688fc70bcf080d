"""Compiled search for the nearest triangle in a tree of boxes."""

from __future__ import annotations

import numpy as np

from vomstudio.geometry.kernels.jit import kernel, part
from vomstudio.geometry.kernels.raytree import LEAF_SIZE_ITEMS


@part
def _squared_box_distance(low, high, node, x, y, z):  # type: ignore[no-untyped-def]
    """Return the squared distance from a position to a box, or infinity for an empty box."""
    if low[node, 0] > high[node, 0]:
        return np.inf
    dx = max(low[node, 0] - x, 0.0, x - high[node, 0])
    dy = max(low[node, 1] - y, 0.0, y - high[node, 1])
    dz = max(low[node, 2] - z, 0.0, z - high[node, 2])
    return dx * dx + dy * dy + dz * dz


@part
def _nearest_edge_fraction(px, py, pz, ex, ey, ez):  # type: ignore[no-untyped-def]
    """Return the nearest point of an edge as a fraction 0 to 1.

    The position and the edge are relative to the first end of the edge.
    """
    length = ex * ex + ey * ey + ez * ez
    if length == 0.0:
        return 0.0
    return min(max((px * ex + py * ey + pz * ez) / length, 0.0), 1.0)


@part
def _nearest_weights(ax, ay, az, ex, ey, ez, fx, fy, fz, x, y, z):  # type: ignore[no-untyped-def]
    """Return the weights of the second and third corner at the nearest point of a triangle.

    They are exactly 0 or 1 on an edge. The triangle is corner a and the edges from it. See Ericson
    (2004), Real-Time Collision Detection, 5.1.5.
    """
    px, py, pz = x - ax, y - ay, z - az
    ee = ex * ex + ey * ey + ez * ez
    ff = fx * fx + fy * fy + fz * fz
    ef = ex * fx + ey * fy + ez * fz
    pe = px * ex + py * ey + pz * ez
    pf = px * fx + py * fy + pz * fz
    area = ee * ff - ef * ef
    if area > 1e-24 * ee * ff:
        u, v = (ff * pe - ef * pf) / area, (ee * pf - ef * pe) / area
        if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
            return u, v
    # Outside, or a triangle without area: on the nearest of the edges.
    u, v = _nearest_edge_fraction(px, py, pz, ex, ey, ez), 0.0
    dx, dy, dz = px - u * ex, py - u * ey, pz - u * ez
    nearest_square = dx * dx + dy * dy + dz * dz
    t = _nearest_edge_fraction(px, py, pz, fx, fy, fz)
    dx, dy, dz = px - t * fx, py - t * fy, pz - t * fz
    square = dx * dx + dy * dy + dz * dz
    if square < nearest_square:
        nearest_square, u, v = square, 0.0, t
    gx, gy, gz = fx - ex, fy - ey, fz - ez
    t = _nearest_edge_fraction(px - ex, py - ey, pz - ez, gx, gy, gz)
    dx, dy, dz = px - ex - t * gx, py - ey - t * gy, pz - ez - t * gz
    square = dx * dx + dy * dy + dz * dz
    if square < nearest_square:
        nearest_square, u, v = square, 1.0 - t, t
    return u, v


@kernel(
    "void(f8[:,::1], i4[:,::1], i8[::1], f8[:,::1], f8[:,::1], f8[:,::1], i8[::1], f8[:,::1],"
    "i8[::1], f8[::1])"
)
def nearest_faces(  # type: ignore[no-untyped-def]
    points, faces, order, low, high, positions, index, weights, stack, entry
):
    """Find the face nearest to each position, and the weights of its corners there.

    `index` is -1 and `weights` NaN on entry.
    """
    n_leaves = (len(low) + 1) // 2
    for row in range(len(positions)):
        x, y, z = positions[row, 0], positions[row, 1], positions[row, 2]
        if not (np.isfinite(x) and np.isfinite(y) and np.isfinite(z)):
            continue
        nearest_square = np.inf
        top = 0
        stack[0], entry[0] = 0, _squared_box_distance(low, high, 0, x, y, z)
        while top >= 0:
            node, position = stack[top], entry[top]
            top -= 1
            if position >= nearest_square:
                continue
            if node < n_leaves - 1:
                a, b = 2 * node + 1, 2 * node + 2
                da, db = (
                    _squared_box_distance(low, high, a, x, y, z),
                    _squared_box_distance(low, high, b, x, y, z),
                )
                if da > db:
                    a, b, da, db = b, a, db, da
                if db < nearest_square:
                    top += 1
                    stack[top], entry[top] = b, db
                if da < nearest_square:
                    top += 1
                    stack[top], entry[top] = a, da
                continue
            first_item = (node - (n_leaves - 1)) * LEAF_SIZE_ITEMS
            for k in range(first_item, min(first_item + LEAF_SIZE_ITEMS, len(order))):
                f = order[k]
                i, j, m = faces[f, 0], faces[f, 1], faces[f, 2]
                ax, ay, az = points[i, 0], points[i, 1], points[i, 2]
                ex, ey, ez = points[j, 0] - ax, points[j, 1] - ay, points[j, 2] - az
                fx, fy, fz = points[m, 0] - ax, points[m, 1] - ay, points[m, 2] - az
                u, v = _nearest_weights(ax, ay, az, ex, ey, ez, fx, fy, fz, x, y, z)
                dx = x - ax - u * ex - v * fx
                dy = y - ay - u * ey - v * fy
                dz = z - az - u * ez - v * fz
                square = dx * dx + dy * dy + dz * dz
                if square < nearest_square:
                    nearest_square = square
                    index[row] = f
                    weights[row, 0], weights[row, 1], weights[row, 2] = 1.0 - u - v, u, v
