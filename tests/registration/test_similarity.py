"""Similarities between frames, and what positions leave undetermined."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.errors import GeometryError
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    rotation_covariance,
)


def some(n: int = 12, seed: int = 0) -> tuple[np.ndarray, Similarity]:
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=seed).as_matrix()
    return rng.normal(0, 5, (n, 3)), Similarity(3.7, rotation, np.array([100.0, -20, 5]))


@pytest.mark.parametrize("seed", range(5))
def test_a_similarity_is_found_again(seed: int) -> None:
    points, truth = some(seed=seed)
    found = fit_similarity(points, truth(points))
    assert found.scale == pytest.approx(3.7)
    assert found.rotation == pytest.approx(truth.rotation)
    assert found.translation == pytest.approx(truth.translation)
    assert found.inverse(found(points)) == pytest.approx(points)


def test_a_mirror_is_never_the_answer() -> None:
    points, _ = some()
    found = fit_similarity(points, points * [1, 1, -1])
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_points_of_a_plane_are_enough() -> None:
    points, truth = some()
    points[:, 2] = 0
    found = fit_similarity(points, truth(points))
    assert found.rotation == pytest.approx(truth.rotation)


def test_points_on_a_line_and_two_points_are_refused() -> None:
    line = np.outer(np.arange(6.0), [1, 2, 3])
    with pytest.raises(GeometryError, match="one line"):
        fit_similarity(line, line)
    with pytest.raises(GeometryError, match="at least 3"):
        fit_similarity(np.eye(3)[:2], np.eye(3)[:2])


def test_weights_of_nothing_leave_points_out() -> None:
    points, truth = some()
    target = truth(points)
    target[3] += 50
    weights = np.ones(len(points))
    weights[3] = 0
    assert fit_similarity(points, target, weights).scale == pytest.approx(3.7)


def test_a_third_of_wrong_points_does_no_harm() -> None:
    points, truth = some(15)
    rng = np.random.default_rng(1)
    target = truth(points) + rng.normal(0, 0.05, (15, 3))
    target[:5] += rng.normal(0, 30, (5, 3))
    found, used = fit_robustly(points, target)
    assert used.tolist() == [False] * 5 + [True] * 10
    assert found.scale == pytest.approx(3.7, rel=0.01)


@pytest.mark.parametrize("n", [8, 12, 30])
def test_good_points_are_seldom_left_out(n: int) -> None:
    left = 0
    for seed in range(20):
        points, truth = some(n, seed)
        noise = np.random.default_rng(seed).normal(0, 0.3, (n, 3))
        left += int((~fit_robustly(points, truth(points) + noise)[1]).sum())
    assert left / (20 * n) < 0.02


def test_the_stated_rotation_error_is_the_one_that_noise_makes() -> None:
    points, truth = some(10)
    target = truth(points)
    found = []
    for seed in range(400):
        noise = np.random.default_rng(seed).normal(0, 1.5, (10, 3))
        turned = fit_similarity(points, target + noise).rotation @ truth.rotation.T
        found.append(Rotation.from_matrix(turned).as_rotvec())
    stated = rotation_covariance(target, 1.5)
    assert np.cov(np.array(found).T) == pytest.approx(stated, abs=0.25 * stated.trace() / 3)


def test_the_rotation_error_of_points_on_the_axes_has_a_closed_form() -> None:
    """Pairs at a, b, c from the middle on the axes, errors of p, q, r along them: a turn about up
    moves the first pair along the second axis and the second along the first."""
    (a, b, c), (p, q, r) = (3.0, 2.0, 5.0), (0.1, 0.3, 0.2)
    pairs = np.diag([a, b, c])
    places = np.vstack([pairs, -pairs]) + [400.0, -70.0, 9.0]
    known = [2 * (b**2 / r**2 + c**2 / q**2), 2 * (a**2 / r**2 + c**2 / p**2)]
    known.append(2 * (a**2 / q**2 + b**2 / p**2))
    found = rotation_covariance(places, np.array([p, q, r]))
    assert found == pytest.approx(np.diag(1 / np.array(known)), rel=1e-9, abs=1e-15)
    # Turns are counted in the frame of the points.
    turn = Rotation.from_euler("xyz", [20, 50, -70], degrees=True).as_matrix()
    even = rotation_covariance(places, 0.1)
    assert rotation_covariance(places @ turn.T, 0.1) == pytest.approx(turn @ even @ turn.T)


def test_about_a_line_the_rotation_is_unknown() -> None:
    line = np.outer(np.arange(6.0), [1, 0, 0])
    covariance = rotation_covariance(line, 0.1)
    assert covariance[0, 0] > 1e5
    assert covariance[2, 2] < 1e-2
