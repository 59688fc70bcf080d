"""What a patch of a surface keeps of its points: enough to fit its plane without its model.

Points of a dense model repeat each other: neighbours share the roughness of the rock. How much is
told by the means of equal cells of the patch. Where every point is independent, these means scatter
by what their number of points explains; where roughness is longer than the spacing they scatter
more, and it is their scatter that tilts the plane. Simulated (60 x 50 points, Gaussian roughness):
the 95 % region holds the truth in 98 % for white noise, 94 to 95 % for roughness whose correlation
falls to 1/e within a tenth of the patch, 88 % at a sixth, 50 % at a third: it cannot be told from a
tilt by then, which is why the verdict on a patch also looks at the hyperbolic error.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray, FloatArray, GenericArray, IntArray
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.jit import for_kernels, for_reading
from vomstudio.geometry.kernels.patch_cells import cell_sums, turned, weighted_spread
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.plane_errors import LEVEL, joint_quantile

Triple = tuple[float, float, float]

# Cells a side: 36 means still have 33 degrees of freedom. A mean of fewer points than this says
# nothing beyond its points.
CELLS = 6
POINTS_PER_CELL = 4
_CHANCE, _MARGIN, _FEWEST_CELLS = 1e-4, 1.4, 9
_LOOKED_AT = 40_000
_MANY = 4_000
"""Of more points cells are found by their bounds."""
_BOUNDED = 5_000
"""By about so many points."""


@dataclass(frozen=True)
class Moments:
    """n distinct points: mean, scatter sum (x - mean)(x - mean)' (3, 3), and the number of
    independent points that would know their plane as well. Any frame; scatter in its unit squared.
    """

    n: int
    mean: Triple
    scatter: tuple[Triple, Triple, Triple]
    n_effective: float


def moments(
    points: npt.ArrayLike, weights: npt.ArrayLike | None = None, *, distinct: bool = False
) -> Moments:
    """Of points (k, 3), float64. weights (k,) positive, only their ratios count: the share of the
    surface each point stands for, so that a finer meshed corner does not draw the plane to itself.
    Points at the same place count once, with their weights added. distinct : there are none"""
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    given = np.ones(len(xyz)) if weights is None else np.asarray(weights, dtype=np.float64)
    if not len(xyz):
        zero = (0.0, 0.0, 0.0)
        return Moments(0, zero, (zero, zero, zero), 0.0)
    weight, places = given, xyz
    if not distinct:
        which = welded(xyz)
        weight = np.bincount(which, given).astype(np.float64)
        places = np.empty((len(weight), 3))
        places[which] = xyz
    n = len(weight)
    if n > _MANY:
        return _many_moments(for_reading(places, np.float64), weight)
    weight = weight * (n / weight.sum())
    first = places[0]
    local = places - first
    mean = (weight[:, None] * local).sum(axis=0) / n
    local = local - mean
    scatter = (weight[:, None] * local).T @ local
    r, v, u = (local @ np.linalg.eigh(scatter / n)[1]).T
    return Moments(
        n,
        _triple(first + mean),
        (_triple(scatter[0]), _triple(scatter[1]), _triple(scatter[2])),
        _effective(u, v, r),
    )


def _many_moments(places: FloatArray, weight: FloatArray) -> Moments:
    """Of so many that it takes long to go over them time and again."""
    n, centre, scatter = len(places), places[0].copy(), np.zeros((3, 3))
    if float(np.ptp(weight)) == 0.0:
        weight = np.ones(1)
    else:
        weight = for_kernels(weight * (n / weight.sum()), np.float64)
    weighted_spread(places, weight, centre, scatter)
    axes = for_kernels(np.linalg.eigh(scatter / n)[1].T[::-1], np.float64)
    u, v, r = (np.empty(n) for _ in range(3))
    turned(places, centre, axes, u, v, r)
    return Moments(
        n,
        _triple(centre),
        (_triple(scatter[0]), _triple(scatter[1]), _triple(scatter[2])),
        _effective(u, v, r),
    )


def _effective(u: FloatArray, v: FloatArray, r: FloatArray) -> float:
    """Number of independent points, from the scatter of the means of equal cells. u, v, r : (n,)
    places along the axes of the points, from the longest on."""
    n = len(u)
    fine = min(2 * CELLS, 2 * int(np.sqrt(n / POINTS_PER_CELL) / 2))
    if fine < 6:
        return float(n)
    white = float((r * r).mean()) * n / (n - 3.0)
    if white <= 0.0:
        return float(n)
    # The last step of Richardson: neighbours across a border between cells are left out of the
    # means' scatter, the more of them the smaller the cell, so sqrt(excess) rises with its width.
    finer, coarse = (np.sqrt(x / white) for x in _excesses(u, v, r, fine))
    excess = max(float(2.0 * coarse - finer), 1.0) ** 2
    free = fine * fine / 4.0 - 3.0
    # q is 2 F / dof times the variance of one independent witness over l3, as plane_errors has it.
    q = float(joint_quantile(np.array([free]))[0]) * free * excess / n
    # Scatter of means does not tell steps, or a layer over a part: there the pieces of the patch
    # agree on another attitude than the whole has.
    some = slice(None, None, max(1, n // _LOOKED_AT))
    q = max(q, _leaning(u[some], v[some], r[some], fine // 2) / white)
    return float(min(3.0 - 2.0 * np.log(LEVEL) / np.log1p(q), n))


def _excesses(u: FloatArray, v: FloatArray, r: FloatArray, side: int) -> tuple[float, float]:
    """Variance that one independent point must have for its means to scatter as those of the
    side x side cells of equal count do, and of cells twice as wide."""
    if len(u) > _MANY:
        count, sums = _sums(u, v, u, v, r, side)
        four = (side // 2, 2, side // 2, 2)
        wide, heights = (x.reshape(four).sum(axis=(1, 3)).ravel() for x in (count, sums[:, 2]))
        return _excess(count, sums[:, 2]), _excess(wide, heights)
    fine, coarse = (equal_cells(u, v, k) for k in (side, side // 2))
    of_fine, of_coarse = (_excess(np.bincount(c), np.bincount(c, r)) for c in (fine, coarse))
    return of_fine, of_coarse


def _excess(count: GenericArray, sums: GenericArray) -> float:
    own = np.asarray(sums, np.float64)
    each = np.maximum(np.asarray(count, np.float64), 1.0)
    return float((own * own / each).sum()) / (len(own) - 3.0)


def _leaning(u: FloatArray, v: FloatArray, r: FloatArray, side: int) -> float:
    """Variance across the plane that would tilt it to the attitude of its pieces, the median of the
    side x side cells, where these differ from it by more than they do from each other by chance;
    0 where they do not."""
    from scipy.stats import f

    # In a lattice whole rows are at one place but for the tilt of the plane, and by that the height
    # of a point would choose its cell.
    rows, columns = (np.round(x / max(1e-3 * float(x.std()), 1e-300)) for x in (u, v))
    aa, ab, bb, ah, bh = _products(rows, columns, u, v, r, side)
    area = aa * bb - ab * ab
    sound = area > 1e-6 * aa * bb
    slopes = np.stack([bb * ah - ab * bh, aa * bh - ab * ah])[:, sound] / area[sound]
    cells = slopes.shape[1]
    if cells < _FEWEST_CELLS:
        return 0.0
    lean = np.median(slopes, axis=1)
    # Of normal deviates the standard error of their median, by their median deviation.
    apart = np.median(np.abs(slopes - lean[:, None]), axis=1)
    error = 1.2533 * 1.4826 * apart / np.sqrt(cells)
    chance = 2.0 * float(f.ppf(1.0 - _CHANCE, 2, cells - 2))
    if float((lean**2).sum()) == 0.0 or (lean**2 <= error**2 * chance / 2.0).all():
        return 0.0
    spread = np.array([(u * u).mean(), (v * v).mean()])
    return float(_MARGIN**2 * (lean**2 @ spread))


def _products(
    rows: FloatArray, columns: FloatArray, u: FloatArray, v: FloatArray, r: FloatArray, side: int
) -> tuple[FloatArray, ...]:
    """Of cells by rows and columns the sums of uu, uv, vv, ur and vr about their means."""
    if len(u) > _MANY:
        count, sums = _sums(rows, columns, u, v, r, side)
        a, b, h = (sums[:, :3] / np.maximum(count, 1)[:, None]).T
        less = a * a, a * b, b * b, a * h, b * h
        return tuple(np.asarray(sums[:, 3 + i] - count * x) for i, x in enumerate(less))
    cell = equal_cells(rows, columns, side)
    count = np.maximum(np.bincount(cell), 1)
    a, b, h = (x - (np.bincount(cell, x) / count)[cell] for x in (u, v, r))
    products = a * a, a * b, b * b, a * h, b * h
    return tuple(np.asarray(np.bincount(cell, x), np.float64) for x in products)


def _sums(
    rows: FloatArray, columns: FloatArray, u: FloatArray, v: FloatArray, r: FloatArray, side: int
) -> tuple[IntArray, FloatArray]:
    """Of side x side cells of nearly equal count, see `cell_sums`."""
    some = slice(None, None, max(1, len(u) // _BOUNDED))
    order = np.argsort(rows[some])
    slabs = np.array_split(columns[some][order], side)
    parts = np.empty((side, side - 1))
    for own, bounds in zip(slabs, parts, strict=True):
        own.sort()
        bounds[:] = [own[len(own) * i // side] for i in range(1, side)]
    ends = np.cumsum([len(own) for own in slabs])[:-1]
    count, sums = np.zeros(side * side, np.int64), np.zeros((side * side, 8))
    across, along, *given = (for_kernels(x, np.float64) for x in (rows, columns, u, v, r))
    slab_bounds = for_kernels(rows[some][order][ends], np.float64)
    cell_sums(across, along, slab_bounds, parts, *given, count, sums)
    return count, sums


def equal_cells(u: AnyArray, v: AnyArray, side: int) -> IntArray:
    """Which of side x side cells of equal count each point is in."""
    n = len(u)
    slab = np.empty(n, np.int16)
    slab[np.argsort(u, kind="stable")] = _equal_parts(np.arange(n), np.int64(n), side)
    lined = np.argsort(v, kind="stable")
    lined = lined[np.argsort(slab[lined], kind="stable")]
    count = np.bincount(slab, minlength=side)
    of = slab[lined].astype(np.int64)
    begin = np.cumsum(count) - count
    cell = np.empty(n, np.int64)
    cell[lined] = of * side + _equal_parts(np.arange(n) - begin[of], count[of], side)
    return cell


def _equal_parts(place: IntArray, count: Any, parts: int) -> IntArray:
    """Which of so many parts of nearly equal size, the larger ones first, a place among `count` is
    in."""
    size, more = np.divmod(count, parts)
    first = more * (size + 1)
    late = more + (place - first) // np.maximum(size, 1)
    return np.asarray(np.where(place < first, place // (size + 1), late), np.int64)


def outline(points: npt.ArrayLike, normal: npt.ArrayLike) -> tuple[Triple, ...]:
    """Ring of those points (k, 3) that are the corners of the patch as seen along its normal: their
    convex hull there. Empty where there are fewer than 3 of them."""
    from scipy.spatial import ConvexHull, QhullError

    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    n = np.asarray(normal, dtype=np.float64)
    if len(xyz) < 3:
        return ()
    u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    local = xyz - xyz.mean(axis=0)
    try:
        hull = ConvexHull(np.stack([local @ u, local @ np.cross(n, u)], axis=1))
    except (QhullError, ValueError):
        return ()
    return tuple(_triple(xyz[i]) for i in hull.vertices)


def face_points(mesh: Mesh, faces: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Vertices (k, 3) of the faces, file frame, and the area that each stands for: a third of each
    of its chosen faces."""
    corners = np.asarray(mesh.faces[np.asarray(faces, dtype=np.int64)], dtype=np.int64)
    ids, which = np.unique(corners, return_inverse=True)
    points = np.asarray(mesh.vertices[ids], dtype=np.float64)
    share = np.repeat(face_areas(mesh, faces) / 3.0, 3)
    weight = np.bincount(which.ravel(), share, minlength=len(ids))
    # Vertices of faces without area belong to the patch all the same.
    return points, np.maximum(weight, 1e-12 * max(float(weight.sum()), 1e-300))


