"""Registration by pairs of points against scipy, simulation, and the symmetries of space."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.messages import refused, with_code
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geology.orientation import Line
from vomstudio.registration.placing import register_points

TRUE = Rotation.from_euler("zyx", [70, -12, 33], degrees=True)
SCALE, SHIFT = 0.013, np.array([364_520.0, 4_721_864.0, 850.0])


def pairs(n: int = 8, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    model = np.random.default_rng(seed).uniform(-500, 500, (n, 3))
    return model, SCALE * TRUE.apply(model) + SHIFT


def test_exact_pairs_recover_the_transform() -> None:
    model, world = pairs()
    found = register_points(model, world)
    matrix = np.array(found.matrix)
    assert found.scale == pytest.approx(SCALE)
    assert matrix[:3, :3] / SCALE == pytest.approx(TRUE.as_matrix(), abs=1e-9)
    assert found(model) == pytest.approx(world)
    assert found.rms_control_m == pytest.approx(0.0, abs=1e-8)
    assert found.rms_check_m is None


def test_fit_with_unequal_errors_matches_scipy() -> None:
    model, world = pairs()
    chance = np.random.default_rng(4)
    sigma = chance.uniform(0.01, 0.5, world.shape)
    world = world + sigma * chance.normal(size=world.shape)

    def misses(p: np.ndarray) -> np.ndarray:
        placed = p[3] * Rotation.from_rotvec(p[:3]).apply(model) + p[4:]
        return np.asarray((placed - (world - SHIFT)) / sigma).ravel()

    start = np.concatenate([TRUE.as_rotvec(), [SCALE], np.zeros(3)])
    best = least_squares(
        misses, start, x_scale=[1e-2] * 3 + [1e-4] + [1e-1] * 3, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    found = register_points(model, world, sigma)
    assert found.scale == pytest.approx(best.x[3], rel=1e-7)
    placed = best.x[3] * Rotation.from_rotvec(best.x[:3]).apply(model) + best.x[4:] + SHIFT
    assert found(model) == pytest.approx(placed, abs=1e-6)


@pytest.mark.full
@pytest.mark.parametrize("stated", [True, False])
def test_stated_errors_cover_the_true_rotation_errors(stated: bool) -> None:
    """95 % of the rotations, about each axis by itself, in 400 simulations."""
    model, world = pairs(6)
    sigma = np.tile([0.02, 0.02, 0.05] if stated else [0.03] * 3, (6, 1))
    chance = np.random.default_rng(11)
    within = np.zeros(4)
    runs = 400
    for _ in range(runs):
        noisy = world + sigma * chance.normal(size=world.shape)
        found = register_points(model, noisy, sigma if stated else None)
        turned = np.array(found.matrix)[:3, :3] / found.scale @ TRUE.as_matrix().T
        east, north, up = np.abs(np.degrees(Rotation.from_matrix(turned).as_rotvec()))
        limits = found.rotation_error_95_deg
        within += [
            east < limits.about_east,
            north < limits.about_north,
            up < limits.about_up,
            abs(found.scale / SCALE - 1) < found.scale_error_95,
        ]
    # Four standard deviations of a binomial count either side.
    assert (np.abs(within / runs - 0.95) < 4 * np.sqrt(0.95 * 0.05 / runs)).all(), within / runs


def test_weakest_axis_is_parallel_to_the_line_of_points() -> None:
    along = np.array([np.sin(np.radians(40)), np.cos(np.radians(40)), 0.0])
    across = np.array([along[1], -along[0], 0.0])
    t = np.linspace(-50, 50, 9)
    world = np.outer(t, along) + np.outer([3.0, -3.0, 3.0, -3.0, 0.0, -3.0, 3.0, -3.0, 3.0], across)
    found = register_points(world, world, np.full(world.shape, 0.05))
    weakest = found.rotation_error_95_deg.weakest
    assert (weakest.trend_deg % 180, weakest.plunge_deg) == pytest.approx((40.0, 0.0), abs=0.5)
    others = found.rotation_error_95_deg
    assert weakest.error_deg >= max(others.about_up, others.about_east, others.about_north)


def test_check_points_are_evaluated_but_not_fitted() -> None:
    model, world = pairs()
    moved = world.copy()
    check = np.arange(8) == 3
    moved[3] += [3.0, -4.0, 12.0]
    found = register_points(model, moved, check=check)
    (left,) = found.check
    assert left.label == "4"
    # Fitted less given.
    assert (left.dx, left.dy, left.dz) == pytest.approx((-3.0, 4.0, -12.0))
    assert left.error_m == pytest.approx(13.0)
    assert found.rms_check_m == pytest.approx(13.0)
    assert found.rms_control_m == pytest.approx(0.0, abs=1e-8)


def test_rotating_the_world_rotates_the_transform() -> None:
    model, world = pairs()
    world = world + np.random.default_rng(3).normal(0, 0.1, world.shape)
    turn = Rotation.from_euler("z", -30, degrees=True)
    here, there = register_points(model, world), register_points(model, turn.apply(world))
    assert there(model) == pytest.approx(turn.apply(here(model)))
    assert there.rms_control_m == pytest.approx(here.rms_control_m)
    assert there.rotation_error_deg.about_up == pytest.approx(here.rotation_error_deg.about_up)


def test_problems_of_the_points_are_reported() -> None:
    model, world = pairs()
    three = register_points(model[:3], world[:3])
    assert with_code(three.warnings, "control.no-redundancy")
    mirrored = register_points(model * [1, 1, -1], world)
    assert "control.swapped-columns" in [each.code for each in mirrored.warnings]
    noisy = world + np.random.default_rng(2).normal(0, 1.0, world.shape)
    doubted = register_points(model, noisy, np.full(world.shape, 0.01))
    assert with_code(doubted.warnings, "registration.residuals-large")
    clean = register_points(model, world, check=np.arange(8) > 5)
    assert clean.warnings == ()


def test_too_few_or_collinear_points_are_rejected() -> None:
    model, world = pairs()
    with refused("registration.too-few-points", GeometryError):
        register_points(model[:2], world[:2])
    with refused("registration.too-few-points", GeometryError):
        register_points(model, world, check=np.arange(8) > 1)
    line = np.outer(np.arange(6.0), [1.0, 2.0, 3.0])
    with refused("control.collinear", GeometryError):
        register_points(line, line)


def _on_a_line(n: int, off: float) -> np.ndarray:
    """Points along 30 m that are off their line by `off` (metres) to all sides."""
    row = np.arange(n)
    return np.column_stack(
        [np.linspace(-15.0, 15.0, n), off * (-1.0) ** row, off * (-1.0) ** (row // 2)]
    )


@pytest.mark.parametrize("n", first_in_default_tier([4, 9]))
@pytest.mark.parametrize("stated", first_in_default_tier([True, False]))
def test_nearly_collinear_points_register_if_their_width_exceeds_their_error(
    n: int, stated: bool
) -> None:
    rng = np.random.default_rng(n)
    runs, inside = 30, np.zeros(3)
    for _ in range(runs):
        model = _on_a_line(n, 0.15)
        world = model + rng.normal(size=model.shape) * 0.005 + [5e5, 5e6, 100.0]
        placed = register_points(model, world, np.full(model.shape, 0.005) if stated else None)
        off = np.abs(
            np.degrees(
                Rotation.from_matrix(np.array(placed.matrix)[:3, :3] / placed.scale).as_rotvec()
            )
        )
        told = placed.rotation_error_95_deg
        inside += off <= [told.about_east, told.about_north, told.about_up]
        line = Line(told.weakest.trend_deg, told.weakest.plunge_deg).vector()
        assert abs(line[0]) > np.cos(np.radians(20.0))
    # Three standard deviations of 30 runs at 95 %.
    assert (inside / runs > 0.83).all()


@pytest.mark.parametrize("n", [3, 4, 5, 8, 12])
@pytest.mark.parametrize("stated", [True, False])
def test_points_off_their_line_by_noise_only_are_rejected(n: int, stated: bool) -> None:
    rng = np.random.default_rng(n)
    for _ in range(20):
        true = _on_a_line(n, 0.0)
        model = true + rng.normal(size=true.shape) * 0.01
        world = true + rng.normal(size=true.shape) * 0.01
        with refused("control.collinear", GeometryError):
            register_points(model, world, np.full(model.shape, 0.01) if stated else None)
