"""Surface of a cloud over a plane: a Delaunay triangulation of its uppermost points.

Coordinates are those of a view against the upward normal of the plane: x and y are in the plane,
and z points into it, so that the uppermost point has the smallest z.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IndexArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.products.ortho.tiles import Grid, Tile

MAX_SIDE_SPACINGS = 5.0
"""Maximum side of a triangle, in typical side lengths.

Between random points, the longest sides are about four times the typical length; longer ones bridge
a hole."""

N_NEIGHBOURS = 16
MIN_GAP_SPREADS = 2.0
"""Minimum gap between sheets, relative to the spread of the neighbours of a point."""

MIN_SEPARATED_SHARE = 0.85
"""Minimum share of correctly ordered pairs for a line to separate upper from other points."""
MIN_POINTS_ABOVE = 3
"""Minimum number of points above a point; fewer are considered outliers."""
MAX_POINTS_BELOW = 3
PASS_COUNT = 4
"""Number of passes; remnants of a lower sheet become isolated in the next pass."""

BUCKET_SPACINGS = 1.5
"""Side of the squares into which points are sorted, in mean point distances."""
MAX_HULL_POINTS = 200_000
"""Maximum number of points used for the approximate outline of a cloud."""

_BLOCK_POINTS = 100_000


def default_side_limit(xy: FloatArray) -> float:
    """Return the default maximum triangle side, in the unit of the points.

    It is `MAX_SIDE_SPACINGS` times the square root of the area per point.

    Parameters
    ----------
    xy : (n, 2) array

    Raises
    ------
    InputError
        If there are fewer than three distinct positions.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        sample = xy[:: -(-len(xy) // MAX_HULL_POINTS)]
        hull = ConvexHull(sample - sample.mean(axis=0))
    except (QhullError, ValueError) as error:
        raise _collinear_points_error() from error
    # Use the area of the cells that the cloud covers instead of its hull, since it may have any
    # outline.
    low, n = xy.min(axis=0), len(xy)
    cell_size = max(np.sqrt(4.0 * hull.volume / n), 1e-300)
    for _ in range(8):
        cells = np.floor((xy - low) / cell_size).astype(np.int64)
        key = cells[:, 1] * (cells[:, 0].max() + 1) + cells[:, 0]
        occupied_cells = _count_cells(key)
        points_per_cell = n / occupied_cells
        # At about four points per cell, few cells within the outline are empty.
        if 3.0 <= points_per_cell <= 8.0:
            break
        cell_size *= np.sqrt(np.clip(4.0 / points_per_cell, 0.1, 4.0))
    return float(MAX_SIDE_SPACINGS * cell_size / np.sqrt(points_per_cell))


def _count_cells(key: IntArray) -> int:
    """Count the distinct cells, given the cell (n,) of each point."""
    count = int(key.max()) + 1
    if count > 40 * len(key):
        return len(np.unique(key))
    is_occupied = np.zeros(count, bool)
    is_occupied[key] = True
    return int(np.count_nonzero(is_occupied))


def extract_top_sheet(points: FloatArray) -> FloatArray:
    """Remove points (n, 3) that lie below another sheet, e.g. under an overhang.

    A point is below another sheet if some of its neighbours in the plane lie above it, beyond a gap
    of `MIN_GAP_SPREADS` times the extent of the neighbourhood, and if these are mixed with the
    other neighbours or surround the point. (On a slope, a line separates the two groups.) If points
    coincide in the plane, the uppermost remains.
    """
    order = np.lexsort((points[:, 2], points[:, 1], points[:, 0]))
    ordered_points = points[order]
    is_first = np.ones(len(ordered_points), bool)
    is_first[1:] = (np.diff(ordered_points[:, :2], axis=0) != 0).any(axis=1)
    unique_points = np.ascontiguousarray(ordered_points[is_first])
    is_candidate = np.ones(len(unique_points), bool)
    for _ in range(PASS_COUNT):
        if len(unique_points) <= N_NEIGHBOURS or not is_candidate.any():
            break
        is_hidden, needs_retest = _find_hidden_points(unique_points, np.flatnonzero(is_candidate))
        unique_points, is_candidate = unique_points[~is_hidden], needs_retest[~is_hidden]
    return unique_points


def _find_hidden_points(
    points: FloatArray, candidate_rows: IndexArray
) -> tuple[BoolArray, BoolArray]:
    """Return masks (n,) of points below another sheet, and of points to be tested again.

    Points to be tested again have a gap above them or are neighbours of hidden points.
    """
    from scipy.spatial import cKDTree

    is_under, needs_retest = np.zeros(len(points), bool), np.zeros(len(points), bool)
    tree = cKDTree(points[:, :2])
    for start in range(0, len(candidate_rows), _BLOCK_POINTS):
        rows = candidate_rows[start : start + _BLOCK_POINTS]
        distances, neighbours = tree.query(points[rows, :2], k=N_NEIGHBOURS, workers=-1)
        heights_above = np.sort(
            np.maximum(points[rows, None, 2] - points[neighbours, 2], 0.0), axis=1
        )
        gaps = np.diff(heights_above, axis=1, prepend=0.0)
        is_wide_gap = gaps > MIN_GAP_SPREADS * np.maximum(distances[:, -1:], 1e-300)
        rows_with_gap = np.flatnonzero(is_wide_gap.any(axis=1))
        if not len(rows_with_gap):
            continue
        offsets = points[neighbours[rows_with_gap]] - points[rows[rows_with_gap], None]
        level = heights_above[rows_with_gap, is_wide_gap[rows_with_gap].argmax(axis=1)]
        is_covered = _is_covered(offsets[:, :, :2], (0.0 - offsets[:, :, 2]) >= level[:, None])
        needs_retest[rows[rows_with_gap]] = True
        needs_retest[neighbours[rows_with_gap[is_covered]]] = True
        is_under[rows[rows_with_gap[is_covered]]] = True
    return is_under, needs_retest & bool(is_under.any())


def _is_covered(offsets: FloatArray, is_above: BoolArray) -> BoolArray:
    """Return whether the neighbours above a point cover it.

    Parameters
    ----------
    offsets : (n, k, 2) array
        Neighbours relative to the point, including the point itself.
    is_above : (n, k) bool array
        Whether each neighbour is above the point.

    Returns
    -------
    (n,) bool array
    """
    counts = is_above.sum(axis=1)
    is_upper, is_lower = is_above[:, :, None], ~is_above[:, :, None]
    upper_centre = (offsets * is_upper).sum(axis=1) / counts[:, None]
    lower_centre = (offsets * is_lower).sum(axis=1) / (is_above.shape[1] - counts)[:, None]
    # Fisher's linear discriminant gives the direction of best separation.
    deviations = offsets - np.where(is_upper, upper_centre[:, None], lower_centre[:, None])
    scatter = np.einsum("nki,nkj->nij", deviations, deviations)
    scale = np.maximum(np.trace(scatter, axis1=1, axis2=2), 1e-300)
    scatter += 1e-6 * scale[:, None, None] * np.eye(2)
    direction = np.linalg.solve(scatter, (upper_centre - lower_centre)[:, :, None])[:, :, 0]
    projections = np.einsum("nki,ni->nk", offsets, direction)
    pairs = is_above[:, :, None] & ~is_above[:, None, :]
    is_ordered = (projections[:, :, None] > projections[:, None, :]) & pairs
    separated_share = is_ordered.sum(axis=(1, 2)) / pairs.sum(axis=(1, 2))
    # Near the edge of an upper sheet, the sheet is on one side, and the lower points are on the
    # other.
    is_outward = np.einsum("nki,ni->nk", offsets, upper_centre) < 0
    is_inside = (is_outward & is_above).any(axis=1) | ~(is_outward & ~is_above).any(axis=1)
    is_mixed = (counts >= MIN_POINTS_ABOVE) & (separated_share < MIN_SEPARATED_SHARE) & is_inside
    # An isolated point of the lower sheet has points above on all sides.
    is_right, is_below = offsets[:, :, 0] >= 0, offsets[:, :, 1] >= 0
    sides = np.zeros(len(offsets), np.int64)
    for quarter in (
        is_right & is_below,
        is_right & ~is_below,
        ~is_right & is_below,
        ~is_right & ~is_below,
    ):
        sides += (quarter & is_above).any(axis=1)
    is_surrounded = (is_above.shape[1] - counts <= MAX_POINTS_BELOW) & (sides >= 3)
    return np.asarray(is_mixed | is_surrounded)


def average_top_points(points: FloatArray, cell_size: float) -> FloatArray:
    """Average, in each square, the points close to the uppermost one.

    They are at most `MIN_GAP_SPREADS` times the side of the square below it.
    """
    cells = np.floor((points[:, :2] - points[:, :2].min(axis=0)) / cell_size).astype(np.int64)
    key = cells[:, 1] * (cells[:, 0].max() + 1) + cells[:, 0]
    order = np.lexsort((points[:, 2], key))
    ordered_points, key = points[order], key[order]
    starts = np.flatnonzero(np.concatenate([[True], np.diff(key) != 0]))
    top = np.repeat(ordered_points[starts, 2], np.diff(np.append(starts, len(key))))
    is_upper = ordered_points[:, 2] <= top + MIN_GAP_SPREADS * cell_size
    counts = np.add.reduceat(is_upper.astype(np.float64), starts)
    sums = np.add.reduceat(ordered_points * is_upper[:, None], starts, axis=0)
    return np.ascontiguousarray(sums / counts[:, None])


def interpolate_tile(points: FloatArray, limit: float, grid: Grid, tile: Tile) -> FloatArray:
    """Interpolate depths (h, w) at the cell centres of a tile in Delaunay triangles.

    Parameters
    ----------
    points : (n, 3) array
        Points at distinct positions.
    limit : float
        Maximum side of a triangle; cells in larger triangles are NaN.
    grid : Grid
    tile : Tile
    """
    from vomstudio.products.elevation._triangle_kernels import interpolate

    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    size = np.maximum(high - low, 1e-12)
    cell_size = max(BUCKET_SPACINGS * float(np.sqrt(size.prod() / len(points))), 1e-9)
    # For a cloud that is almost a line, limit the number of buckets to that of the points.
    cell_size = max(cell_size, float(size.max()) / len(points))
    nx, ny = (int(n) + 1 for n in (size / cell_size).tolist())
    cells = np.minimum(
        np.floor((points[:, :2] - low) / cell_size).astype(np.int64), (nx - 1, ny - 1)
    )
    key = cells[:, 1] * nx + cells[:, 0]
    order = np.argsort(key, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(key, minlength=nx * ny))])
    gsd = grid.gsd
    depth = np.empty((tile.height, tile.width))
    interpolate(
        np.ascontiguousarray(points[order]),
        starts.astype(np.int64),
        nx,
        ny,
        float(low[0]),
        float(low[1]),
        cell_size,
        grid.left + (tile.column + 0.5) * gsd,
        grid.top + (tile.row + 0.5) * gsd,
        gsd,
        limit,
        np.zeros(3, np.int64),
        depth,
    )
    return depth


def _collinear_points_error() -> InputError:
    return InputError(Finding("dem.points-in-line"))
