"""Arguments that contain points: arrays, tables, models, or files of these."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.api.checking import array_points, is_model, numbers, require_valid_rows
from vomstudio.api.models import to_model
from vomstudio.core.arrays import FloatArray


def points(values: Any, name: str = "points") -> FloatArray:
    """Convert an array, a DataFrame with x, y, z, a model or a path to finite points (n, 3).

    Points keep their order. A model or a PyVista data set provides its vertices.

    Raises
    ------
    InputError
        If a row is invalid; the error states the first such row.
    """
    if is_model(values):
        return np.ascontiguousarray(to_model(values, name).points)
    return array_points(values, name)


def pixels_or_points(values: Any, name: str) -> FloatArray:
    """Convert values to points (n, 3), or to finite columns and rows (n, 2) of a photo.

    Raises
    ------
    InputError
        If the array has another shape or contains an invalid row.
    """
    if hasattr(values, "columns") or is_model(values):
        return points(values, name)
    if np.ndim(values) != 2 or np.shape(values)[1] != 2:
        return points(values, name)
    array = numbers(values, name)
    require_valid_rows(np.asarray(~np.isfinite(array).all(axis=1)), name)
    return np.ascontiguousarray(array)
