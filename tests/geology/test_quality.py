"""Verdicts on planes: what makes one good, doubtful or poor, and that the reasons say why."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.messages import by_code
from vomstudio.core.findings import Finding
from vomstudio.geology.quality import (
    Kind,
    Thresholds,
    Verdict,
    feature_extent_m,
    governing_confidence_deg,
    governing_half_angles,
    judge,
    judge_line,
    resolution_tilt_deg,
    total_error_deg,
)
from vomstudio.geometry.lines import FittedLine, fit_line
from vomstudio.geometry.planes import FittedPlane, fit_plane, fit_planes


def good_fit() -> FittedPlane:
    """A well bent trace, 10 m long, 5 mm noise."""
    t = np.linspace(-1.0, 1.0, 40)
    points = np.stack([5.0 * t, 8.0 * t * t, np.zeros(40)], axis=1)
    return fit_plane(points + np.random.default_rng(0).normal(0.0, 0.005, (40, 3)))


GOOD = replace(good_fit(), bow_tilt_deg=None)


def judged(fit: FittedPlane, **changes: object) -> Verdict:
    options: dict[str, object] = {"resolution_m": 0.01, "outcrop_normal": (1.0, 0.0, 0.0)}
    options.update(changes)
    return judge(fit, **options)  # type: ignore[arg-type]


def verdict(fit: FittedPlane, **changes: object) -> tuple[str, list[str]]:
    """Return the quality and the codes of the reasons."""
    result = judged(fit, **changes)
    return result.quality, [each.code for each in result.reasons]


def reason(fit: FittedPlane, **changes: object) -> Finding:
    """Return the only reason of a verdict."""
    (only,) = judged(fit, **changes).reasons
    return only


def notes(fit: FittedPlane, **changes: object) -> dict[str, dict[str, object]]:
    """Return the values of the notes by their codes."""
    return by_code(judged(fit, **changes).notes)


def test_well_curved_trace_on_fine_model_is_good_without_reasons() -> None:
    assert verdict(GOOD) == ("good", [])


def test_unknown_resolution_and_face_are_not_held_against_a_plane() -> None:
    assert verdict(GOOD, resolution_m=None, outcrop_normal=None) == ("good", [])


@pytest.mark.parametrize(
    ("angle", "quality"), [(5.0, "good"), (5.1, "doubtful"), (15.0, "doubtful"), (15.1, "poor")]
)
def test_confidence_alone_sets_the_verdict(angle: float, quality: str) -> None:
    limit_deg = 15.0 if quality == "poor" else 5.0
    expected = Finding("plane.uncertain", error_deg=angle, limit_deg=limit_deg)
    found = judged(replace(GOOD, max_confidence95_deg=angle))
    assert found.quality == quality
    assert found.reasons == (() if quality == "good" else (expected,))


@pytest.mark.parametrize(
    ("change", "code", "values"),
    [
        ({"M": 4.0}, "plane.scattered", {"M": 4.0, "recommended": 4.0}),
        (
            {"K": 0.8, "collinearity": 38.4},
            "plane.almost-straight",
            {"collinearity": 38.4, "K": 0.8, "recommended": 0.8},
        ),
        ({"hyperbolic_overflow": True}, "plane.unbounded-error", {}),
    ],
)
def test_shape_adds_a_note_and_does_not_lower_the_verdict(
    change: dict[str, object], code: str, values: dict[str, object]
) -> None:
    shaped = replace(GOOD, **change)  # type: ignore[arg-type]
    assert verdict(shaped) == ("good", [])
    (note,) = judged(shaped).notes
    assert note.code == code
    assert note.values.items() >= values.items()
    assert notes(GOOD) == {}


def test_long_roughness_makes_plane_doubtful() -> None:
    long = replace(GOOD, long_roughness=True)
    assert verdict(long) == ("doubtful", ["plane.long-roughness"])


def test_an_extent_under_a_hundred_resolutions_is_a_note_and_under_ten_a_reason() -> None:
    assert GOOD.extent is not None
    at = GOOD.extent
    assert judged(GOOD, resolution_m=at / 100.0) == Verdict("good", ())
    found = judged(GOOD, resolution_m=at / 99.0)
    assert (found.quality, found.reasons) == ("good", ())
    (note,) = found.notes
    assert note.code == "plane.small"
    assert note.values == {
        "ratio": 99,
        "recommended": 100.0,
        "error_deg": pytest.approx(0.3, abs=0.05),
    }
    assert judged(GOOD, resolution_m=at / 10.0).quality == "good"
    found = judged(GOOD, resolution_m=at / 9.9)
    assert found.quality == "doubtful"
    assert by_code(found.reasons)["plane.too-small"] == {
        "ratio": pytest.approx(9.9),
        "minimum": 10.0,
    }


def test_the_resolution_tilts_a_patch_by_half_a_spacing_over_its_width() -> None:
    """Points spread evenly over 6 m by 2 m: half of 0.4 m over 2 m are 5.71 degrees."""
    x, y = np.meshgrid(np.linspace(-3, 3, 301), np.linspace(-1, 1, 101))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    fit = fit_plane(points, is_ordered=False)
    tilt = resolution_tilt_deg(fit, 0.4, "patch")
    assert tilt == pytest.approx(np.degrees(np.arctan(0.1)), rel=0.02)
    assert total_error_deg(fit, 0.4, "patch") == tilt
    rough = replace(fit, max_confidence95_deg=30.0)
    assert total_error_deg(rough, 0.4, "patch") == 30.0
    unknown = replace(fit, max_confidence95_deg=None, max_angular_error_deg=None)
    assert total_error_deg(unknown, 0.4, "patch") is None
    assert verdict(fit, resolution_m=0.4, kind="patch")[0] == "doubtful"
    expected = Finding("plane.resolution", error_deg=tilt, limit_deg=5.0)
    assert expected in judged(fit, resolution_m=0.4, kind="patch").reasons
    assert verdict(fit, resolution_m=1.2, kind="patch")[0] == "poor"
    assert verdict(fit, resolution_m=0.3, kind="patch")[0] == "good"


def test_resolution_tilt_of_trace_matches_simulated_point_errors() -> None:
    """Against the spread of the slopes of simulated planes."""
    rng = np.random.default_rng(5)
    t = np.linspace(-1.0, 1.0, 25)
    along = np.stack([5.0 * t, np.cos(9.0 * t)], axis=1)
    exact = fit_plane(np.column_stack([along, np.zeros(25)]))
    stated = resolution_tilt_deg(exact, 1.0)
    design = np.column_stack([np.ones(25), along])
    slopes = np.linalg.lstsq(design, rng.normal(0.0, 0.08, (25, 4000)), rcond=None)[0][1:]
    joint = np.degrees(np.arctan(np.sqrt(-2.0 * np.log(0.05)) * slopes.std(axis=1).max()))
    assert stated == pytest.approx(joint, rel=0.05)
    few = fit_plane(np.column_stack([along[::6], np.zeros(5)]))
    width = np.sqrt(12.0 * few.trace * few.eigenvalues[1])
    assert resolution_tilt_deg(few, 1.0) <= np.degrees(np.arctan(0.5 / width)) + 1e-9


@pytest.mark.parametrize("sagitta", [0.3, 2.0])
def test_arc_error_includes_tilt_from_an_undetected_bow(sagitta: float) -> None:
    """A parabola of 10 m with a bow of 1 cm, along it, is a plane that is tilted by the quotient of
    the two sagittas, and shows no residual; a trace that bends to and fro shows it."""
    t = np.linspace(0.0, 1.0, 30)
    bow, noise = 4.0 * t * (1.0 - t), 1e-5 * np.random.default_rng(1).normal(size=30)
    arc = fit_plane(np.column_stack([10.0 * t, sagitta * bow, noise]))
    assert arc.bow_tilt_deg == pytest.approx(np.degrees(np.arctan(0.01 / sagitta)), rel=1e-3)
    counts = governing_confidence_deg(arc)
    assert counts == pytest.approx(np.hypot(arc.max_confidence95_deg or 0.0, arc.bow_tilt_deg or 0))
    bowed = fit_plane(np.column_stack([10.0 * t, sagitta * bow, noise + 0.01 * bow]))
    tilted = np.degrees(np.arccos(abs(bowed.normal[2])))
    assert tilted == pytest.approx(arc.bow_tilt_deg, rel=0.02)
    assert tilted <= (total_error_deg(bowed, None) or 0.0) * 1.02
    wave = fit_plane(np.column_stack([10.0 * t, sagitta * np.sin(2 * np.pi * t), noise]))
    assert wave.bow_tilt_deg == pytest.approx(0.0, abs=0.01)
    exact = fit_plane(np.column_stack([10.0 * t, sagitta * bow, 0.0 * t]))
    assert exact.bow_tilt_deg == 0.0


@pytest.mark.parametrize(("n", "quality"), [(4, "doubtful"), (5, "doubtful"), (6, "good")])
def test_fewer_than_six_points_need_known_resolution_to_be_good(n: int, quality: str) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    points = np.column_stack([5.0 * np.cos(t), 5.0 * np.sin(t), 1e-3 * np.cos(2.0 * t)])
    fit = fit_plane(points)
    assert (total_error_deg(fit, None) or 90.0) < 1.0
    assert verdict(fit, resolution_m=None)[0] == quality
    assert verdict(fit, resolution_m=0.05)[0] == "good"
    assert verdict(fit, resolution_m=0.8)[0] == ("good" if n == 6 else "doubtful")


@pytest.mark.parametrize("n", [6, 9, 20, 100])
def test_straight_line_on_flat_face_leaves_plane_undetermined(n: int) -> None:
    """Picks stray by one spacing along the face, z = 0: their plane is that face, and says nothing
    of the line's own, which is 30 degrees or more off it."""
    rng = np.random.default_rng(n)
    held, unexplained = 0, 0
    for _ in range(60):
        picks = np.column_stack([100.0 * rng.uniform(size=n), rng.normal(size=n), np.zeros(n)])
        fit = fit_plane(picks + [[0.0, 0.0, 0.2]] * rng.normal(size=(n, 1)))
        face = (0.0, 0.0, 1.0)
        total = total_error_deg(fit, 1.0, outcrop_normal=face)
        held += total is not None and total >= 60.0
        found, reasons = verdict(fit, resolution_m=1.0, outcrop_normal=face)
        unexplained += total == 90.0 and not (found == "poor" and reasons)
    assert held >= 0.9 * 60
    assert unexplained == 0


