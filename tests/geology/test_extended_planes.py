"""A plane carried on: its band against the formula of regression, and against known planes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.extraction.planes_by_construction import axes_of, normal_of
from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geology.beds.extended import (
    bands,
    plane_estimate_from_attitude,
    plane_estimate_from_fit,
    repeat_planes,
)
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.planes import fit_plane

Array = np.ndarray
ATTITUDE = (125.0, 40.0)
PLACE = np.array([4.0e5, 5.2e6, 310.0])


def sampled(rng: np.random.Generator, n: int, noise: float, size: tuple[float, float]) -> Array:
    u, v = axes_of(*ATTITUDE)
    s, t = (rng.uniform(-a / 2, a / 2, (n, 1)) for a in size)
    return PLACE + s * u + t * v + noise * rng.standard_normal((n, 1)) * normal_of(*ATTITUDE)


def test_position_variance_matches_regression() -> None:
    # Least squares of z on x, y for a level plane, whose covariance is the textbook's s^2 (X'X)^-1.
    rng = np.random.default_rng(1)
    n = 40
    x, y = rng.uniform(-4, 4, n), rng.uniform(-1, 1, n)
    points = np.column_stack([x, y, 0.01 * rng.standard_normal(n)])
    belief = plane_estimate_from_fit(fit_plane(points, is_ordered=False))
    columns = np.column_stack([np.ones(n), x, y])
    left = points[:, 2] - columns @ np.linalg.lstsq(columns, points[:, 2], rcond=None)[0]
    covariance = np.linalg.inv(columns.T @ columns) * (left @ left) / (n - 3)
    for place in ([0.0, 0.0], [10.0, 0.0], [3.0, -8.0]):
        row = np.array([1.0, *place])
        expected = math.sqrt(row @ covariance @ row)
        found = belief.position_sd(np.array([[*place, 0.0]]))[0]
        assert found == pytest.approx(expected, rel=2e-3)
    assert belief.degrees_of_freedom == pytest.approx(n - 3)


@pytest.mark.parametrize("far", first_in_default_tier([0.0, 3.0, 30.0], 1))
def test_band_contains_true_plane_in_95_percent(far: float) -> None:
    rng = np.random.default_rng(2)
    u, v = axes_of(*ATTITUDE)
    place = PLACE + far * (0.6 * u + 0.8 * v)
    held, runs = 0, 1000
    for _ in range(runs):
        belief = plane_estimate_from_fit(
            fit_plane(sampled(rng, 12, 0.02, (3.0, 1.5)), is_ordered=False)
        )
        held += bool(
            bands(belief, repeat_planes(belief, place[None], None), place[None]).is_in_band[0]
        )
    assert abs(held / runs - 0.95) < 4 * math.sqrt(0.95 * 0.05 / runs)


def test_stated_attitude_error_widens_band_by_its_tangent() -> None:
    plane = Plane(*ATTITUDE)
    belief = plane_estimate_from_attitude(plane, PLACE, 2.0)
    u, _ = axes_of(*ATTITUDE)
    error = bands(
        belief, repeat_planes(belief, PLACE[None], None), np.array([PLACE, PLACE + 50 * u])
    )
    assert error.error95_m[0] == 0.0
    # The joint region's 2.45 standard deviations are 1.96 of one figure.
    assert error.error95_m[1] == pytest.approx(
        50 * math.tan(math.radians(2.0)) * 1.959964 / math.sqrt(5.991465), rel=1e-6
    )
    wide = plane_estimate_from_attitude(plane, PLACE, 0.0, 0.3)
    assert bands(wide, repeat_planes(wide, PLACE[None], None), PLACE[None]).error95_m[
        0
    ] == pytest.approx(0.3)


def test_repeats_are_spaced_by_thickness_with_growing_error() -> None:
    belief = plane_estimate_from_attitude(Plane(*ATTITUDE), PLACE, 0.0, 0.0)
    normal = normal_of(*ATTITUDE)
    points = PLACE + np.array([-3.2, -1.1, 0.05, 2.01, 7.9])[:, None] * normal
    repeats = repeat_planes(belief, points, 2.0, 0.1)
    assert repeats.numbers.tolist() == [-2, -1, 0, 1, 2, 3, 4]
    found = bands(belief, repeats, points)
    assert found.bed.tolist() == [-2, -1, 0, 1, 4]
    assert found.distance_m == pytest.approx([0.8, 0.9, 0.05, 0.01, -0.1])
    assert found.error95_m == pytest.approx([0.2, 0.1, 0.0, 0.1, 0.4])
    assert found.is_in_band.tolist() == [False, False, False, True, True]


def test_rotating_points_rotates_the_band() -> None:
    rng = np.random.default_rng(3)
    points = sampled(rng, 25, 0.02, (4.0, 1.0)) - PLACE
    far = rng.uniform(-20, 20, (30, 3))
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    one, two = (plane_estimate_from_fit(fit_plane(p)) for p in (points, points @ turn.T))
    assert two.plane.dip_direction_deg == pytest.approx((one.plane.dip_direction_deg + 30) % 360)
    assert one.position_sd(far) == pytest.approx(two.position_sd(far @ turn.T), rel=1e-6)
    assert one.distances(far) == pytest.approx(two.distances(far @ turn.T), abs=1e-9)


def test_a_plane_without_known_errors_has_no_band() -> None:
    three = fit_plane([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]])
    with refused("plane.no-band", GeometryError):
        plane_estimate_from_fit(three)
    rng = np.random.default_rng(4)
    line = np.column_stack([np.linspace(0, 5, 20), np.zeros(20), np.zeros(20)])
    with refused("plane.too-uncertain", GeometryError):
        plane_estimate_from_fit(fit_plane(line + 0.05 * rng.standard_normal((20, 3))))
    belief = plane_estimate_from_attitude(Plane(0, 0), np.zeros(3), 1.0)
    with refused("beds.too-many", GeometryError, thickness_m=0.01, field="thickness"):
        repeat_planes(belief, np.array([[0, 0, 0], [0, 0, 100.0]]), 0.01)
