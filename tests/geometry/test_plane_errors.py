"""The two angular errors of a plane: laws, a second implementation of their quantiles, coverage."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geometry import residual_correlation
from vomstudio.geometry.plane_errors import component_errors_rad, joint_quantile
from vomstudio.geometry.planes import fit_plane, fit_planes
from vomstudio.geometry.vectors import strike_and_dip_lines

UP = np.array([0.0, 0.0, 1.0])


def _simulation() -> ModuleType:
    """The benchmark that prints the table of the documentation."""
    path = Path(__file__).resolve().parents[1] / "benchmarks" / "bench_coverage.py"
    spec = importlib.util.spec_from_file_location("coverage_simulation", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["coverage_simulation"] = module
    spec.loader.exec_module(module)
    return module


SIMULATION = _simulation()
Case = SIMULATION.Case
REPEATS = 4000
# Three standard deviations of a share near 0.95 counted in that many repeats.
LUCK = 3.0 * np.sqrt(0.95 * 0.05 / REPEATS)


def test_the_closed_form_of_fishers_quantile_agrees_with_scipy() -> None:
    from scipy.special import fdtri

    dof = np.array([1.0, 2.0, 3.0, 7.5, 30.0, 1000.0])
    assert np.allclose(joint_quantile(dof), 2.0 * fdtri(2.0, dof, 0.95) / dof, rtol=1e-9)


@pytest.mark.parametrize("shape", first_in_default_tier(["arc", "straight"]))
@pytest.mark.parametrize("n", first_in_default_tier([4, 5, 6, 10, 30, 100]))
@pytest.mark.parametrize("isotropic", first_in_default_tier([False, True]))
def test_white_noise_is_covered_as_often_as_stated(shape: str, n: int, isotropic: bool) -> None:
    cover, *_ = SIMULATION.simulate(Case(shape, n, isotropic=isotropic), REPEATS, 11)
    assert 0.93 - LUCK <= cover <= 0.97 + LUCK


@pytest.mark.parametrize("n", first_in_default_tier([30, 100]))
@pytest.mark.parametrize("noise", first_in_default_tier(["exponential", "gaussian2"]))
@pytest.mark.parametrize("length", first_in_default_tier([1 / 40, 1 / 20, 1 / 10]))
def test_short_roughness_keeps_coverage_at_acceptable_width(
    n: int, noise: str, length: float
) -> None:
    cover, _, ratio, _ = SIMULATION.simulate(Case("arc", n, noise, length), REPEATS, 12)
    assert cover >= 0.93 - LUCK
    assert ratio <= 1.5 * 1.06  # the median of so many repeats is good to a few per cent


@pytest.mark.parametrize("noise", first_in_default_tier(["exponential", "gaussian2"], 1))
def test_a_trace_of_a_thousand_points_is_covered_like_one_of_a_hundred(noise: str) -> None:
    repeats = 600
    luck = 3.0 * np.sqrt(0.95 * 0.05 / repeats)
    cover, _, ratio, _ = SIMULATION.simulate(Case("arc", 1000, noise, 0.1), repeats, 14)
    assert cover >= 0.93 - luck
    assert ratio <= 1.5 * 1.06


@pytest.mark.parametrize("spacing", ["uneven", "random"])
def test_uneven_spacing_keeps_coverage_for_white_and_rough_noise(spacing: str) -> None:
    cover, *_ = SIMULATION.simulate(Case("arc", 60, spacing=spacing), REPEATS, 15)
    assert 0.93 - LUCK <= cover <= 0.97 + LUCK
    cover, _, ratio, _ = SIMULATION.simulate(
        Case("arc", 60, "exponential", 0.1, spacing=spacing), REPEATS, 15
    )
    assert cover >= 0.92 - LUCK
    assert ratio <= 1.5 * 1.06


@pytest.mark.slow
def test_every_stated_row_of_the_coverage_table_is_met() -> None:
    repeats = 6000
    luck = 3.0 * np.sqrt(0.95 * 0.05 / repeats)
    for case in SIMULATION.cases():
        if case.spacing != "even" or case.sigma == SIMULATION.LARGE:
            continue
        cover, _, ratio, _ = SIMULATION.simulate(case, min(repeats, 3_000_000 // case.n), 13)
        if case.noise == "white":
            assert 0.93 - luck <= cover <= 0.97 + luck, case
        elif case.noise in ("exponential", "gaussian2") and case.length <= 0.1:
            # A wave or a ring of 30 points may fall short by a per cent.
            assert cover >= (0.93 if case.shape == "arc" else 0.92) - luck, case
            if case.shape == "arc":
                assert ratio <= 1.5 * 1.06, case


def test_ordering_hardly_widens_confidence_for_white_noise() -> None:
    rng = np.random.default_rng(3)
    t = np.linspace(-1.0, 1.0, 80)
    points = np.stack([5.0 * t, 2.0 * t * t, np.zeros(80)], axis=1)
    points = points + rng.normal(0.0, 0.02, (500, 80, 3))
    offsets = np.arange(501) * 80
    ordered = fit_planes(points.reshape(-1, 3), offsets)
    free = fit_planes(points.reshape(-1, 3), offsets, is_ordered=False)
    ratio = np.median(ordered.max_confidence95_deg / free.max_confidence95_deg)
    assert 1.0 <= ratio < 1.06
    assert not free.long_roughness.any()
    assert ordered.long_roughness.mean() < 0.02


def test_a_smooth_bend_of_the_surface_is_flagged_as_long_roughness() -> None:
    rng = np.random.default_rng(5)
    t = np.linspace(-1.0, 1.0, 100)
    z = 0.1 * np.sin(2.5 * np.pi * t + 0.3) + rng.normal(0.0, 0.003, 100)
    fit = fit_plane(np.stack([5.0 * t, 2.0 * t * t, z], axis=1))
    assert fit.long_roughness
    assert fit.n_effective is not None
    assert fit.n_effective < 15.0


def test_points_exactly_in_a_plane_are_not_called_rough() -> None:
    t = np.linspace(0.0, 1.0, 40)
    fit = fit_plane(np.stack([10.0 * t, 3.0 * t * t, np.zeros(40)], axis=1) + 5e6)
    assert not fit.long_roughness
    assert fit.max_confidence95_deg == 0.0


def test_confidence_shrinks_with_the_number_of_points_and_hyperbolic_errors_do_not() -> None:
    rng = np.random.default_rng(1)

    def fit(n: int) -> tuple[float, float]:
        flat = rng.uniform(-1.0, 1.0, (n, 2))
        f = fit_plane(
            np.concatenate([flat, rng.normal(0.0, 0.02, (n, 1))], axis=1), is_ordered=False
        )
        assert f.max_confidence95_deg is not None
        assert f.max_angular_error_deg is not None
        return f.max_confidence95_deg, f.max_angular_error_deg

    few, many = fit(100), fit(10_000)
    assert many[0] == pytest.approx(few[0] / 10.0, rel=0.2)
    # The angle of the scatter itself, atan(sigma of the noise / sigma of the spread).
    assert many[1] == pytest.approx(np.degrees(np.arctan(0.02 * np.sqrt(3.0))), rel=0.1)


def test_confidence_agrees_with_an_independent_f_test_on_its_boundary() -> None:
    """Regress the coordinate along the tilted normal on those across it: p is 5 % at the limit."""
    from scipy.special import fdtrc

    rng = np.random.default_rng(2)
    points = rng.normal(size=(12, 3)) * [3.0, 1.0, 0.1]
    fit = fit_plane(points, is_ordered=False)
    local = points - points.mean(axis=0)
    for angle, axis in (
        (fit.max_confidence95_deg, fit.axes[1]),
        (fit.min_confidence95_deg, fit.axes[0]),
    ):
        assert angle is not None
        a = np.radians(angle)
        normal = np.cos(a) * fit.normal + np.sin(a) * axis
        across = np.linalg.svd(normal[None, :])[2][1:]
        w, x = local @ normal, local @ across.T
        slopes, *_ = np.linalg.lstsq(x, w, rcond=None)
        left = ((w - x @ slopes) ** 2).sum()
        f = ((w @ w - left) / 2.0) / (left / (12 - 3))
        assert fdtrc(2, 9, f) == pytest.approx(0.05, rel=1e-6)


def _cone_normals(fit, share: float = 1.0) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Normals on the edge of the region."""
    s = np.linspace(0.0, 2.0 * np.pi, 20_001)[:, None]
    t1 = share * np.tan(np.radians(fit.min_confidence95_deg))
    t2 = share * np.tan(np.radians(fit.max_confidence95_deg))
    edge = fit.normal + t1 * np.cos(s) * fit.axes[0] + t2 * np.sin(s) * fit.axes[1]
    return edge / np.linalg.norm(edge, axis=1, keepdims=True)


