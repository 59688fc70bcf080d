"""Verdicts on folds and faulted beds of known shape (textbook 4.2, fig. 31), and how often."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from tests.geology import folded
from tests.geology.folded import Rng, planes
from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.domains import (
    AXIS_DIFFERENCE_SIGNIFICANCE,
    MIN_AXIS_DIFFERENCE_DEG,
    domain_axes,
)
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import Line, angle_between_lines

UNDETERMINED = ("undetermined", "conditional")


def _with_strays(rng: Rng) -> np.ndarray:
    return np.vstack([folded.bent(rng, 54, 120, 3), folded.scatter(rng, 6)])


CASES: dict[str, tuple[Callable[[Rng], FoldAxis], tuple[str, str | None]]] = {
    "a: fault and parallel beds": (
        lambda rng: common_axis(folded.fault_and_beds(rng, 0, 2, 0)),
        ("common axis", "yes"),
    ),
    "b: fault and oblique beds": (
        lambda rng: common_axis(folded.fault_and_beds(rng, 0, 2)),
        ("common axis", "yes"),
    ),
    "c: two axes by 25 degrees": (
        lambda rng: common_axis(folded.fault_and_beds(rng, 25, 2)),
        ("two axes", "no"),
    ),
    "d: cylinder, 40 beds, 120 degrees": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 40, 120, 3))),
        ("cylindrical", "yes"),
    ),
    "cylinder, 20 beds, 100 degrees": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 20, 100, 2))),
        ("cylindrical", "yes"),
    ),
    "cylinder, wavy by 5 degrees": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 60, 140, 5))),
        ("cylindrical", None),
    ),
    "cone of 70 degrees": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 40, 120, 3, 70))),
        ("conical", "no"),
    ),
    "cone of 60 degrees, wavy by 5": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 40, 130, 5, 60))),
        ("conical", "no"),
    ),
    "narrow cone of 30 degrees": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 40, 120, 3, 30))),
        ("conical", "no"),
    ),
    "cone of 50 degrees, all around": (
        lambda rng: fold_axis(*planes(folded.bent(rng, 40, 360, 3, 50))),
        ("conical", "no"),
    ),
    "cylinder, 6 of 60 planes strayed anywhere": (
        lambda rng: fold_axis(*planes(_with_strays(rng))),
        ("cylindrical", None),
    ),
    "one dip": (
        lambda rng: fold_axis(*planes(folded.one_dip(rng, 30, 3))),
        ("homoclinal", "conditional"),
    ),
    "one dip, wavy by 8 degrees": (
        lambda rng: fold_axis(*planes(folded.one_dip(rng, 40, 8))),
        ("homoclinal", "conditional"),
    ),
    "uniform scatter": (
        lambda rng: fold_axis(*planes(folded.scatter(rng, 40))),
        ("scattered", "no"),
    ),
    "chevron of 80 degrees": (
        lambda rng: fold_axis(*planes(folded.chevron(rng, 30, 80, 3))),
        UNDETERMINED,
    ),
    "one limb and one bed of the other": (
        lambda rng: fold_axis(*planes(folded.one_and_the_other(rng, 19, 60, 2))),
        UNDETERMINED,
    ),
    "two folds, axes 30 degrees apart": (
        lambda rng: fold_axis(*planes(folded.two_folds(rng, 60, 100, 3, 30))),
        ("two axes", "no"),
    ),
}


def _is(found: FoldAxis, wanted: tuple[str, str | None]) -> bool:
    return found.verdict == wanted[0] and wanted[1] in (None, found.valid)


@pytest.mark.parametrize("name", first_in_default_tier(CASES, 6))
def test_each_case_gets_its_verdict(name: str) -> None:
    make, wanted = CASES[name]
    rng = np.random.default_rng(20)
    right = sum(_is(make(rng), wanted) for _ in range(12))
    assert right >= 10


def counted(runs: int) -> dict[str, Counter[str]]:
    """How often each verdict falls on variants of each case."""
    table = {}
    for name, (make, _) in CASES.items():
        rng = np.random.default_rng(21)
        table[name] = Counter(
            f"{found.verdict}, {found.valid}" for found in (make(rng) for _ in range(runs))
        )
    return table


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_verdicts_are_correct_at_documented_rate(name: str) -> None:
    make, wanted = CASES[name]
    rng = np.random.default_rng(21)
    runs = 1000
    right = sum(_is(make(rng), wanted) for _ in range(runs))
    assert right >= 0.93 * runs


def test_rotation_changes_no_verdict() -> None:
    rng = np.random.default_rng(22)
    for make in (lambda: folded.bent(rng, 40, 120, 3), lambda: folded.bent(rng, 40, 120, 3, 65)):
        azimuth, dip = planes(make())
        a, b = fold_axis(azimuth, dip), fold_axis(azimuth + 30, dip)
        assert (a.verdict, a.valid) == (b.verdict, b.valid)
        assert a.leave_one_out is not None
        assert b.leave_one_out is not None
        assert a.leave_one_out.index == b.leave_one_out.index
        assert b.leave_one_out.turn_deg == pytest.approx(a.leave_one_out.turn_deg)


@pytest.mark.parametrize(
    ("half_angle_deg", "arc_deg"),
    first_in_default_tier([(80, 200), (80, 270), (70, 360), (50, 330)]),
)
def test_exact_cones_are_found_for_any_pole_sign(half_angle_deg: float, arc_deg: float) -> None:
    """Either end of each pole may be given, and the arc may begin anywhere."""
    conical = 0
    for seed in range(36):
        rng = np.random.default_rng(seed)
        poles = folded.bent(rng, 24, arc_deg, 0.0, half_angle_deg)
        found = fold_axis(*planes(poles * rng.choice([-1.0, 1.0], (24, 1))))
        cone = found.figures.cone
        assert cone is not None
        if found.verdict == "conical":
            assert cone.half_angle_deg == pytest.approx(half_angle_deg, abs=1e-3), seed
        conical += (found.verdict, found.valid) == ("conical", "no")
    assert conical >= 35


@pytest.mark.full
def test_scatter_about_great_circle_is_not_a_cone() -> None:
    """Poles that may choose their ends fit a small circle at 0.8 times their scatter."""
    rng = np.random.default_rng(39)
    cones = 0
    for _ in range(200):
        found = fold_axis(*planes(folded.bent(rng, 30, 160, 6)))
        cones += found.verdict == "conical"
    assert cones <= 0.03 * 200


def test_generated_cone_is_recovered() -> None:
    rng = np.random.default_rng(23)
    t = np.radians(np.linspace(-70, 70, 30))
    poles = np.stack(
        [
            np.cos(np.radians(65)) * np.ones(30),
            np.sin(np.radians(65)) * np.sin(t),
            -np.sin(np.radians(65)) * np.cos(t),
        ],
        axis=1,
    )
    exact = fold_axis(*planes(poles)).figures.cone
    assert exact is not None
    assert exact.half_angle_deg == pytest.approx(65, abs=1e-6)
    assert angle_between_lines(Line(exact.trend_deg, exact.plunge_deg), Line(90, 0)) < 1e-5
    rough = fold_axis(*planes(folded.strayed(rng, poles, 2.0))).figures.cone
    assert rough is not None
    assert rough.half_width95_deg is not None
    assert abs(rough.half_angle_deg - 65) < 2 * rough.half_width95_deg


def test_outliers_are_reported_and_excluded_from_verdict() -> None:
    """Three cross joints among beds: without them the fold is cylindrical, and they are told."""
    rng = np.random.default_rng(26)
    beds = folded.bent(rng, 40, 120, 1)
    alone = fold_axis(*planes(beds))
    joints = folded.strayed(rng, np.tile(alone.beta.vector(), (3, 1)), 1.0)
    found = fold_axis(*planes(np.vstack([beds[:20], joints, beds[20:]])))
    assert (alone.verdict, alone.valid, alone.strays) == ("cylindrical", "yes", ())
    assert (found.verdict, found.valid) == ("cylindrical", "conditional")
    assert [stray.index for stray in found.strays] == [20, 21, 22]
    strays = by_code(found.reasons[:1])["fold.strays"]
    assert (strays["planes"], strays["count"], strays["n"]) == (("21", "22", "23"), 3, 43)
    # Beta is that of all, as the tensor gives it; what the others have is in the finding.
    assert strays["trend_deg"] == pytest.approx(alone.beta.trend_deg)
    assert strays["plunge_deg"] == pytest.approx(alone.beta.plunge_deg)
    assert angle_between_lines(found.beta, alone.beta) > 0.1


def test_second_set_of_planes_is_not_treated_as_outliers() -> None:
    """A quarter of joints is more than a few: nothing is left out."""
    rng = np.random.default_rng(27)
    beds = folded.bent(rng, 30, 120, 1)
    beta = fold_axis(*planes(beds)).beta.vector()
    found = fold_axis(*planes(np.vstack([beds, np.tile(beta, (10, 1))])))
    assert found.strays == ()
    assert found.valid == "no"


def test_most_influential_plane_is_the_misplaced_one() -> None:
    rng = np.random.default_rng(24)
    poles = folded.bent(rng, 20, 100, 1)
    right = fold_axis(*planes(poles)).beta
    found = fold_axis(*planes(np.vstack([poles, poles[0] + right.vector()])))
    assert found.leave_one_out is not None
    assert found.leave_one_out.index == 20
    without = Line(found.leave_one_out.trend_deg, found.leave_one_out.plunge_deg)
    assert angle_between_lines(without, right) < 1e-6
    assert found.leave_one_out.turn_deg == pytest.approx(angle_between_lines(found.beta, right))


def test_limbs_have_interlimb_angle_and_bisecting_axial_plane() -> None:
    # Dips of 40 to the east and 50 to the west: the limbs open by 90 degrees, and the plane that
    # halves them leans by 5 degrees.
    found = fold_axis(
        [90, 91.5, 88.5, 90, 270, 271.5, 268.5, 270], [40, 41, 40, 39, 50, 51, 50, 49]
    )
    limbs = found.limbs
    assert limbs is not None
    assert limbs.interlimb_angle_deg == pytest.approx(90, abs=0.1)
    assert limbs.axial_plane.dip_deg == pytest.approx(85, abs=0.1)
    assert limbs.axial_plane.dip_direction_deg % 180 == pytest.approx(90, abs=0.5)
    assert found.verdict == "undetermined"
    assert by_code(found.reasons)["fold.two-dip-domains"] == {
        "apart_deg": pytest.approx(90, abs=0.1)
    }


def test_uniform_arc_has_no_limbs() -> None:
    assert fold_axis(*planes(folded.bent(np.random.default_rng(25), 40, 140, 2))).limbs is None


def test_three_sets_7_26_and_19_degrees_off_one_plane_have_two_axes() -> None:
    rng = np.random.default_rng(26)
    sets = {}
    for name, along, off in (("A", 0, 7.0), ("B", 60, -26.0), ("C", 115, 19.0)):
        t, w = np.radians([along, off])
        pole = np.array([np.cos(w) * np.cos(t), np.sin(w), -np.cos(w) * np.sin(t)])
        sets[name] = planes(folded.strayed(rng, np.tile(pole, (10, 1)), 4.0))
    found = common_axis(sets)
    assert (found.verdict, found.valid) == ("two axes", "no")
    assert len(found.pairs) == 3


@pytest.mark.full
def test_triple_product_is_rejected_at_nominal_rate() -> None:
    # Sets that share an axis, scattered by 8 degrees: 5 % are off by more than their errors.
    rng = np.random.default_rng(27)
    wrong = 0
    for _ in range(400):
        sets = folded.fault_and_beds(rng, 0, 8)
        wrong += "two axes" in common_axis(sets).verdict
    assert wrong <= 0.08 * 400


def test_intersection_of_two_sets_is_reported_with_its_error() -> None:
    found = common_axis({"bed": ([90.0] * 3, [29.0, 30.0, 31.0]), "fault": ([270.0], [60.0])})
    assert found.pairs[0].sets == ("bed", "fault")
    assert found.pairs[0].angle_deg == pytest.approx(90, abs=0.1)
    assert found.pairs[0].max_confidence95_deg is None
    assert (found.verdict, found.valid) == ("common axis", "conditional")


def test_domains_with_different_axes_are_distinguished_from_one_fold() -> None:
    rng = np.random.default_rng(28)
    both = folded.two_folds(rng, 60, 100, 2, 30)
    beds = {"hanging wall": planes(both[:30]), "footwall": planes(both[30:])}
    figures, one = domain_axes(beds, fold_axis(*planes(both)))
    assert not one.serves_all
    assert one.reasons[0].code == "fold.domains-differ"
    assert one.apart_deg == pytest.approx(30, abs=5)
    for domain in figures.values():
        assert domain.axis is not None
        assert domain.axis.verdict == "cylindrical"
    same = folded.bent(rng, 60, 110, 2)
    beds = {"hanging wall": planes(same[:30]), "footwall": planes(same[30:])}
    _, one = domain_axes(beds, fold_axis(*planes(same)))
    assert one.serves_all
    assert one.p is not None
    assert one.reasons[0].code == "fold.one-axis"
    assert one.beds_off_deg is None


def test_small_but_significant_axis_difference_is_not_reported_as_one_axis() -> None:
    """Many precise planes distinguish axes that are too close to matter."""
    rng = np.random.default_rng(28)
    both = folded.two_folds(rng, 400, 100, 0.5, 2)
    beds = {"hanging wall": planes(both[:200]), "footwall": planes(both[200:])}
    _, one = domain_axes(beds, fold_axis(*planes(both)))
    assert one.serves_all
    assert one.p is not None
    assert one.p < AXIS_DIFFERENCE_SIGNIFICANCE
    assert one.apart_deg is not None
    assert one.apart_deg < MIN_AXIS_DIFFERENCE_DEG
    reasons = by_code(one.reasons)
    assert reasons["fold.domains-close"] == {"p": one.p, "limit_deg": MIN_AXIS_DIFFERENCE_DEG}
    assert reasons.keys().isdisjoint({"fold.one-axis", "fold.domains-differ"})


def test_homoclinal_domain_has_no_axis_to_compare() -> None:
    rng = np.random.default_rng(31)
    fold = folded.bent(rng, 30, 110, 2)
    axis = fold_axis(*planes(fold)).beta
    flank = planes(np.cross(axis.vector(), rng.normal([0.2, 0.3, 1.0], 0.02, (30, 3))))
    beds = {"fold": planes(fold), "flank": flank}
    pooled = fold_axis(*np.hstack([beds["fold"], beds["flank"]]))
    figures, one = domain_axes(beds, pooled)
    assert figures["flank"].axis is not None
    assert figures["flank"].axis.verdict == "homoclinal"
    assert one.apart_deg is None
    assert one.beds_off_deg is not None
    assert one.beds_off_deg < 2.0


def test_stated_waviness_replaces_default_limits() -> None:
    azimuth, dip = planes(folded.bent(np.random.default_rng(29), 60, 140, 5))
    assert fold_axis(azimuth, dip, waviness_deg=5).valid == "yes"
    assert fold_axis(azimuth, dip, waviness_deg=1).verdict == "scattered"
