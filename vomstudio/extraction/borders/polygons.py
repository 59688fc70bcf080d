"""Boundary of a facet in its plane as a polygon with holes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.extraction.borders.kernels import (
    flatten_points,
    roll_disc,
    sort_into_cells,
    thin_cells,
)
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.kernels.jit import to_kernel_array

_EXPECTED_GAPS = 0.1
"""Expected number of random gaps in a facet that are mistaken for holes or bays."""
# With more points, only gaps beside empty cells are used. The cells are so large, relative to the
# spacing, that a cell is very unlikely to be empty by chance.
_MIN_POINTS_FOR_CELLS = 4_000
_CELL_SIZE_SPACINGS = 2.5
_MAX_CELLS = 4_000_000
_MAX_TEXT_LENGTH = 100_000
_SECTOR_TABLE_SIZE = 32
# In cells with more points than this, one point per square is sufficient.
_MAX_CELL_POINTS, _SQUARES_PER_CELL_SIDE = 64, 8
# Half the maximum gap between the pieces of a facet, in side lengths of a face.
_MAX_HALF_GAP_SIDES = 0.8


def plane_axes(normal: FloatArray) -> FloatArray:
    """Return two orthogonal unit vectors in the plane with a given normal.

    Parameters
    ----------
    normal : (3,) ndarray

    Returns
    -------
    (2, 3) ndarray
    """
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)])


def enclose_faces(
    corners: FloatArray, centre: FloatArray, normal: FloatArray
) -> tuple[Any, FloatArray]:
    """Build the polygon that is enclosed by the free edges of faces.

    Narrow gaps between separate pieces are closed.

    Parameters
    ----------
    corners : (k, 3, 3) array
    centre, normal : (3,) arrays
        Centre and normal of the plane.

    Returns
    -------
    polygon : shapely geometry
        Polygon in the coordinates of the plane.
    axes : (2, 3) array
        Axes of these coordinates.
    """
    nodes = weld_points(corners.reshape(-1, 3)).reshape(-1, 3)
    ends = np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=2).reshape(-1, 2)
    axes = plane_axes(normal)
    plane_corners = ((corners.reshape(-1, 3) - centre) @ axes.T).reshape(-1, 3, 2)
    lines = np.stack([plane_corners, np.roll(plane_corners, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    pieces = _label_components(nodes)
    if not pieces.any():
        return _polygonize(lines[_find_free_edges(ends)]), axes
    edge_length = float(np.median(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)))
    return _close_gaps(lines, ends, np.repeat(pieces, 3), _MAX_HALF_GAP_SIDES * edge_length), axes


def _label_components(nodes: IntArray) -> IntArray:
    """Return the connected component (k,) of each face (k, 3)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = int(nodes.max()) + 1
    first, second = nodes[:, [0, 1]].ravel(), nodes[:, [1, 2]].ravel()
    graph = coo_matrix((np.ones(len(first), np.int8), (first, second)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1][nodes[:, 0]], np.int64)


def _close_gaps(lines: FloatArray, ends: IntArray, pieces: IntArray, width: float) -> Any:
    """Enclose the free edges of all components and close gaps narrower than twice the width."""
    import shapely

    parts = []
    for rows in np.split(np.argsort(pieces, kind="stable"), np.cumsum(np.bincount(pieces))[:-1]):
        parts.append(_polygonize(lines[rows[_find_free_edges(ends[rows])]]))
    merged_polygon = shapely.union_all(parts)
    widened_polygon = shapely.buffer(merged_polygon, width, join_style="mitre")
    return shapely.union(
        merged_polygon, shapely.buffer(widened_polygon, -width, join_style="mitre")
    )


