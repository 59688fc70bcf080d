"""Observations from camera attitudes, complete or separated into vertical and north."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import Bowing, fit_bowing_to_rotations
from vomstudio.geology.view_attitudes import (
    camera_rotations,
    error_axes,
    rotations_from_vertical,
    view_angles,
)
from vomstudio.geometry.cameras import View
from vomstudio.io.control.attitude_tables import AttitudeTable, gravity_directions
from vomstudio.registration.attitude_checks import find_outliers, find_vertical_outliers
from vomstudio.registration.observations import Attitudes, Azimuths, ObservationKind, Verticals
from vomstudio.registration.similarity import Similarity

NORTH_SIGMA_DEG = 10.0
"""Default one-sigma error of compass north, due to steel, rocks and the phone itself."""
MOUNT_SIGMA_DEG = 1.0
"""Default one-sigma misalignment of a gimbal or accelerometer with its camera, about each axis.

It is common to all photos, which reveal it only if they look in several directions. (A drone that
recorded -89.9 degrees looked 1.5 degrees off the vertical.)"""
_OUTLIER_FACTOR = 6.0
"""Multiple of the median deviation beyond which verticals are outliers."""
# Steeper views have no meaningful azimuth.
_MAX_STEEPNESS_DEG = 60.0


@dataclass(frozen=True, eq=False)
class AttitudeEvidence:
    """Observations from camera attitudes.

    Attributes
    ----------
    kinds : tuple of ObservationKind
    angles, model : (n, 3) and (n, 3, 3) array
        Attitudes of the photos with a complete attitude: angles in the World frame (degrees), and
        rotations to the model.
    """

    kinds: tuple[ObservationKind, ...]
    angles: FloatArray
    model: FloatArray


def match_attitudes(
    table: AttitudeTable,
    rows: Sequence[int],
    views: Sequence[View],
    north_sigma_deg: float,
    findings: list[Finding],
) -> AttitudeEvidence:
    """Match the attitudes of a table to the cameras of the model.

    Parameters
    ----------
    table : AttitudeTable
        Attitudes, with yaws relative to grid north.
    rows : sequence of int
        Rows of `views` in the table.
    views : sequence of View
    north_sigma_deg : float
        One-sigma error common to all yaws.
    findings : list of Finding
        List to which findings about excluded attitudes are appended.

    Returns
    -------
    AttitudeEvidence
    """
    row_indices = np.asarray(rows, int)
    labels = [table.photos[row] for row in rows]
    model = np.array([np.asarray(view.rotation).T for view in views]).reshape(-1, 3, 3)
    angles, sigma = table.angles[row_indices], np.radians(table.sigma[row_indices])
    down = gravity_directions(table)[row_indices]
    is_complete = np.isfinite(angles).all(axis=1)
    yaw, tilt = np.isfinite(angles[:, 0]), np.isfinite(down[:, 0])
    is_phone = yaw & tilt & ~is_complete
    is_phone &= _has_azimuth(labels, is_phone, down, findings)
    has_full_attitude = is_complete | is_phone
    known_angles = np.full_like(angles, np.nan)
    known_angles[is_complete] = angles[is_complete]
    if is_phone.any():
        known_angles[is_phone] = view_angles(
            rotations_from_vertical(down[is_phone], angles[is_phone, 0])
        )
    is_invalid, is_tilted = np.zeros((2, len(labels)), bool)
    is_invalid[has_full_attitude], is_tilted[has_full_attitude] = find_outliers(
        _select_labels(labels, has_full_attitude),
        known_angles[has_full_attitude],
        model[has_full_attitude],
        findings,
    )
    is_tilted[tilt] |= find_vertical_outliers(
        _select_labels(labels, tilt), down[tilt], model[tilt], ~has_full_attitude[tilt], findings
    )
    north_sigma = float(np.radians(north_sigma_deg)) if table.is_doubted else 0.0
    is_unstated = np.isnan(sigma[:, 1:]).any()
    mount_sigma = float(np.radians(MOUNT_SIGMA_DEG)) if is_unstated else 0.0
    kinds: list[ObservationKind] = [
        _attitudes(
            labels, is_complete & ~is_invalid, angles, model, sigma, north_sigma, mount_sigma
        ),
        # The vertical is correct even if the compass is wrong.
        _verticals(
            labels, tilt & (~is_complete | is_invalid) & ~is_tilted, down, model, sigma, mount_sigma
        ),
        _photo_azimuths(
            labels,
            yaw & ~is_complete & ~is_invalid & (is_phone | ~tilt),
            angles,
            model,
            sigma,
            north_sigma,
        ),
    ]
    is_usable = has_full_attitude & ~is_invalid
    return AttitudeEvidence(
        tuple(kind for kind in kinds if len(kind.labels)), known_angles[is_usable], model[is_usable]
    )


@dataclass(frozen=True)
class AttitudeResidual:
    """Difference between the placed and the stated attitude of a photo, degrees.

    The angles are placed minus stated, about the axes of `error_axes`, or None if the photo does
    not state them.
    """

    photo: str
    yaw_deg: float | None
    pitch_deg: float | None
    roll_deg: float | None


def compare_attitudes(
    table: AttitudeTable, rows: Sequence[int], views: Sequence[View], rotation: FloatArray
) -> list[AttitudeResidual]:
    """Compare the attitudes of the placed model with the attitudes of a table.

    Rows that are not used in the fit are included.

    Parameters
    ----------
    table : AttitudeTable
    rows : sequence of int
    views : sequence of View
    rotation : (3, 3) array
        Rotation from the model to the World frame.
    """
    if not rows:
        return []
    rotations, yaw, tilt = _attitude_errors(table, rows, views, rotation)
    differences = np.degrees(
        np.einsum("nji,nj->ni", error_axes(np.column_stack([yaw, yaw, yaw])), rotations)
    )
    stated_angles = table.angles[np.asarray(rows, int)]
    known_columns = np.column_stack([np.isfinite(stated_angles[:, 0]), tilt, tilt])
    return [
        AttitudeResidual(
            table.photos[row],
            *(
                float(v) if k else None
                for v, k in zip(differences[i], known_columns[i], strict=True)
            ),
        )
        for i, row in enumerate(rows)
    ]


def bowing_from_tilts(
    table: AttitudeTable,
    rows: Sequence[int],
    views: Sequence[View],
    similarity: Similarity,
    extent: FloatArray | None,
) -> Bowing | None:
    """Estimate the bowing of a placed model from the verticals of photos, without outliers.

    Parameters
    ----------
    table : AttitudeTable
    rows : sequence of int
    views : sequence of View
    similarity : Similarity
    extent : (m, 3) array or None
        Points of the model in the model frame.

    Returns
    -------
    Bowing or None
        Bowing, or None if the verticals do not determine it.
    """
    if not rows:
        return None
    rotations, _, tilt = _attitude_errors(table, rows, views, similarity.rotation)
    tilts = (
        rotations[:, :2] - np.median(rotations[tilt, :2], axis=0)
        if tilt.any()
        else rotations[:, :2]
    )
    length = np.hypot(*tilts.T)
    is_inlier = tilt & (
        length <= _OUTLIER_FACTOR * float(np.median(length[tilt])) if tilt.any() else tilt
    )
    positions = similarity(np.array([view.centre for view in views]))
    placed_extent = None if extent is None or not len(extent) else similarity(extent)
    cameras = similarity.rotation @ np.array([np.asarray(view.rotation).T for view in views])
    return fit_bowing_to_rotations(
        positions[is_inlier], rotations[is_inlier], cameras[is_inlier], placed_extent
    )


def _attitude_errors(
    table: AttitudeTable, rows: Sequence[int], views: Sequence[View], rotation: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the rotation of each photo from its stated to its placed attitude.

    Returns
    -------
    turns : (n, 3) array
        Rotation vectors in the World frame, rad.
    yaw : (n,) array
        Yaws, degrees.
    has_vertical : (n,) array of bool
        Whether the photo states its vertical.
    """
    from scipy.spatial.transform import Rotation

    row_indices = np.asarray(rows, int)
    stated_angles, down = table.angles[row_indices], gravity_directions(table)[row_indices]
    placed_rotations = rotation @ np.array([np.asarray(view.rotation).T for view in views])
    placed_angles = view_angles(placed_rotations)
    has_vertical = np.isfinite(down[:, 0])
    yaw = np.where(np.isfinite(stated_angles[:, 0]), stated_angles[:, 0], placed_angles[:, 0])
    stated_rotations = camera_rotations(np.column_stack([yaw, placed_angles[:, 1:]]))
    stated_rotations[has_vertical] = rotations_from_vertical(down[has_vertical], yaw[has_vertical])
    is_complete = np.isfinite(stated_angles).all(axis=1)
    stated_rotations[is_complete] = camera_rotations(stated_angles[is_complete])
    rotations: FloatArray = Rotation.from_matrix(
        placed_rotations @ np.swapaxes(stated_rotations, 1, 2)
    ).as_rotvec()
    return rotations, yaw, has_vertical


