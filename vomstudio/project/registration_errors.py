"""Effects of the registrations of models on their features."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology import orientation
from vomstudio.geology.bowing import MIN_BOWING_POINTS, Bowing, bowing_deg, fit_bowing
from vomstudio.geology.common_rotation_errors import (
    RotationErrors,
    group_rotation_errors,
)
from vomstudio.geology.quality import governing_half_angles, resolution_tilt_deg
from vomstudio.geometry.registrations import Registration, RegistrationPoint
from vomstudio.geometry.rotation_errors import CHI2_TWO, direction_covariance
from vomstudio.project.measurement import Measurement, Records
from vomstudio.project.records import Feature, Model, ModelFeature, get

OUTLIER_RATIO = 6.0
"""Points whose residual exceeds this multiple of the median are treated as outliers."""


def get_model(records: Records, feature: Feature | None) -> Model | None:
    """Return the model of a feature, or None if it has none or the model was removed."""
    return get(records, feature.model_id, Model) if isinstance(feature, ModelFeature) else None


def get_models(records: Records, features: Iterable[Feature]) -> list[Model | None]:
    """Return `get_model` for many features on a few models."""
    ids = [feature.model_id if isinstance(feature, ModelFeature) else "" for feature in features]
    models = {id_: get(records, id_, Model) for id_ in set(ids)}
    return [models[id_] for id_ in ids]


def get_rotation_errors(models: Iterable[Model | None]) -> RotationErrors:
    """Return the rotation errors of features, given the model of each feature.

    Features on models that were placed by the same registration rotate together.
    """
    rotations_by_model: dict[int, tuple[object, FloatArray | None]] = {}
    feature_rotations = []
    for model in models:
        if id(model) not in rotations_by_model:
            registration = None if model is None else model.registration
            rotation = None if registration is None else registration.rotation_covariance()
            rotations_by_model[id(model)] = (
                None if registration is None else registration.id,
                rotation,
            )
        feature_rotations.append(rotations_by_model[id(model)])
    return group_rotation_errors(feature_rotations)


def normal_covariance(measurement: Measurement, model: Model | None) -> FloatArray | None:
    """Return the covariance of a fitted plane's upward normal, as used in its total error.

    Parameters
    ----------
    measurement : Measurement
    model : Model or None
        Model on which the plane was measured. The covariance of its registration's rotation is
        added; if it is unknown, the measured registration error applies in all directions.

    Returns
    -------
    (3, 3) float or None
        Covariance in east, north and up, in radians squared; its eigenvalues times 5.99 are the
        squares of the semi-axes of the 95 % region. None if the error is unknown or is 90 degrees.
    """
    return normal_covariances([measurement], [model])[0]


def normal_covariances(
    measurements: Sequence[Measurement], models: Sequence[Model | None]
) -> list[FloatArray | None]:
    """Compute `normal_covariance` for many measurements at once, which is much faster.

    Parameters
    ----------
    measurements : sequence of Measurement
    models : sequence of Model or None
        Model of each measurement.

    Returns
    -------
    list of (3, 3) ndarray or None
    """
    covariances: list[FloatArray | None] = [None] * len(measurements)
    rows = [_region_angles(measurement) for measurement in measurements]
    indices = [i for i, row in enumerate(rows) if row is not None]
    if not indices:
        return covariances
    dip_direction, dip, rake, major, minor = np.array([rows[i] for i in indices]).T
    normals = orientation.planes_to_normals(dip_direction, dip)
    along = orientation.rake_vectors(dip_direction, dip, rake)
    along -= normals * (along * normals).sum(axis=1)[:, None]
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.cross(normals, along)
    squares = [
        (np.radians(angles) ** 2 / CHI2_TWO)[:, None, None] * axes[:, :, None] * axes[:, None, :]
        for angles, axes in ((major, along), (minor, across))
    ]
    for i, normal, covariance in zip(indices, normals, squares[0] + squares[1], strict=True):
        rotation = _rotation_covariance(measurements[i], models[i])
        if rotation is not None:
            covariance = covariance + direction_covariance(rotation, normal)[0]
        covariances[i] = covariance
    return covariances


def _region_angles(measurement: Measurement) -> tuple[float, float, float, float, float] | None:
    """Return the dip direction, dip, error rake and half-angles of a measured plane.

    Returns None if the error is unknown or at least 90 degrees.
    """
    fit, plane = measurement.fit, measurement.plane
    if fit is None or plane is None or fit.error_rake_deg is None or fit.error is not None:
        return None
    major_deg, minor_deg = governing_half_angles(
        fit,
        measurement.verdict_kind,
        measurement.resolution_m,
        measurement.outcrop_normal,
        measurement.stretch_error_deg,
    )
    if major_deg is None or minor_deg is None or major_deg >= 90.0:
        return None
    tilt_deg = resolution_tilt_deg(fit, measurement.resolution_m, measurement.verdict_kind) or 0.0
    major_deg = max(major_deg, tilt_deg)
    return plane.dip_direction_deg, plane.dip_deg, fit.error_rake_deg, major_deg, minor_deg


def _rotation_covariance(measurement: Measurement, model: Model | None) -> FloatArray | None:
    registration = None if model is None else model.registration
    rotation = None if registration is None else registration.rotation_covariance()
    if rotation is None and measurement.registration_error_deg is not None:
        rotation = np.radians(measurement.registration_error_deg) ** 2 / CHI2_TWO * np.eye(3)
    return rotation


def registration_bowing(registration: Registration | None) -> Bowing | None:
    """Estimate the bowing of a model from its control residuals, excluding outliers.

    Returns None if there are too few points or if their residuals do not constrain the bowing.
    """
    if registration is None or not registration.control:
        return None
    points: Sequence[RegistrationPoint] = registration.control
    check_points = [point for point in points if point.check]
    # A model that was fitted to its control points agrees with them, whether it is bowed or not.
    if registration.method == "control" and len(check_points) >= MIN_BOWING_POINTS:
        points = check_points
    world, residuals = (
        np.array([getattr(point, name) for point in points], np.float64)
        for name in ("world", "residual")
    )
    sigma = np.array([point.sigma_m or (np.nan,) * 3 for point in points], np.float64)
    length = np.linalg.norm(residuals, axis=1)
    inliers = length <= OUTLIER_RATIO * float(np.median(length))
    normal = None if registration.normal is None else np.array(registration.normal)
    bowing = fit_bowing(world[inliers], residuals[inliers], sigma[inliers], normal=normal)
    # The edge of the model may extend beyond the control points.
    reach_m = registration.reach_m
    return bowing if bowing is None or reach_m is None else replace(bowing, reach_m=reach_m)


def bowing_limit_deg(registration: Registration) -> float | None:
    """Return the possible difference in dip between the edges, as in `bowing.bowing_deg`.

    Returns None if it is unknown.
    """
    return bowing_deg(registration.lens_bowing95_deg, registration_bowing(registration))


def max_bowing_deg(models: Iterable[Model | None]) -> float | None:
    """Return the possible difference in dip between the edges of the most bowed model.

    Returns None if the bowing of all models is unknown.
    """
    registrations = {
        model.registration.id: model.registration
        for model in models
        if model and model.registration
    }
    limits = [bowing_limit_deg(registration) for registration in registrations.values()]
    return max((registration for registration in limits if registration is not None), default=None)
