"""Marks that contradict each other and lines that are not level, in photos of known poses."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from tests.io.photos.camera_files import ring
from tests.messages import refused, with_code
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.control.observation_tables import Positions
from vomstudio.registration.evidence import Evidence, register, triangulate_marks
from vomstudio.registration.level_evidence import image_plane_angle_deg, level_line_findings
from vomstudio.registration.marks.mark_errors import Marks
from vomstudio.registration.marks.wrong_marks import find_consistent_marks

Array = npt.NDArray[np.float64]
VIEWS = ring()
PLACE = np.array([1.0, -2.0, 0.5])
LENS = Intrinsics.pinhole(4000, 3000, 3200.0, 2000.0, 1500.0)


def seen(place: Array = PLACE) -> Array:
    return np.array([view.project(place)[0] for view in VIEWS])


def test_consistent_marks_are_all_kept() -> None:
    chance = np.random.default_rng(1)
    rows, wrong = find_consistent_marks("A", Marks(VIEWS, seen() + chance.normal(size=(9, 2))), 6.0)
    assert rows.tolist() == list(range(9))
    assert wrong == []


def test_wrong_mark_is_reported_with_photo_and_expected_position() -> None:
    marks = seen()
    marks[4] += [600.0, -300.0]
    rows, (wrong,) = find_consistent_marks("A", Marks(VIEWS, marks), 6.0)
    assert 4 not in rows
    assert (wrong.label, wrong.photo) == ("A", VIEWS[4].name)
    assert wrong.expected == pytest.approx(tuple(seen()[4]), abs=0.1)


def test_wrong_and_outside_marks_are_excluded_from_triangulation() -> None:
    marks = [
        ("A", view.name, float(x), float(y)) for view, (x, y) in zip(VIEWS, seen(), strict=True)
    ]
    marks[2] = ("A", VIEWS[2].name, 9_999.0, 100.0)
    marks[5] = ("A", VIEWS[5].name, marks[5][2] + 400.0, marks[5][3])
    findings: list[Finding] = []
    evidence = Evidence(views={view.name: view for view in VIEWS})
    places = triangulate_marks(evidence, marks, findings)
    np.testing.assert_allclose(places["A"][0], PLACE, atol=1e-3)
    (outside,) = with_code(findings, "control.mark-outside")
    assert outside.values["photo"] == VIEWS[2].name
    (wrong,) = with_code(findings, "control.wrong-mark")
    assert wrong.values["photo"] == VIEWS[5].name


def wall_view(turn_deg: float) -> View:
    """A level camera 15 m in front of a wall (the plane y = 0), turned about the vertical."""
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    rotation = np.array([[c, -s, 0.0], [0.0, 0.0, -1.0], [s, c, 0.0]])
    return View(f"turned_{turn_deg:.0f}.jpg", LENS, rotation, -rotation @ [0.0, -15.0, 0.0])


@pytest.mark.parametrize("turn", [0.0, 10.0, 25.0])
def test_level_line_on_a_wall_is_skewed_by_the_camera_rotation(turn: float) -> None:
    x, z = np.meshgrid(np.linspace(-20, 20, 161), np.linspace(-8, 8, 65))
    wall = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    view = wall_view(turn)
    ends = view.project(np.array([[-3.0, 0.0, 5.0], [3.0, 0.0, 5.0]]))
    assert image_plane_angle_deg(view, ends, wall) == pytest.approx(turn, abs=1.5)
    findings = level_line_findings([view.name], [view], ends[None], wall)
    assert [each.code for each in findings] == (["level.away"] if turn > 2.0 else [])
    # The axis of the photo, and a horizon above the wall.
    low = wall[wall[:, 2] < 4]
    for line in ([[10.0, 1500.0], [3990.0, 1500.0]], [[10.0, 20.0], [3990.0, 31.0]]):
        assert level_line_findings([view.name], [view], np.array([line]), low) == []


@pytest.mark.parametrize("end", [(-50_000.0, 100.0), (100.0, 90_000.0), (4_500.0, 20.0)])
def test_level_line_ending_outside_its_photo_is_rejected(end: tuple[float, float]) -> None:
    view = wall_view(10.0)
    line = np.array([[[900.0, 100.0], end]])
    with refused("level.outside", x2=end[0], y2=end[1], width=4000, height=3000):
        level_line_findings([view.name], [view], line, None)


def test_vertical_lines_given_as_level_lines_are_reported() -> None:
    """An axis along the columns is upright, unless the photos were held in portrait."""
    names = [f"{turn}" for turn in (-30, 0, 40)]
    views = [wall_view(float(turn)) for turn in (-30, 0, 40)]
    columns = np.tile([[2000.0, 100.0], [2000.0, 2900.0]], (3, 1, 1))
    (finding,) = level_line_findings(names, views, columns, None)
    assert (finding.code, finding.values["photos"]) == ("level.upright", tuple(names))
    rows = np.tile([[100.0, 1500.0], [3900.0, 1500.0]], (3, 1, 1))
    assert level_line_findings(names, views, rows, None) == []
    (finding,) = level_line_findings(names[:1], views[:1], columns[:1], None)
    assert finding.code == "level.portrait"
    mixed = np.array([rows[0], rows[1], columns[2]])
    (finding,) = level_line_findings(names, views, mixed, None)
    assert finding.values["photos"] == ("40",)
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    held = [
        View(v.name, v.intrinsics, quarter @ v.rotation, quarter @ v.translation) for v in views
    ]
    assert level_line_findings(names, held, columns, None) == []


def test_identical_camera_positions_are_rejected() -> None:
    names = tuple(view.name for view in VIEWS)
    places = np.tile([698_000.0, 5_711_000.0, 74.8], (9, 1))
    places[1:, 2] = 0.0
    positions = Positions(names, places, False, np.full((9, 3), np.nan))
    evidence = Evidence(views={view.name: view for view in VIEWS}, positions=positions)
    with refused("gps-equal", GeometryError):
        register(evidence)
