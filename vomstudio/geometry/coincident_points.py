"""Fast search for coincident points by one key per position."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray, UInt64Array


def position_keys(points: npt.NDArray[np.float32 | np.float64]) -> UInt64Array:
    """Return a key for each point; points with equal coordinates have equal keys.

    Two different points have the same key with a probability of 1e-19.

    Parameters
    ----------
    points : (k, 3) ndarray

    Returns
    -------
    (k,) ndarray of uint64
    """
    # -0.0 and 0.0 are the same position.
    bits = (np.ascontiguousarray(points, dtype=np.float64) + 0.0).view(np.uint64)
    key = np.zeros(len(bits), np.uint64)
    for axis in range(3):
        key = (key ^ bits[:, axis]) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return key


def weld_points(points: FloatArray) -> IntArray:
    """Assign a number to each distinct position of points, starting at 0.

    Parameters
    ----------
    points : (k, 3) ndarray

    Returns
    -------
    (k,) ndarray of int
        Number of the position of each point.
    """
    keys = position_keys(points)
    order = np.argsort(keys)
    point_ids = np.empty(len(keys), np.int64)
    point_ids[order] = np.cumsum(np.append(False, np.diff(keys[order]) != 0))
    return point_ids
