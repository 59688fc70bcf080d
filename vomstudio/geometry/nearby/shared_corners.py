"""Shared vertices of faces, with coincident vertices and equal faces merged.

Adjacent free sides, such as at the seam of two tiles, are treated as one side.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.coincident_points import position_keys, weld_points

# Minimum share of free sides at which nearly coincident vertices are snapped.
MIN_FREE_SIDE_SHARE = 0.4
WELD_SHARE = 4e-3
"""Tolerance of coincident vertices relative to the median side length."""
MIN_CORNERS_PER_FACE = 1.5
"""Connected faces have about one vertex for every two faces."""
MAX_FREE_SIDE_SHARE, MIN_FACES = 0.7, 20
MAX_GAP_RATIO, MAX_CANDIDATES, MAX_NEIGHBOURS = 0.75, 9, 2
"""Own choice: maximum gap relative to both sides, and numbers of candidates and neighbours."""


def snap_corners(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Snap vertices whose distance is much smaller than the length of a side.

    Vertices are snapped only if few faces share a side, for example because each face has its own
    rounded or transformed vertices. Otherwise the positions are returned unchanged.

    Parameters
    ----------
    positions : (n, 3) ndarray
        Finite at the vertices of faces.
    faces : (k, 3) ndarray of int

    Returns
    -------
    (n, 3) ndarray
    """
    nodes = weld_points(positions)[faces]
    if not len(faces) or int(nodes.max()) < MIN_CORNERS_PER_FACE * len(faces):
        return positions
    free_side_share = _free_side_share(nodes)
    lengths = np.linalg.norm(positions[faces] - positions[np.roll(faces, 1, axis=1)], axis=2)
    if free_side_share < MIN_FREE_SIDE_SHARE or not (lengths > 0.0).any():
        return positions
    tolerance = WELD_SHARE * float(np.median(lengths[lengths > 0.0]))
    used_corners = np.unique(faces)
    point_ids = _weld_within(positions[used_corners], tolerance)
    first_corner = np.full(int(point_ids.max()) + 1, -1, np.int64)
    first_corner[point_ids[::-1]] = used_corners[::-1]
    result = positions.copy()
    result[used_corners] = positions[first_corner[point_ids]]
    # No gain if the faces are really separate.
    return (
        result
        if _free_side_share(weld_points(result)[faces]) < 0.9 * free_side_share
        else positions
    )


def neighbours_across_gaps(
    nodes: IntArray, corners: FloatArray, is_free_side: BoolArray | None = None
) -> tuple[IntArray, IntArray, IntArray]:
    """Find faces with adjacent free sides.

    Two sides are neighbours if their centres are closer than 0.75 times the sum of their lengths,
    even if tiles overlap, were cut or rounded, or differ in resolution there; a side has at most
    two neighbours. The results are empty if most faces are separate, unless `is_free_side` is
    given.

    Parameters
    ----------
    nodes : (k, 3) ndarray of int
        Numbers of the vertices.
    corners : (k, 3, 3) ndarray
    is_free_side : (k, 3) ndarray of bool, optional
        Sides that belong to a single face; required if `nodes` does not contain all faces.

    Returns
    -------
    faces, sides, neighbours : ndarray of int
        Row of a face, number of its free side (0 to 2), and row of the neighbouring face.
    """
    from scipy.spatial import cKDTree

    no_rows = np.zeros(0, np.int64)
    free_sides = np.flatnonzero(
        _is_free_side(nodes) if is_free_side is None else is_free_side.ravel()
    )
    if len(free_sides) < 2 or (
        is_free_side is None
        and len(nodes) >= MIN_FACES
        and len(free_sides) > MAX_FREE_SIDE_SHARE * nodes.size
    ):
        return no_rows, no_rows, no_rows
    face, side = free_sides // 3, free_sides % 3
    start, end = corners[face, side], corners[face, (side + 1) % 3]
    length = np.linalg.norm(end - start, axis=1)
    centre = (start + end) / 2.0
    count = min(MAX_CANDIDATES, len(free_sides))
    distances, neighbour_rows = cKDTree(centre).query(centre, k=count)
    is_neighbour = distances <= MAX_GAP_RATIO * (length[:, None] + length[neighbour_rows])
    a, b = nodes[face, side], nodes[face, (side + 1) % 3]
    for first_end in (a, b):
        for second_end in (a, b):
            # Consecutive sides of one border are not neighbours.
            is_neighbour &= first_end[:, None] != second_end[neighbour_rows]
    is_neighbour &= face[:, None] != face[neighbour_rows]
    is_neighbour &= np.cumsum(is_neighbour, axis=1) <= MAX_NEIGHBOURS
    row, column = np.nonzero(is_neighbour)
    return face[row], side[row], face[neighbour_rows[row, column]]


