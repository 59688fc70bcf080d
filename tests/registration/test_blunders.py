"""Wrong observations are named, and no right ones beside them."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.registration.placing import register_points


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("wrong_m", [0.5, 5.0, 50.0])
def test_only_the_wrong_point_is_reported(stated: bool, wrong_m: float) -> None:
    for seed in range(5):
        chance = np.random.default_rng(seed)
        model = chance.uniform([0, 0, 0], [100, 90, 12], (8, 3))
        world = model + chance.normal(size=model.shape) * 0.02
        bad = seed % 8
        world[bad, 0] += wrong_m
        sigma = np.full(model.shape, 0.02) if stated else None
        found = register_points(model, world, sigma)
        assert [b.label for b in found.blunders] == [str(bad + 1)]
        assert found.blunders[0].error_m == pytest.approx(wrong_m, abs=0.2)


def test_two_wrong_points_are_reported_and_no_correct_ones() -> None:
    for seed in range(5):
        chance = np.random.default_rng(seed)
        model = chance.uniform([0, 0, 0], [100, 90, 12], (12, 3))
        world = model + chance.normal(size=model.shape) * 0.02
        world[2] += [4.0, 1.0, 0.0]
        world[7] += [0.0, -3.0, 2.0]
        found = register_points(model, world, np.full(model.shape, 0.02))
        assert sorted(b.label for b in found.blunders) == ["3", "8"]


@pytest.mark.parametrize("stated", [True, False])
def test_two_wrong_points_among_six_are_reported(stated: bool) -> None:
    for seed in range(4):
        chance = np.random.default_rng(seed)
        model = chance.uniform([0, 0, 0], [30, 12, 15], (6, 3))
        world = model + chance.normal(size=model.shape) * 0.01
        bad = chance.choice(6, 2, replace=False)
        for row in bad.tolist():
            away = chance.normal(size=3)
            world[row] += 3.0 * away / np.linalg.norm(away)
        sigma = np.full(model.shape, 0.01) if stated else None
        found = register_points(model, world, sigma)
        assert {b.label for b in found.blunders} == {str(row + 1) for row in bad.tolist()}


def test_six_correct_points_give_no_blunder() -> None:
    for seed in range(10):
        chance = np.random.default_rng(seed)
        model = chance.uniform([0, 0, 0], [30, 12, 15], (6, 3))
        world = model + chance.normal(size=model.shape) * 0.01
        assert register_points(model, world).blunders == ()


@pytest.mark.parametrize("mirrored", [False, True])
def test_causes_are_reported_before_their_consequences(mirrored: bool) -> None:
    """More points would not help where one is wrong, or all are mirrored."""
    chance = np.random.default_rng(3)
    model = chance.uniform([0, 0, 0], [20, 18, 12], (8, 3))
    world = model + chance.normal(size=model.shape) * 0.02
    if mirrored:
        model = model * [1.0, 1.0, -1.0]
    else:
        world[2, 0] += 4.0
    first, *others = register_points(model, world).warnings
    assert first.code == ("control.swapped-columns" if mirrored else "registration.blunder")
    assert mirrored or first.values["labels"][0].startswith("3 (")
    codes = {each.code for each in others}
    assert "registration.weak-rotation" in codes
    assert "registration.points-nowhere" not in codes
