"""Compiled loops over cubic cells that contain points.

Points are sorted by cell: the points of cell c are points[starts[c]:starts[c + 1]].
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.cells import smallest_eigenvector
from vomstudio.geometry.kernels.jit import kernel, part

_HASH_FACTOR = 0x9E3779B97F4A7C15 - (1 << 64)
"""Fibonacci hashing (Knuth, The Art of Computer Programming 3, 6.4)."""


@kernel("i8(i8[::1], i8, i8, i8[::1], i8[::1], i4[::1])")
def find_neighbouring_cells(keys, row, layer, position, starts, near_points):  # type: ignore[no-untyped-def]
    """Find the neighbours of each cell (at most 26) and return their total number.

    Parameters
    ----------
    keys : (k,) ndarray
        Sorted numbers of cells, i + row j + layer k. No cell is at an end of a row or layer.
    row, layer : int
        Increments of the cell number along j and k.
    position : (9,) ndarray
        Zeros; working space.
    starts : (k + 1,) ndarray
        Output: the neighbours of cell c are near_points[starts[c]:starts[c + 1]].
    near_points : ndarray
        Output: rows of the neighbours in `keys`.
    """
    count = 0
    for c in range(len(keys)):
        starts[c] = count
        for offset_index in range(9):
            first_key = keys[c] + (offset_index // 3 - 1) * layer + (offset_index % 3 - 1) * row - 1
            p = position[offset_index]
            while p < len(keys) and keys[p] < first_key:
                p += 1
            position[offset_index] = p
            while p < len(keys) and keys[p] <= first_key + 2:
                if p != c:
                    near_points[count] = p
                    count += 1
                p += 1
    starts[len(keys)] = count
    return count


@kernel("b1(f8[:,::1], i8[::1])")
def has_coincident_points(points, cell_starts):  # type: ignore[no-untyped-def]
    """Return whether two points of a cell have the same coordinates."""
    for c in range(len(cell_starts) - 1):
        for a in range(cell_starts[c], cell_starts[c + 1]):
            for b in range(a + 1, cell_starts[c + 1]):
                if (
                    points[a, 0] == points[b, 0]
                    and points[a, 1] == points[b, 1]
                    and points[a, 2] == points[b, 2]
                ):
                    return True
    return False


@kernel("i8(f8[:,::1], f8[::1], f8[::1])")
def find_bounds(points, low, high):  # type: ignore[no-untyped-def]
    """Compute the bounds of the finite points and return the number of non-finite points.

    `low` and `high` are inf and -inf on entry and contain the bounds on return.
    """
    n_non_finite = 0
    ax, ay, az = low[0], low[1], low[2]
    bx, by, bz = high[0], high[1], high[2]
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        if not math.isfinite(x + y + z) and not (
            math.isfinite(x) and math.isfinite(y) and math.isfinite(z)
        ):
            n_non_finite += 1
            continue
        ax, ay, az = min(ax, x), min(ay, y), min(az, z)
        bx, by, bz = max(bx, x), max(by, y), max(bz, z)
    low[0], low[1], low[2] = ax, ay, az
    high[0], high[1], high[2] = bx, by, bz
    return n_non_finite


@part
def _number(points, p, cells_per_unit, row, layer):  # type: ignore[no-untyped-def]
    return (
        int(points[p, 0] * cells_per_unit)
        + 1
        + row * (int(points[p, 1] * cells_per_unit) + 1)
        + layer * (int(points[p, 2] * cells_per_unit) + 1)
    )


@kernel("void(f8[:,::1], f8, i8, i8, i8[::1])")
def cell_numbers(points, cells_per_unit, row, layer, keys):  # type: ignore[no-untyped-def]
    """Compute the cell number i + row j + layer k of each point.

    i, j and k start at 1; `cells_per_unit` is the number of cells per unit. Coordinates are not
    negative.
    """
    for p in range(len(points)):
        keys[p] = _number(points, p, cells_per_unit, row, layer)


@kernel("i8(f8[:,::1], f8, i8, i8, i8[::1])")
def number_points_in_cells(points, cells_per_unit, row, layer, keys):  # type: ignore[no-untyped-def]
    """Compute the cell numbers of the points in one of 16 cells; return their count.

    A sixteenth of the cells is selected by a hash of their numbers; see also `cell_numbers`.
    """
    count = 0
    for p in range(len(points)):
        key = _number(points, p, cells_per_unit, row, layer)
        if (key * _HASH_FACTOR) >> 60 == 0:
            keys[count] = key
            count += 1
    return count


@kernel("void(i8[::1], i8, i8, i8[::1], i8[::1])")
def radix_sort(values, first, last, buffer, counts):  # type: ignore[no-untyped-def]
    """Sort values by the bits `first` to `last` - 1, preserving the order of equal values.

    This is a radix sort from the lowest bits upwards (Knuth, The Art of Computer Programming 3,
    5.2.5). `buffer`, which has the length of `values`, and `counts` (512,) are working space.
    """
    n, n_passes = len(values), 0
    for shift in range(first, last, 9):
        mask = (1 << min(9, last - shift)) - 1
        source, target = (values, buffer) if n_passes % 2 == 0 else (buffer, values)
        n_passes += 1
        counts[:] = 0
        for i in range(n):
            counts[(source[i] >> shift) & mask] += 1
        count = 0
        for k in range(mask + 1):
            counts[k], count = count, count + counts[k]
        for i in range(n):
            k = (source[i] >> shift) & mask
            target[counts[k]] = source[i]
            counts[k] += 1
    if n_passes % 2 == 1:
        # A slice assignment would allocate memory, which requires numba's runtime.
        for i in range(n):
            values[i] = buffer[i]


@kernel("i8(i8[::1], i8, f8[:,::1], i8[::1], i8[::1], f8[:,::1], i8[::1], i8[::1])")
def sort_points_by_cell(packed_keys, bits, points, rows, sorted_rows, positions, keys, cell_starts):  # type: ignore[no-untyped-def]
    """Sort points by cell and return the number of cells.

    Parameters
    ----------
    packed_keys : (n,) ndarray
        Sorted cell numbers, with the row of the point in the lower `bits`.
    bits : int
    points : (n, 3) ndarray
    rows, sorted_rows : (n,) ndarray
        Output: row of each sorted point, and sorted position of each row.
    positions : (n, 3) ndarray
        Output: sorted points.
    keys, cell_starts : ndarray
        Output: number of each cell and its first sorted point.
    """
    n_cells, last_cell = 0, -1
    low = (1 << bits) - 1
    for k in range(len(packed_keys)):
        key, row = packed_keys[k] >> bits, packed_keys[k] & low
        rows[k], sorted_rows[row] = row, k
        positions[k, 0], positions[k, 1], positions[k, 2] = (
            points[row, 0],
            points[row, 1],
            points[row, 2],
        )
        if key != last_cell:
            keys[n_cells], cell_starts[n_cells] = key, k
            n_cells, last_cell = n_cells + 1, key
    cell_starts[n_cells] = len(packed_keys)
    return n_cells


@kernel(
    "void(f8[:,::1], i8[::1], i8[::1], i4[::1], i8[::1], i8, i8, f8, i8[::1], i8[::1],"
    "i4[:,::1], f8[:,::1], b1[::1])"
)
def nearest_in_block(  # type: ignore[no-untyped-def]
    points,
    cell_starts,
    starts,
    neighbouring_cells,
    keys,
    row,
    layer,
    side,
    rows,
    cells,
    near,
    squares,
    is_certain,
):
    """Find the nearest points of each row in its cell and the cells around it.

    Parameters
    ----------
    points, cell_starts, starts, neighbouring_cells, keys
        Sorted points and their cells, as returned by `sort_points_by_cell` and
        `find_neighbouring_cells`.
    row, layer, side
        Increments of the cell number, and side length of a cell.
    rows, cells : (k,) ndarray
        Rows of the query points, and their cells.
    near, squares : (k, m) ndarray
        Output: rows of the nearest points, the point itself first, and squared distances.
    is_certain : (k,) ndarray of bool
        Output: whether m points were found and no point in a farther cell can be nearer.
    """
    maximum = near.shape[1]
    for i in range(len(rows)):
        x, y, z = points[rows[i], 0], points[rows[i], 1], points[rows[i], 2]
        c = cells[i]
        count, worst_square = 0, math.inf
        for neighbour_index in range(starts[c] - 1, starts[c + 1]):
            o = c if neighbour_index < starts[c] else neighbouring_cells[neighbour_index]
            for p in range(cell_starts[o], cell_starts[o + 1]):
                dx, dy, dz = points[p, 0] - x, points[p, 1] - y, points[p, 2] - z
                square = dx * dx + dy * dy + dz * dz
                if square >= worst_square:
                    continue
                j = min(count, maximum - 1)
                while j > 0 and squares[i, j - 1] > square:
                    squares[i, j], near[i, j] = squares[i, j - 1], near[i, j - 1]
                    j -= 1
                squares[i, j], near[i, j] = square, p
                count = min(count + 1, maximum)
                if count == maximum:
                    worst_square = squares[i, maximum - 1]
        # Distance from the point to the border of the block.
        a = x - (keys[c] % row - 1) * side
        b = y - (keys[c] % layer // row - 1) * side
        d = z - (keys[c] // layer - 1) * side
        clearance = min(min(a, side - a), min(b, side - b), min(d, side - d))
        clearance = side * (1.0 - 1e-9) + clearance
        is_certain[i] = count == maximum and worst_square <= clearance * clearance


@kernel("void(f8[:,::1], i8[::1], f8[:,::1], f8[:,::1])")
def cell_moments(points, cell_starts, means, covariances):  # type: ignore[no-untyped-def]
    """Compute the mean and covariance (xx, yy, zz, xy, xz, yz) of the points of each cell."""
    for c in range(len(cell_starts) - 1):
        first_point, last_point = cell_starts[c], cell_starts[c + 1]
        n = last_point - first_point
        x, y, z = points[first_point, 0], points[first_point, 1], points[first_point, 2]
        sx, sy, sz = 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(first_point + 1, last_point):
            dx, dy, dz = points[p, 0] - x, points[p, 1] - y, points[p, 2] - z
            sx, sy, sz = sx + dx, sy + dy, sz + dz
            xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
            xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
        sx, sy, sz = sx / n, sy / n, sz / n
        means[c, 0], means[c, 1], means[c, 2] = x + sx, y + sy, z + sz
        covariances[c, 0], covariances[c, 1], covariances[c, 2] = (
            xx / n - sx * sx,
            yy / n - sy * sy,
            zz / n - sz * sz,
        )
        covariances[c, 3], covariances[c, 4], covariances[c, 5] = (
            xy / n - sx * sy,
            xz / n - sx * sz,
            yz / n - sy * sz,
        )


@kernel(
    "void(i8, i8, i8[::1], f8[:,::1], f8[:,::1], i8[::1], i4[::1], i8[::1], f8[:,::1], f8[:,::1])"
)
def block_planes(  # type: ignore[no-untyped-def]
    first, last, cell_starts, means, covariances, starts, neighbours, count, normals, spreads
):
    """Fit a plane to the points of each cell from `first` to `last` and the cells around it.

    The outputs are the number of points, the unit normal, and the eigenvalues of the covariance in
    ascending order.
    """
    for c in range(first, last):
        x, y, z = means[c, 0], means[c, 1], means[c, 2]
        n = 0.0
        sx, sy, sz = 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(starts[c] - 1, starts[c + 1]):
            o = c if k < starts[c] else neighbours[k]
            w = float(cell_starts[o + 1] - cell_starts[o])
            dx, dy, dz = means[o, 0] - x, means[o, 1] - y, means[o, 2] - z
            n += w
            sx, sy, sz = sx + w * dx, sy + w * dy, sz + w * dz
            xx, yy = xx + w * (dx * dx + covariances[o, 0]), yy + w * (dy * dy + covariances[o, 1])
            zz, xy = zz + w * (dz * dz + covariances[o, 2]), xy + w * (dx * dy + covariances[o, 3])
            xz, yz = xz + w * (dx * dz + covariances[o, 4]), yz + w * (dy * dz + covariances[o, 5])
        sx, sy, sz = sx / n, sy / n, sz / n
        eigen = smallest_eigenvector(
            xx / n - sx * sx,
            yy / n - sy * sy,
            zz / n - sz * sz,
            xy / n - sx * sy,
            xz / n - sx * sz,
            yz / n - sy * sz,
        )
        count[c] = int(n)
        normals[c, 0], normals[c, 1], normals[c, 2] = eigen[0], eigen[1], eigen[2]
        spreads[c, 0], spreads[c, 1], spreads[c, 2] = max(eigen[3], 0.0), eigen[4], eigen[5]
