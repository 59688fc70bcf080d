"""Compiled loops that grow a piece of a surface, or a selection by one ring."""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.cells import find_slot, lower_bound, smallest_eigenvector
from vomstudio.geometry.kernels.jit import kernel, part


@part
def _clear_sums(sums):  # type: ignore[no-untyped-def]
    for j in range(10):
        sums[j] = 0.0


@part
def _add_point(sums, w, x, y, z):  # type: ignore[no-untyped-def]
    sums[0] += w
    sums[1] += w * x
    sums[2] += w * y
    sums[3] += w * z
    sums[4] += w * x * x
    sums[5] += w * y * y
    sums[6] += w * z * z
    sums[7] += w * x * y
    sums[8] += w * x * z
    sums[9] += w * y * z


@part
def _fit_plane(sums, plane):  # type: ignore[no-untyped-def]
    """Write the centre and normal to plane[:6]; leave it unchanged if no plane is defined."""
    w = sums[0]
    if not w > 0.0:
        return
    x, y, z = sums[1] / w, sums[2] / w, sums[3] / w
    eigen = smallest_eigenvector(
        sums[4] / w - x * x,
        sums[5] / w - y * y,
        sums[6] / w - z * z,
        sums[7] / w - x * y,
        sums[8] / w - x * z,
        sums[9] / w - y * z,
    )
    if eigen[4] > 1e-3 * eigen[5]:
        plane[0], plane[1], plane[2] = x, y, z
        plane[3], plane[4], plane[5] = eigen[0], eigen[1], eigen[2]


@kernel("void(f8[:,::1], i4[:,::1], f4[:,::1])")
def compute_face_normals(vertices, faces, out):  # type: ignore[no-untyped-def]
    """Write twice the area of each face times its unit normal."""
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1]
        uz, vz = vertices[b, 2] - vertices[a, 2], vertices[c, 2] - vertices[a, 2]
        vx, vy = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1]
        out[f, 0] = uy * vz - uz * vy
        out[f, 1] = uz * vx - ux * vz
        out[f, 2] = ux * vy - uy * vx


@kernel("void(i4[:,::1], i8[::1], i4[::1], f4[:,::1], i8, f4[:,::1])")
def smooth_normals(corners, starts, neighbours, raw_normals, first, out):  # type: ignore[no-untyped-def]
    """Average the area-weighted normals of faces that share a corner; NaN if the area is 0.

    Only faces within 60 degrees of the face `first` + row are used, regardless of their
    orientation. `corners` (m, 3) are the corner positions of these faces;
    neighbours[starts[i]:starts[i + 1]] are the faces at position i.
    """
    for row in range(len(corners)):
        f = first + row
        nx, ny, nz = float(raw_normals[f, 0]), float(raw_normals[f, 1]), float(raw_normals[f, 2])
        sx, sy, sz = nx, ny, nz
        squared_length = nx * nx + ny * ny + nz * nz
        for k in range(3):
            node = corners[row, k]
            for index in range(starts[node], starts[node + 1]):
                o = neighbours[index]
                x, y, z = (
                    float(raw_normals[o, 0]),
                    float(raw_normals[o, 1]),
                    float(raw_normals[o, 2]),
                )
                cosine = nx * x + ny * y + nz * z
                # A surface beyond an edge must not affect the normals of this one.
                if cosine * cosine < 0.25 * squared_length * (x * x + y * y + z * z):
                    continue
                sign = -1.0 if sx * x + sy * y + sz * z < 0.0 else 1.0
                sx, sy, sz = sx + sign * x, sy + sign * y, sz + sign * z
        size = math.sqrt(sx * sx + sy * sy + sz * sz)
        if size > 0.0:
            out[row, 0], out[row, 1], out[row, 2] = sx / size, sy / size, sz / size
        else:
            out[row, 0] = out[row, 1] = out[row, 2] = math.nan


