from __future__ import annotations

import numpy as np
import pytest

from vomstudio.extraction.planarity import local_eigenvalues, near_planar_share


def test_a_ball_of_points_has_equal_eigenvalues_and_a_disc_has_none_across():
    rng = np.random.default_rng(1)
    ball = rng.normal(size=(1000, 3))
    np.testing.assert_allclose(local_eigenvalues(ball, 100.0)[0], [1 / 3] * 3, atol=0.05)
    disc = ball * [1.0, 1.0, 0.0] + [5e5, 5e6, 0.0]
    np.testing.assert_allclose(local_eigenvalues(disc, 100.0)[0], [0.5, 0.5, 0.0], atol=0.06)


def test_each_neighbourhood_agrees_with_numpys_covariance():
    points = np.random.default_rng(2).normal(size=(300, 3)) * [3, 2, 0.2]
    found = local_eigenvalues(points, 1.0)
    for i in (0, 10, 200):
        near = points[np.linalg.norm(points - points[i], axis=1) <= 1.0]
        if len(near) >= 10:
            values = np.linalg.eigvalsh(np.cov(near.T, bias=True))[::-1]
            np.testing.assert_allclose(found[i], values / values.sum(), atol=1e-12)


def test_lonely_points_say_nothing():
    points = np.array([[0.0, 0, 0], [100.0, 0, 0], [0, 100.0, 0]])
    assert np.isnan(local_eigenvalues(points, 1.0)).all()
    assert np.isnan(near_planar_share(points, 1.0))


def test_half_a_wall_and_half_a_hedge_are_half_near_planar():
    rng = np.random.default_rng(3)
    wall = np.column_stack([rng.uniform(0, 10, (2000, 2)), 0.002 * rng.normal(size=2000)])
    hedge = rng.uniform(0, 5, (2000, 3)) + [100.0, 0, 0]
    share = near_planar_share(np.concatenate([wall, hedge]), 1.0)
    assert share == pytest.approx(0.5, abs=0.02)
