"""The border of a facet in its plane: a polygon with holes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.coincident_points import welded

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# A gap in the points wider than this many mean spacings is a hole or a bay of the facet: random
# points leave gaps of 3 spacings here and there (the largest empty circle).
_GAP = 3.5
_MOST_CORNERS = 20_000
_LONGEST_TEXT = 100_000


def in_plane(points: Array, centre: Array, normal: Array) -> tuple[Array, Array]:
    """Coordinates (k, 2) of points (k, 3) in a plane, and the two axes (2, 3) of it."""
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    axes = np.stack([u, np.cross(normal, u)])
    return (points - centre) @ axes.T, axes


def polygon_of_faces(corners: Array, centre: Array, normal: Array) -> tuple[Any, Array]:
    """Of faces (k, 3, 3): what their free edges go around, as a shapely geometry in the plane's
    coordinates, and these axes (2, 3)."""
    nodes = welded(corners.reshape(-1, 3)).reshape(-1, 3)
    ends = np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=2).reshape(-1, 2)
    flat, axes = in_plane(corners.reshape(-1, 3), centre, normal)
    flat = flat.reshape(-1, 3, 2)
    lines = np.stack([flat, np.roll(flat, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    return _around(lines[_free(ends)]), axes


def polygon_of_points(
    points: Array, spacing: float, centre: Array, normal: Array
) -> tuple[Any, Array]:
    """The same of points (k, 3) with that mean spacing: the union of the triangles of their
    Delaunay triangulation whose circles hold no gap (an alpha shape; Edelsbrunner, Kirkpatrick &
    Seidel 1983)."""
    import shapely
    from scipy.spatial import Delaunay, QhullError

    flat, axes = in_plane(points, centre, normal)
    thinned, side = _thinned(flat, spacing)
    try:
        triangles = Delaunay(thinned).simplices.astype(np.int64)
    except (QhullError, ValueError):
        return shapely.Polygon(), axes
    a, b, c = (thinned[triangles[:, i]] for i in range(3))
    ab, bc, ca = (np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a)))
    cross = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = ab * bc * ca / (2.0 * cross)
    kept = triangles[radius <= 0.5 * _GAP * max(spacing, side)]
    if not len(kept):
        return shapely.Polygon(), axes
    ends = np.stack([kept, np.roll(kept, -1, axis=1)], axis=2).reshape(-1, 2)
    return _around(thinned[ends[_free(ends)]]), axes


def wkt(polygon: Any, axes: Array, centre: Array, tolerance: float) -> str | None:
    """The polygon in World as WKT with z, thinned by the tolerance, and more where the text would
    be too long for a cell of a table. None where there is none."""
    import shapely

    if polygon.is_empty:
        return None
    text = ""
    for _ in range(12):
        thin = shapely.simplify(polygon, tolerance, preserve_topology=True)
        if not thin.is_empty:
            flat = shapely.get_coordinates(thin)
            world = shapely.set_coordinates(shapely.force_3d(thin), centre + flat @ axes)
            text = shapely.to_wkt(world, rounding_precision=4)
            if len(text) <= _LONGEST_TEXT:
                break
        tolerance *= 2.0
    return text or None


def _free(ends: Ints) -> npt.NDArray[np.bool_]:
    """Which of the edges (k, 2) belong to one face only; of those that more than two share, an odd
    one."""
    key = ends.min(axis=1) * (int(ends.max()) + 1) + ends.max(axis=1)
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    first = np.zeros(len(key), np.bool_)
    first[np.unique(which, return_index=True)[1]] = True
    return np.asarray((count[which] % 2 == 1) & first)


def _around(lines: Array) -> Any:
    """What lines (k, 2, 2) go around, with holes; they may cross where the surface is folded."""
    import shapely

    if not len(lines):
        return shapely.Polygon()
    whole = shapely.MultiLineString(list(lines))
    # Lines that cross each other, as those of a folded piece do, are cut there first.
    ways: tuple[Callable[[Any], Any], ...] = (lambda lines: lines, shapely.node, _on_grid)
    for prepared in ways:
        try:
            area = shapely.build_area(prepared(whole))
            area = area if area.is_valid else shapely.make_valid(area)
        except shapely.errors.GEOSException:
            continue
        if not area.is_empty:
            return area
    return shapely.Polygon()


def _on_grid(lines: Any) -> Any:
    """Lines with ends on a fine grid, on which all crossings are exact."""
    import shapely

    low_x, low_y, high_x, high_y = lines.bounds
    return shapely.union_all(lines, grid_size=max(high_x - low_x, high_y - low_y) * 1e-6)


def _thinned(flat: Array, spacing: float) -> tuple[Array, float]:
    """At most some ten thousand points, one of each cell, and the spacing that is left."""
    if len(flat) <= _MOST_CORNERS:
        return flat, spacing
    side = spacing * float(np.sqrt(len(flat) / _MOST_CORNERS)) * 1.5
    cell = np.floor((flat - flat.min(axis=0)) / side).astype(np.int64)
    _, first = np.unique(cell[:, 0] * (int(cell[:, 1].max()) + 1) + cell[:, 1], return_index=True)
    return flat[first], side
