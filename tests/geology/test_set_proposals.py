"""Sets known by construction, found again."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.geology.orientation import normals_to_planes, planes_to_poles
from vomstudio.geology.sets.axial_mixture import (
    clusters_from_seeds,
    expected_random_groups,
    propose_clusters,
)
from vomstudio.geology.sets.proposals import spacing_along_normal
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.geology.statistics import orientation_tensor

Set = tuple[float, float, float, int]
"""Dip direction, dip, Fisher's kappa, number."""


def cluster(of: Set, chance: np.random.Generator) -> np.ndarray:
    """Poles of Fisher's distribution (Fisher, Lewis & Embleton 1987, 3.6.2), either end up."""
    direction, dip, kappa, n = of
    axis = planes_to_poles(direction, dip).ravel()
    share = np.exp(-2 * kappa)
    angle = np.arccos(1 + np.log(chance.random(n) * (1 - share) + share) / kappa)
    turn = chance.uniform(0, 2 * np.pi, n)
    one, two = np.linalg.svd(axis[None])[2][1:]
    across = np.cos(turn)[:, None] * one + np.sin(turn)[:, None] * two
    poles = np.cos(angle)[:, None] * axis + np.sin(angle)[:, None] * across
    return poles * chance.choice([-1.0, 1.0], n)[:, None]


def scatter(n: int, chance: np.random.Generator) -> np.ndarray:
    found = chance.normal(size=(n, 3))
    return found / np.linalg.norm(found, axis=1)[:, None]


def off_deg(poles: np.ndarray, of: Set) -> float:
    """Angle of the mean axis of poles from that of a set."""
    true = planes_to_poles(of[0], of[1]).ravel()
    return float(np.degrees(np.arccos(min(1.0, abs(orientation_tensor(poles)[1][0] @ true)))))


CASES: dict[str, tuple[list[Set], int]] = {
    "three": ([(30, 85, 200, 300), (120, 88, 150, 250), (200, 3, 150, 250)], 0),
    "clutter": ([(30, 85, 200, 300), (120, 88, 150, 250), (200, 40, 150, 250)], 300),
    "unequal": ([(30, 89, 150, 1500), (120, 60, 400, 60), (210, 10, 300, 120)], 100),
    "near": ([(30, 80, 200, 250), (52, 80, 200, 250)], 40),
    "steep": ([(0, 90, 200, 200), (60, 89, 200, 200), (120, 89, 200, 200)], 60),
    "six": (
        [(a, d, 300, 150) for a, d in ((0, 85), (60, 85), (120, 85), (0, 5), (210, 45), (30, 45))],
        100,
    ),
}


@pytest.mark.parametrize("seed", first_in_default_tier(range(3), 1))
@pytest.mark.parametrize("name", sorted(CASES))
def test_sets_are_found_within_a_degree(name: str, seed: int) -> None:
    chance = np.random.default_rng(seed)
    sets, clutter = CASES[name]
    poles = np.vstack([*(cluster(of, chance) for of in sets), scatter(clutter, chance)])
    truth = np.repeat(np.arange(len(sets) + 1), [*(of[3] for of in sets), clutter])
    order = chance.permutation(len(poles))
    poles, truth = poles[order], truth[order]
    found, criteria = propose_clusters(poles, 8)
    assert found.k == len(sets)
    assert len(criteria) > len(sets)
    group = found.most_probable_clusters()
    for i, of in enumerate(sets):
        mine = np.bincount(group[(truth == i) & (group >= 0)], minlength=found.k).argmax()
        assert off_deg(poles[group == mine], of) < 1.0
        assert np.mean(group[truth == i] == mine) > 0.9
    if clutter:
        assert np.mean(group[truth == len(sets)] < 0) > 0.5
    # Probabilities are calibrated: as many wrong as they say.
    best = found.posterior.max(axis=1)
    np.testing.assert_allclose(found.posterior.sum(axis=1), 1.0)
    named = {-1: len(sets)}
    for j in range(found.k):
        named[j] = int(np.bincount(truth[group == j]).argmax())
    right = np.array([named[int(g)] for g in group]) == truth
    assert right.mean() == pytest.approx(best.mean(), abs=0.03)