@kernel("void(i4[:,::1], i8[::1], i4[::1], i8, i4[:,::1])")
def find_adjacent_faces(corners, starts, neighbours, first, out):  # type: ignore[no-untyped-def]
    """Find the next face in the ring at each edge of the faces from `first` on.

    The result is -1 if the edge is free. `corners` (n, 3) are the corner positions of all faces.
    """
    for row in range(len(out)):
        f = first + row
        for k in range(3):
            a, b = corners[f, k], corners[f, (k + 1) % 3]
            lowest_face, second_face = -1, -1
            for index in range(starts[a], starts[a + 1]):
                o = neighbours[index]
                if o == f or a == b:
                    continue
                if corners[o, 0] != b and corners[o, 1] != b and corners[o, 2] != b:
                    continue
                if lowest_face == -1 or o < lowest_face:
                    lowest_face = o
                if o > f and (second_face == -1 or o < second_face):
                    second_face = o
            out[row, k] = second_face if second_face != -1 else lowest_face


@kernel(
    "i8(f8[:,::1], i4[:,::1], i4[:,::1], f4[:,::1], b1[::1], i8, f8, f8, f8[::1], f8[::1], i4[::1])"
)
def grow_faces(  # type: ignore[no-untyped-def]
    vertices,
    faces,
    neighbour_faces,
    normals,
    is_visited,
    seed,
    cosine,
    max_distance,
    plane,
    sums,
    queue,
):
    """Grow a piece from the face `seed` across edges, and return its number of faces.

    A face joins the piece if its normal is within the angle (given by its cosine) of the plane of
    the piece, and its centre is within `max_distance` of the plane. The faces are written to
    `queue`, whose length is the maximum. `is_visited` must be False except for excluded faces;
    `plane` must be zero on entry, and receives the final plane.
    """
    a = faces[seed, 0]
    ox, oy, oz = vertices[a, 0], vertices[a, 1], vertices[a, 2]
    _clear_sums(sums)
    is_visited[seed] = True
    queue[0] = seed
    plane[3], plane[4], plane[5] = normals[seed, 0], normals[seed, 1], normals[seed, 2]
    a, b, c = faces[seed, 0], faces[seed, 1], faces[seed, 2]
    plane[0] = (vertices[a, 0] + vertices[b, 0] + vertices[c, 0]) / 3.0 - ox
    plane[1] = (vertices[a, 1] + vertices[b, 1] + vertices[c, 1]) / 3.0 - oy
    plane[2] = (vertices[a, 2] + vertices[b, 2] + vertices[c, 2]) / 3.0 - oz
    _add_point(sums, 1.0, plane[0], plane[1], plane[2])
    head, tail, refit_size, max_count = 0, 1, 24, len(queue)
    while head < tail:
        e = queue[head]
        head += 1
        for k in range(3):
            o = neighbour_faces[e, k]
            if o == -1 or is_visited[o]:
                continue
            normal_cosine = abs(
                normals[o, 0] * plane[3] + normals[o, 1] * plane[4] + normals[o, 2] * plane[5]
            )
            # Faces without an area have no normal; NaN is not rejected.
            if normal_cosine < cosine:
                continue
            a, b, c = faces[o, 0], faces[o, 1], faces[o, 2]
            x = (vertices[a, 0] + vertices[b, 0] + vertices[c, 0]) / 3.0 - ox
            y = (vertices[a, 1] + vertices[b, 1] + vertices[c, 1]) / 3.0 - oy
            z = (vertices[a, 2] + vertices[b, 2] + vertices[c, 2]) / 3.0 - oz
            offset = (
                (x - plane[0]) * plane[3] + (y - plane[1]) * plane[4] + (z - plane[2]) * plane[5]
            )
            if not abs(offset) <= max_distance:
                continue
            is_visited[o] = True
            if tail == max_count:
                return tail
            queue[tail] = o
            tail += 1
            _add_point(sums, 1.0, x, y, z)
            if tail >= refit_size:
                refit_size = tail + tail // 2
                _fit_plane(sums, plane)
    return tail


