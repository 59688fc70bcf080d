"""Compiled fits of curved surfaces to the points near a position.

The points are sorted by grid cell.
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.cells import cell_index, find_slot, lower_bound
from vomstudio.geometry.kernels.jit import kernel, part

_MIN_POINTS = 10
"""Minimum number of points for the six coefficients of a quadric, so that noise averages out."""


@part
def _solve_linear_system(rows):  # type: ignore[no-untyped-def]
    """Solve rows (6, 7) in place by Gaussian elimination with pivoting.

    Return whether the system has a solution, which is then in the last column.
    """
    for k in range(6):
        pivot = k
        for i in range(k + 1, 6):
            if abs(rows[i, k]) > abs(rows[pivot, k]):
                pivot = i
        if abs(rows[pivot, k]) < 1e-9:
            return False
        if pivot != k:
            for j in range(k, 7):
                rows[k, j], rows[pivot, j] = rows[pivot, j], rows[k, j]
        for i in range(k + 1, 6):
            factor = rows[i, k] / rows[k, k]
            for j in range(k, 7):
                rows[i, j] -= factor * rows[k, j]
    for k in range(5, -1, -1):
        value = rows[k, 6]
        for j in range(k + 1, 6):
            value -= rows[k, j] * rows[j, 6]
        rows[k, 6] = value / rows[k, k]
    return True


@part
def _perpendicular_directions(x, y, z):  # type: ignore[no-untyped-def]
    """Return two directions perpendicular to a unit normal (Duff et al. 2017, JCGT 6(1), 1)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return 1.0 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y


@kernel(
    "void(f8[:,::1], i4[::1], i8[::1], i8[:,::1], f8, i8, i8, i8, f8[:,::1], f8[:,::1], f8,"
    "f8[:,::1], f8[::1])"
)
def fit_local_curvatures(  # type: ignore[no-untyped-def]
    points, cells, names, ends, size, nx, ny, nz, positions, normals, radius, rows, curvature
):
    """Compute the mean curvature of a quadric fitted to the points around each position.

    The quadric is a height along the unit normal (Goldman 2005, Computer Aided Geometric Design 22,
    632). The curvature is positive where the surface bends away from the normal, as on a ball whose
    normals point out. Points and positions are relative to the grid's corner. `rows` (6, 7) is
    working space; `curvature` is NaN on entry and remains NaN if the curvature is unknown.
    """
    limit = radius * radius
    for row in range(len(positions)):
        x, y, z = positions[row, 0], positions[row, 1], positions[row, 2]
        ax, ay, az = normals[row, 0], normals[row, 1], normals[row, 2]
        if not math.isfinite(x + y + z + ax + ay + az):
            continue
        ux, uy, uz, vx, vy, vz = _perpendicular_directions(ax, ay, az)
        i0, i1 = cell_index(x - radius, size, nx), cell_index(x + radius, size, nx)
        j0, j1 = cell_index(y - radius, size, ny), cell_index(y + radius, size, ny)
        k0, k1 = cell_index(z - radius, size, nz), cell_index(z + radius, size, nz)
        for i in range(6):
            for j in range(7):
                rows[i, j] = 0.0
        n = 0
        for k in range(k0, k1 + 1):
            for j in range(j0, j1 + 1):
                slot = find_slot(names, j + ny * k)
                if names[slot] == -1:
                    continue
                stop = ends[slot, 1]
                position = lower_bound(cells, i0, ends[slot, 0], stop)
                while position < stop and cells[position] <= i1:
                    dx, dy, dz = (
                        points[position, 0] - x,
                        points[position, 1] - y,
                        points[position, 2] - z,
                    )
                    position += 1
                    if dx * dx + dy * dy + dz * dz > limit:
                        continue
                    n += 1
                    u = (dx * ux + dy * uy + dz * uz) / radius
                    v = (dx * vx + dy * vy + dz * vz) / radius
                    h = (dx * ax + dy * ay + dz * az) / radius
                    uu, uv, vv = u * u, u * v, v * v
                    rows[0, 0] += 1.0
                    rows[0, 1] += u
                    rows[0, 2] += v
                    rows[0, 3] += uu
                    rows[0, 4] += uv
                    rows[0, 5] += vv
                    rows[0, 6] += h
                    rows[1, 3] += u * uu
                    rows[1, 4] += u * uv
                    rows[1, 5] += u * vv
                    rows[1, 6] += u * h
                    rows[2, 5] += v * vv
                    rows[2, 6] += v * h
                    rows[3, 3] += uu * uu
                    rows[3, 4] += uu * uv
                    rows[3, 5] += uu * vv
                    rows[3, 6] += uu * h
                    rows[4, 5] += uv * vv
                    rows[4, 6] += uv * h
                    rows[5, 5] += vv * vv
                    rows[5, 6] += vv * h
        if n < _MIN_POINTS:
            continue
        # The other products are the same sums.
        rows[1, 1], rows[1, 2], rows[2, 2] = rows[0, 3], rows[0, 4], rows[0, 5]
        rows[2, 3], rows[2, 4], rows[4, 4] = rows[1, 4], rows[1, 5], rows[3, 5]
        for i in range(6):
            for j in range(i, 7):
                rows[i, j] /= n
            for j in range(i):
                rows[i, j] = rows[j, i]
        if not _solve_linear_system(rows):
            continue
        fu, fv = rows[1, 6], rows[2, 6]
        fuu, fuv, fvv = 2.0 * rows[3, 6], rows[4, 6], 2.0 * rows[5, 6]
        g = 1.0 + fu * fu + fv * fv
        bend = (1.0 + fv * fv) * fuu - 2.0 * fu * fv * fuv + (1.0 + fu * fu) * fvv
        curvature[row] = -bend / (2.0 * g * math.sqrt(g) * radius)