def test_width_within_one_spacing_of_pick_noise_is_not_evidence() -> None:
    t = np.arange(101.0)

    def wide(sigma: float, thin: int = 1) -> FittedPlane:
        return fit_plane(
            np.column_stack([t, np.sqrt(2.0) * sigma * np.sin(t), 0.01 * np.sin(2.7 * t)])[::thin]
        )

    def total(fit: FittedPlane, resolution: float) -> float | None:
        return total_error_deg(fit, resolution, outcrop_normal=(0.0, 0.1, 1.0))

    assert total(wide(0.8), 1.0) == 90.0
    assert governing_half_angles(wide(0.8), "trace", 1.0, (0.0, 0.1, 1.0))[0] == 90.0
    narrow = total(wide(1.5), 1.0)
    assert narrow is not None
    assert narrow < 15.0
    # Few picks may be wider by chance; points that lie much closer than the model's stray less.
    assert total(wide(1.2, 13), 1.0) == 90.0
    assert total(wide(3.0, 5), 4.0) == 90.0
    dense = total(wide(3.0), 4.0)
    assert dense is not None
    assert dense < 20.0
    # A patch has no line that it could stray from, and without a resolution nothing is known.
    assert total_error_deg(wide(0.8), 1.0, "patch", None, (0.0, 0.0, 1.0)) != 90.0
    assert total_error_deg(wide(0.8), None) == governing_confidence_deg(wide(0.8))
    # Out of the face the residuals tell how far the points stray.
    across = total_error_deg(wide(0.8), 1.0, outcrop_normal=(0.0, 1.0, 0.0))
    assert across is not None
    assert across < 15.0


