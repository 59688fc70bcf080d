"""Declination against published values, and the correction of azimuths to grid north."""

from __future__ import annotations

from datetime import date

import pytest

from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.io.gis.crs import convergence_deg, degrees_to_grid
from vomstudio.registration.north import NorthInputs, declination_deg


@pytest.mark.parametrize(
    ("latitude", "longitude", "height_km", "year", "wanted"),
    [
        # By IAGA's own Fortran program. The definitive models up to 2015 have not changed since.
        (59.9, -109.9, 1.1, 1900, 33.01),
        (59.9, -109.9, 1.1, 1950, 27.82),
        (59.9, -109.9, 1.1, 1990, 21.95),
        (59.9, -109.9, 1.1, 2010, 15.20),
        (-59.9, 0.0, 100.1, 1945, -22.68),
        (-59.9, 0.0, 100.1, 2000, -19.63),
        (-59.9, 0.0, 100.1, 2012, -20.06),
    ],
)
def test_declination_matches_the_reference_program(
    latitude, longitude, height_km, year, wanted
) -> None:
    # Its years are those and a half.
    found = declination_deg(longitude, latitude, date(year, 7, 2), 1000 * height_km)
    assert found == pytest.approx(wanted, abs=0.011)


@pytest.mark.parametrize(
    ("when", "height_m", "latitude", "longitude", "wanted"),
    [
        (date(2025, 1, 1), 0, 80, 0, 1.28),
        (date(2025, 1, 1), 0, 0, 120, -0.16),
        (date(2025, 1, 1), 0, -80, 240, 68.78),
        (date(2025, 1, 1), 100_000, 80, 0, 0.85),
        (date(2027, 7, 2), 0, 80, 0, 2.59),
    ],
)
def test_declination_agrees_with_the_world_magnetic_model(
    when, height_m, latitude, longitude, wanted
) -> None:
    """The test values of WMM2025 (NOAA and BGS), another model of the same field: they differ by
    some hundredths of a degree, by more near the poles."""
    found = declination_deg(longitude, latitude, when, height_m)
    assert found == pytest.approx(wanted, abs=0.03 if latitude == 0 else 0.3)


@pytest.mark.parametrize(
    ("place", "when", "code"),
    [
        ((13.0, 45.0), date(1899, 12, 31), "north.unknown-year"),
        ((13.0, 45.0), date(2030, 1, 1), "north.unknown-year"),
        ((-150.0, 86.0), date(2025, 1, 1), "north.near-pole"),
    ],
)
def test_declination_outside_the_model_range_is_rejected(place, when, code, capsys) -> None:
    with refused(code):
        declination_deg(*place, when)
    assert not capsys.readouterr().out
    assert abs(declination_deg(13.0, 45.0, date(2029, 12, 31))) < 10
    assert not capsys.readouterr().out


CRS, PLACE = "EPSG:32633", (13.4, 46.5)
CONVERGENCE = convergence_deg(CRS, *degrees_to_grid(CRS)(*PLACE))
IN_CRS = NorthInputs(CRS, PLACE, date(2024, 5, 12), 3.0)


def test_correction_of_each_north_is_its_angle_to_grid_north() -> None:
    assert pytest.approx(-1.1607, abs=1e-4) == CONVERGENCE
    assert IN_CRS.correction("grid").deg == 0.0
    assert IN_CRS.correction("true").deg == pytest.approx(-CONVERGENCE)
    assert IN_CRS.correction("magnetic").deg == pytest.approx(3.0 - CONVERGENCE)
    assert NorthInputs(None, PLACE, None, 3.0).correction("magnetic").deg == 3.0
    assert NorthInputs(None).correction("true").deg == 0.0


@pytest.mark.parametrize(
    ("known", "north", "code", "values"),
    [
        (
            NorthInputs(None, declination_deg=2.6),
            "magnetic",
            "north.declination-added",
            {"correction_deg": 2.6, "source": "as stated"},
        ),
        (
            IN_CRS,
            "magnetic",
            "north.magnetic-corrected",
            {
                "correction_deg": pytest.approx(3.0 - CONVERGENCE),
                "source": "as stated",
                "declination_deg": 3.0,
                "convergence_deg": pytest.approx(CONVERGENCE),
            },
        ),
        (IN_CRS, "true", "north.true-corrected", {"correction_deg": pytest.approx(-CONVERGENCE)}),
        (NorthInputs(None), "true", "north.true-unchanged", {}),
    ],
)
def test_correction_finding_has_its_code_and_values(
    known: NorthInputs, north: str, code: str, values: dict
) -> None:
    finding = known.correction(north).finding
    assert (finding.code, dict(finding.values)) == (code, values)


def test_a_correction_is_shown_to_the_hundredth_of_a_degree() -> None:
    assert "+4.16°" in IN_CRS.correction("magnetic").summary
    assert IN_CRS.correction("grid").finding is None


@pytest.mark.parametrize(
    ("known", "north", "code"),
    [
        (NorthInputs(CRS), "true", "north.no-convergence"),
        (NorthInputs(CRS, PLACE), "magnetic", "north.no-declination"),
        (NorthInputs(None, None, date(2024, 5, 12)), "magnetic", "north.no-declination"),
    ],
)
def test_missing_north_inputs_are_reported(known: NorthInputs, north: str, code: str) -> None:
    with refused(code, UsageError, field="--north"):
        known.require_correction(north, "--north")
