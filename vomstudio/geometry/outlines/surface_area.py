"""Which part of a surface lies inside an outline that was drawn on it, and how large it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.geometry.coincident_points import welded

if TYPE_CHECKING:
    import shapely


_CELLS = 256
"""Along the longer side: most faces are told inside or outside by the cells that they lie in."""
_SEEDS = 64
"""Places on the outline where its surface is looked for."""


@dataclass(frozen=True, eq=False)
class _Enclosed:
    """Triangles (k, 3, 3), also as seen along the outline's normal (k, 3, 2), the share of each
    that is inside (k,), and the outline as it is seen."""

    faces: FloatArray
    seen: FloatArray
    share: FloatArray
    polygon: shapely.Polygon


def area_inside(corners: npt.ArrayLike, ring: npt.ArrayLike) -> float | None:
    """Area of the part of a surface of triangles that an outline encloses, in their unit squared.

    corners : (m, 3, 3) of the triangles around the outline; ring : (n, 3) points on the surface,
    the first not repeated. What is enclosed is seen along the normal of the outline (that by which
    it looks largest); faces that the outline cuts count in part. Only what hangs together with the
    outline counts: not a wall behind it. None where the outline has no area, crosses itself as seen
    along its normal, or has no surface under it.
    """
    found = _enclosed(corners, ring)
    if found is None:
        return None
    edges = found.faces[:, 1:] - found.faces[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return float((areas * found.share).sum())


def part_inside(corners: npt.ArrayLike, ring: npt.ArrayLike) -> FloatArray | None:
    """(k, 3, 3) triangles of the part of a surface that an outline encloses, as in `area_inside`;
    those that the outline cuts are cut there."""
    found = _enclosed(corners, ring)
    if found is None:
        return None
    whole = found.share >= 1.0 - 1e-9
    return np.concatenate(
        [found.faces[whole], _pieces(found.faces[~whole], found.seen[~whole], found.polygon)]
    )


def _pieces(faces: FloatArray, seen: FloatArray, polygon: shapely.Polygon) -> FloatArray:
    """(p, 3, 3) triangles of what is inside of triangles (k, 3, 3) that are seen at (k, 3, 2)."""
    import shapely

    faces, seen = faces[_broad(seen)], seen[_broad(seen)]
    parts = shapely.intersection(shapely.polygons(seen), polygon)
    pieces, of = shapely.get_parts(shapely.constrained_delaunay_triangles(parts), return_index=True)
    if not len(pieces):
        return np.zeros((0, 3, 3))
    places = shapely.get_coordinates(pieces).reshape(-1, 4, 2)[:, :3]
    # A place of a triangle has the same shares of its corners in space as seen.
    a, u, v = seen[of, 0], seen[of, 1] - seen[of, 0], seen[of, 2] - seen[of, 0]
    off = places - a[:, None]
    whole = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])[:, None]
    s = (off[..., 0] * v[:, None, 1] - off[..., 1] * v[:, None, 0]) / whole
    t = (u[:, None, 0] * off[..., 1] - u[:, None, 1] * off[..., 0]) / whole
    first, second = faces[of, 1] - faces[of, 0], faces[of, 2] - faces[of, 0]
    return np.asarray(
        faces[of, :1] + s[..., None] * first[:, None] + t[..., None] * second[:, None]
    )


def _enclosed(corners: npt.ArrayLike, ring: npt.ArrayLike) -> _Enclosed | None:
    import shapely

    xyz = np.asarray(ring, np.float64).reshape(-1, 3)
    faces = np.asarray(corners, np.float64).reshape(-1, 3, 3)
    if len(xyz) < 3 or not len(faces):
        return None
    origin = xyz.mean(axis=0)
    axes = _axes(xyz - origin)
    if axes is None:
        return None
    outline = (xyz - origin) @ axes.T
    polygon = shapely.Polygon(outline[:, :2])
    if not polygon.is_valid:
        return None
    seen = (faces - origin) @ axes.T
    low, high = outline[:, :2].min(axis=0), outline[:, :2].max(axis=0)
    flat = seen[:, :, :2]
    near = _reach(flat, low, high)
    faces, seen = faces[near], seen[near]
    if not len(faces):
        return None
    share = _shares(seen[:, :, :2], polygon, low, high)
    kept = share > 0.0
    faces, seen, share = faces[kept], seen[kept], share[kept]
    own = _hanging_together(faces, _under(seen, outline))
    if own is None:
        return None
    return _Enclosed(faces[own], seen[own, :, :2], share[own], polygon)


def _reach(flat: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """(m,) whether the boxes of triangles (m, 3, 2) meet the box."""
    found = np.ones(len(flat), np.bool_)
    for axis in (0, 1):
        a, b, c = (flat[:, corner, axis] for corner in range(3))
        # Reductions over short axes take ten times as long.
        found &= np.maximum(np.maximum(a, b), c) >= low[axis]
        found &= np.minimum(np.minimum(a, b), c) <= high[axis]
    return found


def _axes(local: FloatArray) -> FloatArray | None:
    """(3, 3) rows: two axes of the outline's plane and its normal; None for no area."""
    normal = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(normal))
    if not size > 1e-12 * float((local**2).sum()):
        return None
    normal = normal / size
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u /= np.linalg.norm(u)
    return np.array([u, np.cross(normal, u), normal])


