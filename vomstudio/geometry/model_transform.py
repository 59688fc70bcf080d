"""Rotation, scaling and translation of whole models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import overload

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh


@overload
def transform_model(data: Mesh, rows: Sequence[Sequence[float]] | FloatArray) -> Mesh: ...
@overload
def transform_model(
    data: PointCloud, rows: Sequence[Sequence[float]] | FloatArray
) -> PointCloud: ...
def transform_model(
    data: Mesh | PointCloud, rows: Sequence[Sequence[float]] | FloatArray
) -> Mesh | PointCloud:
    """Transform the model by a 4 x 4 similarity, in float64.

    The model itself is returned if the similarity is the identity.

    Parameters
    ----------
    data : Mesh or PointCloud
    rows : (4, 4) array_like
        Similarity.

    Returns
    -------
    Mesh or PointCloud
    """
    if np.array_equal(transform.matrix(rows), np.eye(4)):
        return data
    if isinstance(data, Mesh):
        return replace(data, vertices=transform.apply(rows, data.vertices))
    normals = data.normals
    if normals is not None:
        normals = transform.rotate(rows, normals).astype(np.float32)
    points = transform.apply(rows, data.points)
    return replace(data, points=points, normals=normals, arrangement=None)
