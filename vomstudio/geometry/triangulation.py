"""Triangulation of points from their pixels in photos."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cameras import View


def triangulate(views: Sequence[View], pixels: npt.ArrayLike) -> FloatArray:
    """Find the point whose projections have the smallest residuals in photos.

    The point nearest to the rays is refined by Gauss-Newton iterations on the pixels.

    Parameters
    ----------
    views : sequence of View
    pixels : (k, 2) array_like
        Position of the point in each of the k views.

    Returns
    -------
    (3,) ndarray
        NaN for fewer than two rays or for parallel rays.
    """
    marks = np.asarray(pixels, np.float64).reshape(-1, 2)
    if len(views) < 2:
        return np.full(3, np.nan)
    normal_matrix, right_side = np.zeros((3, 3)), np.zeros(3)
    for view, mark in zip(views, marks, strict=True):
        ray = view.rays(mark)[0]
        projector = np.eye(3) - np.outer(ray, ray)
        normal_matrix += projector
        right_side += projector @ view.centre
    if not np.isfinite(normal_matrix).all() or np.linalg.cond(normal_matrix) > 1e8:
        return np.full(3, np.nan)
    point = np.linalg.solve(normal_matrix, right_side)
    step = 1e-6 * max(1e-9, float(np.linalg.norm(point - views[0].centre)))
    offsets = np.vstack([np.zeros(3), np.eye(3) * step, -np.eye(3) * step])
    for _ in range(10):
        projections = np.array([view.project(point + offsets) for view in views])
        residuals = (marks - projections[:, 0]).ravel()
        jacobian = (
            ((projections[:, 1:4] - projections[:, 4:]) / (2 * step))
            .transpose(0, 2, 1)
            .reshape(-1, 3)
        )
        if not np.isfinite(jacobian).all():
            return np.full(3, np.nan)
        change = np.linalg.lstsq(jacobian, residuals, rcond=None)[0]
        point = point + change
        if np.linalg.norm(change) < step:
            break
    return np.asarray(point)
