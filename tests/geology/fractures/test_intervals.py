"""95 % intervals of densities and spacings beside closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from scipy.stats import chi2

from vomstudio.geology.fractures.intervals import (
    STUDENT_FACTOR,
    are_regular,
    area_dispersion,
    density_interval,
    empty_interval,
    line_dispersion,
)
from vomstudio.geology.fractures.network import SamplingRegion, fracture_network
from vomstudio.geology.fractures.scanlines import find_crossings, measure_spacing

SQUARE = shapely.box(0, 0, 10, 10)


def across(places: np.ndarray) -> np.ndarray:
    """Traces across a line along x."""
    low = np.stack([places, np.full(len(places), -1.0)], axis=-1)
    return np.asarray(shapely.linestrings(np.stack([low, low + [0.0, 2.0]], axis=1)))


def line(length: float, y: float = 0.0) -> shapely.LineString:
    return shapely.LineString([(0.0, y), (length, y)])


@pytest.mark.parametrize("n", [1, 4, 13, 100])
def test_equal_weights_have_the_exact_interval_of_poisson(n: int) -> None:
    """Garwood (1936): half of chi square with 2n and 2n + 2 degrees of freedom."""
    low, high = density_interval(np.ones(n), 2.0)
    assert low == pytest.approx(chi2.ppf(0.025, 2 * n) / 4.0)
    assert high == pytest.approx(chi2.ppf(0.975, 2 * n + 2) / 4.0)


def test_no_traces_give_an_upper_limit() -> None:
    assert empty_interval(1.0) == pytest.approx((0.0, chi2.ppf(0.975, 2) / 2.0))
    assert density_interval(np.zeros(3), 1.0) == (0.0, None)


def test_heavier_traces_count_as_fewer() -> None:
    """Four traces of weight 3 are three times four of weight 1."""
    one = np.array(density_interval(np.ones(4), 1.0))
    assert density_interval(np.full(4, 3.0), 1.0) == pytest.approx(tuple(3.0 * one))
    dispersion = 1.0 + 2.0 / STUDENT_FACTOR
    assert density_interval(np.ones(12), 1.0, dispersion) == pytest.approx(tuple(3.0 * one))


def test_many_independent_traces_tend_to_the_normal_interval() -> None:
    lengths = np.random.default_rng(1).exponential(2.0, 40_000)
    low, high = density_interval(lengths, 1.0)
    assert low is not None
    assert high is not None
    half = 1.959964 * math.sqrt(float(np.sum(lengths**2)))
    assert (high - low) / 2.0 == pytest.approx(half, rel=0.02)


def test_clustered_traces_have_larger_dispersion() -> None:
    rng = np.random.default_rng(2)
    places = rng.uniform(0.0, 10.0, (4000, 2))
    ratios = [
        area_dispersion(np.repeat(places[i : i + 100], 8, axis=0), np.ones(800), SQUARE)
        for i in range(0, 4000, 100)
    ]
    # Of clusters of k at one place the variance is k times that of as many single ones.
    assert 7.0 < np.mean(ratios) < 12.0
    along = np.repeat(places[:400, 0], 8)
    assert np.mean([line_dispersion(along[i : i + 400], 10.0) for i in range(0, 3200, 400)]) > 7.0


def test_regular_gaps_are_detected_and_random_ones_rarely() -> None:
    rng = np.random.default_rng(3)
    assert are_regular(rng.gamma(10.0, 0.1, 12))
    assert not are_regular(np.full(3, 1.0))
    flagged = np.mean([are_regular(rng.exponential(1.0, 12)) for _ in range(2000)])
    assert flagged == pytest.approx(0.05, abs=0.015)


def test_interval_of_random_spacing_matches_frequency() -> None:
    places = np.sort(np.random.default_rng(4).uniform(0.0, 20.0, 30))
    crossings = find_crossings(across(places), np.array([line(20.0)]))
    statistics = measure_spacing(crossings, np.ones(30, np.bool_))
    low, high = statistics.P10_95_1_per_m
    assert statistics.mean_95_m == pytest.approx((1.0 / high, 1.0 / low))  # type: ignore[operator]
    assert low <= statistics.P10_1_per_m <= high  # type: ignore[operator]
    assert statistics.true_mean_95_m == pytest.approx(statistics.mean_95_m)


def test_regular_spacing_has_narrow_interval() -> None:
    crossings = find_crossings(across(np.arange(0.5, 20.0)), np.array([line(20.0)]))
    statistics = measure_spacing(crossings, np.ones(20, np.bool_))
    assert statistics.mean_95_m == pytest.approx((1.0, 1.0))
    low, high = statistics.P10_95_1_per_m
    assert 0.9 < low < 1.0 < high < 1.1  # type: ignore[operator]
    assert statistics.dispersion < 0.1


def test_second_scanline_across_same_traces_adds_no_information() -> None:
    places = np.sort(np.random.default_rng(5).uniform(0.0, 20.0, 30))
    one, two = (
        measure_spacing(
            find_crossings(across(places), np.array(lines)), np.ones(30 * len(lines), bool)
        )
        for lines in ([line(20.0)], [line(20.0, -0.1), line(20.0, 0.1)])
    )
    width_of_one, width_of_two = (
        spacing.P10_95_1_per_m[1] - spacing.P10_95_1_per_m[0]  # type: ignore[operator]
        for spacing in (one, two)
    )
    # Sixty independent crossings would be known 1.4 times as well as thirty.
    assert width_of_two > 0.9 * width_of_one


def test_pieces_of_one_trace_count_as_one_event() -> None:
    """A window with a gap sees each of six traces twice: six events of weight two."""
    area = SQUARE.difference(shapely.box(4.0, -1.0, 6.0, 11.0))
    traces = shapely.linestrings([[(1.0, y), (9.0, y)] for y in (1.0, 2.5, 4.0, 6.0, 7.5, 9.0)])
    statistics = fracture_network(np.asarray(traces), SamplingRegion(area)).statistics
    assert statistics.pieces == 12
    six = density_interval(
        np.full(6, 2.0), float(area.area), max(statistics.dispersion or 1.0, 1.0)
    )
    assert statistics.P20_95_1_per_m2 == pytest.approx(six)
