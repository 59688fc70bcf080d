"""Attitudes of cameras as rotations, and as azimuth, elevation and roll of views.

Angles are in degrees: yaw is the azimuth of the view, clockwise from north (for a view straight
down that of the photo's top); pitch is its elevation, 0 level and -90 straight down; roll is 0 if
the photo's long side is level, and clockwise as the photographer tilts the camera. World is east,
north, up; cameras have x right, y down, z forward.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray

# Minimum horizontal component of a view with a defined azimuth.
MIN_HORIZONTAL = 1e-9


def camera_rotations(angles: npt.ArrayLike) -> FloatArray:
    """Return the rotations from cameras to World.

    Parameters
    ----------
    angles : (n, 3) array_like
        Yaw, pitch and roll, degrees.

    Returns
    -------
    (n, 3, 3) ndarray
    """
    yaw, pitch, roll = np.radians(np.asarray(angles, np.float64).reshape(-1, 3)).T
    forward = np.column_stack(
        [np.sin(yaw) * np.cos(pitch), np.cos(yaw) * np.cos(pitch), np.sin(pitch)]
    )
    level = np.column_stack([np.cos(yaw), -np.sin(yaw), np.zeros_like(yaw)])
    below = np.cross(forward, level)
    right = level * np.cos(roll)[:, None] + below * np.sin(roll)[:, None]
    down = below * np.cos(roll)[:, None] - level * np.sin(roll)[:, None]
    return np.stack([right, down, forward], axis=2)


def error_axes(angles: npt.ArrayLike) -> FloatArray:
    """Return the axes about which errors of yaw, pitch and roll rotate a camera.

    They are down, its level side, and level ahead: an instrument measures north and the vertical.
    The vertical is as accurate to the side as ahead, also for a camera that looks down, where roll
    about the view would be yaw.

    Parameters
    ----------
    angles : (n, 3) array_like
        Yaw, pitch and roll, degrees.

    Returns
    -------
    (n, 3, 3) ndarray
        The axes are the columns.
    """
    yaw = np.radians(np.asarray(angles, np.float64).reshape(-1, 3)[:, 0])
    zero = np.zeros_like(yaw)
    down = np.column_stack([zero, zero, zero - 1.0])
    level = np.column_stack([np.cos(yaw), -np.sin(yaw), zero])
    ahead = np.column_stack([np.sin(yaw), np.cos(yaw), zero])
    return np.stack([down, level, ahead], axis=2)


def view_angles(rotations: npt.ArrayLike) -> FloatArray:
    """Return yaw, pitch and roll of views.

    Parameters
    ----------
    rotations : (n, 3, 3) array_like
        From cameras to World.

    Returns
    -------
    (n, 3) ndarray
        Degrees; views straight up or down have roll 0.
    """
    right, down, forward = np.moveaxis(np.asarray(rotations, np.float64).reshape(-1, 3, 3), 2, 0)
    flat = np.hypot(forward[:, 0], forward[:, 1])
    steep = flat < MIN_HORIZONTAL
    # The photo's top is ahead for views down, and behind for views up.
    ahead = np.where(
        steep[:, None], np.where(forward[:, 2:] < 0, -down[:, :2], down[:, :2]), forward[:, :2]
    )
    yaw = np.arctan2(ahead[:, 0], ahead[:, 1])
    pitch = np.arctan2(forward[:, 2], flat)
    level = np.column_stack([np.cos(yaw), -np.sin(yaw), np.zeros_like(yaw)])
    below = np.cross(forward, level)
    roll = np.arctan2((right * below).sum(axis=1), (right * level).sum(axis=1))
    angles = np.column_stack([yaw % (2 * np.pi), pitch, np.where(steep, 0.0, roll)])
    return np.asarray(np.degrees(angles), np.float64)


def nadir_to_view_angles(angles: npt.ArrayLike) -> FloatArray:
    """Convert the attitude of an aircraft with a nadir camera to that of its views.

    The photo's top is ahead, as in Pix4D and OpenDroneMap: rotations about down, then right, then
    ahead (R = Rz Ry Rx in north, east, down; Pix4D, "Yaw, Pitch, Roll and Omega, Phi, Kappa
    angles").

    Parameters
    ----------
    angles : (n, 3) array_like
        Yaw, pitch and roll of the aircraft, degrees.

    Returns
    -------
    (n, 3) ndarray
        Yaw, pitch and roll of the views, degrees.
    """
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_euler("ZYX", np.asarray(angles, np.float64).reshape(-1, 3), degrees=True)
    ahead, right, down = np.moveaxis(turns.as_matrix(), 2, 0)
    cameras = np.stack([right, -ahead, down], axis=2)
    to_world = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    return view_angles(to_world @ cameras)


def rotations_from_vertical(down: npt.ArrayLike, azimuth_deg: npt.ArrayLike) -> FloatArray:
    """Return the rotations from cameras to World by the vertical and the azimuth of the view.

    Parameters
    ----------
    down : (n, 3) array_like
        Direction of gravity in the frame of each camera.
    azimuth_deg : (n,) array_like
        Azimuth of the view; views straight up or down have none.

    Returns
    -------
    (n, 3, 3) ndarray
    """
    vertical = np.asarray(down, np.float64).reshape(-1, 3)
    vertical = vertical / np.linalg.norm(vertical, axis=1, keepdims=True)
    pitch = np.degrees(np.arcsin(np.clip(-vertical[:, 2], -1.0, 1.0)))
    roll = np.degrees(np.arctan2(vertical[:, 0], vertical[:, 1]))
    yaw = np.broadcast_to(np.asarray(azimuth_deg, np.float64), pitch.shape)
    return camera_rotations(np.column_stack([yaw, pitch, roll]))
