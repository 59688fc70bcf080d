"""Moments of the points of a patch, which suffice to fit its plane without the model.

The points of a dense model are redundant, because neighbours share the roughness of the rock. The
means of equal cells of the patch reveal this. If the points are independent, the scatter of the
means follows from the number of points per cell. If the roughness is longer than the point spacing,
the means scatter more, and this scatter tilts the plane. In simulations (60 x 50 points, Gaussian
roughness), the 95 % region has a coverage of 98 % for white noise, 94 to 95 % for roughness whose
correlation decreases to 1/e within a tenth of the patch, 88 % for a sixth, and 50 % for a third.
Such long roughness is indistinguishable from a tilt, so the verdict on a patch also uses the
hyperbolic error.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray, FloatArray, GenericArray, IntArray
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.kernels.jit import to_kernel_array, to_read_only_array
from vomstudio.geometry.kernels.patch_cells import cell_sums, rotate_points, weighted_spread
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.plane_errors import SIGNIFICANCE, joint_quantile

Triple = tuple[float, float, float]

# Number of cells per side: 36 means have 33 degrees of freedom. Means over fewer points would add
# no information.
CELLS_PER_SIDE = 6
POINTS_PER_CELL = 4
TILT_SIGNIFICANCE, TILT_MARGIN, MIN_CELLS = 1e-4, 1.4, 9
MAX_TILT_POINTS = 40_000
MAX_SORTED_POINTS = 4_000
"""Maximum number of points that are sorted into cells; more points are assigned by bounds."""
N_BOUND_POINTS = 5_000
"""Approximate number of points used to compute the bounds."""


@dataclass(frozen=True)
class Moments:
    """Moments of n distinct points in an arbitrary frame.

    Attributes
    ----------
    mean : (3,) tuple
    scatter : (3, 3) tuple
        Sum of (x - mean)(x - mean)', in squared length units.
    n_effective : float
        Number of independent points that would give the same error of the plane.
    """

    n: int
    mean: Triple
    scatter: tuple[Triple, Triple, Triple]
    n_effective: float


def moments(
    points: npt.ArrayLike, weights: npt.ArrayLike | None = None, *, are_distinct: bool = False
) -> Moments:
    """Compute the moments of points.

    Parameters
    ----------
    points : (k, 3) array_like
        Points. Coincident points count once, with the sum of their weights.
    weights : (k,) array_like, optional
        Positive relative weights, such as the area of each point, which prevents the finer parts
        of a mesh from dominating.
    are_distinct : bool
        Whether all points are known to be distinct.

    Returns
    -------
    Moments
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    point_weights = np.ones(len(xyz)) if weights is None else np.asarray(weights, dtype=np.float64)
    if not len(xyz):
        zero_vector = (0.0, 0.0, 0.0)
        return Moments(0, zero_vector, (zero_vector, zero_vector, zero_vector), 0.0)
    weight, positions = point_weights, xyz
    if not are_distinct:
        position_ids = weld_points(xyz)
        weight = np.bincount(position_ids, point_weights).astype(np.float64)
        positions = np.empty((len(weight), 3))
        positions[position_ids] = xyz
    n = len(weight)
    if n > MAX_SORTED_POINTS:
        return _moments_of_many_points(to_read_only_array(positions, np.float64), weight)
    weight = weight * (n / weight.sum())
    origin = positions[0]
    local_points = positions - origin
    mean = (weight[:, None] * local_points).sum(axis=0) / n
    local_points = local_points - mean
    scatter = (weight[:, None] * local_points).T @ local_points
    r, v, u = (local_points @ np.linalg.eigh(scatter / n)[1]).T
    return Moments(
        n,
        _triple(origin + mean),
        (_triple(scatter[0]), _triple(scatter[1]), _triple(scatter[2])),
        _effective_count(u, v, r),
    )


def _moments_of_many_points(positions: FloatArray, weight: FloatArray) -> Moments:
    """Compute the moments of many points with few passes over the data."""
    n, centre, scatter = len(positions), positions[0].copy(), np.zeros((3, 3))
    if float(np.ptp(weight)) == 0.0:
        weight = np.ones(1)
    else:
        weight = to_kernel_array(weight * (n / weight.sum()), np.float64)
    weighted_spread(positions, weight, centre, scatter)
    axes = to_kernel_array(np.linalg.eigh(scatter / n)[1].T[::-1], np.float64)
    u, v, r = (np.empty(n) for _ in range(3))
    rotate_points(positions, centre, axes, u, v, r)
    return Moments(
        n,
        _triple(centre),
        (_triple(scatter[0]), _triple(scatter[1]), _triple(scatter[2])),
        _effective_count(u, v, r),
    )


