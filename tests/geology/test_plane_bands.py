"""What straight traces determine, by closed forms and by simulation."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.plane_bands import (
    PlaneBand,
    SetPrior,
    compare_sets,
    crossing_plane,
    find_plane_band,
)
from vomstudio.geometry.planes import fit_plane


def straight(
    rng: np.random.Generator,
    normal: np.ndarray,
    *,
    n: int = 40,
    noise: float = 0.01,
    bend: float = 0.0,
    turn: float | None = None,
    length: float = 4.0,
) -> np.ndarray:
    """Points of a trace in a plane, with noise in all directions; bend : relief in the plane."""
    first = np.cross(normal, [0.3, 0.9, 0.1])
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    angle = rng.uniform(0.0, np.pi) if turn is None else turn
    along = np.cos(angle) * first + np.sin(angle) * second
    across = np.cross(normal, along)
    t = np.linspace(-0.5, 0.5, n) * length
    shape = np.sin(4.0 * np.pi * t / length)
    points = np.outer(t, along) + bend * np.outer(shape, across)
    return points + noise * rng.standard_normal((n, 3))


def any_normal(rng: np.random.Generator) -> np.ndarray:
    v = rng.standard_normal(3)
    return np.asarray(v / np.linalg.norm(v))


def of_set(rng: np.random.Generator, mean: np.ndarray, sigma: float) -> np.ndarray:
    """A normal of a set: tilted by a normal law of this scatter (radians) along two axes."""
    first = np.cross(mean, np.eye(3)[int(np.argmin(np.abs(mean)))])
    first /= np.linalg.norm(first)
    kappa = 1.0 / sigma**2
    # Fisher's colatitude by its closed quantile function.
    u = rng.uniform()
    cosine = 1.0 + np.log(u + (1.0 - u) * np.exp(-2.0 * kappa)) / kappa
    angle = rng.uniform(0.0, 2.0 * np.pi)
    across = np.cos(angle) * first + np.sin(angle) * np.cross(mean, first)
    return np.asarray(cosine * mean + np.sqrt(1.0 - cosine**2) * across)


def test_line_on_flat_face_allows_any_rotation_despite_pick_noise() -> None:
    """They stray by one spacing along the face z = 0 and hardly out of it."""
    rng = np.random.default_rng(1)
    held, any_turn = 0, 0
    for _ in range(60):
        picks = (
            rng.normal(size=(20, 3)) * [0.0, 1.0, 0.1]
            + [[1.0, 0.0, 0.0]] * np.linspace(0.0, 100.0, 20)[:, None]
        )
        band = find_plane_band(fit_plane(picks), resolution_m=1.0, outcrop_normal=(0.0, 0.0, 1.0))
        turn = np.radians(rng.uniform(30.0, 150.0))
        held += band is not None and bool(band.contains([[0.0, np.sin(turn), np.cos(turn)]])[0])
        any_turn += band is not None and band.turn95_deg == 90.0
    assert held >= 0.9 * 60
    assert any_turn >= 0.9 * 60


def test_curved_trace_has_plane_and_no_band() -> None:
    rng = np.random.default_rng(0)
    points = straight(rng, np.array([0.0, 0.6, 0.8]), bend=0.5)
    assert find_plane_band(fit_plane(points)) is None


def test_isotropic_point_cloud_has_no_band() -> None:
    points = np.random.default_rng(1).standard_normal((40, 3))
    assert find_plane_band(fit_plane(points)) is None


def test_band_axis_is_the_trace_line() -> None:
    rng = np.random.default_rng(2)
    along = Line(120.0, 35.0).vector()
    points = np.outer(np.linspace(-2, 2, 60), along) + 0.005 * rng.standard_normal((60, 3))
    band = find_plane_band(fit_plane(points))
    assert band is not None
    assert band.line.trend_deg == pytest.approx(120.0, abs=0.3)
    assert band.line.plunge_deg == pytest.approx(35.0, abs=0.3)
    assert band.best_plane is None
    # A plane through a line that plunges by p dips by p at least, and may be vertical.
    low, high = band.dips_deg()
    assert low == pytest.approx(35.0, abs=2.0 * band.half_width95_deg)
    assert high == pytest.approx(90.0, abs=0.5)
    # The line's own error: sigma / (sd of t sqrt(n)), twice F's quantile of 2 and n - 3 degrees.
    free = band.degrees_of_freedom
    sigma = 0.005 / (np.std(np.linspace(-2, 2, 60)) * np.sqrt(60))
    wanted = np.degrees(np.sqrt(free * (0.05 ** (-2.0 / free) - 1.0)) * sigma)
    assert band.half_width95_deg == pytest.approx(wanted, rel=0.5)


def test_rotation_about_vertical_rotates_the_band() -> None:
    rng = np.random.default_rng(3)
    points = straight(rng, np.array([0.0, 0.6, 0.8]))
    turn = np.radians(30.0)
    rotation = np.array(
        [[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    here, there = (
        find_plane_band(fit_plane(points)),
        find_plane_band(fit_plane(points @ rotation.T)),
    )
    assert here is not None
    assert there is not None
    difference = (there.line.trend_deg - here.line.trend_deg) % 180.0
    assert difference == pytest.approx(30.0, abs=1e-6)
    assert there.half_width95_deg == pytest.approx(here.half_width95_deg, rel=1e-9)
    assert there.dips_deg() == pytest.approx(here.dips_deg(), abs=1e-6)


@pytest.mark.full
@pytest.mark.parametrize("bend", first_in_default_tier([0.0, 0.01, 0.02], 1))
def test_band_contains_true_plane_in_95_percent_of_runs(bend: float) -> None:
    rng = np.random.default_rng(4)
    held, count = 0, 0
    for _ in range(900):
        normal = any_normal(rng)
        band = find_plane_band(fit_plane(straight(rng, normal, bend=bend), is_ordered=False))
        if band is not None:
            held += bool(band.contains(normal)[0])
            count += 1
    assert count > 600
    assert 0.93 <= held / count <= 0.97


@pytest.mark.full
def test_set_prior_gives_plane_with_calibrated_error() -> None:
    rng = np.random.default_rng(5)
    sigma = np.radians(7.0)
    held, inside, count = 0, 0, 500
    for _ in range(count):
        mean = any_normal(rng)
        normal = of_set(rng, mean, sigma)
        band = find_plane_band(fit_plane(straight(rng, normal), is_ordered=False))
        assert band is not None
        prior = SetPrior("S1", tuple(mean.tolist()), 1.0 / sigma**2, 1000)  # type: ignore[arg-type]
        (found,), none = compare_sets(band, [prior])
        assert found.probability + none == pytest.approx(1.0)
        inside += found.compatible
        plane = Plane(found.dip_direction_deg, found.dip_deg)
        off = np.degrees(np.arccos(min(abs(float(plane.normal() @ normal)), 1.0)))
        # The ellipse is long along the band and narrow across it: by its longer axis alone the
        # region would hold about as much of a normal law in one dimension.
        one = found.max_confidence95_deg * 1.959964 / 2.447747
        held += off <= one
    assert 0.93 <= held / count <= 0.97
    assert 0.93 <= inside / count <= 0.97


def test_plane_from_flat_prior_and_sharp_band_matches_closed_form() -> None:
    """Across the band nothing, along it the prior: the mean turned into the band."""
    mean = Plane(90.0, 40.0).normal()
    line = Line(0.0, 0.0).vector()
    third = np.cross(line, np.cross(mean, line))
    third /= np.linalg.norm(third)
    band = PlaneBand(np.stack([line, np.cross(third, line), third]), (1e-5, 1e-5), np.pi / 2, 50.0)
    kappa = 1.0 / np.radians(6.0) ** 2
    (found,), _ = compare_sets(band, [SetPrior("S", tuple(mean.tolist()), kappa, 10**6)])  # type: ignore[arg-type]
    assert found.dip_direction_deg == pytest.approx(90.0, abs=0.01)
    assert found.dip_deg == pytest.approx(40.0, abs=0.05)
    assert found.max_confidence95_deg == pytest.approx(6.0 * 2.447747, rel=0.04)
    assert found.min_confidence95_deg < 0.1
    assert found.p == pytest.approx(1.0)


@pytest.mark.full
def test_set_probabilities_are_calibrated() -> None:
    rng = np.random.default_rng(6)
    sigma = np.radians(8.0)
    means = [Plane(90.0, 60.0).normal(), Plane(120.0, 30.0).normal()]
    priors = [
        SetPrior(str(i), tuple(mean.tolist()), 1.0 / sigma**2, 200)  # type: ignore[arg-type]
        for i, mean in enumerate(means)
    ]
    stated, right = [], []
    for _ in range(600):
        which = int(rng.integers(2))
        band = find_plane_band(
            fit_plane(straight(rng, of_set(rng, means[which], sigma)), is_ordered=False)
        )
        assert band is not None
        found, _ = compare_sets(band, priors)
        stated.append(found[0].probability)
        right.append(found[0].name == str(which))
    told, was = np.array(stated), np.array(right)
    assert told.mean() == pytest.approx(was.mean(), abs=0.04)
    unsure = told < 0.8
    assert unsure.sum() > 40
    assert told[unsure].mean() == pytest.approx(was[unsure].mean(), abs=0.12)


def test_set_far_from_band_is_not_compatible() -> None:
    rng = np.random.default_rng(7)
    along = Line(0.0, 0.0).vector()
    points = np.outer(np.linspace(-2, 2, 60), along) + 0.005 * rng.standard_normal((60, 3))
    band = find_plane_band(fit_plane(points))
    assert band is not None
    sets = [
        SetPrior("along", tuple(Plane(90.0, 50.0).normal().tolist()), 200.0, 30),  # type: ignore[arg-type]
        SetPrior("across", tuple(Plane(0.0, 50.0).normal().tolist()), 200.0, 30),  # type: ignore[arg-type]
    ]
    found, none = compare_sets(band, sets)
    assert [each.name for each in found] == ["along", "across"]
    assert found[0].compatible
    assert found[0].probability > 0.95
    assert not found[1].compatible
    assert found[1].probability < 1e-6
    assert none < 0.05


@pytest.mark.full
def test_crossing_traces_give_plane_with_calibrated_error() -> None:
    rng = np.random.default_rng(8)
    held, count = 0, 900
    for _ in range(count):
        normal = any_normal(rng)
        angle = rng.uniform(0.0, np.pi)
        bands = [
            find_plane_band(fit_plane(straight(rng, normal, turn=turn), is_ordered=False))
            for turn in (angle, angle + rng.uniform(0.5, 2.6))
        ]
        assert bands[0] is not None
        assert bands[1] is not None
        found = crossing_plane(bands[0], bands[1])
        off = np.array(found.normal) * np.sign(np.array(found.normal) @ normal)
        held += _inside(bands, off, normal)
        size = np.degrees(np.arccos(min(float(off @ normal), 1.0)))
        assert size < 3.0 * found.max_confidence95_deg
    assert 0.93 <= held / count <= 0.97


def _inside(bands: list[PlaneBand | None], found: np.ndarray, normal: np.ndarray) -> bool:
    """Whether the true normal is in the joint region that belongs to the stated semi-axes."""
    total = 0.0
    free = min(band.degrees_of_freedom for band in bands if band is not None)
    for band in bands:
        assert band is not None
        own = band.axes @ found
        sigma = band.sigma_rad(np.array([np.arctan2(own[1], own[2])]))[0]
        total += float((band.axes[0] @ normal) / sigma) ** 2
    return total <= free * (0.05 ** (-2.0 / free) - 1.0)


def test_perpendicular_crossing_traces_match_closed_form() -> None:
    east, north, up = np.eye(3)
    one = PlaneBand(np.stack([east, north, up]), (0.02, 0.02), np.pi / 2, 1e6)
    other = PlaneBand(np.stack([north, -east, up]), (0.05, 0.05), np.pi / 2, 1e6)
    found = crossing_plane(one, other)
    assert found.dip_deg == pytest.approx(0.0, abs=1e-9)
    assert found.crossing_deg == pytest.approx(90.0)
    assert found.max_confidence95_deg == pytest.approx(np.degrees(0.05), rel=0.01)
    assert found.min_confidence95_deg == pytest.approx(np.degrees(0.02), rel=0.01)
    with refused("plane.parallel-traces", GeometryError, angle_deg=0.0):
        crossing_plane(one, one)