def enclose_points(
    points: FloatArray, spacing: float, centre: FloatArray, normal: FloatArray
) -> tuple[Any, FloatArray]:
    """Build the alpha shape of points (Edelsbrunner, Kirkpatrick & Seidel 1983).

    The boundary is traced by an empty disc that is larger than the gaps that occur by chance.

    Parameters
    ----------
    points : (k, 3) array
    spacing : float
        Mean spacing of the points.
    centre, normal : (3,) arrays
        Centre and normal of the plane.

    Returns
    -------
    polygon : shapely geometry
        Polygon in the coordinates of the plane.
    axes : (2, 3) array
        Axes of these coordinates.
    """
    axes = plane_axes(normal)
    plane_coordinates, ends = np.empty((len(points), 2)), np.zeros((2, 2))
    flatten_points(
        to_kernel_array(points, np.float64),
        axes,
        to_kernel_array(centre, np.float64),
        plane_coordinates,
        ends,
    )
    radius = _gap_radius(len(points)) * spacing
    lines = _trace_boundary_lines(plane_coordinates, ends, spacing, radius)
    return _polygonize(
        _triangulated_boundary_lines(plane_coordinates, radius) if lines is None else lines
    ), axes


def _trace_boundary_lines(
    plane_coordinates: FloatArray, ends: FloatArray, spacing: float, radius: float
) -> FloatArray | None:
    """Trace the boundary lines (k, 2, 2) with a disc that rolls around the points.

    Return None if the lines do not close, for example if rounding decides whether four points lie
    on a circle, or if a grid of cells cannot be built.
    """
    low, size = ends[0], ends[1] - ends[0]
    cell_size = max(_CELL_SIZE_SPACINGS * spacing, float(np.sqrt(size[0] * size[1] / _MAX_CELLS)))
    if cell_size <= 0.0 or not (size < 1e4 * cell_size).all():
        return None
    n, max_distance = len(plane_coordinates), int(2.0 * radius / cell_size) + 1
    columns, rows = ((size / cell_size).astype(np.int64) + 2 * max_distance + 4).tolist()
    grid = (
        float(low[0]) - (max_distance + 1) * cell_size,
        float(low[1]) - (max_distance + 1) * cell_size,
        1.0 / cell_size,
    )
    cell_starts, sorted_points = np.zeros(columns * rows + 1, np.int64), np.empty((n, 2))
    sort_into_cells(
        plane_coordinates, *grid, columns, cell_starts, np.empty(n, np.int64), sorted_points
    )
    squares = np.zeros((_SQUARES_PER_CELL_SIDE, _SQUARES_PER_CELL_SIDE), np.bool_)
    sorted_points = sorted_points[
        : thin_cells(sorted_points, cell_starts, *grid, columns, _MAX_CELL_POINTS, squares)
    ]
    edges = np.empty((6 * len(sorted_points), 2), np.int32)
    count = roll_disc(
        sorted_points,
        *grid,
        columns,
        cell_starts,
        max_distance,
        radius,
        n > _MIN_POINTS_FOR_CELLS,
        _tabulate_sectors(),
        np.zeros(len(sorted_points), np.bool_),
        *(np.empty(len(sorted_points), np.int32) for _ in range(2)),
        np.empty((len(sorted_points), 2)),
        edges,
    )
    if count < 0:
        return None
    pairs = edges[:count].astype(np.int64)
    pairs = pairs[_find_free_edges(pairs)] if count else pairs
    if (np.bincount(pairs.ravel(), minlength=1) % 2).any():
        return None
    return np.asarray(sorted_points[pairs])


@cache
def _tabulate_sectors() -> IntArray:
    """Tabulate the directions that a neighbour excludes, as bits for 64 sectors.

    The squares of the table cover twice the radius to each side of a point. A sector is set if a
    neighbour at any position within the square excludes it.
    """
    grid_lines = np.linspace(-2.0, 2.0, _SECTOR_TABLE_SIZE + 1)
    corners = np.stack(np.meshgrid(grid_lines, grid_lines, indexing="ij"), axis=-1)
    angles = 2.0 * np.pi * np.arange(65) / 64.0
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    is_forbidden = np.linalg.norm(corners[:, :, None] - directions, axis=-1) < 1.0 - 1e-9
    is_forbidden = (
        is_forbidden[:-1, :-1]
        & is_forbidden[1:, :-1]
        & is_forbidden[:-1, 1:]
        & is_forbidden[1:, 1:]
    )
    bits = (is_forbidden[..., :-1] & is_forbidden[..., 1:]).astype(np.uint64)
    return np.asarray((bits << np.arange(64, dtype=np.uint64)).sum(axis=-1).view(np.int64))


