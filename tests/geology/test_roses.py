"""Azimuths in bins, against closed forms, laws and scipy's circular mean."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, optimize, special
from scipy.stats import circmean, circvar

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import UsageError
from vomstudio.geology.roses import (
    count_bins,
    count_histogram,
    count_rose,
    rayleigh_p,
    select_angles,
)

azimuths = st.lists(st.floats(-720, 720), min_size=1, max_size=40)


@settings(deadline=None)
@given(azimuths, st.booleans(), st.sampled_from([1.0, 5.0, 7.5, 10.0, 22.5, 45.0, 90.0]))
def test_every_azimuth_is_in_one_bin_and_axes_in_both_halves(
    found: list[float], axial: bool, width: float
) -> None:
    rose = count_rose(found, is_axial=axial, bin_deg=width)
    assert len(rose.shares) == round(360.0 / width)
    half = len(rose.shares) // 2
    if axial:
        np.testing.assert_array_equal(rose.shares[:half], rose.shares[half:])
        assert rose.shares[:half].sum() == pytest.approx(1)
        again = count_rose(np.array(found) + 180.0, is_axial=True, bin_deg=width)
        np.testing.assert_allclose(again.shares, rose.shares)
    else:
        assert rose.shares.sum() == pytest.approx(1)


def test_bin_includes_its_lower_edge_despite_rounding() -> None:
    for edge in np.arange(0.0, 360.0, 10.0):
        for azimuth in (edge, edge - 360.0, edge + 1e-12, (edge + 0.1) - 0.1, edge + 9.999):
            rose = count_rose([azimuth], is_axial=False)
            assert rose.shares[int(edge / 10.0)] == 1.0, azimuth
    assert count_rose([-1e-18], is_axial=True).shares[[0, 18]].tolist() == [1.0, 1.0]


@settings(deadline=None)
@given(st.lists(st.floats(0, 359), min_size=2, max_size=30), st.booleans())
def test_mean_and_resultant_match_scipy(found: list[float], axial: bool) -> None:
    period = 180.0 if axial else 360.0
    rose = count_rose(found, is_axial=axial)
    variance = circvar(np.array(found) % period, high=period)
    assert rose.resultant == pytest.approx(1.0 - variance, abs=1e-9)
    if rose.resultant > 1e-6:
        assert rose.mean_deg is not None
        away = (rose.mean_deg - circmean(np.array(found) % period, high=period)) % period
        assert min(away, period - away) < 1e-6


def test_a_weight_counts_as_that_many_rows() -> None:
    rng = np.random.default_rng(1)
    found, times = rng.uniform(0, 360, 30), rng.integers(0, 5, 30)
    for axial in (False, True):
        weighted = count_rose(found, is_axial=axial, weights=times)
        repeated = count_rose(np.repeat(found, times), is_axial=axial)
        np.testing.assert_allclose(weighted.shares, repeated.shares)
        assert weighted.mean_deg == pytest.approx(repeated.mean_deg)
        assert weighted.resultant == pytest.approx(repeated.resultant)
        assert weighted.total == times.sum()


def test_opposite_directions_have_no_mean_but_opposite_axes_do() -> None:
    assert count_rose([40.0, 220.0], is_axial=False).mean_deg is None
    axes = count_rose([40.0, 220.0], is_axial=True)
    assert axes.mean_deg == pytest.approx(40.0)
    assert axes.resultant == pytest.approx(1.0)
    # North lies between 350 and 10, and between the axes 170 and 10.
    for axial, pair, whole in ((False, [350.0, 10.0], 360.0), (True, [170.0, 10.0], 180.0)):
        mean = count_rose(pair, is_axial=axial).mean_deg
        assert mean is not None
        assert min(mean, whole - mean) == pytest.approx(0.0, abs=1e-9)


def test_uniform_azimuths_have_equal_petals_and_no_resultant() -> None:
    rose = count_rose(np.arange(0.5, 360.0), is_axial=False)
    np.testing.assert_allclose(rose.shares, 1 / 36)
    assert rose.resultant < 1e-12


def test_rows_without_azimuth_or_weight_are_counted() -> None:
    rose = count_rose([10.0, math.nan, 20.0], is_axial=True, weights=[1.0, 1.0, math.nan])
    assert (rose.n, rose.left_out) == (1, 2)
    empty = count_rose([], is_axial=True)
    assert (empty.n, empty.mean_deg, empty.total) == (0, None, 0.0)


@pytest.mark.parametrize("width", [0.0, -10.0, 7.0, 0.5, 180.0, math.nan, math.inf])
def test_uneven_bins_and_negative_weights_are_rejected(width: float) -> None:
    with refused("rose.uneven-bins", UsageError, field="--bin", range_deg=180.0):
        count_bins(width)
    with refused("rose.negative-weight", UsageError, field="--weight"):
        count_rose([10.0], is_axial=True, weights=[-1.0])


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 90), st.floats(0.1, 50)), min_size=2, max_size=40),
    st.sampled_from([1.0, 5.0, 10.0, 22.5, 45.0]),
)
def test_dip_counts_match_numpy_histogram(found: list[tuple[float, float]], width: float) -> None:
    dips, weights = np.array(found).T
    got = count_histogram(dips, bin_deg=width, weights=weights)
    edges = np.arange(0.0, 90.0 + width, width)
    # numpy knows nothing of a hair.
    away = np.abs(dips[:, None] - edges).min(axis=1)
    sound = (away > 1e-6) | (dips == 90.0)
    got = count_histogram(dips[sound], bin_deg=width, weights=weights[sound])
    request_photos, _ = np.histogram(dips[sound], edges, weights=weights[sound])
    if sound.any():
        np.testing.assert_allclose(got.shares, request_photos / weights[sound].sum(), atol=1e-12)
        assert got.mean_deg == pytest.approx(np.average(dips[sound], weights=weights[sound]))


def test_the_spread_of_dips_is_the_standard_deviation() -> None:
    dips = np.array([10.0, 20.0, 25.0, 70.0])
    assert count_histogram(dips).std_deg == pytest.approx(dips.std(ddof=1))
    assert count_histogram(dips, weights=[3.0] * 4).std_deg == pytest.approx(dips.std(ddof=1))
    assert count_histogram([45.0]).std_deg is None
    assert count_histogram([np.nan, 90.0]).left_out == 1
    assert count_histogram([90.0]).shares[-1] == 1.0
    for wrong in (7.0, 60.0, 0.0, np.nan):
        with pytest.raises(UsageError):
            count_histogram([1.0], bin_deg=wrong)


def test_rayleigh_p_matches_published_value() -> None:
    """The example in the documentation of astropy's `rayleightest`, and the resultant of the
    roulette wheel of Mardia & Jupp (2000), example 1.1, which is 0.711."""
    for found, axial in (([130.0, 90.0, 0.0, 145.0], False), ([65.0, 225.0, 0.0, 72.5], True)):
        four = count_rose(found, is_axial=axial)
        assert rayleigh_p(4, four.resultant) == pytest.approx(0.2563487733797317, rel=1e-12)
        # Which are too few.
        assert four.rayleigh_p is None
        assert four.has_preferred_direction
        # A row that counts nothing makes them no more.
        none = count_rose([*found, 3.0], is_axial=axial, weights=[1.0, 1.0, 1.0, 1.0, 0.0])
        assert none.rayleigh_p is None
    wheel = count_rose([43, 45, 52, 61, 75, 88, 88, 279, 357], is_axial=False)
    assert wheel.resultant == pytest.approx(0.711, abs=5e-4)
    assert wheel.has_preferred_direction


@pytest.mark.full
@pytest.mark.parametrize("count", [4, 6, 10, 30, 49, 50, 300])
def test_rayleigh_p_is_uniform_for_random_directions(count: int) -> None:
    """And one of ten has p below 0.1: resultants are drawn here, without the code under test."""
    rng = np.random.default_rng(count)
    turns = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, (20_000, count)))
    p = np.array([rayleigh_p(count, r) for r in np.abs(turns.mean(axis=1))])
    for level in (0.05, 0.1, 0.5):
        assert (p < level).mean() == pytest.approx(level, abs=4.5 * (level / 20_000) ** 0.5 + 0.001)


@pytest.mark.parametrize("count", first_in_default_tier([6, 8, 12, 25, 45]))
@pytest.mark.parametrize("p", first_in_default_tier([0.2, 0.1, 0.05, 0.02]))
def test_rayleigh_p_matches_exact_distribution(count: int, p: float) -> None:
    """Kluyver (1906): of n random steps of one, the chance to come no farther than r is the
    integral of r J1(r t) J0(t)^n over t."""
    t = np.linspace(0.0, 250.0, 500_001)
    steps = special.j0(t) ** count

    def beyond(resultant: float) -> float:
        r = count * resultant
        return float(1.0 - r * integrate.simpson(special.j1(r * t) * steps, x=t))

    exact = optimize.brentq(lambda resultant: beyond(resultant) - p, 0.05, 0.99, xtol=1e-9)
    assert rayleigh_p(count, exact) == pytest.approx(p, rel=0.025)


def test_single_axis_and_fan_have_no_preferred_direction_but_bundle_does() -> None:
    assert rayleigh_p(1.0, 1.0) == 1.0
    for count in (5, 20, 49, 50, 5000):
        bundle = count_rose(np.linspace(40.0, 50.0, count), is_axial=True)
        assert bundle.has_preferred_direction
        assert bundle.rayleigh_p is not None
        assert 0.0 <= bundle.rayleigh_p < 0.01
    fan = count_rose(np.arange(0.0, 180.0, 10.0), is_axial=True)
    assert not fan.has_preferred_direction
    assert count_rose([], is_axial=True).rayleigh_p is None


def test_rayleigh_p_ignores_rotation_and_weight_scale() -> None:
    rng = np.random.default_rng(3)
    found, weights = rng.normal(30.0, 35.0, 20), rng.uniform(1.0, 9.0, 20)
    first = count_rose(found, is_axial=True, weights=weights).rayleigh_p
    assert first == pytest.approx(
        count_rose(found + 77.0, is_axial=True, weights=10.0 * weights).rayleigh_p, rel=1e-9
    )
    even = count_rose(found, is_axial=True, weights=np.full(20, 7.0)).rayleigh_p
    assert even == pytest.approx(count_rose(found, is_axial=True).rayleigh_p, rel=1e-9)
    # One row that outweighs all others is like one row.
    heavy = count_rose(found, is_axial=True, weights=[1e6, *np.ones(19)])
    assert heavy.resultant > 0.99
    assert not heavy.has_preferred_direction


def test_upward_line_equals_opposite_downward_line() -> None:
    trends, plunges = np.array([30.0, 350.0, 210.0, 10.0]), np.array([-40.0, -5.0, 40.0, 0.0])
    assert select_angles(trends, plunges, "trend").tolist() == [210.0, 170.0, 210.0, 10.0]
    assert select_angles(trends, plunges, "plunge").tolist() == [40.0, 5.0, 40.0, 0.0]
