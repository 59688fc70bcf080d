"""Compiled sums over the cells of a patch, which have nearly equal numbers of points."""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel, part


@part
def _count_not_above(bounds, value):  # type: ignore[no-untyped-def]
    """Count the bounds that are not above a value."""
    count = 0
    for k in range(len(bounds)):
        count += value >= bounds[k]
    return count


@kernel("void(f8[::1], f8[::1], f8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1], i8[::1], f8[:,::1])")
def cell_sums(across_component, along_component, slab_bounds, parts, u, v, r, count, sums):  # type: ignore[no-untyped-def]
    """Count the points of each cell, and sum their u, v, r, uu, uv, vv, ur and vr.

    Parameters
    ----------
    across_component, along_component : (n,) ndarray
        Coordinates that determine the cell of a point.
    slab_bounds : (k - 1,) ndarray
        Sorted bounds of `across_component`.
    parts : (k, k - 1) ndarray
        Sorted bounds of `along_component` in each slab.
    u, v, r : (n,) ndarray
    count : (k k,) ndarray
        Output, zeros on entry.
    sums : (k k, 8) ndarray
        Output, zeros on entry.
    """
    cells_per_side = len(parts)
    for i in range(len(u)):
        slab = _count_not_above(slab_bounds, across_component[i])
        position = slab * cells_per_side + _count_not_above(parts[slab], along_component[i])
        a, b, h = u[i], v[i], r[i]
        count[position] += 1
        sums[position, 0] += a
        sums[position, 1] += b
        sums[position, 2] += h
        sums[position, 3] += a * a
        sums[position, 4] += a * b
        sums[position, 5] += b * b
        sums[position, 6] += a * h
        sums[position, 7] += b * h


@kernel("void(f8[:,::1], f8[::1], f8[::1], f8[:,::1])")
def weighted_spread(points, weights, centre, scatter):  # type: ignore[no-untyped-def]
    """Sum the weighted outer products of points about their mean.

    Parameters
    ----------
    points : (k, 3) ndarray
    weights : (k,) ndarray
        Weight of each point, or (1,) for a common weight.
    centre : (3,) ndarray
        Input: position near the points. Output: their mean.
    scatter : (3, 3) ndarray
        Output, zeros on entry.
    """
    x, y, z = centre[0], centre[1], centre[2]
    for pass_index in range(2):
        w, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(len(points)):
            weight = weights[i] if len(weights) > 1 else weights[0]
            dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
            ax, ay, az = weight * dx, weight * dy, weight * dz
            w, sx, sy, sz = w + weight, sx + ax, sy + ay, sz + az
            if pass_index == 1:
                xx, yy, zz = xx + ax * dx, yy + ay * dy, zz + az * dz
                xy, xz, yz = xy + ax * dy, xz + ax * dz, yz + ay * dz
        if pass_index == 0:
            x, y, z = x + sx / w, y + sy / w, z + sz / w
            continue
        centre[0], centre[1], centre[2] = x, y, z
        scatter[0, 0], scatter[1, 1], scatter[2, 2] = xx, yy, zz
        scatter[0, 1] = scatter[1, 0] = xy
        scatter[0, 2] = scatter[2, 0] = xz
        scatter[1, 2] = scatter[2, 1] = yz


@kernel("f8(f8[:,::1], f8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1])")
def rotate_points(points, centre, axes, u, v, r):  # type: ignore[no-untyped-def]
    """Compute coordinates along the rows of `axes`, and return the sum of squares of r.

    The coordinates are relative to `centre`.
    """
    x, y, z = centre[0], centre[1], centre[2]
    total_square = 0.0
    for i in range(len(points)):
        dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
        u[i] = dx * axes[0, 0] + dy * axes[0, 1] + dz * axes[0, 2]
        v[i] = dx * axes[1, 0] + dy * axes[1, 1] + dz * axes[1, 2]
        r[i] = dx * axes[2, 0] + dy * axes[2, 1] + dz * axes[2, 2]
        total_square += r[i] * r[i]
    return total_square
