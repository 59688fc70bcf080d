"""Compiled search for the points of a plane that are touched by an empty disc.

A disc of radius R can touch a point if its centre can be at the distance R from the point without
another point inside the disc. Each neighbour closer than 2 R excludes an arc of directions. The
remaining directions are gaps; at both ends of a gap, the disc touches a neighbour (the alpha shape
of Edelsbrunner, Kirkpatrick & Seidel 1983, edge by edge).
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part

_FULL_CIRCLE_RAD = 2.0 * math.pi
_MIN_ARC_RAD = 1e-12


@kernel("void(f8[:,::1], f8[:,::1], f8[::1], f8[:,::1], f8[:,::1])")
def flatten_points(points, axes, centre, plane_coordinates, ends):  # type: ignore[no-untyped-def]
    """Project points onto two axes (2, 3), and write their coordinates and limits (2, 2)."""
    cx, cy, cz = centre[0], centre[1], centre[2]
    a, b, c = axes[0, 0], axes[0, 1], axes[0, 2]
    d, e, f = axes[1, 0], axes[1, 1], axes[1, 2]
    for i in range(len(points)):
        x, y, z = points[i, 0] - cx, points[i, 1] - cy, points[i, 2] - cz
        u, v = a * x + b * y + c * z, d * x + e * y + f * z
        plane_coordinates[i, 0], plane_coordinates[i, 1] = u, v
        if i == 0:
            ends[0, 0], ends[0, 1], ends[1, 0], ends[1, 1] = u, v, u, v
        ends[0, 0], ends[0, 1] = min(ends[0, 0], u), min(ends[0, 1], v)
        ends[1, 0], ends[1, 1] = max(ends[1, 0], u), max(ends[1, 1], v)


@kernel("void(f8[:,::1], f8, f8, f8, i8, i8[::1], i8[::1], f8[:,::1])")
def sort_into_cells(plane_coordinates, x, y, cells_per_unit, columns, cell_starts, cell, out):  # type: ignore[no-untyped-def]
    """Sort points by the square cells of a grid, row by row.

    The corner of the grid is at (x, y); there are `cells_per_unit` cells per unit. `cell_starts`
    (cells + 1,) must be zero on entry, and receives the start of each cell; `cell` (points,) is a
    work array; the sorted points are written to `out`.
    """
    for i in range(len(plane_coordinates)):
        c = int((plane_coordinates[i, 0] - x) * cells_per_unit) + columns * int(
            (plane_coordinates[i, 1] - y) * cells_per_unit
        )
        cell[i] = c
        cell_starts[c + 1] += 1
    for c in range(1, len(cell_starts)):
        cell_starts[c] += cell_starts[c - 1]
    for i in range(len(plane_coordinates) - 1, -1, -1):
        c = cell[i]
        # Filled from the end, so that each end becomes the start of its cell.
        cell_starts[c + 1] -= 1
        position = cell_starts[c + 1]
        out[position, 0], out[position, 1] = plane_coordinates[i, 0], plane_coordinates[i, 1]
    for c in range(len(cell_starts) - 1):
        cell_starts[c] = cell_starts[c + 1]
    cell_starts[len(cell_starts) - 1] = len(plane_coordinates)


@kernel("i8(f8[:,::1], i8[::1], f8, f8, f8, i8, i8, b1[:,::1])")
def thin_cells(points, cell_starts, x, y, cells_per_unit, columns, max_points, is_occupied):  # type: ignore[no-untyped-def]
    """Keep one point per square in cells with more than `max_points`; return the total.

    The points must be sorted by `sort_into_cells`; they and `cell_starts` are updated in place.
    `is_occupied` is a work array for the squares of one cell.
    """
    squares_per_side, total, first = len(is_occupied), 0, 0
    for c in range(len(cell_starts) - 1):
        last_point = cell_starts[c + 1]
        is_crowded = last_point - first > max_points
        if is_crowded:
            is_occupied[:] = False
        u, v = c % columns, c // columns
        cell_starts[c] = total
        for p in range(first, last_point):
            a, b = points[p, 0], points[p, 1]
            if is_crowded:
                i = min(
                    max(int(((a - x) * cells_per_unit - u) * squares_per_side), 0),
                    squares_per_side - 1,
                )
                j = min(
                    max(int(((b - y) * cells_per_unit - v) * squares_per_side), 0),
                    squares_per_side - 1,
                )
                if is_occupied[i, j]:
                    continue
                is_occupied[i, j] = True
            points[total, 0], points[total, 1] = a, b
            total += 1
        first = last_point
    cell_starts[len(cell_starts) - 1] = total
    return total


@part
def _is_interior(cell_starts, columns, c):  # type: ignore[no-untyped-def]
    """Return whether a cell and its eight neighbours all contain points."""
    for row in range(-1, 2):
        for column in range(-1, 2):
            position = c + row * columns + column
            if cell_starts[position] == cell_starts[position + 1]:
                return False
    return True


@part
def _is_surrounded(points, cell_starts, columns, c, p, max_offset, radius, table):  # type: ignore[no-untyped-def]
    """Return whether neighbours exclude all of the 64 sectors of directions.

    A sector counts only if a single neighbour excludes it completely.
    """
    bins = table.shape[0]
    x, y = points[p, 0], points[p, 1]
    bins_per_unit, half_bins = bins / (4.0 * radius), bins / 2.0
    sectors = 0
    for row in range(max_offset + 1):
        # Start with the nearest rows of cells.
        for side in range(1 if row == 0 else 2):
            first = c + (row if side == 0 else -row) * columns
            for q in range(cell_starts[first - max_offset], cell_starts[first + max_offset + 1]):
                i = int((points[q, 0] - x) * bins_per_unit + half_bins)
                j = int((points[q, 1] - y) * bins_per_unit + half_bins)
                if i >= 0 and j >= 0 and i < bins and j < bins:
                    sectors |= table[i, j]
            if sectors == -1:
                return True
    return False


@part
def _list_arcs(points, cell_starts, columns, c, p, max_offset, radius, neighbours, arcs):  # type: ignore[no-untyped-def]
    """List neighbours with the arcs (start, width) that they exclude; return their number."""
    x, y = points[p, 0], points[p, 1]
    count = 0
    for row in range(-max_offset, max_offset + 1):
        first = c + row * columns
        for q in range(cell_starts[first - max_offset], cell_starts[first + max_offset + 1]):
            dx, dy = points[q, 0] - x, points[q, 1] - y
            distance = math.sqrt(dx * dx + dy * dy)
            if distance >= 2.0 * radius or distance == 0.0 or count == len(neighbours):
                continue
            half_angle = math.acos(distance / (2.0 * radius))
            neighbours[count] = q
            arcs[count, 0], arcs[count, 1] = math.atan2(dy, dx) - half_angle, 2.0 * half_angle
            count += 1
    return count


@part
def _wrap_angle(angle):  # type: ignore[no-untyped-def]
    return angle - _FULL_CIRCLE_RAD * math.floor(angle / _FULL_CIRCLE_RAD)


@kernel(
    "i8(f8[:,::1], f8, f8, f8, i8, i8[::1], i8, f8, b1, i8[:,::1], b1[::1], i4[::1], i4[::1],"
    "f8[:,::1], i4[:,::1])"
)
def roll_disc(  # type: ignore[no-untyped-def]
    points,
    x,
    y,
    cells_per_unit,
    columns,
    cell_starts,
    max_offset,
    radius,
    skip_interior,
    table,
    is_queued,
    queue,
    neighbours,
    arcs,
    edges,
):
    """Write the pairs of points between which an empty disc rolls, and return their number.

    Return -1 if there are more pairs than fit into `edges`. The points must be sorted by
    `sort_into_cells`, with a margin of `max_offset` + 1 empty cells. If `skip_interior`, only gaps
    that reach a cell beside an empty cell are used. `table` contains the sectors that a neighbour
    excludes (see polygons.py); `is_queued` must be False on entry; `queue`, `neighbours` and `arcs`
    are work arrays.
    """
    tail, total = 0, 0
    rows = (len(cell_starts) - 1) // columns
    for row in range(max_offset + 1, rows - max_offset - 1):
        for c in range(row * columns + max_offset + 1, (row + 1) * columns - max_offset - 1):
            if cell_starts[c] == cell_starts[c + 1] or (
                skip_interior and _is_interior(cell_starts, columns, c)
            ):
                continue
            for p in range(cell_starts[c], cell_starts[c + 1]):
                is_queued[p] = True
                queue[tail] = p
                tail += 1
    head = 0
    while head < tail:
        p = queue[head]
        head += 1
        c = int((points[p, 0] - x) * cells_per_unit) + columns * int(
            (points[p, 1] - y) * cells_per_unit
        )
        if _is_surrounded(points, cell_starts, columns, c, p, max_offset, radius, table):
            continue
        arc_count = _list_arcs(
            points, cell_starts, columns, c, p, max_offset, radius, neighbours, arcs
        )
        if arc_count == 0:
            continue
        last_neighbour, swept_angle = neighbours[0], 0.0
        end = arcs[0, 0] + arcs[0, 1]
        while swept_angle < _FULL_CIRCLE_RAD - 1e-9:
            gain, extending_arc, gap, next_arc = _MIN_ARC_RAD, -1, 2.0 * _FULL_CIRCLE_RAD, -1
            for k in range(arc_count):
                arc_offset = _wrap_angle(end - arcs[k, 0])
                if arcs[k, 1] - arc_offset > gain:
                    gain, extending_arc = arcs[k, 1] - arc_offset, k
                elif extending_arc < 0 and _FULL_CIRCLE_RAD - arc_offset < gap:
                    gap, next_arc = _FULL_CIRCLE_RAD - arc_offset, k
            if extending_arc >= 0:
                last_neighbour, end, swept_angle = (
                    neighbours[extending_arc],
                    end + gain,
                    swept_angle + gain,
                )
                continue
            if swept_angle + gap > _FULL_CIRCLE_RAD + 1e-9:
                break
            if total == len(edges):
                return -1
            edges[total, 0], edges[total, 1] = p, neighbours[next_arc]
            total += 1
            for q in (last_neighbour, neighbours[next_arc]):
                if not is_queued[q]:
                    is_queued[q] = True
                    queue[tail] = q
                    tail += 1
            last_neighbour, swept_angle = (
                neighbours[next_arc],
                swept_angle + gap + arcs[next_arc, 1],
            )
            end += gap + arcs[next_arc, 1]
    return total