@pytest.mark.parametrize("dip", [15.0, 45.0, 75.0, 89.0])
def test_dip_and_dip_direction_errors_are_the_extremes_of_the_region(dip: float) -> None:
    rng = np.random.default_rng(9)
    points = rng.normal(size=(30, 3)) * [3.0, 0.8, 0.05]
    a, b = np.radians(dip), np.radians(35.0)
    turn = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    spin = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    fit = fit_plane(points @ spin.T @ turn.T, is_ordered=False)
    edge = _cone_normals(fit)
    azimuth = np.degrees(np.arctan2(edge[:, 0], edge[:, 1]))
    assert fit.dip_direction_deg is not None
    difference = (azimuth - fit.dip_direction_deg + 180.0) % 360.0 - 180.0
    assert fit.dip_direction_error_deg == pytest.approx(np.abs(difference).max(), rel=1e-5)
    dips = np.degrees(np.arctan2(np.hypot(edge[:, 0], edge[:, 1]), edge[:, 2]))
    assert fit.dip_deg is not None
    # The region seen along the dip; the true extreme also feels the turn of the azimuth.
    assert fit.dip_error_deg == pytest.approx(np.abs(dips - fit.dip_deg).max(), rel=0.12)


def test_tilt_about_dip_line_changes_dip_direction_by_tilt_over_tan_dip() -> None:
    """A strike line tilted by t lets the dip direction turn by t / tan(dip)."""
    for dip in (5.0, 30.0, 60.0):
        dd, d = np.array([0.0]), np.array([dip])
        strike, down = strike_and_dip_lines(dd, d)
        small = np.array([1e-5])
        _, azimuth, rake = component_errors_rad(
            down, strike, dd, d, np.array([False]), small, np.array([0.0])
        )
        t = small / np.cos(np.radians(d))  # the normal leans by `small`, the strike line by this
        assert azimuth == pytest.approx(t / np.tan(np.radians(d)), rel=1e-6)
        assert rake == pytest.approx(0.0)


