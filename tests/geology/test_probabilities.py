"""Tails of distributions against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from vomstudio.geology.populations.probabilities import chi2_tail, f_tail, t95


@pytest.mark.parametrize("free", [1, 2, 3, 5, 8, 9, 20])
@pytest.mark.parametrize("square", [0.0, 0.3, 4.0, 11.07, 60.0, 700.0])
def test_chi_square_matches_scipy(free: int, square: float) -> None:
    assert chi2_tail(free, square) == pytest.approx(stats.chi2.sf(square, free), rel=1e-10)


@pytest.mark.parametrize("top", [1, 2, 3, 6])
@pytest.mark.parametrize("bottom", [1, 2, 7, 58, 9997])
def test_f_distribution_matches_scipy(top: int, bottom: int) -> None:
    for ratio in (0.0, 0.01, 1.0, 3.9, 30.0, 1e4):
        wanted = stats.f.sf(ratio, top, bottom)
        assert f_tail(top, bottom, ratio) == pytest.approx(wanted, rel=1e-8, abs=1e-14)


def test_student_t_matches_scipy() -> None:
    for free in (1, 2, 3, 10, 57, 1000, 10**6):
        assert t95(free) == pytest.approx(stats.t.ppf(0.975, free), rel=1e-9)
    # Fisher & Yates, table III.
    assert np.round([t95(1), t95(10), t95(120)], 3).tolist() == [12.706, 2.228, 1.980]
