"""Lengths of traces that were cut off: beside scipy, and by simulation with known truth."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
import shapely
from scipy import integrate, stats
from scipy.optimize import brentq

from vomstudio.geology.fractures.length_laws import (
    LengthLaw,
    Window,
    candidate_laws,
    find_law,
    fit_law,
    fit_laws,
)
from vomstudio.geology.fractures.network import describe_lengths, kaplan_meier
from vomstudio.geology.fractures.pieces import clip_traces
from vomstudio.geology.fractures.windows import fit_window, mean_length_from_ends

TRUE = {
    "exponential": (stats.expon(scale=2.0), {"mean_m": 2.0}),
    "lognormal": (stats.lognorm(0.8, scale=2.0), {"median_m": 2.0, "sigma_log": 0.8}),
    "weibull": (stats.weibull_min(1.4, scale=2.0), {"scale_m": 2.0, "shape": 1.4}),
    "power_law": (stats.pareto(2.5, scale=0.5), {"exponent": 2.5}),
}


def law(name: str, lengths: np.ndarray, cut: np.ndarray) -> LengthLaw:
    return next(law for law in candidate_laws(lengths, cut) if law.name == name)


@functools.cache
def scale_of_stops(name: str, share: float) -> float:
    """With which that share of the lengths is cut off."""
    true = TRUE[name][0]
    least = true.support()[0]

    def whole(scale: float) -> float:
        seen = integrate.quad(
            lambda x: true.pdf(x) * math.exp(-(x - least) / scale), least, np.inf, limit=200
        )
        return float(seen[0]) - (1 - share)

    return float(brentq(whole, 0.1, 1e3))


def cut_off(name: str, n: int, share: float, chance: np.random.Generator) -> tuple:
    """Lengths and whether they were cut off, by stops of their own, exponential."""
    true = TRUE[name][0]
    stops = true.support()[0] + chance.exponential(scale_of_stops(name, share), n)
    lengths = true.rvs(n, random_state=chance)
    return np.minimum(lengths, stops), (stops < lengths).astype(np.int64)


@pytest.mark.full
@pytest.mark.parametrize("name", ["exponential", "lognormal", "weibull"])
def test_censored_fits_match_scipy(name: str) -> None:
    lengths, cut = cut_off(name, 400, 0.3, np.random.default_rng(1))
    data = stats.CensoredData.right_censored(lengths, cut > 0)
    found = fit_law(law(name, lengths, cut), lengths, cut)
    assert found is not None
    values = {k: p.value for k, p in found.parameters.items()}
    if name == "exponential":
        assert values["mean_m"] == pytest.approx(stats.expon.fit(data, floc=0)[1], rel=1e-4)
        # And in closed form.
        assert values["mean_m"] == pytest.approx(lengths.sum() / (cut == 0).sum(), rel=1e-6)
    elif name == "lognormal":
        shape, _, scale = stats.lognorm.fit(data, floc=0)
        assert (values["sigma_log"], values["median_m"]) == pytest.approx((shape, scale), rel=1e-3)
    else:
        shape, _, scale = stats.weibull_min.fit(data, floc=0)
        assert (values["shape"], values["scale_m"]) == pytest.approx((shape, scale), rel=1e-3)


def test_power_law_fit_matches_hill_estimator() -> None:
    lengths, cut = cut_off("power_law", 300, 0.1, np.random.default_rng(2))
    found = fit_law(law("power_law", lengths, cut), lengths, cut)
    assert found is not None
    least = lengths[cut == 0].min()
    closed = (cut == 0).sum() / np.log(np.maximum(lengths / least, 1)).sum()
    assert found.parameters["exponent"].value == pytest.approx(closed, rel=1e-6)


@pytest.mark.parametrize("name", sorted(TRUE))
def test_density_survival_and_integral_are_consistent(name: str) -> None:
    true = TRUE[name][0]
    one = law(name, np.array([0.5, 1, 2, 3, 4.0]), np.zeros(5, np.int64))
    u = np.log(list(TRUE[name][1].values()))
    x = np.array([0.6, 1.0, 2.0, 5.0, 9.0])
    np.testing.assert_allclose(np.exp(one.log_density(x, u)), true.pdf(x), rtol=1e-10)
    np.testing.assert_allclose(np.exp(one.log_survival(x, u)), true.sf(x), rtol=1e-10)
    tails = [integrate.quad(true.sf, at, np.inf, epsabs=1e-13)[0] for at in x]
    np.testing.assert_allclose(np.exp(one.log_survival_integral(x, u)), tails, rtol=1e-7)
    assert math.exp(one.log_mean(u)) == pytest.approx(true.mean())


def test_generating_law_is_selected() -> None:
    for name in TRUE:
        lengths, cut = cut_off(name, 500, 0.3, np.random.default_rng(5))
        fits = fit_laws(lengths, cut)
        assert fits[0].distribution == name
        assert fits[0].delta_aic == 0.0
        aics = [fit.aic for fit in fits]
        assert aics == sorted(aics)
        again, u = find_law(fits[0])
        assert again.name == name
        assert np.isfinite(u).all()


def test_too_few_or_equal_lengths_are_not_fitted() -> None:
    assert fit_laws(np.array([1.0, 2, 3, 4]), np.zeros(4, np.int64)) == []
    assert fit_laws(np.full(20, 2.0), np.zeros(20, np.int64)) == []
    assert fit_laws(np.arange(1.0, 9), np.ones(8, np.int64)) == []


def test_kaplan_meier_matches_hand_calculation() -> None:
    """Lengths 1, 2+, 3, 4+, 5: S is 4/5, 8/15, 0."""
    mean, median = kaplan_meier(
        np.array([1.0, 2, 3, 4, 5]), np.array([False, True, False, True, False])
    )
    assert mean == pytest.approx(1 + 2 * 4 / 5 + 2 * 8 / 15)
    assert median == 5.0
    assert kaplan_meier(np.array([1.0, 2.0]), np.array([True, True])) == (None, None)


def test_window_width_is_measured_across_the_traces() -> None:
    window = shapely.box(0, 0, 20, 10)
    east = clip_traces(shapely.linestrings([[[-5, 3], [25, 3]], [[2, 5], [9, 5]]]), window)
    found = fit_window(east, window)
    assert (found.area_m2, found.width_m) == pytest.approx((200, 10))
    # Two towers side by side are met twice by what runs along.
    comb = shapely.union_all([shapely.box(0, 0, 5, 10), shapely.box(8, 0, 13, 10)])
    assert fit_window(east, comb).width_m == pytest.approx(20)


def traces_seen(name: str, chance: np.random.Generator, window: object) -> object:
    """Pieces of a Poisson process of traces in two sets, far beyond the window."""
    true = TRUE[name][0]
    low_x, low_y, high_x, high_y = shapely.bounds(window)
    pad = 40.0
    n = chance.poisson(0.8 * (high_x - low_x + 2 * pad) * (high_y - low_y + 2 * pad))
    middle = chance.uniform([low_x - pad, low_y - pad], [high_x + pad, high_y + pad], (n, 2))
    turn = np.where(chance.random(n) < 0.6, chance.normal(0.3, 0.1, n), chance.normal(1.8, 0.2, n))
    half = np.stack([np.cos(turn), np.sin(turn)], 1) * true.rvs(n, random_state=chance)[:, None] / 2
    lines = shapely.linestrings(np.stack([middle - half, middle + half], axis=1))
    return clip_traces(lines, window)


NOTCHED = shapely.Polygon([(0, 0), (12, 0), (12, 6), (7, 4), (0, 6)])


@pytest.mark.full
def test_window_bias_towards_long_traces_is_corrected() -> None:
    chance = np.random.default_rng(8)
    naive, by_chance, fitted, by_ends = [], [], [], []
    for _ in range(25):
        pieces = traces_seen("exponential", chance, NOTCHED)
        found = describe_lengths(pieces, NOTCHED)
        naive.append(found.naive_mean_m)
        by_ends.append(found.mean_m)
        for fits, into in ((found.uncorrected, by_chance), (found.fits, fitted)):
            one = next(f for f in fits if f.distribution == "exponential")
            into.append(one.parameters["mean_m"].value)
    assert np.mean(naive) < 1.75
    assert np.mean(by_chance) > 2.4
    assert np.mean(fitted) == pytest.approx(2.0, abs=0.12)
    assert np.mean(by_ends) == pytest.approx(2.0, abs=0.12)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("name", sorted(TRUE))
def test_stated_intervals_contain_truth_in_95_percent(name: str, share: float) -> None:
    """2,000 samples of 100 lengths: the table of docs/fractures.md."""
    chance = np.random.default_rng(11)
    true = TRUE[name][1]
    held = dict.fromkeys(true, 0)
    for _ in range(2000):
        lengths, cut = cut_off(name, 100, share, chance)
        found = fit_law(law(name, lengths, cut), lengths, cut)
        assert found is not None
        for key, value in true.items():
            parameter = found.parameters[key]
            held[key] += parameter.low <= value <= parameter.high
    print(
        f"| {name} | {100 * share:g} | " + ", ".join(f"{k} {v / 20:.1f}" for k, v in held.items())
    )
    for key, count in held.items():
        assert 0.93 <= count / 2000 <= 0.97, key


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(TRUE))
def test_window_corrected_intervals_contain_truth_in_95_percent(name: str) -> None:
    chance = np.random.default_rng(12)
    true, parameters = TRUE[name]
    held = dict.fromkeys([*parameters, "mean by ends"], 0)
    runs, values = 500, []
    for _ in range(runs):
        pieces = traces_seen(name, chance, NOTCHED)
        lengths, cut = pieces.lengths(), pieces.is_cut.sum(axis=1)
        window: Window = fit_window(pieces, NOTCHED)
        found = fit_law(law(name, lengths, cut), lengths, cut, window)
        ends = mean_length_from_ends(lengths, cut)
        assert found is not None
        for key, value in parameters.items():
            held[key] += found.parameters[key].low <= value <= found.parameters[key].high
        held["mean by ends"] += ends.low <= true.mean() <= ends.high
        values.append((lengths.mean(), ends.value))
    naive, corrected = np.mean(values, axis=0)
    print(
        f"| {name} | {true.mean():.2f} | {naive:.2f} | {corrected:.2f} | "
        + ", ".join(f"{k} {100 * v / runs:.1f}" for k, v in held.items())
    )
    assert corrected == pytest.approx(true.mean(), rel=0.03)
    assert naive < 0.9 * true.mean()
    # The mean of a heavy tail needs more traces than one window has.
    least = {"mean by ends": 0.90}
    for key, count in held.items():
        assert least.get(key, 0.92) <= count / runs <= 0.98, key