def test_a_plane_that_may_be_horizontal_has_no_dip_direction_error() -> None:
    rng = np.random.default_rng(4)
    points = rng.normal(size=(20, 3)) * [1.0, 1.0, 0.05] @ np.diag([1, 1, 1])
    points[:, 2] += 0.005 * points[:, 0]
    fit = fit_plane(points, is_ordered=False)
    assert fit.dip_error_deg is not None
    assert fit.dip_deg is not None
    assert fit.dip_error_deg > fit.dip_deg
    assert fit.dip_direction_error_deg is None


def test_error_rake_points_across_a_straight_trace() -> None:
    """A trace running down the dip leaves the plane free to turn about it: tilt along strike."""
    t = np.linspace(-1.0, 1.0, 30)
    rng = np.random.default_rng(6)
    wobble = rng.normal(0.0, 0.005, (30, 3))
    down_dip = np.stack([5.0 * t, 0.2 * t * t, -5.0 * t], axis=1) + wobble
    fit = fit_plane(down_dip)
    assert fit.error_rake_deg is not None
    assert min(fit.error_rake_deg, 180.0 - fit.error_rake_deg) < 5.0
    along_strike = np.stack([0.2 * t * t, 5.0 * t, -0.2 * t * t], axis=1) + wobble
    fit = fit_plane(along_strike)
    assert fit.error_rake_deg == pytest.approx(90.0, abs=5.0)