@pytest.mark.parametrize("unknown", [None, 0.0, -1.0, float("nan")])
def test_unknown_resolution_gives_no_tilt(unknown: float | None) -> None:
    assert resolution_tilt_deg(GOOD, unknown) is None
    assert total_error_deg(GOOD, unknown) == governing_confidence_deg(GOOD)
    failed = fit_planes(np.zeros((2, 3)), [0, 2])[0]
    assert resolution_tilt_deg(failed, 0.1) is None


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_trace_along_outcrop_face_gets_a_note_and_patch_does_not(sense: float) -> None:
    face = sense * np.array([np.sin(np.radians(9.0)), 0.0, np.cos(np.radians(9.0))])
    found = judged(GOOD, outcrop_normal=face)
    assert (found.quality, found.reasons) == ("good", ())
    (question,) = found.notes
    assert question.code == "plane.along-face"
    assert question.values["angle_deg"] == pytest.approx(9.0, abs=0.05)
    assert judged(GOOD, outcrop_normal=face, kind="patch") == Verdict("good", ())
    away = np.array([np.sin(np.radians(11.0)), 0.0, np.cos(np.radians(11.0))])
    assert judged(GOOD, outcrop_normal=away) == Verdict("good", ())


def test_a_trace_without_relief_out_of_the_face_is_doubtful() -> None:
    """Its relief, four standard deviations, is 4 x 5 mm of noise; three resolutions of 1 cm are
    more, and so are 2 per cent of 10 m."""
    assert verdict(GOOD, outcrop_normal=GOOD.normal) == ("doubtful", ["plane.in-face"])
    angle_deg = reason(GOOD, outcrop_normal=GOOD.normal).values["angle_deg"]
    assert angle_deg == pytest.approx(0.0, abs=0.01)
    small = fit_plane([[0, 0, 0], [1, 0, 0.03], [1, 1, 0], [0, 1, 0.03], [0.5, 0.5, 0.0]])
    for resolution, expected in ((0.01, "good"), (0.03, "doubtful")):
        found = judged(small, resolution_m=resolution, outcrop_normal=(0, 0, 1))
        assert ("plane.in-face" in by_code(found.reasons)) == (expected == "doubtful")
        assert ("plane.along-face" in by_code(found.notes)) == (expected == "good")


