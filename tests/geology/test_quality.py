"""Verdicts on planes: what makes one good, doubtful or poor, and that the reasons say why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vomstudio.geology.quality import Thresholds, feature_extent_m, judge
from vomstudio.geometry.planes import PlaneFit, fit_plane


def good_fit() -> PlaneFit:
    """A well bent trace, 10 m long, 5 mm noise."""
    t = np.linspace(-1.0, 1.0, 40)
    points = np.stack([5.0 * t, 8.0 * t * t, np.zeros(40)], axis=1)
    return fit_plane(points + np.random.default_rng(0).normal(0.0, 0.005, (40, 3)))


GOOD = good_fit()


def verdict(fit: PlaneFit, **changes: object) -> tuple[str, str]:
    options: dict[str, object] = {"resolution_m": 0.01, "outcrop_normal": (1.0, 0.0, 0.0)}
    options.update(changes)
    result = judge(fit, **options)  # type: ignore[arg-type]
    return result.quality, "; ".join(result.reasons)


def test_a_well_bent_trace_on_a_fine_model_is_good_without_reasons() -> None:
    assert verdict(GOOD) == ("good", "")


def test_unknown_resolution_and_face_are_not_held_against_a_plane() -> None:
    assert verdict(GOOD, resolution_m=None, outcrop_normal=None) == ("good", "")


@pytest.mark.parametrize(
    ("angle", "quality"), [(5.0, "good"), (5.1, "doubtful"), (15.0, "doubtful"), (15.1, "poor")]
)
def test_confidence_alone_sets_the_bounds(angle: float, quality: str) -> None:
    found, reasons = verdict(replace(GOOD, max_confidence95_deg=angle))
    assert found == quality
    assert ("uncertain by" in reasons) == (quality != "good")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"M": 4.0}, "M 4.0"),
        ({"K": 0.8, "collinearity": 38.4}, "collinearity 38"),
        ({"long_roughness": True}, "as long as the trace"),
        ({"hyperbolic_overflow": True}, "90°"),
    ],
)
def test_one_flag_makes_a_plane_doubtful_and_is_named(
    change: dict[str, object], words: str
) -> None:
    quality, reasons = verdict(replace(GOOD, **change))  # type: ignore[arg-type]
    assert quality == "doubtful"
    assert words in reasons


def test_resolution_alone_makes_doubtful_and_not_poor() -> None:
    quality, reasons = verdict(GOOD, resolution_m=1.0)
    assert quality == "doubtful"
    assert "x resolution (100 wanted)" in reasons
    assert verdict(GOOD, resolution_m=GOOD.extent / 100.0) == ("good", "")  # type: ignore[operator]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_trace_in_the_outcrop_face_is_flagged_and_a_patch_is_not(sense: float) -> None:
    face = sense * np.array([np.sin(np.radians(9.0)), 0.0, np.cos(np.radians(9.0))])
    quality, reasons = verdict(GOOD, outcrop_normal=face)
    assert quality == "doubtful"
    assert "outcrop face" in reasons
    assert "face" not in verdict(GOOD, outcrop_normal=face, kind="patch")[1]
    away = np.array([np.sin(np.radians(11.0)), 0.0, np.cos(np.radians(11.0))])
    assert verdict(GOOD, outcrop_normal=away)[0] == "good"


def test_three_points_are_at_most_doubtful() -> None:
    fit = fit_plane([[0, 0, 0], [10, 0, 0], [3, 9, 1.0]])
    quality, reasons = verdict(fit)
    assert quality == "doubtful"
    assert "three points only" in reasons


def test_an_undefined_error_of_more_than_three_points_is_poor() -> None:
    fit = fit_plane([[0, 0, 0], [10, 0, 0], [3, 9, 1.0], [3, 9, 1.0]])
    quality, reasons = verdict(fit)
    assert quality == "poor"
    assert "only 3 of the 4 points differ" in reasons


def test_an_almost_straight_trace_is_called_so_and_told_what_to_do() -> None:
    t = np.linspace(-1.0, 1.0, 40)
    points = np.stack([5.0 * t, 0.05 * t * t, np.zeros(40)], axis=1)
    fit = fit_plane(points + np.random.default_rng(0).normal(0.0, 0.02, (40, 3)))
    quality, reasons = verdict(fit)
    assert quality == "poor"
    assert "almost straight trace: collinearity" in reasons
    assert "add points where the trace bends" in reasons


def test_the_wider_figure_counts_where_the_roughness_is_as_long_as_the_trace() -> None:
    fit = replace(GOOD, long_roughness=True, max_confidence95_deg=1.0, max_angular_error_deg=20.0)
    assert verdict(fit)[0] == "poor"
    assert verdict(replace(fit, long_roughness=False))[0] == "good"


def test_a_patch_is_judged_by_the_wider_figure() -> None:
    fit = replace(GOOD, max_confidence95_deg=0.1, max_angular_error_deg=7.0)
    assert verdict(fit, kind="patch")[0] == "doubtful"
    assert verdict(fit)[0] == "good"


def test_points_exactly_in_a_plane_are_good() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) * 5.0
    assert verdict(fit_plane(square)) == ("good", "")


def test_the_extent_of_a_disc_shaped_patch_is_its_diameter() -> None:
    rng = np.random.default_rng(1)
    r, a = 3.0 * np.sqrt(rng.random(20_000)), 2.0 * np.pi * rng.random(20_000)
    points = np.stack([r * np.cos(a), r * np.sin(a), rng.normal(0, 0.01, 20_000)], axis=1)
    assert feature_extent_m(fit_plane(points, ordered=False), "patch") == pytest.approx(
        6.0, rel=0.02
    )


def test_thresholds_can_be_set() -> None:
    strict = Thresholds(good_confidence95_deg=0.001)
    assert verdict(GOOD, thresholds=strict)[0] == "doubtful"
