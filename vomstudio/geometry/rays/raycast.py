"""Parallel rays through the pixels of a grid, independent of the window.

Each triangle is tested against the rays rather than each ray against triangles, in float64 and
without a tree: the same hits as Embree (float32), about ten times faster.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array


@dataclass(frozen=True, eq=False)
class GridHits:
    """First hits of parallel rays, arrays with the same leading shape.

    Attributes
    ----------
    face : ndarray of int32
        Row of the triangle, or -1 for a miss.
    depth : ndarray
        z of the hit, or infinity for a miss.
    weights : (..., 2) ndarray
        Barycentric weights of the second and third vertex.
    """

    face: Int32Array
    depth: FloatArray
    weights: FloatArray

    @classmethod
    def empty(cls, *shape: int) -> GridHits:
        return cls(np.full(shape, -1, np.int32), np.full(shape, np.inf), np.zeros((*shape, 2)))


def cast_grid(
    points: FloatArray,
    faces: Int32Array,
    selected_faces: Int32Array,
    *,
    left: float,
    top: float,
    step: float,
    width: int,
    height: int,
) -> GridHits:
    """Cast rays along +z through the centres of a grid's pixels.

    Column i is at x = left + (i + 0.5) step, row j at y = top + (j + 0.5) step. Edge-on faces are
    never hit.

    Parameters
    ----------
    points : (n, 3) ndarray
        C-contiguous.
    faces : (m, 3) ndarray of int32
        C-contiguous.
    selected_faces : (k,) ndarray of int32
        Faces to test.
    left, top, step : float
    width, height : int

    Returns
    -------
    GridHits
        Hits with the shape (height, width).
    """
    from vomstudio.geometry.kernels.raycast import find_grid_hits

    hits = GridHits.empty(height, width)
    find_grid_hits(
        points, faces, selected_faces, left, top, step, hits.face, hits.depth, hits.weights
    )
    return hits


def cast_quarters(
    points: FloatArray,
    faces: Int32Array,
    selected_triangles: Int32Array,
    is_requested: BoolArray,
    *,
    left: float,
    top: float,
    step: float,
) -> GridHits:
    """Cast four rays per requested pixel of a grid, through the centres of its quarters.

    Parameters
    ----------
    points : (n, 3) ndarray
    faces : (k, 3) ndarray of int32
    selected_triangles : (m,) ndarray of int32
        Rows of the faces to hit.
    is_requested : (height, width) ndarray of bool
    left, top : float
        Coordinates of the grid's corner.
    step : float
        Size of a pixel.

    Returns
    -------
    GridHits
        Arrays with one row of four rays for each requested pixel, in row order of `is_requested`.
    """
    from vomstudio.geometry.kernels.raycast import find_quarter_hits

    slot = np.full(is_requested.shape, -1, np.int32)
    n = int(is_requested.sum())
    slot[is_requested] = np.arange(n)
    hits = GridHits.empty(n, 4)
    find_quarter_hits(
        points,
        faces,
        selected_triangles,
        left,
        top,
        step,
        slot,
        hits.face,
        hits.depth,
        hits.weights,
    )
    return hits
