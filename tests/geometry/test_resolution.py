"""Effective resolution against laws: a Poisson process, a grid, and known noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vomstudio.geometry.resolution import SmallPointTree, effective_resolution
from vomstudio.geometry.surface import VertexSurface

DENSITY = 400.0


def at_random(noise: float = 0.0, density: float = DENSITY, seed: int = 0) -> np.ndarray:
    """Points of a Poisson process on a tilted plane of 10 x 10, with noise across it, at UTM."""
    rng = np.random.default_rng(seed)
    flat = np.column_stack([rng.random((int(100 * density), 2)) * 10, np.zeros(int(100 * density))])
    flat[:, 2] = rng.normal(0, noise, len(flat)) if noise else 0.0
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return flat @ turn.T + [465_123.0, 4_612_345.0, 820.0]


def resolved(points: np.ndarray, step: int = 131) -> float:
    local = points - points.mean(axis=0)
    found = effective_resolution(local, cKDTree(local), local[::step])
    assert found is not None
    return found


def test_random_points_resolve_inverse_root_of_density():
    """Twice the mean gap to the nearest neighbour (Clark and Evans 1954)."""
    points = at_random()
    assert resolved(points) == pytest.approx(1 / np.sqrt(DENSITY), rel=0.05)
    gaps = cKDTree(points - points[0]).query(points - points[0], k=2)[0][:, 1]
    assert gaps.mean() == pytest.approx(0.5 / np.sqrt(DENSITY), rel=0.05)


def test_grid_resolution_is_its_step_at_any_rotation():
    x, y = np.meshgrid(np.arange(60) * 0.05, np.arange(60) * 0.05)
    grid = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    assert resolved(grid, 17) == pytest.approx(0.05, rel=0.08)


@pytest.mark.parametrize("times", [0.3, 1.5, 3.0, 5.0])
def test_noise_larger_than_the_spacing_is_the_resolution(times):
    spacing = 1 / np.sqrt(DENSITY)
    found = resolved(at_random(times * spacing))
    assert found == pytest.approx(max(times, 1.0) * spacing, rel=0.12)


def test_four_times_the_points_halve_the_resolution():
    assert resolved(at_random(density=4 * 100)) == pytest.approx(
        0.5 * resolved(at_random(density=100)), rel=0.06
    )


def test_duplicate_points_do_not_improve_resolution():
    points = at_random(density=50)
    assert resolved(np.repeat(points, 2, axis=0)) == pytest.approx(resolved(points), rel=0.1)


@pytest.mark.parametrize("built", [False, True])
def test_local_resolution_of_surface_matches(built):
    points = at_random(noise=3.0 / np.sqrt(DENSITY), density=DENSITY)
    surface = VertexSurface(points)
    if built:
        surface.build()
    found = surface.local_resolution(points[::4000])
    assert found == pytest.approx(3.0 / np.sqrt(DENSITY), rel=0.2)


def test_coincident_points_have_no_resolution():
    points = np.zeros((50, 3))
    assert effective_resolution(points, cKDTree(points), points[:3]) is None


def test_few_points_need_no_tree_for_the_same_answer():
    points = at_random(noise=0.02, density=2.5) - [465_123.0, 4_612_345.0, 820.0]
    few = effective_resolution(points, SmallPointTree(points), points)
    assert few == pytest.approx(effective_resolution(points, cKDTree(points), points), rel=1e-9)


def test_ledges_do_not_count_as_noise():
    """A cliff of steps, each surface a grid of 5 cm without any noise: its treads and risers are as
    deep as ten points are apart."""
    step, depth = 0.05, 0.5
    along, up = np.meshgrid(np.arange(80) * step, np.arange(10) * step)
    faces = []
    for level in range(8):
        riser = np.stack([along, 0 * along + level * depth, up + level * depth], -1)
        tread = np.stack([along, up + level * depth, 0 * along + (level + 1) * depth], -1)
        faces += [riser.reshape(-1, 3), tread.reshape(-1, 3)]
    cliff = np.concatenate(faces)
    assert resolved(cliff) == pytest.approx(step, rel=0.15)
