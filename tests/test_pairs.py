"""What is made of the runs of two versions of the program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from tests.benchmarks.pairs import printed_seconds, ratio


def test_every_number_of_seconds_is_found_under_a_name_of_its_own() -> None:
    text = "reading 1,250.5 s, 20 ms each of 7 files\nreading 2.5 s, 1e-3 ms each of 9 files\n3 MB"
    name = "reading # s, # ms each of # files"
    assert printed_seconds(text) == pytest.approx(
        {f"{name} [1]": 1250.5, f"{name} [2]": 0.02, f"{name} [1], 2": 2.5, f"{name} [2], 2": 1e-6}
    )


def test_the_ratio_is_that_of_the_pairs_whatever_the_machine_does_meanwhile() -> None:
    speed = np.array([1.0, 3.0, 0.5, 2.0])
    assert ratio(list(speed), list(1.1 * speed)) == pytest.approx((1.1, 1.1, 1.1))
    new = speed * np.array([1.0, 1.2, 0.9, 1.1])
    logs = np.log(new / speed)
    low, high = stats.ttest_1samp(logs, 0.0).confidence_interval(0.95)
    expected = tuple(np.exp([logs.mean(), low, high]))
    assert ratio(list(speed), list(new)) == pytest.approx(expected)
