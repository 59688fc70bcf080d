"""Errors of lengths and areas due to the registration of a model.

Lengths, areas and thicknesses do not change if a model is rotated as a whole; only the error of its
scale matters. The rotation matters relative to something that does not rotate with the model: the
vertical, for a horizontal or vertical distance, and the plane of a thickness if it is on another
model or was measured with a compass. All errors are 95 % errors of a single figure.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.orientation import Line
from vomstudio.geometry.plane_sizes import POINT_OVER_RESOLUTION
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.rotation_errors import (
    CHI2_TWO,
    Z95,
    component_error_95,
    horizontal_error_95,
    scale_error_95,
)
from vomstudio.project.measurement import ToWorld
from vomstudio.project.records import Model

_UP = np.array([0.0, 0.0, 1.0])


def registration_errors(
    figures: Mapping[str, float], model: Model | None, step: FloatArray | None
) -> dict[str, float]:
    """Return the errors of a dimension's figures due to the registration of its model.

    Parameters
    ----------
    figures : mapping
        Figures of the dimension by name.
    model : Model or None
        Model on which the dimension was measured.
    step : (3,) float64 or None
        Vector from the first to the last point in the World frame; None for an area.

    Returns
    -------
    dict of str to float
        Errors by name, with "registration95" before the unit. Empty if the model is not registered
        or the error of the registration is unknown.
    """
    shape = _shape(model)
    if shape is None:
        return {}
    relative_error = scale_error_95(shape)
    errors = {
        name: relative_error * figures[name]
        for name in ("distance_m", "length_m", "perimeter_m")
        if name in figures
    }
    if "area_m2" in figures:
        # The area is proportional to the square of the scale.
        errors["area_m2"] = 2.0 * relative_error * figures["area_m2"]
    if step is not None:
        errors["horizontal_m"] = horizontal_error_95(shape, step)
        errors["vertical_m"] = component_error_95(shape, step, _UP)
    return {_error_name(name, "registration95"): value for name, value in errors.items()}


def direction_figures(step: FloatArray, model: Model | None) -> dict[str, float]:
    """Return the trend and plunge of a distance, and the error of the registration.

    Parameters
    ----------
    step : (3,) float64
        Vector from the first to the last point in the World frame.
    model : Model or None
        Model on which the distance was measured.

    Returns
    -------
    dict of str to float
        Degrees; empty if the points coincide.
    """
    if not float(np.linalg.norm(step)) > 0.0:
        return {}
    line = Line.from_vector(step)
    figures = {"trend_deg": line.trend_deg, "plunge_deg": line.plunge_deg}
    tilt = ToWorld.from_model(model).tilt_deg(line.vector())
    return figures if tilt is None else figures | {"direction_registration95_deg": tilt}


def point_errors(figures: Mapping[str, float], resolution_m: float | None) -> dict[str, float]:
    """Return the 95 % errors of a distance and its direction due to the resolution.

    Each coordinate of both points has an error of `POINT_OVER_RESOLUTION` times the resolution. The
    error of the registration is included if it is known.

    Parameters
    ----------
    figures : mapping
        Figures of the dimension by name.
    resolution_m : float or None
        Effective resolution of the model around the points, or None if unknown.

    Returns
    -------
    dict of str to float
        Errors by name; empty if the resolution is unknown.
    """
    distance = figures.get("distance_m", 0.0)
    if not resolution_m or not distance > 0.0:
        return {}
    sigma = float(np.sqrt(2.0)) * POINT_OVER_RESOLUTION * resolution_m
    position_error = float(np.sqrt(CHI2_TWO)) * sigma
    return {
        "distance_error95_m": float(
            np.hypot(Z95 * sigma, figures.get("distance_registration95_m", 0.0))
        ),
        "direction_points95_deg": float(np.degrees(np.arctan2(position_error, distance))),
    }


def thickness_error(
    step: FloatArray, normal: FloatArray, model: Model | None, plane_model: Model | None
) -> float | None:
    """Return the 95 % error of a thickness due to registrations, metres, or None if unknown.

    Parameters
    ----------
    step : (3,) float64
        Vector between the ends of the thickness on `model`, in the World frame.
    normal : (3,) float64
        Normal of the plane in the World frame.
    model : Model or None
        Model on which the ends were picked.
    plane_model : Model or None
        Model on which the plane was picked; None for a compass reading.
    """
    registration, plane_registration = _registration(model), _registration(plane_model)
    shape = None if registration is None else registration.shape_covariance()
    normal_offset = float(step @ normal)
    variance = 0.0 if shape is None else normal_offset**2 * float(shape[3, 3])
    if (registration is None) != (plane_registration is None) or (
        registration and plane_registration and registration.id != plane_registration.id
    ):
        lever_arm = np.cross(step, normal)
        if shape is not None:
            gradient = np.append(lever_arm, normal_offset)
            variance = float(gradient @ shape @ gradient)
        rotation = None if plane_registration is None else plane_registration.rotation_covariance()
        if rotation is not None:
            variance += float(lever_arm @ rotation @ lever_arm)
        elif shape is None:
            return None
    elif shape is None:
        return None
    return Z95 * float(np.sqrt(max(variance, 0.0)))


def _error_name(quantity: str, suffix: str) -> str:
    name, unit = quantity.rsplit("_", 1)
    return f"{name}_{suffix}_{unit}"


def _registration(model: Model | None) -> Registration | None:
    return None if model is None else model.registration


def _shape(model: Model | None) -> FloatArray | None:
    registration = _registration(model)
    return None if registration is None else registration.shape_covariance()
