"""The surface that a cloud stands for, over a plane: triangles between its uppermost points
(Delaunay).

Coordinates are those of a view against the plane's upward normal: x and y in the plane, z into it,
so that the uppermost point has the smallest z.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IndexArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.products.ortho.tiles import Grid, Tile

SIDE_SPACINGS = 5.0
"""The longest side of a triangle, in typical sides: between points strewn at random the longest are
some four, and what is longer bridges a hole."""

NEIGHBOURS = 16
GAP_SPREADS = 2.0
"""A point that lies so many times the spread of its neighbours below them all around is of another
sheet."""

PARTED = 0.85
"""From this share of pairs in order on, a line parts those above from the others."""
FEWEST_ABOVE = 3
"""Fewer points above are strays."""
FEW_BELOW = 3
PASSES = 4
"""What is left of a lower sheet stands alone among an upper one when it is looked at again."""

BUCKET_SPACINGS = 1.5
"""Side of the squares into which points are sorted, in mean distances between them."""
HULL_POINTS = 200_000
"""More points than this tell no more of where a cloud roughly ends."""

_AT_ONCE = 100_000


def longest_side(xy: FloatArray) -> float:
    """The default limit: SIDE_SPACINGS times the square root of the area that a point has to
    itself. xy (n, 2). Raises InputError for fewer than three places."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        some = xy[:: -(-len(xy) // HULL_POINTS)]
        hull = ConvexHull(some - some.mean(axis=0))
    except (QhullError, ValueError) as error:
        raise _no_surface() from error
    # Of the cells that the cloud touches, not of its hull: it may have any outline.
    low, n = xy.min(axis=0), len(xy)
    side = max(np.sqrt(4.0 * hull.volume / n), 1e-300)
    for _ in range(8):
        cells = np.floor((xy - low) / side).astype(np.int64)
        key = cells[:, 1] * (cells[:, 0].max() + 1) + cells[:, 0]
        taken = _taken(key)
        per_cell = n / taken
        # With some four points in each cell few within the outline are empty.
        if 3.0 <= per_cell <= 8.0:
            break
        side *= np.sqrt(np.clip(4.0 / per_cell, 0.1, 4.0))
    return float(SIDE_SPACINGS * side / np.sqrt(per_cell))


def _taken(key: IntArray) -> int:
    """How many cells are touched. key : (n,) of the cell of each point"""
    count = int(key.max()) + 1
    if count > 40 * len(key):
        return len(np.unique(key))
    touched = np.zeros(count, bool)
    touched[key] = True
    return int(np.count_nonzero(touched))


def top_sheet(points: FloatArray) -> FloatArray:
    """Points without those over which another sheet lies, (n, 3) to (k, 3): an overhang and what is
    under it, of which the uppermost counts.

    Where among a point's neighbours in the plane some lie above it, with a gap between that is
    wider than GAP_SPREADS times the reach of the neighbourhood, it is under another sheet if those
    above and the others lie intermingled in the plane: on a slope a line parts them. Of points at
    one place the uppermost is taken.
    """
    order = np.lexsort((points[:, 2], points[:, 1], points[:, 0]))
    ordered = points[order]
    first = np.ones(len(ordered), bool)
    first[1:] = (np.diff(ordered[:, :2], axis=0) != 0).any(axis=1)
    unique = np.ascontiguousarray(ordered[first])
    asked = np.ones(len(unique), bool)
    for _ in range(PASSES):
        if len(unique) <= NEIGHBOURS or not asked.any():
            break
        under, doubtful = _under_another(unique, np.flatnonzero(asked))
        unique, asked = unique[~under], doubtful[~under]
    return unique


def _under_another(points: FloatArray, asked: IndexArray) -> tuple[BoolArray, BoolArray]:
    """(n,) which of the points `asked` are under another sheet, and which must be asked again:
    those with a gap above them and the neighbours of those that go; none where none go."""
    from scipy.spatial import cKDTree

    under, doubtful = np.zeros(len(points), bool), np.zeros(len(points), bool)
    tree = cKDTree(points[:, :2])
    for start in range(0, len(asked), _AT_ONCE):
        rows = asked[start : start + _AT_ONCE]
        reach, near = tree.query(points[rows, :2], k=NEIGHBOURS, workers=-1)
        above = np.sort(np.maximum(points[rows, None, 2] - points[near, 2], 0.0), axis=1)
        gaps = np.diff(above, axis=1, prepend=0.0)
        wide = gaps > GAP_SPREADS * np.maximum(reach[:, -1:], 1e-300)
        some = np.flatnonzero(wide.any(axis=1))
        if not len(some):
            continue
        away = points[near[some]] - points[rows[some], None]
        level = above[some, wide[some].argmax(axis=1)]
        covered = _covered(away[:, :, :2], (0.0 - away[:, :, 2]) >= level[:, None])
        doubtful[rows[some]] = True
        doubtful[near[some[covered]]] = True
        under[rows[some[covered]]] = True
    return under, doubtful & bool(under.any())