def check_connected(nodes: IntArray, warnings: list[Finding]) -> None:
    """Append a warning if most sides of a mesh belong to a single face.

    Meshes with very few faces are not checked.

    Parameters
    ----------
    nodes : (k, 3) int array
        Numbers of the corners of each face.
    warnings : list of Finding
    """
    if len(nodes) < MIN_FACES or int(nodes.max()) < MIN_CORNERS_PER_FACE * len(nodes):
        return
    free_side_share = _free_side_share(nodes)
    if free_side_share > MAX_FREE_SIDE_SHARE:
        warnings.append(Finding("mesh.faces-apart", share_percent=100.0 * free_side_share))


def first_faces(nodes: IntArray, warnings: list[Finding]) -> BoolArray:
    """Return which faces are the first of all faces with the same three corners.

    The orientation of the faces is ignored. A warning is appended if faces are duplicated.

    Parameters
    ----------
    nodes : (k, 3) int array
        Numbers of the corners of each face.
    warnings : list of Finding

    Returns
    -------
    (k,) bool array
    """
    keys = position_keys(np.sort(nodes, axis=1).astype(np.float64))
    order = np.argsort(keys, kind="stable")
    is_repeated = np.zeros(len(nodes), np.bool_)
    # The sort is stable, so the first of equal faces remains the first.
    is_repeated[order[1:]] = np.diff(keys[order]) == 0
    if is_repeated.any():
        warnings.append(
            Finding("mesh.faces-doubled", share_percent=max(100.0 * float(is_repeated.mean()), 1.0))
        )
    return ~is_repeated


def _free_side_share(nodes: IntArray) -> float:
    """Return the share of sides that belong to one face only."""
    return float(_is_free_side(nodes).mean())


def _is_free_side(nodes: IntArray) -> BoolArray:
    """Return which sides (3 k,) of faces (k, 3) belong to one face only."""
    key = _side_keys(nodes)
    order = np.argsort(key, kind="stable")
    is_same = np.diff(key[order]) == 0
    is_free = np.empty(len(key), np.bool_)
    is_free[order] = ~(np.append(is_same, False) | np.append(False, is_same))
    return is_free


def _side_keys(nodes: IntArray) -> IntArray:
    """Return an integer key for each edge of faces (k, 3); edges with equal ends share it."""
    a = nodes.ravel()
    b = np.roll(nodes, -1, axis=1).ravel()
    return np.asarray(np.minimum(a, b) * (int(nodes.max()) + 1) + np.maximum(a, b))


def _weld_within(positions: FloatArray, tolerance: float) -> IntArray:
    """Return equal numbers for positions (n, 3) that are much closer than the tolerance.

    Such positions share a cell in at least one of four grids, whose cell size is the tolerance and
    which are shifted by a quarter cell each.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(positions)
    rows, columns, count = [], [], n
    for shift in range(4):
        cells = np.floor(positions / tolerance + 0.25 * shift)
        cell_ids = weld_points(cells)
        rows.append(np.arange(n))
        columns.append(count + cell_ids)
        count += int(cell_ids.max()) + 1
    source, target = np.concatenate(rows), np.concatenate(columns)
    graph = coo_matrix((np.ones(len(source), np.int8), (source, target)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1][:n], np.int64)
