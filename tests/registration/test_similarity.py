"""Similarities between frames, and what positions leave undetermined."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.registration import similarity
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    is_nearly_collinear,
    rotation_covariance,
)


def some(n: int = 12, seed: int = 0) -> tuple[np.ndarray, Similarity]:
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=seed).as_matrix()
    return rng.normal(0, 5, (n, 3)), Similarity(3.7, rotation, np.array([100.0, -20, 5]))


@pytest.mark.parametrize("seed", range(5))
def test_known_similarity_is_recovered(seed: int) -> None:
    points, truth = some(seed=seed)
    found = fit_similarity(points, truth(points))
    assert found.scale == pytest.approx(3.7)
    assert found.rotation == pytest.approx(truth.rotation)
    assert found.translation == pytest.approx(truth.translation)
    assert found.inverse(found(points)) == pytest.approx(points)


def test_fit_never_returns_a_reflection() -> None:
    points, _ = some()
    found = fit_similarity(points, points * [1, 1, -1])
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_coplanar_points_are_sufficient() -> None:
    points, truth = some()
    points[:, 2] = 0
    found = fit_similarity(points, truth(points))
    assert found.rotation == pytest.approx(truth.rotation)


def test_collinear_points_and_two_points_are_rejected() -> None:
    line = np.outer(np.arange(6.0), [1, 2, 3])
    with refused("control.collinear", GeometryError):
        fit_similarity(line, line)
    with refused("registration.too-few-points", GeometryError):
        fit_similarity(np.eye(3)[:2], np.eye(3)[:2])


def test_zero_weights_exclude_points() -> None:
    points, truth = some()
    target = truth(points)
    target[3] += 50
    weights = np.ones(len(points))
    weights[3] = 0
    assert fit_similarity(points, target, weights).scale == pytest.approx(3.7)


def test_robust_fit_tolerates_one_third_of_wrong_points() -> None:
    points, truth = some(15)
    rng = np.random.default_rng(1)
    target = truth(points) + rng.normal(0, 0.05, (15, 3))
    target[:5] += rng.normal(0, 30, (5, 3))
    found, used = fit_robustly(points, target)
    assert used.tolist() == [False] * 5 + [True] * 10
    assert found.scale == pytest.approx(3.7, rel=0.01)


@pytest.mark.parametrize("n", first_in_default_tier([8, 12, 30]))
def test_robust_fit_rarely_excludes_good_points(n: int) -> None:
    left = 0
    for seed in range(12):
        points, truth = some(n, seed)
        noise = np.random.default_rng(seed).normal(0, 0.3, (n, 3))
        left += int((~fit_robustly(points, truth(points) + noise)[1]).sum())
    assert left / (12 * n) < 0.03


def test_stated_rotation_error_matches_simulated_noise() -> None:
    points, truth = some(10)
    target = truth(points)
    found = []
    for seed in range(400):
        noise = np.random.default_rng(seed).normal(0, 1.5, (10, 3))
        turned = fit_similarity(points, target + noise).rotation @ truth.rotation.T
        found.append(Rotation.from_matrix(turned).as_rotvec())
    stated = rotation_covariance(target, 1.5)
    assert np.cov(np.array(found).T) == pytest.approx(stated, abs=0.25 * stated.trace() / 3)


def test_rotation_error_of_points_on_the_axes_matches_the_closed_form() -> None:
    """Pairs at a, b, c from the middle on the axes, errors of p, q, r along them: a turn about up
    moves the first pair along the second axis and the second along the first."""
    (a, b, c), (p, q, r) = (3.0, 2.0, 5.0), (0.1, 0.3, 0.2)
    pairs = np.diag([a, b, c])
    places = np.vstack([pairs, -pairs]) + [400.0, -70.0, 9.0]
    known = [2 * (b**2 / r**2 + c**2 / q**2), 2 * (a**2 / r**2 + c**2 / p**2)]
    known.append(2 * (a**2 / q**2 + b**2 / p**2))
    found = rotation_covariance(places, np.array([p, q, r]))
    assert found == pytest.approx(np.diag(1 / np.array(known)), rel=1e-9, abs=1e-15)
    # Turns are counted in the frame of the points.
    turn = Rotation.from_euler("xyz", [20, 50, -70], degrees=True).as_matrix()
    even = rotation_covariance(places, 0.1)
    assert rotation_covariance(places @ turn.T, 0.1) == pytest.approx(turn @ even @ turn.T)


def test_rotation_about_a_line_of_points_is_undetermined() -> None:
    line = np.outer(np.arange(6.0), [1, 0, 0])
    covariance = rotation_covariance(line, 0.1)
    assert covariance[0, 0] > 1e5
    assert covariance[2, 2] < 1e-2


@pytest.mark.parametrize("weighted", [False, True])
def test_weighted_residuals_are_orthogonal_to_all_seven_parameters(weighted: bool) -> None:
    """At the least squares the weighted residuals lean on none of the seven ways to move."""
    rng = np.random.default_rng(4)
    points, truth = some(9)
    target = truth(points) + rng.normal(0, 2.0, (9, 3))
    weights = rng.uniform(0.2, 3.0, 9) if weighted else np.ones(9)
    found = fit_similarity(points, target, weights if weighted else None)
    placed = found(points)
    misses = (target - placed) * weights[:, None]
    out = placed - np.average(placed, axis=0, weights=weights)
    assert misses.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    assert np.cross(out, misses).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-8)
    assert (out * misses).sum() == pytest.approx(0.0, abs=1e-8)


def test_collinear_points_in_either_frame_are_rejected_and_slender_ones_not() -> None:
    rng = np.random.default_rng(0)
    along = np.outer(np.linspace(-5, 5, 8), [1.0, 2.0, 3.0])
    for width, on_a_line in ((1e-8, True), (1e-5, False)):
        slender = along + width * rng.normal(size=(8, 3))
        for source, target in ((slender, along + rng.normal(size=(8, 3))), (slender, slender)):
            for a, b in ((source, target), (target, source)):
                for shift in ([0.0, 0, 0], [40.0, -50, 6]):
                    if on_a_line:
                        with refused("control.collinear", GeometryError):
                            fit_similarity(a, b + shift)
                        with refused("control.collinear", GeometryError):
                            fit_similarity(a + shift, b)
                    else:
                        turn = fit_similarity(a, b + shift).rotation
                        assert np.linalg.det(turn) == pytest.approx(1)


@pytest.mark.parametrize(("width", "near"), [(0.015, True), (0.025, False)])
def test_points_are_nearly_collinear_below_one_fiftieth_of_their_length(
    width: float, near: bool
) -> None:
    turn = Rotation.from_euler("xyz", [20, 50, -70], degrees=True).as_matrix()
    pairs = np.diag([1.0, width, width / 2])
    points = np.vstack([pairs, -pairs]) @ turn.T + [40.0, -500, 6]
    assert is_nearly_collinear(points) is near


@pytest.mark.parametrize("count", [0, 1, 2])
def test_fewer_than_three_points_determine_no_rotation(count: int) -> None:
    assert is_nearly_collinear(np.eye(3)[:count])


def test_wrong_point_is_excluded_from_six_points_but_not_from_five() -> None:
    points, truth = some(6)
    target = truth(points)
    target[2] += [9.0, 0, 0]
    found, used = fit_robustly(points[:5], target[:5])
    assert used.all()
    assert found(points[:5]) == pytest.approx(fit_similarity(points[:5], target[:5])(points[:5]))
    found, used = fit_robustly(points, target)
    assert used.tolist() == [True, True, False, True, True, True]
    assert found(points) == pytest.approx(truth(points))


@pytest.mark.parametrize(("off", "kept"), first_in_default_tier([(1.7, True), (11.0, False)]))
def test_point_is_excluded_beyond_about_six_standard_errors(off: float, kept: bool) -> None:
    """Three coordinates at 0.01 %: the square root of 3 F(0.9999; 3, 26) is 5.6."""
    found = []
    for seed in range(12):
        points, truth = some(12, seed)
        rng = np.random.default_rng(seed)
        target = truth(points) + rng.normal(0, 0.3, (12, 3))
        way = rng.normal(size=3)
        target[5] = truth(points[5]) + off * 0.3 * way / np.linalg.norm(way)
        found.append(fit_robustly(points, target)[1][5])
    assert np.mean(found) == pytest.approx(float(kept), abs=0.1)


def test_points_within_min_sigma_are_used() -> None:
    points, truth = some(12)
    target = truth(points)
    target[7] += [0.0, 0.49, 0.0]
    assert not fit_robustly(points, target)[1][7]
    assert not fit_robustly(points, target, min_sigma=0.45)[1][7]
    found, used = fit_robustly(points, target, min_sigma=0.55)
    assert used.all()
    assert found(points) == pytest.approx(fit_similarity(points, target)(points))


def test_robust_fit_tolerates_nearly_half_wrong_points() -> None:
    points, truth = some(13)
    target = truth(points)
    target[:5] += np.random.default_rng(2).normal(0, 60, (5, 3))
    target[5] = target[6]  # one point taken for another
    found, used = fit_robustly(points, target)
    assert used.tolist() == [False] * 6 + [True] * 7
    assert found(points) == pytest.approx(truth(points), abs=1e-6)


def predicted(points: np.ndarray, target: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Covariance (3, 3), for errors of variance 1, of the miss of a new point at the place `at`
    from a similarity fitted to others: by small changes of its seven figures."""
    fit = fit_similarity(points, target)

    def design(places: np.ndarray) -> np.ndarray:
        columns = []
        for k in range(7):
            step = np.zeros(7)
            step[k] = 1e-6
            turn = Rotation.from_rotvec(step[:3]).as_matrix()
            moved = (1 + step[3]) * (fit(places) @ turn.T) + step[4:]
            columns.append((moved - fit(places)).ravel() / 1e-6)
        return np.array(columns).T

    spread = np.linalg.inv(design(points).T @ design(points))
    new = design(at[None])
    return np.eye(3) + new @ spread @ new.T


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("way", [(0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (0.48, -0.64, -0.6)])
@pytest.mark.parametrize("n", [7, 10])
def test_last_point_is_used_up_to_the_f_test_limit(
    n: int, way: tuple[float, float, float], size: float
) -> None:
    """The others are the share of the points that misses least: their scatter, that of a normal
    law cut off there, is less than the whole one by what the chi-square laws say."""
    from scipy.stats import chi2, f

    points, truth = some(n, 3)
    # A hand specimen, an outcrop, a valley: what is wrong does not depend on the unit.
    target = size * (truth(points) + np.random.default_rng(5).normal(0, 0.05, (n, 3)))
    others = np.arange(n) != 2
    fit = fit_similarity(points[others], target[others])
    freedom = 3 * (n - 1) - 7
    variance = ((fit(points[others]) - target[others]) ** 2).sum() / freedom
    share = (n - 1) / n
    variance /= chi2.cdf(chi2.ppf(share, 3), 5) / share
    toward = np.array(way)
    spread = predicted(points[others], target[others], points[2])
    weight = toward @ np.linalg.inv(spread) @ toward
    limit = np.sqrt(3 * variance * f.ppf(0.9999, 3, freedom) / weight)
    for part, joins in ((0.98, True), (1.02, False)):
        target[2] = fit(points[2])[0] + part * limit * toward
        assert fit_robustly(points, target)[1][2] == joins


def test_all_points_are_used_if_the_inliers_are_collinear() -> None:
    """A road with control points along it and three bad ones beside it: the road alone would let
    the model turn about it."""
    road = np.column_stack([np.linspace(-20, 20, 5), np.zeros(5), np.zeros(5)])
    around = np.radians([0.0, 120.0, 240.0])
    beside = np.column_stack([[-6.0, 1.0, 8.0], 5 * np.cos(around), 5 * np.sin(around)])
    points = np.vstack([road, beside])
    target = points.copy()
    target[5:, 1:] *= np.array([[1.1], [1.25], [0.8]])
    found, used = fit_robustly(points, target)
    assert used.all()
    assert found(points) == pytest.approx(fit_similarity(points, target)(points))


def test_adding_inliers_in_groups_gives_the_same_result_as_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With wrong ones of every size among them, in steps that hardly grow with their number."""
    rng = np.random.default_rng(11)
    step, taken = similarity._next_inliers, [0]

    def counted(*given):  # type: ignore[no-untyped-def]
        taken[0] += 1
        return step(*given)

    monkeypatch.setattr(similarity, "_next_inliers", counted)
    for n in (60, 300):
        points, truth = some(n, 4)
        target = truth(points) + rng.normal(0, 0.05, (n, 3))
        target[: n // 5] += rng.normal(0, 1, (n // 5, 3)) * rng.choice([0.2, 2.0], (n // 5, 1))
        taken[0] = 0
        together = fit_robustly(points, target)[1]
        few, taken[0] = taken[0], 0
        with monkeypatch.context() as singly:
            singly.setattr(similarity, "_STEP_DIVISOR", 10**9)
            np.testing.assert_array_equal(together, fit_robustly(points, target)[1])
    assert few < taken[0] / 3
