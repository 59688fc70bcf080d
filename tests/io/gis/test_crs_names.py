"""Reference systems are found as people name them; PROJ says what the codes mean."""

from __future__ import annotations

import pytest
from pyproj import CRS

from vomstudio.io.gis.crs_names import projected_systems, search_systems


@pytest.mark.parametrize(
    ("typed", "code"),
    [
        ("32633", "EPSG:32633"),
        ("EPSG:32633", "EPSG:32633"),
        ("wgs 84 utm 33n", "EPSG:32633"),
        ("British National Grid", "EPSG:27700"),
        ("lambert-93", "EPSG:2154"),
        ("germany utm 32n etrs89", "EPSG:25832"),
    ],
)
def test_search_matches_every_word_in_code_name_and_area(typed: str, code: str) -> None:
    assert code in [each.code for each in search_systems(typed)][:12]


@pytest.mark.parametrize(
    ("typed", "code"),
    [("utm 15n", "EPSG:32615"), ("UTM 56S", "EPSG:32756"), ("utm 5n", "EPSG:32605")],
)
def test_wgs_84_zone_is_first_among_zones_of_one_number(typed: str, code: str) -> None:
    assert search_systems(typed)[0].code == code


def test_the_typed_code_and_the_preferred_systems_are_first() -> None:
    assert search_systems("nad27 utm 15n")[0].code == "EPSG:26715"
    assert search_systems("25832")[0].code == "EPSG:25832"
    assert search_systems("utm", preferred_names=["EPSG:25832"])[0].code == "EPSG:25832"
    assert search_systems("utm 15n", preferred_names=["EPSG:26915"])[0].code == "EPSG:26915"


def test_systems_have_proj_names_and_are_projected() -> None:
    systems = projected_systems()
    assert len(systems) > 3000
    for each in systems[:: len(systems) // 40]:
        crs = CRS(each.code)
        assert crs.is_projected
        assert crs.name == each.name


def test_search_without_match_returns_nothing() -> None:
    assert search_systems("atlantis grid") == []
    assert search_systems("   ") == []
    assert len(search_systems("utm")) == 50
