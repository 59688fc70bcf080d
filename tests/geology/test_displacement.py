"""Displacements whose closed form is known, and their errors beside simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.messages import by_code, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geology.faults.displacement import (
    DisplacementErrors,
    net_slip_from_cutoffs,
    net_slip_from_piercing_points,
    separations,
)
from vomstudio.geology.faults.three_points import plane_of_three_points
from vomstudio.geology.orientation import (
    Line,
    Plane,
    compute_rake,
    line_from_rake,
    normals_to_planes,
    slip_from_rake,
)

FAULT = Plane(90.0, 60.0)
LEVEL = Plane(0.0, 0.0)
AT = np.array([433_000.0, 5_200_000.0, 812.0])


def test_normal_fault_of_60_degrees_has_closed_form_components() -> None:
    """Ten metres down the dip: throw 10 sin 60, heave 10 cos 60."""
    moved = 10 * np.array([math.cos(math.radians(60)), 0, -math.sin(math.radians(60))])
    found = net_slip_from_piercing_points(AT + moved, AT, FAULT)
    assert found.what == "net slip"
    assert found.net_m.value == pytest.approx(10)
    assert found.throw_m.value == pytest.approx(10 * math.sin(math.radians(60)))
    assert found.heave_m.value == pytest.approx(5)
    assert found.strike_slip_m.value == pytest.approx(0, abs=1e-9)
    assert found.dip_slip_m.value == pytest.approx(-10)
    assert found.slip_rake_deg == pytest.approx(-90)
    assert (found.trend_deg, found.plunge_deg) == pytest.approx((90, 60))
    assert found.off_fault_m == pytest.approx(0, abs=1e-9)
    assert found.net_m.error95 is None


@pytest.mark.parametrize("rake", [-170.0, -90.0, -35.0, 0.0, 20.0, 90.0, 140.0])
@pytest.mark.parametrize(
    "fault", [FAULT, Plane(200.0, 35.0), Plane(130.0, 90.0), Plane(300.0, 90.0)]
)
def test_slip_of_any_rake_is_recovered(fault: Plane, rake: float) -> None:
    """Both ways, from the point itself and from a bed that is nowhere near the slip."""
    slip = 7.0 * slip_from_rake(fault, rake).vector()
    found = net_slip_from_piercing_points(AT + slip, AT, fault)
    assert found.net_m.value == pytest.approx(7)
    assert (found.slip_rake_deg - rake + 180) % 360 - 180 == pytest.approx(0, abs=1e-6)
    bed = next(
        b
        for b in (Plane(20, 15), Plane(75, 80), Plane(340, 70))
        if abs(slip @ normal(b)) > 7 * math.sin(math.radians(15))
    )
    along_bed = np.cross(normal(bed), [0.3, 0.2, 0.9])
    lineation = compute_rake(Line.from_vector(slip), fault)
    by_bed = net_slip_from_cutoffs(AT + slip + 2 * along_bed, AT, fault, bed, lineation)
    assert by_bed.net_m.value == pytest.approx(7)
    assert (by_bed.slip_rake_deg - rake + 180) % 360 - 180 == pytest.approx(0, abs=1e-6)


def normal(plane: Plane) -> np.ndarray:
    dd, d = math.radians(plane.dip_direction_deg), math.radians(plane.dip_deg)
    return np.array([math.sin(dd) * math.sin(d), math.cos(dd) * math.sin(d), math.cos(d)])


def test_horizontal_beds_with_unknown_slip_give_separations() -> None:
    """A bed 3 m lower on the hanging wall: throw 3, heave 3 / tan 60, no strike separation."""
    found = separations(AT + [4.0, 17.0, -3.0], AT, FAULT, LEVEL)
    assert found.stratigraphic_m.value == pytest.approx(3)
    assert found.dip is not None
    assert found.dip.what == "separation"
    assert found.dip.throw_m.value == pytest.approx(3)
    assert found.dip.heave_m.value == pytest.approx(3 / math.tan(math.radians(60)))
    assert found.dip.net_m.value == pytest.approx(3 / math.sin(math.radians(60)))
    assert found.strike_m is None


def test_strike_slip_of_a_dipping_bed_looks_like_a_throw() -> None:
    """A vertical fault that runs east, and a bed that dips east by 45 degrees: 5 m along the strike
    and 5 m of throw look the same."""
    fault, bed = Plane(180.0, 90.0), Plane(90.0, 45.0)
    moved = 5 * slip_from_rake(fault, 0.0).vector()
    found = separations(AT + moved, AT, fault, bed)
    assert found.stratigraphic_m.value == pytest.approx(5 * math.sin(math.radians(45)))
    assert abs(found.dip.throw_m.value) == pytest.approx(5)
    assert found.strike_m.value == pytest.approx(5)


def test_a_slip_along_the_bed_is_refused() -> None:
    with refused("displacement.slip-along-bed", GeometryError, limit_deg=5.0):
        net_slip_from_cutoffs(AT, AT + 1, FAULT, LEVEL, 2.0)
    with refused("displacement.bed-along-fault", GeometryError, limit_deg=5.0):
        separations(AT, AT + 1, FAULT, Plane(92, 62))
    with refused("points.invalid", GeometryError):
        net_slip_from_piercing_points([0, 0, np.nan], AT, FAULT)


def test_rotation_rotates_slip_and_keeps_components() -> None:
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    moved = np.array([3.0, -4.0, -2.0])
    one = net_slip_from_piercing_points(moved, np.zeros(3), FAULT)
    two = net_slip_from_piercing_points(turn @ moved, np.zeros(3), Plane(120.0, 60.0))
    assert two.trend_deg == pytest.approx(one.trend_deg + 30)
    for name in ("net_m", "throw_m", "heave_m", "strike_slip_m", "dip_slip_m"):
        assert getattr(two, name).value == pytest.approx(getattr(one, name).value)


@pytest.mark.full
def test_stated_errors_match_simulation() -> None:
    chance = np.random.default_rng(2)
    errors = DisplacementErrors(sigma_m=0.05, fault95_deg=4.0, bed95_deg=3.0, rake95_deg=10.0)
    fault, bed, rake = Plane(70.0, 55.0), Plane(20.0, 20.0), 80.0
    slip = 6 * line_from_rake(fault, rake).vector()
    stated = net_slip_from_cutoffs(AT + slip, AT, fault, bed, rake, errors)
    cone = math.radians(1) / math.sqrt(-2 * math.log(0.05))

    def tilted(plane: Plane, half_angle: float) -> Plane:
        n = normal(plane)
        e = np.linalg.svd(n[None])[2][1:]
        n = n + half_angle * cone * chance.normal(size=2) @ e
        direction, dip, _ = normals_to_planes(n)
        return Plane(float(direction[0]), float(dip[0]))

    figures = []
    for _ in range(3000):
        one = net_slip_from_cutoffs(
            AT + slip + chance.normal(0, 0.05, 3),
            AT + chance.normal(0, 0.05, 3),
            tilted(fault, 4.0),
            tilted(bed, 3.0),
            rake + chance.normal(0, 10 / 1.96),
        )
        figures.append(
            [one.net_m.value, one.throw_m.value, one.heave_m.value, one.strike_slip_m.value]
        )
    spread = 1.96 * np.std(figures, axis=0)
    told = [getattr(stated, n).error95 for n in ("net_m", "throw_m", "heave_m", "strike_slip_m")]
    np.testing.assert_allclose(told, spread, rtol=0.08)


def test_plane_of_three_points_matches_hand_calculation() -> None:
    """Outcrops at 100, 100 and 80 m: the strike runs through the first two."""
    found = plane_of_three_points(np.array([[0, 0, 100], [0, 50, 100], [40, 20, 80.0]]) + AT)
    assert found.plane.dip_direction_deg == pytest.approx(90)
    assert found.plane.dip_deg == pytest.approx(math.degrees(math.atan(0.5)))
    assert found.dip_error_deg is None
    with refused("points.collinear", GeometryError, n=3):
        plane_of_three_points([[0, 0, 0], [1, 1, 1], [2, 2, 2]])


def test_errors_of_three_points_match_simulation() -> None:
    chance = np.random.default_rng(3)
    points = np.array([[0, 0, 0], [10, 2, -4], [3, 9, -5.0]]) + AT
    stated = plane_of_three_points(points, 0.1)
    tried = [plane_of_three_points(points + chance.normal(0, 0.1, (3, 3))) for _ in range(3000)]
    dips = [t.plane.dip_deg for t in tried]
    turns = [
        (t.plane.dip_direction_deg - stated.plane.dip_direction_deg + 180) % 360 - 180
        for t in tried
    ]
    assert stated.dip_error_deg == pytest.approx(1.96 * np.std(dips), rel=0.06)
    assert stated.dip_direction_error_deg == pytest.approx(1.96 * np.std(turns), rel=0.06)
    assert stated.max_confidence95_deg > stated.dip_error_deg


def test_the_errors_of_many_points_cover_the_truth() -> None:
    """Of eight points with an unknown error 95 % of the intervals hold the true plane's dip, and
    95 % of the cones its normal."""
    chance = np.random.default_rng(5)
    places = chance.uniform(-10, 10, (8, 2))
    truth = Plane(220.0, 35.0)
    normal = truth.normal()
    flat = np.column_stack([places, -(places @ normal[:2]) / normal[2]])
    dips = cones = 0
    for _ in range(600):
        found = plane_of_three_points(AT + flat + chance.normal(0, 0.2, (8, 3)))
        dips += abs(found.plane.dip_deg - 35.0) <= found.dip_error_deg
        off = math.degrees(math.acos(min(1.0, found.plane.normal() @ normal)))
        cones += off <= found.max_confidence95_deg
    assert 0.92 <= dips / 600 <= 0.975
    assert 0.93 <= cones / 600 <= 0.99


@pytest.mark.full
def test_stated_errors_of_many_points_match_simulation() -> None:
    chance = np.random.default_rng(6)
    points = np.array([[0, 0, 0], [10, 2, -4], [3, 9, -5.0], [9, 9, -8], [5, 5, -5]]) + AT
    stated = plane_of_three_points(points, 0.1)
    tried = [plane_of_three_points(points + chance.normal(0, 0.1, (5, 3))) for _ in range(2000)]
    dips = [t.plane.dip_deg for t in tried]
    assert stated.dip_error_deg == pytest.approx(1.96 * np.std(dips), rel=0.06)


@pytest.mark.parametrize("beside", first_in_default_tier([0.01, 0.1, 0.3, 2.0, 20.0]))
def test_errors_of_nearly_collinear_points_are_reliable(beside: float) -> None:
    """Of three points known to 5 cm over 200 m: at least 95 % of the dips drawn about the true
    plane, and of those found from what was drawn, lie within what is stated."""
    chance = np.random.default_rng(int(100 * beside))
    points = np.array([[0, 0, 0], [100, 0, 10], [200, beside, 20.0]])
    if beside > 1.0:
        points[1, 1] += beside
    truth = plane_of_three_points(points).plane
    inside = cones = 0
    for _ in range(400):
        found = plane_of_three_points(points + chance.normal(0, 0.05, (3, 3)), 0.05)
        assert found.dip_error_deg is not None
        assert found.max_confidence95_deg is not None
        inside += abs(found.dip_deg - truth.dip_deg) <= found.dip_error_deg
        across = abs(float(found.plane.normal() @ truth.normal()))
        cones += math.degrees(math.acos(min(1.0, across))) <= found.max_confidence95_deg
    assert inside / 400 >= 0.93
    assert cones / 400 >= 0.93
    stated = plane_of_three_points(points, 0.05)
    assert ("points.uncertain-about-line" in by_code(stated.warnings)) == (beside < 1.0)
    unstated = plane_of_three_points(points)
    assert ("points.nearly-collinear" in by_code(unstated.warnings)) == (beside < 10.0)


def test_collinear_points_leave_dip_between_plunge_and_90_degrees() -> None:
    """Of points on a line whose plunge is 5.7 degrees all planes that hold it remain."""
    points = np.array([[0, 0, 0], [100, 0, 10], [200, 0.001, 20.0]])
    found = plane_of_three_points(points, 0.05)
    plunge = math.degrees(math.atan(0.1))
    assert found.dip_deg + found.dip_error_deg >= 90.0 or (
        found.dip_deg - found.dip_error_deg <= plunge + 0.1
    )
    assert found.dip_direction_error_deg is None
    assert found.max_confidence95_deg == pytest.approx(90.0)


def test_wide_triangle_gives_no_warning() -> None:
    chance = np.random.default_rng(8)
    for _ in range(300):
        points = chance.uniform(-50, 50, (3, 3))
        sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if sizes[1] > 0.1 * sizes[0]:
            assert not plane_of_three_points(points, 0.02).warnings
            assert not plane_of_three_points(points).warnings


@pytest.mark.parametrize("stated", [0.05, 0.0])
def test_noise_around_a_line_determines_no_plane(stated: float) -> None:
    """Of six points on a line the normal found is one by chance: the cone is all round it."""
    chance = np.random.default_rng(21)
    line = np.linspace(-100, 100, 6)[:, None] * [[0.8, 0.36, 0.48]]
    known = 0
    for _ in range(300):
        found = plane_of_three_points(line + chance.normal(0, 0.05, (6, 3)), stated)
        assert found.max_confidence95_deg is not None
        known += found.max_confidence95_deg < 89.9
    assert known / 300 <= 0.08


@pytest.mark.parametrize("n", first_in_default_tier([3, 5, 8], 2))
@pytest.mark.parametrize("beside", first_in_default_tier([0.1, 1.0, 10.0], 2))
def test_reported_dip_direction_errors_are_reliable(n: int, beside: float) -> None:
    """Of points known to 5 cm along 20 m, the less they lie beside the line the fewer are told."""
    chance = np.random.default_rng(n)
    told, held = 0, 0
    for _ in range(300):
        flat = chance.uniform(-1.0, 1.0, (n, 2)) * (10.0, beside)
        turn = np.linalg.qr(chance.normal(size=(3, 3)))[0]
        normal = turn[:, 2] * np.sign(turn[2, 2])
        points = np.column_stack([flat, np.zeros(n)]) @ turn.T + chance.normal(0, 0.05, (n, 3))
        found = plane_of_three_points(points, 0.05)
        if found.dip_direction_error_deg is None:
            continue
        true = math.degrees(math.atan2(normal[0], normal[1]))
        off = (true - found.dip_direction_deg + 180.0) % 360.0 - 180.0
        told += 1
        held += abs(off) <= found.dip_direction_error_deg
    assert held >= 0.9 * told or told <= 0.04 * 300
    assert told >= 270 or beside < 10.0
