"""Lines and planes against closed forms, textbooks, mplstereonet and the symmetries of space."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vomstudio.core.errors import GeometryError
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    angle_between_planes,
    angle_line_plane,
    compute_rake,
    intersection,
    line_from_rake,
    lines_to_vectors,
    normals_to_planes,
    planes_to_normals,
    sin_cos_deg,
    slip_from_rake,
    vectors_to_lines,
    wrap360,
)

azimuths = st.floats(0, 360, exclude_max=True)
dips = st.floats(0, 90)
planes = st.builds(Plane, azimuths, dips)
lines = st.builds(Line, azimuths, dips)


def around_up(angle_deg: float) -> np.ndarray:
    """Rotation that adds an angle to every azimuth."""
    s, c = math.sin(math.radians(angle_deg)), math.cos(math.radians(angle_deg))
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def azimuth_gap(a: float, b: float) -> float:
    return abs((a - b + 180) % 360 - 180)


def same_axis(a: np.ndarray, b: np.ndarray) -> float:
    """Angle between two axes in degrees."""
    return math.degrees(math.atan2(np.linalg.norm(np.cross(a, b)), abs(a @ b)))


# Angles


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(360, 0), (-0.0, 0), (-1e-20, 0), (725, 5), (-90, 270), (359.5, 359.5)]
)
def test_azimuths_are_normalized_to_0_360(angle: float, wrapped: float) -> None:
    assert wrap360(angle) == wrapped
    assert math.copysign(1, wrap360(angle)) == 1


A_HAIR_WEST = (1e-17, 1e-16, 2e-15, 1e-12)


@pytest.mark.parametrize("hair", A_HAIR_WEST)
@pytest.mark.parametrize("north", [1.0, -1.0])
def test_azimuth_just_west_of_north_is_never_360(hair: float, north: float) -> None:
    """Its angle is a tiny negative one, which modulo 360 may come out as 360 itself."""
    down, up = np.array([-hair, north, -0.5]), np.array([-hair, north, 0.5])
    for vector in (down, up, -down, -up, np.array([-hair, north, 0.0])):
        plane, line = Plane.from_normal(vector), Line.from_vector(vector)
        directed = Line.from_vector(vector, is_directed=True)
        azimuths = [
            plane.dip_direction_deg,
            plane.strike_rhr_deg,
            plane.pole().trend_deg,
            line.trend_deg,
            line.to_downward().trend_deg,
            line.normal_plane().dip_direction_deg,
            directed.trend_deg,
            directed.to_downward().trend_deg,
            float(normals_to_planes(vector)[0][0]),
            float(vectors_to_lines(vector)[0][0]),
            float(vectors_to_lines(vector, is_directed=True)[0][0]),
            Plane(-hair, 30).dip_direction_deg,
            Plane.from_strike(270 - hair, 30).dip_direction_deg,
            Plane(90 - hair, 30).strike_rhr_deg,
            Line(-hair, 30).trend_deg,
            Line(180 - hair, -30).to_downward().trend_deg,
        ]
        assert all(0.0 <= azimuth < 360.0 for azimuth in azimuths), azimuths


def test_sines_are_exact_at_right_angles() -> None:
    sine, cosine = sin_cos_deg(np.arange(-720.0, 721.0, 90.0))
    assert set(sine) == {-1.0, 0.0, 1.0}
    assert set(cosine) == {-1.0, 0.0, 1.0}
    angles = np.linspace(-800, 800, 1601)
    np.testing.assert_allclose(sin_cos_deg(angles)[0], np.sin(np.radians(angles)), atol=1e-14)


def test_scalar_and_array_sines_are_bit_identical() -> None:
    angles = np.append(np.random.default_rng(3).uniform(-800.0, 800.0, 200), [-90.0, -0.0, 45.0])
    together = sin_cos_deg(angles)
    for place, angle in enumerate(angles.tolist()):
        for single, many in zip(sin_cos_deg(angle), together, strict=True):
            assert single.tobytes() == many[place].tobytes()
    assert np.isnan(sin_cos_deg(math.nan)).all()


# The conventions, point by point


def test_line_vector_follows_trend_and_plunge() -> None:
    np.testing.assert_array_equal(Line(0, 0).vector(), [0, 1, 0])
    np.testing.assert_array_equal(Line(90, 0).vector(), [1, 0, 0])
    np.testing.assert_array_equal(Line(123, 90).vector(), [0, 0, -1])
    h = math.sqrt(0.5)
    np.testing.assert_allclose(Line(180, 45).vector(), [0, -h, -h], atol=1e-16)


def test_plane_normal_points_up_and_toward_dip() -> None:
    h = math.sqrt(0.5)
    np.testing.assert_allclose(Plane(90, 45).normal(), [h, 0, h], atol=1e-16)
    np.testing.assert_array_equal(Plane(90, 90).normal(), [1, 0, 0])
    np.testing.assert_array_equal(Plane(77, 0).normal(), [0, 0, 1])


@given(planes)
def test_the_pole_is_the_downward_normal(plane: Plane) -> None:
    np.testing.assert_allclose(plane.pole().vector(), -plane.normal(), atol=1e-8)
    if not plane.undefined:
        assert plane.pole().plunge_deg == pytest.approx(90 - plane.dip_deg)
        assert azimuth_gap(plane.pole().trend_deg, plane.dip_direction_deg + 180) < 1e-9 or (
            plane.pole().undefined
        )


@given(planes)
def test_the_plane_dips_to_the_right_of_its_strike(plane: Plane) -> None:
    assume(not plane.undefined)
    assert azimuth_gap(plane.strike_rhr_deg + 90, plane.dip_direction_deg) < 1e-9


@given(planes)
def test_planes_round_trip_through_normals(plane: Plane) -> None:
    for normal in (plane.normal(), -plane.normal(), 1e-9 * plane.normal()):
        back = Plane.from_normal(normal)
        assert back.dip_deg == pytest.approx(plane.dip_deg, abs=2e-7)
        assert same_axis(back.normal(), plane.normal()) < 2e-7
        if 1e-6 < plane.dip_deg < 90 - 1e-6:
            spread = 1e-9 / math.sin(math.radians(plane.dip_deg))
            assert azimuth_gap(back.dip_direction_deg, plane.dip_direction_deg) < max(spread, 1e-9)


@given(lines)
def test_lines_round_trip_through_vectors(line: Line) -> None:
    for vector in (line.vector(), -line.vector(), 1e12 * line.vector()):
        assert same_axis(Line.from_vector(vector).vector(), line.vector()) < 2e-7
    directed = Line.from_vector(-line.vector(), is_directed=True)
    np.testing.assert_allclose(directed.vector(), -line.vector(), atol=1e-8)


@given(planes, st.floats(-720, 720))
def test_rotation_about_vertical_adds_to_dip_directions(plane: Plane, turn: float) -> None:
    back = Plane.from_normal(around_up(turn) @ plane.normal())
    assert back.dip_deg == pytest.approx(plane.dip_deg, abs=2e-7)
    if 1e-3 < plane.dip_deg < 90 - 1e-3:
        assert azimuth_gap(back.dip_direction_deg, plane.dip_direction_deg + turn) < 1e-6


@given(planes, planes, st.floats(-720, 720))
def test_rotation_about_vertical_rotates_intersections(a: Plane, b: Plane, turn: float) -> None:
    assume(angle_between_planes(a, b) > 0.1)
    turned = [Plane.from_normal(around_up(turn) @ p.normal()) for p in (a, b)]
    expected = around_up(turn) @ intersection(a, b).vector()
    assert same_axis(intersection(*turned).vector(), expected) < 1e-4


def test_azimuths_outside_0_360_give_equal_planes() -> None:
    assert Plane.from_strike(371, 20) == Plane.from_strike(11, 20)
    assert Plane(-228, 41) == Plane(132, 41)


# What is undefined, vertical, horizontal


def test_horizontal_planes_and_vertical_lines_are_flagged() -> None:
    assert Plane(77, 0).undefined
    assert Plane(77, 0).dip_direction_deg == 0
    assert Plane.from_normal([0, 0, -3]).undefined
    assert Plane(77, 0).pole().undefined
    assert Line(77, 90).undefined
    assert Line(77, 90).trend_deg == 0
    assert not Plane(77, 0.001).undefined
    assert Plane(77, 0.001).dip_direction_deg == 77
    _, dip, flags = normals_to_planes([[0, 0, 1], [0.1, 0, 1]])
    assert flags.tolist() == [True, False]
    assert dip[0] == 0


@given(st.floats(-720, 720))
def test_vertical_plane_attitude_does_not_depend_on_normal_sign(azimuth: float) -> None:
    normal = Plane(azimuth, 90).normal()
    nudges = ([0, 0, 0], [0, 0, 1e-17], [0, 0, -1e-17])
    names = [Plane.from_normal(sign * normal + n) for sign in (1, -1) for n in nudges]
    assert len({n.dip_deg for n in names}) == 1
    assert max(azimuth_gap(n.dip_direction_deg, names[0].dip_direction_deg) for n in names) < 1e-9
    assert all(n.strike_rhr_deg < 180 for n in names)


@given(st.floats(-720, 720))
def test_horizontal_axis_trend_does_not_depend_on_vector_sign(azimuth: float) -> None:
    vector = Line(azimuth, 0).vector()
    a, b = Line.from_vector(vector), Line.from_vector(-vector)
    assert azimuth_gap(a.trend_deg, b.trend_deg) < 1e-9
    assert a.trend_deg < 180


def test_nearly_horizontal_planes_keep_precision() -> None:
    azimuth, dip, _ = normals_to_planes(planes_to_normals([200.0], [1e-5]))
    assert dip[0] == pytest.approx(1e-5, rel=1e-9)
    assert azimuth[0] == pytest.approx(200, abs=1e-8)


def test_undefined_directions_give_nan_and_input_is_unchanged() -> None:
    given_vectors = np.array([[0.0, 0, 0], [np.nan, 0, 1], [0, 0, 5.0]])
    before = given_vectors.copy()
    for function in (vectors_to_lines, normals_to_planes):
        a, b, undefined = function(given_vectors)
        assert np.isnan(a[:2]).all()
        assert np.isnan(b[:2]).all()
        assert undefined.tolist() == [False, False, True]
    np.testing.assert_array_equal(given_vectors, before)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Plane(10, 91),
        lambda: Plane(10, -1),
        lambda: Plane(math.nan, 10),
        lambda: Plane(10, math.inf),
        lambda: Line(10, 95),
        lambda: Plane.from_normal([0, 0, 0]),
        lambda: Line.from_vector([1, math.nan, 0]),
        lambda: intersection(Plane(10, 20), Plane(10, 20)),
        lambda: compute_rake(Plane(10, 20).pole(), Plane(10, 20)),
    ],
)
def test_invalid_orientations_raise(make) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(GeometryError):
        make()


# Intersections, angles


def test_textbook_intersection_of_two_limbs_is_reproduced() -> None:
    # Two limbs that dip 45 east and west meet in a horizontal line north to south.
    assert intersection(Plane(90, 45), Plane(270, 45)) == Line(0, 0)
    # Equal dips d, dip directions 90 apart: plunge with tan p = tan d cos 45, halfway between.
    line = intersection(Plane(0, 30), Plane(90, 30))
    assert line.trend_deg == pytest.approx(45)
    expected = math.degrees(math.atan(math.tan(math.radians(30)) * math.cos(math.radians(45))))
    assert line.plunge_deg == pytest.approx(expected)


@given(planes, planes)
def test_the_intersection_lies_in_both_planes(a: Plane, b: Plane) -> None:
    assume(angle_between_planes(a, b) > 1e-3)
    line = intersection(a, b)
    assert angle_line_plane(line, a) < 1e-6
    assert angle_line_plane(line, b) < 1e-6


def test_intersections_agree_with_mplstereonet(mplstereonet: Any) -> None:
    rng = np.random.default_rng(4)
    for _ in range(200):
        a, b = (Plane(rng.uniform(0, 360), rng.uniform(1, 89)) for _ in range(2))
        plunge, trend = mplstereonet.plane_intersection(
            a.strike_rhr_deg, a.dip_deg, b.strike_rhr_deg, b.dip_deg
        )
        other = lines_to_vectors(trend, plunge)[0]
        assert same_axis(intersection(a, b).vector(), other) < 1e-6


def test_angles_distinguish_axes_from_directions() -> None:
    assert angle_between_planes(Plane(90, 60), Plane(270, 60)) == pytest.approx(60)
    assert angle_between_lines(Line(0, 0), Line(180, 0)) == pytest.approx(0)
    assert angle_between_lines(Line(0, 0), Line(180, 0), is_directed=True) == pytest.approx(180)
    assert angle_between_planes(Plane(10, 30), Plane(10, 30 + 1e-9)) == pytest.approx(
        1e-9, rel=1e-4
    )


# Rakes


def test_rakes_increase_from_strike_through_dip() -> None:
    plane = Plane.from_strike(40, 30)
    assert line_from_rake(plane, 0).trend_deg == pytest.approx(40)
    assert angle_between_lines(line_from_rake(plane, 90), Line(130, 30)) < 1e-9
    assert compute_rake(Line(130, 30), plane) == pytest.approx(90)
    assert compute_rake(Line(220, 0), plane) == pytest.approx(0)
    # sin(plunge) = sin(rake) sin(dip)
    line = line_from_rake(plane, 150)
    assert math.sin(math.radians(line.plunge_deg)) == pytest.approx(0.25)


@given(planes, st.floats(0, 180, exclude_max=True))
def test_rakes_round_trip(plane: Plane, rake: float) -> None:
    line = line_from_rake(plane, rake)
    assert angle_line_plane(line, plane) < 2e-7
    gap = abs((compute_rake(line, plane) - rake + 90) % 180 - 90)
    assert gap < 1e-5


def test_rakes_agree_with_mplstereonet(mplstereonet: Any) -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        strike, dip, rake = rng.uniform(0, 360), rng.uniform(1, 89), rng.uniform(0, 180)
        plunge, bearing = mplstereonet.stereonet_math.geographic2plunge_bearing(
            *mplstereonet.rake(strike, dip, rake)
        )
        line = line_from_rake(Plane.from_strike(strike, dip), rake)
        assert same_axis(line.vector(), lines_to_vectors(bearing, plunge)[0]) < 1e-6


@pytest.mark.parametrize("dip_direction", [120.0, 300.0])
def test_rakes_on_vertical_plane_start_at_strike_below_180(dip_direction: float) -> None:
    plane = Plane(dip_direction, 90)
    assert compute_rake(Line(30, 20), plane) == pytest.approx(20)
    assert compute_rake(Line(210, 20), plane) == pytest.approx(160)


@pytest.mark.parametrize(
    ("rake", "plunge", "trend"),
    # Strike 0, dip 60 to the east: the hanging wall is the east.
    [(90, -60, 270), (-90, 60, 90), (0, 0, 0), (180, 0, 180)],
)
def test_slip_is_the_motion_of_the_hanging_wall(rake: float, plunge: float, trend: float) -> None:
    plane = Plane.from_strike(0, 60)
    slip = slip_from_rake(plane, rake)
    assert slip.plunge_deg == pytest.approx(plunge, abs=1e-9)
    assert azimuth_gap(slip.trend_deg, trend) < 1e-9