def _effective_count(u: FloatArray, v: FloatArray, r: FloatArray) -> float:
    """Return the effective number of points from the scatter of the means of equal cells.

    `u`, `v` and `r` (n,) are coordinates along the principal axes, longest axis first.
    """
    n = len(u)
    cells_per_side = min(2 * CELLS_PER_SIDE, 2 * int(np.sqrt(n / POINTS_PER_CELL) / 2))
    if cells_per_side < 6:
        return float(n)
    white_variance = float((r * r).mean()) * n / (n - 3.0)
    if white_variance <= 0.0:
        return float(n)
    # Richardson extrapolation: the scatter of the means misses correlated neighbours on the other
    # side of a cell border. Small cells miss more, so sqrt(excess) increases with the cell width.
    fine_root, coarse_root = (
        np.sqrt(x / white_variance) for x in _excess_variances(u, v, r, cells_per_side)
    )
    variance_ratio = max(float(2.0 * coarse_root - fine_root), 1.0) ** 2
    degrees_of_freedom = cells_per_side * cells_per_side / 4.0 - 3.0
    # q is 2 F / dof times the variance of one independent point over l3, as in plane_errors.
    q = (
        float(joint_quantile(np.array([degrees_of_freedom]))[0])
        * degrees_of_freedom
        * variance_ratio
        / n
    )
    # The scatter of the means does not reveal steps or a partial layer, in which the pieces of the
    # patch share an attitude that differs from that of the whole.
    sample = slice(None, None, max(1, n // MAX_TILT_POINTS))
    q = max(
        q, _tilt_variance(u[sample], v[sample], r[sample], cells_per_side // 2) / white_variance
    )
    return float(min(3.0 - 2.0 * np.log(SIGNIFICANCE) / np.log1p(q), n))


def _excess_variances(
    u: FloatArray, v: FloatArray, r: FloatArray, cells_per_side: int
) -> tuple[float, float]:
    """Return the variance per independent point, estimated from the means of cells.

    The first value is computed from `cells_per_side` cells along each axis, the second from cells
    that are twice as wide.
    """
    if len(u) > MAX_SORTED_POINTS:
        count, sums = _sum_cells(u, v, u, v, r, cells_per_side)
        block_shape = (cells_per_side // 2, 2, cells_per_side // 2, 2)
        coarse_counts, heights = (
            x.reshape(block_shape).sum(axis=(1, 3)).ravel() for x in (count, sums[:, 2])
        )
        return _excess_variance(count, sums[:, 2]), _excess_variance(coarse_counts, heights)
    fine_cells, coarse_cells = (equal_cells(u, v, k) for k in (cells_per_side, cells_per_side // 2))
    fine_excess, coarse_excess = (
        _excess_variance(np.bincount(c), np.bincount(c, r)) for c in (fine_cells, coarse_cells)
    )
    return fine_excess, coarse_excess


def _excess_variance(count: GenericArray, sums: GenericArray) -> float:
    cell_sums = np.asarray(sums, np.float64)
    cell_counts = np.maximum(np.asarray(count, np.float64), 1.0)
    return float((cell_sums * cell_sums / cell_counts).sum()) / (len(cell_sums) - 3.0)


def _tilt_variance(u: FloatArray, v: FloatArray, r: FloatArray, cells_per_side: int) -> float:
    """Return the variance that would tilt the plane to the median attitude of its cells.

    The variance is 0 if the attitudes of the cells do not differ significantly from the plane.
    """
    from scipy.stats import f

    # Round positions so that the points of a lattice row fall into one cell regardless of the tilt.
    rows, columns = (np.round(x / max(1e-3 * float(x.std()), 1e-300)) for x in (u, v))
    aa, ab, bb, ah, bh = _products(rows, columns, u, v, r, cells_per_side)
    area = aa * bb - ab * ab
    is_valid = area > 1e-6 * aa * bb
    slopes = np.stack([bb * ah - ab * bh, aa * bh - ab * ah])[:, is_valid] / area[is_valid]
    cells = slopes.shape[1]
    if cells < MIN_CELLS:
        return 0.0
    median_slopes = np.median(slopes, axis=1)
    # Standard error of the median of normal deviates, estimated from their median deviation.
    deviation = np.median(np.abs(slopes - median_slopes[:, None]), axis=1)
    error = 1.2533 * 1.4826 * deviation / np.sqrt(cells)
    quantile = 2.0 * float(f.ppf(1.0 - TILT_SIGNIFICANCE, 2, cells - 2))
    if (
        float((median_slopes**2).sum()) == 0.0
        or (median_slopes**2 <= error**2 * quantile / 2.0).all()
    ):
        return 0.0
    mean_squares = np.array([(u * u).mean(), (v * v).mean()])
    return float(TILT_MARGIN**2 * (median_slopes**2 @ mean_squares))


def _products(
    rows: FloatArray,
    columns: FloatArray,
    u: FloatArray,
    v: FloatArray,
    r: FloatArray,
    cells_per_side: int,
) -> tuple[FloatArray, ...]:
    """Return the sums of uu, uv, vv, ur and vr about the mean of each cell."""
    if len(u) > MAX_SORTED_POINTS:
        count, sums = _sum_cells(rows, columns, u, v, r, cells_per_side)
        a, b, h = (sums[:, :3] / np.maximum(count, 1)[:, None]).T
        mean_products = a * a, a * b, b * b, a * h, b * h
        return tuple(np.asarray(sums[:, 3 + i] - count * x) for i, x in enumerate(mean_products))
    cell = equal_cells(rows, columns, cells_per_side)
    count = np.maximum(np.bincount(cell), 1)
    a, b, h = (x - (np.bincount(cell, x) / count)[cell] for x in (u, v, r))
    products = a * a, a * b, b * b, a * h, b * h
    return tuple(np.asarray(np.bincount(cell, x), np.float64) for x in products)


def _sum_cells(
    rows: FloatArray,
    columns: FloatArray,
    u: FloatArray,
    v: FloatArray,
    r: FloatArray,
    cells_per_side: int,
) -> tuple[IntArray, FloatArray]:
    """Return the counts and sums of square blocks of cells; see `cell_sums`.

    There are `cells_per_side` cells along each axis, with nearly equal numbers of points.
    """
    sample = slice(None, None, max(1, len(u) // N_BOUND_POINTS))
    order = np.argsort(rows[sample])
    slabs = np.array_split(columns[sample][order], cells_per_side)
    parts = np.empty((cells_per_side, cells_per_side - 1))
    for slab, bounds in zip(slabs, parts, strict=True):
        slab.sort()
        bounds[:] = [slab[len(slab) * i // cells_per_side] for i in range(1, cells_per_side)]
    ends = np.cumsum([len(slab) for slab in slabs])[:-1]
    count, sums = (
        np.zeros(cells_per_side * cells_per_side, np.int64),
        np.zeros((cells_per_side * cells_per_side, 8)),
    )
    first_coordinates, second_coordinates, *values = (
        to_kernel_array(x, np.float64) for x in (rows, columns, u, v, r)
    )
    slab_bounds = to_kernel_array(rows[sample][order][ends], np.float64)
    cell_sums(first_coordinates, second_coordinates, slab_bounds, parts, *values, count, sums)
    return count, sums


def equal_cells(u: AnyArray, v: AnyArray, cells_per_side: int) -> IntArray:
    """Assign points to the cells of a patch, which have nearly equal numbers of points.

    Parameters
    ----------
    u, v : (n,) ndarray
        Coordinates in the plane.
    cells_per_side : int
        Number of cells along each axis.

    Returns
    -------
    (n,) ndarray of int
        Index of the cell of each point.
    """
    n = len(u)
    slab = np.empty(n, np.int16)
    slab[np.argsort(u, kind="stable")] = _split_equally(np.arange(n), np.int64(n), cells_per_side)
    order = np.argsort(v, kind="stable")
    order = order[np.argsort(slab[order], kind="stable")]
    count = np.bincount(slab, minlength=cells_per_side)
    slab_of_point = slab[order].astype(np.int64)
    starts = np.cumsum(count) - count
    cell = np.empty(n, np.int64)
    cell[order] = slab_of_point * cells_per_side + _split_equally(
        np.arange(n) - starts[slab_of_point], count[slab_of_point], cells_per_side
    )
    return cell


def _split_equally(position: IntArray, count: Any, parts: int) -> IntArray:
    """Assign ranks below `count` to parts of nearly equal size, larger parts first."""
    size, n_larger = np.divmod(count, parts)
    first_size = n_larger * (size + 1)
    later_indices = n_larger + (position - first_size) // np.maximum(size, 1)
    return np.asarray(
        np.where(position < first_size, position // (size + 1), later_indices), np.int64
    )


def outline(points: npt.ArrayLike, normal: npt.ArrayLike) -> tuple[Triple, ...]:
    """Return the convex hull of the points of a patch, projected along its normal.

    Parameters
    ----------
    points : (k, 3) array_like
    normal : (3,) array_like

    Returns
    -------
    tuple of Triple
        Vertices of the hull; empty if the points do not span an area.
    """
    from scipy.spatial import ConvexHull, QhullError

    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    n = np.asarray(normal, dtype=np.float64)
    if len(xyz) < 3:
        return ()
    u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    local_points = xyz - xyz.mean(axis=0)
    try:
        hull = ConvexHull(np.stack([local_points @ u, local_points @ np.cross(n, u)], axis=1))
    except (QhullError, ValueError):
        return ()
    return tuple(_triple(xyz[i]) for i in hull.vertices)


def face_points(mesh: Mesh, faces: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the vertices of faces, weighted by the areas of their faces.

    Parameters
    ----------
    mesh : Mesh
    faces : (m,) array_like of int
        Rows of the faces.

    Returns
    -------
    points : (k, 3) ndarray
        Vertices in the file frame.
    weights : (k,) ndarray
        A third of the area of the adjoining faces.
    """
    corners = np.asarray(mesh.faces[np.asarray(faces, dtype=np.int64)], dtype=np.int64)
    ids, inverse = np.unique(corners, return_inverse=True)
    points = np.asarray(mesh.vertices[ids], dtype=np.float64)
    weights = np.repeat(face_areas(mesh, faces) / 3.0, 3)
    weight = np.bincount(inverse.ravel(), weights, minlength=len(ids))
    # Vertices of faces with zero area also belong to the patch.
    return points, np.maximum(weight, 1e-12 * max(float(weight.sum()), 1e-300))


def face_areas(mesh: Mesh, faces: npt.ArrayLike) -> FloatArray:
    """Return the areas of faces.

    Parameters
    ----------
    mesh : Mesh
    faces : (k,) array_like of int
        Rows of faces.

    Returns
    -------
    (k,) ndarray
        Areas in squared units of the file.
    """
    corners = np.asarray(mesh.faces[np.asarray(faces, dtype=np.int64)], dtype=np.int64)
    a, b, c = (np.asarray(mesh.vertices[corners[:, i]], dtype=np.float64) for i in range(3))
    return triangle_areas(a, b, c)


def triangle_areas(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return the areas of triangles.

    Parameters
    ----------
    a, b, c : (k, 3) ndarray
        Vertices of the triangles.

    Returns
    -------
    (k,) ndarray
        Areas in squared length units.
    """
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def ids_to_runs(ids: npt.ArrayLike) -> tuple[tuple[int, int], ...]:
    """Compress sorted distinct ids to (first, count) runs.

    Faces or points that are neighbours in space usually form few runs.

    Parameters
    ----------
    ids : (n,) array_like of int

    Returns
    -------
    tuple of tuple
        (first, count) of each run.
    """
    x = np.asarray(ids, dtype=np.int64)
    if not (np.diff(x) > 0).all():
        x = np.unique(x)
    if not len(x):
        return ()
    cuts = np.flatnonzero(np.diff(x) != 1) + 1
    starts = np.concatenate([[0], cuts])
    counts = np.diff(np.append(starts, len(x)))
    return tuple(zip(x[starts].tolist(), counts.tolist(), strict=True))


def runs_to_ids(runs: tuple[tuple[int, int], ...]) -> IntArray:
    """Expand (first, count) runs to sorted ids.

    Parameters
    ----------
    runs : tuple of tuple
        (first, count) of each run.

    Returns
    -------
    ndarray of int
    """
    if not runs:
        return np.zeros(0, np.int64)
    first_ids, count = np.array(runs, dtype=np.int64).T
    shift = np.repeat(first_ids - (np.cumsum(count) - count), count)
    return np.asarray(np.arange(int(count.sum()), dtype=np.int64) + shift)


def has_id(runs: tuple[tuple[int, int], ...], id_: int) -> bool:
    """Return whether sorted (first, count) runs contain an id.

    Parameters
    ----------
    runs : tuple of tuple
        (first, count) of each run, sorted.
    id_ : int

    Returns
    -------
    bool
    """
    index = bisect_right(runs, id_, key=lambda run: run[0]) - 1
    return index >= 0 and id_ < runs[index][0] + runs[index][1]


def _triple(x: FloatArray) -> Triple:
    return float(x[0]), float(x[1]), float(x[2])