def test_three_points_are_at_most_doubtful() -> None:
    fit = fit_plane([[0, 0, 0], [10, 0, 0], [3, 9, 1.0]])
    assert verdict(fit) == ("doubtful", ["plane.three-points"])


def test_three_nearly_collinear_points_are_straight_and_get_no_size_note() -> None:
    fit = fit_plane([[0, 0, 0], [5, 0.05, 0], [10, 0, 0.0]])
    found = judged(fit, resolution_m=10.0 / 50.0)
    assert [each.code for each in found.reasons] == ["plane.three-straight-points"]
    assert "plane.small" not in by_code(found.notes)


def test_size_note_is_omitted_if_its_expected_error_is_smaller() -> None:
    assert GOOD.extent is not None
    wide = replace(GOOD, max_confidence95_deg=4.0)
    assert "plane.small" not in by_code(judged(wide, resolution_m=GOOD.extent / 50.0).notes)
    assert "plane.small" in by_code(judged(GOOD, resolution_m=GOOD.extent / 50.0).notes)


def test_an_undefined_error_of_more_than_three_points_is_poor() -> None:
    fit = fit_plane([[0, 0, 0], [10, 0, 0], [3, 9, 1.0], [3, 9, 1.0]])
    assert verdict(fit) == ("poor", ["plane.three-distinct-points"])
    assert reason(fit).values == {"n": 4}


def test_almost_straight_trace_gets_straightness_note_and_reason() -> None:
    t = np.linspace(-1.0, 1.0, 40)
    points = np.stack([5.0 * t, 0.05 * t * t, np.zeros(40)], axis=1)
    fit = fit_plane(points + np.random.default_rng(0).normal(0.0, 0.02, (40, 3)))
    quality, reasons = verdict(fit)
    assert quality == "poor"
    assert "plane.almost-straight" in notes(fit)
    assert "plane.too-straight" in reasons


def test_wider_error_governs_if_roughness_is_as_long_as_the_trace() -> None:
    fit = replace(GOOD, long_roughness=True, max_confidence95_deg=1.0, max_angular_error_deg=20.0)
    assert verdict(fit)[0] == "poor"
    assert verdict(replace(fit, long_roughness=False))[0] == "good"


def test_patch_is_judged_by_the_wider_error() -> None:
    fit = replace(GOOD, max_confidence95_deg=0.1, max_angular_error_deg=7.0)
    assert verdict(fit, kind="patch")[0] == "doubtful"
    assert verdict(fit)[0] == "good"


def test_points_exactly_in_a_plane_are_good() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) * 5.0
    assert verdict(fit_plane(square)) == ("good", [])


def test_the_extent_of_a_disc_shaped_patch_is_its_diameter() -> None:
    rng = np.random.default_rng(1)
    r, a = 3.0 * np.sqrt(rng.random(20_000)), 2.0 * np.pi * rng.random(20_000)
    points = np.stack([r * np.cos(a), r * np.sin(a), rng.normal(0, 0.01, 20_000)], axis=1)
    assert feature_extent_m(fit_plane(points, is_ordered=False), "patch") == pytest.approx(
        6.0, rel=0.02
    )


