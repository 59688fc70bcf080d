"""A registration that turns a model upside down is never without a word."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from tests.messages import with_code
from vomstudio.core.errors import GeometryError
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.registration.checks.comparison import residual_misfit
from vomstudio.registration.checks.mirrors import fits_as_mirror, upside_down_findings
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.observations import Points
from vomstudio.registration.placing import register_points

Array = npt.NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])


def ground(n: int, relief: float, noise: float, seed: int) -> tuple[Array, Array]:
    """Points on ground of 60 by 40 m, and their coordinates."""
    chance = np.random.default_rng(seed)
    model = chance.uniform(-0.5, 0.5, (n, 3)) * [60.0, 40.0, relief]
    return model, model + chance.normal(size=model.shape) * noise


def pairs_of(model: Array, world: Array) -> Pairs:
    n = len(model)
    labels = tuple(f"P{i + 1}" for i in range(n))
    return Pairs(labels, model, world, np.full((n, 3), np.nan), np.zeros(n, bool))


@pytest.mark.parametrize(
    ("n", "relief", "noise"), [(8, 0.5, 0.02), (12, 1.2, 0.05), (10, 2.0, 0.1), (40, 1.0, 0.05)]
)
def test_swapped_columns_on_flat_ground_are_reported(n: int, relief: float, noise: float) -> None:
    for seed in (3, 4):
        model, world = ground(n, relief, noise, seed)
        found = register_points(model, world[:, [1, 0, 2]])
        assert found.warnings[0].code == "control.swapped-columns"
        assert not found.blunders, "where all are mirrored no single one is wrong"


def test_correct_points_on_flat_ground_do_not_fit_as_mirror_image() -> None:
    """Also where the heights are three times as bad as the rest, and the ground is a plane."""
    alarms = 0
    for seed in range(300):
        chance = np.random.default_rng(seed)
        relief = float(chance.choice([0.0, 0.1, 1.0, 10.0]))
        model, world = ground(int(chance.integers(4, 15)), relief, 0.02, seed)
        world[:, 2] += chance.normal(size=len(world)) * 0.06
        alarms += fits_as_mirror(model, world)
    assert alarms <= 3


def test_mirror_image_is_detected_despite_a_wrong_point() -> None:
    for seed in range(4):
        model, world = ground(9, 12.0, 0.05, seed)
        world[2] += [8.0, -6.0, 5.0]
        assert fits_as_mirror(model, world[:, [1, 0, 2]])
        assert not fits_as_mirror(model, world)


def test_registration_that_turns_a_model_upside_down_is_reported() -> None:
    # In one plane exactly no residual tells a plane from its mirror image.
    model, world = ground(3, 0.0, 0.0, 1)
    evidence = Evidence(pairs=pairs_of(model, world[:, [1, 0, 2]]), up=UP)
    assert with_code(register(evidence).warnings, "registration.upside-down")
    evidence = Evidence(pairs=pairs_of(model, world), up=UP)
    assert not with_code(register(evidence).warnings, "registration.upside-down")


def test_ambiguous_upside_down_registration_of_flat_points_is_reported() -> None:
    over = np.diag([1.0, -1.0, -1.0])
    flat, deep = ground(6, 0.0, 0.02, 2), ground(6, 20.0, 0.02, 2)
    labels = [str(i) for i in range(6)]
    nothing = np.full((6, 3), np.nan)

    def codes(pair: tuple[Array, Array], rotation: Array) -> list[str]:
        model, world = pair
        points = Points(labels, model, world @ rotation.T, nothing)
        return [finding.code for finding in upside_down_findings(rotation, None, points)]

    assert codes(flat, over) == ["registration.upside-down-or-mirror"]
    assert codes(deep, over) == []
    assert codes(flat, np.eye(3)) == []


def test_upside_down_check_accepts_any_model_up_direction() -> None:
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    assert upside_down_findings(turn, turn.T @ UP, None) == []
    assert upside_down_findings(turn, -turn.T @ UP, None)


def test_residual_misfit_matches_least_squares() -> None:
    model, world = ground(9, 15.0, 0.05, 5)
    found = register_points(model, world)
    left = residual_misfit(model, world)
    assert left is not None
    assert found.rms_control_m is not None
    assert left.variance == pytest.approx(9 * found.rms_control_m**2 / 20, rel=1e-6)
    assert 20 / 3 <= left.degrees_of_freedom <= 20
    assert residual_misfit(model[:3], world[:3])
    assert residual_misfit(model * [1.0, 0.0, 0.0], world) is None
    with pytest.raises(GeometryError):
        register_points(model * [1.0, 0.0, 0.0], world)
