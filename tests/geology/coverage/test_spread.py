"""Repeated picks: closed forms, scipy, truths that were made, and what must not change."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from scipy.spatial.transform import Rotation

from vomstudio.geology.coverage.repeat_selection import select_repeats
from vomstudio.geology.coverage.spread import (
    check_stated_errors,
    compare_interpreters,
    group_structures,
    measure_spread,
)

UP = np.array([0.0, 0.0, 1.0])


def tilted(by_deg: float, toward_deg: float = 0.0) -> np.ndarray:
    a, t = np.radians([by_deg, toward_deg])
    return np.array([np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a)])


def random_axes(rng: np.random.Generator, n: int) -> np.ndarray:
    """(n, 3) normals in all directions."""
    made = rng.normal(size=(n, 3))
    return made / np.linalg.norm(made, axis=1, keepdims=True)


def picked(
    rng: np.random.Generator, truth: np.ndarray, sigma_deg: tuple[float, float], toward: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Picks about normals (n, 3), by a geodesic step of normal numbers, and the tangent axes one
    standard deviation long. toward : (n, 3) the direction of the first sigma, roughly"""
    first = toward - np.einsum("ni,ni->n", toward, truth)[:, None] * truth
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    frame = np.stack([first, np.cross(truth, first)], axis=1)
    sigma = np.radians(sigma_deg)
    axes = frame * sigma[:, None]
    step = np.einsum("nj,njc->nc", rng.normal(size=(len(truth), 2)), axes)
    # A turn about the axis at right angles to both.
    turn = Rotation.from_rotvec(np.cross(truth, step))
    return turn.apply(truth), turn.as_matrix()[:, None] @ axes[..., None]


def made_pairs(
    rng: np.random.Generator, k: int, sigma_deg: tuple[float, float], stated: float = 1.0
) -> tuple[np.ndarray, np.ndarray, list[list[int]]]:
    truth, toward = random_axes(rng, k), random_axes(rng, k)
    one, its = picked(rng, truth, sigma_deg, toward)
    two, other = picked(rng, truth, sigma_deg, toward)
    vectors = np.concatenate([one, two])
    axes = stated * np.concatenate([its, other])[..., 0]
    return vectors, axes, [[i, k + i] for i in range(k)]


def test_spread_of_one_pair_matches_closed_form() -> None:
    (one,) = group_structures(np.stack([UP, tilted(4.0)]), np.zeros((2, 2, 3)), [[0, 1]])
    spread = measure_spread([one])
    assert spread is not None
    # Sum of squares theta^2 / 2 by 2 degrees of freedom.
    assert spread.sigma_deg == pytest.approx(2.0, rel=1e-9)
    assert spread.error95_deg == pytest.approx(2.0 * np.sqrt(scipy.stats.chi2.ppf(0.95, 2)))
    low, high = 8.0 / scipy.stats.chi2.ppf([0.975, 0.025], 2)
    assert (spread.sigma_low_deg**2, spread.sigma_high_deg**2) == pytest.approx((low, high))
    assert check_stated_errors([one]) is None


def test_poles_are_axes_independent_of_sign() -> None:
    for sign in (1.0, -1.0):
        (one,) = group_structures(np.stack([UP, sign * tilted(4.0)]), np.zeros((2, 2, 3)), [[0, 1]])
        assert one.squares() == pytest.approx(2.0 * np.radians(2.0) ** 2)


def test_chi_square_of_pair_matches_its_difference() -> None:
    """Along the longer axis and across it, of unequal errors: d^2 / (s1^2 + s2^2)."""
    small = np.radians([[2.0, 1.0], [1.5, 0.5]])
    for toward_deg, column in ((0.0, 0), (90.0, 1)):
        second = tilted(3.0, toward_deg)
        turn = Rotation.align_vectors(second[None], UP[None])[0].as_matrix()
        axes = np.array([[[1.0, 0, 0], [0, 1.0, 0]]] * 2)
        axes[1] = axes[1] @ turn.T
        (one,) = group_structures(np.stack([UP, second]), axes * small[..., None], [[0, 1]])
        wanted = np.radians(3.0) ** 2 / (small[:, column] ** 2).sum()
        assert one.chi_square() == pytest.approx(wanted, rel=1e-6)
        found = check_stated_errors([one])
        assert found is not None
        assert found.p == pytest.approx(scipy.stats.chi2.sf(wanted, 2), rel=1e-5)
        assert found.within95 == int(wanted <= scipy.stats.chi2.ppf(0.95, 2))


def test_three_picks_give_two_repeats() -> None:
    vectors = np.stack([tilted(2.0, t) for t in (0.0, 120.0, 240.0)])
    (one,) = group_structures(vectors, np.zeros((3, 2, 3)), [[0, 1, 2]])
    assert one.squares() == pytest.approx(3.0 * np.radians(2.0) ** 2)
    spread = measure_spread([one])
    assert spread is not None
    assert (spread.n, spread.sigma_deg) == (2, pytest.approx(np.sqrt(3.0)))


