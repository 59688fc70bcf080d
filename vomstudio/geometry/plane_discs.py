"""Plane patches for drawing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.planes import PlaneFit

NOTHING_KNOWN_DEG = 45.0
"""A plane whose 95 % error is larger may as well stand across."""


def known_well_enough(fit: PlaneFit) -> bool:
    """Whether a disc says something: one that may as well stand across does not."""
    return fit.max_confidence95_deg is None or fit.max_confidence95_deg < NOTHING_KNOWN_DEG


def disc_of_fit(fit: PlaneFit | None) -> npt.NDArray[np.float64] | None:
    """(c, 3) the ring of a disc as wide as the points of a fit; None for no plane, one of no
    extent, or one that may as well stand across."""
    if fit is None or fit.extent is None or not known_well_enough(fit):
        return None
    return disc(fit.centroid, fit.normal, 0.5 * fit.extent)


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