def _triangulated_boundary_lines(plane_coordinates: FloatArray, radius: float) -> FloatArray:
    """Derive the boundary lines (k, 2, 2) from a Delaunay triangulation.

    They are the free edges of the triangles whose circumcircle is not larger than the disc. There
    are no lines if the points cannot be triangulated.
    """
    from scipy.spatial import Delaunay, QhullError

    try:
        triangles = Delaunay(plane_coordinates).simplices.astype(np.int64)
    except (QhullError, ValueError):
        return np.zeros((0, 2, 2))
    a, b, c = (plane_coordinates[triangles[:, i]] for i in range(3))
    ab, bc, ca = (np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a)))
    doubled_areas = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        small_triangles = triangles[ab * bc * ca / (2.0 * doubled_areas) <= radius]
    ends = np.stack([small_triangles, np.roll(small_triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    return (
        plane_coordinates[ends[_find_free_edges(ends)]]
        if len(small_triangles)
        else np.zeros((0, 2, 2))
    )


def _gap_radius(count: int) -> float:
    """Return the radius, in mean spacings, of a disc larger than nearly all random gaps.

    A fraction (1 + x) exp(-x) of the circles through three random neighbours has an area larger
    than x times the mean area per point (Miles 1970, Mathematical Biosciences 6, 85). There are
    twice as many circles as points.
    """
    x = 10.0
    for _ in range(5):
        x = float(np.log(2.0 * max(count, 1) * (1.0 + x) / _EXPECTED_GAPS))
    return float(np.sqrt(x / np.pi))


def to_wkt(polygon: Any, axes: FloatArray, centre: FloatArray, tolerance: float) -> str | None:
    """Write a polygon as WKT with z coordinates in the World frame.

    Parameters
    ----------
    polygon : shapely geometry
        Polygon in the coordinates of the plane.
    axes : (2, 3) array
    centre : (3,) array
    tolerance : float
        Tolerance of the simplification, m; increased if the text is too long for a table cell.

    Returns
    -------
    str or None
        WKT text; None for an empty polygon.
    """
    import shapely

    if polygon.is_empty:
        return None
    text = ""
    for _ in range(12):
        simplified_polygon = shapely.simplify(polygon, tolerance, preserve_topology=True)
        if not simplified_polygon.is_empty:
            flat_coordinates = shapely.get_coordinates(simplified_polygon)
            world = shapely.set_coordinates(
                shapely.force_3d(simplified_polygon), centre + flat_coordinates @ axes
            )
            text = shapely.to_wkt(world, rounding_precision=4)
            if len(text) <= _MAX_TEXT_LENGTH:
                break
        tolerance *= 2.0
    return text or None


def _find_free_edges(ends: IntArray) -> BoolArray:
    """Find the edges (k, 2) that belong to an odd number of faces; mark each of them once."""
    key = ends.min(axis=1) * (int(ends.max()) + 1) + ends.max(axis=1)
    _, edge_indices, count = np.unique(key, return_inverse=True, return_counts=True)
    is_first = np.zeros(len(key), np.bool_)
    is_first[np.unique(edge_indices, return_index=True)[1]] = True
    return np.asarray((count[edge_indices] % 2 == 1) & is_first)


def _polygonize(lines: FloatArray) -> Any:
    """Polygonize lines (k, 2, 2), with holes; the lines of a folded surface may cross."""
    import shapely

    if not len(lines):
        return shapely.Polygon()
    multiline = shapely.multilinestrings(shapely.linestrings(lines))
    # Lines that cross, such as those of a folded piece, are first split at the crossings.
    preparations: tuple[Callable[[Any], Any], ...] = (
        lambda lines: lines,
        shapely.node,
        _snap_to_grid,
    )
    for prepare in preparations:
        try:
            area = shapely.build_area(prepare(multiline))
            area = area if area.is_valid else shapely.make_valid(area)
        except shapely.errors.GEOSException:
            continue
        if not area.is_empty:
            return area
    return shapely.Polygon()


def _snap_to_grid(lines: Any) -> Any:
    """Snap lines to a fine grid on which all crossings are exact."""
    import shapely

    low_x, low_y, high_x, high_y = lines.bounds
    return shapely.union_all(lines, grid_size=max(high_x - low_x, high_y - low_y) * 1e-6)
