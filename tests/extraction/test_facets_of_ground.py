"""Facets where lawns and level ground lie beside the rock."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.planes_by_construction import sheet
from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.extraction.facets import FacetSegmentation, find_facets
from vomstudio.geometry.cloud import PointCloud

ROCK, GRASS = (130, 120, 105), (105, 135, 70)


def scene(
    seed: int, ground_dip: float, ground: tuple[int, int, int], wall_dip: float
) -> FacetSegmentation:
    """10 x 10 m of smooth ground before a wall of 5 x 5 m, each with the noise of a photo."""
    rng = np.random.default_rng(seed)
    flat = sheet(rng, (20.0, ground_dip), (0.0, 0.0, 0.0), size=10.0, count=20_000, noise=0.01)
    wall = sheet(rng, (200.0, wall_dip), (0.0, 9.0, 3.0), size=5.0, count=5_000, noise=0.01)
    colors = np.repeat([ground, ROCK], [20_000, 5_000], axis=0) + rng.normal(0.0, 6.0, (25_000, 3))
    return find_facets(
        PointCloud(np.concatenate([flat, wall]), colors=np.clip(colors, 0, 255).astype(np.uint8))
    )


@pytest.mark.parametrize("seed", range(740, 743))
def test_smooth_lawn_is_vegetation_and_not_a_facet(seed: int) -> None:
    result = scene(seed, 4.0, GRASS, 75.0)
    assert len(result.facets) == 1
    assert result.facets[0].fit.dip_deg == pytest.approx(75.0, abs=0.1)
    assert result.exposure.vegetation_share == pytest.approx(0.8, abs=0.03)
    assert result.exposure.area_m2 == pytest.approx(125.0, rel=0.1)
    assert result.exposure.exposed_m2 == pytest.approx(25.0, rel=0.1)
    assert result.exposure.level_share == 0.0
    assert by_code(result.warnings)["facets.vegetation"]["share_percent"] == pytest.approx(
        80, abs=9
    )


@pytest.mark.parametrize("seed", first_in_default_tier(range(743, 746)))
def test_level_ground_is_reported_with_its_share(seed: int) -> None:
    result = scene(seed, 4.0, (120, 120, 120), 75.0)
    assert len(result.facets) == 2
    assert result.exposure.level_share == pytest.approx(0.8, abs=0.03)
    assert by_code(result.warnings)["facets.ground"]["limit_deg"] == 10
    steep = scene(seed, 14.0, (120, 120, 120), 75.0)
    assert steep.exposure.level_share == 0.0
    assert not steep.warnings


@pytest.mark.full
@pytest.mark.parametrize("colour", [(60, 255, 30), (115, 118, 110), (130, 110, 90)])
def test_greenish_rock_and_colour_scales_are_not_vegetation(colour: tuple[int, int, int]) -> None:
    result = scene(746, 14.0, colour, 75.0)
    assert len(result.facets) == 2
    assert result.exposure.vegetation_share < 0.01