def test_thresholds_can_be_set() -> None:
    strict = Thresholds(good_confidence95_deg=0.001)
    assert verdict(GOOD, thresholds=strict)[0] == "doubtful"


@pytest.mark.parametrize(
    ("kind", "code"), [("trace", "plane.uncertain"), ("patch", "plane.uncertain-patch")]
)
def test_finding_codes_depend_on_feature_kind(kind: Kind, code: str) -> None:
    wide = replace(GOOD, max_confidence95_deg=7.25)
    assert reason(wide, kind=kind) == Finding(code, error_deg=7.25, limit_deg=5.0)
    expand = replace(GOOD, max_confidence95_deg=22.4)
    assert reason(expand, kind=kind) == Finding(code, error_deg=22.4, limit_deg=15.0)
    three = fit_plane([[0, 0, 0], [10, 0, 0], [3, 9, 1.0]])
    assert verdict(three, kind=kind)[1] == ["plane.three-points"]
    twice = fit_plane([[0, 0, 0], [10, 0, 0], [3, 9, 1.0], [3, 9, 1.0]])
    assert "plane.three-distinct-points" in verdict(twice, kind=kind)[1]
    straight = replace(GOOD, K=None, collinearity=None)
    assert notes(straight, kind=kind) == {
        "plane.almost-straight": {"collinearity": math.inf, "K": math.inf, "recommended": 0.8}
    }


def test_uncertain_straight_trace_gets_too_straight_code() -> None:
    straight = replace(GOOD, K=1.2, max_confidence95_deg=7.25)
    expected = Finding("plane.too-straight", error_deg=7.25, limit_deg=5.0)
    assert reason(straight) == expected
    assert reason(straight, kind="patch").code == "plane.uncertain-patch"


def test_texts_show_the_significant_digits() -> None:
    scattered = notes(replace(GOOD, M=3.94, coplanarity=51.7))["plane.scattered"]
    assert scattered == {"M": 3.94, "coplanarity": 51.7, "recommended": 4.0}
    few = notes(replace(GOOD, M=1.0, coplanarity=9.94))["plane.scattered"]
    assert few["coplanarity"] == 9.94
    infinite = notes(replace(GOOD, M=1.0, coplanarity=None))["plane.scattered"]
    assert infinite["coplanarity"] == math.inf
    straight = notes(replace(GOOD, K=1.234, collinearity=9.96))["plane.almost-straight"]
    assert straight == {"collinearity": 9.96, "K": 1.234, "recommended": 0.8}
    for angle, words in ((9.94, "9.9°"), (9.96, "10°"), (6.0, "6°"), (5.4, "5.4°")):
        assert f"by {words} " in reason(replace(GOOD, max_confidence95_deg=angle)).message
    assert (
        "M 3.9, coplanarity 51.7 "
        in judged(replace(GOOD, M=3.94, coplanarity=51.7)).notes[0].message
    )


def test_failed_fit_is_poor_with_its_cause_as_reason() -> None:
    cause = Finding("feature.too-few-points", count=1, minimum=3)
    failed = judged(replace(GOOD, error=cause))
    assert failed.quality == "poor"
    assert failed.reasons == (cause,)


def test_zero_or_negative_resolution_is_ignored() -> None:
    assert verdict(GOOD, resolution_m=0.0) == ("good", [])
    assert verdict(GOOD, resolution_m=-1.0) == ("good", [])


def test_face_normal_without_direction_is_ignored() -> None:
    for normal in ((0.0, 0.0, 0.0), (np.nan, 0.0, 1.0)):
        assert verdict(GOOD, outcrop_normal=normal) == ("good", [])
    tiny = reason(GOOD, outcrop_normal=1e-6 * GOOD.normal)
    assert tiny.code == "plane.in-face"
    assert tiny.values["angle_deg"] == pytest.approx(0.0, abs=0.05)