@part
def _list_adjacent_cells(rows, columns, names, ends, ny, cell, neighbours):  # type: ignore[no-untyped-def]
    """List a cell and its adjacent cells in `neighbours`; return their number."""
    row, column, count = rows[cell], columns[cell], 0
    j0 = row % ny
    for dk in range(-1, 2):
        for dj in range(-1, 2):
            if j0 + dj < 0 or j0 + dj >= ny or row + dj + ny * dk < 0:
                continue
            slot = find_slot(names, row + dj + ny * dk)
            if names[slot] == -1:
                continue
            end = ends[slot, 1]
            position = lower_bound(columns, column - 1, ends[slot, 0], end)
            while position < end and columns[position] <= column + 1:
                neighbours[count] = position
                count += 1
                position += 1
    return count


@part
def _compute_cell_normal(points, cell_starts, neighbours, count, cell, point_normals, normals):  # type: ignore[no-untyped-def]
    """Write the normal of a cell: the mean of its point normals, or the normal of a plane.

    The plane is fitted to the points of the cell and its adjacent cells if no point has a normal.
    The normal is infinite if these points do not define a plane.
    """
    p = cell_starts[cell]
    if len(point_normals) > 0:
        sx, sy, sz = 0.0, 0.0, 0.0
        for o in range(p, cell_starts[cell + 1]):
            x, y, z = (
                float(point_normals[o, 0]),
                float(point_normals[o, 1]),
                float(point_normals[o, 2]),
            )
            if x * x + y * y + z * z > 0.0:
                sign = -1.0 if sx * x + sy * y + sz * z < 0.0 else 1.0
                sx, sy, sz = sx + sign * x, sy + sign * y, sz + sign * z
        size = math.sqrt(sx * sx + sy * sy + sz * sz)
        if size > 0.0:
            normals[cell, 0], normals[cell, 1] = sx / size, sy / size
            normals[cell, 2] = sz / size
            return
    x, y, z = points[p, 0], points[p, 1], points[p, 2]
    n, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        for o in range(cell_starts[neighbours[k]], cell_starts[neighbours[k] + 1]):
            dx, dy, dz = points[o, 0] - x, points[o, 1] - y, points[o, 2] - z
            n, sx, sy, sz = n + 1.0, sx + dx, sy + dy, sz + dz
            xx, yy, zz = xx + dx * dx, yy + dy * dy, zz + dz * dz
            xy, xz, yz = xy + dx * dy, xz + dx * dz, yz + dy * dz
    sx, sy, sz = sx / n, sy / n, sz / n
    eigen = smallest_eigenvector(
        xx / n - sx * sx,
        yy / n - sy * sy,
        zz / n - sz * sz,
        xy / n - sx * sy,
        xz / n - sx * sz,
        yz / n - sy * sz,
    )
    if n > 3.5 and eigen[4] > 1e-3 * eigen[5]:
        normals[cell, 0], normals[cell, 1], normals[cell, 2] = eigen[0], eigen[1], eigen[2]
    else:
        normals[cell, 0] = normals[cell, 1] = normals[cell, 2] = math.inf


