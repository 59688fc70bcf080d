"""What control can do is said before hours are spent."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from tests.messages import with_code
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.io.control.control_files import read_control, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.georeferencing.control_check import check_control


@dataclass(frozen=True)
class Seen:
    name: str
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    altitude_m: float | None = None
    gps_accuracy_m: float | None = None


PLACES = {"A": (0, 0, 0), "B": (10, 0, 0), "C": (0, 0, 5), "D": (10, 0, 5)}
POINTS = [ControlPoint(k, (float(x), float(y), float(z))) for k, (x, y, z) in PLACES.items()]
PHOTOS = [Seen(f"{n}.jpg") for n in range(5)]


def marks(*labels: str, photos: int = 4) -> list[Mark]:
    return [
        Mark(label, f"{n}.jpg", 50.0 * k, 1.0)
        for k, label in enumerate(labels)
        for n in range(photos)
    ]


def test_enough_points_are_counted_without_warnings() -> None:
    points = [*POINTS, ControlPoint("E", (5.0, 1.0, 2.0), None, True)]
    found = check_control(points, marks(*"ABCDE"), PHOTOS)
    assert found.problem is None
    assert found.summary.code == "control.usable"
    counts = {name: found.summary.values[name] for name in ("control", "check", "least", "most")}
    assert counts == {"control": 4, "check": 1, "least": 4, "most": 4}
    assert found.warnings == ()
    assert found.crs is None


@pytest.mark.parametrize(
    ("given", "count", "cause"),
    [
        (marks("A", "B"), 2, None),
        (marks("A"), 1, None),
        ([], 0, None),
        ([*marks("A", "B"), *marks("C", photos=1)], 2, None),
        (marks("A", "B", "E"), 2, "control.without-coordinates"),
        ([Mark(k, "x.jpg", 1, 1) for k in "ABC"], 0, "control.photos-missing"),
    ],
)
def test_too_few_points_are_counted_with_the_reason(
    given: list[Mark], count: int, cause: str | None
) -> None:
    found = check_control(POINTS, given, PHOTOS)
    assert found.problem is not None
    values = {"count": count, "least": 3, "photos": 2, "reason_codes": (cause,) if cause else ()}
    assert found.problem.code == "control.too-few"
    assert values.items() <= found.problem.values.items()


def test_check_points_do_not_count_as_control() -> None:
    points = [replace(p, check=p.label in "BC") for p in POINTS]
    problem = check_control(points, marks(*"ABCD"), PHOTOS).problem
    assert problem is not None
    assert (problem.code, problem.values["count"]) == ("control.too-few", 2)


def test_points_in_one_line_are_refused() -> None:
    points = [ControlPoint(k, (float(n), 2.0 * n, 3.0 * n)) for n, k in enumerate("ABC")]
    assert check_control(points, marks(*"ABC"), PHOTOS).problem == Finding("control.collinear")


def test_weak_control_is_reported() -> None:
    found = check_control(POINTS, [*marks("A", "B", "C", photos=2), *marks("D", photos=1)], PHOTOS)
    assert found.problem is None
    assert [each for each in found.warnings if each.code != "control.same-spot"] == [
        Finding("control.no-redundancy", count=3, least=4),
        Finding("control.no-check-points"),
        Finding("control.few-marks", labels=["D"]),
        Finding("control.more-marks", wanted=4, labels=["A", "B", "C"]),
    ]


def test_utm_zone_of_the_gps_is_proposed_if_it_contains_the_points() -> None:
    # On the central meridian of zone 33 at 45 degrees: 500 000, 4 982 950 (0.9996 of the meridian
    # arc of 4 984 944 m).
    photos = [replace(p, latitude_deg=45.0, longitude_deg=15.0, altitude_m=9.0) for p in PHOTOS]
    near = [
        replace(p, position=(p.position[0] + 5e5, p.position[1] + 4982950.0, 9.0 + i * i))
        for i, p in enumerate(POINTS)
    ]
    found = check_control(near, marks(*"ABCD"), photos)
    assert found.crs == "EPSG:32633"
    assert found.crs_reason.code == "control.crs-proposed"
    assert found.crs_reason.values["distance_m"] < 100
    local = check_control(POINTS, marks(*"ABCD"), photos)
    assert local.crs is None
    assert local.crs_reason == Finding("control.crs-local")
    wrong = check_control(near, marks(*"ABCD"), photos, "EPSG:32632")
    assert wrong.crs == "EPSG:32632"
    # Six degrees of longitude at 45 degrees are some 472 km.
    (finding,) = with_code(wrong.warnings, "control.far-from-photos")
    assert finding.values["distance_km"] == pytest.approx(472.0, abs=8.0)


def test_saint_martin_has_six_usable_points_and_one_mark_without_a_point(data_dir: Path) -> None:
    folder = data_dir / "saint_martin"
    photos = [Seen(path.name) for path in folder.glob("*.JPG")]
    found = check_control(
        read_control(folder / "Ground-Pts3D.xml"), read_marks(folder / "GroundMeasure.xml"), photos
    )
    assert found.problem is None
    assert sum(p.is_usable for p in found.points) == 6
    (finding,) = with_code(found.warnings, "control.tie-points")
    assert finding.values["labels"] == ("u-of-You",)


def test_position_outside_the_crs_does_not_stop_the_check() -> None:
    photos = [replace(p, latitude_deg=95.0, longitude_deg=15.0, altitude_m=9.0) for p in PHOTOS]
    try:
        found = check_control(POINTS, marks(*"ABCD"), photos, "EPSG:32633")
    except GeometryError:
        pytest.fail("a check does not raise")
    assert found.problem is None


def test_marks_without_coordinates_in_two_photos_are_tie_markers() -> None:
    given = [*marks(*"ABCD"), *marks("T", photos=2), *marks("U", photos=1)]
    warnings = check_control(POINTS, given, PHOTOS).warnings
    (ties,) = with_code(warnings, "control.tie-points")
    assert ties.values["labels"] == ("T",)
    (unused,) = with_code(warnings, "control.without-coordinates")
    assert unused.values["labels"] == ("U",)
