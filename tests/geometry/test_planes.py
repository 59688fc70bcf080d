"""Planes through points: against published figures, closed forms and a second implementation."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.planes import FittedPlane, fit_plane, fit_planes

UTM = np.array([576_700.0, 5_188_200.0, 215.0])
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)


def turn_about_up(points: np.ndarray, azimuth_deg: float) -> np.ndarray:
    """Clockwise seen from above, so that azimuths grow."""
    a = np.radians(azimuth_deg)
    east, north = points[:, 0], points[:, 1]
    return np.stack(
        [
            east * np.cos(a) + north * np.sin(a),
            north * np.cos(a) - east * np.sin(a),
            points[:, 2],
        ],
        axis=1,
    )


def bent_trace(seed: int, n: int = 40, dip: float = 35.0, azimuth: float = 120.0) -> np.ndarray:
    """Noisy arc on a plane of that dip and dip direction, 10 m long."""
    rng = np.random.default_rng(seed)
    t = np.linspace(-1.0, 1.0, n)
    flat = np.stack([2.0 * t * t, 5.0 * t, np.zeros(n)], axis=1)
    flat += rng.normal(0.0, 0.03, flat.shape)
    d = np.radians(dip)
    # x is down-dip, y along strike; then the down-dip line is turned from East to the azimuth.
    tilted = np.stack(
        [
            flat[:, 0] * np.cos(d) + flat[:, 2] * np.sin(d),
            flat[:, 1],
            flat[:, 2] * np.cos(d) - flat[:, 0] * np.sin(d),
        ],
        axis=1,
    )
    return turn_about_up(tilted, azimuth - 90.0)


def angle_between(a: float, b: float) -> float:
    return abs((a - b + 180.0) % 360.0 - 180.0)


@pytest.mark.parametrize(
    ("name", "strike", "dip", "largest", "smallest"),
    [
        ("well_defined", 11.266, 3.492, 0.4753, 0.1473),
        ("poorly_defined", 174.212, 13.223, 16.4899, 0.2920),
    ],
)
def test_published_attitudes_and_hyperbolic_errors_are_reproduced(
    data_dir: Path, name: str, strike: float, dip: float, largest: float, smallest: float
) -> None:
    fit = fit_plane(np.loadtxt(data_dir / "planes" / f"{name}.txt"))
    assert fit.dip_direction_deg is not None
    assert (fit.dip_direction_deg - 90.0) % 360.0 == pytest.approx(strike, abs=5e-4)
    assert fit.dip_deg == pytest.approx(dip, abs=5e-4)
    assert fit.max_angular_error_deg == pytest.approx(largest, abs=5e-5)
    assert fit.min_angular_error_deg == pytest.approx(smallest, abs=5e-5)
    assert not fit.hyperbolic_overflow


def test_published_principal_axes_are_reproduced(data_dir: Path) -> None:
    for record in json.loads((data_dir / "planes" / "planes.json").read_text()):
        fit = fit_plane(np.array(record["centered_array"]) + np.array(record["center"]))
        for ours, theirs in zip(fit.axes, np.array(record["axes"]), strict=True):
            assert abs(ours @ theirs) == pytest.approx(1.0, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(4, 60))
def test_axes_and_eigenvalues_agree_with_a_singular_value_decomposition(seed: int, n: int) -> None:
    points = np.random.default_rng(seed).normal(size=(n, 3)) * [5.0, 2.0, 0.1] + [3.0, -7.0, 90.0]
    fit = fit_plane(points)
    _, s, vt = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    assert np.allclose(fit.eigenvalues, s**2 / (s**2).sum(), rtol=1e-9)
    assert abs(fit.normal @ vt[2]) == pytest.approx(1.0, abs=1e-12)
    assert fit.trace == pytest.approx((s**2).sum() / n)
    assert fit.rms == pytest.approx(s[2] / np.sqrt(n))
    assert fit.normal[2] >= 0.0
    assert np.allclose(fit.axes @ fit.axes.T, np.eye(3), atol=1e-12)
    l1, l2, l3 = fit.eigenvalues
    assert fit.coplanarity == pytest.approx(1 / l3)
    assert fit.collinearity == pytest.approx(l1 / l2)
    assert pytest.approx(np.log(l1 / l3)) == fit.M
    assert pytest.approx(np.log(l1 / l2) / np.log(l2 / l3)) == fit.K


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_regression_agrees_with_a_least_squares_solver(axis: str) -> None:
    points = bent_trace(3) + UTM
    fit = fit_plane(points, method="regression", axis=axis)
    i = "xyz".index(axis)
    others = [k for k in range(3) if k != i]
    local = points - points.mean(axis=0)
    design = np.concatenate([local[:, others], np.ones((len(local), 1))], axis=1)
    solution, *_ = np.linalg.lstsq(design, local[:, i], rcond=None)
    normal = np.zeros(3)
    normal[others], normal[i] = -solution[:2], 1.0
    normal /= np.linalg.norm(normal)
    assert abs(normal @ fit.normal) == pytest.approx(1.0, abs=1e-12)
    left = local[:, i] - design @ solution
    assert fit.residual == pytest.approx(np.sqrt((left**2).mean()), rel=1e-6)
    assert fit.rms == pytest.approx(np.sqrt(((local @ normal) ** 2).mean()), rel=1e-6)


def test_regression_rejects_plane_parallel_to_its_axis() -> None:
    vertical = SQUARE[:, [2, 0, 1]] * 10.0  # in the plane x = 0
    with refused("plane.parallel-to-axis", GeometryError, axis="z"):
        fit_plane(vertical, method="regression", axis="z")
    assert fit_plane(vertical, method="regression").dip_deg == pytest.approx(90.0)


@pytest.mark.parametrize(("azimuth", "dip"), [(0.0, 10.0), (90.0, 45.0), (217.0, 80.0)])
def test_a_plane_of_known_attitude_is_found(azimuth: float, dip: float) -> None:
    fit = fit_plane(bent_trace(1, n=400, dip=dip, azimuth=azimuth))
    assert fit.dip_deg == pytest.approx(dip, abs=0.5)
    assert fit.dip_direction_deg is not None
    assert angle_between(fit.dip_direction_deg, azimuth) < 0.5


def same_but_turned(a: FittedPlane, b: FittedPlane, angle: float, rel: float) -> None:
    vectors = ("centroid", "normal", "axes", "dip_direction_deg")
    for f in fields(a):
        if f.name in (*vectors, "max_coordinate"):
            continue
        x, y = getattr(a, f.name), getattr(b, f.name)
        if isinstance(x, float | np.ndarray):
            assert np.allclose(x, y, rtol=rel, atol=1e-9), f.name
        else:
            assert x == y, f.name
    assert angle_between(a.dip_direction_deg + angle, b.dip_direction_deg) < 1e-6  # type: ignore[operator]


@settings(max_examples=40, deadline=None)
@given(st.floats(0.0, 360.0), st.integers(0, 1000))
def test_rotation_about_vertical_changes_only_dip_direction(angle: float, seed: int) -> None:
    points = bent_trace(seed)
    same_but_turned(fit_plane(points), fit_plane(turn_about_up(points, angle)), angle, 1e-6)


def test_moving_to_utm_changes_nothing() -> None:
    points = bent_trace(5)
    same_but_turned(fit_plane(points), fit_plane(points + UTM), 0.0, 1e-5)


@settings(max_examples=40, deadline=None)
@given(st.integers(-6, 7), st.integers(0, 100))
def test_lengths_scale_and_angles_do_not(power: int, seed: int) -> None:
    scale = 10.0**power
    points = bent_trace(seed)
    a, b = fit_plane(points), fit_plane(points * scale)
    for name in ("rms", "extent"):
        assert getattr(b, name) == pytest.approx(scale * getattr(a, name), rel=1e-9)
    for name in ("dip_deg", "max_confidence95_deg", "max_angular_error_deg", "M", "n_effective"):
        assert getattr(b, name) == pytest.approx(getattr(a, name), rel=1e-4), name


def test_walking_a_trace_backwards_changes_nothing() -> None:
    points = bent_trace(7)
    same_but_turned(fit_plane(points), fit_plane(points[::-1].copy()), 0.0, 1e-6)


def test_point_order_does_not_matter_for_unordered_points() -> None:
    points = bent_trace(8)
    mixed = np.random.default_rng(0).permutation(points)
    same_but_turned(
        fit_plane(points, is_ordered=False), fit_plane(mixed, is_ordered=False), 0.0, 1e-9
    )


@pytest.mark.parametrize("method", ["pca", "regression"])
@pytest.mark.parametrize("ordered", [True, False])
def test_batch_fit_matches_single_fits(method: str, ordered: bool) -> None:
    rng = np.random.default_rng(4)
    groups = [bent_trace(i, n=int(rng.integers(3, 60))) for i in range(40)]
    groups[5] = groups[5][:2]
    groups[9] = np.outer(np.arange(6.0), [1.0, 2.0, 3.0])
    groups[12] = groups[12][:0]
    groups[20] = groups[20].copy()
    groups[20][0, 1] = np.nan
    offsets = np.concatenate([[0], np.cumsum([len(g) for g in groups])])
    fits = fit_planes(np.concatenate(groups), offsets, method=method, is_ordered=ordered)
    assert len(fits) == len(groups)
    for i, group in enumerate(groups):
        if i in (5, 9, 12, 20):
            assert fits.error[i] is not None
            assert np.isnan(fits.normal[i]).all()
            assert fits[i].dip_deg is None
            with pytest.raises(GeometryError):
                fit_plane(group, method=method, is_ordered=ordered)
            continue
        single = fit_plane(group, method=method, is_ordered=ordered)
        same_but_turned(fits[i], single, 0.0, 1e-6)


def test_groups_are_defined_by_offsets_alone() -> None:
    points = np.concatenate([np.full((3, 3), 1e300), bent_trace(1), bent_trace(2)])
    fits = fit_planes(points, [3, 43, 83])
    assert fits[1].dip_deg == pytest.approx(fit_plane(bent_trace(2)).dip_deg)


def test_empty_batch_gives_no_planes() -> None:
    assert len(fit_planes(np.zeros((0, 3)), [0])) == 0


@pytest.mark.parametrize(
    ("points", "code", "values"),
    [
        (SQUARE[:2], "feature.too-few-points", {"count": 1, "minimum": 3}),
        (np.zeros((0, 3)), "feature.too-few-points", {"count": 3, "minimum": 3}),
        ([], "feature.too-few-points", {"count": 3, "minimum": 3}),
        (np.full((5, 3), 0.1), "points.coincident", {"n": 5}),
        (np.tile(UTM, (5, 1)), "points.coincident", {"n": 5}),
        (np.outer(np.linspace(0, 1, 7), [0.3, 0.1, 0.7]) + 1e3, "points.collinear", {"n": 7}),
        (np.outer(np.linspace(0, 90, 50), [0.36, 0.48, 0.8]) + UTM, "points.collinear", {"n": 50}),
        (np.array([[0, 0, 0], [0, 0, 0], [1, 2, 3.0]]), "points.collinear", {"n": 3}),
        (np.array([[0, 0, 0], [1, 0, np.inf], [1, 2, 3.0]]), "points.not-finite", {}),
        (np.array([[0, 0, 0], [1, 0, np.nan], [1, 2, 3.0]]), "points.not-finite", {}),
    ],
)
def test_points_without_a_plane_are_rejected_with_reason(
    points: np.ndarray, code: str, values: dict[str, int]
) -> None:
    with refused(code, GeometryError, **values):
        fit_plane(points)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 100_000), st.floats(1e-3, 1e4), st.integers(3, 50))
def test_collinear_points_are_rejected_at_any_position(seed: int, length: float, n: int) -> None:
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    points = rng.random((n, 1)) * length * direction + rng.uniform(-1, 1, 3) * 5e6
    with pytest.raises(GeometryError):
        fit_plane(points)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000))
def test_small_valid_plane_at_utm_is_accepted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.random((5, 3)) * [0.1, 0.05, 0.001] + UTM
    assert fit_plane(points).max_angular_error_deg is not None


def test_malformed_input_is_rejected_by_name() -> None:
    for points, offsets, code, field in (
        (np.zeros((4, 2)), [0, 4], "points.invalid", "points"),
        (np.zeros((4, 3)), [0, 5], "points.offsets", "offsets"),
        (np.zeros((4, 3)), [3, 0], "points.offsets", "offsets"),
    ):
        with refused(code, GeometryError, field=field):
            fit_planes(points, offsets)
    with refused("option.not-a-choice", GeometryError, value="ransac", field="method"):
        fit_plane(SQUARE, method="ransac")  # type: ignore[arg-type]


def test_three_points_have_an_attitude_and_no_errors() -> None:
    fit = fit_plane([[0, 0, 0], [1, 0, 0], [0, 1, -1.0]])
    assert fit.dip_deg == pytest.approx(45.0)
    assert fit.dip_direction_deg == pytest.approx(0.0)
    for name in (
        "max_angular_error_deg",
        "min_angular_error_deg",
        "max_confidence95_deg",
        "min_confidence95_deg",
        "dip_error_deg",
        "dip_direction_error_deg",
        "n_effective",
    ):
        assert getattr(fit, name) is None, name
    assert not fit.hyperbolic_overflow


def test_duplicate_point_does_not_count_as_fourth_point() -> None:
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, -1.0]])
    assert fit_plane(triangle[[0, 1, 2, 2]]).max_confidence95_deg is None
    assert fit_plane(triangle[[0, 1, 2, 0]], is_ordered=False).max_confidence95_deg is None


def test_points_exactly_in_one_plane_have_no_error_and_an_infinite_coplanarity() -> None:
    fits = fit_planes(SQUARE, [0, 4])
    assert np.isinf(fits.coplanarity[0])
    assert fits[0].coplanarity is None
    assert fits[0].M is None
    assert fits[0].max_confidence95_deg == 0.0
    assert fits[0].max_angular_error_deg == 0.0
    assert fits[0].rms == 0.0


def test_horizontal_plane_is_flagged_as_having_no_dip_direction() -> None:
    fit = fit_plane(SQUARE + UTM)
    assert fit.undefined
    assert fit.dip_direction_deg == 0.0
    assert fit.dip_deg == 0.0
    assert fit.dip_direction_error_deg is None
    assert fit.normal.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("flip", [1.0, -1.0])
def test_strike_of_vertical_plane_is_below_180(flip: float) -> None:
    for azimuth in (90.0, 120.0, 179.0, 180.0, 260.0):
        points = turn_about_up(SQUARE[:, [2, 0, 1]] * flip * 8.0, azimuth - 90.0)
        fit = fit_plane(points)
        assert fit.dip_deg == pytest.approx(90.0)
        assert fit.dip_direction_deg == pytest.approx(azimuth)


@pytest.mark.parametrize("scale", [1e-320, 1e-160, 1e160, 1e308])
def test_coordinates_whose_squares_overflow_are_rejected(scale: float) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0.1], [0, 1, 0.2], [1, 1, 0.5]]) * scale
    with pytest.raises(GeometryError):
        fit_plane(points)


@pytest.mark.parametrize(
    ("offsets", "sound"),
    [
        ([0, 4, 8], True),
        ([0, 4, 4, 8], True),
        ([2, 6], True),
        ([0, 9], False),
        ([-1, 4], False),
        ([0, 5, 4], False),
        ([], False),
        ([[0, 4]], False),
    ],
)
def test_offsets_beyond_the_points_are_rejected(offsets: list[int], sound: bool) -> None:
    points = np.concatenate([SQUARE, SQUARE + UTM])
    if sound:
        assert len(fit_planes(points, offsets)) == len(offsets) - 1
        return
    with pytest.raises(GeometryError, match="Offsets") as caught:
        fit_planes(points, offsets)
    assert caught.value.field == "offsets"


def test_invalid_arguments_are_reported_by_field() -> None:
    for asked, field in (
        ({"method": "ransac"}, "method"),
        ({"axis": "w"}, "axis"),
        ({"axis": "w", "method": "regression"}, "axis"),
    ):
        with pytest.raises(GeometryError) as caught:
            fit_plane(SQUARE, **asked)  # type: ignore[arg-type]
        assert caught.value.field == field
    for points in (np.zeros(3), np.zeros((4, 2)), np.zeros((2, 4, 3))):
        with pytest.raises(GeometryError) as caught:
            fit_planes(points, [0, 4])
        assert caught.value.field == "points"


def test_group_without_plane_is_nan_in_batch_and_affects_no_other() -> None:
    """One too short, one not finite, one far too large, one straight, one at a place."""
    line = np.outer(np.arange(6.0), [1.0, 2.0, 3.0])
    groups = [bent_trace(1), SQUARE[:2], bent_trace(2), SQUARE * np.nan, SQUARE * 1.1e150]
    groups += [line, np.full((5, 3), 2.5), bent_trace(3)]
    offsets = np.concatenate([[0], np.cumsum([len(g) for g in groups])])
    fits = fit_planes(np.concatenate(groups), offsets)
    expected = [
        None,
        Finding("feature.too-few-points", count=1, minimum=3),
        None,
        Finding("points.not-finite"),
        Finding("points.not-finite"),
        Finding("points.collinear", n=6),
        Finding("points.coincident", n=5),
        None,
    ]
    for i, finding in enumerate(expected):
        if finding is None:
            assert fits.error[i] is None
            single = fit_plane(groups[i])
            assert fits[i].dip_deg == pytest.approx(single.dip_deg)
            assert fits[i].n_effective == pytest.approx(single.n_effective)
            continue
        assert fits.error[i] == finding
        assert fits.n[i] == len(groups[i])
        for f in fields(FittedPlane):
            value = getattr(fits[i], f.name)
            if isinstance(value, np.ndarray):
                assert np.isnan(value).all(), f.name
            elif f.name not in ("n", "error", "method", "ordered"):
                assert value is None or value is False, f.name


@pytest.mark.parametrize("dip", [1.0, 20.0, 45.0, 70.0, 89.9])
@pytest.mark.parametrize("azimuth", [0.0, 40.0, 90.0, 230.0])
def test_a_regression_along_the_nearest_axis_keeps_steep_planes_steep(
    dip: float, azimuth: float
) -> None:
    """Of scatter along the normal: along z, 89.9 degrees once became 75.5."""
    random = np.random.default_rng(7)
    normal = Plane(azimuth, dip).normal()
    along = np.linalg.svd(normal[None])[2][1:]
    points = random.uniform(-2.0, 2.0, (400, 2)) @ along + random.normal(0, 0.05, (400, 1)) * normal
    fits = fit_planes(points, [0, 400], method="regression")
    turned = np.degrees(np.arccos(min(1.0, abs(float(fits[0].normal @ normal)))))
    assert turned < 0.3
    nearest = "xyz"[int(np.argmax(np.abs(normal)))]
    named = fit_planes(points, [0, 400], method="regression", axis=nearest)  # type: ignore[arg-type]
    assert np.array_equal(named[0].normal, fits[0].normal)
    if dip == 89.9:
        along_z = fit_planes(points, [0, 400], method="regression", axis="z")
        assert along_z.error[0] == Finding("plane.parallel-to-axis", axis="z")


def test_failed_regression_is_nan_in_batch() -> None:
    vertical = SQUARE[:, [2, 0, 1]] * 10.0
    offsets = [0, 4, 44]
    both = np.concatenate([vertical, bent_trace(1)])
    fits = fit_planes(both, offsets, method="regression", axis="z")
    assert fits.error[0] == Finding("plane.parallel-to-axis", axis="z")
    assert fits[0].dip_deg is fits[0].max_confidence95_deg is None
    assert fits[1].dip_deg == pytest.approx(fit_plane(bent_trace(1), method="regression").dip_deg)


@pytest.mark.parametrize("lean", [0.5e-7, 2e-7])
def test_a_plane_is_parallel_to_an_axis_within_a_ten_millionth_of_its_size(lean: float) -> None:
    """A square of ten metres that leans by so much off the vertical, seen from its axis."""
    upright = SQUARE[:, [2, 0, 1]] * 2.0 - [0.0, 1.0, 1.0]
    upright[:, 0] = 2.0 * lean * upright[:, 2]
    if lean < 1e-7:
        with pytest.raises(GeometryError, match="parallel"):
            fit_plane(upright, method="regression", axis="z")
    else:
        assert fit_plane(upright, method="regression", axis="z").dip_deg == pytest.approx(
            90.0, abs=1e-4
        )


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from(["pca", "regression"]))
def test_any_rotation_rotates_only_the_normal(seed: int, method: str) -> None:
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    points = rng.normal(size=(20, 3)) * [4.0, 1.5, 0.05]
    if method == "regression":
        # Regression knows its axis: axes that change places are all that it bears.
        turn = np.eye(3)[rng.permutation(3)]
    axis = "xyz"[int(np.flatnonzero(turn[:, 2])[0])] if method == "regression" else "z"
    a = fit_plane(points, method=method, is_ordered=False)  # type: ignore[arg-type]
    b = fit_plane(points @ turn.T, method=method, axis=axis, is_ordered=False)  # type: ignore[arg-type]
    assert abs(b.normal @ (turn @ a.normal)) == pytest.approx(1.0, abs=1e-12)
    for name in ("rms", "residual", "extent", "trace", "M", "K", "coplanarity", "collinearity"):
        assert getattr(b, name) == pytest.approx(getattr(a, name), rel=1e-7), name
    for name in ("max_confidence95_deg", "min_confidence95_deg", "max_angular_error_deg"):
        assert getattr(b, name) == pytest.approx(getattr(a, name), rel=1e-7), name


def test_max_coordinate_sets_the_rounding_limit() -> None:
    points = bent_trace(4)
    assert fit_plane(points).max_coordinate == pytest.approx(np.abs(points).max())
    assert fit_plane(points - UTM).max_coordinate == pytest.approx(np.abs(points - UTM).max())


@pytest.mark.parametrize("count", [16, 17])
def test_duplicate_points_are_detected_only_in_short_traces(count: int) -> None:
    """Of sixteen points, one of them twice, fifteen count; in a longer trace it matters little."""
    points = bent_trace(5, n=count - 1)
    repeated = points[[*range(count - 1), 3]]
    fit = fit_plane(repeated, is_ordered=False)
    assert fit.n_effective == count - (count == 16)
    for k, same in ((0, True), (1, False)):
        near = repeated.copy()
        near[-1, 0] += k * 1e-9
        assert (fit_plane(near, is_ordered=False).n_effective == count - 1) == (
            same and count == 16
        )


@pytest.mark.parametrize("seed", range(4))
def test_thin_straight_trace_keeps_thickness_precision(seed: int) -> None:
    """A kilometre long, millimetres wide and far thinner: squares alone would lose it."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = rng.normal(size=(30, 3)) * [300.0, 1e-3, 1e-8] @ turn.T
    fit = fit_plane(points, is_ordered=False)
    _, singular, axes = np.linalg.svd(points - points.mean(axis=0))
    assert fit.rms == pytest.approx(singular[2] / np.sqrt(30), rel=1e-3)
    assert np.linalg.norm(np.cross(fit.normal, axes[2])) < 1e-6


