"""The error that residuals state is the one that simulated registrations have."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.tiers import first_in_default_tier
from vomstudio.registration.scatter import estimate_scatter, scale_findings
from vomstudio.registration.similarity import fit_similarity

REPEATS = 400
SIGMA = 0.3


def inside(n: int, heights: float, stated: bool, shape: tuple[float, ...]) -> np.ndarray:
    """(4,) shares of simulations whose turn about east, north, up and whose scale lie within the
    stated 95 %. heights : how many times as large their errors are"""
    rng = np.random.default_rng(n)
    sigma = SIGMA * np.array([1.0, 1.0, heights])
    hits = np.zeros(4)
    for _ in range(REPEATS):
        places = rng.uniform(-1, 1, (n, 3)) * shape
        target = places + rng.normal(0, 1, (n, 3)) * sigma
        fit = fit_similarity(places, target)
        found = estimate_scatter(target, fit(places) - target, sigma if stated else None)
        off = [*Rotation.from_matrix(fit.rotation).as_rotvec(), fit.scale - 1.0]
        hits += np.abs(off) <= 1.96 * np.sqrt(np.diag(found.covariance)[:4])
    return hits / REPEATS


@pytest.mark.parametrize(
    "shape", first_in_default_tier(map(pytest.param, [(60.0, 20.0, 25.0), (60.0, 3.0, 4.0)]))
)
@pytest.mark.parametrize("heights", first_in_default_tier([0.2, 1.0, 2.0, 4.0]))
@pytest.mark.parametrize("n", first_in_default_tier([5, 6, 12, 40]))
def test_errors_from_residuals_cover_better_and_worse_heights(
    n: int, heights: float, shape: tuple[float, ...]
) -> None:
    found = inside(n, heights, False, shape)
    # 400 repeats know 95 % to 2 % (two sigma).
    assert (found >= 0.90 - 0.02).all(), found
    assert (found <= 0.99 + 0.01).all(), found


@pytest.mark.parametrize("heights", first_in_default_tier([0.5, 1.0, 2.0]))
@pytest.mark.parametrize("n", first_in_default_tier([3, 4, 6, 12, 40]))
def test_errors_from_stated_accuracies_cover_the_true_errors(n: int, heights: float) -> None:
    found = inside(n, heights, True, (60.0, 20.0, 25.0))
    assert (found >= 0.93 - 0.02).all(), found
    assert (found <= 0.97 + 0.025).all(), found


def test_estimated_scatter_of_many_points_matches_the_simulated_errors() -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform(-50, 50, (4000, 3))
    sigma = np.array([0.1, 0.2, 0.9])
    target = places + rng.normal(0, 1, places.shape) * sigma
    fit = fit_similarity(places, target)
    found = estimate_scatter(target, fit(places) - target)
    assert found.sigma == pytest.approx(sigma, rel=0.05)


def test_covariance_rotates_with_the_world() -> None:
    """A world turned by 90 degrees about up exchanges east and north."""
    rng = np.random.default_rng(6)
    places = rng.uniform(-1, 1, (20, 3)) * [40, 5, 8]
    misses = rng.normal(0, 1, (20, 3)) * [0.1, 0.3, 0.5]
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    first = estimate_scatter(places, misses)
    turned = estimate_scatter(places @ quarter.T, misses @ quarter.T)
    assert turned.rotation == pytest.approx(quarter @ first.rotation @ quarter.T, rel=1e-6)
    assert turned.covariance[3, 3] == pytest.approx(first.covariance[3, 3], rel=1e-9)
    assert turned.sigma == pytest.approx(first.sigma[[1, 0, 2]], rel=1e-9)


def test_stated_accuracy_contradicted_by_residuals_is_not_used() -> None:
    rng = np.random.default_rng(7)
    places = rng.uniform(-20, 20, (10, 3))
    misses = rng.normal(0, 1.2, (10, 3))
    fit = fit_similarity(places, places + misses)
    found = estimate_scatter(places + misses, fit(places) - places - misses, 0.0036)
    assert found.sigma.min() > 0.6
    assert found.sigma.max() < 2.5


def test_weak_scale_is_reported_with_its_error() -> None:
    assert scale_findings(0.004) == []
    (finding,) = scale_findings(0.06 / 1.96)
    assert finding.code == "registration.weak-scale"
    assert finding.values["error95_percent"] == pytest.approx(6.0)


def test_receiver_drift_is_detected_if_the_order_is_known() -> None:
    """By independent errors about half of the tilts lie within what is stated."""
    inside, sound = np.zeros(2), 0
    n, runs, rho = 30, 60, 0.9
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        row = np.where(np.arange(n) % 2, 20.0, -20.0)
        places = np.column_stack([np.linspace(-50, 50, n), row, rng.uniform(-5, 5, n)])
        errors = rng.normal(size=(n, 3))
        sound += estimate_scatter(places, left_over(places, errors), is_ordered=True).drift > 0.0
        for i in range(1, n):
            errors[i] = rho * errors[i - 1] + np.sqrt(1.0 - rho**2) * errors[i]
        fit = fit_similarity(places, places + errors)
        off = np.abs(Rotation.from_matrix(fit.rotation).as_rotvec())
        for k, in_order in enumerate((False, True)):
            found = estimate_scatter(places, fit(places) - places - errors, is_ordered=in_order)
            inside[k] += (off <= 1.96 * np.sqrt(np.diag(found.rotation))).mean()
    assert inside[0] / runs < 0.75
    assert inside[1] / runs > 0.84
    assert sound <= 4


def left_over(places: np.ndarray, errors: np.ndarray) -> np.ndarray:
    return fit_similarity(places, places + errors)(places) - places - errors


@pytest.mark.parametrize("heights", [1.0, 2.0])
def test_stated_errors_of_four_points_cover_the_true_errors(
    heights: float,
) -> None:
    """By one error for all coordinates 85 % of the tilts lie within it."""
    found = inside(4, heights, False, (60.0, 40.0, 6.0))
    assert (found >= 0.90 - 0.02).all(), found
    assert (found <= 0.99 + 0.01).all(), found
