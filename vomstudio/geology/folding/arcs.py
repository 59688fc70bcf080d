"""Arcs of great circles that contain poles, their ends, and poles flipped into an arc."""

from __future__ import annotations

import math

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.statistics import flip_to_hemisphere


def rms(values: FloatArray) -> float:
    """Return the root mean square of values.

    Parameters
    ----------
    values : ndarray

    Returns
    -------
    float
    """
    return math.sqrt(float(np.mean(np.asarray(values) ** 2)))


def arc_deg(poles: FloatArray, axes: FloatArray) -> float:
    """Return the length of the shortest great-circle arc that contains all poles.

    It is 180 degrees minus the widest gap between neighbouring axial poles.

    Parameters
    ----------
    poles : (n, 3) ndarray
    axes : (3, 3) ndarray
        Eigenvectors of the orientation tensor.

    Returns
    -------
    float
        Degrees.
    """
    pole_angles = _sorted_angles_deg(poles, axes)
    gaps = np.diff(np.append(pole_angles, pole_angles[0] + 180.0))
    return float(180.0 - gaps.max())


def arc_ends(poles: FloatArray, axes: FloatArray) -> tuple[int, int]:
    """Return the rows of the poles at both ends of the arc that contains all poles.

    Parameters
    ----------
    poles : (n, 3) ndarray
    axes : (3, 3) ndarray
        Eigenvectors of the orientation tensor.

    Returns
    -------
    tuple of int
    """
    angle = np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0
    order = np.argsort(angle)
    sorted_angles = angle[order]
    widest_gap = int(np.argmax(np.diff(np.append(sorted_angles, sorted_angles[0] + 180.0))))
    return int(order[widest_gap]), int(order[(widest_gap + 1) % len(order)])


def _sorted_angles_deg(poles: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the sorted angles of poles along the great circle, 0 to 180 degrees."""
    return np.sort(np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0)


def flip_into_arc(poles: FloatArray, axes: FloatArray) -> FloatArray:
    """Flip poles so that they lie in the arc that contains all of them.

    Parameters
    ----------
    poles : (n, 3) ndarray
    axes : (3, 3) ndarray
        Eigenvectors of the orientation tensor.

    Returns
    -------
    (n, 3) ndarray
    """
    angle = np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0
    sorted_angles = np.sort(angle)
    gaps = np.diff(np.append(sorted_angles, sorted_angles[0] + 180.0))
    widest_gap = int(np.argmax(gaps))
    centre = sorted_angles[widest_gap] + gaps[widest_gap] + (180.0 - gaps[widest_gap]) / 2.0
    middle_rad = math.radians(centre)
    return flip_to_hemisphere(
        poles, math.cos(middle_rad) * axes[0] + math.sin(middle_rad) * axes[1]
    )
