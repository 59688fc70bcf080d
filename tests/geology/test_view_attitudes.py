"""Yaw, pitch and roll, held against turns that are built from what the words mean."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from vomstudio.geology.view_attitudes import (
    camera_rotations,
    nadir_to_view_angles,
    rotations_from_vertical,
    view_angles,
)

NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""North, east, down to east, north, up."""
EAST, NORTH, UP = np.eye(3)


@pytest.mark.parametrize(
    ("angles", "right", "down", "forward"),
    [
        ([0, 0, 0], EAST, -UP, NORTH),
        ([90, 0, 0], -NORTH, -UP, EAST),
        # Straight down: the photo's top points to the yaw.
        ([0, -90, 0], EAST, -NORTH, -UP),
        ([90, -90, 0], -NORTH, -EAST, -UP),
        # The camera's right side was lowered: clockwise as the photographer sees it.
        ([0, 0, 90], -UP, -EAST, NORTH),
        ([0, 30, 0], EAST, [0, 0.5, -np.sqrt(0.75)], [0, np.sqrt(0.75), 0.5]),
    ],
)
def test_angles_give_expected_camera_axes(angles, right, down, forward) -> None:
    rotation = camera_rotations([angles])[0]
    np.testing.assert_allclose(rotation, np.column_stack([right, down, forward]), atol=1e-12)


@given(st.floats(-180, 360), st.floats(-89.9, 89.9), st.floats(-180, 180))
def test_yaw_pitch_roll_matches_aircraft_convention(yaw, pitch, roll) -> None:
    """The convention of DJI and of aircraft, whose axes are ahead, right and down."""
    body = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True).as_matrix()
    camera = NED @ body[:, [1, 2, 0]]
    np.testing.assert_allclose(camera_rotations([[yaw, pitch, roll]])[0], camera, atol=1e-9)
    again = camera_rotations(view_angles(camera[None]))[0]
    np.testing.assert_allclose(again, camera, atol=1e-9)


@pytest.mark.parametrize("pitch", [-90.0, 90.0])
def test_vertical_views_round_trip_with_zero_roll(pitch: float) -> None:
    for yaw, roll in ((30.0, 0.0), (200.0, 50.0), (10.0, 180.0)):
        camera = camera_rotations([[yaw, pitch, roll]])
        angles = view_angles(camera)
        assert angles[0, 2] == pytest.approx(0.0, abs=1e-9)
        np.testing.assert_allclose(camera_rotations(angles), camera, atol=1e-9)


@pytest.mark.parametrize(
    ("body", "view"),
    [
        ([0, 0, 0], [0, -90, 0]),
        ([90, 0, 0], [90, -90, 0]),
        # Pix4D: a pitch of 90 looks ahead.
        ([0, 90, 0], [0, 0, 0]),
        ([40, 60, 0], [40, -30, 0]),
    ],
)
def test_nadir_camera_of_aircraft_gives_expected_view_angles(body, view) -> None:
    found = nadir_to_view_angles([body])
    np.testing.assert_allclose(camera_rotations(found), camera_rotations([view]), atol=1e-9)


def test_nadir_camera_looks_left_if_aircraft_banks_right() -> None:
    """The right wing is lowered by 20 degrees: the camera below looks to the left, and the top of
    the photo stays ahead."""
    right, down, forward = camera_rotations(nadir_to_view_angles([[0, 0, 20]]))[0].T
    s, c = np.sin(np.radians(20)), np.cos(np.radians(20))
    np.testing.assert_allclose(forward, [-s, 0, -c], atol=1e-12)
    np.testing.assert_allclose(down, -NORTH, atol=1e-12)
    np.testing.assert_allclose(right, [c, 0, -s], atol=1e-12)


def test_vertical_and_azimuth_determine_camera_attitude() -> None:
    rng = np.random.default_rng(0)
    angles = np.column_stack(
        [rng.uniform(0, 360, 50), rng.uniform(-80, 80, 50), rng.uniform(-180, 180, 50)]
    )
    cameras = camera_rotations(angles)
    down = -cameras[:, 2, :]
    np.testing.assert_allclose(
        rotations_from_vertical(9.81 * down, angles[:, 0]), cameras, atol=1e-9
    )
