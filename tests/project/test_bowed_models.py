"""A bowed model says so in its panel and tables, and a fold no stronger than that is warned of."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import by_code, with_code
from vomstudio.geology.folds import fold_axis
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration, RegistrationPoint
from vomstudio.project.records import Model
from vomstudio.project.registration_errors import max_bowing_deg, registration_bowing
from vomstudio.registration.summary import summarize_registration


def registration(curvature: float, *, n: int = 14, wrong: bool = False) -> Registration:
    """By points on level ground 60 m across, on a model that is bent by c r^2."""
    rng = np.random.default_rng(3)
    world = np.column_stack([rng.uniform(-30, 30, (n, 2)), 0.2 * rng.normal(size=n)])
    left = 0.01 * rng.normal(size=(n, 3))
    left[:, 2] += curvature * (world[:, :2] ** 2).sum(axis=1)
    left -= left.mean(axis=0)
    if wrong:
        left[0] = [0.0, 0.0, 40.0]
    points = tuple(
        RegistrationPoint(
            str(i), tuple((w + r).tolist()), tuple(w.tolist()), tuple(r.tolist()), check=i > 9
        )
        for i, (w, r) in enumerate(zip(world, left, strict=True))
    )
    shape = np.diag([*(np.radians([0.3, 0.2, 0.1]) ** 2), 0.002**2, 0.0, 0.0, 0.0])
    rows = tuple(map(tuple, shape.tolist()))
    return Registration(
        "r1", "r", "points", Frame("local"), control=points, covariance=rows, scale_error=0.002
    )


def model(placed: Registration | Frame) -> Model:
    return Model("m1", "m", "m.ply", "mesh", "hash", placed)


def test_bowing_matches_the_bent_ground() -> None:
    found = registration_bowing(registration(-0.001))
    assert found is not None
    assert found.significant
    assert found.curvature_per_m == pytest.approx(-0.001, rel=0.1)
    expected = np.degrees(2.0 * 0.001 * found.reach_m)
    assert found.side_deg == pytest.approx(expected, rel=0.1)
    assert max_bowing_deg([model(registration(-0.001)), None]) == pytest.approx(found.across_deg)


def test_wrong_point_neither_hides_nor_causes_bowing() -> None:
    bent = registration_bowing(registration(-0.001, wrong=True))
    assert bent is not None
    assert bent.curvature_per_m == pytest.approx(-0.001, rel=0.1)
    assert max_bowing_deg([model(registration(0.0, wrong=True))]) is None


def test_flat_and_declared_models_have_no_bowing() -> None:
    assert max_bowing_deg([model(registration(0.0)), model(Frame("local")), None]) is None


def test_summary_states_the_rotation_error_and_warnings_of_a_registration() -> None:
    told = summarize_registration(registration(-0.001))
    facts = {fact.code: fact for fact in told.facts}
    assert facts["control-points"].values == {"count": 10}
    assert facts["check-points"].values == {"count": 4}
    # 95 % of each turn: 1.96 times 0.3, 0.2 and 0.1 degrees.
    for axis, error_deg in (("east", 0.588), ("north", 0.392), ("up", 0.196)):
        error = facts[f"turned-about-{axis}"].values["error95_deg"]
        assert error == pytest.approx(error_deg, abs=1e-3)
    assert facts["weakest-axis"].text == "090/00 ± 0.59°"
    assert facts["scale"].values["error95_percent"] == pytest.approx(0.392, abs=1e-3)
    assert facts["bowing"].values["significant"]
    assert told.rotation is not None
    assert told.rotation.code == "registration.weakest-axis"
    assert told.rotation.values["error95_deg"] == pytest.approx(0.588, abs=1e-3)
    (bowed,) = with_code(told.warnings, "registration.bowed")
    assert (bowed.values["source"], bowed.values["n"]) == ("residuals", 14)
    assert not with_code(summarize_registration(registration(0.0)).warnings, "registration.bowed")


def test_few_control_points_and_missing_check_points_are_reported() -> None:
    record = registration(0.0, n=3)
    warnings = by_code(summarize_registration(record).warnings)
    assert warnings["control.no-redundancy"] == {"count": 3, "least": 4}
    assert "control.no-check-points" in warnings


def test_registration_without_errors_has_no_rotation_or_warnings() -> None:
    told = summarize_registration(Registration("r1", "r", "local", Frame("scaled")))
    assert told.rotation is None
    assert [fact.code for fact in told.facts] == ["method"]
    assert told.warnings == ()


def test_fold_weaker_than_the_bowing_gives_a_warning() -> None:
    """Beds that dip 3 degrees either way along a ridge: an arc of 6 degrees."""
    azimuth = np.array([90.0, 90.0, 270.0, 270.0, 90.0])
    dip = np.array([3.0, 1.5, 1.6, 3.0, 0.8])
    bowed_axis = fold_axis(azimuth, dip, None, 8.0)
    assert by_code(bowed_axis.reasons)["fold.bowed"] == {
        "bowed_deg": 8.0,
        "arc_deg": bowed_axis.arc_deg,
    }
    for bowed in (None, 4.0):
        found = fold_axis(azimuth, dip, None, bowed)
        assert found.arc_deg == pytest.approx(6.0, abs=0.01)
        assert "fold.bowed" not in by_code(found.reasons)
