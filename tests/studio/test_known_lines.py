"""Models that are placed in part by lines of which something is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Model
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.studio.placing.known_lines import line_residuals
from vomstudio.studio.placing.register_order import register_model
from vomstudio.studio.placing.registering import create_registration, place_by_points

BARE = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64)
NO_PAIRS = Pairs((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, bool))
TURN = Rotation.from_euler("xyz", [8.0, -5.0, 30.0], degrees=True).as_matrix()
"""From World to the file."""
SCALE = 0.25
EXTENT = np.random.default_rng(3).uniform(-20.0, 20.0, (50, 3))


def line(number: int, kind: str, azimuth_deg: float, plunge_deg: float = 0.0, **more) -> KnownLine:
    """10 m long in World, from its middle."""
    a, p = np.radians([azimuth_deg, plunge_deg])
    step = np.array([np.sin(a) * np.cos(p), np.cos(a) * np.cos(p), -np.sin(p)])
    ends = (np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0] + 10.0 * step])) @ TURN.T / SCALE
    return KnownLine(
        f"k{number}",
        f"K{number}",
        kind,
        "m1",
        BARE.content_hash,
        tuple(map(tuple, ends.tolist())),
        **more,
    )


LEVEL = [line(1, "level", 10.0), line(2, "level", 95.0)]
AZIMUTH = line(3, "azimuth", 220.0, 20.0, value=220.0)
PLUMB = line(8, "plumb", 0.0, 90.0)
LENGTH = line(4, "length", 77.0, -40.0, value=10.0)


def registered(lines, model=BARE, crs=None) -> Registration:
    placed = place_by_points(NO_PAIRS, None, model, crs, EXTENT, lines)
    return create_registration(placed, NO_PAIRS, model, crs)


@pytest.mark.parametrize(
    ("lines", "frame"),
    [
        (LEVEL, Frame("undeclared", level=True)),
        ([*LEVEL, LENGTH], Frame("scaled", level=True)),
        ([LENGTH], Frame("scaled")),
        ([*LEVEL, AZIMUTH], Frame("oriented")),
        ([*LEVEL, AZIMUTH, LENGTH], Frame("local")),
        ([PLUMB], Frame("undeclared", level=True)),
        ([PLUMB, AZIMUTH, LENGTH], Frame("local")),
    ],
)
def test_frame_claims_only_properties_determined_by_the_lines(lines, frame) -> None:
    record = registered(lines)
    assert record.frame == frame
    assert record.method == "lines"
    turn = np.array(record.matrix)[:3, :3] @ TURN
    if frame.has_up:
        up = turn @ [0.0, 0.0, 1.0]
        assert up / np.linalg.norm(up) == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    if frame.has_metres:
        assert np.cbrt(np.linalg.det(turn)) == pytest.approx(SCALE, rel=1e-6)
    if frame.has_north:
        assert turn / np.cbrt(np.linalg.det(turn)) == pytest.approx(np.eye(3), abs=1e-6)


def test_known_text_lists_north_vertical_scale_and_position_once() -> None:
    for frame in (
        Frame(),
        Frame("scaled", level=True),
        Frame("oriented"),
        Frame("local"),
        Frame("crs", crs="EPSG:32633"),
    ):
        words = frame.known_text()
        assert [words.count(w) for w in ("north", "vertical", "scale", "position")] == [1] * 4


def test_registration_record_matches_the_register_command() -> None:
    def text(known: KnownLine) -> str:
        values = [*known.vertices[0], *known.vertices[1]]
        values += [] if known.value is None else [known.value]
        return ",".join(repr(v) for v in values)

    record = registered([*LEVEL, PLUMB, AZIMUTH, LENGTH])
    options = RegisterOptions(
        level=tuple(text(known) for known in LEVEL),
        plumb=(text(PLUMB),),
        bearing=(text(AZIMUTH),),
        scale=(text(LENGTH),),
    )
    placed = register_model("-", options, None).placed
    ours, theirs = np.array(record.matrix)[:3, :3], np.array(placed.matrix)[:3, :3]
    assert ours == pytest.approx(theirs, abs=1e-9)
    shape = np.array(record.covariance)[:4, :4]
    assert shape == pytest.approx(np.array(placed.covariance)[:4, :4], rel=1e-6, abs=1e-15)


def test_parameters_undetermined_by_lines_keep_their_value_and_error() -> None:
    """A model that GPS has placed, tilted by 4 degrees and doubted by 3, is levelled: its north,
    its scale and its system stay, and the error of these."""
    tilted = Rotation.from_euler("x", 4.0, degrees=True).as_matrix() @ TURN.T
    matrix = np.eye(4)
    matrix[:3, :3] = SCALE * tilted
    matrix[:3, 3] = [398_000.0, 4_980_000.0, 320.0]
    sigma = np.array([*np.radians([3.0, 3.0, 2.0]), 0.02, 1.0, 1.0, 2.0])
    gps = Registration(
        "r1",
        "gps",
        "gps",
        Frame("crs", crs="EPSG:32633"),
        tuple(map(tuple, matrix.tolist())),
        covariance=tuple(map(tuple, np.diag(sigma**2).tolist())),
        centre=(398_000.0, 4_980_000.0, 320.0),
    )
    model = replace(BARE, placement=gps)
    record = registered(LEVEL, model)
    assert record.frame == gps.frame
    turn = np.array(record.matrix)[:3, :3] @ TURN / SCALE
    assert turn[2, 2] == pytest.approx(1.0, abs=1e-6)
    # Turned by the tilt alone.
    moved = turn @ (tilted @ TURN).T
    angle = np.degrees(np.arccos((np.trace(moved) - 1.0) / 2.0))
    assert angle == pytest.approx(4.0, abs=1e-3)
    covariance = np.array(record.covariance)
    assert np.degrees(np.sqrt(covariance[2, 2])) == pytest.approx(2.0, rel=1e-6)
    assert np.degrees(np.sqrt(covariance[:2, :2].trace())) < 1.0
    assert np.sqrt(covariance[3, 3]) == pytest.approx(0.02, rel=1e-6)
    # To do it again changes nothing.
    again = registered(LEVEL, replace(model, placement=record))
    assert np.array(again.matrix)[:3] == pytest.approx(np.array(record.matrix)[:3], abs=1e-6)
    assert np.array(again.covariance)[:4, :4] == pytest.approx(covariance[:4, :4], rel=1e-6)


def test_residuals_have_the_unit_of_their_line_and_check_lines_are_not_fitted() -> None:
    wrong = replace(line(5, "level", 40.0, 6.0), check=True)
    long = replace(LENGTH, id="k6", name="K6", value=10.5, check=True)
    far = replace(AZIMUTH, id="k7", name="K7", value=225.0, check=True)
    leaning = replace(line(9, "plumb", 120.0, -86.0), check=True)
    judges = [wrong, long, far, leaning]
    lines = [*LEVEL, PLUMB, AZIMUTH, LENGTH]
    placed = place_by_points(NO_PAIRS, None, BARE, None, EXTENT, [*lines, *judges])
    deviation = {miss.id: miss.deviation for miss in line_residuals([*lines, *judges], placed)}
    for each in lines:
        assert deviation[each.id] == pytest.approx(0.0, abs=1e-5)
    assert deviation["k5"] == pytest.approx(-6.0, abs=1e-5)
    assert deviation["k6"] == pytest.approx(-0.5, abs=1e-6)
    assert deviation["k7"] == pytest.approx(-5.0, abs=1e-5)
    assert deviation["k9"] == pytest.approx(4.0, abs=1e-5)


def test_common_azimuth_error_is_included_in_the_north_error() -> None:
    many = [replace(AZIMUTH, id=f"a{i}", name=f"A{i}", sigma=0.01) for i in range(9)]
    placed = place_by_points(NO_PAIRS, None, BARE, None, EXTENT, [*LEVEL, *many], 4.0)
    assert placed.rotation_error_deg.about_up == pytest.approx(4.0, rel=0.01)


def test_photo_upright_refers_to_file_axes_even_for_a_rotated_model() -> None:
    """Two lines 2 degrees apart level the model along them; what they leave open stays by the
    photos, wherever the model stands."""
    up = TURN @ [0.0, 0.0, 1.0]
    lines = [line(1, "level", 10.0), line(2, "level", 12.0, 1.0)]
    turned = Rotation.from_euler("xyz", [25.0, 10.0, 60.0], degrees=True).as_matrix()
    matrix = np.eye(4)
    matrix[:3, :3] = turned
    record = Registration("r", "r", "lines", Frame("scaled"), tuple(map(tuple, matrix.tolist())))
    for model in (BARE, replace(BARE, placement=record)):
        placed = place_by_points(NO_PAIRS, None, model, None, EXTENT, lines, photo_up=up)
        tilt = placed.matrix[:3, :3] / placed.scale @ up
        assert np.degrees(np.arccos(tilt[2])) < 1.0
        assert not placed.known.vertical
    assert {group.kind for group in placed.observations} == {"level_lines", "photo_upright"}


def test_line_without_a_value_is_ignored() -> None:
    bare = replace(AZIMUTH, value=None)
    assert not line_residuals([bare], place_by_points(NO_PAIRS, None, BARE, None, EXTENT, LEVEL))
    assert not place_by_points(NO_PAIRS, None, BARE, None, EXTENT, [*LEVEL, bare]).known.north
