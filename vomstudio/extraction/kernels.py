"""Compiled inner loops of the facet search.

Elements are the faces of a mesh or the points of a cloud; `starts` and `neighbours` list the
neighbours of each element. No function allocates memory: results are written to arguments.
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.cells import find_slot, smallest_eigenvector
from vomstudio.geometry.kernels.jit import kernel, part


@kernel("void(f8[:,::1], f8[:,::1], i4[:,::1], f8[:,::1], f8[::1])")
def fit_local_planes(points, positions, rows, normals, variation):  # type: ignore[no-untyped-def]
    """Fit a plane to the k points around each position.

    Unit normals (n, 3) and the surface variation (n,) are written. The variation is the smallest
    eigenvalue of the covariance divided by the sum of the eigenvalues (Pauly, Gross & Kobbelt
    2002). Both are NaN if the points do not define a plane.
    """
    k = rows.shape[1]
    for row in range(len(positions)):
        x, y, z = positions[row, 0], positions[row, 1], positions[row, 2]
        sx, sy, sz = 0.0, 0.0, 0.0
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(k):
            position = rows[row, j]
            dx, dy, dz = points[position, 0] - x, points[position, 1] - y, points[position, 2] - z
            sx, sy, sz = sx + dx, sy + dy, sz + dz
            xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
            xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
        sx, sy, sz = sx / k, sy / k, sz / k
        eigen = smallest_eigenvector(
            xx / k - sx * sx,
            yy / k - sy * sy,
            zz / k - sz * sz,
            xy / k - sx * sy,
            xz / k - sx * sz,
            yz / k - sy * sz,
        )
        total = eigen[3] + eigen[4] + eigen[5]
        if eigen[4] > 1e-9 * eigen[5] and total > 0.0:
            normals[row, 0], normals[row, 1], normals[row, 2] = eigen[0], eigen[1], eigen[2]
            variation[row] = max(eigen[3], 0.0) / total
        else:
            normals[row, 0], normals[row, 1], normals[row, 2] = math.nan, math.nan, math.nan
            variation[row] = math.nan


@kernel("void(f8[:,::1], f8[::1], i8[::1], i4[::1], f8, f8[:,::1])")
def average_normals(normals, areas, starts, neighbours, min_cosine, out):  # type: ignore[no-untyped-def]
    """Average the normals of each element and its neighbours, weighted by area.

    Only neighbours within the angle whose cosine is `min_cosine` are used. Normals are axial.
    """
    for e in range(len(normals)):
        nx, ny, nz = normals[e, 0], normals[e, 1], normals[e, 2]
        sx, sy, sz = areas[e] * nx, areas[e] * ny, areas[e] * nz
        for k in range(starts[e], starts[e + 1]):
            o = neighbours[k]
            c = nx * normals[o, 0] + ny * normals[o, 1] + nz * normals[o, 2]
            if abs(c) < min_cosine or c != c:
                continue
            w = areas[o] if c > 0.0 else -areas[o]
            sx, sy, sz = sx + w * normals[o, 0], sy + w * normals[o, 1], sz + w * normals[o, 2]
        size = math.sqrt(sx * sx + sy * sy + sz * sz)
        if size > 0.0:
            out[e, 0], out[e, 1], out[e, 2] = sx / size, sy / size, sz / size
        else:
            out[e, 0], out[e, 1], out[e, 2] = nx, ny, nz


@kernel("void(f8[:,::1], i8[::1], i4[::1], f8[::1])")
def neighbour_cosines(normals, starts, neighbours, out):  # type: ignore[no-untyped-def]
    """Write the cosines between the normals of neighbours, in the order of `neighbours`.

    Normals are axial.
    """
    for e in range(len(normals)):
        nx, ny, nz = normals[e, 0], normals[e, 1], normals[e, 2]
        for k in range(starts[e], starts[e + 1]):
            o = neighbours[k]
            out[k] = abs(nx * normals[o, 0] + ny * normals[o, 1] + nz * normals[o, 2])


@part
def _clear_sums(sums):  # type: ignore[no-untyped-def]
    for j in range(10):
        sums[j] = 0.0


@part
def _add_element(sums, w, x, y, z, inner_moments, e):  # type: ignore[no-untyped-def]
    """Add an element to the sums of weight, first moments and second moments."""
    i = e if len(inner_moments) > 1 else 0
    sums[0] += w
    sums[1] += w * x
    sums[2] += w * y
    sums[3] += w * z
    sums[4] += w * (x * x + inner_moments[i, 0])
    sums[5] += w * (y * y + inner_moments[i, 1])
    sums[6] += w * (z * z + inner_moments[i, 2])
    sums[7] += w * (x * y + inner_moments[i, 3])
    sums[8] += w * (x * z + inner_moments[i, 4])
    sums[9] += w * (y * z + inner_moments[i, 5])


@part
def _fit_plane(sums):  # type: ignore[no-untyped-def]
    """Return the normal, the mean and the two larger eigenvalues of the sums."""
    w = sums[0]
    x, y, z = sums[1] / w, sums[2] / w, sums[3] / w
    eigen = smallest_eigenvector(
        sums[4] / w - x * x,
        sums[5] / w - y * y,
        sums[6] / w - z * z,
        sums[7] / w - x * y,
        sums[8] / w - x * z,
        sums[9] / w - y * z,
    )
    return eigen[0], eigen[1], eigen[2], x, y, z, eigen[4], eigen[5]


@kernel(
    "i8(i8[::1], i8, i8, f8[:,::1], f8[:,::1], f8[::1], f8[:,::1], f8[::1], i8[::1], i4[::1],"
    "f8, i8, f8, i4[::1], i4[::1], i8, f8[::1])"
)
def grow_regions(  # type: ignore[no-untyped-def]
    order,
    first,
    last,
    positions,
    normals,
    areas,
    inner_moments,
    max_distance,
    starts,
    neighbours,
    min_cosine,
    min_count,
    min_area,
    labels,
    queue,
    label,
    sums,
):
    """Grow regions from the seeds order[first:last], in order; return the next free label.

    An element joins a region if its normal is within the angle of the plane of the region, and its
    position is within its `max_distance` of the plane. The plane is refitted whenever the region
    has grown by half. Regions with fewer elements than `min_count` are dissolved unless they
    reach `min_area`. In `labels`, -1 marks free elements and -2 excluded elements.
    """
    for seed in range(first, last):
        s = order[seed]
        if labels[s] != -1:
            continue
        ox, oy, oz = positions[s, 0], positions[s, 1], positions[s, 2]
        nx, ny, nz = normals[s, 0], normals[s, 1], normals[s, 2]
        cx, cy, cz = 0.0, 0.0, 0.0
        _clear_sums(sums)
        _add_element(sums, areas[s], 0.0, 0.0, 0.0, inner_moments, s)
        labels[s] = label
        queue[0] = s
        head, tail, refit_size = 0, 1, 8
        while head < tail:
            e = queue[head]
            head += 1
            for k in range(starts[e], starts[e + 1]):
                o = neighbours[k]
                if labels[o] != -1:
                    continue
                c = nx * normals[o, 0] + ny * normals[o, 1] + nz * normals[o, 2]
                if not abs(c) >= min_cosine:
                    continue
                x, y, z = positions[o, 0] - ox, positions[o, 1] - oy, positions[o, 2] - oz
                offset = (x - cx) * nx + (y - cy) * ny + (z - cz) * nz
                if not abs(offset) <= max_distance[o]:
                    continue
                labels[o] = label
                queue[tail] = o
                tail += 1
                _add_element(sums, areas[o], x, y, z, inner_moments, o)
                if tail >= refit_size:
                    refit_size = tail + tail // 2
                    plane = _fit_plane(sums)
                    if plane[6] > 1e-6 * plane[7]:
                        nx, ny, nz = plane[0], plane[1], plane[2]
                        cx, cy, cz = plane[3], plane[4], plane[5]
        if tail < min_count and sums[0] < min_area:
            for k in range(tail):
                labels[queue[k]] = -1
        else:
            label += 1
    return label


@kernel(
    "i8(i8[::1], f8[:,::1], f8[:,::1], f8[::1], i8[::1], i4[::1], f8, f8[:,::1], f8[:,::1],"
    "f8[::1], i4[::1], i4[::1])"
)
def assign_nearest_planes(  # type: ignore[no-untyped-def]
    rows,
    positions,
    normals,
    max_distance,
    starts,
    neighbours,
    min_cosine,
    centres,
    plane_normals,
    limits,
    labels,
    out,
):
    """Assign each element of `rows` to the nearest plane among its own and its neighbours'.

    `centres` and `plane_normals` (f, 3) and `limits` (f,) describe the planes of the facets. An
    element beyond the limit of a plane or beyond its own `max_distance` is not assigned to this
    plane. If its normal differs by more than the angle, as at an edge between two faces, it must be
    twice as close; if it differs by more than 60 degrees or is unknown, it is not assigned. The
    labels are written to `out` (rows,), and the number of changes is returned.
    """
    changed_count = 0
    for i in range(len(rows)):
        e = rows[i]
        best_plane, min_distance = -1, math.inf
        if labels[e] == -2:
            out[i] = -2
            continue
        for k in range(starts[e] - 1, starts[e + 1]):
            f = labels[e] if k < starts[e] else labels[neighbours[k]]
            if f < 0 or f == best_plane:
                continue
            distance = abs(
                (positions[e, 0] - centres[f, 0]) * plane_normals[f, 0]
                + (positions[e, 1] - centres[f, 1]) * plane_normals[f, 1]
                + (positions[e, 2] - centres[f, 2]) * plane_normals[f, 2]
            )
            limit = min(max_distance[e], limits[f])
            c = abs(
                normals[e, 0] * plane_normals[f, 0]
                + normals[e, 1] * plane_normals[f, 1]
                + normals[e, 2] * plane_normals[f, 2]
            )
            if not c >= min_cosine:
                limit *= 0.5
                if not c >= 0.5:
                    continue
            if distance <= limit and distance < min_distance:
                best_plane, min_distance = f, distance
        out[i] = best_plane
        if best_plane != labels[e]:
            changed_count += 1
    return changed_count


@kernel(
    "void(i8[::1], f8[:,::1], f8[::1], f8[:,::1], f8[::1], i4[::1], f8[:,::1], b1[::1], f8[:,::1],"
    "i8[::1])"
)
def add_moments(  # type: ignore[no-untyped-def]
    rows,
    positions,
    areas,
    inner_moments,
    max_distance,
    labels,
    reference_points,
    is_known,
    sums,
    count,
):
    """Add the moments of the elements `rows` to the `sums` and `count` of their facets.

    The columns of `sums` (f, 11) are the weight, the first and second moments about the reference
    point (the position of the first element unless `is_known`), and the squares of `max_distance`
    if it has one value per element. `count` has the shape (f,).
    """
    for e in rows:
        f = labels[e]
        if f < 0:
            continue
        if not is_known[f]:
            is_known[f] = True
            reference_points[f, 0], reference_points[f, 1], reference_points[f, 2] = (
                positions[e, 0],
                positions[e, 1],
                positions[e, 2],
            )
        count[f] += 1
        if len(max_distance) > 1:
            sums[f, 10] += max_distance[e] * max_distance[e]
        _add_element(
            sums[f],
            areas[e],
            positions[e, 0] - reference_points[f, 0],
            positions[e, 1] - reference_points[f, 1],
            positions[e, 2] - reference_points[f, 2],
            inner_moments,
            e,
        )


@kernel("void(i4[::1], i4[::1], i4[::1])")
def map_labels(labels, number, out):  # type: ignore[no-untyped-def]
    """Map labels to numbers; labels below 0 index from the end of `number`."""
    for e in range(len(labels)):
        f = labels[e]
        out[e] = number[f if f >= 0 else len(number) + f]


@kernel("void(f8[:,::1], f8[:,::1], f8[::1], f8, i8[::1], i8[:,::1], f8[:,::1])")
def add_to_cells(positions, normals, areas, cells_per_unit, names, ends, sums):  # type: ignore[no-untyped-def]
    """Add elements with a normal to the cubic cells of a table.

    The cells have a width of 1 / `cells_per_unit`. The columns of `sums` are the area and the
    area-weighted sums of the products of the normals (xx, yy, zz, xy, xz, yz), of the positions
    relative to the corner of the cell, and of the products of these positions.
    """
    for e in range(len(positions)):
        x, y, z = (
            positions[e, 0] * cells_per_unit,
            positions[e, 1] * cells_per_unit,
            positions[e, 2] * cells_per_unit,
        )
        i, j, k = int(x), int(y), int(z)
        slot = find_slot(names, cell_key(i, j, k))
        u, v, w = normals[e, 0], normals[e, 1], normals[e, 2]
        if names[slot] == -1 or u != u:
            continue
        row, area = sums[ends[slot, 0]], areas[e]
        x, y, z = x - i, y - j, z - k
        row[0] += area
        row[1] += area * u * u
        row[2] += area * v * v
        row[3] += area * w * w
        row[4] += area * u * v
        row[5] += area * u * w
        row[6] += area * v * w
        row[7] += area * x
        row[8] += area * y
        row[9] += area * z
        row[10] += area * x * x
        row[11] += area * y * y
        row[12] += area * z * z
        row[13] += area * x * y
        row[14] += area * x * z
        row[15] += area * y * z


@part
def cell_key(i, j, k):  # type: ignore[no-untyped-def]
    """Combine three cell indices into one key, which repeats after 2 million cells."""
    return ((i & 0x1FFFFF) << 42) | ((j & 0x1FFFFF) << 21) | (k & 0x1FFFFF)


@kernel("void(i4[::1], i8[::1], i8[::1])")
def sort_by_label(labels, starts, order):  # type: ignore[no-untyped-def]
    """Sort elements by facet: the elements of facet f become order[starts[f]:starts[f + 1]].

    `starts` (facets + 1,) must be zero on entry. Elements that belong to no facet are omitted.
    """
    for e in range(len(labels)):
        if labels[e] >= 0:
            starts[labels[e] + 1] += 1
    for f in range(1, len(starts)):
        starts[f] += starts[f - 1]
    for e in range(len(labels)):
        if labels[e] >= 0:
            order[starts[labels[e]]] = e
            starts[labels[e]] += 1
    for f in range(len(starts) - 1, 0, -1):
        starts[f] = starts[f - 1]
    starts[0] = 0
