"""What the registrations of models do to the features on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology import orientation
from vomstudio.geology.bowing import FEWEST, Bowing, bowing_deg, bowing_of
from vomstudio.geology.common_rotation_errors import Turns, squared_region, together
from vomstudio.geology.quality import resolution_tilt_deg, wider_of
from vomstudio.geometry.registrations import Registration, RegistrationPoint
from vomstudio.geometry.rotation_errors import CHI2_TWO, direction_covariance
from vomstudio.project.measurement import Measurement, Records
from vomstudio.project.records import Feature, Model, OnAModel, get

_WRONG = 6.0
"""A point is wrong that is so many times further off than half of the points are."""


def model_of(records: Records, feature: Feature | None) -> Model | None:
    """The model that a feature is on; None for one that is on none, or whose model is gone."""
    return get(records, feature.model_id, Model) if isinstance(feature, OnAModel) else None


def models_of(records: Records, features: Iterable[Feature]) -> list[Model | None]:
    """As `model_of`, of thousands of features on a few models."""
    ids = [f.model_id if isinstance(f, OnAModel) else "" for f in features]
    models = {id_: get(records, id_, Model) for id_ in set(ids)}
    return [models[id_] for id_ in ids]


def turns_of(models: Iterable[Model | None]) -> Turns:
    """How features on these models, one each, turn with the registrations; models that were placed
    by one registration turn together."""
    known: dict[int, tuple[object, FloatArray | None]] = {}
    found = []
    for model in models:
        if id(model) not in known:
            registration = None if model is None else model.registration
            rotation = None if registration is None else registration.rotation_covariance()
            known[id(model)] = (None if registration is None else registration.id, rotation)
        found.append(known[id(model)])
    return together(found)


def normal_covariance(measured: Measurement, model: Model | None) -> FloatArray | None:
    """Return the covariance of a fitted plane's upward normal, with all that its total error has.

    Parameters
    ----------
    measured : Measurement
    model : Model or None
        Its registration turns the plane as its rotation's covariance states; without one the
        measured registration error counts alike in all directions.

    Returns
    -------
    (3, 3) float or None
        East, north, up, radians squared; the 95 % region has the squares of its semi-axes times
        5.99. None if the error is not known, or 90 degrees.
    """
    fit, plane = measured.fit, measured.plane
    if fit is None or plane is None or fit.error_rake_deg is None or fit.error is not None:
        return None
    largest, smallest = wider_of(
        fit,
        measured.judged_as,
        measured.resolution_m,
        measured.outcrop_normal,
        measured.stretch_error_deg,
    )
    if largest is None or smallest is None or largest >= 90.0:
        return None
    normal = plane.normal()
    toward = orientation.line_from_rake(plane, fit.error_rake_deg).vector()
    largest = max(
        largest, resolution_tilt_deg(fit, measured.resolution_m, measured.judged_as) or 0.0
    )
    covariance = squared_region(normal, largest, smallest, toward) / CHI2_TWO
    registration = None if model is None else model.registration
    rotation = None if registration is None else registration.rotation_covariance()
    if rotation is None and measured.registration_error_deg is not None:
        rotation = np.radians(measured.registration_error_deg) ** 2 / CHI2_TWO * np.eye(3)
    if rotation is not None:
        covariance = covariance + direction_covariance(rotation, normal)[0]
    return np.asarray(covariance)


def bowing_of_registration(registration: Registration | None) -> Bowing | None:
    """The bowing that the residuals of its points show, wrong ones left out; None where there are
    too few, or they tell nothing of it."""
    if registration is None or not registration.control:
        return None
    points: Sequence[RegistrationPoint] = registration.control
    judges = [p for p in points if p.check]
    # A model that was bent to its control fits that, bowed or not.
    if registration.method == "control" and len(judges) >= FEWEST:
        points = judges
    world, left = (
        np.array([getattr(p, name) for p in points], np.float64) for name in ("world", "residual")
    )
    sigma = np.array([p.sigma_m or (np.nan,) * 3 for p in points], np.float64)
    length = np.linalg.norm(left, axis=1)
    right = length <= _WRONG * float(np.median(length))
    normal = None if registration.normal is None else np.array(registration.normal)
    found = bowing_of(world[right], left[right], sigma[right], normal=normal)
    # The edge is that of the model, which may reach farther than its points.
    reach = registration.reach_m
    return found if found is None or reach is None else replace(found, reach_m=reach)


def may_be_bowed_deg(registration: Registration) -> float | None:
    """By how much dips may differ from edge to edge of a model, as in `bowing.bowing_deg`."""
    return bowing_deg(registration.lens_bowing95_deg, bowing_of_registration(registration))


def bowed_deg(models: Iterable[Model | None]) -> float | None:
    """By how much dips may differ from edge to edge of the worst bowed of these models; None where
    nothing tells of it."""
    registrations = {m.registration.id: m.registration for m in models if m and m.registration}
    found = [may_be_bowed_deg(each) for each in registrations.values()]
    return max((each for each in found if each is not None), default=None)