def face_areas(mesh: Mesh, faces: npt.ArrayLike) -> FloatArray:
    """(k,) areas of faces, in the file's unit squared."""
    corners = np.asarray(mesh.faces[np.asarray(faces, dtype=np.int64)], dtype=np.int64)
    a, b, c = (np.asarray(mesh.vertices[corners[:, i]], dtype=np.float64) for i in range(3))
    return triangle_areas(a, b, c)


def triangle_areas(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """(k,) areas of triangles with the corners a, b, c (k, 3)."""
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def runs_of(ids: npt.ArrayLike) -> tuple[tuple[int, int], ...]:
    """Sorted distinct ids as (first, count) runs: neighbours in a file are mostly neighbours in
    space, so this is short."""
    x = np.asarray(ids, dtype=np.int64)
    if not (np.diff(x) > 0).all():
        x = np.unique(x)
    if not len(x):
        return ()
    cuts = np.flatnonzero(np.diff(x) != 1) + 1
    starts = np.concatenate([[0], cuts])
    counts = np.diff(np.append(starts, len(x)))
    return tuple(zip(x[starts].tolist(), counts.tolist(), strict=True))


def ids_of(runs: tuple[tuple[int, int], ...]) -> IntArray:
    """The sorted ids of (first, count) runs."""
    if not runs:
        return np.zeros(0, np.int64)
    first, count = np.array(runs, dtype=np.int64).T
    shift = np.repeat(first - (np.cumsum(count) - count), count)
    return np.asarray(np.arange(int(count.sum()), dtype=np.int64) + shift)


def has_id(runs: tuple[tuple[int, int], ...], id_: int) -> bool:
    """Whether sorted (first, count) runs have an id."""
    at = bisect_right(runs, id_, key=lambda run: run[0]) - 1
    return at >= 0 and id_ < runs[at][0] + runs[at][1]


def _triple(x: FloatArray) -> Triple:
    return float(x[0]), float(x[1]), float(x[2])
