"""Compiled sums over the points near a position; the points are sorted by grid cell."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part

_HASH_FACTOR = 0x9E3779B97F4A7C15 - (1 << 64)
"""Fibonacci hashing (Knuth, The Art of Computer Programming 3, 6.4)."""


@part
def find_slot(names, name):  # type: ignore[no-untyped-def]
    """Return the slot of a row of cells in the hash table, or the free slot for it."""
    last_index = len(names) - 1
    position = ((name * _HASH_FACTOR) >> 20) & last_index
    while names[position] != -1 and names[position] != name:
        position = (position + 1) & last_index
    return position


@kernel("void(i8[::1], i8[::1], i8[::1], i8[:,::1])")
def fill_row_table(rows, cell_starts, names, ends):  # type: ignore[no-untyped-def]
    """Fill the table of rows of cells that contain points.

    Parameters
    ----------
    rows : (r,) ndarray
        Numbers of the rows of cells.
    cell_starts : (r + 1,) ndarray
        First point of each row.
    names : ndarray
        Output: number of the row in each slot, -1 on entry; its length is a power of two above r.
    ends : (len(names), 2) ndarray
        Output: first point of the row and of the next row.
    """
    for k in range(len(rows)):
        slot = find_slot(names, rows[k])
        names[slot] = rows[k]
        ends[slot, 0], ends[slot, 1] = cell_starts[k], cell_starts[k + 1]


@part
def lower_bound(keys, bound, low, high):  # type: ignore[no-untyped-def]
    """Return the first position in a range of sorted keys whose key is not below `bound`."""
    while low < high:
        centre = (low + high) // 2
        if keys[centre] < bound:
            low = centre + 1
        else:
            high = centre
    return low


@part
def cell_index(value, size, count):  # type: ignore[no-untyped-def]
    """Return the index of the cell that contains a coordinate, clipped to the grid."""
    return min(max(math.floor(value / size), 0), count - 1)


@part
def _jacobi_rotation(p, q, m):  # type: ignore[no-untyped-def]
    """Return the tangent, cosine and sine of the rotation that eliminates an element.

    The element m is the off-diagonal element of the diagonal elements p and q.
    """
    if m == 0.0:
        return 0.0, 1.0, 0.0
    t = (q - p) / (2.0 * m)
    t = math.copysign(1.0, t) / (abs(t) + math.sqrt(t * t + 1.0))
    k = 1.0 / math.sqrt(t * t + 1.0)
    return t, k, t * k


@part
def _rotate_pair(k, s, x, y):  # type: ignore[no-untyped-def]
    return k * x - s * y, s * x + k * y


@part
def smallest_eigenvector(a, b, c, d, e, f):  # type: ignore[no-untyped-def]
    """Return the eigenvector of the smallest eigenvalue and all eigenvalues, ascending.

    The symmetric matrix has the rows (a, d, e), (d, b, f), (e, f, c). The method is cyclic Jacobi
    rotation (Golub & Van Loan, Matrix Computations, 8.5).
    """
    v00, v01, v02 = 1.0, 0.0, 0.0
    v10, v11, v12 = 0.0, 1.0, 0.0
    v20, v21, v22 = 0.0, 0.0, 1.0
    for _ in range(30):
        if d * d + e * e + f * f <= 1e-32 * (a * a + b * b + c * c):
            break
        t, k, s = _jacobi_rotation(a, b, d)
        a, b, d = a - t * d, b + t * d, 0.0
        e, f = _rotate_pair(k, s, e, f)
        v00, v01 = _rotate_pair(k, s, v00, v01)
        v10, v11 = _rotate_pair(k, s, v10, v11)
        v20, v21 = _rotate_pair(k, s, v20, v21)
        t, k, s = _jacobi_rotation(a, c, e)
        a, c, e = a - t * e, c + t * e, 0.0
        d, f = _rotate_pair(k, s, d, f)
        v00, v02 = _rotate_pair(k, s, v00, v02)
        v10, v12 = _rotate_pair(k, s, v10, v12)
        v20, v22 = _rotate_pair(k, s, v20, v22)
        t, k, s = _jacobi_rotation(b, c, f)
        b, c, f = b - t * f, c + t * f, 0.0
        d, e = _rotate_pair(k, s, d, e)
        v01, v02 = _rotate_pair(k, s, v01, v02)
        v11, v12 = _rotate_pair(k, s, v11, v12)
        v21, v22 = _rotate_pair(k, s, v21, v22)
    trace = a + b + c
    smallest_eigenvalue, maximum = min(a, b, c), max(a, b, c)
    x, y, z = v00, v10, v20
    if smallest_eigenvalue == b:
        x, y, z = v01, v11, v21
    elif smallest_eigenvalue == c:
        x, y, z = v02, v12, v22
    return x, y, z, smallest_eigenvalue, trace - smallest_eigenvalue - maximum, maximum


@kernel(
    "void(f8[:,::1], i4[::1], i8[::1], i8[:,::1], f8, i8, i8, i8, f8[:,::1], f8, i8[::1],"
    "f8[:,::1], f8[:,::1], f8[:,::1])"
)
def fit_local_planes(  # type: ignore[no-untyped-def]
    points, cells, names, ends, size, nx, ny, nz, positions, radius, count, means, normals, spreads
):
    """Fit a plane to the points in a ball around each position.

    The outputs are the number of points, their mean, the unit normal of their plane, and the
    eigenvalues of their covariance in ascending order. The normal and the eigenvalues are not
    written for fewer than three points. Points and positions are relative to the corner of the
    grid.
    """
    limit = radius * radius
    for row in range(len(positions)):
        x, y, z = positions[row, 0], positions[row, 1], positions[row, 2]
        i0, i1 = cell_index(x - radius, size, nx), cell_index(x + radius, size, nx)
        j0, j1 = cell_index(y - radius, size, ny), cell_index(y + radius, size, ny)
        k0, k1 = cell_index(z - radius, size, nz), cell_index(z + radius, size, nz)
        n = 0
        sx, sy, sz = 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
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
                    sx, sy, sz = sx + dx, sy + dy, sz + dz
                    xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
                    xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
        count[row] = n
        if n == 0:
            continue
        sx, sy, sz = sx / n, sy / n, sz / n
        means[row, 0], means[row, 1], means[row, 2] = x + sx, y + sy, z + sz
        if n < 3:
            continue
        eigen = smallest_eigenvector(
            xx / n - sx * sx,
            yy / n - sy * sy,
            zz / n - sz * sz,
            xy / n - sx * sy,
            xz / n - sx * sz,
            yz / n - sy * sz,
        )
        normals[row, 0], normals[row, 1], normals[row, 2] = eigen[0], eigen[1], eigen[2]
        spreads[row, 0], spreads[row, 1], spreads[row, 2] = eigen[3], eigen[4], eigen[5]


@kernel(
    "void(f8[:,::1], i4[::1], i8[::1], i8[:,::1], f8, i8, i8, i8, f8[:,::1], f8[:,::1], f8, f8,"
    "i8[::1], f8[::1], f8[::1])"
)
def measure_along_axes(  # type: ignore[no-untyped-def]
    points,
    cells,
    names,
    ends,
    size,
    nx,
    ny,
    nz,
    positions,
    axes,
    radius,
    max_distance,
    count,
    means,
    spreads,
):
    """Measure the points in a cylinder around each position along a unit axis.

    The cylinder extends by `max_distance` in both directions. The outputs are the number of points,
    and the mean and the standard deviation (divisor n - 1) of their positions along the axis.
    Points and positions are relative to the corner of the grid.
    """
    pieces = max(1, math.ceil(max_distance / size))
    half_length = max_distance / pieces
    for row in range(len(positions)):
        x, y, z = positions[row, 0], positions[row, 1], positions[row, 2]
        ux, uy, uz = axes[row, 0], axes[row, 1], axes[row, 2]
        if not math.isfinite(ux + uy + uz):
            continue
        # Half the sides of the bounding box of a piece of the cylinder.
        wx = abs(ux) * half_length + radius * math.sqrt(max(1.0 - ux * ux, 0.0))
        wy = abs(uy) * half_length + radius * math.sqrt(max(1.0 - uy * uy, 0.0))
        wz = abs(uz) * half_length + radius * math.sqrt(max(1.0 - uz * uz, 0.0))
        n, mean, squares = 0, 0.0, 0.0
        for piece in range(pieces):
            t = (2 * piece + 1 - pieces) * half_length
            cx, cy, cz = x + t * ux, y + t * uy, z + t * uz
            if (
                cx + wx < 0.0
                or cy + wy < 0.0
                or cz + wz < 0.0
                or cx - wx > nx * size
                or cy - wy > ny * size
                or cz - wz > nz * size
            ):
                continue
            i0, i1 = cell_index(cx - wx, size, nx), cell_index(cx + wx, size, nx)
            j0, j1 = cell_index(cy - wy, size, ny), cell_index(cy + wy, size, ny)
            k0, k1 = cell_index(cz - wz, size, nz), cell_index(cz + wz, size, nz)
            is_last = piece == pieces - 1
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
                        axis_component = dx * ux + dy * uy + dz * uz
                        # Count each point in one piece only.
                        if (
                            axis_component < t - half_length
                            or axis_component > t + half_length
                            or (axis_component == t + half_length and not is_last)
                        ):
                            continue
                        offset = dx * dx + dy * dy + dz * dz - axis_component * axis_component
                        if offset > radius * radius:
                            continue
                        n += 1
                        step = axis_component - mean
                        mean += step / n
                        squares += step * (axis_component - mean)
        count[row] = n
        if n > 0:
            means[row] = mean
        if n > 1:
            spreads[row] = math.sqrt(squares / (n - 1))
