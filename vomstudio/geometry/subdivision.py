"""The mesh that was subdivided: a face that was divided carries no more information than before.

Linear subdivision (at the middles of edges, at centroids, by bisection) leaves each face as a flat
patch whose outline has the corners of that face; the vertices on its sides and inside it follow
from these. A wall that is truly flat cannot be told from one that was measured and is flat, so a
patch counts as divided only if it is a triangle, or has as many faces for each triangle of its
outline as those have. All vertices of other patches count, and the spacing is the resolution there.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray, IntegerArray
from vomstudio.geometry.coincident_points import place_keys, welded

MIN_BEND_RAD, MAX_BEND_RAD = 3e-4, 2e-2
"""Faces that form a smaller angle are coplanar, sides that do are straight; between these limits as
much as the rounding of the coordinates can bend."""
ROUNDINGS = 4.0
MAX_DECIMALS = 7
SAMPLED_VERTICES = 1000
MIN_SHARE = 0.05
"""A mesh in which fewer vertices follow from their neighbours was not divided."""
MIN_AREA_SHARE = 0.25
"""Of the area, divided triangles: from how many faces each triangle was divided into is known."""
FACE_RATIO = 1.5


def undivided(vertices: FloatArray, faces: IntegerArray) -> tuple[FloatArray, Int32Array] | None:
    """Find the vertices and faces from which others follow by linear interpolation.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of rows into `vertices`

    Returns
    -------
    Vertices (k, 3), each place once, and faces; None if the mesh was not subdivided. Divided faces
    that lie in one plane with their neighbours leave their vertices, but no face.
    """
    if len(faces) < 8 or not len(vertices):
        return None
    bend = _largest_bend(vertices, faces)
    if _sampled_share(vertices, faces, bend) < MIN_SHARE:
        return None
    used, inverse = np.unique(faces, return_inverse=True)
    number = welded(np.asarray(vertices[used], np.float64))
    origin = np.asarray(vertices[used[0]], np.float64)
    places = np.empty((int(number.max()) + 1, 3))
    places[number] = vertices[used] - origin
    own = number[inverse.reshape(-1, 3)]
    normals, areas = _normals(places[own])
    sound = (areas > 0.0) & np.isfinite(areas)
    own, normals, areas = own[sound], normals[sound], areas[sound]
    if len(own) < 8:
        return None
    patch = _flat_patches(own, normals, bend)
    outlines, corner = _corners(places, own, patch, bend)
    count = np.bincount(patch)
    area = np.bincount(patch, areas)
    corners = np.bincount(outlines, minlength=len(count))
    triangle = corners == 3
    divided = triangle & (count > 1)
    if area[divided].sum() < MIN_AREA_SHARE * area.sum():
        return None
    order = np.argsort(count[divided])
    total = np.cumsum(area[divided][order])
    each = float(count[divided][order][np.searchsorted(total, 0.5 * total[-1])])
    ratio = count / np.maximum(corners - 2.0, 1.0) / each
    plain = ~triangle & ~((corners > 2) & (ratio < FACE_RATIO) & (ratio > 1.0 / FACE_RATIO))
    # The corners come patch by patch.
    whole = np.concatenate([corner[triangle[outlines]].reshape(-1, 3), own[plain[patch]]])
    independent = np.zeros(len(places), np.bool_)
    independent[corner] = independent[whole.ravel()] = True
    row = np.cumsum(independent) - 1
    return places[independent] + origin, row[whole].astype(np.int32)


def _normals(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit normals (m, 3) and areas (m,) of triangles (m, 3, 3)."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(cross, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return cross / double[:, None], 0.5 * double


def _largest_bend(vertices: FloatArray, faces: IntegerArray) -> float:
    """Angle by which rounding of the coordinates can bend a flat surface, radians."""
    some = np.asarray(vertices[:: max(1, len(vertices) // SAMPLED_VERTICES)], np.float64)
    some = some[np.isfinite(some).all(axis=1)]
    if not len(some):
        return MIN_BEND_RAD
    rounding = 0.0
    if (some == some.astype(np.float32)).all():
        rounding = float(np.abs(some).max()) * float(np.finfo(np.float32).eps)
    for decimals in range(MAX_DECIMALS, 0, -1):
        if not (some == np.round(some, decimals)).all():
            break
        rounding = 10.0**-decimals
    corners = vertices[faces[:: max(1, len(faces) // SAMPLED_VERTICES)]]
    edge = float(np.sqrt(np.nanmedian(2.0 * _normals(corners)[1])))
    bend = ROUNDINGS * rounding / edge if edge > 0.0 else 0.0
    return min(max(bend, MIN_BEND_RAD), MAX_BEND_RAD)


def _sampled_share(vertices: FloatArray, faces: IntegerArray, bend: float) -> float:
    """Share of some vertices whose faces lie in one plane or in two."""
    step = max(1, len(vertices) // SAMPLED_VERTICES)
    keys = place_keys(vertices)
    chosen = np.unique(keys[step // 2 :: step])
    row = np.minimum(np.searchsorted(chosen, keys), len(chosen) - 1)
    row[chosen[row] != keys] = -1
    near = row[faces]
    of_face, corner = np.nonzero(near >= 0)
    normals, areas = _normals(np.asarray(vertices[faces[of_face]], np.float64))
    sound = areas > 0.0
    at, normals = near[of_face, corner][sound], normals[sound]
    tensor = np.zeros((len(chosen), 3, 3))
    np.add.at(tensor, at, normals[:, :, None] * normals[:, None, :])
    count = np.bincount(at, minlength=len(chosen))
    # Of two faces nothing can be said.
    values = np.linalg.eigvalsh(tensor[count > 2])
    return float((values[:, 0] < bend**2).mean()) if len(values) else 0.0


def _flat_patches(faces: IntArray, normals: FloatArray, largest: float) -> IntArray:
    """(m,) number of the coplanar patch of each face."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(faces)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.argsort(low * (int(faces.max()) + 1) + high, kind="stable")
    same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
    one, other = order[:-1][same] // 3, order[1:][same] // 3
    bend = np.linalg.norm(np.cross(normals[one], normals[other]), axis=1)
    flat = bend < largest
    pairs = coo_array((np.ones(int(flat.sum()), np.bool_), (one[flat], other[flat])), (n, n))
    return np.asarray(connected_components(pairs, directed=False)[1], np.int64)


