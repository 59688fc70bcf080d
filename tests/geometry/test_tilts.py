"""What an error of a model's rotation does to planes and lines: closed forms and drawn turns."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from vomstudio.geometry.rotation_errors import CHI2_TWO, direction_covariance, errors_95_deg


def test_limit_is_the_two_dimensional_chi_square_quantile() -> None:
    assert pytest.approx(chi2.ppf(0.95, 2)) == CHI2_TWO


def test_rotation_error_about_vertical_affects_only_steep_planes() -> None:
    """About up by 1 degree (1 sigma): the pole of an upright plane by as much, that of a flat one
    not at all, that of one that dips 30 degrees by sin 30 of it."""
    rotation = np.diag([0.0, 0.0, np.radians(1.0) ** 2])
    poles = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.5, np.sqrt(0.75)]])
    told = errors_95_deg(rotation, poles)
    assert told == pytest.approx(np.sqrt(chi2.ppf(0.95, 2)) * np.array([1.0, 0.0, 0.5]))


def test_isotropic_rotation_error_gives_a_cone() -> None:
    rotation = np.eye(3) * np.radians(2.0) ** 2
    poles = Rotation.random(20, random_state=1).as_matrix()[:, 0]
    assert errors_95_deg(rotation, poles) == pytest.approx(2.0 * np.sqrt(chi2.ppf(0.95, 2)))
    spread = direction_covariance(rotation, poles)
    # Nothing along the pole itself.
    assert np.einsum("ni,nij,nj->n", poles, spread, poles) == pytest.approx(0.0, abs=1e-15)


def test_sampled_rotations_stay_within_half_angle_as_often_as_stated() -> None:
    rng = np.random.default_rng(4)
    root = rng.normal(size=(3, 3)) * np.radians(1.5)
    rotation = root @ root.T
    pole = np.array([0.6, 0.0, 0.8])
    limit = errors_95_deg(rotation, pole[None])[0]
    turns = Rotation.from_rotvec(rng.normal(size=(20_000, 3)) @ root.T)
    off = np.degrees(np.arccos(np.clip(turns.apply(pole) @ pole, -1.0, 1.0)))
    assert 0.945 < (off <= limit).mean() < 0.985


def test_errors_are_invariant_to_rotation_about_vertical() -> None:
    rng = np.random.default_rng(5)
    root = rng.normal(size=(3, 3)) * 0.02
    rotation, pole = root @ root.T, np.array([[0.36, 0.48, 0.8]])
    turn = Rotation.from_euler("z", 30.0, degrees=True).as_matrix()
    moved = errors_95_deg(turn @ rotation @ turn.T, pole @ turn.T)
    assert moved == pytest.approx(errors_95_deg(rotation, pole))
