"""Plane patches for drawing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def disc(
    centre: npt.ArrayLike, normal: npt.ArrayLike, radius: float, corners: int = 48
) -> npt.NDArray[np.float64]:
    """(corners, 3) ring of a disc, in the frame of `centre` and `normal` (unit vector), from whose
    tip it runs anticlockwise."""
    n = np.asarray(normal, dtype=np.float64)
    # Any direction that is not nearly the normal gives a stable pair of axes.
    helper = np.eye(3)[np.argmin(np.abs(n))]
    u = np.cross(n, helper)
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)[:, None]
    around = radius * (np.cos(angle) * u + np.sin(angle) * v)
    return np.asarray(np.asarray(centre, dtype=np.float64) + around)
