"""What a fit of one model to another begins with: points of both, and where the model stands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import resolution
from vomstudio.registration.similarity import Similarity
from vomstudio.registration.surface_points import surface_points


def points_and_spacing(data: Mesh | PointCloud, path: Path) -> tuple[FloatArray, float]:
    """(n, 3) points of the surface, and their resolution. path : of its file. Raises InputError for
    a model that is a single point or none."""
    spacing = resolution(data)
    if not (np.isfinite(spacing) and spacing > 0):
        raise InputError(Finding("reference.no-extent"), file=path)
    return surface_points(data, spacing)[0], spacing


def box_of(points: FloatArray) -> FloatArray:
    """(2, 3) around the points (n, 3) that are finite."""
    sound = points[np.isfinite(points).all(axis=1)]
    return np.array([sound.min(axis=0), sound.max(axis=0)])


def similarity_of(rows: Any) -> Similarity:
    """Of a 4 x 4 matrix."""
    matrix = transform.matrix(rows)
    scale = float(transform.scale_of(matrix))
    return Similarity(scale, matrix[:3, :3] / scale, matrix[:3, 3])


def with_scale(fit: Similarity, scale: float, middle: FloatArray) -> Similarity:
    """The same place and attitude of the model's middle (3,) with another scale."""
    there = fit(middle[None])[0]
    return Similarity(scale, fit.rotation, there - scale * fit.rotation @ middle)
