"""What is made of the runs of two versions of the program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from tests.benchmarks.pairs import printed_seconds, ratio


def test_each_printed_time_is_parsed_under_a_unique_name() -> None:
    text = "reading 1,250.5 s, 20 ms each of 7 files\nreading 2.5 s, 1e-3 ms each of 9 files\n3 MB"
    name = "reading # s, # ms each of # files"
    assert printed_seconds(text) == pytest.approx(
        {f"{name} [1]": 1250.5, f"{name} [2]": 0.02, f"{name} [1], 2": 2.5, f"{name} [2], 2": 1e-6}
    )


def test_ratio_of_paired_runs_is_independent_of_machine_speed() -> None:
    speed = np.array([1.0, 3.0, 0.5, 2.0])
    assert ratio(list(speed), list(1.1 * speed)) == pytest.approx((1.1, 1.1, 1.1))
    new = speed * np.array([1.0, 1.2, 0.9, 1.1])
    logs = np.log(new / speed)
    low, high = stats.ttest_1samp(logs, 0.0).confidence_interval(0.95)
    expected = tuple(np.exp([logs.mean(), low, high]))
    assert ratio(list(speed), list(new)) == pytest.approx(expected)