FAR = 2.0**20
STEP = np.spacing(FAR)
"""The roundings of this coordinate."""
SADDLE = np.array([1.0, -1.0, -1.0, 1.0]) * STEP


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("steps", "beyond"), [(3, False), (5, True)])
def test_extent_within_four_roundings_of_largest_coordinate_is_zero(
    axis: int, steps: int, beyond: bool
) -> None:
    """A thickness, a width and a length of so many roundings, far from the origin."""
    thick = np.column_stack([[-0.5, 0.5, -0.5, 0.5], [-0.5, -0.5, 0.5, 0.5], steps * SADDLE])
    wide = np.column_stack([[0, 1, 2, 3], steps * SADDLE, [0, 0, 0, 0]])
    long = np.column_stack([steps * SADDLE, np.zeros((4, 2))])
    thick, wide, long = (np.roll(each, axis, axis=1) + FAR for each in (thick, wide, long))
    rms = fit_plane(thick).rms
    assert rms == (pytest.approx(steps * STEP, rel=1e-6) if beyond else 0.0)
    if beyond:
        assert fit_plane(wide).rms == 0.0
    else:
        with refused("points.collinear", GeometryError):
            fit_plane(wide)
    with refused("points.collinear" if beyond else "points.coincident", GeometryError):
        fit_plane(long)


