"""Where planes meet: a second library, closed forms, and coverage by simulation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geology.intersections import (
    UncertainPlane,
    deviation95,
    intersection_line,
    mean_plane,
    uncertain_plane,
)
from vomstudio.geology.orientation import Line, Plane, compute_rake

JOINT = -2.0 * math.log(0.05)  # chi squared of two, 95 %


def axial_deg(a, b) -> float:
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(np.dot(a, b)))))


def random_planes(count: int, seed: int) -> list[Plane]:
    chance = np.random.default_rng(seed)
    return [Plane.from_normal(chance.normal(size=3)) for _ in range(count)]


def known(plane: Plane) -> UncertainPlane:
    return UncertainPlane(plane.normal(), None)


def test_intersection_lines_match_mplstereonet(mplstereonet: Any):
    for a, b in zip(random_planes(60, 1), random_planes(60, 2), strict=True):
        plunge, bearing = mplstereonet.plane_intersection(
            a.strike_rhr_deg, a.dip_deg, b.strike_rhr_deg, b.dip_deg
        )
        theirs = Line(float(bearing[0]) % 360.0, float(plunge[0]))
        ours = intersection_line(known(a), known(b))
        assert axial_deg(ours.line.vector(), theirs.vector()) < 1e-6
        assert ours.max_confidence95_deg is None
        assert ours.confidence_axis is None


def test_intersection_rakes_match_mplstereonet(mplstereonet: Any):
    """Its rake runs from the other end of the strike where it is negative."""
    for plane, other in zip(random_planes(60, 3), random_planes(60, 4), strict=True):
        line = intersection_line(known(plane), known(other)).line
        theirs = mplstereonet.azimuth2rake(plane.strike_rhr_deg, plane.dip_deg, line.trend_deg)
        assert compute_rake(line, plane) == pytest.approx(float(theirs) % 180.0, abs=1e-5)


def test_vertical_and_horizontal_planes_intersect_along_strike_of_the_vertical_one():
    found = intersection_line(known(Plane(120.0, 90.0)), known(Plane(0.0, 0.0)))
    assert found.line.plunge_deg == pytest.approx(0.0, abs=1e-9)
    assert found.line.trend_deg % 180.0 == pytest.approx(30.0)
    assert found.angle_deg == pytest.approx(90.0)


def test_parallel_planes_do_not_meet():
    with refused("planes.parallel", GeometryError):
        intersection_line(known(Plane(40.0, 30.0)), known(Plane(40.0, 30.0)))


def test_intersection_line_rotates_with_its_planes():
    chance = np.random.default_rng(8)
    a = spread(chance, np.array([0.3, 0.1, 0.9]), 2.0, 0.5)
    b = spread(chance, np.array([-0.5, 0.6, 0.4]), 1.5, 1.0)
    plain = intersection_line(a, b)
    for _ in range(10):
        turn = np.linalg.qr(chance.normal(size=(3, 3)))[0]
        moved = intersection_line(turned(a, turn), turned(b, turn))
        assert axial_deg(moved.line.vector(), turn @ plain.line.vector()) < 1e-6
        assert moved.max_confidence95_deg == pytest.approx(plain.max_confidence95_deg)
        assert moved.min_confidence95_deg == pytest.approx(plain.min_confidence95_deg)
        assert axial_deg(moved.confidence_axis, turn @ plain.confidence_axis) < 1e-6


def turned(plane: UncertainPlane, turn: np.ndarray) -> UncertainPlane:
    return UncertainPlane(turn @ plane.normal, turn @ plane.spread95 @ turn.T)


def spread(chance, normal, large_deg: float, small_deg: float) -> UncertainPlane:
    """A plane whose normal strays with these semi-axes (joint 95 %), in a random direction."""
    n = normal / np.linalg.norm(normal)
    tilt = np.cross(n, chance.normal(size=3))
    return uncertain_plane(n, tilt / np.linalg.norm(tilt), large_deg, small_deg)


def test_errors_of_perpendicular_planes_become_the_two_axes_of_the_line_error():
    a = uncertain_plane([0, 0, 1], [1, 0, 0], 3.0, 3.0)
    b = uncertain_plane([1, 0, 0], [0, 1, 0], 1.0, 1.0)
    found = intersection_line(a, b)
    assert found.max_confidence95_deg == pytest.approx(3.0)
    assert found.min_confidence95_deg == pytest.approx(1.0)
    # A tilt of the first plane moves the line out of that plane, along its normal.
    assert axial_deg(found.confidence_axis, [0, 0, 1]) < 1e-6


def test_a_narrow_angle_makes_the_line_uncertain():
    widths = []
    for angle in (90.0, 45.0, 20.0, 10.0):
        a = uncertain_plane([0, 0, 1], [1, 0, 0], 1.0, 1.0)
        n = [math.sin(math.radians(angle)), 0.0, math.cos(math.radians(angle))]
        b = uncertain_plane(n, [0, 1, 0], 1.0, 1.0)
        widths.append(intersection_line(a, b).max_confidence95_deg)
    assert widths == sorted(widths)
    # Both planes tilt about the bisector: the sine of half the angle is the lever.
    assert widths[-1] == pytest.approx(1.0 / (math.sqrt(2) * math.sin(math.radians(5.0))), rel=0.01)


def stray(chance, normal: np.ndarray, spread95: np.ndarray, count: int) -> np.ndarray:
    """(count, 3) normals that stray with the covariance behind a joint 95 % ellipse."""
    values, axes = np.linalg.eigh(spread95)
    steps = chance.normal(size=(count, 3)) * np.sqrt(np.maximum(values, 0.0) / JOINT)
    found = normal + steps @ axes.T
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def held(line: Line, axis, largest: float, smallest: float, truth: np.ndarray) -> bool:
    """Whether the ellipse around `line` holds the true direction."""
    v = line.vector()
    t = truth * np.sign(truth @ v)
    t = t / (t @ v) - v
    e1 = axis - v * (axis @ v)
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(v, e1)
    x = (t @ e1) / math.tan(math.radians(largest))
    y = (t @ e2) / math.tan(math.radians(smallest))
    return x * x + y * y <= 1.0


@pytest.mark.parametrize("between", [90.0, 60.0, 30.0, 15.0])
def test_confidence_ellipse_contains_true_line_in_95_percent_of_runs(between):
    chance = np.random.default_rng(int(between))
    n1 = np.array([0.2, -0.4, 0.8])
    n1 /= np.linalg.norm(n1)
    u = np.cross(n1, [1.0, 0.2, 0.0])
    u /= np.linalg.norm(u)
    n2 = math.cos(math.radians(between)) * n1 + math.sin(math.radians(between)) * u
    a, b = spread(chance, n1, 3.0, 0.8), spread(chance, n2, 2.0, 1.0)
    truth = np.cross(n1, n2)
    truth /= np.linalg.norm(truth)
    runs, inside = 1200, 0
    for m1, m2 in zip(
        stray(chance, n1, a.spread95, runs), stray(chance, n2, b.spread95, runs), strict=True
    ):
        found = intersection_line(UncertainPlane(m1, a.spread95), UncertainPlane(m2, b.spread95))
        inside += held(
            found.line,
            found.confidence_axis,
            found.max_confidence95_deg,
            found.min_confidence95_deg,
            truth,
        )
    assert 0.93 <= inside / runs <= 0.97


@pytest.mark.parametrize("n", first_in_default_tier([2, 3, 4, 6, 10, 25]))
def test_mean_plane_region_contains_true_normal_in_95_percent_of_runs(n):
    chance = np.random.default_rng(100 + n)
    truth = np.array([0.3, 0.5, 0.8])
    truth /= np.linalg.norm(truth)
    # Two or three planes do not tell the shape of their scatter: it is taken as round.
    shape = uncertain_plane(truth, np.cross(truth, [0, 0, 1]) / 0.9, 6.0, 6.0 if n < 4 else 2.0)
    runs, inside = 1200, 0
    for _ in range(runs):
        normals = stray(chance, truth, shape.spread95, n)
        signs = np.where(chance.random(n) < 0.5, -1.0, 1.0)
        mean = mean_plane([UncertainPlane(v, None) for v in normals * signs[:, None]])
        step = truth - mean.normal * (truth @ mean.normal)
        inside += step @ np.linalg.pinv(mean.spread95, rcond=1e-9) @ step <= 1.0
    assert 0.93 <= inside / runs <= 0.97


def test_mean_of_one_plane_is_that_plane_and_mean_of_none_raises():
    one = uncertain_plane([0, 0, 1], [1, 0, 0], 3.0, 1.0, 12.0)
    assert mean_plane([one]) is one
    with refused("sets.no-members", GeometryError):
        mean_plane([])


@pytest.mark.parametrize("free", [1.0, 3.0, 8.0, 40.0, math.inf])
def test_interval_of_single_deviation_uses_student_t(free):
    """Against scipy's own laws: the joint half-width is sqrt(2 F), the interval t."""
    from scipy import stats

    joint = math.sqrt(2.0 * stats.f.ppf(0.95, 2, free)) if free < math.inf else math.sqrt(JOINT)
    alone = stats.t.ppf(0.975, free) if free < math.inf else stats.norm.ppf(0.975)
    plane = uncertain_plane([0, 0, 1], [1, 0, 0], 2.0, 1.0, free)
    wide = deviation95(plane, [5.0, 0.0, 0.0])
    assert wide == pytest.approx(5.0 * math.tan(math.radians(2.0)))
    assert deviation95(plane, [5.0, 0.0, 0.0], is_joint=False) / wide == pytest.approx(
        alone / joint
    )
