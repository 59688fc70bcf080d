"""Projections are metric where their scale is 1, whatever they are called."""

from __future__ import annotations

import numpy as np
import pytest
from pyproj import Geod, Transformer

from vomstudio.core.errors import InputError
from vomstudio.io.gate.metric import (
    MAX_SCALE_ERROR,
    check_metric,
    degrees_finding,
    map_scale,
)


def box(crs: str, longitude: float, latitude: float, size: float = 20.0) -> np.ndarray:
    """Bounds of a square about a place, in the unit of a CRS."""
    x, y = Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(longitude, latitude)
    return np.array([[x - size / 2, y - size / 2, 0.0], [x + size / 2, y + size / 2, 30.0]])


def codes(crs: str, longitude: float, latitude: float) -> set[str]:
    return {each.code for each in check_metric(crs, box(crs, longitude, latitude))}


@pytest.mark.parametrize(
    ("crs", "longitude", "latitude"),
    [
        ("EPSG:3857", 12.0, 46.0),
        ("EPSG:3857", 12.0, 6.0),
        ("EPSG:3395", 12.0, 46.0),
        ("EPSG:6933", 12.0, 46.0),
        ("EPSG:6933", 12.0, 5.0),
        ("EPSG:32633", -5.0, 46.0),
        ("EPSG:3035", 12.5, 36.0),
    ],
)
def test_distorting_projection_is_rejected_with_a_metric_suggestion(
    crs, longitude, latitude
) -> None:
    with pytest.raises(InputError) as refused:
        check_metric(crs, box(crs, longitude, latitude))
    assert refused.value.code == "frame.not-metric"
    suggested = refused.value.values["suggested_crs"]
    assert check_metric(suggested, box(suggested, longitude, latitude)) == ()


@pytest.mark.parametrize(
    ("crs", "longitude", "latitude", "expected"),
    [
        ("EPSG:32633", 15.0, 46.0, set()),
        ("EPSG:32733", 15.0, -33.0, set()),
        ("EPSG:3857", 12.0, 0.0, set()),
        ("EPSG:6933", 12.0, 30.0, set()),
        ("EPSG:3035", 10.0, 48.0, set()),
        ("EPSG:2264", -80.0, 35.5, set()),
        # UTM 32 in Puglia: 0.39 % too long.
        ("EPSG:32632", 16.0, 41.0, {"frame.outside-area"}),
    ],
)
def test_nearly_metric_projection_is_accepted(crs, longitude, latitude, expected) -> None:
    assert codes(crs, longitude, latitude) == expected


@pytest.mark.parametrize("crs", ["EPSG:3857", "EPSG:3035", "EPSG:6933", "EPSG:32632", "EPSG:2264"])
def test_map_scale_matches_distances_on_the_ellipsoid(crs) -> None:
    longitude, latitude = (-80.0, 35.5) if crs == "EPSG:2264" else (17.0, 41.0)
    bounds = box(crs, longitude, latitude)
    back = Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    x, y = bounds[:, :2].mean(axis=0)
    unit_m = 1200 / 3937 if crs == "EPSG:2264" else 1.0
    scales = []
    for angle in np.radians(np.arange(0, 180, 5)):
        ends = np.array([[-1, 1]]).T * 10.0 * np.array([[np.cos(angle), np.sin(angle)]])
        lon, lat = back.transform(x + ends[:, 0], y + ends[:, 1])
        _, _, metres = Geod(ellps="WGS84").inv(lon[0], lat[0], lon[1], lat[1])
        scales.append(20.0 * unit_m / metres)
    scale = map_scale(crs, bounds)
    worst = max(scales, key=lambda each: abs(each - 1.0))
    # PROJ takes the Earth as a sphere for Web Mercator, as its definition does.
    tolerance = 3e-3 if crs == "EPSG:3857" else 2e-4
    assert scale.scale == pytest.approx(worst, rel=tolerance)
    expected = max(scales) / min(scales) - 1.0
    assert scale.anisotropy == pytest.approx(expected, abs=2.0 * tolerance)


def test_quick_utm_check_accepts_only_areas_that_proj_accepts() -> None:
    chance = np.random.default_rng(3)
    for _ in range(300):
        crs = f"EPSG:32{chance.choice(['6', '7'])}33"
        corner = np.array([chance.uniform(-5e5, 1.5e6), chance.uniform(-1e6, 1.1e7), 0.0])
        bounds = np.array([corner, corner + 100.0])
        try:
            quick = check_metric(crs, bounds)
        except InputError:
            continue
        scale = map_scale(crs, bounds)
        assert scale.is_metric
        assert bool(quick) == (not scale.is_in_area)


def test_max_scale_error_is_half_a_percent() -> None:
    assert MAX_SCALE_ERROR == 0.005


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        ([12.0, 46.0, 300.0], [12.0003, 46.0002, 340.0], True),
        ([-71.2, -33.1, 300.0], [-71.1, -33.0, 340.0], True),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 5.0], True),
        ([0.0, 0.0, 0.0], [8.0, 2.0, 15.0], False),
        ([500_000.0, 5_000_000.0, 0.0], [500_000.1, 5_000_000.1, 50.0], False),
        ([0.0, 91.0, 0.0], [0.01, 91.01, 50.0], False),
    ],
)
def test_probable_degrees_are_reported(low, high, expected) -> None:
    found = degrees_finding(np.array([low, high]))
    assert (found is not None and found.code == "frame.maybe-degrees") == expected
