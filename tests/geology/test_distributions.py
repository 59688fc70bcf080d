"""Bingham's and Kent's distributions, tests and confidence, against closed forms and published
figures, and by simulation where a level is promised."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import gammaln, hyp1f1, ive
from scipy.stats import f as f_distribution

from tests.geology.samples import bingham_sample, fisher_sample
from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import UsageError
from vomstudio.geology.orientation import Line, lines_to_vectors, planes_to_poles
from vomstudio.geology.populations import distributions
from vomstudio.geology.populations.distributions import (
    AxisConfidence,
    LineAttitude,
    assess_uniformity,
)
from vomstudio.geology.populations.error_weights import ERROR_COLUMNS, OrientationErrors
from vomstudio.geology.populations.set_statistics import SetStatistics, set_statistics
from vomstudio.geology.populations.sphere_models import (
    bingham_nodes,
    estimate_bingham,
    kent_concentrations,
    kent_nodes,
)


@pytest.mark.parametrize("k", [-0.1, -1.0, -10.0, -100.0])
def test_bingham_constant_matches_watson_for_symmetric_case(k: float) -> None:
    # A round cluster, and a round girdle: 4 pi 1F1(1/2; 3/2; .) (Mardia & Jupp 2000, 9.4.2).
    cluster = bingham_nodes(k, k).log_constant
    assert cluster == pytest.approx(math.log(4 * math.pi * hyp1f1(0.5, 1.5, -k)) + k, abs=1e-6)
    girdle = bingham_nodes(k, 0.0).log_constant
    assert girdle == pytest.approx(math.log(4 * math.pi * hyp1f1(0.5, 1.5, k)), abs=1e-6)


def test_bingham_constant_and_moments_match_numerical_integration() -> None:
    k1, k2 = -7.0, -2.0

    def density(turn: float, x: float) -> float:
        flat = 1 - x * x
        return math.exp(k1 * x * x + k2 * flat * math.sin(turn) ** 2)

    total, _ = dblquad(density, -1, 1, 0, 2 * math.pi)
    moment, _ = dblquad(lambda t, x: x * x * density(t, x), -1, 1, 0, 2 * math.pi)
    nodes = bingham_nodes(k1, k2)
    assert nodes.log_constant == pytest.approx(math.log(total), abs=1e-9)
    assert float(nodes.mean(nodes.positions[:, 2] ** 2)) == pytest.approx(moment / total, abs=1e-9)


@pytest.mark.parametrize(
    "eigenvalues",
    [
        (0.5901, 0.3525, 0.0573),
        (0.98, 0.012, 0.008),
        (0.5, 0.499, 0.001),
        (0.6, 0.2, 0.2),
        (0.34, 0.33, 0.33),
        (1 - 1e-6, 6e-7, 4e-7),
    ],
)
def test_bingham_fit_reproduces_moments_of_data(eigenvalues: tuple[float, ...]) -> None:
    model = estimate_bingham(eigenvalues)
    assert model is not None
    assert model.k1 <= model.k2 <= 0
    found = model.nodes.mean(model.nodes.positions**2)
    total = sum(eigenvalues)
    np.testing.assert_allclose(found, np.array(eigenvalues) / total, atol=1e-4 * eigenvalues[2])


def test_concentrated_bingham_approaches_bivariate_normal() -> None:
    # In a narrow cluster the coordinates across are normal with the variances -1 / (2 k).
    model = estimate_bingham((1 - 3e-6, 2e-6, 1e-6))
    assert model is not None
    assert model.k1 == pytest.approx(-0.5e6, rel=1e-4)
    assert model.k2 == pytest.approx(-0.25e6, rel=1e-4)


@pytest.mark.parametrize(("kappa", "beta"), [(8.0, 1.0), (42.16, 9.27), (100.0, 49.0), (1e4, 1e3)])
def test_kent_constant_matches_series(kappa: float, beta: float) -> None:
    # Kent (1982), equation 2.3.
    j = np.arange(300)
    terms = gammaln(j + 0.5) - gammaln(j + 1) + 2 * j * math.log(beta)
    terms += -(2 * j + 0.5) * math.log(kappa / 2)
    with np.errstate(divide="ignore"):
        terms += np.log(ive(2 * j + 0.5, kappa))
    series = math.log(2 * math.pi) + kappa + math.log(float(np.exp(terms).sum()))
    assert kent_nodes(kappa, beta).log_constant == pytest.approx(series, abs=2e-7)


@pytest.mark.parametrize(("kappa", "beta"), [(42.0, 9.3), (20.0, 2.0), (80.0, 35.0)])
def test_kent_fit_matches_series(kappa: float, beta: float) -> None:
    # By maximum likelihood the mean resultant and the difference of the mean squares are the
    # derivatives of the logarithm of the constant: here of Kent's (1982) series, by differences.
    def series(k: float, b: float) -> float:
        j = np.arange(300)
        terms = gammaln(j + 0.5) - gammaln(j + 1) + 2 * j * math.log(b)
        terms += -(2 * j + 0.5) * math.log(k / 2)
        with np.errstate(divide="ignore"):
            terms += np.log(ive(2 * j + 0.5, k))
        return k + math.log(float(np.exp(terms).sum()))

    step = 1e-4
    resultant = (series(kappa + step, beta) - series(kappa - step, beta)) / (2 * step)
    longer = (series(kappa, beta + step) - series(kappa, beta - step)) / (2 * step)
    found = kent_concentrations(resultant, longer)
    assert found is not None
    assert found[0] == pytest.approx(kappa, rel=1e-4)
    assert found[1] == pytest.approx(beta, rel=1e-3)


BINGHAM_TABLE = (
    (0.02, 0.02, -25.55, -25.55),
    (0.02, 0.06, -25.58, -8.996),
    (0.06, 0.06, -9.043, -9.043),
    (0.04, 0.08, -13.16, -6.999),
    (0.08, 0.10, -7.042, -5.798),
    (0.12, 0.14, -4.896, -4.258),
    (0.02, 0.16, -25.65, -3.796),
    (0.18, 0.18, -3.160, -3.160),
    (0.10, 0.22, -5.658, -2.609),
    (0.16, 0.22, -3.518, -2.470),
    (0.22, 0.26, -2.146, -1.661),
    (0.28, 0.28, -1.106, -1.106),
    (0.14, 0.30, -3.842, -1.417),
    (0.28, 0.32, -0.891, -0.541),
    (0.24, 0.36, -1.322, -0.249),
    (0.06, 0.38, -8.670, -0.824),
    (0.04, 0.40, -12.80, -0.702),
    (0.14, 0.42, -3.349, -0.104),
    (0.10, 0.44, -4.955, -0.097),
    (0.02, 0.46, -25.12, -0.250),
)
"""S3, S2, k1, k2 of Mardia & Zemroch (1977, Journal of Statistical Computation and Simulation 6,
29-34), as Onstott (1980, Journal of Geophysical Research 85, 1500-1510) and PmagPy print them."""


@pytest.mark.parametrize(("s3", "s2", "k1", "k2"), BINGHAM_TABLE)
def test_bingham_concentrations_match_published_table(
    s3: float, s2: float, k1: float, k2: float
) -> None:
    found = estimate_bingham((1.0 - s2 - s3, s2, s3))
    assert found is not None
    digits = 0.0051 if abs(k1) > 10 else 0.00051
    assert found.k1 == pytest.approx(k1, abs=digits)
    assert found.k2 == pytest.approx(k2, abs=0.0051 if abs(k2) > 10 else 0.00051)


KENT_EXAMPLE = (
    "358.3 58.6 357.9 42.7 294.5 -11.4 345.2 53.3 16.9 61.2 8.1 37.3 32.5 51.5 349.6 70.2 345.8 64 "
    "352.9 66.3 351 63 349.2 65.6 10.6 55.7 11.5 26.6 14.8 60.9 358.8 66.4 4.4 27.7 350.1 74.7 "
    "17.9 75.9 15.4 35.2"
)
"""PmagPy's example of Kent's statistics (gokent): declination and inclination of 20 directions. It
gives the mean 359.2/55.0 and the 95 % ellipse 9.3 degrees toward 147.7/30.8 by 7.8 degrees."""


def test_kent_ellipse_matches_published_example(monkeypatch: pytest.MonkeyPatch) -> None:
    # The cluster is as good as round, for which Kent's ellipse is not told otherwise.
    monkeypatch.setattr(distributions, "ELONGATION_SIGNIFICANCE", 1.0)
    v = lines_to_vectors(*np.array(KENT_EXAMPLE.split(), float).reshape(-1, 2).T)
    found, _ = distributions.fit_kent(v, True)
    assert found is not None
    assert (found.trend_deg, found.plunge_deg) == (
        pytest.approx(359.15, abs=0.01),
        pytest.approx(55.03, abs=0.01),
    )
    assert (found.major.trend_deg, found.major.plunge_deg) == (
        pytest.approx(147.70, abs=0.01),
        pytest.approx(30.82, abs=0.01),
    )
    # There by chi-square, here by F, which is wider for 20: sin^2 = squares 2 F / (n - 2) in place
    # of -2 ln 0.05 / n.
    n = 20
    expand = math.sqrt(2 * f_distribution.ppf(0.95, 2, n - 2) / (n - 2) / (-2 * math.log(0.05) / n))
    for angle, theirs in (
        (found.max_confidence95_deg, 9.3047),
        (found.min_confidence95_deg, 7.8052),
    ):
        sine = math.sin(math.radians(theirs)) * expand
        assert angle == pytest.approx(math.degrees(math.asin(sine)), abs=0.002)


def test_round_clusters_are_called_elongated_one_time_in_twenty() -> None:
    rng = np.random.default_rng(12)
    elongated = 0
    for _ in range(300):
        found, _ = distributions.fit_kent(fisher_sample(rng, 60, 30.0), True)
        elongated += found is not None
    # 15 expected, and within three standard deviations of that.
    assert 4 <= elongated <= 27


def test_bingham_fit_of_girdle_is_accepted() -> None:
    rng = np.random.default_rng(3)
    found = set_statistics(bingham_sample(rng, 400, -30.0, -1.0)).bingham
    assert found is not None
    assert found.k1 == pytest.approx(-30, rel=0.2)
    assert found.k2 == pytest.approx(-1, abs=0.6)
    assert found.fit_p is not None
    assert found.fit_p > 0.001


def test_bingham_fit_of_two_limbs_is_rejected() -> None:
    rng = np.random.default_rng(4)
    limbs = np.vstack([fisher_sample(rng, 60, 80, planes_to_poles(d, 50)) for d in (90, 270)])
    found = set_statistics(limbs).bingham
    assert found is not None
    assert found.fit_p is not None
    assert found.fit_p < 1e-4


def test_elongated_cluster_fits_kent_but_not_fisher() -> None:
    rng = np.random.default_rng(5)
    flat = rng.normal(size=(200, 2)) * np.radians([12.0, 4.0])
    v = np.column_stack([flat, -np.ones(200)])
    found = set_statistics(v)
    assert found.fisher is not None
    assert found.fisher.fit_p is not None
    assert found.fisher.fit_p < 1e-4
    kent = found.kent
    assert kent is not None
    assert kent.elongated_p < 1e-6
    assert kent.major.plunge_deg < 5
    assert abs(kent.major.trend_deg % 180 - 90) < 5
    # The ellipse of the mean: sigma sqrt(2 F / n) along and across, here 12 and 4 degrees.
    scale = math.sqrt(2 * 3.0 / 200)
    assert kent.max_confidence95_deg == pytest.approx(12 * scale, rel=0.15)
    assert kent.min_confidence95_deg == pytest.approx(4 * scale, rel=0.15)


def test_round_cluster_has_no_kent_fit_with_reason() -> None:
    found = set_statistics(fisher_sample(np.random.default_rng(6), 60, 40))
    assert found.kent is None
    assert found.kent_reason is not None
    assert found.kent_reason.code == "kent.round"
    assert found.kent_reason.values["p"] > 0.05


def test_uniformity_test_matches_closed_forms() -> None:
    # Six directions along the axes: nothing is preferred, both statistics are 0.
    cross = np.vstack([np.eye(3), -np.eye(3)])
    assert assess_uniformity(cross, True).statistic == pytest.approx(0)
    assert assess_uniformity(cross, False).statistic == pytest.approx(0)
    assert assess_uniformity(cross, False).p == pytest.approx(1)
    # All alike: Rayleigh's 3 n with its correction, 3 n - 3 / 2 + 9 n / 10.
    same = np.tile([0, 0, -1.0], (10, 1))
    assert assess_uniformity(same, True).statistic == pytest.approx(30 - 1.5 + 9)
    assert assess_uniformity(same[:4], True).p is None


@pytest.mark.parametrize("n", [5, 10, 50])
def test_uniformity_is_rejected_at_nominal_rate(n: int) -> None:
    rng = np.random.default_rng(7)
    v = rng.normal(size=(2000, n, 3))
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    for directed in (True, False):
        p = np.array([assess_uniformity(each, directed).p for each in v])
        # Bingham's is a little shy of so few.
        assert 0.025 < np.mean(p < 0.05) < 0.065


def _holds(found: SetStatistics, truth: np.ndarray) -> tuple[bool, bool]:
    axis = found.tensor.axes[2]
    beta = Line(axis.trend_deg, axis.plunge_deg).vector()
    truth = truth * np.sign(truth @ beta)
    held = []
    assert found.bingham is not None
    for region in (found.tensor.confidence95[2], found.bingham.confidence95[2]):
        assert region is not None
        major = Line(region.toward.trend_deg, region.toward.plunge_deg).vector()
        u = math.degrees(math.atan2(truth @ major, truth @ beta))
        w = math.degrees(math.atan2(truth @ np.cross(beta, major), truth @ beta))
        held.append((u / region.max_deg) ** 2 + (w / region.min_deg) ** 2 <= 1)
    return held[0], held[1]


@pytest.mark.slow
@pytest.mark.parametrize(("n", "k1", "k2"), [(20, -20, -3), (50, -20, -3), (100, -5, -1)])
def test_axis_regions_contain_truth_at_stated_rate(n: int, k1: float, k2: float) -> None:
    rng = np.random.default_rng(8)
    found = [set_statistics(bingham_sample(rng, n, k1, k2)) for _ in range(600)]
    told = [each for each in found if each.tensor.confidence95[2] is not None]
    assert len(told) >= 0.9 * len(found)
    free, modelled = np.mean([_holds(each, np.array([1.0, 0, 0])) for each in told], axis=0)
    assert 0.90 < free < 0.98
    assert 0.92 < modelled < 0.99


@pytest.mark.slow
@pytest.mark.parametrize(("n", "kappa"), [(20, 10), (50, 30), (100, 300)])
def test_true_model_is_rejected_at_nominal_rate(n: int, kappa: float) -> None:
    rng = np.random.default_rng(9)
    fishers, kents = [], []
    for _ in range(600):
        found = set_statistics(fisher_sample(rng, n, kappa), "lines", is_directed=True)
        assert found.fisher is not None
        fishers.append(found.fisher.fit_p)
        kents.append(found.kent is not None)
    assert 0.01 < np.mean(np.array(fishers) < 0.05) < 0.08
    assert 0.02 < np.mean(kents) < 0.08


def test_precise_plane_has_more_weight_than_uncertain_one() -> None:
    # Two exact readings about 040/30 and two poor ones 20 degrees off: the mean stays near.
    v = planes_to_poles([40, 41, 60, 62], [30, 31, 30, 31])
    errors = OrientationErrors(np.array([0.5, 0.5, 40.0, 40.0]), "total95_deg")
    alike = set_statistics(v)
    found = set_statistics(v, errors=errors)
    assert alike.fisher is not None
    assert found.fisher is not None
    assert abs((alike.fisher.trend_deg - 180) - 50.7) < 1
    assert abs((found.fisher.trend_deg - 180) - 40.5) < 2
    assert found.weights is not None
    assert 1.9 < found.weights.effective_n < 2.3
    assert found.weights.without_error == 0


def test_natural_scatter_limits_weight_of_most_precise_plane() -> None:
    # Errors of 0.1 and 3 degrees, but the planes differ by 10 by nature: all count nearly alike.
    rng = np.random.default_rng(10)
    v = fisher_sample(rng, 200, 1 / math.radians(10) ** 2)
    errors = OrientationErrors(np.where(np.arange(200) == 0, 0.1, 3.0), "total95_deg")
    found = set_statistics(v, errors=errors).weights
    assert found is not None
    assert found.natural_scatter_deg == pytest.approx(10, rel=0.1)
    assert found.effective_n > 199


def test_rotating_data_rotates_the_statistics() -> None:
    rng = np.random.default_rng(11)
    azimuth, dip = rng.normal(120, 15, 40), rng.normal(40, 5, 40)
    a = set_statistics(planes_to_poles(azimuth, dip))
    b = set_statistics(planes_to_poles(azimuth + 30, dip))
    assert a.bingham is not None
    assert b.bingham is not None
    assert b.bingham.k1 == pytest.approx(a.bingham.k1)
    assert a.kent is not None
    assert b.kent is not None
    assert (b.kent.trend_deg - a.kent.trend_deg) % 360 == pytest.approx(30)
    assert (b.kent.major.trend_deg - a.kent.major.trend_deg) % 180 == pytest.approx(30)
    assert b.kent.max_confidence95_deg == pytest.approx(a.kent.max_confidence95_deg)
    toward = [s.tensor.confidence95[0] for s in (a, b)]
    assert toward[0] is not None
    assert toward[1] is not None
    assert (toward[1].toward.trend_deg - toward[0].toward.trend_deg) % 180 == pytest.approx(30)


@pytest.mark.parametrize(
    "v",
    [
        planes_to_poles([90], [30]),
        planes_to_poles([90, 90], [30, 30]),
        planes_to_poles([90] * 30, [30] * 30),
        planes_to_poles([90, 270] * 15, np.linspace(0, 80, 30)),
        planes_to_poles(np.linspace(0, 350, 36), [90] * 36),
        np.eye(3),
        planes_to_poles([90, 90 + 1e-7, 90], [30, 30, 30 + 1e-7]),
    ],
    ids=["one", "two parallel", "all parallel", "in one plane", "vertical", "three", "nearly"],
)
@pytest.mark.parametrize("directed", [True, False])
def test_undefined_values_are_null_with_a_reason(v: np.ndarray, directed: bool) -> None:
    found = set_statistics(v, "lines" if directed else "poles", directed)
    json.dumps(found.to_dict(), allow_nan=False)
    assert (found.bingham is None) == (found.bingham_reason is not None)
    assert (found.kent is None) == (found.kent_reason is not None)


def test_weights_without_errors_are_refused() -> None:
    from vomstudio.geology.populations.statistics_options import StatisticsOptions
    from vomstudio.geology.populations.table_statistics import table_statistics
    from vomstudio.io.text.orientation_reading import extract_orientations
    from vomstudio.io.text.tables import table_from_cells

    table = extract_orientations(
        table_from_cells(["dipdir", "dip"], [["10", "20"], ["30", "40"]], Path("t.csv"))
    )
    with refused("table.no-errors", UsageError, columns=ERROR_COLUMNS, field="--weights"):
        table_statistics(table, StatisticsOptions(weights="error"))


@pytest.mark.full
@pytest.mark.parametrize("n", first_in_default_tier([5, 7], 1))
def test_girdle_axis_region_of_few_poles_contains_truth_at_stated_rate(n: int) -> None:
    rng = np.random.default_rng(n)
    held = told = 0
    for _ in range(300):
        t = np.radians(rng.uniform(-50, 50, n))
        v = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1) + np.radians(5) * rng.normal(
            size=(n, 3)
        )
        tensor = set_statistics(v).tensor
        if tensor.confidence95[2] is not None:
            told += 1
            held += _region_holds(tensor.axes[2], tensor.confidence95[2], np.array([0.0, 0.0, 1.0]))
    assert told >= {5: 0.75, 7: 0.95}[n] * 300
    assert 0.91 * told <= held <= 0.98 * told


@pytest.mark.full
@pytest.mark.parametrize("n", first_in_default_tier([6, 10, 30, 100], 1))
def test_axes_undetermined_within_a_plane_have_no_region(n: int) -> None:
    """Round clusters and even girdles: no more are told than chance lets differ (5 %)."""
    rng = np.random.default_rng(n)
    of_cluster = of_girdle = 0
    for _ in range(200):
        stray = rng.normal(0, 0.2, (n, 2))
        round_ = np.column_stack([np.ones(n), stray])
        turn = rng.uniform(0, np.pi, n)
        girdle = np.column_stack([np.cos(turn), np.sin(turn), rng.normal(0, 0.05, n)])
        first, second, third = set_statistics(round_).tensor.confidence95
        assert first is not None or n < 10
        of_cluster += second is not None or third is not None
        first, second, third = set_statistics(girdle).tensor.confidence95
        assert third is not None
        of_girdle += first is not None or second is not None
    assert of_cluster <= 0.1 * 200
    assert of_girdle <= 0.1 * 200


@pytest.mark.full
@pytest.mark.parametrize("n", [30, 100])
def test_axis_regions_of_elongated_cluster_contain_truth(n: int) -> None:
    rng = np.random.default_rng(n)
    held = told = 0
    for _ in range(200):
        v = np.column_stack([np.ones(n), rng.normal(0, 0.3, n), rng.normal(0, 0.12, n)])
        tensor = set_statistics(v).tensor
        if tensor.confidence95[1] is not None:
            told += 1
            held += _region_holds(tensor.axes[1], tensor.confidence95[1], np.array([0.0, 1.0, 0.0]))
    assert told >= 0.95 * 200
    assert 0.9 * told <= held <= 0.98 * told


@pytest.mark.full
@pytest.mark.parametrize("n", [5, 10])
def test_regions_of_error_weighted_means_contain_truth_at_stated_rate(n: int) -> None:
    """Errors of 0.5 to 10 degrees: neither all held, as if few counted, nor too seldom."""
    rng = np.random.default_rng(n)
    truth = np.array([0.6, 0.0, -0.8])
    fisher = first = told = 0
    for _ in range(300):
        own = np.radians(rng.choice([0.5, 1, 2, 5, 10], n))
        v = truth + own[:, None] * rng.normal(size=(n, 3))
        found = set_statistics(v, errors=OrientationErrors(np.degrees(own) * 2.4477, "total95_deg"))
        first += _region_holds(found.tensor.axes[0], found.tensor.confidence95[0], truth)
        if found.fisher is not None and found.fisher.alpha95_deg is not None:
            told += 1
            mean = lines_to_vectors(found.fisher.trend_deg, found.fisher.plunge_deg)
            off = np.degrees(np.arccos(min(abs(float(mean @ truth)), 1.0)))
            fisher += off <= found.fisher.alpha95_deg
    assert 0.9 * told <= fisher <= 0.985 * told
    assert first >= 0.93 * 300


def _region_holds(axis: LineAttitude, region: AxisConfidence | None, truth: np.ndarray) -> bool:
    assert region is not None
    a = lines_to_vectors(axis.trend_deg, axis.plunge_deg)
    major = lines_to_vectors(region.toward.trend_deg, region.toward.plunge_deg)
    minor = np.cross(a, major)
    to = truth if truth @ a > 0 else -truth
    tilt = np.degrees(np.arctan2([to @ major, to @ minor], to @ a))
    return bool(np.sum((tilt / [region.max_deg, region.min_deg]) ** 2) <= 1.0)
