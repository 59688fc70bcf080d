"""Normals and their angles, batched. World frame: x East, y North, z Up."""

from __future__ import annotations

from typing import overload

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray

# Sine of the tilt below which a plane or a normal is horizontal within rounding.
MIN_TILT = 1e-12


@overload
def wrap360(angle_deg: float) -> float: ...
@overload
def wrap360(angle_deg: FloatArray) -> FloatArray: ...
def wrap360(angle_deg: float | FloatArray) -> float | FloatArray:
    """Wrap an azimuth to [0, 360), never returning -0.0 or 360.0.

    Parameters
    ----------
    angle_deg : float or ndarray

    Returns
    -------
    float or ndarray
    """
    # mod(-1e-20, 360) is 360.0 itself; adding 0.0 turns -0.0 into 0.0.
    if type(angle_deg) is float or np.ndim(angle_deg) == 0:
        # Python's remainder is NumPy's, in a twentieth of the time.
        wrapped_scalar = float(angle_deg) % 360.0
        return 0.0 if wrapped_scalar >= 360.0 else wrapped_scalar + 0.0
    wrapped_angle = np.mod(angle_deg, 360.0)
    return np.where(wrapped_angle >= 360.0, 0.0, wrapped_angle) + 0.0


def flip_upward(normals: FloatArray) -> FloatArray:
    """Flip normals upward; a horizontal normal points to an azimuth in [90, 270).

    In this half, the right-hand-rule strike of a vertical plane is in [0, 180).

    Parameters
    ----------
    normals : (m, 3) ndarray

    Returns
    -------
    (m, 3) ndarray
    """
    x, y, z = normals[:, 0], normals[:, 1], normals[:, 2]
    is_level = np.abs(z) <= MIN_TILT
    is_downward = np.where(is_level, (y > 0.0) | ((y == 0.0) & (x < 0.0)), z < 0.0)
    result: FloatArray = (
        np.where(is_downward[:, None], -normals, normals) + 0.0
    )  # + 0.0: no negative zero
    result[:, 2] = np.where(is_level, 0.0, result[:, 2])
    return result


def dips_from_normals(
    normals: FloatArray, min_tilt: FloatArray | float = MIN_TILT
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the dip direction and dip of upward normals.

    Parameters
    ----------
    normals : (m, 3) ndarray
    min_tilt : ndarray or float, optional
        Sine of the tilt below which a plane is horizontal; its dip direction is then 0 and
        undefined.

    Returns
    -------
    dip_direction_deg : (m,) ndarray
        In [0, 360).
    dip_deg : (m,) ndarray
        In [0, 90].
    undefined : (m,) ndarray of bool
    """
    horizontal_length = np.hypot(normals[:, 0], normals[:, 1])
    is_flat = horizontal_length <= min_tilt
    azimuth = wrap360(np.degrees(np.arctan2(normals[:, 0], normals[:, 1])))
    azimuth = np.where(is_flat, 0.0, azimuth)
    dip = np.where(is_flat, 0.0, np.degrees(np.arctan2(horizontal_length, normals[:, 2])))
    return azimuth, dip, is_flat


def strike_and_dip_lines(
    dip_direction_deg: FloatArray, dip_deg: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors along the right-hand-rule strike and down the dip of planes.

    Parameters
    ----------
    dip_direction_deg, dip_deg : (m,) ndarray

    Returns
    -------
    strike, dip : (m, 3) ndarray
    """
    a, d = np.radians(dip_direction_deg), np.radians(dip_deg)
    zeros = np.zeros_like(a)
    strike = np.stack([-np.cos(a), np.sin(a), zeros], axis=1)
    down = np.stack([np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), -np.sin(d)], axis=1)
    return strike, down