def _shares(
    flat: FloatArray, polygon: shapely.Polygon, low: FloatArray, high: FloatArray
) -> FloatArray:
    """(m,) 0 to 1: which part of each triangle (m, 3, 2) is inside."""
    import shapely

    step = float((high - low).max()) / _CELLS
    count = np.maximum(np.ceil((high - low) / step).astype(int), 1) + 2
    start = low - step
    border = _border(polygon, start, step, count)
    middle = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in count), indexing="ij"), axis=-1)
    places = (start + step * middle).reshape(-1, 2)
    inside = shapely.contains_xy(polygon, places[:, 0], places[:, 1]).reshape(count)
    first = np.clip(((flat.min(axis=1) - start) / step).astype(int), 0, count - 1)
    last = np.clip(((flat.max(axis=1) - start) / step).astype(int), 0, count - 1)
    # Of a table of sums: how many cells of the border each triangle's box has.
    sums = np.zeros(count + 1, np.int64)
    sums[1:, 1:] = border.cumsum(axis=0).cumsum(axis=1)
    (x0, y0), (x1, y1) = first.T, last.T + 1
    crossed = sums[x1, y1] - sums[x0, y1] - sums[x1, y0] + sums[x0, y0] > 0
    share = np.where(crossed, 0.0, inside[x0, y0].astype(np.float64))
    if crossed.any():
        share[crossed] = _cut(flat[crossed], polygon)
    return share


def _border(
    polygon: shapely.Polygon, start: FloatArray, step: float, count: npt.NDArray[np.int_]
) -> BoolArray:
    """Cells that the outline goes through, or passes beside."""
    ends = np.asarray(polygon.exterior.coords)[:, :2]
    pieces = np.diff(ends, axis=0)
    many = np.maximum(np.ceil(2.0 * np.linalg.norm(pieces, axis=1) / step).astype(int), 1)
    which = np.repeat(np.arange(len(pieces)), many)
    along = (np.arange(len(which)) - np.repeat(np.cumsum(many) - many, many)) / many[which]
    places = ends[which] + along[:, None] * pieces[which]
    cells = np.clip(((places - start) / step).astype(int), 1, count - 2)
    border = np.zeros(count, np.bool_)
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            border[cells[:, 0] + dx, cells[:, 1] + dy] = True
    return border


def _cut(flat: FloatArray, polygon: shapely.Polygon) -> FloatArray:
    """(k,) shares of triangles that the outline may go through."""
    import shapely

    middle = flat.mean(axis=1)
    # Seen from their edge they have no area to cut: they are where their middle is.
    share: FloatArray = shapely.contains_xy(polygon, middle[:, 0], middle[:, 1]).astype(np.float64)
    broad, area = _broad(flat), _flat_areas(flat)
    triangles = shapely.polygons(flat[broad])
    share[broad] = np.clip(
        shapely.area(shapely.intersection(triangles, polygon)) / area[broad], 0, 1
    )
    return share


def _flat_areas(flat: FloatArray) -> FloatArray:
    """(k,) of triangles (k, 3, 2)."""
    a, b = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    return np.asarray(0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))


def _broad(flat: FloatArray) -> BoolArray:
    """(k,) whether triangles (k, 3, 2) are not seen from their edge."""
    longest = (np.ptp(flat, axis=1) ** 2).sum(axis=1)
    return np.asarray(_flat_areas(flat) > 1e-9 * longest)


def _under(seen: FloatArray, outline: FloatArray) -> IntArray:
    """Rows of the triangles (m, 3, 3) on which places of the outline lie: of those that are seen
    there, the nearest."""
    corners = [[np.ascontiguousarray(seen[:, k, axis]) for k in range(3)] for axis in (0, 1)]
    low = [np.minimum(np.minimum(a, b), c) for a, b, c in corners]
    high = [np.maximum(np.maximum(a, b), c) for a, b, c in corners]
    found = []
    for place in outline[:: max(1, len(outline) // _SEEDS)]:
        x, y = float(place[0]), float(place[1])
        there = (low[0] <= x) & (high[0] >= x) & (low[1] <= y) & (high[1] >= y)
        rows = np.flatnonzero(there)
        if not len(rows):
            continue
        off = np.abs(_depth(seen[rows], place[:2]) - place[2])
        found.append(int(rows[int(np.argmin(off))]))
    return np.array(sorted(set(found)), np.int64)


def _depth(triangles: FloatArray, place: FloatArray) -> FloatArray:
    """(k,) height of the triangles' planes at a place that is in the box of each; infinite where
    that is outside of the triangle."""
    a = triangles[:, 0]
    b, c, p = triangles[:, 1] - a, triangles[:, 2] - a, place - a[:, :2]
    whole = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (p[:, 0] * c[:, 1] - p[:, 1] * c[:, 0]) / whole
        t = (b[:, 0] * p[:, 1] - b[:, 1] * p[:, 0]) / whole
    depth = a[:, 2] + s * b[:, 2] + t * c[:, 2]
    outside = ~(np.isfinite(depth) & (s > -1e-6) & (t > -1e-6) & (s + t < 1.0 + 1e-6))
    return np.asarray(np.where(outside, np.inf, depth), np.float64)


def _hanging_together(faces: FloatArray, seeds: IntArray) -> BoolArray | None:
    """Which faces (k, 3, 3) can be reached from one of the seeds over shared corners."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    if not len(seeds):
        return None
    k = len(faces)
    nodes = welded(faces.reshape(-1, 3))
    size = k + int(nodes.max()) + 1
    starts = np.full(size + 1, 3 * k, np.int64)
    starts[: k + 1] = np.arange(0, 3 * k + 1, 3)
    graph = csr_array((np.ones(3 * k), nodes + k, starts), (size, size))
    label = connected_components(graph, directed=False)[1][:k]
    return np.asarray(np.isin(label, label[seeds]))
