"""Points that fit exactly are as accurate as their coordinates are written or stored."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from vomstudio.registration.placing import register_points
from vomstudio.registration.precision import rounding_step
from vomstudio.registration.similarity import rotation_covariance

Array = npt.NDArray[np.float64]
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def worst_deg(model: Array, world: Array) -> float:
    error = register_points(model, world).rotation_error_95_deg.weakest.error_deg
    assert error is not None
    return error


@pytest.mark.parametrize(
    ("values", "step"),
    [
        ([0.125, 398_000.01, 7.5], 1e-3),
        ([1.25, 2.5, 3.75], 1e-2),
        ([1.0, 900.0], 1e-2),  # whole numbers: trailing zeros are lost
        ([0.1234, 0.5], 1e-4),
        ([np.pi, 1.0], np.spacing(np.pi)),
        ([np.pi * 1e6, 1.0], np.spacing(np.pi * 1e6)),
        ([float(np.float32(np.pi)), 8.5], float(np.spacing(np.float32(8.5)))),
        ([float(np.float32(np.pi * 1e6)), 2.0], float(np.spacing(np.float32(np.pi * 1e6)))),
    ],
)
def test_rounding_step_matches_the_written_digits(values: list[float], step: float) -> None:
    assert rounding_step(values) == pytest.approx(step, rel=1e-9)


@pytest.mark.parametrize("decimals", [2, 3, 5])
@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_the_error_of_exact_points_follows_their_last_decimal(decimals: int, scale: float) -> None:
    """That of a uniform distribution: step / sqrt(12), in each frame, against the closed form."""
    rng = np.random.default_rng(4)
    model = np.round(rng.uniform(-10.0, 10.0, (4, 3)), decimals)
    world = np.round(scale * model @ QUARTER.T + [500.0, 200.0, 30.0], decimals)
    # Written with the same decimals, or with two less, but at least two.
    step = 10.0 ** -max(decimals - round(np.log10(scale)), 2)
    sigma = np.hypot(step, scale * 10.0**-decimals) / np.sqrt(12.0)
    by_hand = np.linalg.eigvalsh(rotation_covariance(world, sigma))[-1]
    assert worst_deg(model, world) == pytest.approx(1.96 * np.degrees(np.sqrt(by_hand)), rel=0.01)


def test_the_error_of_exact_points_follows_the_size_of_their_coordinates() -> None:
    rng = np.random.default_rng(5)
    model = rng.uniform(-10.0, 10.0, (4, 3)).astype(np.float32).astype(np.float64)
    at = {far: worst_deg(model, model @ QUARTER.T + far) for far in (0.0, 2.0**22)}
    # In float64 the numbers of World need not be worse than those of the model in float32.
    assert at[2.0**22] == pytest.approx(at[0.0], rel=0.5)
    # Kept in float32, they are: 2^22 leaves half a unit, and then all lie on halves.
    halves = np.round(2.0 * model) / 2.0
    far = halves @ QUARTER.T + 2.0**22 + 0.5
    near = halves @ QUARTER.T + 0.5
    assert worst_deg(halves, far) > 10.0 * worst_deg(halves, near)


def test_rounding_does_not_affect_errors_of_noisy_points() -> None:
    rng = np.random.default_rng(6)
    model = np.round(rng.uniform(-10.0, 10.0, (6, 3)), 3)
    noisy = model @ QUARTER.T + rng.normal(size=(6, 3)) * 0.05
    rounded = register_points(model, np.round(noisy, 3)).rotation_error_deg
    exact = register_points(model, noisy).rotation_error_deg
    assert rounded.about_up == pytest.approx(exact.about_up, rel=0.02)
    stated = register_points(model, model @ QUARTER.T, np.full((6, 3), 0.05)).rotation_error_deg
    covariance = rotation_covariance(model @ QUARTER.T, 0.05)
    assert stated.about_up == pytest.approx(np.degrees(np.sqrt(covariance[2, 2])), rel=1e-6)
