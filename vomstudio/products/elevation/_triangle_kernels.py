"""Compiled interpolation between scattered points without a complete triangulation.

Among all triangles that enclose a position, the Delaunay triangle is the one for which the plane
through its corners, lifted to x^2 + y^2, is lowest at this position. Finding it is a linear
programme with three unknowns, which the simplex method solves for each cell among the nearby
points. The result is the same as that of a triangulation of all points, because no other point may
lie inside the circumcircle.
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part

MAX_FLIPS = 1000
POSITION_OFFSET = 1e-6
"""Offset of the evaluated position from the cell centre, in bucket sides.

Without it, a position on an edge between points in rows would not be inside any triangle."""
CIRCLE_TOLERANCE = 1e-9
"""Tolerance of the test whether a point is inside a circle, in squared bucket sides."""


@part
def _row(starts, nx, j, low, high, grid_left, cell_size):  # type: ignore[no-untyped-def]
    """Return the range of points (end excluded) in a row of buckets between two positions."""
    i0 = min(max(math.floor((low - grid_left) / cell_size), 0), nx - 1)
    i1 = min(max(math.floor((high - grid_left) / cell_size), 0), nx - 1)
    return starts[j * nx + i0], starts[j * nx + i1 + 1]


@part
def _rows(ny, low, high, top, cell_size):  # type: ignore[no-untyped-def]
    j0 = min(max(math.floor((low - top) / cell_size), 0), ny - 1)
    j1 = min(max(math.floor((high - top) / cell_size), 0), ny - 1)
    return j0, j1


@part
def _find_enclosing_triangle(  # type: ignore[no-untyped-def]
    points, starts, nx, ny, grid_left, top, cell_size, x, y, half_width, triangle
):
    """Find three points of a square around a position, and return whether they enclose it.

    The first is the point nearest to the position. The other two are the points on either side of
    the line to it that have the largest angles from it, as seen from the position.
    """
    j0, j1 = _rows(ny, y - half_width, y + half_width, top, cell_size)
    nearest_square, a = math.inf, -1
    for j in range(j0, j1 + 1):
        s, e = _row(starts, nx, j, x - half_width, x + half_width, grid_left, cell_size)
        for p in range(s, e):
            d = (points[p, 0] - x) ** 2 + (points[p, 1] - y) ** 2
            if d < nearest_square:
                nearest_square, a = d, p
    if a < 0:
        return False
    ax, ay = points[a, 0] - x, points[a, 1] - y
    b, c = -1, -1
    bx = by = cx = cy = 0.0
    for j in range(j0, j1 + 1):
        s, e = _row(starts, nx, j, x - half_width, x + half_width, grid_left, cell_size)
        for p in range(s, e):
            if p == a:
                continue
            px, py = points[p, 0] - x, points[p, 1] - y
            if ax * py - ay * px >= 0.0:
                if b < 0 or bx * py - by * px > 0.0:
                    b, bx, by = p, px, py
            elif c < 0 or cx * py - cy * px < 0.0:
                c, cx, cy = p, px, py
    triangle[0], triangle[1], triangle[2] = a, b, c
    return b >= 0 and c >= 0 and bx * cy - by * cx > 0.0


@part
def _barycentric_coordinates(points, a, b, c, x, y):  # type: ignore[no-untyped-def]
    """Return the barycentric coordinates of a position; -inf if the points are collinear."""
    ax, ay = points[a, 0] - x, points[a, 1] - y
    bx, by = points[b, 0] - x, points[b, 1] - y
    cx, cy = points[c, 0] - x, points[c, 1] - y
    u, v, w = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
    weight_sum = u + v + w
    if weight_sum == 0.0:
        return -math.inf, -math.inf, -math.inf
    return u / weight_sum, v / weight_sum, w / weight_sum


@part
def _lifted_plane(points, triangle, x, y):  # type: ignore[no-untyped-def]
    """Return the slopes of the plane through lifted points, and its height at a position.

    All are NaN if the points are collinear.
    """
    ax, ay = points[triangle[0], 0] - x, points[triangle[0], 1] - y
    bx, by = points[triangle[1], 0] - x, points[triangle[1], 1] - y
    cx, cy = points[triangle[2], 0] - x, points[triangle[2], 1] - y
    h = ax * ax + ay * ay
    ux, uy, uh = bx - ax, by - ay, bx * bx + by * by - h
    vx, vy, vh = cx - ax, cy - ay, cx * cx + cy * cy - h
    area = ux * vy - uy * vx
    if area == 0.0:
        return math.nan, math.nan, math.nan
    f, g = (uh * vy - uy * vh) / area, (ux * vh - uh * vx) / area
    return f, g, h - f * ax - g * ay


@part
def _find_deepest_point(  # type: ignore[no-untyped-def]
    points, starts, nx, ny, grid_left, top, cell_size, x, y, f, g, h, half_width
):
    """Return the index of the point deepest inside the circle of a lifted plane.

    Only points in the square around the position are tested. Returns -1 if none is inside.
    """
    mx, my = f / 2, g / 2
    radius = math.sqrt(max(h + mx * mx + my * my, 0.0))
    low_y, high_y = max(my - radius, -half_width), min(my + radius, half_width)
    deepest_point, greatest_depth = -1, -CIRCLE_TOLERANCE * cell_size * cell_size
    if low_y > high_y:
        return deepest_point
    j0, j1 = _rows(ny, y + low_y, y + high_y, top, cell_size)
    low_x, high_x = max(mx - radius, -half_width), min(mx + radius, half_width)
    if low_x > high_x:
        return deepest_point
    for j in range(j0, j1 + 1):
        s, e = _row(starts, nx, j, x + low_x, x + high_x, grid_left, cell_size)
        for p in range(s, e):
            px, py = points[p, 0] - x, points[p, 1] - y
            power = px * px + py * py - f * px - g * py - h
            if power < greatest_depth:
                deepest_point, greatest_depth = p, power
    return deepest_point


@part
def _replace_point(points, triangle, new, x, y):  # type: ignore[no-untyped-def]
    """Replace one of three points by a new one so that they still enclose the position."""
    best_score, replaced_corner = -math.inf, 0
    for k in range(3):
        a = new if k == 0 else triangle[0]
        b = new if k == 1 else triangle[1]
        c = new if k == 2 else triangle[2]
        u, v, w = _barycentric_coordinates(points, a, b, c, x, y)
        smallest_weight = min(u, v, w)
        if smallest_weight > best_score:
            best_score, replaced_corner = smallest_weight, k
    triangle[replaced_corner] = new


@part
def _has_long_edge(points, triangle, limit):  # type: ignore[no-untyped-def]
    for k in range(3):
        a, b = triangle[k], triangle[(k + 1) % 3]
        dx, dy = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1]
        if dx * dx + dy * dy > limit * limit:
            return True
    return False


@part
def _flip_to_delaunay(points, starts, nx, ny, grid_left, top, cell_size, x, y, limit, triangle):  # type: ignore[no-untyped-def]
    """Turn an enclosing triangle into the Delaunay triangle; return whether it is usable.

    It is not usable if a side exceeds the limit or if the search fails.
    """
    for _ in range(MAX_FLIPS):
        f, g, h = _lifted_plane(points, triangle, x, y)
        if math.isnan(f):
            return False
        new = _find_deepest_point(
            points, starts, nx, ny, grid_left, top, cell_size, x, y, f, g, h, limit
        )
        if new < 0:
            if _has_long_edge(points, triangle, limit):
                return False
            # A point farther away would become a corner that is farther than the maximum side
            # length.
            deepest_point = _find_deepest_point(
                points, starts, nx, ny, grid_left, top, cell_size, x, y, f, g, h, math.inf
            )
            return deepest_point < 0
        _replace_point(points, triangle, new, x, y)
    return False


@kernel("void(f8[:,::1], i8[::1], i8, i8, f8, f8, f8, f8, f8, f8, f8, i8[::1], f8[:,::1])")
def interpolate(  # type: ignore[no-untyped-def]
    points,
    starts,
    nx,
    ny,
    grid_left,
    top,
    cell_size,
    first_x,
    first_y,
    step,
    limit,
    triangle,
    depth,
):
    """Interpolate depths at cell centres in Delaunay triangles of points.

    Parameters
    ----------
    points : (n, 3) array
        Points at distinct positions, sorted by bucket.
    starts : (nx ny + 1,) array
        Index of the first point of each bucket, followed by n.
    nx, ny, grid_left, top, cell_size
        Grid of buckets: ny rows of nx squares.
    first_x, first_y, step
        Centre of the first cell, and cell spacing.
    limit : float
        Maximum length of a side.
    triangle : (3,) int array
        Work array.
    depth : (h, w) array
        Output array; NaN outside the triangles and where a side exceeds the limit.
    """
    h, w = depth.shape
    offset_x, offset_y = POSITION_OFFSET * cell_size, 0.618 * POSITION_OFFSET * cell_size
    for row in range(h):
        y = first_y + row * step + offset_y
        is_enclosed = False
        for column in range(w):
            x = first_x + column * step + offset_x
            if is_enclosed:
                u, v, q = _barycentric_coordinates(
                    points, triangle[0], triangle[1], triangle[2], x, y
                )
                is_enclosed = min(u, v, q) >= 0.0
            half_width = cell_size
            while not is_enclosed and half_width < 2.0 * limit:
                is_enclosed = _find_enclosing_triangle(
                    points,
                    starts,
                    nx,
                    ny,
                    grid_left,
                    top,
                    cell_size,
                    x,
                    y,
                    min(half_width, limit),
                    triangle,
                )
                half_width *= 2.0
            is_enclosed = is_enclosed and _flip_to_delaunay(
                points, starts, nx, ny, grid_left, top, cell_size, x, y, limit, triangle
            )
            if not is_enclosed:
                depth[row, column] = math.nan
                continue
            u, v, q = _barycentric_coordinates(points, triangle[0], triangle[1], triangle[2], x, y)
            depth[row, column] = (
                u * points[triangle[0], 2] + v * points[triangle[1], 2] + q * points[triangle[2], 2]
            )
