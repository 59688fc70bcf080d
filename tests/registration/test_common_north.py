"""A compass that is off by the same angle in all its readings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.benchmarks.bench_registration import Case, _compass, outcome
from tests.messages import with_code
from vomstudio.core.findings import Finding
from vomstudio.registration.observations import COMPASS, Azimuths, Directions, Points
from vomstudio.registration.placing import place

TURN = Rotation.from_euler("zyx", [70.0, 10.0, -6.0], degrees=True).as_matrix()


def planes(rng, n: int, off_deg: float, doubt_deg: float = 0.0, noise_deg: float = 2.0):
    """Readings whose azimuths are all too large by `off_deg`."""
    model = Rotation.random(n, random_state=5).as_matrix()[:, :, 0]
    world = model @ TURN.T + rng.normal(size=(n, 3)) * np.radians(noise_deg)
    world /= np.linalg.norm(world, axis=1, keepdims=True)
    # Azimuths run clockwise, turns about up do not.
    world = world @ Rotation.from_euler("z", -off_deg, degrees=True).as_matrix().T
    sigma = np.full((n, 2), np.radians(max(noise_deg, 0.1)))
    labels = [f"C{i}" for i in range(n)]
    return Directions(labels, model, world, sigma, north_sigma=float(np.radians(doubt_deg)))


def points(rng, n: int = 5, noise: float = 0.01):
    model = np.random.default_rng(2).uniform(-15.0, 15.0, (n, 3))
    world = 2.0 * model @ TURN.T + [398_000.0, 4_980_000.0, 320.0]
    world += rng.normal(size=(n, 3)) * noise
    return Points([f"P{i}" for i in range(n)], model, world, np.full((n, 3), max(noise, 1e-3)))


def turns_named(placed) -> list[Finding]:
    return with_code(placed.warnings, "registration.north-turned")


@pytest.mark.parametrize("off", [-35.0, -9.0, 4.0, 9.0, 20.0])
def test_compass_offset_is_reported_with_its_sign_if_points_fix_north(off) -> None:
    rng = np.random.default_rng(1)
    placed = place([points(rng), planes(rng, 8, off)])
    (finding,) = turns_named(placed)
    assert finding.values["kind"] == COMPASS
    assert finding.values["turn_deg"] == pytest.approx(off, abs=2.5)
    assert not placed.blunders, "none of the readings is wrong beside the others"


def test_compass_offset_without_noise_is_estimated_to_0_01_degrees() -> None:
    rng = np.random.default_rng(1)
    placed = place([points(rng, noise=0.0), planes(rng, 6, 12.34, noise_deg=0.0)])
    assert turns_named(placed)[0].values["turn_deg"] == pytest.approx(12.34, abs=0.01)


@pytest.mark.slow
def test_correct_compass_is_rarely_reported() -> None:
    rng = np.random.default_rng(4)
    named = sum(bool(turns_named(place([points(rng), planes(rng, 6, 0.0)]))) for _ in range(200))
    assert named <= 2


def test_compass_offset_is_not_reported_without_points() -> None:
    rng = np.random.default_rng(1)
    assert not turns_named(place([planes(rng, 8, 9.0)]))


def test_wrong_reading_is_reported_in_addition_to_the_compass_offset() -> None:
    rng = np.random.default_rng(3)
    read = planes(rng, 8, 9.0)
    away = Rotation.from_rotvec([0.5, 0.3, 0.0]).as_matrix()
    read.world[4] = read.world[4] @ away.T
    placed = place([points(rng), read])
    assert turns_named(placed)
    assert [blunder.label for blunder in placed.blunders] == ["C4"]


def test_compass_uncertainty_is_common_to_all_readings() -> None:
    """Of very good readings nothing but the doubt is left about the vertical."""
    rng = np.random.default_rng(1)
    for n in (4, 40):
        placed = place([planes(rng, n, 0.0, doubt_deg=5.0, noise_deg=0.0)])
        assert placed.rotation_error_deg.about_up == pytest.approx(5.0, rel=0.01)
        assert placed.rotation_error_deg.about_east < 0.2
    level = np.array([[1.0, 0.3, 0.0], [-0.2, 1.0, 0.0]]) / np.hypot(1.0, [[0.3], [0.2]])
    lines = Azimuths(
        ["a", "b"],
        level @ TURN,
        np.arctan2(level[:, 0], level[:, 1]),
        np.full(2, 1e-3),
        float(np.radians(5.0)),
    )
    both = place([planes(rng, 8, 0.0, doubt_deg=5.0, noise_deg=0.0), lines])
    assert both.rotation_error_deg.about_up == pytest.approx(5.0, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "deg", "north"), [(8, 2.0, 5.0), (5, 3.0, 10.0)])
def test_stated_error_covers_a_random_compass_bias(n, deg, north) -> None:
    found = outcome(Case("planes", _compass(n, deg, north)), 400, seed=7)
    # 400 know a share of 95 % to 1.1 %, one sigma.
    for share in (found.up, found.east, found.north):
        assert 0.915 <= share <= 0.985
