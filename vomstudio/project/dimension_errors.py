"""What the registration of a model does to the lengths and areas that are measured on it.

A model that is turned as a whole has the same lengths, areas and thicknesses: only its scale counts
for them. Its rotation counts where something stays while the model turns: the vertical, for a
horizontal or vertical distance, and the plane of a thickness where that is on another model, or was
read with a compass. All errors are 95 %, each of its one figure.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.rotation_errors import (
    Z95,
    component_error_95,
    horizontal_error_95,
    scale_error_95,
)
from vomstudio.project.records import Model

_UP = np.array([0.0, 0.0, 1.0])


def registration_errors(
    figures: Mapping[str, float], model: Model | None, step: FloatArray | None
) -> dict[str, float]:
    """Of the figures of a dimension on a model, under their names with `_registration95` before the
    unit; nothing where the model's registration, or its error, is not known.

    step : (3,) World, from its first point to its last, None for an area
    """
    shape = _shape(model)
    if shape is None:
        return {}
    share = scale_error_95(shape)
    found = {
        name: share * figures[name]
        for name in ("distance_m", "length_m", "perimeter_m")
        if name in figures
    }
    if "area_m2" in figures:
        # Lengths to the second power.
        found["area_m2"] = 2.0 * share * figures["area_m2"]
    if step is not None:
        found["horizontal_m"] = horizontal_error_95(shape, step)
        found["vertical_m"] = component_error_95(shape, step, _UP)
    return {_named(name, "registration95"): value for name, value in found.items()}


def thickness_error(
    step: FloatArray, normal: FloatArray, model: Model | None, of_plane: Model | None
) -> float | None:
    """Of a thickness: `step` (3,) between its ends on one model, across a plane with this normal
    (3,) on another, or on none; None where no error of a registration is known."""
    own, other = _registration(model), _registration(of_plane)
    shape = None if own is None else own.shape_covariance()
    across = float(step @ normal)
    variance = 0.0 if shape is None else across**2 * float(shape[3, 3])
    if (own is None) != (other is None) or (own and other and own.id != other.id):
        lever = np.cross(step, normal)
        if shape is not None:
            gradient = np.append(lever, across)
            variance = float(gradient @ shape @ gradient)
        turned = None if other is None else other.rotation_covariance()
        if turned is not None:
            variance += float(lever @ turned @ lever)
        elif shape is None:
            return None
    elif shape is None:
        return None
    return Z95 * float(np.sqrt(max(variance, 0.0)))


def _named(figure: str, what: str) -> str:
    name, unit = figure.rsplit("_", 1)
    return f"{name}_{what}_{unit}"


def _registration(model: Model | None) -> Registration | None:
    return None if model is None else model.registration


def _shape(model: Model | None) -> FloatArray | None:
    registration = _registration(model)
    return None if registration is None else registration.shape_covariance()
