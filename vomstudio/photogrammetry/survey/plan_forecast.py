"""Forecasts of the registration of a planned survey, and advice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.survey.planning import SurveyPlan
from vomstudio.photogrammetry.survey.registration_forecast import Forecast, forecast
from vomstudio.photogrammetry.survey.survey_options import DEFAULT_CONTROL_M, DEFAULT_RECEIVER_M

_HEIGHT_ERROR_FACTOR = 2.0
_MAX_ERROR_DEG = 2.0


def add_forecasts(
    plan: SurveyPlan, receiver_m: float | None = None, control_m: float | None = None
) -> SurveyPlan:
    """Add forecasts of the registration to a plan.

    They are made for the positions of the cameras and for the control points. A warning is added if
    the former are not sufficient, provided that the receiver was given or that the cameras are
    nearly in one line, for which no receiver is sufficient.

    Parameters
    ----------
    plan : SurveyPlan
    receiver_m, control_m : float, optional
        Standard deviation of a horizontal coordinate of a camera and of a control point.
    """
    both_forecasts = forecasts(
        plan, receiver_m or DEFAULT_RECEIVER_M, control_m or DEFAULT_CONTROL_M
    )
    findings = []
    if receiver_m is not None or _is_nearly_collinear(plan):
        findings = forecast_findings(plan, *both_forecasts)
    return replace(plan, registration=both_forecasts, warnings=(*plan.warnings, *findings))


def forecasts(plan: SurveyPlan, receiver_m: float, control_m: float) -> tuple[Forecast, Forecast]:
    """Return the forecasts of a plan, by its camera positions and by its control points.

    Parameters
    ----------
    plan : SurveyPlan
    receiver_m, control_m : float
        Standard deviation of a horizontal coordinate. Heights are assumed to be half as accurate
        for the receiver, and equally accurate for control points.
    """
    is_upright = plan.manner != "terrain"
    cameras = np.array([[s.along_m, s.up_m, s.away_m] for s in plan.positions])
    control = np.array(
        [[p.along_m, p.up_m, 0.0] for p in plan.control_points if p.use == "control"]
    )
    receiver_forecast = forecast(
        "receiver",
        convert_to_world(cameras, is_upright),
        (receiver_m, _HEIGHT_ERROR_FACTOR * receiver_m),
    )
    return receiver_forecast, forecast(
        "control", convert_to_world(control, is_upright), (control_m, control_m)
    )


def forecast_findings(plan: SurveyPlan, receiver: Forecast, control: Forecast) -> list[Finding]:
    """Report advice if the positions of the cameras alone cannot orient the model."""
    worst_error_deg = receiver.worst_95_deg
    if worst_error_deg is not None and worst_error_deg <= _MAX_ERROR_DEG:
        return []
    if worst_error_deg is None:
        findings = [Finding("plan.unregistrable")]
    else:
        findings = [
            Finding("plan.rotation", sigma_m=receiver.sigma_m[0], rotation95_deg=worst_error_deg)
        ]
    if control.worst_95_deg is not None and control.worst_95_deg <= _MAX_ERROR_DEG:
        findings.append(
            Finding(
                "plan.rotation-by-control",
                sigma_m=control.sigma_m[0],
                rotation95_deg=control.worst_95_deg,
            )
        )
    if _is_nearly_collinear(plan):
        findings.append(Finding("plan.nearly-in-line"))
    findings.append(Finding("plan.measure-on-site"))
    return findings


def convert_to_world(positions: FloatArray, is_upright: bool) -> FloatArray:
    """Convert positions in the frame of the outcrop to a frame with z up.

    Parameters
    ----------
    positions : (n, 3) array
        Coordinates along, up and away from the outcrop.
    is_upright : bool
        Whether the outcrop is a wall and not terrain.

    Returns
    -------
    (n, 3) array
        Coordinates along the outcrop, into it, and up.
    """
    if not len(positions):
        return np.zeros((0, 3))
    horizontal, up, distances = positions.T
    return np.column_stack(
        [horizontal, -distances, up] if is_upright else [horizontal, up, distances]
    )


def _is_nearly_collinear(plan: SurveyPlan) -> bool:
    """Return whether the extent of the cameras is ten times larger along one line than across."""
    positions = np.array([[s.along_m, s.up_m, s.away_m] for s in plan.positions])
    singular_values = np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)
    return bool(len(positions) < 3 or singular_values[1] < 0.1 * singular_values[0])


def forecast_text(result: Forecast) -> str:
    """Describe a forecast in one line."""
    if result.why_not is not None:
        return result.why_not.message
    values = {
        "count": result.points,
        "sigma": result.sigma_m[0],
        "worst": _angle_text(result.worst_95_deg),
        "up": _angle_text(result.about_up_95_deg),
    }
    if result.by == "receiver":
        return tr(
            "{count} positions accurate to {sigma:.2g} m: rotation error up to {worst} (95 %),"
            " {up} about the vertical",
            **values,
        )
    return tr(
        "{count} control points accurate to {sigma:.2g} m: rotation error up to {worst} (95 %),"
        " {up} about the vertical",
        **values,
    )


def forecast_summary(result: Forecast) -> str:
    """Describe a forecast in a few words."""
    if result.why_not is not None:
        return tr("cannot be registered")
    return tr(
        "{worst} (95 %), if accurate to {sigma:.2g} m",
        worst=_angle_text(result.worst_95_deg),
        sigma=result.sigma_m[0],
    )


def _angle_text(angle: float | None) -> str:
    return tr("any angle") if angle is None else f"{angle:.2g}°"
