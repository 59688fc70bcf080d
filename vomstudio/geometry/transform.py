"""Similarity transforms as 4x4 matrices acting on column vectors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray


def matrix(rows: Sequence[Sequence[float]] | FloatArray) -> FloatArray:
    """(4, 4) float64 of nested rows."""
    return np.asarray(rows, dtype=np.float64).reshape(4, 4)


def apply(rows: Sequence[Sequence[float]] | FloatArray, points: npt.ArrayLike) -> FloatArray:
    """Points (n, 3) through a 4x4 similarity, in float64."""
    m = matrix(rows)
    p = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return p @ m[:3, :3].T + m[:3, 3]


def invert(rows: Sequence[Sequence[float]] | FloatArray) -> FloatArray:
    return np.asarray(np.linalg.inv(matrix(rows)))


def scale_of(rows: Sequence[Sequence[float]] | FloatArray) -> float:
    """Lengths grow by this factor."""
    return float(np.cbrt(abs(np.linalg.det(matrix(rows)[:3, :3]))))


def rotate(rows: Sequence[Sequence[float]] | FloatArray, vectors: npt.ArrayLike) -> FloatArray:
    """Directions (n, 3) through the rotation part; their length stays."""
    m = matrix(rows)
    return np.asarray(vectors, dtype=np.float64).reshape(-1, 3) @ (m[:3, :3] / scale_of(m)).T
