"""Checks of whether the attitudes of cameras agree, and of the cause if they do not.

Every photo determines the rotation of the model on its own, from its attitudes in the World frame
and in the model. If conventions differ or a photo was rotated, these rotations scatter, and a
single change of the angles makes them agree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.view_attitudes import camera_rotations
from vomstudio.registration.selection import select_names

# Scatter of rotations that agree: the instruments are good, whatever the convention.
_MAX_SCATTER_DEG = 5.0
_MAX_CONVERTED_SCATTER_DEG = 10.0
_MAX_SCATTER_RATIO = 0.3
_MIN_PHOTOS = 4
# A photo is an outlier beyond this angle and this multiple of the scatter.
_OUTLIER_DEG = 15.0
_OUTLIER_FACTOR = 5.0
# Maximum number of photos that are compared; of more photos, a subset is used.
_MAX_COMPARED_PHOTOS = 600
# Vertical component of a rotation axis above which the vertical is unchanged.
_MIN_VERTICAL_COMPONENT = 0.95


def find_outliers(
    labels: Sequence[str], angles: FloatArray, model: FloatArray, findings: list[Finding]
) -> tuple[BoolArray, BoolArray]:
    """Find the photos whose attitudes do not agree with those of most other photos.

    Parameters
    ----------
    labels : sequence of str
    angles : (n, 3) array
        Yaw, pitch and roll in the World frame, degrees.
    model : (n, 3, 3) array
        Rotations from the cameras to the model.
    findings : list of Finding
        List to which findings about suspicious angles are appended.

    Returns
    -------
    outliers : (n,) array of bool
    is_tilted : (n,) array of bool
        Outliers whose vertical does not agree either.
    """
    empty_mask = np.zeros(len(labels), bool)
    if len(labels) < _MIN_PHOTOS:
        return empty_mask, empty_mask
    rotations = camera_rotations(angles) @ np.swapaxes(model, 1, 2)
    typical_rotation, scatter = _majority_rotation(rotations)
    if scatter > _MAX_SCATTER_DEG:
        alternatives = [
            (
                _majority_rotation(camera_rotations(change(angles)) @ np.swapaxes(model, 1, 2))[1],
                sentence,
            )
            for change, sentence in _conventions()
        ]
        least_scatter, sentence = min(alternatives)
        if least_scatter < min(_MAX_SCATTER_RATIO * scatter, _MAX_CONVERTED_SCATTER_DEG):
            findings.append(
                Finding(
                    "attitude.other-convention",
                    scatter_deg=scatter,
                    least_deg=least_scatter,
                    change=sentence,
                )
            )
            return empty_mask, empty_mask
    deviations = _rotation_angles(rotations, typical_rotation)
    limit_deg = _outlier_limit_deg(deviations)
    outliers = np.asarray(deviations > limit_deg)
    is_tilted = empty_mask.copy()
    if outliers.any():
        is_tilted[outliers] = _describe_outliers(
            labels, angles, model, typical_rotation, outliers, limit_deg, findings
        )
    return outliers, is_tilted


def find_vertical_outliers(
    labels: Sequence[str],
    down: FloatArray,
    model: FloatArray,
    is_considered: BoolArray,
    findings: list[Finding],
) -> BoolArray:
    """Find the photos whose verticals do not agree with those of most other photos.

    Parameters
    ----------
    labels : sequence of str
    down : (n, 3) array
        Direction of gravity in the frame of each camera.
    model : (n, 3, 3) array
        Rotations from the cameras to the model.
    is_considered : (n,) array of bool
        Photos to check.
    findings : list of Finding
        List to which findings about excluded photos are appended.

    Returns
    -------
    (n,) array of bool
    """
    if len(labels) < _MIN_PHOTOS or not is_considered.any():
        return np.zeros(len(labels), bool)
    rotated_axes = [down]
    for _ in range(3):
        # Rotate the photo clockwise by a quarter turn.
        right, down_axis, forward = rotated_axes[-1].T
        rotated_axes.append(np.column_stack([-down_axis, right, forward]))
    directions_by_quarter_turn = [np.einsum("nij,nj->ni", model, item) for item in rotated_axes]
    typical_direction, scatter = _majority_direction(directions_by_quarter_turn[0])
    if scatter > _MAX_SCATTER_DEG:
        min_scatter, quarter = min(
            (_majority_direction(item)[1], k) for k, item in enumerate(directions_by_quarter_turn)
        )
        if quarter and min_scatter < min(_MAX_SCATTER_RATIO * scatter, _MAX_CONVERTED_SCATTER_DEG):
            findings.append(
                Finding(
                    "attitude.turned-photos",
                    scatter_deg=scatter,
                    least_deg=min_scatter,
                    turn_deg=90 * quarter,
                )
            )
            return np.zeros(len(labels), bool)
    offset = _angles_to_direction(directions_by_quarter_turn[0], typical_direction)
    is_outlier = np.asarray(is_considered & (offset > _outlier_limit_deg(offset)))
    if is_outlier.any():
        angles = np.array(
            [_angles_to_direction(item, typical_direction) for item in directions_by_quarter_turn]
        )[:, is_outlier]
        is_close = angles.min(axis=0) < _MAX_CONVERTED_SCATTER_DEG
        quarters = np.unique(90 * angles.argmin(axis=0)[is_close]).tolist()
        findings.append(
            Finding("attitude.verticals-left-out", photos=select_names(labels, is_outlier))
        )
        if quarters:
            findings.append(Finding("attitude.verticals-turned", turns_deg=quarters))
    return is_outlier


# --- angle conventions ------------------------------------------------------------------------
def _add_degrees(column: int, degrees: float) -> Callable[[FloatArray], FloatArray]:
    return lambda angles: angles + degrees * np.eye(3)[column]


def _multiply(*factors: float) -> Callable[[FloatArray], FloatArray]:
    return lambda angles: angles * factors


def _quarter_turns() -> list[tuple[Callable[[FloatArray], FloatArray], str]]:
    return [
        (_add_degrees(2, 90.0), tr("90° is added to roll (photos in portrait)")),
        (_add_degrees(2, -90.0), tr("90° is subtracted from roll (photos in portrait)")),
        (_add_degrees(2, 180.0), tr("180° is added to roll (photos upside down)")),
    ]


def _conventions() -> list[tuple[Callable[[FloatArray], FloatArray], str]]:
    return [
        *_quarter_turns(),
        (_add_degrees(1, -90.0), tr("90° is subtracted from pitch (measured from straight down)")),
        (
            _add_degrees(1, 90.0),
            tr("90° is added to pitch (measured downwards from the horizon)"),
        ),
        (_multiply(1.0, -1.0, 1.0), tr("the sign of pitch is reversed (positive downwards)")),
        (_multiply(-1.0, 1.0, 1.0), tr("the sign of yaw is reversed (counterclockwise)")),
        (_multiply(1.0, 1.0, -1.0), tr("the sign of roll is reversed")),
        (_radians_to_degrees, tr("all angles are multiplied by 57.2958 (radians)")),
    ]


def _radians_to_degrees(angles: FloatArray) -> FloatArray:
    """Convert angles to degrees if all are small enough to be radians."""
    is_in_radians = np.nanmax(np.abs(angles), initial=0.0) <= 2.0 * np.pi + 1e-6
    return np.degrees(angles) if is_in_radians else angles


def _describe_outliers(
    labels: Sequence[str],
    angles: FloatArray,
    model: FloatArray,
    typical_rotation: FloatArray,
    is_outlier: BoolArray,
    limit_deg: float,
    findings: list[Finding],
) -> list[bool]:
    """Return whether the vertical of each excluded photo is also excluded.

    Appends one finding for all photos with the same error.
    """
    from scipy.spatial.transform import Rotation

    inverse_rotations = np.swapaxes(model, 1, 2)
    photos_by_reason: dict[tuple[str, Any], list[str]] = {}
    is_tilted = []
    for row in map(int, np.flatnonzero(is_outlier)):
        angles_of_photo = angles[row : row + 1]
        candidates = [
            (
                float(
                    _rotation_angles(
                        camera_rotations(change(angles_of_photo)) @ inverse_rotations[row],
                        typical_rotation,
                    )[0]
                ),
                sentence,
            )
            for change, sentence in _quarter_turns()
        ]
        min_angle, sentence = min(candidates)
        relative_rotation = (
            camera_rotations(angles_of_photo)[0] @ inverse_rotations[row] @ typical_rotation.T
        )
        rotation = np.degrees(Rotation.from_matrix(relative_rotation).as_rotvec())
        # If a camera looks down, a rotated photo appears to have another yaw.
        is_quarter_turn = min_angle < limit_deg / 2
        is_flat = not is_quarter_turn and abs(
            rotation[2]
        ) > _MIN_VERTICAL_COMPONENT * np.linalg.norm(rotation)
        is_tilted.append(not is_flat)
        if is_quarter_turn:
            photos_by_reason.setdefault(("quarter", sentence), []).append(labels[row])
        elif is_flat:
            photos_by_reason.setdefault(("yaw", round(-float(rotation[2]) / 5) * 5), []).append(
                labels[row]
            )
        else:
            photos_by_reason.setdefault(("far", limit_deg), []).append(labels[row])
    findings += [
        _exclusion_finding(reason, value, names)
        for (reason, value), names in photos_by_reason.items()
    ]
    return is_tilted


def _exclusion_finding(reason: str, value: Any, photos: list[str]) -> Finding:
    if reason == "yaw":
        return Finding("attitude.yaw-left-out", off_deg=value, photos=photos)
    if reason == "quarter":
        return Finding("attitude.convention-left-out", change=value, photos=photos)
    return Finding("attitude.left-out", limit_deg=value, photos=photos)


def _outlier_limit_deg(offset: FloatArray) -> float:
    return max(_OUTLIER_DEG, _OUTLIER_FACTOR * 1.4826 * float(np.median(offset)))


def _majority_direction(directions: FloatArray) -> tuple[FloatArray, float]:
    """Return the direction close to most directions (n, 3), and their median angle to it."""
    subset = directions[:: max(1, -(-len(directions) // _MAX_COMPARED_PHOTOS))]
    angles = np.degrees(np.arccos(np.clip(subset @ subset.T, -1.0, 1.0)))
    median = subset[int(np.argmin(np.median(angles, axis=1)))]
    angles_to_median = _angles_to_direction(subset, median)
    mean = subset[angles_to_median <= np.median(angles_to_median)].sum(axis=0)
    refined_direction = mean / np.linalg.norm(mean)
    return refined_direction, float(np.median(_angles_to_direction(directions, refined_direction)))


def _angles_to_direction(directions: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the angles (n,) to a direction, in degrees."""
    return np.asarray(np.degrees(np.arccos(np.clip(directions @ reference, -1.0, 1.0))), np.float64)


def _majority_rotation(rotations: FloatArray) -> tuple[FloatArray, float]:
    """Return the rotation close to most rotations (n, 3, 3), and their median angle to it."""
    sample = rotations[:: max(1, -(-len(rotations) // _MAX_COMPARED_PHOTOS))]
    flat_matrices = sample.reshape(-1, 9)
    angles = np.degrees(
        np.arccos(np.clip((flat_matrices @ flat_matrices.T - 1.0) / 2.0, -1.0, 1.0))
    )
    median = sample[int(np.argmin(np.median(angles, axis=1)))]
    angles_to_median = _rotation_angles(sample, median)
    u, _, vt = np.linalg.svd(sample[angles_to_median <= np.median(angles_to_median)].sum(axis=0))
    nearest_rotation = np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt, np.float64)
    return nearest_rotation, float(np.median(_rotation_angles(rotations, nearest_rotation)))


def _rotation_angles(rotations: FloatArray, typical_rotation: FloatArray) -> FloatArray:
    """Return the angles (n,) between rotations (n, 3, 3) and one rotation, in degrees."""
    trace = np.einsum("nij,ij->n", rotations.reshape(-1, 3, 3), typical_rotation)
    return np.asarray(np.degrees(np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0))), np.float64)
