"""What roughness costs a trace: against a second implementation with plain matrices, and laws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import fdtrc

from tests.tiers import first_in_default_tier
from vomstudio.geometry import residual_correlation
from vomstudio.geometry.plane_errors import joint_quantile
from vomstudio.geometry.planes import fit_plane

Trace = tuple[np.ndarray, np.ndarray, np.ndarray]


def noise(n: int, length: float, seed: int, white: float = 0.0) -> np.ndarray:
    """Heights at even places whose correlation falls to 1/e within `length` of the trace."""
    rng = np.random.default_rng(seed)
    if length == 0.0:
        return rng.standard_normal(n)
    h = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) / (n - 1.0)
    rough = np.linalg.cholesky(np.exp(-h / length) + 1e-9 * np.eye(n)) @ rng.standard_normal(n)
    return np.sqrt(1.0 - white) * rough + np.sqrt(white) * rng.standard_normal(n)


def trace(n: int, length: float, seed: int, uneven: float = 0.0) -> Trace:
    """Coordinates along the axes of a plane fitted to a wavy arc."""
    rng = np.random.default_rng(seed + 1000)
    t = np.linspace(-1.0, 1.0, n)
    t = np.sort(t + uneven * rng.standard_normal(n) / n) if uneven < 9.0 else t**3
    points = np.column_stack([5.0 * t, 2.0 * t * t + 0.1 * t, 0.02 * noise(n, length, seed)])
    points = points - points.mean(axis=0)
    axes = np.linalg.svd(points)[2]
    u, v, r = (points @ axes.T).T
    return u, v, r


def correlations(n: int, each: int) -> tuple[np.ndarray, np.ndarray]:
    """Of the means of n pieces of `each` points (models, n, n), the first one white; and how much
    of their variance is white noise."""
    places = np.arange(n * each) / (n * each - 1.0)
    h = np.abs(places[:, None] - places)
    found, whites = [np.eye(n)], [1.0]
    for length, white, smooth in zip(
        residual_correlation.MODEL_LENGTHS,
        residual_correlation.MODEL_WHITE_SHARES,
        residual_correlation.IS_SMOOTH_MODEL,
        strict=True,
    ):
        x = h / length
        rough = (1.0 - white) * (np.exp(-0.5 * x * x) if smooth else np.exp(-x))
        both = rough + white * np.eye(n * each)
        means = both.reshape(n, each, n, each).mean(axis=(1, 3))
        found.append(means / means[0, 0])
        whites.append(white / each / means[0, 0])
    return np.array(found), np.array(whites)


_KNOWN: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}


def plainly(u: np.ndarray, v: np.ndarray, r: np.ndarray, dof: float) -> tuple[float, ...]:
    """q along e1, along e2, effective number, long roughness, as the module says they are."""
    length = np.append(0.0, np.cumsum(np.hypot(np.diff(u), np.diff(v))))
    place = length / length[-1]
    n_points = len(u)
    whole = u, v, r
    n, part, each = n_points, 1.0, max(round(n_points / residual_correlation.MAX_PIECES), 1)
    free = dof
    if n > residual_correlation.MAX_PIECES:
        n, free = residual_correlation.MAX_PIECES, min(dof, residual_correlation.MAX_PIECES - 3.0)
        cuts = [int(k * n_points / n) for k in range(n)]
        u, v, r = (np.array([p.mean() for p in np.split(x, cuts[1:])]) for x in whole)
        part = (r**2).mean() / (whole[2] ** 2).mean()
    if (n, each) not in _KNOWN:
        _KNOWN[n, each] = correlations(n, each)
    matrices, whites = _KNOWN[n, each]
    k = np.arange(1, n)
    cosines = np.sqrt(2.0 / n) * np.cos(np.pi * np.outer(k, np.arange(n) + 0.5) / n)
    s = np.maximum(np.einsum("ki,mij,kj->mk", cosines, matrices, cosines, optimize=True), 0.0)
    power = [(cosines @ x) ** 2 / (x @ x) for x in (u, v, r)]
    left = np.maximum(1.0 - power[0] - power[1], 0.0)
    lean = np.array([np.einsum("i,mij,j->m", x, matrices, x) / (x @ x) for x in (u, v)])
    mean = matrices.sum(axis=(1, 2)) / n
    remains = np.maximum(n - mean - lean.sum(axis=0), 1e-3 * n)
    share = free / (n - 3.0)
    freedom = np.minimum(residual_correlation.DOF_FACTOR * remains**2 / (s**2 @ left), n - 3.0)
    freedom[0] = n - 3.0
    g = np.maximum(lean * free / remains, 1.0)
    if (
        (np.diff(place) * (n_points - 1.0) - 1.0) ** 2
    ).mean() > residual_correlation.MAX_UNEVENNESS**2:
        bins = np.minimum((place * n).astype(int), n - 1)
        total = [np.bincount(bins, x, n) for x in (*whole[:2], np.ones(n_points))]
        norm = [whole[0] @ whole[0], whole[1] @ whole[1], n_points]
        rough = matrices - whites[:, None, None] * np.eye(n)
        there = np.array(
            [
                np.einsum("i,mij,j->m", t, rough, t) / (size * n_points / n) + whites
                for t, size in zip(total, norm, strict=True)
            ]
        )
        kept = np.maximum(n - there.sum(axis=0), 1e-2 * n)
        g = np.maximum(g, there[:2] * free / kept)

    low = np.maximum(n - mean - s[:, 0] - s[:, 1], 1e-3 * n)
    heard = slice(0, residual_correlation.N_FREQUENCIES)
    model = s[:, heard] * ((n - 3.0) / low)[:, None] + residual_correlation.MIN_NOISE_SHARE
    seen = power[2][heard] * (n - 3.0) + residual_correlation.MIN_NOISE_SHARE * left[heard]
    number = left[heard].sum() * share
    told = -0.5 * (np.log(model) @ left[heard] + number * np.log((seen / model).sum(axis=1)))
    falls = (
        np.where(residual_correlation.IS_SMOOTH_MODEL, np.sqrt(2.0), 1.0)
        * residual_correlation.MODEL_LENGTHS
    )
    prior = np.where(falls > each / (n * each - 1.0), residual_correlation.MODEL_WEIGHTS, 0.0)
    white = max(
        (residual_correlation.WHITE_POINTS / n) ** residual_correlation.WHITE_POWER,
        residual_correlation.MIN_WHITE_WEIGHT,
    )
    even = np.exp(told - told.max()) * np.append(
        True, residual_correlation.MODEL_WHITE_SHARES == 0.0
    )
    far = np.append(False, residual_correlation.MODEL_LENGTHS > 0.12)
    weight = (np.exp(told - told.max()) * np.append(white, prior)) ** residual_correlation.SHARPNESS
    weight /= weight.sum()

    def excess(x: float, axis: int) -> float:
        f = np.exp(x) * free / 2.0 / g[axis]
        return float(weight @ fdtrc(2.0, freedom * share, f)) - 0.05

    q1, q2 = (part * np.exp(brentq(excess, -40.0, 600.0, args=(a,))) for a in (0, 1))
    effective = min(3.0 - 2.0 * np.log(0.05) / np.log1p(q2), dof + 3.0)
    return q1, q2, effective, bool(even[far].sum() > 0.5 * even.sum())


def inflated(traces: list[Trace], dof: np.ndarray) -> tuple[np.ndarray, ...]:
    counts = np.array([len(t[0]) for t in traces])
    u, v, r = (np.concatenate([t[i] for t in traces]) for i in range(3))
    return residual_correlation.inflate(
        u, v, r, np.cumsum(counts) - counts, counts, dof, joint_quantile(dof)
    )


def compared(traces: list[Trace], dof: np.ndarray) -> None:
    found = np.array(inflated(traces, dof), dtype=float).T
    for own, each, free in zip(found, traces, dof, strict=True):
        wanted = np.array(plainly(*each, free), dtype=float)
        np.testing.assert_allclose(own, wanted, rtol=2e-4, err_msg=f"{len(each[0])} points")


@pytest.mark.parametrize("n", first_in_default_tier([12, 13, 31, 100, 255, 256]))
@pytest.mark.parametrize("length", first_in_default_tier([0.0, 0.03, 0.1, 0.5]))
def test_batch_costs_match_dense_matrices(n: int, length: float) -> None:
    traces = [trace(n, length, seed) for seed in range(3)]
    compared(traces, np.full(3, n - 3.0))


@pytest.mark.parametrize("uneven", [0.2, 0.6, 1.5, 9.0])
def test_uneven_spacing_uses_point_positions(uneven: float) -> None:
    traces = [trace(60, length, seed, uneven) for seed, length in enumerate((0.0, 0.05, 0.2))]
    compared(traces, np.full(3, 57.0))


def picked_again(distinct: int, n: int, seed: int) -> Trace:
    """A trace of n points at so many places only."""
    rng = np.random.default_rng(seed)
    own = np.arange(distinct)
    rows = np.sort(np.append(own, rng.integers(0, distinct, n - distinct)))
    points = np.column_stack(trace(distinct, 0.0, seed))[rows]
    points = points - points.mean(axis=0)
    u, v, r = (points @ np.linalg.svd(points)[2].T).T
    return u, v, r


def test_duplicate_points_reduce_degrees_of_freedom() -> None:
    sizes = [5, 7, 9, 12]
    traces = [picked_again(size, 14, seed) for seed, size in enumerate(sizes)]
    compared(traces, np.array(sizes) - 3.0)


@pytest.mark.parametrize("n", first_in_default_tier([257, 300, 640, 900], 1))
def test_long_trace_is_compared_by_segment_means(n: int) -> None:
    traces = [trace(n, length, seed) for seed, length in enumerate((0.0, 0.05))]
    traces.append(trace(n, 0.1, 7, uneven=9.0))
    compared(traces, np.full(3, n - 3.0))


def test_traces_of_mixed_length_keep_their_order_in_batch() -> None:
    sizes = [40, 12, 300, 11, 40, 5, 12, 27]
    traces = [trace(n, 0.05, seed) for seed, n in enumerate(sizes)]
    dof = np.array(sizes) - 3.0
    together = inflated(traces, dof)
    for i, own in enumerate(traces):
        alone = inflated([own], dof[i : i + 1])
        for a, b in zip(together, alone, strict=True):
            assert a[i] == pytest.approx(b[0], rel=1e-9)
    short = np.array(sizes) < residual_correlation.MIN_POINTS
    for q in together[:2]:
        np.testing.assert_array_equal(q[short], joint_quantile(dof)[short])
    np.testing.assert_array_equal(together[2][short], np.array(sizes)[short])
    assert not together[3][short].any()


def test_one_degree_of_freedom_leaves_nothing_to_compare() -> None:
    for distinct, compares in ((4, False), (5, True)):
        free = np.array([distinct - 3.0])
        q1, q2, effective, _ = inflated([picked_again(distinct, 14, 1)], free)
        assert (q1[0] != joint_quantile(free)[0]) == compares
        assert (q2[0] != joint_quantile(free)[0]) == compares
        assert (effective[0] != distinct) == compares


@pytest.mark.parametrize(("each", "close"), [(2, 1e-12), (16, 1e-12), (17, 5e-3), (40, 5e-3)])
def test_segment_means_lose_white_noise_and_keep_roughness(each: int, close: float) -> None:
    """Of more than sixteen points in a piece the correlation is worked out with sixteen."""
    rho, white = residual_correlation._correlations(20, each)
    matrices, wanted = correlations(20, each)
    np.testing.assert_allclose(white, wanted, rtol=3.0 * close)
    rho[:, 0] += white
    np.testing.assert_allclose(rho, matrices[:, 0], atol=close)


@pytest.mark.parametrize("length", [0.0, 0.1, 0.5])
def test_roughness_cost_ignores_trace_scale_and_direction(
    length: float,
) -> None:
    own = trace(50, length, 3)
    dof = np.array([47.0])
    plain = inflated([own], dof)
    for other in (
        [tuple(x[::-1].copy() for x in own)],
        [tuple(1e-5 * x for x in own)],
        [tuple(1e6 * x for x in own)],
        [(own[0], own[1], -3.0 * own[2])],
        [(-own[0], own[1], own[2])],
    ):
        for a, b in zip(inflated(other, dof), plain, strict=True):  # type: ignore[arg-type]
            assert a[0] == pytest.approx(b[0], rel=1e-6)


def test_trace_rough_along_its_whole_length_is_flagged() -> None:
    """Half of the belief in lengths beyond a tenth makes the flag; seen over many traces."""
    flagged = {
        length: np.mean([inflated([trace(80, length, s)], np.array([77.0]))[3] for s in range(40)])
        for length in (0.0, 0.02, 0.5)
    }
    assert flagged[0.0] <= 0.1
    assert flagged[0.02] <= 0.2
    assert flagged[0.5] >= 0.5


def test_exactly_planar_points_have_zero_error() -> None:
    t = np.linspace(-1.0, 1.0, 30)
    fit = fit_plane(np.column_stack([5.0 * t, 2.0 * t * t, 3.0 * t]))
    assert fit.max_confidence95_deg == pytest.approx(0.0, abs=1e-6)


def test_model_weights_normalize_without_overflow() -> None:
    """A model that explains a trace worse by more than numbers can tell is given nothing."""
    logarithms = np.array([[0.0, -3000.0, np.log(3.0)], [5000.0, 5000.0, -5000.0]])
    for shift in (0.0, 900.0, -900.0):
        found = residual_correlation._normalize(logarithms + shift)
        np.testing.assert_allclose(found, [[0.25, 0.0, 0.75], [0.5, 0.5, 0.0]], atol=1e-12)


@pytest.mark.parametrize("each", [1, 3])
def test_correlation_length_counts_if_neighbours_correlate_above_1_in_e(each: int) -> None:
    """Of the means of pieces, over the length of a piece."""
    told = 0
    for k, length in enumerate(residual_correlation.MODEL_LENGTHS):
        fallen = length * (np.sqrt(2.0) if residual_correlation.IS_SMOOTH_MODEL[k] else 1.0)
        first = int(1.0 / fallen + 1.0 / each) + 1
        for n, known in ((first, True), (first - 1, False)):
            assert (fallen * (n * each - 1.0) > each) == known
            if n >= residual_correlation.MIN_POINTS:
                weight = np.exp(residual_correlation._ModelLibrary(n, each).log_weight[k + 1])
                assert weight == pytest.approx(
                    residual_correlation.MODEL_WEIGHTS[k]
                    if known
                    else residual_correlation.MIN_FLOAT
                )
                told += 1
    assert told > 30


@pytest.mark.parametrize("heavy", [0.051, 0.06, 0.3])
@pytest.mark.parametrize("cost", [1e2, 1e5])
def test_unlikely_but_much_wider_model_sets_the_quantile(heavy: float, cost: float) -> None:
    """The tail then has a long flat step, over which straight steps overshoot."""
    weight, g = np.array([[1.0 - heavy, heavy]]), np.array([[[1.0, cost]], [[cost, 1.0]]])
    freedom, dof = np.array([[40.0, 25.0]]), np.array([40.0])
    found = residual_correlation._mixture_quantile(g, freedom, weight, dof)[:, 0]
    for axis in (0, 1):

        def excess(x: float, axis: int = axis) -> float:
            f = np.expm1(x) * dof[0] / 2.0 / g[axis, 0]
            return float(weight[0] @ fdtrc(2.0, freedom[0], f)) - 0.05

        wanted = np.expm1(brentq(excess, 1e-9, 60.0, xtol=1e-14))
        assert found[axis] == pytest.approx(wanted, rel=1e-11)


def test_mixture_quantile_has_five_percent_tail() -> None:
    rng = np.random.default_rng(1)
    traces, models = 4000, 12
    g = rng.uniform(0.2, 30.0, (2, traces, models))
    freedom = rng.uniform(3.0, 60.0, (traces, models))
    weight = rng.dirichlet(np.full(models, 0.3), traces)
    dof = rng.uniform(5.0, 100.0, traces)
    q = residual_correlation._mixture_quantile(g, freedom, weight, dof)
    # Of F with 2 and n degrees of freedom the tail beyond x is (1 + 2 x / n)^(-n / 2).
    tail = fdtrc(2, freedom, 0.5 * dof[:, None] / g * q[..., None])
    assert (weight * tail).sum(axis=-1) == pytest.approx(0.05, rel=1e-11)
