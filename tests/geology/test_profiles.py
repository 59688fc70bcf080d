"""The textbook's profile: its figures are computed by numpy from points in closed form."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from tests.messages import by_code
from vomstudio.geology.profiles import (
    DEFAULT_THRESHOLDS,
    PROFILES_BY_NAME,
    TEXTBOOK_THRESHOLDS,
    Thresholds,
)
from vomstudio.geology.quality import judge
from vomstudio.geometry.planes import fit_plane

COPLANARITY, COLLINEARITY, EXTENT = "plane.not-coplanar", "plane.collinear", "plane.too-small"


def points(length: float, width: float, rough: float, n: int = 60) -> np.ndarray:
    """A rectangle of points whose variances along three axes are known to be what they are."""
    random = np.random.default_rng(3)
    box = random.uniform(-0.5, 0.5, (n, 3)) * [length, width, 0.0]
    return np.asarray(box + random.normal(0.0, 1.0, (n, 3)) * [0.0, 0.0, rough])


def indices(xyz: np.ndarray) -> tuple[float, float]:
    """Coplanarity and collinearity by equations 20 and 21 of the textbook."""
    values = np.sort(np.linalg.eigvalsh(np.cov(xyz.T)))[::-1]
    return float(values.sum() / values[2]), float(values[0] / values[1])


def test_textbook_limits_are_m_4_and_k_0_8() -> None:
    # ln(l1 / l3) = 4 and ln(l1 / l2) = 0.8 ln(l2 / l3).
    second = np.exp(4.0 / 1.8)
    first = np.exp(4.0)
    assert first + second + 1.0 == pytest.approx(TEXTBOOK_THRESHOLDS.least_coplanarity, rel=0.01)
    assert first / second == pytest.approx(TEXTBOOK_THRESHOLDS.most_collinearity, rel=0.02)


@pytest.mark.parametrize(
    ("shape", "resolution", "quality", "missed"),
    [
        ((4.0, 3.0, 0.02), 0.01, "good", ()),
        ((4.0, 3.0, 0.6), 0.01, "doubtful", (COPLANARITY,)),
        ((4.0, 0.6, 0.02), 0.01, "doubtful", (COLLINEARITY,)),
        ((4.0, 3.0, 0.02), 0.1, "doubtful", (EXTENT,)),
        ((4.0, 0.6, 0.02), 0.1, "poor", (COLLINEARITY, EXTENT)),
        ((4.0, 0.7, 0.17), 0.1, "poor", (COPLANARITY, COLLINEARITY, EXTENT)),
    ],
)
def test_one_missed_limit_makes_a_plane_doubtful_and_two_make_it_poor(
    shape: tuple[float, float, float], resolution: float, quality: str, missed: tuple[str, ...]
) -> None:
    xyz = points(*shape)
    coplanarity, collinearity = indices(xyz)
    assert (coplanarity < 65.0, collinearity > 6.0) == (
        COPLANARITY in missed,
        COLLINEARITY in missed,
    )
    fit = fit_plane(xyz, is_ordered=False)
    verdict = judge(
        fit, resolution_m=resolution, outcrop_normal=None, thresholds=TEXTBOOK_THRESHOLDS
    )
    assert (verdict.quality, verdict.profile) == (quality, "textbook")
    assert tuple(each.code for each in verdict.reasons) == missed
    values = by_code(verdict.reasons)
    if COPLANARITY in missed:
        assert values[COPLANARITY] == {"coplanarity": pytest.approx(coplanarity), "minimum": 65.0}
    if COLLINEARITY in missed:
        number = float(values[COLLINEARITY].pop("collinearity"))
        assert number == pytest.approx(collinearity, rel=0.05)
        assert values[COLLINEARITY] == {"maximum": 6.0}
    if EXTENT in missed:
        ratio = fit.extent / resolution if fit.extent else None
        assert values[EXTENT] == {"ratio": pytest.approx(ratio), "minimum": 100.0}


def test_error_rule_reasons_become_notes_in_textbook_profile() -> None:
    # 40 centimetres of roughness on 3 metres: known to some ten degrees.
    fit = fit_plane(points(4.0, 3.0, 0.3, n=12), is_ordered=False)
    by_error = judge(fit, resolution_m=None, outcrop_normal=None)
    assert by_error.quality != "good"
    by_shape = judge(
        fit,
        resolution_m=None,
        outcrop_normal=None,
        thresholds=replace(
            TEXTBOOK_THRESHOLDS, profile="loose", least_coplanarity=10.0, most_collinearity=50.0
        ),
    )
    assert (by_shape.quality, by_shape.profile) == ("good", "loose")
    assert set(by_error.reasons) < set(by_shape.notes)


def test_three_points_are_doubtful_in_every_profile() -> None:
    three = fit_plane([[0, 0, 0], [3, 0, 1], [0, 3, 1]])
    for limits in PROFILES_BY_NAME.values():
        verdict = judge(three, resolution_m=0.001, outcrop_normal=None, thresholds=limits)
        assert verdict.quality == "doubtful"
        assert verdict.reasons[0].code == "plane.three-points"


def test_limits_of_wrong_type_are_rejected() -> None:
    assert Thresholds(good_confidence95_deg=4).good_confidence95_deg == 4
    for wrong in ({"good_M": "4"}, {"good_K": True}, {"by": "taste"}, {"profile": 3}):
        with pytest.raises(TypeError):
            Thresholds(**wrong)  # type: ignore[arg-type]
    assert DEFAULT_THRESHOLDS.profile == "error"


@pytest.mark.parametrize("limits", PROFILES_BY_NAME.values())
def test_profile_description_states_every_limit_that_decides(limits: Thresholds) -> None:
    """Each limit is moved to a value of its own, and only those that judge change the words."""
    decides = {
        "error": {"good_confidence95_deg", "poor_confidence95_deg", "least_extent_over_resolution"},
        "shape": {"least_coplanarity", "most_collinearity", "extent_over_resolution"},
    }[limits.by] | {"surface_effect_deg"}
    assert f"“{limits.profile}”" in limits.description
    for field in fields(limits):
        if field.type != "float":
            continue
        said = replace(limits, **{field.name: 13.7}).description
        assert ("13.7" in said) == (field.name in decides), field.name