def _corners(
    places: FloatArray, faces: IntArray, patch: IntArray, largest: float
) -> tuple[IntArray, IntArray]:
    """Patch and vertex of each corner of the patches' outlines, patch by patch."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    own = np.repeat(patch, 3)
    size = int(faces.max()) + 1
    key = np.minimum(start, end) * size + np.maximum(start, end)
    # An edge within a patch is there twice.
    order = np.lexsort((key, own))
    twice = (np.diff(key[order]) == 0) & (np.diff(own[order]) == 0)
    rim = np.ones(len(key), np.bool_)
    rim[order[:-1][twice]] = rim[order[1:][twice]] = False
    start, end, own = start[rim], end[rim], own[rim]
    side = places[end] - places[start]
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    # At a vertex of an outline one side arrives and one leaves.
    arrives = np.argsort(own * size + end, kind="stable")
    leaves = np.argsort(own * size + start, kind="stable")
    into, out = (own * size + end)[arrives], (own * size + start)[leaves]
    if not np.array_equal(into, out):
        # Faces that are turned differently, or outlines that touch themselves.
        both = np.intersect1d(into, out)
        arrives = arrives[np.searchsorted(into, both)]
        leaves = leaves[np.searchsorted(out, both)]
        into = both
    bend = np.linalg.norm(np.cross(side[arrives], side[leaves]), axis=1)
    ahead = (side[arrives] * side[leaves]).sum(axis=1)
    turns = (bend > largest) | (ahead < 0.0)
    return into[turns] // size, into[turns] % size
