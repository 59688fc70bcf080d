"""What errors of a model's rotation and scale do to what is measured on it.

A small turn w moves a unit vector u by w x u, so its covariance C gives the vector the covariance
[u]x C [u]x', in the plane at right angles to it. That of a plane's normal is the plane's.
With a relative change s of the scale a difference d of two places moves by w x d + s d: its length
by s alone, its component along a direction that stays (up, say) by w . (d x u) + s d . u.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray

CHI2_TWO = 5.991464547107979
"""Of the 95 % region in two dimensions."""

Z95 = 1.959963984540054
"""Standard deviations either side that hold 95 % of one figure."""


def cross_matrix(directions: FloatArray) -> FloatArray:
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


def direction_covariance(rotation: FloatArray, directions: FloatArray) -> FloatArray:
    """(n, 3, 3) of unit vectors (n, 3), by the (3, 3) covariance of the rotation, radians squared
    about east, north, up."""
    skew = cross_matrix(np.asarray(directions, np.float64).reshape(-1, 3))
    return np.asarray(skew @ rotation @ np.swapaxes(skew, 1, 2))


def errors_95_deg(rotation: FloatArray, directions: FloatArray) -> FloatArray:
    """(n,) larger half-angle of the 95 % region (of both dimensions together) that the rotation's
    covariance (3, 3) gives normals or lines (n, 3), degrees, at most 90."""
    spread = direction_covariance(rotation, directions)
    largest = np.linalg.eigvalsh(spread)[:, -1]
    return np.asarray(np.minimum(np.degrees(np.sqrt(CHI2_TWO * np.maximum(largest, 0.0))), 90.0))


def enlarged_semi_axes(
    largest_deg: npt.ArrayLike,
    smallest_deg: npt.ArrayLike,
    total_deg: npt.ArrayLike,
    excluded_deg: npt.ArrayLike = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Enlarge the 95 % ellipse of a fitted normal to its total error.

    What resolution and registration add counts alike in all directions. A plane that may turn about
    its line by any angle (90) is as well known across it as before.

    Parameters
    ----------
    largest_deg, smallest_deg : (n,) or float
        Semi-axes of the fit.
    total_deg : (n,) or float
        Larger half-angle with all errors; not less than that of the fit.
    excluded_deg : (n,) or float
        Part of the total that is left out, such as a registration that turns planes together.

    Returns
    -------
    largest, smallest : (n,) or ()
        Degrees, at most 90.
    """
    own, narrow, total, excluded = (
        np.asarray(each, np.float64)
        for each in (largest_deg, smallest_deg, total_deg, excluded_deg)
    )
    free = total >= 90.0
    added = np.where(free, 0.0, np.maximum(total**2 - own**2 - excluded**2, 0.0))
    largest = np.where(free, 90.0, np.minimum(np.sqrt(own**2 + added), 90.0))
    return largest, np.minimum(np.sqrt(narrow**2 + added), 90.0)


def component_error_95(shape: FloatArray, step: FloatArray, direction: FloatArray) -> float:
    """95 % error, of this figure alone, of the component of a difference of two places (3,) along a
    unit vector (3,) that does not turn with the model.

    shape : (4, 4) covariance of turns about east, north, up (rad) and of a relative change of scale
    """
    gradient = np.append(np.cross(step, direction), float(step @ direction))
    return Z95 * float(np.sqrt(max(float(gradient @ shape @ gradient), 0.0)))


def horizontal_error_95(shape: FloatArray, step: FloatArray) -> float:
    """The same of the horizontal distance; of an upright one, whose horizontal part can only grow,
    in the direction in which it does so most."""
    flat = np.array([step[0], step[1], 0.0])
    length = float(np.linalg.norm(flat))
    if length > 1e-9 * float(np.linalg.norm(step)):
        return component_error_95(shape, step, flat / length)
    ways = np.array([[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0.0, np.pi, 180, False)])
    return max(component_error_95(shape, step, way) for way in ways)


def scale_error_95(shape: FloatArray) -> float:
    """95 % error of the scale, as a share; shape as in `component_error_95`."""
    return Z95 * float(np.sqrt(max(float(shape[3, 3]), 0.0)))
