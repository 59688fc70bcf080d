"""Sums over points near places, against every point being asked."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.core.errors import Cancelled
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.nearby.point_grid import PointGrid

CORNER = np.array([364_520.25, 4_721_864.5, -846.0])


def cloud(n: int = 3000, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.uniform(0, [4, 3, 2], (n, 3)) ** [1, 1, 2] + CORNER


@pytest.mark.parametrize("cell", [0.05, 0.3, 2.0])
def test_planes_use_all_points_within_the_radius(cell: float) -> None:
    points = cloud()
    places = np.concatenate([points[::100], CORNER + [[9.0, 9.0, 9.0], [-0.2, 1.0, 1.0]]])
    found = PointGrid(points, cell).planes(places, 0.3)
    for row, place in enumerate(places):
        near = points[np.linalg.norm(points - place, axis=1) <= 0.3]
        assert found.count[row] == len(near)
        if len(near) < 3:
            assert np.isnan(found.normal[row]).all()
            continue
        assert found.mean[row] == pytest.approx(near.mean(axis=0), abs=1e-8)
        values, axes = np.linalg.eigh(np.cov(near.T, ddof=0))
        assert found.spread[row] == pytest.approx(values, rel=1e-6, abs=1e-12)
        assert abs(found.normal[row] @ axes[:, 0]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("cell", "reach"), [(0.2, 0.15), (0.2, 1.3), (0.05, 0.7), (3.0, 5.0)])
def test_cylinders_contain_expected_points(cell: float, reach: float) -> None:
    points, radius = cloud(), 0.2
    places = points[::100] + 0.01
    axes = np.random.default_rng(2).normal(size=places.shape)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    axes[:3] = np.eye(3)
    found = PointGrid(points, cell).along(places, axes, radius, reach)
    for row, (place, axis) in enumerate(zip(places, axes, strict=True)):
        along = (points - place) @ axis
        off = np.linalg.norm(points - place - along[:, None] * axis, axis=1)
        inside = along[(off <= radius) & (np.abs(along) <= reach)]
        assert found.count[row] == len(inside)
        if len(inside) > 1:
            assert found.mean[row] == pytest.approx(inside.mean(), abs=1e-8)
            assert found.deviation[row] == pytest.approx(inside.std(ddof=1), abs=1e-8)


def test_planes_with_equal_eigenvalues_and_exact_lines_are_fitted() -> None:
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    level = np.column_stack([x.ravel(), y.ravel(), np.full(25, 7.0)])
    found = PointGrid(level, 1.0).planes(level, 1.5)
    assert np.abs(found.normal[:, 2]) == pytest.approx(np.ones(25))
    assert found.spread[12] == pytest.approx([0.0, 6 / 9, 6 / 9])
    line = level[:5]
    found = PointGrid(line, 1.0).planes(line, 2.5)
    assert found.spread[2] == pytest.approx([0.0, 0.0, 2.0], abs=1e-12)


def test_invalid_distant_and_missing_points_are_handled() -> None:
    points = np.array([[np.nan, 0, 0], [0.0, 0, 0], [1e7, 1e7, 1e7]])
    assert PointGrid(points, 1e-3).planes(points[1:], 0.5).count.tolist() == [1, 1]
    assert PointGrid(np.zeros((0, 3)), 1.0).planes(points[1:], 0.5).count.tolist() == [0, 0]


def test_construction_can_be_cancelled() -> None:
    points = np.random.default_rng(1).uniform(0, 1, (60_000, 3))
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        PointGrid(points, 0.02).planes(points, 0.02, SilentProgress(token))
