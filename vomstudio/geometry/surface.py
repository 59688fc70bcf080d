"""Properties of a model on which measurements depend."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.plane_sizes import is_width_within_wander
from vomstudio.geometry.resolution import resolution_from_neighbours

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


# Numbers of points that suffice to determine the spacing and the face, and that are processed fast
# enough on every click.
N_SAMPLES = 24
MAX_COARSE_VERTICES = 200_000
MAX_FACE_POINTS = 20_000
# The face of the outcrop is larger than the trace; it is not the ledge along which the trace runs.
FACE_EXTENT_RATIO = 3.0
# Rock face that contains a line: number of vertices near each point of the line, and maximum angle
# to the plane of the face (15 degrees).
N_NEIGHBOURS = 12
MIN_FACE_COSINE = float(np.cos(np.radians(15.0)))
MIN_NORMAL_POINTS = 64
BLOCK_SIZE = 1_000_000


class Surface(Protocol):
    """Surface of a model, in the file frame."""

    def local_resolution(self, points: FloatArray) -> float | None:
        """Return the effective resolution of the model around points (k, 3), m.

        It is the larger of the mean spacing and the noise of the vertices or points; see
        `geometry.resolution`. It is None if it is unknown.
        """

    def outcrop_normal(self, points: FloatArray) -> FloatArray | None:
        """Return the unit normal (3,) of the outcrop face around a line through points (k, 3).

        The normal refers to a scale of several times the extent of the line. If the line lies in a
        single rock face and is straight within the scatter of its points, the normal of that face
        is returned. The result is None if no face can be fitted.
        """


class VertexSurface:
    """Surface defined by the vertices of a mesh or a cloud.

    `build` creates the search tree and may run in any thread. Until it has finished, an exhaustive
    search gives the same results.
    """

    def __init__(
        self,
        vertices: FloatArray,
        undivided_vertices: FloatArray | Callable[[], FloatArray] | None = None,
    ) -> None:
        """Store the vertices (n, 3) float64 without copying them.

        `undivided_vertices` contains the vertices that determine the resolution (see
        `geometry.subdivision`), or is a function that returns them. If None, all vertices are used.
        """
        self._vertices = vertices
        self._undivided_vertices = undivided_vertices
        self._tree: cKDTree | None = None
        self._coarse_tree: cKDTree | None = None
        self._lock = threading.Lock()
        self._coarse_vertices = vertices[:: max(1, len(vertices) // MAX_COARSE_VERTICES)]

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
                self._coarse_tree = cKDTree(np.asarray(self._coarse_vertices))
        if self._resolving_surface is not self:
            self._resolving_surface.build()

    @property
    def extent(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self._coarse_vertices, axis=0)))

    @cached_property
    def _resolving_surface(self) -> VertexSurface:
        """Surface of the vertices that determine the resolution."""
        vertices = (
            self._undivided_vertices()
            if callable(self._undivided_vertices)
            else self._undivided_vertices
        )
        return self if vertices is None or vertices is self._vertices else VertexSurface(vertices)

    def local_resolution(self, points: FloatArray) -> float | None:
        if self._resolving_surface is not self:
            return self._resolving_surface.local_resolution(points)
        positions = [self._nearest(point, 1)[0] for point in _sample_points(points, N_SAMPLES)]

        def neighbours(count: int) -> FloatArray | None:
            # Use one call for all matrices, because a single 3 x 3 matrix takes as long.
            neighbourhoods = [self._nearest(position, count) for position in positions]
            return np.stack(neighbourhoods) if neighbourhoods else None

        return resolution_from_neighbours(neighbours)

    def outcrop_normal(self, points: FloatArray) -> FloatArray | None:
        line = _resample_polyline(points)
        extent = float(np.linalg.norm(np.ptp(line, axis=0)))
        resolution = self.local_resolution(points) or 0.0
        plane_normal = _plane_within_wander(points, resolution)
        if plane_normal is not None:
            neighbours = [
                self._nearest(point, N_NEIGHBOURS) for point in _sample_points(line, N_SAMPLES)
            ]
            face = _fit_face_normal(
                line, np.unique(np.concatenate(neighbours), axis=0), 2.0 * resolution
            )
            if face is not None and abs(float(face @ plane_normal)) > MIN_FACE_COSINE:
                return face
        radius = max(FACE_EXTENT_RATIO * extent, 10.0 * resolution)
        near_points = self._vertices_near_box(line.min(axis=0) - radius, line.max(axis=0) + radius)
        return _fit_face_normal(
            line, near_points[:: max(1, len(near_points) // MAX_FACE_POINTS)], radius
        )

    def _vertices_near_box(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return vertices (k, 3) in a box that suffice to determine the attitude of the surface."""
        is_inside = np.all((self._coarse_vertices >= low) & (self._coarse_vertices <= high), axis=1)
        return np.asarray(self._coarse_vertices[is_inside])

    def _ids_in_ball(self, centre: FloatArray, radius: float) -> IntArray:
        """Return the ids of the vertices in a ball, in any order."""
        if self._tree is not None:
            ids = self._tree.query_ball_point(centre, radius, return_sorted=False)
            return np.asarray(ids, dtype=np.int64)
        id_blocks = []
        for start in range(0, len(self._vertices), BLOCK_SIZE):
            part = np.asarray(self._vertices[start : start + BLOCK_SIZE])
            near_indices = np.flatnonzero(np.abs(part[:, 0] - centre[0]) <= radius)
            offsets = part[near_indices] - centre
            id_blocks.append(
                start + near_indices[np.einsum("ij,ij->i", offsets, offsets) <= radius**2]
            )
        return np.concatenate(id_blocks)

    def _normal(self, centre: FloatArray, radius: float) -> FloatArray | None:
        """Return the unit normal of the vertices in a ball.

        Return None if there are too few vertices or the tree has not been built.
        """
        if self._tree is None or self._coarse_tree is None:
            return None
        near_points = self._coarse_vertices[self._coarse_tree.query_ball_point(centre, radius)]
        if len(near_points) < MIN_NORMAL_POINTS:
            distance, index = self._tree.query(
                centre, k=min(MIN_NORMAL_POINTS, len(self._vertices)), distance_upper_bound=radius
            )
            near_points = self._vertices[np.atleast_1d(index)[np.isfinite(np.atleast_1d(distance))]]
        if len(near_points) < 3:
            return None
        centred_points = near_points - near_points.mean(axis=0)
        values, vectors = np.linalg.eigh(centred_points.T @ centred_points)
        return np.asarray(vectors[:, 0]) if values[1] > 1e-12 * values[2] else None

    def _nearest(self, point: FloatArray, count: int) -> FloatArray:
        count = min(count, len(self._vertices))
        if self._tree is not None:
            _, index = self._tree.query(point, k=count)
            return np.asarray(self._vertices[np.atleast_1d(index)])
        square = ((np.asarray(self._vertices) - point) ** 2).sum(axis=1)
        index = np.argpartition(square, count - 1)[:count]
        return np.asarray(self._vertices[index[np.argsort(square[index])]])


