"""Facets of clouds with much noise, scattered points and vegetation."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.planes_by_construction import (
    angle_deg,
    axes_of,
    clouds_of,
    normal_of,
    sheet,
)
from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.extraction.facets import FacetSegmentation, find_facets
from vomstudio.geometry.cloud import PointCloud

ATTITUDES = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]
VOLUME = Finding("facets.volume")


def squares(
    rng: np.random.Generator, number: int, size: float, spacing: float, noise: float
) -> list[np.ndarray]:
    count = int((size / spacing) ** 2)
    return [
        sheet(rng, ATTITUDES[i % 3], (3 * size * i, 0, 0), size=size, count=count, noise=noise)
        for i in range(number)
    ]


def worst(result: FacetSegmentation, part: np.ndarray) -> float:
    return max(
        angle_deg(
            facet.fit.normal, normal_of(*ATTITUDES[int(np.bincount(part[facet.rows]).argmax()) % 3])
        )
        for facet in result.facets
    )


@pytest.mark.parametrize("times", [2.0, 3.0])
def test_noise_of_several_spacings_neither_hides_nor_adds_planes(times: float) -> None:
    rng = np.random.default_rng(1)
    cloud, part = clouds_of(*squares(rng, 3, 2.5, 0.03, times * 0.03))
    result = find_facets(cloud)
    assert len(result.facets) == 3
    assert worst(result, part) < 0.5
    assert by_code(result.warnings)["cloud.noisy"]["times"] == pytest.approx(times, rel=0.3)


def test_connected_noisy_walls_are_separated() -> None:
    rng = np.random.default_rng(2)
    places = rng.uniform(0.0, 4.0, (3, 15_000, 2))
    walls = [np.insert(places[k], k, 0.08 * rng.standard_normal(15_000), axis=1) for k in range(3)]
    result = find_facets(PointCloud(np.concatenate(walls)))
    assert len(result.facets) == 3
    axes = np.abs([facet.fit.normal for facet in result.facets])
    assert np.sort(axes.argmax(axis=1)).tolist() == [0, 1, 2]
    assert axes.max(axis=1).min() > np.cos(np.radians(0.5))


@pytest.mark.parametrize("number", first_in_default_tier([15_000, 51_000], 1))
def test_point_volume_has_no_facets_and_gives_warning(number: int) -> None:
    rng = np.random.default_rng(3)
    for points in (
        rng.uniform(0.0, 1.0, (number, 3)),
        np.concatenate(squares(rng, 3, 0.03 * np.sqrt(number / 3), 0.03, 1.0)),
    ):
        result = find_facets(PointCloud(points))
        assert not result.facets
        assert result.warnings == (VOLUME,)


@pytest.mark.full
def test_volume_next_to_smooth_square_has_no_facet() -> None:
    rng = np.random.default_rng(4)
    quiet = squares(rng, 1, 2.5, 0.03, 0.003)[0]
    result = find_facets(PointCloud(np.concatenate([quiet, rng.uniform(3.0, 5.0, (15_000, 3))])))
    rows = result.facets[0].rows
    assert (rows < len(quiet)).mean() > 0.99
    assert sum((facet.rows >= len(quiet)).sum() for facet in result.facets) < 0.01 * 15_000


@pytest.mark.parametrize(("share", "times"), [(0.002, 1.0), (0.01, 0.5), (0.05, 1.0), (0.1, 0.3)])
def test_scattered_points_neither_split_planes_nor_count_as_rock(
    share: float, times: float
) -> None:
    rng = np.random.default_rng(5)
    parts = squares(rng, 6, 3.0, 0.03, times * 0.03)
    count = sum(map(len, parts))
    low, high = [-5.0, -5.0, -5.0], [50.0, 5.0, 5.0]
    cloud, part = clouds_of(*parts, rng.uniform(low, high, (int(share * count), 3)))
    result = find_facets(cloud)
    assert len(result.facets) == 6
    assert worst(result, part) < 0.3
    assert (result.labels[part < 6] >= 0).mean() > 0.99
    assert result.exposure.near_planar_share is not None
    assert result.exposure.near_planar_share > 0.93
    assert not result.warnings


@pytest.mark.parametrize("depth", first_in_default_tier([0.2, 0.5, 1.0]))
def test_volume_in_front_of_wall_is_not_counted_as_rock(depth: float) -> None:
    rng = np.random.default_rng(6)
    wall = sheet(rng, (90.0, 85.0), (0.0, 0.0, 0.0), size=8.0, count=40_000, noise=0.006)
    u, v = axes_of(90.0, 85.0)
    hidden = (wall @ u > 0.0) & (wall @ v > 0.0)
    count = int(hidden.sum())
    along, down, out = rng.uniform(0.0, [[4.0], [4.0], [depth]], (3, count))
    plants = along[:, None] * u + down[:, None] * v + out[:, None] * normal_of(90.0, 85.0)
    result = find_facets(PointCloud(np.concatenate([wall[~hidden], plants])))
    assert (result.cover_classes[-count:] == 2).mean() > 0.9
    assert result.exposure.vegetation_share == pytest.approx(0.25, abs=0.04)
    assert result.exposure.near_planar_share is not None
    assert result.exposure.near_planar_share > 0.97


def test_excessive_noise_creates_no_planes() -> None:
    rng = np.random.default_rng(7)
    for times in (4.0, 8.0):
        cloud, part = clouds_of(*squares(rng, 3, 2.5, 0.03, times * 0.03))
        result = find_facets(cloud)
        assert not result.facets or (len(result.facets) == 3 and worst(result, part) < 1.0)
        assert result.warnings


def two_scans(off: float) -> tuple[PointCloud, np.ndarray]:
    """Of three squares, and of one half of each a second time, off by so much."""
    rng, parts = np.random.default_rng(8), []
    for i, attitude in enumerate(ATTITUDES):
        first = sheet(rng, attitude, (4.0 * i, 0, 0), size=3.0, count=10_000, noise=0.002)
        again = sheet(rng, attitude, (4.0 * i, 0, 0), size=3.0, count=10_000, noise=0.002)
        down = (again - [4.0 * i, 0.0, 0.0]) @ axes_of(*attitude)[1]
        parts.append(np.concatenate([first, again[down > 0.0] + off * normal_of(*attitude)]))
    return clouds_of(*parts)


@pytest.mark.parametrize("off", first_in_default_tier([0.015, 0.02, 0.025]))
def test_stated_error_includes_tilt_from_misaligned_scan(off: float) -> None:
    cloud, part = two_scans(off)
    result = find_facets(cloud)
    assert len(result.facets) == 3
    for facet in result.facets:
        truth = normal_of(*ATTITUDES[int(np.bincount(part[facet.rows]).argmax())])
        assert angle_deg(facet.fit.normal, truth) < (facet.fit.max_confidence95_deg or 0.0)


def test_two_layers_in_one_facet_are_reported_as_doubtful() -> None:
    rng = np.random.default_rng(9)
    layers = [
        sheet(rng, (100.0, 60.0), tuple(gap * normal_of(100.0, 60.0)), size=3.0, count=2500)
        for gap in (0.0, 0.06)
    ]
    both, alone = (find_facets(PointCloud(x)) for x in (np.concatenate(layers), layers[0]))
    assert len(both.facets) == len(alone.facets) == 1
    assert both.facets[0].verdict.quality == "doubtful"
    assert by_code(both.facets[0].verdict.reasons)["plane.levels"] == {
        "gap_m": pytest.approx(0.06, rel=0.1)
    }
    assert alone.facets[0].verdict.quality == "good"
