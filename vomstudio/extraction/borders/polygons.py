"""The border of a facet in its plane: a polygon with holes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.extraction.borders.kernels import flattened, into_cells, rolled_around, thin_out
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.jit import for_kernels

_CHANCE_GAPS = 0.1
"""As many gaps of a random facet may be taken for holes or bays by chance."""
# Of more points only gaps beside empty cells are some: in cells of so many spacings that hardly one
# is empty by chance.
_FEW_POINTS = 4_000
_CELL = 2.5
_MOST_CELLS = 4_000_000
_LONGEST_TEXT = 100_000
_SECTOR_SQUARES = 32
# Of cells with more points one of each square is enough.
_CROWDED, _SQUARES = 64, 8
# Of a side: the gap between the pieces of a facet is up to twice as wide.
_CLOSED = 0.8


def axes_in(normal: FloatArray) -> FloatArray:
    """Two axes (2, 3) in a plane."""
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)])


def polygon_of_faces(
    corners: FloatArray, centre: FloatArray, normal: FloatArray
) -> tuple[Any, FloatArray]:
    """Of faces (k, 3, 3): what their free edges go around, as a shapely geometry in the plane's
    coordinates, and these axes (2, 3)."""
    nodes = welded(corners.reshape(-1, 3)).reshape(-1, 3)
    ends = np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=2).reshape(-1, 2)
    axes = axes_in(normal)
    flat = ((corners.reshape(-1, 3) - centre) @ axes.T).reshape(-1, 3, 2)
    lines = np.stack([flat, np.roll(flat, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    pieces = _pieces(nodes)
    if not pieces.any():
        return _around(lines[_free(ends)]), axes
    side = float(np.median(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)))
    return _closed(lines, ends, np.repeat(pieces, 3), _CLOSED * side), axes


def _pieces(nodes: IntArray) -> IntArray:
    """(k,) which piece that hangs together each face (k, 3) is of."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = int(nodes.max()) + 1
    one, two = nodes[:, [0, 1]].ravel(), nodes[:, [1, 2]].ravel()
    graph = coo_matrix((np.ones(len(one), np.int8), (one, two)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1][nodes[:, 0]], np.int64)


def _closed(lines: FloatArray, ends: IntArray, pieces: IntArray, width: float) -> Any:
    """What the pieces' free edges go around, which may overlap, with the gaps between them that are
    narrower than twice the width."""
    import shapely

    parts = []
    for own in np.split(np.argsort(pieces, kind="stable"), np.cumsum(np.bincount(pieces))[:-1]):
        parts.append(_around(lines[own[_free(ends[own])]]))
    whole = shapely.union_all(parts)
    wider = shapely.buffer(whole, width, join_style="mitre")
    return shapely.union(whole, shapely.buffer(wider, -width, join_style="mitre"))


def polygon_of_points(
    points: FloatArray, spacing: float, centre: FloatArray, normal: FloatArray
) -> tuple[Any, FloatArray]:
    """The same of points (k, 3) with that mean spacing: what their alpha shape goes around
    (Edelsbrunner, Kirkpatrick & Seidel 1983), which leaves out what a disc without points can reach
    that is larger than chance makes gaps."""
    axes = axes_in(normal)
    flat, ends = np.empty((len(points), 2)), np.zeros((2, 2))
    flattened(for_kernels(points, np.float64), axes, for_kernels(centre, np.float64), flat, ends)
    radius = _gap_radius(len(points)) * spacing
    lines = _lines_of(flat, ends, spacing, radius)
    return _around(_lines_by_triangles(flat, radius) if lines is None else lines), axes


