"""Errors of measurements caused by errors in the rotation and scale of a model.

A small rotation w moves a unit vector u by w x u. A rotation with the covariance C therefore gives
the vector the covariance [u]x C [u]x' in the plane perpendicular to it. The attitude of a plane has
the covariance of its normal. With a relative change s of the scale, the difference d of two points
changes by w x d + s d: its relative length changes by s only, and its component along a fixed
direction u (such as up) changes by w . (d x u) + s d . u.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray

CHI2_TWO = 5.991464547107979
"""95 % quantile of chi-square with two degrees of freedom."""

Z95 = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution."""


def cross_matrix(directions: FloatArray) -> FloatArray:
    """Return the matrices of the cross product with unit vectors.

    Parameters
    ----------
    directions : (n, 3) ndarray

    Returns
    -------
    (n, 3, 3) ndarray
    """
    x, y, z = directions.T
    zeros = np.zeros_like(x)
    return np.stack(
        [
            np.stack([zeros, -z, y], axis=1),
            np.stack([z, zeros, -x], axis=1),
            np.stack([-y, x, zeros], axis=1),
        ],
        axis=1,
    )


def direction_covariance(rotation: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the covariances of unit vectors caused by the covariance of the rotation.

    Parameters
    ----------
    rotation : (3, 3) ndarray
        Covariance of rotations about east, north and up, radians squared.
    directions : (n, 3) ndarray

    Returns
    -------
    (n, 3, 3) ndarray
    """
    skew = cross_matrix(np.asarray(directions, np.float64).reshape(-1, 3))
    return np.asarray(skew @ rotation @ np.swapaxes(skew, 1, 2))


def errors_95_deg(rotation: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the larger half-angle of the joint 95 % region of directions.

    Parameters
    ----------
    rotation : (3, 3) ndarray
        Covariance of rotations about east, north and up, radians squared.
    directions : (n, 3) ndarray

    Returns
    -------
    (n,) ndarray
        Degrees, at most 90.
    """
    covariances = direction_covariance(rotation, directions)
    largest_variances = np.linalg.eigvalsh(covariances)[:, -1]
    return np.asarray(
        np.minimum(np.degrees(np.sqrt(CHI2_TWO * np.maximum(largest_variances, 0.0))), 90.0)
    )


def enlarged_semi_axes(
    largest_deg: npt.ArrayLike,
    smallest_deg: npt.ArrayLike,
    total_deg: npt.ArrayLike,
    excluded_deg: npt.ArrayLike = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Enlarge the 95 % ellipse of a fitted normal to its total error.

    Resolution and registration contribute equally in all directions. A plane that may rotate freely
    about its line (semi-axis of 90 degrees) keeps its error across that line.

    Parameters
    ----------
    largest_deg, smallest_deg : (n,) array_like or float
        Semi-axes of the fit, degrees.
    total_deg : (n,) array_like or float
        Larger half-angle with all errors; not less than `largest_deg`, degrees.
    excluded_deg : (n,) array_like or float
        Part of the total to exclude, such as a registration that rotates planes together, degrees.

    Returns
    -------
    largest, smallest : (n,) ndarray or float
        Degrees, at most 90.
    """
    fit_major, fit_minor, total_error, excluded_error = (
        np.asarray(item, np.float64)
        for item in (largest_deg, smallest_deg, total_deg, excluded_deg)
    )
    is_free = total_error >= 90.0
    added_squares = np.where(
        is_free, 0.0, np.maximum(total_error**2 - fit_major**2 - excluded_error**2, 0.0)
    )
    major_deg = np.where(is_free, 90.0, np.minimum(np.sqrt(fit_major**2 + added_squares), 90.0))
    return major_deg, np.minimum(np.sqrt(fit_minor**2 + added_squares), 90.0)


def component_error_95(shape: FloatArray, step: FloatArray, direction: FloatArray) -> float:
    """Return the 95 % error of a component of the difference of two positions.

    Parameters
    ----------
    shape : (4, 4) ndarray
        Covariance of rotations about east, north and up (radians), and of the relative scale.
    step : (3,) ndarray
        Difference of the positions in the World frame.
    direction : (3,) ndarray
        Fixed direction of the component.

    Returns
    -------
    float
        In the unit of `step`.
    """
    gradient = np.append(np.cross(step, direction), float(step @ direction))
    return Z95 * float(np.sqrt(max(float(gradient @ shape @ gradient), 0.0)))


def horizontal_error_95(shape: FloatArray, step: FloatArray) -> float:
    """Return the 95 % error of the horizontal distance of two positions.

    For a vertical difference, whose horizontal part can only grow, it is the maximum over
    directions.

    Parameters
    ----------
    shape : (4, 4) ndarray
        See `component_error_95`.
    step : (3,) ndarray
        Difference of the positions in the World frame.

    Returns
    -------
    float
        In the unit of `step`.
    """
    horizontal_step = np.array([step[0], step[1], 0.0])
    length = float(np.linalg.norm(horizontal_step))
    if length > 1e-9 * float(np.linalg.norm(step)):
        return component_error_95(shape, step, horizontal_step / length)
    directions = np.array(
        [[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0.0, np.pi, 180, False)]
    )
    return max(component_error_95(shape, step, direction) for direction in directions)


def scale_error_95(shape: FloatArray) -> float:
    """Return the relative 95 % error of the scale.

    Parameters
    ----------
    shape : (4, 4) ndarray
        See `component_error_95`.

    Returns
    -------
    float
    """
    return Z95 * float(np.sqrt(max(float(shape[3, 3]), 0.0)))
