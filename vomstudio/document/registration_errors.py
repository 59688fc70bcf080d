"""What the registrations of models do to the features on them."""

from __future__ import annotations

from collections.abc import Iterable

from vomstudio.document.measurement import Floats, Measurement, Records
from vomstudio.document.records import Feature, Model, OnAModel, get
from vomstudio.geology import orientation
from vomstudio.geology.common_turns import Region, Turns, region, together
from vomstudio.geometry.tilts import direction_covariance


def model_of(records: Records, feature: Feature | None) -> Model | None:
    """The model that a feature is on; None for one that is on none, or whose model is gone."""
    return get(records, feature.model_id, Model) if isinstance(feature, OnAModel) else None


def turns_of(models: Iterable[Model | None]) -> Turns:
    """How features on these models, one each, turn with the registrations; models that were placed
    by one registration turn together."""
    known: dict[int, tuple[object, Floats | None]] = {}
    found = []
    for model in models:
        if id(model) not in known:
            registration = None if model is None else model.registration
            rotation = None if registration is None else registration.rotation_covariance()
            known[id(model)] = (None if registration is None else registration.id, rotation)
        found.append(known[id(model)])
    return together(found)


def pole_region(measured: Measurement, model: Model | None) -> Region | None:
    """The joint 95 % region of a fitted plane's normal together with the registration of its model;
    None where one of the two is not known."""
    fit = measured.fit
    registration = None if model is None else model.registration
    rotation = None if registration is None else registration.rotation_covariance()
    if rotation is None or fit is None or measured.plane is None:
        return None
    if fit.max_confidence95_deg is None or fit.error_rake_deg is None:
        return None
    toward = orientation.line_from_rake(measured.plane, fit.error_rake_deg).vector()
    own = (fit.max_confidence95_deg, fit.min_confidence95_deg or 0.0, toward)
    normal = measured.plane.normal()
    return region(normal, direction_covariance(rotation, normal)[0], own)