@kernel(
    "i8(f8[:,::1], f4[:,::1], i8[::1], i8[::1], i4[::1], i8[::1], i8[:,::1], i8, f4[:,::1],"
    "b1[::1], b1[::1], i8, i8, f8, f8, f8[::1], f8[::1], i8[::1], i4[::1], i4[::1])"
)
def grow_points(  # type: ignore[no-untyped-def]
    points,
    point_normals,
    cell_starts,
    rows,
    columns,
    names,
    ends,
    ny,
    normals,
    is_excluded,
    is_reached,
    seed,
    cell,
    cosine,
    max_distance,
    plane,
    sums,
    neighbours,
    cells,
    queue,
):
    """Grow a piece from the point `seed` over adjacent cells of a grid. See `grow_faces`.

    The points are sorted by cell. A cell joins the piece if its normal is within the angle, and its
    points within `max_distance` are added. Return the number of points, or -1 if the cell of the
    seed has no plane.

    `cell_starts` (c + 1,) is the first point of each cell; `point_normals` contains the normals of
    the points, or is empty; `normals` contains the normals of the cells, NaN if not yet computed;
    `is_excluded` marks excluded points; `is_reached` must be False on entry; `neighbours` and
    `cells` are work arrays for 27 cells and for all cells.
    """
    ox, oy, oz = points[seed, 0], points[seed, 1], points[seed, 2]
    _clear_sums(sums)
    is_reached[cell] = True
    cells[0] = cell
    head, tail, count, refit_size, max_count = 0, 1, 0, 24, len(queue)
    while head < tail:
        c = cells[head]
        adjacent_count = _list_adjacent_cells(rows, columns, names, ends, ny, c, neighbours)
        if normals[c, 0] != normals[c, 0]:
            _compute_cell_normal(
                points, cell_starts, neighbours, adjacent_count, c, point_normals, normals
            )
        if head == 0:
            if normals[c, 0] == math.inf:
                return -1
            plane[3], plane[4], plane[5] = normals[c, 0], normals[c, 1], normals[c, 2]
        head += 1
        normal_cosine = abs(
            normals[c, 0] * plane[3] + normals[c, 1] * plane[4] + normals[c, 2] * plane[5]
        )
        if not (normal_cosine >= cosine and normal_cosine < 2.0):
            continue
        previous_count = count
        for o in range(cell_starts[c], cell_starts[c + 1]):
            if is_excluded[o]:
                continue
            x, y, z = points[o, 0] - ox, points[o, 1] - oy, points[o, 2] - oz
            offset = (
                (x - plane[0]) * plane[3] + (y - plane[1]) * plane[4] + (z - plane[2]) * plane[5]
            )
            if not abs(offset) <= max_distance:
                continue
            if count == max_count:
                return count
            queue[count] = o
            count += 1
            _add_point(sums, 1.0, x, y, z)
        if count >= refit_size:
            refit_size = count + count // 2
            _fit_plane(sums, plane)
        if count == previous_count:
            continue
        for k in range(adjacent_count):
            if not is_reached[neighbours[k]]:
                is_reached[neighbours[k]] = True
                cells[tail] = neighbours[k]
                tail += 1
    return count


@kernel(
    "void(f8[:,::1], i8[::1], i8[::1], i4[::1], i8[::1], i8[:,::1], i8, b1[::1], i4[::1], f8,"
    "i8[::1], b1[::1], b1[::1])"
)
def mark_ring(  # type: ignore[no-untyped-def]
    points,
    cell_starts,
    rows,
    columns,
    names,
    ends,
    ny,
    is_selected,
    cells,
    link_distance,
    neighbours,
    is_gained,
    is_lost,
):
    """Mark points within `link_distance` of the other side of the boundary of a selection.

    `is_gained` receives the points to add, `is_lost` the points to remove. `cells` are the
    cells that contain selected points; `neighbours` is a work array for 27 cells.
    """
    limit = link_distance * link_distance
    for index in range(len(cells)):
        c = cells[index]
        adjacent_count = _list_adjacent_cells(rows, columns, names, ends, ny, c, neighbours)
        for k in range(adjacent_count):
            for o in range(cell_starts[neighbours[k]], cell_starts[neighbours[k] + 1]):
                if is_selected[o]:
                    continue
                for p in range(cell_starts[c], cell_starts[c + 1]):
                    if is_selected[p] and not (is_gained[o] and is_lost[p]):
                        dx, dy = points[o, 0] - points[p, 0], points[o, 1] - points[p, 1]
                        dz = points[o, 2] - points[p, 2]
                        if dx * dx + dy * dy + dz * dz <= limit:
                            is_gained[o] = True
                            is_lost[p] = True


@kernel("void(i4[:,::1], b1[::1], b1[::1])")
def mark_nodes(corners, is_selected, is_marked_node):  # type: ignore[no-untyped-def]
    """Mark the corners of selected faces."""
    for f in range(len(corners)):
        if is_selected[f]:
            is_marked_node[corners[f, 0]] = True
            is_marked_node[corners[f, 1]] = True
            is_marked_node[corners[f, 2]] = True


@kernel("void(i4[:,::1], b1[::1], b1[::1])")
def find_marked_faces(corners, is_marked_node, out):  # type: ignore[no-untyped-def]
    """Find the faces that have a marked corner."""
    for f in range(len(corners)):
        out[f] = (
            is_marked_node[corners[f, 0]]
            | is_marked_node[corners[f, 1]]
            | is_marked_node[corners[f, 2]]
        )
