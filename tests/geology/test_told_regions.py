"""Regions that are told of few, uneven or weighted orientations hold as often as they say, and are
not told where they could not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.geology.samples import bingham_sample
from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import lines_to_vectors
from vomstudio.geology.populations import distributions
from vomstudio.geology.populations.distributions import axes_confidence
from vomstudio.geology.populations.error_weights import (
    JOINT_QUANTILE95,
    OrientationErrors,
    weights_by_error,
)
from vomstudio.geology.populations.set_statistics import set_statistics
from vomstudio.geology.statistics import fisher, orientation_tensor

TRUTH = np.array([0.6, 0.0, -0.8])


def _errors(own: np.ndarray) -> OrientationErrors:
    return OrientationErrors(np.degrees(own) * JOINT_QUANTILE95, "total95_deg")


@pytest.mark.parametrize("natural", first_in_default_tier([0.0, 2.0, 5.0], 1))
@pytest.mark.parametrize("n", first_in_default_tier([2, 3, 4, 5, 8], 1))
def test_weighted_means_of_few_planes_have_calibrated_cones_or_none(n: int, natural: float) -> None:
    """Errors of half a degree and of ten, with and without a scatter by nature, which so few do not
    always show."""
    rng = np.random.default_rng([n, int(natural)])
    held = told = 0
    for _ in range(400):
        own = np.radians(rng.choice([0.5, 10.0], n))
        stray = np.hypot(own, math.radians(natural))
        v = TRUTH + stray[:, None] * rng.normal(size=(n, 3))
        v /= np.linalg.norm(v, axis=1)[:, None]
        weights, _ = weights_by_error(v, _errors(own))
        found = fisher(v, False, weights)
        if found.alpha95_deg is None:
            continue
        told += 1
        off = math.degrees(math.acos(min(abs(float(found.mean.vector() @ TRUTH)), 1.0)))
        held += off <= found.alpha95_deg
    # Three standard deviations of chance below 95 %, and of what is left over.
    assert told >= 0.25 * 400
    assert held / told >= 0.93 - 3.0 * math.sqrt(0.05 * 0.95 / told)


def test_mean_dominated_by_few_planes_has_reason_instead_of_cone() -> None:
    own = np.radians([0.5, 10.0, 10.0, 10.0, 10.0])
    v = TRUTH + own[:, None] * np.random.default_rng(3).normal(size=(5, 3))
    found = set_statistics(v, errors=_errors(own))
    assert found.fisher is not None
    assert found.fisher.alpha95_deg is None
    assert found.fisher_reason is not None
    assert found.fisher_reason.code == "fisher.few-decide"
    assert found.fisher_reason.values["n"] == 5
    assert found.fisher_reason.values["worth"] == pytest.approx(2.13, abs=0.01)
    assert set_statistics(v, "lines", errors=_errors(own)).fisher_reason == found.fisher_reason
    # Alike, all count, and nothing changes.
    alike = np.radians(np.full(5, 2.0))
    weighted = set_statistics(v, errors=_errors(alike)).fisher
    plain = set_statistics(v).fisher
    assert weighted is not None
    assert plain is not None
    assert weighted.alpha95_deg == pytest.approx(plain.alpha95_deg)


def test_fewer_than_12_directions_have_no_kent_distribution() -> None:
    """So few show that they are elongated where they happen to lie in a line, and their region is
    then too narrow across it."""
    rng = np.random.default_rng(4)
    for n in (5, 8, 11):
        v = np.column_stack([np.ones(n), rng.normal(0, 0.2, n), rng.normal(0, 0.005, n)])
        found = set_statistics(v)
        assert found.kent is None
        assert found.kent_reason == Finding("kent.too-few", n=n, minimum=12)


@pytest.mark.full
def test_kent_region_is_calibrated_at_minimum_sample_size() -> None:
    rng = np.random.default_rng(5)
    held = told = 0
    for _ in range(300):
        v = np.column_stack([np.ones(12), rng.normal(0, 0.3, 12), rng.normal(0, 0.1, 12)])
        kent = set_statistics(v).kent
        if kent is None:
            continue
        told += 1
        mean = lines_to_vectors(kent.trend_deg, kent.plunge_deg)
        major = lines_to_vectors(kent.major.trend_deg, kent.major.plunge_deg)
        truth = np.array([1.0, 0, 0]) * np.sign(mean[0])
        tilt = np.degrees([math.asin(truth @ major), math.asin(truth @ np.cross(mean, major))])
        reach = [kent.max_confidence95_deg, kent.min_confidence95_deg]
        held += float(np.sum((tilt / reach) ** 2)) <= 1.0
    assert told >= 0.6 * 300
    assert held >= 0.91 * told


def test_axis_region_uses_sine_of_the_half_angle() -> None:
    """Anderson's (1963) region of a principal axis is an ellipse of the sines of the angles to the
    others: of a round tensor's first axis (a cluster, variances s along both) with F in place of
    chi-square sin(reach)^2 = 2 F s^2 / n, where its tangent would fall short."""
    n, s = 12, 0.35
    turn = 2.0 * np.pi * np.arange(n) / n
    v = np.column_stack(
        [np.full(n, math.cos(s)), math.sin(s) * np.cos(turn), math.sin(s) * np.sin(turn)]
    )
    values, axes = orientation_tensor(v)
    region = axes_confidence(v, values, axes)[0]
    assert region is not None
    # Of the cone exactly: each pull is sin s cos s / (cos^2 s - sin^2 s / 2), of a half of them
    # squared; shares of the jackknife as documented.
    apart = math.cos(s) ** 2 - math.sin(s) ** 2 / 2.0
    share = (math.cos(s) ** 2 - math.sin(s) ** 2 * np.cos(turn) ** 2) / apart / n
    pull = math.sin(s) * math.cos(s) * np.cos(turn) / apart / (1.0 - share)
    free = n - 2.0
    f95 = free / 2.0 * math.expm1(2.0 / free * math.log(20.0))
    reach = math.sqrt(2.0 * f95 * float(pull @ pull) / n**2)
    assert math.sin(math.radians(region.max_deg)) == pytest.approx(reach, rel=1e-9)


def test_axis_unconstrained_in_one_direction_has_90_degree_half_angle() -> None:
    """Where the sine reaches one; the tangent said 45 degrees there."""
    # Half-angles by the closed form, F(2, 3) being 3/2 (20^(2/3) - 1).
    f95 = 1.5 * (20.0 ** (2.0 / 3.0) - 1.0)
    covariance = np.diag([0.25, 1.0]) / (2.0 * f95)
    region = distributions._build_axis_confidence(covariance, np.eye(3)[:2], 3.0)
    assert region is not None
    assert region.max_deg == pytest.approx(90.0)
    assert region.min_deg == pytest.approx(30.0)


def test_bingham_has_no_regions_of_weighted_axes() -> None:
    """His are those of axes that all stray alike; those free of a model stand in for them."""
    rng = np.random.default_rng(7)
    v = bingham_sample(rng, 30, -30.0, -3.0)
    errors = OrientationErrors(rng.uniform(1.0, 20.0, 30), "total95_deg")
    found = set_statistics(v, errors=errors)
    assert found.bingham is not None
    assert found.bingham.confidence95 == (None, None, None)
    assert found.tensor.confidence95[2] is not None
