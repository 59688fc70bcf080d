"""The surface that a brush works on, of whichever kind of data a model has."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.brush import CloudSurface, MeshSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud

_FACE_POINTS = 20_000


def surface_of(data: Mesh | PointCloud) -> MeshSurface | CloudSurface:
    if isinstance(data, StreamedCloud):
        return StreamedSurface(data)
    return MeshSurface(data) if isinstance(data, Mesh) else CloudSurface(data)


class StreamedSurface(CloudSurface):
    """The surface of the nodes that are there. The brush, the spacing and the face around a trace
    therefore know what is loaded for the present view, which is what is seen."""

    def __init__(self, cloud: StreamedCloud) -> None:
        super().__init__(cloud)
        self._store = cloud.store
        self._box = cloud.box

    def build(self) -> None:
        # Or the first stroke would wait for them.
        import scipy.sparse.csgraph
        import scipy.spatial  # noqa: F401

    @property
    def count(self) -> int:
        return self._store.total

    @property
    def extent(self) -> float:
        return float(np.linalg.norm(self._box[1] - self._box[0]))

    def corners(self, ids: IntArray) -> FloatArray:
        return self._store.points_of(ids)

    def _in_ball(self, centre: FloatArray, radius: float) -> IntArray:
        centre = np.asarray(centre, np.float64)
        found = [np.zeros(0, np.int64)]
        for row, cloud in self._store.touching(centre - radius, centre + radius):
            near = self._store.tree(row, cloud).query_ball_point(centre, radius)
            found.append(np.asarray(near, np.int64) + self._store.starts[row])
        return np.concatenate(found)

    def _nearest(self, point: FloatArray, count: int) -> FloatArray:
        point = np.asarray(point, np.float64)
        best, where = np.full(count, np.inf), np.zeros((count, 3))
        there = self._store.loaded()
        rows = np.fromiter(there, np.int64, len(there))
        low, high = self._store.bounds[rows, 0], self._store.bounds[rows, 1]
        away = np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0), axis=1)
        for k in np.argsort(away, kind="stable"):
            if away[k] > best[-1]:
                break
            row = int(rows[k])
            cloud = there[row]
            distance, index = self._store.tree(row, cloud).query(
                point, k=min(count, len(cloud.points)), distance_upper_bound=best[-1]
            )
            distance, index = np.atleast_1d(distance), np.atleast_1d(index)
            good = np.isfinite(distance)
            distances = np.concatenate([best, distance[good]])
            places = np.concatenate([where, cloud.points[index[good]]])
            order = np.argsort(distances, kind="stable")[:count]
            best, where = distances[order], places[order]
        return np.asarray(where[np.isfinite(best)])

    def _near_box(self, low: FloatArray, high: FloatArray) -> FloatArray:
        found = [np.zeros((0, 3))]
        for _, cloud in self._store.touching(low, high):
            inside = ((cloud.points >= low) & (cloud.points <= high)).all(axis=1)
            found.append(cloud.points[inside])
        near = np.concatenate(found)
        return near[:: max(1, len(near) // _FACE_POINTS)]

    def _normal(self, centre: FloatArray, radius: float) -> FloatArray | None:
        near = self._near_box(centre - radius, centre + radius)
        off = near - centre
        near = near[np.einsum("ij,ij->i", off, off) <= radius**2]
        if len(near) < 3:
            return None
        centred = near - near.mean(axis=0)
        values, vectors = np.linalg.eigh(centred.T @ centred)
        return np.asarray(vectors[:, 0]) if values[1] > 1e-12 * values[2] else None
