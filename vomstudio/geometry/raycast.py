"""The only ray caster outside the window.

Any rays: `RayCaster`, which is Embree with the digits put back. Embree works in float32: 0.03 mm at
500 m from the origin, 6 cm at a UTM northing. So the triangles are taken relative to the centre of
their bounds, rays are started just outside those bounds, and once the triangle that a ray meets is
known the point on it is computed anew in float64. What stays float32 is which triangle is met,
within some 1e-7 of the size of the whole: cast large models in tiles. `embreex` is imported when
the first caster is made.

Parallel rays through a grid: `cast_grid` and `cast_quarters`. They ask each triangle which rays
meet it instead of each ray which triangle, all in float64, with no tree to build: the same hits,
some ten times sooner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Hits:
    """What n rays met first.

    face : (n,) int32 row of the triangle, -1 where nothing was met
    distance : (n,) float64 metres from the ray's start, infinite where nothing was met
    weights : (n, 2) float64 barycentric weights of the second and third corner; the first corner's
        is 1 minus both
    """

    face: npt.NDArray[np.int32]
    distance: Array
    weights: Array


class RayCaster:
    """Triangles that rays can be cast at. May be used from several threads at once."""

    def __init__(self, corners: npt.ArrayLike) -> None:
        """corners : (m, 3, 3) float64, the three corners of each triangle, m >= 1."""
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        from vomstudio.geometry import _raycast_kernels  # noqa: F401 - compiled before first use

        self._corners = np.ascontiguousarray(corners, np.float64).reshape(-1, 3, 3)
        if not len(self._corners):
            raise GeometryError("There are no triangles to cast rays at.")
        low = self._corners.min(axis=(0, 1))
        high = self._corners.max(axis=(0, 1))
        self._origin = low + (high - low) / 2
        self._radius = float(np.linalg.norm(high - low)) / 2 * (1 + 1e-5) + 1e-30
        if not np.isfinite(self._radius):
            raise GeometryError("The triangles have corners that are not finite numbers.")
        # Robust: a ray through the edge between two triangles meets one of them.
        self._scene = EmbreeScene(robust=True)
        TriangleMesh(self._scene, (self._corners - self._origin).astype(np.float32))
        # The first ray of a scene builds its tree; later ones may then come from any thread.
        self.cast(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))

    def cast(self, starts: npt.ArrayLike, directions: npt.ArrayLike) -> Hits:
        """The first triangle that each ray meets, front or back.

        starts : (n, 3) float64. directions : (n, 3), or (1, 3) or (3,) for all rays; of any length
        but zero.
        """
        from vomstudio.geometry._raycast_kernels import exact_hits, float32_rays

        s = np.ascontiguousarray(starts, np.float64).reshape(-1, 3)
        d = np.ascontiguousarray(directions, np.float64).reshape(-1, 3)
        n = len(s)
        if len(d) not in (1, n):
            raise ValueError("as many directions as starts, or one for all")
        near = np.empty((n, 3), np.float32)
        along = np.empty((n, 3), np.float32)
        float32_rays(s, d, self._origin, self._radius, near, along)
        met = self._scene.run(near, along, query="INTERSECT", output=True)
        distance = np.empty(n)
        weights = np.stack([met["u"], met["v"]], axis=1).astype(np.float64)
        face = np.asarray(met["primID"], np.int32)
        exact_hits(s, d, self._corners, face, weights, distance)
        return Hits(face, distance, weights)


@dataclass(frozen=True, eq=False)
class GridHits:
    """What parallel rays met first, arrays of the same leading shape.

    face : int32 row of the triangle, -1 where nothing was met
    depth : float64, z of the point, infinite where nothing was met
    weights : (..., 2) float64 barycentric weights of the second and third corner
    """

    face: npt.NDArray[np.int32]
    depth: Array
    weights: Array

    @classmethod
    def none(cls, *shape: int) -> GridHits:
        return cls(np.full(shape, -1, np.int32), np.full(shape, np.inf), np.zeros((*shape, 2)))


def cast_grid(
    points: Array,
    faces: npt.NDArray[np.int32],
    chosen: npt.NDArray[np.int32],
    *,
    left: float,
    top: float,
    step: float,
    width: int,
    height: int,
) -> GridHits:
    """Rays along +z through the centres of a grid's pixels, column i at x = left + (i + 0.5) step,
    row j at y = top + (j + 0.5) step; results (height, width).

    points (n, 3), faces (m, 3), both C-contiguous; chosen (k,) the faces to be asked. A face that
    is seen edge-on is never met.
    """
    from vomstudio.geometry._raycast_kernels import grid_hits

    hits = GridHits.none(height, width)
    grid_hits(points, faces, chosen, left, top, step, hits.face, hits.depth, hits.weights)
    return hits


def cast_quarters(
    points: Array,
    faces: npt.NDArray[np.int32],
    chosen: npt.NDArray[np.int32],
    wanted: npt.NDArray[np.bool_],
    *,
    left: float,
    top: float,
    step: float,
) -> GridHits:
    """Four rays, through the middles of the quarters, in each of the n pixels of the grid that is
    `wanted` (height, width); results (n, 4), row by row."""
    from vomstudio.geometry._raycast_kernels import quarter_hits

    slot = np.full(wanted.shape, -1, np.int32)
    n = int(wanted.sum())
    slot[wanted] = np.arange(n)
    hits = GridHits.none(n, 4)
    quarter_hits(points, faces, chosen, left, top, step, slot, hits.face, hits.depth, hits.weights)
    return hits
