"""Plane patches for drawing."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.planes import FittedPlane

MAX_DISC_ERROR_DEG = 45.0
"""95 % error above which a plane could equally well be perpendicular to the fitted plane."""


def is_attitude_accurate(fit: FittedPlane) -> bool:
    """Return whether the attitude of a fit is accurate enough to draw a disc.

    A fit without a stated error counts as accurate.

    Parameters
    ----------
    fit : FittedPlane

    Returns
    -------
    bool
    """
    return fit.max_confidence95_deg is None or fit.max_confidence95_deg < MAX_DISC_ERROR_DEG


def disc_of_fit(fit: FittedPlane | None) -> FloatArray | None:
    """Return the ring of a disc as wide as the points of a fit.

    Parameters
    ----------
    fit : FittedPlane or None

    Returns
    -------
    (c, 3) ndarray or None
        Vertices, or None if the plane or its extent is missing, or the attitude is practically
        unknown.
    """
    if fit is None or fit.extent is None or not is_attitude_accurate(fit):
        return None
    return disc(fit.centroid, fit.normal, 0.5 * fit.extent)


def disc(
    centre: npt.ArrayLike, normal: npt.ArrayLike, radius: float, corners: int = 48
) -> FloatArray:
    """Return the ring of a disc.

    Parameters
    ----------
    centre : (3,) array_like
    normal : (3,) array_like
        Unit vector; the ring runs anticlockwise as seen from its tip.
    radius : float
    corners : int, optional
        Number of vertices.

    Returns
    -------
    (corners, 3) ndarray
        In the frame of `centre`.
    """
    n = np.asarray(normal, dtype=np.float64)
    # Any direction that is not nearly the normal gives a stable pair of axes.
    helper = [0.0, 0.0, 0.0]
    helper[int(np.argmin(np.abs(n)))] = 1.0
    u = np.array(_cross_product(n.tolist(), helper))
    u /= math.sqrt(u.dot(u))
    v = np.array(_cross_product(n.tolist(), u.tolist()))
    cosine, sine = _circle(corners)
    circle = radius * (cosine * u + sine * v)
    return np.asarray(np.asarray(centre, dtype=np.float64) + circle)


def _cross_product(a: list[float], b: list[float]) -> list[float]:
    # By hand: NumPy takes twenty times as long for two vectors, and there are thousands of discs.
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


@lru_cache(maxsize=8)
def _circle(corners: int) -> tuple[FloatArray, FloatArray]:
    """Return the cosine and sine (corners, 1) of angles around a full circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)[:, None]
    return np.cos(angle), np.sin(angle)
