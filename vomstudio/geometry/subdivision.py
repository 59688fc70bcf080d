"""Detection of subdivided meshes, whose additional faces contain no information.

Linear subdivision (at the midpoints of edges, at centroids, or by bisection) turns each face into a
flat patch whose outline has the corners of that face; the vertices on its sides and inside are
interpolated. A patch is considered divided only if it is a triangle, or has about as many faces per
triangle of its outline as the divided triangles. All vertices of other patches are used, and their
spacing is the resolution there.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray, IntegerArray
from vomstudio.geometry.coincident_points import position_keys, weld_points

MIN_BEND_RAD, MAX_BEND_RAD = 3e-4, 2e-2
"""Faces with a smaller angle are coplanar, and sides are straight; between these limits the angle
that rounding of the coordinates can cause is used.
"""
ROUNDING_FACTOR = 4.0
MAX_DECIMALS = 7
MAX_SAMPLED_VERTICES = 1000
MIN_INTERPOLATED_SHARE = 0.05
"""Minimum share of interpolated vertices in a divided mesh."""
MIN_AREA_SHARE = 0.25
"""Minimum share of the area in divided triangles, which determine the number of faces per
triangle.
"""
MAX_FACE_RATIO = 1.5


def find_undivided(
    vertices: FloatArray, faces: IntegerArray
) -> tuple[FloatArray, Int32Array] | None:
    """Find the vertices and faces from which others follow by linear interpolation.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of rows into `vertices`

    Returns
    -------
    vertices, faces : ndarray, or None
        Distinct vertices (k, 3) and faces, or None if the mesh was not subdivided. Divided faces
        that are coplanar with their neighbours contribute their vertices, but no faces.
    """
    if len(faces) < 8 or not len(vertices):
        return None
    bend = _rounding_bend_rad(vertices, faces)
    if _sampled_flat_share(vertices, faces, bend) < MIN_INTERPOLATED_SHARE:
        return None
    used_corners, inverse = np.unique(faces, return_inverse=True)
    point_ids = weld_points(np.asarray(vertices[used_corners], np.float64))
    origin = np.asarray(vertices[used_corners[0]], np.float64)
    positions = np.empty((int(point_ids.max()) + 1, 3))
    positions[point_ids] = vertices[used_corners] - origin
    face_numbers = point_ids[inverse.reshape(-1, 3)]
    normals, areas = _normals(positions[face_numbers])
    is_valid = (areas > 0.0) & np.isfinite(areas)
    face_numbers, normals, areas = face_numbers[is_valid], normals[is_valid], areas[is_valid]
    if len(face_numbers) < 8:
        return None
    patch = _flat_patches(face_numbers, normals, bend)
    corner_patch, corner = _corners(positions, face_numbers, patch, bend)
    count = np.bincount(patch)
    area = np.bincount(patch, areas)
    corners = np.bincount(corner_patch, minlength=len(count))
    is_triangle = corners == 3
    is_divided = is_triangle & (count > 1)
    if area[is_divided].sum() < MIN_AREA_SHARE * area.sum():
        return None
    order = np.argsort(count[is_divided])
    cumulative_area = np.cumsum(area[is_divided][order])
    faces_per_triangle = float(
        count[is_divided][order][np.searchsorted(cumulative_area, 0.5 * cumulative_area[-1])]
    )
    ratio = count / np.maximum(corners - 2.0, 1.0) / faces_per_triangle
    is_unchanged = ~is_triangle & ~(
        (corners > 2) & (ratio < MAX_FACE_RATIO) & (ratio > 1.0 / MAX_FACE_RATIO)
    )
    # Corners are in order of patches.
    independent_faces = np.concatenate(
        [corner[is_triangle[corner_patch]].reshape(-1, 3), face_numbers[is_unchanged[patch]]]
    )
    is_independent = np.zeros(len(positions), np.bool_)
    is_independent[corner] = is_independent[independent_faces.ravel()] = True
    row = np.cumsum(is_independent) - 1
    return positions[is_independent] + origin, row[independent_faces].astype(np.int32)


def _normals(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit normals (m, 3) and areas (m,) of triangles (m, 3, 3)."""
    cross_products = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_areas = np.linalg.norm(cross_products, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return cross_products / doubled_areas[:, None], 0.5 * doubled_areas


def _rounding_bend_rad(vertices: FloatArray, faces: IntegerArray) -> float:
    """Return the angle by which rounding of the coordinates can bend a flat surface, radians."""
    sample = np.asarray(vertices[:: max(1, len(vertices) // MAX_SAMPLED_VERTICES)], np.float64)
    sample = sample[np.isfinite(sample).all(axis=1)]
    if not len(sample):
        return MIN_BEND_RAD
    rounding = 0.0
    if (sample == sample.astype(np.float32)).all():
        rounding = float(np.abs(sample).max()) * float(np.finfo(np.float32).eps)
    for decimals in range(MAX_DECIMALS, 0, -1):
        if not (sample == np.round(sample, decimals)).all():
            break
        rounding = 10.0**-decimals
    corners = vertices[faces[:: max(1, len(faces) // MAX_SAMPLED_VERTICES)]]
    edge = float(np.sqrt(np.nanmedian(2.0 * _normals(corners)[1])))
    bend = ROUNDING_FACTOR * rounding / edge if edge > 0.0 else 0.0
    return min(max(bend, MIN_BEND_RAD), MAX_BEND_RAD)


def _sampled_flat_share(vertices: FloatArray, faces: IntegerArray, bend: float) -> float:
    """Return the share of sampled vertices whose faces lie in at most two planes."""
    step = max(1, len(vertices) // MAX_SAMPLED_VERTICES)
    keys = position_keys(vertices)
    sampled_keys = np.unique(keys[step // 2 :: step])
    row = np.minimum(np.searchsorted(sampled_keys, keys), len(sampled_keys) - 1)
    row[sampled_keys[row] != keys] = -1
    sample_row = row[faces]
    face_row, corner = np.nonzero(sample_row >= 0)
    normals, areas = _normals(np.asarray(vertices[faces[face_row]], np.float64))
    is_valid = areas > 0.0
    vertex_row, normals = sample_row[face_row, corner][is_valid], normals[is_valid]
    tensor = np.zeros((len(sampled_keys), 3, 3))
    np.add.at(tensor, vertex_row, normals[:, :, None] * normals[:, None, :])
    count = np.bincount(vertex_row, minlength=len(sampled_keys))
    # Two faces are always in two planes.
    values = np.linalg.eigvalsh(tensor[count > 2])
    return float((values[:, 0] < bend**2).mean()) if len(values) else 0.0


def _flat_patches(faces: IntArray, normals: FloatArray, max_bend: float) -> IntArray:
    """Return the coplanar patch (m,) of each face."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(faces)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.argsort(low * (int(faces.max()) + 1) + high, kind="stable")
    is_same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
    first_face, second_face = order[:-1][is_same] // 3, order[1:][is_same] // 3
    bend = np.linalg.norm(np.cross(normals[first_face], normals[second_face]), axis=1)
    is_flat = bend < max_bend
    pairs = coo_array(
        (np.ones(int(is_flat.sum()), np.bool_), (first_face[is_flat], second_face[is_flat])), (n, n)
    )
    return np.asarray(connected_components(pairs, directed=False)[1], np.int64)


def _corners(
    positions: FloatArray, faces: IntArray, patch: IntArray, max_bend: float
) -> tuple[IntArray, IntArray]:
    """Return the patch and vertex of each corner of the outlines, in order of patches."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    side_patch = np.repeat(patch, 3)
    size = int(faces.max()) + 1
    key = np.minimum(start, end) * size + np.maximum(start, end)
    # An edge within a patch occurs twice.
    order = np.lexsort((key, side_patch))
    is_inner = (np.diff(key[order]) == 0) & (np.diff(side_patch[order]) == 0)
    is_border = np.ones(len(key), np.bool_)
    is_border[order[:-1][is_inner]] = is_border[order[1:][is_inner]] = False
    start, end, side_patch = start[is_border], end[is_border], side_patch[is_border]
    edges = positions[end] - positions[start]
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    # At a vertex of an outline one side arrives and one leaves.
    incoming_rows = np.argsort(side_patch * size + end, kind="stable")
    outgoing_rows = np.argsort(side_patch * size + start, kind="stable")
    incoming_keys, outgoing_keys = (
        (side_patch * size + end)[incoming_rows],
        (side_patch * size + start)[outgoing_rows],
    )
    if not np.array_equal(incoming_keys, outgoing_keys):
        # Faces with different orientation, or outlines that touch themselves.
        shared_corners = np.intersect1d(incoming_keys, outgoing_keys)
        incoming_rows = incoming_rows[np.searchsorted(incoming_keys, shared_corners)]
        outgoing_rows = outgoing_rows[np.searchsorted(outgoing_keys, shared_corners)]
        incoming_keys = shared_corners
    bend = np.linalg.norm(np.cross(edges[incoming_rows], edges[outgoing_rows]), axis=1)
    forward = (edges[incoming_rows] * edges[outgoing_rows]).sum(axis=1)
    is_corner = (bend > max_bend) | (forward < 0.0)
    return incoming_keys[is_corner] // size, incoming_keys[is_corner] % size
