"""Surfaces of all kinds of models, on which a brush operates."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.brush import CloudSurface, MeshSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud

MAX_FACE_POINTS = 20_000


def create_surface(data: Mesh | PointCloud) -> MeshSurface | CloudSurface:
    """Return the surface of a model, for queries of its faces or points.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    MeshSurface or CloudSurface
    """
    if isinstance(data, StreamedCloud):
        return StreamedSurface(data)
    return MeshSurface(data) if isinstance(data, Mesh) else CloudSurface(data)


class StreamedSurface(CloudSurface):
    """Surface of the loaded nodes.

    The brush, the spacing and the face around a trace use the nodes loaded for the current view.
    """

    def __init__(self, cloud: StreamedCloud) -> None:
        super().__init__(cloud)
        self._store = cloud.store
        self._box = cloud.box

    def build(self) -> None:
        # Import in advance, so that the first stroke is not delayed.
        import scipy.sparse.csgraph
        import scipy.spatial  # noqa: F401

    @property
    def count(self) -> int:
        return self._store.point_count

    @property
    def extent(self) -> float:
        return float(np.linalg.norm(self._box[1] - self._box[0]))

    def corners(self, ids: IntArray) -> FloatArray:
        return self._store.points_of(ids)

    def _ids_in_ball(self, centre: FloatArray, radius: float) -> IntArray:
        centre = np.asarray(centre, np.float64)
        ids = [np.zeros(0, np.int64)]
        for row, cloud in self._store.find_touching_nodes(centre - radius, centre + radius):
            near_ids = self._store.tree(row, cloud).query_ball_point(centre, radius)
            ids.append(np.asarray(near_ids, np.int64) + self._store.starts[row])
        return np.concatenate(ids)

    def _nearest(self, point: FloatArray, count: int) -> FloatArray:
        point = np.asarray(point, np.float64)
        best_distances, best_positions = np.full(count, np.inf), np.zeros((count, 3))
        loaded_nodes = self._store.loaded_nodes()
        rows = np.fromiter(loaded_nodes, np.int64, len(loaded_nodes))
        low, high = self._store.bounds[rows, 0], self._store.bounds[rows, 1]
        box_distances = np.linalg.norm(
            np.maximum(np.maximum(low - point, point - high), 0.0), axis=1
        )
        for k in np.argsort(box_distances, kind="stable"):
            if box_distances[k] > best_distances[-1]:
                break
            row = int(rows[k])
            cloud = loaded_nodes[row]
            distance, index = self._store.tree(row, cloud).query(
                point, k=min(count, len(cloud.points)), distance_upper_bound=best_distances[-1]
            )
            distance, index = np.atleast_1d(distance), np.atleast_1d(index)
            is_finite = np.isfinite(distance)
            distances = np.concatenate([best_distances, distance[is_finite]])
            positions = np.concatenate([best_positions, cloud.points[index[is_finite]]])
            order = np.argsort(distances, kind="stable")[:count]
            best_distances, best_positions = distances[order], positions[order]
        return np.asarray(best_positions[np.isfinite(best_distances)])

    def _vertices_near_box(self, low: FloatArray, high: FloatArray) -> FloatArray:
        points = [np.zeros((0, 3))]
        for _, cloud in self._store.find_touching_nodes(low, high):
            is_inside = ((cloud.points >= low) & (cloud.points <= high)).all(axis=1)
            points.append(cloud.points[is_inside])
        near_points = np.concatenate(points)
        return near_points[:: max(1, len(near_points) // MAX_FACE_POINTS)]

    def _normal(self, centre: FloatArray, radius: float) -> FloatArray | None:
        near_points = self._vertices_near_box(centre - radius, centre + radius)
        offsets = near_points - centre
        near_points = near_points[np.einsum("ij,ij->i", offsets, offsets) <= radius**2]
        if len(near_points) < 3:
            return None
        centred_points = near_points - near_points.mean(axis=0)
        values, vectors = np.linalg.eigh(centred_points.T @ centred_points)
        return np.asarray(vectors[:, 0]) if values[1] > 1e-12 * values[2] else None
