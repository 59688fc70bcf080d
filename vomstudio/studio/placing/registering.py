"""Placement of a model of the project by points on it, in one edit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.statistics import orientation_tensor
from vomstudio.geometry import transform
from vomstudio.geometry.matrices import Matrix, Point
from vomstudio.geometry.registrations import Method, NorthReference, Registration, RegistrationPoint
from vomstudio.io.control.observation_tables import CompassTable, Pairs
from vomstudio.project.edit import Edit, change
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, Model, Record, TypedFeature, get
from vomstudio.registration.coordinate_checks import (
    check_area,
    relocation_findings,
    require_on_model,
)
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.placing import prepend_warnings
from vomstudio.registration.results import ModelPlacement, PointResidual
from vomstudio.registration.rotation_uncertainty import worst_turn95_deg
from vomstudio.registration.similarity import jacobian
from vomstudio.studio.placing.known_lines import (
    frame_after_placement,
    place_by_known_lines,
    placement_covariance,
    placement_lines,
    up_direction,
)

MAX_SETS_REPORTED = 5
Z_95 = 1.959963984540054


def import_control_points(
    records: Mapping[str, Record],
    model: Model,
    pairs: Pairs,
    known_control_points: Sequence[ControlPoint],
) -> Edit:
    """Create the edit that imports points of a file as control points of a model.

    `known_control_points` are the existing points of the model. A point with the same label gets
    the coordinates of the file.
    """
    existing_points = {point.name: point for point in known_control_points}
    records_after: dict[str, Record | None] = {}
    for row, label in enumerate(pairs.labels):
        control_point = existing_points.get(label)
        if control_point is None:
            control_point = ControlPoint(new_id("control"), label, model.id, model.content_hash)
        is_picked = np.isfinite(pairs.model[row]).all()
        sigma = pairs.sigma[row]
        point = replace(
            control_point,
            position=_to_point(pairs.world[row]),
            sigma_m=_to_point(sigma) if np.isfinite(sigma).all() else None,
            check=bool(pairs.check[row]),
            vertices=(_to_point(pairs.model[row]),) if is_picked else control_point.vertices,
        )
        records_after[point.id] = point
    return change(
        records,
        tr_n("Add {count} control point", "Add {count} control points", len(records_after)),
        records_after,
    )


def control_pairs(points: Sequence[ControlPoint]) -> Pairs:
    """Return pairs for the points that were located on the model and have coordinates."""
    located_points = [p for p in points if p.vertices and p.position is not None]
    unknown_sigma = (np.nan, np.nan, np.nan)
    return Pairs(
        tuple(p.name for p in located_points),
        np.array([p.vertices[0] for p in located_points], np.float64).reshape(-1, 3),
        np.array([p.position for p in located_points], np.float64).reshape(-1, 3),
        np.array([p.sigma_m or unknown_sigma for p in located_points], np.float64).reshape(-1, 3),
        np.array([p.check for p in located_points], bool),
    )


def expected_positions(
    points: Sequence[ControlPoint], placement: ModelPlacement | None, model: Model
) -> dict[str, FloatArray]:
    """Return the expected positions of points without a location, keyed by id.

    The positions (3,) are in the World frame of the present placement. They are computed from
    `placement` or, if it is None, from two points on a model with a known vertical direction.
    """
    remaining_points = [p for p in points if not p.vertices and p.position is not None]
    to_model = (
        _match_two_points(points, model)
        if placement is None
        else transform.invert(placement.matrix)
    )
    if not remaining_points or to_model is None:
        return {}
    world = np.array([p.position for p in remaining_points], np.float64)
    positions = transform.apply(to_model, world)
    if placement is not None:
        positions = transform.apply(model.to_world, positions)
    return {p.id: position for p, position in zip(remaining_points, positions, strict=True)}


def _match_two_points(points: Sequence[ControlPoint], model: Model) -> FloatArray | None:
    """Return the 4 x 4 matrix from the coordinates of points to the placed model, or None.

    Two points that are not vertically above each other determine the rotation about the
    vertical, the scale and the translation. The vertical of the model must be known.
    """
    pairs = control_pairs(points)
    if len(pairs.labels) != 2 or not model.frame.has_up:
        return None
    model_points, target_points = transform.apply(model.to_world, pairs.model), pairs.world
    (x, y, z), (u, v, w) = model_points[1] - model_points[0], target_points[1] - target_points[0]
    horizontal_length, length = np.hypot(u, v), np.linalg.norm([u, v, w])
    if np.hypot(x, y) <= 0.1 * np.linalg.norm([x, y, z]) or horizontal_length <= 0.1 * length:
        return None
    angle = np.arctan2(y, x) - np.arctan2(v, u)
    to_model = np.eye(4)
    to_model[:3, :3] = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
    to_model[:3, :3] *= np.linalg.norm([x, y, z]) / length
    to_model[:3, 3] = model_points.mean(axis=0) - to_model[:3, :3] @ target_points.mean(axis=0)
    return to_model


def place_by_points(
    pairs: Pairs,
    bounds: FloatArray | None,
    model: Model,
    crs: str | None,
    extent: FloatArray | None = None,
    lines: Sequence[KnownLine] = (),
    north_doubt_deg: float = 0.0,
    compass: CompassTable | None = None,
    turned_deg: float = 0.0,
    *,
    is_north_sigma_stated: bool = False,
    photo_up: FloatArray | None = None,
    keep_scale: bool = False,
    click_sigma_m: float | None = None,
    resolution: float | None = None,
) -> ModelPlacement:
    """Place a model by points, lines and compass readings, and check the coordinates.

    Parameters
    ----------
    pairs : Pairs
        Points on the model and their World coordinates.
    bounds : (2, 3) float64 or None
        Bounds of the model in its file's frame.
    model : Model
    crs : str or None
        CRS of the points.
    extent : (n, 3) float64, optional
        Sample of the model's points, in its file's frame.
    lines : sequence of KnownLine, optional
    compass : CompassTable, optional
        Compass readings in the file frame.
    turned_deg : float
        Correction that is added to all azimuths, degrees.
    north_doubt_deg : float
        Standard deviation of the common error of all azimuths, degrees.
    is_north_sigma_stated : bool
        Whether `north_doubt_deg` was stated and is not a default.
    photo_up : (3,) float64, optional
        See `Evidence`.
    keep_scale : bool
        Whether the scale of the model is fixed.
    click_sigma_m : float, optional
        Standard deviation of a click on the model, metres; by default half the resolution.
    resolution : float, optional
        Resolution of the model in the unit of its file.

    Raises
    ------
    GeometryError
        If the placement is not determined, or the points are far from the model.
    """
    require_on_model(pairs.model, bounds)
    if not placement_lines(lines) and compass is None:
        evidence = Evidence(
            pairs=pairs,
            click_sigma_m=click_sigma_m,
            resolution=resolution,
            up=up_direction(model),
            crs=crs,
        )
        if keep_scale:
            evidence.scale = transform.scale_factor(model.to_world)
            registration = model.registration
            evidence.scale_error = None if registration is None else registration.scale_error
        placement = register(evidence, extent)
    else:
        placement = place_by_known_lines(
            pairs,
            lines,
            model,
            extent,
            north_doubt_deg,
            compass,
            turned_deg,
            is_north_sigma_stated=is_north_sigma_stated,
            photo_up=photo_up,
            keep_scale=keep_scale,
            click_sigma_m=click_sigma_m,
            resolution=resolution,
        )
    if not len(pairs.labels):
        return placement
    findings = check_area(pairs.world, crs)
    # The position of a registered model differs from that in its file.
    is_in_file_frame = (
        model.registration is None and model.frame.crs == crs and placement.known.position
    )
    if bounds is not None and crs is not None and is_in_file_frame:
        checked_points = bounds if extent is None or not len(extent) else extent
        findings += relocation_findings(
            transform.apply(model.to_world, checked_points), placement(checked_points), crs
        )
    return prepend_warnings(placement, findings)


def create_registration(
    placement: ModelPlacement,
    pairs: Pairs | None,
    model: Model,
    crs: str | None,
    reference: str = "",
    read_north: NorthReference | None = None,
) -> Registration:
    """Return the registration record of a placement, in `crs` or in a local frame.

    A model that was placed by the same method before keeps the id of its registration.
    `reference` is the name of the reference of a fit, or "" for a placement by pairs and known
    lines. `read_north` is the north reference of the azimuths, or None if no azimuths were used.
    """
    previous_registration = model.registration
    has_points = pairs is not None and bool(len(pairs.labels))
    method, name = _method(placement, model.name, reference, has_points=has_points)
    id_ = (
        previous_registration.id
        if previous_registration is not None and previous_registration.method == method
        else new_id("registration")
    )
    error = placement.rotation_error_deg
    covariance = placement_covariance(placement, previous_registration)
    rotation_errors = None
    if (
        error.about_up is not None
        and error.about_east is not None
        and error.about_north is not None
    ):
        rotation_errors = (error.about_up, error.about_east, error.about_north)
    return Registration(
        id_,
        name,
        method,
        frame_after_placement(placement, model, crs),
        _matrix(placement),
        rotation_error_deg=rotation_errors,
        scale_error=float(np.sqrt(covariance[3, 3])),
        rms_control_m=placement.rms_control_m,
        rms_check_m=placement.rms_check_m,
        control=() if pairs is None else _registration_points(placement, pairs),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        centre=placement.centre,
        reach_m=placement.reach_m,
        normal=placement.normal,
        # Angles and ratios are invariant under a similarity.
        lens_bowing95_deg=None
        if previous_registration is None
        else previous_registration.lens_bowing95_deg,
        lens_stretch95=None
        if previous_registration is None
        else previous_registration.lens_stretch95,
        read_north=read_north,
        observations=placement.observations,
        click_sigma_m=placement.click_sigma_m,
    )


def _method(
    placement: ModelPlacement, model: str, reference: str, *, has_points: bool
) -> tuple[Method, str]:
    """Return the main method of a registration, and the name of the registration."""
    if reference:
        return "reference", tr("{model} fitted to {reference}", model=model, reference=reference)
    if has_points:
        return "points", tr("points on {model}", model=model)
    kinds = {group.kind for group in placement.observations}
    if "cameras" in kinds:
        return "gps", tr("camera positions of {model}", model=model)
    if kinds & {"attitudes", "verticals"}:
        return "attitudes", tr("camera attitudes of {model}", model=model)
    return "lines", tr("known lines and planes on {model}", model=model)


def add_reference_error(
    record: Registration, other_registration: Registration | None, *, scale_fitted: bool
) -> Registration:
    """Add the error of the reference to the registration of a model fitted to it.

    Parameters
    ----------
    record : Registration
        Registration by the fit, without the errors of the reference.
    other_registration : Registration, optional
        Registration of the reference, or None if the reference has no registration.
    scale_fitted : bool
        Whether the model was scaled to the reference. Otherwise a scale error of the reference
        only shifts the model.

    Returns
    -------
    Registration
        Registration with combined errors, or `record` unchanged if the errors of either are
        unknown.
    """
    if other_registration is None or record.covariance is None or record.centre is None:
        return record
    shape = other_registration.shape_covariance()
    if shape is None:
        return record
    other_covariance, offsets = np.zeros((7, 7)), np.zeros(3)
    other_covariance[:4, :4] = shape
    if other_registration.covariance is not None and other_registration.centre is not None:
        other_covariance = np.array(other_registration.covariance, np.float64)
        offsets = np.subtract(record.centre, other_registration.centre)
    # A rotation or scale about the centre also shifts other points.
    moves = np.eye(7)
    moves[4:] = jacobian(offsets)
    moves[3, 3] = 1.0 if scale_fitted else 0.0
    total = np.array(record.covariance, np.float64) + moves @ other_covariance @ moves.T
    east, north, up, scale = np.sqrt(np.diag(total)[:4]).tolist()
    axis_rotations_deg = np.degrees([up, east, north]).tolist()
    return replace(
        record,
        covariance=tuple(tuple(row) for row in total.tolist()),
        rotation_error_deg=(axis_rotations_deg[0], axis_rotations_deg[1], axis_rotations_deg[2]),
        scale_error=scale,
    )


def reference_findings(record: Registration) -> tuple[Finding, ...]:
    """Return a finding on the combined errors of a fit and its reference; empty if unknown."""
    rotation, scale = worst_turn95_deg(record.rotation_covariance()), record.scale_error
    if rotation is None or scale is None:
        return ()
    values = {"rotation95_deg": rotation, "scale95_percent": 100.0 * Z_95 * scale}
    return (Finding("registration.reference-error", **values),)


def rotation_deg(previous_model: Model, new_model: Model) -> float:
    """Return the angle between two placements of a model, degrees."""
    return float(
        np.degrees(Rotation.from_matrix(_rotation_between(previous_model, new_model)).magnitude())
    )


def set_rotations_deg(
    records: Mapping[str, Record],
    previous_model: Model,
    new_model: Model,
    measurements: Mapping[str, Measurement],
) -> dict[str, float]:
    """Return the rotation of the mean pole of each set of planes, degrees.

    A rotation about the pole itself does not change a plane.

    Parameters
    ----------
    records : mapping
    previous_model, new_model : Model
        Model before and after the placement.
    measurements : mapping of str to Measurement
        Measurements of the features in `records` after the placement.

    Returns
    -------
    dict of str to float
        Rotation, keyed by feature type and set name.
    """
    poles: dict[str, list[FloatArray]] = {}
    for id_, figures in measurements.items():
        feature = records.get(id_)
        if (
            figures.plane is None
            or not isinstance(feature, TypedFeature)
            or getattr(feature, "model_id", "") != new_model.id
        ):
            continue
        feature_type = get(records, feature.type_id, FeatureType)
        name = feature.type_id if feature_type is None else feature_type.name
        name = f"{name}: {feature.set_name}" if feature.set_name else name
        poles.setdefault(name, []).append(figures.plane.normal())
    rotation_back = _rotation_between(previous_model, new_model).T
    rotations = {}
    for name, poles_of_set in poles.items():
        mean = orientation_tensor(np.array(poles_of_set))[1][0]
        rotations[name] = float(
            np.degrees(np.arccos(min(1.0, abs(float(mean @ rotation_back @ mean)))))
        )
    return rotations


def set_rotation_finding(rotation_by_set_deg: Mapping[str, float]) -> Finding | None:
    """Return the finding on set rotations, largest first, or None if there are no sets."""
    sorted_rotations = sorted(rotation_by_set_deg.items(), key=lambda each: -each[1])
    parts = [
        tr("{set_name} by {turn:.1f}°", set_name=name, turn=rotation)
        for name, rotation in sorted_rotations[:MAX_SETS_REPORTED]
    ]
    if len(sorted_rotations) > MAX_SETS_REPORTED:
        parts.append(tr("others by less"))
    return Finding("registration.sets-turned", sets=parts) if parts else None


def _rotation_between(previous_model: Model, new_model: Model) -> FloatArray:
    """Return the rotation matrix (3, 3) between two placements."""
    previous_matrix, new_matrix = (
        transform.matrix(m.to_world) for m in (previous_model, new_model)
    )
    return np.asarray(
        (new_matrix[:3, :3] / transform.scale_factor(new_matrix))
        @ (previous_matrix[:3, :3] / transform.scale_factor(previous_matrix)).T
    )


def _matrix(placement: ModelPlacement) -> Matrix:
    rows = [(row[0], row[1], row[2], row[3]) for row in placement.matrix.tolist()]
    return (rows[0], rows[1], rows[2], rows[3])


def _registration_points(placement: ModelPlacement, pairs: Pairs) -> tuple[RegistrationPoint, ...]:
    """Return the points of a registration in the order of the table."""
    residuals: dict[str, PointResidual] = {
        point.label: point for point in (*placement.control, *placement.check)
    }
    rows = []
    for row, label in enumerate(pairs.labels):
        residual = residuals[label]
        sigma = pairs.sigma[row]
        rows.append(
            RegistrationPoint(
                label,
                _to_point(pairs.model[row]),
                _to_point(pairs.world[row]),
                (residual.dx, residual.dy, residual.dz),
                _to_point(sigma) if np.isfinite(sigma).all() else None,
                bool(pairs.check[row]),
            )
        )
    return tuple(rows)


def _to_point(row: np.ndarray) -> Point:
    x, y, z = (float(v) for v in row)
    return (x, y, z)
