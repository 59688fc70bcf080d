"""Marks in photos: predicted places against closed forms, and what is missing in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.photos.cameras_file import Cameras
from vomstudio.photogrammetry.georeferencing.mark_prediction import (
    ControlMarks,
    PlacedPhotos,
    find_usable_points,
    missing_marks_findings,
)

BENT = Intrinsics("OPENCV", 1000, 800, (900.0, 905.0, 510.0, 395.0, -0.12, 0.03, 1e-3, -5e-4))


def looking(name: str, x: float, turn_deg: float = 0.0, lens: Intrinsics = BENT) -> View:
    """At x, 8 m in front of the wall y = 0, looking north and turned to the east."""
    a = np.radians(turn_deg)
    forward = np.array([np.sin(a), np.cos(a), 0.0])
    down = np.array([0.0, 0.0, -1.0])
    rotation = np.array([np.cross(down, forward), down, forward])
    return View(name, lens, rotation, -rotation @ np.array([x, -8.0, 0.0]))


def by_hand(view: View, point) -> tuple[float, float]:
    """Brown's equations as COLMAP's OPENCV model has them, written out."""
    fx, fy, cx, cy, k1, k2, p1, p2 = view.intrinsics.params
    x, y, z = view.rotation @ np.asarray(point) + view.translation
    u, v = x / z, y / z
    r2 = u * u + v * v
    radial = 1 + k1 * r2 + k2 * r2 * r2
    du = 2 * p1 * u * v + p2 * (r2 + 2 * u * u)
    dv = 2 * p2 * u * v + p1 * (r2 + 2 * v * v)
    return fx * (u * radial + du) + cx, fy * (v * radial + dv) + cy


VIEWS = (
    looking("a.jpg", -2.0, 12.0),
    looking("b.jpg", 0.0),
    looking("c.jpg", 2.5, -15.0),
    looking("far.jpg", 40.0),
)
PLACED = PlacedPhotos((Cameras(VIEWS, Path("photos")),))
POINT = (0.7, 0.3, -0.9)


def set_mark(*photos: str, label: str = "A", point=POINT) -> ControlMarks:
    made = ControlMarks()
    for name in photos:
        view = next(v for v in VIEWS if v.name == name)
        made = made.set_mark(label, name, by_hand(view, point))
    return made


def test_two_marks_predict_the_point_in_the_third_photo() -> None:
    sight = PLACED.predict(set_mark("a.jpg", "b.jpg"), "A")
    assert set(sight.expected) == {"c.jpg"}, "the far one does not show it"
    assert sight.expected["c.jpg"] == pytest.approx(by_hand(VIEWS[2], POINT), abs=1e-4)
    assert max(sight.residuals_px.values()) < 1e-4
    depth = 8.3 * np.cos(np.radians(15)) + 1.8 * np.sin(np.radians(15))
    assert sight.pixel["c.jpg"] == pytest.approx(depth / 902.5, rel=1e-6)


def test_one_mark_predicts_nothing() -> None:
    sight = PLACED.predict(set_mark("a.jpg"), "A")
    assert not sight.expected
    assert not sight.residuals_px
    assert sight.worst_mark is None


def test_one_mark_gives_an_epipolar_line_through_the_point() -> None:
    made = set_mark("a.jpg")
    line = PLACED.epipolar_line(made, "A", "c.jpg")
    truth = by_hand(VIEWS[2], POINT)
    a, ab = line[:-1], np.diff(line, axis=0)
    share = np.clip(((truth - a) * ab).sum(axis=1) / (ab**2).sum(axis=1), 0.0, 1.0)
    assert np.hypot(*(a + share[:, None] * ab - truth).T).min() < 0.05
    assert VIEWS[2].contains(line).all()
    assert not len(PLACED.epipolar_line(made, "A", "a.jpg")), "it is marked there"
    assert not len(PLACED.epipolar_line(set_mark("a.jpg", "b.jpg"), "A", "c.jpg")), (
        "two marks tell more"
    )


def test_wrong_mark_is_reported_as_the_worst() -> None:
    """Five photos, one of them marked 6 pixels beside."""
    views = tuple(looking(f"{i}.jpg", x) for i, x in enumerate((-3.0, -1.5, 0.0, 1.5, 3.0)))
    made = ControlMarks()
    for view in views:
        x, y = by_hand(view, POINT)
        made = made.set_mark("A", view.name, (x, y + (6.0 if view.name == "3.jpg" else 0.0)))
    sight = PlacedPhotos((Cameras(views, Path()),)).predict(made, "A")
    assert sight.worst_mark is not None
    name, residual = sight.worst_mark
    assert name == "3.jpg"
    assert 4.0 < residual < 6.0
    assert max(r for n, r in sight.residuals_px.items() if n != name) < residual / 2


@pytest.mark.parametrize("wrong", range(4))
@pytest.mark.parametrize("way", [(7.0, 0.0), (0.0, 7.0), (-5.0, 5.0)])
def test_wrong_one_of_four_marks_is_found_in_any_direction(wrong, way) -> None:
    """Along the row of cameras least squares would blame another one."""
    views = tuple(looking(f"{i}.jpg", x, -4 * x) for i, x in enumerate((-3.0, -1.0, 1.2, 3.0)))
    made = ControlMarks()
    for number, view in enumerate(views):
        x, y = by_hand(view, POINT)
        dx, dy = way if number == wrong else (0.0, 0.0)
        made = made.set_mark("A", view.name, (x + dx, y + dy))
    sight = PlacedPhotos((Cameras(views, Path()),)).predict(made, "A")
    assert sight.worst_mark is not None
    assert sight.worst_mark[0] == f"{wrong}.jpg"


def world(point) -> tuple[float, float, float]:
    """The scene turned by 30 degrees, three times as large and at UTM coordinates."""
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    x, y, z = 3.0 * (np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.asarray(point))
    return (x + 500_000, y + 5_000_000, z + 120)


def test_three_marked_control_points_predict_the_others() -> None:
    made = ControlMarks()
    for label, point in (("A", POINT), ("B", (-1.0, 0.0, 0.8)), ("C", (1.2, 0.5, 1.0))):
        made = made.set_coordinates(ControlPoint(label, world(point)))
        for view in VIEWS[:2]:
            made = made.set_mark(label, view.name, by_hand(view, point))
    other = (-0.6, 0.2, -0.2)
    made = made.set_coordinates(ControlPoint("D", world(other)))
    sight = PLACED.predict(made, "D")
    assert set(sight.expected) == {"a.jpg", "b.jpg", "c.jpg"}
    for view in VIEWS[:3]:
        assert sight.expected[view.name] == pytest.approx(by_hand(view, other), abs=1e-3)


def test_coordinates_predict_points_directly_in_a_georeferenced_model() -> None:
    cameras = Cameras(VIEWS, Path(), (500_000, 5_000_000, 100), "EPSG:32633", True)
    point = ControlPoint("A", (500_000.7, 5_000_000.3, 99.1))
    sight = PlacedPhotos((cameras,)).predict(ControlMarks((point,)), "A")
    assert sight.expected["b.jpg"] == pytest.approx(by_hand(VIEWS[1], POINT), abs=1e-4)


def test_components_have_separate_frames() -> None:
    """A tie point is predicted in the part in which it is marked twice, and in no other."""
    other = tuple(View(f"p{v.name}", v.intrinsics, v.rotation, v.translation) for v in VIEWS[:3])
    set_coordinates = PlacedPhotos((Cameras(VIEWS[:3], Path()), Cameras(other, Path())))
    made = set_mark("a.jpg", "b.jpg").set_mark("A", "pc.jpg", (5.0, 5.0))
    assert set(set_coordinates.predict(made, "A").expected) == {"c.jpg"}
    assert set_coordinates.component_number("pb.jpg") == 1
    finding, begun = missing_marks_findings(made, set_coordinates)
    assert (finding.code, finding.values["size"]) == ("join.few-markers", 3)
    assert (begun.code, begun.values["component"]) == ("join.begun-markers", 2)
    assert finding.values["not_located"] == ("A",)


def test_missing_marks_of_a_registration_are_reported() -> None:
    points = tuple(ControlPoint(name, (i, i * i, 0.0)) for i, name in enumerate("ABC"))
    made = ControlMarks(points)
    for label in "BC":
        for photo in ("a.jpg", "b.jpg"):
            made = made.set_mark(label, photo, (1.0, 2.0))
    made = made.set_mark("A", "a.jpg", (1.0, 2.0))
    (finding,) = missing_marks_findings(made)
    values = {"count": 2, "total": 3, "least": 3, "photos": 2, "labels": ("A",)}
    assert finding.code == "control.too-few"
    assert values.items() <= finding.values.items()
    assert "A (1 mark)" in finding.message
    assert find_usable_points(made) == ["B", "C"]
    assert missing_marks_findings(made.set_mark("A", "b.jpg", (3.0, 3.0))) == []
    (finding,) = missing_marks_findings(made.remove_point("A"))
    assert (finding.values["count"], finding.values["total"]) == (2, 2)
    assert missing_marks_findings(made.remove_point("A").remove_point("B").remove_point("C")) == []
    assert find_usable_points(made, ["a.jpg"]) == []


def test_collinear_control_points_are_reported() -> None:
    made = ControlMarks(
        tuple(ControlPoint(name, (i, 2.0 * i, 0.0)) for i, name in enumerate("ABC"))
    )
    for label in "ABC":
        for photo in ("a.jpg", "b.jpg"):
            made = made.set_mark(label, photo, (1.0, 2.0))
    assert [finding.code for finding in missing_marks_findings(made)] == ["control.collinear"]


def test_points_are_changed_renamed_and_removed() -> None:
    made = ControlMarks().add_label("tie1").set_mark("tie1", "a.jpg", (1.0, 2.0))
    assert made.free_label() == "tie2"
    assert made.new_labels == ()
    assert made.role("tie1") == "tie"
    made = made.set_mark("tie1", "a.jpg", (3.0, 4.0))
    assert made.marks == (Mark("tie1", "a.jpg", 3.0, 4.0),)
    named = made.rename_point("tie1", "corner")
    assert named.labels == ("corner",)
    with refused("label.in-use", GeometryError):
        named.add_label("x").rename_point("x", "corner")
    for bad in ("", " a", "a\nb"):
        with refused("label.invalid", GeometryError):
            named.rename_point("corner", bad)
    made = named.set_coordinates(ControlPoint("corner", (1.0, 2.0, 3.0), None, True))
    assert made.role("corner") == "check"
    assert made.remove_coordinates("corner").role("corner") == "tie"
    gone = made.remove_mark("corner", "a.jpg")
    assert gone.labels == ("corner",)
    assert made.remove_point("corner") == ControlMarks()


def test_photos_are_matched_by_the_last_part_of_their_path() -> None:
    photos = ["left/one.jpg", "right/one.jpg", "right/two.jpg"]
    made, strangers = ControlMarks().add_marks(
        [Mark("A", "TWO.JPG", 1, 2), Mark("A", "x", 1, 2)], photos
    )
    assert made.marks_in_photo("right/two.jpg") == {"A": (1.0, 2.0)}
    assert strangers == ["x"]
    assert made.marks_in_photo("x"), "kept for when the photo is there again"
