"""A piece of a model around what somebody looks at, on which work is quick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

_NARROW = 0.02
"""Half the width of the ray that finds what is looked at, over its length."""


@dataclass(frozen=True, eq=False)
class Part:
    """data : the piece alone; points : its rows among the points or vertices of the model; faces :
    among the faces of a mesh, none for a cloud"""

    data: Mesh | PointCloud
    points: IntArray
    faces: IntArray


def part_in_view(
    data: Mesh | PointCloud, eye: npt.ArrayLike, toward: npt.ArrayLike, count: int
) -> Part:
    """The `count` points that are nearest to the place that is seen from `eye` (3,) in the
    direction of the point `toward` (3,), all in the frame of the data; all of a smaller model."""
    points = np.asarray(data.vertices if isinstance(data, Mesh) else data.points, np.float64)
    rows = np.arange(len(points))
    if len(points) > count:
        middle = _seen(points, np.asarray(eye, np.float64), np.asarray(toward, np.float64))
        square = np.nan_to_num(((points - middle) ** 2).sum(axis=1), nan=np.inf)
        rows = np.sort(np.argpartition(square, count)[:count])
    if not isinstance(data, Mesh):
        return Part(data.of_rows(rows), rows, np.zeros(0, np.int64))
    number = np.full(len(points), -1, np.int32)
    number[rows] = np.arange(len(rows))
    own = number[data.faces]
    faces = np.flatnonzero((own >= 0).all(axis=1))
    colors = None if data.colors is None else data.colors[rows]
    return Part(Mesh(points[rows], np.ascontiguousarray(own[faces]), colors=colors), rows, faces)


def _seen(points: FloatArray, eye: FloatArray, toward: FloatArray) -> FloatArray:
    """The first point near the ray; where it meets none, the point nearest to its end."""
    way = toward - eye
    size = float(np.linalg.norm(way))
    off = points - eye
    if size > 0.0:
        depth = off @ (way / size)
        aside = np.sqrt(np.maximum((off**2).sum(axis=1) - depth**2, 0.0))
        near = np.flatnonzero((depth > 0.0) & (aside < _NARROW * depth))
        if len(near):
            # Of what is seen first, the middle.
            first = near[depth[near] <= (1.0 + _NARROW) * depth[near].min()]
            return np.asarray(points[first[np.argmin(aside[first])]])
    return np.asarray(points[np.nanargmin(((points - toward) ** 2).sum(axis=1))])