def test_governing_half_angles_depend_on_feature_kind() -> None:
    fit = replace(
        GOOD,
        max_confidence95_deg=2.0,
        min_confidence95_deg=1.0,
        bow_tilt_deg=None,
        max_angular_error_deg=7.0,
        min_angular_error_deg=3.0,
    )
    assert governing_half_angles(fit) == (2.0, 1.0)
    assert governing_half_angles(fit, "patch") == (7.0, 3.0)
    assert governing_half_angles(replace(fit, long_roughness=True)) == (7.0, 3.0)
    narrow = replace(fit, max_angular_error_deg=1.5, min_angular_error_deg=1.2)
    assert governing_half_angles(narrow, "patch") == (2.0, 1.0)
    assert governing_half_angles(replace(fit, min_angular_error_deg=0.5), "patch") == (7.0, 1.0)
    assert governing_half_angles(replace(fit, min_angular_error_deg=None), "patch") == (7.0, 1.0)
    for unknown in ("max_confidence95_deg", "min_confidence95_deg"):
        assert governing_half_angles(replace(fit, **{unknown: None})) == (None, None)  # type: ignore[arg-type]
    assert governing_confidence_deg(replace(fit, max_confidence95_deg=None), "patch") == 7.0
    assert governing_confidence_deg(replace(fit, max_confidence95_deg=None)) is None


def test_the_extent_of_a_trace_is_its_length() -> None:
    assert feature_extent_m(GOOD) == GOOD.extent
    failed = fit_planes(np.zeros((2, 3)), [0, 2])[0]
    assert feature_extent_m(failed, "patch") is None


# Lines


def straight(n: int, noise: float = 0.0) -> FittedLine:
    rng = np.random.default_rng(2)
    points = np.outer(np.linspace(0, 3, n), [1.0, 0.0, -1.0]) + rng.normal(0, noise, (n, 3))
    return fit_line(points)


@pytest.mark.parametrize(
    ("angle", "quality", "limit_deg"),
    [(5.0, "good", None), (5.1, "doubtful", 5.0), (15.0, "doubtful", 5.0), (15.1, "poor", 15.0)],
)
def test_a_line_is_judged_by_its_error(angle: float, quality: str, limit_deg: float | None) -> None:
    fit = straight(9, 0.01)
    assert fit.confidence95_deg is not None
    for given, code in (
        (None, "line.uncertain-plane"),
        (fit, "line.uncertain-plane"),
        (replace(fit, confidence95_deg=90.0), "line.uncertain"),
        (replace(fit, confidence95_deg=angle), "line.uncertain"),
        (straight(2), "line.uncertain"),
    ):
        found = judge_line(given, confidence95_deg=angle)
        assert found.quality == quality
        expected = Finding(code, error_deg=angle, limit_deg=limit_deg)
        assert found.reasons == (() if limit_deg is None else (expected,))


@pytest.mark.parametrize(("registration", "is_most"), [(7.0, False), (7.1, True)])
def test_line_error_mostly_from_registration_has_that_reason(
    registration: float, is_most: bool
) -> None:
    """From half of the variance on."""
    for fit in (None, straight(9, 0.01)):
        found = judge_line(fit, confidence95_deg=10.0, registration_deg=registration)
        code = "line.registration" if is_most else "line.uncertain-plane"
        assert found.reasons == (Finding(code, error_deg=10.0, limit_deg=5.0),)


def test_a_line_of_unknown_error_has_the_cause_as_its_reason() -> None:
    def reasons(fit: FittedLine | None, known: bool = True) -> list[str]:
        found = judge_line(fit, confidence95_deg=None, is_plane_known=known)
        assert found.quality == ("doubtful" if found.reasons else "good")
        return [each.code for each in found.reasons]

    plane, two = "line.plane-error-unknown", "line.two-points"
    assert reasons(None) == reasons(None, False) == [plane]
    assert reasons(straight(2)) == [two]
    assert reasons(straight(2), False) == [two, plane]
    assert reasons(straight(9, 0.01), False) == [plane]
    assert reasons(straight(9, 0.01)) == []


def test_lines_off_plane_from_scattered_set_or_missing_plane_are_doubtful() -> None:
    fit = straight(9, 0.01)

    def found(**more: object) -> tuple[str, tuple[Finding, ...]]:
        verdict_ = judge_line(fit, confidence95_deg=1.0, **more)  # type: ignore[arg-type]
        return verdict_.quality, verdict_.reasons

    assert found(off_plane_deg=10.0, scatter_deg=12.0) == ("good", ())
    off = Finding("line.off-plane", angle_deg=10.4)
    assert found(off_plane_deg=10.4) == ("doubtful", (off,))
    scattered = Finding("line.scattered-set", scatter_deg=12.6)
    assert found(scatter_deg=12.6) == ("doubtful", (scattered,))
    assert found(is_plane_missing=True) == ("doubtful", (Finding("line.plane-missing"),))
    strict = Thresholds(good_confidence95_deg=0.5, poor_confidence95_deg=0.9)
    assert found(thresholds=strict)[0] == "poor"
