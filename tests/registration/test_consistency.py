"""Points and cameras that place a model alike, and such that do not."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from tests.messages import with_code
from vomstudio.core.findings import Finding
from vomstudio.registration.observations import Points
from vomstudio.registration.placing import place

Array = npt.NDArray[np.float64]
ORIGIN = np.array([576_700.0, 5_188_160.0, 160.0])


def told(seed: int, lens: float = 1.0) -> list[Finding]:
    """The warnings of a wall of 30 m that was photographed from 20 m, with GPS of 3 cm and points
    of 1 cm; lens : by how much a wrong lens sets the cameras too far apart."""
    chance = np.random.default_rng(seed)
    wall = chance.uniform([-15, -1, -6], [15, 1, 6], (7, 3))
    stand = chance.uniform([-15, -22, -3], [15, -18, 3], (9, 3))

    def observed(true: Array, model: Array, sigma: float, name: str) -> Points:
        world = ORIGIN + true + chance.normal(size=true.shape) * sigma
        labels = [f"{name} {i}" for i in range(len(true))]
        return Points(labels, model, world, np.full(world.shape, np.nan), name)

    kinds = [
        observed(wall, wall, 0.01, "points"),
        observed(stand, stand * [lens, 1.0, lens], 0.03, "cameras"),
    ]
    return with_code(place(kinds).warnings, "registration.points-and-cameras")


@pytest.mark.full
def test_consistent_points_and_cameras_are_rarely_reported() -> None:
    assert sum(bool(told(seed)) for seed in range(60)) <= 1


def test_wrong_focal_length_is_reported_as_a_scale_difference() -> None:
    found = [told(seed, 1.05) for seed in range(5)]
    assert all(found)
    assert abs(found[0][0].values["scale_percent"]) == pytest.approx(5.0, abs=1.0)
