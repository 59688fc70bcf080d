"""Attitudes of cameras as rotations, or as azimuth, elevation and roll of their views.

Angles are in degrees. Yaw is the azimuth of the view, clockwise from north (for a view straight
down, the azimuth of the top of the photo). Pitch is the elevation of the view, 0 if level and -90
if straight down. Roll is 0 if the long side of the photo is level, and positive if the photographer
tilts the camera clockwise. The World frame is east, north, up; camera axes are x right, y down, z
forward.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray

# Minimum horizontal component of a view for its azimuth to be defined.
MIN_HORIZONTAL_LENGTH = 1e-9


def camera_rotations(angles: npt.ArrayLike) -> FloatArray:
    """Return the rotations from the camera frames to the World frame.

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
    down_axis = np.cross(forward, level)
    right = level * np.cos(roll)[:, None] + down_axis * np.sin(roll)[:, None]
    down = down_axis * np.cos(roll)[:, None] - level * np.sin(roll)[:, None]
    return np.stack([right, down, forward], axis=2)


def error_axes(angles: npt.ArrayLike) -> FloatArray:
    """Return the axes about which errors of yaw, pitch and roll rotate a camera.

    These are the downward axis, the level side axis and the level forward axis, because an
    instrument measures north and the vertical. The vertical has the same accuracy sideways and
    forward. This also applies to a camera that looks down, for which a roll about the view would be
    a yaw.

    Parameters
    ----------
    angles : (n, 3) array_like
        Yaw, pitch and roll, degrees.

    Returns
    -------
    (n, 3, 3) ndarray
        Axes as columns, in the World frame.
    """
    yaw = np.radians(np.asarray(angles, np.float64).reshape(-1, 3)[:, 0])
    zeros = np.zeros_like(yaw)
    down = np.column_stack([zeros, zeros, zeros - 1.0])
    level = np.column_stack([np.cos(yaw), -np.sin(yaw), zeros])
    forward = np.column_stack([np.sin(yaw), np.cos(yaw), zeros])
    return np.stack([down, level, forward], axis=2)


def view_angles(rotations: npt.ArrayLike) -> FloatArray:
    """Return the yaw, pitch and roll of views.

    Parameters
    ----------
    rotations : (n, 3, 3) array_like
        Rotations from the camera frames to the World frame.

    Returns
    -------
    (n, 3) ndarray
        Angles in degrees; the roll of views straight up or down is 0.
    """
    right, down, forward = np.moveaxis(np.asarray(rotations, np.float64).reshape(-1, 3, 3), 2, 0)
    horizontal_lengths = np.hypot(forward[:, 0], forward[:, 1])
    is_steep = horizontal_lengths < MIN_HORIZONTAL_LENGTH
    # The top of the photo is forward for downward views, and backward for upward views.
    forward_direction = np.where(
        is_steep[:, None], np.where(forward[:, 2:] < 0, -down[:, :2], down[:, :2]), forward[:, :2]
    )
    yaw = np.arctan2(forward_direction[:, 0], forward_direction[:, 1])
    pitch = np.arctan2(forward[:, 2], horizontal_lengths)
    level = np.column_stack([np.cos(yaw), -np.sin(yaw), np.zeros_like(yaw)])
    down_axis = np.cross(forward, level)
    roll = np.arctan2((right * down_axis).sum(axis=1), (right * level).sum(axis=1))
    angles = np.column_stack([yaw % (2 * np.pi), pitch, np.where(is_steep, 0.0, roll)])
    return np.asarray(np.degrees(angles), np.float64)


def nadir_to_view_angles(angles: npt.ArrayLike) -> FloatArray:
    """Convert attitudes of an aircraft with a nadir camera to attitudes of its views.

    The top of the photo points forward, as in Pix4D and OpenDroneMap. The rotations are about the
    down, right and forward axes, in this order (R = Rz Ry Rx in north, east, down; Pix4D, "Yaw,
    Pitch, Roll and Omega, Phi, Kappa angles").

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

    view_rotations = Rotation.from_euler(
        "ZYX", np.asarray(angles, np.float64).reshape(-1, 3), degrees=True
    )
    forward, right, down = np.moveaxis(view_rotations.as_matrix(), 2, 0)
    cameras = np.stack([right, -forward, down], axis=2)
    world_axes = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    return view_angles(world_axes @ cameras)


def rotations_from_vertical(down: npt.ArrayLike, azimuth_deg: npt.ArrayLike) -> FloatArray:
    """Return the rotations from camera to World for given verticals and view azimuths.

    Parameters
    ----------
    down : (n, 3) array_like
        Direction of gravity in the frame of each camera.
    azimuth_deg : (n,) array_like
        Azimuths of the views, degrees; undefined for views straight up or down.

    Returns
    -------
    (n, 3, 3) ndarray
    """
    down_vectors = np.asarray(down, np.float64).reshape(-1, 3)
    down_vectors = down_vectors / np.linalg.norm(down_vectors, axis=1, keepdims=True)
    pitch = np.degrees(np.arcsin(np.clip(-down_vectors[:, 2], -1.0, 1.0)))
    roll = np.degrees(np.arctan2(down_vectors[:, 0], down_vectors[:, 1]))
    yaw = np.broadcast_to(np.asarray(azimuth_deg, np.float64), pitch.shape)
    return camera_rotations(np.column_stack([yaw, pitch, roll]))
