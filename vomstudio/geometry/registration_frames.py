"""Changes of registrations when the World axes or the file coordinates of a model change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import IDENTITY, Matrix, Point
from vomstudio.geometry.registrations import Registration, RegistrationPoint


def change_world_frame(
    registration: Registration, change_matrix: npt.ArrayLike, frame: Frame
) -> Registration:
    """Return a registration after a similarity of the World frame.

    Parameters
    ----------
    registration : Registration
    change_matrix : (4, 4) float
        Similarity from the World frame to the new World frame.
    frame : Frame
        Description of the new World frame.

    Returns
    -------
    Registration
        Registration whose rotations and translations refer to the new axes, and whose lengths are
        scaled by `change_matrix`.
    """
    rows = transform.matrix(np.asarray(change_matrix, np.float64))
    scale = transform.scale_factor(rows)
    rotation = rows[:3, :3] / scale
    covariance = None
    if registration.covariance is not None:
        change = np.eye(7)
        change[:3, :3], change[4:, 4:] = rotation, scale * rotation
        old_covariance = np.array(registration.covariance, np.float64)
        covariance = tuple(map(tuple, (change @ old_covariance @ change.T).tolist()))
    rotations = registration.rotation_error_deg
    if rotations is not None:
        up, east, north = rotations
        east, north, up = _rotate_sigma((east, north, up), rotation)
        rotations = (up, east, north)

    def scale_length(length: float | None) -> float | None:
        return None if length is None else scale * length

    def transform_point(point: Point) -> Point:
        return _to_point(transform.apply(rows, [point])[0])

    def transform_control(point: RegistrationPoint) -> RegistrationPoint:
        sigma = point.sigma_m
        if sigma is not None:
            sigma = _to_point(scale * np.array(_rotate_sigma(sigma, rotation)))
        residual = _to_point(scale * rotation @ np.array(point.residual))
        return replace(point, world=transform_point(point.world), residual=residual, sigma_m=sigma)

    return replace(
        registration,
        frame=frame,
        matrix=_to_matrix(rows @ transform.matrix(registration.matrix)),
        rotation_error_deg=rotations,
        rms_control_m=scale_length(registration.rms_control_m),
        rms_check_m=scale_length(registration.rms_check_m),
        control=tuple(map(transform_control, registration.control)),
        covariance=covariance,
        centre=None if registration.centre is None else transform_point(registration.centre),
        reach_m=scale_length(registration.reach_m),
        normal=(
            None
            if registration.normal is None
            else _to_point(rotation @ np.array(registration.normal))
        ),
    )


def change_file_frame(registration: Registration, change_matrix: npt.ArrayLike) -> Registration:
    """Return a registration after a similarity of the file coordinates of the model.

    The position of the model in the World frame and its errors do not change. If the new
    file coordinates are World coordinates, the matrix is the identity.

    Parameters
    ----------
    registration : Registration
    change_matrix : (4, 4) float
        Similarity from the old to the new file coordinates.
    """
    rows = transform.matrix(np.asarray(change_matrix, np.float64))
    old_matrix = transform.matrix(registration.matrix)
    if np.array_equal(rows, np.eye(4)):
        return registration
    matrix = IDENTITY
    if not np.array_equal(rows, old_matrix):
        matrix = _to_matrix(old_matrix @ transform.invert(rows))
    control = tuple(
        replace(point, model=_to_point(transform.apply(rows, [point.model])[0]))
        for point in registration.control
    )
    return replace(registration, matrix=matrix, control=control)


def is_same_registration(first: Registration, second: Registration) -> bool:
    """Return whether two registrations are equal apart from ids of records and the name.

    Parameters
    ----------
    first, second : Registration

    Returns
    -------
    bool
    """
    renamed_registration = replace(
        first,
        id=second.id,
        name=second.name,
        reconstruction_id=second.reconstruction_id,
    )
    return renamed_registration == second


def _rotate_sigma(sigma: Point, rotation: FloatArray) -> Point:
    """Return independent one-sigma errors along rotated axes."""
    variances = np.einsum("ij,j->i", rotation**2, np.square(sigma))
    return _to_point(np.sqrt(variances))


def _to_matrix(rows: FloatArray) -> Matrix:
    a, b, c, d = ((row[0], row[1], row[2], row[3]) for row in rows.tolist())
    return (a, b, c, d)


def _to_point(values: FloatArray) -> Point:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
