"""Lines through points: closed forms, laws, and coverage of the 95 % cone by simulation."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.lines import (
    fit_line,
    nearest_approach,
    path_length,
    path_lengths,
    ring_area,
)


def turns(count: int, seed: int = 3) -> list[np.ndarray]:
    chance = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        q, _ = np.linalg.qr(chance.normal(size=(3, 3)))
        found.append(q * np.sign(np.linalg.det(q)))
    return found


def axial_deg(a, b) -> float:
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(np.dot(a, b)))))


def test_two_points_give_downward_direction_and_no_error():
    fit = fit_line([[10.0, 20.0, 5.0], [13.0, 20.0, 9.0]])
    assert fit.direction == pytest.approx([-0.6, 0.0, -0.8])
    assert fit.length == pytest.approx(5.0)
    assert fit.confidence95_deg is None
    assert fit.rms == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("points", [[[1, 2, 3]], [[1, 2, 3]] * 4, [[0, 0, 0], [np.nan, 0, 0]]])
def test_points_without_a_line_are_rejected(points):
    with pytest.raises(GeometryError):
        fit_line(points)


def test_a_line_turns_with_its_points_and_keeps_its_error():
    chance = np.random.default_rng(5)
    points = np.outer(np.linspace(-1, 1, 9), [1.0, 2.0, -0.5]) + chance.normal(0, 0.02, (9, 3))
    plain = fit_line(points)
    for turn in turns(20):
        fit = fit_line(points @ turn.T + [4e5, 5e6, 800.0])
        assert axial_deg(fit.direction, turn @ plain.direction) < 1e-6
        assert fit.direction[2] <= 0.0
        assert fit.confidence95_deg == pytest.approx(plain.confidence95_deg, rel=1e-6)
        assert fit.rms == pytest.approx(plain.rms, rel=1e-6)


def test_order_and_direction_of_picking_do_not_matter():
    chance = np.random.default_rng(6)
    points = np.outer(np.linspace(0, 3, 7), [0.3, -1.0, 0.2]) + chance.normal(0, 0.05, (7, 3))
    a, b = fit_line(points), fit_line(points[::-1])
    assert a.direction == pytest.approx(b.direction)
    assert a.confidence95_deg == pytest.approx(b.confidence95_deg)


def missed(n: int, sigma: float, runs: int, seed: int) -> float:
    """Share of runs in which the cone holds the true direction."""
    chance = np.random.default_rng(seed)
    truth = np.array([0.6, 0.48, -0.64])
    held = 0
    for _ in range(runs):
        distance_along_line = np.sort(chance.uniform(-1.0, 1.0, n))
        fit = fit_line(np.outer(distance_along_line, truth) + chance.normal(0.0, sigma, (n, 3)))
        held += axial_deg(fit.direction, truth) <= fit.confidence95_deg
    return held / runs


@pytest.mark.parametrize("n", first_in_default_tier([3, 4, 5, 8, 12, 20]))
def test_cone_contains_true_direction_in_95_percent_of_runs(n):
    """At 4000 runs 1.1 % is three standard deviations."""
    share = missed(n, 0.01, 4000, 40 + n)
    assert 0.937 <= share <= 0.963


def test_the_length_of_a_path_is_the_sum_of_its_steps():
    assert path_length([[0, 0, 0], [3, 4, 0], [3, 4, 12]]) == pytest.approx(17.0)
    assert path_length([[1, 1, 1]]) == 0.0


def test_ring_area_is_invariant_to_rotation_and_vertex_order():
    ring = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [2, 1, 0], [0, 3, 0]], float)
    for turn in turns(10):
        moved = ring @ turn.T + [4e5, 5e6, 800.0]
        assert ring_area(moved) == pytest.approx(8.0, rel=1e-8)
        assert ring_area(moved[::-1]) == pytest.approx(8.0, rel=1e-8)
        assert ring_area(np.roll(moved, 2, axis=0)) == pytest.approx(8.0, rel=1e-8)


def test_area_of_sloping_ring_is_measured_on_the_slope():
    ring = np.array([[0, 0, 0], [2, 0, 2], [2, 5, 2], [0, 5, 0]], float)
    assert ring_area(ring) == pytest.approx(5 * np.hypot(2, 2))


@pytest.mark.parametrize(
    ("points", "code"),
    [
        (np.zeros((0, 3)), "feature.too-few-points"),
        ([[1.0, 2.0, 3.0]], "feature.too-few-points"),
        ([[4e5, 5e6, 8e2]] * 4, "points.coincident"),
        ([[0, 0, 0], [np.inf, 0, 0]], "points.not-finite"),
        ([[0, 0, 0], [1.1e150, 0, 0]], "points.not-finite"),
    ],
)
def test_degenerate_points_are_rejected_with_reason(points, code):
    values = {"count": 2 - len(points), "minimum": 2} if code == "feature.too-few-points" else {}
    with refused(code, GeometryError, **values):
        fit_line(points)


@pytest.mark.parametrize("shift", [0.0, 1.0, 5e6])
def test_points_farther_apart_than_rounding_form_a_line(shift):
    """Four roundings of the largest coordinate are the limit."""
    apart = 64.0 * np.finfo(float).eps * max(shift, 1e-6)
    points = np.array([[0.0, 0, 0], [apart, 0, 0]]) + shift
    assert abs(fit_line(points).direction[0]) == pytest.approx(1.0)


def test_line_fit_matches_fisher_statistics_and_projections():
    from scipy.stats import f

    chance = np.random.default_rng(8)
    for n in (3, 4, 9, 30):
        points = np.outer(chance.uniform(-4, 4, n), [0.6, 0.48, -0.64]) + 3.0
        points += chance.normal(0.0, 0.3, (n, 3))
        fit = fit_line(points)
        assert fit.n == n
        local = points - points.mean(axis=0)
        values, vectors = np.linalg.eigh(local.T @ local)
        assert axial_deg(fit.direction, vectors[:, 2]) < 1e-6
        assert fit.centroid == pytest.approx(points.mean(axis=0))
        assert fit.length == pytest.approx(np.ptp(points @ vectors[:, 2]))
        assert fit.rms == pytest.approx(np.sqrt((values[0] + values[1]) / n))
        free = 2 * n - 4
        square = 2.0 * f.ppf(0.95, 2, free) * (values[0] + values[1]) / free / values[2]
        assert fit.confidence95_deg == pytest.approx(np.degrees(np.arctan(np.sqrt(square))))


@pytest.mark.parametrize(("steps", "is_line"), [(7, False), (9, True)])
def test_points_are_distinct_from_eight_roundings_of_largest_coordinate(steps, is_line):
    far = 2.0**20
    points = np.array([[far, 0, 0], [far + steps * np.spacing(far), 0, 0]])
    if is_line:
        assert fit_line(points).length == steps * np.spacing(far)
    else:
        with refused("points.coincident", GeometryError):
            fit_line(points)


def test_coordinates_below_1e150_form_a_line():
    assert fit_line([[0, 0, 0], [0, 0.9e150, 0]]).length == pytest.approx(0.9e150)


@pytest.mark.full
def test_nearest_approach_matches_search_along_both_lines() -> None:
    """Against scipy's bounded search over every two segments; lines that cross or touch have no
    distance."""
    from scipy.optimize import minimize

    generator = np.random.default_rng(4)
    base = np.array([372_410.0, 4_709_820.0, 613.0])
    for _ in range(20):
        line, other = generator.normal(0, 3, (2, 4, 3)) + base
        found = nearest_approach(line, other)
        least = np.inf
        for i in range(3):
            for j in range(3):
                ends = (line[i], line[i + 1], other[j], other[j + 1])

                def gap(st, ends=ends):
                    a, b, c, d = ends
                    return float(np.sum((a + st[0] * (b - a) - c - st[1] * (d - c)) ** 2))

                made = minimize(gap, [0.5, 0.5], bounds=[(0, 1), (0, 1)], tol=1e-14)
                least = min(least, np.sqrt(made.fun))
        assert found.distance == pytest.approx(least, abs=1e-4)
        assert 0 <= found.distance_along_line <= path_length(line) + 1e-9
    crossing = nearest_approach([[0, 0, 0], [4, 0, 0]], [[3, -1, 0], [3, 1, 0]])
    assert (crossing.distance, crossing.distance_along_line) == pytest.approx((0.0, 3.0))
    assert crossing.midpoint == pytest.approx([3, 0, 0])
    alike = nearest_approach([[0, 0, 0], [4, 0, 0]], [[1, 0, 2], [9, 0, 2]])
    assert alike.distance == pytest.approx(2.0)
    point = nearest_approach([[0, 0, 0], [0, 0, 0], [4, 0, 0]], [[2, 1, 0], [2, 1, 0]])
    assert (point.distance, point.distance_along_line) == pytest.approx((1.0, 2.0))


def test_path_lengths_match_single_path_lengths() -> None:
    """Also of lines of one point and of none, wherever they stand among the others."""
    chance = np.random.default_rng(8)
    counts = [0, 5, 1, 0, 2, 30, 1, 0]
    lines = [chance.normal(size=(n, 3)) * 10 + [3e5, 4e6, 100] for n in counts]
    found = path_lengths(lines)
    assert found == pytest.approx([path_length(line) for line in lines], abs=1e-7)
    assert found[4] == pytest.approx(np.linalg.norm(lines[4][1] - lines[4][0]), abs=1e-7)
    assert list(path_lengths([])) == []
    assert list(path_lengths([np.zeros((0, 3))])) == [0.0]
