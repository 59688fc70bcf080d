"""Inputs of the fit of one model to another: the points of both, and the start."""

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
    """Return the points (n, 3) of a surface and their resolution.

    Raises
    ------
    InputError
        If the model has fewer than two points or no extent.
    """
    spacing = resolution(data)
    if not (np.isfinite(spacing) and spacing > 0):
        raise InputError(Finding("reference.no-extent"), file=path)
    return surface_points(data, spacing)[0], spacing


def bounding_box(points: FloatArray) -> FloatArray:
    """Return the bounding box of the finite points.

    Parameters
    ----------
    points : (n, 3) ndarray

    Returns
    -------
    (2, 3) ndarray
        Minimum and maximum corners.
    """
    finite_points = points[np.isfinite(points).all(axis=1)]
    return np.array([finite_points.min(axis=0), finite_points.max(axis=0)])


def matrix_to_similarity(rows: Any) -> Similarity:
    """Convert a matrix to a similarity.

    Parameters
    ----------
    rows : (4, 4) array_like

    Returns
    -------
    Similarity
    """
    matrix = transform.matrix(rows)
    scale = float(transform.scale_factor(matrix))
    return Similarity(scale, matrix[:3, :3] / scale, matrix[:3, 3])


def replace_scale(fit: Similarity, scale: float, centre: FloatArray) -> Similarity:
    """Replace the scale of a similarity; the centre of the model does not move.

    Parameters
    ----------
    fit : Similarity
    scale : float
    centre : (3,) ndarray
        Middle of the model, model frame.

    Returns
    -------
    Similarity
    """
    placed_centre = fit(centre[None])[0]
    return Similarity(scale, fit.rotation, placed_centre - scale * fit.rotation @ centre)
