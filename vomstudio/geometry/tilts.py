"""What an error of a model's rotation does to what is measured on it.

A small turn w moves a unit vector u by w x u, so its covariance C gives the vector the covariance
[u]x C [u]x', in the plane at right angles to it. That of a plane's normal is the plane's.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

CHI2_TWO = 5.991464547107979
"""Of the 95 % region in two dimensions."""


def _across(directions: Array) -> Array:
    """(n, 3, 3) the matrices of the cross product with unit vectors (n, 3)."""
    x, y, z = directions.T
    zero = np.zeros_like(x)
    return np.stack(
        [
            np.stack([zero, -z, y], axis=1),
            np.stack([z, zero, -x], axis=1),
            np.stack([-y, x, zero], axis=1),
        ],
        axis=1,
    )


def direction_covariance(rotation: Array, directions: Array) -> Array:
    """(n, 3, 3) of unit vectors (n, 3), by the (3, 3) covariance of the rotation, radians squared
    about east, north, up."""
    across = _across(np.asarray(directions, np.float64).reshape(-1, 3))
    return np.asarray(across @ rotation @ np.swapaxes(across, 1, 2))


def errors_95_deg(rotation: Array, directions: Array) -> Array:
    """(n,) larger half-angle of the 95 % region (of both dimensions together) that the rotation's
    covariance (3, 3) gives normals or lines (n, 3), degrees, at most 90."""
    spread = direction_covariance(rotation, directions)
    largest = np.linalg.eigvalsh(spread)[:, -1]
    return np.asarray(np.minimum(np.degrees(np.sqrt(CHI2_TWO * np.maximum(largest, 0.0))), 90.0))
