"""What a patch keeps of its points, and how sure its plane is."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import (
    face_areas,
    face_points,
    has_id,
    ids_to_runs,
    moments,
    outline,
    runs_to_ids,
)
from vomstudio.geometry.planes import FittedPlane, fit_plane

ACROSS, ALONG = 36, 30


def roughness(rng: np.random.Generator, length: float) -> np.ndarray:
    """Heights on a grid of unit size whose correlation falls to 1/e within `length` (0: white)."""
    rows, columns = ALONG, ACROSS
    if length == 0.0:
        return rng.standard_normal((rows, columns))
    big = (4 * rows, 4 * columns)
    spectrum = np.fft.rfft2(rng.standard_normal(big))
    # A Gaussian filter of width s correlates over 2 s: exp(-d^2 / (4 s^2)).
    s = length / 2.0
    fy = np.fft.fftfreq(big[0], 1.0 / ALONG)[:, None]
    fx = np.fft.rfftfreq(big[1], 1.0 / ALONG)[None]
    spectrum *= np.exp(-2.0 * (np.pi * s) ** 2 * (fx**2 + fy**2))
    field = np.fft.irfft2(spectrum, big)[:rows, :columns]
    return field / field.std()


def coverage(length: float, repeats: int, seed: int) -> tuple[float, tuple[float, float]]:
    """How often the 95 % region holds the true plane z = 0, and the median half-angles (toward e1,
    e2) over what the scatter of the tilts calls for."""
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(ACROSS) / ALONG, np.arange(ALONG) / ALONG)
    tilts, semis = [], []
    for _ in range(repeats):
        z = 0.02 * roughness(rng, length)
        known = moments(np.column_stack([u.ravel(), v.ravel(), z.ravel()]))
        fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
        # The tilt of the true normal along the two axes, in units of the half-angles.
        rise = np.array([0.0, 0.0, 1.0]) @ fit.axes.T
        tilts.append(np.degrees(np.arctan2(rise[:2], rise[2])))
        semis.append([fit.min_confidence95_deg, fit.max_confidence95_deg])
    tilt, semi = np.array(tilts), np.array(semis)
    held = float((((tilt / semi) ** 2).sum(axis=1) <= 1.0).mean())
    # Two normal errors are jointly within sqrt(5.99) of their standard deviations in 95 %.
    wanted = np.sqrt(-2.0 * np.log(0.05) * (tilt**2).mean(axis=0))
    first, second = np.median(semi, axis=0) / wanted
    return held, (float(first), float(second))


@pytest.mark.parametrize("length", first_in_default_tier([0.0, 0.05, 0.1]))
def test_patch_confidence_contains_true_plane_and_is_not_too_wide(
    length: float,
) -> None:
    """Roughness up to a tenth of the patch; the scatter of 250 tilts is known to 5 %."""
    held, widths = coverage(length, 250, seed=7)
    assert 0.91 <= held <= 0.995
    assert 0.9 <= min(widths) <= max(widths) <= 1.35


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.0, 0.03, 0.05, 0.08, 0.1])
def test_patch_confidence_contains_true_plane_in_many_trials(length):
    held, widths = coverage(length, 3000, seed=8)
    assert 0.93 <= held <= 0.995
    assert 0.9 <= min(widths) <= max(widths) <= 1.35


def blob(n: int, seed: int, thickness: float = 0.05) -> np.ndarray:
    """Points scattered about a plane that dips 40 to 70 degrees, a kilometre from the origin."""
    rng = np.random.default_rng(seed)
    flat = rng.normal(size=(n, 3)) * [3.0, 1.2, thickness]
    e3 = np.array([0.5, -0.4, 0.6]) + rng.normal(0.0, 0.1, 3)
    e3 /= np.linalg.norm(e3)
    e1 = np.cross(e3, rng.normal(size=3))
    e1 /= np.linalg.norm(e1)
    return flat @ np.array([e1, np.cross(e3, e1), e3]) + [700.0, -300.0, 40.0]


def moment_fit(points: np.ndarray) -> FittedPlane:
    known = moments(points)
    return fit_moments(known.n, known.mean, known.scatter)


# The extent of a patch is a diameter, its largest coordinate that of its centre.
OF_ITS_OWN = ("extent", "max_coordinate", "ordered", "axes")


@pytest.mark.parametrize("n", [4, 5, 9, 30, 400])
@pytest.mark.parametrize("thickness", [0.002, 0.05, 0.6])
def test_patch_fit_matches_plane_through_its_points(n: int, thickness: float) -> None:
    points = blob(n, n, thickness)
    patch, plane = moment_fit(points), fit_plane(points, is_ordered=False)
    for field in fields(FittedPlane):
        if field.name in OF_ITS_OWN:
            continue
        ours, theirs = getattr(patch, field.name), getattr(plane, field.name)
        if isinstance(theirs, float | np.ndarray):
            np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9, err_msg=field.name)
        else:
            assert ours == theirs, field.name
    np.testing.assert_allclose(np.abs(patch.axes @ plane.axes.T), np.eye(3), atol=1e-6)
    assert patch.max_coordinate == pytest.approx(np.abs(points.mean(axis=0)).max())


ERRORS = (
    "max_angular_error_deg",
    "min_angular_error_deg",
    "max_confidence95_deg",
    "min_confidence95_deg",
    "error_rake_deg",
    "dip_error_deg",
    "dip_direction_error_deg",
    "n_effective",
)


def test_a_patch_of_three_points_has_an_attitude_and_no_errors() -> None:
    fit = moment_fit(np.array([[0, 0, 0], [1, 0, 0], [0, 1, -1.0]]))
    assert fit.dip_deg == pytest.approx(45.0)
    assert fit.dip_direction_deg == pytest.approx(0.0)
    assert {name: getattr(fit, name) for name in ERRORS} == dict.fromkeys(ERRORS)
    assert not fit.hyperbolic_overflow


def test_exactly_planar_patch_has_zero_error_and_no_coplanarity() -> None:
    rng = np.random.default_rng(1)
    flat = rng.normal(size=(50, 2))
    fit = moment_fit(np.column_stack([flat, np.zeros(50)]))
    assert fit.undefined
    assert (fit.dip_deg, fit.dip_direction_deg) == (0.0, 0.0)
    assert fit.coplanarity is fit.M is fit.K is None
    assert fit.max_confidence95_deg == fit.max_angular_error_deg == fit.rms == 0.0


def test_fewer_independent_points_widen_confidence_by_fisher_law() -> None:
    from scipy.stats import f

    points = blob(500, 3)
    known = moments(points)
    for effective in (4.0, 12.0, 80.0, 500.0, 9000.0):
        fit = fit_moments(known.n, known.mean, known.scatter, effective)
        free = min(effective, 500.0) - 3.0
        q = 2.0 * f.ppf(0.95, 2, free) / free
        l1, l2, l3 = fit.eigenvalues
        for semi, spread in ((fit.min_confidence95_deg, l1), (fit.max_confidence95_deg, l2)):
            sine = 2.0 * np.sqrt(q * spread * l3) / (spread - l3)
            wanted = np.degrees(0.5 * np.arcsin(sine)) if sine < 1.0 else 90.0
            assert semi == pytest.approx(wanted)
        assert fit.n_effective == min(effective, 500.0)


def test_the_extent_of_a_round_patch_is_its_diameter() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    rings = np.sqrt((np.arange(60) + 0.5) / 60.0)  # equal areas
    x, y = (np.outer(rings, g).ravel() for g in (np.cos(turn), np.sin(turn)))
    assert moment_fit(5.0 * np.column_stack([x, y, 0 * x])).extent == pytest.approx(10.0, rel=1e-3)


@pytest.mark.parametrize(
    ("points", "code", "values"),
    [
        (np.eye(3)[:2], "feature.too-few-points", {"count": 1, "minimum": 3}),
        # One place.
        (np.full((5, 3), 7.0), "feature.too-few-points", {"count": 2, "minimum": 3}),
        (np.outer(np.arange(5.0), [1.0, 2.0, 3.0]) + 1e3, "points.collinear", {"n": 5}),
        (
            np.array([[0, 0, 0], [1e-12, 0, 0], [0, 1e-12, 0]]) + 1e5,
            "feature.too-few-points",
            {"count": 2, "minimum": 3},
        ),
    ],
)
def test_patch_without_plane_is_rejected_with_reason(
    points: np.ndarray, code: str, values: dict[str, int]
) -> None:
    with refused(code, GeometryError, **values):
        moment_fit(points)


def test_invalid_moments_are_rejected() -> None:
    eye = np.eye(3)
    for mean, scatter, code in (
        ((0.0, 0.0, np.nan), eye, "points.not-finite"),
        ((0.0, 0.0, 1e151), eye, "points.not-finite"),
        ((0.0, 0.0, 0.0), np.full((3, 3), np.inf), "points.not-finite"),
        ((0.0, 0.0, 1e6), 1e-20 * eye, "points.coincident"),
        ((0.0, 0.0, 0.0), 0.0 * eye, "points.coincident"),
        ((0.0, 0.0, 1e6), np.diag([1.0, 1e-20, 1e-20]), "points.collinear"),
    ):
        with refused(code, GeometryError):
            fit_moments(5, mean, scatter)


def test_weighted_moments_match_repeated_points() -> None:
    rng = np.random.default_rng(2)
    points = rng.normal(size=(30, 3)) + [50.0, -80.0, 3.0]
    weights = rng.integers(1, 6, 30)
    found = moments(points, 0.01 * weights)
    assert found.n == 30
    np.testing.assert_allclose(found.mean, np.average(points, axis=0, weights=weights))
    covariance = np.cov(points.T, fweights=weights, ddof=0)
    np.testing.assert_allclose(found.scatter, 30 * covariance, rtol=1e-9)
    nothing = moments(np.zeros((0, 3)))
    assert (nothing.n, nothing.mean, nothing.n_effective) == (0, (0.0, 0.0, 0.0), 0.0)


def test_white_noise_points_are_nearly_all_independent_and_rough_ones_few() -> None:
    rng = np.random.default_rng(4)
    u, v = np.meshgrid(np.arange(ACROSS) / ALONG, np.arange(ALONG) / ALONG)

    def effective(length: float) -> float:
        found = [
            moments(np.column_stack([u.ravel(), v.ravel(), roughness(rng, length).ravel() / 50]))
            for _ in range(15)
        ]
        return float(np.median([each.n_effective for each in found]))

    numbers = [effective(length) for length in (0.0, 0.05, 0.1, 0.3)]
    assert numbers == sorted(numbers, reverse=True)
    n = ACROSS * ALONG
    assert 0.5 * n < numbers[0] <= n
    # A patch of correlation length c holds about 1 / (2 pi s^2) independent pieces, s = c / sqrt 2.
    for number, length in zip(numbers[1:3], (0.05, 0.1), strict=True):
        assert 0.4 < number * np.pi * length**2 / 1.2 < 2.5


def test_few_points_and_points_in_a_plane_are_all_independent() -> None:
    assert moments(blob(100, 5)).n_effective == 100.0
    flat = np.column_stack([*np.random.default_rng(0).normal(size=(2, 400)), np.zeros(400)])
    assert moments(flat).n_effective == 400.0


def test_patch_outline_is_a_ring_of_its_corners() -> None:
    rng = np.random.default_rng(6)
    square = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0.0]])
    inner = np.column_stack([rng.uniform(0.1, 1.9, 40), rng.uniform(0.1, 0.9, 40), np.zeros(40)])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    ring = np.array(outline(np.concatenate([inner, square]) @ turn, turn[2]))
    assert sorted(map(tuple, ring.round(9))) == sorted(map(tuple, (square @ turn).round(9)))
    sides = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    assert sorted(sides.round(9)) == [1.0, 1.0, 2.0, 2.0]
    assert outline(square[:2], [0, 0, 1]) == ()
    assert outline(np.outer(np.arange(5.0), [1, 2, 3]), [0, 0, 1]) == ()


def test_corners_of_faces_share_their_area() -> None:
    points = np.array([[0, 0, 0], [3, 0, 0], [0, 4, 0], [0, 0, 5.0], [9, 9, 9], [9, 9, 9]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 4]], np.int32)
    mesh = Mesh(points, faces)
    np.testing.assert_allclose(face_areas(mesh, [0, 1, 2]), [6.0, 10.0, 0.0])
    corners, weights = face_points(mesh, [0, 1])
    np.testing.assert_array_equal(corners, points[:4])
    np.testing.assert_allclose(weights, [16 / 3, 2.0, 16 / 3, 10 / 3])
    _, weights = face_points(mesh, [0, 2])
    assert (weights > 0).all()
    assert weights.sum() == pytest.approx(6.0)


def test_duplicate_point_counts_once():
    rng = np.random.default_rng(0)
    points = rng.standard_normal((200, 3)) * [1.0, 0.6, 0.01]
    once, twice = moments(points), moments(np.repeat(points, 2, axis=0))
    assert once.n == twice.n == 200
    np.testing.assert_allclose(once.mean, twice.mean)
    np.testing.assert_allclose(once.scatter, twice.scatter)
    assert once.n_effective == pytest.approx(twice.n_effective)


def test_finely_meshed_part_does_not_bias_the_plane():
    """A tent of two equal slopes: its plane is level, however finely one slope is cut."""

    def slope(n: int, sign: float, first: int) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n))
        i = first + np.arange(n * n).reshape(n, n)
        a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
        points = np.column_stack([sign * x.ravel(), y.ravel(), -0.3 * x.ravel()])
        return points, np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])

    left, right = slope(41, -1.0, 0), slope(9, 1.0, 41 * 41)
    mesh = Mesh(
        np.concatenate([left[0], right[0]]), np.concatenate([left[1], right[1]]).astype(np.int32)
    )
    known = moments(*face_points(mesh, np.arange(len(mesh.faces))))
    fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
    plain = moments(mesh.vertices)
    assert fit.dip_deg < 1.0 < fit_moments(plain.n, plain.mean, plain.scatter).dip_deg


def test_id_runs_round_trip():
    rng = np.random.default_rng(3)
    ids = np.unique(rng.integers(0, 5000, 900))
    runs = ids_to_runs(rng.permutation(np.repeat(ids, 2)))
    assert runs_to_ids(runs).tolist() == ids.tolist()
    for id_ in range(-1, 5001, 7):
        assert has_id(runs, id_) == (id_ in ids)
    assert ids_to_runs([]) == ()
    assert not has_id((), 0)


@pytest.mark.parametrize("power", [-7, -3, 0, 4, 7])
def test_lengths_of_a_patch_scale_and_its_angles_do_not(power: int) -> None:
    points = blob(60, 8) - [700.0, -300.0, 40.0]
    a, b = moment_fit(points), moment_fit(10.0**power * points)
    for name in ("rms", "residual", "extent", "max_coordinate"):
        assert getattr(b, name) == pytest.approx(10.0**power * getattr(a, name), rel=1e-9), name
    assert b.trace == pytest.approx(100.0**power * a.trace)  # type: ignore[operator]
    for name in ("dip_deg", "dip_direction_deg", "M", "K", "coplanarity", *ERRORS):
        assert getattr(b, name) == pytest.approx(getattr(a, name), rel=1e-9), name


def cells(side: int, smooth: float, seed: int) -> np.ndarray:
    """Heights (side, side) of cells that neither lift nor tilt the plane through their points."""
    height = np.random.default_rng(seed).standard_normal((side, side))
    if smooth:
        turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi * smooth, side))
        height = 0.3 * height + 3.0 * np.outer(turn, turn).real
    u, v = np.meshgrid(np.arange(side) - (side - 1) / 2, np.arange(side) - (side - 1) / 2)
    known = np.stack([np.ones(side * side), u.ravel(), v.ravel()])
    flat = height.ravel()
    return np.asarray((flat - known.T @ np.linalg.lstsq(known.T, flat)[0]).reshape(side, side))


@pytest.mark.parametrize("smooth", [0.0, 1.0, 2.0])
@pytest.mark.parametrize(("fine", "wide"), [(6, 2), (8, 2), (10, 2), (12, 2), (12, 3), (12, 5)])
def test_independent_count_of_patch_matches_closed_form(
    fine: int, wide: int, smooth: float
) -> None:
    """The means of the cells and of every four of them are known, and so is their scatter."""
    height = cells(fine, smooth, fine)
    z = 0.01 * np.kron(height, np.ones((wide, wide)))
    side = fine * wide
    u, v = np.meshgrid(np.arange(side) * 1.0, np.arange(side) * 0.7)
    points = np.column_stack([u.ravel(), v.ravel(), z.ravel()])
    n = side * side
    white = (z**2).mean() * n / (n - 3.0)
    fours = 0.01 * height.reshape(fine // 2, 2, fine // 2, 2).mean(axis=(1, 3))
    finer = n * ((0.01 * height) ** 2).mean() / (fine**2 - 3.0) / white
    coarse = n * (fours**2).mean() / (fours.size - 3.0) / white
    excess = max(2.0 * np.sqrt(coarse) - np.sqrt(finer), 1.0) ** 2
    free = fours.size - 3.0
    q = (0.05 ** (-2.0 / free) - 1.0) * free * excess / n
    wanted = min(3.0 - 2.0 * np.log(0.05) / np.log1p(q), n)
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    for seen in (points, rng.permutation(points), 300.0 * points @ turn.T + 50.0):
        assert moments(seen).n_effective == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("n", [100, 143])
def test_a_patch_too_small_for_cells_of_four_points_counts_every_point(n: int) -> None:
    for seed in range(5):
        rough = blob(n, seed)
        rough[:, 2] += 0.5 * np.sin(rough[:, 0])
        assert moments(rough).n_effective == n


FAR = 2.0**20
ROUNDING = 4.0 * float(np.finfo(np.float64).eps) * FAR
"""What is shape and what is rounding at that distance from the origin, m."""


@pytest.mark.parametrize(("share", "beyond"), [(0.95, False), (1.05, True)])
def test_patch_smaller_than_rounding_of_its_position_has_no_shape(
    share: float, beyond: bool
) -> None:
    """Its size and its width, each just below and just above what can be told."""
    place = (0.0, -FAR, 0.0)
    length = share * ROUNDING
    with refused("points.collinear" if beyond else "points.coincident", GeometryError, n=9):
        fit_moments(9, place, 9.0 * np.diag([length**2, 0.0, 0.0]))
    # The width of a patch of ten micrometres, far away, and of one of a metre here.
    near = np.sqrt(64.0 * np.finfo(np.float64).eps)
    for where, size, limit in ((place, 1e-5, ROUNDING), ((0.0, 0.0, 0.0), 1.0, near)):
        scatter = 9.0 * np.diag([size**2, (share * limit) ** 2, 0.0])
        if beyond:
            assert fit_moments(9, where, scatter).rms == 0.0
        else:
            with refused("points.collinear", GeometryError, n=9):
                fit_moments(9, where, scatter)
        # What is thinner than can be told has no thickness.
        scatter = 9.0 * np.diag([1.0, 1.0, (np.sqrt(2.0) * share * near) ** 2])
        assert (fit_moments(9, (0.0, 0.0, 0.0), scatter).rms > 0.0) == beyond


@pytest.mark.parametrize(
    ("place", "width", "limit"),
    [
        ((FAR, 0.0, 0.0), 0.1, ROUNDING / 0.1),
        ((FAR, 0.0, 0.0), 1e-7, 1e-3),
        ((0, 0, 0), 0.1, 1e-12),
    ],
)
def test_patch_tilted_only_by_rounding_is_horizontal(
    place: tuple[float, float, float], width: float, limit: float
) -> None:
    """A lean of more than a thousandth is one wherever the patch lies and however narrow it is."""
    for lean in (0.9 * limit, 1.1 * limit):
        down, along = np.array([np.cos(lean), 0.0, -np.sin(lean)]), np.array([0.0, 1.0, 0.0])
        scatter = (np.outer(down, down) + 4.0 * np.outer(along, along)) * width**2
        fit = fit_moments(7, place, 7.0 * scatter)
        assert fit.undefined == (lean < limit)
        assert fit.dip_deg == pytest.approx(0.0 if fit.undefined else np.degrees(lean), rel=0.01)
        assert fit.dip_direction_deg == (0.0 if fit.undefined else pytest.approx(90.0))
