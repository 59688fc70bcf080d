"""The border of a facet in its plane: a polygon with holes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.coincident_points import welded

Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]

_CHANCE_GAPS = 0.1
"""As many gaps of a random facet may be taken for holes or bays by chance."""
_MOST_CORNERS = 20_000
# Of more points only those beside gaps are looked at: in cells of so many spacings that hardly one
# is empty by chance.
_FEW_POINTS = 4_000
_CELL = 2.5
_MOST_CELLS = 4_000_000
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
    beside, amid = _beside_gaps(flat, spacing)
    thinned, side = _thinned(beside, spacing)
    try:
        triangles = Delaunay(thinned).simplices.astype(np.int64)
    except (QhullError, ValueError):
        return shapely.Polygon(), axes
    a, b, c = (thinned[triangles[:, i]] for i in range(3))
    ab, bc, ca = (np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a)))
    cross = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = ab * bc * ca / (2.0 * cross)
    near = radius <= _gap_radius(len(points)) * max(spacing, side)
    kept = triangles[near | amid((a + b + c) / 3.0)]
    if not len(kept):
        return shapely.Polygon(), axes
    ends = np.stack([kept, np.roll(kept, -1, axis=1)], axis=2).reshape(-1, 2)
    return _around(thinned[ends[_free(ends)]]), axes


def _gap_radius(count: int) -> float:
    """In mean spacings: of the circles through three neighbours of so many random points hardly one
    is larger. Of them a share (1 + x) exp(-x) has more than the area x (Miles 1970, Mathematical
    Biosciences 6, 85), and they are twice as many as the points."""
    x = 10.0
    for _ in range(5):
        x = float(np.log(2.0 * max(count, 1) * (1.0 + x) / _CHANCE_GAPS))
    return float(np.sqrt(x / np.pi))


def _beside_gaps(flat: Array, spacing: float) -> tuple[Array, Callable[[Array], Bools]]:
    """Of many points those in cells beside an empty one and in the cells beside these, and whether
    places (k, 2) are in a cell amid full ones. All points where they are few."""
    low, size = flat.min(axis=0), np.ptp(flat, axis=0)
    side = max(_CELL * spacing, float(np.sqrt(size[0] * size[1] / _MOST_CELLS)))
    if len(flat) <= _FEW_POINTS or not (size < 1e4 * side).all() or side <= 0.0:
        return flat, lambda places: np.zeros(len(places), np.bool_)
    shape = (size / side).astype(np.int64) + 5

    def cells_of(places: Array) -> Ints:
        i, j = ((places - low) / side).astype(np.int64).T + 2
        return np.asarray(i * shape[1] + j)

    own = cells_of(flat)
    full = np.zeros(int(shape[0] * shape[1]), np.bool_)
    full[own] = True
    amid = _shrunk(full.reshape(shape))
    deep = _shrunk(amid).ravel()
    amid = amid.ravel()
    return flat[~deep[own]], lambda places: np.asarray(amid[cells_of(places)])


def _shrunk(full: Bools) -> Bools:
    """Cells of which all eight around are full as well."""
    for axis in (0, 1):
        full = full & np.roll(full, 1, axis) & np.roll(full, -1, axis)
    return full


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


def _free(ends: Ints) -> Bools:
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
