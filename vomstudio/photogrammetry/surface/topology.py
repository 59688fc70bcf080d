"""Topology of triangle meshes: neighbours, components, and repair to a manifold."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray


def edge_keys(faces: Int32Array) -> IntArray:
    """Return a key (m, 3) of each edge, from corner k to corner k + 1.

    The key is the same for both directions of an edge.
    """
    start, end = faces.astype(np.int64), np.roll(faces, -1, axis=1).astype(np.int64)
    return np.minimum(start, end) << 32 | np.maximum(start, end)


def neighbours(faces: Int32Array) -> Int32Array:
    """Return the face (m, 3) across each edge; -1 unless the edge joins exactly two faces."""
    keys = edge_keys(faces).ravel()
    order = np.argsort(keys, kind="stable")
    sorted_keys = keys[order]
    first_rows = np.flatnonzero(np.r_[True, sorted_keys[1:] != sorted_keys[:-1]])
    counts = np.diff(np.r_[first_rows, len(sorted_keys)])
    pair_starts = first_rows[counts == 2]
    opposite_faces = np.full(len(keys), -1, np.int32)
    a, b = order[pair_starts], order[pair_starts + 1]
    opposite_faces[a], opposite_faces[b] = b // 3, a // 3
    return opposite_faces.reshape(-1, 3)


def components(faces: Int32Array, is_included: BoolArray | None = None) -> Int32Array:
    """Return the index (m,) of the connected piece of each face; -1 for excluded faces.

    Faces are connected by common edges.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    neighbour_faces = neighbours(faces)
    face, side = np.nonzero(neighbour_faces >= 0)
    other_face = neighbour_faces[face, side]
    if is_included is not None:
        is_included_pair = is_included[face] & is_included[other_face]
        face, other_face = face[is_included_pair], other_face[is_included_pair]
    n = len(faces)
    links = coo_matrix((np.ones(len(face), np.int8), (face, other_face)), shape=(n, n))
    labels: Int32Array = connected_components(links, directed=False)[1].astype(np.int32)
    if is_included is None:
        return labels
    labels[~is_included] = -1
    used_labels, packed_labels = np.unique(labels[is_included], return_inverse=True)
    del used_labels
    labels[is_included] = packed_labels
    return labels


def compact(vertices: FloatArray, faces: Int32Array) -> tuple[FloatArray, Int32Array, IntArray]:
    """Remove unused vertices.

    Returns the remaining vertices, the faces, and the original rows of the vertices.
    """
    is_used = np.zeros(len(vertices), bool)
    is_used[faces] = True
    rows = np.flatnonzero(is_used)
    return vertices[rows], (np.cumsum(is_used) - 1)[faces].astype(np.int32), rows


def cross_products(vertices: FloatArray, faces: Int32Array) -> FloatArray:
    """Return normals (m, 3) of faces with a length of twice their area."""
    corners = vertices[faces]
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def vertex_normals(vertices: FloatArray, faces: Int32Array) -> FloatArray:
    """Return area-weighted unit normals (n, 3); zero if a vertex has no faces."""
    cross = cross_products(vertices, faces)
    total = np.empty_like(vertices)
    for axis in range(3):
        total[:, axis] = np.bincount(
            faces.ravel(), np.repeat(cross[:, axis], 3), minlength=len(vertices)
        )
    length = np.linalg.norm(total, axis=1, keepdims=True)
    unit = np.zeros_like(total)
    np.divide(total, length, out=unit, where=length > 0)
    return unit


def make_manifold(vertices: FloatArray, faces: Int32Array) -> tuple[FloatArray, Int32Array]:
    """Repair a mesh to a manifold.

    Degenerate and duplicate faces are removed, only the two largest faces of an edge are kept, and
    vertices at which sheets only touch are duplicated.
    """
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    faces = faces[faces[:, 2] != faces[:, 0]]
    faces = faces[np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])]
    while len(faces):
        areas = np.linalg.norm(cross_products(vertices, faces), axis=1)
        keys = edge_keys(faces).ravel()
        order = np.lexsort((-np.repeat(areas, 3), keys))
        sorted_keys = keys[order]
        first_rows = np.flatnonzero(np.r_[True, sorted_keys[1:] != sorted_keys[:-1]])
        ranks = np.arange(len(sorted_keys)) - np.repeat(
            first_rows, np.diff(np.r_[first_rows, len(sorted_keys)])
        )
        surplus_faces = np.unique(order[ranks >= 2] // 3)
        if not len(surplus_faces):
            break
        faces = np.delete(faces, surplus_faces, axis=0)
    return compact(*_split_vertices(vertices, faces))[:2]


def _split_vertices(vertices: FloatArray, faces: Int32Array) -> tuple[FloatArray, Int32Array]:
    """Duplicate vertices for groups of faces that do not share an edge at them."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    neighbour_faces = neighbours(faces)
    face, side = np.nonzero(neighbour_faces >= 0)
    other_face = neighbour_faces[face, side]
    ends = []
    for corner in (side, (side + 1) % 3):
        vertex = faces[face, corner]
        matching_corner = np.argmax(faces[other_face] == vertex[:, None], axis=1)
        ends.append((face * 3 + corner, other_face.astype(np.int64) * 3 + matching_corner))
    a = np.concatenate([e[0] for e in ends])
    b = np.concatenate([e[1] for e in ends])
    n = faces.size
    links = coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(n, n))
    count, fan = connected_components(links, directed=False)
    original_vertices = np.zeros(count, np.int64)
    original_vertices[fan] = faces.ravel()
    return vertices[original_vertices], fan.reshape(-1, 3).astype(np.int32)


def is_manifold(faces: Int32Array) -> bool:
    """Return whether all edges have at most two faces."""
    _, face_counts = np.unique(edge_keys(faces), return_counts=True)
    return bool(face_counts.max(initial=0) <= 2)