@pytest.mark.full
def test_five_wide_sets_among_clutter_are_separated() -> None:
    sets = [(40, 70), (100, 80), (160, 60), (250, 15), (300, 50)]
    right = 0
    for seed in range(16):
        chance = np.random.default_rng(seed)
        poles = np.vstack([*(cluster((*of, 30.0, 40), chance) for of in sets), scatter(22, chance)])
        right += propose_clusters(poles, 8)[0].k == 5
    assert right >= 14


def test_cone_of_set_among_clutter_contains_true_mean_in_95_percent() -> None:
    from vomstudio.geology.sets.proposals import propose_sets_of_poles

    held, sets = [], [(40.0, 70.0, 50.0, 40), (130.0, 85.0, 50.0, 40), (250.0, 15.0, 50.0, 40)]
    seeds = SetOptions(seeds=",".join(f"{of[0]}/{of[1]}" for of in sets))
    for seed in range(60):
        chance = np.random.default_rng(seed)
        poles = np.vstack([*(cluster(of, chance) for of in sets), scatter(60, chance)])
        for of, one in zip(sets, propose_sets_of_poles(poles, seeds).sets, strict=True):
            mean = planes_to_poles(one.dip_direction_deg, one.dip_deg).ravel()
            off = np.degrees(np.arccos(min(1.0, abs(mean @ planes_to_poles(*of[:2]).ravel()))))
            held.append(off <= (one.cone95_deg or 0.0))
    assert np.mean(held) == pytest.approx(0.95, abs=0.03)


@pytest.mark.full
@pytest.mark.parametrize("shape", ["disc", "heavy tails"])
def test_wide_non_fisher_set_is_not_split(shape: str) -> None:
    for seed in range(3):
        chance = np.random.default_rng(seed)
        if shape == "disc":
            # Evenly within 18 degrees of the axis.
            cosine = 1.0 - (1.0 - np.cos(np.radians(18.0))) * chance.random(150)
            turn, sine = chance.uniform(0, 2 * np.pi, 150), np.sqrt(1.0 - cosine**2)
            poles = np.column_stack([cosine, sine * np.cos(turn), sine * np.sin(turn)])
        else:
            poles = np.vstack([cluster((40, 70, kappa, 50), chance) for kappa in (15, 40, 150)])
        found, _ = propose_clusters(np.vstack([poles, scatter(15, chance)]), 8)
        assert found.k == 1


@pytest.mark.parametrize("seed", range(5))
def test_uniform_scatter_has_no_sets(seed: int) -> None:
    found, _ = propose_clusters(scatter(300, np.random.default_rng(seed)), 8)
    assert found.k == 0
    assert (found.most_probable_clusters() == -1).all()


def test_elongated_set_is_not_split() -> None:
    chance = np.random.default_rng(3)
    direction = 100 + chance.normal(0, 15, 300)
    poles = planes_to_poles(direction, 50 + chance.normal(0, 3, 300))
    found, _ = propose_clusters(np.vstack([poles, scatter(50, chance)]), 8)
    assert found.k == 1


@pytest.mark.full
def test_rotation_about_vertical_rotates_sets_and_keeps_members() -> None:
    chance = np.random.default_rng(4)
    poles = np.vstack([*(cluster(of, chance) for of in CASES["three"][0]), scatter(50, chance)])
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    one, _ = propose_clusters(poles, 8)
    two, _ = propose_clusters(poles @ turn.T, 8)
    np.testing.assert_array_equal(one.most_probable_clusters(), two.most_probable_clusters())
    first = normals_to_planes(one.axes[0, 0])[0]
    assert normals_to_planes(two.axes[0, 0])[0] == pytest.approx((first + 30) % 360, abs=1e-3)
    again, _ = propose_clusters(poles, 8)
    np.testing.assert_array_equal(again.posterior, one.posterior)


