"""A girdle that is split into sets is told; true sets are not called a girdle."""

import numpy as np
import pytest

from tests.messages import with_code
from tests.tiers import first_in_default_tier
from vomstudio.geology.sets.proposals import propose_sets_of_poles


def fold(rng, half_deg, n, noise_deg):
    """Poles of a cylindrical fold, evenly over an arc about the vertical."""
    at = np.radians(rng.uniform(-half_deg, half_deg, n))
    poles = np.c_[np.sin(at), np.zeros(n), np.cos(at)]
    poles += rng.normal(0.0, np.radians(noise_deg), (n, 3))
    return poles / np.linalg.norm(poles, axis=1)[:, None]


def sets_on_a_circle(rng, k, n, spread_deg):
    """k round clusters, evenly about one great circle."""
    at = np.repeat(np.arange(k) * np.pi / k, n)
    poles = np.c_[np.sin(at), np.zeros(k * n), np.cos(at)]
    poles += rng.normal(0.0, np.radians(spread_deg), (k * n, 3))
    return poles / np.linalg.norm(poles, axis=1)[:, None]


def told(poles):
    return bool(with_code(propose_sets_of_poles(poles).warnings, "sets.girdle"))


@pytest.mark.full
@pytest.mark.parametrize("half_deg", [50, 70])
def test_split_girdle_is_reported(half_deg):
    # By its construction the test misses some even spreads, and the cut between two sets seeks the
    # thinnest place, so more than its 5 %; most must be told.
    split = missed = 0
    for seed in range(10, 18):
        poles = fold(np.random.default_rng(seed), half_deg, 150, 3.5)
        if len(propose_sets_of_poles(poles).sets) > 1:
            split += 1
            missed += not told(poles)
    assert split >= 3
    assert missed <= 0.25 * split


@pytest.mark.parametrize("k", first_in_default_tier([2, 3]))
def test_separate_sets_on_one_great_circle_are_not_reported_as_girdle(k):
    false = sum(
        told(sets_on_a_circle(np.random.default_rng(seed), k, 40, 6.0)) for seed in range(6)
    )
    assert false == 0
