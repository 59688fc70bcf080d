"""Decimation of meshes that are much finer than required, by vertex clustering."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.extraction.measurable_kernels import accumulate_areas, cluster_vertices
from vomstudio.geometry.kernels.jit import to_read_only_array


@dataclass(frozen=True, eq=False)
class ThinnedMesh:
    """Decimated mesh and its relation to the original mesh.

    Parameters
    ----------
    vertices : (n, 3) array
    nodes : (vertices of the input,) int array
        New vertex that replaces each original vertex.
    faces : (k, 3) int array
    rows : (k,) int array
        Original face from which each face is derived.
    areas : (k,) array
        Area of the original mesh that each face represents.
    """

    vertices: FloatArray
    nodes: IntArray
    faces: IntArray
    rows: IntArray
    areas: FloatArray


def thin_mesh(vertices: FloatArray, faces: IntArray, cell_size: float) -> ThinnedMesh:
    """Merge vertices that lie in the same cube and are connected by edges within it.

    Each cluster is replaced by its mean (after Rossignac & Borrel 1993, but only for connected
    vertices). Faces with fewer than three remaining vertices are removed, and their area is
    distributed to the surrounding faces. A component smaller than a cube, which would lose all its
    faces, remains unchanged.

    Parameters
    ----------
    vertices : (v, 3) array
    faces : (f, 3) int array
    cell_size : float
        Side length of the cubes, in the unit of the vertices.

    Returns
    -------
    ThinnedMesh
    """
    corner = vertices.min(axis=0)
    cells = ((vertices - corner) / cell_size).astype(np.int32)
    faces = to_read_only_array(faces, np.int64)
    root = np.empty(len(vertices), np.int64)
    cluster_vertices(cells, faces, root)
    clustered_faces = root[faces]
    is_kept = _has_distinct_corners(clustered_faces)
    has_face = np.zeros(len(vertices), np.bool_)
    has_face[clustered_faces[is_kept].ravel()] = True
    lost_rows = np.flatnonzero(~has_face[root])
    if len(lost_rows):
        root[lost_rows] = lost_rows
        clustered_faces = root[faces]
        is_kept = _has_distinct_corners(clustered_faces)
        _merge_isolated_vertices(lost_rows, clustered_faces[is_kept], faces, root)
    number = np.cumsum(root == np.arange(len(root))) - 1
    nodes = number[root]
    count = np.bincount(nodes)
    centres = np.stack([np.bincount(nodes, vertices[:, k]) / count for k in range(3)], axis=1)
    rows = np.flatnonzero(is_kept)
    new_faces = nodes[faces[rows]]
    # Each corner of a face receives a third of the area of the face.
    old_area = np.zeros(len(count))
    area = np.empty(len(faces))
    accumulate_areas(to_read_only_array(vertices, np.float64), faces, nodes, area, old_area)
    face_area = np.empty(len(new_faces))
    new_area = np.zeros(len(count))
    accumulate_areas(
        centres, to_read_only_array(new_faces, np.int64), np.arange(len(count)), face_area, new_area
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.where(new_area > 0.0, old_area / new_area, 0.0)
    return ThinnedMesh(centres, nodes, new_faces, rows, face_area * scale[new_faces].mean(axis=1))


def _merge_isolated_vertices(
    lost_rows: IntArray, remaining_faces: IntArray, faces: IntArray, root: IntArray
) -> None:
    """Merge vertices without a face, such as the tips of a rim, into a neighbouring vertex."""
    is_isolated = np.zeros(len(root), np.bool_)
    is_isolated[lost_rows] = True
    is_isolated[remaining_faces.ravel()] = False
    neighbour_faces = faces[is_isolated[faces].any(axis=1)]
    for first_corner, second_corner in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        a, b = neighbour_faces[:, first_corner], neighbour_faces[:, second_corner]
        is_joined = is_isolated[a] & ~is_isolated[b]
        root[a[is_joined]] = root[b[is_joined]]


def _has_distinct_corners(faces: IntArray) -> BoolArray:
    """Return for each face (k, 3) whether it has three distinct corners."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))