def _lines_of(
    flat: FloatArray, ends: FloatArray, spacing: float, radius: float
) -> FloatArray | None:
    """Of the border: its lines (k, 2, 2), from a disc that rolls around the points. None where that
    does not close, as where rounding decides whether four points are on one circle."""
    low, size = ends[0], ends[1] - ends[0]
    side = max(_CELL * spacing, float(np.sqrt(size[0] * size[1] / _MOST_CELLS)))
    if side <= 0.0 or not (size < 1e4 * side).all():
        return None
    n, reach = len(flat), int(2.0 * radius / side) + 1
    columns, rows = ((size / side).astype(np.int64) + 2 * reach + 4).tolist()
    grid = float(low[0]) - (reach + 1) * side, float(low[1]) - (reach + 1) * side, 1.0 / side
    begins, own = np.zeros(columns * rows + 1, np.int64), np.empty((n, 2))
    into_cells(flat, *grid, columns, begins, np.empty(n, np.int64), own)
    squares = np.zeros((_SQUARES, _SQUARES), np.bool_)
    own = own[: thin_out(own, begins, *grid, columns, _CROWDED, squares)]
    edges = np.empty((6 * len(own), 2), np.int32)
    count = rolled_around(
        own,
        *grid,
        columns,
        begins,
        reach,
        radius,
        n > _FEW_POINTS,
        _sectors(),
        np.zeros(len(own), np.bool_),
        *(np.empty(len(own), np.int32) for _ in range(2)),
        np.empty((len(own), 2)),
        edges,
    )
    if count < 0:
        return None
    pairs = edges[:count].astype(np.int64)
    pairs = pairs[_free(pairs)] if count else pairs
    if (np.bincount(pairs.ravel(), minlength=1) % 2).any():
        return None
    return np.asarray(own[pairs])


@cache
def _sectors() -> IntArray:
    """Where a neighbour lies, in squares over twice the radius to each side, and of 64 sectors of
    directions, as bits, those that it forbids a disc from anywhere in its square."""
    edge = np.linspace(-2.0, 2.0, _SECTOR_SQUARES + 1)
    corner = np.stack(np.meshgrid(edge, edge, indexing="ij"), axis=-1)
    turn = 2.0 * np.pi * np.arange(65) / 64.0
    middle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    held = np.linalg.norm(corner[:, :, None] - middle, axis=-1) < 1.0 - 1e-9
    held = held[:-1, :-1] & held[1:, :-1] & held[:-1, 1:] & held[1:, 1:]
    bits = (held[..., :-1] & held[..., 1:]).astype(np.uint64)
    return np.asarray((bits << np.arange(64, dtype=np.uint64)).sum(axis=-1).view(np.int64))


def _lines_by_triangles(flat: FloatArray, radius: float) -> FloatArray:
    """The same lines from a Delaunay triangulation: the free edges of the triangles whose circles
    have no larger radius."""
    from scipy.spatial import Delaunay, QhullError

    try:
        triangles = Delaunay(flat).simplices.astype(np.int64)
    except (QhullError, ValueError):
        return np.zeros((0, 2, 2))
    a, b, c = (flat[triangles[:, i]] for i in range(3))
    ab, bc, ca = (np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a)))
    cross = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        kept = triangles[ab * bc * ca / (2.0 * cross) <= radius]
    ends = np.stack([kept, np.roll(kept, -1, axis=1)], axis=2).reshape(-1, 2)
    return flat[ends[_free(ends)]] if len(kept) else np.zeros((0, 2, 2))


def _gap_radius(count: int) -> float:
    """In mean spacings: of the circles through three neighbours of so many random points hardly one
    is larger. Of them a share (1 + x) exp(-x) has more than the area x (Miles 1970, Mathematical
    Biosciences 6, 85), and they are twice as many as the points."""
    x = 10.0
    for _ in range(5):
        x = float(np.log(2.0 * max(count, 1) * (1.0 + x) / _CHANCE_GAPS))
    return float(np.sqrt(x / np.pi))


def wkt(polygon: Any, axes: FloatArray, centre: FloatArray, tolerance: float) -> str | None:
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


def _free(ends: IntArray) -> BoolArray:
    """Which of the edges (k, 2) belong to one face only; of those that more than two share, an odd
    one."""
    key = ends.min(axis=1) * (int(ends.max()) + 1) + ends.max(axis=1)
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    first = np.zeros(len(key), np.bool_)
    first[np.unique(which, return_index=True)[1]] = True
    return np.asarray((count[which] % 2 == 1) & first)


def _around(lines: FloatArray) -> Any:
    """What lines (k, 2, 2) go around, with holes; they may cross where the surface is folded."""
    import shapely

    if not len(lines):
        return shapely.Polygon()
    whole = shapely.multilinestrings(shapely.linestrings(lines))
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
