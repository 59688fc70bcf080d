"""The foretold registration is the one that comes about: closed forms and drawn surveys."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import vomstudio as vs
from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.photogrammetry.survey.plan_camera import parse_camera
from vomstudio.photogrammetry.survey.plan_forecast import add_forecasts
from vomstudio.photogrammetry.survey.planning import SurveyPlan, plan_survey
from vomstudio.photogrammetry.survey.registration_forecast import forecast
from vomstudio.photogrammetry.survey.survey_options import PlanOptions
from vomstudio.registration.similarity import fit_similarity

CAMERA = "23.5x15.6,35,6000x4000"
Z95 = 1.959963984540054


def plan(width: float, height: float, distance: float, manner: str = "drone") -> SurveyPlan:
    made = plan_survey(
        parse_camera(CAMERA, None),
        PlanOptions(width_m=width, height_m=height, distance_m=distance, manner=manner),
    )
    return made


def test_error_of_a_square_of_cameras_follows_from_its_lever_arms() -> None:
    """Four points at (+-a, +-a) in one level: about up the sum of squares of the levers is 8 a^2,
    about east that of the heights' is 4 a^2."""
    a, level, height = 10.0, 0.5, 1.0
    places = np.array([[a, a, 0], [-a, a, 0], [-a, -a, 0], [a, -a, 0.0]])
    found = forecast("control", places, (level, height))
    assert found.about_up_95_deg == pytest.approx(Z95 * np.degrees(level / np.sqrt(8 * a * a)))
    for told in (found.about_along_95_deg, found.about_view_95_deg):
        assert told == pytest.approx(Z95 * np.degrees(height / np.sqrt(4 * a * a)))
    assert found.worst_95_deg == pytest.approx(Z95 * np.degrees(height / np.sqrt(4 * a * a)))
    assert found.scale_error_95 == pytest.approx(Z95 * level / np.sqrt(8 * a * a))


def test_planned_cameras_rotate_the_model_as_predicted() -> None:
    made = plan(100.0, 40.0, 30.0)
    places = np.array([[s.along_m, -s.away_m, s.up_m] for s in made.positions])
    found = forecast("receiver", places, (2.0, 4.0))
    rng = np.random.default_rng(1)
    turns = []
    for _ in range(400):
        noise = rng.normal(size=places.shape) * [2.0, 2.0, 4.0]
        # Weighted as they are known: the axes in units of their errors would bend the similarity,
        # so that equal weights stand in, which are a little worse.
        fit = fit_similarity(places, places + noise)
        turns.append(Rotation.from_matrix(fit.rotation).as_rotvec(degrees=True))
    spread = Z95 * np.std(turns, axis=0)
    told = [found.about_along_95_deg, found.about_view_95_deg, found.about_up_95_deg]
    assert spread == pytest.approx(np.array(told, float), rel=0.25)
    assert (np.array(told, float) < 1.1 * spread).all()


@pytest.mark.parametrize("times", [2.0, 5.0])
def test_errors_scale_with_the_receiver_error(times: float) -> None:
    made = plan(100.0, 40.0, 30.0)
    one, more = add_forecasts(made, 0.1, 0.02), add_forecasts(made, 0.1 * times, 0.02 * times)
    for a, b in zip(one.registration, more.registration, strict=True):
        assert a.worst_95_deg is not None
        assert b.worst_95_deg == pytest.approx(times * a.worst_95_deg, rel=1e-6)


def test_line_of_cameras_gives_a_warning_with_advice() -> None:
    made = add_forecasts(plan(40.0, 6.0, 15.0, "handheld"))
    receiver, control = made.registration
    # It may turn about the line along which the cameras stand.
    assert receiver.worst_95_deg is None or receiver.worst_95_deg > 20.0
    assert control.worst_95_deg is not None
    assert control.worst_95_deg < 2.0
    codes = {each.code for each in made.warnings}
    assert {"plan.nearly-in-line", "plan.measure-on-site"} <= codes


def test_good_plan_has_no_warnings() -> None:
    before = plan(100.0, 40.0, 30.0)
    assert add_forecasts(before, 0.02).warnings == before.warnings


def test_single_position_cannot_register_a_model_and_gives_the_reason() -> None:
    found = forecast("receiver", np.zeros((1, 3)), (3.0, 6.0))
    assert found.worst_95_deg is None
    assert found.why_not is not None
    assert found.why_not.code == "registration.too-few-points"


def test_invalid_receiver_error_is_rejected() -> None:
    for bad in (0.0, -1.0, float("nan"), 1e9):
        with refused("option.out-of-range", UsageError, field="--receiver"):
            PlanOptions(width_m=20.0, height_m=10.0, receiver_m=bad)


def test_plan_function_reports_the_forecasts_and_warnings() -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        made = vs.plan(
            CAMERA, width_m=40, height_m=6, distance_m=15, receiver_m=5.0, control_m=0.01
        )
    assert any("second set" in str(each.message) for each in told)
    assert [each.by for each in made.registration] == ["receiver", "control"]
    assert made.registration[0].sigma_m == (5.0, 10.0)
    assert made.to_dict()["registration"][1]["sigma_m"] == [0.01, 0.01]
