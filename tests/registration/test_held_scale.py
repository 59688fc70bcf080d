"""A scale that a registration holds keeps the error that it had before."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.stats import chi2

from tests.registration.rock_faces import sampled
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.project.records import Model
from vomstudio.registration.by_model.reference import fit_to_reference
from vomstudio.registration.placing import place
from vomstudio.registration.results import ModelPlacement
from vomstudio.registration.similarity import Similarity, jacobian
from vomstudio.registration.similarity_observation import difference
from vomstudio.studio.placing.registering import (
    add_reference_error,
    create_registration,
    place_by_points,
)

Array = npt.NDArray[np.float64]
SCALE_ERROR = 1e-3
SIZE, COUNT = 9.0, (2_500, 3_500)


def fitted(
    seed: int, relative_error: float, scale_error: float | None
) -> tuple[ModelPlacement, Array]:
    """Fit a model whose scale is off to its reference, and return the seven errors of the fit."""
    rng = np.random.default_rng(seed)
    reference = sampled(COUNT[1], rng, 0.01, SIZE)
    middle = np.array([SIZE / 2, 0.0, SIZE / 2])
    model = (sampled(COUNT[0], rng, 0.01, SIZE) - middle) / (1.0 + relative_error)
    truth = Similarity(1.0 + relative_error, np.eye(3), middle)
    spacing = (SIZE / np.sqrt(COUNT[0]), SIZE / np.sqrt(COUNT[1]))
    found = fit_to_reference(
        model,
        reference,
        Similarity(1.0, np.eye(3), middle),
        spacing=spacing,
        include_scale=False,
        scale_error=scale_error,
    )
    placed = place([found.observation], None, model)
    rotation = placed.matrix[:3, :3] / placed.scale
    fit = Similarity(placed.scale, rotation, placed.matrix[:3, 3])
    return placed, difference(fit, truth, np.array(placed.centre))


def test_fit_with_fixed_scale_states_the_scale_error() -> None:
    """The case of the report: the scale was off by 0.104 %, and ± 0.02 % was stated."""
    placed, off = fitted(3, 1.04e-3, SCALE_ERROR)
    assert placed.scale == pytest.approx(1.0, abs=1e-9)
    assert off[3] == pytest.approx(-1.04e-3, abs=1e-5)
    assert placed.scale_error_95 == pytest.approx(1.96e-3, rel=0.02)
    unstated, _ = fitted(3, 1.04e-3, None)
    assert unstated.scale_error_95 == pytest.approx(1.96e-4, rel=0.02)
    # Where the model comes to lie does not depend on how well its scale is known.
    assert unstated.matrix == pytest.approx(placed.matrix, abs=1e-12)


def test_covariance_includes_the_effect_of_scale_error_on_rotation_and_shift() -> None:
    """The same points with a right and a wrong scale: what differs is the predicted response."""
    right, off_right = fitted(3, 0.0, None)
    sigma = np.sqrt(np.diag(right.covariance))
    for relative_error in (5e-3, -5e-3):
        wrong, off_wrong = fitted(3, relative_error, abs(relative_error))
        covariance = np.array(wrong.covariance)
        response = covariance[:, 3] / covariance[3, 3]
        # This wall turns by half a radian per unit of scale about the vertical.
        assert abs(response[2]) > 0.3
        assert abs(response[2] * relative_error) > 3.0 * sigma[2]
        left = off_wrong - off_right - response * off_wrong[3]
        assert (np.abs(left) < sigma).all()


@pytest.mark.full
def test_stated_errors_cover_random_scale_errors() -> None:
    rng = np.random.default_rng(11)
    inside, runs = np.zeros(7), 40
    for seed in range(runs):
        placed, off = fitted(500 + seed, SCALE_ERROR * rng.normal(), SCALE_ERROR)
        inside += np.abs(off) <= 1.96 * np.sqrt(np.diag(placed.covariance))
    # Three standard deviations of 40 runs at 95 %; Student's widening makes it more.
    assert (inside / runs > 0.95 - 0.11).all()


@pytest.mark.full
def test_point_registration_states_the_error_of_its_fixed_scale() -> None:
    """The centre of the model is not that of the points: the kept scale shifts it too."""
    rng = np.random.default_rng(5)
    points = rng.uniform(-1.0, 1.0, (8, 3)) * [10.0, 4.0, 6.0]
    extent = rng.uniform(-1.0, 1.0, (200, 3)) * [10.0, 4.0, 6.0] + [30.0, 0.0, 0.0]
    sigma = np.full((8, 3), 0.005)
    zero = np.zeros(8, bool)
    before = Registration("r", "r", "gps", Frame("local"), scale_error=SCALE_ERROR)
    inside, runs = 0, 40
    for _ in range(runs):
        grow = 1.0 + SCALE_ERROR * rng.normal()
        world = points * grow + rng.normal(0.0, 0.005, (8, 3))
        pairs = Pairs(tuple("ABCDEFGH"), points, world, sigma, zero)
        model = Model("m", "cliff", "cliff.ply", "cloud", "", before)
        placed = place_by_points(pairs, None, model, None, extent, keep_scale=True)
        record = create_registration(placed, pairs, model, None)
        # A kept scale is known to 0.01 % to the adjustment: good points move it a little.
        assert abs(placed.scale - 1.0) < 0.3 * abs(grow - 1.0) + 2e-4
        assert 0.8 * SCALE_ERROR < record.scale_error < 1.05 * SCALE_ERROR
        truth = Similarity(grow, np.eye(3), np.zeros(3))
        rotation = placed.matrix[:3, :3] / placed.scale
        fit = Similarity(placed.scale, rotation, placed.matrix[:3, 3])
        off = difference(fit, truth, np.array(placed.centre))
        covariance = np.array(record.covariance)
        inside += off @ np.linalg.solve(covariance, off) <= chi2.ppf(0.95, 7)
    assert inside / runs == pytest.approx(0.95, abs=0.1)


def test_fixed_scale_does_not_inherit_the_reference_scale_error() -> None:
    """Against 4,000 references drawn by the covariance of theirs."""
    own = np.diag([1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-6, 1e-6])
    theirs = np.diag([1e-6, 4e-6, 2e-6, 9e-6, 1e-4, 2e-4, 1e-4])
    centre, away = np.array([100.0, 50.0, 20.0]), np.array([30.0, -20.0, 5.0])

    def record(covariance: Array, at: Array) -> Registration:
        rows = tuple(map(tuple, covariance.tolist()))
        return Registration(
            "r", "r", "reference", Frame("local"), covariance=rows, centre=tuple(at)
        )

    total = {
        scale: np.array(
            add_reference_error(
                record(own, centre + away), record(theirs, centre), scale_fitted=scale
            ).covariance
        )
        for scale in (True, False)
    }
    rng = np.random.default_rng(2)
    drawn = rng.multivariate_normal(np.zeros(7), theirs, 4_000)
    shifts = drawn @ jacobian(away).T
    for scale in (True, False):
        moved = np.hstack([drawn[:, :3], drawn[:, 3:4] * scale, shifts])
        wanted = moved.T @ moved / len(moved) + own
        found = np.sqrt(np.diag(total[scale]))
        assert found == pytest.approx(np.sqrt(np.diag(wanted)), rel=0.05)
    assert total[False][3, 3] == own[3, 3]
