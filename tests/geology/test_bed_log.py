"""Logs along a line, against textbook problems and simulation."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import by_code, with_code
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.beds.bed_log import bed_log
from vomstudio.geology.beds.lithologies import strabospot_fields
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.orientation import Line, Plane


def test_ragans_sandstone_has_published_thickness() -> None:
    # Ragan (2009), Structural Geology, chapter 2, problem 4: strike 245, dip 35 by the right-hand
    # rule, a level traverse of 125 m along N10E from the bottom to the top: 58.7 m.
    bed = Plane.from_strike(245.0, 35.0)
    found = bed_log([[0, 0, 0], 125.0 * Line(10.0, 0.0).vector()], bed)
    assert found.total_m.value == pytest.approx(58.7, abs=0.05)
    assert found.total_m.error95 is None


def test_units_of_published_map_have_published_thickness() -> None:
    # Cardozo, Computational structural geology (after Bennison's maps), notebook 5: contacts of the
    # units Q, R, S and T, which strike 84.5 and dip 22.5: 195.6, 278.6, 94.6 and 467.2 m.
    contacts = [
        [1147, 3329, 400],
        [1323, 2362, 500],
        [1105, 1850, 400],
        [1768, 940, 300],
        [1842, 191, 200],
    ]
    found = bed_log(contacts, Plane.from_strike(84.5, 22.5), lithologies=["", *"TSRQ"])
    thick = [i.thickness_m.value for i in found.intervals]
    assert thick == pytest.approx([467.2, 94.6, 278.6, 195.6], abs=0.05)
    assert found.total_m.value == pytest.approx(sum(thick))
    assert found.intervals[-1].top_m == pytest.approx(sum(thick))


def test_errors_match_simulation() -> None:
    rng = np.random.default_rng(5)
    bed = Plane(120.0, 40.0)
    points = np.array([[0.0, 0.0, 0.0], [2.0, 6.0, 9.0], [-5.0, -5.0, 19.0]])
    stated = bed_log(points, bed, sigma_m=0.05, bed_error_deg=3.0)
    cone = 3.0 / np.sqrt(2.0 * np.log(20.0))
    tried = []
    for _ in range(4000):
        normal = bed.normal() + np.radians(cone) * rng.normal(size=3)
        turned = Plane.from_normal(normal / np.linalg.norm(normal))
        found = bed_log(points + rng.normal(0, 0.05, (3, 3)), turned)
        tried.append([i.thickness_m.value for i in found.intervals])
    spread = 1.96 * np.std(tried, axis=0)
    errors = [i.thickness_m.error95 for i in stated.intervals]
    assert errors == pytest.approx(list(spread), rel=0.06)


def test_beds_are_ordered_upwards_with_names_and_descriptions() -> None:
    points = [[0, 0, 0], [0, 0, 3], [0, 0, 1]]
    level = Plane(0.0, 0.0)
    found = bed_log(
        points,
        level,
        names=["a", "b", "c"],
        lithologies=["Sandstone", "", "gneiss"],
        notes=["coarse", "", "?"],
    )
    first, second = found.intervals
    assert (first.base, first.top, first.lithology, first.notes) == (
        "a",
        "c",
        "Sandstone",
        "coarse",
    )
    assert (second.base, second.top, second.strabospot) == ("c", "b", {})
    assert found.reordered == ("c", "b")
    assert by_code(found.warnings)["log.unknown-lithology"]["word"] == "gneiss"
    down = bed_log(points, level, names=["a", "b", "c"], overturned=True)
    assert [i.base for i in down.intervals] == ["b", "c"]
    # A log that was walked from the top down is in order, too.
    assert bed_log([[0, 0, 3], [0, 0, 2], [0, 0, 0]], level).reordered == ()


def test_rotation_changes_nothing() -> None:
    points = np.array([[0, 0, 0], [3, 1, 2], [4, 4, 7.0]])
    turn = np.radians(-30.0)
    around = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    one = bed_log(points, Plane(80, 30), bed_error_deg=2.0)
    other = bed_log(points @ around.T + [5e5, 5e6, 100], Plane(110, 30), bed_error_deg=2.0)
    for a, b in zip(one.intervals, other.intervals, strict=True):
        assert a.thickness_m.value == pytest.approx(b.thickness_m.value, abs=1e-6)
        assert a.thickness_m.error95 == pytest.approx(b.thickness_m.error95, abs=1e-6)


def test_invalid_logs_are_refused() -> None:
    for points in ([[0, 0, 0]], [[0, 0, np.nan], [0, 0, 1]], [[0, 0], [1, 1]]):
        with pytest.raises(GeometryError):
            bed_log(points, Plane(0, 0))
    with pytest.raises(UsageError) as refused:
        LogOptions(sigma_m=-1)
    assert refused.value.code == "option.out-of-range"
    thin = bed_log([[0, 0, 0], [9, 0, 0.1]], Plane(90, 0.1), bed_error_deg=3)
    assert with_code(thin.warnings, "log.thickness-uncertain") == [
        Finding("log.thickness-uncertain", base="1", top="2")
    ]


def test_rocks_are_translated_to_strabospot_terms() -> None:
    assert strabospot_fields("Sandstone")["siliciclastic_type"] == "sandstone"
    assert strabospot_fields("mudstone")["primary_lithology"] == "siliciclastic"
    assert strabospot_fields("lime mudstone")["dunham_classification"] == "mudstone"
    assert strabospot_fields("Organic/Coal")["primary_lithology"] == "organic_coal"
    assert strabospot_fields("welded_tuff")["primary_lithology"] == "volcaniclastic"
    assert not any(strabospot_fields("covered").values())
    assert strabospot_fields("granite") is None
