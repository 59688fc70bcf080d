"""Subdivision of large triangles, so that all pieces of a surface are small enough."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.extraction.measurable_kernels import square_longest_sides
from vomstudio.geometry.kernels.jit import to_read_only_array
from vomstudio.geometry.patches import triangle_areas

MAX_FACES = 6_000_000
"""Maximum number of faces after the subdivision."""
_MAX_ROUNDS = 40
# Maximum area of a triangle with sides of up to 1 (equilateral).
_MAX_UNIT_AREA = np.sqrt(3.0) / 4.0


def subdivide_mesh(
    vertices: FloatArray, faces: IntArray, max_edge_length: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Subdivide a mesh until no edge exceeds a maximum length.

    An edge is halved in all of its faces, so that neighbouring faces remain connected.

    Parameters
    ----------
    vertices : (v, 3) array
    faces : (f, 3) int array
    max_edge_length : float
        Maximum length of an edge in the unit of the vertices.

    Returns
    -------
    vertices : (n, 3) array
    faces : (k, 3) int array
    source : (k,) int array
        Original face that each face belongs to.

    Raises
    ------
    GeometryError
        If the result would have too many faces.
    """
    squared_lengths = np.empty(len(faces))
    square_longest_sides(
        to_read_only_array(vertices, np.float64),
        to_read_only_array(faces, np.int64),
        squared_lengths,
    )
    has_long_face = np.zeros(len(vertices), np.bool_)
    has_long_face[faces[squared_lengths > max_edge_length**2].ravel()] = True
    # A face with a long edge contains at least two such vertices.
    is_candidate = has_long_face[faces].sum(axis=1) >= 2
    source = np.flatnonzero(is_candidate)
    finished_parts: list[tuple[IntArray, IntArray]] = [
        (faces[~is_candidate], np.flatnonzero(~is_candidate))
    ]
    faces = faces[is_candidate]
    area = float(triangle_areas(*(vertices[faces[:, k]] for k in range(3))).sum())
    if area > MAX_FACES * _MAX_UNIT_AREA * max_edge_length**2:
        # Fail early: detecting this by subdivision would take half a minute.
        raise GeometryError(Finding("faces.length-too-small"))
    for _ in range(_MAX_ROUNDS):
        ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
        # Sort the ends, so that the length of an edge is identical for both of its faces.
        low, high = ends.min(axis=2), ends.max(axis=2)
        length = np.linalg.norm(vertices[low] - vertices[high], axis=2)
        # Cut only the longest edge of a face, so that the pieces keep its shape (Rivara 1984). A
        # face is also cut at a shorter edge if this is the longest edge of its neighbour.
        is_long = (length >= length.max(axis=1, keepdims=True) * (1.0 - 1e-9)) & (
            length > max_edge_length
        )
        if not is_long.any():
            finished_parts.append((faces, source))
            break
        key = low * np.int64(len(vertices)) + high
        cut_edges = np.unique(key[is_long])
        cut_rows = np.searchsorted(cut_edges, key)
        cut_rows[cut_rows == len(cut_edges)] = 0
        is_cut = cut_edges[cut_rows] == key
        # A face without a cut edge will only be cut later if it is itself too large: every edge cut
        # later is longer than `longest`.
        is_active = (length > max_edge_length).any(axis=1) | is_cut.any(axis=1)
        finished_parts.append((faces[~is_active], source[~is_active]))
        faces, source, cut_rows, is_cut = (
            faces[is_active],
            source[is_active],
            cut_rows[is_active],
            is_cut[is_active],
        )
        midpoints = np.where(is_cut, cut_rows + len(vertices), -1)
        vertices = np.concatenate(
            [
                vertices,
                0.5 * (vertices[cut_edges // len(vertices)] + vertices[cut_edges % len(vertices)]),
            ]
        )
        faces, source = _split_faces(faces, midpoints, source)
        if len(faces) + sum(len(part) for part, _ in finished_parts) > MAX_FACES:
            raise GeometryError(Finding("faces.length-too-small"))
    return (
        vertices,
        np.concatenate([part for part, _ in finished_parts]),
        np.concatenate([part_source for _, part_source in finished_parts]),
    )


def _split_faces(
    faces: IntArray, midpoints: IntArray, source: IntArray
) -> tuple[IntArray, IntArray]:
    """Split faces at the midpoints (k, 3) of their edges into up to four faces each.

    An edge with the midpoint -1 is not divided.
    """
    count = (midpoints >= 0).sum(axis=1)
    new_faces, new_source = [faces[count == 0]], [source[count == 0]]
    for corner in range(3):
        # Indices of the corners and midpoints of a face, starting from the current corner.
        a, b, c = (faces[:, (corner + k) % 3] for k in range(3))
        ab, bc, ca = (midpoints[:, (corner + k) % 3] for k in range(3))
        has_one_cut = (count == 1) & (ab >= 0)
        has_two_cuts = (count == 2) & (ca < 0)
        has_three_cuts = (count == 3) & (corner == 0)
        for rows, parts in (
            (has_one_cut, ((a, ab, c), (ab, b, c))),
            (has_two_cuts, ((a, ab, c), (ab, b, bc), (ab, bc, c))),
            (has_three_cuts, ((a, ab, ca), (ab, b, bc), (bc, c, ca), (ab, bc, ca))),
        ):
            for part in parts:
                new_faces.append(np.stack([node[rows] for node in part], axis=1))
                new_source.append(source[rows])
    return np.concatenate(new_faces), np.concatenate(new_source)
