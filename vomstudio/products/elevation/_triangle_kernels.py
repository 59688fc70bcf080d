"""Compiled interpolation between points strewn in a plane, without their triangulation.

Of all triangles of points that enclose a place, Delaunay's is the one whose plane through the
points lifted to x^2 + y^2 is lowest there: a linear programme of three unknowns. It is solved for
each cell by the simplex method among the points near it, and the answer is that of a triangulation
of all points, since no point may be left inside the circle of the three.
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part

MOST_TURNS = 1000
NUDGE = 1e-6
"""Cells are asked so far off their centres, in sides of a bucket: on an edge between points that
lie in rows no triangle would enclose them."""
ROUNDING = 1e-9
"""A point counts as inside the circle by so much, in squares of the side of a bucket."""


@part
def _row(starts, nx, j, low, high, left, side):  # type: ignore[no-untyped-def]
    """First and last (not included) point of a row of buckets between two places."""
    i0 = min(max(math.floor((low - left) / side), 0), nx - 1)
    i1 = min(max(math.floor((high - left) / side), 0), nx - 1)
    return starts[j * nx + i0], starts[j * nx + i1 + 1]


@part
def _rows(ny, low, high, top, side):  # type: ignore[no-untyped-def]
    j0 = min(max(math.floor((low - top) / side), 0), ny - 1)
    j1 = min(max(math.floor((high - top) / side), 0), ny - 1)
    return j0, j1


@part
def _enclose(points, starts, nx, ny, left, top, side, x, y, reach, tri):  # type: ignore[no-untyped-def]
    """Whether three points in the square about a place enclose it; which: the nearest one, and
    those that are farthest round on either side of it."""
    j0, j1 = _rows(ny, y - reach, y + reach, top, side)
    nearest, a = math.inf, -1
    for j in range(j0, j1 + 1):
        s, e = _row(starts, nx, j, x - reach, x + reach, left, side)
        for p in range(s, e):
            d = (points[p, 0] - x) ** 2 + (points[p, 1] - y) ** 2
            if d < nearest:
                nearest, a = d, p
    if a < 0:
        return False
    ax, ay = points[a, 0] - x, points[a, 1] - y
    b, c = -1, -1
    bx = by = cx = cy = 0.0
    for j in range(j0, j1 + 1):
        s, e = _row(starts, nx, j, x - reach, x + reach, left, side)
        for p in range(s, e):
            if p == a:
                continue
            px, py = points[p, 0] - x, points[p, 1] - y
            if ax * py - ay * px >= 0.0:
                if b < 0 or bx * py - by * px > 0.0:
                    b, bx, by = p, px, py
            elif c < 0 or cx * py - cy * px < 0.0:
                c, cx, cy = p, px, py
    tri[0], tri[1], tri[2] = a, b, c
    return b >= 0 and c >= 0 and bx * cy - by * cx > 0.0


@part
def _shares(points, a, b, c, x, y):  # type: ignore[no-untyped-def]
    """Barycentric coordinates of a place; -inf where the three lie on a line."""
    ax, ay = points[a, 0] - x, points[a, 1] - y
    bx, by = points[b, 0] - x, points[b, 1] - y
    cx, cy = points[c, 0] - x, points[c, 1] - y
    u, v, w = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
    whole = u + v + w
    if whole == 0.0:
        return -math.inf, -math.inf, -math.inf
    return u / whole, v / whole, w / whole


@part
def _lifted(points, tri, x, y):  # type: ignore[no-untyped-def]
    """The plane through the three lifted points about a place: slopes and height there."""
    ax, ay = points[tri[0], 0] - x, points[tri[0], 1] - y
    bx, by = points[tri[1], 0] - x, points[tri[1], 1] - y
    cx, cy = points[tri[2], 0] - x, points[tri[2], 1] - y
    h = ax * ax + ay * ay
    ux, uy, uh = bx - ax, by - ay, bx * bx + by * by - h
    vx, vy, vh = cx - ax, cy - ay, cx * cx + cy * cy - h
    area = ux * vy - uy * vx
    if area == 0.0:
        return math.nan, math.nan, math.nan
    f, g = (uh * vy - uy * vh) / area, (ux * vh - uh * vx) / area
    return f, g, h - f * ax - g * ay


@part
def _inside(points, starts, nx, ny, left, top, side, x, y, f, g, h, reach):  # type: ignore[no-untyped-def]
    """The point that lies deepest inside the circle of a plane and within the square about a place,
    -1 for none."""
    mx, my = f / 2, g / 2
    radius = math.sqrt(max(h + mx * mx + my * my, 0.0))
    low_y, high_y = max(my - radius, -reach), min(my + radius, reach)
    found, deepest = -1, -ROUNDING * side * side
    if low_y > high_y:
        return found
    j0, j1 = _rows(ny, y + low_y, y + high_y, top, side)
    low_x, high_x = max(mx - radius, -reach), min(mx + radius, reach)
    if low_x > high_x:
        return found
    for j in range(j0, j1 + 1):
        s, e = _row(starts, nx, j, x + low_x, x + high_x, left, side)
        for p in range(s, e):
            px, py = points[p, 0] - x, points[p, 1] - y
            above = px * px + py * py - f * px - g * py - h
            if above < deepest:
                found, deepest = p, above
    return found


@part
def _enter(points, tri, new, x, y):  # type: ignore[no-untyped-def]
    """Put a point in place of the one of three without which they enclose the place still."""
    best, leaves = -math.inf, 0
    for k in range(3):
        a = new if k == 0 else tri[0]
        b = new if k == 1 else tri[1]
        c = new if k == 2 else tri[2]
        u, v, w = _shares(points, a, b, c, x, y)
        least = min(u, v, w)
        if least > best:
            best, leaves = least, k
    tri[leaves] = new


@part
def _too_long(points, tri, limit):  # type: ignore[no-untyped-def]
    for k in range(3):
        a, b = tri[k], tri[(k + 1) % 3]
        dx, dy = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1]
        if dx * dx + dy * dy > limit * limit:
            return True
    return False


@part
def _settle(points, starts, nx, ny, left, top, side, x, y, limit, tri):  # type: ignore[no-untyped-def]
    """Whether Delaunay's triangle about a place, into which an enclosing one is changed, has no
    side over the limit."""
    for _ in range(MOST_TURNS):
        f, g, h = _lifted(points, tri, x, y)
        if math.isnan(f):
            return False
        new = _inside(points, starts, nx, ny, left, top, side, x, y, f, g, h, limit)
        if new < 0:
            if _too_long(points, tri, limit):
                return False
            # A farther one would be a corner, and farther from here than a side may be long.
            far = _inside(points, starts, nx, ny, left, top, side, x, y, f, g, h, math.inf)
            return far < 0
        _enter(points, tri, new, x, y)
    return False


@kernel("void(f8[:,::1], i8[::1], i8, i8, f8, f8, f8, f8, f8, f8, f8, i8[::1], f8[:,::1])")
def interpolate(  # type: ignore[no-untyped-def]
    points, starts, nx, ny, left, top, side, first_x, first_y, step, limit, tri, depth
):
    """Heights between points by Delaunay's triangles, NaN where one has a side over the limit.

    points : (n, 3) sorted by buckets, ny rows of nx squares of this side from (left, top) on, no
        two at one place; starts : (nx ny + 1,) of each; first_x, first_y : the first cell's centre
    tri : (3,) room to work in; depth : (h, w)
    """
    h, w = depth.shape
    off_x, off_y = NUDGE * side, 0.618 * NUDGE * side
    for row in range(h):
        y = first_y + row * step + off_y
        held = False
        for column in range(w):
            x = first_x + column * step + off_x
            if held:
                u, v, q = _shares(points, tri[0], tri[1], tri[2], x, y)
                held = min(u, v, q) >= 0.0
            reach = side
            while not held and reach < 2.0 * limit:
                held = _enclose(
                    points, starts, nx, ny, left, top, side, x, y, min(reach, limit), tri
                )
                reach *= 2.0
            held = held and _settle(points, starts, nx, ny, left, top, side, x, y, limit, tri)
            if not held:
                depth[row, column] = math.nan
                continue
            u, v, q = _shares(points, tri[0], tri[1], tri[2], x, y)
            depth[row, column] = (
                u * points[tri[0], 2] + v * points[tri[1], 2] + q * points[tri[2], 2]
            )
