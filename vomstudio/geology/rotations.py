"""Rotation of orientations: untilting by a plane, and rotation about any axis.

Untilting rotates a plane to the horizontal about its strike by its dip: the poles of the beds that
it represents become vertical (Fisher, Lewis & Embleton 1987, 2.5; Ramsay 1961, Journal of Geology
69, 84-100). The younging direction of the beds is irrelevant for axial data.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.orientation import Line, Plane, sin_cos_deg


def rotate_vectors(vectors: npt.ArrayLike, axis: Line, angle_deg: float) -> FloatArray:
    """Rotate vectors about an axis, clockwise when looking down its plunge.

    Rodrigues' rotation formula is used.

    Parameters
    ----------
    vectors : (n, 3) array_like
    axis : Line
    angle_deg : float

    Returns
    -------
    (n, 3) ndarray
    """
    v = np.asarray(vectors, dtype=np.float64)
    k = axis.vector()
    sine, cosine = sin_cos_deg(angle_deg)
    projections = (v @ k)[..., None] * k
    return np.asarray(v * cosine + np.cross(k, v) * sine + projections * (1.0 - cosine))


def untilt(vectors: npt.ArrayLike, plane: Plane) -> FloatArray:
    """Rotate vectors about the strike of a plane so that the plane becomes horizontal.

    Parameters
    ----------
    vectors : (n, 3) array_like
    plane : Plane

    Returns
    -------
    (n, 3) ndarray
    """
    if plane.undefined:
        return np.array(vectors, dtype=np.float64)
    # Rotate about the right-hand-rule strike, to the right of which the plane dips.
    return rotate_vectors(vectors, Line(plane.strike_rhr_deg, 0.0), -plane.dip_deg)


def pairwise_intersections(poles: npt.ArrayLike, min_angle_deg: float = 1.0) -> FloatArray:
    """Return the downward intersection lines of all pairs of planes.

    Parameters
    ----------
    poles : (n, 3) array_like
    min_angle_deg : float, optional
        Minimum angle between two planes in degrees; below it, their intersection is random and the
        pair is excluded.

    Returns
    -------
    (m, 3) ndarray
    """
    p = np.asarray(poles, dtype=np.float64)
    first_rows, second_rows = np.triu_indices(len(p), 1)
    lines = np.cross(p[first_rows], p[second_rows])
    length = np.linalg.norm(lines, axis=1)
    is_valid = length > float(np.sin(np.radians(min_angle_deg)))
    lines = lines[is_valid] / length[is_valid, None]
    return np.asarray(np.where(lines[:, 2:] > 0, -lines, lines))