@pytest.mark.full
def test_requested_number_of_sets_is_returned_if_possible() -> None:
    from vomstudio.geology.sets.proposals import propose_sets_of_poles

    chance = np.random.default_rng(8)
    sets = CASES["three"][0]
    poles = np.vstack([*(cluster(of, chance) for of in sets), scatter(60, chance)])
    for k in (1, 2, 3, 5):
        found = propose_sets_of_poles(poles, SetOptions(exactly=k))
        assert len(found.sets) == k
        assert sum(s.n for s in found.sets) + found.unassigned == len(poles)
    assert not found.warnings
    # One direction cannot be two sets.
    alike = propose_sets_of_poles(planes_to_poles([90.0] * 9, [45.0] * 9), SetOptions(exactly=2))
    assert len(alike.sets) == 1
    assert by_code(alike.warnings)["sets.fewer"] == {
        "count": 1,
        "minimum": 3,
        "wanted": 2,
    }


def test_set_count_respects_maximum_and_seeds_keep_order() -> None:
    chance = np.random.default_rng(5)
    sets = CASES["clutter"][0]
    poles = np.vstack([*(cluster(of, chance) for of in sets), scatter(100, chance)])
    assert propose_clusters(poles, 2)[0].k <= 2
    seeds = planes_to_poles([of[0] + 8 for of in sets], [of[1] - 6 for of in sets])
    found = clusters_from_seeds(poles, seeds)
    for j, of in enumerate(sets):
        assert off_deg(poles[found.most_probable_clusters() == j], of) < 1.0


def test_spacing_matches_planes_a_known_distance_apart() -> None:
    chance = np.random.default_rng(6)
    normal = -planes_to_poles(70, 60).ravel()
    along = np.linalg.svd(normal[None])[2][1:]
    places = 0.4 * np.arange(20)[:, None] * normal + chance.normal(0, 3, (20, 2)) @ along
    mean, cv = spacing_along_normal(normal, places[chance.permutation(20)] + [4e5, 6e6, 300])
    assert mean == pytest.approx(0.4)
    assert cv == pytest.approx(0.0, abs=1e-6)
    assert spacing_along_normal(normal, places[:1]) == (None, None)
    assert spacing_along_normal(normal, None) == (None, None)


def test_ten_planes_in_three_clusters_give_three_sets() -> None:
    chance = np.random.default_rng(39)
    for _ in range(10):
        sets: list[Set] = [(30, 80, 200, 4), (120, 70, 200, 3), (230, 20, 200, 3)]
        mixture, _ = propose_clusters(np.vstack([cluster(of, chance) for of in sets]), 8)
        groups = mixture.most_probable_clusters()
        assert mixture.k == 3
        assert [len(set(groups[i:j].tolist())) for i, j in ((0, 4), (4, 7), (7, 10))] == [1, 1, 1]


def test_few_scattered_planes_rarely_form_a_set() -> None:
    chance = np.random.default_rng(39)
    found = [propose_clusters(scatter(10, chance), 8)[0].k > 0 for _ in range(100)]
    assert np.mean(found) < 0.2


def test_expected_random_groups_match_simulation() -> None:
    """The number of triples within 20 degrees of each other among 12 scattered poles."""
    chance = np.random.default_rng(39)
    least = np.cos(np.radians(20))
    counts = []
    for _ in range(400):
        near = np.abs((poles := scatter(12, chance)) @ poles.T) >= least
        counts.append(
            sum(near[i, j] and near[i, k] and near[j, k] for i, j, k in combinations(range(12), 3))
        )
    one, two = np.array([0.0, 0.0, 1.0]), np.array([np.sin(np.radians(20)), 0.0, least])
    expected = expected_random_groups(12, np.array([one, two, one]))
    assert np.mean(counts) == pytest.approx(expected, rel=0.15)


def test_big_elk_bedding_has_two_limbs(data_dir: Path) -> None:
    from vomstudio.geology.sets.proposals import propose_sets
    from vomstudio.io.gate.orientation_files import read_orientations

    found = propose_sets(
        read_orientations(data_dir / "planes" / "big_elk_strike_dip.txt", "strike")
    )
    assert [s.n for s in found.sets] == [38, 23]
