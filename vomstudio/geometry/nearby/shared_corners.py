"""What a mesh's faces share: corners at one place are one corner, faces on the same corners are one
piece of surface, and free sides beside each other, as at the seam of two tiles, are one side."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.coincident_points import place_keys, welded

# Of the faces' sides: with more that are of one face only the corners may be beside each other.
_LOOSE = 0.4
_NEAR = 4e-3
"""Of a usual side: the cells in which corners are at one place."""
_MANY = 1.5
"""For each face; where faces share corners there is one for two of them."""
_APART, _FEW = 0.7, 20
_WITHIN, _LOOKED_AT, _BESIDE = 0.75, 9, 2
"""Ours: a gap is no more than so many times the two sides; so many are looked at and taken."""


def snapped(places: FloatArray, faces: IntArray) -> FloatArray:
    """The places (n, 3), finite where faces (k, 3) have corners, with those moved together that are
    much nearer to each other than a side is long. Only where hardly any faces share a side, as when
    each has corners of its own that were rounded or transformed apart; else as they are."""
    nodes = welded(places)[faces]
    if not len(faces) or int(nodes.max()) < _MANY * len(faces):
        return places
    loose = _loose(nodes)
    lengths = np.linalg.norm(places[faces] - places[np.roll(faces, 1, axis=1)], axis=2)
    if loose < _LOOSE or not (lengths > 0.0).any():
        return places
    near = _NEAR * float(np.median(lengths[lengths > 0.0]))
    used = np.unique(faces)
    number = _nearly_welded(places[used], near)
    first = np.full(int(number.max()) + 1, -1, np.int64)
    first[number[::-1]] = used[::-1]
    result = places.copy()
    result[used] = places[first[number]]
    # Nothing is gained where the faces are apart in truth.
    return result if _loose(welded(result)[faces]) < 0.9 * loose else places


def across_gaps(
    nodes: IntArray, corners: FloatArray, alone: BoolArray | None = None
) -> tuple[IntArray, IntArray, IntArray]:
    """Faces, their sides (0 to 2) that are of one face only, and the faces that have such a side
    beside that one: what is nearer than a side is long is as near as neighbours are, whether tiles
    were cut there, rounded apart, overlap, or are not as fine as each other. nodes : (k, 3) numbers
    of corners (k, 3, 3); alone : (k, 3) which sides are of one face, where these are not all faces.
    Nothing where most faces are apart."""
    from scipy.spatial import cKDTree

    none = np.zeros(0, np.int64)
    free = np.flatnonzero(_alone(nodes) if alone is None else alone.ravel())
    if len(free) < 2 or (alone is None and len(nodes) >= _FEW and len(free) > _APART * nodes.size):
        return none, none, none
    face, side = free // 3, free % 3
    begin, end = corners[face, side], corners[face, (side + 1) % 3]
    length = np.linalg.norm(end - begin, axis=1)
    middle = (begin + end) / 2.0
    count = min(_LOOKED_AT, len(free))
    apart, other = cKDTree(middle).query(middle, k=count)
    beside = apart <= _WITHIN * (length[:, None] + length[other])
    a, b = nodes[face, side], nodes[face, (side + 1) % 3]
    for one in (a, b):
        for two in (a, b):
            # Sides of one border follow each other.
            beside &= one[:, None] != two[other]
    beside &= face[:, None] != face[other]
    beside &= np.cumsum(beside, axis=1) <= _BESIDE
    row, column = np.nonzero(beside)
    return face[row], side[row], face[other[row, column]]


def check_connected(nodes: IntArray, warnings: list[Finding]) -> None:
    """Append a warning if most faces share no side with another.

    Parameters
    ----------
    nodes : (k, 3) int array
        Numbers of the corners of each face.
    warnings : list of Finding
    """
    if len(nodes) < _FEW or int(nodes.max()) < _MANY * len(nodes):
        return
    loose = _loose(nodes)
    if loose > _APART:
        warnings.append(Finding("mesh.faces-apart", share_percent=100.0 * loose))


def first_faces(nodes: IntArray, warnings: list[Finding]) -> BoolArray:
    """Return which faces are the first on their three corners, in either orientation.

    A warning is appended if faces are doubled.

    Parameters
    ----------
    nodes : (k, 3) int array
        Numbers of the corners of each face.
    warnings : list of Finding

    Returns
    -------
    (k,) bool array
    """
    keys = place_keys(np.sort(nodes, axis=1).astype(np.float64))
    order = np.argsort(keys, kind="stable")
    again = np.zeros(len(nodes), np.bool_)
    # The sort is stable: the first of those that are alike comes first.
    again[order[1:]] = np.diff(keys[order]) == 0
    if again.any():
        warnings.append(
            Finding("mesh.faces-doubled", share_percent=max(100.0 * float(again.mean()), 1.0))
        )
    return ~again


def _loose(nodes: IntArray) -> float:
    """Of the sides of faces, the share that is of one face only."""
    return float(_alone(nodes).mean())


def _alone(nodes: IntArray) -> BoolArray:
    """(3 k,) which sides of faces (k, 3) are of one face only."""
    key = _side_keys(nodes)
    order = np.argsort(key, kind="stable")
    same = np.diff(key[order]) == 0
    alone = np.empty(len(key), np.bool_)
    alone[order] = ~(np.append(same, False) | np.append(False, same))
    return alone


def _side_keys(nodes: IntArray) -> IntArray:
    """A number for each side of faces (k, 3), one after the other, the same for the same ends."""
    a = nodes.ravel()
    b = np.roll(nodes, -1, axis=1).ravel()
    return np.asarray(np.minimum(a, b) * (int(nodes.max()) + 1) + np.maximum(a, b))


def _nearly_welded(places: FloatArray, near: float) -> IntArray:
    """Of places (n, 3) the number that those much nearer than `near` have in common: which are in
    one cell of that side in one of four grids, each shifted by a quarter."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(places)
    rows, columns, count = [], [], n
    for part in range(4):
        cells = np.floor(places / near + 0.25 * part)
        which = welded(cells)
        rows.append(np.arange(n))
        columns.append(count + which)
        count += int(which.max()) + 1
    source, target = np.concatenate(rows), np.concatenate(columns)
    graph = coo_matrix((np.ones(len(source), np.int8), (source, target)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1][:n], np.int64)
