"""How cameras are held: rotations from the azimuth, elevation and roll of their views, and back.

Angles are degrees: yaw is the azimuth of the view, clockwise from north (of a view straight down
that of the photo's top); pitch its elevation, 0 level and -90 straight down; roll is 0 where the
photo's long side is level, and clockwise as the photographer tilts the camera. World is east,
north, up; cameras have x right, y down, z forward.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray

# From the vertical: nearer to it the azimuth of a view means nothing.
_STEEP = 1e-9


def camera_rotations(angles: npt.ArrayLike) -> FloatArray:
    """(n, 3, 3) rotations from cameras to World; angles : (n, 3) yaw, pitch, roll."""
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
    """(n, 3, 3) the axes, as columns, about which errors of yaw, pitch and roll turn a camera:
    down, its level side, and what is level ahead of it.

    An instrument finds north and the vertical. The vertical is as good to the side as it is ahead,
    also where a camera looks down, and roll about the view would be yaw.
    angles : (n, 3) yaw, pitch, roll
    """
    yaw = np.radians(np.asarray(angles, np.float64).reshape(-1, 3)[:, 0])
    zero = np.zeros_like(yaw)
    down = np.column_stack([zero, zero, zero - 1.0])
    level = np.column_stack([np.cos(yaw), -np.sin(yaw), zero])
    ahead = np.column_stack([np.sin(yaw), np.cos(yaw), zero])
    return np.stack([down, level, ahead], axis=2)


def view_angles(rotations: npt.ArrayLike) -> FloatArray:
    """(n, 3) yaw, pitch, roll of rotations (n, 3, 3) from cameras to World; a view straight up or
    down has roll 0."""
    right, down, forward = np.moveaxis(np.asarray(rotations, np.float64).reshape(-1, 3, 3), 2, 0)
    flat = np.hypot(forward[:, 0], forward[:, 1])
    steep = flat < _STEEP
    # The photo's top is ahead where it looks down, and behind where it looks up.
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


def of_nadir_body(angles: npt.ArrayLike) -> FloatArray:
    """(n, 3) yaw, pitch, roll of views from those of an aircraft below which the camera looks
    straight down with the photo's top ahead, as Pix4D and OpenDroneMap have it: turns about down,
    then right, then ahead (R = Rz Ry Rx in north, east, down; Pix4D, "Yaw, Pitch, Roll and Omega,
    Phi, Kappa angles")."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_euler("ZYX", np.asarray(angles, np.float64).reshape(-1, 3), degrees=True)
    ahead, aside, below = np.moveaxis(turns.as_matrix(), 2, 0)
    cameras = np.stack([aside, -ahead, below], axis=2)
    to_world = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    return view_angles(to_world @ cameras)


def from_down_and_azimuth(down: npt.ArrayLike, azimuth_deg: npt.ArrayLike) -> FloatArray:
    """(n, 3, 3) rotations from cameras to World, from the direction in which things fall, in the
    frame of each camera (n, 3), and the azimuth of its view (n,). Views straight up or down have
    none."""
    vertical = np.asarray(down, np.float64).reshape(-1, 3)
    vertical = vertical / np.linalg.norm(vertical, axis=1, keepdims=True)
    pitch = np.degrees(np.arcsin(np.clip(-vertical[:, 2], -1.0, 1.0)))
    roll = np.degrees(np.arctan2(vertical[:, 0], vertical[:, 1]))
    yaw = np.broadcast_to(np.asarray(azimuth_deg, np.float64), pitch.shape)
    return camera_rotations(np.column_stack([yaw, pitch, roll]))
