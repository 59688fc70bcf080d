"""Limbs of folds of known shape: the right angle between them, or none with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.benchmarks.bench_folds import ANY, simulate
from tests.geology import folded
from tests.geology.folded import planes
from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.geology.folding.limbs import find_limbs
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import Plane
from vomstudio.geology.statistics import orientation_tensor

LONE_PLANE = {"fold.one-plane-turns", "fold.one-plane-decides"}


def fold_of(rng: folded.Rng, dips: np.ndarray, noise: float = 2.0) -> FoldAxis:
    """Beds with these dips about an axis in any direction, positive toward one side."""
    _, up, across = folded.axis_frame(rng)
    t = np.radians(dips)[:, None]
    return fold_axis(*planes(folded.strayed(rng, np.cos(t) * up + np.sin(t) * across, noise)))


@pytest.mark.parametrize("hinge", first_in_default_tier([4, 8, 15], 3))
@pytest.mark.parametrize("half", first_in_default_tier([70.0, 75.0, 80.0, 84.0, 88.0], 3))
def test_tight_fold_with_hinge_has_no_wrong_interlimb_angle(half: float, hinge: int) -> None:
    """The poles of both limbs fall together, as those of one limb at right angles to the hinge."""
    rng = np.random.default_rng(int(half) + hinge)
    for _ in range(4):
        limbs = np.repeat([-half, half], 15)
        found = fold_of(rng, np.concatenate([limbs, rng.uniform(-10, 10, hinge)]))
        if found.limbs is not None:
            assert found.limbs.interlimb_angle_deg == pytest.approx(180 - 2 * half, abs=8)
        elif half >= 80:
            assert "fold.limbs-or-hinge" in by_code(found.reasons)


@pytest.mark.parametrize("half", [30.0, 45.0, 60.0])
def test_interlimb_angle_of_two_limbs_is_recovered(half: float) -> None:
    """About an axis that is flat, upright or tilted a little: the angle on the side of the hinge is
    that of the upward normals."""
    rng = np.random.default_rng(int(half))
    told = 0
    for _ in range(12):
        dips = np.radians(np.repeat([-half, half], (16, 24)) + rng.normal(0, 2, 40))
        off = np.radians(rng.normal(0, 2, 40))
        normals = np.stack([np.sin(dips), np.sin(off), np.cos(dips) * np.cos(off)], axis=1)
        found = fold_axis(*planes(normals / np.linalg.norm(normals, axis=1)[:, None]))
        if found.limbs is not None:
            told += 1
            assert found.limbs.interlimb_angle_deg == pytest.approx(180 - 2 * half, abs=3)
            assert found.limbs.axial_plane.dip_deg == pytest.approx(90.0, abs=2)
    assert told >= 11


def test_arc_next_to_a_limb_is_not_a_second_limb() -> None:
    rng = np.random.default_rng(7)
    for _ in range(5):
        found = fold_of(rng, np.concatenate([np.full(30, -50.0), rng.uniform(-50, 60, 10)]))
        assert found.limbs is None


@pytest.mark.parametrize("n", [9, 19, 39])
@pytest.mark.parametrize("apart", [40.0, 60.0, 120.0])
def test_limb_of_one_plane_is_reported_and_verdict_undetermined(n: int, apart: float) -> None:
    rng = np.random.default_rng(n)
    for _ in range(5):
        poles = folded.one_and_the_other(rng, n, apart, 1.5)
        found = fold_axis(*planes(poles), names=[f"B{k}" for k in range(n + 1)])
        assert found.verdict in ("undetermined", "homoclinal")
        if found.verdict == "undetermined":
            (reason,) = (each for each in found.reasons if each.code in LONE_PLANE)
            assert reason.values["plane"] == f"B{n}"


@pytest.mark.full
def test_well_sampled_folds_do_not_depend_on_one_plane() -> None:
    rng = np.random.default_rng(4)
    said = 0
    for _ in range(40):
        found = fold_axis(*planes(folded.bent(rng, 12, 100, 3)))
        said += not LONE_PLANE.isdisjoint(by_code(found.reasons))
    assert said == 0


def upright(rng: folded.Rng, dips: np.ndarray, noise_deg: float) -> np.ndarray:
    """Upward normals of beds with these dips, eastward positive, about a level axis to the north,
    each strayed at random."""
    t = np.radians(dips)
    return folded.strayed(rng, np.stack([np.sin(t), 0 * t, np.cos(t)], axis=1), noise_deg)


@pytest.mark.parametrize("n", first_in_default_tier([9, 19]))
@pytest.mark.parametrize("apart", first_in_default_tier([40.0, 60.0]))
def test_single_plane_next_to_widely_spread_limb_does_not_decide_verdict(
    n: int, apart: float
) -> None:
    """What is called cylindrical with the plane of the other limb is so without it."""
    rng = np.random.default_rng(int(n + apart))
    for _ in range(12):
        axis, first, second = folded.axis_frame(rng)
        t = np.radians(np.append(rng.normal(0, 12, n), apart))[:, None]
        off = np.radians(rng.normal(0, 3, n + 1))[:, None]
        poles = np.cos(off) * (np.cos(t) * first + np.sin(t) * second) + np.sin(off) * axis
        if fold_axis(*planes(poles)).verdict == "cylindrical":
            alone = fold_axis(*planes(poles[:-1]))
            short = alone.arc_deg * n / (n - 1) < 30
            assert not short
            # One plane fewer makes the error of an axis larger, and so no more than that.
            nearly = (alone.max_confidence95_deg or 90.0) < 12.0
            assert alone.verdict != "homoclinal" or nearly


@pytest.mark.parametrize(
    ("n", "inter"),
    first_in_default_tier([((20, 20), 90), ((40, 8), 90), ((20, 5), 120), ((3, 3), 50)], 1),
)
def test_stated_errors_of_limbs_are_reliable(n: tuple[int, int], inter: float) -> None:
    rng = np.random.default_rng(sum(n))
    half, told, held, axial = 90.0 - inter / 2.0, 0, 0, 0
    for _ in range(60):
        limbs = fold_axis(*planes(upright(rng, np.repeat([half, -half], n), 2.0))).limbs
        if limbs is None:
            continue
        told += 1
        held += abs(limbs.interlimb_angle_deg - inter) <= limbs.interlimb_error95_deg
        plane = Plane(limbs.axial_plane.dip_direction_deg, limbs.axial_plane.dip_deg)
        off = np.degrees(np.arccos(min(abs(float(plane.normal()[0])), 1.0)))
        axial += off <= limbs.axial_plane_error95_deg
    assert told >= 54
    assert held >= 0.86 * told
    assert axial >= 0.9 * told


def test_overturned_limb_reduces_interlimb_angle() -> None:
    """Beds that dip by 30 to the west, and overturned ones by 70: what is upward of them points 140
    degrees apart, not 40."""
    normals = upright(np.random.default_rng(3), np.repeat([-30.0, -70.0], 15), 1.0)
    flags = np.repeat([False, True], 15)
    right, upward = (fold_axis(*planes(normals), overturned=f).limbs for f in (flags, None))
    assert right is not None
    assert upward is not None
    assert right.interlimb_angle_deg == pytest.approx(40, abs=2)
    assert upward.interlimb_angle_deg == pytest.approx(140, abs=2)
    assert sorted(right.overturned) == [False, True]
    # Halfway between a bed that dips by 30 and one by 110.
    assert right.axial_plane.dip_deg == pytest.approx(50, abs=1.5)
    assert right.axial_plane.dip_direction_deg == pytest.approx(270, abs=2)
    half_of_them = np.tile([False, True], 15)
    mixed = fold_axis(*planes(normals), overturned=half_of_them)
    assert mixed.limbs is None
    assert "fold.mixed-limbs" in by_code(mixed.reasons)


@pytest.mark.full
@pytest.mark.parametrize("few", first_in_default_tier([2, 3, 4], 1))
def test_error_is_reliable_for_small_limb_with_larger_scatter(few: int) -> None:
    """Two limbs 70 degrees apart, one of ten planes that stray by 3 degrees, one of a few that
    stray by 9: so few do not show that they do."""
    rng = np.random.default_rng([16, few])
    held = told = 0
    while told < 300:
        parts = []
        for n, stray, apart in ((few, 9.0, 0.0), (10, 3.0, 70.0)):
            along = np.radians(apart + rng.normal(0, stray, n))
            across = np.radians(rng.normal(0, stray, n))
            flat = np.cos(across)
            parts.append(np.stack([flat * np.cos(along), flat * np.sin(along), np.sin(across)], 1))
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        poles = np.concatenate(parts) @ turn
        _, axes = orientation_tensor(poles)
        limbs = find_limbs(poles, axes)
        if limbs is None or limbs.doubt:
            continue
        told += 1
        between = math.degrees(math.acos(min(abs(float(limbs.poles[0] @ limbs.poles[1])), 1.0)))
        held += abs(between - 70.0) <= limbs.errors95_deg(axes[2])[0]
    assert held >= 0.89 * told


@pytest.mark.parametrize("n", first_in_default_tier([8, 12, 20], 1))
def test_few_beds_of_a_cone_are_not_called_valid(n: int) -> None:
    rng = np.random.default_rng(5)
    yes = 0
    for _ in range(60):
        t, a = np.radians(rng.uniform(-60.0, 60.0, n)), math.radians(60.0)
        poles = np.column_stack(
            [math.sin(a) * np.sin(t), np.full(n, math.cos(a)), math.sin(a) * np.cos(t)]
        ) + math.radians(3.0) * rng.normal(size=(n, 3))
        poles = np.where(poles[:, 2:] < 0, -poles, poles)
        poles /= np.linalg.norm(poles, axis=1)[:, None]
        dips = np.degrees(np.arccos(poles[:, 2]))
        azimuths = np.degrees(np.arctan2(poles[:, 0], poles[:, 1])) % 360.0
        yes += fold_axis(azimuths, dips).valid == "yes"
    assert yes <= 1


@pytest.mark.full
@pytest.mark.parametrize("along", [0.0, 0.2, 0.6, 1.0])
def test_dip_domains_scattered_in_one_direction_are_undetermined(along: float) -> None:
    """Two groups of poles always lie on a great circle, in whatever direction they stray."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        t = np.radians(
            np.r_[-30.0 + along * rng.normal(size=12), 35.0 + along * rng.normal(size=9)]
        )
        off = np.radians(0.03) * rng.normal(size=len(t))
        poles = np.stack([np.sin(t) * np.cos(off), np.sin(off), np.cos(t) * np.cos(off)], axis=1)
        dips = np.degrees(np.arccos(poles[:, 2]))
        azimuths = np.degrees(np.arctan2(poles[:, 0], poles[:, 1])) % 360.0
        assert fold_axis(azimuths, dips).verdict == "undetermined"


def bent_beds(n: int, scatter_deg: float) -> tuple[np.ndarray, np.ndarray]:
    return planes(folded.bent(np.random.default_rng(39), n, 140, scatter_deg))


def test_few_beds_give_conditional_verdict_with_required_number() -> None:
    few, enough = fold_axis(*bent_beds(7, 0.5)), fold_axis(*bent_beds(8, 0.5))
    assert (few.verdict, few.valid) == ("cylindrical", "conditional")
    assert by_code(few.reasons)["fold.too-few-planes"] == {"n": 7, "wanted": 8}
    assert enough.valid == "yes"
    assert "fold.too-few-planes" not in by_code(enough.reasons)


@pytest.mark.slow
@pytest.mark.parametrize("n", [8, 12, 20])
def test_regions_of_valid_axes_are_reliable(n: int) -> None:
    """Of beds that scatter by 1 to 8 degrees, as `bench_folds` prints for the documentation."""
    count = simulate(n, ANY, 1000, 40)
    slack = 3.0 * math.sqrt(0.93 * 0.07 / count.yes)
    assert count.yes > 300
    assert count.yes_held >= (0.93 - slack) * count.yes
