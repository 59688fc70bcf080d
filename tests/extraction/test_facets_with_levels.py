"""Facets, and patches of what they are, whose points lie at two levels or in two layers."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.planes_by_construction import angle_deg, axes_of, grid_mesh, normal_of
from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.extraction.facets import FacetSegmentation, find_facets
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

ATTITUDE = (100.0, 60.0)
NOISE = 0.004


def turned(x: np.ndarray, y: np.ndarray, height: np.ndarray) -> np.ndarray:
    u, v = axes_of(*ATTITUDE)
    n = normal_of(*ATTITUDE)
    return x[:, None] * u + y[:, None] * v + height[:, None] * n


def at_two_levels(seed: int, times: float, share: float = 0.5, *, over: bool = False) -> PointCloud:
    """2 x 2 m with a step of so many times the noise, or with a layer over the other."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-1.0, 1.0, (2, 8000))
    up = rng.random(8000) < share if over else x > 1.0 - 2.0 * share
    return PointCloud(turned(x, y, NOISE * (rng.standard_normal(8000) + times * up)))


def are_told(result: FacetSegmentation) -> bool:
    """The two levels are two good planes of the right attitude, or the one is said to be none."""
    if len(result.facets) == 1:
        verdict = result.facets[0].verdict
        return verdict.quality != "good" and "plane.levels" in by_code(verdict.reasons)
    return all(
        angle_deg(facet.fit.normal, normal_of(*ATTITUDE)) < 0.1 for facet in result.facets[:2]
    )


@pytest.mark.parametrize("seed", first_in_default_tier(range(700, 704)))
@pytest.mark.parametrize(
    ("times", "share"),
    first_in_default_tier([(2.0, 0.5), (3.0, 0.5), (5.0, 0.5), (3.0, 0.2), (5.0, 0.2)]),
)
def test_step_of_several_noise_levels_is_reported(times: float, share: float, seed: int) -> None:
    assert are_told(find_facets(at_two_levels(seed, times, share)))


@pytest.mark.parametrize("seed", first_in_default_tier(range(704, 708)))
@pytest.mark.parametrize("times", first_in_default_tier([4.0, 5.0, 7.0]))
def test_overlying_layer_is_reported(times: float, seed: int) -> None:
    result = find_facets(at_two_levels(seed, times, over=True))
    assert len(result.facets) == 1
    assert are_told(result)
    assert result.facets[0].level_gap == pytest.approx(times * NOISE, rel=0.1)


@pytest.mark.parametrize("seed", range(708, 711))
@pytest.mark.parametrize("times", [2.0, 3.0])
def test_step_in_mesh_is_reported(times: float, seed: int) -> None:
    heights = NOISE * np.random.default_rng(seed).standard_normal((100, 100))
    heights[:, 50:] += times * NOISE
    mesh = grid_mesh(heights, 0.02)
    assert are_told(find_facets(Mesh(turned(*mesh.vertices.T), mesh.faces)))


@pytest.mark.parametrize("seed", first_in_default_tier(range(711, 714)))
def test_single_level_is_not_reported_as_two(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-1.0, 1.0, (2, 8000))
    noise = rng.standard_normal(8000)
    for height in (
        NOISE * noise,
        # Even noise, a bow, and a wave of the height of the noise.
        NOISE * rng.uniform(-1.0, 1.0, 8000),
        NOISE * (noise + 4.0 * x * x),
        NOISE * (noise + np.sin(8.0 * x)),
    ):
        result = find_facets(PointCloud(turned(x, y, height)))
        assert result.facets[0].level_gap is None
        assert result.facets[0].verdict.quality == "good"


@pytest.mark.parametrize("dip", [0.0, 0.3, 5.0])
def test_rounded_coordinates_are_not_reported_as_levels(dip: float) -> None:
    rng = np.random.default_rng(714)
    x, y = rng.uniform(-1.0, 1.0, (2, 8000))
    height = x * np.tan(np.radians(dip)) + NOISE * rng.standard_normal(8000)
    points = np.round(np.stack([x, y, height], axis=1), 2)
    result = find_facets(PointCloud(points))
    assert result.facets[0].level_gap is None
    assert result.facets[0].verdict.quality == "good"


def worn_cube(rng: np.random.Generator, radius: float) -> np.ndarray:
    """2 m wide, its edges and corners rounded, with 4 mm of noise."""
    points = rng.uniform(0.0, 2.0, (30_000, 3))
    side = np.arange(30_000) % 6
    points[np.arange(30_000), side // 2] = 2.0 * (side % 2)
    core = np.clip(points, radius, 2.0 - radius)
    off = points - core
    length = np.maximum(np.linalg.norm(off, axis=1, keepdims=True), 1e-12)
    return core + radius * off / length + NOISE * rng.standard_normal(points.shape)


@pytest.mark.full
@pytest.mark.parametrize("seed", first_in_default_tier(range(715, 718), 1))
def test_pieces_of_round_block_are_not_good_but_worn_planes_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    flat = find_facets(PointCloud(worn_cube(rng, 0.3)))
    assert [f.is_bent for f in flat.facets[:6]] == [False] * 6
    assert all(f.verdict.quality == "good" for f in flat.facets[:6])
    assert "facets.wavy" not in by_code(flat.warnings)
    ball = rng.standard_normal((30_000, 3))
    ball *= (1.0 + NOISE * rng.standard_normal((30_000, 1))) / np.linalg.norm(ball, axis=1)[:, None]
    x, y = rng.uniform(0.0, 8.0, (2, 26_000))
    egg_box = 0.3 * np.sin(np.pi * x) * np.sin(np.pi * y) + 0.003 * rng.standard_normal(26_000)
    for points, share in ((ball, 0.6), (np.stack([x, y, egg_box], axis=1), 0.5)):
        result = find_facets(PointCloud(points))
        assert "facets.wavy" in by_code(result.warnings)
        area = sum(f.area for f in result.facets)
        assert sum(f.area for f in result.facets if f.is_bent) > share * area
        assert not any(f.is_bent and f.verdict.quality == "good" for f in result.facets)


@pytest.mark.parametrize("seed", first_in_default_tier(range(718, 721)))
@pytest.mark.parametrize("times", first_in_default_tier([0.5, 0.75, 1.0]))
def test_mesh_with_noise_as_large_as_its_edges_is_one_plane(times: float, seed: int) -> None:
    heights = times * 0.02 * np.random.default_rng(seed).standard_normal((100, 100))
    mesh = grid_mesh(heights, 0.02)
    result = find_facets(Mesh(turned(*mesh.vertices.T), mesh.faces))
    assert len(result.facets) == 1
    assert result.exposure.coverage is not None
    assert result.exposure.coverage > 0.97
    assert angle_deg(result.facets[0].fit.normal, normal_of(*ATTITUDE)) < 0.1