def _fit_face_normal(line: FloatArray, near_points: FloatArray, radius: float) -> FloatArray | None:
    """Fit the unit normal (3,) of vertices (k, 3) within a radius of a line.

    Return None if they do not form a face.
    """
    from scipy.spatial import cKDTree

    if len(near_points) < 3:
        return None
    distance, _ = cKDTree(line).query(near_points, distance_upper_bound=radius)
    near_points = near_points[np.isfinite(distance)]
    if len(near_points) < 3:
        return None
    centred_points = near_points - near_points.mean(axis=0)
    values, vectors = np.linalg.eigh(centred_points.T @ centred_points)
    # A line or a blob of points is not a face.
    if values[1] <= 1e-12 * values[2] or values[0] > 0.5 * values[1]:
        return None
    return np.asarray(vectors[:, 0])


def _plane_within_wander(points: FloatArray, resolution: float) -> FloatArray | None:
    """Return the normal (3,) of the plane of a trace whose width may be due to wandering.

    Return None for wider traces and for exactly straight ones; see
    `plane_sizes.is_width_within_wander`.
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(points) < 3 or not resolution > 0.0:
        return None
    centred_points = points - points.mean(axis=0)
    values, vectors = np.linalg.eigh(centred_points.T @ centred_points / len(points))
    extent = float(np.ptp(centred_points @ vectors[:, 2]))
    is_straight = values[1] <= 1e-12 * values[2]
    if is_straight or not is_width_within_wander(float(values[1]), extent, len(points), resolution):
        return None
    return np.asarray(vectors[:, 0])


def _sample_points(points: FloatArray, count: int) -> FloatArray:
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(points) <= count:
        return points
    return np.asarray(points[np.linspace(0, len(points) - 1, count).round().astype(int)])


def _resample_polyline(points: FloatArray, pieces: int = 200) -> FloatArray:
    """Resample a polyline at even steps."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(points) < 2:
        return points
    distances = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    steps = np.linspace(0.0, distances[-1], pieces)
    return np.stack([np.interp(steps, distances, points[:, axis]) for axis in range(3)], axis=1)
