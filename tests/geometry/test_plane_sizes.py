"""How large a plane must be: against simulated planes, and against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geometry.plane_errors import confidence_axes_rad, joint_quantile
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.geometry.planes import fit_plane

RESOLUTION = 0.1


def simulated(sizes: PlaneSizes, size: float, runs: int = 3000) -> np.ndarray:
    """(runs,) angles between a disc and the plane fitted to its noisy points by SVD, degrees; one
    point for each square of the resolution, and the registration's rotation on top."""
    rng = np.random.default_rng(11)
    count = round(math.pi / 4 * (size / sizes.resolution) ** 2)
    angle, radius = rng.uniform(0, 2 * np.pi, (runs, count)), np.sqrt(rng.random((runs, count)))
    x, y = size / 2 * radius * np.cos(angle), size / 2 * radius * np.sin(angle)
    points = np.stack([x, y, rng.normal(0, sizes.noise, x.shape)], axis=-1)
    points -= points.mean(axis=1, keepdims=True)
    normals = np.linalg.svd(points, full_matrices=False)[2][:, 2]
    normals *= np.sign(normals[:, 2:])
    # 95 % of a circular Gaussian tilt lie within 2.448 sigma.
    tilt = rng.normal(0, np.radians(sizes.registration_deg) / 2.448, (runs, 2))
    off = normals[:, :2] / normals[:, 2:] + tilt
    return np.degrees(np.arctan(np.hypot(*off.T)))


@pytest.mark.parametrize("registration", first_in_default_tier([0.0, 3.0], 2))
@pytest.mark.parametrize(
    ("noise", "times"), first_in_default_tier([(0.1, 12), (0.15, 12), (0.15, 20), (0.4, 30)], 2)
)
def test_95_percent_of_noisy_planes_are_within_expected_error(noise, registration, times):
    """Noise so large that it, not the resolution, decides."""
    sizes = PlaneSizes(RESOLUTION, noise, registration)
    size = times * RESOLUTION
    within = (simulated(sizes, size) <= sizes.error_deg(size)).mean()
    assert 0.93 < within < 0.975


def test_expected_error_for_many_points_matches_closed_form():
    """sqrt(-2 ln 0.05) sigma over the square root of n, over a quarter of the diameter; more where
    the disc is as thick as wide (Creasy 1956)."""
    sizes = PlaneSizes(RESOLUTION, 20.0)
    size = 1000 * RESOLUTION
    count = math.pi / 4 * 1000.0**2
    slope = math.sqrt(-2 * math.log(0.05)) * 20.0 / math.sqrt(count) / (size / 4)
    expected = math.degrees(slope / (1 - (20.0 / (size / 4)) ** 2))
    assert sizes.error_deg(size) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("noise", [0.1, 0.6, 4.0, 40.0])
def test_expected_error_matches_confidence_region_of_plane(noise):
    sizes, size = PlaneSizes(RESOLUTION, noise), 60 * RESOLUTION
    values = np.array([[(size / 4) ** 2, (size / 4) ** 2, noise**2]])
    quantile = joint_quantile(np.array([math.pi / 4 * 60.0**2 - 3]))
    axis = np.degrees(confidence_axes_rad(values, quantile, quantile)[0][0])
    tilt = math.degrees(math.atan(0.5 / (60 * math.sqrt(12) / 4)))
    assert sizes.error_deg(size) == pytest.approx(max(axis if noise < 1.5 else 90.0, tilt))


def test_without_noise_resolution_limits_the_error():
    sizes = PlaneSizes(RESOLUTION, 0.0)
    # Half of the resolution over the width of a strip with the variance of the disc.
    expected = math.degrees(math.atan(0.5 / (100 * math.sqrt(12) / 4)))
    assert sizes.error_deg(100 * RESOLUTION) == pytest.approx(expected)
    assert sizes.error_deg(9.9 * RESOLUTION) is None


def test_expected_error_matches_fits_of_noisy_discs():
    """The verdict's own figure for a disc of points with this noise."""
    rng = np.random.default_rng(4)
    sizes, size = PlaneSizes(RESOLUTION, 0.3), 3.0
    found = []
    for _ in range(60):
        count = round(math.pi / 4 * 30**2)
        turn, radius = rng.uniform(0, 2 * np.pi, count), size / 2 * np.sqrt(rng.random(count))
        points = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=-1)
        points = np.column_stack([points, rng.normal(0, sizes.noise, count)])
        found.append(fit_plane(points, is_ordered=False).max_confidence95_deg)
    # The larger of the two axes of an ellipse that is round but for chance,
    # which makes it longer by some percent.
    assert np.median(found) == pytest.approx(sizes.error_deg(size), rel=0.15)


def test_error_falls_with_size_and_rises_with_resolution_and_noise():
    plain = PlaneSizes.from_pixel_size(0.013)
    errors = [plane.error95_deg for plane in plain.curve()]
    assert errors == sorted(errors, reverse=True)
    for worse in (
        PlaneSizes(2 * plain.resolution, plain.noise),
        PlaneSizes(plain.resolution, 500 * plain.noise),
        PlaneSizes(plain.resolution, plain.noise, 1.0),
    ):
        assert worse.error_deg(13.0) > plain.error_deg(13.0)


def test_the_textbooks_limit_of_a_thousand_pixels_is_on_the_curve():
    sizes = PlaneSizes.from_pixel_size(0.013)
    assert sizes.textbook == pytest.approx(13.0)
    assert any(plane.size_m == pytest.approx(sizes.textbook) for plane in sizes.curve())
    # A metre and a half is known far better than a geologist's compass tells it.
    assert sizes.size_for_error(5.0) < 1.5
    assert sizes.error_deg(13.0) < 0.5


@pytest.mark.parametrize("registration", [0.0, 1.0, 4.9])
@pytest.mark.parametrize("noise", [0.01, 0.5, 3.0])
def test_the_size_for_an_error_has_that_error(noise, registration):
    sizes = PlaneSizes(RESOLUTION, noise, registration)
    size = sizes.size_for_error(5.0)
    assert sizes.error_deg(size) <= 5.0 + 1e-6
    assert size == pytest.approx(sizes.min_size) or sizes.error_deg(0.99 * size) > 5.0


def test_plane_error_is_never_below_registration_error():
    assert PlaneSizes(RESOLUTION, 0.01, 7.0).size_for_error(5.0) is None
    assert PlaneSizes(RESOLUTION, 0.01, 7.0).error_deg(1e6) == pytest.approx(7.0, abs=1e-3)