@pytest.mark.parametrize(("steps", "flat"), [(3, True), (5, False)])
def test_plane_tilted_only_by_rounding_is_horizontal(steps: int, flat: bool) -> None:
    """Of a square a metre wide, eight roundings of its largest coordinate from side to side."""
    x, y = np.array([-0.5, 0.5, -0.5, 0.5]), np.array([-0.5, -0.5, 0.5, 0.5])
    fit = fit_plane(np.column_stack([x, y, -2.0 * steps * STEP * x]) + FAR)
    assert fit.undefined == flat
    assert fit.dip_direction_deg == pytest.approx(0.0 if flat else 90.0)
    assert fit.dip_deg == pytest.approx(0.0 if flat else np.degrees(2.0 * steps * STEP))


@pytest.mark.parametrize(
    ("size", "code"),
    [
        (0.9e150, None),
        (1.1e150, "points.not-finite"),
        (1.1e-150, None),
        (0.9e-150, "points.coincident"),
    ],
)
def test_sizes_from_1e_minus_150_to_1e150_are_fitted(size: float, code: str | None) -> None:
    points = np.array([[-1, -1, -0.5], [1, -1, 0.5], [-1, 1, -0.5], [1, 1, 0.5]]) * size
    if code is None:
        fit = fit_plane(points)
        assert fit.dip_deg == pytest.approx(np.degrees(np.arctan(0.5)))
        assert fit.extent == pytest.approx(size * np.hypot(2.0, 1.0))
    else:
        with refused(code, GeometryError):
            fit_plane(points)


@pytest.mark.parametrize(("steps", "parallel"), [(3, True), (5, False)])
@pytest.mark.parametrize("axis", range(3))
def test_a_small_plane_far_away_is_parallel_to_an_axis_within_its_roundings(
    axis: int, steps: int, parallel: bool
) -> None:
    """It leans by so many roundings of the largest coordinate from side to side."""
    half = 2.0**-11
    u, v = np.array([-1.0, 1.0, -1.0, 1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    points = np.roll(np.column_stack([half * u, steps * STEP * v, half * v]), axis - 2, axis=1)
    name = "xyz"[axis]
    if parallel:
        with refused("plane.parallel-to-axis", GeometryError, axis=name):
            fit_plane(points + FAR, method="regression", axis=name)  # type: ignore[arg-type]
    else:
        fit = fit_plane(points + FAR, method="regression", axis=name)  # type: ignore[arg-type]
        lean = fit.normal[axis] / np.linalg.norm(fit.normal)
        assert abs(lean) == pytest.approx(steps * STEP / half, rel=1e-6)