@pytest.mark.parametrize("shape", ["closed", "zigzag"])
@pytest.mark.parametrize("spacing", ["even", "uneven", "random"])
def test_unusual_trace_shapes_have_reasonable_errors(shape: str, spacing: str) -> None:
    flat, _ = SIMULATION.trace(shape, 40, spacing)
    points = np.zeros((500, 40, 3))
    points[:, :, :2] = flat
    points[:, :, 2] = np.random.default_rng(8).normal(0.0, 0.02, (500, 40))
    offsets = np.arange(501) * 40
    fits = fit_planes(points.reshape(-1, 3), offsets)
    free = fit_planes(points.reshape(-1, 3), offsets, is_ordered=False)
    ratio = fits.max_confidence95_deg / free.max_confidence95_deg
    assert ratio.min() >= 1.0 - 1e-9
    assert np.median(ratio) < 1.2
    assert np.mean(ratio > 2.0) < 0.15
    assert ratio.max() < 8.0


@pytest.mark.parametrize("method", ["pca", "regression"])
def test_regression_and_orthogonal_fits_are_both_calibrated_at_gentle_dip(method: str) -> None:
    rng = np.random.default_rng(10)
    repeats = 3000
    points = np.zeros((repeats, 20, 3))
    points[:, :, :2] = rng.uniform(-1.0, 1.0, (20, 2)) * [3.0, 1.0]
    points[:, :, 2] = 0.3 * points[:, :, 0] + rng.normal(0.0, 0.05, (repeats, 20))
    fits = fit_planes(
        points.reshape(-1, 3), np.arange(repeats + 1) * 20, method=method, is_ordered=False
    )
    true = np.array([-0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0)
    strike, down = strike_and_dip_lines(fits.dip_direction_deg, fits.dip_deg)
    rake = np.radians(fits.error_rake_deg)[:, None]
    e2 = np.cos(rake) * strike + np.sin(rake) * down
    e1 = np.cross(e2, fits.normal)
    ahead = fits.normal @ true
    x = (e1 @ true) / ahead / np.tan(np.radians(fits.min_confidence95_deg))
    y = (e2 @ true) / ahead / np.tan(np.radians(fits.max_confidence95_deg))
    assert (x * x + y * y <= 1.0).mean() == pytest.approx(0.95, abs=0.015)


@pytest.mark.parametrize("n", [12, 31, 64])
@pytest.mark.parametrize("each", [1, 3])
def test_expected_spectra_match_their_covariance(n: int, each: int) -> None:
    """Against plain matrices: the cosine transform of R, and the form of R with a series."""
    library = residual_correlation._ModelLibrary(n, each)
    i = np.arange(n)
    cosines = np.sqrt(2.0 / n) * np.cos(np.pi * np.outer(np.arange(1, n), i + 0.5) / n)
    places = np.arange(n * each) / (n * each - 1.0)
    h = np.abs(places[:, None] - places)
    series = np.random.default_rng(n).normal(size=n)
    power = np.abs(np.fft.rfft(series, 2 * n)) ** 2
    for k in (
        0,
        3,
        len(residual_correlation.SHORT_LENGTHS) + len(residual_correlation.LONG_LENGTHS) + 2,
        len(residual_correlation.MODEL_LENGTHS) - 3,
    ):
        r = np.eye(n * each)
        if k > 0:
            x, w = (
                h / residual_correlation.MODEL_LENGTHS[k - 1],
                residual_correlation.MODEL_WHITE_SHARES[k - 1],
            )
            smooth = residual_correlation.IS_SMOOTH_MODEL[k - 1]
            r = (1.0 - w) * (np.exp(-0.5 * x * x) if smooth else np.exp(-x)) + w * r
        r = r.reshape(n, each, n, each).mean(axis=(1, 3))  # of the means of pieces
        r /= r[0, 0]
        form = power @ library.toeplitz[k] + library.white_shares[k] * (series @ series)
        assert np.allclose(
            library.squared_power[k], np.diag(cosines @ r @ cosines.T) ** 2, atol=1e-9
        )
        assert form == pytest.approx(series @ r @ series)
        assert library.mean[k] == pytest.approx(r.sum() / n)


def test_segmenting_a_very_long_trace_does_not_change_its_errors() -> None:
    rng = np.random.default_rng(12)
    ratios = []
    for _ in range(20):
        t = np.linspace(-1.0, 1.0, 5000)
        points = np.stack([5.0 * t, 2.0 * t * t, rng.normal(0.0, 0.02, 5000)], axis=1)
        ordered, free = fit_plane(points), fit_plane(points, is_ordered=False)
        assert ordered.max_confidence95_deg is not None
        assert free.max_confidence95_deg is not None
        ratios.append(ordered.max_confidence95_deg / free.max_confidence95_deg)
    assert np.median(ratios) == pytest.approx(1.0, abs=0.05)
    cover, _, ratio, _ = SIMULATION.simulate(Case("arc", 700, "exponential", 0.05), 1000, 5)
    assert cover >= 0.93 - 3.0 * np.sqrt(0.95 * 0.05 / 1000)
    assert ratio <= 1.6


def test_roughness_models_have_the_calibrated_weights() -> None:
    """Those of a tenth of the trace, from where they grow with a power of the length."""
    pure = residual_correlation.MODEL_WHITE_SHARES == 0.0
    long = residual_correlation.MODEL_LENGTHS > residual_correlation.MIN_LONG_LENGTH
    for smooth in (False, True):
        kind = (smooth == residual_correlation.IS_SMOOTH_MODEL) & pure
        some = kind & ~long | (
            kind & np.isin(residual_correlation.MODEL_LENGTHS, residual_correlation.SHORT_LENGTHS)
        )
        length, weight = (
            residual_correlation.MODEL_LENGTHS[some],
            residual_correlation.MODEL_WEIGHTS[some],
        )
        assert len(length) == len(residual_correlation.SHORT_LENGTHS)
        wanted = (
            residual_correlation.SMOOTHNESS_WEIGHTS[smooth]
            * (length / 0.1) ** residual_correlation.SMOOTHNESS_WEIGHT_SLOPES[smooth]
        )
        assert weight == pytest.approx(wanted)
        far = kind & np.isin(residual_correlation.MODEL_LENGTHS, residual_correlation.LONG_LENGTHS)
        assert (
            residual_correlation.MODEL_WEIGHTS[far].tolist()
            == [residual_correlation.LONG_LENGTH_WEIGHTS[smooth]] * 2
        )
    for share, each in zip(
        residual_correlation.MIXED_WHITE_SHARES, residual_correlation.MIXED_WEIGHT, strict=True
    ):
        mixed = share == residual_correlation.MODEL_WHITE_SHARES
        assert not residual_correlation.IS_SMOOTH_MODEL[mixed].any()
        wanted = (
            each
            * (residual_correlation.MODEL_LENGTHS[mixed] / 0.1)
            ** residual_correlation.MIXED_WEIGHT_SLOPE
        )
        assert residual_correlation.MODEL_WEIGHTS[mixed] == pytest.approx(wanted)
    # Lengths go down from sqrt 2 tenths by halves of an octave.
    steps = np.array(residual_correlation.SHORT_LENGTHS[1:]) / np.array(
        residual_correlation.SHORT_LENGTHS[:-1]
    )
    assert steps == pytest.approx(np.full(8, np.sqrt(0.5)))
    assert residual_correlation.SHORT_LENGTHS[1] == pytest.approx(0.1)


def test_mixture_quantile_has_five_percent_tail() -> None:
    """Against Fisher's laws and a root finder of scipy's."""
    from scipy.optimize import brentq
    from scipy.special import fdtrc

    rng = np.random.default_rng(7)
    k, models = 20, 6
    g = rng.uniform(1.0, 40.0, (2, k, models))
    freedom = rng.uniform(2.0, 30.0, (k, models))
    weight = rng.random((k, models)) ** 4
    weight /= weight.sum(axis=1, keepdims=True)
    dof = rng.uniform(5.0, 60.0, k)
    found = residual_correlation._mixture_quantile(g, freedom, weight, dof)
    for axis in range(2):
        for i in range(k):

            def tail(q: float, axis: int = axis, i: int = i) -> float:
                # q is 2 F / dof of a variance that is g times the white one's.
                return float(weight[i] @ fdtrc(2.0, freedom[i], q * dof[i] / 2.0 / g[axis, i]))

            wanted = brentq(lambda q: tail(q) - 0.05, 1e-9, 1e6, xtol=1e-13, rtol=1e-14)
            assert found[axis, i] == pytest.approx(wanted, rel=1e-11)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("n", [4, 9, 40])
def test_regression_region_matches_joint_region_of_slopes(axis: str, n: int) -> None:
    """The joint 95 % ellipse of the two slopes, as a textbook has it, carried over to normals."""
    from scipy.stats import f

    rng = np.random.default_rng(n)
    i = "xyz".index(axis)
    others = [k for k in range(3) if k != i]
    points = np.empty((n, 3))
    points[:, others] = rng.normal(size=(n, 2)) * [3.0, 1.0]
    points[:, i] = points[:, others] @ [0.7, -0.4] + rng.normal(0.0, 1e-5, n)
    fit = fit_plane(points, method="regression", axis=axis, is_ordered=False)  # type: ignore[arg-type]
    x = points[:, others] - points[:, others].mean(axis=0)
    slopes, left, *_ = np.linalg.lstsq(x, points[:, i] - points[:, i].mean())
    root = np.linalg.cholesky(np.linalg.inv(x.T @ x) * 2.0 * f.ppf(0.95, 2, n - 3) / (n - 3) * left)
    angle = np.linspace(0.0, 2.0 * np.pi, 20_001)
    ends = slopes + np.column_stack([np.cos(angle), np.sin(angle)]) @ root.T
    normals = np.ones((len(ends), 3))
    normals[:, others] = -ends
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    off = np.degrees(np.linalg.norm(np.cross(normals, fit.normal), axis=1))
    assert fit.max_confidence95_deg == pytest.approx(off.max(), rel=1e-3)
    assert fit.min_confidence95_deg == pytest.approx(off.min(), rel=1e-3)
    # The direction that tilts most, as a rake within the plane.
    strike, down = strike_and_dip_lines(np.array([fit.dip_direction_deg]), np.array([fit.dip_deg]))
    tilt = normals[off.argmax()] * np.sign(normals[off.argmax()] @ fit.normal) - fit.normal
    rake = np.degrees(np.arctan2((down @ tilt)[0], (strike @ tilt)[0])) % 180.0
    assert (rake - fit.error_rake_deg + 90.0) % 180.0 - 90.0 == pytest.approx(0.0, abs=0.5)


@pytest.mark.parametrize("hair", [0.0, 1e-20, 1e-17, 1e-16, 2e-16])
def test_rake_just_below_180_is_returned_as_0(hair: float) -> None:
    """The window and the tables take rakes from 0 to below 180."""
    dd, d = np.array([40.0, 40.0]), np.array([30.0, 30.0])
    strike, down = strike_and_dip_lines(dd, d)
    signs = np.array([[1.0], [-1.0]])
    lean = signs * (strike - hair * down)
    flat = np.zeros(2, bool)
    small = np.array([0.01, 0.01])
    _, _, rake = component_errors_rad(np.cross(lean, [0, 0, 1.0]), lean, dd, d, flat, small, small)
    assert ((rake >= 0.0) & (rake < np.pi)).all()
    assert np.minimum(rake, np.pi - rake) == pytest.approx(np.zeros(2), abs=1e-15)
    assert rake[0] == rake[1]
