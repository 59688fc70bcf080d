"""What a measurement asks of the model it was made on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.plane_sizes import within_wander
from vomstudio.geometry.resolution import resolution_by

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


# Enough points for a mean spacing and for the plane of a face, few enough for every click.
_SAMPLES = 24
_COARSE = 200_000
_FACE_POINTS = 20_000
# The face is the outcrop's on a scale larger than the trace, not the ledge that it runs along.
_FACE_EXTENTS = 3.0
# The face of the rock on which a line lies: as many vertices beside each of its points, and within
# 15 degrees of its plane.
_BESIDE = 12
_IN_ONE_FACE = float(np.cos(np.radians(15.0)))
_NORMAL_POINTS = 64
_STEP = 1_000_000


class Surface(Protocol):
    """All in the model's file frame."""

    def resolution_near(self, points: FloatArray) -> float | None:
        """Effective resolution of the model around `points` (k, 3): the larger of the mean spacing
        of its vertices or points and of their noise, see `geometry.resolution`."""

    def outcrop_normal(self, points: FloatArray) -> FloatArray | None:
        """Unit normal (3,) of the outcrop face around the line through `points` (k, 3), on a scale
        of several times its extent; of a line that lies in one face of the rock and is no wider
        there than points stray, of that face."""


class VertexSurface:
    """A surface known by its vertices, mesh or cloud.

    `build` makes the search tree and may run in any thread; until it is done the answers come from
    a plain search and are the same.
    """

    def __init__(
        self,
        vertices: FloatArray,
        undivided: FloatArray | Callable[[], FloatArray] | None = None,
    ) -> None:
        """vertices : (n, 3) float64; kept, not copied. undivided : vertices that count for the
        resolution, see `geometry.subdivision`, or what finds them; None for these."""
        self._vertices = vertices
        self._undivided = undivided
        self._tree: cKDTree | None = None
        self._coarse_tree: cKDTree | None = None
        self._lock = threading.Lock()
        self._coarse = vertices[:: max(1, len(vertices) // _COARSE)]

    def build(self) -> None:
        from scipy.spatial import cKDTree

        with self._lock:
            if self._tree is None:
                self._tree = cKDTree(
                    np.asarray(self._vertices),
                    leafsize=32,
                    compact_nodes=False,
                    balanced_tree=False,
                )
                self._coarse_tree = cKDTree(np.asarray(self._coarse))
        if self._resolving is not self:
            self._resolving.build()

    @property
    def extent(self) -> float:
        """Length of the diagonal of the box around it."""
        return float(np.linalg.norm(np.ptp(self._coarse, axis=0)))

    @cached_property
    def _resolving(self) -> VertexSurface:
        """With the vertices that count for the resolution."""
        own = self._undivided() if callable(self._undivided) else self._undivided
        return self if own is None or own is self._vertices else VertexSurface(own)

    def resolution_near(self, points: FloatArray) -> float | None:
        if self._resolving is not self:
            return self._resolving.resolution_near(points)
        places = [self._nearest(point, 1)[0] for point in _sample(points, _SAMPLES)]

        def neighbours(count: int) -> FloatArray | None:
            # All at once: a single 3 x 3 matrix takes as long as all of them.
            near = [self._nearest(place, count) for place in places]
            return np.stack(near) if near else None

        return resolution_by(neighbours)

    def outcrop_normal(self, points: FloatArray) -> FloatArray | None:
        line = _densified(points)
        extent = float(np.linalg.norm(np.ptp(line, axis=0)))
        resolution = self.resolution_near(points) or 0.0
        own = _plane_within_wander(points, resolution)
        if own is not None:
            beside = [self._nearest(place, _BESIDE) for place in _sample(line, _SAMPLES)]
            face = _face_of(line, np.unique(np.concatenate(beside), axis=0), 2.0 * resolution)
            if face is not None and abs(float(face @ own)) > _IN_ONE_FACE:
                return face
        radius = max(_FACE_EXTENTS * extent, 10.0 * resolution)
        near = self._near_box(line.min(axis=0) - radius, line.max(axis=0) + radius)
        return _face_of(line, near[:: max(1, len(near) // _FACE_POINTS)], radius)

    def _near_box(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Vertices (k, 3) in a box: enough to tell how the surface lies there."""
        inside = np.all((self._coarse >= low) & (self._coarse <= high), axis=1)
        return np.asarray(self._coarse[inside])

    def _in_ball(self, centre: FloatArray, radius: float) -> IntArray:
        """Ids of the vertices in a ball, in no order."""
        if self._tree is not None:
            found = self._tree.query_ball_point(centre, radius, return_sorted=False)
            return np.asarray(found, dtype=np.int64)
        hits = []
        for start in range(0, len(self._vertices), _STEP):
            part = np.asarray(self._vertices[start : start + _STEP])
            near = np.flatnonzero(np.abs(part[:, 0] - centre[0]) <= radius)
            off = part[near] - centre
            hits.append(start + near[np.einsum("ij,ij->i", off, off) <= radius**2])
        return np.concatenate(hits)

    def _normal(self, centre: FloatArray, radius: float) -> FloatArray | None:
        """Unit normal of the vertices in a ball; None where they are too few, or it would take
        long to find them."""
        if self._tree is None or self._coarse_tree is None:
            return None
        near = self._coarse[self._coarse_tree.query_ball_point(centre, radius)]
        if len(near) < _NORMAL_POINTS:
            distance, index = self._tree.query(
                centre, k=min(_NORMAL_POINTS, len(self._vertices)), distance_upper_bound=radius
            )
            near = self._vertices[np.atleast_1d(index)[np.isfinite(np.atleast_1d(distance))]]
        if len(near) < 3:
            return None
        centred = near - near.mean(axis=0)
        values, vectors = np.linalg.eigh(centred.T @ centred)
        return np.asarray(vectors[:, 0]) if values[1] > 1e-12 * values[2] else None

    def _nearest(self, point: FloatArray, count: int) -> FloatArray:
        count = min(count, len(self._vertices))
        if self._tree is not None:
            _, index = self._tree.query(point, k=count)
            return np.asarray(self._vertices[np.atleast_1d(index)])
        square = ((np.asarray(self._vertices) - point) ** 2).sum(axis=1)
        index = np.argpartition(square, count - 1)[:count]
        return np.asarray(self._vertices[index[np.argsort(square[index])]])


def _face_of(line: FloatArray, near: FloatArray, radius: float) -> FloatArray | None:
    """Unit normal (3,) of those of the vertices (k, 3) that are within a radius of the points of a
    line; None where they are no face."""
    from scipy.spatial import cKDTree

    if len(near) < 3:
        return None
    distance, _ = cKDTree(line).query(near, distance_upper_bound=radius)
    near = near[np.isfinite(distance)]
    if len(near) < 3:
        return None
    centred = near - near.mean(axis=0)
    values, vectors = np.linalg.eigh(centred.T @ centred)
    # A line or a blob of points has no face.
    if values[1] <= 1e-12 * values[2] or values[0] > 0.5 * values[1]:
        return None
    return np.asarray(vectors[:, 0])


def _plane_within_wander(points: FloatArray, resolution: float) -> FloatArray | None:
    """Unit normal (3,) of the plane through points (k, 3) that are no wider across their line than
    points stray on a model of this resolution; None for others."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(points) < 3 or not resolution > 0.0:
        return None
    centred = points - points.mean(axis=0)
    values, vectors = np.linalg.eigh(centred.T @ centred / len(points))
    extent = float(np.ptp(centred @ vectors[:, 2]))
    straight = values[1] <= 1e-12 * values[2]
    if straight or not within_wander(float(values[1]), extent, len(points), resolution):
        return None
    return np.asarray(vectors[:, 0])


def _sample(points: FloatArray, count: int) -> FloatArray:
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(points) <= count:
        return points
    return np.asarray(points[np.linspace(0, len(points) - 1, count).round().astype(int)])


def _densified(points: FloatArray, pieces: int = 200) -> FloatArray:
    """The polyline through `points`, as points at even steps."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(points) < 2:
        return points
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    steps = np.linspace(0.0, along[-1], pieces)
    return np.stack([np.interp(steps, along, points[:, axis]) for axis in range(3)], axis=1)