def test_rotation_changes_nothing() -> None:
    vectors, axes, groups = made_pairs(np.random.default_rng(1), 20, (3.0, 1.0))
    before = group_structures(vectors, axes, groups)
    turn = Rotation.from_euler("zyx", [30.0, 40.0, 80.0], degrees=True).as_matrix()
    after = group_structures(vectors @ turn.T, axes @ turn.T, groups)
    for a, b in (
        (measure_spread(before), measure_spread(after)),
        (check_stated_errors(before), check_stated_errors(after)),
    ):
        assert a is not None
        assert vars(a) == pytest.approx(vars(b), rel=1e-9)


@pytest.mark.full
def test_known_sigma_is_recovered_and_inside_its_interval() -> None:
    """500 experiments of 30 pairs with errors of 4 and 2 degrees."""
    rng = np.random.default_rng(7)
    truth = np.sqrt((4.0**2 + 2.0**2) / 2.0)
    equal = 3.0
    sigmas, inside, ps, shares = [], 0, [], []
    for _ in range(500):
        vectors, axes, groups = made_pairs(rng, 30, (4.0, 2.0))
        found = group_structures(vectors, axes, groups)
        spread, held = measure_spread(found), check_stated_errors(found)
        assert spread is not None
        assert held is not None
        sigmas.append(spread.sigma_deg**2)
        ps.append(held.p)
        shares.append(held.within95_share)
        vectors, axes, groups = made_pairs(rng, 30, (equal, equal))
        round_one = measure_spread(group_structures(vectors, axes, groups))
        assert round_one is not None
        inside += round_one.sigma_low_deg <= equal <= round_one.sigma_high_deg
    assert np.sqrt(np.mean(sigmas)) == pytest.approx(truth, rel=0.01)
    assert 0.93 <= inside / 500 <= 0.97
    # Where the stated errors are right, p is uniform and 95 % of the pairs lie within them.
    assert scipy.stats.kstest(ps, "uniform").pvalue > 0.01
    assert np.mean(shares) == pytest.approx(0.95, abs=0.005)


@pytest.mark.full
def test_underestimated_errors_are_detected_at_stated_rate() -> None:
    rng = np.random.default_rng(11)
    noticed, k = 0, 20
    free = 2 * k
    factor = np.sqrt(scipy.stats.chi2.ppf(0.95, free) / scipy.stats.chi2.ppf(0.2, free))
    for _ in range(400):
        found = check_stated_errors(group_structures(*made_pairs(rng, k, (3.0, 2.0), 1.0 / factor)))
        assert found is not None
        assert found.noticeable_factor == pytest.approx(factor)
        noticed += found.p < 0.05
    assert 0.75 <= noticed / 400 <= 0.85


def test_differing_interpreters_are_detected() -> None:
    """The F of a one-way analysis of variance, of both axes together."""
    rng = np.random.default_rng(3)
    k, sigma = 15, 2.0
    alike = []
    for offset in [0.0] * 200 + [6.0]:
        truth = random_axes(rng, k)
        toward = random_axes(rng, k)
        rows, names = [], []
        for who, moved in (("A", 0.0), ("A", 0.0), ("B", offset), ("B", offset)):
            base = truth
            if moved:
                axis = np.cross(truth, toward)
                axis *= np.radians(moved) / np.linalg.norm(axis, axis=1, keepdims=True)
                base = Rotation.from_rotvec(axis).apply(truth)
            rows.append(picked(rng, base, (sigma, sigma), toward)[0])
            names += [who] * k
        groups = [[i, k + i, 2 * k + i, 3 * k + i] for i in range(k)]
        found = group_structures(np.concatenate(rows), np.zeros((4 * k, 2, 3)), groups)
        own, between = compare_interpreters(found, names)
        assert between is not None
        assert (between.n, between.within_n) == (k, 2 * k)
        assert {name: s.n for name, s in own.items()} == {"A": k, "B": k}
        if offset:
            assert between.p < 1e-6
        else:
            alike.append(between.p)
    assert scipy.stats.kstest(alike, "uniform").pvalue > 0.01
    one = found[0]
    # By hand: squares of each interpreter about the own mean, the rest between.
    halves = [one.positions[:2], one.positions[2:]]
    within = sum(((half - half.mean(axis=0)) ** 2).sum() for half in halves)
    means = np.array([half.mean(axis=0) for half in halves])
    between_squares = 2.0 * ((means - one.positions.mean(axis=0)) ** 2).sum()
    assert one.squares() == pytest.approx(within + between_squares)


def test_tenth_of_traces_is_selected_reproducibly() -> None:
    ids = [f"trace-{i}" for i in range(95)]
    chosen = select_repeats(ids)
    assert len(chosen) == 10
    assert select_repeats(ids[::-1]) == chosen
    assert select_repeats(ids, seed="other") != chosen
    assert len(select_repeats(["one"])) == 1
    assert select_repeats([]) == ()
    # Every pick has the same chance.
    counts = dict.fromkeys(ids, 0)
    for seed in range(1000):
        for id_ in select_repeats(ids, 0.2, str(seed)):
            counts[id_] += 1
    assert scipy.stats.chisquare(list(counts.values())).pvalue > 0.01
