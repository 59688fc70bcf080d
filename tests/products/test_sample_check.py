"""The law of the stated 95 %: about 1 in 20 misses, over picks drawn from many seeds."""

from __future__ import annotations

from collections import defaultdict

import pytest
from scipy.stats import binom

from tests.sample_maker import drawn, maker
from vomstudio.products.sample.check import check_sample


def law(cliff_seeds: list[int], draws: int) -> dict[str, list[bool]]:
    """Whether each check's region held the truth, by what was checked."""
    held: dict[str, list[bool]] = defaultdict(list)
    for cliff_seed in cliff_seeds:
        cliff = maker("relief").Cliff(cliff_seed)
        courses = maker("picks").courses(cliff)
        for number in range(draws):
            picks, truth = drawn(cliff, courses, 1000 * cliff_seed + number)
            for check in check_sample(picks, truth).checks:
                assert check.within is not None
                held[check.name.split()[0]].append(check.within)
    return held


def bounds(n: int, low: float, high: float) -> tuple[int, int]:
    """Counts of hits that a coverage between low and high explains, at 1 in 1000 each side."""
    return int(binom.ppf(0.001, n, low)), int(binom.ppf(0.999, n, high))


def test_stated_regions_of_planes_hold_the_truth_as_often_as_they_say() -> None:
    held = law([7], 10)
    planes = held["bedding"] + held["fault"] + held["joint"]
    low, high = bounds(len(planes), 0.92, 0.975)
    assert low <= sum(planes) <= high


@pytest.mark.slow
def test_about_one_in_twenty_of_all_stated_regions_misses_the_truth() -> None:
    held = law([7, 11, 23], 80)
    for name in ("bedding", "fault", "joint", "fold", "displacement"):
        low, high = bounds(len(held[name]), 0.92, 0.98)
        assert low <= sum(held[name]) <= high, (name, sum(held[name]), len(held[name]))
    # Its scatter is known from the four picks of the fault alone, so it is stated widely.
    meetings = held["intersection"]
    assert sum(meetings) >= bounds(len(meetings), 0.95, 0.95)[0]
    everything = [within for group in held.values() for within in group]
    assert 0.93 <= sum(everything) / len(everything) <= 0.97
