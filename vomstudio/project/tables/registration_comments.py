"""The lines of a table's `#` block that say how far each registration's rotation is known.

They make a table complete: from `registration_error_deg`, one half-angle a row, the axis about
which a model may be turned cannot be told.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vomstudio.geometry.registrations import Registration
from vomstudio.io.text.registration_comments import REGISTRATION_PREFIX
from vomstudio.project.records import Feature, Model, OnAModel, Record, get
from vomstudio.project.registration_errors import may_be_bowed_deg


def registrations_of(
    records: Mapping[str, Record], features: Iterable[Feature]
) -> list[dict[str, Any]]:
    """The registrations of the models that features are on, as far as their error is known.

    models : their names; rotation_covariance_deg2 : (3, 3) about east, north and up, degrees
    squared; bowed_deg : by how much dips may differ from edge to edge, where
    that is known
    """
    ids = dict.fromkeys(f.model_id for f in features if isinstance(f, OnAModel))
    found: dict[str, tuple[Registration, list[str]]] = {}
    for id_ in ids:
        model = get(records, id_, Model)
        registration = None if model is None else model.registration
        if model is not None and registration is not None:
            found.setdefault(registration.id, (registration, []))[1].append(model.name)
    told = []
    for registration, models in found.values():
        covariance = registration.rotation_covariance()
        if covariance is not None:
            degrees = covariance * np.degrees(1.0) ** 2
            own: dict[str, Any] = {"models": models, "rotation_covariance_deg2": degrees.tolist()}
            bowed = may_be_bowed_deg(registration)
            if bowed is not None:
                own["bowed_deg"] = bowed
            told.append(own)
    return told


def registration_lines(told: Sequence[Mapping[str, Any]]) -> list[str]:
    """One line each, without the `#`."""
    return [f"{REGISTRATION_PREFIX} {json.dumps(dict(each))}" for each in told]
