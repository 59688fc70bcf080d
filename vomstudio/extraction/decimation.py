"""Meshes far finer than what is asked of them, thinned by clusters of their vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.extraction.measurable_kernels import areas_of, clustered
from vomstudio.geometry.kernels.jit import for_reading


@dataclass(frozen=True, eq=False)
class Thinner:
    """vertices : (n, 3); nodes : (vertices that were,) the vertex that stands for each of them
    faces : (k, 3); rows : (k,) the face that each was; areas : (k,) that it stands for
    """

    vertices: FloatArray
    nodes: IntArray
    faces: IntArray
    rows: IntArray
    areas: FloatArray


def thinner(vertices: FloatArray, faces: IntArray, cell: float) -> Thinner:
    """Vertices in one cube with sides of `cell` that hang together along edges within it are put
    together at their mean (Rossignac & Borrel 1993, but for what only lies close by), and faces
    with less than three of them go. Their area goes to the faces around.

    What would have no face left, as a piece smaller than a cube, stays as it is.
    """
    corner = vertices.min(axis=0)
    cells = ((vertices - corner) / cell).astype(np.int32)
    faces = for_reading(faces, np.int64)
    root = np.empty(len(vertices), np.int64)
    clustered(cells, faces, root)
    own = root[faces]
    left = _three(own)
    shown = np.zeros(len(vertices), np.bool_)
    shown[own[left].ravel()] = True
    lost = np.flatnonzero(~shown[root])
    if len(lost):
        root[lost] = lost
        own = root[faces]
        left = _three(own)
        _beside(lost, own[left], faces, root)
    number = np.cumsum(root == np.arange(len(root))) - 1
    nodes = number[root]
    count = np.bincount(nodes)
    middle = np.stack([np.bincount(nodes, vertices[:, k]) / count for k in range(3)], axis=1)
    rows = np.flatnonzero(left)
    fewer = nodes[faces[rows]]
    # A third of each face is of each corner.
    there = np.zeros(len(count))
    area = np.empty(len(faces))
    areas_of(for_reading(vertices, np.float64), faces, nodes, area, there)
    kept = np.empty(len(fewer))
    shows = np.zeros(len(count))
    areas_of(middle, for_reading(fewer, np.int64), np.arange(len(count)), kept, shows)
    with np.errstate(invalid="ignore", divide="ignore"):
        more = np.where(shows > 0.0, there / shows, 0.0)
    return Thinner(middle, nodes, fewer, rows, kept * more[fewer].mean(axis=1))


def _beside(lost: IntArray, left: IntArray, faces: IntArray, root: IntArray) -> None:
    """Those that still have no face, as the tips of a rim, go to the vertex beside them."""
    bare = np.zeros(len(root), np.bool_)
    bare[lost] = True
    bare[left.ravel()] = False
    around = faces[bare[faces].any(axis=1)]
    for one, other in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        a, b = around[:, one], around[:, other]
        joins = bare[a] & ~bare[b]
        root[a[joins]] = root[b[joins]]


def _three(faces: IntArray) -> BoolArray:
    """Which faces (k, 3) have three corners."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))
