"""Comment lines of a table that state the covariance of the rotation of each registration.

The column `registration_error_deg` contains only one half-angle per row and does not
describe the axis about which a model may be rotated.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vomstudio.geometry.registrations import Registration
from vomstudio.io.text.registration_comments import REGISTRATION_PREFIX
from vomstudio.project.records import Feature, Model, ModelFeature, Record, get
from vomstudio.project.registration_errors import bowing_limit_deg


def find_registrations(
    records: Mapping[str, Record], features: Iterable[Feature]
) -> list[dict[str, Any]]:
    """Return the registrations used by the models of some features.

    Registrations without a known rotation error are omitted.

    Returns
    -------
    list of dict
        ``models``: names of the models. ``rotation_covariance_deg2``: covariance (3, 3) about east,
        north and up, in degrees squared. ``bowed_deg``: possible difference in dip between the
        edges; missing if unknown.
    """
    ids = dict.fromkeys(
        feature.model_id for feature in features if isinstance(feature, ModelFeature)
    )
    models_of_registration: dict[str, tuple[Registration, list[str]]] = {}
    for id_ in ids:
        model = get(records, id_, Model)
        registration = None if model is None else model.registration
        if model is not None and registration is not None:
            models_of_registration.setdefault(registration.id, (registration, []))[1].append(
                model.name
            )
    result = []
    for registration, models in models_of_registration.values():
        covariance = registration.rotation_covariance()
        if covariance is not None:
            degrees = covariance * np.degrees(1.0) ** 2
            values: dict[str, Any] = {
                "models": models,
                "rotation_covariance_deg2": degrees.tolist(),
            }
            bowed_deg = bowing_limit_deg(registration)
            if bowed_deg is not None:
                values["bowed_deg"] = bowed_deg
            result.append(values)
    return result


def registration_lines(registrations: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return one comment line per registration, without the leading `#`."""
    return [
        f"{REGISTRATION_PREFIX} {json.dumps(dict(registration))}" for registration in registrations
    ]
