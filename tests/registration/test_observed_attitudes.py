"""How misses of attitudes change, held against small moves that are really made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.registrations import TURN
from vomstudio.geology.view_attitudes import camera_rotations, error_axes
from vomstudio.registration.observations import Attitudes, Azimuths, ObservationKind, Verticals
from vomstudio.registration.similarity import Similarity

Array = npt.NDArray[np.float64]

FIT = Similarity(2.0, TURN, np.zeros(3))
ANGLES = np.array([[10, 0, 5], [100, -40, -3], [250, -90, 0], [300, 20, 90]], float)
CAMERAS = camera_rotations(ANGLES)
MODEL = TURN.T @ CAMERAS
LABELS = list("abcd")
NONE = np.full((4, 3), np.nan)


def observed(kind: str) -> ObservationKind:
    """Without any miss."""
    if kind == "attitudes":
        return Attitudes(LABELS, MODEL, CAMERAS, error_axes(ANGLES), NONE, 0.2, 0.02)
    if kind == "verticals":
        down = MODEL @ -CAMERAS[:, 2, :, None]
        return Verticals(LABELS, down[:, :, 0], NONE[:, :2], MODEL, 0.02)
    which = [0, 1, 3]
    azimuths = np.radians(ANGLES[which, 0])
    return Azimuths(list("abd"), MODEL[which][:, :, 2], azimuths, NONE[which, 0], 0.2)


@pytest.mark.parametrize("kind", ["attitudes", "verticals", "azimuths"])
def test_attitude_residuals_change_linearly_with_a_small_rotation(kind: str) -> None:
    rows = observed(kind).rows(FIT, np.zeros(3))
    np.testing.assert_allclose(rows.residuals, 0.0, atol=1e-9)
    for axis in np.eye(3):
        turned = replace(FIT, rotation=Rotation.from_rotvec(1e-5 * axis).as_matrix() @ TURN)
        change = observed(kind).rows(turned, np.zeros(3)).residuals / 1e-5
        np.testing.assert_allclose(change, rows.design[:, :3] @ axis, atol=1e-4)


def test_wrong_north_is_one_error_common_to_all_photos() -> None:
    """Yaws of all photos are read 0.01 rad too large: predicted less observed falls by as much."""
    off = 1e-3
    for kind, given in (("attitudes", ANGLES), ("azimuths", ANGLES[[0, 1, 3]])):
        right = observed(kind)
        rows = right.rows(FIT, np.zeros(3))
        read = given + [np.degrees(off), 0.0, 0.0]
        wrong = (
            replace(right, world=camera_rotations(read), axes=error_axes(read))
            if isinstance(right, Attitudes)
            else replace(right, azimuth=np.radians(read[:, 0]))  # type: ignore[type-var]
        )
        change = wrong.rows(FIT, np.zeros(3)).residuals
        north = rows.shared_design[:, 0]
        # By the first shared error, and by nothing else, up to its sign.
        amount = float(change @ north) / float(north @ north)
        np.testing.assert_allclose(change, amount * north, atol=1e-6)
        assert abs(amount) == pytest.approx(off, rel=1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_sensor_misalignment_is_one_error_common_to_all_photos(axis: int) -> None:
    """The sensor is turned by 0.001 rad about an axis of each camera."""
    off = Rotation.from_rotvec(1e-3 * np.eye(3)[axis]).as_matrix()
    attitudes, verticals = observed("attitudes"), observed("verticals")
    assert isinstance(attitudes, Attitudes)
    assert isinstance(verticals, Verticals)
    read = replace(attitudes, world=CAMERAS @ off)
    felt = (off.T @ -CAMERAS[:, 2, :, None])[:, :, 0]
    fell = replace(verticals, model=np.einsum("nij,nj->ni", MODEL, felt))
    for right, wrong, first in ((attitudes, read, 1), (verticals, fell, 0)):
        column = right.rows(FIT, np.zeros(3)).shared_design[:, first + axis]
        change = wrong.rows(FIT, np.zeros(3)).residuals
        np.testing.assert_allclose(change, -1e-3 * column, atol=2e-6)


def test_upside_down_model_has_residuals_of_180_degrees() -> None:
    over = replace(FIT, rotation=np.diag([1.0, -1.0, -1.0]) @ TURN)
    rows = observed("verticals").rows(over, np.zeros(3))
    np.testing.assert_allclose(np.hypot(rows.residuals[::2], rows.residuals[1::2]), np.pi)