def _attitudes(
    labels: Sequence[str],
    mask: BoolArray,
    angles: FloatArray,
    model: FloatArray,
    sigma: FloatArray,
    north_sigma: float,
    mount_sigma: float,
) -> Attitudes:
    world, axes = camera_rotations(angles[mask]), error_axes(angles[mask])
    return Attitudes(
        _select_labels(labels, mask),
        model[mask],
        world,
        axes,
        sigma[mask],
        north_sigma,
        mount_sigma,
    )


def _verticals(
    labels: Sequence[str],
    mask: BoolArray,
    down: FloatArray,
    model: FloatArray,
    sigma: FloatArray,
    mount_sigma: float,
) -> Verticals:
    directions = np.einsum("nij,nj->ni", model[mask], down[mask])
    names = _select_labels(labels, mask)
    return Verticals(names, directions, sigma[mask, 1:], model[mask], mount_sigma)


def _photo_azimuths(
    labels: Sequence[str],
    mask: BoolArray,
    angles: FloatArray,
    model: FloatArray,
    sigma: FloatArray,
    north_sigma: float,
) -> Azimuths:
    names = _select_labels(labels, mask)
    azimuths = np.radians(angles[mask, 0])
    return Azimuths(names, model[mask][:, :, 2], azimuths, sigma[mask, 0], north_sigma)


def _has_azimuth(
    labels: Sequence[str], is_phone: BoolArray, down: FloatArray, findings: list[Finding]
) -> BoolArray:
    is_steep = is_phone & (np.abs(down[:, 2]) > np.sin(np.radians(_MAX_STEEPNESS_DEG)))
    if is_steep.any():
        findings.append(Finding("attitude.too-steep", photos=_select_labels(labels, is_steep)))
    return np.asarray(~is_steep)


def _select_labels(labels: Sequence[str], mask: BoolArray) -> list[str]:
    return [labels[int(i)] for i in np.flatnonzero(mask)]
