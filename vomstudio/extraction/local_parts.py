"""Part of a model around the point in view, small enough for fast computations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

_RAY_HALF_WIDTH = 0.02
"""Half-width of the line of sight as a fraction of its length."""


@dataclass(frozen=True, eq=False)
class ModelPart:
    """Part of a model and the rows of its points and faces.

    Parameters
    ----------
    data : Mesh or PointCloud
        Data of this part only.
    points : (k,) int array
        Rows among the points or vertices of the model.
    faces : (m,) int array
        Rows among the faces of a mesh; empty for a cloud.
    """

    data: Mesh | PointCloud
    points: IntArray
    faces: IntArray


def extract_visible_part(
    data: Mesh | PointCloud, eye: npt.ArrayLike, view_target: npt.ArrayLike, count: int
) -> ModelPart:
    """Extract the `count` points that are nearest to the point in view.

    Parameters
    ----------
    data : Mesh or PointCloud
    eye, view_target : (3,) array_like
        Position of the viewer and a point in the viewing direction, in the frame of the data.
    count : int

    Returns
    -------
    ModelPart
        The extracted part, or the whole model if it has no more points than requested.
    """
    points = np.asarray(data.vertices if isinstance(data, Mesh) else data.points, np.float64)
    rows = np.arange(len(points))
    if len(points) > count:
        centre = _find_point_in_view(
            points, np.asarray(eye, np.float64), np.asarray(view_target, np.float64)
        )
        squared_distances = np.nan_to_num(((points - centre) ** 2).sum(axis=1), nan=np.inf)
        rows = np.sort(np.argpartition(squared_distances, count)[:count])
    if not isinstance(data, Mesh):
        return ModelPart(data.select_rows(rows), rows, np.zeros(0, np.int64))
    number = np.full(len(points), -1, np.int32)
    number[rows] = np.arange(len(rows))
    local_faces = number[data.faces]
    faces = np.flatnonzero((local_faces >= 0).all(axis=1))
    colors = None if data.colors is None else data.colors[rows]
    return ModelPart(
        Mesh(points[rows], np.ascontiguousarray(local_faces[faces]), colors=colors), rows, faces
    )


def _find_point_in_view(points: FloatArray, eye: FloatArray, view_target: FloatArray) -> FloatArray:
    """Return the first point near the line of sight, or else the point nearest to its end."""
    direction = view_target - eye
    size = float(np.linalg.norm(direction))
    offsets = points - eye
    if size > 0.0:
        depth = offsets @ (direction / size)
        distance = np.sqrt(np.maximum((offsets**2).sum(axis=1) - depth**2, 0.0))
        rows_near_ray = np.flatnonzero((depth > 0.0) & (distance < _RAY_HALF_WIDTH * depth))
        if len(rows_near_ray):
            # Among the nearest points, select the one closest to the line.
            first = rows_near_ray[
                depth[rows_near_ray] <= (1.0 + _RAY_HALF_WIDTH) * depth[rows_near_ray].min()
            ]
            return np.asarray(points[first[np.argmin(distance[first])]])
    return np.asarray(points[np.nanargmin(((points - view_target) ** 2).sum(axis=1))])