def _covered(away: FloatArray, over: BoolArray) -> BoolArray:
    """(n,) whether the neighbours above lie over the point. away : (n, k, 2) from the point, which
    is one of them; over : (n, k) those above."""
    counts = over.sum(axis=1)
    upper, lower = over[:, :, None], ~over[:, :, None]
    middle_up = (away * upper).sum(axis=1) / counts[:, None]
    middle_low = (away * lower).sum(axis=1) / (over.shape[1] - counts)[:, None]
    # Fisher's linear discriminant is the direction that parts them best.
    rest = away - np.where(upper, middle_up[:, None], middle_low[:, None])
    scatter = np.einsum("nki,nkj->nij", rest, rest)
    scale = np.maximum(np.trace(scatter, axis1=1, axis2=2), 1e-300)
    scatter += 1e-6 * scale[:, None, None] * np.eye(2)
    toward = np.linalg.solve(scatter, (middle_up - middle_low)[:, :, None])[:, :, 0]
    along = np.einsum("nki,ni->nk", away, toward)
    pairs = over[:, :, None] & ~over[:, None, :]
    right = (along[:, :, None] > along[:, None, :]) & pairs
    parted = right.sum(axis=(1, 2)) / pairs.sum(axis=(1, 2))
    # Beside the edge of an upper sheet, all of it lies on one side, and of the lower one more.
    outward = np.einsum("nki,ni->nk", away, middle_up) < 0
    inside = (outward & over).any(axis=1) | ~(outward & ~over).any(axis=1)
    mingled = (counts >= FEWEST_ABOVE) & (parted < PARTED) & inside
    # One that is left of the lower sheet has those above on all sides.
    right_of, below = away[:, :, 0] >= 0, away[:, :, 1] >= 0
    sides = np.zeros(len(away), np.int64)
    for quarter in (right_of & below, right_of & ~below, ~right_of & below, ~right_of & ~below):
        sides += (quarter & over).any(axis=1)
    alone = (over.shape[1] - counts <= FEW_BELOW) & (sides >= 3)
    return np.asarray(mingled | alone)


def thinned(points: FloatArray, side: float) -> FloatArray:
    """One point for each square of the plane: the mean of its uppermost ones, those no more than
    a few sides below the highest."""
    cells = np.floor((points[:, :2] - points[:, :2].min(axis=0)) / side).astype(np.int64)
    key = cells[:, 1] * (cells[:, 0].max() + 1) + cells[:, 0]
    order = np.lexsort((points[:, 2], key))
    ordered, key = points[order], key[order]
    starts = np.flatnonzero(np.concatenate([[True], np.diff(key) != 0]))
    top = np.repeat(ordered[starts, 2], np.diff(np.append(starts, len(key))))
    upper = ordered[:, 2] <= top + GAP_SPREADS * side
    counts = np.add.reduceat(upper.astype(np.float64), starts)
    sums = np.add.reduceat(ordered * upper[:, None], starts, axis=0)
    return np.ascontiguousarray(sums / counts[:, None])


def interpolated(points: FloatArray, limit: float, grid: Grid, tile: Tile) -> FloatArray:
    """(h, w) depths at the centres of a tile's cells, by the triangles of Delaunay between the
    points' places, NaN where such a triangle has a side longer than `limit`. points : (n, 3), no
    two at one place"""
    from vomstudio.products.elevation._triangle_kernels import interpolate

    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    size = np.maximum(high - low, 1e-12)
    side = max(BUCKET_SPACINGS * float(np.sqrt(size.prod() / len(points))), 1e-9)
    # A cloud that is all but a line has no more buckets than points.
    side = max(side, float(size.max()) / len(points))
    nx, ny = (int(n) + 1 for n in (size / side).tolist())
    cells = np.minimum(np.floor((points[:, :2] - low) / side).astype(np.int64), (nx - 1, ny - 1))
    key = cells[:, 1] * nx + cells[:, 0]
    order = np.argsort(key, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(key, minlength=nx * ny))])
    g = grid.gsd
    depth = np.empty((tile.height, tile.width))
    interpolate(
        np.ascontiguousarray(points[order]),
        starts.astype(np.int64),
        nx,
        ny,
        float(low[0]),
        float(low[1]),
        side,
        grid.left + (tile.column + 0.5) * g,
        grid.top + (tile.row + 0.5) * g,
        g,
        limit,
        np.zeros(3, np.int64),
        depth,
    )
    return depth


def _no_surface() -> InputError:
    return InputError(Finding("dem.points-in-line"))
