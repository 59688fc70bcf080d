"""Similarity transforms as 4x4 matrices acting on column vectors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray


def matrix(rows: Sequence[Sequence[float]] | FloatArray) -> FloatArray:
    """Convert nested rows to a matrix.

    Parameters
    ----------
    rows : (4, 4) array_like

    Returns
    -------
    (4, 4) ndarray
    """
    return np.asarray(rows, dtype=np.float64).reshape(4, 4)


def apply(rows: Sequence[Sequence[float]] | FloatArray, points: npt.ArrayLike) -> FloatArray:
    """Transform points by a similarity, in float64.

    Parameters
    ----------
    rows : (4, 4) array_like
    points : (n, 3) array_like

    Returns
    -------
    (n, 3) ndarray
    """
    m = matrix(rows)
    p = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return p @ m[:3, :3].T + m[:3, 3]


def invert(rows: Sequence[Sequence[float]] | FloatArray) -> FloatArray:
    """Return the inverse of a similarity.

    Parameters
    ----------
    rows : (4, 4) array_like

    Returns
    -------
    (4, 4) ndarray
    """
    return np.asarray(np.linalg.inv(matrix(rows)))


def scale_factor(rows: Sequence[Sequence[float]] | FloatArray) -> float:
    """Return the factor by which a similarity changes lengths.

    Parameters
    ----------
    rows : (4, 4) array_like

    Returns
    -------
    float
    """
    return float(np.cbrt(abs(np.linalg.det(matrix(rows)[:3, :3]))))


def rotate(rows: Sequence[Sequence[float]] | FloatArray, vectors: npt.ArrayLike) -> FloatArray:
    """Rotate directions by the rotation part of a similarity; lengths do not change.

    Parameters
    ----------
    rows : (4, 4) array_like
    vectors : (n, 3) array_like

    Returns
    -------
    (n, 3) ndarray
    """
    m = matrix(rows)
    return np.asarray(vectors, dtype=np.float64).reshape(-1, 3) @ (m[:3, :3] / scale_factor(m)).T
